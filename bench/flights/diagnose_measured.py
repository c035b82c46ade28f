#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Asks msm_diagnose what the plane flow about a plate gets wrong against the measured forces on a hovering wing at Re = 75.
docs/results/flight-records.md has the answer.

usage: diagnose [--program MSM_DIAGNOSE] [--points N] [--model-sd X] [--effects LIST] MEASURED FOLDER

MEASURED is the folder with CL_measured.dat and CD_measured.dat. The program writes the case, the record of the measured forces
and diagnose.ini into FOLDER and runs msm_diagnose there. What was simulated stays in FOLDER and is not simulated again.
"""
import argparse
import math
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import plane_plate

RE, STROKE = 75, 2.8
BEATS = 3                                     # of a flight; its last beat is the middle one of the three that were averaged
BOX = 10                                      # chords
CHORD, SPEED, DENSITY = 0.01, 1.0, 1.2        # SI: choices, since coefficients were published and no forces
FREQUENCY = SPEED / CHORD / (math.pi * STROKE)  # Hz
SAMPLES = 40                                  # phases of the beat; a curve has about 50 points in a beat
TURN = 0.05                                   # beats about the ends of a stroke without a force along y
RECORD = "flight/wing"

UNITS = f"""
[units]
length = {CHORD!r}
frequency = {SPEED / CHORD!r}
density = {DENSITY!r}
"""

DIAGNOSE = """\
; Measured forces on a hovering wing against a plane flow. The wing file is not used: there are no bending tests.
[Wing]
file = {wing}
[Measurement]
file = measured.h5
[Flight]
file = case/run.ini
beats = {beats}
folder = flights
model_sd = {model_sd!r}
refine = grid
rounds = 0; they serve a cause with a name
{more}[Diagnose]
noise = declared
starts = 1
draws = 2000
[Saving]
name = diagnosis
"""


def write_record(measured, folder):
    """Writes measured.h5: mean and spread of the second to fourth beat. Three beats say little about the spread at one phase, so that
    all phases get the root mean square of a component's spread. Forces along y are drag with the sign of each half-stroke; they are
    left out near its ends, where a small error of the time turns the sign."""
    curves = {"Fy": plane_plate.read_measured(measured, "CD"), "Fz": plane_plate.read_measured(measured, "CL")}
    curves["Fy"][:, 1] = plane_plate.along_stroke(*curves["Fy"].T)
    size = DENSITY * SPEED**2 * CHORD / 2
    table = {}
    for n, curve in enumerate(curves.values()):
        for t, value in curve:
            table.setdefault(t, ["", ""])[n] = repr(float(size * value))
    (folder / "measured.csv").write_text("time,Fy,Fz\n" + "".join(f"{float(t / FREQUENCY)!r},{','.join(table[t])}\n" for t in sorted(table)))
    subprocess.run([sys.executable, "-B", plane_plate.ROOT / "tools/import_forces", "measured.csv", "-o", "measured.h5", "--time-units",
                    "s", "--frequency", repr(FREQUENCY), "--force-units", "N/m", "--start", repr(1 / FREQUENCY), "--samples",
                    str(SAMPLES), "--name", RECORD.split("/")[1]], cwd=folder, check=True)
    with h5py.File(folder / "measured.h5", "r+") as file:
        spread = file[RECORD]["spread"]
        turned = np.abs((2 * file[RECORD]["time"][...] + 0.5) % 1 - 0.5) / 2  # beats since, or until, the stroke turns
        file[RECORD]["mean"][turned < TURN, 0] = np.nan
        spread[...] = np.sqrt(np.mean(spread[...]**2, axis=0)) * np.ones(spread.shape)
    seal = plane_plate.ROOT / "tools/seal"
    subprocess.run([sys.executable, "-B", seal, "measured.h5"], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def write_all(measured, folder, points, model_sd, more=""):
    """Writes the record, the case with this many points in a chord, and diagnose.ini with the lines `more` in [Flight]."""
    plane_plate.write(folder / "case", RE, STROKE, BEATS, points, 0, False, BOX)
    with open(folder / "case/run.ini", "a") as file:
        file.write(UNITS)
    write_record(measured, folder)
    (folder / "diagnose.ini").write_text(DIAGNOSE.format(wing=plane_plate.ROOT / "wings/calliphora_small.h5", beats=BEATS,
                                                         model_sd=model_sd, more=more))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=plane_plate.ROOT / "build/release/bin/msm_diagnose")
    parser.add_argument("--points", type=int, default=12, help="in a chord (12)")
    parser.add_argument("--model-sd", type=float, default=0.05, help="relative error of the simulation that is allowed for (0.05)")
    parser.add_argument("--effects", help="causes that are tested (all)")
    parser.add_argument("measured", type=Path)
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    write_all(options.measured, options.folder, options.points, options.model_sd,
              f"effects = {options.effects}\n" if options.effects else "")
    done = subprocess.run([options.program.resolve(), "diagnose.ini"], cwd=options.folder, check=False)
    sys.exit(done.returncode)


if __name__ == "__main__":
    main()
