#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The measurement that msm_diagnose recommends separates the first cause from its imitator by as much as was promised: the
load is applied in mechanics of its own, and the diagnosis made once more.

usage: diagnosis_next_measurement.py <msm_diagnose> <h5dump> [tests]

Errors are declared and not made, so that the separation, which is a sum of squares, has no chance in it, and effect and
errors are ten times smaller than usual: the prediction is linear. It leaves out the error of the unloaded scan that new and
old loads share, which is nothing with a thousand scans, and it is made of tangents at a baseline that lacks the cause: the
fits with and without the new load differ by some 2 % of their stiffness, and so may tangents. 5 % are allowed.
"""
import csv
import shutil

from synthetic_bending import append_loads, diagnose, measure
from whole_program import check, main

OPTIONS = """observations = 20000;
noise = declared;
starts = 1;
draws = 500;
intervals = no;
validation = no;
"""
TEST = {"stiffness": {"plate": "edges", "E_gradient": -0.04}, "protocol": {"levels": [1, -1], "random_order": True},
        "noise": {"height": 1e-9, "reference_scans": 1000},
        "declared": {"height": 1e-6}}
ALLOWED = 0.05


def ranking(case, name):
    with open(case.folder / f"{name}_next_measurements.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row["now"], row["then"] = (float(row[f"separation {when} [sd]"]) for when in ("now", "after it"))
    return rows


def test_promise(case):
    """A load at the best new place, and the best one that is there once more."""
    measure(case, "data.h5", **TEST)
    diagnose(case, "data.h5", "before", OPTIONS)
    rows = ranking(case, "before")
    new = [row for row in rows if row["measurement"] == "new load"]
    repeats = [row for row in rows if row["kind"] == "bending" and row not in new]
    check(rows[0]["then"] == max(row["then"] for row in rows), "the best one comes first")
    for title, best in ("place", new[0]), ("repeat", repeats[0]):
        load = [float(best[key]) for key in ("x [m]", "y [m]", "force [N]")]
        measure(case, "further.h5", **{**TEST, "protocol": {"levels": [1.0]}}, seed=77, loads=[load])
        shutil.copy(case.folder / "data.h5", case.folder / f"{title}.h5")
        append_loads(case, f"{title}.h5", "further.h5")
        diagnose(case, f"{title}.h5", f"with_{title}", OPTIONS)
        found = ranking(case, f"with_{title}")[0]["now"]
        print(f"    {title}: {best['now']:.3f} sd now, {best['then']:.3f} promised, {found:.3f} found")
        check(best["then"] > 1.05 * best["now"], f"{title}: it is worth while")
        check(abs(found / best["then"] - 1) < ALLOWED, f"{title}: the separation is as promised")


main(globals())
