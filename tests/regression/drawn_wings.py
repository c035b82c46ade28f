#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The wings that are shipped as drawings: each is made, trained on a measurement of another program, and flies.

usage: drawn_wings.py <msm_train> <h5dump> <flusi> [tests]

The measurement hides nothing but E, which is found again. Meshes and grids are far too coarse for physics; what is tested is that a drawing goes all the way.
"""
import re
import subprocess
import sys

import h5py
import numpy as np
from whole_program import EXIT_OK, SOURCE, Case, check, ini_text, main

FLUSI = sys.argv.pop(3)
TOOLS = SOURCE / "tools"
TRUE_E = 9e9
# Edge length [mm], length [m], wing beats [1/s], bending stiffness D of the membrane [N m], forces [N] at parts of the length
# that bend the wing by a few per cent of it, mass of the membrane [ug].
WINGS = {
    "calliphora": (0.7, 9.0e-3, 158, 1e-8, ((0.5, 1e-3), (0.8, 1e-4)), 60),
    "bee": (0.7, 9.25e-3, 230, 1e-8, ((0.5, 4e-4), (0.8, 3e-5)), 50),
    "fly": (0.2, 2.42e-3, 220, 2e-9, ((0.5, 4e-5), (0.8, 1e-5)), 3),
    "rectangle": (0.7, 8.0e-3, 150, 1e-8, ((0.5, 6e-4), (0.9, 2e-4)), 40),
}


def drawn(case, name):
    """The wing file, its mass [ug] as the tool tells it, and the loads."""
    done = subprocess.run([sys.executable, "-B", TOOLS / "make_wing", SOURCE / f"wings/{name}.svg", "-o", "wing.h5", "--edge",
                    str(WINGS[name][0]), "--mesher", "own", "--no-picture", "--membrane-mass",
                           str(WINGS[name][5]), "--mass-source", "a guess"], cwd=case.folder, check=True, stdout=subprocess.PIPE,
                          text=True)
    mass = float(re.search(r"together ([\d.]+) ug", done.stdout).group(1))
    with h5py.File(case.folder / "wing.h5") as file:
        points = file["points"][:]
        front = np.concatenate([group["nodes"][:] - 1 for group in file["veins"].values()])
    places = []
    for part, force in WINGS[name][4]:
        near = front[np.abs(points[front, 0] - part * points[:, 0].max()).argmin()]  # a point of a vein
        places.append([float(points[near, 0]), float(points[near, 1]), force])
    return mass, places


def train(case, name, loads):
    text = f'{{"title": "{name}", "wing": "wing.h5", "loads": {loads}, "spacing": {WINGS[name][1] / 20}, ' \
           f'"stiffness": {{"E": {TRUE_E}, "D": {WINGS[name][3]}, "plate": "edges"}}, "noise": {{"height": {WINGS[name][1] * 1e-5}}}}}'
    case.write("measure.json", text)
    subprocess.run([sys.executable, "-B", TOOLS / "make_measurement", "measure.json", "-o", "measurement.h5"], cwd=case.folder,
                   check=True, stdout=subprocess.DEVNULL)
    case.write("train.ini", ini_text({
        "Wing": {"file": "wing.h5", "E": 5e9, "D": WINGS[name][3]}, "Measurement": {"file": "measurement.h5"},
        "Train": {"parameters": "E", "seed": 1}, "CMAES": {"max_generations": 1, "restarts": "none"},
        "Polish": {"intervals": "no"}, "Saving": {"name": "train", "result": "trained.ini"}}))
    run = case.run("train.ini", ranks=0)
    check(run.code == EXIT_OK, run.out + run.err)
    found = float(re.search(r"^E = ([^;]*);", (case.folder / "trained.ini").read_text(), re.M).group(1))
    # The other program bends a mesh of half the edge length; edges of 0.08 of the wing's length make E wrong by up to that.
    check(abs(found / TRUE_E - 1) < 0.1, f"{name}: E is found, {found:.4g} for {TRUE_E:.4g} Pa")


def fly(case, name, mass):
    flight = Case(FLUSI, case.h5dump, case.folder / "flight")
    _, length, frequency, *_ = WINGS[name]
    motion = f"from_file::{SOURCE}/ini/kinematics/calliphora.ini"
    flight.write("fly.ini", ini_text({
        "include": {"file": "../trained.ini"},
        "units": {"length": length, "frequency": frequency, "density": 1.225},
        "Resolution": {"nx": 32, "ny": 32, "nz": 16}, "Geometry": {"xl": 4.0, "yl": 4.0, "zl": 2.0},
        "Time": {"nt": 8, "dt_fixed": 4e-3}, "ReynoldsNumber": {"nu": 5e-3}, "InitialCondition": {"inicond": "quiescent"},
        "Penalization": {"iPenalization": 1, "iMask": "Insect", "eps": 5e-3},
        "Insects": {"wings": "flexible", "x0": "2.0 2.0 1.0", "yawpitchroll_0": "180.0 0.0 0.0", "eta0": -70.0,
                    "x_pivot_l": "0.0 0.5 0.0", "x_pivot_r": "0.0 -0.5 0.0", "wing_ramp": 0.05,
                    "FlappingMotion_left": motion, "FlappingMotion_right": motion},
        "Wing": {"file": "../wing.h5"},
        "Saving": {"tintegral": 4e-3, "tsave": 1.0}}))
    run = flight.run("fly.ini", ranks=0)
    check(run.code == EXIT_OK, run.out + run.err)
    told = float(re.search(r"^bending .* mass ([\d.]+) ug", run.out, re.M).group(1))
    check(abs(told - mass) < 0.06, f"{name}: the wing weighs what its file says: {told}, {mass} ug")
    check("the program assumes" not in run.out + run.err, f"nothing is assumed:\n{run.out}{run.err}")
    rows = flight.series("bending_left.t").rows
    check(len(rows) >= 8, "every step is recorded")
    moved = max(abs(row[4]) for row in rows)
    check(0 < moved < 0.5, f"{name}: the wing bends, and not wildly: {moved}")


def all_the_way(case, name):
    mass, loads = drawn(case, name)
    train(case, name, loads)
    fly(case, name, mass)


def test_calliphora(case):
    all_the_way(case, "calliphora")


def test_bee(case):
    all_the_way(case, "bee")


def test_fly(case):
    all_the_way(case, "fly")


def test_rectangle(case):
    all_the_way(case, "rectangle")


if __name__ == "__main__":
    main(globals())
