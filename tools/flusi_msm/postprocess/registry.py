# SPDX-License-Identifier: GPL-3.0-or-later
"""Describes a tool of postprocess: its arguments, its options, its use of memory, and the function that does its work."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.postprocess.fields import Field, Output, dataset_name, open_fields, refuse_to_overwrite

PRECISIONS = ("single-precision", "double-precision")
ORDERS = ("second-order", "fourth-order", "second-order-nonper")


@dataclass
class Call:
    """The call of a tool with its arguments and options."""
    tool: "Tool"
    words: list[str]
    options: dict[str, list[str]]

    def has(self, option: str) -> bool:
        """Returns whether an option was given."""
        return option in self.options

    def number(self, option: str, default: float | None = None) -> float | None:
        """Returns the number of an option, or the default."""
        return as_number(self.options[option][0], f"--{option}") if option in self.options else default

    def fields(self, paths: Sequence[str], outputs: Sequence[str] = (), same_time: bool = False) -> list[Field]:
        """Opens the inputs, which must fit together, after a check that none of them would be overwritten."""
        refuse_to_overwrite(paths, outputs)
        for path in outputs:
            if Path(path).suffix != ".h5" and self.tool.writes_fields:
                raise InputError(f"{path}: files of fields end in .h5, like vorx_000500.h5")
        return open_fields(paths, same_time)

    def output(self, path: str, like: Field, shape: Sequence[int] | None = None, **attributes: Any) -> Output:
        """Returns a field file to write, in the precision of the input or in the one that the user wants."""
        kind = np.dtype("f4") if self.has(PRECISIONS[0]) else np.dtype("f8") if self.has(PRECISIONS[1]) else like.precision
        return Output(path, like, kind, self.tool.name, shape, **attributes)

    def save(self, path: str, like: Field, values: np.ndarray, **attributes: Any) -> None:
        """Writes a field file and prints its range."""
        with self.output(path, like, values.shape, **attributes) as out:
            out.write(values)
        print(f"{path}: {dataset_name(Path(path))}, {' x '.join(map(str, values.shape[::-1]))} points, "
              f"from {values.min():.6g} to {values.max():.6g}")


@dataclass
class Tool:
    """A tool: `words` are names of its arguments ('...' after one that may be repeated)."""
    name: str
    words: tuple[str, ...]
    about: str
    memory: str
    run: Callable[[Call], None]
    options: dict[str, tuple[int, str]] = field(default_factory=dict)
    other_names: tuple[str, ...] = ()
    optional: int = 0  # how many arguments may be missing: those in brackets, or else the last ones
    writes_fields: bool = True

    def usage(self) -> str:
        last = len(self.words) - (0 if any(word.startswith("[") for word in self.words) else self.optional)
        words = " ".join(word if i < last else f"[{word}]" for i, word in enumerate(self.words))
        return f"postprocess {self.name} {words}" + "".join(
            f" [--{name}{' VALUE' * count}]" for name, (count, _) in self.options.items())


TOOLS: dict[str, Tool] = {}


def tool(name: str, words: str, about: str, memory: str = "slabs", options: dict[str, tuple[int, str]] | None = None,
         other_names: Sequence[str] = (), optional: int = 0, writes_fields: bool = True) -> Callable:
    """Adds the decorated function to the list of tools."""
    def enter(run: Callable[[Call], None]) -> Callable[[Call], None]:
        entry = Tool(name, tuple(words.split()), about, memory, run, options or {}, tuple(other_names), optional, writes_fields)
        for key in (name, *other_names):
            TOOLS[key] = entry
        return run
    return enter


def as_number(text: str, what: str) -> float:
    """Returns a number; raises an InputError if the text is none."""
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{what}: '{text}' is not a number") from None
    if not np.isfinite(value):
        raise InputError(f"{what}: '{text}' is not a finite number")
    return value


def as_count(text: str, what: str, least: int = 0) -> int:
    """Returns a whole number; raises an InputError if the text is none."""
    try:
        value = int(text)
    except ValueError:
        raise InputError(f"{what}: '{text}' is not a whole number") from None
    if value < least:
        raise InputError(f"{what}: {value} must be at least {least}")
    return value


def write_text(path: str, lines: Sequence[str], inputs: Sequence[str], show: bool = True) -> None:
    """Writes a text file, and with `show` prints the same text."""
    refuse_to_overwrite(inputs, [path])
    text = "\n".join(lines) + "\n"
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError:
        raise InputError(f"{path}: cannot be written: is there such a folder, and may you write into it?") from None
    if show:
        print(text, end="")
