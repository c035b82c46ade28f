#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""FLUSI's two published cases, from input in FLUSI's syntax: number of steps and keys of the fields.

usage: flusi_reference_keys.py <flusi> <h5dump>
"""
import shutil

from whole_program import SOURCE, check, main

# The reference fields are single precision (6e-8) and carry round-off of 600 to 2000 steps.
RELATIVE = 1e-6
# A mean that vanishes is round-off: below the single precision of numbers of the size of the field's maximum.
VANISHING = 1e-7


def references(source):
    """Rows (field, label, [max, min, mean, mean square]) of the table."""
    table = (SOURCE / "tests/regression/flusi_reference_keys.txt").read_text().splitlines()
    for line in table:
        words = line.split()
        if words[0] == source:
            yield words[1], words[2], [float(w) for w in words[3:]]


def mirrored(rows):
    """Adds uy and vorz where the table lacks them: (x, y, z) -> (x, z, y) turns uz into uy and vory into
    -vorz."""
    rows = list(rows)
    known = {(field, label) for field, label, _ in rows}
    for field, label, (high, low, mean, square) in list(rows):
        if field == "uz" and ("uy", label) not in known:
            rows.append(("uy", label, [high, low, mean, square]))
        if field == "vory" and ("vorz", label) not in known:
            rows.append(("vorz", label, [-low, -high, -mean, square]))
    return rows


def run_case(case, name, source, steps):
    shutil.copy(SOURCE / f"ini/flusi/{name}.ini", case.folder)
    case.run(f"{name}.ini", ranks=2, timeout=120)
    rows = case.series("timesteps_info.t").rows
    check(len(rows) == steps, f"{name} takes {steps} steps, not {len(rows)}")
    check(rows[-1][2] == steps, f"the last step is called {steps}")
    compared = 0
    for field, label, reference in mirrored(references(source)):
        # FLUSI's label is the time asked for; the save is the first step at or after it.
        file = min(f for f in case.files() if f.startswith(f"{field}_") and f >= f"{field}_{label}.h5")
        keys = [float(w) for w in case.run("--keyvalues", file, ranks=0).out.split()]
        case_time, key = keys[0], keys[1:5]
        check(0 <= case_time - float(label) / 1000 < 1.5e-3, f"{field}_{label} is the first save after its time")
        largest = max(abs(reference[0]), abs(reference[1]))
        for what, got, want in zip(("max", "min", "mean", "mean square"), key, reference):
            allowed = RELATIVE * abs(want)
            if what == "mean" and abs(want) < VANISHING * largest:
                allowed = VANISHING * largest
            check(abs(got - want) <= allowed, f"{what} of {field}_{label} is {want} within {allowed}, not {got}")
            compared += 1
    check(compared == 48, f"all keys were compared, {compared}")
    case.check_index(f"{name}.xmf")


def test_vortex_ring(case):
    run_case(case, "vortex_ring", "vortex_ring1_AB2", 630)


def test_sphere(case):
    run_case(case, "sphere", "sphere", 2021)
    rows = case.series("forces.t").rows
    # FLUSI's forces.t, five digits published. The nearest record is less than a step from that time.
    row = min(rows, key=lambda r: abs(r[0] - 1.991))
    check(abs(row[0] - 1.991) < 1e-3, f"there is a record at t = 1.991, the nearest is {row[0]}")
    check(abs(row[1] - 0.32234) <= 1e-4 * 0.32234, f"Fx(t = 1.991) is 0.32234 within 1e-4, not {row[1]}")


main(globals())
