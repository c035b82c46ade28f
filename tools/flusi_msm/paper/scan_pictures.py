# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of the scan of the kinematics: small multiples over two angles, one column for each value of the third."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.paper.cases import FLEXIBLE, RIGID
from flusi_msm.paper.numbers import COLUMNS
from flusi_msm.paper.scan import AXES, complete, quantities
from flusi_msm.style import save, use_style

if TYPE_CHECKING:
    from flusi_msm.paper.scan import Quantity, ValueOf
    from flusi_msm.paper.study_files import Picture

LABELS = dict(zip(COLUMNS, ("lift [mN]", "drag [mN]", "power [mW]", "lift / drag", "lift / power [mN/mW]")))
CHANGE_LABELS = {"lift_to_drag": "lift / drag [%]", "lift_to_power": "lift / power [%]"}
NAMES = {"pitch": "mean pitch [°]", "stroke": "amplitude [°]", "tilt": "tilt [°]"}
PAPER_COLOUR, SHIPPED_COLOUR = "#D55E00", "#000000"


def axes_of(found: dict[str, Any]) -> list[str]:
    """(x, y, axis of the columns): angles that have several values first, in the order of AXES."""
    return sorted(AXES, key=lambda axis: len(found["values"][axis]) == 1)


def field(found: dict[str, Any], value: ValueOf, column: float) -> np.ndarray:
    """(values of y, values of x) of a quantity in one column; NaN where there is none."""
    x, y, third = axes_of(found)
    at = {(point[y], point[x]): value(point) for point in found["scan"] if point[third] == column}
    return np.array([[np.nan if at.get((v, u)) is None else at[v, u] for u in found["values"][x]] for v in found["values"][y]], float)


def edges(values: Sequence[float]) -> np.ndarray:
    """Of the cells about the values."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    half = (values[1] - values[0]) / 2
    return np.append(np.asarray(values) - half, values[-1] + half)


def colours_of(quantity: Quantity, fields: Sequence[np.ndarray], paper: float) -> tuple[str, Normalize]:
    """(colour map, norm): changes are white at 0; the others have the paper's value in their range."""
    there = np.concatenate([f[np.isfinite(f)] for f in fields] + [[paper]])
    if quantity[0] == "change":
        limit = float(np.max(np.abs(there))) or 1.0
        return "RdBu", matplotlib.colors.Normalize(-limit, limit)
    low, high = float(there.min()), float(there.max())
    return "viridis", matplotlib.colors.Normalize(low, high if high > low else low + 1)


def draw_cell_numbers(ax: Axes, places: tuple[Sequence[float], Sequence[float]], values: np.ndarray, colours: Colormap, norm: Normalize,
                      is_change: bool) -> None:
    """Writes the numbers of a map into its cells."""
    for (v, u), value in zip(((v, u) for v in places[1] for u in places[0]), values.ravel()):
        if not np.isfinite(value):
            ax.text(u, v, "–", ha="center", va="center", color="0.4")
            continue
        red, green, blue, _ = colours(norm(value))
        dark = 0.3 * red + 0.59 * green + 0.11 * blue < 0.5
        text = f"{value:+.0f}" if is_change else f"{value:#.3g}"
        ax.text(u, v, text, ha="center", va="center", color="w" if dark else "k", fontsize=8.5, zorder=4)


def draw_map(ax: Axes, places: tuple[Sequence[float], Sequence[float]], quantity: Quantity, values: np.ndarray, paper: float,
             colours: Colormap, norm: Normalize) -> None:
    """One panel; `places` are the values of x and y."""
    ax.pcolormesh(*map(edges, places), np.ma.masked_invalid(values), cmap=colours, norm=norm)
    draw_cell_numbers(ax, places, values, colours, norm, quantity[0] == "change")
    whole = min(map(len, places)) > 1 and np.isfinite(values).sum() > 3
    if whole and np.nanmin(values) <= paper <= np.nanmax(values):
        ax.contour(*places, np.ma.masked_invalid(values), levels=[paper], colors=PAPER_COLOUR, linewidths=2.0)
    if quantity[0] == "change" and whole and np.nanmin(values) < 0 < np.nanmax(values):
        ax.contour(*places, np.ma.masked_invalid(values), levels=[0.0], colors="0.2", linewidths=1.2, linestyles="--")
    ax.set_xticks(places[0])
    ax.set_yticks(places[1])
    ax.tick_params(length=0)


def mark(ax: Axes, found: dict[str, Any], column: float) -> None:
    """A frame about the shipped kinematics, one about the nearest point."""
    x, y, third = axes_of(found)
    width, height = (np.ptp(edges(found["values"][axis])) / len(found["values"][axis]) for axis in (x, y))
    for name, colour, style in (("shipped", SHIPPED_COLOUR, "-"), ("nearest", PAPER_COLOUR, ":")):
        point = found.get(name)
        if point and point[third] == column:
            ax.add_patch(plt.Rectangle((point[x] - 0.47 * width, point[y] - 0.47 * height), 0.94 * width, 0.94 * height,
                                       fill=False, edgecolor=colour, linestyle=style, linewidth=1.6, zorder=3))


def panels(rows: int, columns: int) -> tuple[Figure, np.ndarray]:
    """(figure, axes [row, column]): quantities below each other; beside each other if there is one column."""
    if columns > 1:
        shape, size = (rows, columns), (1.9 + 2.3 * columns, 0.6 + 1.75 * rows)
    else:
        shape, size = (1, rows), (3.3 * rows, 2.6)
    figure, axes = plt.subplots(*shape, squeeze=False, sharex=True, sharey=True, layout="constrained", figsize=size)
    return figure, axes if columns > 1 else axes.T


def maps(found: dict[str, Any], kind: str, folder: Path) -> Path:
    """The map of all quantities of one kind, 'rigid', 'flexible' or 'change'."""
    use_style()
    rows = [row for row in quantities() if row[0][0] == kind]
    x, y, third = axes_of(found)
    places, columns = (found["values"][x], found["values"][y]), found["values"][third]
    figure, axes = panels(len(rows), len(columns))
    for line, (quantity, value, paper) in zip(axes, rows):
        fields = [field(found, value, column) for column in columns]
        name, norm = colours_of(quantity, fields, paper)
        colours = matplotlib.colormaps[name]
        for ax, values, column in zip(line, fields, columns):
            draw_map(ax, places, quantity, values, paper, colours, norm)
            mark(ax, found, column)
        bar = figure.colorbar(matplotlib.cm.ScalarMappable(norm, colours), ax=line[-1], aspect=14, fraction=0.09)
        bar.ax.axhline(paper, color=PAPER_COLOUR, linewidth=2.5)
        bar.set_label((CHANGE_LABELS if kind == "change" else LABELS)[quantity[1]])
        text = f"{paper:+.0f} %" if kind == "change" else f"{paper:#.3g}"
        line[0].annotate(f"paper {text}", (0.0, 1.02), xycoords="axes fraction", color=PAPER_COLOUR, fontsize=8.5)
    for ax in axes[:, 0] if len(columns) > 1 else axes[0]:
        ax.set_ylabel(NAMES[y])
    for ax, column in zip(axes[0], columns):
        ax.set_title(f"{NAMES[third].split(' [')[0]} {column:g}°", pad=16)
    for ax in axes[-1] if len(columns) > 1 else axes[:, 0]:
        ax.set_xlabel(NAMES[x])
    path = folder / f"map_{kind}.png"
    save(figure, path)
    return path


def all_maps(found: dict[str, Any], folder: Path) -> list[Picture]:
    """[(heading, caption, path)]; nothing before a point has both wings."""
    if not complete(found):
        return []
    folder.mkdir(parents=True, exist_ok=True)
    legend = (" Orange line, and mark on the colour bar: the paper's value (linear between the points). Black frame: the shipped "
              "kinematics; dotted orange frame: the point nearest to the paper.")
    grid = f"{found['points_along_x']} points, beat {found['beats']}."
    made = [("What bending changes", f"Flexible against rigid wings, {grid} Blue: bending raises the ratio; dashed: no change." + legend,
             maps(found, "change", folder))]
    for kind in (RIGID, FLEXIBLE):
        made.append((f"{kind.capitalize()} wings", f"Both wings together, {grid}" + legend, maps(found, kind, folder)))
    return made
