# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes a wing that revolves at a constant rate (ini/revolving.ini): rigid and flexible, as a surface without thickness and as a
sheet in the mask, on several grids. docs/results/verification-wings.md holds the table.

usage: bench/wing/run_revolving [--program FLUSI] FOLDER [CASE ...]
       bench/wing/run_revolving --list

runs the cases (without names all but those on 192 and 256 points) in FOLDER and prints lift, torque about the axis and their ratio, means over
2.5 < t < 6 radians; the last line is JSON. A case that has finished is not run again. FOLDER may hold only some of the cases.
"""
import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from flusi_msm.results.ini import with_values

ROOT = Path(__file__).resolve().parents[2]
BEGIN, END = 2.5, 6.0
CHORD, BOX = 0.33378, 4.0  # mean chord and width of the box, R
SURFACES = {"thin": {"Insects": {"surface": "thin"}, "Time": {"CFL": 0.45}},
            "mask": {"Insects": {"surface": "penalized"}, "Time": {"CFL": 0.5}}}
# name: surface, rigid or flexible, points over the width of the box
CASES = {f"{surface}-{wings}-{n}": (surface, wings, n) for n in (64, 96, 128, 160, 192, 256) for surface in SURFACES
         for wings in ("rigid", "flexible")}
MOST = 160  # points of a case that is run without its name; the others take long


def write(folder, surface, wings, points):
    """Writes the input file of a case. The sponge keeps the length that it has on 128 points."""
    folder.mkdir(parents=True, exist_ok=True)
    changes = {section: dict(keys) for section, keys in SURFACES[surface].items()}
    changes["Insects"]["wings"] = wings
    changes["Resolution"] = {"nx": points, "ny": points, "nz": points // 2}
    changes["Sponge"] = {"sponge_thickness": round(points / 32)}
    changes["Saving"] = {"tsave": 100.0, "iSaveVelocity": 0, "iSaveVorticity": 0, "iSaveMask": 0, "iDoBackup": "no"}
    text = with_values((ROOT / "ini/revolving.ini").read_text(), changes)
    text = re.sub(r"(from_file|kinematics_loader)::", rf"\1::{ROOT}/ini/", text)
    (folder / "run.ini").write_text(text.replace("../wings/", f"{ROOT}/wings/"))


def measure(folder):
    """Returns the means over time of the lift [rho R^4/T^2], of the torque about the axis against the motion [rho R^5/T^2] and
    their ratio [1/R], and how much the ratio of the second half of that time differs from that of the first."""
    rows = np.array([[float(x) for x in line.split()] for line in (folder / "forces.t").read_text().splitlines()
                     if line.strip() and line.lstrip()[0] != "%"])
    t, lift, torque = rows[:, 0], rows[:, 3] + rows[:, 6], np.abs(rows[:, 9] + rows[:, 12])

    def mean(x, begin, end):
        inside = (t >= begin) & (t <= end)
        return float(np.trapezoid(x[inside], t[inside]) / np.ptp(t[inside]))
    middle = (BEGIN + END) / 2
    halves = [mean(lift, a, b) / mean(torque, a, b) for a, b in ((BEGIN, middle), (middle, END))]
    found = [mean(x, BEGIN, END) for x in (lift, torque)]
    return {"lift": found[0], "torque": found[1], "ratio": found[0] / found[1], "drift": halves[1] / halves[0] - 1}


def table(root):
    print(f"{'case':22s}{'c/dx':>6s}{'lift':>9s}{'torque':>9s}{'ratio':>8s}{'drift %':>9s}")
    found = {}
    for name, (_, _, n) in CASES.items():
        if (root / name / "done").exists():
            m = found[name] = measure(root / name)
            print(f"{name:22s}{CHORD * n / BOX:6.1f}{m['lift']:9.4f}{m['torque']:9.4f}{m['ratio']:8.3f}{100 * m['drift']:9.1f}")
    print(json.dumps({name: {key: round(value, 5) for key, value in m.items()} for name, m in found.items()}))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/flusi"), help="flusi (that of build/release)")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    options = parser.parse_args()
    if options.list:
        print("\n".join(CASES))
        return
    if options.folder is None or not set(options.cases) <= set(CASES):
        parser.error("a folder is needed, and cases that --list names")
    program = str(Path(options.program).resolve())
    for name in options.cases or [name for name, (_, _, n) in CASES.items() if n <= MOST]:
        folder = options.folder / name
        if (folder / "done").exists():
            continue
        write(folder, *CASES[name])
        with open(folder / "log", "w") as log:
            done = subprocess.run([program, "run.ini", "--overwrite"], cwd=folder, stdout=log, stderr=log, check=False)
        if done.returncode:
            sys.exit(f"{folder}: flusi stops with {done.returncode}; see {folder / 'log'}")
        (folder / "done").touch()
    table(options.folder)


if __name__ == "__main__":
    main()
