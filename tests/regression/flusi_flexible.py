#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flexible wings in the flow: the rigid limit, restart, ranks, release, mistakes.

usage: flusi_flexible.py <flusi> <h5dump> [tests]

The grid is far too coarse for physics; what is tested is that parts fit together.
"""
import math
import re
import shutil
import struct
from pathlib import Path

from flight_case import FLIGHT, LAST_DIGIT, largest, same_flight
from whole_program import EXIT_NUMERICAL, EXIT_USER, SOURCE, check, ini_text, main, merged, same_checkpoints

FLOWN = {}  # finished runs by ranks and input: tests that ask for the same flight read the same files


def fly(case, ranks=0, **sections):
    flight = ranks, ini_text(merged(FLIGHT, sections))
    if flight not in FLOWN:
        case.write("run.ini", flight[1])
        case.run("run.ini", ranks=ranks)
        FLOWN[flight] = case
    return FLOWN[flight]


def table(case, name):
    return case.series(name).rows


def difference(a, b, columns):
    """Largest difference of two tables in `columns`, over the largest number there."""
    check(len(a) == len(b), "both runs have the same records")
    size = max(largest(a, c) for c in columns)
    return max(abs(x[c] - y[c]) for x, y in zip(a, b) for c in columns) / size


def test_rigid_limit(case):
    """Deflection and the change of force are inversely proportional to the stiffness."""
    rigid = fly(case.sub("rigid"), Insects={"wings": "rigid"})
    moved, changed = [], []
    for factor in (1e3, 1e4):
        stiff = fly(case.sub(f"stiff{factor:.0e}"), Wing={"E": 12.58e9 * factor, "D": 2e-7 * factor, "k_e": 1e5 * factor,
                                                        "joint_stiffness": None})
        moved.append(largest(table(stiff, "bending_left.t"), 4))
        changed.append(difference(table(stiff, "forces.t"), table(rigid, "forces.t"), (1, 3)))
    check(moved[0] < 2e-3, f"a stiff wing bends little: {moved[0]}")
    check(changed[0] < 5e-2, f"its forces are almost those of the rigid wing: {changed[0]}")
    check(5 < moved[0] / moved[1] < 20, f"a tenth of the bending for ten times the stiffness: {moved}")
    check(changed[1] < 0.2 * changed[0], f"and a tenth of the change of force: {changed}")


def test_restart(case):
    """11 steps, restart, 5 steps are 16 steps to the bit, on two ranks; fewer with the other couplings."""
    strong = {"coupling": "strong", "load": "pressure_viscous"}
    # The rigid wings of the last case are released after the restart.
    held = {"coupling": "extrapolated", "T_release": 0.018}
    for coupling, steps, first in (({}, 16, 11), ({"coupling": "extrapolated"}, 12, 7), (strong, 8, 5), (held, 8, 3)):
        setup = {"Flexible_wing": coupling, "Saving": {"tintegral": 8e-3}}
        name = "held" if "T_release" in coupling else coupling.get("coupling", "weak")
        whole = fly(case.sub(name), ranks=2, Time={"nt": steps}, **setup)
        parts = fly(case.sub(f"{name}_parts"), ranks=2, Time={"nt": first}, **setup)
        parts.write("run.ini", merged(FLIGHT, {"Time": {"nt": steps}, **setup}))
        parts.run("run.ini", "--restart", ranks=2)
        same_checkpoints(whole, whole.newest_checkpoint(), parts, parts.newest_checkpoint())
        check(largest(table(whole, "bending_left.t"), 4) > 0, f"{name}: the wing bends in the end")
        for series in ("forces.t", "bending_left.t", "bending_right.t", "wing_right.t", "coupling_left.t"):
            check(whole.series(series).lines == parts.series(series).lines, f"{name}, {series}: the last digit")


def test_trials_are_steps(case):
    """A step that begins with the last trial of the strong coupling is the same as one that repeats it."""
    strong = {"Time": {"nt": 8}, "Flexible_wing": {"coupling": "strong"}}
    each = fly(case.sub("each"), **strong)
    other = fly(case.sub("other"), Saving={"tintegral": 8e-3}, **strong)
    for name in ("forces.t", "bending_left.t", "wing_right.t"):
        check(set(other.series(name).lines) <= set(each.series(name).lines), f"{name} is the same to the last digit")
        check(len(other.series(name).lines) < len(each.series(name).lines), "with fewer records")


def test_ranks(case):
    """Every rank count gives the same flight."""
    one = fly(case.sub("n1"))
    for n in (2, 3):
        other = fly(case.sub(f"n{n}"), ranks=n, Time={"nt": 14})
        same_flight(one, other, 14)


def test_mirror(case):
    """Both wings do the same: the z displacements in their frames are opposite."""
    run = fly(case)
    left, right = table(run, "bending_left.t"), table(run, "bending_right.t")
    check(largest(left, 3) > 0.01, "the wings bend")
    for a, b in zip(left, right):
        check(abs(a[3] + b[3]) < 1e-7 and abs(a[1] - b[1]) < 1e-7, f"mirror images at t = {a[0]}")


# Wings that tell up from down.
SIDED = {"Wing": {"sided_joints": "yes", "sided_veins": "yes", "joint_stiffness": 2e-6,
                  "parameters": "camber_chord 30, one_way:R1_Rs 0.1, one_way:C_Sc 0.1, one_way:R4+5_base 0.1"}}


def test_mirror_of_sides(case):
    """So they do if they tell up from down, to whichever side z points, which makes a difference. A restart is exact."""
    tips = []
    for side in ("left ventral", "right dorsal"):
        setup = merged(SIDED, {"Wing": {"z_side": side}, "Time": {"nt": 8}, "Saving": {"tintegral": 8e-3}})
        whole = fly(case.sub(side.replace(" ", "_")), ranks=2, **setup)
        left, right = table(whole, "bending_left.t"), table(whole, "bending_right.t")
        check(largest(left, 3) > 1e-3, "the wings bend")
        for column in (*range(1, 7), *range(12, 26)):
            # Nine digits. The imbalance is a small difference of energies.
            size = max(largest(left, column), largest(left, 5) if column == 25 else 0)
            mirror = -1 if column == 3 else 1
            worst = max(abs(a[column] - mirror * b[column]) for a, b in zip(left, right))
            check(worst <= LAST_DIGIT * size, f"{side}, column {column + 1}: {worst} of {size}")
        tips.append(left)
    check(difference(*tips, (1, 2, 3)) > 0.1, "the side counts")
    # Of the last flight the left wing is the mirror image of the one in the file.
    parts = fly(case.sub("parts"), ranks=2, **merged(setup, {"Time": {"nt": 5}}))
    parts.write("run.ini", merged(FLIGHT, setup))
    parts.run("run.ini", "--restart", ranks=2)
    same_checkpoints(whole, whole.newest_checkpoint(), parts, parts.newest_checkpoint())
    for series in ("forces.t", "bending_left.t", "bending_right.t"):
        check(whole.series(series).lines == parts.series(series).lines, f"{series}: the last digit")


def test_field_with_a_time(case):
    """Wings that begin in a flow from a file begin at its time: stiff ones have the kinetic energy of their motion then,
    which after this part of the ramp is hundreds of times that near the beginning."""
    stiff = {"Wing": {"E": 12.58e12, "D": 2e-4, "k_e": 1e8, "joint_stiffness": None},
             "Saving": {"tsave": 0.056, "iSaveVelocity": "yes", "field_precision": "double"}}
    first, second = case.sub("first"), case.sub("second")
    fly(first, Time={"nt": 18}, **stiff)
    last = sorted(name for name in first.files() if name.startswith("ux_"))[-2][3:]
    for c in "xyz":
        shutil.copy(first.folder / f"u{c}_{last}", second.folder / f"start_{c}.h5")
    fly(second, Time={"nt": 4}, InitialCondition={"inicond": "infile", **{f"file_u{c}": f"start_{c}.h5" for c in "xyz"}},
        **stiff)
    whole, part = ({row[0]: row for row in table(run, "bending_left.t")} for run in (first, second))
    begun = min(part)
    check(begun > 0.05, f"the time of the file: {begun}")
    rows = [(whole[t], part[t]) for t in sorted(part) if t in whole and t > begun][:3]
    check(len(rows) == 3, "records of the same times")
    for a, b in rows:
        # Of the vibration that the bending takes up anew there is 2 %.
        check(abs(b[21] / a[21] - 1) < 4e-2, f"kinetic energy at t = {a[0]}: {a[21]}, {b[21]}")
    check(rows[0][0][21] > 100 * whole[min(t for t in whole if t > 0)][21], "which is not that of the beginning")


def test_work_per_step(case):
    """In the first steps of ini/wing.ini with its time step, on a coarser grid with the small wing, a step takes at most
    three factorisations per wing, as soon as what the impulsive start of the flow brings is over; with the strong coupling
    all its repetitions together. (So do whole beats: docs/results/coupling-results.md. Cases with steps three times as long and a
    ramp five times as short, as in the other tests, take dozens where steps are halved: the first guess of a step is
    wrong by what accelerations change in it, and inertia holds Newton's method by 1/dt^2.)"""
    for coupling, end in (("weak", 0.036), ("strong", 0.02)):
        count_work(case.sub(coupling), coupling, end)


def count_work(case, coupling, end):
    text = (SOURCE / "ini/wing.ini").read_text()
    for key, value in (("nx", 40), ("ny", 40), ("nz", 20), ("Tmax", end), ("sponge_thickness", 5),
                       ("coupling", coupling), ("surface", "penalized"), ("iMoving", "1\neps = 1.2e-3"),
                       ("file", f"{SOURCE}/wings/calliphora_small.h5")):
        text, found = re.subn(rf"^{key} *=.*", f"{key} = {value}", text, flags=re.MULTILINE)
        check(found == 1, f"{key} is in the file")
    text = re.sub(r"^iSave.*", "", text.replace("from_file::", f"from_file::{SOURCE}/ini/"), flags=re.MULTILINE)
    (case.folder / "run.ini").write_text(text)
    case.run("run.ini", ranks=2)
    for side in ("left", "right"):
        rows = [row for row in table(case, f"coupling_{side}.t")]
        check(len(rows) > 800 * end and largest(table(case, "dt.t"), 1) > 1e-3, f"the steps of the case: {len(rows)}")
        work = [row[9] for row in rows if row[0] > 0.01]
        check(min(work) >= 1 and max(work) <= 3, f"{coupling}, {side}: factorisations {work}")
        check(max(row[10] for row in rows) == 1 or coupling == "strong", f"{coupling}, {side}: evaluations of the flow")
        check(max(row[9] for row in rows) <= 4, f"{side}, at the start: {[row[9] for row in rows[:9]]}")


def test_release(case):
    """Until T_release the wings are rigid."""
    run = fly(case, Flexible_wing={"T_release": 0.05})
    rows = table(run, "bending_left.t")
    check(all(row[4] == 0 for row in rows if row[0] <= 0.05), "no bending before the release")
    check(largest(rows, 4) > 0, "bending afterwards")


def numbers(case, file, name, kind="d", columns=3):
    """A dataset as rows of numbers."""
    raw = case.raw(file, name)
    flat = struct.unpack(f"<{len(raw) // struct.calcsize(kind)}{kind}", raw)
    return [flat[i:i + columns] for i in range(0, len(flat), columns)]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def attribute(case, file, name):
    return [float(x) for x in case.contents(file)[name]]


def test_surfaces(case):
    """The saved wings: what bends them and how far, in agreement with the series and with the rigid wing."""
    run = fly(case.sub("flexible"))
    rigid = fly(case.sub("rigid"), Insects={"wings": "rigid"})
    for index in ("run_left.xmf", "run_right.xmf"):
        run.check_index(index)
        rigid.check_index(index)
    file = max(name for name in run.files() if name.startswith("wing_right_"))
    points, displacement = numbers(run, file, "points"), numbers(run, file, "displacement")
    replicate = [minus(x, u) for x, u in zip(points, displacement)]
    same = max(abs(c) for x, y in zip(replicate, numbers(rigid, file, "points")) for c in minus(x, y))
    check(same < 1e-13, f"without its displacement the wing is its rigid replicate: {same}")
    row = table(run, "bending_right.t")[-1]
    check(abs(row[0] - attribute(run, file, "time")[0]) < 1e-8, "the last record is that of the last surface")
    tip = max(math.hypot(*u) for u in displacement)
    check(abs(tip / row[4] - 1) < 1e-8 and tip > 1e-3, f"the largest displacement is that of the series: {tip}")
    areas, total = [0.0] * len(points), [0.0] * 3
    jumps = [j for (j,) in numbers(run, file, "pressure_jump", columns=1)]
    for corners, jump in zip(numbers(run, file, "triangles", "i"), jumps):
        a, b, c = (points[i] for i in corners)
        area = [x / 2 for x in cross(minus(b, a), minus(c, a))]
        total = [t - jump * x for t, x in zip(total, area)]
        for i in corners:
            areas[i] += math.hypot(*area) / 3
    load = [sum(area * f[c] for area, f in zip(areas, numbers(run, file, "load"))) for c in range(3)]
    size = max(abs(x) for x in row[7:10])
    check(max(abs(a - b) for a, b in zip(load, row[7:10])) < 1e-7 * size, f"the load is the force: {load}, {row[7:10]}")
    check(max(abs(a - b) for a, b in zip(total, load)) < 1e-10 * size, f"and that of the pressure jump: {total}")


def test_shape(case):
    """Mirror images have the same trailing edge, twist and camber, and the tip bends with the trailing edge."""
    run = fly(case)
    left, right = table(run, "bending_left.t"), table(run, "bending_right.t")
    for a, b in zip(left, right):
        check(len(a) == 30, "nine columns of shape, five of energy, four of mismatch")
        check(all(abs(x - y) < 1e-7 for x, y in zip(a[12:21], b[12:21])), f"mirror images at t = {a[0]}: {a}, {b}")
    for column, name in ((12, "trailing edge"), (13, "twist"), (14, "camber")):
        check(largest(left, column) > 1e-4, f"there is some {name}")
    check(largest(left, 18) > largest(left, 12), "the trailing edge moves farther outboard")
    # z of the left wing points to its lower side.
    check(left[-1][3] * left[-1][18] < 0, f"up is up: {left[-1][3]}, {left[-1][18]}")


def test_balance_columns(case):
    """Powers are the rates of the energies up to the imbalance; the mismatch is the difference of two forces."""
    run = fly(case)
    bending, wing = table(run, "bending_right.t"), table(run, "wing_right.t")
    most = max(largest(bending, c) for c in (5, 21))
    check(largest(bending, 22) > 0 and largest(bending, 23) > 0, "hinge and load have power")
    for a, b in zip(bending, bending[1:]):
        change = b[5] + b[21] - a[5] - a[21] - (b[0] - a[0]) * (b[22] + b[23] - b[24])
        check(abs(change - (b[25] - a[25])) < 1e-7 * most, f"energy at t = {b[0]}: {change}, {b[25] - a[25]}")
    size = max(largest(bending, c) for c in (7, 8, 9))
    for a, b in zip(bending, wing):
        for c in range(3):
            check(abs(a[26 + c] - (a[7 + c] - b[1 + c])) < 1e-7 * size, f"mismatch of the force at t = {a[0]}")


def test_coupling_series(case):
    """Every step has a record of load and mismatch, the numbers of the other series where these have a record too."""
    run = fly(case, Time={"nt": 16}, Saving={"tintegral": 8e-3}, Flexible_wing={"load": "pressure_viscous"})
    for side in ("left", "right"):
        steps, bending = table(run, f"coupling_{side}.t"), table(run, f"bending_{side}.t")
        wing = table(run, f"wing_{side}.t")
        check([r[0] for r in steps] == [r[0] for r in table(run, "dt.t")] and len(steps) == 16, "one for each step")
        rows = {row[0]: row for row in steps}
        common = [(rows[b[0]], b, w) for b, w in zip(bending, wing) if b[0] in rows]
        check(len(common) >= 8, f"records of the same time: {len(common)}")
        size, watts = largest(steps, 1), largest(steps, 7)
        for row, bent, flown in common:
            check(max(abs(x - y) for x, y in zip(row[1:4], bent[7:10])) < 1e-7 * size, "the load is that of the bending")
            check(max(abs(x - y) for x, y in zip(row[4:7], bent[26:29])) < 1e-7 * size, "so is the mismatch")
            check(max(abs(a - b - c) for a, b, c in zip(row[1:4], flown[1:4], row[4:7])) < 1e-7 * size,
                  "which is the load without the penalization's")
            check(abs(row[8] - bent[29]) < 1e-7 * watts, "and that of the power")
            check(abs(row[7] - flown[13] - row[8]) < 1e-7 * watts, "which is of what the wing gives to the flow")
        check(all(row[9] >= 1 and row[10] == 1 for row in steps), "the work of each step is told")


def test_limit(case):
    """A wing that bends too far stops the run, with a reason and a checkpoint from which it can go on."""
    case.write("run.ini", merged(FLIGHT, {"Flexible_wing": {"largest_deflection": 0.02}}))
    done = case.run("run.ini", code=EXIT_NUMERICAL, ranks=2)
    check("bends beyond the limit" in done.err, "the reason is told")
    check("failed_backup.h5" in done.err, "and where to go on")
    steps = len(table(case, "bending_left.t"))
    before = table(case, "bending_left.t")[-1]
    check(0 < steps < 24, f"it stopped after {steps} steps")
    case.write("run.ini", FLIGHT)
    done = case.run("run.ini", "--restart=failed_backup.h5", ranks=2)
    after = table(case, "bending_left.t")
    check(after[steps - 1] == before and len(after) == 25, "the run has gone on to its end")
    # The wing makes its step again from where it was.
    # Its energies are those of then: the step that went too far is in none of them.
    check(after[steps][21:26] == before[21:26], f"energies: {before[21:26]}, {after[steps][21:26]}")
    check(after[steps][4] == before[4] and after[steps + 1][4] > 0.02, f"bending: {before}, {after[steps:steps + 2]}")


def test_no_solution(case):
    """A wing that Newton's method cannot advance even with the smallest steps stops the run in the same way."""
    case.write("run.ini", merged(FLIGHT, {"Flexible_wing": {"gravity": "0 0 1e12"}}))
    done = case.run("run.ini", code=EXIT_NUMERICAL)
    check("the time step of a wing failed: Newton's method did not converge" in done.err, f"the reason is told:\n{done.err}")
    check("failed_backup.h5" in case.files(), "there is a checkpoint")
    case.write("run.ini", merged(FLIGHT, {"Time": {"nt": 3}}))
    case.run("run.ini", "--restart=failed_backup.h5")


def test_touching(case):
    """Wings that touch or leave the box stop the run; what can be foreseen is said before it begins."""
    near = {"x_pivot_l": "0.0 0.2 0.0", "x_pivot_r": "0.0 -0.2 0.0"}
    case.write("run.ini", merged(FLIGHT, {"Insects": near}))
    done = case.run("run.ini", code=EXIT_NUMERICAL)
    check("the left wing touches the right wing: 0.3" in done.err and "wings are 0.5 L thick" in done.err,
          f"the reason is told:\n{done.err}")
    check("at t = 0.0 the left wing, if it does not bend, touches the right wing: 0.3" in done.out + done.err, "foreseen, too")
    check("the flow has diverged" not in done.err, "not as a flow that has diverged")
    check(not any(name.startswith("failed") for name in case.files()), "no parameter of the mechanics would help")
    images = {"Insects": {"x0": "2.0 1.52 1.0"}, "Geometry": {"yl": 3.04}, "Time": {"nt": 50}}
    case.write("run.ini", merged(FLIGHT, images))
    done = case.run("run.ini", "--overwrite", code=EXIT_NUMERICAL)
    check("beyond a periodic boundary of the box" in done.err, f"images are neighbours, too:\n{done.err}")
    case.write("run.ini", merged(FLIGHT, {"Insects": {"WingThickness": 0.3}}))
    err = case.run("--check", "run.ini", ranks=0).err
    check(err.count("the wings are 2.4 cells thick") == 1, f"thin wings are remarked upon:\n{err}")


def test_leaving(case):
    """A wing that leaves the box stops the run, where that was foreseen and where it is its bending's fault."""
    low = {"Insects": {"x0": "2.0 2.0 0.3"}}
    case.write("run.ini", merged(FLIGHT, low))
    err = case.run("--check", "run.ini", ranks=0, code=EXIT_USER).err
    said = re.search(r"x0: the left wing, if it does not bend, leaves the box at t = (\S+) in the direction z: it "
                     r"reaches from (\S+) to \S+, the box from 0 to 2", err)
    check(said and 0.3 < float(said[1]) < 0.4 and -0.1 < float(said[2]) < 0, f"when and where is told:\n{err}")
    when = float(said[1])
    # Until shortly before that time nothing is wrong; rigid wings go on, as the flow is periodic.
    case.run("--check", merged_file(case, low, {"Time": {"Tmax": when - 0.01, "nt": 1000}}), ranks=0)
    err = case.run("--check", merged_file(case, low, {"Insects": {"wings": "rigid"}}), ranks=0).err
    check(f"at t = {said[1]} the left wing leaves the box" in err and "from the other side" in err, f"a remark:\n{err}")
    # Gravity bends these out of the box; without it they stay inside until the end of the run.
    short = {"Insects": {"x0": "2.0 2.0 0.16"}, "Time": {"nt": 12, "Tmax": 0.048}}
    case.run(merged_file(case, short), ranks=0)
    heavy = {"Flexible_wing": {"gravity": "0 0 -3e5"}}
    err = case.run(merged_file(case, short, heavy), "--overwrite", ranks=2, code=EXIT_NUMERICAL).err
    check(re.search(r"at t = 0\.0\S+ the left wing leaves the box in the direction z: it reaches from -(0\.0|\d\S*e-)", err),
          f"the reason is told:\n{err}")
    check("the velocity" not in err and not any(name.startswith("failed") for name in case.files()), "and no other")


def merged_file(case, *parts):
    sections = FLIGHT
    for part in parts:
        sections = merged(sections, part)
    case.write("other.ini", sections)
    return "other.ini"


def dry(case, **sections):
    return case.run("--dry-run", merged_file(case, sections), ranks=0).out


def test_jerk(case):
    """Flexible wings that have their full speed from the first step on are remarked upon, others not."""
    for ramp, release, jerks in ((0.1, 0, False), (0, 0, True), (0, 0.05, False)):
        parts = {"Insects": {"wing_ramp": ramp}, "Flexible_wing": {"T_release": release}}
        err = case.run("--check", merged_file(case, parts), ranks=0).err
        check(("start with a shock" in err) == jerks, f"ramp {ramp}, release {release}:\n{err}")


def test_foreseen(case):
    """What the parameters say of the stability of a coupling, and of the memory that it takes."""
    words = {"weak": "with weak coupling the load lags", "extrapolated": "compare with coupling = strong",
             "strong": "strong coupling is stable here"}
    for coupling, said in words.items():
        heavy_air = dry(case, units={"density": 12.0}, Flexible_wing={"coupling": coupling})
        check(said in heavy_air, f"{coupling}, a light wing: {said}")
        check(said not in dry(case, Flexible_wing={"coupling": coupling}), f"{coupling}: nothing to say in air")
    # All mass in the veins: the membrane has next to none, and the mask pulls at it all the same.
    bare = {"Mass": {"membrane_mass": 1e-13}}
    check("may exceed 4.00: the coupling may be unstable" in dry(case, **bare), "without a membrane")
    check("unstable" not in dry(case, Flexible_wing={"coupling": "strong"}, **bare), "sub-iterations have no limit")
    check("unstable" not in dry(case), "with a membrane it is stable")
    grid = {"Resolution": {"nx": 128, "ny": 128, "nz": 64}}
    memory = [float(re.search(r"\d+ ranks = 1 x 1 +([\d.]+) MB", dry(case, **grid, **what))[1])
              for what in ({"Saving": {"iSavePress": 1}}, {"Insects": {"wings": "rigid"}, "Saving": {"iSavePress": 1}})]
    # Beyond what a rigid run needs, if both save their pressure: one field to sample from.
    check(abs(memory[0] - memory[1] - 8 * 128 * 128 * 64 / 1e6) < 0.11, f"memory: {memory}")


def write_outboard(case, path):
    """The small wing's file with its points squeezed into the outer 5 of its 9 mm."""
    source = f"{SOURCE}/wings/calliphora_small.h5"
    old = case.raw(source, "points")
    content = Path(source).read_bytes()[:-64]  # without its seal, which would call this damage
    check(content.count(old) == 1, "the points are in one piece")
    flat = list(struct.unpack(f"<{len(old) // 8}d", old))
    flat[::3] = [4e-3 + x * 5 / 9 for x in flat[::3]]
    path.write_bytes(content.replace(old, struct.pack(f"<{len(flat)}d", *flat)))


def test_short_mesh(case):
    """A mesh that begins beyond a quarter of the span is said to have no section there."""
    notice = "the wing has no section at 25 % of its span"
    check(notice not in case.run("--check", merged_file(case), ranks=0).err, "the blowfly's has all")
    wing = case.folder / "short.h5"
    write_outboard(case, wing)
    err = case.run("--check", merged_file(case, {"Wing": {"file": str(wing)}}), ranks=0).err
    check(err.count(notice) == 1, f"it is said:\n{err}")
    run = fly(case, Wing={"file": str(wing)}, Time={"nt": 4})
    rows = table(run, "bending_left.t")
    check(largest(rows, 12) == 0 and largest(rows, 13) == 0 and largest(rows, 15) > 0, "zeros there, not elsewhere")


def test_checked_is_equivalent(case):
    """What --check prints is accepted and means the same."""
    case.write("run.ini", FLIGHT)
    first = case.run("--check", "run.ini")
    case.write("printed.ini", first.out)
    second = case.run("--check", "printed.ini")
    check(sum(line.startswith("  ") for line in first.out.splitlines()) > 100, "keys are printed")
    for a, b in zip(first.out.splitlines(), second.out.splitlines()):
        check(a.split(";")[0] == b.split(";")[0], f"'{a}' is '{b}'")


def refused(case, sections, *sentences):
    """These mistakes and no others."""
    case.write("run.ini", merged(FLIGHT, sections))
    done = case.run("--check", "run.ini", ranks=0, code=EXIT_USER)
    for words in sentences:
        check(done.err.count(words) == 1, f"'{words}' is said:\n{done.err}")
    check(len(done.err.splitlines()) == len(sentences), f"and nothing else:\n{done.err}")


def test_contradictions(case):
    refused(case, {"Wing": {"file": None}}, "[Wing] file: is missing")
    refused(case, {"Wing": {"file": "nosuch.h5"}}, "[Wing] file: ")
    refused(case, {"units": {"density": None}}, "[units] density: is missing")
    refused(case, {"units": {k: None for k in FLIGHT["units"]}}, "[units] length: is missing: the mechanics")
    refused(case, {"Penalization": {"iMask": "sphere"}, "Geometry": {"Size": 1.0}},
            "[Insects] wings: there are no wings to bend")
    refused(case, {"Penalization": {"iPenalization": 0}}, "[Insects] wings: there are no wings to bend")
    refused(case, {"Penalization": {"iMask": "Insct"}}, "[Penalization] iMask: ")
    refused(case, {"Flexible_wing": {"use_flexible_wing_model": "no"}}, "use_flexible_wing_model: contradicts")
    refused(case, {"Flexible_wing": {"use_flexible_wing_model": "yes"}, "Insects": {"wings": "rigid"}},
            "[Insects] wings: contradicts")
    refused(case, {"Flexible_wing": {"T_relase": 0.1}}, "did you mean 'T_release'?")
    refused(case, {"Flexible_wing": {"load_distance": 1.2}}, "load_distance: is more than the length of the wing")
    twice = {"load_distance": 0.6, "load_extrapolated": "yes"}
    refused(case, {"Flexible_wing": twice}, "load_distance: is more than the length of the wing")
    case.run("--check", merged_file(case, {"Flexible_wing": {"load_distance": 0.6}}), ranks=0)
    refused(case, {"Insects": {"wing_length": 1.0}}, "[Insects] wing_length: contradicts")
    case.write("run.ini", merged(FLIGHT, {"Time": {"Tmax": 0.5}, "Flexible_wing": {"T_release": 0.6}}))
    check("T_release is not before Tmax" in case.run("--check", "run.ini").err, "a wing that is never released")


def test_mistakes(case):
    """What is missing or contradicts itself is said in one go."""
    case.write("run.ini", merged(FLIGHT, {"Wing": {"file": None}, "units": {k: None for k in FLIGHT["units"]},
                                          "Insects": {"WingShape": "from_file::x.ini"}}))
    done = case.run("--check", "run.ini", code=EXIT_USER)
    for words in ("[Wing] file: is missing", "[Insects] WingShape: contradicts", "[units] length: is missing"):
        check(words in done.err, f"'{words}' is said")


def reals(case, name, dataset):
    data = case.raw(name, dataset)
    return struct.unpack(f"<{len(data) // 8}d", data)


def test_sides(case):
    """Pressure on both sides of the wings: in the mask what is looked at bends them, one spacing beside the mask; beside wings without
    thickness two and a half."""
    saving = {"iSaveWingSides": "yes", "tsave": 0.02}
    mask = fly(case.sub("mask"), ranks=2, Time={"nt": 5}, Saving=saving)
    thin = fly(case.sub("thin"), ranks=2, Time={"nt": 5}, Saving=saving, Insects={"surface": "thin"})
    for side in ("left", "right"):
        file = f"wing_{side}_000020.h5"
        dorsal, ventral, jump = (reals(mask, file, f"pressure_{what}") for what in ("dorsal", "ventral", "jump"))
        check(largest(zip(jump), 0) > 0, f"the {side} wing bears a load")
        up = 1 if side == "left" else -1  # z of a left wing's frame points to its ventral side
        check(all(j == up * (v - d) for d, v, j in zip(dorsal, ventral, jump)), f"the {side} wing is bent by what is saved")
        check(len(reals(mask, file, "traction_ventral")) == 3 * len(jump), "tractions are vectors")
        for run, spacings in ((mask, 4), (thin, 2.5)):
            check(abs(run.attribute(file, "side_distance")[0] - spacings / 8) < 1e-12, f"{spacings} spacings beside the {side} wing")


def test_words_of_flusi(case):
    """iMask = Flexible_wing with FLUSI's time steppers: the same flight, to the bit."""
    here = fly(case.sub("here"), Time={"nt": 5}, Flexible_wing={"coupling": "strong"})
    theirs = fly(case.sub("theirs"), Time={"nt": 5, "iTimeMethodFluid": "FSI_AB2_iteration"}, Penalization={"iMask": "Flexible_wing"},
                 Flexible_wing={"use_flexible_wing_model": "yes", "EIy": 1e-5}, Insects={"wings": None, "WingShape": "drosophila"})
    for name in ("forces.t", "bending_left.t", "coupling_left.t"):
        check(here.series(name).lines == theirs.series(name).lines, f"{name} is the same")


if __name__ == "__main__":
    main(globals())
