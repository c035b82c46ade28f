#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces on a plate that hovers in a plane flow, in msm_diagnose. The data come from flusi on a finer grid, with noise that covers what
the grids differ by, so that a cause is found through another discretisation than that of the diagnosis.

usage: flight_records.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import functools
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
from synthetic_bending import ADEQUATE, NAMED, SET
from whole_program import SOURCE, check, main

RE, STROKE, BOX, BEATS = 75, 2.0, 6, 2
PERIOD = math.pi * STROKE  # c/U, with U = pi f A0 = 1
LENGTH, FREQUENCY, DENSITY = 0.01, 50.0, 1.2  # SI values of chord and beat; of the case: one T is c/U
UNIT_FREQUENCY = FREQUENCY * PERIOD
TIMES = (np.arange(30) + 0.5) / 30
FORCE = DENSITY * LENGTH**3 * UNIT_FREQUENCY**2  # N/m

INI = """\
[units]
length = {length!r}
frequency = {unit!r}
density = {density!r}
[Resolution]
nx = 1;
ny = {cells}
nz = {cells}
[Geometry]
yl = {box}.0
zl = {box}.0
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
surface = {surface}
{thickness}RightWing = no
x0 = 0.0 {middle} {middle}
BodyMotion = from_file::stroke.t
FlappingMotion_left = from_file::pitch.ini
wing_frequency = {beat!r}
{more}[MeanFlow]
iMeanFlow = 1;
ux = 0.0
uy = 0.0
uz = 0.0
[Saving]
tintegral = {record!r}
iDoBackup = no
progress_interval = 300
"""
PLATE = "[Wing]\ntype = rectangular\nroot = -0.5\nlength = 0.5\nmean_chord = 1.0\nfront = 0.5\n"
TURN = """[kinematics]
type = fourier
nfft_phi = 1
a0_phi = 180.0
ai_phi = 0.0
bi_phi = 45.0
nfft_alpha = 1
a0_alpha = 0.0
ai_alpha = 0.0
bi_alpha = 0.0
nfft_theta = 1
a0_theta = 0.0
ai_theta = 0.0
bi_theta = 0.0
"""


def write_case(folder, points, surface="thin", more=""):
    """A case with so many points per chord."""
    folder.mkdir(parents=True, exist_ok=True)
    middle = BOX / 2
    (folder / "plate.ini").write_text(PLATE)
    (folder / "pitch.ini").write_text(TURN)
    rows = []
    for i in range(200 * BEATS + 41):
        t = i * PERIOD / 200
        w = 2 * math.pi * t / PERIOD
        y, v = middle + STROKE / 2 * math.cos(w), -STROKE / 2 * (2 * math.pi / PERIOD) * math.sin(w)
        rows.append(f"{t:.12e} 0 {y:.12e} {middle} 0 {v:.12e} 0  1 0 0 0  0 0 0\n")
    (folder / "stroke.t").write_text("".join(rows))
    dt = 0.2 / points
    (folder / "hover.ini").write_text(INI.format(
        length=LENGTH, unit=UNIT_FREQUENCY, density=DENSITY, cells=BOX * points, box=BOX, end=BEATS * PERIOD, dt=dt, nu=1 / RE, eps=1.2 * dt,
        surface=surface, thickness="" if surface == "thin" else f"WingThickness = {4 / points!r}\n", middle=middle, beat=1 / PERIOD,
        more=more, record=PERIOD / 200))


@functools.lru_cache(maxsize=None)
def flown(flusi, points, more=""):
    """Fy, Fz [N/m] at TIMES of the last beat of a flight of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_case(folder, points, more=more)
        subprocess.run([flusi, "hover.ini"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        lines = (folder / "forces.t").read_text().splitlines()
        rows = np.array([[float(x) for x in line.split()] for line in lines if not line.lstrip().startswith("%")])
    t = rows[:, 0] / PERIOD - (BEATS - 1)
    return FORCE * np.stack([np.interp(TIMES, t, rows[:, 1 + c] + rows[:, 4 + c]) for c in (1, 2)], axis=1)


def write_data(path, mean, sd, seed):
    rng = np.random.default_rng(seed)
    with h5py.File(path, "w", libver=("v108", "v108")) as f:
        f.attrs.update(schema="flusi-msm measurement", version=1)
        flight = f.create_group("flight/hover")
        flight.attrs.update(frequency=FREQUENCY, beats=16, frame="lab", reference=np.zeros(3), components="Fy, Fz", units="N/m, N/m",
                            per_length=1)
        flight["time"] = TIMES
        flight["mean"] = mean + sd * rng.standard_normal(mean.shape)
        flight["sd"] = np.full(mean.shape, sd)


def diagnose(case, data, name, more="", ranks=1, flags=(), cache="flights"):
    """Exit code, JSON (or none) and what was printed."""
    case_folder = case.folder / "case"
    if not case_folder.exists():
        write_case(case_folder, 8)
    (case.folder / f"{name}.ini").write_text(
        f"[Wing]\nfile = {SOURCE}/wings/calliphora_small.h5\nE = 12.58e9\nD = 2e-7\n[Measurement]\nfile = {data}\n"
        f"[Flight]\nfile = case/hover.ini\nbeats = {BEATS}\nharmonics = 12\nfolder = {cache}\n{more}"
        f"[Diagnose]\nnoise = declared\ndraws = 1000\nstarts = 1\n[Saving]\nname = {name}\n")
    command = [*(["mpirun", "-n", str(ranks)] if ranks > 1 else []), str(case.program), f"{name}.ini", "--exit-code", *flags]
    done = subprocess.run(command, cwd=case.folder, capture_output=True, text=True, check=False)
    path = case.folder / f"{name}.json"
    return done.returncode, json.loads(path.read_text()) if path.exists() else None, done.stdout + done.stderr
