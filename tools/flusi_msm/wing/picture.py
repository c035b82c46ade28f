# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a wing as it was made: veins in different colours and as wide as they are, mesh, joints, root, centre."""
from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Wedge

from flusi_msm.wing.file import Wing
from flusi_msm.wing.report import Quality

INK, MESH, MEMBRANE, ROOT = "#2B2118", "#C9C9C9", "#F7F5EF", "#B2182B"
WIDTH = 11.0                  # inches
ROW = 0.021                   # height of a line of text by the size of the wing
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8860B", "#2F9BD7", "#7B3F00", "#6A51A3", "#D6336C", "#4D7C0F", "#0F766E",
           "#A63603", "#525252", "#8C6BB1"]


def vein_polygons(xy: np.ndarray, nodes: Sequence[int], diameters: np.ndarray) -> np.ndarray:
    """Returns one quadrilateral (4, 2) per segment, as wide as the vein at both ends; the gaps in bends are closed by round
    ends, which are drawn separately."""
    p, d = xy[list(nodes)], np.asarray(diameters)[:, None] / 2
    along = np.diff(p, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return np.stack([p[:-1] + normal * d[:-1], p[1:] + normal * d[1:], p[1:] - normal * d[1:], p[:-1] - normal * d[:-1]], axis=1)


def _place_names(axes: Axes, wing: Wing, xy: np.ndarray, span: float, colours: dict[str, str], taken: list[np.ndarray]) -> None:
    """Places a name at its vein, as far as possible from what is already drawn."""
    every = {name: xy[list(nodes)] for name, (nodes, _) in wing.veins.items()}
    gap = 0.019 * span
    for name, line in sorted(every.items(), key=lambda item: -len(item[1])):
        others = [p for other, p in every.items() if other != name] + taken
        best = (-np.inf, line[0], 0.0)
        s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        half = (0.0033 * len(name) + 0.004) * span
        for part, far in product(np.linspace(0.15, 0.85, 29), (1.0, 1.5, 2.2)):
            here, ahead = (np.array([np.interp(min(max(part + shift, 0), 1) * s[-1], s, line[:, i]) for i in (0, 1)])
                           for shift in (-0.02, 0.02))
            middle, along = (here + ahead) / 2, (ahead - here) / (np.linalg.norm(ahead - here) or 1)
            along = along if along[0] > 0.2 or (along[0] > -0.2 and along[1] > 0) else -along
            is_steep = s[-1] < 3 * half              # too short to be named along its direction
            for side in (1, -1):
                normal = side * np.array([-along[1], along[0]])
                word = middle + normal * far * (gap if not is_steep else gap * 0.7 + half * abs(normal[0]))
                direction = np.array([1.0, 0.0]) if is_steep else along
                spots = word + np.linspace(-half, half, 7)[:, None] * direction
                room = min([np.linalg.norm(p[:, None] - spots, axis=2).min() for p in others] or [span])
                own = np.linalg.norm(line[:, None] - spots, axis=2).min()
                room = min(room, own, 1.1 * gap) - max(0.0, own - room) - 0.004 * span * abs(part - 0.5) - 0.3 * gap * (far - 1)
                if room > best[0]:
                    best = (room, word, 0.0 if is_steep else float(np.degrees(np.arctan2(along[1], along[0]))))
                    spots_of_best = spots
        axes.text(*best[1], name, rotation=best[2], rotation_mode="anchor", ha="center", va="center", fontsize=8, style="italic",
                  color=colours[name], zorder=9)
        taken.append(spots_of_best)


def _mark_centre(axes: Axes, place: np.ndarray, radius: float) -> None:
    """Draws the black and white disc that marks a centre of mass."""
    axes.add_patch(Circle(place, radius, fc="white", ec="black", lw=0.9, zorder=12))
    for begin in (0, 180):
        axes.add_patch(Wedge(place, radius, begin, begin + 90, fc="black", ec="none", zorder=13))


def _draw_surface(axes: Axes, wing: Wing, xy: np.ndarray, edges: np.ndarray, count: np.ndarray) -> None:
    """Draws the membrane with its mesh and its outline. `count` says of how many triangles an edge is part."""
    axes.add_collection(PolyCollection(xy[wing.triangles], facecolors=MEMBRANE, edgecolors="none", zorder=0))
    axes.add_collection(LineCollection(xy[edges], colors=MESH, linewidths=0.45, zorder=1))
    axes.add_collection(LineCollection(xy[edges[count == 1]], colors=INK, linewidths=0.7, zorder=2))


def _draw_veins(axes: Axes, wing: Wing, xy: np.ndarray, colours: dict[str, str]) -> None:
    """Draws the veins with their diameters, thick ones first."""
    for name in sorted(colours, key=lambda name: -max(wing.veins[name][1])):
        nodes, diameters = wing.veins[name]
        axes.add_collection(PolyCollection(vein_polygons(xy, nodes, 1e3 * np.asarray(diameters)), facecolors=colours[name],
                                           edgecolors=colours[name], linewidths=0.3, snap=False, zorder=4))
        for node, diameter in zip(nodes, diameters):
            axes.add_patch(Circle(xy[node], 5e2 * diameter, fc=colours[name], lw=0, snap=False, zorder=4))


def _draw_joints(axes: Axes, wing: Wing, xy: np.ndarray, span: float) -> list[np.ndarray]:
    """Draws the numbered joints, and returns the points that each of them covers."""
    taken = []
    for k, name in enumerate(sorted(wing.joints), 1):
        before, middle, last = wing.joint_nodes(name)
        place = xy[middle]
        if len(wing.joints[name]) == 3:              # away from the place where veins meet
            along = xy[last] - xy[middle]
            place = place + along / np.linalg.norm(along) * 0.02 * span
        axes.plot(*place, "o", ms=10, mfc="white", mec=INK, mew=1.1, zorder=10)
        axes.text(*place, str(k), ha="center", va="center_baseline", fontsize=7, color=INK, weight="bold", zorder=11)
        taken.append(place + 0.012 * span * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]]))
    return taken


def _draw_legend(axes: Axes, quality: Quality, has_veins: bool, span: float, left: float, top: float) -> None:
    """Draws the scale, and what the marks mean, below `top`."""
    step = _round_length(span / 5)
    x, y = left, top - 0.015 * span
    axes.plot([x, x + step], [y, y], color=INK, lw=2.2, solid_capstyle="butt")
    axes.text(x + step / 2, y - 0.006 * span, f"{step:g} mm", ha="center", va="top", fontsize=8.5, color=INK)
    x += step + 0.04 * span
    _mark_centre(axes, np.array([x, y]), 0.009 * span)
    centre = "centre of mass" if quality.membrane_mass else "centre of mass of the veins" if has_veins else "centre of area"
    axes.text(x + 0.016 * span, y, centre, ha="left", va="center", fontsize=8.5, color=INK)
    axes.plot([x], [y - 0.026 * span], "s", ms=5, mfc=ROOT, mec="white", mew=0.5)
    axes.text(x + 0.016 * span, y - 0.026 * span, "root", ha="left", va="center", fontsize=8.5, color=INK)


def _facts(wing: Wing, quality: Quality) -> str:
    """Returns size, mesh and masses of the wing in one line."""
    facts = f"{len(wing.points)} points · {len(wing.triangles)} triangles · {1e6 * quality.area:.2f} mm² · smallest angle " \
            f"{quality.angles.min():.0f}°"
    if wing.veins:
        d = np.concatenate([np.asarray(d) for _, d in wing.veins.values()])
        facts += f" · veins {1e6 * d.min():.0f} to {1e6 * d.max():.0f} µm, {_mass(quality.vein_mass)}"
    if quality.membrane_mass:
        facts += f" · membrane {_mass(quality.membrane_mass)}"
    return facts


def draw_wing(wing: Wing, quality: Quality, title: str = "") -> Figure:
    """Draws the figure; lengths in mm."""
    xy = 1e3 * wing.points[:, :2]
    low, high = xy.min(0), xy.max(0)
    span = max(high - low)
    lines = [f"{k:2d}  {name}" for k, name in enumerate(sorted(wing.joints), 1)]
    columns = 1 + (len(lines) - 1) // 6 if lines else 0
    rows = -(-len(lines) // columns) if columns else 0
    margin = np.array([0.04, 0.04]) * span
    band = max(0.06, ROW * rows + 0.01) * span       # below the wing, for scale and keys
    bottom = low[1] - margin[1] - band
    top = high[1] + margin[1]
    size = (WIDTH, WIDTH * (top - bottom) / (high[0] - low[0] + 2 * margin[0]) + 0.5)
    figure = plt.figure(figsize=size)
    axes = figure.add_axes([0, 0, 1, 1 - 0.5 / size[1]])
    axes.set_xlim(low[0] - margin[0], high[0] + margin[0])
    axes.set_ylim(bottom, top)
    axes.set_aspect("equal")
    axes.axis("off")
    edges, count = wing.edges()
    names = sorted(wing.veins)
    colours = {name: COLOURS[k % len(COLOURS)] for k, name in enumerate(names)}
    _draw_surface(axes, wing, xy, edges, count)
    _draw_veins(axes, wing, xy, colours)
    axes.plot(*xy[wing.root].T, "s", ms=5, mfc=ROOT, mec="white", mew=0.5, zorder=7)
    taken = [xy[edges[count == 1]].mean(1)]
    taken += _draw_joints(axes, wing, xy, span)
    _mark_centre(axes, 1e3 * quality.centre, 0.011 * span)
    taken.append(1e3 * quality.centre[None, :])
    _place_names(axes, wing, xy, span, colours, taken)
    _draw_legend(axes, quality, bool(wing.veins), span, low[0], bottom + band)
    for column in range(columns):
        part = lines[column * rows:(column + 1) * rows]
        axes.text(low[0] + (0.52 + 0.16 * column) * span, bottom + band, "\n".join(part), va="top",
                  fontsize=8, color=INK, family="monospace", linespacing=1.25)
    figure.text(0.03, 1 - 0.08 / size[1], title or wing.title, ha="left", va="top", fontsize=12, color=INK)
    figure.text(0.03, 1 - 0.32 / size[1], _facts(wing, quality), ha="left", va="top", fontsize=9, color="0.35")
    return figure


def _mass(kg: float) -> str:
    return f"{1e9 * kg:.3g} µg" if kg < 1e-6 else f"{1e6 * kg:.3g} mg" if kg < 1e-3 else f"{1e3 * kg:.3g} g"


def _round_length(length: float) -> float:
    """Returns 1, 2 or 5 times a power of ten, at most `length`."""
    power = 10.0**np.floor(np.log10(length))
    return float(max(step for step in (1, 2, 5) if step * power <= length) * power)
