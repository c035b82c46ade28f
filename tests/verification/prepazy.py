# SPDX-License-Identifier: GPL-3.0-or-later
"""The stiffness of a beam from readings of its tip, as tools/import_prepazy with bench_prepazy and msm_train find it.

usage: prepazy.py BENCH_PREPAZY MSM_TRAIN synthetic    exact readings of the elastica with known stiffness and zeros
       prepazy.py BENCH_PREPAZY MSM_TRAIN measured     the Pre-Pazy wing; exit code 77 where its readings are not

The readings are looked for in the folder that FLUSI_PREPAZY names, or in ../shared/data/prepazy beside the repository.
Both are compared with a fit of the elastica, which shares nothing with the solver.
"""
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import elastica
from flusi_msm.importers.prepazy import GRAVITY, LENGTH, read_loadings, repeatability
from flusi_msm.plots.prepazy import read_fit

SOURCE = Path(__file__).resolve().parents[2]
SKIPPED = 77
# Chain for beam: 1/110^2 of the compliance; springs that grow 0.1 mm longer under loads that move the tip 290 mm.
MODEL = 5e-4
ZERO_MODEL = 1e-4    # [m]
SQRT_THRESHOLD = 1.6449  # of 90 %, one degree of freedom


def check(condition, sentence):
    print("ok  " if condition else "FAIL", sentence)
    if not condition:
        sys.exit(1)


TRAINING = """[Wing]
file = w.h5;
E = 4e10;
k_e = 3e7;
[Measurement]
file = m.h5;
[Train]
parameters = E 1e9 1e12;
"""


def run(programs, folder, sd_mm):
    """What bench_prepazy finds; what msm_train finds must be the same."""
    with tempfile.TemporaryDirectory() as place:
        wing, measurement, fit, picture = (Path(place) / name for name in ("w.h5", "m.h5", "fit.txt", "fit.png"))
        subprocess.run([sys.executable, "-B", SOURCE / "tools/import_prepazy", folder, "--wing", wing,
                        "-o", measurement, "--sd", repr(sd_mm)], check=True)
        fit.write_text(subprocess.run([programs[0], wing, measurement], check=True, capture_output=True, text=True).stdout)
        subprocess.run([sys.executable, "-B", SOURCE / "tools/plot_prepazy", fit, "-o", picture], check=True)
        check(picture.stat().st_size > 10000, "the picture is drawn")
        unknowns, found = read_fit(fit)
        check_training(programs[1], Path(place), unknowns)
        return unknowns, found


def check_training(program, place, unknowns):
    """The search from a random start, least squares and intervals of the program end where those of bench_prepazy do,
    which begin near; and its history can be drawn."""
    (place / "train.ini").write_text(TRAINING)
    told = subprocess.run([program, "train.ini"], cwd=place, check=True, capture_output=True, text=True).stdout
    said = re.search(r"^E: (\S+) Pa, with 90 % confidence between (\S+) and (\S+) Pa", told, re.M)
    check(said and "h = " not in told, f"E has an interval, and no heights are spoken of:\n{told}")
    value, low, high = (1e-10 * float(number) for number in said.groups())
    best, lower, upper = unknowns["EI"]
    # Ends are sought to 1 % of the threshold's root; six and four digits are printed.
    check(abs(value / best - 1) < 1e-4, f"the stiffness is the same: {value} and {best}")
    check(max(abs(low - lower), abs(high - upper)) < 0.015 * (upper - lower), f"so is the interval: {low} to {high}")
    subprocess.run([sys.executable, "-B", SOURCE / "tools/plot_training", place], check=True)
    page = next(place.glob("*_report.html")).read_text()
    check("zero" in page and page.count("<img") + page.count("<svg") >= 3, "the report has pictures and zeros")


def synthetic(programs):
    stiffness, zeros = 3.7, {"first": 0.012, "second": -0.004}
    with tempfile.TemporaryDirectory() as folder:
        rows = [(mass, zero - LENGTH * elastica.deflection(GRAVITY * mass * LENGTH**2 / stiffness))
                for zero, masses in zip(zeros.values(), (np.arange(0, 1.3, 0.3), np.arange(0, 2.6, 0.5)))
                for mass in masses]
        np.savetxt(Path(folder) / "bending_with_skin.txt", rows)
        unknowns, _ = run(programs, folder, 1.0)
    value, low, high = unknowns["EI"]
    check(abs(value / stiffness - 1) < MODEL, f"the stiffness is found: {value:.5f} of {stiffness}")
    check(low < stiffness < high, "and lies in its interval")
    for name, zero in zeros.items():
        check(abs(unknowns[f"zero:{name}"][0] - zero) < ZERO_MODEL, f"the zero of the {name} loading is found")


def measured(programs):
    folder = Path(os.environ.get("FLUSI_PREPAZY", SOURCE.parent / "shared/data/prepazy"))
    if not (folder / "bending_with_skin.txt").is_file():
        print(f"skipped: no readings in {folder}")
        sys.exit(SKIPPED)
    loadings = read_loadings(folder / "bending_with_skin.txt")
    sd, _ = repeatability(loadings)
    rows = np.concatenate(loadings)
    loading = np.repeat(np.arange(len(loadings)), [len(part) for part in loadings])
    stiffness, deviation, zeros, squares = elastica.fit(GRAVITY * rows[:, 0], rows[:, 1], loading, sd, LENGTH)
    unknowns, found = run(programs, folder, float(1e3 * sd))
    value, low, high = unknowns["EI"]
    print(f"EI {value:.4f} N m^2, {low:.4f} to {high:.4f}; elastica {stiffness:.4f}, sd {deviation:.4f}")
    check(sum(map(len, found.values())) == len(rows), "every reading is used")
    check(abs(value / stiffness - 1) < MODEL, "the stiffness is that of the elastica")
    # The profile is a parabola to a few per cent, for the stiffness is known to one.
    check(abs((high - low) / (2 * SQRT_THRESHOLD * deviation) - 1) < 0.03, "the interval is as wide as the linear one")
    for name, zero in zip(found, zeros):
        check(abs(unknowns[f"zero:{name}"][0] - zero) < ZERO_MODEL, f"the {name} zero is that of the elastica")
    chi2 = sum((((part[:, 1] - part[:, 2]) / part[:, 3])**2).sum() for part in found.values())
    check(abs(chi2 / squares - 1) < 0.05, f"so is the sum of squares: {chi2:.2f} of {len(rows)} readings")


if __name__ == "__main__":
    {"synthetic": synthetic, "measured": measured}[sys.argv[3]](sys.argv[1:3])
