# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the flusi case of a section whose motion is stated, as an experimenter would: the simulation with which msm_diagnose
compares a blind flight. Lengths of the case are in chords, and times in chords over the mean speed pi f times the stroke."""
from __future__ import annotations

import math
import os
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flusi_msm.errors import InputError
from flusi_msm.hovering_plate import write_plate, write_stroke

NAME = "hover.ini"
RECORDS = 200   # of forces in a beat
CASE = """; A plate that hovers as it is stated. Units: chord, chord over the mean speed.
[units]
length = {length!r}; m
frequency = {unit!r}; 1/s
density = {density!r}; kg/m^3
[Resolution]
nx = 1; two-dimensional
ny = {cells}
nz = {cells}
[Geometry]
yl = {box!r}
zl = {box!r}
[Time]
Tmax = {end!r}
dt_fixed = {dt!r}
[ReynoldsNumber]
nu = {nu!r}
[InitialCondition]
inicond = quiescent
[Penalization]
iPenalization = yes
iMask = Insect
eps = {eps!r}
[Insects]
WingShape = from_file::plate.ini
surface = thin
RightWing = no
x0 = 0.0 {middle!r} {middle!r}
BodyMotion = from_file::stroke.t
FlappingMotion_left = from_file::pitch.ini
wing_frequency = {beat!r}
[MeanFlow]
iMeanFlow = 1; the box is at rest
ux = 0.0
uy = 0.0
uz = 0.0
[Saving]
tintegral = {record!r}
iDoBackup = no
progress_interval = 300
"""


@dataclass(frozen=True)
class Grid:
    """How finely the section is simulated."""
    points: int = 12    # in a chord
    box: int = 8        # chords
    step: float = 0.25  # of dx over the mean speed


def write_section(folder: Path, stated: Mapping[str, Any], grid: Grid = Grid()) -> Path:
    """Writes the case into a folder, all of it or nothing, unless it exists. `stated` has wing, kinematics and fluid of
    measurement.flight, and `beats`. Returns the path of the parameter file."""
    if not (folder / NAME).exists():
        part = folder.with_name(f"{folder.name}.{os.getpid()}.part")
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
        _write(part, stated, grid)
        try:
            os.rename(part, folder)
        except OSError:
            shutil.rmtree(part)
            if not (folder / NAME).exists():
                raise InputError(f"{folder}: cannot be made") from None
    return folder / NAME


def _write(folder: Path, stated: Mapping[str, Any], grid: Grid) -> None:
    wing, k, fluid = stated["wing"], stated["kinematics"], stated["fluid"]
    if wing["hinge"] != 0.5 or any(k["centre"]) or any(fluid["wind"]):
        raise InputError("a blind flight turns about the middle of its chord and about the middle of its path, in a fluid at rest")
    chord, speed = wing["chord"], math.pi * k["frequency"] * k["stroke"]
    stroke, dt = k["stroke"] / chord, grid.step / grid.points
    period, box = math.pi * stroke, float(grid.box)
    write_plate(folder, 0.5, k["pitch"], k["lead"], k["mean_angle"])
    write_stroke(folder, stroke, period, stated["beats"], box / 2, RECORDS)
    (folder / NAME).write_text(CASE.format(
        length=chord, unit=k["frequency"] * period, density=fluid["density"], cells=grid.box * grid.points, box=box,
        end=stated["beats"] * period, dt=dt, nu=fluid["viscosity"] / (speed * chord), eps=1.2 * dt, middle=box / 2, beat=1 / period,
        record=period / RECORDS))
