#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""No bending test tells a force sensor that reads too little from a wing that is softer everywhere. msm_diagnose says that natural
modes would, and by how much; modes of tools/make_modes, whose stiffness and masses share nothing with the solver, then do.

usage: diagnosis_next_kinds.py <msm_diagnose> <h5dump> [tests]

Heights and frequencies have declared errors and are made without, so that separations have no chance in them.
"""
import csv
import json
import shutil
import subprocess
import sys

import h5py
from synthetic_bending import NAMED, SET, WING, diagnose, measure
from whole_program import SOURCE, check, main

from json_schema import validate

OPTIONS = "observations = 120;\nnoise = declared;\nstarts = 1;\ndraws = 500;\nrefits = 2;\nintervals = no;\nvalidation = no;\n"
# The last load bends the wing so far that another scale of the heights does not look like another force.
BENDING = {"stiffness": {"plate": "edges"}, "hidden": {"force_gain": 1.12}, "noise": {"height": 1e-9, "reference_scans": 1000},
           "declared": {"height": 5e-7}, "protocol": {"levels": [1.0]},
           "loads": [[0.00405, 0.00066, 2.0e-3], [0.00541, 0.00005, 6.0e-4], [0.00721, -0.00032, 1.6e-4], [0.00856, -0.00078, 1.0e-4],
                     [0.0034, -0.00139, 2.2e-3]]}
FREQUENCY_SD = 0.004  # relative
TWINS = {"force_gain", "elasticity"}


def add_modes(case, file, count, medium):
    """Adds frequencies of the lowest modes, with their numbers and a declared error."""
    test = {"wing": WING, "modes": count, "sites": 6, "medium": medium, "air_ratio": 1.0, "stiffness": {"plate": "edges"},
            "noise": {"frequency": 1e-7, "shape": 1e-3}}
    (case.folder / "modes.json").write_text(json.dumps(test))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_modes", "modes.json", "-o", file, "--add"], cwd=case.folder, check=True,
                   stdout=subprocess.DEVNULL)
    with h5py.File(case.folder / file, "r+") as data:
        frequencies = []
        for number in range(1, count + 1):
            mode = data[f"modes/mode{number}"]
            for name in "points", "shape", "sigma":
                del mode[name]
            mode.attrs["number"] = number
            mode.attrs["frequency_sigma"] = FREQUENCY_SD * mode.attrs["frequency"]
            frequencies.append(float(mode.attrs["frequency"]))
    return frequencies


def best_of(found, kind):
    return next(one for one in found["next"]["measurements"] if one["kind"] == kind)


def test_modes(case):
    """The table ranks modes first, and no load tells both apart; with these modes the diagnosis names the gain."""
    measure(case, "data.h5", **BENDING)
    # Of a release less is known, so that modes come first.
    code, found = diagnose(case, "data.h5", "before", f"{OPTIONS}[Next]\nfrequency_sd = {FREQUENCY_SD};\nmotion_sd = 0.1;\nsamples = 60;\n")
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")
    cause, others = found["verdict"]["causes"][0]["effect"], found["next"]["other_members"]
    check(code == SET and {cause, *others} == TWINS, f"bending leaves {cause} and {others}")
    table = found["next"]["measurements"]
    first, load, release = table[0], best_of(found, "bending"), best_of(found, "series")
    print(f"    now {found['next']['from_members_now_sd']} sd, with modes {first['from_members_sd']} sd, with a release "
          f"{release['from_members_sd']} sd, with a load {load['from_members_sd']} sd")
    check(first["kind"] == "modes" and first["tells_apart"] == others, f"{first}")
    # Large deflections tell them apart a little. At 0.5 sd their log likelihoods differ by 1/8, a twenty-fourth of the 3 of a name.
    check(load["from_members_sd"][0] < 0.5 and not load["tells_apart"], "no load tells both apart")
    # docs/theory/diagnosis.md has 9 sd. Errors are declared and not drawn, so that half of the last digit is its uncertainty.
    check(abs(first["from_members_sd"][0] - 9) < 0.5, f"modes separate them by {first['from_members_sd'][0]} sd")
    check(sorted(table, key=lambda one: -one["separation_sd"]) == table, "the best one comes first")
    with open(case.folder / "before_next_measurements.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    check([row["kind"] for row in rows] == [one["kind"] for one in table], "the table is the same in the CSV file")
    check(rows[0]["tells apart"] == others[0] and rows[0]["measurement"].startswith("natural modes 1 to 4 in "), f"{rows[0]}")
    frequencies = add_modes(case, "data.h5", 4, first["medium"])
    for expected, frequency in zip(first["frequencies_hz"], frequencies):
        print(f"    mode expected at {expected:.1f} Hz, at {frequency:.1f} Hz")
        # The wing of the baseline is softer by the gain of 12 %: its frequencies are 6 % lower. The generator has them 1 to 3 % lower.
        check(abs(expected / frequency - 1) < 0.1, f"expected modes have {expected} Hz, not {frequency} Hz")
    code, found = diagnose(case, "data.h5", "after", f"{OPTIONS}[Next]\nsamples = 20;\n")
    check(code == NAMED and found["verdict"]["set"] == ["force_gain"], found["verdict"]["sentence"])


def test_no_mass(case):
    """A wing whose mass nobody states: the table says why it has no modes, and so does the plan."""
    bare = case.folder / "wing.h5"
    shutil.copy(WING, bare)
    with h5py.File(bare, "r+") as file:
        for name in "mass_source", "membrane_law", "membrane_mass", "membrane_weights", "vein_density":
            del file.attrs[name]
    measure(case, "data.h5", **{**BENDING, "loads": BENDING["loads"][:2]})
    text = f"[Wing]\nfile = {bare};\n[Measurement]\nfile = data.h5;\n[Diagnose]\nparameters = E;\nrefine = no;\n{OPTIONS}"
    done = case.run(case.write("bare.ini", text + "[Saving]\nname = bare;\n"), "--plan")
    check("Natural modes and records of motion were not tried: they need the mass of the wing" in done.out, done.out)
    plan = json.loads((case.folder / "bare_plan.json").read_text())
    check("membrane_mass" in plan["motion_not_tried"], f"{plan['motion_not_tried']}")
    check(not any("with_motion" in one for one in plan["effects"]), "no strength with motion")
    done = case.run(case.write("given.ini", text + "[Mass]\nmembrane_mass = 8e-8;\n[Saving]\nname = given;\n"), "--plan")
    check("with modes in vacuum" in done.out, done.out)
    plan = json.loads((case.folder / "given_plan.json").read_text())
    check(any("with_motion" in one for one in plan["effects"]), "strengths with motion")
    problems = validate(plan, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")


if __name__ == "__main__":
    main(globals())
