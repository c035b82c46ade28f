# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws measured natural modes and those of the baseline and of the extended wing, for the report of a diagnosis."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flusi_msm.diagnosis.versions import entry_of
from flusi_msm.style import COLOURS

LIMIT = 4.0  # sd


def read_modes(tables: Path, diagnosis: dict[str, Any]) -> list[tuple[dict[str, Any], np.ndarray]]:
    """Returns [(facts of the JSON file, table (places, 6): x y measured sigma baseline extended)], in the order of frequencies.
    """
    modes = []
    sets = entry_of(diagnosis, "modes")["sets"]
    if sets and tables.exists():
        with h5py.File(tables, "r") as file:
            for facts in sorted(sets, key=lambda one: one["frequency_hz"]):
                stored = file[f"modes/{facts['name']}"]
                table = np.asarray(stored) if isinstance(stored, h5py.Dataset) else np.zeros((0, 6))
                modes.append((facts, table if table.shape[-1] == 6 else table.T))
    return modes


def label(facts: dict[str, Any]) -> str:
    """Name of a mode; one about a loaded shape says so."""
    return facts["name"] + (" (loaded)" if facts.get("is_loaded") else "")


def draw_values(ax: Axes, modes: Sequence[dict[str, Any]], keys: tuple[str, str, str], is_extended: bool) -> None:
    """Draws how far a number of each mode is from the measured one, in percent. `keys`: of the measured number and its sd, and the end
    of those of the models."""
    places = np.arange(len(modes))
    measured = np.array([facts[keys[0]] for facts in modes])
    scale = np.where(measured > 0, measured, 1.0)  # a damping ratio may be 0
    ax.errorbar(places, 0 * measured, 100 * np.array([facts[keys[1]] for facts in modes]) / scale, fmt="k_", capsize=3, label="measured")
    for k, which in enumerate(("baseline", "extended")[:2 if is_extended else 1]):
        values = np.array([facts[f"{which}_{keys[2]}"] for facts in modes])
        ax.plot(places + 0.12 * (k + 1), 100 * (values - measured) / scale, "o", color=COLOURS[k], ms=4, label=which)
    unit = "{:.0f} Hz" if keys[2] == "hz" else "ratio {:.3g}"
    ax.set_xticks(places, [f"{label(facts)}\n" + unit.format(facts[keys[0]]) for facts in modes], fontsize=7)
    ax.set_ylabel("frequency [%]" if keys[2] == "hz" else "damping ratio [%]", fontsize=7)
    ax.tick_params(axis="y", labelsize=7)
    ax.legend(fontsize=7, ncols=3)


def draw_modes(modes: Sequence[tuple[dict[str, Any], np.ndarray]], outline: Sequence[np.ndarray],
               draw_outline: Callable[[Axes, Sequence[np.ndarray]], None], is_extended: bool) -> Figure:
    """Draws frequencies and damping ratios of both models against measured ones, and for each mode its shape and the residuals of the
    models."""
    columns = 3 if is_extended else 2
    ratios = [facts for facts, _ in modes if "damping_ratio" in facts]
    tops = 2 if ratios else 1
    figure = plt.figure(figsize=(2.9 * columns, 1.6 * tops + 1.25 * len(modes)), layout="constrained")
    grid = figure.add_gridspec(tops + len(modes), columns, height_ratios=[1.6] * tops + [1.25] * len(modes))
    draw_values(figure.add_subplot(grid[0, :]), [facts for facts, _ in modes], ("frequency_hz", "sd_hz", "hz"), is_extended)
    if ratios:
        draw_values(figure.add_subplot(grid[1, :]), ratios, ("damping_ratio", "damping_sd", "damping_ratio"), is_extended)
    image = None
    for row, (facts, table) in enumerate(modes, tops):
        if not len(table):
            continue
        x, y, shape, sigma = 1e3 * table[:, 0], 1e3 * table[:, 1], table[:, 2], table[:, 3]
        panels = [(shape / np.abs(shape).max(), "viridis", 1.0, label(facts))]
        panels += [((table[:, 4 + k] - shape) / sigma, "RdBu_r", LIMIT, f"{which} leaves [sd], MAC {facts[which + '_mac']:.3f}")
                   for k, which in enumerate(("baseline", "extended")[:columns - 1])]
        for column, (values, colours, limit, title) in enumerate(panels):
            ax = figure.add_subplot(grid[row, column])
            shown = ax.scatter(x, y, c=values, s=18, cmap=colours, vmin=-limit, vmax=limit)
            draw_outline(ax, outline)
            ax.set_title(title, fontsize=7)
            ax.tick_params(labelsize=6)
            image = shown if column else image
    if image is not None:
        figure.colorbar(image, ax=figure.axes[tops:], shrink=0.5).ax.tick_params(labelsize=7)
    return figure
