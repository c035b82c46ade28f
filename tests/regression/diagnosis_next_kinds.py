#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""No bending test tells a force sensor that reads too little from a wing that is softer everywhere. msm_diagnose says that natural
modes would, and by how much; modes of tools/make_modes, whose stiffness and masses share nothing with the solver, then do.

usage: diagnosis_next_kinds.py <msm_diagnose> <h5dump> [tests]

Heights and frequencies have declared errors and are made without, so that separations have no chance in them.
"""
import csv
import json
import subprocess
import sys

import h5py
from synthetic_bending import NAMED, SET, WING, diagnose, measure
from whole_program import SOURCE, check, main

from json_schema import validate

OPTIONS = "observations = 120;\nnoise = declared;\nstarts = 1;\ndraws = 500;\nrefits = 2;\nintervals = no;\nvalidation = no;\n"
GAIN = 1.2
BENDING = {"stiffness": {"plate": "edges"}, "hidden": {"force_gain": GAIN}, "noise": {"height": 1e-9, "reference_scans": 1000},
           "declared": {"height": 1e-6}}
FREQUENCY_SD = 0.004  # relative
TWINS = {"force_gain", "elasticity"}
APART = 2.45  # sd


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
    options = f"{OPTIONS}[Next]\nmodes = 4;\nfrequency_sd = {FREQUENCY_SD};\n"
    code, found = diagnose(case, "data.h5", "before", options)
    check(code == SET and set(found["verdict"]["set"]) == TWINS, f"{found['verdict']['set']}")
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")
    table = found["next"]["measurements"]
    first, load, release = table[0], best_of(found, "bending"), best_of(found, "series")
    print(f"    modes {first['from_members_sd']} sd, release {release['from_members_sd']} sd, load {load['from_members_sd']} sd")
    check(first["kind"] == "modes" and set(first["tells_apart"]) | {found["verdict"]["causes"][0]["effect"]} == TWINS, f"{first}")
    check(load["from_members_sd"][0] < 0.5 and not load["tells_apart"], "no load tells both apart")
    check(sorted(table, key=lambda one: -one["separation_sd"]) == table, "the best one comes first")
    with open(case.folder / "before_next_measurements.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    check([row["kind"] for row in rows] == [one["kind"] for one in table], "the table is the same in the CSV file")
    check(rows[0]["tells apart"] in TWINS and rows[0]["measurement"].startswith("natural modes 1 to 4 in "), f"{rows[0]}")
    frequencies = add_modes(case, "data.h5", 4, first["medium"])
    for expected, frequency in zip(first["frequencies_hz"], frequencies):
        check(abs(expected / frequency - 1) < 0.2, f"expected modes have {expected} Hz, not {frequency} Hz")
    code, found = diagnose(case, "data.h5", "after", OPTIONS)
    check(code == NAMED and found["verdict"]["set"] == ["force_gain"], found["verdict"]["sentence"])
    reached = {one["effect"]: one["separation_now_sd"] for one in found["rivals"]}["elasticity"]
    print(f"    promised {first['from_members_sd'][0]:.2f} sd, found {reached:.2f} sd")


def test_no_mass(case):
    """A wing whose mass is not known: the table says why it has no modes."""
    measure(case, "data.h5", **BENDING)


if __name__ == "__main__":
    main(globals())
