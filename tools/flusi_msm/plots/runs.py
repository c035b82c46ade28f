# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares two flights, usually rigid against flexible wings: a table of mean and peak lift, drag and power with
lift/drag and lift/power, as text and CSV, and both over the wing beat in one picture."""
from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Optional

import numpy as np

from flusi_msm.errors import InputError, run_command
from flusi_msm.plots.cycle import Chosen, draw, span
from flusi_msm.results.cycles import FlappingRun
from flusi_msm.style import name_of

ROWS = ("lift", "drag", "aerodynamic power")
Number = tuple[float, Optional[float], Optional[float], str]  # value, half its range over the cycles, factor to SI, SI unit
# Name, unit, values in units of the run, their half ranges, values in SI, change from the first run to the second.
Row = tuple[str, str, list[float], list[Optional[float]], Optional[list[float]], float]


def numbers(run: FlappingRun, cycles: list[int]) -> dict[str, Number]:
    """Returns {row: (value, spread or None, factor to SI, unit)} of one run."""
    table: dict[str, Number] = {}
    means = {}
    for quantity in ROWS:
        if quantity not in run.signals:
            raise InputError(f"{run.name}: {quantity} is not in its series")
        mean, spread = run.means(quantity, cycles)
        factor, unit = run.si_factor(quantity)
        means[quantity] = mean, factor, unit
        peaks = [np.max(run.signals[quantity].cycle(n)[1]) for n in cycles]
        table[f"mean {quantity}"] = mean, spread, factor, unit
        table[f"peak {quantity}"] = float(np.mean(peaks)), float(np.ptp(peaks)) / 2, factor, unit
    (lift, lift_si, _), (drag, _, _), (power, power_si, _) = (means[q] for q in ROWS)
    table["lift / drag"] = (lift / drag if drag else float("nan")), None, None, ""
    ratio_si = lift_si / power_si if lift_si and power_si else None
    table["lift / power"] = (lift / power if power else float("nan")), None, ratio_si, "mN/mW" if ratio_si else ""
    return table


def rows_of(runs: Sequence[Chosen]) -> list[Row]:
    """Returns (name, unit, values in units of the run, values in SI or None, change) for every row."""
    tables = [numbers(run, cycles) for run, cycles, _ in runs]
    rows = []
    for name in tables[0]:
        values = [table[name][0] for table in tables]
        factors = [table[name][2] for table in tables]
        si = [v * f for v, f in zip(values, factors) if f] if all(factors) else None
        base = (si or values)[0]
        change = ((si or values)[1] / base - 1) if base else float("nan")
        rows.append((name, tables[0][name][3], values, [table[name][1] for table in tables], si, change))
    return rows


def text_of(runs: Sequence[Chosen], rows: Sequence[Row]) -> str:
    """Returns the comparison as text."""
    labels = [label for _, _, label in runs]
    lines = [f"{label}: {run.folder}, {span(cycles)}" for run, cycles, label in runs]
    head = f"{'':24}" + "".join(f"{label[:20]:>22}" for label in labels) + f"{'change':>10}"
    lines += ["", "normalised (forces by rho L^4/T^2, power by rho L^5/T^3)", head]
    for name, _, values, spreads, _, change in rows:
        cells = [f"{v:.5g}" + (f" +- {s:.1g}" if s is not None else "") for v, s in zip(values, spreads)]
        lines.append(f"{name:24}" + "".join(f"{cell:>22}" for cell in cells) + f"{100 * change:>9.1f}%")
    if any(si for *_, si, _ in rows):
        lines += ["", "SI", head]
        for name, unit, _, _, si, change in rows:
            if si:
                lines.append(f"{name + ' [' + unit + ']':24}" + "".join(f"{v:>22.5g}" for v in si)
                             + f"{100 * change:>9.1f}%")
    return "\n".join(lines) + "\n"


def write(path: Path, runs: Sequence[Chosen], rows: Sequence[Row]) -> None:
    """Writes the table as CSV."""
    labels = [label for _, _, label in runs]
    try:
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["quantity", *labels, *(f"spread {label}" for label in labels), "unit",
                             *(f"SI {label}" for label in labels), "change"])
            for name, unit, values, spreads, si, change in rows:
                writer.writerow([name, *(f"{v:.8g}" for v in values),
                                 *("" if s is None else f"{s:.3g}" for s in spreads), unit,
                                 *(f"{v:.8g}" for v in si or [float("nan")] * len(values)), f"{change:.5g}"])
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    print(path)


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rigid", metavar="RIGID", help="folder of the run to compare with")
    parser.add_argument("flexible", metavar="FLEXIBLE", help="folder of the other run")
    parser.add_argument("--cycles", default="last", help="as in plot_cycle")
    parser.add_argument("--labels", default="rigid,flexible", help="names of the runs (default rigid,flexible)")
    parser.add_argument("--frequency", type=float, default=1.0, help="wing beats per unit of time (default 1)")
    parser.add_argument("--wind", default="x", choices=("x", "y", "-x", "-y"), help="as in plot_cycle")
    parser.add_argument("-o", "--output", help="stem of the files written (default: comparison_RIGID in FLEXIBLE, with the cycles that were "
                        "asked for)")
    a = parser.parse_args()
    labels = [label.strip() for label in a.labels.split(",")]
    if len(labels) != 2:
        raise InputError("--labels needs two names, separated by a comma")
    runs = []
    for folder, label in zip((a.rigid, a.flexible), labels):
        run = FlappingRun(folder, a.frequency, a.wind)
        runs.append((run, run.choose(a.cycles), label))
    rows = rows_of(runs)
    text = text_of(runs, rows)
    print(text)
    stem = Path(a.output or Path(a.flexible) / name_of("comparison", runs[0][0].name, a.cycles if a.cycles != "last" else ""))
    try:
        stem.with_suffix(".txt").write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{stem}.txt: {error.strerror}") from None
    write(stem.with_suffix(".csv"), runs, rows)
    draw(runs, stem.with_suffix(".png"))


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("compare_runs", main)
