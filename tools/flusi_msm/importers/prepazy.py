# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a wing file and a measurement file from the bending readings of the Pre-Pazy wing (docs/results/prepazy.md).

usage: import_prepazy FOLDER --wing prepazy.h5 -o measurement.h5 [--sd MM]

FOLDER holds bending_with_skin.txt: mass hung at the tip [kg] and reading of the tip's height [m], down is negative, one
line each; a mass of 0 begins a new loading, whose zero reading is unknown. The wing becomes one straight vein with the
second moment of area 1e-10 m^4, so that E [Pa] is 1e10 times the bending stiffness EI [N m^2].

Without --sd the standard deviation of a reading is taken from the readings themselves: the differences between two
loadings at equal masses would be constant if readings were exact.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from math import pi
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.errors import InputError, run_command
from flusi_msm.measurement.file import SCHEMA, VERSION
from flusi_msm.seal import write_seal
from flusi_msm.wing.file import Wing, write_wing

LENGTH = 0.55        # [m] from the clamp to the tip
GRAVITY = 9.81       # [m/s^2]
MOMENT = 1e-10       # [m^4] chosen: only E times it is measured
SEGMENTS = 110       # the chain differs from a beam by about 1/SEGMENTS^2
NAMES = ["first", "second", "third", "fourth", "fifth", "sixth"]
SAME_MASS = 1e-6     # [kg]


def read_loadings(path: Path) -> list[np.ndarray]:
    """Returns arrays (n, 2) of mass [kg] and reading [m], one for each loading."""
    try:
        rows = np.loadtxt(path, ndmin=2)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    if rows.ndim != 2 or rows.shape[1] != 2 or not np.isfinite(rows).all():
        raise InputError(f"{path}: two finite numbers in every line are needed: mass [kg] and reading [m]")
    begins = np.flatnonzero(rows[:, 0] == 0)
    if not len(begins) or begins[0] != 0:
        raise InputError(f"{path}: the first line must be the reading without a mass")
    if len(begins) > len(NAMES) or (rows[:, 0] < 0).any() or np.abs(rows[:, 1]).max() > LENGTH:
        raise InputError(f"{path}: masses must be positive [kg], readings below {LENGTH} m, loadings at most "
                         f"{len(NAMES)}")
    return np.split(rows, begins[1:])


def repeatability(loadings: Sequence[np.ndarray]) -> tuple[float, int]:
    """Returns the standard deviation of a reading [m] from equal masses in the first two loadings, and the number of such pairs.
    """
    if len(loadings) < 2:
        raise InputError("a single loading does not tell how exact readings are; give --sd")
    first, second = loadings[:2]
    pairs = [(a[1], b[1]) for a in first for b in second if abs(a[0] - b[0]) < SAME_MASS]
    if len(pairs) < 3:
        raise InputError("fewer than three masses are common to the first two loadings; give --sd")
    return np.std([a - b for a, b in pairs], ddof=1) / np.sqrt(2), len(pairs)


def beam() -> Wing:
    """Returns the cantilever as a chain."""
    points = np.zeros((SEGMENTS + 1, 3))
    points[:, 0] = np.linspace(0, LENGTH, SEGMENTS + 1)
    diameter = (64 * MOMENT / pi)**0.25
    return Wing(points, np.zeros((0, 3), int), {"spar": (list(range(SEGMENTS + 1)), np.full(SEGMENTS + 1, diameter))},
                {}, [0], "Pre-Pazy wing as one vein, I = 1e-10 m^4")


def write_readings(path: str | Path, loadings: Sequence[np.ndarray], sd: float) -> None:
    """Writes loads and observations; the offset of a loading is named after the loading."""
    try:
        with h5py.File(path, "w", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_(SCHEMA)
            file.attrs["version"] = np.int32(VERSION)
            file.attrs["title"] = np.bytes_("Pre-Pazy wing with skin, weights at the tip, doi:10.5281/zenodo.4299868")
            order = 0
            for name, rows in zip(NAMES, loadings):
                for k, (mass, reading) in enumerate(rows):
                    order += 1
                    load = file.create_group(f"loads/{name}_{k:02d}")
                    load.attrs["force"] = np.float64(GRAVITY * mass)
                    load.attrs["direction"] = np.array([0.0, 0.0, -1.0])
                    load.attrs["point"] = np.array([LENGTH, 0.0])
                    load.attrs["order"] = np.int32(order)
                    seen = file.create_group(f"points/{name}_{k:02d}")
                    for key, text in (("load", f"{name}_{k:02d}"), ("quantity", "displacement"), ("units", "m"),
                                      ("zero", name)):
                        seen.attrs[key] = np.bytes_(text)
                    seen.attrs["point"] = np.array([LENGTH, 0.0])
                    seen.attrs["axis"] = np.array([0.0, 0.0, 1.0])
                    seen.attrs["value"] = np.float64(reading)
                    seen.attrs["sigma"] = np.float64(sd)
            file.create_group("accuracy")
        write_seal(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error}") from error


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("--wing", required=True, metavar="FILE", help="wing file to write")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="measurement file to write")
    parser.add_argument("--sd", type=float, metavar="MM", help="standard deviation of a reading [mm]")
    options = parser.parse_args()
    loadings = read_loadings(Path(options.folder) / "bending_with_skin.txt")
    if options.sd is None:
        sd, n = repeatability(loadings)
        source = f"from {n} masses that two loadings have in common"
    elif options.sd > 0:
        sd, source = 1e-3 * options.sd, "as given"
    else:
        raise InputError("--sd must be positive")
    write_wing(options.wing, beam())
    write_readings(options.output, loadings, sd)
    print(f"{options.wing}: cantilever of {LENGTH} m in {SEGMENTS} segments")
    print(f"{options.output}: {sum(map(len, loadings))} readings in {len(loadings)} loadings, up to "
          f"{GRAVITY * max(rows[:, 0].max() for rows in loadings):.4g} N, sd {1e3 * sd:.3g} mm {source}")


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("import_prepazy", main)
