#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate that hovers in a plane flow, on coarse grids, against the finest of docs/results/hovering.md; the added mass of a plate.

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


def test_added_mass(case):
    """The first step of a plate from rest: its added mass is that of a plate that is wider by a number of cells that does not depend on
    the grid, so that the widths on two grids extrapolate to the exact one. The rest is of second order: (1.3/12)^2 = 1 %."""
    command = [str(SOURCE / "bench/plates/run_added_mass"), "--program", str(case.program), str(case.folder), "strip-12",
               "strip-24"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"the study runs: {done.stderr}")
    found = json.loads(done.stdout.splitlines()[-1])
    widths = [found[name][0]**0.5 for name in ("strip-12", "strip-24")]
    check(abs(2 * widths[1] - widths[0] - 1) < 0.01, f"the width without a grid is that of the plate: {widths}")
    check(1.15 < widths[0] < 1.25, f"on 12 points the plate is about 1.3 cells wider on each side: {widths}")


if __name__ == "__main__":
    main(globals())
