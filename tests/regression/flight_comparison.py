#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a cause of bending tests changes in flight: msm_diagnose flies a small case with both wings, and along a direction of what the
fit leaves. The grid is far too coarse for physics.

usage: flight_comparison.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from flight_case import FLIGHT
from synthetic_bending import NAMED, SET, WING, measure
from whole_program import SOURCE, check, ini_text, main, merged, series

from json_schema import validate

DT = 0.02  # of a beat
N_PHASES = 200
CASE = merged(FLIGHT, {"Resolution": {"nx": 24, "ny": 24, "nz": 12}, "Time": {"nt": 100000, "dt_fixed": DT, "Tmax": 1.0},
                       "Penalization": {"eps": 1.2 * DT}, "Insects": {"RightWing": "no"}, "Saving": {"tintegral": 1 / N_PHASES, "tsave": 100.0}})
FEW = {"loads": [[0.00541, 0.00005, 6.0e-4], [0.00856, -0.00078, 1.0e-4]], "spacing": 8e-4, "protocol": {"levels": [1]}}
INPUT = """[Wing]
file = {wing}
[Measurement]
file = data.h5
[Flight]
file = wing.ini
beats = 1
compare = yes
directions = 1
{more}[Next]
modes = 0
[Diagnose]
parameters = E
refine = no
noise = declared
draws = 500
starts = 1
refits = 1
observations = 100
validation = no
intervals = no
[Saving]
name = bent
"""


def means_of(folder):
    """Mean lift, drag [N] and power [W] over the first beat of a run, by its records at the phases of a diagnosis."""
    units = CASE["units"]
    force = units["density"] * units["length"]**4 * units["frequency"]**2
    rows = np.array(series(folder / "forces.t").rows)
    phases = np.arange(N_PHASES) / N_PHASES

    def mean(column):
        # Before the first record the line through the first two goes on, as in the diagnosis.
        slope = (column[1] - column[0]) / (rows[1, 0] - rows[0, 0])
        return np.mean(np.where(phases < rows[0, 0], column[0] + slope * (phases - rows[0, 0]), np.interp(phases, rows[:, 0], column)))
    return [force * mean(rows[:, 3] + rows[:, 6]), force * mean(rows[:, 1] + rows[:, 4]),
            force * units["length"] * units["frequency"] * mean(rows[:, 13])]


def test_wings(case):
    """Both wings and one direction: flights as flusi makes them with the files of the wings; nothing is flown twice, and with the same
    flights the result is the same to the bit on two ranks. The cost is printed before."""
    measure(case, "data.h5", stiffness={"E_gradient": -1.2}, **FEW)
    case.write("wing.ini", ini_text(CASE))
    case.write("bent.ini", INPUT.format(wing=WING, more=""))
    done = case.flusi("bent.ini", "--plan")
    check(done.code == 0 and "with both wings, and up to 2 times for what the fit leaves" in done.out, f"a plan tells what it costs: {done}")
    check(not (case.folder / "flights").exists(), "and flies nothing")
    done = case.flusi("bent.ini", "--exit-code", timeout=600)
    check(done.code in (NAMED, SET), f"a cause is found: {done}")
    check(done.out.count("flight    ") == 4, f"two wings, and one direction to both sides: {done.out}")
    check(done.out.index("flights   after the diagnosis") < done.out.index("flight    "), "the cost is printed before")
    first = (case.folder / "bent.json").read_bytes()
    found = json.loads(first)
    table = found["flights"]
    check(table["is_known"] and table["wings_were_flown"] and table["directions"] == 1, f"{table}")
    check(0 < table["variance_share"] <= 1 and "compared  the flight with the wing of the baseline" in done.out, done.out)
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")
    for which in "baseline", "extended":
        folder = case.folder / which
        folder.mkdir()
        wing = (case.folder / f"bent_{which}.ini").read_text()
        (folder / "run.ini").write_text(f"[include]\nfile = ../wing.ini;\n{wing}")
        subprocess.run([FLUSI, "run.ini"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        wanted = means_of(folder)
        for one, value in zip(table["means"], wanted):
            # Both are means of the same nine digits of the same flight.
            check(abs(one[which] - value) < 1e-12 * abs(value), f"{which}, {one['name']}: {one[which]}, flown {value}")
    for one in table["means"]:
        if one["is_determined"]:
            low, high = one["interval_90"]
            check(low < high, f"the interval of {one['name']}: {one}")
    # By 9 % in these flights.
    power, = (one for one in table["means"] if one["name"] == "power")
    check(power["change"] < -0.05, f"a wing that is softer toward its tip needs less power: {power}")
    done = case.flusi("bent.ini", "--exit-code", ranks=2, timeout=600)
    check("flight    " not in done.out and (case.folder / "bent.json").read_bytes() == first, f"nothing is flown again: {done.out}")


def test_refused(case):
    """Rigid wings, another wing, and no case."""
    measure(case, "data.h5", **FEW)
    case.write("bent.ini", INPUT.format(wing=WING, more=""))
    for changes, message in ((("Insects", "wings", "rigid"), "[Flight] compare: needs a case whose wings bend"),
                             (("Wing", "file", f"{SOURCE}/wings/calliphora.h5"), "the case cannot be simulated with the wing of this diagnosis")):
        section, key, value = changes
        case.write("wing.ini", ini_text(merged(CASE, {section: {key: value}})))
        done = case.flusi("bent.ini", "--check")
        check(done.code == 2 and message in done.err, f"{done}")
    case.write("bent.ini", INPUT.format(wing=WING, more="").replace("file = wing.ini\n", ""))
    done = case.flusi("bent.ini", "--check")
    check(done.code == 2 and "[Flight] file: is missing: compare = yes simulates this flusi case with two wings" in done.err, f"{done}")


if __name__ == "__main__":
    FLUSI = str(Path(sys.argv.pop(3)).resolve())
    main(globals())
