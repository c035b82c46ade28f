#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate that hovers in a plane flow, on coarse grids, against the finest of docs/results/hovering.md.

usage: flusi_hovering.py <flusi> <h5dump> [tests]
"""
import json
import subprocess

from whole_program import SOURCE, check, main

# Means over the beat on 64 points per chord, without thickness.
FINE = {"re100": {"lift": 0.86257, "power": 1.03525, "ratio": 0.8332}, "re1000": {"lift": 1.00768, "power": 1.06366, "ratio": 0.94737}}


def fly(case, name):
    """Errors of a case of bench/hovering, relative to the finest grid."""
    command = [str(SOURCE / "bench/hovering/run"), "--program", str(case.program), str(case.folder), name]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"the study runs {name}: {done.stderr}")
    flow = name.split("-")[0]
    found = json.loads(done.stdout.splitlines()[-1])[flow][name]
    return {key: found[key] / value - 1 for key, value in FINE[flow].items()}


def test_thin(case):
    """What a surface without thickness has of lift and power on grids of a workstation: errors of the page, and a little room."""
    for name, bounds in (("re100-thin-12", {"lift": 0.10, "power": 0.05, "ratio": 0.05}),
                         ("re1000-thin-16", {"lift": 0.10, "power": 0.10, "ratio": 0.10})):
        errors = fly(case, name)
        for key, bound in bounds.items():
            check(abs(errors[key]) < bound, f"{name}: {key} within {bound}: {errors}")


def test_mask(case):
    """A sheet of four cells in the mask needs far more power."""
    errors = fly(case, "re100-mask-12")
    check(errors["power"] > 0.4 and errors["ratio"] < -0.3, f"power and lift over power: {errors}")


if __name__ == "__main__":
    main(globals())
