#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a diagnosis of msm_diagnose and collects everything in one page that needs no other file: the verdict and what is
gained by it, what it may be confused with, maps of what the model misses, all candidates, and what to measure next.

usage: plot_diagnosis.py NAME.json [-o HTML] [--pictures FOLDER]

NAME.h5 is looked for beside NAME.json.
"""
import argparse
import io
import json
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from _diagnosis_report import page  # noqa: E402
from _flusi_io import InputError, run_tool  # noqa: E402
from _style import COLOURS, use_style  # noqa: E402

SHOWN_LOADS = 8
LIMIT = 4.0  # sd, of the colours of residuals


def read(path):
    """The JSON file and the tables of the HDF5 file beside it."""
    try:
        diagnosis = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}") from None
    if diagnosis.get("schema") != "flusi-msm diagnosis" or diagnosis.get("schema_version") != 1:
        raise InputError(f"{path}: no diagnosis of a known version")
    loads, unknown = {}, {}
    tables = path.with_suffix(".h5")
    if tables.exists():
        with h5py.File(tables, "r") as file:
            for name, table in file["loads"].items():
                loads[name] = (np.asarray(table), np.ravel(table.attrs["point"]),
                               float(np.ravel(table.attrs["force"])[0]))
            for name, table in file.get("unknown", {}).items():
                unknown[name] = np.asarray(table)
    return diagnosis, loads, unknown


def table_of(values):
    """Rows of a table, whichever way it was stored."""
    return values if values.shape[1] in (4, 7) else values.T


def draw_residuals(loads):
    """Residuals of baseline and extended wing, in units of their sd, for the loads that fit worst."""
    def misfit(name):
        return -float(np.sum(table_of(loads[name][0])[:, 5]**2))
    names = sorted(sorted(loads, key=misfit)[:SHOWN_LOADS])
    figure, axes = plt.subplots(len(names), 3, figsize=(10, 1.7 * len(names)), squeeze=False, layout="constrained")
    for row, name in zip(axes, names):
        rows, point, force = table_of(loads[name][0]), *loads[name][1:]
        x, y = 1e3 * rows[:, 0], 1e3 * rows[:, 1]
        pictures = [(1e6 * rows[:, 2], "measured [µm]", "viridis", None), (rows[:, 5], "baseline [sd]", "RdBu_r", LIMIT),
                    (rows[:, 6], "extended [sd]", "RdBu_r", LIMIT)]
        for ax, (values, title, colours, limit) in zip(row, pictures):
            on = (rows[:, 0] != 0) | (rows[:, 1] != 0)
            image = ax.scatter(x[on], y[on], c=values[on], s=42, marker="s", cmap=colours,
                               vmin=None if limit is None else -limit, vmax=limit)
            ax.plot(*(1e3 * point), "k+", ms=8)
            ax.set_aspect("equal")
            ax.set_title(f"{name}, {1e3 * force:.3g} mN: {title}" if values is pictures[0][0] else title, fontsize=8)
            ax.tick_params(labelsize=7)
            figure.colorbar(image, ax=ax, shrink=0.8).ax.tick_params(labelsize=7)
    return figure


def draw_unknown(unknown):
    """Where stiffness or forces would have to differ."""
    figure, axes = plt.subplots(1, len(unknown), figsize=(4.8 * len(unknown), 2.6), squeeze=False, layout="constrained")
    for ax, (name, values) in zip(axes[0], sorted(unknown.items())):
        rows = table_of(values)
        ratio = rows[:, 2] / np.maximum(rows[:, 3], 1e-300)
        image = ax.scatter(1e3 * rows[:, 0], 1e3 * rows[:, 1], c=ratio, s=320, cmap="RdBu_r", vmin=-LIMIT, vmax=LIMIT,
                           edgecolors="#8c8478")
        ax.set_aspect("equal")
        ax.set_title(f"{name}: mean over sd")
        ax.set_xlabel("x [mm]")
        ax.set_ylabel("y [mm]")
        figure.colorbar(image, ax=ax, shrink=0.8)
    return figure


def draw_evidence(effects):
    """Evidence of all candidates that were tested."""
    tested = sorted((e for e in effects if e["status"] == "tested"), key=lambda e: e["log_evidence"])
    figure, ax = plt.subplots(figsize=(7, 0.8 + 0.26 * len(tested)), layout="constrained")
    values = [e["log_evidence"] for e in tested]
    ax.barh([e["title"] for e in tested], values,
            color=[COLOURS[1] if e["is_measurement"] else COLOURS[0] for e in tested])
    ax.axvline(0, color="k", lw=0.8)
    if values:
        ax.axvline(max(values) - 3, color="k", lw=0.8, ls="--")
    ax.set_xlabel("log evidence over the baseline")
    return figure


def draw_folds(validation):
    """Log predictive density of every location that was left out."""
    base, extended = validation["baseline"], validation["extended"]
    common = [f for f in base["location"] if f in extended["location"]]
    gains = [extended["log_density"][extended["location"].index(f)] - base["log_density"][base["location"].index(f)]
             for f in common]
    figure, ax = plt.subplots(figsize=(5, 2.6), layout="constrained")
    ax.bar([f"{f:.0f}" for f in common], gains, color=COLOURS[2])
    ax.axhline(0, color="k", lw=0.8)
    ax.set_xlabel("location left out")
    ax.set_ylabel("gain of log density")
    return figure


def pictures_of(diagnosis, loads, unknown):
    """(name, heading, caption, figure)."""
    made = []
    if loads:
        made.append(("residuals", "What the model misses", "For the loads that fit worst: the measured deformation, and "
                     "what the baseline and the extended wing leave of it, in units of its errors. White is noise; "
                     "patches of one colour are a shape. The cross marks the force.", draw_residuals(loads)))
    made.append(("evidence", "The candidates", "How much more probable each cause makes the data than the baseline alone "
                 "(blue: of the wing, orange: of the measurement). What lies right of the dashed line the data cannot "
                 "tell from the first.", draw_evidence(diagnosis["effects"])))
    if unknown:
        made.append(("unknown", "Where on the wing", "If nothing but the stiffness, or nothing but further forces, were "
                     "free all over the wing: where they would have to differ, in units of what chance does.",
                     draw_unknown(unknown)))
    if diagnosis["validation"]["has_gain"]:
        made.append(("folds", "Loads that the fit has not seen", "Each location was left out with all its levels and "
                     "predicted from the others. Above zero the extended wing predicts better.",
                     draw_folds(diagnosis["validation"])))
    return made


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("json", type=Path)
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--pictures", type=Path, help="also write the pictures into this folder")
    options = parser.parse_args()
    use_style()
    diagnosis, loads, unknown = read(options.json)
    pictures = []
    for name, heading, caption, figure in pictures_of(diagnosis, loads, unknown):
        data = io.BytesIO()
        figure.savefig(data, format="png", dpi=110)
        if options.pictures:
            options.pictures.mkdir(parents=True, exist_ok=True)
            (options.pictures / f"diagnosis_{name}.png").write_bytes(data.getvalue())
        plt.close(figure)
        pictures.append((heading, caption, data.getvalue()))
    output = options.output or options.json.parent / "report.html"
    try:
        output.write_text(page(diagnosis, pictures))
    except OSError as error:
        raise InputError(f"{output}: {error}") from None
    print(output)


if __name__ == "__main__":
    run_tool("plot_diagnosis.py", main)
