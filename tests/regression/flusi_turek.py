#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""An elastic beam behind a cylinder in a channel, ini/turek-hron.ini: FSI1 of Turek & Hron (2006) on a grid coarser than
those of docs/results/verification-coupling.md, in the mask and without thickness; restart within the start of the inflow, mistakes.

usage: flusi_turek.py <flusi> <h5dump> [tests]
"""
import re

from whole_program import EXIT_USER, SOURCE, check, main, same_runs

NZ = 72  # points over 0.48 m: the beam is three cells thick
SLOW = {"ny": NZ * 256 // 48, "nz": NZ, "eps": (0.33909 * 0.48 / NZ)**2 / 1e-3, "inflow_velocity": 0.2,
        "areal_density": 20.0, "iSaveVorticity": 0}


def changed(keys, is_thin=False):
    """ini/turek-hron.ini with other values, of the beam in the mask or as a surface without thickness."""
    text = (SOURCE / "ini/turek-hron.ini").read_text().replace("../wings/", f"{SOURCE}/wings/")
    if is_thin:
        text, count = re.subn(r"(?m)^WingThickness = .*$", "surface = thin;", text)
        check(count == 1, "the beam has a thickness")
    for key, value in keys.items():
        text, count = re.subn(rf"(?m)^{key} = [^;]*;", f"{key} = {value};", text)
        check(count == 1, f"the file has {key}")
    return text


def test_fsi1(case):
    """Steady flow at Re = 20."""
    case.write("run.ini", changed({**SLOW, "Tmax": 5.0, "tsave": 10.0}))
    case.run("run.ini", ranks=0, timeout=300)
    forces, tip = case.series("forces.t").rows, case.series("bending_left.t").rows
    drag = 1000 * (forces[-1][2] + forces[-1][5])
    # Walls are seen within a sixteenth of a cell (test_inflow_channel): 0.8 % of the diameter. The mask of the beam stands
    # half its thickness, 3 %, over its end. The rest is of second order; this grid has made 2.3 %, the next one 0.8 %.
    check(abs(drag / 14.295 - 1) < 0.04, f"drag of cylinder and beam: {drag} N/m")
    # It bends because the cylinder stands 5 mm off the middle of the channel, less than a cell of this grid: -23 %, on the
    # next one +3 %.
    check(abs(-tip[-1][3] / 0.8209e-3 - 1) < 0.3, f"deflection of the beam: {-tip[-1][3]} m")
    before = [row for row in tip if row[0] < 4.5][-1]
    check(abs(before[3] / tip[-1][3] - 1) < 0.03, f"which rests: {before[3]}, {tip[-1][3]}")
    parts = [case.series(f"forces_part{c}.t").rows[-1] for c in (1, 2)]
    check(abs(sum(part[2] for part in parts) - forces[-1][2]) < 1e-8, "cylinder and beam have the whole force")
    check(min(part[2] for part in parts) > 0.1 * forces[-1][2], f"and both of them drag: {parts}")


THIN = {**SLOW, "ny": NZ * 128 // 48, "yl": 1.28, "CFL": 0.45}  # in a channel of half the length


def test_thin_fsi1(case):
    """The beam as a surface without thickness beside the cylinder and the walls in the mask."""
    case.write("run.ini", changed({**THIN, "Tmax": 5.0, "tsave": 10.0}, True))
    case.run("run.ini", ranks=0, timeout=300)
    forces, tip, slip = (case.series(name).rows for name in ("forces.t", "bending_left.t", "slip.t"))
    drag = 1000 * (forces[-1][2] + forces[-1][5])
    # The beam has no end for the pressure to act on, which is 5 % (docs/results/verification-coupling.md). The mask's errors remain:
    # 0.8 % of the walls and 2 % of the grid, as in the channel of twice the length of test_fsi1.
    check(abs(drag / 14.295 - 0.95) < 0.03, f"drag of cylinder and beam: {drag} N/m")
    # Less than a cell moves the cylinder off the middle. At t = 5 s it is -8 % here; the cases of the page, in the same channel until
    # t = 9 s, have -6 % on this grid and +4 % on the next one.
    check(abs(-tip[-1][3] / 0.8209e-3 - 1) < 0.15, f"the beam bends as published: {-tip[-1][3]} m")
    before = [row for row in tip if row[0] < 4.5][-1]
    check(abs(before[3] / tip[-1][3] - 1) < 0.03, f"and rests: {before[3]}, {tip[-1][3]}")
    parts = [case.series(f"forces_part{c}.t").rows[-1] for c in (1, 2)]
    check(abs(sum(part[2] for part in parts) - forces[-1][2]) < 1e-8, "cylinder and beam have the whole force")
    # Friction pulls along the beam, E A = 33333 N. The end moves by F/(E A) times the mean distance of the friction from the clamp:
    # L/2 if it is even, 3/4 L if it grows from 0 with the square of the distance. Behind the cylinder the
    # flow is slow and becomes faster toward the end: the distance is 0.61 L.
    pulled = tip[-1][1] / (1000 * parts[1][2] * 0.35 / 33333)
    check(0.49 < pulled < 0.75, f"friction stretches the beam: {pulled}")
    check(slip[-1][1] < 0.02 * slip[-1][2], f"the flow rests at the beam: {slip[-1]}")


def test_thin_power(case):
    """A weight across the channel sets the beam in motion: the flow receives the power that the beam loses, but for the slip."""
    text = changed({**THIN, "Tmax": 0.3, "tintegral": 1e-9, "tsave": 10.0}, True)
    case.write("run.ini", text.replace("[Flexible_wing]", "[Flexible_wing]\ngravity = 0.0 0.0 0.4;"))
    case.run("run.ini", ranks=0, timeout=300)
    rows = case.series("slip.t").rows
    check(len(rows) > 50 and case.series("bending_left.t").rows[-1][3] < -1e-3, "the beam moves")
    largest = max(row[7] for row in rows)
    for row in rows[1:]:
        # The forces work at the slip, too: they are about those at the velocity of the beam.
        check(abs(row[4] - row[7]) < 0.01 * largest, f"power to the flow and from the beam at t = {row[0]}: {row[4]}, {row[7]}")
    check(max(row[1] for row in rows) < 0.01 * max(row[3] for row in rows), "the flow follows the beam")


def test_restart(case):
    """The inflow goes on growing where it was."""
    early = {**SLOW, "inflow_start": 0.05, "tintegral": 1e-3, "tsave": 4e-3, "iSaveVorticity": 1}
    whole, parts = case.sub("whole"), case.sub("parts")
    for run, steps in ((whole, 16), (parts, 9)):
        run.write("run.ini", changed(early).replace("[Time]", f"[Time]\nnt = {steps};"))
        run.run("run.ini", ranks=2)
    parts.write("run.ini", changed(early).replace("[Time]", "[Time]\nnt = 16;"))
    parts.run("run.ini", "--restart", ranks=2)
    check(whole.series("meanflow.t").rows[-1][2] > 0, "it flows")
    same_runs(whole, parts)


def test_mistakes(case):
    def refused(text, words):
        case.write("run.ini", text)
        done = case.run("--check", "run.ini", ranks=0, code=EXIT_USER)
        check(done.err.count(words) == 1 and len(done.err.splitlines()) == 1, f"'{words}' and nothing else:\n{done.err}")

    refused(changed({"inflow_length": 0.0}), "the inflow of turek needs a length between 0 and yl")
    refused(changed({"thick_wall": 0.5}), "it must be thinner than zl")
    refused(changed({"iMask": "cylinder", "wings": "rigid"}), "turek has its own cylinder; valid with it: none, empty, Insect")
    refused(changed({}) + "[MeanFlow]\niMeanFlow_y = fixed;\n", "the inflow of turek prescribes the mean flow")


if __name__ == "__main__":
    main(globals())
