# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws imported height maps: known and missing heights, outliers, and the fit of the scan to the wing."""
from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.importers.registration import Registration
from flusi_msm.style import save, use_style

MISSING, OUTSIDE, OUTLINE = "#D9D9D9", "#A6A6A6", "#B2182B"
MOST = 24  # panels
ARROWS = 20.0  # residuals are drawn so many times as long


def draw_preview(path: Path, x: np.ndarray, y: np.ndarray, heights: dict[str, np.ndarray], points: dict[str, np.ndarray],
                 outliers: dict[str, np.ndarray], outline: np.ndarray | None, registration: Registration) -> None:
    """Draws one panel for every map: heights of `reference` and changes from it (ny, nx) [m] in mm and um, its outliers (n, 2)
    [m], and the place where the force acts."""
    use_style()
    names = sorted(heights, key=lambda name: (name != "reference", name))[:MOST]
    columns = min(3, len(names))
    rows = -(-len(names) // columns)
    aspect = (np.ptp(y) / np.ptp(x)) or 1
    figure, axes = plt.subplots(rows, columns, figsize=(4.2 * columns, rows * (4.0 * aspect + 1.0) + 0.6), squeeze=False,
                                constrained_layout=True)
    rest = heights["reference"]
    for axis in axes.ravel()[len(names):]:
        axis.axis("off")
    for axis, name in zip(axes.ravel(), names):
        shown = 1e6 * (rest if name == "reference" else heights[name] - rest)
        known = np.isfinite(shown)
        largest = np.percentile(np.abs(shown[known] - (np.median(shown[known]) if name == "reference" else 0)), 99) if known.any() else 1
        middle = np.median(shown[known]) if name == "reference" and known.any() else 0
        axis.set_facecolor(MISSING)
        mesh = axis.pcolormesh(1e3 * x, 1e3 * y, np.ma.masked_invalid(shown), cmap="RdBu_r", vmin=middle - largest,
                               vmax=middle + (largest or 1), shading="nearest", rasterized=True)
        figure.colorbar(mesh, ax=axis, label="height, um" if name == "reference" else "change, um", shrink=0.8)
        if outline is not None:
            axis.plot(*(1e3 * outline.T), color=OUTLINE, lw=0.9)
        far = outliers.get(name, np.zeros((0, 2)))
        if len(far):
            axis.scatter(*(1e3 * far.T), s=22, facecolors="none", edgecolors="black", linewidths=0.8)
        if name in points:
            axis.plot(*(1e3 * points[name]), marker="+", ms=10, mew=1.6, color="black")
        if name == "reference" and registration.names and registration.places is not None and registration.residuals is not None:
            places, gaps = 1e3 * registration.places, 1e3 * registration.residuals
            axis.scatter(*places.T, s=18, color=OUTLINE, zorder=4)
            axis.quiver(*places.T, *(ARROWS * gaps.T), angles="xy", scale_units="xy", scale=1, color=OUTLINE, width=0.006, zorder=5)
            for place, label in zip(places, registration.names):
                axis.annotate(label, place, xytext=(3, 3), textcoords="offset points", fontsize=7)
        title = f"{name}: {known.mean():.0%} known"
        axis.set_title(title + (f", {len(far)} outliers (circles)" if len(far) else ""))
        axis.set_aspect("equal")
        axis.set_xlabel("x, mm (toward the tip)")
        axis.set_ylabel("y, mm (leading edge)")
    head = registration.report()[0]
    if registration.names:
        head += f"\narrows: residuals of the landmarks, {ARROWS:.0f} times as long"
    figure.suptitle(head + "\ngrey: no height; +: where the force acts", fontsize=9)
    save(figure, path)
