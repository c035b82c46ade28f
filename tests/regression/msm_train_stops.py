#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_train: what a kill, a signal or the wall clock ends, goes on to the same end; what is told on the way.

usage: msm_train_stops.py <msm_train> <h5dump> <write_replicate> [tests]
"""
import contextlib
import os
import pty
import random
import re
import shutil
import signal
import subprocess
import time

from training_case import quick, replicate, same_outcome, training
from whole_program import ALIVE, EXIT_OK, EXIT_STOPPED, EXIT_UNWRITABLE, EXIT_USER, Finished, check, main, merged, no_crash


def wait_for(case, n, told):
    """Waits until the run that `start` began has told a number of at least n, and a moment more."""
    end = time.monotonic() + ALIVE
    while time.monotonic() < end:
        has_ended = case.process.poll() is not None
        if any(int(g) >= n for g in re.findall(told, case.out.read_text(), re.M)):
            time.sleep(random.uniform(0, 0.05))  # about a generation
            return
        check(not has_ended, f"the run ended too early: {case.out.read_text()}{case.err.read_text()}")
        time.sleep(0.01)
    raise AssertionError("no progress")


def kill(case, ranks):
    """kill -9 of the program if it has no launcher, or of the rank that leads: all end with it. What it told until then; nothing
    if that came too late."""
    if ranks == 0:
        case.process.kill()  # nothing, if the program has ended
    elif case.ranks():
        with contextlib.suppress(ProcessLookupError, ValueError):
            os.kill(min(case.ranks()), signal.SIGKILL)
    done = case.wait_killed()
    end = time.monotonic() + ALIVE
    while case.ranks():
        check(time.monotonic() < end, "no rank outlives mpiexec")
    if re.search(r"^evaluations +\d+ in all", done.out, re.M):  # it has ended what it had to do, and writes, or has written
        return ""
    check(done.code not in (0, EXIT_STOPPED), f"it was killed: {done}")
    check("trained.ini" not in case.files(), "an unfinished training leaves no wing")
    return done.out


def terminate(case, _):
    """SIGTERM to the program without a launcher. What it told until then; nothing if that came too late."""
    case.process.send_signal(signal.SIGTERM)  # nothing, if the program has ended
    done = case.wait()
    if done.code == EXIT_OK:
        return ""
    check(done.code == EXIT_STOPPED and "continue with --restart" in done.out, f"stopped: {done}")
    check("trained.ini" not in case.files(), "an unfinished training leaves no wing")
    return done.out


def run_and(end_it, case, *words, ranks, n, told, most=10**9):
    """Ends a run once it has told n, and begins anew from the same files where a busy machine was late with it: the run has
    ended, or told more than `most`."""
    before = case.folder.with_name(case.folder.name + "_before")
    shutil.copytree(case.folder, before)
    for _ in range(20):
        case.start("train.ini", *words, ranks=ranks)
        wait_for(case, n, told)
        numbers = [int(g) for g in re.findall(told, end_it(case, ranks), re.M)]
        if numbers and max(numbers) <= most:
            shutil.rmtree(before)
            return
        shutil.rmtree(case.folder)
        shutil.copytree(before, case.folder)
    raise AssertionError(f"never in time: {words} on {ranks} ranks, {n} of {told}")


def test_kill(case):
    """Killed on two ranks, and stopped by a signal, at random: the restarted runs are the undisturbed one to the bit."""
    whole, killed = case.sub("whole"), case.sub("killed")
    ini = quick(CMAES={"max_generations": 9, "restarts": "ipop", "max_restarts": 1, "lambda": 5, "max_evaluations": 150})
    for one in (whole, killed):
        replicate(one)
        one.write("train.ini", ini)
    done = whole.run("train.ini", ranks=0)
    # No candidate of so short a search meets heights to the declared 0.1 um.
    for text in (done.out, (whole.folder / "trained.ini").read_text()):
        check("warning: the fit does not agree with the declared errors" in text, f"what does not fit is told:\n{text}")
    told = r"^generation +\d+  evaluations +(\d+) "
    first, second = random.randint(10, 20), random.randint(30, 80)  # the backup of generation 1, of 5 candidates, is written then
    print(f"killed after {first} evaluations or a little later, stopped after {second}")
    run_and(kill, killed, ranks=2, n=first, told=told, most=100)  # of 135, which leaves some to stop in
    run_and(terminate, killed, "--restart", ranks=0, n=second, told=told)
    killed.write("short.ini", merged(ini, {"Saving": {"wtimemax": 1e-9}}))
    done = killed.run("short.ini", "--restart", ranks=0, code=EXIT_STOPPED)
    check("wall time" in done.out, f"the wall time is over at once:\n{done.out}")
    done = killed.run("train.ini", "--restart", ranks=2)
    check("restart   after" in done.out, done.out)
    same_outcome(whole, killed)
    killed.run("train.ini", "--restart", ranks=0)  # nothing is left to search
    same_outcome(whole, killed)
    check("trained.ini.earlier" in killed.files(), "what it had trained moved aside, so that no kill leaves it there")
    killed.write("other.ini", merged(ini, {"Train": {"seed": 2}}))
    done = killed.run("other.ini", "--restart", ranks=0, code=EXIT_USER)
    check("does not fit this input" in done.err and "[Train] seed = 2, was " in done.err, f"what differs is told:\n{done.err}")
    done = killed.run("train.ini", ranks=0, code=EXIT_USER)
    check("this folder has the results of run" in done.err, f"a new training does not take the place of another:\n{done.err}")


def test_kill_polish(case):
    """Killed in the polish on three ranks, and again while an interval is sought: the restart does both anew, to the bit."""
    whole, killed = case.sub("whole"), case.sub("killed")
    ini = training(CMAES={"max_generations": 1}, Polish={"starts": 1})
    for one in (whole, killed):
        replicate(one)
        one.write("train.ini", ini)
    whole.run("train.ini", ranks=0)
    point, interval = random.randint(2, 8), random.randint(1, 2)
    print(f"killed at point {point} of the polish, and in interval {interval}")
    for words, ranks, told, n in ((), 3, r"^polish from start 1 of at most 1  evaluations +(\d+) ", point), \
            (("--restart",), 0, r"^interval (\d) of 3, ", interval):
        run_and(kill, killed, *words, ranks=ranks, n=n, told=told)
    done = killed.run("train.ini", "--restart", ranks=0)
    check("restart   after" in done.out and "generation" not in done.out, f"the search is not repeated:\n{done.out}")
    same_outcome(whole, killed)


def test_stop_in_moves(case):
    """Stopped by a signal while parameters are moved, twice: each restart continues after the moves that have ended, on one rank
    and on two, and the outcome is that of an undisturbed run, to the bit."""
    whole, stopped = case.sub("whole"), case.sub("stopped")
    ini = training(CMAES={"max_generations": 1}, Polish={"starts": 1, "intervals": "no"})
    for one in (whole, stopped):
        replicate(one, **{"joint:C_Sc": 3e-4})  # no wing of three parameters fits it
        one.write("train.ini", ini)
    done = whole.run("train.ini", ranks=0)
    check("moves of single parameters" in done.out, f"parameters are moved:\n{done.out}")
    told = r"^polish from move (\d) of at most 3 "
    for words, n in ((), 2), (("--restart",), 3):
        run_and(terminate, stopped, *words, ranks=0, n=n, told=told)
    for ranks in 2, 0:
        done = stopped.run("train.ini", "--restart", ranks=ranks)
        check(re.search(r"^restart   continues after \d+ moves of single parameters", done.out, re.M) is not None
              and "polish from start" not in done.out, f"the moves continue:\n{done.out}")
        same_outcome(whole, stopped)
    stopped.write("other.ini", merged(ini, {"Polish": {"prior_decades": 0.9}}))
    done = stopped.run("other.ini", "--restart", ranks=0)
    check("continues after" not in done.out, f"another polish begins anew:\n{done.out}")


def test_terminal(case):
    """On a terminal lines move, and the log has no more of them than elsewhere; a value at a bound is said to be there."""
    replicate(case)
    joint = "joint:R4+5_base"
    case.write("train.ini", training(Train={"parameters": f"E 4e9 3e10, {joint} 1e-4 1e-3"}, CMAES={"max_generations": 20},
                                     Polish={"intervals": "no", "starts": 1}, Saving={"progress_interval": 3600}))
    leader, follower = pty.openpty()
    with subprocess.Popen([case.program, "train.ini"], cwd=case.folder, stdin=subprocess.DEVNULL, stdout=follower,
                          stderr=follower) as run:
        os.close(follower)
        out = ""
        try:
            while True:
                out += os.read(leader, 4096).decode()
        except OSError:  # that is how a terminal ends
            os.close(leader)
        check(run.wait() == 0, out)
    moves = out.count("\rgeneration") + out.count("\rpolish from")
    log = (case.folder / "train.log").read_text()
    filed = len(re.findall("^generation|^polish from", log, re.M))
    check(moves >= 2 and filed == 1, f"{moves} lines on the terminal, the first of an hour in the log, not {filed}")
    # The truth, 3e-5, is outside.
    for text in (out, log, (case.folder / "trained.ini").read_text()):
        check(f"{joint}: at the lower bound: 1.000000E-04 N m/rad" in text, text)


def on_small_disk(case, free):
    """The training on a disk with `free` kB left, or nothing where it is not allowed to mount one: exit code and messages."""
    (case.folder / "small").mkdir(exist_ok=True)
    script = (f"mount -t tmpfs -o size=20m tmpfs small 2> /dev/null || exit 77; cp replicate.h5 train.ini small; cd small; "
              f"dd if=/dev/zero of=filler bs=1k count=$(($(df --output=avail . | tail -1) - {free})) 2> /dev/null; "
              f"exec {case.program} train.ini")
    return subprocess.run(["unshare", "-m", "bash", "-c", script], cwd=case.folder, capture_output=True, text=True, timeout=ALIVE)


def test_disk_full(case):
    """A disk that becomes full while the search is kept is told, by the name of the file; HDF5 does not end the program."""
    replicate(case)
    case.write("train.ini", quick(CMAES={"max_generations": 30}))
    told = 0
    for free in (20, 100, 300, 350, 400):
        done = on_small_disk(case, free)
        if done.returncode in (1, 77) and not done.stdout:
            print(f"no right to mount a small disk: left out. {done.stderr}")
            return
        no_crash(Finished(done.returncode, done.stdout, done.stderr))
        check(done.returncode in (EXIT_OK, EXIT_UNWRITABLE), f"with {free} kB left: {done}")
        if done.returncode == EXIT_UNWRITABLE:
            told += 1
            check("msm_train: " in done.stderr and ".h5" in done.stderr, f"with {free} kB left: {done.stderr}")
    check(told > 0, "the disk became full")


def test_stopped(case):
    """Without time left, nothing is said of loads that were not solved, and no batch is begun to its end."""
    replicate(case)
    case.write("train.ini", training())
    case.write("short.ini", training(Saving={"wtimemax": 1e-9}))
    for ini, word, ranks, env, why in (("short.ini", "--evaluate", 0, {}, "wtimemax"), ("short.ini", "--screen", 2, {}, "wtimemax"),
                                       ("train.ini", "--evaluate", 3, {"SLURM_JOB_END_TIME": "1"}, "the job ends soon")):
        done = case.run(ini, word, ranks=ranks, env=env, code=EXIT_STOPPED)
        check("stopped early" in done.out and why in done.out, f"the end is told:\n{done.out}")
        check("no equilibrium" not in done.out and "load_" not in done.out, f"and nothing of loads:\n{done.out}")


main(globals())
