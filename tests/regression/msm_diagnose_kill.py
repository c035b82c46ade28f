#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_diagnose goes on where a kill has ended it: the verdict is that of an undisturbed diagnosis to the byte, on whatever
number of ranks, and no verdict of before is left meanwhile.

usage: msm_diagnose_kill.py <msm_diagnose> <h5dump> [tests]     FLUSI_TEST_SEED in the environment repeats the kills
"""
import json
import os
import random
import signal
import subprocess
import sys
import time

from whole_program import EXIT_USER, SOURCE, check, main, no_crash, same_files

CASE = {
    "wing": str(SOURCE / "wings/calliphora_small.h5"), "seed": 3, "spacing": 3e-4,
    "loads": [[0.00541, 0.00005, 6.0e-4], [0.00721, -0.00032, 1.6e-4], [0.00856, -0.00078, 1.0e-4]],
    "protocol": {"levels": [1, -1], "random_order": True},
    "stiffness": {"plate": "edges", "E": 9.0e9, "joints": {"C_Sc": 1.0e-6}, "E_gradient": -1.2},
    "noise": {"height": 1.0e-5, "tilt": 1.0e-3, "piston": 5.0e-6, "reference_scans": 4},
}
INPUT = f"""[Wing]
file = {CASE["wing"]};
[Measurement]
file = bending.h5;
[Diagnose]
parameters = E, joint:C_Sc, joint:R4+5_r-m;
observations = 400;
refine = REFINE;
starts = 1;
draws = 500;
refits = 2;
validation = no;
intervals = yes;
"""
JOURNAL = "diagnosis.journal"
KILLS = int(os.environ.get("FLUSI_TEST_KILLS", "2"))


def synthesise(case, refine):
    (case.folder / "case.json").write_text(json.dumps(CASE))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_measurement", "case.json", "-o", "bending.h5"],
                   cwd=case.folder, check=True, stdout=subprocess.DEVNULL)
    case.write("diagnose.ini", INPUT.replace("REFINE", refine))


def size(case):
    path = case.folder / JOURNAL
    return path.stat().st_size if path.exists() else 0


def kill(case, ranks, dice, whole):
    """kill -9 of the rank that leads, or of the program if it has no launcher, at an instant after which the journal has
    grown by a random part of the size `whole` that it ends with. Whether that was in time."""
    wanted = size(case) + dice.uniform(0, 0.3) * whole
    case.start("diagnose.ini", ranks=ranks)
    while case.process.poll() is None and size(case) < wanted:
        time.sleep(0.002)
    victims = [case.process.pid] if ranks == 0 else case.ranks()
    for process in victims:
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            pass
    done = case.wait(120)
    no_crash(done)
    if "diagnosis.json" in case.files():
        return False
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
    whole, killed = case.sub("whole"), case.sub("killed")
    synthesise(whole, refine)
    synthesise(killed, refine)
    begun, largest = time.monotonic(), 0
    whole.start("diagnose.ini", ranks=2)
    while whole.process.poll() is None:
        largest = max(largest, size(whole))
        time.sleep(0.01)
    done = whole.wait()
    check(done.code >= 10, f"a verdict: {done}")
    print(f"      seed {seed}; undisturbed: {time.monotonic() - begun:.1f} s, journal of {largest / 1e6:.1f} MB", flush=True)
    n = 0
    for k in range(KILLS):
        if not kill(killed, (2, 0, 3)[k % 3], dice, largest):
            break
        n += 1
    if "diagnosis.json" not in killed.files():
        begun = time.monotonic()
        done = killed.flusi("diagnose.ini", ranks=1, timeout=300)
        check("of a diagnosis of the same inputs that did not end; this one goes on with it" in done.err, f"told: {done}")
        print(f"      {n} kills, then {time.monotonic() - begun:.1f} s to the end", flush=True)
    same_outcome(whole, killed)
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
        killed.write("diagnose.ini", INPUT.replace("REFINE", "no").replace("seed = 1", "seed = 2").replace("observations = 400",
                                                                                                           "observations = 300"))
        done = killed.flusi("diagnose.ini", timeout=300)
        check("goes on" not in done.err and done.code != EXIT_USER, f"another diagnosis begins anew: {done.err}")
        check((whole.folder / "diagnosis.json").read_bytes() != (killed.folder / "diagnosis.json").read_bytes(), "it differs")


def test_kill_band(case):
    """Killed at random, with the mesh's error: two meshes, in turn."""
    kills(case, "yes")


main(globals())
