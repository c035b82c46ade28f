# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools that change the points of a field, or the attributes of its file."""
from __future__ import annotations

import h5py
import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.postprocess.fields import XYZ, Field
from flusi_msm.postprocess.registry import Call, as_count, as_number, tool
from flusi_msm.postprocess.spectral import resample


@tool("upsample", "SOURCE TARGET NX NY NZ", "the field at other numbers of points of the same box: its trigonometric interpolant, exact "
      "for what the grid resolves; also to fewer points", "target and source")
def upsample(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:2])
    n = [as_count(word, f"upsample N{c.upper()}", 1) for c, word in zip(XYZ, call.words[2:])]
    call.save(call.words[1], f, resample(f, n))


def index_range(text: str, n: int, what: str) -> range:
    """Converts FIRST:LAST or FIRST:STEP:LAST, both ends included, counted from 0; a LAST beyond the end means the end, as in
    FLUSI."""
    words = text.split(":")
    if len(words) == 2:
        words.insert(1, "1")
    if len(words) != 3:
        raise InputError(f"{what}: '{text}' is not FIRST:LAST or FIRST:STEP:LAST")
    first, step, last = as_count(words[0], what), as_count(words[1], what, 1), as_count(words[2], what)
    if first > min(last, n - 1):
        raise InputError(f"{what}: '{text}' holds none of the points 0 to {n - 1}")
    return range(first, min(last, n - 1) + 1, step)


def subset(call: Call, ranges: list[str]) -> None:
    f, = call.fields(call.words[:1], call.words[1:2])
    chosen = [index_range(text, m, f"{call.tool.name} {c}") for c, text, m in zip(XYZ, ranges, f.n)]
    spacing = f.spacing
    z, y, x = (slice(r.start, r.stop, r.step) for r in reversed(chosen))
    length = [len(r) * r.step * h for r, h in zip(chosen, spacing)]
    origin = [o + r.start * h for o, r, h in zip(f.origin, chosen, spacing)]
    call.save(call.words[1], f, f.read((z, y, x)), domain_size=np.array(length), origin=np.array(origin))


@tool("extract-subset", "FIELD OUT X Y Z", "points FIRST:STEP:LAST of each direction, counted from 0, both ends included",
      "what is kept")
def extract_subset(call: Call) -> None:
    subset(call, call.words[2:])


@tool("crop", "FIELD OUT X Y Z", "points FIRST:LAST of each direction, counted from 0, both ends included", "what is kept")
def crop(call: Call) -> None:
    subset(call, call.words[2:])


@tool("extract-slice", "FIELD OUT AXIS INDEX", "the plane across AXIS (x, y or z) at a point, counted from 0")
def extract_slice(call: Call) -> None:
    axis = _axis(call, call.words[2])
    index = as_count(call.words[3], "extract-slice INDEX")
    subset(call, [f"{index}:{index}" if c == axis else "0:999999999" for c in range(3)])


@tool("mean-over", "FIELD OUT AXIS", "mean along AXIS (x, y or z): a field with one point in this direction", "1 field")
def mean_over(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:2])
    axis = _axis(call, call.words[2])
    call.save(call.words[1], f, f.read().mean(axis=2 - axis, keepdims=True))


@tool("max-over", "FIELD OUT AXIS", "largest value along AXIS (x, y or z): a field with one point in this direction", "1 field")
def max_over(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:2])
    axis = _axis(call, call.words[2])
    call.save(call.words[1], f, f.read().max(axis=2 - axis, keepdims=True))


@tool("shift", "FIELD OUT DX DY DZ", "the periodic field moved by a distance in L, also by a part of the spacing", "2 fields")
def shift(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:2])
    values = f.read()
    for c, word in enumerate(call.words[2:]):
        cells = as_number(word, f"shift D{XYZ[c].upper()}") / f.spacing[c]
        if cells == round(cells):
            values = np.roll(values, round(cells), axis=2 - c)
        else:
            values = _moved(values, 2 - c, cells)
    call.save(call.words[1], f, values)


def _moved(values: np.ndarray, axis: int, cells: float) -> np.ndarray:
    n = values.shape[axis]
    if n == 1:
        return values
    phase = np.exp(-2j * np.pi * cells / n * np.arange(n // 2 + 1))
    if n % 2 == 0:
        phase[-1] = np.cos(np.pi * cells)
    shape = [1, 1, 1]
    shape[axis] = -1
    return np.fft.irfft(np.fft.rfft(values, axis=axis) * phase.reshape(shape), n=n, axis=axis)


def _axis(call: Call, word: str) -> int:
    if word not in XYZ or len(word) != 1:
        raise InputError(f"{call.tool.name} AXIS: '{word}' is not x, y or z")
    return XYZ.index(word)


@tool("set-hdf5-attribute", "FILE NAME N VALUES", "writes an attribute of N numbers, separated by commas, to the dataset of a field",
      writes_fields=False)
def set_attribute(call: Call) -> None:
    path, name, count, text = call.words
    number = as_count(count, "set-hdf5-attribute N", 1)
    values = [as_number(word, "set-hdf5-attribute VALUES") for word in text.split(",")]
    if len(values) != number:
        raise InputError(f"set-hdf5-attribute: N is {number}, but {len(values)} values are given: separate them with commas, no blanks")
    dataset = Field(path).dataset
    try:
        with h5py.File(path, "r+") as file:
            file[dataset].attrs[name] = np.array(values)
    except OSError:
        raise InputError(f"{path}: cannot be written to: may you write to it, and does no program use it?") from None
    print(f"{path}: {name} = {', '.join(f'{v:g}' for v in values)}")
