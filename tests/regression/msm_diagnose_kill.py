#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_diagnose goes on where a kill has ended it: the verdict is that of an undisturbed diagnosis to the byte, on whatever
number of ranks, and no verdict of before is left meanwhile.

usage: msm_diagnose_kill.py <msm_diagnose> <h5dump> [tests]     in the environment FLUSI_TEST_SEED repeats the kills, and
FLUSI_TEST_KILLS tells how many of each test
"""
import contextlib
import os
import random
import signal
import time

from gradient_case import input_text, synthesise
from whole_program import EXIT_OK, EXIT_USER, check, main, no_crash, same_files

JOURNAL = "diagnosis.journal"
KILLS = int(os.environ.get("FLUSI_TEST_KILLS", "2"))


def text_of(refine):
    return input_text(refine, draws=500, intervals="yes")


def size(case):
    with contextlib.suppress(FileNotFoundError):  # it goes when the diagnosis ends
        return (case.folder / JOURNAL).stat().st_size
    return 0


def kill(case, ranks, dice, whole):
    """kill -9 of the rank that leads, or of the program if it has no launcher, at an instant after which the journal has
    grown by a random part of the size `whole` that it ends with. Whether that was in time."""
    wanted = size(case) + dice.uniform(0, 0.15) * whole
    case.start("diagnose.ini", ranks=ranks)
    while case.process.poll() is None and size(case) < wanted:
        time.sleep(0.002)
    victims = [case.process.pid] if ranks == 0 else case.ranks()
    for process in victims:
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            pass
    done = case.wait_killed()
    no_crash(done)
    if JOURNAL not in case.files():  # it has ended
        return False
    if "diagnosis.json" in case.files():  # which is written last
        check("diagnosis.h5" in case.files() and "diagnosis_extended.ini" in case.files(), f"a verdict is whole: {case.files()}")
    check(size(case) > 0, f"what was computed is kept: {case.files()}")
    return True


def same_outcome(whole, killed):
    for name in ("diagnosis.json", "diagnosis_extended.ini"):
        check((whole.folder / name).read_bytes() == (killed.folder / name).read_bytes(), f"{name} is the same to the byte")
    check(same_files(whole.folder / "diagnosis.h5", killed.folder / "diagnosis.h5"), "the maps are the same to the bit")
    check(JOURNAL not in killed.files() and JOURNAL not in whole.files(), "no journal is left of what has ended")


def kills(case, refine):
    seed = int(os.environ.get("FLUSI_TEST_SEED", time.time()))
    dice = random.Random(seed)
    whole = case.sub("whole")
    synthesise(whole, text=text_of(refine))
    begun, largest = time.monotonic(), 0
    whole.start("diagnose.ini", ranks=2)
    while whole.process.poll() is None:
        largest = max(largest, size(whole))
        time.sleep(0.01)
    done = whole.wait()
    check(done.code == EXIT_OK and "verdict   adequate" not in done.out, f"a cause: {done}")
    print(f"      seed {seed}; undisturbed: {time.monotonic() - begun:.1f} s, journal of {largest / 1e6:.1f} MB", flush=True)
    n, chains = 0, 0
    while n < KILLS:
        killed = case.sub("killed")
        synthesise(killed, text=text_of(refine))
        chains += 1
        of_this = 0
        while n < KILLS and kill(killed, (2, 0, 3)[n % 3], dice, largest):
            n += 1
            of_this += 1
        if JOURNAL in killed.files():
            begun = time.monotonic()
            done = killed.flusi("diagnose.ini", ranks=1, timeout=300)
            check("belongs to an unfinished diagnosis of the same inputs; this diagnosis continues it" in done.err, f"told: {done}")
            print(f"      {of_this} kills, then {time.monotonic() - begun:.1f} s to the end", flush=True)
        same_outcome(whole, killed)
        check(chains < 5 * KILLS, "kills come in time")
    print(f"      {n} kills of {chains} diagnoses", flush=True)
    return whole, killed, largest


def test_kill(case):
    """Killed at random; then with a damaged journal, and with other inputs."""
    whole, killed, largest = kills(case, "no")
    (killed.folder / "diagnosis.json").unlink()
    dice = random.Random(1)
    if kill(killed, 0, dice, largest):
        path = killed.folder / JOURNAL
        data = bytearray(path.read_bytes())
        data[len(data) * 2 // 3] ^= 16
        path.write_bytes(data[:-5])
        killed.flusi("diagnose.ini", timeout=300)
        same_outcome(whole, killed)
    (killed.folder / "diagnosis.json").unlink()
    if kill(killed, 0, dice, largest):
        killed.write("diagnose.ini", text_of("no").replace("observations = 400", "observations = 300"))
        done = killed.flusi("diagnose.ini", timeout=300)
        check("continues it" not in done.err and done.code != EXIT_USER, f"another diagnosis begins anew: {done.err}")
        check((whole.folder / "diagnosis.json").read_bytes() != (killed.folder / "diagnosis.json").read_bytes(), "it differs")


def test_kill_band(case):
    """Killed at random, with the mesh's error: two meshes, in turn."""
    kills(case, "yes")


main(globals())
