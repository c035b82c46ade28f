#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured natural frequencies of the Pazy wing in msm_diagnose, by tools/import_modes (docs/results/vibration-study.md).

usage: pazy_modes.py <msm_diagnose> <h5dump> [tests]

The model is a uniform beam. The published inertia of the wing (00_Models/01_Pazy_Technion of the data that tests/data/pazy-modes.csv
cites) has 20.683 g at each of its stations, which are 0.55/15 m apart, but at the tip 32.8 g, and beside it 4.8 g, more than a uniform
beam. The answer is therefore known: a mass of 37.6 g at the tip.
"""
import json
import subprocess
import sys

import numpy as np
from synthetic_bending import ADEQUATE, SET
from whole_program import SOURCE, check, main

from flusi_msm.wing.file import Wing, write_wing

SPAN, SEGMENTS = 0.55, 30              # [m]
MOMENT = 1e-10                         # [m^4]: E = 1e10 Pa times the bending stiffness [N m^2]
STATIC = 4.703                         # [N m^2] of the Pre-Pazy wing, from bending tests: docs/results/prepazy.md
TIP_MASS = 0.0376                      # [kg]
DIAMETER = (64 * MOMENT / np.pi)**0.25
DENSITY = 0.020683 / (SPAN / 15) / (np.pi * DIAMETER**2 / 4)
INPUT = """[Wing]
file = pazy.h5;
E = 4.475e10;
k_e = 3e7;
[Mass]
vein_density = {density};
{more}
[Measurement]
file = modes.h5;
[Diagnose]
parameters = E;
refine = no;
noise = declared;
starts = 1;
draws = 1000;
[Saving]
name = {name};
"""


def diagnose(case, name, more=""):
    """Exit code and JSON of the diagnosis of all six frequencies."""
    points = np.zeros((SEGMENTS + 1, 3))
    points[:, 0] = np.linspace(0, SPAN, SEGMENTS + 1)
    write_wing(case.folder / "pazy.h5", Wing(points, np.zeros((0, 3), int),
                                             {"spar": (list(range(SEGMENTS + 1)), np.full(SEGMENTS + 1, DIAMETER))}, {}, [0]))
    for table, more_options in (("pazy-modes", ()), ("pazy-modes-weight", ("--gravity", "0", "0", "-9.81", "--add"))):
        subprocess.run([sys.executable, "-B", SOURCE / "tools/import_modes", SOURCE / f"tests/data/{table}.csv", "-o", "modes.h5",
                        "--frequency-units", "Hz", "--frequencies", "undamped", "--medium", "air", "--wing", "pazy.h5", *more_options],
                       cwd=case.folder, check=True, stdout=subprocess.DEVNULL)
    done = case.flusi(case.write(f"{name}.ini", INPUT.format(density=DENSITY, more=more, name=name)), "--exit-code", timeout=300)
    check(done.code in (ADEQUATE, SET), f"{done.code} {done.out}{done.err}")
    found = json.loads((case.folder / f"{name}.json").read_text())
    print(f"    {name}: {done.code} {found['verdict']['sentence']}", flush=True)
    return done.code, found


def test_uniform(case):
    """A uniform beam: a set, which has the mass at the tip, and no name. No further mode would tell its members apart."""
    code, found = diagnose(case, "uniform")
    check(code == SET and found["verdict"]["grade"] == "B", found["verdict"]["sentence"])
    check("point_mass" in found["verdict"]["set"] and "E_gradient" in found["verdict"]["set"], f"{found['verdict']['set']}")


def test_known_mass(case):
    """With the mass at the tip nothing is left to explain. The stiffness is that of the bending tests, within 2 sd of both."""
    code, found = diagnose(case, "known", f"point_mass = {SPAN} 0.0 {TIP_MASS};")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    modulus, = [one for one in found["baseline"]["parameters"] if one["name"] == "E"]
    stiffness = modulus["value"] * MOMENT
    print(f"    EI {stiffness:.3f} N m^2, sd {100 * modulus['sd']:.1f} %, chi^2 {found['baseline']['chi2']:.2f}")
    check(abs(np.log(stiffness / STATIC)) < 2 * modulus["sd"], f"EI is {stiffness} N m^2")


if __name__ == "__main__":
    main(globals())
