# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a wing motion: its angles over the cycle, the path of the wing tips and the wing chord seen from the
side ("lollipops", the dot is the leading edge). Takes FLUSI's kinematics files: [kinematics] with Fourier or
Hermite coefficients, or a table of kinematics_loader."""
from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from flusi_msm.errors import InputError, run_command
from flusi_msm.style import COLOURS, save, use_style

ANGLES = ("phi", "alpha", "theta")
NAMES = {"phi": r"position $\phi$", "alpha": r"feathering $\alpha$", "theta": r"deviation $\theta$"}
DOWN, UP, SHADE = COLOURS[0], COLOURS[1], "0.92"
Angle = Callable[[np.ndarray], np.ndarray]  # degrees over the cycle number


# ---- reading -------------------------------------------------------------------------------------

class Motion:
    """Angles of one wing in degrees, in FLUSI's convention, as functions of the cycle number."""

    def __init__(self, functions: Mapping[str, Angle], length: float, periodic: bool) -> None:
        self.functions, self.length, self.periodic = functions, length, periodic

    def __call__(self, x: Sequence[float] | np.ndarray) -> dict[str, np.ndarray]:
        return {angle: self.functions[angle](np.asarray(x, dtype=float)) for angle in ANGLES}


def read_motion(path: str | Path) -> Motion:
    """Reads the motion in a file of either kind."""
    path = Path(path)
    try:
        text = path.read_text(errors="replace")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    if re.search(r"^\s*\[kinematics\]", text, re.MULTILINE):
        return motion_of_series(path, text)
    return motion_of_table(path, text)


def keys_of(text: str) -> dict[str, str]:
    """Returns {key: value} of the section [kinematics]."""
    keys: dict[str, str] = {}
    inside = False
    for line in text.splitlines():
        line = line.strip()
        if line.startswith("["):
            inside = line.startswith("[kinematics]")
        elif inside and "=" in line and line[0] not in ";#!%":
            key, value = line.split("=", 1)
            keys.setdefault(key.strip(), value.split(";", 1)[0].strip())
    return keys


def motion_of_series(path: Path, text: str) -> Motion:
    """Returns the motion of a section [kinematics]."""
    keys = keys_of(text)

    def numbers(key: str, n: int) -> np.ndarray:
        try:
            values = [float(word.replace("d", "e").replace("D", "e"))
                      for word in keys.get(key, "").replace(",", " ").split()]
        except ValueError:
            raise InputError(f"{path}: [kinematics] {key}: '{keys[key]}' is not a list of numbers") from None
        if len(values) != n:
            raise InputError(f"{path}: [kinematics] {key}: {len(values)} number(s), not {n}")
        return np.array(values)

    kind = keys.get("type", "").lower()
    if kind not in ("fourier", "hermite"):
        raise InputError(f"{path}: [kinematics] type: '{kind}' is unknown; valid: fourier | hermite")
    unit = 1.0 if keys.get("units", "degree").lower().startswith("degree") else 180 / np.pi
    functions = {}
    for angle in ANGLES:
        n = int(numbers(f"nfft_{angle}", 1)[0])
        a, b = numbers(f"ai_{angle}", n), numbers(f"bi_{angle}", n)
        sign = -1.0 if angle == "theta" and "sisc" in keys.get("convention", "").lower() else 1.0
        if kind == "fourier":
            mean = numbers(f"a0_{angle}", 1)[0] / 2 if f"a0_{angle}" in keys else 0.0
            functions[angle] = fourier(sign * unit * mean, sign * unit * a, sign * unit * b)
        elif n == 0:
            raise InputError(f"{path}: [kinematics] nfft_{angle}: is 0, but hermite needs a value")
        else:
            nodes = np.arange(n + 1) / n
            functions[angle] = cubic(nodes, sign * unit * np.append(a, a[0]), sign * unit * np.append(b, b[0]), True)
    return Motion(functions, 1.0, True)


def motion_of_table(path: Path, text: str) -> Motion:
    """Returns the motion of a table of kinematics_loader."""
    lines = [re.split(r"[;#!%]", line)[0].split() for line in text.splitlines()]
    try:
        rows = [[float(word) for word in line] for line in lines if line]
    except ValueError:
        raise InputError(f"{path}: neither [kinematics] nor a table of numbers") from None
    if len(rows) < 5 or any(len(row) != 1 for row in rows[:3]) or any(len(row) != 13 for row in rows[3:]):
        raise InputError(f"{path}: a table has period, wing length, number of rows, then rows of 13 numbers")
    period, data = rows[0][0], np.array(rows[3:])
    if len(data) != rows[2][0]:
        raise InputError(f"{path}: {len(data)} rows, but the third line announces {rows[2][0]:g}")
    x = data[:, 0] / period
    functions = {angle: cubic(x, sign * data[:, i], sign * period * data[:, i + 6], False)
                 for angle, i, sign in (("phi", 1, 1), ("alpha", 2, 1), ("theta", 3, -1))}
    return Motion(functions, x[-1], False)


def fourier(mean: float, a: np.ndarray, b: np.ndarray) -> Angle:
    """Returns the function of a Fourier series."""
    k = 2 * np.pi * np.arange(1, len(a) + 1)
    return lambda x: mean + np.cos(np.multiply.outer(x, k)) @ a + np.sin(np.multiply.outer(x, k)) @ b


def cubic(nodes: np.ndarray, values: np.ndarray, slopes: np.ndarray, periodic: bool) -> Angle:
    """Returns cubic Hermite pieces between the nodes."""
    def evaluate(x: np.ndarray) -> np.ndarray:
        x = x % 1.0 if periodic else x
        i = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
        h = nodes[i + 1] - nodes[i]
        s = (x - nodes[i]) / h
        rise = values[i + 1] - values[i]
        c2 = 3 * rise - h * (2 * slopes[i] + slopes[i + 1])
        c3 = h * (slopes[i] + slopes[i + 1]) - 2 * rise
        return values[i] + s * (h * slopes[i] + s * (c2 + s * c3))
    return evaluate


# ---- geometry ------------------------------------------------------------------------------------

def rotation(axis: int, degrees: Sequence[float] | np.ndarray | float) -> np.ndarray:
    """Returns passive rotations about an axis, one for each angle: (n, 3, 3)."""
    angle = np.radians(np.atleast_1d(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((len(angle), 3, 3))
    matrix[:, axis, axis] = 1
    matrix[:, i, i] = matrix[:, j, j] = np.cos(angle)
    matrix[:, i, j] = np.sin(angle)
    matrix[:, j, i] = -np.sin(angle)
    return matrix


def left_wing(angles: Mapping[str, Sequence[float] | np.ndarray], eta: float, pitch: float) -> tuple[np.ndarray, np.ndarray]:
    """Returns unit vectors (n, 3) from the hinge to the tip and from trailing to leading edge, in space."""
    m = (rotation(1, angles["alpha"]) @ rotation(2, angles["theta"]) @ rotation(0, angles["phi"])
         @ rotation(1, eta) @ rotation(1, pitch))
    return m[:, 1, :], m[:, 0, :]


def half_strokes(phi: np.ndarray) -> np.ndarray:
    """Returns True where the wing moves down, phi decreasing."""
    return np.gradient(phi) < 0


# ---- drawing -------------------------------------------------------------------------------------

def draw(path: str | Path, eta: float, pitch: float, count: int, out: str | Path) -> None:
    """Draws the motion of a file."""
    motion = read_motion(path)
    x = np.linspace(0, motion.length, 1 + max(400, int(400 * motion.length)))
    angles = motion(x)
    tip, _ = left_wing(angles, eta, pitch)
    use_style()
    figure = plt.figure(figsize=(8.0, 5.0), layout="constrained")
    rows = figure.add_gridspec(2, 3, height_ratios=[1.15, 1.0], width_ratios=[1.0, 1.4, 1.4])
    draw_angles(figure.add_subplot(rows[0, :]), x, angles)
    draw_path(figure.add_subplot(rows[1, 0]), tip, half_strokes(angles["phi"]))
    first = 0.0 if motion.periodic else max(0.0, motion.length - 1.0)
    for column, down in ((1, True), (2, False)):
        ax = figure.add_subplot(rows[1, column])
        draw_lollipops(ax, motion, first, min(motion.length, first + 1), down, (eta, pitch), count)
        if down:
            ax.set_ylabel("up $z/R$")
        else:
            ax.tick_params(labelleft=False)
    save(figure, out)


def draw_angles(ax: Axes, x: np.ndarray, angles: Mapping[str, np.ndarray]) -> None:
    """Draws the angles over the cycle."""
    down = half_strokes(angles["phi"])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], down, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2):
        ax.axvspan(x[begin], x[min(end, len(x) - 1)], color=SHADE, linewidth=0)
    ax.axhline(0, color="0.6", linewidth=0.6)
    for colour, angle in zip((COLOURS[6], COLOURS[2], COLOURS[3]), ANGLES):
        ax.plot(x, angles[angle], color=colour, label=NAMES[angle])
    ax.margins(x=0)
    ax.set_xlabel("cycle $t f$   (downstroke shaded)")
    ax.set_ylabel("angle [degree]")
    largest = max(np.max(np.abs(angles[angle])) for angle in ANGLES)
    if largest < 180:
        ax.yaxis.set_major_locator(matplotlib.ticker.MultipleLocator(30))
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)


def draw_path(ax: Axes, tip: np.ndarray, down: np.ndarray) -> None:
    """Draws both tips from above; the head is at the top."""
    for side in (1, -1):
        for part, colour, line in ((down, DOWN, "-"), (~down, UP, (0, (4, 3)))):
            shown = np.where(part[:, None], tip, np.nan)
            ax.plot(-side * shown[:, 1], shown[:, 0], linestyle=line, color=colour)
        for i in (np.argmax(tip[:, 0]), np.argmin(tip[:, 0])):
            ax.plot([0, -side * tip[i, 1]], [0, tip[i, 0]], color="0.75", linewidth=0.8, zorder=0)
    ax.plot([0, 0], [-0.45, 0.35], color="0.3", linewidth=4, solid_capstyle="round")
    ax.plot(0, 0.42, "o", color="0.3", markersize=6)
    ax.set_aspect("equal")
    ax.set(xlim=(-1.15, 1.15), ylim=(-1.15, 1.15), xlabel="right $-y/R$", ylabel="forward $x/R$")
    ax.set_title("tips from above", loc="left")


def draw_lollipops(ax: Axes, motion: Motion, begin: float, end: float, down: bool, attitude: tuple[float, float], count: int) -> None:
    """Draws the chord at the tip seen from the left: forward is left, as for a fly in a wind from the left."""
    x = np.linspace(begin, end, 2001)
    inside = np.flatnonzero(half_strokes(motion(x)["phi"]) == down)
    colour = DOWN if down else UP
    chord = 0.3
    tip, _ = left_wing(motion(x), *attitude)
    ax.plot(-tip[:, 0], tip[:, 2], color="0.8", linewidth=0.8, zorder=0)
    low, high = np.min(tip[:, 2]), np.max(tip[:, 2])
    if len(inside):
        chosen = x[inside[np.round(np.linspace(0, len(inside) - 1, count)).astype(int)]]
        tip, forward = left_wing(motion(chosen), *attitude)
        for p, c in zip(tip, forward):
            front, back = p + 0.3 * chord * c, p - 0.7 * chord * c
            ax.plot([-front[0], -back[0]], [front[2], back[2]], color=colour, linewidth=1.4, solid_capstyle="round")
            ax.plot(-front[0], front[2], "o", color=colour, markersize=3.6)
    ax.set_aspect("equal")
    ax.set(xlim=(-1.2, 1.2), ylim=(min(-0.7, low - 0.3), max(0.7, high + 0.3)))
    ax.set_xlabel("backward $-x/R$")
    ax.set_title("downstroke" if down else "upstroke", loc="left", color=colour)


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", help="kinematics file (.ini) or table (.dat)")
    parser.add_argument("--eta", type=float, default=-90.0, help="stroke-plane angle in degrees (default -90: the "
                        "plane of the body axes x and y)")
    parser.add_argument("--pitch", type=float, default=0.0, help="pitch of the body in degrees; negative is nose up")
    parser.add_argument("--count", type=int, default=11, help="chords drawn in each half stroke")
    parser.add_argument("-o", "--output", help="picture to write (default: beside the file, NAME_kinematics.png)")
    a = parser.parse_args()
    if a.count < 2:
        raise InputError("--count takes 2 or more")
    draw(a.file, a.eta, a.pitch, a.count,
         a.output or Path(a.file).with_name(f"{Path(a.file).stem}_kinematics.png"))


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_kinematics", main)
