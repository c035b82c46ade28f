# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws where landmarks on wings were over the beat, and where the simulation has them, without and with the cause, for the report of a
diagnosis."""
from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flusi_msm.diagnosis.beat import MODELS
from flusi_msm.diagnosis.versions import entry_of
from flusi_msm.style import COLOURS

Marks = dict[int, dict[str, dict[str, Any]]]  # {landmark: {axis: its set in the JSON file}}
SHOWN = 4   # landmarks of a picture


def read_tracks(diagnosis: dict[str, Any]) -> list[tuple[str, Marks]]:
    """Returns [(record and wing, its landmarks)] of a diagnosis; [] without landmarks."""
    found: dict[str, Marks] = {}
    for one in entry_of(diagnosis, "landmarks")["sets"]:
        found.setdefault(f"{one['record']}_{one['wing']}", {}).setdefault(one["landmark"], {})[one["component"]] = one
    return list(found.items())


def left_over(one: dict[str, Any], model: str) -> np.ndarray:
    """Returns the simulated minus the measured coordinate in units of the sd."""
    return (np.array(one[model]) - np.array(one["measured"])) / np.array(one["sd"])


def worst(marks: Marks) -> list[int]:
    """Returns the landmarks that the case fits worst, in their order."""
    misfit = {mark: sum(float((left_over(one, "simulated")**2).sum()) for one in axes.values()) for mark, axes in marks.items()}
    return sorted(sorted(misfit, key=lambda mark: -misfit[mark])[:SHOWN])


def views_of(marks: Marks) -> list[tuple[str, str]]:
    """Returns the pairs of axes from which the motion is seen, as far as they were measured."""
    seen = {axis for axes in marks.values() for axis in axes}
    return [pair for pair in (("y", "z"), ("x", "z"), ("x", "y")) if set(pair) <= seen][:2]


def draw_view(ax: Axes, marks: Marks, pair: tuple[str, str], is_extended: bool) -> None:
    """Draws the tracks of the landmarks that fit worst in one plane [mm]. The first one that is drawn has the labels."""
    is_first = True
    for mark in worst(marks):
        if not set(pair) <= set(marks[mark]):
            continue
        across, up = (marks[mark][axis] for axis in pair)
        common, first, second = np.intersect1d(across["time"], up["time"], return_indices=True)
        if not len(common):
            continue
        ax.plot(1e3 * np.array(across["measured"])[first], 1e3 * np.array(up["measured"])[second], "k.", ms=3,
                label="measured" if is_first else None)
        for (model, label, style), colour in list(zip(MODELS, COLOURS))[:1 + is_extended]:
            ax.plot(1e3 * np.array(across[model])[first], 1e3 * np.array(up[model])[second], style, color=colour, lw=1.0,
                    label=label if is_first else None)
        is_first = False
    ax.set_xlabel(f"{pair[0]} [mm]", fontsize=8)
    ax.set_ylabel(f"{pair[1]} [mm]", fontsize=8)
    ax.set_aspect("equal", adjustable="datalim")
    ax.tick_params(labelsize=7)


def draw_left(ax: Axes, marks: Marks, is_extended: bool) -> None:
    """Draws the root mean square of what the models leave of all coordinates, over the beat."""
    every = [one for axes in marks.values() for one in axes.values()]
    times = np.unique(np.concatenate([one["time"] for one in every]))
    ax.axhspan(0, 1, color="0.9", zorder=0)
    for (model, _, style), colour in list(zip(MODELS, COLOURS))[:1 + is_extended]:
        squares, count = np.zeros(len(times)), np.zeros(len(times))
        for one in every:
            at = np.searchsorted(times, one["time"])
            squares[at] += left_over(one, model)**2
            count[at] += 1
        ax.plot(times, np.sqrt(squares / count), style, color=colour, lw=0.9, marker=".", ms=3)
    ax.set_xlim(0, 1)
    ax.set_ylim(bottom=0)
    ax.set_xlabel("$t/T$", fontsize=8)
    ax.set_ylabel("left [sd]", fontsize=7)
    ax.tick_params(labelsize=7)


def draw_tracks(marks: Marks, is_extended: bool) -> Figure:
    """Draws the landmarks of one wing: measured, simulated, and simulated with the cause."""
    views = views_of(marks)
    rows = len(views) + 1
    figure, axes = plt.subplots(rows, 1, figsize=(6.2, 1.8 + 3.0 * len(views)), squeeze=False, height_ratios=[3] * len(views) + [1.2],
                                layout="constrained")
    for ax, pair in zip(axes[:, 0], views):
        draw_view(ax, marks, pair, is_extended)
    if views and axes[0, 0].lines:
        axes[0, 0].legend(fontsize=7, ncols=3)
    draw_left(axes[-1, 0], marks, is_extended)
    return figure
