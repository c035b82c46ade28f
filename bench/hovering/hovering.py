#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes a plate that hovers in a plane flow: lift, power and their ratio for several numbers of points per chord. The plate
is a surface without thickness or a sheet in the mask; both are compared with the finest grid of the former. It also computes
the plane idealisation of a measured wing at Re = 75. docs/results/hovering.md holds the tables and describes the comparisons.

usage: run [--program FLUSI] [--measured FOLDER] [--picture FILE] FOLDER [CASE ...]
       run --list

runs the cases (all of them without names) in FOLDER and prints the tables; the last line is JSON. A case that has finished is
not run again. FOLDER may hold only some of the cases. --measured names the folder with CL_measured.dat and CD_measured.dat,
--picture writes one.
"""
import argparse
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from flusi_msm.hovering_plate import write_plate, write_stroke

ROOT = Path(__file__).resolve().parents[2]
PITCH = 45.0             # degrees
STEP = 0.15              # of dx/U
WINDOW = (0.15, 0.98)    # part of the beat: from after the start of the pitch to before the last record
FINE = 64


def cases():
    """Name: Re, stroke in chords, beats, points per chord, thickness of the mask in dx (0: none), whether its outline is moved
    inward by half of the thickness, chords of the box."""
    table = {}
    for re, grids, masks in ((100, (8, 12, 16, 24, 32, FINE), (8, 12, 16, 24, 32)),
                             (1000, (8, 12, 16, 24, 32, FINE), (12, 16, 24, 32))):
        for n in grids:
            table[f"re{re}-thin-{n}"] = (re, 2.0, 1, n, 0, False, 8)
        for n in masks:
            table[f"re{re}-mask-{n}"] = (re, 2.0, 1, n, 4, False, 8)
            table[f"re{re}-drawn-in-{n}"] = (re, 2.0, 1, n, 4, True, 8)
    for n in (16, 32):
        table[f"re75-thin-{n}"] = (75, 2.8, 4, n, 0, False, 10)
    table["re75-thin-16-wide"] = (75, 2.8, 4, 16, 0, False, 20)
    table["re75-drawn-in-32"] = (75, 2.8, 4, 32, 4, True, 10)  # an eighth of the chord thick, with round ends
    return table


CASES = cases()

INI = """\
; A plate that hovers: chord 1, U = pi f A0 = 1, Re = U c/nu = {re}. Units: c, c/U.
[Resolution]
nx = 1; two-dimensional
ny = {cells}
nz = {cells}
[Geometry]
yl = {box}
zl = {box}
[Time]
Tmax = {end!r}
dt_fixed = {dt!r}
[ReynoldsNumber]
nu = {nu!r}
[InitialCondition]
inicond = quiescent
[Penalization]
iPenalization = yes
iMask = Insect
eps = {eps!r}
[Insects]
WingShape = from_file::plate.ini
{surface}
RightWing = no
x0 = 0.0 {middle} {middle}
BodyMotion = from_file::stroke.t
FlappingMotion_left = from_file::pitch.ini
wing_frequency = {frequency!r}
[MeanFlow]
iMeanFlow = 1; the box is at rest
ux = 0.0
uy = 0.0
uz = 0.0
[Sponge]
iVorticitySponge = yes
iSpongeType = 2D_frame
eps_sponge = 0.1
sponge_thickness = {sponge}
[Saving]
tintegral = {record!r}
iDoBackup = no
progress_interval = 300
"""


def write(folder, re, stroke, beats, points, cells, is_drawn_in, box):
    """Writes the files of a run: the place of the plate is A0/2 cos(2 pi f t), the angle of its chord 90 + 45 sin(2 pi f t)
    degrees."""
    folder.mkdir(parents=True, exist_ok=True)
    period, middle = math.pi * stroke, box / 2
    end = beats * period
    half = 0.5 - (cells / points / 2 if is_drawn_in else 0)
    dt = STEP / points
    write_plate(folder, half, PITCH)
    write_stroke(folder, stroke, period, beats, middle, 400)
    (folder / "run.ini").write_text(INI.format(
        re=re, cells=points * box, box=float(box), end=end, dt=dt, nu=1 / re, eps=1.2 * dt, middle=middle, frequency=1 / period,
        surface=f"surface = penalized\nWingThickness = {cells / points!r}" if cells else "surface = thin",
        sponge=points // 2, record=period / 400))


def run(program, folder, case):
    write(folder, *case)
    with open(folder / "log", "w") as log:
        done = subprocess.run([program, "run.ini", "--overwrite"], cwd=folder, stdout=log, stderr=log, check=False)
    if done.returncode:
        sys.exit(f"{folder}: flusi stops with {done.returncode}; see {folder / 'log'}")
    (folder / "done").touch()


def series(path):
    return np.array([[float(x) for x in line.split()] for line in path.read_text().splitlines()
                     if line.strip() and line.lstrip()[0] != "%"])


def read(folder, stroke):
    """Reads t/T, the force along y and z on the plate, and the power that it gives to the flow, in units of rho U^2 c/2 and
    rho U^3 c/2."""
    forces, power = series(folder / "forces.t"), series(folder / "aero_power.t")
    f = forces[:, 1:4] + forces[:, 4:7]
    return forces[:, 0] / (math.pi * stroke), 2 * f[:, 1], 2 * f[:, 2], 2 * np.interp(forces[:, 0], power[:, 0], power[:, 1])


def mean_over(t, x):
    """Returns the mean over t of the polygon through the points (t, x)."""
    return float(np.sum(np.diff(t) * (x[1:] + x[:-1]) / 2) / (t[-1] - t[0]))


def measure(root, name):
    """Returns the means of lift and power over the window and their ratio, and the time and both curves."""
    t, _, lift, power = read(root / name, CASES[name][1])
    inside = (t >= WINDOW[0]) & (t <= WINDOW[1])
    mean = [mean_over(t[inside], x[inside]) for x in (lift, power)]
    return {"lift": mean[0], "power": mean[1], "ratio": mean[0] / mean[1]}, t, lift, power


def compare(root, re):
    """Prints the table of one Reynolds number and returns its numbers."""
    names = [name for name in CASES if name.startswith(f"re{re}-") and (root / name / "done").exists()]
    fine = f"re{re}-thin-{FINE}"
    found = {name: measure(root, name) for name in names}
    numbers = {name: {key: round(value, 5) for key, value in means.items()} for name, (means, *_) in found.items()}
    if fine not in found:
        return numbers
    base, t, lift, power = found[fine]
    print(f"\nRe = {re}, against {FINE} points without thickness: C_L {base['lift']:.4f}, C_P {base['power']:.4f}, "
          f"L/P {base['ratio']:.4f} (errors in %)")
    print(f"{'surface':10s}{'c/dx':>5s}{'lift':>8s}{'rms':>7s}{'power':>8s}{'rms':>7s}{'L/P':>8s}")
    inside = (t >= WINDOW[0]) & (t <= WINDOW[1])
    for name in names:
        if name == fine:
            continue
        means, s, *curves = found[name]
        rms = [100 * np.sqrt(np.mean((np.interp(t, s, x) - y)[inside] ** 2) / np.mean(y[inside] ** 2))
               for x, y in zip(curves, (lift, power))]
        errors = {key: 100 * (means[key] / base[key] - 1) for key in base}
        numbers[name].update({f"{key}_error": round(value, 2) for key, value in errors.items()})
        numbers[name].update(lift_rms=round(float(rms[0]), 2), power_rms=round(float(rms[1]), 2))
        print(f"{'-'.join(name.split('-')[1:-1]):10s}{CASES[name][3]:5d}{errors['lift']:8.1f}{rms[0]:7.1f}{errors['power']:8.1f}"
              f"{rms[1]:7.1f}{errors['ratio']:8.1f}")
    return numbers


def read_measured(folder, name):
    """Reads t/T and a coefficient, as digitised; returns None without the file."""
    path = folder / f"{name}_measured.dat" if folder else None
    return series(path) if path and path.exists() else None


def along_stroke(t, force):
    """Returns the drag: the force against the motion of each half-stroke."""
    return np.where((t % 1) < 0.5, force, -force)


def beside_measured(root, measured):
    """Returns the lines of the comparison at Re = 75 and their numbers: means over the last three beats."""
    found = {}
    data = {key: read_measured(measured, key) for key in ("CL", "CD")}
    begin = 1.0
    names = [name for name in CASES if name.startswith("re75-") and (root / name / "done").exists()]
    if not names:
        return found
    print("\nRe = 75, mean over 1 < t/T < 4")
    print(f"{'case':22s}{'C_L':>8s}{'C_D':>8s}{'L/D':>8s}{'largest C_L':>13s}{'largest C_D':>13s}   correlation: C_L, C_D")
    rows = {}
    for name in names:
        t, force, lift, _ = read(root / name, CASES[name][1])
        rows[name] = {"CL": (t, lift), "CD": (t, along_stroke(t, force))}
    if all(x is not None for x in data.values()):
        rows["measured"] = {}
        for key, x in data.items():
            x = x[np.argsort(x[:, 0], kind="stable")]
            rows["measured"][key] = (x[:, 0], x[:, 1])
    for name, curves in rows.items():
        numbers = {}
        for key, (t, x) in curves.items():
            inside = t >= begin
            numbers[key] = mean_over(t[inside], x[inside])
            numbers[f"{key}_largest"] = float(x[inside].max())
        line = (f"{name:22s}{numbers['CL']:8.3f}{numbers['CD']:8.3f}{numbers['CL'] / numbers['CD']:8.3f}"
                f"{numbers['CL_largest']:13.3f}{numbers['CD_largest']:13.3f}")
        for key in ("CL", "CD") if "measured" in rows and name != "measured" else ():
            t, x = rows["measured"][key]
            inside = t >= begin
            numbers[f"{key}_correlation"] = float(np.corrcoef(np.interp(t, *curves[key])[inside], x[inside])[0, 1])
            line += f"{numbers[f'{key}_correlation']:8.2f}"
        found[name] = {key: round(value, 4) for key, value in numbers.items()}
        print(line)
    return found


def draw(root, measured, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from flusi_msm.style import COLOURS, save, use_style
    use_style()
    figure, axes = plt.subplots(2, 2, figsize=(10, 6.4))
    for axis, re in zip(axes[0], (100, 1000)):
        shown = [(f"re{re}-thin-{FINE}", "no thickness", "black"), (f"re{re}-thin-12", "no thickness", COLOURS[0]),
                 (f"re{re}-thin-16", "no thickness", COLOURS[2]), (f"re{re}-mask-12", "mask", COLOURS[1]),
                 (f"re{re}-mask-24", "mask", COLOURS[4])]
        for name, label, colour in shown:
            if (root / name / "done").exists():
                t, _, _, power = read(root / name, CASES[name][1])
                axis.plot(t, power, color=colour, label=f"{label}, c/dx = {CASES[name][3]}")
        axis.set(xlabel="t/T", ylabel="power over $\\rho U^3 c/2$", title=f"Re = {re}", ylim=(-1, 5))
        axis.legend(fontsize=7)
    for axis, key, label in zip(axes[1], ("CL", "CD"), ("lift", "drag")):
        for name, words, colour in (("re75-thin-32", "plate without thickness, plane flow", COLOURS[0]),
                                    ("re75-drawn-in-32", "plate c/8 thick, plane flow", COLOURS[1])):
            if (root / name / "done").exists():
                t, force, lift, _ = read(root / name, CASES[name][1])
                axis.plot(t, lift if key == "CL" else along_stroke(t, force), color=colour, label=words)
        data = read_measured(measured, key)
        if data is not None:
            axis.plot(data[:, 0], data[:, 1], "k.", ms=3, label="measured, three-dimensional wing")
        axis.set(xlabel="t/T", ylabel=f"{label} over $\\rho U^2 c/2$", title="Re = 75", ylim=(-2.2, 3.4))
        axis.legend(fontsize=7)
    figure.tight_layout()
    save(figure, path)


def read_options(text, known):
    """Returns the options of a program that computes the `known` cases. The program ends here if they are only to be listed.
    `text` is its help."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/flusi"), help="flusi (that of build/release)")
    parser.add_argument("--measured", type=Path)
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    options = parser.parse_args()
    if options.list:
        print("\n".join(known))
        sys.exit()
    if options.folder is None or not set(options.cases) <= set(known):
        parser.error("a folder is needed, and cases that --list names")
    return options


def fly(options, known):
    """Runs those of the chosen cases that have not finished; the known cases are {name: arguments of `write`}."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    for name in options.cases or known:
        if not (options.folder / name / "done").exists():
            run(str(Path(options.program).resolve()), options.folder / name, known[name])


def main():
    options = read_options(__doc__, CASES)
    fly(options, CASES)
    found = {f"re{re}": compare(options.folder, re) for re in (100, 1000)}
    found["re75"] = beside_measured(options.folder, options.measured)
    if options.picture:
        draw(options.folder, options.measured, options.picture)
    print(json.dumps(found))


if __name__ == "__main__":
    main()
