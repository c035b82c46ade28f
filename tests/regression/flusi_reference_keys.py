#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""FLUSI's two published cases, from input in FLUSI's syntax: number of steps and keys of the fields; its insects, as drawn.

usage: flusi_reference_keys.py <flusi> <h5dump>
"""
import shutil

from whole_program import SOURCE, check, main, merged

# The reference fields are single precision (6e-8) and carry round-off of 600 to 2000 steps.
RELATIVE = 1e-6
# A mean that vanishes is round-off: below the single precision of numbers of the size of the field's maximum.
VANISHING = 1e-7
# Four cells at root and tip, where the two ellipses of a wing meet, are 6.4e-6 of the mask of `jerry`.
MASKS = {"insects_mask_jerry": 1e-5, "insects_mask_drosophila": RELATIVE}

INSECT = {
    "Time": {"Tmax": 0}, "ReynoldsNumber": {"nu": 1e-2}, "InitialCondition": {"inicond": "quiescent"},
    "Penalization": {"iPenalization": 1, "iMoving": 1, "iMask": "Insect", "eps": 1e-3},
    "Insects": {"BodyMotion": "tethered", "FlappingMotion_right": "Drosophila_hovering_fry"},
    "Saving": {"tsave": 1, "iSaveMask": 1, "iSaveSolidVelocity": 1, "field_precision": "single", "iDoBackup": 0},
    "DryRun": {"dry_run_without_fluid": "yes"},
}
INSECTS = {
    "insects_mask_jerry": merged(INSECT, {
        "Resolution": {"nx": 128, "ny": 64, "nz": 86}, "Geometry": {"xl": 3.0, "yl": 1.5, "zl": 2.0},
        "Insects": {"BodyType": "jerry", "WingShape": "TwoEllipses", "FlappingMotion_left": "flapper_dickinson", "b_top": 0.1,
                    "b_bot": 0.3, "L_span": 1.0, "L_body": 1.0, "b_body": 0.1, "R_head": 0.125, "R_eye": 0.0625,
                    "x0": "1.5 0.75 1.0", "eta0": 0.0, "yawpitchroll_0": "0.0 0.0 0.0", "WingThickness": 0.09375,
                    "x_pivot_l": "0.05 0.2165 0.0", "x_pivot_r": "0.05 -0.2165 0.0"}}),
    "insects_mask_drosophila": merged(INSECT, {
        "Resolution": {"nx": 128, "ny": 128, "nz": 128}, "Geometry": {"xl": 4.0, "yl": 4.0, "zl": 4.0},
        "Insects": {"BodyType": "drosophila_maeda", "WingShape": "drosophila", "FlappingMotion_left": "Drosophila_hovering_fry",
                    "x0": "2.0 2.0 2.0", "eta0": 90.0, "yawpitchroll_0": "90.0 60.0 0.0", "WingThickness": 0.125,
                    "x_pivot_l": "0.0 0.2 0.0", "x_pivot_r": "0.0 -0.2 0.0"}}),
}


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


def keys_of(case, field, label):
    """Time and keys of a field. FLUSI's label is the time asked for; the save is the first step at or after it."""
    file = min(f for f in case.files() if f.startswith(f"{field}_") and f >= f"{field}_{label}.h5")
    keys = [float(w) for w in case.run("--keyvalues", file, ranks=0).out.split()]
    return keys[0], keys[1:5]


def check_keys(name, keys, reference, relative=RELATIVE):
    """Holds max, min, mean and mean square to a reference in single precision."""
    largest = max(abs(reference[0]), abs(reference[1]))
    for what, got, want in zip(("max", "min", "mean", "mean square"), keys, reference):
        allowed = relative * abs(want)
        if what == "mean" and abs(want) < VANISHING * largest:
            allowed = VANISHING * largest
        check(abs(got - want) <= allowed, f"{what} of {name} is {want} within {allowed}, not {got}")


def run_case(case, name, source, steps):
    shutil.copy(SOURCE / f"ini/flusi/{name}.ini", case.folder)
    case.run(f"{name}.ini", ranks=2)
    rows = case.series("timesteps_info.t").rows
    check(len(rows) == steps, f"{name} takes {steps} steps, not {len(rows)}")
    check(rows[-1][2] == steps, f"the last step is called {steps}")
    compared = 0
    for field, label, reference in mirrored(references(source)):
        if field == "p":
            continue
        case_time, keys = keys_of(case, field, label)
        check(0 <= case_time - float(label) / 1000 < 1.5e-3, f"{field}_{label} is the first save after its time")
        check_keys(f"{field}_{label}", keys, reference)
        compared += 1
    check(compared == 12, f"all fields were compared, {compared}")
    case.check_index(f"{name}.xmf")


def check_pressure(case, source, own, outside):
    """FLUSI keeps the modes of p that lie outside the truncation. What they add to the mean square is their share of
    the variance, `outside` squared at most; the mean is that of -|u|^2/2 with them and without."""
    compared = 0
    for (field, label, theirs), (_, _, ours) in zip((row for row in references(source) if row[0] == "p"),
                                                    references(own)):
        _, keys = keys_of(case, field, label)
        check_keys(f"{field}_{label}", keys, ours)
        check(abs(keys[2] / theirs[2] - 1) <= RELATIVE, f"mean of p_{label}: {keys[2]}, FLUSI's {theirs[2]}")
        share = (theirs[3] - keys[3]) / (theirs[3] - theirs[2] ** 2)
        check(0 <= share <= outside ** 2, f"FLUSI's p_{label} has {share} of its variance outside the truncation")
        compared += 1
    check(compared == 2, f"p was compared at two times, {compared}")


def test_vortex_ring(case):
    run_case(case, "vortex_ring", "vortex_ring1_AB2", 630)
    # 1.1 % of the exact p is outside (test_exact_pressure).
    check_pressure(case, "vortex_ring1_AB2", "truncated_ring", 0.012)


def test_sphere(case):
    run_case(case, "sphere", "sphere", 2021)
    # p has a bend at the surface, whose modes fall off like 1/k^2 only: 5.6 % are above mode 10 of 16.
    check_pressure(case, "sphere", "truncated_sphere", 0.06)
    rows = case.series("forces.t").rows
    # FLUSI's forces.t, five digits published. The nearest record is less than a step from that time.
    row = min(rows, key=lambda r: abs(r[0] - 1.991))
    check(abs(row[0] - 1.991) < 1e-3, f"there is a record at t = 1.991, the nearest is {row[0]}")
    check(abs(row[1] - 0.32234) <= 1e-4 * 0.32234, f"Fx(t = 1.991) is 0.32234 within 1e-4, not {row[1]}")


def test_insects(case):
    """Body and wings by FLUSI's names, drawn as FLUSI draws them."""
    for source, ini in INSECTS.items():
        run = case.sub(source)
        run.write("run.ini", ini)
        run.run("run.ini", ranks=2)
        rows = list(references(source))
        check(rows, f"{source} has references")
        for field, label, reference in rows:
            check_keys(f"{field}_{label} of {source}", keys_of(run, field, label)[1], reference,
                       MASKS[source] if field == "mask" else RELATIVE)


main(globals())
