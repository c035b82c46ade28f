# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads height maps in the formats that instruments write: CSV, NPZ, TIFF, MAT."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.importers.tables import Table, read_table


@dataclass
class Pixels:
    """Properties of a picture that its file does not contain; in the units of axes and heights."""
    size: tuple[float, float] | None = None  # of one pixel along x and y
    count: float | None = None               # height of one step of an integer
    zero: float = 0.0                           # the integer that means height 0
    missing: float | None = None             # the number that means no height


@dataclass
class Map:
    """Heights z[j, i] at (x[i], y[j]), both increasing, in the units of the file; sigma of the same shape, or None."""
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    sigma: np.ndarray | None = None
    notes: list[str] = field(default_factory=list)  # how the file was understood


def read_csv_map(path: Path, pixels: Pixels) -> Map:
    """Reads a table with x in its first line and y in its first column, or with one line `x,y,z` (and sigma) for every height."""
    table = read_table(path)
    rows = table.rows
    names = [cell.lower().split("[")[0].split("(")[0].strip() for cell in rows[0]]
    if names[:3] == ["x", "y", "z"]:
        return from_points(path, table, names)
    if len(rows) < 3 or len(rows[0]) < 3:
        raise InputError(f"{path}: a map has at least two columns and two rows of heights ({table.spelling()})")
    values, wrong = np.full((len(rows), len(rows[0])), np.nan), []
    for j, row in enumerate(rows):
        if len(row) != len(rows[0]):
            wrong.append(f"{path}: line {table.lines[j]} has {len(row)} cells, the first one {len(rows[0])} ({table.spelling()})")
            continue
        for i, cell in enumerate(row):
            if (j, i) != (0, 0):
                values[j, i] = number_of(path, table, j, i, cell, wrong)
    stop_if(path, wrong)
    return Map(values[0, 1:], values[1:, 0], values[1:, 1:], None, [table.spelling()])


def number_of(path: Path, table: Table, j: int, i: int, cell: str, wrong: list[str]) -> float:
    """Returns the number in a cell, or NaN and one mistake more."""
    try:
        return table.number(cell)
    except ValueError:
        wrong.append(f"{path}: line {table.lines[j]}, cell {i + 1}: {cell!r} is not a number ({table.spelling()})")
        return np.nan


def stop_if(path: Path, wrong: list[str]) -> None:
    """Raises an error with the first five mistakes, if there are any."""
    if wrong:
        more = [f"{path}: and {len(wrong) - 5} more of this kind"] if len(wrong) > 5 else []
        raise InputError("\n".join(wrong[:5] + more))


def from_points(path: Path, table: Table, names: list[str]) -> Map:
    """Returns a map of lines x, y, z; places without a line have no height."""
    wrong: list[str] = []
    short = [table.lines[j] for j, row in enumerate(table.rows) if len(row) < len(names)]
    if short:
        raise InputError(f"{path}: line {short[0]} has less cells than the first one ({table.spelling()})")
    values = np.array([[number_of(path, table, j, i, cell, wrong) for i, cell in enumerate(row[:len(names)])]
                       for j, row in enumerate(table.rows[1:], 1)])
    stop_if(path, wrong)
    x, i = np.unique(values[:, 0], return_inverse=True)
    y, j = np.unique(values[:, 1], return_inverse=True)
    if x.size * y.size > 4 * len(values) + 1000:
        raise InputError(f"{path}: its points do not lie on a grid: {x.size} different x and {y.size} different y of {len(values)} points")
    z, sigma = np.full((y.size, x.size), np.nan), None
    z[j, i] = values[:, 2]
    if "sigma" in names:
        sigma = np.full(z.shape, np.nan)
        sigma[j, i] = values[:, names.index("sigma")]
    return Map(x, y, z, sigma, [table.spelling(), "one line for each height"])


def read_npz_map(path: Path, pixels: Pixels) -> Map:
    """Reads arrays x, y and z, and if wanted sigma."""
    try:
        with np.load(path) as arrays:
            return from_arrays(path, {name: arrays[name] for name in arrays.files})
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error


def read_mat_map(path: Path, pixels: Pixels) -> Map:
    """Reads variables x, y and z, and if wanted sigma; those of version 7.3 are HDF5 and transposed."""
    import h5py
    try:
        if h5py.is_hdf5(path):
            with h5py.File(path, "r") as file:
                found = from_arrays(path, {name: np.asarray(file[name]).T for name in file if isinstance(file[name], h5py.Dataset)})
        else:
            from scipy.io import loadmat
            found = from_arrays(path, {name: value for name, value in loadmat(path).items() if not name.startswith("__")})
    except (OSError, ValueError, NotImplementedError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    return found


def from_arrays(path: Path, arrays: dict[str, np.ndarray]) -> Map:
    """Returns a map of arrays; x and y are lines, or matrices of meshgrid."""
    missing = [name for name in "xyz" if name not in arrays]
    if missing:
        raise InputError(f"{path}: has no array {', '.join(missing)}; it has {', '.join(sorted(arrays)) or 'none'}")
    try:
        values: dict[str, np.ndarray] = {name: np.asarray(arrays[name], float) for name in ("x", "y", "z", "sigma") if name in arrays}
    except (TypeError, ValueError):
        raise InputError(f"{path}: x, y, z must be numbers") from None
    axes: dict[str, np.ndarray] = {}
    for name, along in (("x", 1), ("y", 0)):
        axis = values[name]
        if axis.ndim == 2 and 1 in axis.shape:
            axis = axis.ravel()
        elif axis.ndim == 2 and axis.shape == values["z"].shape:  # meshgrid
            line = axis[0, :] if along else axis[:, 0]
            if not np.array_equal(axis, np.broadcast_to(line[None, :] if along else line[:, None], axis.shape)):
                raise InputError(f"{path}: {name} is a matrix, but not the same in every {'row' if along else 'column'}")
            axis = line
        axes[name] = axis
    return Map(axes["x"], axes["y"], values["z"], values.get("sigma"))


def read_tiff_map(path: Path, pixels: Pixels) -> Map:
    """Reads a grey picture of integers (8, 16, 32 bit) or reals. Its lowest row has y = 0, its left column x = 0."""
    from PIL import Image, UnidentifiedImageError
    Image.MAX_IMAGE_PIXELS = None
    try:
        with Image.open(path) as picture:
            counts, pages = np.asarray(picture), getattr(picture, "n_frames", 1)
    except (OSError, UnidentifiedImageError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    wrong = []
    if counts.ndim != 2 or counts.dtype == bool:
        raise InputError(f"{path}: is not a grey picture: its pixels have the shape {counts.shape[2:] or 'of bits'}")
    if pages > 1:
        wrong.append(f"{path}: has {pages} pages; save one height map in a file")
    if pixels.size is None:
        wrong.append(f"{path}: a picture does not say how large it is: give --pixel SIZE in --axis-units")
    is_real = counts.dtype.kind == "f"
    if not is_real and pixels.count is None:
        wrong.append(f"{path}: holds integers: give --height-per-count, the height of one step in --height-units")
    if wrong or pixels.size is None:
        raise InputError("\n".join(wrong))
    z = counts.astype(float)
    if pixels.missing is not None:
        z[counts == pixels.missing] = np.nan
    if pixels.count is not None:
        z = (z - pixels.zero) * pixels.count
    width, height = pixels.size
    note = f"{8 * counts.dtype.itemsize} bit {'reals' if is_real else 'integers'}, the lowest row is y = 0"
    return Map(width * np.arange(z.shape[1]), height * np.arange(z.shape[0]), z[::-1], None, [note])


READERS: dict[str, Callable[[Path, Pixels], Map]] = {
    ".csv": read_csv_map, ".txt": read_csv_map, ".tsv": read_csv_map, ".xyz": read_csv_map, ".npz": read_npz_map,
    ".tif": read_tiff_map, ".tiff": read_tiff_map, ".mat": read_mat_map}


def read_map(path: Path, pixels: Pixels = Pixels()) -> Map:
    """Reads the map of a file in any of these formats; its axes increase, and it has no infinite heights."""
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path}: is in no known form; valid: {', '.join(READERS)}")
    found = reader(path, pixels)
    x, y, z, sigma = found.x, found.y, found.z, found.sigma
    if x.ndim != 1 or y.ndim != 1 or z.shape != (y.size, x.size):
        raise InputError(f"{path}: z has the shape {z.shape}; {y.size} y and {x.size} x ask for ({y.size}, {x.size})")
    if sigma is not None and (sigma.shape != z.shape or not (np.isfinite(sigma) & (sigma > 0))[np.isfinite(z)].all()):
        raise InputError(f"{path}: sigma must have the shape of z, and be positive where there is a height")
    wrong = []
    for name, axis in (("x", x), ("y", y)):
        steps = np.diff(axis)
        if not np.isfinite(axis).all() or not (np.all(steps > 0) or np.all(steps < 0)):
            wrong.append(f"{path}: {name} neither increases nor decreases from grid line to grid line")
    if np.isinf(z).any():
        wrong.append(f"{path}: has infinite heights; missing ones are empty or nan")
    if wrong:
        raise InputError("\n".join(wrong))
    along_x, along_y = slice(None, None, -1 if x[0] > x[-1] else 1), slice(None, None, -1 if y[0] > y[-1] else 1)
    if sigma is not None:
        sigma = np.where(np.isfinite(z), sigma, 1.0)[along_y, along_x]  # without a height it is not used
    return Map(x[along_x], y[along_y], z[along_y, along_x], sigma, found.notes)
