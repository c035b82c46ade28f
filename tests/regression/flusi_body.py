#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole runs with a body beside the wings: ranks, restart to the bit, forces by colour, momentum, the sphere, mistakes.

usage: flusi_body.py <flusi> <h5dump> [tests]

The grids are far too coarse for physics; what is tested is that parts fit together.
"""
import math

from flusi_flexible import FLIGHT
from flusi_wing import BEAT, WING, make, restarted, same_on_ranks, steps
from whole_program import EXIT_USER, check, close, main, merged

BODY = merged(WING, {
    "Insects": {"BodyType": "drosophila_maeda", "BodyMotion": "pitch", "x_pivot_l": "0.05 0.2165 0.0", "WingShape": "bumblebee",
                "x_pivot_r": "0.05 -0.2165 0.0", "Jxx": None, "Jyy": None, "wing_length": None},
    "Saving": {"tsave": 9, "tintegral": 1e-9},
})
THIN = {"Insects": {"surface": "thin", "slip_interval": 1}, "Time": {"CFL": 0.4}}
STILL = {"MeanFlow": {"iMeanFlow_x": "free", "iMeanFlow_y": "free", "iMeanFlow_z": "free"}, "Sponge": {"iVorticitySponge": "no"}}


def check_parts(run):
    """Force and power of body and wings are those of all."""
    for whole, *parts in zip(*(run.series(f"forces{n}.t").rows for n in ("", "_part1", "_part2", "_part3"))):
        for columns in (range(1, 4), range(4, 7), (13,)):
            close([whole[c] for c in columns], [sum(p[c] for p in parts) for c in columns], 1e-7, "body and wings are all")


def check_momentum(run, lengths):
    """What the flow loses of its momentum the body and the wings feel: d/dt of the mean flow is -F/volume. The difference of
    two records is that of Adams-Bashforth, 3/2 of the force of a step minus 1/2 of the one before."""
    volume = lengths[0] * lengths[1] * lengths[2]
    flow, forces = run.series("meanflow.t").rows, run.series("forces.t").rows
    for n in range(2, len(flow) - 1):
        dt = flow[n + 1][0] - flow[n][0]
        before = flow[n][0] - flow[n - 1][0]
        for axis in (1, 2, 3):
            force = forces[n][axis] + dt / before / 2 * (forces[n][axis] - forces[n - 1][axis])
            scale = max(abs(f[axis]) for f in forces)
            check(abs((flow[n + 1][axis] - flow[n][axis]) / dt * volume + force) < 1e-4 * scale,
                  f"record {n}, axis {axis}: {(flow[n + 1][axis] - flow[n][axis]) / dt * volume} is not {-force}")


def test_ranks(case):
    run = same_on_ranks(case, merged(BODY, STILL), 3, "forces_part1.t")
    check_parts(run)
    check_momentum(run, (4, 4, 2))
    check(any(abs(row[13]) > 1e-6 for row in run.series("forces_part1.t").rows), "a body that pitches gives power to the flow")


def test_thin(case):
    run = same_on_ranks(case, merged(merged(BODY, STILL), THIN), 2, "forces_part1.t")
    check_parts(run)


FLEXIBLE = merged(FLIGHT, {**STILL, "Insects": {"BodyType": "ellipsoid", "L_body": 0.8, "b_body": 0.15}, "Wing": {"E": 2e9},
                           "MeanFlow": {"iMeanFlow": None, **{f"iMeanFlow_{axis}": "free" for axis in "xyz"}},
                           "Time": {"nt": 10}, "Saving": {"tsave": 9, "tintegral": 1e-9}})


def flown(case, ini, *parts, ranks=1):
    """A run in parts of so many steps, each the restart of the one before."""
    for number, nt in enumerate(parts):
        case.write("run.ini", merged(ini, steps(nt)))
        case.run("run.ini", *(["--restart"] if number else []), ranks=ranks)
    return case


def same_in_parts_and_on_ranks(case, ini, *names):
    """Restart to the bit, and the same numbers on two ranks but for their last digit. Returns the run on one."""
    whole, parts, two = flown(case.sub("whole"), ini, 10), flown(case.sub("parts"), ini, 6, 10), flown(case.sub("two"), ini, 10, ranks=2)
    for name in ("forces.t", "forces_part1.t", "bending_left.t", "wing_right.t", "meanflow.t", *names):
        check(whole.series(name).lines == parts.series(name).lines, f"{name}: restart to the last digit")
        a, b = whole.series(name).rows, two.series(name).rows
        check(len(a) == len(b) > 9, f"{name} has the same records on two ranks")
        for p, q in zip(zip(*a), zip(*b)):
            close(p, q, 2e-8, f"a column of {name}")
    check(max(abs(row[1]) for row in whole.series("bending_left.t").rows) > 1e-4, "the wing bends")
    return whole


def test_flexible_thin(case):
    """Flexible wings without thickness beside a body in the mask. The flow loses in a step the force of the markers in it and
    that of the body, with the weights of Adams-Bashforth."""
    run = same_in_parts_and_on_ranks(case, merged(FLEXIBLE, {"Insects": {"surface": "thin"}}))
    check_parts(run)
    flow, body = run.series("meanflow.t").rows, run.series("forces_part1.t").rows
    wings = [run.series(f"forces_part{n}.t").rows for n in "23"]
    for axis in (1, 2, 3):
        scale = max(abs(row[axis]) for rows in (body, *wings) for row in rows)
        for n in range(2, len(flow)):
            dt = flow[n][0] - flow[n - 1][0]
            force = 1.5 * body[n - 1][axis] - 0.5 * body[n - 2][axis] + sum(rows[n][axis] for rows in wings)
            change = 32 * (flow[n][axis] - flow[n - 1][axis]) / dt
            check(abs(change + force) < 1e-5 * scale, f"record {n}, axis {axis}: {change} is not {-force}")


def test_flexible_free(case):
    """Flexible wings in the mask on a body that flies: momentum of insect and flow changes by the weight alone."""
    ini = merged(FLEXIBLE, {"Insects": {"BodyMotion": "free_flight", "mass": 50.0, "gravity": -0.05, "J_body_yawpitchroll": "4.0 4.0 3.0"},
                            "Flexible_wing": {"coupling": "weak"}, "Time": {"dt_fixed": 2.5e-3}})
    run = same_in_parts_and_on_ranks(case, ini, "rigidsolidsolver.t", "free_flight.t")
    rows = [(a[0], [a[16 + i] + 32 * b[1 + i] for i in range(3)]) for a, b in zip(run.series("free_flight.t").rows,
                                                                                 run.series("meanflow.t").rows)]
    for time, momentum in rows:
        check(max(abs(p - q - w * time) for p, q, w in zip(momentum, rows[0][1], (0, 0, -2.5))) < 1e-6, f"{momentum} at {time}")


def test_covered(case):
    """Wings without thickness inside a body at rest, where the mask is 1, are part of it."""
    ini = merged(merged(BODY, STILL), THIN)
    ini = merged(ini, {"Insects": {"BodyType": "sphere", "L_body": 1.9, "BodyMotion": "tethered", "wing_length": 0.4,
                                   "WingShape": WING["Insects"]["WingShape"]}})
    run = make(case, ini, 1)
    for side in ("2", "3"):
        rows = run.series(f"forces_part{side}.t").rows
        check(len(rows) > 3 and not any(any(row[1:14]) for row in rows), "a wing inside the body has no force, moment and power")


def test_restart(case):
    restarted(case, BODY, ranks=2)
    restarted(case.sub("thin"), merged(BODY, THIN), ranks=2)


def test_soft_wings(case):
    """`wing_edges = flusi` draws wings thinner than their step as FLUSI does, with chi up to 0.96 for 1.5 cells; otherwise the
    step is narrower, and chi reaches 1 where a point lies in the wing."""
    ini = merged(BODY, {"Insects": {"BodyType": None, "BodyMotion": None, "WingShape": "rectangular", "b_top": 0.2, "b_bot": 0.3,
                                    "L_span": 0.8, "WingThickness": "1.5*dx", "RightWing": "no"},
                        "DryRun": {"dry_run_without_fluid": "yes"},
                        "Saving": {"iSaveMask": "yes", "field_precision": "double"}})
    most = (1 + math.cos(math.pi / 8)) / 2  # half a cosine from 0.25 cells beyond its middle
    for name, edges, low, high in (("soft", "flusi", most - 0.02, most), ("auto", "auto", 0.99, 1)):
        run = make(case.sub(name), merged(ini, {"Insects": {"wing_edges": edges}}), 2)
        top = max(run.field("mask_000000.h5"))
        check(low <= top <= high + 1e-12, f"{name}: chi is at most {high}, not {top}")


def test_corrugated(case):
    """Wings with a relief: in the mask they are mirror images of each other and no flat ones; without thickness they fly, too."""
    (case.folder / "w.ini").write_text(
        "[Wing]\ntype=fourier;\na0_wings=0.6;\nai_wings=0.0;\nbi_wings=0.0;\nx0w=-0.1;\ny0w=0.5;\ncorrugated=yes;\n"
        "corrugation_profile=(/0.0 0.3\n0.2 -0.1\n0.0 0.3/)\nwing_thickness_distribution=variable;\n"
        "wing_thickness_profile=(/0.2 0.3\n0.4 0.3/)\n")
    ini = merged(BODY, {"Insects": {"BodyType": None, "BodyMotion": None, "WingShape": f"from_file::{case.folder}/w.ini", "wing_ramp": 0.0},
                        "Saving": {"iSaveMask": "yes", "tsave": 0.05, "field_precision": "double"}, "Time": {"nt": 4, "CFL": 0.4}})
    dry = make(case.sub("dry"), merged(ini, {"DryRun": {"dry_run_without_fluid": "yes"}, "Time": {"nt": None, "Tmax": 0.1}}), 2)
    for name in ("mask_000000.h5", "mask_000100.h5"):
        mask = dry.field(name)
        rows = [mask[32 * n:32 * (n + 1)] for n in range(32 * 16)]  # x of (y, z)
        for z in range(16):
            for y in range(1, 32):
                close(rows[y + 32 * z], rows[(32 - y) + 32 * z], 1e-12, "left and right wing")
    check(len({x for x in dry.field("mask_000000.h5") if x > 0}) > 50, "there are wings")
    thin = make(case.sub("thin"), merged(ini, {"Insects": {"surface": "thin", "slip_interval": 1}}), 1)
    done = thin.run("run.ini", "--check")
    check("has a variable thickness, which counts only" in done.out + done.err, f"what does not count is told: {done.err}")
    check(len(thin.series("slip.t").rows) > 1, "wings without thickness fly")


PLATES = {"Insects": {"BodyType": None, "BodyMotion": None, "WingShape": "rectangular", "L_span": 0.8, "b_top": 0.2, "b_bot": 0.3,
                      "wing_ramp": 0.0},
          "Geometry": {"Size": 0.9, "x0": 0.2, "y0": 2.0, "z0": 1.0}}


def check_obstacle(run):
    """All parts are there, and what the flow loses of its momentum all feel: the plates in the step, the obstacle by
    Adams-Bashforth."""
    flow, left, right, body, total = (run.series(f"{name}.t").rows for name in
                                      ("meanflow", "forces_part2", "forces_part3", "forces_part4", "forces"))
    wing = [[a + b for a, b in zip(*rows)] for rows in zip(left, right)]
    check(max(abs(row[1]) for row in body) > 0.1, "the stream pushes the obstacle")
    for n in range(2, len(flow) - 1):
        dt, before = flow[n + 1][0] - flow[n][0], flow[n][0] - flow[n - 1][0]
        scale = max(abs(x) for row in total for x in row[1:4])
        for axis in (1, 2, 3):
            check(abs(total[n][axis] - wing[n][axis] - body[n][axis]) < 1e-7 * scale, "all parts are there")
            force = body[n][axis] + dt / before / 2 * (body[n][axis] - body[n - 1][axis]) + wing[n + 1][axis]
            change = (flow[n + 1][axis] - flow[n][axis]) / dt * 4 * 4 * 2
            check(abs(change + force) < 1e-4 * scale, f"record {n}, axis {axis}: {change} is not {-force}")


def test_obstacle(case):
    """A sphere or a cylinder at rest beside plates without thickness: the same on several numbers of ranks and after a restart,
    and a balance of momentum."""
    free = merged(merged(merged(BODY, {**STILL, "InitialCondition": {"inicond": "MeanFlow"}}), THIN), PLATES)
    ini = merged(free, {"Penalization": {"obstacle": "sphere"}})
    run = same_on_ranks(case.sub("two"), ini, 2, "forces_part4.t")
    check_obstacle(run)
    sphere = max(abs(row[1]) for row in run.series("forces_part4.t").rows)
    same_on_ranks(case.sub("three"), ini, 3, "forces_part4.t")
    restarted(case.sub("again"), ini)
    run = same_on_ranks(case.sub("cylinder"), merged(free, {"Penalization": {"obstacle": "cylinder"}}), 2, "forces_part4.t")
    check_obstacle(run)
    cylinder = max(abs(row[1]) for row in run.series("forces_part4.t").rows)
    # The first force is the momentum of the stream in the body over eps. Of the volumes the mask's smooth step changes 4 %.
    check(abs(cylinder / sphere / (1.5 * 2 / 0.9) - 1) < 0.1, f"the cylinder reaches through the box: {cylinder}, {sphere}")
    for name, keys, words in (("flow", {"Penalization": {"iMask": "sphere"}}, "obstacle: needs an insect"),
                              ("size", {"Geometry": {"Size": 0.0}}, "Size: the body needs a size"),
                              ("free", {"Insects": {"BodyMotion": "free_flight", "mass": 1.0}}, "obstacle: needs an insect that")):
        case.write(f"{name}.ini", merged(ini, keys))
        case.write("beat.ini", BEAT)
        done = case.run(f"{name}.ini", "--check", code=EXIT_USER)
        check(words in done.err, f"{name}: {words!r} is told, not {done.err}")


def test_walls(case):
    """A cylinder and a wall, or the walls of a cavity, beside plates without thickness: the same on two ranks and after a restart.
    Walls are no body: forces are those of the plates and the cylinder. They hold the flow."""
    ini = merged(merged(merged(BODY, {"Sponge": STILL["Sponge"], "InitialCondition": {"inicond": "MeanFlow"}}), THIN), PLATES)
    ini = merged(ini, {"Penalization": {"obstacle": "cylinder"}, "Saving": {"iSaveVelocity": "yes"}})
    for name, keys, walls in (("channel", {"iChannel": "xy", "thick_wall": 0.25, "pos_wall": 0.25}, (0, 1, 2)),
                              ("cavity", {"iCavity": "yes", "cavity_size": 2}, (0, 1, 14, 15))):
        walled = merged(ini, {"Penalization": keys})
        run = same_on_ranks(case.sub(name), walled, 2, "forces_part4.t")
        for total, *parts in zip(*(run.series(f"forces{part}.t").rows for part in ("", "_part2", "_part3", "_part4"))):
            for axis in (1, 2, 3):
                close([total[axis]], [sum(part[axis] for part in parts)], 1e-7, "plates and cylinder have the whole force", floor=1)
        u = run.field(max(file for file in run.files() if file.startswith("ux_")))
        layers = [sum(abs(x) for x in u[32 * 32 * z:32 * 32 * (z + 1)]) / 32**2 for z in range(16)]
        # A truncated jump overshoots by 9 % of it, on both sides, and walls of two points have both of them.
        check(all((speed < 0.25 * max(layers)) == (z in walls) for z, speed in enumerate(layers)),
              f"{name}: the flow rests in the walls: {layers}")
        restarted(case.sub(f"{name}_again"), walled)


def test_edges(case):
    """A Fourier outline of a file is FLUSI's wing: in the mask it ends at its outline, with the volume area times thickness;
    so does any flat wing with `round`, but for its edge. The same wing reaches farther with `beyond`."""
    radius, dx, box = 0.3, 4.0 / 32, 4.0 * 4.0 * 2.0
    (case.folder / "w.ini").write_text(f"[Wing]\ntype=fourier;\na0_wings={2 * radius};\nai_wings=0.0;\nbi_wings=0.0;\n"
                                       "x0w=0.0;\ny0w=0.4;\n")
    ini = merged(BODY, {"Insects": {"BodyType": None, "BodyMotion": None, "WingShape": f"from_file::{case.folder}/w.ini",
                                    "RightWing": "no", "WingThickness": 2 * dx, "wing_length": None},
                        "DryRun": {"dry_run_without_fluid": "yes"}, "Saving": {"iSaveMask": "yes", "field_precision": "double"}})
    flat = math.pi * radius**2 * 2 * dx
    shares = {}
    for edges in ("auto", "flusi", "round", "beyond"):
        run = make(case.sub(edges), merged(ini, {"Insects": {"wing_edges": edges}}), 2)
        mask = run.field("mask_000000.h5")
        shares[edges] = sum(mask) / len(mask) * box / flat
    check(abs(shares["auto"] - 1) < 0.03 and shares["auto"] == shares["flusi"], f"area times thickness: {shares}")
    core, r = radius - dx, dx
    inside = (2 * math.pi * core**2 * r + math.pi**2 * r**2 * core + 4 / 3 * math.pi * r**3 +
              (math.pi**2 * core + 4 * math.pi * r) * dx**2 * (1 - 8 / math.pi**2)) / flat
    check(abs(shares["round"] / inside - 1) < 0.05, f"with a round edge {inside}: {shares}")
    check(shares["beyond"] > 1.5, f"beyond it more: {shares}")
    for name, keys, words in (("told", {"wing_edges": "round"}, "wing_edges: is round: the round edges end at the outline of the wing; set beyond"),
                              ("thin", {"wing_edges": "beyond", "surface": "thin", "WingThickness": None}, "wing_edges: has no effect"),
                              ("auto", {}, "")):
        case.write("beat.ini", BEAT)
        case.write(f"{name}.ini", merged(ini, {"Insects": keys, "DryRun": {"dry_run_without_fluid": None}, "Saving": {"iSaveMask": "no"}}))
        told = case.run(f"{name}.ini", "--check").err
        check(words in told if words else "wing_edges" not in told, f"{name}: {words!r} is told, not {told}")


def test_sphere(case):
    """The body called sphere without wings is the sphere of iMask, with its smoothing."""
    flow = merged(WING, {**STILL, "MeanFlow": {"iMeanFlow_x": "fixed", "ux": 1.0}})
    flow["Insects"] = {}
    mask = merged(flow, {"Penalization": {"iMask": "sphere", "iMoving": "no"},
                         "Geometry": {"Size": 0.9, "x0": 2.0, "y0": 2.0, "z0": 1.0}, "Saving": {"tsave": 9, "tintegral": 1e-9}})
    body = merged(flow, {"Insects": {"BodyType": "sphere", "L_body": 0.9, "LeftWing": "no", "RightWing": "no",
                                     "x0": "2.0 2.0 1.0", "body_smoothing": "1.5*dx"},
                         "Saving": {"tsave": 9, "tintegral": 1e-9}})
    a, b = make(case.sub("mask"), mask, 2), make(case.sub("body"), body, 2)
    rows = [run.series("forces.t").rows for run in (a, b)]
    check(len(rows[0]) == len(rows[1]) == 17, "the same number of records")
    for p, q in zip(*(list(zip(*r))[1:4] for r in rows)):
        close(p, q, 1e-9, "the force on the sphere")


def test_mistakes(case):
    case.write("beat.ini", BEAT)
    case.write("open.stl", "solid x\n" + "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
               "endloop\nendfacet\n" * 4 + "endsolid\n")
    for name, keys, words in (("open", {"BodyType": "from_file::open.stl"}, "open.stl"),
                              ("missing", {"BodyType": "from_file::gone.stl"}, "does not exist"),
                              ("profile", {"BodyType": "revolution"}, "body_profile: is missing"),
                              ("large", {"BodyType": "sphere", "L_body": 5.0}, "larger than the box"),
                              ("edges", {"WingShape": WING["Insects"]["WingShape"], "wing_length": 1.0,
                                         "wing_edges": "flusi"}, "wing_edges: is flusi"),
                              ("nothing", {"BodyType": "nobody", "LeftWing": "no", "RightWing": "no"}, "neither a wing nor a body")):
        case.write(f"{name}.ini", merged(BODY, {"Insects": keys}))
        done = case.run(f"{name}.ini", "--check", code=EXIT_USER)
        check(words in done.err, f"{name}: {words!r} is told, not {done.err}")


if __name__ == "__main__":
    main(globals())
