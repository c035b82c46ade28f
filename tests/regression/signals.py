#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""TERM, INT, HUP and USR1, to the launcher or to a program without one, end a run with a backup from which it goes on.

usage: signals.py <flusi> <h5dump> <write_replicate> <msm_train> <msm_diagnose> [tests]

Open MPI 4 turns TERM, INT and HUP into a TERM for its ranks, and kills them `odls_base_sigkill_timeout` seconds later; before the
TERM it waits as long. The tests give a busy machine some seconds, and await all signals at once. Open MPI 5 kills them after 0.2 seconds,
which may be too short for a backup and its message: a backup that is there must then be a whole one.
"""
import contextlib
import re
import signal
import subprocess
import sys
import time

from gradient_case import input_text, synthesise
from training_case import replicate, training
from whole_program import ALIVE, EXIT_OK, EXIT_STOPPED, check, main, merged, no_crash, series, sphere

TRAIN, DIAGNOSE = sys.argv.pop(3), sys.argv.pop(3)
LAUNCHERS = signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGUSR1
SECONDS = "8"  # between TERM and KILL
PATIENT = {"OMPI_MCA_odls_base_sigkill_timeout": SECONDS}


def kills_soon(case, name, ranks):
    """Whether the launcher kills the ranks of a run that gets this signal before they can end by themselves."""
    if ranks == 0 or name == "SIGUSR1":
        return False
    told = subprocess.run([case.mpiexec, "--version"], stdout=subprocess.PIPE, text=True).stdout
    version = re.search(r"Open MPI\D* (\d+)\.", told)
    return version is not None and int(version.group(1)) >= 5


def steps(case):
    with contextlib.suppress(FileNotFoundError):
        return len(series(case.folder / "timesteps_info.t").rows)
    return 0


def ended_by(case, signals, ranks, prepare, ready, env=PATIENT):
    """A run for each of the signals, in a folder of its own, sent once the run is `ready`: name, case and how it ended."""
    runs, words = [], []
    for number in signals:
        name = signal.Signals(number).name
        run = case.sub(f"{name}_{ranks}")
        run.program = case.program
        words.append(prepare(run))
        runs.append((name, number, run))
    for (_, _, run), arguments in zip(runs, words):
        run.start(*arguments, ranks=ranks, env=env)
    waiting, end = list(runs), time.monotonic() + ALIVE
    while waiting and time.monotonic() < end:
        for one in list(waiting):
            name, number, run = one
            check(run.process.poll() is None, f"{name}: the run goes on until the signal: {run.err.read_text()}")
            if ready(run):
                run.process.send_signal(number)
                waiting.remove(one)
        time.sleep(0.01)
    check(not waiting, f"all runs got so far: {[one[0] for one in waiting]}")
    for name, _, run in runs:
        done = run.wait(120)
        no_crash(done)
        check(not run.ranks(), f"{name}: no rank is left")
        yield name, run, done


def check_stop(name, run, done, ranks):
    told = done.out + (run.folder / "train.log").read_text() if (run.folder / "train.log").exists() else done.out
    check("a signal asked for it; the backup is written; continue with --restart" in told, f"{name}: the end is told: {done}")
    if ranks == 0 or name == "SIGUSR1":
        check(done.code == EXIT_STOPPED, f"{name}: exit code 4: {done}")


def check_hasty(name, run, made):
    """What was killed goes on from a whole backup, or has none."""
    run.write("run.ini", merged(sphere(), {"Time": {"nt": made + 5}}))
    done = run.flusi("run.ini", "--restart")
    no_crash(done)
    check(done.code == EXIT_OK or "there is no valid backup" in done.err, f"{name}: {done}")


def test_flusi(case):
    def prepare(run):
        run.write("run.ini", merged(sphere(), {"Time": {"nt": 999999}}))
        return ["run.ini"]

    for ranks in (2, 0):
        for name, run, done in ended_by(case, LAUNCHERS, ranks, prepare, lambda run: steps(run) > 2):
            if kills_soon(run, name, ranks):
                check_hasty(name, run, steps(run))
                continue
            check_stop(name, run, done, ranks)
            saved = int(run.contents(run.newest_checkpoint())["step"][0])
            check(saved >= steps(run) > 2, f"{name}: the last step is saved: {saved} of {steps(run)}")
            run.write("run.ini", merged(sphere(), {"Time": {"nt": saved + 2}}))
            run.run("run.ini", "--restart")


def test_nohup(case):
    """What is ignored remains ignored: a run behind nohup outlives the terminal."""
    case.write("run.ini", merged(sphere(), {"Time": {"nt": 999999}}))
    old = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # a child inherits that
    case.start("run.ini")
    signal.signal(signal.SIGHUP, old)
    case.wait_for_steps(3)
    case.process.send_signal(signal.SIGHUP)
    before = steps(case)
    case.wait_for_steps(before + 20)
    case.process.send_signal(signal.SIGUSR1)
    check(case.wait().code == EXIT_STOPPED, "another signal ends it")


def test_train(case):
    case.program = TRAIN

    def prepare(run):
        replicate(run)
        run.write("train.ini", training(CMAES={"max_generations": 5000, "max_evaluations": 100000, "restarts": "ipop",
                                               "max_restarts": 30}))
        return ["train.ini"]

    def ready(run):
        return re.search(r"^generation +[3-9]", run.out.read_text(), re.M)

    for ranks in (2, 0):
        for name, run, done in ended_by(case, LAUNCHERS, ranks, prepare, ready):
            if not kills_soon(run, name, ranks):
                check_stop(name, run, done, ranks)
            elif not any("backup" in file for file in run.files()):
                continue
            run.write("train.ini", training(CMAES={"max_generations": 1, "max_evaluations": 100000, "restarts": "ipop",
                                                   "max_restarts": 30}, Saving={"wtimemax": 1e-9}))
            done = run.run("train.ini", "--restart", code=EXIT_STOPPED)
            check("restart   after" in done.out, f"{name}: the training goes on: {done.out}")


def test_diagnose(case):
    """A diagnosis keeps its journal at all times: the signal ends it, and it goes on from there."""
    case.program = DIAGNOSE

    def prepare(run):
        synthesise(run, text=input_text("no", draws=500))
        return ["diagnose.ini"]

    def ready(run):
        journal = run.folder / "diagnosis.journal"
        return journal.exists() and journal.stat().st_size > 100000

    for ranks in (2, 0):
        for name, run, done in ended_by(case, LAUNCHERS, ranks, prepare, ready, env={}):
            check("diagnosis.journal" in run.files() and "diagnosis.json" not in run.files(), f"{name}: {run.files()}, {done}")
            if (name, ranks) in (("SIGTERM", 2), ("SIGINT", 0)):
                done = run.flusi("diagnose.ini", timeout=300)
                check("this diagnosis continues it" in done.err and done.code == EXIT_OK, f"{name}: it goes on: {done}")


main(globals())
