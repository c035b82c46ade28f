#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Causes that the blind cases do not hide, as they need other data or other mechanics: msm_diagnose finds each of them in
data of tools/make_measurement, with an interval that is where the truth is. And the shipped case, as its head says.

usage: diagnosis_entries.py <msm_diagnose> <h5dump> [tests]

Intervals are of 90 %: their half width is 1.645 sd, and the truth is asked to be within 3.3 sd, which it is but once in a
thousand times; seeds are given.
"""
import json
import shutil
import subprocess
import sys

from synthetic_bending import NAMED, SET, append_loads, diagnose, measure
from whole_program import MOST_LINES, SOURCE, check, main

OPTIONS = "observations = 600;\n"
QUICK = OPTIONS + "starts = 1;\ndraws = 1000;\n"
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
    code, found = diagnose(case, "data.h5", "creep", QUICK)
    is_named(code, found, "creep")
    holds(found, "creep", 0.01)


def test_root(case):
    """A fifth of the stiffness where the veins are clamped: not the compliance of the clamp, nor damage beside it. Two heights
    in a hundred have errors of Student's t with a scale of 0.3 mm, thirty times that of the others: as normal ones they would
    hide everything. Nearly all of them stand out."""
    measure(case, "data.h5", stiffness={**STIFFNESS, "root": 0.2}, noise={"outliers": 0.02, "outlier_scale": 3.0e-4})
    code, found = diagnose(case, "data.h5", "root", OPTIONS)
    is_named(code, found, "root_stiffness")
    holds(found, "root", 0.2)
    tails = found["noise"]["heavy_tails"]
    print(f"    {tails['heights_left_out']} of {tails['heights_tested']} heights stand out")
    check(tails["is_found"] and tails["share_90"][0] < 0.02 < 1.5 * tails["share_90"][1], "two in a hundred stand out")
    check(found["noise"]["variance_ratio"] < 1.5, "what stays is as exact as its neighbours say")


def test_camber(case):
    """A wing with an arch, a bow and a twist of 10 um, in which the plate is Morley's and knows what is curved."""
    measure(case, "data.h5", stiffness={**STIFFNESS, "plate": "morley", "camber": [1.0e-5, 1.0e-5, 1.0e-5]})
    code, found = diagnose(case, "data.h5", "camber", OPTIONS)
    is_named(code, found, "camber")


def test_gravity(case):
    """A membrane of 0.1 kg/m^2 sags. What has sagged is not flat: camber does much the same, and both are the answer."""
    measure(case, "data.h5", stiffness=STIFFNESS, hidden={"gravity": [0, 0, -9.81], "areal_density": 0.1})
    code, found = diagnose(case, "data.h5", "gravity", QUICK + "validation = no;\n", "[Mass]\nmembrane_law = uniform;\nareal_density = 0.1;\n")
    check(code == SET and set(found["verdict"]["set"]) == {"gravity", "camber"} or code == NAMED and
          found["verdict"]["set"] == ["gravity"], found["verdict"]["sentence"])
    if found["verdict"]["set"][0] == "gravity":
        holds(found, "gravity_z", -9.81)


def test_shipped(case):
    """What the head of ini/diagnose.ini says to do: the gradient that ini/diagnose.json hides is in a set with the cross-sections
    of veins, which do almost the same, or named, and there is a report."""
    for path in ("ini/diagnose.ini", "ini/diagnose.json", "wings/calliphora_small.h5"):
        (case.folder / path).parent.mkdir(exist_ok=True)
        shutil.copy(SOURCE / path, case.folder / path)
    tool(case, "make_measurement", "ini/diagnose.json", "-o", "ini/bending.h5")
    done = case.flusi("ini/diagnose.ini", "--exit-code", timeout=300)
    verdict = json.loads((case.folder / "diagnosis.json").read_text())["verdict"]
    check(done.code in (NAMED, SET) and verdict["set"] in (["E_gradient"], ["E_gradient", "taper"]), verdict["sentence"])
    check(len((done.out + done.err).splitlines()) <= MOST_LINES, f"at most {MOST_LINES} lines on the terminal")
    tool(case, "plot_diagnosis", "diagnosis.json")
    report = (case.folder / "diagnosis_report.html").read_text()
    check("stiffness that changes along the span" in report and "src=\"data:image/png;base64" in report and
          "What to measure next" in report, "the report has words, pictures and what to measure next")


def tool(case, name, *arguments):
    subprocess.run([sys.executable, "-B", SOURCE / "tools" / name, *arguments], cwd=case.folder, check=True,
                   stdout=subprocess.DEVNULL)


main(globals())
