#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wings on which least squares that begin near [Wing] end in a minimum that is not the lowest: moves of single parameters
leave it, or, where the wing snaps, fits without one load. The measurement is made by tools/make_measurement, whose mechanics are not the solver's.

usage: training_minimum.py <msm_train> <h5dump> [tests]
"""
import json
import re
import signal
import time

import h5py
import numpy as np
from whole_program import ALIVE, EXIT_STOPPED, SOURCE, check, main

from flusi_msm.measurement.case import read_case
from flusi_msm.measurement.file import write_test
from flusi_msm.measurement.synthesis import synthesise

WING = SOURCE / "wings/calliphora_small.h5"
YOUNG = 1.4258e9  # Pa
JOINTS = {"A1+CuA2_CuA2": 1.827e-6, "C_h": 2.352e-5, "C_Sc": 2.259e-4, "M1+2_bm-cu": 8.245e-6, "M1+2_bend": 2.126e-7,
          "R1_Rs": 1.8716e-5, "R4+5_r-m": 8.757e-6, "CuA1_base": 1.7345e-5, "R2+3_base": 1.6786e-5, "R4+5_base": 1.7634e-5}  # N m/rad
# A wing that snaps under P03 (number 55 of docs/results/training-results.md).
SNAPPING_YOUNG = 8.790562592502443e9
SNAPPING = {"A1+CuA2_CuA2": 1.6410144164863526e-06, "C_h": 0.0016076634356340447, "C_Sc": 0.00025685828559713524,
            "M1+2_bm-cu": 0.00019646335664836087, "M1+2_bend": 6.58778422800436e-07, "R1_Rs": 0.00044077299680825023,
            "R4+5_r-m": 3.082362491647533e-06, "CuA1_base": 8.521610623698997e-05, "R2+3_base": 2.1840311725768504e-06,
            "R4+5_base": 0.00011764503994300812}
SNAPPING_SEED, SNAPPING_TRUTH = 1756779181, 6484.6  # of the errors; sum of squares with the true values


def measure(path, young=YOUNG, joints=JOINTS, seed=11):
    """Ten loads, errors of 10 um."""
    description = SOURCE / "ini/train.json"
    designed = json.loads(description.read_text())["stiffness"]["E"]
    case = read_case(description, [f"wing={json.dumps(str(WING))}", "noise.reference_scans=100"], drop=("stiffness",))
    case.stiffness.plate = "edges"
    case.stiffness.E = young
    case.stiffness.joints = dict(joints)
    case.loads = [(point, vector * (young / designed)) for point, vector in case.loads]
    case.seed = seed
    content, _ = synthesise(case)
    write_test(path, content)


def write(case, name, moves, progress=1e6, seed=11, **cmaes):
    case.write(f"{name}.ini", {
        "Wing": {"file": WING}, "Measurement": {"file": "measurement.h5"},
        "Train": {"parameters": "E 1e8 1e12, joint:* 1e-8 1e-2", "seed": seed},
        "CMAES": cmaes, "Polish": {"moves": moves, "starts": 1, "intervals": "no"},
        "Saving": {"name": name, "result": f"{name}_trained.ini", "progress_interval": progress}})
    return f"{name}.ini"


def sum_of_squares(text):
    found = re.search(r"chi\^2 = +(\S+) of", text)
    check(found is not None, f"the sum of squares is told:\n{text}")
    return float(found[1])


def wing(case, name):
    return [line for line in (case.folder / f"{name}_trained.ini").read_text().splitlines() if not line.startswith(";")]


def test_loads(case):
    """A load has the wrong one of two shapes at the end of the fits and of all moves of single parameters. Fits without one load
    lead to the lowest minimum."""
    measure(case.folder / "measurement.h5", SNAPPING_YOUNG, SNAPPING, SNAPPING_SEED)
    text = case.run(write(case, "snapping", "yes", seed=55), ranks=2).out
    check("has another shape, because the wing snaps" in text, f"the wing snaps:\n{text}")
    found = re.search(r"moves of single parameters and [1-9]\d* without one load, [1-9]\d* of them to a lower minimum", text)
    check(found is not None and sum_of_squares(text) < SNAPPING_TRUTH, f"and its load is put right:\n{text}")


def test_moves(case):
    """Without moves the training ends 44 above the lowest minimum, within the declared errors. With them the search is short. A stop
    while parameters are moved, and two ranks, change nothing."""
    measure(case.folder / "measurement.h5")
    text = case.run(write(case, "stuck", "no", max_evaluations=11), ranks=0).out
    check("moves of single parameters" not in text, f"moves = no makes none:\n{text}")
    stuck = sum_of_squares(text)
    text = case.run(write(case, "free", "yes"), ranks=0).out
    check("without one load" not in text, f"a wing that does not snap keeps its loads:\n{text}")
    lowest = sum_of_squares(text)
    check("search    ended after 11 evaluations; a candidate has an equilibrium under all loads" in text, f"the search ends with its first generation:\n{text}")
    check(lowest < stuck - 20, f"moves lead lower: {stuck} without them, {lowest} with them\n{text}")
    check("to a lower minimum" in text and "most different is joint:R4+5_base" in text, f"and that is told:\n{text}")
    check_path(case.folder / "free_history.h5", lowest)
    case.run(write(case, "ranks", "yes"), ranks=2)
    check(wing(case, "ranks") == wing(case, "free"), "two ranks find the same wing")
    same_history(case, "ranks", "free")
    stop_in_moves(case, write(case, "stopped", "yes", progress=0))
    done = case.run("stopped.ini", "--restart", ranks=0)
    check("generation" not in done.out, f"the restart does not lengthen the search:\n{done.out}")
    check(re.search(r"^restart   continues after [1-9]\d* moves? of single parameters", done.out, re.M) is not None,
          f"it continues with the moves:\n{done.out}")
    check("polish from start" not in done.out, f"and does not repeat the fit before them:\n{done.out}")
    check(wing(case, "stopped") == wing(case, "free"), "and it ends with the same wing, to the bit")
    same_history(case, "stopped", "free")


def same_history(case, one, other):
    """Both histories hold the same outcome, path and ends, to the bit."""
    with h5py.File(case.folder / f"{one}_history.h5") as a, h5py.File(case.folder / f"{other}_history.h5") as b:
        names = []
        a["outcome"].visit(names.append)
        check({"path", "ends"} <= set(names), f"path and ends are there: {names}")
        for name in names:
            if isinstance(a["outcome"][name], h5py.Dataset):
                check(np.array_equal(a["outcome"][name], b["outcome"][name]), f"{name} of {one} is that of {other}")
        for name, value in a["outcome"].attrs.items():
            check(np.array_equal(value, b["outcome"].attrs[name]), f"{name} of {one} is that of {other}")


def check_path(file, lowest):
    """The path goes on through all moves, and meets the minimum that is told."""
    with h5py.File(file) as f:
        evaluations, chi2, _, stage = np.atleast_2d(f["outcome/path"]).reshape(-1, 4).T
    check(np.all(np.diff(evaluations) >= 0), f"evaluations are counted through: {evaluations}")
    ends = chi2[stage == 1]
    check(np.any(abs(ends - lowest) < 0.01 * lowest), f"the path has a point of chi^2 {lowest}: {ends}")
    check(np.count_nonzero(np.diff(stage) > 0) > 3, f"it holds the fits of all moves: {stage}")


def stop_in_moves(case, ini):
    """SIGTERM once two moves have ended and another one has begun."""
    case.start(ini)
    end = time.monotonic() + ALIVE
    while not re.search(r"^polish from move [3-9]", case.out.read_text(), re.M):
        check(case.process.poll() is None and time.monotonic() < end, f"a move begins:\n{case.out.read_text()}")
        time.sleep(0.01)
    case.process.send_signal(signal.SIGTERM)
    done = case.wait()
    check(done.code == EXIT_STOPPED and "moves of single parameters" not in done.out, f"stopped while parameters are moved: {done}")


main(globals())
