# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws lift, drag and power of flapping wings over the normalised cycle, with their means; two or more folders are drawn in one
picture. Reads forces.t, aero_power.t (or wing_left.t, wing_right.t) and kinematics.t."""
from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.errors import InputError, run_command
from flusi_msm.results.cycles import PHASES, QUANTITIES, FlappingRun
from flusi_msm.style import COLOURS, name_of, save, use_style

PANELS = (("lift", ()), ("drag", ()), ("aerodynamic power", ("inertial power",)))
NORMALS = {"lift": r"lift / $\rho R^4 f^2$", "drag": r"drag / $\rho R^4 f^2$",
           "aerodynamic power": r"power / $\rho R^5 f^3$"}
DOWN_SHADE, UP_SHADE = "0.90", "0.97"
Chosen = tuple[FlappingRun, list[int], str]  # a run, its cycles that are drawn or averaged, its name for readers


# ---- numbers -------------------------------------------------------------------------------------

def span(cycles: Sequence[int]) -> str:
    """Writes numbers of cycles as 'cycle 4', 'cycles 3-4', 'cycles 1, 3'."""
    if len(cycles) == 1:
        return f"cycle {cycles[0]}"
    if cycles == list(range(cycles[0], cycles[-1] + 1)):
        return f"cycles {cycles[0]}-{cycles[-1]}"
    return f"cycles {', '.join(map(str, cycles))}"


def mean_text(run: FlappingRun, quantity: str, cycles: list[int], spread: bool = True) -> str:
    """Writes a mean with its spread, and in SI where its unit is known."""
    mean, half = run.means(quantity, cycles)
    text = f"{mean:.4g}"
    if spread and len(cycles) > 1:
        text += f" \N{PLUS-MINUS SIGN} {half:.2g}"
    factor, unit = run.si_factor(quantity)
    return text + (f" = {factor * mean:.4g} {unit}" if factor else "")


def print_means(runs: Sequence[Chosen]) -> None:
    """Prints the means of all runs."""
    for run, cycles, label in runs:
        print(f"{label}, {span(cycles)}:")
        for quantity in QUANTITIES:
            if quantity in run.signals:
                print(f"  mean {quantity:<18} {mean_text(run, quantity, cycles)}")


def write_csv(path: str | Path, runs: Sequence[Chosen]) -> None:
    """Writes phase averages of all runs in units of the run, and in SI where the units are known."""
    columns, notes = [("phase [1]", PHASES)], []
    for run, cycles, label in runs:
        end = f" {label}" if len(runs) > 1 else ""
        for quantity in QUANTITIES:
            if quantity not in run.signals:
                continue
            values = run.phase_average(quantity, cycles)
            factor, unit = run.si_factor(quantity)
            notes.append(f"# {label}, {span(cycles)}, mean {quantity}: {mean_text(run, quantity, cycles)}")
            unit_of_run = "rho L^5/T^3" if "power" in quantity else "rho L^4/T^2"
            columns.append((f"{quantity}{end} [{unit_of_run}]", values))
            if factor:
                columns.append((f"{quantity}{end} [{unit}]", factor * values))
    try:
        with open(path, "w", newline="", encoding="utf-8") as file:
            file.write("".join(note + "\n" for note in notes))
            writer = csv.writer(file)
            writer.writerow([name for name, _ in columns])
            writer.writerows([f"{value:.8g}" for value in row] for row in zip(*(values for _, values in columns)))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    print(path)


# ---- drawing -------------------------------------------------------------------------------------

def draw(runs: Sequence[Chosen], out: str | Path) -> None:
    """Draws all runs in one picture."""
    shown = [(main, extra) for main, extra in PANELS if any(main in run.signals for run, _, _ in runs)]
    use_style()
    figure, axes = plt.subplots(len(shown), 1, sharex=True, squeeze=False,
                                figsize=(6.4, 0.8 + 2.3 * len(shown)), layout="constrained")
    down = stroke_of(runs)
    for ax, (main, extra) in zip(axes[:, 0], shown):
        shade(ax, down, labelled=ax is axes[0, 0])
        draw_panel(ax, runs, main, extra)
    cut = any(starts_suddenly(run, cycles, main) for run, cycles, _ in runs for main, _ in shown if main in run.signals)
    axes[-1, 0].set_xlabel("$t/T$" + (f"\n{NOTE}" if cut else ""))
    figure.align_ylabels()
    save(figure, out)


def stroke_of(runs: Sequence[Chosen]) -> np.ndarray | None:
    """Returns the downstroke of the first run that knows it."""
    for run, cycles, _ in runs:
        down = run.downstroke(cycles[-1])
        if down is not None:
            return down
    print("note: no kinematics.t for this cycle, so up- and downstroke are not shaded", file=sys.stderr)
    return None


def shade(ax: Axes, down: np.ndarray | None, labelled: bool) -> None:
    """Shades up- and downstroke."""
    if down is None:
        return
    ends = np.concatenate([[0], 1 + np.flatnonzero(np.diff(down.astype(int))), [len(down)]])
    widest: dict[bool, tuple[int, float]] = {}
    for begin, end in zip(ends[:-1], ends[1:]):
        moves_down = bool(down[begin])
        ax.axvspan(begin / len(down), end / len(down), color=DOWN_SHADE if moves_down else UP_SHADE, linewidth=0)
        if end - begin > widest.get(moves_down, (0, 0))[0]:
            widest[moves_down] = (end - begin, (begin + end) / 2 / len(down))
    if labelled:
        for moves_down, (_, middle) in widest.items():
            ax.text(middle, 0.97, "downstroke" if moves_down else "upstroke", transform=ax.get_xaxis_transform(),
                    ha="center", va="top", fontsize="small", color="0.35")


START = 0.1  # of the first cycle, in which the flow starts: the peaks in summary.txt do not include it, either
NOTE = f"axes and peaks leave out t/T < {START:g} of cycle 1, in which the flow starts"


def settled(phases: np.ndarray, values: np.ndarray, cycles: Sequence[int]) -> np.ndarray:
    """Returns the record without the start of the flow, next to which all other values would be small."""
    chosen = phases >= START if 1 in cycles else np.full(len(phases), True)
    return values[chosen] if chosen.any() else values


def starts_suddenly(run: FlappingRun, cycles: Sequence[int], quantity: str) -> bool:
    """Returns whether the start of the flow in cycle 1 is higher than all later values."""
    if 1 not in cycles:
        return False
    phases, values = run.signals[quantity].cycle(1)
    rest = settled(phases, values, [1])
    return bool(np.ptp(np.append(values, 0.0)) > 1.02 * np.ptp(np.append(rest, 0.0)))


def draw_panel(ax: Axes, runs: Sequence[Chosen], main: str, extra: Sequence[str]) -> None:
    """Draws one quantity of all runs, with thin lines for what belongs to it."""
    ax.axhline(0, color="0.6", linewidth=0.6)
    strong = []
    for number, (run, cycles, label) in enumerate(runs):
        if main not in run.signals:
            continue
        colour = COLOURS[number % len(COLOURS)]
        for n in run.cycles():
            if cycles != [n]:
                ax.plot(*run.signals[main].cycle(n), color=colour, alpha=0.35, linewidth=0.6, zorder=1.5)
        text = [label if len(runs) > 1 else span(cycles), f"mean {mean_text(run, main, cycles, spread=False)}"]
        strong.append((cycles, *best_curve(run, main, cycles)))
        ax.plot(*strong[-1][1:], color=colour, linewidth=1.8, label=", ".join(text), zorder=2.5)
        ax.axhline(run.means(main, cycles)[0], color=colour, linewidth=0.9, linestyle=(0, (1, 1.5)), zorder=2)
        for quantity in moving(run, extra):
            strong.append((cycles, *best_curve(run, quantity, cycles)))
            ax.plot(*strong[-1][1:], "--", color=colour, linewidth=1.1, zorder=2.5)
    if any(moving(run, extra) for run, _, _ in runs):
        ax.plot([], [], "--", color="0.3", linewidth=1.1, label=" ".join(extra).replace(" power", ""))
    ax.set_xlim(0, 1)
    low = min(0.0, *(np.min(settled(x, y, cycles)) for cycles, x, y in strong))
    high = max(0.0, *(np.max(settled(x, y, cycles)) for cycles, x, y in strong))
    room = 0.08 * ((high - low) or 1.0)
    ax.set_ylim(low - room, high + 1.8 * room)
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2 if len(runs) < 2 else 1, borderaxespad=0.2,
              handlelength=1.6, labelspacing=0.2)
    ax.set_ylabel(NORMALS[main] if runs[0][0].scales else f"{main} [code units]".replace("aerodynamic ", ""))
    factor, unit = runs[0][0].si_factor(main)
    if factor and all(np.isclose(run.si_factor(main)[0] or 0, factor) for run, _, _ in runs):
        right = ax.secondary_yaxis("right", functions=(lambda y: y * factor, lambda y: y / factor))
        right.set_ylabel(f"[{unit}]")
        right.spines["right"].set_visible(True)


def moving(run: FlappingRun, quantities: Sequence[str]) -> list[str]:
    """Returns the quantities that exist and are not always zero, as is the inertial power of wings without mass."""
    return [q for q in quantities if q in run.signals and np.any(run.signals[q].values)]


def best_curve(run: FlappingRun, quantity: str, cycles: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Returns the record itself if it is one cycle, else the average at equal phases."""
    if len(cycles) == 1:
        return run.signals[quantity].cycle(cycles[0])
    return PHASES, run.phase_average(quantity, cycles)


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", metavar="DIR", help="folder of a run")
    parser.add_argument("--cycles", default="last", help="cycles to average and draw strongly: last (default), all, "
                        "4, 3-4 or 1,3; the first is 1")
    parser.add_argument("--labels", help="names of the runs in the legend, separated by commas")
    parser.add_argument("--frequency", type=float, default=1.0, help="wing beats per unit of time of the run "
                        "(default 1)")
    parser.add_argument("--wind", default="x", choices=("x", "y", "-x", "-y"), help="direction of the mean flow "
                        "and of positive drag (default x); lift is z")
    parser.add_argument("--csv", help="write the curves and means into this file, too")
    parser.add_argument("-o", "--output", help="picture to write (default: cycle.png in the first folder, with "
                        "the names of several runs and the cycles that were asked for)")
    a = parser.parse_args()
    if a.frequency <= 0:
        raise InputError("--frequency must be positive")
    labels = [label.strip() for label in a.labels.split(",")] if a.labels else []
    if labels and len(labels) != len(a.folders):
        raise InputError(f"--labels: {len(labels)} name(s) for {len(a.folders)} folder(s)")
    runs = []
    for number, folder in enumerate(a.folders):
        run = FlappingRun(folder, a.frequency, a.wind)
        runs.append((run, run.choose(a.cycles), labels[number] if labels else run.name))
    print_means(runs)
    if a.csv:
        write_csv(a.csv, runs)
    others = [run.name for run, _, _ in runs] if len(runs) > 1 else []
    name = name_of("cycle", *others, a.cycles if a.cycles != "last" else "")
    draw(runs, a.output or Path(a.folders[0]) / f"{name}.png")


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_cycle", main)
