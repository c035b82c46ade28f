#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a training of msm_train: convergence of the search, parameters with their intervals, and for every load the
measured and the computed deformation and their difference; all in one self-contained page.

usage: plot_training.py [HISTORY.h5] [-o report.html]
"""
import argparse
import base64
import html
import io
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import h5py  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from _flusi_io import InputError, run_tool  # noqa: E402
from _style import COLOURS, use_style  # noqa: E402

EVALUATIONS, BEST, GENERATION_BEST, MEDIAN, SIGMA, CONDITION = 4, 5, 6, 7, 8, 9
SCHEMA = "flusi-msm training history"


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def words(value):
    return text(value).split()


def read_history(path):
    """Everything of the file, by name; the outcome and the loads only if the training reached its end."""
    try:
        with h5py.File(path) as file:
            if text(file.attrs.get("schema", "")) != SCHEMA:
                raise InputError(f"{path}: is not the history of a training")
            history = {"names": words(file.attrs["unknowns"]), "units": text(file.attrs["units"]).split(", "),
                       "cost": words(file.attrs["cost"])[0], "lower": np.atleast_1d(file.attrs["lower"]),
                       "upper": np.atleast_1d(file.attrs["upper"]), "outcome": None, "loads": {}}
            if "generations" not in file:
                raise InputError(f"{path}: holds no generation yet")
            history["generations"] = file["generations"][:]
            if "outcome" in file:
                group = file["outcome"]
                history["outcome"] = {name: np.atleast_1d(value) for name, value in group.attrs.items()}
                history["outcome"].update({name: data[:] for name, data in group.items()})
                history["loads"] = {name: (data[:], float(np.ravel(data.attrs["force"])[0]), data.attrs["point"])
                                    for name, data in file["loads"].items()}
            return history
    except (OSError, KeyError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None


def draw_convergence(history):
    """Costs, step and condition against evaluations."""
    rows = history["generations"]
    at = rows[:, EVALUATIONS]
    figure, (costs, steps) = plt.subplots(1, 2, figsize=(9, 3.2))
    for column, label, colour in ((MEDIAN, "median of the generation", COLOURS[5]),
                                  (GENERATION_BEST, "best of the generation", COLOURS[0]),
                                  (BEST, "best so far", COLOURS[1])):
        costs.semilogy(at, rows[:, column], color=colour, label=label)
    costs.set(xlabel="evaluations", ylabel="h [m]" if history["cost"] == "h" else "χ²")
    costs.legend()
    steps.semilogy(at, rows[:, SIGMA], color=COLOURS[0], label="step σ, of the box")
    steps.semilogy(at, np.sqrt(rows[:, CONDITION]), color=COLOURS[1], label="longest over shortest axis")
    steps.set(xlabel="evaluations")
    steps.legend()
    return figure


def draw_parameters(history):
    """Each parameter in its box, in decades: the outcome with its interval, arrows where there is no end."""
    outcome, names = history["outcome"], history["names"]
    figure, axes = plt.subplots(figsize=(9, 0.6 + 0.32 * len(names)))
    for i, name in enumerate(names):
        lower, upper, value = history["lower"][i], history["upper"][i], outcome["values"][i]
        scale = np.log if lower > 0 else (lambda x: x)

        def place(x, scale=scale, lower=lower, upper=upper):
            return (scale(x) - scale(lower)) / (scale(upper) - scale(lower))

        y = len(names) - 1 - i
        axes.plot([0, 1], [y, y], color="0.85", lw=5, solid_capstyle="round", zorder=1)
        if "intervals" in outcome:
            low, _, high, has_low, has_high = outcome["intervals"][i]
            axes.plot([place(low), place(high)], [y, y], color=COLOURS[0], lw=2.5, zorder=2)
            for has, x, marker in ((has_low, place(low), "<"), (has_high, place(high), ">")):
                axes.plot([x], [y], marker="|" if has else marker, color=COLOURS[0], ms=8, zorder=3)
        axes.plot([place(value)], [y], "o", color=COLOURS[1], ms=5, zorder=4)
        axes.text(1.02, y, f"{value:.4g} {history['units'][i] if history['units'][i] != '1' else ''}", va="center")
    axes.set(xlim=(-0.02, 1.0), yticks=range(len(names)), yticklabels=names[::-1], xticks=[0, 1],
             xticklabels=["lower bound", "upper bound"])
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    return figure


def draw_load(name, rows, force, point):
    """Measured, computed, and their difference at the measured places."""
    x, y, measured, computed = rows.T * np.array([[1e3], [1e3], [1e6], [1e6]])
    figure, axes = plt.subplots(1, 3, figsize=(11, 2.6), sharey=True, constrained_layout=True)
    limit = max(np.abs(measured).max(), np.abs(computed).max(), 1e-12)
    difference = computed - measured
    spread = max(np.abs(difference).max(), 1e-12)
    for part, (ax, values, title, top) in enumerate(zip(axes, (measured, computed, difference),
                                                        ("measured", "computed", "difference"),
                                                        (limit, limit, spread))):
        dots = ax.scatter(x, y, c=values, s=7, marker="s", cmap="RdBu_r", vmin=-top, vmax=top, linewidths=0)
        ax.plot(1e3 * point[0], 1e3 * point[1], "x", color="black")
        ax.set(title=title, xlabel="x [mm]", aspect="equal")
        if part != 1:
            figure.colorbar(dots, ax=ax, label="deformation [µm]", shrink=0.9)
    axes[0].set(ylabel="y [mm]")
    figure.suptitle(f"{name}: {1e3 * force:.4g} mN; rms of the difference {np.sqrt(np.mean(difference**2)):.3g} µm",
                    fontsize=10)
    return figure


def picture(figure):
    """The figure as an element of a page."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", bbox_inches="tight", pad_inches=0.05)
    plt.close(figure)
    return f'<img alt="" src="data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}">'


def page(history, source):
    title = html.escape(f"Training: {source}")
    parts = [f"<!DOCTYPE html><html><head><meta charset='utf-8'><title>{title}</title><style>body{{font-family:"
             "sans-serif;max-width:60em;margin:2em auto}img{max-width:100%}</style></head><body>", f"<h1>{title}</h1>",
             "<h2>Search</h2>", picture(draw_convergence(history))]
    if history["outcome"] is None:
        parts.append("<p>The training has not reached its end.</p>")
    else:
        outcome = history["outcome"]
        parts += ["<h2>Parameters</h2>", f"<p>h = {outcome['h'][0]:.4g} m, χ² = {outcome['chi2'][0]:.4g}; dots: outcome, "
                  "bars: 90 % intervals, arrows: no end within the box.</p>", picture(draw_parameters(history))]
        if "singular_values" in outcome:
            parts.append("<p>Singular values of the derivatives: "
                         + ", ".join(f"{value:.3g}" for value in outcome["singular_values"]) + "</p>")
        parts.append("<h2>Loads</h2>")
        parts += [picture(draw_load(name, *load)) for name, load in history["loads"].items()]
    return "\n".join(parts + ["</body></html>\n"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("history", nargs="?", default="train_history.h5", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("report.html"))
    options = parser.parse_args()
    use_style()
    report = page(read_history(options.history), options.history)
    try:
        options.output.write_text(report, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{options.output}: cannot be written: {error.strerror}") from None
    print(options.output)


if __name__ == "__main__":
    run_tool("plot_training", main)
