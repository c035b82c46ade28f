# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws measured angles with their fit, the path of the tips, and the chords of a beat, so that the user can check signs and
sides."""
from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from flusi_msm.plots.kinematics import ANGLES, NAMES, Motion, draw_lollipops, half_strokes, left_wing
from flusi_msm.style import COLOURS, save, use_style

if TYPE_CHECKING:
    from flusi_msm.importers.kinematics import Measured

SIDE_COLOURS = {"": COLOURS[6], "left": COLOURS[0], "right": COLOURS[1]}


def draw_motions(path: Path, motions: Mapping[str, Measured], eta: float) -> None:
    """Draws all motions. `motions`: {side: (phase, angles, fits)}, the side "" for both wings."""
    use_style()
    figure = plt.figure(figsize=(9.0, 6.4), layout="constrained")
    rows = figure.add_gridspec(2, 3, height_ratios=[1.0, 1.1])
    x = np.linspace(0, 1, 401)
    for column, name in enumerate(ANGLES):
        axis = figure.add_subplot(rows[0, column])
        for side, (phase, angles, fits) in motions.items():
            axis.plot(phase, angles[name], ".", ms=3, alpha=0.5, color=SIDE_COLOURS[side])
            axis.plot(x, fits[name](x), color=SIDE_COLOURS[side],
                      label=f"{side + ' ' if side else ''}residual {fits[name].residual:.2g}°")
        down = half_strokes(next(iter(motions.values()))[2]["phi"](x))
        for begin, end in np.flatnonzero(np.diff(np.concatenate([[False], down, [False]]).astype(int))).reshape(-1, 2):
            axis.axvspan(x[begin], x[min(end, 400)], color="0.92", lw=0, zorder=0)
        axis.set(xlim=(0, 1), xlabel="phase (downstroke shaded)", ylabel="degrees", title=NAMES[name])
        axis.legend(fontsize=8)
    side, (_, _, fits) = next(iter(motions.items()))
    motion = Motion(fits, 1.0, True)
    draw_tips(figure.add_subplot(rows[1, 0]), motions, eta, x)
    for column, is_down in ((1, True), (2, False)):
        axis = figure.add_subplot(rows[1, column])
        draw_lollipops(axis, motion, 0.0, 1.0, is_down, (eta, 0.0), 11)
        axis.set_title(("downstroke" if is_down else "upstroke") + ", seen from the left" + (f", {side} wing" if side else ""), loc="left")
    figure.suptitle("The dot is the leading edge. In most flights it goes first in both half strokes. Forward is left.", fontsize=9)
    save(figure, path)


def draw_tips(axis: Axes, motions: Mapping[str, Measured], eta: float, x: np.ndarray) -> None:
    """Draws both tips from above, the head at the top: the right wing is the mirror image."""
    for side in ("left", "right"):
        _, _, fits = motions.get(side) or next(iter(motions.values()))
        angles = {name: fits[name](x) for name in ANGLES}
        tip, forward = left_wing(angles, eta, 0.0)
        sign = -1 if side == "left" else 1
        axis.plot(sign * tip[:, 1], tip[:, 0], color=SIDE_COLOURS[side if side in motions else ""])
        middle = int(np.argmin(np.gradient(angles["phi"])))
        edge = tip[middle] + 0.25 * forward[middle]
        axis.plot([0, sign * tip[middle, 1]], [0, tip[middle, 0]], color="0.75", lw=0.8, zorder=0)
        axis.plot([sign * tip[middle, 1], sign * edge[1]], [tip[middle, 0], edge[0]], color="0.3", lw=1.4)
        axis.plot(sign * edge[1], edge[0], "o", ms=4, color="0.3")
        axis.text(sign * 0.75, 1.0, side, ha="center")
    axis.plot([0, 0], [-0.45, 0.35], color="0.3", lw=4, solid_capstyle="round")
    axis.plot(0, 0.42, "o", color="0.3", ms=6)
    axis.set_aspect("equal")
    axis.set(xlim=(-1.25, 1.25), ylim=(-1.25, 1.25), xlabel="right $-y/R$", ylabel="forward $x/R$")
    axis.set_title("tips from above, mid-downstroke", loc="left")
