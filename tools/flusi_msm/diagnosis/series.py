# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws records of motion and those of the baseline and of the extended wing, for the report of a diagnosis."""
from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from flusi_msm.diagnosis.versions import entry_of
from flusi_msm.style import COLOURS

UNITS = {"m": (1e6, "displacement [µm]"), "m/s": (1e3, "velocity [mm/s]")}
Traces = dict[int, tuple[np.ndarray, np.ndarray]]  # number of the trace: table, place
Record = tuple[dict[str, Any], Traces]             # facts of the JSON file, traces
SHOWN = 4  # traces of a record, from the one that fits worst


def read_series(tables: Path, diagnosis: dict[str, Any]) -> list[Record]:
    """Returns [(facts of the JSON file, {trace: table (samples, 5): time measured sigma baseline extended, place})]."""
    records = []
    sets = entry_of(diagnosis, "series")["sets"]
    if sets and tables.exists():
        with h5py.File(tables, "r") as file:
            for facts in sets:
                traces = {}
                for name, stored in file.get(f"series/{facts['name']}", {}).items():
                    table = np.asarray(stored)
                    traces[int(name)] = table if table.shape[-1] == 5 else table.T, np.ravel(stored.attrs["point"])
                if traces:
                    records.append((facts, traces))
    return records


def draw_record(facts: dict[str, Any], traces: Traces, is_extended: bool) -> Figure:
    """Draws each trace over time, and below it the residuals of the models."""
    factor, title = UNITS[facts["units"]]

    def misfit(number: int) -> float:
        table = traces[number][0]
        return float(np.nansum(((table[:, 3] - table[:, 1]) / table[:, 2])**2))
    shown = sorted(sorted(traces, key=misfit, reverse=True)[:SHOWN])
    figure, axes = plt.subplots(2 * len(shown), 1, figsize=(6.2, 0.6 + 2.3 * len(shown)), sharex=True, squeeze=False,
                                height_ratios=[1.5, 1] * len(shown), layout="constrained")
    for row, number in enumerate(shown):
        table, place = traces[number]
        time, measured, sd = 1e3 * table[:, 0], table[:, 1], table[:, 2]
        above, below = axes[2 * row, 0], axes[2 * row + 1, 0]
        above.errorbar(time, factor * measured, factor * sd, fmt="k.", ms=3, lw=0.6, label="measured", zorder=1)
        below.axhspan(-1, 1, color="0.9", zorder=0)
        for k, which in enumerate(("baseline", "extended")[:1 + is_extended]):
            above.plot(time, factor * table[:, 3 + k], color=COLOURS[k], lw=1.2, ls="-" if k == 0 else "--", label=which)
            below.plot(time, (table[:, 3 + k] - measured) / sd, color=COLOURS[k], lw=0.9, marker=".", ms=3)
        above.set_title(f"{facts['name']}, point {number} at ({1e3 * place[0]:.1f}, {1e3 * place[1]:.1f}) mm", fontsize=8)
        above.set_ylabel(title, fontsize=7)
        below.set_ylabel("left [sd]", fontsize=7)
        for ax in above, below:
            ax.tick_params(labelsize=7)
    axes[0, 0].legend(fontsize=7, ncols=3, loc="upper right")
    axes[-1, 0].set_xlabel("time after the excitation [ms]", fontsize=8)
    return figure
