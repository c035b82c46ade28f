# SPDX-License-Identifier: GPL-3.0-or-later
"""A wing whose stiffness falls along the span, measured under three loads, and the input that diagnoses it."""
import json
import subprocess
import sys

from whole_program import SOURCE

CASE = {
    "wing": str(SOURCE / "wings/calliphora_small.h5"), "seed": 3, "spacing": 3e-4,
    "loads": [[0.00541, 0.00005, 6.0e-4], [0.00721, -0.00032, 1.6e-4], [0.00856, -0.00078, 1.0e-4]],
    "protocol": {"levels": [1, -1], "random_order": True},
    "stiffness": {"plate": "edges", "E": 9.0e9, "joints": {"C_Sc": 1.0e-6}, "E_gradient": -1.2},
    "noise": {"height": 1.0e-5, "tilt": 1.0e-3, "piston": 5.0e-6, "reference_scans": 4},
}
INPUT = """[Wing]
file = {wing};
[Measurement]
file = bending.h5;
[Next]
modes = {modes};
[Diagnose]
parameters = E, joint:C_Sc, joint:R4+5_r-m;
observations = 400;
refine = {refine};
starts = 1;
draws = {draws};
refits = 2;
validation = no;
intervals = {intervals};
"""


def input_text(refine="no", draws=1000, intervals="no", modes=0):
    """Unless told otherwise, no new modes and records are ranked: that takes as long as the rest."""
    return INPUT.format(wing=CASE["wing"], refine=refine, draws=draws, intervals=intervals, modes=modes)


def synthesise(case, *arguments, text=None, **changes):
    """bending.h5 of CASE with `changes`, by make_measurement with `arguments`, and diagnose.ini with `text` or input_text()."""
    (case.folder / "case.json").write_text(json.dumps({**CASE, **changes}))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_measurement", "case.json", "-o", "bending.h5", *arguments],
                   cwd=case.folder, check=True, stdout=subprocess.DEVNULL)
    case.write("diagnose.ini", text or input_text())
