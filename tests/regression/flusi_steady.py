#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A long flight of flexible wings takes no more memory and opens no more files the longer it lasts, though it writes fields,
series and backups all the time. Only the text of the indices for ParaView, which rank 0 holds, grows with every save.

usage: flusi_steady.py <flusi> <h5dump> [tests]     in the environment FLUSI_TEST_STEPS tells how many steps, and
FLUSI_TEST_RANKS on how many ranks
"""
import os
import re
import time
from pathlib import Path

from flight_case import FLIGHT
from whole_program import EXIT_STOPPED, check, main, merged, series

STEPS = int(os.environ.get("FLUSI_TEST_STEPS", "60"))
RANKS = int(os.environ.get("FLUSI_TEST_RANKS", "2"))
# The allocator of the system keeps some memory back in each new size of block: the heap of a rank moves by less than this. A field
# of a backup is 0.13 MB on one rank: one that is lost in each of 40 backups is five times as much.
SLACK = 1.0  # MB
TEXTS = 3  # times the size of the indices: a text that grows leaves holes of its size behind
MORE_FILES = 2  # that happen to be open in all looks: a backup and a field


def steps_of(case):
    try:
        return len(series(case.folder / "timesteps_info.t").rows)
    except FileNotFoundError:
        return 0


def indices(case):
    """MB of the indices."""
    return sum(path.stat().st_size for path in case.folder.glob("*.xmf")) / 1e6


def state(case):
    """MB and open descriptors of every rank, by process; the least of a few looks, for a file may be open."""
    found = {}
    for _ in range(20):
        for process in case.ranks():
            try:
                status = Path(f"/proc/{process}/status").read_text()
                count = len(os.listdir(f"/proc/{process}/fd"))
            except OSError:
                continue
            resident = int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) / 1024
            old = found.get(process, (resident, count))
            found[process] = min(old[0], resident), min(old[1], count)
        time.sleep(0.02)
    return found


def state_at(case, step):
    while steps_of(case) < step:
        check(case.process.poll() is None, f"the run goes on: {case.err.read_text()}")
        time.sleep(0.05)
    return state(case)


def test_steady(case):
    case.write("run.ini", merged(FLIGHT, {
        "Time": {"nt": 999999}, "Saving": {"tsave": 0.048, "iSaveVelocity": "yes", "iSavePress": "yes", "iSaveMask": "yes",
                                           "truntime": 1e-9 if STEPS < 1000 else 1e-3}}))
    case.start("run.ini", ranks=RANKS)
    early = state_at(case, STEPS // 10 if STEPS >= 1000 else STEPS // 3)
    texts = indices(case)
    late = state_at(case, STEPS)
    slack = SLACK + TEXTS * (indices(case) - texts)
    (case.folder / "runtime_control.ini").write_text("[runtime_control]\nruntime_control=save_stop;\n")
    done = case.wait(120)
    check(done.code == EXIT_STOPPED, f"it stops when told: {done}")
    check(early.keys() == late.keys() and len(early) == RANKS, f"all ranks are there: {early}, {late}")
    for process, (memory, files) in early.items():
        print(f"      {memory:.2f} MB, then {late[process][0]:.2f} MB; {files} open files, then {late[process][1]}", flush=True)
    for process, (memory, files) in early.items():
        check(late[process][0] <= memory + slack, f"memory is constant: {memory} MB, then {late[process][0]} MB")
        check(late[process][1] <= files + MORE_FILES, f"open files are closed: {files}, then {late[process][1]}")


main(globals())
