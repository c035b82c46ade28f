#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffness of wings that bend in records of a flight: a filament whose clamped end heaves across a plane stream. Data and diagnosis have
the same grid, which is far too coarse for physics.

usage: flight_stiffness.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import functools
import json
import math
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
from synthetic_bending import ADEQUATE, NAMED, SET, seal
from whole_program import SOURCE, check, ini_text, main, series

PERIOD, HEAVE, BEATS = 2.0, 0.05, 2
YOUNG, PLATE, DENSITY = 1.5e8, 0.08, 100.0  # Pa, N m, kg/m^3: E within the bounds of this parameter
TIMES = (np.arange(25) + 0.5) / 25
FILAMENT = {
    "units": {"length": 1.0, "frequency": 1.0, "density": DENSITY},
    "Resolution": {"nx": 1, "ny": 64, "nz": 48},
    "Geometry": {"yl": 4.0, "zl": 3.0},
    "Time": {"Tmax": PERIOD * BEATS, "dt_fixed": 0.01},
    "ReynoldsNumber": {"nu": 2e-2},
    "InitialCondition": {"inicond": "MeanFlow"},
    "Penalization": {"iPenalization": "yes", "iMask": "Insect", "eps": 1.2e-2},
    "Insects": {"wings": "flexible", "surface": "thin", "RightWing": "no", "x0": "0.0 1.2 1.5", "eta0": -45.0,
                "BodyMotion": "from_file::heave.t", "wing_frequency": 1 / PERIOD},
    "Flexible_wing": {"largest_deflection": 3.0},
    "Wing": {"file": f"{SOURCE}/wings/filament.h5", "E": YOUNG, "D": PLATE, "k_e": 1e7},
    "Mass": {"membrane_law": "uniform", "areal_density": 5 * DENSITY, "vein_density": 1e-7},
    "MeanFlow": {"iMeanFlow": 1, "ux": 0.0, "uy": 1.0, "uz": 0.0},
    "Saving": {"tintegral": 0.01, "iDoBackup": "no", "progress_interval": 300},
}


def write_case(folder, factor=1.0):
    """The case, with so many times the stiffness of its spars. The end begins to heave within the first beat."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for i in range(200 * (BEATS + 1) + 41):
        t = i * PERIOD / 200
        w, x = 2 * math.pi * t / PERIOD, min(t / PERIOD, 1)
        size, growth = x**3 * (10 - 15 * x + 6 * x * x), 30 * x**2 * (1 - x)**2 / PERIOD
        z = 1.5 + HEAVE * size * math.sin(w)
        v = HEAVE * (size * 2 * math.pi / PERIOD * math.cos(w) + growth * math.sin(w))
        rows.append(f"{t:.12e} 0 1.2 {z:.12e} 0 0 {v:.12e}  1 0 0 0  0 0 0\n")
    (folder / "heave.t").write_text("".join(rows))
    (folder / "heave.ini").write_text(ini_text({**FILAMENT, "Wing": {**FILAMENT["Wing"], "E": factor * YOUNG}}))


@functools.lru_cache(maxsize=None)
def flown(factor):
    """Fy and Fz [N/m] at TIMES of the last beat of a flight of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_case(folder, factor)
        subprocess.run([FLUSI, "heave.ini"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        rows = np.array(series(folder / "forces.t").rows)
    t = rows[:, 0] / PERIOD - (BEATS - 1)
    return DENSITY * np.stack([np.interp(TIMES, t, rows[:, k] + rows[:, k + 3]) for k in (2, 3)], axis=1)


def add_record(path, mean, seed, error=0.2):
    """Adds the record to a measurement, which is made if it is missing."""
    rng = np.random.default_rng(seed)
    sd = error * np.sqrt(np.mean(mean**2, axis=0)) * np.ones_like(mean)
    with h5py.File(path, "a", libver=("v108", "v108")) as f:
        f.attrs.update(schema="flusi-msm measurement", version=1)
        flight = f.create_group("flight/heave")
        flight.attrs.update(frequency=1 / PERIOD, beats=16, frame="lab", reference=np.zeros(3), per_length=1, components="Fy, Fz",
                            units="N/m, N/m")
        flight["time"] = TIMES
        flight["mean"] = mean + sd * rng.standard_normal(mean.shape)
        flight["sd"] = sd
    seal(path)


def diagnose(case, data, name, flight, flags=(), parameters="E"):
    """Exit code, JSON (or none) and what was printed."""
    write_case(case.folder / "case")
    wing = {**FILAMENT["Wing"], "E": YOUNG}
    text = ini_text({"Wing": wing, "Mass": FILAMENT["Mass"], "Measurement": {"file": data}})
    if flight:
        text += f"[Flight]\nfile = case/heave.ini\nbeats = {BEATS}\nharmonics = 12\nfolder = ../flights\nmodel_sd = 0\nrefine = no\n{flight}"
    text += f"[Diagnose]\nnoise = declared\ndraws = 500\nstarts = 1\nvalidation = no\nrefine = no\nparameters = {parameters}\n[Next]\nmodes = 0\n[Saving]\nname = {name}\n"
    (case.folder / f"{name}.ini").write_text(text)
    done = case.flusi(f"{name}.ini", "--exit-code", *flags, timeout=300)
    path = case.folder / f"{name}.json"
    found = json.loads(path.read_text()) if path.exists() else None
    print(f"    {name}: {done.code} {found['verdict']['sentence'] if found else done.err}", flush=True)
    return done.code, found, done.out + done.err


def test_alone(case):
    """Forces on a filament with spars a quarter stiffer than those of the case name this cause, with its size."""
    add_record(case.folder / "data.h5", flown(1.25), 1)
    code, found, text = diagnose(case, "data.h5", "alone", "effects = vein_stiffness, balance_gain\nrounds = 1\n")
    check(text.startswith("flights   3 of "), text)
    check(code == NAMED and found["verdict"]["set"] == ["vein_stiffness"], text)
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    # A third of the prior, whose 90 % are 2 * 1.645 * 0.2 wide: it is the forces that give E.
    check(lower <= 1.25 <= upper and upper - lower < 0.2, f"spars {lower} {best} {upper} times as stiff")
    changed = (case.folder / "alone_extended_flight.ini").read_text()
    young = float(changed.split("[Wing]")[1].split("E = ")[1].split()[0])
    # Both files give the number with more than six digits.
    check(abs(young / (best * YOUNG) - 1) < 1e-6, f"the case with this E: {changed}")


def add_mode(path, factor, error):
    """Adds the lowest frequency of a clamped bar with the stiffness and the mass of the filament, which is wrong by `error` sd of 4 %."""
    spars = 2 * math.pi * 0.1**4 / 64  # moment of area, m^4 per metre of width
    rigidity = factor * YOUNG * spars + PLATE
    frequency = 1.8751**2 / (2 * math.pi) * math.sqrt(rigidity / FILAMENT["Mass"]["areal_density"])
    with h5py.File(path, "a", libver=("v108", "v108")) as f:
        f.attrs.update(schema="flusi-msm measurement", version=1)
        f.create_group("modes/first").attrs.update(frequency=frequency * (1 + 0.04 * error), frequency_sigma=0.04 * frequency, medium="vacuum",
                                                   number=1)
    seal(path)


def stiffness_of(found):
    """E in the baseline, which has D within its prior beside it."""
    known = {one["name"]: one for one in found["baseline"]["parameters"]}
    check(set(known) == {"E", "membrane_error"} and abs(known["membrane_error"]["value"] - 1) < 0.1, f"{known}")
    return known["E"]


def test_shared(case):
    """A natural frequency and forces in flight, of spars 15 % stiffer than assumed, share E. The frequency alone leaves 8 %, and it errs
    by as much; with the forces E is known to 3 %. The flights for E and D are counted before."""
    for name in "mode", "both":
        add_mode(case.folder / f"{name}-data.h5", 1.15, 1.0)
    add_record(case.folder / "both-data.h5", flown(1.15), 2)
    _, found, _ = diagnose(case, "mode-data.h5", "mode", "")
    apart = stiffness_of(found)
    _, _, text = diagnose(case, "both-data.h5", "both", "effects = balance_gain\nrounds = 0\n", flags=("--plan",))
    check(text.startswith("flights   5 of "), f"the case, and twice for E and D: {text}")
    code, found, text = diagnose(case, "both-data.h5", "both", "effects = balance_gain\nrounds = 0\n")
    together = stiffness_of(found)
    check(code == ADEQUATE, text)
    # The frequency goes as the root of E, so its 4 % leave 2 * 0.04 / 1.04 = 0.077, and its error moves E by 8 %. Forces that weigh five
    # times as much leave 0.015, two of which are 3 %.
    check(together["sd"] < 0.015 and apart["sd"] > 0.07, f"sd of log E: {apart['sd']} and {together['sd']}")
    check(abs(together["value"] / (1.15 * YOUNG) - 1) < 0.03 < 0.05 < abs(apart["value"] / (1.15 * YOUNG) - 1), f"{apart} {together}")


def test_other_cause(case):
    """A wing that is heavier than assumed rings more slowly and flies on: it is no reason to compare flights, though E is common to both."""
    add_mode(case.folder / "data.h5", 1.0, -8.0)
    add_record(case.folder / "data.h5", flown(1.0), 3)
    code, found, text = diagnose(case, "data.h5", "mass", "effects = balance_gain\nrounds = 0\n")
    check(code in (NAMED, SET) and found["extended"], text)
    check(not {"vein_stiffness", "membrane_bending", "elasticity"} & {one["effect"] for one in found["verdict"]["causes"]}, text)
    check("flights" not in found and "compared" not in text, f"two flights that are the same: {text}")


if __name__ == "__main__":
    shutil.rmtree("flights", ignore_errors=True)  # those of this program alone
    FLUSI = str(Path(sys.argv.pop(3)).resolve())
    main(globals())
