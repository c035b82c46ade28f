#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole runs with wings without thickness, rigid and flexible: restart to the bit, ranks, mirror images, mistakes.

usage: flusi_thin.py <flusi> <h5dump> [tests]

The grids are far too coarse for physics; what is tested is that parts fit together.
"""
import re
import struct
import subprocess

from flusi_flexible import FLIGHT, SIDED, table
from flusi_wing import BEAT, LAST_DIGIT, ROUND_OFF, SERIES, WING, make, restarted, steps
from whole_program import EXIT_NUMERICAL, EXIT_USER, check, close, main, merged, same_checkpoints

THIN = merged(WING, {"Insects": {"surface": "thin", "slip_interval": 1}, "Time": {"CFL": 0.4}})


def test_rigid_restart(case):
    """Wings without thickness: a restart gives the same digits, and a checkpoint knows what surface it belongs to."""
    _, parts = restarted(case, THIN)
    parts.write("run.ini", merged(WING, steps(20)))
    done = parts.run("run.ini", "--restart", code=EXIT_USER)
    check("surface = thin" in done.err, f"another surface is refused: {done.err}")


def test_rigid_ranks(case):
    """Wings without thickness: the same numbers on any number of ranks, and the flow follows the wings."""
    one = make(case.sub("ranks_1"), THIN, 1)
    last = max(n for n in one.files() if n.startswith("ux_"))
    for ranks, rows in ((2, 2), (3, 1), (4, 2)):
        other = make(case.sub(f"ranks_{ranks}"), merged(THIN, {"Resolution": {"process_rows": rows}}), ranks)
        for name in (*SERIES, "slip.t"):
            a, b = one.series(name).rows, other.series(name).rows
            check(len(a) == len(b) > 3, f"{name} has the same records on {ranks} ranks")
            for p, q in zip(zip(*a), zip(*b)):
                close(p, q, LAST_DIGIT, f"a column of {name}")
        for prefix in ("ux", "uy", "uz"):
            name = last.replace("ux", prefix)
            close(one.field(name), other.field(name), ROUND_OFF, name)
    # What is left after the forces comes from the response, which is exact to a few per cent of what they had to do on
    # so coarse a grid.
    for _, after, before, *_ in one.series("slip.t").rows:
        check(after < 0.1 * before, f"the forces take the slip from {before} to {after}")
    follows(one, WING["Insects"]["wing_ramp"])
    for left, right in zip(one.series("wing_left.t").rows, one.series("wing_right.t").rows):
        close([left[1], -left[2], left[3]], right[1:4], 1e-7, "the wings are mirror images")


def follows(run, since):
    """From the time `since` on, after the ramp, the slip after every step is at most 2 % of the speed that the wings reach."""
    rows = [row for row in run.series("slip.t").rows if row[0] > since]
    speed = max(row[3] for row in rows)
    check(len(rows) > 3, f"the wings fly on after their ramp: {len(rows)} steps")
    check(max(row[1] for row in rows) <= 0.02 * speed, f"the flow follows: {[row[1] / speed for row in rows]}")


def test_end(case):
    """The end is shared by the last two steps: in a tiny one what is left of the slip would be a large force."""
    make(case, merged(THIN, {"Time": {"nt": 1000, "Tmax": 0.15}, "Saving": {"tintegral": 1e-9, "tsave": 9}}), 1)
    steps = [row[1] for row in case.series("dt.t").rows]
    check(min(steps[-2:]) > 0.4 * steps[-3], f"none is tiny: {steps[-3:]}")
    force = [row[3] for row in case.series("forces.t").rows]
    check(abs(force[-1] - force[-2]) < 0.2 * max(map(abs, force)), f"nor is the force another: {force[-3:]}")


def test_damping(case):
    """The vanishing viscosity is the motion's: a run to a later end has the same."""
    found = []
    for end in (3.0, 40.0):
        case.write("beat.ini", BEAT)
        case.write("run.ini", merged(THIN, {"Time": {"nt": 1, "Tmax": end}, "Insects": {"BodyMotion": "casting"},
                                            "ReynoldsNumber": {"nu": 1e-4}}))
        found += re.findall(r"the largest wavenumber at (\S+) per T", case.run("run.ini", "--overwrite").out)
    check(len(found) == 2 and found[0] == found[1] != "0.00", f"the same rate: {found}")


def test_slip_interval(case):
    """The slip is measured in the same steps by a run in parts, in those whose number is a multiple, and no step depends on it."""
    every = make(case.sub("every"), merged(THIN, steps(8)), 2)
    third = merged(THIN, {"Insects": {"slip_interval": 3}})
    whole = make(case.sub("whole"), merged(third, steps(8)), 2)
    parts = make(case.sub("parts"), merged(third, steps(4)), 2)
    parts.write("run.ini", merged(third, steps(8)))
    parts.run("run.ini", "--restart", ranks=2)
    rows = every.series("slip.t").rows
    check(len(rows) == 8, f"all steps are measured: {len(rows)}")
    for run in (whole, parts):
        check(run.series("slip.t").rows == [rows[2], rows[5]], f"the third and the sixth step are: {run.series('slip.t').rows}")
        for name in ("forces.t", "dt.t"):
            check(run.series(name).lines == every.series(name).lines, f"{name}: the last digit")
        last = max(n for n in every.files() if n.startswith("ux_"))
        check(run.field(last) == every.field(last), f"{last}: to the bit")
    same_checkpoints(whole, whole.newest_checkpoint(), parts, parts.newest_checkpoint())


def test_slip_unknown(case):
    """A summary whose last beat has no rows of slip.t, or no file with rows, says so."""
    beats = merged(THIN, {"Time": {"nt": 1000, "Tmax": 3.0, "dt_fixed": 0.02}, "Saving": {"tsave": 9.0, "tintegral": 0.02}})
    for interval in (80, 900):
        run = make(case.sub(f"every_{interval}"), merged(beats, {"Insects": {"slip_interval": interval}}), 2)
        check(len(run.series("slip.t").rows) == 150 // interval, "few rows")
        text = (run.folder / "summary.txt").read_text()
        check("slip        was not measured in the last beat" in text, f"interval {interval} is told: {text}")
        check("%" not in text and "balance" not in text, f"nothing is made of no rows: {text}")


def test_rigid_mistakes(case):
    """What wings without thickness cannot do is refused by its key."""
    case.write("beat.ini", BEAT)
    for section, key, value in (("Time", "iTimeMethodFluid", "RK4"), ("Dealiasing", "iDealias", 0),
                                ("Insects", "marker_spacing", 1.0)):
        case.write("run.ini", merged(THIN, {section: {key: value}}))
        done = case.run("run.ini", "--check", code=EXIT_USER)
        check(key in done.err, f"{key} is named: {done.err}")


BENT = merged(FLIGHT, {"Insects": {"surface": "thin", "slip_interval": 1}, "Time": {"nt": 12}, "Saving": {"tintegral": 4e-3},
                       "Wing": {"E": 2e9}})
BENT_SERIES = ("forces.t", "bending_left.t", "bending_right.t", "wing_right.t", "coupling_left.t", "slip.t")


def fly(case, ranks=1, **sections):
    case.write("run.ini", merged(BENT, sections))
    case.run("run.ini", ranks=ranks)
    return case


def same_flights(whole, parts, name):
    same_checkpoints(whole, whole.newest_checkpoint(), parts, parts.newest_checkpoint())
    for series in BENT_SERIES:
        check(whole.series(series).lines == parts.series(series).lines, f"{name}, {series}: the last digit")
    check(max(abs(row[4]) for row in table(whole, "bending_left.t")) > 0, f"{name}: the wing bends")


def go_on(run, nt, **sections):
    run.write("run.ini", merged(merged(BENT, {"Time": {"nt": nt}}), sections))
    run.run("run.ini", "--restart", ranks=2)


def test_flexible_restart(case):
    """A flight in parts is one in a piece, to the bit, with the strong coupling and with wings that are released after the
    restart."""
    for name, coupling, first, end in (("strong", {"coupling": "strong"}, 7, 9), ("held", {"T_release": 0.018}, 3, 8)):
        whole = fly(case.sub(name), 2, Flexible_wing=coupling, Time={"nt": end})
        parts = fly(case.sub(f"{name}_parts"), 2, Flexible_wing=coupling, Time={"nt": first})
        go_on(parts, end, Flexible_wing=coupling)
        same_flights(whole, parts, name)
        check(all((row[10] > 1) == (name == "strong") for row in table(whole, "coupling_left.t")[2:]), "passes are told")


def test_response(case):
    """The response belongs to the shape for which it was made: after a restart between two such shapes the flight goes on
    to the bit. With a larger limit the first shape serves longer."""
    small, soft = {"dt_fixed": 2e-3, "nt": 24}, {"E": 2e8}
    whole = fly(case.sub("whole"), 2, Time=small, Wing=soft)
    parts = fly(case.sub("parts"), 2, Time={**small, "nt": 22}, Wing=soft)
    shape = made_for(parts)
    start = made_for(fly(case.sub("start"), 2, Time={**small, "nt": 1}, Wing=soft))
    check(shape != start, "it was made for a bent wing")
    patient = fly(case.sub("patient"), 2, Time={**small, "nt": 22}, Wing=soft, Insects={"marker_response_limit": 0.4})
    check(made_for(patient) == start, "a larger limit keeps the first one")
    go_on(parts, 24, Time={"dt_fixed": 2e-3}, Wing=soft)
    check(shape == made_for(parts), "and not made anew in the last steps")
    same_flights(whole, parts, "small steps")


def made_for(run):
    done = subprocess.run([run.h5dump, "-d", "marker_shape", run.folder / run.newest_checkpoint()], check=True,
                          capture_output=True, text=True)
    return done.stdout.split("DATA", 1)[1]


def test_flexible_ranks(case):
    """The same flight on any number of ranks: each wing has its owner, and the grid is cut both ways. On five ranks groups of
    three and two share the responses. Places and flow agree to 1e-12, although Newton's method leaves 1e-8 of the forces: its
    iterations are the same on all ranks."""
    fields = {"Saving": {"iSaveVelocity": "yes", "iSavePress": "yes", "field_precision": "double"}}
    one = fly(case.sub("n1"), **fields)
    last = max(n for n in one.files() if n.startswith("ux_"))
    for ranks, rows, response in ((2, 2, "group"), (3, 1, "auto"), (4, 2, "auto"), (5, 1, "group")):
        sections = {"Resolution": {"process_rows": rows}, "Insects": {"marker_response": response}, **fields}
        other = fly(case.sub(f"n{ranks}"), ranks, **sections)
        for prefix in ("ux", "uy", "uz", "p"):
            name = last.replace("ux", prefix)
            close(one.field(name), other.field(name), ROUND_OFF, f"{name} on {ranks} ranks")
        for name in ("left_u", "left_v", "right_u", "right_v"):
            a, b = (struct.unpack(f"<{len(raw) // 8}d", raw) for raw in
                    (run.raw(run.newest_checkpoint(), name) for run in (one, other)))
            # Velocities are differences of displacements over a step, which here are ten times smaller.
            close(a, b, (10 if name.endswith("_v") else 1) * ROUND_OFF, f"{name} on {ranks} ranks", floor=1e-9)
        for name in BENT_SERIES:
            a, b = table(one, name), table(other, name)
            check(len(a) == len(b) >= 12, f"{name} has the same records on {ranks} ranks")
            for p, q in zip(zip(*a), zip(*b)):
                # The y forces of mirror images cancel; Newton's method stops at 1e-8 of the forces.
                size = max(abs(x) for x in p)
                worst = max(abs(x - y) for x, y in zip(p, q))
                check(worst <= LAST_DIGIT * size + 1e-9, f"{name} on {ranks} ranks: {worst} of {size}")


def test_flexible_mirror(case):
    """Wings that tell up from down do the same on both sides, to whichever side z points."""
    run = fly(case, 2, **merged(SIDED, {"Wing": {"z_side": "right dorsal"}}))
    left, right = table(run, "bending_left.t"), table(run, "bending_right.t")
    check(max(abs(row[3]) for row in left) > 1e-3, "the wings bend")
    for a, b in zip(left, right):
        check(abs(a[3] + b[3]) < 1e-7 and abs(a[1] - b[1]) < 1e-7, f"mirror images at t = {a[0]}")


def test_power(case):
    """The flow receives the power that the wings lose, but for the slip; the summary says so."""
    beat = {"Time": {"nt": 10000, "Tmax": 1.0, "dt_fixed": 0.01}, "Wing": {"E": 12.58e9}, "Saving": {"tintegral": 0.01}}
    text = (fly(case, 2, **beat).folder / "summary.txt").read_text()
    ratio = float(re.search(r"the wings lose is (\S+) of the power that the flow receives", text).group(1))
    check(0.98 < ratio < 1.02, f"the power is balanced: {ratio}")
    check("should be equal" not in text, f"and the summary does not warn: {text}")
    follows(case, 3 * FLIGHT["Insects"]["wing_ramp"])  # until 2.2 ramps the wings swing back from their start
    rows = table(case, "slip.t")
    received = [row[4] for row in rows]
    for interval in (7, 10):
        few = rows[interval - 1::interval]
        ratio = sum(row[7] for row in few) / sum(row[4] for row in few)
        check(0.98 < ratio < 1.02, f"also in every {interval}th step: {ratio}")
    lost = [row[13] for row in table(case, "forces.t")][1:]  # the loads at the end of a step are known when the next begins
    size = max(abs(x) for x in lost)
    check(len(lost) == len(rows) - 1 or len(lost) == len(rows), f"both have every step: {len(lost)}, {len(rows)}")
    for known, row in zip(lost, rows):
        check(abs(known - row[7]) < 1e-7 * size, f"slip.t has the loss of forces.t at t = {row[0]}: {row[7]}, {known}")
    worst = max(abs(a - b) for a, b in zip(lost, received))
    check(worst < 0.1 * size, f"in every step: {worst} of {size}")


def test_failed_backup(case):
    """Flexible wings that bend too far leave a checkpoint, from which the run goes on as the message says."""
    case.write("run.ini", merged(BENT, {"Flexible_wing": {"largest_deflection": 0.02}, "Time": {"nt": 40}}))
    done = case.run("run.ini", ranks=2, code=EXIT_NUMERICAL)
    check("bends beyond the limit" in done.err and "--restart=failed_backup.h5 continues" in done.err,
          f"the program says why it stopped and how to continue:\n{done.err}")
    before = len(table(case, "bending_left.t"))
    case.write("run.ini", merged(BENT, {"Time": {"nt": 40}}))
    case.run("run.ini", "--restart=failed_backup.h5", ranks=2)
    after = table(case, "bending_left.t")
    check(len(after) > before, f"the run goes on: {before}, {len(after)} records")
    check(max(abs(row[4]) for row in after) < 1, "and the wings stay wings")
    rows = case.series("slip.t").rows[-5:]
    check(all(row[1] < 0.1 * row[3] for row in rows), f"the flow follows the wings again: {rows}")


def test_flexible_gap(case):
    """Flexible wings that come closer than a grid spacing stop the run, which says what to do. It foresees this of unbent wings."""
    fly(case.sub("apart"), 2, Insects={"x_pivot_l": "0.0 0.08 0.0", "x_pivot_r": "0.0 -0.08 0.0"}, Time={"nt": 2})
    case.write("run.ini", merged(BENT, {"Insects": {"x_pivot_l": "0.0 0.05 0.0", "x_pivot_r": "0.0 -0.05 0.0"}}))
    done = case.run("run.ini", ranks=2, code=EXIT_NUMERICAL)
    reason = ("too close to the right wing: 0.08472 L are between them, and the flow cannot enter a gap below a grid "
              "spacing, 0.125 L")
    check(f"the left wing comes {reason}: set a larger distance" in done.err, f"the reason and what to do are told:\n{done.err}")
    check(f"the left wing, if it does not bend, comes {reason}" in done.out + done.err, "foreseen, too")


def test_flexible_keys(case):
    """Keys of the load beside the wings have no effect, which is told."""
    case.write("run.ini", merged(BENT, {"Flexible_wing": {"load_distance": 0.3, "load": "pressure_viscous"}}))
    done = case.run("run.ini", "--check")
    for key in ("load_distance", "load"):
        check(f"[Flexible_wing] {key} has no effect" in done.err + done.out, f"{key} is named: {done.err}")


if __name__ == "__main__":
    main(globals())
