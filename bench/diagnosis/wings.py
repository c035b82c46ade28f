# SPDX-License-Identifier: GPL-3.0-or-later
"""Six coarse cases of forces on two flapping wings in space, in msm_diagnose. The data come from flusi with the other representation
of the wings (penalized, a sheet of four cells) on twice the points, with noise and the errors of a balance; the diagnosis flies
wings without thickness. Its input states the thickness of the wings of the data. docs/results/flight-study.md has the results.

usage: run_wings [--points 16] [--beats 2] [--seed 1] [--folder runs/bench_diagnosis_wings] [--programs build/release/bin]
                 [--ranks 1] [--rounds 3] [--unknown-thickness] [--cost] [CASE ...]

Cases: null, null-again, pitch_lead, stroke_amplitude, balance_gain, outside. --cost only says what they cost. Flights and verdicts
that are there are not computed again. The last line is JSON.
"""
import argparse
import json
import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from flusi_msm.errors import InputError, run_command
from flusi_msm.measurement.flight_file import write_record

ROOT = Path(__file__).resolve().parents[2]
LENGTH, FREQUENCY, DENSITY = 9.0e-3, 158.0, 1.225   # of ini/wing-rigid.ini: wing, beat, air
TIMES = (np.arange(40) + 0.5) / 40
WHITE, MODEL, SAME = 0.02, 0.10, 0.06   # of the rms of a component: noise of the mean; difference of two simulations, for this share of a beat
NAMES = ("Fx", "Fy", "Fz", "power")
GAIN = 1.3
KINEMATICS = ROOT / "ini/kinematics/calliphora.ini"
# Name: (keys of flusi or "wave", gain of the balance, seed of the noise, cause).
CASES = {"null": ("", 1.0, 1, None), "null-again": ("", 1.0, 2, None),
         "pitch_lead": ("kinematics_lead = 0.0 0.03 0.0", 1.0, 3, "pitch_lead"),
         "stroke_amplitude": ("kinematics_factor = 1.1 1.0 1.0", 1.0, 4, "stroke_amplitude"),
         "balance_gain": ("", GAIN, 5, "balance_gain"), "outside": ("wave", 1.0, 6, "outside")}
WAVE = 10.0   # degrees, third harmonic of the stroke

FLIGHT = """[include]
file = {root}/ini/wing-rigid.ini
[Resolution]
nx = {nx}
ny = {nx}
nz = {nz}
[Time]
Tmax = {beats}.0
[Insects]
surface = {surface}
FlappingMotion_left = from_file::{kinematics}
FlappingMotion_right = from_file::{kinematics}
{more}
[Wing]
file = {root}/wings/calliphora_small.h5
[Sponge]
sponge_thickness = {sponge}
[Saving]
tsave = 1000.0
tintegral = 0.005
iSaveVelocity = 0
iSaveVorticity = 0
iSaveWingSides = 0
iDoBackup = no
"""
DIAGNOSE = """[Wing]
file = {root}/wings/calliphora_small.h5
E = 12.58e9
D = 2.0e-7
[Measurement]
file = data.h5
[Flight]
file = ../case/flight.ini
folder = ../flights
ranks = 1
beats = {beats}
rounds = {rounds}
{thickness}[Diagnose]
noise = declared
[Saving]
name = diagnosis
"""


def write_diagnose(folder, options):
    """Writes diagnose.ini. The wings of the data are four cells of twice the points thick."""
    thickness = "" if options.unknown_thickness else f"wing_thickness = {4 / (2 * options.points) * LENGTH!r}\n"
    (folder / "diagnose.ini").write_text(DIAGNOSE.format(root=ROOT, beats=options.beats, rounds=options.rounds, thickness=thickness))


def write_flight(folder, points, options, hidden="", surface="thin"):
    """Writes flight.ini: two rigid wings, so many points in a length of the wing."""
    folder.mkdir(parents=True, exist_ok=True)
    kinematics = KINEMATICS
    if hidden == "wave":
        kinematics, hidden = folder / "kinematics.ini", ""
        kinematics.write_text(with_wave(KINEMATICS.read_text()))
    (folder / "flight.ini").write_text(FLIGHT.format(root=ROOT, nx=4 * points, nz=2 * points, beats=options.beats, surface=surface,
                                                     kinematics=kinematics, more=hidden, sponge=max(2, points // 4)))


def with_wave(text):
    """Returns kinematics with a third harmonic of the stroke."""
    rows = []
    for line in text.splitlines():
        key, equals, rest = line.partition("=")
        values = rest.partition(";")[0].replace(",", " ").split()
        if key.strip() == "nfft_phi":
            line = "nfft_phi = 3"
        elif key.strip() in ("ai_phi", "bi_phi") and equals:
            numbers = ([float(x) for x in values] + [0.0, 0.0])[:3]
            numbers[2] += WAVE if key.strip() == "ai_phi" else 0.0
            line = f"{key.strip()} = " + " ".join(map(repr, numbers))
        rows.append(line)
    return "\n".join(rows) + "\n"


def run(options, program, arguments, folder):
    """Runs a program in a folder; returns what it did, or raises an InputError if it cannot."""
    command = [str(options.programs / program), *arguments]
    if options.ranks > 1:
        command = ["mpirun", "-n", str(options.ranks), *command]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    (folder / f"{program}.log").write_text(done.stdout + done.stderr)
    return done


def flown(options, hidden):
    """Returns the forces [N] and the power [W] at TIMES of the last beat of the flight on twice the points."""
    words = hidden.replace("=", " ").split()
    folder = options.folder / "data" / ("-".join(words) or "plain")
    if not (folder / "ended").exists():
        write_flight(folder, 2 * options.points, options, hidden, "penalized")
        done = run(options, "flusi", ["flight.ini", "--overwrite"], folder)
        if done.returncode:
            raise InputError(f"{folder}: flusi stops with {done.returncode}; see flusi.log")
        (folder / "ended").touch()
    rows = np.array([[float(x) for x in line.split()] for line in (folder / "forces.t").read_text().splitlines()
                     if not line.lstrip().startswith("%")])
    forces = rows[:, 1:4] + rows[:, 4:7]
    size = DENSITY * LENGTH**4 * FREQUENCY**2
    columns = [*(size * forces.T), size * LENGTH * FREQUENCY * rows[:, 13]]
    return np.stack([np.interp(TIMES, rows[:, 0] - (options.beats - 1), column) for column in columns], axis=1)


def write_data(path, exact, gain, seed):
    """Writes a record with the errors of a balance: a gain of all forces, white noise, and an sd that also covers what two
    simulations differ by. All axes of the balance have the errors of the largest force: by symmetry one component is 0."""
    rng = np.random.default_rng(seed)
    rms = np.sqrt(np.mean(exact**2, axis=0))
    rms[:3] = rms[:3].max()
    seen = exact * np.array([gain, gain, gain, 1.0]) + WHITE * rms * rng.standard_normal(exact.shape)
    path.unlink(missing_ok=True)
    write_record(path, "wings", {"frequency": FREQUENCY, "beats": 20, "reference": np.zeros(3), "components": ", ".join(NAMES),
                                 "units": "N, N, N, W", "per_length": 0, "correlation_time": SAME / FREQUENCY},
                 {"time": TIMES, "mean": seen, "sd": math.hypot(WHITE, MODEL) * rms * np.ones_like(exact)})


def judged(cause, found):
    """Returns whether a verdict is right."""
    verdict = found["verdict"]
    names = verdict["set"] or [one["effect"] for one in verdict["causes"]]
    if cause is None:
        return verdict["word"] == "adequate"
    if cause == "outside":
        return verdict["word"] == "unknown_cause"
    return verdict["word"] not in ("adequate", "unknown_cause") and cause in names


def diagnose(options, name):
    """Returns the verdict on a case, and whether it is right."""
    hidden, gain, seed, cause = CASES[name]
    folder = options.folder / name
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "diagnosis.json").exists():
        write_data(folder / "data.h5", flown(options, hidden), gain, options.seed + seed)
        write_diagnose(folder, options)
        begin = time.time()
        done = run(options, "msm_diagnose", ["diagnose.ini"], folder)
        if done.returncode:
            raise InputError(f"{folder}: msm_diagnose stops with {done.returncode}; see msm_diagnose.log")
        (folder / "seconds").write_text(f"{time.time() - begin:.0f}\n")
    found = json.loads((folder / "diagnosis.json").read_text())
    return found["verdict"]["sentence"], judged(cause, found)


def tell_cost(options):
    """Prints what the flights cost: steps of flusi, and the plan of msm_diagnose."""
    folder = options.folder / "data/plain"
    write_flight(folder, 2 * options.points, options, "", "penalized")
    done = run(options, "flusi", ["flight.ini", "--dry-run"], folder)
    print(f"data: {len({case[0] for case in CASES.values()})} flights on {2 * options.points} points in a length of the wing, each:")
    print(done.stdout + done.stderr)
    plan = options.folder / "plan"
    plan.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(1)
    write_data(plan / "data.h5", 1e-5 * rng.standard_normal((len(TIMES), len(NAMES))), 1.0, 1)
    write_diagnose(plan, options)
    done = run(options, "msm_diagnose", ["diagnose.ini", "--plan"], plan)
    print("diagnoses, whose first flights are made once for all cases:")
    print(done.stdout + done.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=16, help="in a length of the wing, for the diagnosis")
    parser.add_argument("--beats", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1, help="of the noise")
    parser.add_argument("--folder", type=Path, default=ROOT / "runs/bench_diagnosis_wings")
    parser.add_argument("--programs", type=Path, default=ROOT / "build/release/bin")
    parser.add_argument("--ranks", type=int, default=1, help="of a flight of the data; the diagnosis makes as many flights at a time")
    parser.add_argument("--rounds", type=int, default=3, help="of flights with what is found")
    parser.add_argument("--unknown-thickness", action="store_true", help="the diagnosis is not told how thick the wings of the data are")
    parser.add_argument("--cost", action="store_true", help="only say what the cases cost")
    parser.add_argument("cases", nargs="*", metavar="CASE")
    options = parser.parse_args()
    if not set(options.cases) <= set(CASES):
        raise InputError(f"cases are {', '.join(CASES)}")
    options.folder, options.programs = options.folder.resolve(), options.programs.resolve()
    write_flight(options.folder / "case", options.points, options)
    if options.cost:
        tell_cost(options)
        return
    right = {}
    for name in options.cases or CASES:
        sentence, right[name] = diagnose(options, name)
        print(f"{name}: {'right' if right[name] else 'wrong'}: {sentence}", flush=True)
    print(json.dumps({"right": sum(right.values()), "cases": len(right), **right}))
    sys.exit(0)


if __name__ == "__main__":
    run_command("run_wings", main)
