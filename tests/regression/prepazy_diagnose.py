# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_diagnose names geometric nonlinearity where a baseline of small deflections meets readings of a beam that bends
far, finds that both series of readings began from different zeros, and names it no more with the right baseline.

usage: prepazy_diagnose.py MSM_DIAGNOSE synthetic    readings of the elastica, without the solver, with noise
       prepazy_diagnose.py MSM_DIAGNOSE measured     the Pre-Pazy wing; exit code 77 where its readings are not

The readings are looked for in the folder that FLUSI_PREPAZY names, or in ../shared/data/prepazy beside the repository.
"""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import elastica
from whole_program import MOST_LINES
from flusi_msm.importers.prepazy import GRAVITY, LENGTH, read_loadings, repeatability

SOURCE = Path(__file__).resolve().parents[2]

SKIPPED, ADEQUATE, NAMED = 77, 0, 10
SYNTHETIC_SD = 1e-3  # [m]


def check(condition, sentence):
    print("ok  " if condition else "FAIL", sentence)
    if not condition:
        sys.exit(1)


def diagnose(program, folder, sd, baselines):
    """Results of the shipped input with each of the baselines, (exit code, JSON)."""
    found = []
    with tempfile.TemporaryDirectory() as place:
        place = Path(place)
        subprocess.run([sys.executable, "-B", SOURCE / "tools/import_prepazy", folder, "--wing", place / "prepazy.h5",
                        "-o", place / "prepazy-readings.h5", "--sd", repr(1e3 * sd)], check=True)
        text = (SOURCE / "ini/prepazy-diagnose.ini").read_text()
        check("nonlinearity 0" in text, "the shipped input has the baseline of small deflections")
        for nonlinearity, extra in baselines:
            (place / "case.ini").write_text(text.replace("nonlinearity 0", f"nonlinearity {nonlinearity}")
                                            .replace("starts = 1;", "starts = 1;\ndraws = 1000;\n" + extra))
            done = subprocess.run([program, "case.ini", "--exit-code"], cwd=place, capture_output=True, text=True, timeout=300)
            print(done.stdout, done.stderr, sep="")
            check(len(done.stdout.splitlines()) <= MOST_LINES, f"at most {MOST_LINES} lines on the terminal")
            found.append((done.returncode, json.loads((place / "prepazy-diagnosis.json").read_text())))
    return found


def check_named(code, found):
    check(code == NAMED and [c["effect"] for c in found["verdict"]["causes"]] == ["nonlinearity"],
          f"geometric nonlinearity is named: {found['verdict']['sentence']}")
    gain = found["validation"]
    check(gain["has_gain"] and gain["gain_per_location"] > max(10, gain["standard_error"]),
          f"and predicts forces left out better: {gain['gain_per_location']:.1f} +- {gain['standard_error']:.1f}")


def check_not_named(found):
    named = [c["effect"] for c in found["verdict"]["causes"]] + found["verdict"]["set"]
    check("nonlinearity" not in named, f"with large deflections it is not named: {found['verdict']['sentence']}")
    status = {e["name"]: e for e in found["effects"]}["nonlinearity"]
    check(status["status"] == "not_testable" and "part of the baseline" in status["missing"], "because it is part of the baseline")


def shift(found):
    """Difference of the second zero reading to the first one, and its sd [m]."""
    second = found["zeros"]["readings"][1]
    return second["difference_to_first_m"], second["difference_sd_m"]


def synthetic(program):
    """Noise of 1 mm; the zeros are 16 mm apart, ten times the sd of their difference."""
    stiffness, zeros = 3.7, [0.012, -0.004]
    rng = np.random.default_rng(7)
    with tempfile.TemporaryDirectory() as folder:
        rows = [(mass, zero - LENGTH * elastica.deflection(GRAVITY * mass * LENGTH**2 / stiffness)
                 + SYNTHETIC_SD * rng.standard_normal())
                for zero, masses in zip(zeros, (np.arange(0, 1.3, 0.3), np.arange(0, 2.6, 0.5))) for mass in masses]
        np.savetxt(Path(folder) / "bending_with_skin.txt", rows)
        (code, small), (other, large) = diagnose(program, folder, SYNTHETIC_SD, [(0, ""), (1, "validation = no;\n")])
    check_named(code, small)
    interval = small["extended"]["intervals_90"][0]["lower_best_upper"]
    value = {p["name"]: p["value"] for p in small["extended"]["parameters"]}["nonlinearity"]
    # sd of a 90 % interval is its width over 3.29; four of them are exceeded once in 16000 data sets.
    check(abs(value - 1) < 4 * (interval[2] - interval[0]) / 3.29, f"in full: {value:.3f}")
    for found in small, large:
        difference, sd = shift(found)
        check(abs(difference - (zeros[1] - zeros[0])) < 4 * sd, f"the zeros differ by {1e3 * difference:.1f} mm")
    check(small["zeros"]["p_equal"] < 1e-10, "which is no chance")
    check_not_named(large)
    check(other == ADEQUATE, "and the right baseline is adequate")


def measured(program):
    folder = Path(os.environ.get("FLUSI_PREPAZY", SOURCE.parent / "shared/data/prepazy"))
    if not (folder / "bending_with_skin.txt").is_file():
        print(f"skipped: no readings in {folder}")
        sys.exit(SKIPPED)
    loadings = read_loadings(folder / "bending_with_skin.txt")
    sd, _ = repeatability(loadings)
    rows = np.concatenate(loadings)
    loading = np.repeat(np.arange(len(loadings)), [len(part) for part in loadings])
    _, _, zeros, _ = elastica.fit(GRAVITY * rows[:, 0], rows[:, 1], loading, sd, LENGTH)
    (code, small), (_, large) = diagnose(program, folder, float(sd), [(0, ""), (1, "validation = no;\nintervals = no;\nrefits = 1;\n")])
    check_named(code, small)
    # What docs/results/diagnosis-results.md says of it.
    lower, best, upper = small["extended"]["intervals_90"][0]["lower_best_upper"]
    check(max(abs(lower - 0.872), abs(best - 0.906), abs(upper - 0.940)) < 0.01, f"the fraction is {best:.3f}, {lower:.3f} to {upper:.3f}")
    values = [found[model]["chi2"] for found, model in ((small, "baseline"), (small, "extended"), (large, "baseline"))]
    check(np.allclose(values, [1712, 15.8, 36.0], rtol=0.02), f"chi^2 without the cause, with it, and with it in full: {values}")
    check_not_named(large)
    for found in small, large:
        difference, error = shift(found)
        print(f"zeros differ by {1e3 * difference:.2f} +- {1e3 * error:.2f} mm, p {found['zeros']['p_equal']:.1e}")
        check(found["zeros"]["p_equal"] < 0.01, "the two loadings began from different zeros")
        check(abs(difference - (zeros[1] - zeros[0])) < 2 * error, "by what the elastica fitted to the readings says")


if __name__ == "__main__":
    {"synthetic": synthetic, "measured": measured}[sys.argv[2]](sys.argv[1])
