#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes a filament that flaps in a stream (ini/flag.ini) on several grids and with other parameters, and a pendulum made of
it in a fluid at rest, and compares the latter with theory. docs/results/verification-coupling.md holds the tables and describes
the comparisons.

usage: flag.py <flusi> <folder> [case ...]     runs the cases (all of them without names), then prints
       flag.py --table <folder>                prints what is there; the last line is JSON
       flag.py --plot <folder> <picture>       draws the path of the tail
       flag.py --list                          names the cases

A case that has finished in <folder> is not run again. The cases called thin are those of thin_filament.py, a
computation of the same filament by another method. In those called sheet the filament is a surface without thickness.
"""
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SPARS = 2 * math.pi * 0.1**4 / 64  # moment of area of the spars of wings/filament.h5, m^4 per metre of width
MASS, RIGIDITY, TILT = 1.5, 0.00225, 18.0
THIN = {"thin-24-normal": "reference, no friction", "thin-40": "reference, with friction"}
BLACK = "#000000"  # of the curves in THIN alone
SURFACE = {f"sheet-{n}": f"surface, L/dx = {n}" for n in (24, 32)}


def grid(points, length=6, height=4):
    return {"ny": points * length, "nz": points * height, "yl": float(length), "zl": float(height),
            "sponge_thickness": points // 2, "x0": f"0.0 {length / 3} {height / 2}", "iSaveVorticity": 0}


MARGIN = 1.3  # cells by which a surface without thickness moves more fluid on each side (bench/plates/run_added_mass)
SHEET = {"surface": "thin", "WingThickness": None, "CFL": 0.45}


def stiffness(rigidity):
    return {"E": repr(0.98 * rigidity / SPARS), "D": repr(0.02 * rigidity)}


def pendulum(points, density=1.0):
    return {**grid(points, 6, 6), **stiffness(200.0), "x0": "0.0 2.5 3.0", "eps": 2e-3, "nu": 1e-3, "uy": 0.0,
            "inicond": "quiescent", "iVorticitySponge": "no", "gravity": "0.0 25.0 0.0", "density": density,
            "yawpitchroll_0": "0.0 0.0 5.0", "Tmax": 1.3, "tintegral": 0.005}


# name: the keys of ini/flag.ini that differ. C_eta changes with dx, so that the leak through the filament is the same.
CASES = {
    **{f"{n}": {**grid(n), "eps": 0.096 / n} for n in (16, 24, 32, 48, 64)},
    **{f"sheet-{n}": {**grid(n), **SHEET} for n in (12, 16, 24, 32, 48)},
    "sheet-16-box": {**grid(16, 9, 6), **SHEET},
    "sheet-16-sharp": {**grid(16), **SHEET, "surface_viscosity": 0.0},
    "sheet-16-step": {**grid(16), **SHEET, "CFL": 0.15},
    "sheet-16-sharp-step": {**grid(16), **SHEET, "CFL": 0.15, "surface_viscosity": 0.0},
    "16-eps": {**grid(16), "eps": 3e-3},
    "16-step": {**grid(16), "eps": 6e-3, "CFL_eta": 0.495},
    "16-box": {**grid(16, 9, 6), "eps": 6e-3, "Tmax": 17.0},
    "16-thin": {**grid(16), "eps": 6e-3, "WingThickness": "2.0*dx"},
    "16-near": {**grid(16), "eps": 6e-3, "load_distance": "3.0*dx"},
    "16-extrapolated": {**grid(16), "eps": 6e-3, "coupling": "extrapolated"},
    "16-strong": {**grid(16), "eps": 6e-3, "coupling": "strong", "Tmax": 18.0},
    "16-viscous": {**grid(16), "eps": 6e-3, "load": "pressure_viscous"},
    "16-soft": {**grid(16), "eps": 6e-3, **stiffness(0.0015)},
    "32-thin": {**grid(32), "eps": 3e-3, "WingThickness": "2.0*dx"},
    "32-soft": {**grid(32), "eps": 3e-3, **stiffness(0.0015)},
    **{f"pendulum-{n}": pendulum(n) for n in (16, 24, 32, 48)},
    "pendulum-vacuum": pendulum(12, 1e-9),
    **{f"pendulum-sheet-{n}": {**pendulum(n), **SHEET, "dt_max": 2e-3} for n in (16, 24, 32)},
    "thin-16": (16, 22.0),
    "thin-16-normal": (16, 22.0, "--normal"),
    "thin-24": (24, 22.0),
    "thin-24-inset": (24, 22.0, "--inset", "1"),
    "thin-40": (40, 20.0),
    "thin-24-normal": (24, 22.0, "--normal"),
    "thin-40-normal": (40, 20.0, "--normal"),
}


def change(text, keys):
    """Returns the input file with other values; keys that it does not have are added to their section, and those without value
    are left out."""
    homes = {"CFL_eta": "Time", "iDoBackup": "Saving", "load_distance": "Flexible_wing", "coupling": "Flexible_wing",
             "load": "Flexible_wing", "surface": "Insects", "surface_viscosity": "Insects", "dt_max": "Time"}
    for key, value in keys.items():
        if value is None:
            text = re.sub(rf"(?m)^{key} = .*\n", "", text)
            continue
        new, count = re.subn(rf"(?m)^{key} = .*$", f"{key} = {value};", text)
        text = new if count else text.replace(f"[{homes[key]}]", f"[{homes[key]}]\n{key} = {value};")
    return text


def run(program, folder, name):
    folder.mkdir(parents=True, exist_ok=True)
    case = CASES[name]
    if isinstance(case, tuple):
        command = [sys.executable, str(Path(__file__).with_name("thin_filament.py")), str(case[0]), str(case[1]),
                   "tail.txt", "--rigidity", str(RIGIDITY), *case[2:]]
    else:
        text = (ROOT / "ini/flag.ini").read_text().replace("../wings/", f"{ROOT}/wings/")
        (folder / "run.ini").write_text(change(text, {**case, "iDoBackup": "no"}))
        command = [program, "run.ini", "--overwrite"]
    with open(folder / "log", "w") as log:
        subprocess.run(command, cwd=folder, stdout=log, stderr=log, check=True)
    (folder / "done").touch()


def series(path):
    return np.array([[float(x) for x in line.split()] for line in path.read_text().splitlines()
                     if line.strip() and line.lstrip()[0] not in "%#"])


def tail(folder, tilt):
    """Reads the time and the position of the tail relative to the pinned end, along and across the stream."""
    if (folder / "tail.txt").exists():
        return series(folder / "tail.txt")[:, :3].T
    t, ux, _, uz = series(folder / "bending_left.t")[:, :4].T
    c, s = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    return np.array([t, (1 + ux) * c + uz * s, (1 + ux) * s - uz * c])


def zeros(t, z):
    """Returns the times at which z rises through 0."""
    i = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    return t[i] - z[i] * (t[i + 1] - t[i]) / (z[i + 1] - z[i])


def flapping(folder):
    """Returns the frequency, the range of the tail across and along the stream, and the mean force along it, all over the last
    three cycles; and how much the range of the last of these cycles differs from that of the first."""
    t, y, z = tail(folder, TILT)
    begins = zeros(t, z)[-4:]
    cycles = [(t >= a) & (t <= b) for a, b in zip(begins, begins[1:])]
    ranges = [np.ptp(z[c]) for c in cycles]
    if (folder / "tail.txt").exists():
        time, force = series(folder / "tail.txt")[:, [0, 4]].T
    else:
        time, force = series(folder / "forces.t")[:, [0, 2]].T
    inside = (time >= begins[0]) & (time <= begins[-1])
    every = (t >= begins[0]) & (t <= begins[-1])
    return {"St": len(cycles) / (begins[-1] - begins[0]), "A": float(np.mean(ranges)), "A_y": float(np.ptp(y[every])),
            "F": float(force[inside].mean()), "drift": float(ranges[-1] / ranges[0] - 1)}


def half_period(folder):
    """Returns half a period of the pendulum, relative to that of a uniform bar in a vacuum."""
    t, y, z = tail(folder, 5.0)
    angle = np.arctan2(z, y)
    crossings = np.sort(np.concatenate([zeros(t, angle), zeros(t, -angle)]))
    return float((crossings[1] - crossings[0]) / (math.pi * math.sqrt(2 / (3 * 25.0))))


def added_mass(thickness):
    """Returns the same ratio for a bar with the added moment of inertia of a plate that is wider than it by `thickness`: of the
    mask, or twice the margin of a surface without thickness."""
    a = (1 + thickness) / 2
    return math.sqrt(1 + (math.pi * a**4 / 8 + math.pi * a**2 / 4) / (MASS / 3))


def table(root):
    found = {}
    print("case                St  range of tail  along  mean force    drift")
    for name in CASES:
        folder = root / name
        if not (folder / "done").exists():
            continue
        if name.startswith("pendulum"):
            found[name] = half_period(folder)
            continue
        f = found[name] = flapping(folder)
        print(f"{name:14s} {f['St']:7.4f} {f['A']:11.3f} {f['A_y']:10.3f} {f['F']:9.3f} {100 * f['drift']:+8.1f} %")
    vacuum = found.get("pendulum-vacuum", 1.0)
    for name, ratio in found.items():
        points = name.split("-")[-1]
        if name.startswith("pendulum") and points.isdigit():
            theory = added_mass((2 * MARGIN if "sheet" in name else 4) / int(points))
            print(f"{name:17s} period {ratio:.4f}, in a vacuum {vacuum:.4f}; added mass {theory:.4f}, "
                  f"difference {100 * (ratio / vacuum / theory - 1):+.2f} %")
    print(json.dumps({name: value if isinstance(value, float) else {k: round(v, 5) for k, v in value.items()}
                      for name, value in found.items()}))


def plot(root, picture):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from flusi_msm.style import COLOURS, save, use_style
    use_style()
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.4), width_ratios=(2.2, 1))
    names = [name for name in CASES if (name.isdigit() or name in SURFACE or name in THIN) and (root / name / "done").exists()]
    colours = iter(colour for colour in COLOURS if colour != BLACK)
    for name in names:
        t, y, z = tail(root / name, TILT)
        label = f"mask, L/dx = {name}, t = {4 / int(name):.3g} L" if name.isdigit() else {**SURFACE, **THIN}[name]
        if name in THIN:
            style = {"color": BLACK, "lw": 1.0, "ls": ":" if name.endswith("normal") else "--"}
        else:
            style = {"color": next(colours), "lw": 2.0 if name in SURFACE else None}
        left.plot(t, z, label=label, **style)
        begins = zeros(t, z)
        last = (t >= begins[-2]) & (t <= begins[-1])
        right.plot(y[last], z[last], **style)
    left.set(xlabel="t U/L", ylabel="tail across the stream / L", xlim=(0, 22), ylim=(-0.6, 0.8))
    left.legend(ncols=2, loc="upper right", fontsize=8)
    right.set(xlabel="tail along the stream / L", title="last cycle")
    save(figure, picture)


def main():
    arguments = sys.argv[1:]
    if arguments == ["--list"]:
        print("\n".join(CASES))
    elif len(arguments) == 2 and arguments[0] == "--table":
        table(Path(arguments[1]))
    elif len(arguments) == 3 and arguments[0] == "--plot":
        plot(Path(arguments[1]), arguments[2])
    elif len(arguments) >= 2 and not arguments[0].startswith("-") and set(arguments[2:]) <= set(CASES):
        program, root = str(Path(arguments[0]).resolve()), Path(arguments[1])
        for name in arguments[2:] or CASES:
            if not (root / name / "done").exists():
                run(program, root / name, name)
        table(root)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
