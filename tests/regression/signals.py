#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""TERM, INT, HUP and USR1, to the launcher or to a program without one, end a run with a backup from which it goes on.

usage: signals.py <flusi> <h5dump> <write_replicate> <msm_train> <msm_diagnose> [tests]

Open MPI 4 turns TERM, INT and HUP into a TERM for its ranks, and kills them `odls_base_sigkill_timeout` seconds later; before the
TERM it waits as long. The tests give some seconds, and await all signals at once. What a busy machine has not ended by then is tried again
with more seconds. Open MPI 5 kills them after 0.2 seconds,
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
STOP = "a signal asked for it; the backup is written; continue with --restart"
LAUNCHERS = signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGUSR1
SECONDS = 8, 60  # between TERM and KILL, in the first trial and in the second


def kills_soon(case, name, ranks):
    """Whether the launcher kills the ranks of a run that gets this signal before they can end by themselves."""
    if ranks == 0 or name == "SIGUSR1":
        return False
    said = subprocess.run([case.mpiexec, "--version"], stdout=subprocess.PIPE, text=True).stdout
    version = re.search(r"Open MPI\D* (\d+)\.", said)
    return version is not None and int(version.group(1)) >= 5


def steps(case):
    with contextlib.suppress(FileNotFoundError):
        return len(series(case.folder / "timesteps_info.t").rows)
    return 0


def patience(seconds):
    return {"OMPI_MCA_odls_base_sigkill_timeout": str(seconds)}


def told(run, done):
    """What a run has told of its end."""
    log = run.folder / "train.log"
    return done.out + log.read_text() if log.exists() else done.out


def stopped_by(case, signals, ranks, prepare, ready):
    """What `ended_by` gives. A rank that the launcher has killed before it could tell its end has another, longer trial."""
    late = []
    for name, run, done in ended_by(case, signals, ranks, prepare, ready, patience(SECONDS[0])):
        if ranks > 0 and name != "SIGUSR1" and STOP not in told(run, done) and not kills_soon(run, name, ranks):
            print(f"      {name} on {ranks} ranks: killed after {SECONDS[0]} s", flush=True)
            late.append(signal.Signals[name])
        else:
            yield name, run, done
    yield from ended_by(case, late, ranks, prepare, ready, patience(SECONDS[1]))


def ended_by(case, signals, ranks, prepare, ready, env):
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
        done = run.wait()
        no_crash(done)
        end = time.monotonic() + ALIVE
        while run.ranks():  # a rank that the launcher has killed needs a moment to end
            check(time.monotonic() < end, f"{name}: no rank is left")
            time.sleep(0.01)
        yield name, run, done


def check_stop(name, run, done, ranks):
    check(STOP in told(run, done), f"{name}: the run must say that it stopped and how to continue: {done}")
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
        for name, run, done in stopped_by(case, LAUNCHERS, ranks, prepare, lambda run: steps(run) > 2):
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
        for name, run, done in stopped_by(case, LAUNCHERS, ranks, prepare, ready):
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
