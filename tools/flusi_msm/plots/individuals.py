# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares flights of several individuals, usually the nine of ini/individuals: normalised lift, drag and power of all, means
over the last cycles, and the spread over the individuals, (largest - smallest)/median, compared with that of Truong et al.
Writes text, CSV and one picture: box plots of the means and the curves over the wing beat."""
from __future__ import annotations

import argparse
import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib

from flusi_msm.plots.cycle import Chosen

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.errors import InputError, run_command
from flusi_msm.plots.cycle import NORMALS, shade, span, stroke_of
from flusi_msm.results.cycles import PHASES, FlappingRun
from flusi_msm.style import COLOURS, save, use_style

QUANTITIES = ("lift", "drag", "aerodynamic power")
PAPER = {"lift": 5.12, "drag": 45.16, "aerodynamic power": 5.14}  # %, spread of the nine flexible pairs


def last_cycles(run: FlappingRun, wanted: str | None) -> list[int]:
    """Returns the given cycles, by default the last two (or the only one)."""
    return run.cycles()[-2:] if wanted is None else run.choose(wanted)


def table_of(runs: Sequence[Chosen]) -> dict[str, np.ndarray]:
    """Returns {quantity: means of the runs}, with both ratios."""
    table = {quantity: np.array([run.means(quantity, cycles)[0] for run, cycles, _ in runs]) for quantity in QUANTITIES}
    with np.errstate(divide="ignore", invalid="ignore"):
        table["lift / drag"] = table["lift"] / table["drag"]
        table["lift / power"] = table["lift"] / table["aerodynamic power"]
    return table


def spread_of(values: np.ndarray) -> tuple[float, float]:
    """Returns (median, (largest - smallest)/median in %)."""
    median = float(np.median(values))
    return median, 100 * float(np.ptp(values)) / abs(median) if median else float("nan")


def text_of(runs: Sequence[Chosen], table: Mapping[str, np.ndarray]) -> str:
    """Returns the table of all individuals as text."""
    lines = ["normalised by rho R^4 f^2 and rho R^5 f^3; " + ", ".join(sorted({span(c) for _, c, _ in runs})), "",
             f"{'':16}" + "".join(f"{name:>20}" for name in table)]
    for n, (_, _, label) in enumerate(runs):
        lines.append(f"{label[:15]:16}" + "".join(f"{values[n]:>20.5g}" for values in table.values()))
    spreads = [spread_of(values) for values in table.values()]
    lines.append(f"{'median':16}" + "".join(f"{median:>20.5g}" for median, _ in spreads))
    lines.append(f"{'spread %':16}" + "".join(f"{spread:>20.2f}" for _, spread in spreads))
    lines.append(f"{'paper, spread %':16}" + "".join(f"{PAPER[name]:>20.2f}" if name in PAPER else f"{'-':>20}"
                                                      for name in table))
    return "\n".join(lines) + "\n"


def write(path: Path, runs: Sequence[Chosen], table: Mapping[str, np.ndarray]) -> None:
    """Writes the means of all individuals as CSV."""
    try:
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["individual", *table])
            for n, (_, _, label) in enumerate(runs):
                writer.writerow([label, *(f"{values[n]:.8g}" for values in table.values())])
            writer.writerow(["median", *(f"{spread_of(values)[0]:.8g}" for values in table.values())])
            writer.writerow(["spread %", *(f"{spread_of(values)[1]:.6g}" for values in table.values())])
            writer.writerow(["paper, spread %", *(PAPER.get(name, "") for name in table)])
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    print(path)


def draw(runs: Sequence[Chosen], table: Mapping[str, np.ndarray], out: Path) -> None:
    """Draws box plots of the means and the curves over the beat."""
    use_style()
    figure, axes = plt.subplots(len(QUANTITIES), 2, figsize=(8.4, 2.3 * len(QUANTITIES)), layout="constrained",
                                width_ratios=(1, 3.2))
    down = stroke_of(runs)
    for (box, curves), quantity in zip(axes, QUANTITIES):
        values = table[quantity]
        box.boxplot(values, whis=(0, 100), widths=0.5, medianprops={"color": COLOURS[1]})
        # They are drawn next to each other, for runs with equal means.
        places = 1 + 0.16 * (np.arange(len(values)) / max(1, len(values) - 1) - 0.5)
        box.plot(places, values, "o", color=COLOURS[0], markersize=3.5, alpha=0.7)
        box.set_xticks([])
        low, high = min(values.min(), 0), max(values.max(), 0)
        box.set_ylim(low - 0.08 * (high - low), high + 0.12 * (high - low))
        box.set_title(f"spread {spread_of(values)[1]:.2f} % (paper {PAPER[quantity]:.2f} %)", loc="left")
        box.set_ylabel(f"mean {NORMALS[quantity]}")
        shade(curves, down, labelled=quantity == QUANTITIES[0])
        curves.axhline(0, color="0.6", linewidth=0.6)
        for n, (run, cycles, label) in enumerate(runs):
            curves.plot(PHASES, run.phase_average(quantity, cycles), color=COLOURS[n % len(COLOURS)], linewidth=1.0,
                        linestyle="-" if n < len(COLOURS) else "--", label=label)
        curves.set_xlim(0, 1)
    axes[-1, 1].set_xlabel("$t/T$")
    axes[0, 1].legend(ncols=3, loc="upper right", bbox_to_anchor=(1, 0.92))
    save(figure, out)


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", metavar="DIR", nargs="+", type=Path, help="folders of the runs, two or more")
    parser.add_argument("--cycles", help="as in plot_cycle (default: the last two)")
    parser.add_argument("--labels", help="names of the runs, separated by commas (default: of the folders)")
    parser.add_argument("--frequency", type=float, default=1.0, help="wing beats per unit of time (default 1)")
    parser.add_argument("--wind", default="x", choices=("x", "y", "-x", "-y"), help="as in plot_cycle")
    parser.add_argument("-o", "--output", type=Path, default=Path("individuals"),
                        help="stem of the files written (default individuals)")
    a = parser.parse_args()
    if len(a.folders) < 2:
        raise InputError("a spread needs two runs or more")
    labels = [label.strip() for label in a.labels.split(",")] if a.labels else [f.resolve().name for f in a.folders]
    if len(labels) != len(a.folders):
        raise InputError(f"--labels has {len(labels)} names for {len(a.folders)} runs")
    runs = []
    for folder, label in zip(a.folders, labels):
        run = FlappingRun(folder, a.frequency, a.wind)
        for quantity in QUANTITIES:
            if quantity not in run.signals:
                raise InputError(f"{folder}: {quantity} is not in its series")
        runs.append((run, last_cycles(run, a.cycles), label))
    table = table_of(runs)
    text = text_of(runs, table)
    print(text)
    try:
        a.output.with_suffix(".txt").write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{a.output}.txt: {error.strerror}") from None
    write(a.output.with_suffix(".csv"), runs, table)
    draw(runs, table, a.output.with_suffix(".png"))


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("compare_individuals", main)
