#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole runs with flapping wings: restart to the bit, ranks, units, output, and what users get wrong.

usage: flusi_wing.py <flusi> <h5dump> [tests]
"""
import re

from whole_program import EXIT_USER, SOURCE, check, close, main, merged, no_crash, ring, same_runs

ROUND_OFF = 1e-12
LAST_DIGIT = 2e-8  # series hold nine digits

WING = {
    "Resolution": {"nx": 32, "ny": 32, "nz": 16},
    "Geometry": {"xl": 4.0, "yl": 4.0, "zl": 2.0},
    "Time": {"nt": 16, "CFL": 0.5},
    "ReynoldsNumber": {"nu": 1e-2},
    "InitialCondition": {"inicond": "MeanFlow"},
    "Penalization": {"iPenalization": "yes", "iMoving": "yes", "iMask": "Insect", "eps": 1.25e-2},
    "Insects": {"surface": "penalized", "WingShape": f"from_file::{SOURCE}/ini/wings/calliphora.ini", "wing_length": 1.0,
                "FlappingMotion_left": "from_file::beat.ini", "FlappingMotion_right": "from_file::beat.ini",
                "x0": "2.0 2.0 1.0", "yawpitchroll_0": "180.0 0.0 0.0", "eta0": -70.0,
                "x_pivot_l": "0.0 0.5 0.0", "x_pivot_r": "0.0 -0.5 0.0", "wing_ramp": 0.1, "Jxx": 1e-3, "Jyy": 1e-4},
    "MeanFlow": {"iMeanFlow_x": "fixed", "iMeanFlow_y": "free", "iMeanFlow_z": "fixed", "ux": 0.95, "uy": 0.0, "uz": 0.0},
    "Sponge": {"iVorticitySponge": "yes", "iSpongeType": "outlet_x", "eps_sponge": 5e-2, "sponge_thickness": 6},
    "Saving": {"tsave": 0.03, "tintegral": 0.01, "iSaveVelocity": "yes", "iSaveMask": "yes", "iSaveSolidVelocity": "yes",
               "field_precision": "double"},
}
BEAT = (SOURCE / "ini/kinematics/calliphora.ini").read_text()
SERIES = ("forces.t", "forces_part2.t", "forces_part3.t", "wing_left.t", "wing_right.t", "aero_power.t", "kinematics.t")


def make(case, ini, ranks=2):
    case.write("beat.ini", BEAT)
    case.write("run.ini", ini)
    case.run("run.ini", ranks=ranks)
    return case


def steps(n):
    return {"Time": {"nt": n}}


def restarted(case, ini, ranks=2):
    whole = make(case.sub("whole"), merged(ini, steps(16)), ranks)
    parts = make(case.sub("parts"), merged(ini, steps(7)), ranks)
    parts.write("run.ini", merged(ini, steps(16)))
    parts.run("run.ini", "--restart", ranks=ranks)
    same_runs(whole, parts)
    return whole, parts


def same_on_ranks(case, ini, ranks, *further):
    """The series of wings and `further` ones are the same on one and on `ranks` ranks, to their last digit. Returns the run on one."""
    one = make(case.sub("ranks_1"), ini, 1)
    other = make(case.sub(f"ranks_{ranks}"), ini, ranks)
    for name in (*SERIES, *further):
        a, b = one.series(name).rows, other.series(name).rows
        check(len(a) == len(b) > 3, f"{name} has the same records on {ranks} ranks")
        for p, q in zip(zip(*a), zip(*b)):
            close(p, q, 2e-8, f"a column of {name}")
    return one


def test_restart(case):
    whole, parts = restarted(case, WING)
    check(set(SERIES) <= set(whole.all_series()), f"all series of wings are there: {sorted(whole.all_series())}")
    saved = [n for n in whole.files() if n.startswith(("wing_left_", "wing_right_")) and n.endswith(".h5")]
    check(len(saved) >= 4, f"wings are saved: {saved}")
    for side in ("left", "right"):
        text = (parts.folder / f"run_{side}.xmf").read_text()
        files = re.findall(r">(wing_\w+\.h5):/points", text)
        check(files == sorted(n for n in saved if side in n), f"the index of the {side} wing lists its files: {files}")
        check(text.count('TopologyType="Triangle"') == len(files), "as triangles")
        for size, file, dataset in re.findall(r'Dimensions="(\d+) 3">(wing_\w+\.h5):/(\w+)', text):
            found = re.search(rf'DATASET "{dataset}".*?SIMPLE \{{ \( (\d+), 3 \)', parts.header(file), re.S)
            check(found and found.group(1) == size, f"{file} has {size} {dataset}")


def test_restart_runge_kutta(case):
    ini = merged(WING, {"Time": {"iTimeMethodFluid": "RK4"}, "MeanFlow": {"iMeanFlow_z": "dynamic", "m_fluid": 40.0}})
    whole, _ = restarted(case, ini, ranks=1)
    # The stages move the wings; what is written belongs to the beginning of the step.
    times = [row[0] for row in whole.series("forces.t").rows]
    for name in SERIES:
        check([row[0] for row in whole.series(name).rows] == times, f"{name} has the times of the forces")


def test_ranks(case):
    """The same numbers on any number of ranks, to the last printed digit and in fields to round-off."""
    one = make(case.sub("ranks_1"), WING, 1)
    last = max(n for n in one.files() if n.startswith("ux_"))
    for ranks, rows in ((2, 2), (3, 1)):
        other = make(case.sub(f"ranks_{ranks}"), merged(WING, {"Resolution": {"process_rows": rows}}), ranks)
        for name in SERIES:
            a, b = one.series(name).rows, other.series(name).rows
            check(len(a) == len(b) > 3, f"{name} has the same records on {ranks} ranks")
            for p, q in zip(zip(*a), zip(*b)):
                close(p, q, LAST_DIGIT, f"a column of {name}")
        for prefix in ("ux", "uy", "uz", "mask", "usx"):
            name = last.replace("ux", prefix)
            close(one.field(name), other.field(name), ROUND_OFF, name)


def test_series(case):
    """The parts are the wings, the total is their sum, and lab and wing frame hold the same vectors."""
    make(case, WING, 1)
    total, power = case.series("forces.t").rows, case.series("aero_power.t").rows
    left, right = case.series("wing_left.t").rows, case.series("wing_right.t").rows
    check(len(total) == len(power) == len(left) == len(right) > 5, "records at the same times")
    for t, p, one, other in zip(total, power, left, right):
        check(t[0] == p[0] == one[0] == other[0], "the same time")
        close([a + b for a, b in zip(one[1:4], other[1:4])], [a + b for a, b in zip(t[1:4], t[4:7])], 1e-7,
              "the force on both wings")
        close([one[13] + other[13]], p[1:2], 1e-7, "their power")
        close([one[15] + other[15]], p[2:3], 1e-7, "their inertial power")
        close(t[13:15], p[1:3], 1e-7, "power in forces.t")
        for wing in (one, other):
            for lab, own in ((wing[1:4], wing[4:7]), (wing[7:10], wing[10:13])):
                close([sum(x * x for x in lab)], [sum(x * x for x in own)], 1e-7, "a length in both frames")


def test_units(case):
    """The run in SI units is the run without units, to the last printed digit."""
    length, time, mass = 9e-3, 1 / 158, 1.225 * 9e-3**3
    one = make(case.sub("one"), merged(WING, {"units": {"length": 9e-3, "frequency": 158, "density": 1.225}}), 1)
    si = merged(WING, {
        "units": {"input": "SI", "length": 9e-3, "frequency": 158, "density": 1.225},
        "Geometry": {k: repr(v * length) for k, v in WING["Geometry"].items()},
        "ReynoldsNumber": {"nu": repr(1e-2 * length**2 / time)},
        "Penalization": {"eps": repr(1.25e-2 * time)},
        "Insects": {"wing_length": repr(length), "x0": " ".join(repr(x * length) for x in (2, 2, 1)),
                    "x_pivot_l": f"0.0 {0.5 * length!r} 0.0", "x_pivot_r": f"0.0 {-0.5 * length!r} 0.0",
                    "wing_ramp": repr(0.1 * time), "wing_frequency": 158.0, "Jxx": repr(1e-3 * mass * length**2),
                    "Jyy": repr(1e-4 * mass * length**2)},
        "MeanFlow": {"ux": repr(0.95 * length / time)},
        "Sponge": {"eps_sponge": repr(5e-2 * time)},
        "Saving": {"tsave": repr(0.03 * time), "tintegral": repr(0.01 * time)}})
    two = make(case.sub("two"), si, 1)
    for name in SERIES:
        a, b = one.series(name).rows, two.series(name).rows
        check(len(a) == len(b) > 3, f"{name} has the same records")
        for p, q in zip(zip(*a), zip(*b)):
            close(p, q, LAST_DIGIT, f"a column of {name}")


def test_check(case):
    """The examples of this repository are right."""
    for name in ("wing.ini",):
        done = case.run(str(SOURCE / "ini" / name), "--check", ranks=0)
        check("error" not in (done.out + done.err).lower(), f"{name} has no mistakes:\n{done.out}{done.err}")
    check(case.files() == [], "nothing is written")


def checked(case, ini):
    """What --check prints is accepted as input, without remarks, and printed again."""
    case.write("beat.ini", BEAT)
    case.write("run.ini", ini)
    first = case.run("run.ini", "--check", ranks=0)
    case.write("printed.ini", first.out)
    second = case.run("printed.ini", "--check", ranks=0)

    def values(text):
        return re.findall(r"^  (\S+ = .*?);", text, re.M)

    a, b = values(first.out), values(second.out)
    check(len(a) == len(b) > 100, "the same keys")
    for one, two in zip(a, b):
        words = list(zip(one.split(), two.split()))
        check(len(one.split()) == len(two.split()) and one.split("=")[0] == two.split("=")[0], f"{one} is {two}")
        for x, y in words:
            try:
                close([float(x)], [float(y)], 1e-14, one)
            except ValueError:
                check(x == y, f"{one} is {two}")
    return first


def test_checked_is_equivalent(case):
    # Without iMoving, whose default depends on the mask.
    ini = merged(WING, {"Penalization": {"iMoving": None}})
    checked(case.sub("plain"), ini)
    first = checked(case.sub("si"), merged(ini, {
        "units": {"input": "SI", "length": 1e-2, "frequency": 100, "density": 1.2},
        "Geometry": {"xl": 0.04, "yl": 0.04, "zl": 0.02}, "ReynoldsNumber": {"nu": 1e-4}, "Penalization": {"eps": 1e-4},
        "Insects": {"wing_length": 0.01, "x0": "0.02 0.02 0.01", "x_pivot_l": "0.0 0.005 0.0",
                    "x_pivot_r": "0.0 -0.005 0.0", "wing_ramp": None, "Jxx": None, "Jyy": None, "wing_frequency": 100},
        "MeanFlow": {"ux": 0.95}, "Sponge": {"eps_sponge": 5e-4}, "Saving": {"tsave": None, "tintegral": None}}))
    found = re.search(r"^  tintegral = (\S+);", first.out, re.M)
    close([float(found.group(1))], [1e-4], 1e-14, "0.01 beats of 1/100 s, printed in seconds")


def noticed(case, ini, sentence):
    case.write("beat.ini", BEAT)
    case.write("run.ini", ini)
    done = case.run("run.ini", "--check", ranks=0)
    check(len(re.findall(sentence, done.err)) == 1, f"'{sentence}' is said once:\n{done.err}")


def test_notices(case):
    units = {"length": 9e-3, "frequency": 158, "density": 1.225}
    words = r"wing_frequency equals \[units\] frequency, but its unit is 1/T: there are 158\S* beats"
    noticed(case, merged(WING, {"units": units, "Insects": {"wing_frequency": 158}}), words)
    case.write("run.ini", merged(WING, {"units": units}))
    check("wing_frequency equals" not in case.run("run.ini", "--check", ranks=0).err, "one beat in T is all right")


def test_no_wind(case):
    """A flow that begins at rest and that nothing holds has no wind in the numbers at the start."""
    calm = merged(WING, {"InitialCondition": {"inicond": "quiescent"}, "Time": {"nt": 1}})
    calm.pop("MeanFlow")
    case.write("beat.ini", BEAT)
    case.write("run.ini", calm)
    out = case.run("run.ini").out
    check(re.search(r"u_inf = 0?\.0+E?[+0]*$", out, re.M), f"there is no wind:\n{out}")
    noticed(case.sub("idle"), merged(calm, {"MeanFlow": {"ux": 2.0}}), r"\[MeanFlow\] ux: has no effect: .*iMeanFlow_x = fixed")
    for wind in ({"ux": 2.0, "iMeanFlow_x": "fixed"}, {"ux": 0.0}):
        case.write("run.ini", merged(calm, {"MeanFlow": wind}))
        check("has no effect" not in case.run("run.ini", "--check", ranks=0).err, f"{wind} is not doubted")
    dynamic = case.sub("dynamic")
    noticed(dynamic, merged(calm, {"MeanFlow": {"ux": 2.0, "iMeanFlow_x": "dynamic"}}), r"for a wind set .*inicond = MeanFlow\n")


def test_wind_of_a_checkpoint(case):
    """A run that continues a flow at rest has no wind either, unless its input gives one."""
    calm = merged(WING, {"InitialCondition": {"inicond": "quiescent"}, "Time": {"nt": 1}})
    calm.pop("MeanFlow")
    make(case, calm)
    on = merged(calm, {"InitialCondition": {"inicond": "backup"}, "Time": {"nt": 2}})
    case.write("run.ini", on)
    out = case.run("run.ini").out
    check(re.search(r"u_inf = 0?\.0+E?[+0]*$", out, re.M), f"there is no wind:\n{out}")
    case.write("run.ini", merged(on, {"MeanFlow": {"ux": 2.0}}))
    check("has no effect" not in case.run("run.ini", "--check", ranks=0).err, "a wind that is given is not doubted")


def test_wind_of_a_ring(case):
    """A vortex ring begins with the velocity of [MeanFlow], and keeps it where there is no solid."""
    case.write("run.ini", ring(Time={"nt": 2}, MeanFlow={"ux": 1.0}))
    done = case.run("run.ini")
    check("has no effect" not in done.out + done.err, f"the wind is not doubted:\n{done.out}{done.err}")
    for row in case.series("meanflow.t").rows:
        close(row[1:4], [1.0, 0.0, 0.0], LAST_DIGIT, "the mean flow")


def test_no_end(case):
    """The program warns of a run without an end; a number of steps is an end."""
    endless = merged(WING, {"Time": {"Tmax": None, "nt": None}})
    noticed(case, endless, r"\[Time\] Tmax: neither Tmax nor nt is given: nothing but the wall time or you will stop")
    case.write("run.ini", merged(endless, {"Time": {"nt": 7}}))
    check("neither Tmax" not in case.run("run.ini", "--check", ranks=0).err, "nt is an end")


def test_magnitudes(case):
    """Units that were mixed up: nu in mm^2/s, eps in ms."""
    units = {"length": 9e-3, "frequency": 158, "density": 1.225}
    for change, sentence in (({"ReynoldsNumber": {"nu": 1e3}}, r"\[ReynoldsNumber\] nu: makes an unusual Reynolds number: .* is too small"),
                             ({"Penalization": {"eps": 5.0}}, r"\[Penalization\] eps: 5.0 beats is too large .*; .*5.0e-3 would be")):
        noticed(case, merged(merged(WING, {"units": units}), change), sentence)
    for change, sentence in (({"ReynoldsNumber": {"nu": None}},
                              r"\[ReynoldsNumber\] nu: is not given; the program assumes 0.01 L\^2/T, .* Reynolds number \d+"),
                             ({"ReynoldsNumber": {"nu": 0}}, r"\[ReynoldsNumber\] nu: is 0: "),
                             ({"Penalization": {"eps": None}}, r"\[Penalization\] eps: is not given; the program assumes 0.01 T")):
        noticed(case, merged(merged(WING, {"units": units}), change), sentence)
    case.write("run.ini", merged(WING, {"units": units}))
    told = case.run("run.ini", "--check", ranks=0).err
    check("is too" not in told and "the program assumes" not in told, f"usual numbers are not doubted:\n{told}")


def mistakes(case, ini, *sentences):
    """All of these and nothing else, in one report, by --check and by a run on two ranks."""
    case.write("beat.ini", BEAT)
    case.write("run.ini", ini)
    before = case.files()
    for arguments, ranks in ((("run.ini", "--check"), 0), (("run.ini",), 2)):
        done = case.flusi(*arguments, ranks=ranks)
        check(done.code == EXIT_USER, f"exit code 2, not {done.code}:\n{done.out}{done.err}")
        no_crash(done)
        for sentence in sentences:
            check(len(re.findall(sentence, done.err)) == 1, f"'{sentence}' is said once:\n{done.err}")
        found = [line for line in done.err.splitlines() if re.match(r"(flusi: |error: )?\S+(:\d+)?: ", line)]
        check(len(found) >= len(sentences), f"{len(sentences)} mistakes are reported:\n{done.err}")
        check(case.files() == before, f"nothing is written: {case.files()}")


def test_mistakes(case):
    mistakes(case.sub("shape"), merged(WING, {"Insects": {"WingShape": None}}), r"WingShape: is missing; valid: ")
    mistakes(case.sub("planform"), merged(WING, {"Insects": {"WingShape": "from_file::nosuch.ini"}}),
             r"run\.ini:\d+: \[Insects\] WingShape: .?nosuch\.ini.? does not exist")
    mistakes(case.sub("none"), merged(WING, {"Insects": {"LeftWing": "no", "RightWing": "no"}}),
             r"LeftWing: there is neither a wing nor a body")
    mistakes(case.sub("moving"), merged(WING, {"Penalization": {"iMoving": "no"}}),
             r"run\.ini:\d+: \[Penalization\] iMoving: would hold the wings")
    mistakes(case.sub("thin"), merged(WING, {"Insects": {"WingThickness": 0.1}}),
             r"run\.ini:\d+: \[Insects\] WingThickness: makes wings thinner")
    mistakes(case.sub("hinges"), merged(WING, {"Insects": {"x_pivot_r": "0.0 0.5 0.0"}}),
             r"run\.ini:\d+: \[Insects\] x_pivot_r: is the same point as x_pivot_l")
    mistakes(case.sub("swapped"), merged(WING, {"Insects": {"x_pivot_l": "0.0 -0.5 0.0", "x_pivot_r": "0.0 0.5 0.0"}}),
             r"run\.ini:\d+: \[Insects\] x_pivot_l: is to the right of x_pivot_r")
    mistakes(case.sub("outside"), merged(WING, {"Insects": {"x0": "2.0 2.0 18.0"}}),
             r"run\.ini:\d+: \[Insects\] x0: is outside of the box")
    mistakes(case.sub("room"), merged(WING, {"Geometry": {"zl": 8.0}, "Resolution": {"nz": 64},
                                             "Insects": {"wing_length": 3.5}}),
             r"run\.ini:\d+: \[Geometry\] yl: is too small: with its thickness the left wing extends")
    small = case.sub("small")
    small.write("planform.ini", "[Wing]\ntype = rectangular\nlength = 9e-3\nmean_chord = 3e-3\n")
    tiny = merged(WING, {"Insects": {"WingShape": "from_file::planform.ini", "wing_length": None}})
    mistakes(small, tiny, r"\[Insects\] wing_length: is needed: the file of the planform has its tip at x = 0?\.009")
    mistakes(small, merged(tiny, {"Insects": {"wing_length": 0.1}}), r"\[Insects\] wing_length: is too small: the tip")
    short = case.sub("short")
    rows = "".join(f"{t} 0.0 45.0 0.0 0.0 0.0 0.0 10.0 0.0 0.0 0.0 0.0 0.0\n" for t in (0.0, 0.5))
    short.write("table.dat", "1.0\n1.0\n2\n" + rows)
    mistakes(short, merged(WING, {"Time": {"Tmax": 1.0}, "Insects": {"FlappingMotion_left": "kinematics_loader::table.dat"}}),
             r"table\.dat: the table ends after 0?\.50* cycles, the run after 1\.?0* cycles|table\.dat: the table ends after")


def test_all_mistakes(case):
    """Independent mistakes come together."""
    case.write("table.dat", "1.0\n1.0\n2\n0.0" + " 0.0" * 12 + "\n0.5" + " 0.0" * 12 + "\n")
    case.write("planform.ini", "[Wing]\ntype = ellipse\nlength = -1\n")
    mistakes(case, merged(WING, {
        "Resolution": {"nx": 31}, "Time": {"Tmax": 1.0}, "Penalization": {"iMoving": "no"},
        "Insects": {"WingShape": "from_file::planform.ini", "WingThickness": 0.1, "FlappingMotion_left": "from_file::gone.ini",
                    "FlappingMotion_right": "kinematics_loader::table.dat", "x_pivot_r": "0.0 0.5 0.0", "wing_speed": 3}}),
        r"\[Resolution\] nx: ", r"\[Penalization\] iMoving: would hold", r"WingThickness: makes wings thinner",
        r"planform\.ini:3: \[Wing\] length: ", r"FlappingMotion_left: .?gone\.ini.? does not exist",
        r"table\.dat: the table ends after", r"x_pivot_r: is the same point", r"wing_speed: ")


if __name__ == "__main__":
    main(globals())
