# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the numbers of a training: convergence, parameters with their intervals, profiles, scalar readings."""
from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

from flusi_msm.style import COLOURS
from flusi_msm.training.run import Parameter, Training, prefix_of

INK, PALE = "#3A2A18", "0.85"
KNOWN, ROUGH, OPEN = COLOURS[0], COLOURS[4], "0.55"  # determined, roughly determined, not determined
VERDICT_COLOURS = {"determined": KNOWN, "roughly": ROUGH, "unknown": "0.25"}
THRESHOLD_90 = 2.705543454095404  # 90 % of chi^2 with one degree of freedom


# ---- convergence ---------------------------------------------------------------------------------

def cost_scale(training: Training) -> tuple[float, str]:
    """Returns (factor, label) of the cost."""
    return (1e6, "h [µm]") if training.cost == "h" else (1.0, r"$\chi^2$")


def runs_of(training: Training) -> list[slice]:
    """Returns slices of the generations that belong to one run of one stage."""
    g = training.generations
    change = np.flatnonzero((np.diff(g["stage"]) != 0) | (np.diff(g["run"]) != 0)) + 1
    ends = [0, *change, len(g["stage"])]
    return [slice(a, b) for a, b in zip(ends, ends[1:])]


def draw_convergence(training: Training) -> Figure:
    """Draws cost, step and condition over the evaluated candidates, and the final least squares next to them."""
    g = training.generations
    count = np.cumsum(g["lambda"])
    has_polish = training.polish is not None and len(training.polish) > 1
    figure = plt.figure(figsize=(11, 7.4))
    grid = figure.add_gridspec(4, 2 if has_polish else 1, width_ratios=[2.3, 1] if has_polish else None,
                               height_ratios=[2.2, 1, 1, 0.8], hspace=0.14, wspace=0.25)
    panels = [figure.add_subplot(grid[k, 0]) for k in range(4)]
    for axes in panels[1:]:
        axes.sharex(panels[0])
    factor, label = cost_scale(training)
    runs = runs_of(training)
    for k, part in enumerate(runs):
        x = count[part]
        first = k == 0
        alone = "o" if len(x) == 1 else None  # a line through one point is not visible
        panels[0].plot(x, factor * g["generation_median"][part], color="0.72", lw=1.0, marker=alone, ms=4,
                       label="median of a generation" if first else None)
        panels[0].plot(x, factor * g["generation_best"][part], ".", color=COLOURS[5], ms=4,
                       label="best of a generation" if first else None)
        panels[0].plot(x, factor * g["best"][part], color=COLOURS[0], lw=2.0, marker=alone, ms=6, zorder=1.9,
                       label="best so far" if first else None)
        panels[1].plot(x, g["sigma"][part], color=COLOURS[2], marker=alone)
        panels[2].plot(x, g["condition"][part], color=COLOURS[3], marker=alone)
        if not first:
            mark_restart(panels, g, part, runs[k - 1], count)
    panels[3].bar(count, 100 * g["infeasible"] / g["lambda"], width=-g["lambda"], align="edge", color=COLOURS[4],
                  label="in an excluded zone")
    panels[3].bar(count, 100 * g["failed"] / g["lambda"], bottom=100 * g["infeasible"] / g["lambda"], align="edge",
                  width=-g["lambda"], color=COLOURS[1], label="without a solution")
    mark_outcome(training, panels[0], factor, count[-1])
    for axes, name in zip(panels, (label, "step σ", "condition", "left out [%]")):
        axes.set_ylabel(name)
        axes.grid(axis="y", color="0.92", lw=0.6)
        axes.set_axisbelow(True)
        if axes is not panels[3]:
            low, high = axes.dataLim.intervaly
            if axes is panels[0] or high > 5 * low:
                axes.set_yscale("log")
            axes.tick_params(labelbottom=False)
    panels[3].set_ylim(0, max(20.0, min(100.0, 1.15 * np.max(100 * (g["infeasible"] + g["failed"]) / g["lambda"]))))
    panels[3].legend(loc="upper right", ncols=2, borderaxespad=0)
    panels[3].set_xlabel("candidates tried")
    panels[0].set_xlim(0, None)
    low, high = panels[0].get_ylim()
    if low > 0.5 and high < 2e4:  # plain numbers
        panels[0].yaxis.set_major_formatter(LogFormatter())
        panels[0].yaxis.set_minor_formatter(LogFormatter())
    panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)
    panels[0].set_title("global search (CMA-ES)", loc="left")
    if has_polish:
        draw_polish(training, figure.add_subplot(grid[:2, 1]))
    figure.align_ylabels(panels)
    return figure


def mark_restart(panels: Sequence[Axes], g: Mapping[str, np.ndarray], part: slice, before: slice, count: np.ndarray) -> None:
    """Draws a line where a run ends, and the reason why the next one begins."""
    at = count[before.stop - 1]
    for axes in panels:
        axes.axvline(at, color="0.45", lw=0.9, ls=(0, (4, 3)), zorder=0)
    is_stage = g["stage"][part.start] != g["stage"][before.start]
    text = f"stage {g['stage'][part.start]:.0f}" if is_stage else f"restart, λ = {g['lambda'][part.start]:.0f}"
    panels[0].text(at, 0.98, " " + text, transform=panels[0].get_xaxis_transform(), fontsize=8, color="0.3", va="top",
                   ha="left", rotation=90)


def mark_outcome(training: Training, axes: Axes, factor: float, last: float) -> None:
    """Draws the final value after the least squares."""
    final = training.outcome.get(training.cost)
    if not final or not final > 0:
        return
    at = last + (training.polish[-1, 0] if training.polish is not None and len(training.polish) else 0)
    axes.plot([last, at], [factor * training.generations["best"][-1], factor * final], color=COLOURS[1], lw=1.0, ls=":")
    axes.plot(at, factor * final, "*", color=COLOURS[1], ms=13, mec="white", mew=0.6, clip_on=False, zorder=5,
              label="trained wing")


def begins_of_fits(training: Training) -> list[int]:
    """Returns the first row of each fit in the path of least squares: a fit only goes down while its errors stay the same, and its
    errors only become smaller."""
    assert training.polish is not None
    _, data, prior, *errors = training.polish.T
    stage = errors[0] if errors else np.ones(len(data))
    total = data / stage**2 + prior
    rises = (stage[1:] > stage[:-1]) | ((stage[1:] == stage[:-1]) & (total[1:] > total[:-1]))
    return [0, *(np.flatnonzero(rises) + 1)]


def draw_polish(training: Training, axes: Axes) -> None:
    """Draws the sum of squares over the evaluations of least squares: of the first fit, with marks where a stage with smaller errors
    begins, and of those from further starts and moves."""
    assert training.polish is not None
    n, data, prior, *errors = training.polish.T
    begins = begins_of_fits(training)
    for first, last in zip(begins, [*begins[1:], len(n)]):
        fit = slice(first, last)
        if first == 0:
            axes.plot(n[fit], (data + prior)[fit], "o-", color=COLOURS[1], ms=4.5, label="with the priors", zorder=3)
            axes.plot(n[fit], data[fit], ".", color=INK, ms=4, label="of the measurements", zorder=4)
        else:
            axes.plot(n[fit], (data + prior)[fit], ".-", color="0.55", ms=3, lw=0.9, zorder=2,
                      label="further starts and moves" if first == begins[1] else None)
    if (data + prior).max() > 5 * data.min():
        axes.set_yscale("log")
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))
    axes.grid(axis="y", color="0.92", lw=0.6)
    axes.set_xlabel("evaluations of all loads")
    axes.set_ylabel(r"$\chi^2$")
    end = begins[1] if len(begins) > 1 else len(n)
    stages = np.flatnonzero(np.diff(errors[0][:end])) if errors else np.empty(0, dtype=int)
    for k in stages:
        axes.axvline(0.5 * (n[k] + n[k + 1]), color="0.45", lw=0.9, ls=(0, (4, 3)), zorder=0,
                     label="next stage" if k == stages[0] else None)
    axes.set_title("polish (least squares)", loc="left")
    axes.legend(loc="upper right", frameon=True, facecolor="white", edgecolor="none", framealpha=1, fontsize=8)


# ---- parameters ----------------------------------------------------------------------------------

def groups_of(parameters: Sequence[Parameter]) -> list[list[Parameter]]:
    """Groups parameters of one unit and one scale, which share an axis."""
    groups: dict[tuple[str, bool], list[Parameter]] = {}
    for p in parameters:
        groups.setdefault((p.unit, p.is_log), []).append(p)
    return list(groups.values())


def draw_parameters(training: Training) -> Figure:
    """Draws a row for every parameter: its range in the search, its value and 90 % interval, and an arrow where the measurements
    give no end."""
    groups = groups_of(training.parameters)
    heights = [0.34 * len(group) + 0.75 for group in groups]
    figure, panels = plt.subplots(len(groups), 1, figsize=(10.5, sum(heights)), squeeze=False,
                                  gridspec_kw={"height_ratios": heights, "hspace": 1.15 / np.mean(heights)})
    for axes, group in zip(panels[:, 0], groups):
        for row, p in enumerate(group):
            draw_parameter(axes, len(group) - 1 - row, p)
        dress_parameters(axes, group)
    return figure


def draw_parameter(axes: Axes, y: float, p: Parameter) -> None:
    """Draws one row: range, value and interval."""
    colour = VERDICT_COLOURS.get(p.verdict, OPEN)
    axes.plot([p.low, p.high], [y, y], color=PALE, lw=7, solid_capstyle="butt", zorder=1)
    if p.verdict in ("determined", "roughly"):
        axes.plot([p.known.lower, p.known.upper], [y, y], color=colour, lw=3.2, solid_capstyle="butt", zorder=3)
        for end in (p.known.lower, p.known.upper):
            axes.plot([end, end], [y - 0.22, y + 0.22], color=colour, lw=1.4, zorder=3)
        axes.plot(p.known.best, y, "o", ms=6.5, color=colour, mec="white", mew=0.9, zorder=4)
    elif p.verdict == "unknown":
        if np.isfinite(p.value):
            axes.plot(p.value, y, "o", ms=6, mfc="white", mec=colour, mew=1.3, zorder=4)
    elif p.verdict != "failed":
        ends = p.known.lower if p.known.has_lower else p.low, p.known.upper if p.known.has_upper else p.high
        style = {"lower": "-|>", "upper": "<|-", "open": "<|-|>"}[p.verdict]
        axes.annotate("", xy=(ends[1], y), xytext=(ends[0], y), zorder=3,
                      arrowprops={"arrowstyle": style + ",head_width=0.22,head_length=0.45", "color": OPEN, "lw": 1.8,
                                  "shrinkA": 0, "shrinkB": 0, "ls": "-" if p.verdict != "open" else (0, (3, 2))})
        for has, end in ((p.known.has_lower, p.known.lower), (p.known.has_upper, p.known.upper)):
            if has:
                axes.plot([end, end], [y - 0.27, y + 0.27], color=OPEN, lw=2.2, zorder=4)
    text = p.shown() + (f"   {p.uncertainty()}" if p.uncertainty() else "")
    text = "interval not found" if p.verdict == "failed" else text
    axes.text(1.02, y, text, transform=axes.get_yaxis_transform(), va="center", fontsize=9,
              color=INK if p.verdict in ("determined", "roughly", "unknown") else "0.45")


def dress_parameters(axes: Axes, group: Sequence[Parameter]) -> None:
    low, high = min(p.low for p in group), max(p.high for p in group)
    axes.set_yticks(range(len(group)), [p.label for p in reversed(group)])
    axes.set_ylim(-0.7, len(group) - 0.3)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    if group[0].is_log:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(10, numticks=20))
        axes.set_xlim(low / (high / low)**0.01, high * (high / low)**0.01)
    axes.grid(axis="x", color="0.93", lw=0.7)
    axes.set_axisbelow(True)
    unit = group[0].unit
    axes.set_xlabel(f"[{unit}]" if unit not in ("", "1") else "[–]", labelpad=1)


# ---- profiles ------------------------------------------------------------------------------------

def has_profile(p: Parameter) -> bool:
    """Returns whether there is a profile to draw."""
    return p.interval is not None and p.profile is not None and len(p.profile) > 1


def draw_profiles(training: Training) -> Figure | None:
    """Draws how the best possible fit becomes worse if one parameter is held at other values; None without profiles."""
    chosen = [p for p in training.parameters if has_profile(p)]
    if not chosen:
        return None
    columns = min(4, len(chosen))
    rows = -(-len(chosen) // columns)
    figure, panels = plt.subplots(rows, columns, figsize=(2.85 * columns + 0.5, 2.45 * rows), squeeze=False,
                                  gridspec_kw={"hspace": 0.62, "wspace": 0.16})
    for k, axes in enumerate(panels.ravel()):
        if k >= len(chosen):
            axes.axis("off")
            continue
        draw_profile(axes, chosen[k])
        if k % columns:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(r"$\chi^2$ above minimum")
    return figure


def draw_profile(axes: Axes, p: Parameter) -> None:
    """Draws the profile of one parameter."""
    assert p.profile is not None
    rows = p.profile[np.argsort(p.profile[:, 0])]
    colour = VERDICT_COLOURS.get(p.verdict, OPEN)
    one = p.known
    factor, unit = prefix_of(one.best, p.unit)
    x, y = factor * rows[:, 0], rows[:, 1]
    ends = factor * one.lower, factor * one.upper
    axes.axvspan(*ends, color=colour, alpha=0.13, lw=0)
    axes.axhline(THRESHOLD_90, color="0.4", lw=0.8, ls=(0, (4, 3)))
    axes.plot(x, y, "o", color=colour, ms=3.6, zorder=3)
    axes.plot(*between_points(x, y, factor * one.best, p.is_log), color=colour, lw=1.2)
    axes.set_ylim(-0.15, 2.3 * THRESHOLD_90)
    if p.is_log and ends[1] / ends[0] > 4:
        axes.set_xscale("log")
        room = (ends[1] / ends[0])**0.12
        axes.set_xlim(ends[0] / room, ends[1] * room)
        if ends[1] / ends[0] > 30:
            axes.xaxis.set_major_locator(LogLocator(10, numticks=6))
            axes.xaxis.set_minor_locator(NullLocator())
        else:
            axes.xaxis.set_major_locator(LogLocator(10, subs=(1, 2, 5)))
            axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        room = 0.25 * (ends[1] - ends[0]) or abs(ends[0]) * 1e-3 or 1e-3
        axes.set_xlim(ends[0] - room, ends[1] + room)
        axes.xaxis.set_major_locator(MaxNLocator(3))
        axes.ticklabel_format(axis="x", useOffset=False, style="plain")
    axes.set_xlabel(f"[{unit}]" if unit else "[–]", labelpad=1)
    axes.set_title(p.label, loc="left", fontsize=9)


def between_points(x: np.ndarray, y: np.ndarray, best: float, is_log: bool) -> tuple[np.ndarray, np.ndarray]:
    """Returns a profile between its points: the root of the sum of squares, which is straight for linear problems, is
    interpolated linearly."""
    at = np.log(x) if is_log else x
    fine = np.unique(np.concatenate([np.linspace(at[0], at[-1], 400), at]))
    root = np.interp(fine, at, np.where(x < best, -1, 1) * np.sqrt(np.maximum(y, 0)))
    return np.exp(fine) if is_log else fine, root**2


# ---- scalar observations -------------------------------------------------------------------------

def draw_readings(training: Training) -> Figure | None:
    """Draws scalar observations with their 90 % errors and the values of the trained wing; None without any."""
    if training.readings is None:
        return None
    is_rotation = training.readings.rows[:, 4] > 0.5
    kinds = [kind for kind in (("displacement", "m", ~is_rotation), ("rotation", "rad", is_rotation)) if kind[2].any()]
    figure, panels = plt.subplots(2, len(kinds), figsize=(2 + 5.2 * len(kinds), 5.6), squeeze=False, sharex="col",
                                  gridspec_kw={"height_ratios": [2, 1], "hspace": 0.1, "wspace": 0.3})
    for (name, unit, mask), (top, below) in zip(kinds, panels.T):
        rows = training.readings.rows[mask]
        factor, shown = prefix_of(float(np.abs(rows[:, 1]).max()), unit)
        n = np.arange(1, len(rows) + 1)
        top.errorbar(n, factor * rows[:, 1], 1.645 * factor * rows[:, 3], fmt="o", color=INK, ms=4, capsize=2,
                     label="measured, 90 %")
        top.plot(n, factor * rows[:, 2], "_", color=COLOURS[1], ms=12, mew=2.2, label="simulated")
        top.set_ylabel(f"{name} [{shown}]")
        top.legend()
        below.axhspan(-1.645, 1.645, color=COLOURS[0], alpha=0.12, lw=0)
        below.axhline(0, color="0.5", lw=0.8)
        below.vlines(n, 0, (rows[:, 2] - rows[:, 1]) / rows[:, 3], color=COLOURS[1], lw=2)
        below.set_ylabel("difference [sd]")
        below.set_xlim(0.4, len(n) + 0.6)
        below.set_xlabel("reading" if len(n) > 30 else "")
        if len(n) <= 30:
            names = [one for one, is_of in zip(training.readings.names, mask) if is_of]
            below.set_xticks(n, names, rotation=60, ha="right", fontsize=8)
    return figure
