# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows how a diagnosed cause changes a flight: two runs of flusi, with the baseline and with the extended wing, as a section of
the report."""
from __future__ import annotations

import io
from collections.abc import Sequence
from html import escape
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.page_parts import table_html
from flusi_msm.plots.cycle import Chosen
from flusi_msm.plots.runs import ROWS, Row, rows_of
from flusi_msm.results.cycles import PHASES, FlappingRun
from flusi_msm.style import COLOURS

LABELS = ("baseline", "extended")


def read_flights(folders: Sequence[Path]) -> list[Chosen]:
    """Returns [(run, cycles, label)] of the last cycle that both runs have."""
    runs = [FlappingRun(folder) for folder in folders]
    common = sorted(set(runs[0].cycles()) & set(runs[1].cycles()))[-1:]
    return [(run, run.choose(",".join(map(str, common))), label) for run, label in zip(runs, LABELS)]


def sentence_of(rows: Sequence[Row]) -> str:
    """Describes the changes of the means in words."""
    changes = {name: change for name, _, _, _, _, change in rows}
    parts = [f"{name} by {100 * changes['mean ' + name]:+.1f} %" for name in ROWS]
    return f"With the extended wing in place of the baseline the mean {', the mean '.join(parts[:-1])} and the mean " \
           f"{parts[-1]} change."


def draw_flights(runs: Sequence[Chosen]) -> bytes:
    """Draws lift, drag and power of both runs over the beat."""
    figure, axes = plt.subplots(1, len(ROWS), figsize=(10, 2.8), layout="constrained")
    for ax, quantity in zip(axes, ROWS):
        for (run, cycles, label), colour, style in zip(runs, COLOURS, ("-", "--")):
            factor, unit = run.si_factor(quantity)
            ax.plot(PHASES, (factor or 1) * run.phase_average(quantity, cycles), style, color=colour, label=label)
        ax.axhline(0, color="0.6", lw=0.6)
        ax.set_xlim(0, 1)
        ax.set_xlabel("$t/T$")
        ax.set_title(quantity + (f" [{unit}]" if unit else ""))
    axes[0].legend()
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=110)
    plt.close(figure)
    return data.getvalue()


def table_of_changes(runs: Sequence[Chosen], rows: Sequence[Row]) -> str:
    """Returns a table of means and peaks of both runs as HTML."""
    cycle = runs[0][1][0]
    lines = []
    for name, unit, values, _, si, change in rows:
        shown = si or values
        number = f"{100 * change:+.1f} %" if np.isfinite(change) else "–"
        lines.append((f"{escape(name)}{f' [{unit}]' if si and unit else ''}", *(f"{value:.4g}" for value in shown), number))
    return table_html((f"beat {cycle}", ("baseline", True), ("extended", True), ("change", True)), lines, "flight")


def flight_section(folders: Sequence[Path]) -> tuple[str, bytes]:
    """Returns (html without the picture, picture) of two folders of runs, baseline first."""
    runs = read_flights(folders)
    rows = rows_of(runs)
    return f"<p>{escape(sentence_of(rows))}</p>{table_of_changes(runs, rows)}", draw_flights(runs)
