#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Causes of the structure in records of a flight: the filament of flight_stiffness.py with another mass or a softer end. Data and
diagnosis have the same grid, which is far too coarse for physics.

usage: flight_structure.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import functools
import math
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import flight_stiffness
import h5py
import numpy as np
from flight_stiffness import DENSITY, FILAMENT, PERIOD, PLATE, TIMES, YOUNG, add_record, diagnose, write_case
from synthetic_bending import NAMED, SET, seal
from whole_program import check, main, series

FILAMENT["Mass"]["areal_density"] = 2.5 * DENSITY  # light enough not to flutter
BEATS = flight_stiffness.BEATS = 1
FILAMENT["Time"]["Tmax"] = PERIOD * BEATS
ROOTS = {1: 1.8751041, 5: 4.6940911}  # of 1 + cos x cosh x = 0, a clamped bar, by the number of the mode: others twist and shear
ERROR = 0.02                             # relative, of a frequency
SPARS = 2 * math.pi * 0.1**4 / 64        # moment of area, m^4 per metre of width


@functools.lru_cache(maxsize=None)
def flown(changes):
    """Fy and Fz [N/m] at TIMES of the last beat of a flight of its own, with these sections behind the case."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_case(folder)
        (folder / "run.ini").write_text("[include]\nfile = heave.ini;\n" + changes)
        subprocess.run([flight_stiffness.FLUSI, "run.ini"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        rows = np.array(series(folder / "forces.t").rows)
    t = rows[:, 0] / PERIOD - (BEATS - 1)
    return DENSITY * np.stack([np.interp(TIMES, t, rows[:, k] + rows[:, k + 3]) for k in (2, 3)], axis=1)


def add_modes(path, mass, seed):
    """Adds the lowest frequencies of a clamped bar with the stiffness of the filament and so many times its mass."""
    rng = np.random.default_rng(seed)
    with h5py.File(path, "a", libver=("v108", "v108")) as f:
        f.attrs.update(schema="flusi-msm measurement", version=1)
        for number, root in ROOTS.items():
            frequency = root**2 / (2 * math.pi) * math.sqrt((YOUNG * SPARS + PLATE) / (mass * FILAMENT["Mass"]["areal_density"]))
            f.create_group(f"modes/number{number}").attrs.update(
                frequency=frequency * (1 + ERROR * rng.standard_normal()), frequency_sigma=ERROR * frequency, medium="vacuum", number=number)
    seal(path)


def interval(found, name):
    one, = (x for x in found["extended"]["intervals_90"] if x["name"] == name)
    return one["lower_best_upper"]


def test_first(case):
    """A membrane that is 40 % heavier, in modes and forces: named with flights before the decision."""
    add_modes(case.folder / "data.h5", 0.85, 1)
    add_record(case.folder / "data.h5", flown("[Mass]\nmembrane_factor = 0.85\n"), 2, error=0.05)
    code, found, text = diagnose(case, "data.h5", "first", "effects = membrane_mass, balance_gain\nrounds = 0\n", parameters="D")
    print(text)
    print(found["extended"].get("intervals_90"))


def test_round(case):
    add_modes(case.folder / "data.h5", 0.85, 1)
    add_record(case.folder / "data.h5", flown("[Mass]\nmembrane_factor = 0.85\n"), 2, error=0.2)
    code, found, text = diagnose(case, "data.h5", "later", "effects = balance_gain\nrounds = 3\n", parameters="D")
    print(text)
    print(found["extended"].get("intervals_90"))


def test_alone(case):
    add_record(case.folder / "data.h5", flown("[Mass]\nmembrane_factor = 0.85\n"), 2, error=0.05)
    code, found, text = diagnose(case, "data.h5", "alone", "effects = membrane_mass, balance_gain\nrounds = 1\n")
    print(text)
    print(found["extended"].get("intervals_90"))


if __name__ == "__main__":
    #shutil.rmtree("flights", ignore_errors=True)  # those of this program alone
    flight_stiffness.FLUSI = str(Path(sys.argv.pop(3)).resolve())
    main(globals())
