#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate that hovers in a plane flow, on coarse grids, against the finest of docs/results/hovering.md; the added mass of a plate and
of a disk, and the drag of the disk.

usage: flusi_hovering.py <flusi> <h5dump> [tests]
"""
import json
import math
import subprocess
import sys

from whole_program import SOURCE, check, main

sys.path.insert(0, str(SOURCE / "bench/plates"))
import plates  # noqa: E402

# Means over the beat on 64 points per chord, without thickness.
FINE = {"re100": {"lift": 0.86257, "power": 1.03525, "ratio": 0.8332}, "re1000": {"lift": 1.00768, "power": 1.06366, "ratio": 0.94737}}


def numbers(case, name):
    """What bench/hovering finds for a case."""
    command = [str(SOURCE / "bench/hovering/run"), "--program", str(case.program), str(case.folder), name]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"the study runs {name}: {done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])[name.split("-")[0]][name]


def fly(case, name):
    """Errors of a case of bench/hovering, relative to the finest grid."""
    found = numbers(case, name)
    return {key: found[key] / value - 1 for key, value in FINE[name.split("-")[0]].items()}


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


def test_four_beats(case):
    """The plane idealisation of a measured wing at Re = 75 keeps its lift and drag of four beats (docs/results/hovering.md): means
    to half of their last digit and a per mille, the largest values, which depend on single vortices, to 2 %."""
    found = numbers(case, "re75-thin-16")
    for key, value, bound in (("CL", 0.714, 0.002), ("CD", 1.202, 0.002), ("CL_largest", 2.05, 0.02), ("CD_largest", 2.63, 0.02)):
        check(abs(found[key] / value - 1) < bound, f"{key} is {value}, not {found[key]}")


def start(case, *names):
    """The forces of the first step of surfaces that are accelerated from rest, over those of their exact added mass."""
    command = [str(SOURCE / "bench/plates/run_added_mass"), "--program", str(case.program), str(case.folder), *names]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"the study runs: {done.stderr}")
    found = json.loads(done.stdout.splitlines()[-1])
    return [found[name][0] for name in names]


def test_added_mass(case):
    """The first step of a plate from rest: its added mass is that of a plate that is wider by a number of cells that does not depend on
    the grid, so that the widths on two grids extrapolate to the exact one. The rest is of second order: (1.3/12)^2 = 1 %."""
    widths = [ratio**0.5 for ratio in start(case, "strip-12", "strip-24")]
    check(abs(2 * widths[1] - widths[0] - 1) < 0.01, f"the width without a grid is that of the plate: {widths}")
    check(1.15 < widths[0] < 1.25, f"on 12 points the plate is about 1.3 cells wider on each side: {widths}")


def test_disk_added_mass(case):
    """The same of a disk: its added mass grows with the third power of its diameter. Four and six gaps between markers make up the
    diameter, and a rim of so few markers is no circle: margins of two grids differ by a tenth of a cell at most."""
    margins = [(ratio**(1 / 3) - 1) / 2 * points for ratio, points in zip(start(case, "disk-8", "disk-12"), (8, 12))]
    check(all(1.1 < margin < 1.35 for margin in margins), f"the disk is 1.2 cells larger on every side: {margins}")
    check(abs(margins[0] - margins[1]) < 0.1, f"on both grids: {margins}")


def test_disk_drag(case):
    """A disk normal to a stream at Re = 20 on 12 points has the drag of one that is 0.1 to 0.3 cells larger on every side. The box
    raises its drag by 12 %, as two boxes on 16 points show (docs/results/verification-wings.md)."""
    name, boxes = "disk-20-12-sheet", 1.122
    command = [sys.executable, "-B", str(SOURCE / "bench/plates/plates.py"), str(case.program), str(case.folder), name]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"the study runs: {done.stderr}")
    _, force, before = plates.last_force(case.folder / name / "forces.t")
    margin = plates.margin(20, 12, force[0] / (math.pi / 8) / boxes)
    check(abs(force[0] / before[0] - 1) < 0.003, f"the drag no longer changes: {before[0]}, {force[0]}")
    check(0.1 < margin < 0.3, f"the disk is about 0.2 cells larger on every side: {margin}")
    check(max(map(abs, force[1:])) < 2e-3 * force[0], f"the force is along the stream: {force}")


if __name__ == "__main__":
    main(globals())
