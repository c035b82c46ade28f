# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws records of forces over the beat and those of the simulation, without and with the cause, for the report of a diagnosis."""
from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flusi_msm.diagnosis.versions import entry_of
from flusi_msm.style import COLOURS
from flusi_msm.training.run import prefix_of

Components = list[dict[str, Any]]  # of one record, as in the JSON file
MODELS = (("simulated", "simulated", "-"), ("extended", "with the cause", "--"))


def read_beats(diagnosis: dict[str, Any]) -> list[tuple[str, Components]]:
    """Returns [(record, its components)] of a diagnosis; [] without records of forces."""
    records: dict[str, Components] = {}
    for one in entry_of(diagnosis, "flight")["sets"]:
        records.setdefault(one["record"], []).append(one)
    return list(records.items())


def draw_beat(components: Components, is_extended: bool) -> Figure:
    """Draws each component of a record over the beat, measured with a band of one sd and simulated, and below it what the
    simulation leaves in units of the sd."""
    n = len(components)
    figure, axes = plt.subplots(2 * n, 1, figsize=(6.2, 0.7 + 2.2 * n), sharex=True, squeeze=False, height_ratios=[1.6, 1] * n,
                                layout="constrained")
    for row, one in enumerate(components):
        draw_component(axes[2 * row, 0], axes[2 * row + 1, 0], one, is_extended)
    axes[0, 0].legend(fontsize=7, ncols=3)
    axes[-1, 0].set_xlim(0, 1)
    axes[-1, 0].set_xlabel("$t/T$", fontsize=8)
    return figure


def draw_component(above: Axes, below: Axes, one: dict[str, Any], is_extended: bool) -> None:
    """Draws one component into its two panels."""
    time, measured, sd = (np.array(one[name], dtype=float) for name in ("time", "measured", "sd"))
    factor, unit = prefix_of(float(np.max(np.abs(measured))), one["unit"])
    above.fill_between(time, factor * (measured - sd), factor * (measured + sd), color="0.85", lw=0)
    above.plot(time, factor * measured, "k.", ms=3, label="measured, 1 sd")
    above.axhline(0, color="0.6", lw=0.6)
    below.axhspan(-1, 1, color="0.9", zorder=0)
    for (name, label, style), colour in list(zip(MODELS, COLOURS))[:1 + is_extended]:
        values = np.array(one[name])
        above.plot(time, factor * values, style, color=colour, lw=1.2, label=label)
        below.plot(time, (values - measured) / sd, style, color=colour, lw=0.9, marker=".", ms=3)
    above.set_ylabel(f"{one['component']} [{unit}]", fontsize=8)
    below.set_ylabel("left [sd]", fontsize=7)
    for ax in above, below:
        ax.tick_params(labelsize=7)
