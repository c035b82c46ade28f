# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads descriptions of synthetic experiments from JSON files, changes their keys, and converts them to dataclasses."""
from __future__ import annotations

import difflib
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, cast, get_origin, get_type_hints

import numpy as np

from flusi_msm.errors import InputError

Described = TypeVar("Described")  # a dataclass
NAMED = ("E_wave", "one_way")  # keys whose first value is a name
WORDS = {float: "a number, in SI units and without a unit", int: "a whole number", bool: "true or false", str: "a text", tuple: "a list",
         list: "a list", dict: "a section {...}"}


def read_json(path: str | Path, changes: Sequence[str] = (), drop: Sequence[str] = ()) -> Any:
    """Returns the dictionary in a JSON file, without the sections `drop` and with changes `section.key=value`."""
    try:
        data = json.loads(Path(path).read_text())
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: not JSON: {error}") from None
    for section in drop if isinstance(data, dict) else ():
        data.pop(section, None)
    for change in changes:
        name, equals, text = change.partition("=")
        if not equals:
            raise InputError(f"--set {change}: write key=value or section.key=value")
        try:
            value = json.loads(text)
        except ValueError:
            value = text
        *sections, key = name.strip().split(".")
        place = data
        for section in sections:
            place = place.setdefault(section, {})
            if not isinstance(place, dict):
                raise InputError(f"--set {change}: {section} is not a section")
        place[key] = value
    return data


@contextmanager
def mistakes_in(path: str | Path, changes: Sequence[str] = ()) -> Iterator[None]:
    """Puts the name of the file before every mistake that is found in it, and --set before those of the keys that it changes."""
    changed = {change.partition("=")[0].strip() for change in changes}

    def named(line: str) -> str:
        if line.startswith((f"{path}: ", "--set ")):
            return line
        return f"--set {line}" if line.replace(":", " ").split()[0] in changed else f"{path}: {line}"

    try:
        yield
    except InputError as error:
        raise InputError("\n".join(named(line) for line in str(error).splitlines())) from None


def build(kind: type[Described], data: Any, section: str) -> Described:
    """Makes a dataclass from a dictionary; unknown keys and values of another kind are refused, all at once, a line for each."""
    if not isinstance(data, dict):
        raise InputError(f"{section or 'the case'}: must be a section {{...}}")
    section += "." if section else ""
    owner: type[Any] = kind
    known = {f.name: f for f in fields(owner)}
    values, problems = {}, []
    for key, value in data.items():
        if key in known:
            try:
                values[key] = convert(owner, key, value, section + key)
            except InputError as error:
                problems.append(str(error))
        else:
            near = difflib.get_close_matches(key, known, 1)
            problems.append(f"{section}{key}: unknown" + (f"; did you mean {near[0]}?" if near else f"; known are {', '.join(known)}"))
    for name, item in known.items():
        if name not in data and item.default is MISSING and item.default_factory is MISSING:
            problems.append(f"{section}{name}: required")
    if problems:
        raise InputError("\n".join(problems))
    return kind(**values)


def kinds_of(kind: type[Any]) -> dict[str, Any]:
    """Returns the kind of each field of a dataclass: float, tuple, dict, another dataclass, ...; what a tuple holds is left out."""
    return {name: get_origin(hint) or hint for name, hint in get_type_hints(kind).items()}


def convert(owner: type[Any], key: str, value: Any, name: str) -> Any:
    """Returns the value for the field `key` of the dataclass `owner`; `name` is the key in messages."""
    item, kind = owner.__dataclass_fields__[key], kinds_of(owner)[key]
    if isinstance(kind, type) and is_dataclass(kind):
        return build(kind, value, name)
    if kind is float and is_number(value):
        return float(value)
    if kind is tuple and isinstance(value, list):
        size = len(cast(tuple, item.default))
        if name.endswith(("shift", "tilt", "creep", "compliance", "gravity", "fringe")) and len(value) != size:
            raise InputError(f"{name}: needs {size} numbers")
        rows = [v if isinstance(v, list) else [v] for v in (value[1:] if item.name in NAMED else value)]
        rows = [row[1:] for row in rows] if item.name == "soft_places" else rows
        if not all(is_number(v) for row in rows for v in row):
            raise InputError(f"{name} = {value!r}: holds what is no number")
        return tuple(tuple(v) if isinstance(v, list) else v for v in value)
    if kind is dict and isinstance(value, dict) and not all(is_number(v) for v in value.values()):
        raise InputError(f"{name} = {value!r}: holds what is no number")
    if kind in (int, bool, str, dict, list) and type(value) is kind:
        return value
    raise InputError(f"{name} = {value!r}: must be {WORDS.get(kind, kind)}")


def is_number(value: object) -> bool:
    """Returns whether a value is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and bool(np.isfinite(value))
