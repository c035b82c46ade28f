#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""flusi --solid: free vibration as the modes and BDF2 say, exact restarts, rest under a load as in statics.

usage: flusi_solid.py <flusi> <h5dump> [tests]
"""
import math
import re
import shutil

from whole_program import (
    EXIT_NUMERICAL,
    EXIT_OK,
    EXIT_STOPPED,
    EXIT_UNWRITABLE,
    EXIT_USER,
    SOLID_REFERENCE,
    SOURCE,
    TRAIN_REFERENCE,
    check,
    live_keys,
    main,
    merged,
    same_checkpoints,
)

WING = SOURCE / "wings/calliphora_small.h5"
COLUMNS = ("time tip_x tip_y tip_z largest E_kin E_kin_rel E_elastic W_loads W_weight W_frame Q_damping imbalance "
           "newton substeps residual P_x P_y P_z L_x L_y L_z").split()


def wing(**sections):
    """The small wing for ten steps; `sections` add to it or replace keys."""
    return merged({"Wing": {"file": WING}, "Time": {"dt": 2e-5, "t_max": 2e-4}}, sections)


def flapping(**sections):
    """The small wing in its first beat, with damping, weight and a load: all that could forget its past."""
    return merged(merged(wing(), {
        "Damping": {"rayleigh_stiffness": 3e-5, "rayleigh_mass": 20, "nodal": 1e-9},
        "Motion": {"type": "flapping", "wing": "right"}, "units": {"length": 0.009, "frequency": 158},
        "Insects": {"FlappingMotion_right": f"from_file::{SOURCE}/ini/kinematics/calliphora.ini", "eta0": -90,
                    "wing_ramp": 1, "x_pivot_r": "0.1 -0.15 0.05"},
        "Loads": {"gravity": "0 0 -9.81", "sinusoidal": "tip 0 0 1e-5", "frequency": 300, "phase": 30},
        "Time": {"dt": 3e-5, "t_max": 1.2e-3}, "Saving": {"t_save": 3e-4}}), sections)


def run(case, ini, *arguments, name="run.ini", code=EXIT_OK, ranks=0):
    """Without arguments a new run, whatever is there."""
    case.write(name, ini)
    return case.run("--solid", name, *(arguments or ["--overwrite"]), ranks=ranks, code=code)


def records(case, name="solid.t"):
    """The records of the time series, by column."""
    found = case.series(name)
    names = [n for n in re.split(r"\s{2,}", found.header[0].strip("% ")) if n]
    check([n.split(" ")[0] for n in names] == COLUMNS, f"the columns are named: {names}")
    check(all(re.search(r"\[.+\]$", n) for n in names), "with units")
    return [dict(zip(COLUMNS, row)) for row in found.rows]


def oscillator(omega, h, steps):
    """Displacement and energy of an oscillator by the scheme of the program: one step of implicit Euler, then
    BDF2. Energy relative to the first."""
    u, v = [1.0], [0.0]
    for n in range(steps):
        if n == 0:
            q, bu, bv = 1 / h, u[0], v[0]
        else:
            q, bu, bv = 1.5 / h, (4 * u[-1] - u[-2]) / 3, (4 * v[-1] - v[-2]) / 3
        new = (q * bv + q * q * bu) / (q * q + omega**2)  # q (q (u - bu) - bv) + omega^2 u = 0
        u.append(new)
        v.append(q * (new - bu))
    return u, [x * x + (y / omega)**2 for x, y in zip(u, v)]


def test_free_vibration(case):
    """In its first mode the wing is one oscillator: its frequency is that of the modes, step by step as BDF2 has it;
    displacement and energy converge with the square of the step. The springs, which bending does not spare, hold 6e-5
    of the energy at this amplitude of 1e-7 m; it goes with its square."""
    errors, losses = [], []
    t_end = 2.4e-3
    for h in (2e-5, 1e-5):
        done = run(case, wing(Initial={"mode": 1, "amplitude": 1e-7}, Time={"dt": h, "t_max": t_end}))
        frequency = float(re.search(r"mode +1 of the unloaded wing: ([\d.]+) Hz", done.out).group(1))
        rows = records(case)
        steps = round(t_end / h)
        check(len(rows) == steps + 1 and abs(rows[-1]["time"] - t_end) < 1e-12, f"{steps} steps: {len(rows)}")
        check(abs(rows[0]["largest"] - 1e-7) < 1e-16 and rows[0]["E_kin"] == 0, "it starts bent and at rest")
        omega = 2 * math.pi * frequency
        u, energy = oscillator(omega, h, steps)
        moved = [r["tip_z"] / rows[0]["tip_z"] for r in rows]
        total = [(r["E_kin_rel"] + r["E_elastic"]) / (rows[0]["E_elastic"]) for r in rows]
        check(max(abs(a - b) for a, b in zip(u, moved)) < 1e-4, "the tip moves as the oscillator of this frequency")
        check(max(abs(a - b) for a, b in zip(energy, total)) < 1e-4, "and has its energy")
        check(all(abs(r["imbalance"] - (e - 1) * rows[0]["E_elastic"]) < 1e-6 * rows[0]["E_elastic"]
                  for r, e in zip(rows, total)), "what is lost is called an imbalance")
        errors.append(max(abs(a - math.cos(omega * r["time"])) for a, r in zip(moved, rows)))
        losses.append(1 - total[-1])
    check(0 < losses[1] < 0.01, f"the energy is kept but for one part in a hundred: {losses}")
    for what, pair in (("displacement", errors), ("energy", losses)):
        check(3.5 < pair[0] / pair[1] < 4.7, f"half the step, a quarter of the error of the {what}: {pair}")


def test_joint_friction(case):
    """Friction in the joints of veins and the drag of the air take energy out of a free vibration, and the balance counts it."""
    lost = []
    for damping in ({}, {"joint_friction": 1e-4}, {"drag": 2e3}):
        run(case, wing(Initial={"mode": 1, "amplitude": 1e-7}, Time={"dt": 1e-5, "t_max": 1e-3}, Damping=damping))
        rows = records(case)
        start = rows[0]["E_elastic"]
        lost.append(1 - (rows[-1]["E_kin_rel"] + rows[-1]["E_elastic"]) / start)
        taken = -rows[-1]["Q_damping"] / start
        # What the scheme loses beside: less than a hundredth, see test_free_vibration.
        check(abs(abs(taken) - lost[-1]) < 0.01, f"{damping}: {lost[-1]} is lost, {taken} is counted")
    check(min(lost[1:]) > lost[0] + 0.02, f"friction and drag take energy: {lost}")


def test_second_mode(case):
    """The modes of --static are those of --solid, and their shapes are saved."""
    case.write("modes.ini", {"Wing": {"file": WING}, "Modes": {"modes": 3}})
    done = case.run("--static", "modes.ini", ranks=0)
    found = case.series("static_modes.t")
    frequencies = [row[1] for row in found.rows]
    check(len(frequencies) == 3 and 300 < frequencies[0] < frequencies[1] < frequencies[2], f"{frequencies}")
    check(re.search(rf"^ +2 +{frequencies[1]:.4f}$", done.out, re.M), "they are printed")
    check({f"static_mode_0{i}.{e}" for i in (1, 2, 3) for e in ("h5", "xmf")} < set(case.files()), "shapes are saved")
    check("static_loads.t" not in case.files(), "no loads are needed")
    case.check_index("static_mode_02.xmf")
    h = 1e-5
    done = run(case, wing(Initial={"mode": 2, "amplitude": 1e-7}, Time={"dt": h, "t_max": 6e-4}))
    check(f"mode      2 of the unloaded wing: {frequencies[1]:.4f} Hz" in done.out, "the same frequency")
    u, _ = oscillator(2 * math.pi * frequencies[1], h, 60)
    rows = records(case)
    check(max(abs(a - r["tip_z"] / rows[0]["tip_z"]) for a, r in zip(u, rows)) < 2e-4, "and that is how it moves")


def same_runs(whole, parts):
    """Series, index, shapes and the newest checkpoint are the same to the bit."""
    one, two = (case.series("solid.t").lines for case in (whole, parts))
    check(one == two and len(one) == 41, f"the same series: {len(one)} and {len(two)} records")
    check((whole.folder / "solid.xmf").read_text() == (parts.folder / "solid.xmf").read_text(), "the same index")
    shapes = [n for n in whole.files() if re.fullmatch(r"solid_\d{5}\.h5", n)]
    check(len(shapes) == 5 and shapes == [n for n in parts.files() if re.fullmatch(r"solid_\d{5}\.h5", n)],
          f"the same shapes: {shapes}")
    for name in shapes:
        check(whole.contents(name) == parts.contents(name), f"{name} is the same to the bit")
    same_checkpoints(whole, newest(whole), parts, newest(parts))


def newest(case):
    names = [n for n in case.files() if n.startswith("solid_backup")]
    check(names, "there is a backup")
    return max(names, key=case.generation)


def test_restart(case):
    """2 N steps are N steps, restart, N steps, when the end or the wall time stopped the first part, and when the
    run went on behind the backup that is restarted from."""
    whole = case.sub("whole")
    run(whole, flapping())
    rows = records(whole)
    for name in ("W_loads", "W_weight", "W_frame", "Q_damping", "tip_z"):
        check(abs(rows[-1][name]) > 0, f"{name} takes part")
    whole.check_index("solid.xmf")
    ended = case.sub("ended")
    run(ended, flapping(Time={"t_max": 5.1e-4}))
    ended.check_index("solid.xmf")
    check("solid_00002.h5" in ended.files(), "the end is saved also between two saves")
    done = run(ended, flapping(), "--restart")
    check("restart   at t =  5.1" in done.out, f"it says where it goes on:\n{done.out}")
    same_runs(whole, ended)
    stopped = case.sub("stopped")
    done = run(stopped, flapping(Saving={"wtimemax": 1e-9}), code=EXIT_STOPPED)
    check("stopped early: the wall time wtimemax is used up" in done.out, done.out)
    check(len(stopped.series("solid.t").rows) == 2, "it stops after a step")
    run(stopped, flapping(), "--restart")
    same_runs(whole, stopped)
    behind = case.sub("behind")
    run(behind, flapping(Time={"t_max": 6e-4}))
    shutil.copy(behind.folder / newest(behind), behind.folder / "kept.h5")
    run(behind, flapping(Time={"t_max": 9e-4}), "--restart")
    run(behind, flapping(), "--restart=kept.h5")
    same_runs(whole, behind)


def test_refused_restarts(case):
    done = run(case, wing(), "--restart", code=EXIT_USER)
    check("there is no valid backup to restart from" in done.err, done.err)
    run(case, wing(Saving={"name": "here"}))
    check("here_backup0.h5" in case.files(), f"{case.files()}")
    done = run(case, wing(Wing={"file": SOURCE / "wings/plate.h5"}), "--restart=here_backup0.h5", code=EXIT_USER)
    check("the checkpoint belongs to another wing" in done.err, done.err)
    done = run(case, wing(), "--restart=here_00000.h5", code=EXIT_USER)
    check("flusi: " in done.err and "here_00000.h5" in done.err, done.err)
    check("solid.t" not in case.files(), "nothing was written")
    case.write("here.xmf", "of something else\n")
    done = run(case, wing(Saving={"name": "here"}, Time={"t_max": 4e-4}), "--restart", code=EXIT_UNWRITABLE)
    check("here.xmf: was not written by this program" in done.err, done.err)


def test_rest(case):
    """Damped strongly, a wing under loads and gravity comes to rest where statics has its equilibrium."""
    loads = "vein:C:last 0 0 4e-5 + at:0.00721:-0.00032 1e-5 0 2e-4"
    case.write("static.ini", {"Wing": {"file": WING}, "Loads": {"named_forces": loads, "gravity": "0 0 -50"}})
    case.run("--static", "static.ini", ranks=0)
    names = "load x y fx fy fz converged residual factors snaps stages rcond at_load tip_x tip_y tip_z".split()
    static = dict(zip(names, case.series("static_loads.t").rows[0]))
    run(case, wing(Damping={"rayleigh_mass": 6000}, Time={"dt": 1e-3, "t_max": 0.1, "tolerance": 1e-11},
                   Loads={"constant": "vein:C:last 0 0 4e-5", "ramped": "at:0.00721:-0.00032 1e-5 0 2e-4",
                          "ramp": 5e-3, "gravity": "0 0 -50"}, Saving={"series_every": 50}))
    rows = records(case)
    check([round(r["time"], 9) for r in rows] == [0, 0.05, 0.1], "every 50th step has a record")
    last = rows[-1]
    # Statics ends at 1e-8 of the load, which soft directions turn into some 1e-7 of the movement.
    for name in ("tip_x", "tip_y", "tip_z"):
        check(abs(last[name] - static[name]) < 1e-6 * abs(static["tip_z"]), f"{name}: {last[name]}, {static[name]}")
    check(last["E_kin"] < 1e-12 * last["E_elastic"], "it rests")
    # A slow sine, behind by a quarter of its period, is at its largest after half of it; the wing, whose modes are ten
    # times as fast, is then close to its equilibrium.
    run(case, wing(Damping={"rayleigh_mass": 2000}, Time={"dt": 1e-4, "t_max": 0.01},
                   Loads={"sinusoidal": loads, "frequency": 50, "phase": -90, "gravity": "0 0 -50"}))
    quarter = records(case)[-1]
    check(abs(quarter["tip_z"] / static["tip_z"] - 1) < 0.03, f"{quarter['tip_z']}, {static['tip_z']}")
    # Released from there without damping it swings back through the flat shape.
    run(case, wing(Initial={"released": loads}, Time={"t_max": 1e-3}))
    rows = records(case)
    check(rows[0]["tip_z"] > 2e-4 and min(r["tip_z"] for r in rows) < -0.5 * rows[0]["tip_z"], "it swings")
    check(rows[0]["E_kin"] == 0 and rows[1]["E_kin"] > 0, "from rest")


def test_rotation(case):
    """A wing that rotates about its normal is stretched and does not leave its plane."""
    run(case, wing(Motion={"type": "rotation", "axis": "0 0 2", "frequency": 50, "ramp": 5e-4},
                   Damping={"rayleigh_mass": 5000}, Time={"dt": 5e-5, "t_max": 5e-3}))
    rows = records(case)
    last = rows[-1]
    check(abs(last["tip_z"]) < 1e-15 < 1e-10 < last["tip_x"], f"the tip moves outwards: {last}")
    inertia = last["E_kin"] * 2 / (2 * math.pi * 50)**2
    # 250 ug at distances of 3.2 mm, and a radius of gyration of some 2 mm about their centre.
    check(250e-9 * 3e-3**2 < inertia < 250e-9 * 5e-3**2, f"the moment of inertia is {inertia} kg m^2")


def shipped():
    """ini/solid.ini with the paths of its files."""
    text = (SOURCE / "ini/solid.ini").read_text()
    for old, new in (("../wings/", f"{SOURCE}/wings/"), ("::kinematics/", f"::{SOURCE}/ini/kinematics/")):
        check(old in text, f"ini/solid.ini names {old}")
        text = text.replace(old, new)
    return text


def test_flapping(case):
    """ini/solid.ini over its first beat, with its step and twice that: the numbers of the README. Work of the frame
    and loss to damping differ by the square of the step, 3 %; the imbalance is this square."""
    ends = []
    for steps in (100, 200):
        text = re.sub(r"\ndt = \S+", f"\ndt = {1 / 158 / steps!r};", shipped())
        run(case, re.sub(r"\nt_max = \S+", f"\nt_max = {1 / 158!r};", text), name="solid.ini")
        ends.append(records(case)[-1])
    two, one = ends
    check(abs(one["imbalance"] + 3.44e-9) < 0.01e-9 and abs(one["W_frame"] - 2.688e-7) < 1e-10, f"{one}")
    # Where the wing is fastest it turns about its root almost as one piece: P = m s Omega, L = J Omega, E = J Omega^2/2
    # with at most the distance of the centre of mass for s, m s = 249.34 ug 3.426 mm, and at most the largest moment of
    # inertia, 4.42e-12 kg m^2 (both printed at the start); its turning about the span takes less than a fifth from them.
    fast = max(records(case), key=lambda record: record["E_kin"])
    momentum, angular = (sum(fast[f"{name}_{axis}"] ** 2 for axis in "xyz") ** 0.5 for name in "PL")
    inertia = angular ** 2 / (2 * fast["E_kin"])
    static = momentum * angular / (2 * fast["E_kin"])
    check(0.8 * 4.42e-12 < inertia < 4.42e-12, f"moment of inertia {inertia}")
    check(0.8 * 8.54e-10 < static < 8.54e-10, f"mass times distance {static}")
    check(3.5 < two["imbalance"] / one["imbalance"] < 4.7, f"half the step, a quarter of the imbalance: {ends}")
    for name in ("W_frame", "Q_damping", "E_elastic"):
        check(abs(one[name] - two[name]) < 0.04 * one["W_frame"], f"{name}: {ends}")


def test_mirror(case):
    """Along the axes of the wing file both wings of a fly do the same, also if they tell up from down; not so if z of the
    file is on the other side."""
    sides = {"Wing": {"sided_joints": "yes", "sided_veins": "yes", "joint_stiffness": 2e-6,
                      "parameters": "camber_chord 30, one_way:R1_Rs 0.1, one_way:C_Sc 0.1"}}
    motion = f"from_file::{SOURCE}/ini/kinematics/calliphora.ini"
    found = {}
    for name, extra in (("left", {}), ("right", {}), ("turned", {"z_side": "right dorsal"})):
        mirrored = {"Motion": {"wing": name.replace("turned", "left")}, "Time": {"t_max": 3e-4},
                    "Insects": {"FlappingMotion_left": motion, "FlappingMotion_right": motion, "x_pivot_l": "0.1 0.15 0.05",
                                "wing_ramp": 0}}
        folder = case.sub(name)
        run(folder, merged(merged(flapping(**mirrored), sides), {"Wing": extra}))
        found[name] = records(folder)
    largest = {name: max(abs(row[name]) for row in found["left"]) for name in COLUMNS}
    for name in COLUMNS:
        # Ten digits. The imbalance is a small difference of energies.
        size = max(largest[name], largest["E_kin"] if name == "imbalance" else 0)
        for a, b in zip(found["left"], found["right"]):
            check(name == "residual" or abs(a[name] - b[name]) <= 2e-9 * size, f"{name}: {a[name]}, {b[name]}")
    check(largest["tip_z"] > 1e-5, f"the wing bends: {largest}")
    off = max(abs(a["tip_z"] - b["tip_z"]) for a, b in zip(found["left"], found["turned"]))
    check(off > 0.1 * largest["tip_z"], f"the side counts: {off} of {largest['tip_z']}")


def test_failure(case):
    """A step without convergence ends the run with the reason; the last good state is there to go on from."""
    hard = wing(Time={"iterations": 3, "halvings": 0, "t_max": 2e-3}, Saving={"t_save": 1e-3},
                Loads={"ramped": "tip 0 0 2e-3", "ramp": 1e-3})
    done = run(case, hard, code=EXIT_NUMERICAL)
    check(re.search(r"flusi: the step from t = .* s failed: Newton's method did not converge", done.err), done.err)
    check("the last good state is in the newest backup and the last shape" in done.err, done.err)
    rows = records(case)
    check(1 < len(rows) < 100 and all(r["substeps"] == 1 for r in rows[1:]), "some steps were made")
    case.check_index("solid.xmf")
    text = (case.folder / "solid.xmf").read_text()
    last = float(re.findall(r'Time Value="([^"]+)"', text)[-1])
    check(abs(last - rows[-1]["time"]) < 1e-9 * last, "the last shape is there")
    go_on = merged(hard, {"Time": {"iterations": 10, "halvings": 8, "t_max": rows[-1]["time"] + 1e-4}})
    done = run(case, go_on, "--restart")
    check(len(records(case)) == len(rows) + 5, "patience helps")
    done = run(case, wing(Time={"iterations": 1, "halvings": 0}, Loads={"constant": "tip 0 0 5"}), code=EXIT_NUMERICAL,
               name="first.ini")
    check("the step from t =  0.0" in done.err and "newest backup" not in done.err, done.err)


def test_mistakes(case):
    mistakes = [
        ({"Time": {"dt": None}}, ["[Time] dt: is missing"]),
        ({"Time": {"dt": 0}}, ["[Time] dt"]),
        ({"Time": {"dt": 1}}, ["[Time] dt: is longer than the run"]),
        ({"Wing": {"file": "nosuch.h5"}}, ["run.ini:2: [Wing] file: 'nosuch.h5' does not exist"]),
        ({"Mass": {"membrane_law": "uniform", "areal_density": 0}}, ["[Mass] areal_density"]),
        ({"Motion": {"type": "rotate"}}, ["[Motion] type", "rotation"]),
        ({"Motion": {"type": "rotation", "axis": "0 0 0"}}, ["[Motion] axis: has no direction",
                                                             "[Motion] frequency: is 0"]),
        ({"Motion": {"type": "flapping"}, "Insects": {"FlappingMotion_left": "from_file::no.ini"}},
         ["[Insects] FlappingMotion_left: 'no.ini' does not exist"]),
        ({"Motion": {"type": "flapping"}, "Insects": {"FlappingMotion_left": "from_file::run.ini"}}, ["run.ini:1"]),
        ({"Loads": {"constant": "nose 0 0 1, tip 0 0, tip 0 0 x, tip 0 0 0"}},
         ["[Loads] constant: 'nose' is no site of the wing; valid: tip, vein:NAME:first",
          "'tip 0 0' is not SITE FX FY FZ", "'x' is not a number",
          "'tip 0 0 0': the force is zero"]),
        ({"Loads": {"ramped": "vein:nose:last 0 0 1, vein:C 0 0 1, vein:C:99 0 0 1, joint:nose 0 0 1"}},
         ["[Loads] ramped: there is no vein 'nose'; valid: ", " | C | ", "where on vein C? valid: vein:C:first",
          "99 is no point; valid: 1 to ", "there is no joint 'nose'; valid: ", "C_Sc"]),
        ({"Loads": {"sinusoidal": "at:1 0 0 1, at:1:2 0 0 1, point:0 0 0 1, vein:C:first 0 0 1"}},
         ["needs two coordinates, at:X:Y", "the place 1.0 2.0 m is not on the membrane", "0 is no point",
          "the force acts on the clamped root only"]),
        ({"Initial": {"released": "tip 0 0 1e-4", "mode": 1}}, ["[Initial] mode: contradicts released"]),
        ({"Saving": {"name": "a<b"}}, ["[Saving] name: must not contain"]),
        ({"Saving": {"t_save": 1e-12}}, ["[Saving] t_save: is too short"]),
        ({"Saving": {"tsave": 1}}, ["[Saving] tsave", "did you mean 't_save'"]),
    ]
    for number, (change, sentences) in enumerate(mistakes):
        for arguments in ([], ["--check"]) if number < 2 else (["--check"],):
            done = run(case, wing(**change), *arguments, code=EXIT_USER)
            for sentence in sentences:
                check(sentence in done.err, f"{change}: {sentence}:\n{done.err}")
            check(done.out == "" and case.files() == ["run.ini"], f"{change} writes nothing: {case.files()}")
    for arguments, word in ((["--dry-run"], "--solid goes with"), (["--static"], "--solid contradicts --static"),
                            (["--check", "--restart"], "--restart is valid for a run only")):
        done = run(case, wing(), *arguments, code=EXIT_USER)
        check(word in done.err and case.files() == ["run.ini"], f"{arguments}:\n{done.err}")
    idle = {"Motion": {"axis": "1 0 0"}, "Insects": {"FlappingMotion_right": "from_file::nosuch.ini"}}
    done = run(case, wing(**idle), "--check")
    for sentence in ("notice: run.ini:7: [Motion] axis: has no effect with type = rest",
                     "[Insects] FlappingMotion_right: has no effect with [Motion] type = rest"):
        check(sentence in done.out, f"{sentence}:\n{done.out}")
    done = run(case, wing(), ranks=2, code=EXIT_USER)
    check(done.err.count("flusi: --solid runs on one rank, not on 2") == 1, done.err)
    done = run(case, wing(Saving={"name": "no/such/folder"}), code=EXIT_UNWRITABLE)
    check("no/such/folder.lock: cannot be written" in done.err, done.err)


def test_doubts(case):
    """What is assumed is told, and so are numbers with units mixed up; a wing file that states its mass needs no key."""
    def told(wing_file, **sections):
        known = {"Wing": {"file": SOURCE / "wings" / wing_file, "E": 1e10, "D": 2.1e-7}}
        done = run(case, merged(merged(wing(), known), sections), "--check")
        return [line for line in (done.out + done.err).splitlines() if line.startswith("; notice: ")]
    notices = told("plate.h5", Wing={"E": None, "D": None})
    for words in ("[Wing] E: is not given; the program assumes 12.58 GPa", "[Wing] D: is not given; the program assumes 2e-7 N m",
                  "[Mass] membrane_mass: is not given; the program assumes 81.475 ug"):
        check(sum(words in line for line in notices) == 1, f"{words}:\n{notices}")
    stated = {"vein_density": 1300, "membrane_law": "bilinear", "membrane_mass": 6e-8}
    check(told("plate.h5", Mass=stated) == [], "stated numbers are not doubted")
    for given, left, words in ((stated, "membrane_law", "bilinear, so that the mass is spread as in a blowfly's wing"),
                               (stated, "vein_density", "1300 kg/m^3, of insect cuticle"),
                               (stated, "membrane_mass", "81.475 ug spread by the bilinear law"),
                               ({**stated, "membrane_law": "uniform"}, "areal_density", "3e-3 kg/m^2")):
        notices = told("plate.h5", Mass={**given, left: None})
        check(len(notices) == 1 and f"[Mass] {left}: is not given; the program assumes {words}" in notices[0], f"{left}:\n{notices}")
    check(told("calliphora_small.h5", Mass={"membrane_mass": 6e-8}) == [], "the law is that of the file, the mass that of the input")
    check(told("calliphora_small.h5") == [], "the file of the blowfly's wing states its mass")
    for section, key, value, words in (
            ("Wing", "E", 12.58, "12.58 Pa is too small for veins of insects, which have 1e7 to 1e11 Pa; if the value is in GPa, write 12.58e9"),
            ("Wing", "D", 0.01, "0.01 N m is too large"),
            ("Mass", "vein_density", 1.3, "1.3 kg/m^3 is too small for veins of insects"),
            ("Mass", "membrane_mass", 81.475, "81.475 kg is too large for membranes of this size, which have 3e-9 to 3e-6 kg; if the value is in ug, "
             "write 81.475e-9")):
        notices = told("calliphora_small.h5", **{section: {key: value}})
        check(len(notices) == 1 and f"[{section}] {key}: " in notices[0] and words in notices[0], f"{key}:\n{notices}")


def test_mass_keys(case):
    """Keys of [Mass] count before what the wing file states; drawn_wings.py has files that state other masses."""
    found = {}
    for name, mass in (("file", {}), ("same", {"membrane_law": "bilinear", "membrane_mass": 81.475e-9}),
                       ("mass", {"membrane_mass": 81.475e-9}), ("other", {"membrane_law": "uniform", "areal_density": 6e-3})):
        done = run(case, wing(Mass=mass, Time={"t_max": 2e-5}))
        found[name] = re.search(r"^mass .*", done.out, re.M).group(0)
    check(found["file"] == found["same"] == found["mass"] != found["other"], f"{found}")


def test_check(case):
    """--check prints every documented key and writes nothing; the shipped case runs."""
    text = shipped()
    done = run(case, text, "--check", name="solid.ini")
    known = live_keys(case.flusi("--parameters").out.split(SOLID_REFERENCE)[1].split(TRAIN_REFERENCE)[0])
    known.discard(("include", "file"))  # what was included is printed in its place
    section, printed = "", set()
    for line in done.out.splitlines():
        section = line.strip("[]") if line.startswith("[") else section
        found = re.match(r"  (\S+) = ", line)
        if found:
            printed.add((section, found.group(1)))
    check(len(known) > 40 and printed == known, f"every key: {printed ^ known}")
    check(case.files() == ["solid.ini"], "nothing is written")
    done = run(case, re.sub(r"t_max = \S+", "t_max = 6.4e-4;", text), name="solid.ini")
    check("done: 21 steps" in done.out and done.err == "", f"{done.out}{done.err}")
    rows = records(case)
    check(abs(rows[-1]["time"] - 6.4e-4) < 1e-15, "the last step is shorter and ends in time")
    case.check_index("solid.xmf")


if __name__ == "__main__":
    main(globals())
