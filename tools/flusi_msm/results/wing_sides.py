# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and draws the pressure and the viscous traction on the dorsal and on the ventral side of a wing. A run with iSaveWingSides = 1
writes both to the files of its wings."""
from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from flusi_msm.render.wing_surface import SIDES, WingSurface
from flusi_msm.results.files import InputError
from flusi_msm.style import use_style

BOTH = ("dorsal", "ventral")
ARROWS = 14       # along the span
SHARE = 98        # % of the triangles whose values are within the colours
PRESSURE_COLOURS, TRACTION_COLOURS = "RdBu_r", "YlOrBr"


def open_sides(paths: Sequence[str | Path]) -> list[WingSides]:
    """Opens the files that have pressure and traction; a run writes none at its start. Raises an InputError if no file has them."""
    found = [path for path in paths if not lacking(path)]
    for path in [path for path in paths if path not in found] if found else []:
        print(f"{path}: left out, it has no pressure and traction", file=sys.stderr)
    return [WingSides(path) for path in found or paths]


def lacking(path: str | Path) -> list[str]:
    """Returns the names of the data that the file of a surface lacks, [] for what is no such file."""
    import h5py
    try:
        with h5py.File(path, "r") as file:
            return [f"{what}_{side}" for what in ("pressure", "traction") for side in BOTH if f"{what}_{side}" not in file]
    except OSError:
        return []


class WingSides:
    """`wing` with `pressure` {side: (m)} of its m triangles and `traction` {side: (m, 3)}, along x, y and z of the wing frame, both
    in rho L^2/T^2, at the `distance` L from the wing."""

    def __init__(self, path: str | Path) -> None:
        import h5py
        path = Path(path)
        name = next((side for side in SIDES if path.name.startswith(f"wing_{side}_")), SIDES[0])
        self.wing = WingSurface(path, name)
        if names := lacking(path):
            raise InputError(f"{path}: no {', '.join(names)}; a run with [Saving] iSaveWingSides = 1 writes them after its start")
        with h5py.File(path, "r") as file:
            self.pressure = {side: file[f"pressure_{side}"][...].astype(float) for side in BOTH}
            self.traction = {side: file[f"traction_{side}"][...].astype(float) @ self.wing.matrix.T for side in BOTH}
            self.distance = float(np.ravel(file.attrs.get("side_distance", np.nan))[0])
        count = len(self.wing.triangles)
        if any(p.shape != (count,) for p in self.pressure.values()) or any(t.shape != (count, 3) for t in self.traction.values()):
            raise InputError(f"{path}: pressure and traction must have one value for each of the {count} triangles")

    def corners(self) -> np.ndarray:
        """Returns the corners (m, 3, 2) of the triangles in the plane of the wing, where they would be if it did not bend."""
        wing = self.wing
        rest = wing.points if wing.rigid_points is None else wing.rigid_points
        return wing.in_wing_frame(rest)[wing.triangles][:, :, :2]

    def arrows(self, side: str, cell: float) -> tuple[np.ndarray, np.ndarray]:
        """Returns places (k, 2) and tractions (k, 2) in the plane of the wing: means over the triangles in squares of size `cell`,
        weighted by area."""
        corners = self.corners()
        edges = corners[:, 1:] - corners[:, :1]
        areas = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / 2
        middles = corners.mean(axis=1)
        _, square = np.unique(np.floor(middles / cell).astype(int), axis=0, return_inverse=True)
        square = np.ravel(square)
        total = np.bincount(square, areas)
        full = total > 0.3 * cell**2  # the others are slivers of squares at the edge

        def means(values: np.ndarray) -> np.ndarray:
            return np.column_stack([np.bincount(square, areas * v) for v in values.T])[full] / total[full, None]
        return means(middles), means(self.traction[side][:, :2])


def draw_sides(found: Sequence[WingSides], unit: str = r"\rho L^2/T^2") -> Figure:
    """Draws pressure and traction on both sides of a wing, one column for each time: the pressure in colour, the magnitude of the
    traction in colour with arrows along its part in the plane of the wing. The wing is drawn unbent, both sides over the same x and y
    of the wing frame, root on the left, leading edge up; `unit` is the text of the unit of both."""
    use_style()
    pressures = np.concatenate([np.abs(p) for sides in found for p in sides.pressure.values()])
    tractions = np.concatenate([np.linalg.norm(t, axis=1) for sides in found for t in sides.traction.values()])
    limits = [float(np.percentile(values, SHARE)) or 1.0 for values in (pressures, tractions)]
    size = np.ptp(np.concatenate([sides.corners().reshape(-1, 2) for sides in found]), axis=0)
    height = min(2.0, max(0.9, 2.5 * size[1] / size[0] + 0.25))
    figure, axes = plt.subplots(4, len(found), squeeze=False, figsize=(1.7 + 2.7 * len(found), 0.5 + 4 * height), sharex=True,
                                sharey=True, layout="constrained")
    for column, sides in zip(axes.T, found):
        column[0].set_title(f"$t = {sides.wing.time:.4g}$", loc="left")
        column[-1].set_xlabel("$x$")
        for row, side in enumerate(BOTH):
            pressure = paint(column[row], sides, sides.pressure[side], PRESSURE_COLOURS, (-limits[0], limits[0]))
            traction = paint(column[row + 2], sides, np.linalg.norm(sides.traction[side], axis=1), TRACTION_COLOURS, (0, limits[1]))
            cell = size[0] / ARROWS
            places, vectors = sides.arrows(side, cell)
            column[row + 2].quiver(*places.T, *vectors.T, angles="xy", scale_units="xy", scale=limits[1] / (1.3 * cell), width=0.006,
                                   headwidth=4, color="0.1", pivot="mid")
    for ax, side in zip(axes[:, 0], 2 * BOTH):
        ax.set_ylabel(side)
    for rows, image, text, extend in ((axes[:2, -1], pressure, f"pressure [${unit}$]", "both"),
                                      (axes[2:, -1], traction, f"traction [${unit}$]", "max")):
        figure.colorbar(image, ax=rows, extend=extend, aspect=18).set_label(text)
    return figure


def paint(ax: Axes, sides: WingSides, values: np.ndarray, colours: str, limits: tuple[float, float]) -> PolyCollection:
    """Draws triangles in colours."""
    corners = sides.corners()
    image = PolyCollection(corners, array=values, cmap=colours, edgecolors="face", linewidths=0.3)
    image.set_clim(*limits)
    ax.add_collection(image)
    ax.autoscale_view()
    ax.set_aspect("equal")
    return image
