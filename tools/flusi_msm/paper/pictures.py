# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the pictures of the comparison with Truong et al. and writes them to files. Each function returns (heading, caption,
path), or None if there is nothing to draw."""
from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

from flusi_msm.paper.cases import Case
from flusi_msm.paper.study_files import Picture

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from flusi_msm.paper.cases import FLEXIBLE, RIGID, SNAPSHOT_PHASES
from flusi_msm.paper.numbers import (
    COLUMNS,
    MID_DOWN,
    MID_UP,
    TABLE_2,
    TIP_DEFLECTION,
    average,
    individual_runs,
    open_run,
    shapes_of,
    sides_at,
    snapshot_at,
)
from flusi_msm.plots import cycle as plot_cycle
from flusi_msm.plots import individuals as compare_individuals
from flusi_msm.results.cycles import PHASES
from flusi_msm.results.section import DEFAULT_FRACTIONS, draw_sections
from flusi_msm.results.wing_sides import draw_sides
from flusi_msm.style import COLOURS, save, use_style

KIND_COLOURS = dict(zip((RIGID, FLEXIBLE), COLOURS))
LABELS = ("lift [mN]", "drag [mN]", "power [mW]", "lift / drag", "lift / power [mN/mW]")


@contextlib.contextmanager
def quietly() -> Iterator[None]:
    """Prints nothing inside."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def convergence(grids: Sequence[dict[str, Any]], folder: Path) -> Picture:
    """Draws all numbers of Table 2 over the grids."""
    use_style()
    figure, axes = plt.subplots(1, len(COLUMNS), figsize=(12.5, 2.9), layout="constrained")
    for ax, key, label in zip(axes, COLUMNS, LABELS):
        for kind, colour in KIND_COLOURS.items():
            ax.axhline(TABLE_2[kind][key], color=colour, linewidth=1.0, linestyle="--")
            there = [grid for grid in grids if kind in grid]
            rows = [grid[kind] for grid in there]
            ax.errorbar([grid["points"] for grid in there], [row[key] for row in rows],
                        yerr=[row["half_range"].get(key, 0.0) for row in rows], color=colour, marker="o", markersize=4,
                        capsize=2, label=kind)
        ax.set_title(label, loc="left")
        ax.set_xlabel("points along x")
        ax.set_xticks([grid["points"] for grid in grids])
        ax.set_ylim(bottom=0)
    axes[0].plot([], [], "--", color="0.3", label="paper")
    axes[0].legend(fontsize="small")
    path = folder / "convergence.png"
    save(figure, path)
    return ("Convergence", "Means of the last two beats on all grids; bars are half the range over these beats. Dashed: the "
            "paper, on 1024 x 1024 x 512 points with a sheet of four cells.", path)


def forces(cases: Sequence[Case], folder: Path) -> Picture:
    """Draws lift, drag and power over the beat, rigid and flexible."""
    runs = [open_run(case) for case in cases]
    path = folder / "forces.png"
    plot_cycle.draw(runs, path)
    return ("Lift, drag and power over the beat",
            f"{cases[0].points} points; strong lines: the mean of the {plot_cycle.span(runs[0][1])}, thin ones: the beats. "
            "Dotted: means; dashed: inertial power.", path)


def deformation(case: Case, folder: Path) -> Picture:
    """Draws tip, twist and camber of the left flexible wing over the beat."""
    run, cycles, _ = open_run(case)
    signals = shapes_of(case)
    use_style()
    figure, axes = plt.subplots(2, 2, figsize=(9.4, 5.4), sharex=True, layout="constrained")
    panels = ((axes[0, 0], ("tip",), "tip [R]"),
              *((ax, tuple(f"{what}_{span}" for span in (25, 50, 75)), label) for ax, what, label in (
                  (axes[0, 1], "trailing_edge", "trailing edge [R]"), (axes[1, 0], "twist", "twist [rad]"),
                  (axes[1, 1], "camber", "camber [chord]"))))
    down = plot_cycle.stroke_of([(run, cycles, case.label)])
    for ax, names, label in panels:
        plot_cycle.shade(ax, down, labelled=ax is axes[0, 0])
        ax.axhline(0, color="0.6", linewidth=0.6)
        for name, colour in zip(names, COLOURS):
            for n in cycles:
                ax.plot(*signals[name].cycle(n), color=colour, linewidth=0.5, alpha=0.5)
            ax.plot(PHASES, average(signals[name], cycles), color=colour, linewidth=1.6,
                    label=f"{name[-2:]} % of the span" if len(names) > 1 else None)
        ax.set_ylabel(label)
        ax.set_xlim(0, 1)
    axes[0, 0].plot(MID_DOWN, TIP_DEFLECTION[0], "v", color="black", label="paper: 10 % of R")
    axes[0, 0].legend(fontsize="small", loc="center right")
    low, high = axes[0, 0].get_ylim()
    axes[0, 0].set_ylim(low, high + 0.15 * (high - low))
    axes[0, 1].legend(fontsize="small")
    for ax in axes[1]:
        ax.set_xlabel("$t/T$")
    path = folder / "deformation.png"
    save(figure, path)
    return ("Deformation", f"Left flexible wing, {case.points} points, in its own frame: movement of the tip and of the trailing "
            "edge, twist and camber at parts of the span, positive toward the dorsal side. Thick: the mean of the last beats.",
            path)


def sections(case: Case, phase: float, folder: Path) -> Picture | None:
    """Draws the spanwise vorticity around the left wing at a phase of the last beat."""
    snapshot = snapshot_at(case, phase)
    if snapshot is None or not (snapshot.folder / f"vorx_{snapshot.label}.h5").is_file():
        return None
    path = folder / f"section_{case.kind}_{round(100 * phase)}.png"
    with quietly():
        draw_sections(snapshot, "left", DEFAULT_FRACTIONS, None, path)
    stroke = {MID_DOWN: "downstroke", MID_UP: "upstroke"}[phase]
    return (f"Sections in the middle of the {stroke}: {case.kind} wing",
            f"Spanwise vorticity at a quarter, half and three quarters of the span, {case.points} points"
            + ("; black: the bent wing, blue: the rigid one." if case.kind == FLEXIBLE else "."), path)


def wing_sides(case: Case, folder: Path) -> Picture | None:
    """Draws pressure and viscous traction on both sides of the left wing at the phases that are saved, as in the paper's Figure 10,
    which has the pressure alone."""
    snapshots = [snapshot_at(case, phase) for phase in SNAPSHOT_PHASES]
    found = [sides for snapshot in snapshots if snapshot and (sides := sides_at(snapshot))]
    if not found:
        return None
    path = folder / f"sides_{case.kind}.png"
    save(draw_sides(found, r"\rho R^2 f^2"), path)
    return (f"Pressure and friction on both sides, {case.kind} wing", f"Left wing, {case.points} points, drawn unbent; root on the "
            f"left, leading edge up. The flow {found[0].distance:.2g} R beside the wing; friction: magnitude in colour, arrows along "
            "the wing. The paper's Figure 10 shows pressure and has p <= -10 on a large part of the dorsal side in the downstroke.",
            path)


def individuals(cases: Mapping[str, Case], folder: Path) -> Picture:
    """Draws the means and curves of all individuals."""
    runs = individual_runs(cases)
    path = folder / "individuals.png"
    compare_individuals.draw(runs, compare_individuals.table_of(runs), path)
    return ("Individuals", f"{next(iter(cases.values())).points} points; boxes: means of the last two beats, curves: their "
            "averages over the beat. Individuals whose files are the same are one flight.", path)


def all_pictures(found: dict[str, Any], pairs: Sequence[Case], individual_cases: Mapping[str, Case], folder: Path) -> list[Picture]:
    """Returns [(heading, caption, path)] of all pictures that are possible; sections and the like are on the finest grid that
    has both wings."""
    folder.mkdir(parents=True, exist_ok=True)
    made: list[Picture | None] = []
    with quietly():
        done = [grid for grid in found["grids"] if any(kind in grid for kind in KIND_COLOURS)]
        if done:
            made.append(convergence(done, folder))
        finest = max((grid["points"] for grid in done if "change_percent" in grid), default=None)
        cases = [case for case in pairs if case.points == finest]
        if cases:
            made += [forces(cases, folder), deformation(cases[-1], folder)]
            made += [sections(case, phase, folder) for phase in (MID_DOWN, MID_UP) for case in cases]
            made += [wing_sides(case, folder) for case in cases]
        if "individuals" in found:
            made.append(individuals({label: case for label, case in individual_cases.items() if case.is_finished()}, folder))
    return [picture for picture in made if picture]
