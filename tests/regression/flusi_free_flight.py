#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole runs of insects that fly freely or move as prescribed: restart to the bit, ranks, repetition from a table, mistakes.

usage: flusi_free_flight.py <flusi> <h5dump> [tests]

The grids are far too coarse for physics; what is tested is that parts fit together.
"""
import math
import re

from flusi_flexible import FLIGHT
from flusi_wing import BEAT, WING, make, restarted, same_on_ranks, steps
from whole_program import EXIT_USER, SOURCE, check, close, main, merged, same_runs

FREE = merged(WING, {
    "Insects": {"BodyMotion": "free_flight", "mass": 20.0, "gravity": -0.05, "J_body_yawpitchroll": "4.0 4.0 3.0",
                "wing_mass": 0.2, "v0": "-0.1 0.0 0.05"},
    "MeanFlow": {"iMeanFlow_x": "free", "iMeanFlow_y": "free", "iMeanFlow_z": "free", "ux": 0.0},
    "Saving": {"tsave": 9, "tintegral": 1e-9},
})
SPHERE = {
    "Resolution": {"nx": 24, "ny": 24, "nz": 24},
    "Geometry": {"xl": 3.0, "yl": 3.0, "zl": 3.0},
    "Time": {"nt": 16, "CFL": 0.5},
    "ReynoldsNumber": {"nu": 2e-3},
    "InitialCondition": {"inicond": "quiescent"},
    "Penalization": {"iPenalization": "yes", "iMask": "Insect", "eps": 5e-3},
    "Insects": {"BodyMotion": "free_flight", "BodyType": "sphere", "L_body": 1.0, "LeftWing": "no", "RightWing": "no",
                "mass": 1.34, "gravity": -1.0 / 1.34, "J_body_yawpitchroll": "0.134 0.134 0.134", "x0": "1.5 1.5 1.5"},
    "MeanFlow": {"iMeanFlow": 1, "ux": 0.0, "uy": 0.0, "uz": 0.0},
    "Saving": {"tsave": 0.02, "tintegral": 1e-9, "iSaveVelocity": "yes"},
}
EXAMPLE = (1.98340912, 1.97500181, 2.49945266, -4.22964940e-2, 1.51016555e-5, -3.17224540e-3)
THIN = {"Insects": {"surface": "thin", "slip_interval": 1}, "Time": {"CFL": 0.4}}


def test_restart(case):
    """Thick rigid wings on a free body."""
    whole, parts = restarted(case, FREE, ranks=1)
    parts.write("run.ini", merged(FREE, {"Insects": {"mass": 21.0}, "Time": {"nt": 20}}))
    done = parts.run("run.ini", "--restart", code=EXIT_USER)
    check("another mass" in done.err, f"momenta belong to a mass: {done.err}")
    check("rigidsolidsolver.t" in whole.all_series(), "the states are in a file")
    check(len(whole.series("rigidsolidsolver.t").rows[0]) == 14, "with FLUSI's columns")
    check(len(whole.series("rigidsolidsolver.t").rows) == 17, "in every step, and at the end")


def test_restart_thin(case):
    restarted(case, merged(FREE, THIN), ranks=2)


def test_ranks(case):
    one = same_on_ranks(case, FREE, 3, "rigidsolidsolver.t", "free_flight.t")
    first, last = one.series("rigidsolidsolver.t").rows[0], one.series("rigidsolidsolver.t").rows[-1]
    check(max(abs(a - b) for a, b in zip(first[4:7], last[4:7])) > 1e-4, f"the insect gets faster: {first} {last}")
    same_on_ranks(case.sub("thin"), merged(FREE, THIN), 2, "rigidsolidsolver.t", "free_flight.t")


def test_flexible(case):
    """Flexible wings without thickness hang on the free body: restart to the bit; their weight is that of [Insects]."""
    ini = merged(FLIGHT, {
        "Insects": {"surface": "thin", "slip_interval": 1, "BodyMotion": "free_flight", "mass": 50.0, "gravity": -0.05,
                    "J_body_yawpitchroll": "4.0 4.0 3.0"},
        "Time": {"nt": 10}, "Wing": {"E": 2e9}, "Saving": {"tintegral": 4e-3}})
    ends = []
    for name, parts in (("whole", (10,)), ("parts", (6, 10))):
        run = case.sub(name)
        for i, nt in enumerate(parts):
            run.write("run.ini", merged(ini, steps(nt)))
            run.run("run.ini", *(["--restart"] if i else []), ranks=2)
        ends.append(run)
    for series in ("rigidsolidsolver.t", "free_flight.t", "bending_left.t", "coupling_right.t", "forces.t"):
        check(ends[0].series(series).lines == ends[1].series(series).lines, f"{series}: the last digit")
    run = case.sub("weight")
    run.write("run.ini", merged(ini, {"Flexible_wing": {"gravity": "0 0 -9.81"}}))
    done = run.run("run.ini", "--check", code=EXIT_USER)
    check("differs from [Insects] gravity" in done.err, f"two weights are refused: {done.err}")


def test_sphere(case):
    """A body without wings falls: restart to the bit, and the first fall is that of its mass with the fluid it carries."""
    whole, _ = restarted(case, SPHERE, ranks=2)
    rows = whole.series("rigidsolidsolver.t").rows
    fall = -rows[-1][6] / rows[-1][0]
    check(0.5 < fall * 1.34 < 0.85, f"it falls slower than in a vacuum, where it would with 1/1.34: {fall}")
    check(max(map(abs, rows[-1][4:6])) < 1e-6, "and straight down")


def test_carried_fluid(case):
    """`unst_corrections = no`: the body and the fluid in its mask are moved by the weight of the body alone. Momentum of body and
    flow is conserved, restart to the bit, not with another word."""
    flow = {"iMeanFlow": None, **{f"iMeanFlow_{axis}": "free" for axis in "xyz"}}
    ini = merged(SPHERE, {"Penalization": {"unst_corrections": "no"}, "MeanFlow": flow})
    whole, parts = restarted(case, ini, ranks=2)
    mass, volume, weight = 1.34, 27.0, -1.0
    rows = [(a[0], mass * a[6] + volume * b[3]) for a, b in zip(whole.series("rigidsolidsolver.t").rows,
                                                                whole.series("meanflow.t").rows)]
    check(len(rows) == 17, "all steps")
    for time, momentum in rows:
        check(abs(momentum - weight * time) < 1e-7 * abs(weight * rows[-1][0]), f"{momentum} is not {weight * time}")
    parts.write("run.ini", merged(ini, {"Penalization": {"unst_corrections": "yes"}, "Time": {"nt": 20}}))
    done = parts.run("run.ini", "--restart", code=EXIT_USER)
    check("unst_corrections" in done.err, f"the momentum of a body with its fluid is not that of the body: {done.err}")


def test_repeat(case):
    """The states of a free flight, read back as BodyMotion = from_file::, are the same flight; FLUSI's motions run."""
    ini = merged(FREE, {"Time": {"dt_fixed": 5e-3}})
    free = make(case.sub("free"), ini, 1)
    again = case.sub("again")
    (again.folder / "flight.t").write_text((free.folder / "rigidsolidsolver.t").read_text())
    end = free.series("rigidsolidsolver.t").rows[-1]
    make(again, merged(ini, {"Insects": {"BodyMotion": "from_file::flight.t", "v0": "0 0 0"},
                             "Time": {"Tmax": end[0], "nt": 99}}), 1)
    for old, new in zip(free.series("kinematics.t").rows, again.series("kinematics.t").rows):
        close(old[:6], new[:6], 1e-7, "the place, roll and pitch of the body")
        check(abs(math.remainder(old[6] - new[6], 2 * math.pi)) < 1e-6, "its yaw")
    close(free.series("forces.t").rows[-1][1:4], again.series("forces.t").rows[-1][1:4], 1e-2, "the forces at the end")
    swing = make(case.sub("swing"), merged(WING, {"Insects": {"BodyMotion": "yawpitchroll", "v0": "-0.1 0 0"},
                                                 "Time": {"nt": 6}}), 1)
    same_runs(swing, make(case.sub("swing_again"), merged(WING, {
        "Insects": {"BodyMotion": "yawpitchroll", "v0": "-0.1 0 0"}, "Time": {"nt": 6}}), 1))
    check(swing.series("kinematics.t").rows[-1][4] > 0.01, "the body rolls")


def test_example(case):
    """ini/free-flight.ini on a coarser grid, half a beat: the numbers of this version."""
    ini = SOURCE / "ini"
    text = (ini / "free-flight.ini").read_text()
    for key, value in (("nx", 40), ("ny", 40), ("nz", 40), ("Tmax", 0.5), ("tsave", 9)):
        text = re.sub(rf"(?m)^{key} = \S+", f"{key} = {value}", text)
    case.write("run.ini", re.sub(r"from_file::", f"from_file::{ini}/", text))
    done = case.run("run.ini", "--check", ranks=0)
    check(done.err == "", f"the example is checked without a remark:\n{done.err}")
    case.run("run.ini", ranks=2)
    last = case.series("rigidsolidsolver.t").rows[-1]
    close(last[1:7], EXAMPLE, 1e-4, "place and velocity after half a beat")


def test_mistakes(case):
    """What cannot fly is refused by its key."""
    case.write("beat.ini", BEAT)
    for section, key, value in (("Time", "iTimeMethodFluid", "RK4"), ("Time", "iTimeMethodFluid", "RK2"), ("Insects", "DoF", "1112"), ("Insects", "mass", 0),
                                ("Insects", "wing_mass", 30.0), ("Insects", "J_body_yawpitchroll", "1 1 9"),
                                ("Insects", "J_body_yawpitchroll", "0 1 1"), ("Insects", "BodyMotion", "from_file::no.t")):
        case.write("run.ini", merged(FREE, {section: {key: value}}))
        done = case.run("run.ini", "--check", code=EXIT_USER)
        check((key if key != "wing_mass" else "mass") in done.err, f"{key} is named: {done.err}")
    case.write("run.ini", merged(FREE, {"Insects": {"Jxx": 60.0, "wing_mass": None}}))
    done = case.run("run.ini", "--check")
    check("Jxx: makes the mass of the wings" in done.err, f"wings of FLUSI's files that outweigh the insect have no mass: {done.err}")
    case.write("run.ini", merged(FREE, {"Insects": {"mass": 0.5, "J_body_yawpitchroll": "0.01 0.01 0.01", "wing_mass": 0}}))
    done = case.run("run.ini", code=EXIT_USER)
    check("too light to fly freely" in done.err, f"an insect that is lighter than what it displaces is refused: {done.err}")


if __name__ == "__main__":
    main(globals())
