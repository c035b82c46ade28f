# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a wing file: veins to scale and coloured by diameter, mesh, joints with their numbers, root; or deformed
wings: map of the deflection, side view, sections; or pressure and viscous traction on both sides of a wing in a flow.

usage: plot_wing WING [-o PNG] [--no-mesh] [--no-names] [--field FILE --dataset NAME [--label TEXT]]
       plot_wing --shape FILE [FILE ...] [-o PNG]
       plot_wing --sides FILE [FILE ...] [-o PNG]

The FILEs of --shape are those that `flusi --static` (static_01.h5) and `flusi --solid` (solid_00012.h5) save. If there are
several the map shows the last one, and the side view shows all. The FILEs of --sides are surfaces of one wing (wing_left_000250.h5)
that a run with iSaveWingSides saves; each has a column of its own. With --field the membrane is coloured by a dataset of an HDF5
file with one value per point (or three, of which the last one, the deflection normal to the wing, is taken).
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flusi_msm.wing.file import Wing

matplotlib.use("Agg")
import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize

from flusi_msm.errors import InputError, run_command
from flusi_msm.results.wing_sides import draw_sides, open_sides
from flusi_msm.style import save, use_style
from flusi_msm.wing.bent_shape import draw_shapes, read_shape
from flusi_msm.wing.file import read_wing

MEMBRANE, MESH, INK, JOINT, ROOT = "#F6F1E4", "#CFC4AC", "#3A2A18", "#0072B2", "#B2182B"
CUTICLE = LinearSegmentedColormap.from_list("cuticle", ["#D9A441", "#A8642A", "#6B3A1E", "#2B1810"])


def outline_edges(wing: Wing) -> np.ndarray:
    """Returns the edges (k, 2) that belong to one triangle."""
    edges, count = wing.edges()
    return edges[count == 1]


def vein_polygons(xy: np.ndarray, nodes: Sequence[int], diameters: Sequence[float] | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns one quadrilateral per segment, as wide as the vein at both ends; and the mean diameters."""
    p, d = xy[nodes], np.asarray(diameters)
    along = np.diff(p, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    normal, r = np.stack([-along[:, 1], along[:, 0]], axis=1), d[:, None] / 2
    quads = np.stack([p[:-1] + normal * r[:-1], p[1:] + normal * r[1:], p[1:] - normal * r[1:], p[:-1] - normal * r[:-1]], axis=1)
    return quads, (d[:-1] + d[1:]) / 2


def draw_veins(axes: Axes, wing: Wing, xy: np.ndarray, norm: Normalize) -> None:
    """Draws thick veins over thin ones; round points where they meet."""
    for nodes, diameters in sorted(wing.veins.values(), key=lambda vein: max(vein[1])):
        quads, means = vein_polygons(xy, nodes, 1e3 * np.asarray(diameters))
        colours = CUTICLE(norm(1e3 * means))
        axes.add_collection(PolyCollection(quads, facecolors=colours, edgecolors=colours, linewidths=0.4, snap=False, zorder=3))
        for node, diameter in zip(nodes, diameters):
            axes.add_patch(plt.Circle(xy[node], 5e2 * diameter, facecolor=CUTICLE(norm(1e6 * diameter)), lw=0,
                                      snap=False, zorder=3))


def name_veins(axes: Axes, wing: Wing, xy: np.ndarray, span: float) -> None:
    """Writes names at the longest stretch of each vein, on the side with more room."""
    for name, (nodes, _) in wing.veins.items():
        p = xy[nodes]
        length = np.linalg.norm(np.diff(p, axis=0), axis=1)
        at = np.concatenate([[0], np.cumsum(length)])
        k = min(len(p) - 2, int(np.searchsorted(at, 0.62 * at[-1])))
        direction = p[k + 1] - p[k]
        angle = np.degrees(np.arctan2(direction[1], direction[0]))
        angle = (angle + 90) % 180 - 90
        is_short = at[-1] < 0.12 * span
        normal = np.array([-np.sin(np.radians(angle)), np.cos(np.radians(angle))])
        place = (p[k] + p[k + 1]) / 2 + normal * 0.013 * span
        if is_short:
            place, angle = p.mean(0) + np.array([0.006 * span, 0]), 0
        is_front = place[1] > xy[:, 1].max() - 0.03 * span
        axes.text(*place, name, rotation=angle, rotation_mode="anchor", ha="left" if is_short else "center",
                  va="center", fontsize=8, color=INK, zorder=6, style="italic",
                  bbox=None if is_front else {"boxstyle": "round,pad=0.12", "fc": MEMBRANE, "ec": "none", "alpha": 0.75})


def draw_joints(axes: Axes, wing: Wing, xy: np.ndarray) -> list[str]:
    """Draws numbered joints; a joint into another vein is marked on that vein, at some distance from the place where it begins.
    """
    lines = []
    for k, name in enumerate(sorted(wing.joints), 1):
        _, middle, last = wing.joint_nodes(name)
        place = xy[middle]
        if len(wing.joints[name]) == 3:
            along = xy[last] - xy[middle]
            place = place + along / np.linalg.norm(along) * 0.018 * np.ptp(xy, axis=0).max()
        axes.plot(*place, "o", ms=10.5, mfc="white", mec=JOINT, mew=1.3, zorder=7)
        axes.text(*place, str(k), ha="center", va="center_baseline", fontsize=7, color=JOINT, weight="bold", zorder=8)
        lines.append(f"{k:2d}  {name}")
    return lines


def field_of(path: str | Path, dataset: str, n: int) -> np.ndarray:
    """Returns the values of a dataset at the points of the wing."""
    try:
        with h5py.File(path, "r") as file:
            values = np.asarray(file[dataset][:], float)
    except (OSError, KeyError) as error:
        raise InputError(f"{path}: no readable dataset '{dataset}': {error}") from None
    if values.shape == (n, 3):
        values = values[:, 2]
    if values.shape != (n,):
        raise InputError(f"{path}: '{dataset}' has shape {values.shape}, the wing has {n} points")
    return values


def draw_membrane(axes: Axes, wing: Wing, xy: np.ndarray, values: np.ndarray | None, label: str) -> None:
    """Draws the membrane in one colour, or coloured by values at the points."""
    if not len(wing.triangles):
        return
    if values is None:
        axes.add_collection(PolyCollection(xy[wing.triangles], facecolors=MEMBRANE, edgecolors=MEMBRANE,
                                           linewidths=0.5, zorder=0))
        return
    largest = np.abs(values).max() or 1.0
    signed = values.min() < -0.05 * largest and values.max() > 0.05 * largest
    limits = (-largest, largest) if signed else (min(0, values.min()), max(0, values.max()))
    drawn = axes.tripcolor(xy[:, 0], xy[:, 1], wing.triangles, values, shading="gouraud", zorder=0,
                           cmap="RdBu_r" if signed else "viridis", vmin=limits[0], vmax=limits[1])
    bar = axes.figure.colorbar(drawn, ax=axes, fraction=0.02, pad=0.01, shrink=0.7)
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)


def draw(wing: Wing, mesh: bool = True, names: bool = True, values: np.ndarray | None = None, label: str = "") -> Figure:
    """Draws the figure; lengths in mm."""
    xy = 1e3 * wing.points[:, :2]
    low, high = xy.min(0), xy.max(0)
    span = max(high - low)
    figure, axes = plt.subplots(figsize=(12, 1.6 + 12 * min(1.0, max(0.25, (high - low)[1] / span))))
    draw_membrane(axes, wing, xy, values, label)
    if len(wing.triangles):
        if mesh:
            axes.add_collection(LineCollection(xy[wing.edges()[0]], colors=MESH, linewidths=0.45, zorder=1,
                                               alpha=1.0 if values is None else 0.35))
        axes.add_collection(LineCollection(xy[outline_edges(wing)], colors=INK, linewidths=0.8, zorder=2))
    if wing.veins:
        every = 1e6 * np.concatenate([d for _, d in wing.veins.values()])
        norm = Normalize(every.min(), max(every.max(), 1.001 * every.min()))
        draw_veins(axes, wing, xy, norm)
        scale = plt.cm.ScalarMappable(norm=norm, cmap=CUTICLE)
        inset = axes.inset_axes([0.03, 0.09, 0.2, 0.022])
        bar = figure.colorbar(scale, cax=inset, orientation="horizontal")
        bar.set_label("vein diameter [µm]", fontsize=8, labelpad=2)
        bar.ax.tick_params(labelsize=8, length=2)
        bar.outline.set_linewidth(0.4)
        if names:
            name_veins(axes, wing, xy, span)
    axes.plot(*xy[wing.root].T, "s", ms=5.5, mfc=ROOT, mec="white", mew=0.6, zorder=7)
    lines = draw_joints(axes, wing, xy)
    if lines:
        half = max(5, (len(lines) + 1) // 2)
        for column, part in enumerate((lines[:half], lines[half:])):
            axes.text(0.74 + 0.14 * column, 0.015, "\n".join(part), transform=axes.transAxes, fontsize=7.5,
                      color=JOINT, va="bottom", family="monospace", linespacing=1.35)
    step = 10.0**np.floor(np.log10(span / 4))
    x, y = low[0] + 0.30 * span, low[1] - 0.035 * span
    axes.plot([x, x + step], [y, y], color=INK, lw=2, solid_capstyle="butt")
    axes.text(x + step / 2, y - 0.008 * span, f"{step:g} mm", ha="center", va="top", fontsize=8, color=INK)
    facts = f"{len(wing.points)} points · {len(wing.triangles)} triangles · {len(wing.veins)} veins"
    if len(wing.triangles):
        facts += f" · {wing.areas().sum() * 1e6:.2f} mm² · smallest angle {wing.smallest_angle():.1f}°"
    axes.set_title(f"{wing.title}\n", loc="left", fontsize=12, color=INK, pad=2)
    axes.text(0, 1.0, facts, transform=axes.transAxes, fontsize=9, color="0.35", va="bottom")
    axes.set_xlim(low[0] - 0.03 * span, high[0] + 0.03 * span)
    axes.set_ylim(low[1] - 0.075 * span, high[1] + 0.035 * span)
    axes.set_aspect("equal")
    axes.axis("off")
    return figure


def beside(path: str | Path, kind: str) -> Path:
    """Returns where the picture of a file is written; NAME.png is that of tools/make_wing."""
    return Path(path).with_name(f"{Path(path).stem}_{kind}.png")


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wing", metavar="WING", nargs="?", help="wing file")
    parser.add_argument("-o", "--output", metavar="PNG", help="picture to write (default: beside the last file, "
                        "NAME_mesh.png, with --shape NAME_shape.png, with --sides NAME_sides.png)")
    parser.add_argument("--shape", nargs="+", metavar="FILE", help="deformed wings of flusi --static or --solid")
    parser.add_argument("--sides", nargs="+", metavar="FILE", help="surfaces of a wing with pressure and traction")
    parser.add_argument("--no-mesh", action="store_true", help="leave out the edges of the mesh")
    parser.add_argument("--no-names", action="store_true", help="leave out the names of the veins")
    parser.add_argument("--field", metavar="FILE", help="HDF5 file with a value for every point")
    parser.add_argument("--dataset", default="displacement", metavar="NAME", help="in FILE (default: displacement)")
    parser.add_argument("--label", default="deflection [m]", metavar="TEXT", help="of the colours")
    options = parser.parse_args()
    use_style()
    if sum(map(bool, (options.wing, options.shape, options.sides))) != 1:
        parser.error("give a wing file, or --shape with deformed wings, or --sides with surfaces of a wing")
    if options.shape:
        save(draw_shapes([read_shape(path) for path in options.shape]),
             options.output or beside(options.shape[-1], "shape"))
        return
    if options.sides:
        save(draw_sides(open_sides(options.sides)), options.output or beside(options.sides[-1], "sides"))
        return
    wing = read_wing(options.wing)
    wing.title = wing.title or Path(options.wing).stem
    values = field_of(options.field, options.dataset, len(wing.points)) if options.field else None
    save(draw(wing, not options.no_mesh, not options.no_names, values, options.label),
         options.output or beside(options.wing, "mesh"))


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_wing", main)
