# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds flusi, msm_train and msm_diagnose, and runs them from Python."""
from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Union

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.project_python import program

ENVIRONMENT = "FLUSI_BIN"
EXIT_USER, EXIT_NUMERICAL, EXIT_STOPPED, EXIT_UNWRITABLE = 2, 3, 4, 5
Sections = Mapping[str, Mapping[str, object]]
Source = Union[str, os.PathLike, Sections]


class RunError(RuntimeError):
    """A program failed, although its input is correct. `code` is its exit code, `output` the text that it printed."""

    def __init__(self, text: str, code: int, output: str) -> None:
        super().__init__(text)
        self.code, self.output = code, output


@dataclass
class Finished:
    """A program that has ended without an error."""
    code: int
    output: str
    folder: Path


def find_program(name: str) -> Path:
    """Returns the path of a program: in the folder $FLUSI_BIN if this is set, else in the build, next to the installation, or in
    PATH. Raises an InputError if there is none."""
    folder = os.environ.get(ENVIRONMENT)
    found = Path(folder, name) if folder else program(name)
    if not folder and not found.is_file():
        found = Path(shutil.which(name) or found)
    if not os.access(found, os.X_OK) or not found.is_file():
        raise InputError(f"{name}: not found" + (f" in {ENVIRONMENT} = {folder}" if folder else
                         f"; set {ENVIRONMENT} to the folder of the programs, or put them into PATH"))
    return found.resolve()


def text_of_input(sections: Sections) -> str:
    """Returns the text of an input file from {section: {key: value}}. Booleans become yes and no, lists are separated by blanks,
    keys with None are left out."""
    def word(value: object) -> str:
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, (list, tuple)):
            return " ".join(word(v) for v in value)
        return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)

    lines = []
    for section, keys in sections.items():
        lines += [f"[{section}]", *(f"{key} = {word(value)};" for key, value in keys.items() if value is not None)]
    return "\n".join(lines) + "\n"


def prepare(source: Source, folder: str | os.PathLike | None, name: str) -> tuple:
    """Makes the folder to run in, and returns it and the path of the input. Sections are written to `name` there; files that
    they name are searched in this folder. An existing input file is used where it is."""
    if isinstance(source, Mapping):
        where = Path(folder or ".")
        where.mkdir(parents=True, exist_ok=True)
        (where / name).write_text(text_of_input(source))
        return where, name
    path = Path(source).resolve()
    if not path.is_file():
        raise InputError(f"{source}: no such file")
    where = Path(folder) if folder else path.parent
    where.mkdir(parents=True, exist_ok=True)
    return where, str(path)


def run(name: str, arguments: Sequence[str], folder: Path, ranks: int = 1, good: Sequence[int] = (0,), timeout: float | None = None,
        echo: bool = False) -> Finished:
    """Runs a program in `folder` to its end. Exit code 2 becomes an InputError with all mistakes; any other that is not in
    `good` becomes a RunError. With `echo` the output is printed immediately."""
    command = [str(find_program(name)), *map(str, arguments)]
    if ranks > 1:
        mpiexec = os.environ.get("MPIEXEC") or shutil.which("mpiexec") or shutil.which("mpirun")
        if not mpiexec:
            raise InputError(f"ranks = {ranks}: there is no mpiexec in PATH")
        command = [mpiexec, "-n", str(ranks), *command]
    lines = []
    with subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace") as process:
        try:
            if echo:
                for line in process.stdout or ():
                    print(line, end="", flush=True)
                    lines.append(line)
                process.wait(timeout)
            else:
                lines.append(process.communicate(timeout=timeout)[0])
        except BaseException as error:  # the program ends with a notebook that is stopped
            process.terminate()
            process.wait()
            if isinstance(error, subprocess.TimeoutExpired):
                raise RunError(f"{name}: no end within {timeout} s", -1, "".join(lines)) from None
            raise
    output = "".join(lines)
    if process.returncode == EXIT_USER:
        raise InputError(output.strip())
    if process.returncode not in good:
        last = "\n".join(output.strip().splitlines()[-15:])
        raise RunError(f"{name}: exit code {process.returncode}\n{last}", process.returncode, output)
    return Finished(process.returncode, output, Path(folder))
