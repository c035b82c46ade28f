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
import json

import numpy as np
from plane_plate import along_stroke, fly, mean_over, read, read_measured, read_options

WINDOW = (0.15, 0.98)    # part of the beat: from after the start of the pitch to before the last record
FINE = 64
# Grids like that of 12 points, and the numbers of gaps between markers on the chord: they are 1.7 to 2.4 dx wide.
NEAR = [(n, gaps) for n in range(10, 16) for gaps in range(5, 9) if 1.65 <= n / gaps <= 2.4]
MARGIN = 0.37            # of a marker surface in a creeping flow, in dx (bench/plates/edge_margin.py)


def cases():
    """Name: Re, stroke in chords, beats, points per chord, thickness of the mask in dx (0: none), whether its outline is moved
    inward by half of the thickness, chords of the box, the distance of markers in dx if it is not the program's,
    and by how many dx the plate is shorter at both ends."""
    table = {}
    for re, grids, masks in ((100, (8, 12, 16, 24, 32, FINE), (8, 12, 16, 24, 32)),
                             (1000, (8, 12, 16, 24, 32, FINE), (12, 16, 24, 32))):
        for n in grids:
            table[f"re{re}-thin-{n}"] = (re, 2.0, 1, n, 0, False, 8)
        for n in masks:
            table[f"re{re}-mask-{n}"] = (re, 2.0, 1, n, 4, False, 8)
            table[f"re{re}-drawn-in-{n}"] = (re, 2.0, 1, n, 4, True, 8)
    for n, gaps in NEAR:
        table[f"re100-thin-gaps{gaps}-{n}"] = (100, 2.0, 1, n, 0, False, 8, n / gaps)
    for re, n, gaps in [(100, *near) for near in NEAR if near[0] / near[1] < 2.21] + [(100, 16, 8), (100, 24, 12), (1000, 16, 8), (1000, 24, 12)]:
        table[f"re{re}-short-gaps{gaps}-{n}"] = (re, 2.0, 1, n, 0, False, 8, (n - 2 * MARGIN) / gaps, MARGIN)
    for n in (16, 32):
        table[f"re75-thin-{n}"] = (75, 2.8, 4, n, 0, False, 10)
    table["re75-thin-16-wide"] = (75, 2.8, 4, 16, 0, False, 20)
    table["re75-drawn-in-32"] = (75, 2.8, 4, 32, 4, True, 10)  # an eighth of the chord thick, with round ends
    return table


CASES = cases()

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
