# SPDX-License-Identifier: GPL-3.0-or-later
"""Interpolates fields at any point of the periodic box, and computes the vorticity there or in the whole box, from its files or
else from the velocity with the derivatives of the solver. Only the necessary data are read, unless they are smoothed: a run may be
larger than the memory.
"""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flusi_msm.results.files import Field, InputError, Snapshot, derivative_in_plane, field_path, has_field, load_field

VELOCITY = ("ux", "uy", "uz")
VORTICITY = ("vorx", "vory", "vorz")


class Block:
    """The grid points around some points (m, 3): `count` of them from `start` on along x, y, z, continued periodically."""

    def __init__(self, field: Field, points: np.ndarray) -> None:
        self.n = field.n
        place = (np.asarray(points, dtype=float) - field.origin) / field.spacing
        self.start = np.floor(place.min(axis=0)).astype(int)
        self.count = np.minimum(np.floor(place.max(axis=0)).astype(int) + 2 - self.start, self.n)
        self.place = place - self.start

    def read(self, field: Field, whole: int | None = None) -> np.ndarray:
        """Returns the field in the block, (z, y, x); along the axis `whole` all of it."""
        if tuple(field.n) != tuple(self.n):
            raise InputError(f"{field.path}: {' x '.join(map(str, field.n))} points, unlike the other fields")
        where, wrapped = [slice(None)] * 3, []
        for axis in range(3):
            begin = self.start[axis] % self.n[axis]
            end = begin + self.count[axis]
            if axis == whole:
                continue
            if end <= self.n[axis]:
                where[2 - axis] = slice(begin, end)
            else:
                wrapped.append((2 - axis, np.arange(begin, end) % self.n[axis]))
        data = field.data[tuple(where)].astype(float)
        for array_axis, index in wrapped:
            data = np.take(data, index, axis=array_axis)
        return data

    def derivative(self, field: Field, along: int) -> np.ndarray:
        """Returns the derivative of the field along an axis, in the block."""
        lines = derivative_in_plane(self.read(field, whole=along), 2 - along, field.length[along])
        index = (self.start[along] + np.arange(self.count[along])) % self.n[along]
        return np.take(lines, index, axis=2 - along)

    def interpolate(self, values: np.ndarray) -> np.ndarray:
        """Returns values at the points from those in the block, trilinear."""
        lower = np.floor(self.place).astype(int)
        part = self.place - lower
        result = np.zeros(len(lower))
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, part, 1 - part), axis=1)
            x, y, z = ((lower + corner) % self.count).T
            result += weight * values[z, y, x]
        return result


def vorticity_source(snapshot: Snapshot) -> str:
    """Returns 'vorticity' or 'velocity', whichever has its three files."""
    for name, files in (("vorticity", VORTICITY), ("velocity", VELOCITY)):
        if all(has_field(snapshot, file) for file in files):
            return name
    lacking = [u for u in VELOCITY if not has_field(snapshot, u)]
    raise InputError(f"the vorticity needs {field_path(snapshot, 'vorx')}, vory, vorz or the velocity; "
                     f"missing: {', '.join(lacking)}")


def at_points(snapshot: Snapshot, name: str, points: np.ndarray) -> np.ndarray:
    """Returns a stored field at points (m, 3)."""
    field = load_field(snapshot, name)
    block = Block(field, points)
    return block.interpolate(block.read(field))


def vorticity_at(snapshot: Snapshot, points: np.ndarray, direction: Sequence[float] | np.ndarray, smooth: bool = False) -> np.ndarray:
    """Returns omega . direction at points (m, 3), with `smooth` of the mean over three grid points in each direction."""
    stored = vorticity_source(snapshot) == "vorticity"
    fields = [load_field(snapshot, name, smooth) for name in (VORTICITY if stored else VELOCITY)]
    block = Block(fields[0], points)
    total = np.zeros(block.count[::-1])
    for c, part in enumerate(direction):
        one, two = (c + 1) % 3, (c + 2) % 3
        if part == 0:
            continue
        if stored:
            total += part * block.read(fields[c])
        else:
            total += part * (block.derivative(fields[two], one) - block.derivative(fields[one], two))
    return block.interpolate(total)


def every(field: Field, stride: int) -> np.ndarray:
    """Returns every stride-th point of a field along each axis, in single precision, read plane by plane."""
    planes = [field.data[k][::stride, ::stride] for k in range(0, field.data.shape[0], stride)]
    return np.array(planes, dtype="f4")


def vorticity_files(snapshot: Snapshot, smooth: bool = False) -> tuple[str, ...]:
    """Returns the stored fields from which |omega| is known, with `smooth` its components where they are known."""
    has_parts = any(all(has_field(snapshot, name) for name in names) for names in (VORTICITY, VELOCITY))
    if has_field(snapshot, "vorabs") and not (smooth and has_parts):
        return ("vorabs",)
    return VORTICITY if vorticity_source(snapshot) == "vorticity" else VELOCITY


def vorticity_magnitude(snapshot: Snapshot, stride: int = 1, smooth: bool = False) -> np.ndarray:
    """Returns |omega| at every stride-th point of the box, in single precision; with `smooth` the magnitude of the mean over three
    grid points in each direction, or, if a run has stored the magnitude alone, its mean."""
    names = vorticity_files(snapshot, smooth)
    fields = [load_field(snapshot, name, smooth) for name in names]
    if names == ("vorabs",):
        return every(fields[0], stride)
    square: np.ndarray | float = 0.0
    for c in range(3):
        one, two = (c + 1) % 3, (c + 2) % 3
        if names == VORTICITY:
            part = every(fields[c], stride)
        else:  # the derivatives need all points
            part = (derivative_in_plane(fields[two].data[...], 2 - one, fields[two].length[one])
                    - derivative_in_plane(fields[one].data[...], 2 - two, fields[one].length[two]))
            part = part[::stride, ::stride, ::stride].astype("f4")
        square = square + part**2
    return np.sqrt(square)
