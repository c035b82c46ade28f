#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes an elastic beam behind a cylinder in a channel (ini/turek-hron.ini) on several grids: the cases FSI1 and FSI2 of
Turek & Hron (2006, DOI 10.1007/3-540-34596-5_15), and CFD1 and CFD2 with a rigid beam. docs/results/verification-coupling.md
holds the tables and describes the comparisons.

usage: turek.py <flusi> <folder> [case ...]     runs the cases (all of them without names), then prints
       turek.py --table <folder>                prints what is there; the last line is JSON
       turek.py --plot <folder> <picture>       draws the path of the end of the beam
       turek.py --list                          names the cases

A case that has finished in <folder> is not run again.
"""
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]

LENGTH, HEIGHT, DENSITY, NU = 2.56, 0.48, 1000.0, 1e-3  # of the box and of the fluid, SI units
# A mask whose step is 2 h wide has its wall where it is drawn if sqrt(nu C_eta) is this part of h = dx: the zero of
# wall_shift in tests/verification/fluid/support_walls.f90.
LAYER = 0.33909
ROUND_SHIFT = 0.3033  # and for half of it the wall is this part of h inside of the flow, if the grid resolves the layer
WALL, DIAMETER = 0.07, 0.1

# Published: mean and amplitude or one number; lengths in m, forces in N/m, frequencies in Hz.
PUBLISHED = {
    "cfd1": {"drag": 14.29, "lift": 1.119},
    "cfd2": {"drag": 136.7, "lift": 10.53},
    "fsi1": {"ux": 0.0227e-3, "uy": 0.8209e-3, "drag": 14.295, "lift": 0.7638},
    "fsi2": {"ux": (-14.58e-3, 12.44e-3, 3.8), "uy": (1.23e-3, 80.6e-3, 2.0), "drag": (208.83, 73.75, 3.8),
             "lift": (0.88, 234.2, 2.0)},
}


def grid(points, thin=1):
    """Returns the keys of a grid with `points` over the height of the box; the layer is `thin` times thinner."""
    dx = HEIGHT / points
    return {"ny": round(points * LENGTH / HEIGHT), "nz": points, "eps": (LAYER / thin * dx)**2 / NU, "iSaveVorticity": 0}


def short(points, thin=1):
    """Returns the keys of a channel that ends 0.6 m behind the beam."""
    return {**grid(points, thin), "ny": round(points * LENGTH / HEIGHT / 2), "yl": LENGTH / 2}


def seen_wall(points, thin, shift):
    """Returns by how many dx the walls of the channel are inside of the flow where a Poiseuille flow on the grid sees them, if they
    are drawn `shift` dx outside of where the benchmark has them. The grid does not resolve the layer, so that this depends on the
    places of the points, too."""
    dx = HEIGHT / points
    wave = 2 * np.pi * np.fft.fftfreq(points, dx)
    z = np.arange(points) * dx
    depth = (np.abs((z - (HEIGHT - WALL / 2) + HEIGHT / 2) % HEIGHT - HEIGHT / 2) - WALL / 2) / dx + shift
    mask = np.where(depth <= -1, 1, np.where(depth >= 1, 0, (1 + np.cos(np.pi * (depth + 1) / 2)) / 2))
    to, back = np.fft.fft(np.eye(points)), np.fft.ifft(np.eye(points))
    kept = (back @ np.diag(1.0 * (np.abs(wave) <= 2 / 3 * np.pi / dx)) @ to).real
    diffusion = (back @ np.diag(-NU * wave**2) @ to).real
    operator = kept @ (diffusion - np.diag(mask * NU / (LAYER / thin * dx)**2)) @ kept + np.eye(points) - kept
    flow = np.linalg.solve(operator, -kept @ np.ones(points)).sum() * dx
    return ((HEIGHT - WALL) - (12 * NU * flow)**(1 / 3)) / 2 / dx


def wall_shift(points, thin):
    """Returns by how many dx the walls must be drawn outside, so that the flow sees them where the benchmark has them."""
    low, high = 0.0, 1.0
    while high - low > 1e-6:
        shift = (low + high) / 2
        low, high = (shift, high) if seen_wall(points, thin, shift) > 0 else (low, shift)
    return low


def sheet(points, thin=2, is_moved=False):
    """Returns the keys of a short channel with the beam as a surface without thickness. If the walls and the cylinder `are moved`,
    the flow sees them where the benchmark has them; the flow through the channel remains the same."""
    keys = {**short(points, thin), "surface": "thin", "WingThickness": None, "CFL": 0.45}
    if not is_moved:
        return keys
    dx, height = HEIGHT / points, HEIGHT - WALL
    shift = wall_shift(points, thin) * dx
    return {**keys, "thick_wall": WALL - 2 * shift, "pos_wall": -shift, "Size": DIAMETER - 2 * ROUND_SHIFT * dx,
            "inflow_velocity": height / (height + 2 * shift)}


GRIDS = (72, 96, 120, 144, 192)
SLOW = {"inflow_velocity": 0.2, "Tmax": 9.0, "areal_density": 20.0, "tintegral": 0.05}
RIGID = {"wings": "rigid", "tintegral": 0.05, "Tmax": 3.5}
# FSI2 swings up slowly: when the inflow has grown a transverse weight pushes the beam, for a third of a second.
WEIGHT, BEGIN, RELEASE = "0.0 0.0 4.0", 2.0, 2.3
EARLY, LATE = {"Tmax": 8.0}, {"Tmax": 11.0}
# name: keys of ini/turek-hron.ini that differ
CASES = {
    **{f"cfd1-{n}": {**grid(n), **SLOW, "wings": "rigid"} for n in GRIDS},
    **{f"cfd2-{n}-short": {**short(n, 2), **RIGID} for n in GRIDS[1:]},
    "cfd2-96-short-thick": {**short(96), **RIGID},
    **{f"fsi1-{n}": {**grid(n), **SLOW} for n in GRIDS},
    "fsi1-96-short": {**short(96), **SLOW},
    **{f"fsi1-{n}-short-sheet": {**sheet(n, 1), **SLOW} for n in GRIDS[:3]},
    **{f"cfd2-{n}-short-sheet": {**sheet(n), **RIGID} for n in GRIDS},
    "cfd2-96-short-sheet-thick": {**sheet(96, 1), **RIGID},
    **{f"cfd2-{n}-short-sheet-moved": {**sheet(n, 2, True), **RIGID} for n in GRIDS[:4]},
    "fsi1-96-short-viscous": {**short(96), **SLOW, "load": "pressure_viscous"},
    "fsi1-96-short-step": {**short(96), **SLOW, "CFL_eta": 0.5},
    **{f"fsi2-{n}": {**grid(n, 2), **EARLY} for n in GRIDS[1:]},
    **{f"fsi2-{n}-short": {**short(n, 2), **EARLY} for n in GRIDS[1:]},
    "fsi2-96-short-thick": {**short(96), **EARLY},
    # The mask of the beam half as thick; its mass and stiffness remain.
    "fsi2-96-short-half": {**short(96, 2), **EARLY, "WingThickness": 0.01},
    # The load extrapolated to the beam instead of taken two cells beside it.
    "fsi2-96-short-near": {**short(96, 2), **EARLY, "load_extrapolated": "yes"},
    # The beam without thickness; the first one is the input file with another surface and no push.
    "fsi2-96-sheet": {"surface": "thin", "WingThickness": None, "CFL": 0.45, "iSaveVorticity": 0},
    **{f"fsi2-{n}-short-sheet": {**sheet(n), **EARLY} for n in GRIDS},
    "fsi2-96-short-sheet-thick": {**sheet(96, 1), **EARLY},
    "fsi2-96-short-sheet-moved": {**sheet(96, 2, True), **EARLY},
    # These continue from the end of fsi2-96-short.
    "fsi2-96-short-extrapolated": {**short(96, 2), **LATE, "coupling": "extrapolated"},
    "fsi2-96-short-strong": {**short(96, 2), **LATE, "coupling": "strong"},
    "fsi2-96-short-viscous": {**short(96, 2), **LATE, "load": "pressure_viscous"},
    "fsi2-96-short-step": {**short(96, 2), **LATE, "CFL_eta": 0.5},
}


def change(text, keys):
    """Returns the input file with other values; keys that it does not have are added to their section, and those without value
    are left out."""
    homes = {"CFL_eta": "Time", "gravity": "Flexible_wing", "iDoBackup": "Saving", "surface": "Insects",
             "load_extrapolated": "Flexible_wing"}
    for key, value in keys.items():
        if value is None:
            text = re.sub(rf"(?m)^{key} = .*\n", "", text)
            continue
        new, count = re.subn(rf"(?m)^{key} = [^;]*;", f"{key} = {value};", text)
        text = new if count else text.replace(f"[{homes[key]}]", f"[{homes[key]}]\n{key} = {value};")
    return text


def run(program, folder, name):
    folder.mkdir(parents=True, exist_ok=True)
    text = (ROOT / "ini/turek-hron.ini").read_text().replace("../wings/", f"{ROOT}/wings/")
    case = CASES[name]
    parts, first = [case], folder.parent / "fsi2-96-short"
    goes_on = case.get("Tmax") == LATE["Tmax"]
    if goes_on:
        if not (first / "done").exists():
            run(program, first, first.name)
        for backup in first.glob("runtime_backup*.h5"):
            shutil.copy(backup, folder)
    elif name.startswith("fsi2") and case.get("Tmax") == EARLY["Tmax"]:
        parts = [{**case, "Tmax": BEGIN}, {**case, "Tmax": RELEASE, "gravity": WEIGHT}, case]
    with open(folder / "log", "w") as log:
        for i, keys in enumerate(parts):
            (folder / "run.ini").write_text(change(text, keys))
            command = [program, "run.ini", "--restart" if goes_on or i > 0 else "--overwrite"]
            subprocess.run(command, cwd=folder, stdout=log, stderr=log, check=True)
    (folder / "done").touch()


def series(path):
    return np.array([[float(x) for x in line.split()] for line in path.read_text().splitlines()
                     if line.strip() and line.lstrip()[0] not in "%#"])


def read(folder):
    """Reads the time, the displacement of the end of the beam [m], and drag and lift of cylinder and beam [N/m]."""
    forces = series(folder / "forces.t")
    found = {"t": forces[:, 0], "drag": DENSITY * (forces[:, 2] + forces[:, 5]),
             "lift": DENSITY * (forces[:, 3] + forces[:, 6])}
    if (folder / "bending_left.t").exists():
        tip = series(folder / "bending_left.t")
        found["ux"], found["uy"] = tip[:, 1], -tip[:, 3]
    return found


def rising(t, x):
    """Returns the times at which x rises through 0."""
    i = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    return t[i] - x[i] * (t[i + 1] - t[i]) / (x[i + 1] - x[i])


def swing(t, x, begin, end):
    """Returns the mean of the extremes, half their distance, and the frequency: as the benchmark defines them, over whole
    cycles."""
    inside = (t >= begin) & (t <= end)
    middle, half = (x[inside].max() + x[inside].min()) / 2, np.ptp(x[inside]) / 2
    crossings = rising(t[inside], x[inside] - middle)
    frequency = (len(crossings) - 1) / (crossings[-1] - crossings[0]) if len(crossings) > 1 else 0.0
    return float(middle), float(half), float(frequency)


def steady(t, x):
    """Returns the last value, and how much of it has changed over the last tenth of the time."""
    last = x[t >= 0.9 * t[-1]]
    return float(x[-1]), float(np.ptp(last) / abs(x[-1]))


def measure(name, folder):
    d = read(folder)
    t, case = d["t"], name.split("-")[0]
    if case != "fsi2":
        return {key: steady(t, d[key]) for key in PUBLISHED[case] if key in d}
    # The last four cycles of the beam.
    begins = rising(t, d["uy"] - d["uy"][t > t[-1] - 1].mean())[-5:]
    found = {key: swing(t, d[key], begins[0], begins[-1]) for key in PUBLISHED[case]}
    ranges = [np.ptp(d["uy"][(t >= a) & (t <= b)]) for a, b in zip(begins, begins[1:])]
    found["drift"] = float(ranges[-1] / ranges[0] - 1)
    return found


def text(key, value, published):
    scale = 1e3 if key in ("ux", "uy") else 1
    if isinstance(published, tuple):
        return (f"{key} {scale * value[0]:.4g} +- {scale * value[1]:.4g} [{value[2]:.3f}] "
                f"({100 * (value[1] / published[1] - 1):+.1f} %, {100 * (value[2] / published[2] - 1):+.1f} %)")
    return f"{key} {scale * value[0]:.5g} ({100 * (value[0] / published - 1):+.1f} %)"


def table(root):
    found = {}
    print("mm, N/m, Hz; in brackets the deviation from the published value: of amplitude and frequency in FSI2")
    for name in CASES:
        folder = root / name
        if not (folder / "done").exists():
            continue
        case = PUBLISHED[name.split("-")[0]]
        found[name] = measure(name, folder)
        print(f"{name:22s}", "  ".join(text(key, found[name][key], case[key]) for key in case if key in found[name]))
    print(json.dumps({name: {key: [float(f"{x:.6g}") for x in value] if isinstance(value, tuple) else round(value, 4)
                             for key, value in values.items()} for name, values in found.items()}))


def plot(root, picture):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from flusi_msm.style import COLOURS, save, use_style
    use_style()
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.4), width_ratios=(2.2, 1))
    names = [name for n in GRIDS for name in (f"fsi2-{n}", f"fsi2-{n}-short")
             if (root / name / "done").exists()]
    middle, half, _ = PUBLISHED["fsi2"]["uy"]
    for value in (middle - half, middle + half):
        left.axhline(1e3 * value, color="black", lw=1.0, ls=":", label=None if value > middle else "published extremes")
    for name, colour in zip(names, COLOURS):
        d = read(root / name)
        label = f"dx = {1e3 * HEIGHT / int(name.split('-')[1]):.3g} mm"
        left.plot(d["t"], 1e3 * d["uy"], color=colour, label=label)
        last = d["t"] >= rising(d["t"], d["uy"])[-2]
        right.plot(1e3 * d["ux"][last], 1e3 * d["uy"][last], color=colour, label=label)
    mean, reach, _ = PUBLISHED["fsi2"]["ux"]
    right.plot(1e3 * (mean + np.array([-1, 1, 1, -1, -1]) * reach), 1e3 * (middle + np.array([-1, -1, 1, 1, -1]) * half),
               color="black", lw=1.0, ls=":")
    left.set(xlabel="t [s]", ylabel="end of the beam, across [mm]")
    left.legend(loc="upper left", fontsize=8)
    right.set(xlabel="along the channel [mm]", title="last cycle")
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
        root = Path(arguments[1])
        for name in arguments[2:] or CASES:
            if not (root / name / "done").exists():
                run(str(Path(arguments[0]).resolve()), root / name, name)
        table(root)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
