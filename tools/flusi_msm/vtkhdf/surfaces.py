# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the surface of a wing or of a body as one VTKHDF PolyData with time. Surfaces are small and copied."""
from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.vtkhdf.fields import begin
from flusi_msm.vtkhdf.index import Source, Step

CELLS = ("Vertices", "Lines", "Polygons", "Strips")  # of PolyData, in the order of the columns of Steps/CellOffsets
TRIANGLES = CELLS.index("Polygons")


def read(folder: Path, source: Source) -> np.ndarray:
    """Returns the array of a source."""
    with h5py.File(folder / source.file, "r") as file:
        return file[source.dataset][...]


def behind_each_other(counts: np.ndarray) -> np.ndarray:
    """Returns where each of several consecutive blocks begins."""
    return np.concatenate([[0], np.cumsum(counts)[:-1]]).astype("i8")


def write_triangles(group: h5py.Group, meshes: list[np.ndarray]) -> None:
    """Writes triangles of all steps, one part each."""
    count = np.array([len(mesh) for mesh in meshes], dtype="i8")
    none = np.zeros(len(meshes), dtype="i8")
    for number, name in enumerate(CELLS):
        cells = group.create_group(name)
        mine = count if number == TRIANGLES else none
        cells["NumberOfCells"] = mine
        cells["NumberOfConnectivityIds"] = 3 * mine
        # Every part has one number more than cells: where each cell begins and where the last one ends.
        cells["Offsets"] = np.concatenate([3 * np.arange(n + 1, dtype="i8") for n in mine])
        cells["Connectivity"] = np.concatenate([mesh.ravel() for mesh in meshes]).astype("i8") if number == TRIANGLES else none[:0]
    offsets = np.zeros((len(meshes), len(CELLS)), dtype="i8")
    offsets[:, TRIANGLES] = behind_each_other(count)
    group["Steps/CellOffsets"] = offsets
    group["Steps/ConnectivityIdOffsets"] = 3 * offsets


def quantities_of(steps: list[Step], path: str) -> list[tuple[str, bool]]:
    """Returns (name, whether it is on the points). Raises an InputError if they change with time."""
    found = [{(name, quantity.on_points) for name, quantity in step.quantities.items()} for step in steps]
    for step, have in zip(steps, found):
        if have != found[0]:
            changed = ", ".join(sorted(name for name, _ in have ^ found[0]))
            raise InputError(f"{path}: {changed} is not there at all times between t = {steps[0].time:g} and {step.time:g}")
    return [(name, quantity.on_points) for name, quantity in steps[0].quantities.items()]


def write_surface(path: str, steps: list[Step]) -> list[str]:
    """Writes the file and returns the names of its quantities. The sources are in its folder."""
    folder = Path(path).parent
    quantities = quantities_of(steps, path)
    points = [read(folder, step.points) for step in steps if step.points]
    meshes = [read(folder, step.triangles) for step in steps if step.triangles]
    with h5py.File(path, "w", libver=("earliest", "v110")) as file:
        group = begin(file, "PolyData", steps)
        n_points = np.array([len(block) for block in points], dtype="i8")
        group["NumberOfPoints"] = n_points
        group["Points"] = np.concatenate(points)
        write_triangles(group, meshes)
        times = group["Steps"]
        times["NumberOfParts"] = np.ones(len(steps), dtype="i8")
        times["PartOffsets"] = np.arange(len(steps), dtype="i8")
        times["PointOffsets"] = behind_each_other(n_points)
        for place, kind, begins in ((True, "PointData", times["PointOffsets"][...]),
                                    (False, "CellData", times["CellOffsets"][:, TRIANGLES])):
            for name in (name for name, on_points in quantities if on_points == place):
                values = [read(folder, step.quantities[name].sources[0]) for step in steps]
                group.require_group(kind)[name] = np.concatenate(values)
                times.require_group(kind + "Offsets")[name] = begins
    return [name for name, _ in quantities]
