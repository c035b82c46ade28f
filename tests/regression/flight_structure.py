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
from whole_program import SOURCE, check, main, series

from json_schema import validate

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


LIGHT = "[Mass]\nmembrane_factor = 0.85\n"


def check_mass(found, code, flights, text, hidden=0.85):
    """The cause is the mass of the membrane, as hidden within three sd of its interval, and flights took part in its fit as `flights` says."""
    check(code == NAMED and found["verdict"]["set"] == ["membrane_mass"] or code == SET and flights == "round", text)
    cause = found["verdict"]["causes"][0]
    check(cause["effect"] == "membrane_mass" and cause.get("flights") == flights, f"{cause}: {text}")
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")
    lower, best, upper = (math.log(x) for x in found["extended"]["intervals_90"][0]["lower_best_upper"])
    sd = (upper - lower) / (2 * 1.645)
    check(abs(best - math.log(hidden)) < 3 * sd, f"{hidden} is hidden: {math.exp(best)}, sd {sd}")
    return sd


def test_first(case):
    """A membrane that is lighter by 15 %, in two natural frequencies and forces: flights for its mass are among the first ones, and all data
    determine it. What the frequencies alone leave is 2 sd / sqrt(2 frequencies); forces as exact as these halve it."""
    add_modes(case.folder / "data.h5", 0.85, 1)
    add_record(case.folder / "data.h5", flown(LIGHT), 2, error=0.05)
    flight = "effects = membrane_mass, balance_gain\nrounds = 0\n"
    _, _, text = diagnose(case, "data.h5", "first", flight, flags=("--plan",), parameters="D")
    check(text.startswith("flights   5 of ") and "parameters of the wing: membrane_mass\n" in text, f"the case, and twice for D and the mass: {text}")
    code, found, text = diagnose(case, "data.h5", "first", flight, parameters="D")
    sd = check_mass(found, code, "first", text)
    check(sd < 0.75 * 2 * ERROR / math.sqrt(2), f"sd {sd}")
    changed = (case.folder / "first_extended_flight.ini").read_text()
    best = found["extended"]["intervals_90"][0]["lower_best_upper"][1]
    check(abs(float(changed.split("membrane_factor = ")[1].split()[0]) / best - 1) < 1e-6, f"the case with this mass: {changed}")


def test_round(case):
    """A mass of three quarters, without first flights for it: the frequencies find it, it is flown with its value, and the forces of the fit are those of a
    flight of its own with this mass."""
    add_modes(case.folder / "data.h5", 0.75, 1)
    add_record(case.folder / "data.h5", flown(LIGHT.replace("0.85", "0.75")), 2, error=0.4)
    code, found, text = diagnose(case, "data.h5", "later", "effects = balance_gain\nrounds = 3\n", parameters="D")
    check(text.startswith("flights   3 of "), f"the case, and twice for D: {text}")
    check_mass(found, code, "round", text, 0.75)
    best = found["extended"]["intervals_90"][0]["lower_best_upper"][1]
    wanted = flown(f"[Mass]\nmembrane_factor = {best}\n")
    for one, values in zip((s for d in found["data"] if d["kind"] == "flight" for s in d["sets"]), wanted.T):
        apart = [np.sqrt(np.mean((np.array(one[which]) - values)**2)) for which in ("extended", "simulated")]
        # The last round is about a mass within a tenth of an sd of the fit.
        check(apart[0] < 0.05 * apart[1], f"{one['name']}: {apart}")


def test_no_round(case):
    """Without rounds the other data alone determine a cause, and the diagnosis says so."""
    add_modes(case.folder / "data.h5", 0.85, 1)
    add_record(case.folder / "data.h5", flown(LIGHT), 2, error=0.4)
    _, found, text = diagnose(case, "data.h5", "none", "effects = balance_gain\nrounds = 0\n", parameters="D")
    cause = found["verdict"]["causes"][0]
    check(cause["flights"] == "no" and "[Flight] rounds = 0" in cause["flights_reason"], f"{cause}: {text}")
    check("flights   take no part in the fit of" in text, text)


def test_alone(case):
    """Forces alone name the mass if its flights are asked for."""
    add_record(case.folder / "data.h5", flown(LIGHT), 2, error=0.05)
    code, found, text = diagnose(case, "data.h5", "alone", "effects = membrane_mass, balance_gain\nrounds = 1\n")
    check_mass(found, code, None, text)


def test_effects(case):
    """Flights of every cause of the structure that a user can name run to their end."""
    names = ("root_stiffness E_gradient E_per_vein taper orthotropy thickness_gradient pretension camber vein_torsion joint_hardening cuticle "
             "vein_mass membrane_mass membrane_gradient")
    add_record(case.folder / "data.h5", flown(LIGHT), 2, error=0.05)
    _, found, text = diagnose(case, "data.h5", "all", f"effects = {names.replace(' ', ', ')}\nrounds = 0\n")
    status = {one["name"]: one["status"] for one in found["effects"]}
    for name in names.split():
        # Hardening needs two forces at one place of a bending test.
        check((status[name] == "not_testable") == (name in ("joint_hardening", "cuticle")), f"{name} {status[name]}: {text}")


def test_mistakes(case):
    """Names that are none, places, and parameters that the baseline does not fit."""
    add_record(case.folder / "data.h5", np.ones((25, 2)), 1)
    for name, hint in (("E_gradiant", "did you mean 'E_gradient'"), ("damage", "there is no effect 'damage'"), ("joint:*", "valid: ")):
        _, _, text = diagnose(case, "data.h5", "wrong", f"effects = {name}\n", flags=("--plan",))
        check("[Flight] effects: there is no effect" in text and hint in text, text)


if __name__ == "__main__":
    shutil.rmtree("flights", ignore_errors=True)  # those of this program alone
    flight_stiffness.FLUSI = str(Path(sys.argv.pop(3)).resolve())
    main(globals())
