#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""2 N steps are N steps, restart, N steps: checkpoints, fields and series, for every way to stop.

usage: flusi_restart.py <flusi> <h5dump> [tests]

On the same number of ranks everything is compared to the bit. On another number of ranks the order of
sums changes: round-off, relative to the largest number of a table, grows to less than 1e-12.
"""
import os
import shutil
import signal
import time

from whole_program import EXIT_STOPPED, EXIT_USER, check, close, main, merged, ring, same_checkpoints, same_runs, sphere

ROUND_OFF = 1e-12
# Series hold nine digits: a number may be rounded to its neighbour.
LAST_DIGIT = 2e-8

# Forces with the unsteady correction, double precision fields, slices: all that could forget its past.
RICH = sphere(
    Penalization={"unst_corrections": "yes", "us_fixed": "0.1 0.0 0.0"},
    MeanFlow={"iMeanFlow": None, "iMeanFlow_x": "dynamic", "iMeanFlow_y": "fixed", "m_fluid": 50.0},
    Saving={"field_precision": "double", "iSaveVorticity": "yes", "iSavePress": "yes", "iSaveMask": "yes",
            "iSaveQ": "yes", "iSaveSpectrae": "yes"},
    SaveSlices={"use_slicing": "yes", "slice1": 4, "tslice": 0.02})


def reference(case, ini, steps, ranks):
    case.write("run.ini", merged(ini, {"Time": {"nt": steps}}))
    case.run("run.ini", ranks=ranks)
    check(len(case.series("ekin.t").rows) == steps, f"the reference makes {steps} steps")
    return case


def go_on(case, ini, steps, ranks, *arguments):
    case.write("run.ini", merged(ini, {"Time": {"nt": steps}}))
    done = case.run("run.ini", *(arguments or ["--restart"]), ranks=ranks)
    check("restart   at t = " in done.out, "the program says where it goes on")
    return done


def test_nt(case):
    """nt reached is the end of a run, not an early stop."""
    whole, parts = reference(case.sub("whole"), RICH, 40, 2), reference(case.sub("parts"), RICH, 20, 2)
    go_on(parts, RICH, 40, 2)
    same_runs(whole, parts)
    parts.check_index("run.xmf")


def test_every_stop(case):
    """A stop file, signals, the control file, wtimemax and the end of a job: exit code 4, a valid backup,
    and the run goes on as if nothing had happened."""

    def stop_file(part):
        (part.folder / "STOP").touch()

    def control_file(part):
        (part.folder / "runtime_control.ini").write_text("[runtime_control]\nruntime_control=save_stop;\n")

    def signal_to_launcher(part):
        part.process.send_signal(signal.SIGUSR1)

    def signal_to_one_rank(part):
        ranks = part.ranks()
        check(len(ranks) == 2, f"both ranks are found: {ranks}")
        os.kill(max(ranks), signal.SIGTERM)

    def nothing(part):
        pass

    stops = {
        "stop_file": (stop_file, {}, {}, "a control file asked for it"),
        "control_file": (control_file, {}, {}, "a control file asked for it"),
        "launcher_usr1": (signal_to_launcher, {}, {}, "a signal asked for it"),
        "rank_term": (signal_to_one_rank, {}, {}, "a signal asked for it"),
        "wtimemax": (nothing, {"wtimemax": 1e-5}, {}, "the wall time wtimemax is used up"),
        "job_end": (nothing, {"job_end_margin": 60}, {}, "the job ends soon"),
    }
    parts, steps = {}, 0
    for name, (stop, saving, env, reason) in stops.items():
        part = parts[name] = case.sub(name)
        part.write("run.ini", merged(RICH, {"Time": {"nt": 999999}, "Saving": saving}))
        if name == "job_end":
            env = {"SLURM_JOB_END_TIME": str(int(time.time()) + 61)}  # one second is left
        part.start("run.ini", ranks=2, env=env)
        if stop is not nothing:
            part.wait_for_steps(12)
            stop(part)
        done = part.wait()
        check(done.code == EXIT_STOPPED, f"{name}: exit code 4, not {done.code}:\n{done.out}{done.err}")
        check(f"stopped early: {reason}; the backup is written" in done.out, f"{name}: the reason is said:\n{done.out}")
        check(not (part.folder / "STOP").exists(), f"{name}: the stop file is gone")
        control = (part.folder / "runtime_control.ini").read_text()
        check("runtime_control=nothing;" in control, f"{name}: the control file is set back")
        backup = part.contents(part.newest_checkpoint())
        made = part.series("timesteps_info.t").rows[-1][2]
        check(backup["step"] == [str(int(made))], f"{name}: the backup is that of the last step")
        steps = max(steps, int(made))
    steps += 15
    whole = reference(case.sub("whole"), RICH, steps, 2)
    for name, part in parts.items():
        go_on(part, RICH, steps, 2)
        same_runs(whole, part)


def test_runge_kutta(case):
    for scheme, steps in (("RK4", 24), ("RK2", 16), ("Euler", 16)):
        ini = merged(ring(), {"Time": {"iTimeMethodFluid": scheme}})
        whole, parts = (reference(case.sub(scheme + name), ini, steps // n, 2) for name, n in (("whole", 1), ("parts", 2)))
        go_on(parts, ini, steps, 2)
        same_runs(whole, parts)


def test_intelligent_dt(case):
    ini = merged(RICH, {"Time": {"intelligent_dt": "yes"}})
    whole, parts = reference(case.sub("whole"), ini, 30, 1), reference(case.sub("parts"), ini, 17, 1)
    go_on(parts, ini, 30, 1)
    same_runs(whole, parts)


def test_other_ranks(case):
    """Any number of ranks goes on from the backup of any other."""
    whole = reference(case.sub("whole"), RICH, 40, 2)
    for first, second, rows in ((1, 4, 2), (4, 3, 0), (3, 1, 0)):
        part = case.sub(f"from_{first}_to_{second}")
        reference(part, RICH, 20, first)
        go_on(part, merged(RICH, {"Resolution": {"process_rows": rows}}), 40, second)
        same_checkpoints(whole, whole.newest_checkpoint(), part, part.newest_checkpoint(), ROUND_OFF)
        for name in whole.all_series():
            if name in ("timesteps_info.t", "divu.t", "u_residual.t"):
                continue  # the machine, and numbers that are round-off themselves
            one, two = whole.series(name).rows, part.series(name).rows
            check(len(one) == len(two), f"{name} has the same number of records on {first} and {second} ranks")
            for p, q in zip(zip(*one), zip(*two)):
                close(p, q, LAST_DIGIT, f"a column of {name}", floor=1e-6)
        last = max(n for n in whole.files() if n.startswith("ux_"))
        for prefix in ("ux", "uy", "uz", "vorx", "vory", "vorz", "p", "mask"):
            name = last.replace("ux", prefix)
            close(whole.field(name), part.field(name), ROUND_OFF, name)


def test_measured_plans(case):
    """Plans that were measured are kept beside the backups, and the last step is the same to the bit."""
    ini = merged(RICH, {"Resolution": {"ny": 18, "planner": "measure"}, "Saving": {"truntime": 1e-9}})
    whole = reference(case.sub("whole"), ini, 8, 3)
    check("fftw_wisdom" in whole.files(), "the plans are kept")
    newest = whole.newest_checkpoint()
    # Also where the run that goes on would not have measured: it finds the plans.
    for planner in ("measure", "auto"):
        part = case.sub(planner)
        for name in whole.files():
            if name != newest:
                shutil.copy(whole.folder / name, part.folder)
        done = go_on(part, merged(ini, {"Resolution": {"planner": planner}}), 8, 3)
        check("step 7" in done.out, "the run goes on from the backup before the last")
        check("plans     measured" in done.out, f"planner = {planner} goes on with measured plans")
        same_checkpoints(whole, newest, part, newest)


def test_other_transform(case):
    """A backup made with one transform goes on with the other, on any number of ranks."""
    if not case.has_p3dfft():
        print("skipped: this program was built without P3DFFT")
        return
    builtin, p3dfft = ({"Parallel": {"transform": name}} for name in ("builtin", "p3dfft"))
    whole = reference(case.sub("whole"), merged(RICH, builtin), 40, 2)
    for name, first, second, ranks in (("to_p3dfft", builtin, p3dfft, 4), ("to_builtin", p3dfft, builtin, 3)):
        part = reference(case.sub(name), merged(RICH, first), 20, 2)
        go_on(part, merged(RICH, second), 40, ranks)
        same_checkpoints(whole, whole.newest_checkpoint(), part, part.newest_checkpoint(), ROUND_OFF)


def test_named_file(case):
    """--restart=FILE and inicond = backup::FILE, also for a file of another name in another folder."""
    whole, first = reference(case.sub("whole"), RICH, 40, 2), reference(case.sub("first"), RICH, 20, 2)
    backup = first.folder / first.newest_checkpoint()
    for name, arguments, inicond in (("argument", ["--restart=../kept/state.h5"], "quiescent"),
                                     ("inicond", [], "backup::../kept/state.h5")):
        part = case.sub(name)
        for file in first.files():
            if not file.startswith("runtime_backup"):
                shutil.copy(first.folder / file, part.folder)
        kept = case.folder / "kept"
        kept.mkdir(exist_ok=True)
        shutil.copy(backup, kept / "state.h5")
        before = (kept / "state.h5").read_bytes()
        ini = merged(RICH, {"InitialCondition": {"inicond": inicond}, "Time": {"nt": 40}})
        part.write("run.ini", ini)
        part.run("run.ini", *arguments, ranks=2)
        same_runs(whole, part)
        check((kept / "state.h5").read_bytes() == before, "the file it came from is as it was")


def test_source_is_kept(case):
    """The first backup of a restarted run never replaces the file that the run came from, even if that is
    the older one; nor does it if the newer one is damaged."""
    ini = merged(RICH, {"Saving": {"truntime": 1e-9}})
    reference(case, ini, 7, 2)
    generation = {n: case.generation(n) for n in ("runtime_backup0.h5", "runtime_backup1.h5")}
    newest, oldest = sorted(generation, key=generation.get, reverse=True)
    for arguments, source, steps in (([f"--restart={oldest}"], oldest, 7), ([f"--restart=./{newest}"], newest, 8),
                                     (["--restart"], newest, 8)):
        part = case.sub(f"to_{steps}_{len(arguments[0])}")
        for name in generation:
            shutil.copy(case.folder / name, part.folder)
        before = (part.folder / source).read_bytes()
        steps_there = int(part.contents(source)["step"][0])
        # One more step, and no backup but the last: the source must still be there.
        part.write("run.ini", merged(RICH, {"Time": {"nt": steps_there + 1}}))
        part.run("run.ini", *arguments, ranks=2)
        check((part.folder / source).read_bytes() == before, f"{arguments}: {source} is as it was")
        check(int(part.contents(part.newest_checkpoint())["step"][0]) == steps_there + 1, "the next backup is newest")
    damaged = case.sub("damaged")
    for name in generation:
        shutil.copy(case.folder / name, damaged.folder)
    data = bytearray((damaged.folder / newest).read_bytes())
    table = damaged.raw(newest, "history_y")
    data[data.index(table) + len(table) // 2] ^= 1
    (damaged.folder / newest).write_bytes(data)
    before = (damaged.folder / oldest).read_bytes()
    damaged.write("run.ini", merged(RICH, {"Time": {"nt": 7}}))
    done = damaged.run("run.ini", "--restart", ranks=2)
    check("step 6" in done.out, f"the run goes on from the older backup:\n{done.out}")
    check((damaged.folder / oldest).read_bytes() == before, "the valid backup is as it was")
    whole = reference(case.sub("whole"), RICH, 7, 2)
    same_checkpoints(whole, whole.newest_checkpoint(), damaged, newest)


def test_refusals(case):
    """Restarts that cannot be: the reason is said, the exit code is 2, nothing is written."""
    reference(case, RICH, 4, 2)
    wrong = {
        "grid": ({"Resolution": {"nx": 20}}, "the checkpoint has another grid, 16 x 16 x 16 instead of 20 x 16 x 16: set nx"),
        "box": ({"Geometry": {"xl": 2.0}}, "the checkpoint has another box"),
        "truncation": ({"Dealiasing": {"iDealias": "box"}}, "the checkpoint has another truncation, ellipsoid: set"),
        "scheme": ({"Time": {"iTimeMethodFluid": "RK4"}}, "the checkpoint was made with another time stepper"),
    }
    for name, (change, reason) in wrong.items():
        part = case.sub(name)
        shutil.copy(case.folder / "runtime_backup0.h5", part.folder)
        part.write("run.ini", merged(RICH, change))
        unchanged(part, reason, "run.ini", "--restart")
    empty = case.sub("empty")
    empty.write("run.ini", RICH)
    unchanged(empty, "there is no valid backup to restart from", "run.ini", "--restart")
    unchanged(empty, "runtime_backup0.h5: does not exist", "run.ini", "--restart")
    unchanged(empty, "nosuch.h5: does not exist", "run.ini", "--restart=nosuch.h5")
    empty.write("run.ini", merged(RICH, {"InitialCondition": {"inicond": "backup::nosuch.h5"}}))
    unchanged(empty, "nosuch.h5", "run.ini")
    empty.write("run.ini", RICH)
    field = case.folder / "ux_000000.h5"
    unchanged(empty, "ux_000000.h5", "run.ini", f"--restart={field}")
    (empty.folder / "text.h5").write_text("not HDF5\n")
    unchanged(empty, "text.h5", "run.ini", "--restart=text.h5")


def unchanged(case, reason, *arguments):
    before = {n: (case.folder / n).read_bytes() for n in case.files()}
    done = case.run(*arguments, ranks=2, code=EXIT_USER)
    check(reason in done.err, f"the reason is said: {reason}:\n{done.err}")
    after = {n: (case.folder / n).read_bytes() for n in case.files()}
    check(before == after, f"nothing is written: {sorted(set(after) - set(before))}")


def test_stop_without_backups(case):
    """Whoever asks a run to stop gets a checkpoint, also with iDoBackup = no; a run that reaches its end
    does not write one."""
    ini = merged(RICH, {"Saving": {"iDoBackup": "no"}})
    end = reference(case.sub("end"), merged(ini, {"Saving": {"truntime": 1e-9}}), 5, 2)
    check(not any(n.startswith("runtime_backup") for n in end.files()), "no backups are written")
    case.write("run.ini", ini)
    (case.folder / "STOP").touch()
    case.run("run.ini", ranks=2, code=EXIT_STOPPED)
    check("runtime_backup0.h5" in case.files(), "the backup is written")
    go_on(case, ini, 40, 2)
    check(len(case.series("ekin.t").rows) == 40, "and the run goes on from it")


def test_no_step_left(case):
    """A restart of a finished run writes its end again and changes nothing."""
    reference(case, RICH, 10, 2)
    before = case.all_series()
    done = case.run("run.ini", "--restart", ranks=2)
    check(case.all_series() == before, "the series are the same")
    check("this is the end of the run: to go on, increase [Time] Tmax" in done.out, f"the program says why it computes nothing:\n{done.out}")


main(globals())
