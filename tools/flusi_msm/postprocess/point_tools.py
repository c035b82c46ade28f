# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools that compute point by point, in slabs."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Callable

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.postprocess.fields import Field
from flusi_msm.postprocess.registry import Call, as_number, tool

OPERATIONS = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide,
              "add": np.add, "subtract": np.subtract, "multiply": np.multiply, "divide": np.divide}


def by_points(call: Call, path: str, fields: list[Field], function: Callable[..., np.ndarray], **attributes: Any) -> None:
    """Writes function(values of the first field, of the second, ...)."""
    low, high = np.inf, -np.inf
    with call.output(path, fields[0], **attributes) as out:
        for box in fields[0].slabs():
            values = function(*(f.read(box) for f in fields))
            low, high = min(low, values.min()), max(high, values.max())
            out.write(values, box)
    print(f"{path}: {' x '.join(map(str, fields[0].n))} points, from {low:.6g} to {high:.6g}")


@tool("magnitude", "UX UY UZ OUT", "sqrt(ux^2 + uy^2 + uz^2)")
def magnitude(call: Call) -> None:
    by_points(call, call.words[3], call.fields(call.words[:3], call.words[3:], True),
              lambda x, y, z: np.sqrt(x * x + y * y + z * z))


@tool("energy", "UX UY UZ OUT", "(ux^2 + uy^2 + uz^2)/2")
def energy(call: Call) -> None:
    by_points(call, call.words[3], call.fields(call.words[:3], call.words[3:], True),
              lambda x, y, z: 0.5 * (x * x + y * y + z * z))


@tool("TKE-mean", "EKINAVG UAVGX UAVGY UAVGZ OUT", "turbulent kinetic energy of means over time: "
      "ekinavg - (uavgx^2 + uavgy^2 + uavgz^2)/2", options={"urms": (0, "the root mean square velocity sqrt(2 TKE/3) instead")})
def tke(call: Call) -> None:
    def value(e: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        k = e - 0.5 * (x * x + y * y + z * z)
        return np.sqrt(2 / 3 * np.maximum(k, 0)) if call.has("urms") else k
    by_points(call, call.words[4], call.fields(call.words[:4], call.words[4:]), value)


@tool("simple-field-operation", "FIELD1 OP FIELD2 OUT", "FIELD1 OP FIELD2 with OP one of + - * / or add, subtract, multiply, divide "
      "(the shell wants '*' in quotes); one of the fields may be a number",
      options={"where-zero": (1, "what a division by 0 gives; else it is refused")})
def operation(call: Call) -> None:
    one, op, two, path = call.words
    if op not in OPERATIONS:
        raise InputError(f"simple-field-operation: '{op}' is no operation: take {', '.join(OPERATIONS)}"
                         + (" (put '*' in quotes)" if Path(op).exists() else ""))
    files = [word for word in (one, two) if word.endswith(".h5")]
    if not files:
        raise InputError(f"simple-field-operation: neither {one} nor {two} is a field file (*.h5)")
    fields = call.fields(files, [path])
    numbers = {word: as_number(word, "simple-field-operation") for word in (one, two) if word not in files}
    where_zero = call.number("where-zero")

    def value(*arrays: np.ndarray) -> np.ndarray:
        rest = list(arrays)
        a, b = (numbers[word] if word in numbers else rest.pop(0) for word in (one, two))
        if OPERATIONS[op] is np.divide and np.any(np.asarray(b) == 0):
            if where_zero is None:
                raise InputError(f"{two}: is 0 at some points, and {one} cannot be divided by it there: say with --where-zero VALUE "
                                 "what they get")
            b = np.asarray(b)
            return np.where(b == 0, where_zero, a / np.where(b == 0, 1.0, b))
        return OPERATIONS[op](a, b)
    by_points(call, path, fields, value)


@tool("time-avg", "LIST... OUT", "mean of fields: their names, or a text file with one name in each line",
      options={"time": (1, "time to write into OUT (0)"), "trapezoidal": (0, "weights from the times of the files by the trapezoidal "
                                                                         "rule, for times that are not evenly spaced")})
def time_average(call: Call) -> None:
    def time_of(f: Field) -> float:
        return np.nan if f.time is None else f.time

    fields = _series(call)
    weights = np.full(len(fields), 1 / len(fields))
    if call.has("trapezoidal"):
        if any(f.time is None for f in fields) or len(fields) < 2:
            raise InputError("time-avg: --trapezoidal needs two files or more, all with the attribute time")
        fields.sort(key=time_of)
        steps = np.diff([time_of(f) for f in fields])
        if steps.min() <= 0:
            raise InputError("time-avg: --trapezoidal needs files of different times")
        weights = 0.5 * (np.r_[0, steps] + np.r_[steps, 0]) / steps.sum()
    weight_of = dict(zip((id(f) for f in fields), weights))
    _over_time(call, fields, lambda total, f, values: total + weight_of[id(f)] * values, time=call.number("time", 0.0))
    print(f"mean of {len(fields)} fields")


@tool("max-over-time", "LIST... OUT", "largest |f| of fields at each point: their names, or a text file with one name in each line")
def largest(call: Call) -> None:
    _over_time(call, _series(call), lambda total, f, values: np.maximum(total, np.abs(values)))


def _over_time(call: Call, fields: list[Field], add: Callable[[np.ndarray, Field, np.ndarray], np.ndarray], **attributes: Any) -> None:
    """Writes the result of `add(so far, field, its values)`, applied to one field after the other and beginning with 0. It needs
    the memory of two slabs, however many fields there are."""
    low, high, path = np.inf, -np.inf, call.words[-1]
    with call.output(path, fields[0], **attributes) as out:
        for box in fields[0].slabs():
            values = np.zeros_like(fields[0].read(box))
            for f in fields:
                values = add(values, f, f.read(box))
            low, high = min(low, values.min()), max(high, values.max())
            out.write(values, box)
    print(f"{path}: {' x '.join(map(str, fields[0].n))} points, from {low:.6g} to {high:.6g}")


def _series(call: Call) -> list[Field]:
    """Returns the fields that are named by the arguments, or by the lines of a text file, whose names are relative to the
    working folder."""
    paths: list[str] = []
    for word in call.words[:-1]:
        if word.endswith(".h5"):
            paths.append(word)
            continue
        try:
            lines = Path(word).read_text(encoding="utf-8").split("\n")
        except (OSError, UnicodeDecodeError):
            raise InputError(f"{word}: is neither a text file with names of fields nor an .h5 file") from None
        paths += [line.strip() for line in lines if line.strip()]
    if not paths:
        raise InputError(f"{call.words[0]}: names no files: write one name of a field into each line")
    return call.fields(paths, call.words[-1:])


@tool("remove-mean", "FIELD OUT", "field less its mean")
def remove_mean(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:])
    mean = sum(f.read(box).sum() for box in f.slabs()) / np.prod(f.n, dtype=float)
    by_points(call, call.words[1], [f], lambda values: values - mean)


@tool("cp", "FIELD OUT", "copy, with the dataset named after the new file; also changes the precision", other_names=["readwrite"])
def copy(call: Call) -> None:
    by_points(call, call.words[1], call.fields(call.words[:1], call.words[1:]), lambda values: values)


@tool("dist2mask", "DIST MASK SIGN", "signed distance to a mask: 1 inside (negative distance), 0 outside, over 2 dz on each side a cosine; "
      "SIGN = -1 turns the distance round", other_names=["dist2chi"], optional=1)
def distance_to_mask(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:2])
    sign = as_number(call.words[2], "dist2mask SIGN") if len(call.words) > 2 else 1.0
    if abs(sign) != 1:
        raise InputError(f"dist2mask: SIGN is {sign:g}, but must be 1 or -1")
    half = 2 * f.spacing[2]
    by_points(call, call.words[1], [f],
              lambda d: 0.5 * (1 + np.cos(0.5 * np.pi * (np.clip(sign * d / half, -1, 1) + 1))))


