#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Causes that the blind cases do not hide, as they need other data or other mechanics: msm_diagnose finds each of them in
data of tools/make_measurement, with an interval that is where the truth is.

usage: diagnosis_entries.py <msm_diagnose> <h5dump> [tests]

Intervals are of 90 %: their half width is 1.645 sd, and the truth is asked to be within 3.3 sd, which it is but once in a
thousand times; seeds are given.
"""
from synthetic_bending import NAMED, SET, append_loads, diagnose, measure
from whole_program import check, main

INPUT = """[Wing]
file = {wing};
[Measurement]
file = {file};
[Diagnose]
parameters = E, joint:*;
observations = 600;
refine = no;
[Saving]
name = {name};
"""
STIFFNESS = {"plate": "edges", "E": 9.0e9, "joints": {"C_Sc": 1.0e-6}}


def holds(found, name, truth):
    """The interval of a parameter, made twice as wide, has the truth in it."""
    lower, best, upper = {one["name"]: one["lower_best_upper"] for one in found["extended"]["intervals_90"]}[name]
    print(f"    {name} = {best:.4g} ({lower:.4g} to {upper:.4g}), truth {truth:.4g}")
    check(2 * lower - best <= truth <= 2 * upper - best, f"{name} is as it was made")


def is_named(code, found, effect):
    check(code == NAMED and [cause["effect"] for cause in found["verdict"]["causes"]] == [effect],
          found["verdict"]["sentence"])


def test_creep(case):
    """Scans after 2 s, then as many after 600 s: drift would go on from scan to scan."""
    hidden = {"creep": [0.01, 1.0]}
    measure(case, "data.h5", stiffness=STIFFNESS, hidden=hidden, protocol={"hold": 2.0})
    measure(case, "later.h5", stiffness=STIFFNESS, hidden=hidden, protocol={"hold": 600.0}, seed=6)
    append_loads(case, "data.h5", "later.h5")
    code, found = diagnose(case, "data.h5", "creep", INPUT)
    is_named(code, found, "creep")
    holds(found, "creep", 0.01)


def test_root(case):
    """A fifth of the stiffness where the veins are clamped: not the compliance of the clamp, nor damage beside it."""
    measure(case, "data.h5", stiffness={**STIFFNESS, "root": 0.2})
    code, found = diagnose(case, "data.h5", "root", INPUT)
    is_named(code, found, "root_stiffness")
    holds(found, "root", 0.2)


def test_camber(case):
    """A wing with an arch, a bow and a twist of 10 um, in which the plate is Morley's and knows what is curved."""
    measure(case, "data.h5", stiffness={**STIFFNESS, "plate": "morley", "camber": [1.0e-5, 1.0e-5, 1.0e-5]})
    code, found = diagnose(case, "data.h5", "camber", INPUT)
    is_named(code, found, "camber")


def test_gravity(case):
    """A membrane of 0.1 kg/m^2 sags. What has sagged is not flat: camber does much the same, and both are the answer."""
    measure(case, "data.h5", stiffness=STIFFNESS, hidden={"gravity": [0, 0, -9.81], "areal_density": 0.1})
    code, found = diagnose(case, "data.h5", "gravity", "[Mass]\nmembrane_law = uniform;\nareal_density = 0.1;\n" + INPUT)
    check(code == SET and set(found["verdict"]["set"]) == {"gravity", "camber"} or code == NAMED and
          found["verdict"]["set"] == ["gravity"], found["verdict"]["sentence"])
    if found["verdict"]["set"][0] == "gravity":
        holds(found, "gravity_z", -9.81)


main(globals())
