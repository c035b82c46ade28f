# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the rings of the vorticity around wings without thickness, and lift and power, over [Insects] surface_viscosity: rigid
wings of the blowfly (ini/wing-rigid.ini) on 96 x 96 x 48 points, one beat from rest. docs/results/thin-wings-results.md holds the
table.

usage: bench/thin/run [--program FLUSI] [--points N] FOLDER [VISCOSITY ...]

runs the values (0.15, 0.3, 0.6 and 1 without any) in FOLDER and prints the table; the last line is JSON. A value that has finished
on this grid is not run again. Lift and power are means over 0.3 < t < 1; the vorticity is that at t = 0.25. Its height is the percentile 99.9 of
the magnitude. Rings are the rms of the magnitude more than ten grid spacings from where it is a tenth of its largest value or more.
"""
import argparse
import json
import re
import subprocess
from pathlib import Path

import numpy as np
from scipy.ndimage import distance_transform_edt

from flusi_msm.results.files import choose_snapshot
from flusi_msm.results.flow import vorticity_magnitude
from flusi_msm.results.ini import with_values

ROOT = Path(__file__).resolve().parents[2]
VISCOSITIES = ("0.15", "0.3", "0.6", "1.0")
BEGIN, END, TIME = 0.3, 1.0, 0.25
STRONG, APART = 0.1, 10


def write(folder, viscosity, points):
    """Writes the input file of a case. The sponge keeps its length."""
    folder.mkdir(parents=True, exist_ok=True)
    text = with_values((ROOT / "ini/wing-rigid.ini").read_text(), {
        "Resolution": {"nx": points, "ny": points, "nz": points // 2},
        "Insects": {"surface_viscosity": viscosity},
        "Sponge": {"sponge_thickness": round(points / 8)},
        "Saving": {"tsave": TIME, "iSaveVelocity": 0, "iSaveVorticity": 1, "iSaveWingSides": 0, "iDoBackup": "no"}})
    (folder / "run.ini").write_text(re.sub(r"from_file::", f"from_file::{ROOT}/ini/", text).replace("../wings/", f"{ROOT}/wings/"))


def mean(path, columns):
    """Returns the mean over time of the sum of the columns."""
    rows = np.array([[float(x) for x in line.split()] for line in path.read_text().splitlines()
                     if line.strip() and line.lstrip()[0] != "%"])
    rows = rows[(rows[:, 0] >= BEGIN) & (rows[:, 0] <= END)]
    return float(np.trapezoid(rows[:, columns].sum(1), rows[:, 0]) / np.ptp(rows[:, 0]))


def heights(magnitude):
    """Returns the percentile 99.9 and the rms far from what is strong. The box is periodic."""
    pad = APART + 1
    strong = np.pad(magnitude >= STRONG * magnitude.max(), pad, mode="wrap")
    far = distance_transform_edt(~strong)[pad:-pad, pad:-pad, pad:-pad] > APART
    return float(np.percentile(magnitude, 99.9)), float(np.sqrt(np.mean(magnitude[far] ** 2)))


def measure(folder):
    snapshot = choose_snapshot(folder, TIME, None)
    found = {"lift": mean(folder / "forces.t", [3, 6]), "power": mean(folder / "aero_power.t", [1])}
    for name, is_mean in (("stored", False), ("means", True)):
        found[f"height_{name}"], found[f"rings_{name}"] = heights(vorticity_magnitude(snapshot, smooth=is_mean))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/flusi")
    parser.add_argument("--points", type=int, default=96)
    parser.add_argument("folder", type=Path)
    parser.add_argument("viscosities", nargs="*", default=VISCOSITIES)
    options = parser.parse_args()
    found = {}
    for viscosity in options.viscosities:
        folder = options.folder / f"{options.points}-{viscosity}"
        if not (folder / "done").exists():
            write(folder, viscosity, options.points)
            with open(folder / "log", "w") as log:
                subprocess.run([options.program.resolve(), "run.ini", "--overwrite"], cwd=folder, stdout=log, stderr=log, check=True)
            (folder / "done").touch()
        found[viscosity] = measure(folder)
    print(f"{'viscosity':10s}{'lift':>8s}{'power':>8s}{'height':>8s}{'rings':>8s}   means over 3 points:{'height':>8s}{'rings':>8s}")
    for viscosity, row in found.items():
        print(f"{viscosity:10s}{row['lift']:8.2f}{row['power']:8.1f}{row['height_stored']:8.0f}{row['rings_stored']:8.2f}"
              f"{'':23s}{row['height_means']:8.0f}{row['rings_means']:8.2f}")
    print(json.dumps({viscosity: {key: round(value, 4) for key, value in row.items()} for viscosity, row in found.items()}))


if __name__ == "__main__":
    main()
