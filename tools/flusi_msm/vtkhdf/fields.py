# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the flow of a run as one VTKHDF ImageData with time. It consists of virtual datasets: the numbers stay in the files of
the run."""
from __future__ import annotations

import h5py
import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.vtkhdf.index import Quantity, Step


def begin(file: h5py.File, kind: str, steps: list[Step]) -> h5py.Group:
    """Makes the group VTKHDF of a file with the times of the steps."""
    group = file.create_group("VTKHDF")
    group.attrs["Version"] = np.array([2, 0], dtype="i8")
    group.attrs.create("Type", kind.encode("ascii"), dtype=h5py.string_dtype("ascii", len(kind)))  # the reader needs ASCII of fixed length
    times = group.create_group("Steps")
    if len(steps) == 1:  # the reader uses Steps for two times or more
        group["FieldData/TimeValue"] = np.array([steps[0].time])
    times.attrs["NSteps"] = np.int64(len(steps))
    times["Values"] = np.array([step.time for step in steps], dtype="f8")
    return group


def grid_of(steps: list[Step], path: str) -> Step:
    """Returns the first step; raises an InputError if another one has another grid."""
    first = steps[0]
    for step in steps[1:]:
        if step.shape != first.shape or not np.allclose(step.spacing + step.origin, first.spacing + first.origin, rtol=1e-12):
            raise InputError(f"{path}: the grid at t = {step.time:g} is another one than at t = {first.time:g}; a VTKHDF file has one")
    return first


def virtual(steps: list[Step], name: str, shape: tuple[int, ...]) -> h5py.VirtualLayout:
    """Returns the quantity at all times, (time, z, y, x), vectors with (..., component). If there is only one time there is no
    axis of time, because the reader expects none. Where the run did not save it, it is not a number."""
    known: list[Quantity] = [step.quantities[name] for step in steps if name in step.quantities]
    components = len(known[0].sources)
    one_time = len(steps) == 1
    whole = ((len(steps),) if not one_time else ()) + tuple(shape) + ((components,) if components > 1 else ())
    precision = max(source.precision for quantity in known for source in quantity.sources)
    layout = h5py.VirtualLayout(whole, dtype=f"<f{precision}")
    for number, step in enumerate(steps):
        if name not in step.quantities:
            continue
        for component, source in enumerate(step.quantities[name].sources):
            part = h5py.VirtualSource(source.file, source.dataset, source.shape, dtype=f"<f{source.precision}")
            where = (() if one_time else (number,)) + (slice(None),) * 3 + ((component,) if components > 1 else ())
            layout[where] = part
    return layout


def write_fields(path: str, steps: list[Step]) -> list[str]:
    """Writes the file next to those that it refers to, and returns the names of its quantities. It can be moved only together
    with them. Raises an InputError if the grid changes with time."""
    first = grid_of(steps, path)
    names: dict[str, None] = dict.fromkeys(name for step in steps for name in step.quantities)
    with h5py.File(path, "w", libver=("v110", "v110")) as file:  # virtual datasets are of HDF5 1.10
        group = begin(file, "ImageData", steps)
        group.attrs["WholeExtent"] = np.ravel([(0, n - 1) for n in first.shape[::-1]]).astype("i8")
        group.attrs["Origin"] = np.array(first.origin, dtype="f8")
        group.attrs["Spacing"] = np.array(first.spacing, dtype="f8")
        group.attrs["Direction"] = np.eye(3).ravel()
        data, offsets = group.create_group("PointData"), group["Steps"].create_group("PointDataOffsets")
        for name in names:
            data.create_virtual_dataset(name, virtual(steps, name, first.shape), fillvalue=np.nan)
            offsets[name] = np.arange(len(steps), dtype="i8")
    return list(names)
