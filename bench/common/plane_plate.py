# SPDX-License-Identifier: GPL-3.0-or-later
"""Flights of a plate that hovers in a plane flow, which several studies fly: their input files, their series, and the command line."""
import argparse
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from flusi_msm.hovering_plate import write_plate, write_stroke

ROOT = Path(__file__).resolve().parents[2]
PITCH = 45.0             # degrees
STEP = 0.15              # of dx/U

INI = """\
; A plate that hovers: chord 1, U = pi f A0 = 1, Re = U c/nu = {re}. Units: c, c/U.
[Resolution]
nx = 1; two-dimensional
ny = {cells}
nz = {cells}
[Geometry]
yl = {box}
zl = {box}
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
{surface}
RightWing = no
x0 = 0.0 {middle} {middle}
BodyMotion = from_file::stroke.t
FlappingMotion_left = from_file::pitch.ini
wing_frequency = {frequency!r}
[MeanFlow]
iMeanFlow = 1; the box is at rest
ux = 0.0
uy = 0.0
uz = 0.0
[Sponge]
iVorticitySponge = yes
iSpongeType = 2D_frame
eps_sponge = 0.1
sponge_thickness = {sponge}
[Saving]
tintegral = {record!r}
iDoBackup = no
progress_interval = 300
"""


def write(folder, re, stroke, beats, points, cells, is_drawn_in, box, spacing=2.0, inset=0.0):
    """Writes the files of a run: the place of the plate is A0/2 cos(2 pi f t), the angle of its chord 90 + 45 sin(2 pi f t)
    degrees. `spacing` is the distance of markers in dx. The plate is shorter by `inset` dx at both ends."""
    folder.mkdir(parents=True, exist_ok=True)
    period, middle = math.pi * stroke, box / 2
    end = beats * period
    half = 0.5 - (cells / 2 if is_drawn_in else inset) / points
    dt = STEP / points
    write_plate(folder, half, PITCH)
    write_stroke(folder, stroke, period, beats, middle, 400)
    (folder / "run.ini").write_text(INI.format(
        re=re, cells=points * box, box=float(box), end=end, dt=dt, nu=1 / re, eps=1.2 * dt, middle=middle, frequency=1 / period,
        surface=f"surface = penalized\nWingThickness = {cells / points!r}" if cells
        else f"surface = thin\nmarker_spacing = {spacing!r}",
        sponge=points // 2, record=period / 400))


def run_flusi(program, folder):
    """Runs flusi with run.ini in the folder, and marks the folder as done."""
    program = str(Path(program).resolve())
    with open(folder / "log", "w") as log:
        done = subprocess.run([program, "run.ini", "--overwrite"], cwd=folder, stdout=log, stderr=log, check=False)
    if done.returncode:
        sys.exit(f"{folder}: flusi stops with {done.returncode}; see {folder / 'log'}")
    (folder / "done").touch()


def series(path):
    return np.array([[float(x) for x in line.split()] for line in path.read_text().splitlines()
                     if line.strip() and line.lstrip()[0] != "%"])


def read(folder, stroke):
    """Reads t/T, the force along y and z on the plate, and the power that it gives to the flow, in units of rho U^2 c/2 and
    rho U^3 c/2."""
    forces, power = series(folder / "forces.t"), series(folder / "aero_power.t")
    f = forces[:, 1:4] + forces[:, 4:7]
    return forces[:, 0] / (math.pi * stroke), 2 * f[:, 1], 2 * f[:, 2], 2 * np.interp(forces[:, 0], power[:, 0], power[:, 1])


def mean_over(t, x):
    """Returns the mean over t of the polygon through the points (t, x)."""
    return float(np.sum(np.diff(t) * (x[1:] + x[:-1]) / 2) / (t[-1] - t[0]))


def read_measured(folder, name):
    """Reads t/T and a coefficient, as digitised; returns None without the file."""
    path = folder / f"{name}_measured.dat" if folder else None
    return series(path) if path and path.exists() else None


def along_stroke(t, force):
    """Returns the drag: the force against the motion of each half-stroke."""
    return np.where((t % 1) < 0.5, force, -force)


def read_options(text, known):
    """Returns the options of a program that computes the `known` cases. The program ends here if they are only to be listed.
    `text` is its help."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/flusi"), help="flusi (that of build/release)")
    parser.add_argument("--measured", type=Path)
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    options = parser.parse_args()
    if options.list:
        print("\n".join(known))
        sys.exit()
    if options.folder is None or not set(options.cases) <= set(known):
        parser.error("a folder is needed, and cases that --list names")
    return options


def fly(options, known):
    """Runs those of the chosen cases that have not finished; the known cases are {name: arguments of `write`}."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    for name in options.cases or known:
        if not (options.folder / name / "done").exists():
            write(options.folder / name, *known[name])
            run_flusi(options.program, options.folder / name)
