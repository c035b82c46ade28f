# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws maps of a training, load by load: the measurement, the trained wing, and the difference."""
from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flusi_msm.style import COLOURS
from flusi_msm.training.run import Load, Training, in_words, prefix_of
from flusi_msm.wing.file import Wing

INK, PALE = "#3A2A18", "0.85"
LOADS_A_PICTURE = 5

Lines = tuple[list[np.ndarray], list[np.ndarray], np.ndarray]  # outline, veins, triangles


def grid_of(load: Load, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns (x, y, values on the grid with NaN where there are none), lengths in mm."""
    x, i = np.unique(load.rows[:, 0], return_inverse=True)
    y, j = np.unique(load.rows[:, 1], return_inverse=True)
    field = np.full((len(y), len(x)), np.nan)
    field[j, i] = values
    return 1e3 * x, 1e3 * y, field


def edges_of(lines: np.ndarray) -> np.ndarray:
    """Returns the borders of the cells around grid lines; where lines are left out the cells are wider."""
    if len(lines) == 1:
        return lines[0] + np.array([-0.5, 0.5])
    middle = (lines[1:] + lines[:-1]) / 2
    return np.concatenate([[2 * lines[0] - middle[0]], middle, [2 * lines[-1] - middle[-1]]])


def outline(wing: Wing) -> Lines:
    """Returns outline, veins and triangles as lines in the plane [mm]."""
    edges, count = wing.edges()
    lines = [1e3 * wing.points[e, :2] for e in edges[count == 1]]
    veins = [1e3 * wing.points[nodes, :2] for nodes, _ in wing.veins.values()]
    return lines, veins, 1e3 * wing.points[wing.triangles, :2]


def frame_of(training: Training) -> tuple[np.ndarray, np.ndarray]:
    """Returns the limits [mm] of all maps."""
    places = [1e3 * load.rows[:, :2] for load in training.loads]
    if training.wing is not None:
        places.append(1e3 * training.wing.points[:, :2])
    low, high = np.min([p.min(0) for p in places], axis=0), np.max([p.max(0) for p in places], axis=0)
    room = 0.03 * max(high - low)
    return low - room, high + room


def direction_text(load: Load) -> str:
    """Describes the direction of the force."""
    if load.direction is None:
        return ""
    axis = int(np.argmax(np.abs(load.direction)))
    if abs(load.direction[axis]) < 0.99 * np.linalg.norm(load.direction):
        return " along (" + ", ".join(f"{c:.2g}" for c in load.direction) + ")"
    return f" along {'+' if load.direction[axis] > 0 else '−'}{'xyz'[axis]}"


def draw_loads(training: Training) -> list[Figure]:
    """Draws pictures of at most LOADS_A_PICTURE loads each: measured, simulated, difference."""
    pages = [training.loads[k:k + LOADS_A_PICTURE] for k in range(0, len(training.loads), LOADS_A_PICTURE)]
    return [draw_page(training, page) for page in pages]


def draw_page(training: Training, loads: Sequence[Load]) -> Figure:
    """Draws the maps of some loads on one page."""
    low, high = frame_of(training)
    width = 3.55
    height = width * (high - low)[1] / (high - low)[0]
    left, right, gap, bar, top, below = 0.45, 0.75, 0.12, 0.12, 0.62, 0.42
    between = right + 0.05
    size = (left + 3 * width + gap + 2 * bar + 0.24 + between + right, len(loads) * (height + top) + below)
    figure = plt.figure(figsize=size)
    lines = outline(training.wing) if training.wing is not None else None

    def panel(x: float, y: float, w: float, h: float) -> Axes:
        return figure.add_axes([x / size[0], y / size[1], w / size[0], h / size[1]])

    for k, load in enumerate(loads):
        y = below + (len(loads) - 1 - k) * (height + top)
        third = left + 2 * width + gap + 0.12 + bar + between
        axes = [panel(x, y, width, height) for x in (left, left + width + gap, third)]
        bars = [panel(left + 2 * width + gap + 0.12, y, bar, height), panel(third + width + 0.12, y, bar, height)]
        draw_load(axes, bars, load, lines)
        for a in axes:
            a.set_xlim(low[0], high[0])
            a.set_ylim(low[1], high[1])
            a.tick_params(labelbottom=k == len(loads) - 1, labelleft=a is axes[0])
            a.xaxis.set_major_locator(MaxNLocator(5, integer=True))
            a.yaxis.set_major_locator(MaxNLocator(4, integer=True))
            if k == len(loads) - 1:
                a.set_xlabel("x [mm]")
        axes[0].set_ylabel("y [mm]", labelpad=1)
        percent = f" ({100 * load.rms / load.largest:.2g} % of the largest deformation)" if load.largest > 0 else ""
        axes[0].text(0, height_share(height, 0.30), f"{load.name}:  {1e3 * load.force:.3g} mN{direction_text(load)}",
                     transform=axes[0].transAxes, weight="bold", fontsize=10)
        axes[2].text(1, height_share(height, 0.30), f"rms {in_words(load.rms, 'm')}{percent}", fontsize=9, color="0.3",
                     transform=axes[2].transAxes, ha="right")
        for a, name in zip(axes, ("measured", "simulated", "simulated − measured")):
            a.text(0, height_share(height, 0.07), name, transform=a.transAxes, fontsize=9, color="0.25")
    return figure


def height_share(height: float, inches: float) -> float:
    """Returns a place above a panel, in its own units."""
    return 1 + inches / height


def draw_load(axes: Sequence[Axes], bars: Sequence[Axes], load: Load, lines: Lines | None) -> None:
    """Draws the three maps of one load and their colour bars."""
    largest = 1e3 * max(load.largest, float(np.abs(load.rows[:, 3]).max())) or 1.0
    both = 1e3 * load.rows[:, 2:]
    signed = both.min() < -0.1 * largest and both.max() > 0.1 * largest
    if signed:
        limits, colours = (-largest, largest), "RdBu_r"
    elif both.max() >= -both.min():
        limits, colours = (0, largest), "viridis"
    else:
        limits, colours = (-largest, 0), "viridis_r"
    levels = np.linspace(*limits, 11)[1:-1]
    for a, values in zip(axes[:2], both.T):
        x, y, field = grid_of(load, values)
        drawn = a.pcolormesh(edges_of(x), edges_of(y), np.ma.masked_invalid(field), cmap=colours, vmin=limits[0],
                             vmax=limits[1], rasterized=True)
        if min(field.shape) > 2:
            a.contour(x, y, np.ma.masked_invalid(field), levels=levels, colors="white", linewidths=0.6, alpha=0.85,
                      linestyles="solid")
    worst = float(np.percentile(np.abs(load.difference), 99.5)) or 1e-15
    factor, unit = prefix_of(worst, "m")
    worst *= factor
    x, y, field = grid_of(load, factor * load.difference)
    other = axes[2].pcolormesh(edges_of(x), edges_of(y), np.ma.masked_invalid(field), cmap="RdBu_r", vmin=-worst,
                               vmax=worst, rasterized=True)
    for a in axes:
        a.set_aspect("equal")
        if lines:
            a.add_collection(PolyCollection(lines[2], facecolors=PALE, edgecolors=PALE, linewidths=0.5, zorder=0))
            a.add_collection(LineCollection(lines[1], colors=INK, linewidths=0.7, alpha=0.6))
            a.add_collection(LineCollection(lines[0], colors=INK, linewidths=0.9))
        a.plot(*(1e3 * load.point), marker="o", ms=7, mfc=COLOURS[1], mec="white", mew=1.2, zorder=6)
    for cax, made, name in zip(bars, (drawn, other), ("deformation [mm]", f"difference [{unit}]")):
        bar = axes[0].figure.colorbar(made, cax=cax, extend="both" if made is other else "neither")
        bar.set_label(name)
        bar.outline.set_linewidth(0.5)
