# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a free flight: its path from the side and from above, velocity, attitude, and the weight and the force of the flow.
Reads rigidsolidsolver.t, free_flight.t in the folder of the run."""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.errors import run_command
from flusi_msm.results.files import InputError, read_series
from flusi_msm.style import COLOURS, save, use_style

BODY = 0.15  # length of the line that shows the attitude, over the longest way drawn


def read(folder: str | Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns time, states (13 columns) and loads (21 columns) of a run."""
    states = read_series(Path(folder) / "rigidsolidsolver.t")
    loads = read_series(Path(folder) / "free_flight.t")
    if states.data.shape[1] < 14 or loads.data.shape[1] < 22:
        raise InputError(f"{folder}: these are not the series of a free flight")
    n = min(len(states.data), len(loads.data))
    if n < 2:
        raise InputError(f"{folder}: a flight of one record has no path")
    return states.data[:n, 0], states.data[:n, 1:14], loads.data[:n, 1:22]


def heading(states: np.ndarray) -> np.ndarray:
    """Returns the direction of the body's x axis in space."""
    q0, q1, q2, q3 = states[:, 6:10].T
    return np.array([q0**2 + q1**2 - q2**2 - q3**2, 2 * (q1 * q2 + q0 * q3), 2 * (q1 * q3 - q0 * q2)]).T


def draw_path(ax: Axes, time: np.ndarray, states: np.ndarray, across: int, names: str) -> None:
    """Draws the path in the plane of x and the axis `across`, with the body at ten times."""
    x, y = states[:, 0], states[:, across]
    ax.plot(x, y, color=COLOURS[0])
    size = BODY * max(np.ptp(x), np.ptp(y), 1e-9)
    ahead = heading(states)
    for i in np.linspace(0, len(time) - 1, 10).astype(int):
        d = size * ahead[i, [0, across]]
        ax.plot([x[i] - d[0], x[i] + d[0]], [y[i] - d[1], y[i] + d[1]], color=COLOURS[1], linewidth=2, alpha=0.7)
        ax.plot([x[i] + d[0]], [y[i] + d[1]], "o", color=COLOURS[1], markersize=3)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("x [L]")
    ax.set_ylabel(f"{'xyz'[across]} [L]")
    ax.set_title(names)


def draw_lines(ax: Axes, time: np.ndarray, columns: np.ndarray, names: Sequence[str], label: str, title: str) -> None:
    """Draws columns over time."""
    for i, (values, name) in enumerate(zip(columns.T, names)):
        ax.plot(time, values, color=COLOURS[i], label=name)
    ax.axhline(0, color="0.7", linewidth=0.6, zorder=0)
    ax.set_xlabel("time [T]")
    ax.set_ylabel(label)
    ax.set_title(title)
    ax.legend(loc="best", ncols=3, handlelength=1.2)


def smooth(time: np.ndarray, values: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Returns the mean over the period before each time, where there is one."""
    integral = np.concatenate([[0], np.cumsum(np.diff(time) * (values[1:] + values[:-1]) / 2)])
    late = time >= time[0] + period
    return time[late], (integral[late] - np.interp(time[late] - period, time, integral)) / period


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", help="folder of a run")
    parser.add_argument("--frequency", type=float, default=1.0, help="wing beats per unit of time (default 1)")
    parser.add_argument("--weight", type=float, help="weight in rho L^4/T^2, to be drawn beside the force")
    parser.add_argument("-o", "--output", help="picture to write (default: flight.png in the folder)")
    a = parser.parse_args()
    if a.frequency <= 0:
        raise InputError("--frequency must be positive")
    time, states, loads = read(a.folder)
    use_style()
    figure, axes = plt.subplots(2, 3, figsize=(12.5, 7), layout="constrained")
    draw_path(axes[0, 0], time, states, 2, "path from the side; red: body, head at the dot")
    draw_path(axes[1, 0], time, states, 1, "path from above")
    draw_lines(axes[0, 1], time, states[:, 3:6], ("$v_x$", "$v_y$", "$v_z$"), "velocity [L/T]", "velocity of the body")
    draw_lines(axes[1, 1], time, np.degrees(np.unwrap(loads[:, 0:3], axis=0)), ("roll", "pitch", "yaw"), "angle [degrees]",
               "attitude (positive pitch: nose down)")
    draw_lines(axes[1, 2], time, states[:, 10:13], ("x", "y", "z"), r"$\omega$ [rad/T]", "angular velocity, body frame")
    ax = axes[0, 2]
    ax.plot(time, loads[:, 11], color=COLOURS[5], linewidth=0.7, label="$F_z$")
    ax.plot(*smooth(time, loads[:, 11], 1 / a.frequency), color=COLOURS[0], label="mean over a beat")
    if a.weight is not None:
        ax.axhline(a.weight, color=COLOURS[1], linestyle="--", label="weight")
    late = loads[time > time[0] + 0.1 * np.ptp(time), 11]
    if late.size:
        ax.set_ylim(min(0, late.min()) * 1.1, late.max() * 1.3 or 1)
    ax.set_xlabel("time [T]")
    ax.set_ylabel(r"force [$\rho L^4/T^2$]")
    ax.set_title("vertical force of the flow")
    ax.legend(loc="best")
    save(figure, a.output or Path(a.folder) / "flight.png")


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_flight", main)
