#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Trainings that are killed again and again at random instants, each time on another number of ranks, end as if nothing had
happened.

usage: msm_train_kills.py <msm_train> <h5dump> <write_replicate> [tests]     in the environment FLUSI_TEST_SEED repeats the kills,
and FLUSI_TEST_KILLS tells how many
"""
import os
import random
import re
import signal
import time

from training_case import replicate, same_outcome, training
from whole_program import check, main, no_crash

KILLS = int(os.environ.get("FLUSI_TEST_KILLS", "6"))
CHAIN = 8  # kills of one training
# A search with a restart, then a polish with intervals: a search is resumed, a polish begins anew.
INI = training(CMAES={"max_generations": 12, "restarts": "ipop", "max_restarts": 1, "lambda": 5, "max_evaluations": 150},
               Polish={"starts": 1})


def backups(case):
    """Identities of the backup files; a new backup is a new file."""
    return [(n, (case.folder / n).stat().st_mtime_ns) for n in case.files() if re.fullmatch(r"train_backup\d\.h5", n)]


def kill(case, words, ranks, dice, needs_backup):
    """kill -9 of all ranks, after a new backup if one is needed. Whether that was in time; the run has ended otherwise."""
    before = backups(case)
    begun = time.monotonic()
    case.start("train.ini", *words, ranks=ranks)
    while needs_backup and case.process.poll() is None and backups(case) == before and time.monotonic() < begun + 20:
        time.sleep(0.005)
    time.sleep(dice.uniform(0, 1.0))
    for process in case.ranks():
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            pass
    done = case.wait_killed()
    no_crash(done)
    check(done.code not in (2, 3, 4, 5), f"nothing but the kill ends it: {done}")
    if re.search(r"^evaluations +\d+ in all", done.out, re.M):  # it writes what it has found, or has written
        return False
    check("trained.ini" not in case.files(), "an unfinished training leaves no wing")
    return True


def test_kills(case):
    seed = int(os.environ.get("FLUSI_TEST_SEED", time.time()))
    dice = random.Random(seed)
    print(f"      seed {seed}", flush=True)
    whole = case.sub("whole")
    replicate(whole)
    whole.write("train.ini", INI)
    whole.run("train.ini", ranks=0, timeout=300)
    n, resumed, trainings = 0, 0, 0
    while n < KILLS:
        killed = case.sub("killed")
        replicate(killed)
        killed.write("train.ini", INI)
        trainings += 1
        for k in range(min(CHAIN, KILLS - n)):
            words = ["--restart"] if backups(killed) else ["--overwrite"]
            resumed += words == ["--restart"]
            ranks = dice.choice((0, 2, 3))
            if not kill(killed, words, ranks, dice, k % 3 != 2):
                break
            n += 1
            print(f"      kill {n}: {ranks} ranks, {' '.join(words)}", flush=True)
        words = ["--restart"] if backups(killed) else ["--overwrite"]
        killed.run("train.ini", *words, ranks=dice.choice((0, 2, 3)), timeout=300)
        same_outcome(whole, killed)
    print(f"      {n} kills of {trainings} trainings, {resumed} times resumed from a backup", flush=True)


main(globals())
