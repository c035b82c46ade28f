# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes field files in the layout of FLUSI: one dataset, named after the file, with attributes about time and box.

Files are read by slabs, so that a field need not fit into memory. They are written under a temporary name, which is replaced by
the name of the file when the file is complete.
"""
from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flusi_msm.errors import InputError

SLAB_BYTES = 32 * 2**20  # of doubles read at a time
XYZ = "xyz"
Box = tuple[slice, slice, slice]


def dataset_name(path: Path) -> str:
    """Returns the name of the dataset in a file of FLUSI: the part of the file's name before the first underscore."""
    return path.stem.split("_")[0] if path.stem.find("_") > 0 else path.stem


class Field:
    """A field in a file. The file is open only while it is read, since a mean over time may use thousands of files."""

    def __init__(self, path: str) -> None:
        self.path = Path(path)
        if not self.path.is_file():
            raise InputError(f"{path}: there is no such file")
        try:
            file = h5py.File(self.path, "r")
        except OSError:
            raise InputError(f"{path}: is not an HDF5 file, or it is damaged") from None
        with file:
            data = self._find(file)
            self.dataset: str = data.name
            self._rank = data.ndim
            self.shape: tuple[int, int, int] = (tuple(data.shape) + (1, 1))[:3]  # slices have no x
            self.precision = np.dtype("f8") if data.dtype.itemsize == 8 else np.dtype("f4")
            self.attributes: dict[str, Any] = dict(data.attrs)
        self.n = tuple(self.shape[::-1])  # points along x, y, z

    def _find(self, file: h5py.File) -> h5py.Dataset:
        sets = {name: item for name, item in file.items() if isinstance(item, h5py.Dataset)}
        name = dataset_name(self.path)
        if name not in sets and len(sets) == 1:
            name = next(iter(sets))
        if name not in sets:
            raise InputError(f"{self.path}: holds neither a dataset '{name}' nor a single other one: it is not a field")
        if sets[name].dtype.kind not in "fiu" or not 2 <= sets[name].ndim <= 3 or sets[name].size == 0:
            raise InputError(f"{self.path}: dataset '{name}' is not a field in two or three dimensions")
        return sets[name]

    @property
    def time(self) -> float | None:
        """Returns the time of the field; None if the file does not state it."""
        return float(np.ravel(self.attributes["time"])[0]) if "time" in self.attributes else None

    def number(self, name: str) -> float:
        """Returns the attribute of that name."""
        if name not in self.attributes:
            raise InputError(f"{self.path}: has no attribute '{name}': give it one with postprocess set-hdf5-attribute "
                             f"{self.path} {name} 1 VALUE")
        return float(np.ravel(self.attributes[name])[0])

    @property
    def length(self) -> np.ndarray:
        """Returns the edges of the periodic box along x, y, z."""
        length = np.ravel(self.attributes.get("domain_size", ())).astype(float)
        if length.size != 3 or not (length > 0).all():
            raise InputError(f"{self.path}: has no domain_size: give it one with postprocess set-hdf5-attribute "
                             f"{self.path} domain_size 3 LX,LY,LZ")
        return length

    @property
    def origin(self) -> np.ndarray:
        """Returns the place of the first point."""
        return np.ravel(self.attributes.get("origin", np.zeros(3))).astype(float)

    @property
    def spacing(self) -> np.ndarray:
        """Returns the distances of the points."""
        return self.length / self.n

    def read(self, box: Box | None = None) -> np.ndarray:
        """Returns the values of a box of indices (z, y, x), or all of them, in double precision."""
        box = box or (slice(None),) * 3
        try:
            with h5py.File(self.path, "r") as file:
                values = np.asarray(file[self.dataset][box[:self._rank]], dtype="f8")
        except (OSError, KeyError):
            raise InputError(f"{self.path}: cannot be read: it was moved, changed or damaged after it was opened") from None
        if values.ndim == 2:
            values = values[:, :, None][:, :, box[2]]
        if not np.isfinite(values).all():
            raise InputError(f"{self.path}: has values that are not finite numbers (NaN); the run that wrote it may have diverged")
        return values

    def slabs(self, axis: int = 0) -> Iterator[Box]:
        """Returns boxes that fill the field, cut along an axis of the array (0 z, 1 y, 2 x)."""
        return slabs_of(self.shape, axis)


def slabs_of(shape: Sequence[int], axis: int = 0) -> Iterator[Box]:
    """Returns boxes of about SLAB_BYTES that fill an array, cut along one of its axes."""
    thick = max(1, int(SLAB_BYTES / (8 * np.prod(shape, dtype=float) / shape[axis])))
    for first in range(0, shape[axis], thick):
        box = [slice(None)] * 3
        box[axis] = slice(first, min(first + thick, shape[axis]))
        yield box[0], box[1], box[2]


def open_fields(paths: Sequence[str], same_time: bool = False) -> list[Field]:
    """Returns the fields in files, which must have the same points in the same box; with `same_time` also the same time."""
    problems, fields = [], []
    for path in paths:
        try:
            fields.append(Field(path))
        except InputError as error:
            problems.append(str(error))
    if problems:
        raise InputError("\n".join(problems))
    first = fields[0]
    for other in fields[1:]:
        if other.n != first.n:
            raise InputError(f"{other.path} has {points(other.n)} points, but {first.path} has {points(first.n)}: bring one to the "
                             f"size of the other with postprocess upsample")
        here, there = (f.attributes.get("domain_size") for f in (first, other))
        if here is not None and there is not None and not np.allclose(here, there, rtol=1e-6, atol=0):
            raise InputError(f"{other.path} and {first.path} are of different boxes (domain_size {box_text(there)} and "
                             f"{box_text(here)})")
        if same_time and first.time is not None and other.time is not None and abs(other.time - first.time) > 1e-6 * max(1, abs(first.time)):
            raise InputError(f"{other.path} is of time {other.time:g}, but {first.path} of {first.time:g}: give files of one time")
    return fields


def points(n: Sequence[int]) -> str:
    """Writes a number of points."""
    return " x ".join(str(value) for value in n)


def box_text(size: np.ndarray) -> str:
    """Writes the size of a box."""
    return " x ".join(f"{value:g}" for value in np.ravel(size))


class Output:
    """A field file that is being written. The attributes are those of `like`, except for the given ones. Use it in a `with`."""

    def __init__(self, path: str, like: Field, precision: np.dtype, tool: str, shape: Sequence[int] | None = None,
                 **attributes: Any) -> None:
        self.path, self.shape = Path(path), tuple(shape or like.shape)
        self._part = self.path.with_name(self.path.name + ".part")
        kept = {name: value for name, value in like.attributes.items() if name not in ("nxyz", "program")}
        kept.update(attributes)
        try:
            self._file = h5py.File(self._part, "w")
        except OSError:
            raise InputError(f"{path}: cannot be written: is there such a folder, and may you write into it?") from None
        self._data = self._file.create_dataset(dataset_name(self.path), shape=self.shape, dtype=precision)
        for name, value in kept.items():
            self._data.attrs[name] = np.atleast_1d(value) if np.asarray(value).dtype.kind in "fiu" else value
        self._data.attrs["nxyz"] = np.array(self.shape[::-1], dtype="i4")
        self._data.attrs["program"] = np.bytes_(f"flusi-msm postprocess {tool}")

    def __enter__(self) -> "Output":
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        self._file.close()
        if kind is None:
            os.replace(self._part, self.path)
        else:
            self._part.unlink()

    def write(self, values: np.ndarray, box: Box | None = None) -> None:
        """Stores the values of a box, or of the whole field."""
        try:
            with np.errstate(over="ignore"):
                self._data[box or (slice(None),) * 3] = values
        except OSError:
            raise InputError(f"{self.path}: cannot be written; is the disk full?") from None


def refuse_to_overwrite(inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Raises an error if an output is one of the inputs, by whatever name, or if two outputs are the same."""
    taken = {os.path.realpath(path): path for path in inputs}
    for path in outputs:
        real = os.path.realpath(path)
        if real in taken:
            raise InputError(f"{path}: would overwrite {'an input' if taken[real] in inputs else 'another output'}: choose another name")
        taken[real] = path
