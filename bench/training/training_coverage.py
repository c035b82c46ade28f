#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures how often the 90 % intervals of msm_train contain the truth, over wings that are measured with other mechanics than
its own: those of tools/make_measurement. The last line is JSON.

usage: training_coverage.py BUILD N [FIRST] [--wing FILE] [--folder DIR] [--scans N] [--set SECTION.KEY=VALUE ...]

Wing w has E and joints log-uniform within a factor of ten of the defaults, the ten loads of ini/train.json with forces in
proportion to E, and white errors of 10 um in every height; the unloaded wing is scanned --scans times. Its random numbers depend
on w alone. The results for wing w are kept in DIR/w/wing.json, so that an interrupted run continues where it was; other options
need another DIR.
"""
import argparse
import json
import math
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[variable] = "1"
sys.dont_write_bytecode = True
import h5py
import numpy as np
from training_program import write_input

from flusi_msm.bending.statics import NoEquilibrium
from flusi_msm.measurement.case import read_case
from flusi_msm.measurement.file import write_test
from flusi_msm.measurement.synthesis import Bench, joint_truth, synthesise

SOURCE = Path(__file__).resolve().parents[2]
SEED = 20261122
DESCRIPTION = SOURCE / "ini/train.json"
# The program has its usual settings, in a box that holds every truth. (With fewer candidates, such as CMAES.max_evaluations=11,
# its least squares start from one point only, and it cannot see that another minimum is lower.)
SECTIONS = {"Train": {"parameters": "E 1e8 1e12, joint:* 1e-8 1e-2"}, "Saving": {"progress_interval": 1e6}}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("wings", type=int)
    parser.add_argument("first", type=int, nargs="?", default=1)
    parser.add_argument("--wing", type=Path, default=SOURCE / "wings/calliphora_small.h5")
    parser.add_argument("--folder", type=Path, default=Path("runs/coverage"))
    parser.add_argument("--scans", type=int, default=100, help="of the unloaded wing, whose errors all loads share")
    parser.add_argument("--set", dest="changes", action="append", default=[])
    options = parser.parse_args()
    results = []
    for w in range(options.first, options.first + options.wings):
        folder = options.folder / f"{w:04d}"
        folder.mkdir(parents=True, exist_ok=True)
        done = folder / "wing.json"
        if not done.exists():
            result = cover_wing(options, w, folder)
            new = folder / "wing.json.part"
            new.write_text(json.dumps(result, indent=1) + "\n")
            new.replace(done)
            for name in ("measurement.h5", "train_backup0.h5", "train_backup1.h5"):
                (folder / name).unlink(missing_ok=True)
        results.append(json.loads(done.read_text()))
        tell(w, results)
    print(json.dumps(summary(options, results)))


def cover_wing(options, w, folder):
    """Returns the result of msm_train for wing w, and the truth."""
    begun = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    truth, redrawn = measure(options, w, folder)
    made = resource.getrusage(resource.RUSAGE_SELF).ru_utime - begun
    sections = {"Wing": {"file": options.wing.resolve()}, "Measurement": {"file": "measurement.h5"},
                **{name: dict(keys) for name, keys in SECTIONS.items()}}
    sections["Train"]["seed"] = w
    write_input(folder, sections, options.changes)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([options.build.resolve() / "bin/msm_train", "train.ini", "--overwrite"], cwd=folder,
                          stdout=subprocess.PIPE, text=True)
    fitted = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    result = {"wing": w, "truth": truth, "redrawn": redrawn, "make_s": round(made, 1), "fit_s": round(fitted, 1),
              "code": done.returncode, "intervals": {}}
    if done.returncode == 0:
        result.update(read_outcome(folder / "train_history.h5", done.stdout))
        result["chi2_of_truth"] = chi2_of_truth(options, folder, sections, truth)
    return result


def is_above_truth(one):
    """Tells whether the wing with the true values has a lower sum of squares than the end of the training, by more than 3."""
    return one.get("chi2_of_truth") is not None and one["chi2_of_truth"] < one["chi2"] - 3


def chi2_of_truth(options, folder, sections, truth):
    """Returns the sum of squares of the wing with the true values, loads solved from the unloaded wing, as --evaluate prints it, or None."""
    joints = ", ".join(f"{name} {value!r}" for name, value in truth.items() if name != "E")
    write_input(folder, sections, [*options.changes, f"Wing.E={truth['E']!r}", f"Wing.parameters={joints}"], "truth.ini")
    done = subprocess.run([options.build.resolve() / "bin/msm_train", "truth.ini", "--evaluate"], cwd=folder, stdout=subprocess.PIPE,
                          text=True)
    table = done.stdout.partition("chi^2/points")[2].splitlines()[1:]
    rows = [re.fullmatch(r"\S+ +\S+ +(\d+) +\S+ +\S+ +(\S+) +\d+ +\d+.*", line) for line in table if line.startswith("P")]
    if not rows or not all(rows):
        return None  # a shape was not found
    return sum(int(points) * float(chi2) for points, chi2 in (row.groups() for row in rows))


def measure(options, w, folder):
    """Makes measurement.h5. Returns the truth by the names of the parameters, and how many truths were drawn before that had a
    load without a shape, or with a shape that is reached by a snap."""
    rng = np.random.default_rng([SEED, w])
    case = read_case(DESCRIPTION, [f"wing={json.dumps(str(options.wing.resolve()))}",
                                   f"noise.reference_scans={options.scans}"], drop=("stiffness",))
    case.stiffness.plate = "edges"
    joints = {name: one["stiffness"] for name, one in joint_truth(Bench(case)).items()}
    loads, young = case.loads, case.stiffness.E
    designed = json.loads(DESCRIPTION.read_text())["stiffness"]["E"]
    redrawn = 0
    while True:
        case.stiffness.E = young * 10 ** rng.uniform(-1, 1)
        case.stiffness.joints = {name: value * 10 ** rng.uniform(-1, 1) for name, value in joints.items()}
        case.loads = [(point, vector * (case.stiffness.E / designed)) for point, vector in loads]
        case.seed = int(rng.integers(2**31))
        try:
            content, told = synthesise(case)
        except NoEquilibrium:
            redrawn += 1
            continue
        if all(load["snaps"] == 0 and load["moved"] > 0 for load in told["loads"]):
            break
        redrawn += 1
    write_test(folder / "measurement.h5", content)
    return {"E": case.stiffness.E, **{f"joint:{name}": value for name, value in case.stiffness.joints.items()}}, redrawn


def read_outcome(path, text):
    """Returns the intervals by the names of the parameters, and how the fit went."""
    found = {}
    with h5py.File(path) as file:
        names = bytes(file.attrs["unknowns"]).decode().split()
        outcome = file["outcome"]
        for name, (lower, best, upper, *has) in zip(names, outcome["intervals"][:].tolist()):
            profile = file["profiles"].get(name)
            facts = {} if profile is None else profile.attrs
            found[name] = {"lower": lower, "best": best, "upper": upper, "ends": int(sum(has)),
                           "is_complete": bool(np.ravel(facts["is_complete"])[0]) if "is_complete" in facts else False,
                           "is_jump": bool(np.any(facts.get("is_jump", 0))),
                           "left_out": bytes(facts["left_out"]).decode() if "left_out" in facts else ""}
        numbers = {key: float(np.ravel(outcome.attrs[key])[0]) for key in ("chi2", "h", "residuals", "cold_difference")}
    return {**numbers, "fits": "does not fit within the declared errors" not in text,
            "evaluations": int(re.search(r"\nevaluations (\d+) in all", text).group(1)), "intervals": found}


def tally(results):
    """Counts rows (truth in the interval?, number of ends, does the fit meet the errors?, does a load jump?), and intervals
    that were given up."""
    rows, incomplete = [], 0
    for one in results:
        for name, interval in one["intervals"].items():
            if not interval["is_complete"]:
                incomplete += 1
                continue
            rows.append((interval["lower"] <= one["truth"][name] <= interval["upper"], interval["ends"], one["fits"],
                         interval["is_jump"] or interval["left_out"] != ""))
    return rows, incomplete


def tell(w, results):
    """Prints the progress, and which intervals of this wing miss the truth."""
    rows, _ = tally(results)
    one = results[-1]
    print(f"wing {w}: so far {sum(r[0] for r in rows if r[1] == 2)} of {sum(r[1] == 2 for r in rows)} intervals with both "
          f"ends hold the truth, {sum(r[0] for r in rows)} of {len(rows)} in all; made in {one['make_s']} s, fitted in "
          f"{one['fit_s']} s" + ("" if one["code"] == 0 else f", exit code {one['code']}"), flush=True)
    if is_above_truth(one):
        print(f"  the truth has a lower sum of squares: {one['chi2_of_truth']:.7g} instead of {one['chi2']:.7g}")
    if one["code"] == 0 and not one["fits"]:
        print(f"  does not fit: chi^2 = {one['chi2']:.5g} of {one['residuals']:.0f}")
    for name, i in one["intervals"].items():
        if i["is_complete"] and not i["lower"] <= one["truth"][name] <= i["upper"]:
            print(f"  {name:24} truth {one['truth'][name]:.4e} outside {i['lower']:.4e} to {i['upper']:.4e}"
                  + (f", without {i['left_out']}" if i["left_out"] else "") + (", ends at a jump" if i["is_jump"] else ""))


def summary(options, results):
    rows, incomplete = tally(results)
    two = [r[0] for r in rows if r[1] == 2]
    fitting = [r[0] for r in rows if r[2] and r[1] == 2]
    return {"wings": options.wings, "first": options.first, "intervals": len(two), "covered": sum(two),
            "one_end": sum(r[1] == 1 for r in rows), "one_end_covered": sum(r[0] for r in rows if r[1] == 1),
            "no_end": sum(r[1] == 0 for r in rows), "no_end_covered": sum(r[0] for r in rows if r[1] == 0),
            "coverage": round(sum(two) / max(1, len(two)), 4), "binomial_sd": round(math.sqrt(0.09 / max(1, len(two))), 4),
            "all": len(rows), "all_covered": sum(r[0] for r in rows), "incomplete": incomplete,
            "failed": sum(one["code"] != 0 for one in results),
            "not_fitting": sum(one["code"] == 0 and not one["fits"] for one in results),
            "coverage_where_it_fits": round(sum(fitting) / max(1, len(fitting)), 4),
            "truth_below_by_3": sum(is_above_truth(one) for one in results),
            "truth_unknown": sum(one.get("chi2_of_truth") is None for one in results if one["code"] == 0),
            "fit_s": round(sum(one["fit_s"] for one in results), 1),
            "missed_at_a_jump": sum(not r[0] and r[3] for r in rows), "redrawn": sum(one["redrawn"] for one in results),
            "cpu_s": round(sum(one["make_s"] + one["fit_s"] for one in results), 1)}


main()
