#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows how much two simulations of the same plane flight differ from each other and from measured forces: `flusi` with a
surface without thickness, and the flow of tools/make_flight about thin ellipses, which shares no code with it.
docs/results/flight-records.md holds the tables.

usage: run [--program FLUSI] [--measured FOLDER] [--picture FILE] FOLDER [CASE ...]
       run --list

runs the cases of flusi (all of them without names) in FOLDER and those of the other flow, and prints the tables; the last line is
JSON. What has finished is not run again. --measured names the folder with CL_measured.dat and CD_measured.dat.
"""
import json

import numpy as np
import plane_plate

from flusi_msm.flow2d.beat import Beat
from flusi_msm.flow2d.grid import Resolution
from flusi_msm.flow2d.hover import Effort, Section, fly

RE, STROKE = 75, 2.8
# Name: beats, points in a chord, chords of the box.
CASES = {"flusi-16": (4, 16, 10), "flusi-32": (4, 32, 10), "flusi-16-wide": (4, 16, 20), "flusi-32-wide": (2, 32, 20)}
# Name: thickness over chord, effort.
ELLIPSES = {"ellipse-0.02": (0.02, Effort()), "ellipse-0.05": (0.05, Effort()), "ellipse-0.12": (0.12, Effort()),
            "ellipse-0.05-coarse": (0.05, Effort(resolution=Resolution(48, 70)))}
THIN = "thickness 0"     # the straight line through the two thinnest ellipses
BEATS = 4
WINDOWS = {"1": (0.15, 0.98), "2": (1.0, 1.98), "3, 4": (2.0, 3.98)}
NAMES = "drag", "lift", "power"


def ellipse(folder, name):
    """Computes the curves of an ellipse: t/T, force along y and z, and power, in units of rho U^2 c/2 and rho U^3 c/2."""
    path = folder / f"{name}.npy"
    if not path.exists():
        ratio, effort = ELLIPSES[name]
        period = np.pi * STROKE
        beat = Beat(lambda s: (STROKE / 2 * np.cos(2 * np.pi * s), 0 * s),
                    lambda s: np.pi / 2 + np.radians(plane_plate.PITCH) * np.sin(2 * np.pi * s), period)
        found = fly(Section(ratio=ratio, nu=1 / RE), beat, BEATS, effort)
        np.save(path, np.stack([found["time"] / period, 2 * found["force"][:, 0], 2 * found["force"][:, 1], 2 * found["power"]]))
    return np.load(path)


def curves_of(folder):
    """Returns {name: (t/T, force along y, lift, power)}."""
    found = {}
    for name in ELLIPSES:
        found[name] = ellipse(folder, name)
    a, b = found["ellipse-0.02"], found["ellipse-0.05"]
    found[THIN] = np.stack([a[0], *((5 * x - 2 * np.interp(a[0], b[0], y)) / 3 for x, y in zip(a[1:], b[1:]))])
    for name in CASES:
        if (folder / name / "done").exists():
            found[name] = np.stack(plane_plate.read(folder / name, STROKE))
    return found


def at(curve, t):
    """Returns drag along the stroke (it jumps where the stroke turns), lift and power at the times t."""
    y, z, power = (np.interp(t, curve[0], x) for x in curve[1:])
    return np.array([plane_plate.along_stroke(t, y), z, power])


def compare(curves, reference):
    """Returns a table of the means and of the rms differences from one curve, in % of its rms, over parts of the flight."""
    rows = {}
    print(f"\nDifferences from {reference}, in % of the rms of its curve (drag, lift, power)")
    print(f"{'case':22s}{'beat':>6s}{'mean':>24s}{'difference of means':>24s}{'rms of differences':>24s}{'best factor':>24s}{'rms with it':>24s}")
    base = curves[reference]
    for name, curve in curves.items():
        for beat, (begin, end) in WINDOWS.items():
            if curve[0][-1] < end - 0.05 or name == reference:
                continue
            t = np.linspace(begin, end, 1500)
            here, there = at(curve, t), at(base, t)
            size = np.sqrt((there**2).mean(1))
            factor = (here * there).sum(1) / (here**2).sum(1)
            row = {"mean": here.mean(1), "difference": 100 * (here - there).mean(1) / size,
                   "rms": 100 * np.sqrt(((here - there)**2).mean(1)) / size, "factor": factor,
                   "rms_at_factor": 100 * np.sqrt(((factor[:, None] * here - there)**2).mean(1)) / size}
            rows[f"{name}, beat {beat}"] = {key: [round(float(v), 4) for v in values] for key, values in row.items()}
            print(f"{name:22s}{beat:>6s}" + "".join("".join(f"{v:8.3f}" if key in ("mean", "factor") else f"{v:8.1f}" for v in values)
                                                    for key, values in row.items()))
    return rows


def beside_measured(curves, measured):
    """Returns the lines of the comparison with the measured curves over 1 < t/T < 4."""
    data = {key: plane_plate.read_measured(measured, key) for key in ("CD", "CL")}
    if any(x is None for x in data.values()):
        return {}
    print("\nOver 1 < t/T < 4: mean C_D, C_L; rms of the difference from the measured curves in % of their rms, and at the best\n"
          "common factor on both; the factor; correlations")
    rows = {}
    sorted_data = {key: x[np.argsort(x[:, 0], kind="stable")] for key, x in data.items()}
    inside = {key: x[x[:, 0] >= 1] for key, x in sorted_data.items()}
    print("measured" + "".join(f"{plane_plate.mean_over(*inside[key].T):8.3f}" for key in ("CD", "CL")))
    for name, curve in curves.items():
        if curve[0][-1] < 3.9:
            continue
        here = {key: at(curve, x[:, 0])[n] for (key, x), n in zip(inside.items(), (0, 1))}
        top = sum(float(here[key] @ inside[key][:, 1]) for key in here)
        factor = top / sum(float(h @ h) for h in here.values())
        row = {"mean": [plane_plate.mean_over(*np.stack([inside[key][:, 0], h])) for key, h in here.items()],
               "rms": [100 * rms(h - inside[key][:, 1]) / rms(inside[key][:, 1]) for key, h in here.items()],
               "rms_at_factor": [100 * rms(factor * h - inside[key][:, 1]) / rms(inside[key][:, 1]) for key, h in here.items()],
               "factor": [factor], "correlation": [float(np.corrcoef(h, inside[key][:, 1])[0, 1]) for key, h in here.items()]}
        rows[name] = {key: [round(float(v), 4) for v in values] for key, values in row.items()}
        print(f"{name:22s}" + "".join("".join(f"{v:9.3f}" for v in values) + "  " for values in row.values()))
    return rows


def rms(x):
    return float(np.sqrt(np.mean(np.asarray(x)**2)))


def draw(curves, measured, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from flusi_msm.style import COLOURS, save, use_style
    use_style()
    figure, axes = plt.subplots(2, 1, figsize=(10, 6.4), sharex=True)
    for axis, n, key, label in zip(axes, (1, 0), ("CL", "CD"), ("lift", "drag")):
        for name, words, colour in (("flusi-32", "flusi, no thickness, c/dx = 32", COLOURS[0]),
                                    ("flusi-16", "flusi, no thickness, c/dx = 16", COLOURS[2]),
                                    ("ellipse-0.02", "other flow, ellipse of 2 %", COLOURS[1]),
                                    ("ellipse-0.12", "other flow, ellipse of 12 %", COLOURS[4])):
            if name in curves:
                t = np.linspace(0.01, 3.99, 3000)
                axis.plot(t, at(curves[name], t)[n], color=colour, label=words)
        data = plane_plate.read_measured(measured, key)
        if data is not None:
            axis.plot(data[:, 0], data[:, 1], "k.", ms=3, label="measured, three-dimensional wing")
        axis.set(ylabel=f"{label} over $\\rho U^2 c/2$", ylim=(-2.2, 3.4))
    axes[0].legend(fontsize=7, ncol=3)
    axes[1].set(xlabel="t/T")
    figure.tight_layout()
    save(figure, path)


def main():
    options = plane_plate.read_options(__doc__, CASES)
    plane_plate.fly(options, {name: (RE, STROKE, beats, points, 0, False, box) for name, (beats, points, box) in CASES.items()})
    curves = curves_of(options.folder)
    found = {reference: compare(curves, reference) for reference in (THIN, "ellipse-0.05")}
    found["measured"] = beside_measured(curves, options.measured)
    if options.picture:
        draw(curves, options.measured, options.picture)
    print(json.dumps(found))


if __name__ == "__main__":
    main()
