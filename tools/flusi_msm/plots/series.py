# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws time series (*.t): the important columns of each file, or the given ones."""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes

from flusi_msm.results.files import Series

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from flusi_msm.errors import run_command
from flusi_msm.results.files import InputError, read_series
from flusi_msm.style import COLOURS, name_of, save, use_style

# The panels of each known file, as (label of the axis, column numbers).
PANELS: dict[str, list[tuple[str, tuple[int, ...]]]] = {
    "forces": [("force", (1, 2, 3)), ("moment", (7, 8, 9))],
    "energy": [("kinetic energy", (1, 2, 3, 4)), ("dissipation rate", (5,))],
    "ekin": [("kinetic energy", (1,))],
    "dt": [("time step", (1,)), ("CFL number", (2,))],
    "timesteps_info": [("wall time per step [s]", (1,)), ("time step", (3,))],
    "meanflow": [("mean velocity", (1, 2, 3))],
}
# Series of `flusi --solid`, whose file has the name of the run.
WING_COLUMNS = ("tip_x", "tip_y", "tip_z", "largest", "E_kin", "E_kin_rel", "E_elastic")
WING_PANELS = [("displacement", (1, 2, 3, 4)), ("energy", (5, 6, 7)), ("work and loss", (8, 9, 10, 11, 12))]
MOST_COLUMNS = 8  # in one panel of an unknown file


def panels_of(series: Series, wanted: Sequence[str]) -> list[tuple[str, list[int]]]:
    """Returns [(label of the axis, column numbers)] to draw from a file."""
    n = len(series.names)
    if wanted:
        by_unit: dict[str, list[int]] = {}
        for name in wanted:
            i = series.index(name)
            by_unit.setdefault(series.units[i], []).append(i)
        return [(f"[{unit}]" if unit else "", columns) for unit, columns in by_unit.items()]
    kind = "forces" if series.kind.startswith("forces_part") else series.kind
    panels = WING_PANELS if tuple(series.names[1:8]) == WING_COLUMNS else PANELS.get(kind, [])
    known = [(label, [i for i in columns if i < n]) for label, columns in panels]
    largest = np.nanmax(np.abs(series.data[:, 1:]), initial=0.0)
    # A moment that vanishes by symmetry would be drawn as a panel of rounding errors.
    known = [(label, columns) for number, (label, columns) in enumerate(known)
             if number == 0 or not columns or np.nanmax(np.abs(series.data[:, columns])) > 1e-10 * largest]
    known = [(with_unit(label, series, columns), columns) for label, columns in known if columns]
    return known or [("", list(range(1, min(n, MOST_COLUMNS + 1))))]


def with_unit(label: str, series: Series, columns: Sequence[int]) -> str:
    """Returns the label with the unit of its columns, if they have one in common."""
    units = {series.units[i] for i in columns}
    unit = units.pop() if len(units) == 1 else ""
    return f"{label} [{unit}]" if unit and "[" not in label else label


def draw(files: Sequence[str | Path], wanted: Sequence[str], out: str | Path) -> None:
    """Draws all files in one picture."""
    all_series = [read_series(path) for path in files]
    for series in all_series:
        if len(series.data) < 2:
            raise InputError(f"{series.path}: {len(series.data)} line(s) of numbers, nothing to draw yet")

    panels: dict[tuple[str, int], list[tuple[Series, list[int]]]] = {}  # by the kind of file and the number of the panel
    labels: dict[tuple[str, int], str] = {}
    for series in all_series:
        for number, (label, columns) in enumerate(panels_of(series, wanted)):
            panels.setdefault((series.kind, number), []).append((series, columns))
            labels.setdefault((series.kind, number), label)

    use_style()
    figure, axes = plt.subplots(len(panels), 1, sharex=True, squeeze=False,
                                figsize=(6.4, 1.0 + 2.3 * len(panels)), layout="constrained")
    for ax, key in zip(axes[:, 0], panels):
        draw_panel(ax, panels[key], labels[key])
    unit = all_series[0].units[0]
    axes[-1, 0].set_xlabel(f"time [{unit}]" if unit else "time")
    figure.align_ylabels()
    save(figure, out)


def draw_panel(ax: Axes, content: Sequence[tuple[Series, list[int]]], label: str) -> None:
    """Draws columns of one or more files in one panel."""
    lines = ("-", "--", ":", "-.")
    n_curves = sum(len(columns) for _, columns in content)
    for number, (series, columns) in enumerate(content):
        for colour, i in enumerate(columns):
            name = series.names[i]
            if len(content) > 1:
                name += f" ({series.path.parent.name or series.path})"
            ax.plot(series.time, series.data[:, i], lines[number % len(lines)],
                    color=COLOURS[colour % len(COLOURS)], label=name)
    first, columns = content[0]
    ax.set_ylabel(label or (first.names[columns[0]] if len(columns) == 1 else ""))
    ax.margins(x=0)
    limit_axis(ax, [series.data[:, i] for series, columns in content for i in columns])
    if n_curves > 1:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def limit_axis(ax: Axes, curves: Sequence[np.ndarray]) -> None:
    """Limits an axis: if a few values, such as those of an impulsive start, make it ten times longer, they are cut off, and the
    axis says so."""
    values = np.concatenate(curves)
    values = values[np.isfinite(values)]
    if len(values) < 50:
        return
    low, high = np.percentile(values, [2, 98])
    middle = max(high - low, 0.2 * max(abs(low), abs(high)))
    if middle == 0 or np.ptp(values) < 10 * middle:
        return
    low, high = low - 0.15 * middle, high + 0.15 * middle
    ax.set_ylim(low, high)
    beyond = np.count_nonzero((values < low) | (values > high))
    ax.text(0.99, 0.97, f"{beyond} of {len(values)} values beyond the axis, extremes {values.min():.3g} and "
            f"{values.max():.3g}", transform=ax.transAxes, ha="right", va="top", fontsize="x-small", color="0.4")


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.t")
    parser.add_argument("--columns", help="names of columns, separated by commas")
    parser.add_argument("-o", "--output", help="picture to write (default: beside the first file, named after all files and columns)")
    arguments = parser.parse_args()
    wanted = [name.strip() for name in (arguments.columns or "").split(",") if name.strip()]
    first = Path(arguments.files[0])
    name = name_of(*dict.fromkeys(Path(path).stem for path in arguments.files), *wanted)
    draw(arguments.files, wanted, arguments.output or first.with_name(f"{name}.png"))


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_series", main)
