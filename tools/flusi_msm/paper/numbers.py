# SPDX-License-Identifier: GPL-3.0-or-later
"""Collects numbers of the flights and those of Truong et al., "An experimental data-driven mass-spring model of flexible
Calliphora wings": their Table 2, the shapes of the wings, and the spread over individuals."""
from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.paper.cases import FLEXIBLE, RIGID, Case
from flusi_msm.plots.cycle import Chosen
from flusi_msm.plots.individuals import PAPER as PAPER_SPREADS
from flusi_msm.plots.individuals import QUANTITIES, spread_of, table_of
from flusi_msm.plots.runs import Number, numbers
from flusi_msm.render.wing_surface import UPPER_SIDE, surface_path
from flusi_msm.results.cycles import PHASES, CyclicSignal, FlappingRun
from flusi_msm.results.files import InputError, Snapshot, choose_snapshot, read_series
from flusi_msm.results.wing_sides import BOTH, WingSides

KINDS = (RIGID, FLEXIBLE)
# Names in the JSON file, and the rows of compare_runs.
COLUMNS = {"lift_mN": "mean lift", "drag_mN": "mean drag", "power_mW": "mean aerodynamic power",
           "lift_to_drag": "lift / drag", "lift_to_power": "lift / power"}
TABLE_2 = {RIGID: dict(zip(COLUMNS, (0.754, 0.167, 5.228, 4.513, 0.144))),
           FLEXIBLE: dict(zip(COLUMNS, (0.513, 0.062, 3.128, 8.294, 0.164)))}
PEAK_LIFT = {RIGID: 2.49, FLEXIBLE: 1.58}  # mN
TIP_DEFLECTION = (0.10, np.tan(np.radians(10)))  # of R: "10 %" in its text, "10 degrees" in the caption
SUCTION = -10.0  # normalised pressure, "p <= -10" on a large part of the dorsal side in the middle of the downstroke
MID_DOWN, MID_UP = 0.25, 0.75
SHAPES = {"tip": "tip uz, wing frame", **{f"{what.replace(' ', '_')}_{span}": f"{what} at {span} %"
                                          for what in ("trailing edge", "twist", "camber") for span in (25, 50, 75)}}


def change(rigid: Mapping[str, float], flexible: Mapping[str, float]) -> dict[str, float]:
    """Returns {column: the change by bending, in %}."""
    return {key: 100 * (flexible[key] / rigid[key] - 1) if rigid[key] else float("nan") for key in rigid}


PAPER: dict[str, Any] = {"table_2": TABLE_2, "change_percent": change(TABLE_2[RIGID], TABLE_2[FLEXIBLE]), "peak_lift_mN": PEAK_LIFT,
         "spread_of_individuals_percent": PAPER_SPREADS}


def last_two(run: FlappingRun) -> list[int]:
    """Returns the last two beats of a run."""
    return run.cycles()[-2:]


def open_run(case: Case) -> Chosen:
    """Returns (run, its last two beats, label) of a finished flight."""
    run = FlappingRun(case.folder)
    return run, last_two(run), case.label


def means_of(run: FlappingRun, cycles: list[int]) -> tuple[dict[str, Any], dict[str, Number], dict[str, float]]:
    """(row of Table 2, the table of compare_runs, its factors to SI)."""
    table = numbers(run, cycles)
    si = {name: value[2] or 1.0 for name, value in table.items()}
    return {key: table[name][0] * si[name] for key, name in COLUMNS.items()}, table, si


def row_of(case: Case) -> dict[str, Any]:
    """Returns the flight's own row of Table 2, with half the range over its beats, and numbers about its accuracy."""
    run, cycles, _ = open_run(case)
    row, table, si = means_of(run, cycles)
    row["half_range"] = {key: half * si[name] for key, name in COLUMNS.items() if (half := table[name][1]) is not None}
    row["peak_lift_mN"] = table["peak lift"][0] * si["peak lift"]
    row["lift_in_downstroke"] = lift_in_downstroke(run, cycles)
    row["beats"] = cycles
    state = case.state()
    row |= {"seconds": state.get("seconds"), "ranks": state.get("ranks"), "versions": state.get("versions", [])}
    return row | quality_of(case.folder)


def lift_in_downstroke(run: FlappingRun, cycles: list[int]) -> float | None:
    """Returns the part of the lift impulse of a beat that belongs to the downstroke, or None."""
    down, lift = run.downstroke(cycles[-1]), run.phase_average("lift", cycles)
    return float(lift[down].sum() / lift.sum()) if down is not None and lift.sum() else None


def quality_of(folder: Path) -> dict[str, float]:
    """Returns the steps per beat, the mean slip, and the ratio of the power that the wings lose to the power that the flow
    receives, from the last beat."""
    found: dict[str, float] = {}
    try:
        text = (folder / "summary.txt").read_text(encoding="utf-8", errors="replace")
        times = read_series(folder / "timesteps_info.t").time
    except (OSError, InputError):
        return found
    found["steps_in_last_beat"] = int(np.sum(times >= times[-1] - 1))
    for key, pattern in (("slip_percent", r"at a marker is\s+(\S+) %"), ("power_balance", r"wings lose is\s+(\S+) of")):
        match = re.search(pattern, text)
        if match:
            found[key] = float(match[1])
    return found


# ---- shapes ----------------------------------------------------------------------------------------

def shapes_of(case: Case) -> dict[str, CyclicSignal]:
    """Returns {name: CyclicSignal} of the left wing, positive to its dorsal side; lengths in R, twist in rad, camber in chords.
    """
    series = read_series(case.folder / "bending_left.t")
    sign = {"tip": UPPER_SIDE["left"]}  # the others are already positive to that side
    return {name: CyclicSignal(series.time, sign.get(name, 1) * series.column(column)) for name, column in SHAPES.items()}


def average(signal: CyclicSignal, cycles: Sequence[int]) -> np.ndarray:
    """Returns the mean over beats at PHASES."""
    return np.mean([signal.at(n, PHASES) for n in cycles], axis=0)


def deformation_of(case: Case) -> dict[str, dict[str, float]]:
    """Returns {name: extremes over the mean of the last two beats, their phases, and the middles of both strokes}."""
    cycles, found = open_run(case)[1], {}
    for name, signal in shapes_of(case).items():
        values = average(signal, cycles)
        largest = int(np.argmax(np.abs(values)))
        found[name] = {"lowest": float(values.min()), "highest": float(values.max()),
                       "phase_of_largest": float(PHASES[largest]), "largest": float(values[largest]),
                       "middle_of_downstroke": float(np.interp(MID_DOWN, PHASES, values)),
                       "middle_of_upstroke": float(np.interp(MID_UP, PHASES, values))}
    return found


def snapshot_at(case: Case, phase: float) -> Snapshot | None:
    """Returns what is saved at a phase of the last beat, or None."""
    try:
        snapshot = choose_snapshot(case.folder, case.beats - 1 + phase, None)
    except InputError:
        return None
    time = surface_time(surface_path(snapshot, "left"))
    return snapshot if time is not None and abs(time - (case.beats - 1 + phase)) < 0.06 else None


def surface_time(path: Path) -> float | None:
    """Returns the time of a surface file; None if it cannot be read."""
    import h5py
    try:
        with h5py.File(path, "r") as file:
            return float(np.ravel(file.attrs["time"])[0])
    except (OSError, KeyError):
        return None


def sides_at(snapshot: Snapshot, side: str = "left") -> WingSides | None:
    """Returns pressure and traction on both sides of a wing, or None if its surface has none."""
    try:
        return WingSides(surface_path(snapshot, side))
    except InputError:
        return None


def pressure_numbers(case: Case) -> dict[str, dict[str, float]]:
    """Returns {phase: lowest on the dorsal side, mean difference ventral - dorsal, part of the area with p <= -10, mean magnitude of
    the traction on both sides} or {}."""
    found = {}
    for phase in (MID_DOWN, MID_UP):
        snapshot = snapshot_at(case, phase)
        sides = sides_at(snapshot) if snapshot else None
        if sides is None:
            return {}
        wing = sides.wing
        a, b, c = (wing.points[wing.triangles[:, k]] for k in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        dorsal, ventral = (sides.pressure[side] for side in BOTH)
        found[str(phase)] = {"lowest_dorsal": float(dorsal.min()),
                             "mean_difference": float(np.average(ventral - dorsal, weights=areas)),
                             "part_in_suction": float(areas[dorsal <= SUCTION].sum() / areas.sum()),
                             **{f"mean_traction_{side}": float(np.average(np.linalg.norm(sides.traction[side], axis=1), weights=areas))
                                for side in BOTH}}
    return found


# ---- all of it -------------------------------------------------------------------------------------

def collect(pairs: Sequence[Case], individuals: Mapping[str, Case]) -> dict[str, Any]:
    """Returns the contents of the JSON file, from the flights that are finished. `pairs` are cases; `individuals` {label: case}.
    """
    grids = []
    for points in sorted({case.points for case in pairs}):
        grid: dict[str, Any] = {"points": points}
        for case in (c for c in pairs if c.points == points and c.is_finished()):
            grid[case.kind] = row_of(case)
            if case.kind == FLEXIBLE:
                grid["deformation"] = deformation_of(case)
                grid["pressure"] = pressure_numbers(case)
        if all(kind in grid for kind in KINDS):
            grid["change_percent"] = change(*({key: grid[kind][key] for key in COLUMNS} for kind in KINDS))
        grids.append(grid)
    found = {"schema": "flusi-msm reproduction", "schema_version": 1, "paper": PAPER, "grids": grids}
    done = {label: case for label, case in individuals.items() if case.is_finished()}
    if len(done) > 1:
        found["individuals"] = spread_over(done)
    return found


def individual_runs(cases: Mapping[str, Case]) -> list[Chosen]:
    """Returns (run, beats, label) of every individual; those that share a flight share the run."""
    opened = {case.name: open_run(case) for case in cases.values()}
    return [(*opened[case.name][:2], label) for label, case in cases.items()]


def spread_over(cases: Mapping[str, Case]) -> dict[str, Any]:
    """Returns means of the individuals and their spread."""
    table = table_of(individual_runs(cases))
    return {"points": next(iter(cases.values())).points, "flights": {label: case.name for label, case in cases.items()},
            "means": {name: dict(zip(cases, map(float, values))) for name, values in table.items()},
            "spread_percent": {name: spread_of(table[name])[1] for name in QUANTITIES}}
