# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws deformed wings, as `flusi --static` and `flusi --solid` save them: map of deflection, side view, sections."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from flusi_msm.results.files import InputError
from flusi_msm.style import COLOURS

INK, PALE = "#3A2A18", "0.75"
STATIONS = (0.25, 0.5, 0.75)  # of the span, where sections are cut
SMALL = 0.03                  # a deflection below this part of the span is drawn enlarged


@dataclass
class Shape:
    """A deformed wing."""
    path: Path
    title: str
    time: float              # [s], or NaN
    rest: np.ndarray         # (n, 3) [mm]
    points: np.ndarray       # (n, 3) [mm]
    triangles: np.ndarray    # (m, 3)
    veins: list              # lists of points [mm] (k, 3), deformed
    rest_veins: list         # the same at rest


def read_shape(path: str | Path) -> Shape:
    """Reads a shape file; lengths in mm."""
    try:
        with h5py.File(path, "r") as file:
            schema = file.attrs.get("schema", b"")
            schema = schema.decode() if isinstance(schema, bytes) else str(schema)
            if not schema.startswith("flusi-msm") or not {"vein_displacement", "displacement"} & set(file):
                raise InputError(f"{path}: not a deformed wing of this program")
            data = {name: np.asarray(file[name][()]) for name in file if isinstance(file[name], h5py.Dataset)}
            facts = {name: np.ravel(file.attrs[name]) for name in file.attrs}
    except OSError as error:
        raise InputError(f"{path}: {error}") from None
    time = float(facts["time"][0]) if "time" in facts else np.nan
    veins, rest_veins = [], []
    cells, at = data.get("vein_cells", np.array([], int)), 0
    while at < len(cells):
        nodes = cells[at + 2:at + 2 + cells[at + 1]]
        veins.append(1e3 * data["vein_points"][nodes])
        rest_veins.append(veins[-1] - 1e3 * data["vein_displacement"][nodes])
        at += 2 + cells[at + 1]
    triangles = data.get("triangles", np.zeros((0, 3), int))
    points = 1e3 * data["points"] if len(triangles) else np.concatenate(veins)
    rest = points - 1e3 * data["displacement"] if len(triangles) else np.concatenate(rest_veins)
    if "load" in facts:
        title = f"load {int(facts['load'][0])}"
    elif "frequency" in facts:
        title = f"mode at {facts['frequency'][0]:.1f} Hz"
    else:
        title = f"t = {1e3 * time:.3g} ms"
    return Shape(Path(path), title, time, rest, points, triangles, veins, rest_veins)


def outline(triangles: np.ndarray) -> np.ndarray:
    """Returns the edges that belong to one triangle."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    return edges[count == 1]


def section(shape: Shape, x: float) -> np.ndarray:
    """Returns points of the deformed membrane that are at `x` at rest, from the trailing to the leading edge."""
    edges = np.unique(np.sort(np.concatenate([shape.triangles[:, [0, 1]], shape.triangles[:, [1, 2]],
                                              shape.triangles[:, [2, 0]]]), axis=1), axis=0)
    a, b = shape.rest[edges[:, 0], 0], shape.rest[edges[:, 1], 0]
    cut = (a - x) * (b - x) < 0
    t = ((x - a[cut]) / (b[cut] - a[cut]))[:, None]
    ends = edges[cut]
    places = [(1 - t) * p[ends[:, 0]] + t * p[ends[:, 1]] for p in (shape.rest, shape.points)]
    return places[1][np.argsort(places[0][:, 1])]


class Sheet:
    """A figure on which a millimetre of the wing has the same length in every panel: the map at the top, the side view below it,
    and the sections next to the side view."""

    WIDTH, LEFT, GAP, BOTTOM, TITLE = 7.0, 0.7, 0.75, 0.55, 0.35  # inches

    def __init__(self, shapes: Sequence[Shape]) -> None:
        places = [p for s in shapes for p in (s.rest, s.points)]
        low, high = np.min([p.min(0) for p in places], axis=0), np.max([p.max(0) for p in places], axis=0)
        room = 0.02 * (high - low)[0]
        self.low, self.high = low - room, high + room
        self.scale = self.WIDTH / (self.high - self.low)[0]  # inches per mm
        self.true_z = (high - low)[2] > SMALL * (high - low)[0]
        if not self.true_z:
            extra = 0.08 * (high - low)[2] or 1e-6
            self.low[2], self.high[2] = low[2] - extra, high[2] + extra
        self.chord = (self.high - self.low)[1] * self.scale
        self.height = max(1.0, (self.high - self.low)[2] * self.scale) if self.true_z else 1.8
        if self.true_z:  # a low panel is filled up to its height
            missing = self.height / self.scale - (self.high - self.low)[2]
            self.low[2] -= missing / 2
            self.high[2] += missing / 2
        has_map = len(shapes[-1].triangles) > 0
        size = (self.LEFT + self.WIDTH + (self.GAP + self.chord if has_map else 0) + 0.2,
                self.BOTTOM + self.height + self.TITLE + (self.BOTTOM + self.chord + self.TITLE if has_map else 0))
        self.figure = plt.figure(figsize=size)
        self.side = self.panel(self.LEFT, self.BOTTOM, self.WIDTH, self.height)
        self.map: Axes | None = None          # nothing of these without triangles
        self.sections: Axes | None = None
        self.bar: Axes | None = None
        if has_map:
            right, top = self.LEFT + self.WIDTH + self.GAP, self.BOTTOM + self.height + self.TITLE + self.BOTTOM
            self.sections = self.panel(right, self.BOTTOM, self.chord, self.height)
            self.map = self.panel(self.LEFT, top, self.WIDTH, self.chord)
            self.bar = self.panel(self.LEFT + self.WIDTH + 0.2, top, 0.15, self.chord)

    def panel(self, x: float, y: float, width: float, height: float) -> Axes:
        """Returns a panel at a place [inches]."""
        all_x, all_y = self.figure.get_size_inches()
        return self.figure.add_axes([x / all_x, y / all_y, width / all_x, height / all_y])

    def frame(self, axes: Axes, across: int, up: int, label: bool) -> None:
        """Sets limits, zero line and labels of a panel that shows coordinates number `across` and `up`."""
        axes.set_xlim(self.low[across], self.high[across])
        axes.set_ylim(self.low[up], self.high[up])
        axes.set_xlabel(f"{'xyz'[across]} [mm]")
        if label:
            axes.set_ylabel(f"{'xyz'[up]} [mm]")
        if up == 2:
            axes.axhline(0, color=PALE, lw=0.8, zorder=0)
            if not self.true_z and label:
                axes.text(0.01, 0.97, "z not to scale", transform=axes.transAxes, va="top", color="0.4",
                          fontsize="small")


def draw_map(sheet: Sheet, shape: Shape) -> None:
    """Draws where the unloaded wing moves, and how far along its normal."""
    axes = sheet.map
    assert axes is not None
    z = (shape.points - shape.rest)[:, 2]
    largest = np.abs(z).max() or 1.0
    signed = z.min() < -0.05 * largest and z.max() > 0.05 * largest
    limits = (-largest, largest) if signed else (min(0, z.min()), max(0, z.max()) or (1.0 if not z.any() else 0))
    colours = "RdBu_r" if signed else "viridis" if z.max() >= -z.min() else "viridis_r"
    drawn = axes.tripcolor(shape.rest[:, 0], shape.rest[:, 1], shape.triangles, z, shading="gouraud", cmap=colours,
                           vmin=limits[0], vmax=limits[1], rasterized=True)
    if np.ptp(z) > 0:
        axes.tricontour(shape.rest[:, 0], shape.rest[:, 1], shape.triangles, z, levels=9, colors="white",
                        linewidths=0.6, alpha=0.8, linestyles="solid")
    axes.add_collection(LineCollection([v[:, :2] for v in shape.rest_veins], colors=INK, linewidths=0.9))
    axes.add_collection(LineCollection(shape.rest[outline(shape.triangles)][:, :, :2], colors=INK, linewidths=0.6))
    bar = sheet.figure.colorbar(drawn, cax=sheet.bar)
    bar.set_label("deflection $u_z$ [mm]")
    bar.outline.set_linewidth(0.5)
    sheet.frame(axes, 0, 1, True)
    axes.set_title(f"deflection, {shape.title}", loc="left")


def draw_side(axes: Axes, shape: Shape, colour: str, is_only: bool) -> None:
    """Draws the wing seen along its chord: its edges, and its veins if they do not hide others."""
    if is_only and len(shape.triangles):
        axes.add_collection(PolyCollection(shape.points[shape.triangles][:, :, [0, 2]], facecolors="#F1E8D2",
                                           edgecolors="#F1E8D2", linewidths=0.3, zorder=1))
    if len(shape.triangles):
        edges = shape.points[outline(shape.triangles)][:, :, [0, 2]]
        axes.add_collection(LineCollection(edges, colors=[colour], linewidths=1.3, zorder=3))
    if is_only or not len(shape.triangles):
        axes.add_collection(LineCollection([v[:, [0, 2]] for v in shape.veins], linewidths=1.0, zorder=2,
                                           colors=["#A8642A" if len(shape.triangles) else colour]))


def draw_sections(sheet: Sheet, shapes: Sequence[Shape], colours: Sequence[str]) -> None:
    """Draws sections across the span, seen from the tip: three of one shape, or one of several shapes."""
    axes = sheet.sections
    assert axes is not None
    low, high = shapes[-1].rest[:, 0].min(), shapes[-1].rest[:, 0].max()
    if len(shapes) == 1:
        axes.set_title("sections across the span", loc="left")
        for station, colour in zip(STATIONS, COLOURS):
            cut = section(shapes[0], low + station * (high - low))
            axes.plot(cut[:, 1], cut[:, 2], color=colour, label=f"at {100 * station:.0f} % of the span")
    else:
        axes.set_title(f"section at {100 * STATIONS[-1]:.0f} % of the span", loc="left")
        for shape, colour in zip(shapes, colours):
            cut = section(shape, low + STATIONS[-1] * (high - low))
            axes.plot(cut[:, 1], cut[:, 2], color=colour)
    sheet.frame(axes, 1, 2, False)
    axes.tick_params(labelleft=False)


def draw_shapes(shapes: Sequence[Shape]) -> Figure:
    """Draws the figure: map of the last shape, side view of all, sections."""
    sheet = Sheet(shapes)
    is_only = len(shapes) == 1
    colours = [COLOURS[0]] if is_only else [plt.cm.plasma(0.88 * i / (len(shapes) - 1)) for i in range(len(shapes))]
    for shape, colour in zip(shapes, colours):
        draw_side(sheet.side, shape, colour, is_only)
    sheet.frame(sheet.side, 0, 2, True)
    parts = "veins" if not sheet.map else "edges and veins" if is_only else "edges"
    sheet.side.set_title(f"side view: {parts}", loc="left")
    if sheet.map:
        draw_map(sheet, shapes[-1])
        draw_sections(sheet, shapes, colours)
    add_key(sheet, shapes, colours)
    return sheet.figure


def add_key(sheet: Sheet, shapes: Sequence[Shape], colours: Sequence[str]) -> None:
    """Adds a key to sections or shapes; of many shapes it has the first, the last and some between."""
    if len(shapes) > 1:
        step = -(-len(shapes) // 8)
        shown = sorted({*range(0, len(shapes), step), len(shapes) - 1})
        handles = [plt.Line2D([], [], color=colours[i]) for i in shown]
        labels = [shapes[i].title for i in shown]
    elif sheet.sections:
        handles, labels = sheet.sections.get_legend_handles_labels()
    else:
        return
    if sheet.bar:
        sheet.bar.legend(handles, labels, loc="center left", bbox_to_anchor=(6.5, 0.5), borderaxespad=0)
    else:
        sheet.side.legend(handles, labels, loc="center left", bbox_to_anchor=(1.0, 0.5))
