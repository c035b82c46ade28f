# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the spanwise vorticity around sections of a wing, on planes normal to its span."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.image import AxesImage

from flusi_msm.render.wing_surface import SIDES, UPPER_SIDE, WingSurface, load_surface
from flusi_msm.results.files import InputError, Snapshot, has_field, has_rings, load_field
from flusi_msm.results.flow import at_points, vorticity_at
from flusi_msm.style import SMOOTHED, name_of, save, use_style

DEFAULT_FRACTIONS = (0.25, 0.5, 0.75)
MOST_POINTS = 400  # along the chord
TWIN = "#0072B2"   # the rigid wing


def parse_section(words: Sequence[str]) -> tuple[str, tuple[float, ...]]:
    """Returns ('left', (0.25, 0.5)) for ['left', '0.25', '0.5']."""
    try:
        side, fractions = words[0], tuple(float(word) for word in words[1:])
    except ValueError:
        side, fractions = words[0], (np.nan,)
    if side not in SIDES or not all(0 < fraction < 1 for fraction in fractions):
        raise InputError(f"--section takes left or right and fractions of the span between 0 and 1, not "
                         f"'{' '.join(words)}'; put the folder before it")
    return side, fractions or DEFAULT_FRACTIONS


class Section:
    """The plane at a fraction of the span: y, z of its points in the wing frame, the vorticity along the span (z, y), the mask
    if there is one, and the cuts through the wing and through its rigid twin (or None). With `smooth` the vorticity is that of means
    over three grid points."""

    def __init__(self, snapshot: Snapshot, wing: WingSurface, fraction: float, cut: np.ndarray,
                 twin: np.ndarray | None, y: np.ndarray, z: np.ndarray, smooth: bool = False) -> None:
        self.fraction, self.cut, self.twin, self.y, self.z = fraction, cut, twin, y, z
        z, y = np.meshgrid(z, y, indexing="ij")
        x = np.full(y.size, fraction * wing.length())
        points = wing.in_space(np.column_stack([x, y.ravel(), z.ravel()]))
        self.vorticity = vorticity_at(snapshot, points, wing.matrix[0], smooth).reshape(y.shape)
        self.mask = at_points(snapshot, "mask", points).reshape(y.shape) if has_field(snapshot, "mask") else None

    def outside(self) -> np.ndarray:
        """Returns the vorticity in the fluid."""
        return self.vorticity if self.mask is None else self.vorticity[self.mask < 0.5]


def sections_of(snapshot: Snapshot, wing: WingSurface, fractions: Sequence[float], spacing: float, smooth: bool = False) \
        -> list[Section]:
    """Returns sections in one window, which is wider than all cuts by more than half a chord."""
    cuts = [wing.cut(fraction * wing.length()) for fraction in fractions]
    for fraction, cut in zip(fractions, cuts):
        if len(cut) == 0:
            raise InputError(f"{wing.path}: no part of the wing at {fraction:g} of the span")
    twins = [None if wing.rigid_points is None else wing.cut(fraction * wing.length(), wing.rigid_points)
             for fraction in fractions]
    ends = np.concatenate(cuts + [twin for twin in twins if twin is not None]).reshape(-1, 2)
    chord = max(float(np.linalg.norm(np.ptp(cut.reshape(-1, 2), axis=0))) for cut in cuts)
    low, high = ends.min(axis=0) - (0.6 * chord, 0.9 * chord), ends.max(axis=0) + (0.6 * chord, 0.9 * chord)
    step = max(spacing / 2, (high[0] - low[0]) / MOST_POINTS)
    y, z = (low[i] + step * np.arange(int((high[i] - low[i]) / step) + 2) for i in (0, 1))
    return [Section(snapshot, wing, fraction, cut, twin, y, z, smooth)
            for fraction, cut, twin in zip(fractions, cuts, twins)]


def draw_sections(snapshot: Snapshot, side: str, fractions: Sequence[float], limit: float | None, out: str | Path | None,
                  stored: bool = False) -> None:
    """Draws sections of a wing next to each other, and prints their range; without the rings about wings without thickness unless
    the vorticity is to be drawn as it is stored."""
    smooth = has_rings(snapshot) and not stored
    wing = load_surface(snapshot, side)
    name = "mask" if has_field(snapshot, "mask") else "vorx" if has_field(snapshot, "vorx") else "ux"
    sections = sections_of(snapshot, wing, fractions, load_field(snapshot, name).spacing.min(), smooth)
    sample = np.concatenate([s.outside().ravel() for s in sections])
    limit = limit or np.percentile(np.abs(sample), 99.5) or 1.0

    use_style()
    first = sections[0]
    ratio = np.ptp(first.z) / np.ptp(first.y)
    figure, axes = plt.subplots(1, len(sections), sharey=True, squeeze=False, layout="constrained",
                                figsize=(1.4 + 2.9 * len(sections), 1.1 + 2.8 * ratio))
    for ax, section in zip(axes[0], sections):
        image = draw_section(ax, section, limit)
        ax.set_xlabel("$y$")
    # The leading edge is on the left, the upper side of the wing is up.
    if UPPER_SIDE[side] < 0:
        axes[0, 0].invert_yaxis()
    axes[0, 0].set_ylabel("$z$")
    note = ("" if wing.rigid_points is None else "; blue: the rigid wing") + (f"; {SMOOTHED}" if smooth else "")
    figure.suptitle(f"{side} wing, $t = {wing.time:.4g}$; leading edge left, upper side up{note}", x=0.01, ha="left",
                    fontsize="medium")
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    bar = figure.colorbar(image, ax=axes[0, -1], pad=0.03, aspect=30,
                          extend=extend[bool(sample.min() < -limit), bool(sample.max() > limit)])
    bar.set_label(r"$\omega \cdot e_\mathrm{span}$ [1/T]")
    bar.outline.set_linewidth(0.6)
    places = "" if tuple(fractions) == DEFAULT_FRACTIONS else ",".join(f"{fraction:g}" for fraction in fractions)
    save(figure, out or snapshot.folder / f"{name_of('section', side, snapshot.label, places)}.png")
    for section in sections:
        values = section.outside()
        print(f"span {section.fraction:g}: spanwise vorticity {values.min():.4g} to {values.max():.4g}, "
              f"mean {values.mean():.4g}")


def draw_section(ax: Axes, section: Section, limit: float) -> AxesImage:
    """Draws one section."""
    y, z = section.y, section.z
    half = (y[1] - y[0]) / 2
    image = ax.imshow(section.vorticity, origin="lower", cmap="RdBu_r", vmin=-limit, vmax=limit, aspect="equal",
                      extent=(y[0] - half, y[-1] + half, z[0] - half, z[-1] + half), interpolation="bilinear")
    if section.mask is not None and section.mask.max() > 0.5:
        ax.contourf(y, z, section.mask, levels=[0.5, np.inf], colors=["0.85"])
        ax.contour(y, z, section.mask, levels=[0.5], colors=["0.15"], linewidths=0.7)
    if section.twin is not None:
        ax.add_collection(LineCollection(section.twin, colors=TWIN, linewidths=1.2, capstyle="round"))
    ax.add_collection(LineCollection(section.cut, colors="black", linewidths=1.6, capstyle="round"))
    ax.set_xlim(y[-1] + half, y[0] - half)
    for spine in ax.spines.values():
        spine.set_visible(True)
    ax.set_title(f"{section.fraction:g} of the span", loc="left")
    return image
