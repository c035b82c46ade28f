#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_diagnose goes on where a kill has ended it, also while it compares two meshes: the verdict is that of an undisturbed
diagnosis to the byte, on whatever number of ranks, and no verdict of before is left meanwhile.

usage: msm_diagnose_kill.py <msm_diagnose> <h5dump> [tests]     in the environment FLUSI_TEST_SEED repeats the kills, and
FLUSI_TEST_KILLS tells how many of each test
"""
import contextlib
import json
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import time

from gradient_case import CASE, input_text, synthesise
from whole_program import EXIT_OK, EXIT_USER, SOURCE, check, main, no_crash, same_files

JOURNAL = "diagnosis.journal"
KILLS = int(os.environ.get("FLUSI_TEST_KILLS", "2"))


MODES = {"wing": CASE["wing"], "modes": 3, "seed": 4, "medium": "vacuum", "sites": 4, "stiffness": {"plate": "edges"},
         "noise": {"frequency": 0.003, "shape": 0.02}, "refine": 1, "mass": {"membrane": 1.4}}
COMPARED, UNKNOWN = "notice: a mesh of half the size changes the motion", "notice: the error of the mesh is not estimated"
HEADER = RECORD = 32  # bytes of the journal, see io_journal


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


def vibration(case):
    """Natural modes of a wing of a finer mesh, so that the error of the mesh decides which mesh the fits use."""
    (case.folder / "modes.json").write_text(json.dumps(MODES))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_modes", "modes.json", "-o", "modes.h5"], cwd=case.folder, check=True,
                   stdout=subprocess.DEVNULL)
    text = input_text("auto", draws=500).replace("bending.h5", "modes.h5").replace("E, joint:C_Sc, joint:R4+5_r-m", "E")
    case.write("diagnose.ini", text + "noise = declared;\n")


def until(case, ranks, is_there):
    """Starts a diagnosis and kills it as soon as is_there() holds."""
    case.start("diagnose.ini", ranks=ranks)
    while case.process.poll() is None and not is_there():
        time.sleep(0.001)
    check(case.process.poll() is None, f"it ended too early: {case.err.read_text()}")
    told = case.err.read_text()
    for process in [case.process.pid] if ranks == 0 else case.ranks():
        os.kill(process, signal.SIGKILL)
    no_crash(case.wait_killed())
    return told


def scrambled(word, position):
    """As in base_checksum."""
    left, right, low = word >> 32, word & 0xFFFFFFFF, 0xFFFFFFFF
    for number, factor in enumerate((0x7FEB352D, 0x46CA6B6B, 0x5F356495, 0x2C1B3C6D), 1):
        mixed = ((right ^ ((position & low if number % 2 else position >> 32) + 16777619 * number)) & low) * factor & low
        left, right = right, left ^ mixed ^ mixed >> 15
    return left << 32 | right


def deny(path):
    """Makes every answer of a journal "there is no result", and returns how many answers it has with numbers."""
    data, at, n = bytearray(path.read_bytes()), HEADER, 0
    while at + RECORD <= len(data):
        _, count, is_valid, total = struct.unpack_from("<QQQQ", data, at)
        if is_valid and count:
            struct.pack_into("<QQ", data, at + 16, 0, (total - scrambled(1, 2) + scrambled(0, 2)) % 2**64)
            n += 1
        at += RECORD + 8 * count
    path.write_bytes(data)
    return n


def test_kill_comparison(case):
    """Killed while it compares two meshes: the answers that it had are those of the next start, as one learns from a journal that says
    that there are none. Killed again after the comparison; other ranks end it, and all is the same to the byte."""
    whole, killed = case.sub("whole"), case.sub("killed")
    for one in whole, killed:
        vibration(one)
    whole.start("diagnose.ini", ranks=2)
    compared = largest = 0
    while whole.process.poll() is None:
        largest = max(largest, size(whole))
        if not compared and COMPARED in whole.err.read_text():
            compared = size(whole)
        time.sleep(0.001)
    done = whole.wait()
    check(done.code == EXIT_OK and HEADER < compared < largest, f"{compared} of {largest} bytes are of the comparison: {done}")
    told = until(killed, 0, lambda: size(killed) > 0.4 * compared)
    check(COMPARED not in told and "continues it" not in told, f"it was comparing: {told}")
    denied = case.sub("denied")
    shutil.copytree(killed.folder, denied.folder, dirs_exist_ok=True)
    n = deny(denied.folder / JOURNAL)
    print(f"      killed with {n} answers, {size(killed)} of {compared} bytes of the comparison, {largest} in all", flush=True)
    check(n > 0, "it had answers")
    told = until(denied, 0, lambda: UNKNOWN in denied.err.read_text() or COMPARED in denied.err.read_text())
    check("continues it" in told and UNKNOWN in told, f"the next start takes them: {told}")
    told = until(killed, 3, lambda: size(killed) > compared + 0.5 * (largest - compared))
    check("continues it" in told and COMPARED in told, f"the fits have begun: {told}")
    check("diagnosis.json" not in killed.files(), "and not ended")
    begun = time.monotonic()
    done = killed.flusi("diagnose.ini", ranks=1, timeout=300)
    print(f"      {time.monotonic() - begun:.1f} s to the end", flush=True)
    check("continues it" in done.err, f"told: {done}")
    same_outcome(whole, killed)


main(globals())
