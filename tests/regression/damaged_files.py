#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wing and measurement files with one flipped bit, sealed and without a seal: each is read as it was or refused with a
message, and no signal ends a program.

usage: damaged_files.py <flusi> <h5dump> <msm_train> <write_replicate> [number of flips] [tests]
FLUSI_TEST_SEED in the environment repeats the flips.
"""
import os
import random
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

TRAIN = Path(sys.argv.pop(3)).resolve()
import training_case
from whole_program import EXIT_OK, EXIT_USER, SOURCE, check, ini_text, main

FLIPS = int(sys.argv.pop(3)) if len(sys.argv) > 3 and sys.argv[3].isdigit() else 40
SEED = int(os.environ.get("FLUSI_TEST_SEED", time.time()))
SEAL, MARK = 64, 24  # bytes of a seal, and of those that say that it is one
WINGS = sorted((SOURCE / "wings").glob("*.h5"))
# Bits of the wing without its seal on which HDF5 1.10.8 crashes: number of the byte, what is changed in it.
WORST = ((18863, 2), (26121, 2), (27592, 2), (28185, 1))


def flipped(data, byte, bits):
    return data[:byte] + bytes([data[byte] ^ bits]) + data[byte + 1:]


def judge(words, folder, name):
    """Exit code of a program that reads the file: signals are negative; what it told."""
    done = subprocess.run([*map(str, words)], cwd=folder, capture_output=True, text=True, errors="replace")
    check(done.returncode in (EXIT_OK, EXIT_USER), f"{words} ends with {done.returncode}:\n{done.stdout[-400:]}{done.stderr[-800:]}")
    check((done.returncode == EXIT_USER) == ("static.ini:" in done.stderr or name in done.stderr), f"a message: {done.stderr}")
    return done.returncode, done.stderr


def wing_reader(case):
    """The words that make flusi read damaged.h5 as a wing."""
    (case.folder / "static.ini").write_text(ini_text({"Wing": {"file": "damaged.h5"}, "Mass": {"membrane_law": "uniform"},
                                                       "Loads": {"gravity": "0 0 -9.81"}}))
    return [case.program, "--static", "static.ini", "--check"]


def measurement_reader(case):
    """The words that make msm_train read damaged.h5 as a measurement; its bytes."""
    training_case.replicate(case, "damaged.h5")
    ini = training_case.quick(Measurement={"file": "damaged.h5"})
    (case.folder / "train.ini").write_text(ini_text(ini))
    return [TRAIN, "train.ini", "--check"], (case.folder / "damaged.h5").read_bytes()


def flip_all(case, dice, words, data, n, is_sealed):
    """n flips of single bits in `data`: how many files were refused, accepted and of which HDF5 would have crashed."""
    path, counts = case.folder / "damaged.h5", Counter()
    for _ in range(n):
        byte, bit = dice.randrange(len(data)), dice.randrange(8)
        path.write_bytes(flipped(data, byte, 1 << bit))
        code, told = judge(words, case.folder, "damaged.h5")
        kind = "accepted" if code == EXIT_OK else "crash averted" if "library crashes" in told else "refused"
        counts[kind] += 1
        if is_sealed:
            in_mark = len(data) - SEAL <= byte < len(data) - SEAL + MARK
            check(("differ from the checksum" in told) != in_mark and (code == EXIT_OK) == in_mark,
                  f"byte {byte}, bit {bit}: damage is told, and a seal that is none is no damage: {told}")
    return counts


def test_worst(case):
    """Bits that crashed programs."""
    words = wing_reader(case)
    data = (SOURCE / "wings/calliphora_small.h5").read_bytes()
    path = case.folder / "damaged.h5"
    path.write_bytes(data)
    check(judge(words, case.folder, "damaged.h5")[0] == EXIT_OK, "a sealed wing is read")
    path.write_bytes(data[:-SEAL])
    check(judge(words, case.folder, "damaged.h5")[0] == EXIT_OK, "a wing without a seal is read")
    for byte, bits in WORST:
        path.write_bytes(flipped(data, byte, bits))
        code, told = judge(words, case.folder, "damaged.h5")
        check(code == EXIT_USER and "damaged.h5: is damaged: its bytes differ from the checksum at its end" in told, told)
        path.write_bytes(flipped(data[:-SEAL], byte, bits))
        code, told = judge(words, case.folder, "damaged.h5")
        probe = subprocess.run([Path(case.program).parent / "msm_probe", "wing", "damaged.h5"], cwd=case.folder,
                               capture_output=True)
        print(f"      byte {byte}: msm_probe ends with {probe.returncode}, flusi says: {told.strip()[-120:]}", flush=True)
        if probe.returncode < 0:
            check(code == EXIT_USER and "the HDF5 library crashes when it reads it" in told, told)


def test_wings(case):
    dice = random.Random(SEED)
    print(f"      seed {SEED}", flush=True)
    words = wing_reader(case)
    for k, wing in enumerate(WINGS):
        data = wing.read_bytes()
        n = len(range(k, FLIPS, len(WINGS)))
        print(f"      {wing.name}: {n} flips sealed {dict(flip_all(case, dice, words, data, n, True))}, without seal "
              f"{dict(flip_all(case, dice, words, data[:-SEAL], n, False))}", flush=True)


def test_measurement(case):
    dice = random.Random(SEED + 1)
    words, data = measurement_reader(case)
    n = max(1, FLIPS // 20)  # each start of msm_train takes a second where it has no launcher
    sealed = flip_all(case, dice, words, data, n, True)
    print(f"      {n} flips sealed {dict(sealed)}, without seal "
          f"{dict(flip_all(case, dice, words, data[:-SEAL], n, False))}", flush=True)


main(globals())
