# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the XDMF indices that a run writes: they state what each dataset is, and its time."""
from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

import h5py

from flusi_msm.errors import InputError, Problems


class Source(NamedTuple):
    """A dataset of a file next to the index, with the shape and the bytes per number that the index states."""

    file: str
    dataset: str
    shape: tuple[int, ...]
    precision: int


class Quantity(NamedTuple):
    """A quantity on the points or, if not `on_points`, on the cells; a vector of the flow has a source for each component."""

    sources: tuple[Source, ...]
    on_points: bool


class Step(NamedTuple):
    """One time. `triangles` and `points` are those of a surface; a flow has `origin` and `spacing` (x, y, z) and `shape` (z, y,
    x)."""

    time: float
    quantities: dict[str, Quantity]
    points: Source | None = None
    triangles: Source | None = None
    origin: tuple[float, ...] = ()
    spacing: tuple[float, ...] = ()
    shape: tuple[int, ...] = ()


def _part(element: ElementTree.Element, name: str) -> ElementTree.Element:
    found = element.find(name)
    if found is None:
        raise ValueError(f"a {element.tag} has no {name}")
    return found


def _attribute(element: ElementTree.Element, name: str) -> str:
    value = element.get(name)
    if value is None:
        raise ValueError(f"a {element.tag} has no {name}")
    return value


def _numbers(element: ElementTree.Element) -> tuple[float, ...]:
    return tuple(float(word) for word in (element.text or "").split())


def _source(item: ElementTree.Element) -> Source:
    file, dataset = (item.text or "").strip().split(":/")
    return Source(file, dataset, tuple(int(n) for n in _attribute(item, "Dimensions").split()), int(_attribute(item, "Precision")))


def _quantity(attribute: ElementTree.Element) -> Quantity:
    item = _part(attribute, "DataItem")
    parts = item.findall("DataItem") if item.get("ItemType") == "Function" else [item]
    return Quantity(tuple(map(_source, parts)), attribute.get("Center") == "Node")


def _step(grid: ElementTree.Element) -> Step | None:
    topology, geometry = grid.find("Topology"), grid.find("Geometry")
    if grid.get("GridType") != "Uniform" or topology is None or geometry is None:
        return None
    time = float(_attribute(_part(grid, "Time"), "Value"))
    quantities = {_attribute(attribute, "Name"): _quantity(attribute) for attribute in grid.findall("Attribute")}
    if topology.get("TopologyType") == "3DCoRectMesh":
        origin, spacing = (_numbers(item)[::-1] for item in geometry.findall("DataItem"))
        shape = tuple(int(n) for n in _attribute(topology, "Dimensions").split())
        return Step(time, quantities, origin=origin, spacing=spacing, shape=shape)
    if topology.get("TopologyType") == "Triangle":
        return Step(time, quantities, _source(_part(geometry, "DataItem")), _source(_part(topology, "DataItem")))
    return None


def read_index(path: Path) -> list[Step]:
    """Returns the steps of an index in the order of time; none if it is of another kind (the shapes of `flusi --solid` and
    `--static`). Raises an InputError where it cannot be read."""
    try:
        series = ElementTree.parse(path).getroot().findall("Domain/Grid")
        if len(series) != 1 or series[0].get("CollectionType") != "Temporal":
            return []
        grids = series[0].findall("Grid")
        steps = [step for step in map(_step, grids) if step is not None]
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except (ElementTree.ParseError, AttributeError, ValueError, TypeError) as error:
        raise InputError(f"{path}: not an index of this program: {error}") from None
    return [] if len(steps) < len(grids) else sorted(steps, key=lambda step: step.time)


def check_sources(folder: Path, steps: list[Step], problems: Problems) -> None:
    """Reports every file and dataset that does not exist or does not agree with the index."""
    for step in steps:
        wanted = [source for quantity in step.quantities.values() for source in quantity.sources]
        wanted += [source for source in (step.points, step.triangles) if source]
        for source in dict.fromkeys(wanted):
            path = folder / source.file
            try:
                with h5py.File(path, "r") as file:
                    if source.dataset not in file:
                        problems.error(f"{path}: no dataset '{source.dataset}'")
                    elif file[source.dataset].shape != source.shape:
                        problems.error(f"{path}: '{source.dataset}' has the shape {file[source.dataset].shape}, the index of the run "
                                       f"says {source.shape}")
            except OSError:
                problems.error(f"{path}: " + ("not a readable HDF5 file" if path.exists() else "no such file"))
