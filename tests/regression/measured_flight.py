#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_diagnose compares measured forces on a hovering wing with a plane flow (bench/flights/diagnose). The catalogue has no cause for
the difference, so that the program must name none.

usage: measured_flight.py <msm_diagnose>     exit code 77 where the measured curves are not

They are looked for in the folder that FLUSI_FLAPPING names, or in ../shared/data/flapping2d_re75 beside the repository.
"""
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).resolve().parents[2]
SKIPPED = 77


def check(condition, sentence):
    print("ok  " if condition else "FAIL", sentence)
    if not condition:
        sys.exit(1)


def main(program):
    measured = Path(os.environ.get("FLUSI_FLAPPING", SOURCE.parent / "shared/data/flapping2d_re75"))
    if not (measured / "CL_measured.dat").is_file():
        print(f"skipped: no curves in {measured}")
        sys.exit(SKIPPED)
    subprocess.run([SOURCE / "bench/flights/diagnose", "--program", program, measured, "."], check=True)
    found = json.loads(Path("diagnosis.json").read_text())
    verdict = found["verdict"]
    check(verdict["word"] == "unknown_cause" and not verdict["set"] and verdict["grade"] == "",
          f"what is wrong has no name: {verdict['sentence']}")
    check(verdict["global_p"] < 1e-10, f"but something is wrong, p = {verdict['global_p']}")
    record, = [entry for entry in found["data"] if entry["kind"] == "flight"]
    for one in record["sets"]:
        simulated, shown = (np.sqrt(np.mean(np.array(one[name])**2)) for name in ("simulated", "measured"))
        check(1.5 < simulated / shown < 2.1, f"{one['component']} is {simulated / shown:.2f} times that measured")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
