# SPDX-License-Identifier: GPL-3.0-or-later
"""Trainings on the replicate of a small wing, for the tests of msm_train; the path of write_replicate is their third argument."""
import re
import subprocess
import sys

from whole_program import SOURCE, check, merged

TWIN = sys.argv.pop(3)
WING = SOURCE / "wings/calliphora_small.h5"
TRUTH = {"E": 8e9, "joint:R4+5_base": 3e-5, "joint:R1_Rs": 2e-4}
OTHERS = 1e-4  # stiffness of the joints that are not sought
JOINTS = ("A1+CuA2_CuA2", "C_Sc", "C_h", "CuA1_base", "M1+2_bend", "M1+2_bm-cu", "R1_Rs", "R2+3_base", "R4+5_base",
          "R4+5_r-m")
SIGMA = 1e-7  # m, declared


def replicate(case, name="replicate.h5", **truth):
    """Three loads on the wing with the true parameters."""
    pairs = {**{f"joint:{joint}": OTHERS for joint in JOINTS}, **TRUTH, **truth, "force": 0.3}
    words = [str(word) for pair in pairs.items() for word in pair]
    subprocess.run([TWIN, WING, case.folder / name, "3", str(SIGMA), "30", "15", *words], check=True)


def training(**sections):
    """Three parameters; `sections` add keys or replace them."""
    return merged({"Wing": {"file": WING, "joint_stiffness": OTHERS}, "Measurement": {"file": "replicate.h5"},
                   "Train": {"parameters": "E 4e9 3e10, joint:R4+5_base 1e-5 1e-3, joint:R1_Rs 1e-5 1e-3"},
                   "CMAES": {"max_generations": 6}, "Saving": {"progress_interval": 0}}, sections)


def quick(**sections):
    """A search without a polish."""
    return training(**merged({"Polish": {"polish": "no"}}, sections))


def number(pattern, text):
    found = re.search(pattern, text)
    check(found is not None, f"'{pattern}' is told:\n{text}")
    return float(found.group(1))


def same_outcome(one, two):
    """The same history and the same wing, to the bit."""
    a, b = one.contents("train_history.h5"), two.contents("train_history.h5")
    check(a.keys() == b.keys() and len(a) > 10, f"the histories hold the same things: {sorted(a)}")
    for key in a:
        check(a[key] == b[key], f"{key} is the same to the bit")
    check(without_comments(one) == without_comments(two), "the wing is the same to the bit")


def without_comments(case):
    return [line for line in (case.folder / "trained.ini").read_text().splitlines() if not line.startswith(";")]
