#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the added mass of a surface without thickness that is accelerated from rest, normal to itself: a strip in a plane flow,
pi/4 rho c^2 per length, and a disk, rho D^3/3. docs/results/verification-wings.md holds the table and describes the study.

usage: run_added_mass [--program FLUSI] FOLDER [CASE ...]     runs the cases (all of them without names), then prints the table
       run_added_mass --list                                  names the cases

The last line is JSON. A case that has finished in FOLDER is not run again.
"""
import json
import math

import numpy as np
from plane_plate import read_options, run_flusi, series

BOX, END, NU = 6, 0.5, 0.01                      # the acceleration is 1, and so is the chord or the diameter
TIMES = (0.1, 0.2, 0.5)                          # when the momentum of the flow is compared with the exact one
EXACT = {"strip": math.pi / 4, "disk": 1 / 3}    # added mass over rho
GRIDS = {"strip": (8, 12, 16, 24, 32, 64), "disk": (8, 12, 16, 24)}
CASES = {f"{body}-{points}": (body, points) for body, grids in GRIDS.items() for points in grids}

INI = """\
; A surface that is accelerated from rest along {axis}, normal to itself. Units: its size, its acceleration, the density.
[Resolution]
nx = {nx}
ny = {n}
nz = {n}
[Geometry]
{xl}yl = {box}
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
eps = 0.01
[Insects]
WingShape = from_file::planform.ini
surface = thin
RightWing = no
x0 = {middle}
{attitude}
BodyMotion = from_file::start.t
[MeanFlow]
iMeanFlow = 1; the box is at rest
ux = 0.0
uy = 0.0
uz = 0.0
[Saving]
tintegral = {dt!r}
iDoBackup = no
progress_interval = 300
"""
STRIP = "[Wing]\ntype = rectangular\nroot = -0.5\nlength = 0.5\nmean_chord = 1.0\nfront = 0.5\n"
DISK = f"[Wing]\ntype = ellipse\nroot = -0.5\nlength = 0.5\nmean_chord = {math.pi / 4!r}\nfront = 0.5\n"
# The chord of the strip stands along z, and the wing of the disk is turned into the plane normal to x.
TURN = "[kinematics]\ntype = fourier\n" + "".join(
    f"nfft_{angle} = 1\na0_{angle} = {mean}\nai_{angle} = 0.0\nbi_{angle} = 0.0\n"
    for angle, mean in (("phi", 180.0), ("alpha", 0.0), ("theta", 0.0)))


def write(folder, body, points):
    """Writes the files of a run. A step moves the surface by less than a thirtieth of the spacing."""
    folder.mkdir(parents=True, exist_ok=True)
    is_plane = body == "strip"
    dt = 0.05 / points
    (folder / "planform.ini").write_text(STRIP if is_plane else DISK)
    (folder / "turn.ini").write_text(TURN)
    rows = []
    for i in range(round(END / dt) + 41):
        t = i * dt
        place, speed = [BOX / 2, BOX / 2, BOX / 2], [0.0, 0.0, 0.0]
        axis = 1 if is_plane else 0
        place[0] = 0.0 if is_plane else BOX / 2
        place[axis] += t**2 / 2
        speed[axis] = t
        rows.append(" ".join(f"{x:.15e}" for x in (t, *place, *speed)) + "  1 0 0 0  0 0 0\n")
    (folder / "start.t").write_text("".join(rows))
    n = points * BOX
    (folder / "run.ini").write_text(INI.format(
        axis="y" if is_plane else "x", nx="1" if is_plane else n, n=n, xl="" if is_plane else f"xl = {float(BOX)}\n",
        box=float(BOX), end=END, dt=dt, nu=NU, middle=f"0.0 {BOX / 2} {BOX / 2}" if is_plane else f"{BOX / 2} {BOX / 2} {BOX / 2}",
        attitude="FlappingMotion_left = from_file::turn.ini" if is_plane else "eta0 = 45.0"))


def measure(folder, body):
    """Returns the added mass of the first step, and the momentum that the flow has at TIMES over the speed, both over the exact added
    mass."""
    rows = series(folder / "forces.t")
    axis = 2 if body == "strip" else 1
    t, force = rows[:, 0], np.abs(rows[:, axis] + rows[:, axis + 3])
    momentum = np.cumsum(force * np.diff(t, prepend=0.0))  # a force is the mean over the step that ends at its time
    at = [int(np.argmin(np.abs(t - time))) for time in TIMES]
    return [float(x / EXACT[body]) for x in (force[t > 0][0], *(momentum[i] / t[i] for i in at))]


def main():
    options = read_options(__doc__, CASES)
    for name in options.cases or CASES:
        folder = options.folder / name
        if not (folder / "done").exists():
            write(folder, *CASES[name])
            run_flusi(options.program, folder)
    found = {name: measure(options.folder / name, body) for name, (body, _) in CASES.items() if (options.folder / name / "done").exists()}
    print(f"{'case':12s}{'first step':>12s}" + "".join(f"{f't = {time:g}':>10s}" for time in TIMES) + "   over the exact added mass")
    for name, ratios in found.items():
        print(f"{name:12s}{ratios[0]:12.4f}" + "".join(f"{ratio:10.4f}" for ratio in ratios[1:]))
    print(json.dumps({name: [round(ratio, 5) for ratio in ratios] for name, ratios in found.items()}))


if __name__ == "__main__":
    main()
