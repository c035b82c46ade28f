# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds natural modes and records of motion to measurement files (docs/formats/measurement-format.md), and tells which places are
on a wing."""
from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.seal import write_seal

LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
MEDIA = ("air", "vacuum")
NEAR = 0.01        # of the wing's length: a place near a point of a wing without triangles
INSIDE = -1e-9     # smallest share of a corner in a place on a triangle
AIR_DENSITY = 1.2  # [kg/m^3], where a file states none

Group = tuple[Mapping[str, Any], Mapping[str, Any]]  # attributes and datasets


def held(path: str | Path, section: str) -> dict[str, dict[str, Any]]:
    """Returns the groups of a section of a measurement file: their attributes, and the shapes of their datasets as `NAME.shape`."""
    import h5py
    if not Path(path).exists():
        return {}
    try:
        with h5py.File(path) as file:
            found = {}
            for name, group in file.get(section, {}).items():
                shapes = {f"{key}.shape": item.shape for key, item in group.items() if isinstance(item, h5py.Dataset)}
                found[name] = {**dict(group.attrs), **shapes, "has_loads": "loads" in group}
            return found
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error}") from error


def write_groups(path: str | Path, section: str, groups: Mapping[str, Group], air_density: float | None, is_added: bool) -> None:
    """Makes a measurement file, or adds to one that exists, and seals it. `air_density` None: as in the file, or the default."""
    import h5py
    try:
        with h5py.File(path, "a" if is_added else "w", libver=("v108", "v108")) as file:
            file.attrs["schema"], file.attrs["version"] = np.bytes_("flusi-msm measurement"), np.int32(1)
            top = file.require_group(section)
            stated = float(top.attrs.get("air_density", AIR_DENSITY)) if len(top) else air_density
            if air_density is not None and stated != air_density:
                raise InputError(f"--air-density {air_density:g}: /{section} of {path} has {stated:g} kg/m^3; a file has one density")
            if air_density is not None:
                top.attrs["air_density"] = air_density
            for name, (attributes, data) in groups.items():
                group = top.create_group(name)
                for key, value in attributes.items():
                    group.attrs[key] = (np.bytes_(value) if isinstance(value, str) else np.int32(value) if isinstance(value, int)
                                        else np.asarray(value, "<f8"))
                for key, numbers in data.items():
                    group.create_dataset(key, data=np.asarray(numbers, "<f8"), track_times=False)
                if "points" in data:
                    group["points"].attrs["units"] = np.bytes_("m")
        write_seal(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written: {error}") from error


class OnWing:
    """Tells which places (x, y) [m] are on a wing, by the rule of the program that reads the file. Without a wing, all are."""

    def __init__(self, path: str | None) -> None:
        self.path = path
        if path is None:
            return
        from flusi_msm.wing.file import read_wing
        wing = read_wing(path)
        self.points, self.triangles = np.asarray(wing.points)[:, :2], np.asarray(wing.triangles, int).reshape(-1, 3)
        self.length = float(np.linalg.norm(self.points - self.points[wing.root].mean(axis=0), axis=1).max())

    def mistake(self, place: np.ndarray) -> str:
        """Returns what is wrong with a place; an empty text for one that is on the wing, or for an unknown wing or place."""
        if self.path is None or not np.isfinite(place).all():
            return ""
        distance = float(np.linalg.norm(self.points - place, axis=1).min())
        if len(self.triangles):
            a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
            whole = twice_area(a, b, c)
            shares = np.stack([twice_area(place, b, c), twice_area(a, place, c), twice_area(a, b, place)]) / whole
            is_on = bool((shares.min(axis=0) >= INSIDE).any())
        else:
            is_on = distance <= NEAR * self.length
        far = np.abs(place).max() > 30 * self.length or 0 < np.abs(place).max() < self.length / 1000
        return "" if is_on else (f"({place[0]:g}, {place[1]:g}) m is not on the wing {self.path}, of length {self.length:g} m; its nearest "
                                 f"point is {distance:.3g} m away" + ("; is --length-units right?" if far else ""))


def twice_area(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Returns twice the area of triangles (.., 2), negative if their corners go clockwise."""
    return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
