#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A run that is killed at random instants, while it backs up after every step, and restarted each time, ends as if nothing
had happened: to the bit on the same number of ranks, but for round-off on others.

usage: flusi_kill.py <flusi> <h5dump> [tests]     in the environment FLUSI_TEST_SEED repeats the kills, and FLUSI_TEST_KILLS
tells how many of each test
"""
import contextlib
import os
import random
import re
import signal
import time

from flight_case import FLIGHT, LAST_DIGIT, differences, same_flight
from whole_program import ALIVE, check, main, merged, no_crash, same_runs, sphere

KILLS = int(os.environ.get("FLUSI_TEST_KILLS", "20"))
INI = sphere(Penalization={"unst_corrections": "yes", "us_fixed": "0.1 0.0 0.0"},
             MeanFlow={"iMeanFlow": None, "iMeanFlow_x": "dynamic", "m_fluid": 50.0},
             Saving={"tsave": 0.03, "iSavePress": "yes", "truntime": 1e-9})


def backups(case):
    """Identities of the backup files; a new backup is a new file."""
    return [(n, (case.folder / n).stat().st_mtime_ns) for n in case.files() if re.fullmatch(r"runtime_backup\d\.h5", n)]


def kill(case, delay, n):
    """Kills all n ranks at once, `delay` seconds from now or as soon as they exist; says what was under way."""
    time.sleep(delay)
    end = time.monotonic() + ALIVE
    while len(case.ranks()) < n and time.monotonic() < end:
        check(case.process.poll() is None, f"the run goes on until it is killed:\n{case.err.read_text()}")
    ranks = case.ranks()
    check(len(ranks) == n, f"all ranks are found: {ranks}")
    for process in ranks:
        with contextlib.suppress(ProcessLookupError):  # the launcher has ended it, as another rank is dead
            os.kill(process, signal.SIGKILL)
    done = case.wait_killed()
    check(done.code not in (0, 4), f"the run was killed: {done.code}")
    no_crash(done)
    return sorted(name for name in case.files() if name.endswith(".part"))


def kill_often(part, ini, choices):
    """Kills a run KILLS times, on numbers of ranks that are drawn from `choices`. The step that the last backup holds."""
    seed = int(os.environ.get("FLUSI_TEST_SEED", time.time()))
    dice = random.Random(seed)
    print(f"      seed {seed}", flush=True)
    part.write("run.ini", merged(ini, {"Time": {"nt": 999999}, "Saving": {"truntime": 1e-9}}))
    steps = 0
    for i in range(KILLS):
        before = backups(part)
        n = dice.choice(choices)
        part.start("run.ini", *(["--restart"] if i else []), ranks=n)
        # Every third kill may hit the start, where a restart reads the backup and rewrites the series; the
        # others come after the first backup of their run.
        while i % 3 != 2 and backups(part) == before:
            check(part.process.poll() is None, f"the run goes on:\n{part.err.read_text()}")
            time.sleep(0.005)
        left = kill(part, dice.uniform(0, 0.4), n)
        saved = int(part.contents(part.newest_checkpoint())["step"][0])
        check(saved >= steps + (i % 3 != 2), f"nothing that was saved is lost: step {saved} after {steps}")
        steps = saved
        print(f"      kill {i + 1} on {n} ranks: step {steps} is saved, unfinished: {' '.join(left) or 'nothing'}", flush=True)
    return steps


def test_kill(case):
    """On two ranks, to the bit."""
    part = case.sub("killed")
    last = kill_often(part, INI, (2,)) + 10
    part.write("run.ini", merged(INI, {"Time": {"nt": last}}))
    part.run("run.ini", "--restart", ranks=2)
    whole = case.sub("whole")
    whole.write("run.ini", merged(INI, {"Time": {"nt": last}, "Saving": {"truntime": 1}}))
    whole.run("run.ini", ranks=2)
    same_runs(whole, part)
    part.check_index("run.xmf")
    check(not [n for n in part.files() if n.endswith(".part")], "no unfinished file is left")


def test_kill_ranks(case):
    """Flexible wings, each time on another number of ranks."""
    part = case.sub("killed")
    last = kill_often(part, FLIGHT, (1, 2, 3)) + 3
    part.write("run.ini", merged(FLIGHT, {"Time": {"nt": last}}))
    part.run("run.ini", "--restart", ranks=3)
    whole = {}
    for ranks in (1, 2, 3):
        whole[ranks] = case.sub(f"whole_{ranks}")
        whole[ranks].write("run.ini", merged(FLIGHT, {"Time": {"nt": last}}))
        whole[ranks].run("run.ini", ranks=ranks, timeout=300)
    # Ranks change the order of sums, and the motion amplifies that step by step. Flights that were not killed tell by how
    # much. The killed one draws its orders anew, so it may be further away, but not ten times.
    apart = max(max(differences(whole[1], whole[n], last).values()) for n in (2, 3))
    print(f"      numbers of ranks are {apart:.1e} apart after {last} steps", flush=True)
    same_flight(whole[2], part, last, tolerance=max(LAST_DIGIT, 10 * apart))


main(globals())
