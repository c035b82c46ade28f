#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws kinematics_frames.png of docs/guide/kinematics.md with the matrices of tools/plot_kinematics."""
from pathlib import Path

import numpy as np

from flusi_msm.plots import kinematics
from flusi_msm.plots.kinematics import COLOURS, plt, save, use_style

HERE = Path(__file__).resolve().parent

ETA, PHI, ALPHA, THETA = -70.0, 12.0, 55.0, 0.0
BODY, LEFT, RIGHT, GREY = "0.25", COLOURS[0], COLOURS[1], "0.6"
MIRROR = np.array([1.0, -1.0, 1.0])


def wing_axes(phi, alpha, theta, is_right=False):
    """Wing frame of this program: rows x, y, z in body components."""
    tip, front = kinematics.left_wing({"phi": [phi], "alpha": [alpha], "theta": [theta]}, ETA, 0.0)
    x, y = tip[0], front[0]
    if is_right:
        x, y = x * MIRROR, y * MIRROR
    return np.array([x, y, np.cross(x, y)])


def seen(points):
    """Parallel projection from front, left and above."""
    azimuth, height = np.radians(48), np.radians(38)
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    back = np.array([np.cos(azimuth), np.sin(azimuth), 0])
    up = np.array([0, 0, np.cos(height)]) - np.sin(height) * back
    return np.array([points @ right, points @ up])


def arrow(ax, begin, end, label, colour, away=0.09):
    ax.annotate("", xy=end, xytext=begin, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.3,
                                                      "shrinkA": 0, "shrinkB": 0})
    direction = np.subtract(end, begin) / np.hypot(*np.subtract(end, begin))
    ax.text(*(np.array(end) + away * direction), label, color=colour, ha="center", va="center")


def arc(ax, centre, radius, begin, end, label, colour="k", away=0.14):
    """From one direction to another, in degrees, with an arrow head."""
    angle = np.radians(np.linspace(begin, end, 40))
    x, y = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    ax.plot(x[:-2], y[:-2], color=colour, linewidth=1.0)
    ax.annotate("", xy=(x[-1], y[-1]), xytext=(x[-4], y[-4]),
                arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.0, "shrinkA": 0, "shrinkB": 0})
    middle = np.radians((begin + end) / 2)
    ax.text(centre[0] + (radius + away) * np.cos(middle), centre[1] + (radius + away) * np.sin(middle), label,
            color=colour, ha="center", va="center")


def draw_frames(ax):
    s = np.linspace(0, 2 * np.pi, 100)
    for radius, centre in ((0.2, -0.25), (0.17, 0.1), (0.13, 0.38)):
        ax.fill(*(seen(np.array([[centre, 0, 0]])) + radius * np.array([np.cos(s), np.sin(s)])), color="0.85")
    hinge = np.array([0.0, 0.28, 0.14])
    for is_right, colour in ((True, RIGHT), (False, LEFT)):
        axes = wing_axes(PHI, ALPHA, THETA, is_right)
        root = hinge * MIRROR if is_right else hinge
        r = 0.5 - 0.5 * np.cos(s)
        chord = np.where(s < np.pi, 0.07, -0.27) * np.abs(np.sin(s)) ** 0.8
        outline = root + np.outer(r, axes[0]) + np.outer(chord, axes[1])
        ax.fill(*seen(outline), facecolor=colour, alpha=0.15, edgecolor=colour, linewidth=1.2)
        for length, axis, name in zip((1.2, 0.38, 0.5), axes, "xyz"):
            arrow(ax, seen(root), seen(root + length * axis), f"${name}$", colour)
        ax.plot(*seen(root), "o", color=colour, markersize=4)
    ax.text(0.95, -0.85, "left wing:\n$z$ on the lower side", color=LEFT, ha="center", va="center")
    ax.text(-1.0, -0.05, "right wing:\n$z$ on the upper side", color=RIGHT, ha="center", va="center")
    ax.set(xlim=(-1.45, 1.45), ylim=(-1.1, 1.3))
    for axis, name, length in zip(np.eye(3), ("forward $x_b$", "left $y_b$", "up $z_b$"), (0.95, 0.95, 1.05)):
        arrow(ax, seen(np.zeros(3)), seen(length * axis), name, BODY, away=0.1)
    ax.set_title("frames of body and wings", loc="left")


def draw_stroke_plane(ax):
    eta = np.radians(ETA)
    plane = np.array([-np.sin(eta), np.cos(eta)])  # to the upper end of the stroke; forward is left
    normal = np.array([-np.cos(eta), -np.sin(eta)])
    arrow(ax, (0, 0), (-1.1, 0), "$x_b$", BODY)
    arrow(ax, (0, 0), (0, 0.85), "$z_b$", BODY)
    ax.plot(*np.transpose([-plane, plane]), color=GREY, linewidth=1.4)
    ax.text(*(plane + [0.02, 0.12]), "stroke plane", color=GREY, ha="center")
    arc(ax, (0, 0), 0.62, 90, 90 + ETA, r"$-\eta$")
    begin = -0.55 * plane
    alpha = np.radians(ALPHA)
    chord = np.cos(alpha) * normal - np.sin(alpha) * plane
    ax.plot(*np.transpose([begin, begin + 0.5 * normal]), color=GREY, linestyle="--", linewidth=0.9)
    ax.plot(*np.transpose([begin + 0.2 * chord, begin - 0.4 * chord]), color=LEFT, linewidth=2)
    ax.plot(*(begin + 0.2 * chord), "o", color=LEFT, markersize=5)
    n = np.degrees(np.arctan2(normal[1], normal[0]))
    arc(ax, begin, 0.34, n, n + ALPHA, r"$\alpha$", LEFT, 0.1)
    below = 0.55 * plane - 0.2 * normal
    arrow(ax, below, below - 0.4 * plane, "", GREY)
    ax.text(*(below - 0.1 * plane - 0.13 * normal), "downstroke", color=GREY, ha="left", va="top")
    ax.set(xlim=(-1.3, 1.3), ylim=(-0.55, 0.98))
    ax.set_title(r"from the left: $\eta$ and $\alpha$ (dot: leading edge)", loc="left")


def draw_position(ax):
    arrow(ax, (0, 0), (-0.75, 0), "forward", GREY, away=0.26)
    ax.plot([0, 0], [0, -1.0], color=GREY, linestyle="--", linewidth=0.9)
    ax.text(0, -1.1, "left", color=GREY, ha="center", va="top")
    tip = np.array([np.sin(np.radians(40)), -np.cos(np.radians(40))])
    ax.plot(*np.transpose([(0, 0), tip]), color=LEFT, linewidth=2)
    arc(ax, (0, 0), 0.6, -90, -50, r"$\phi$", LEFT)
    ax.set(xlim=(-1.1, 0.9), ylim=(-1.25, 0.2))
    ax.set_title(r"from above: $\phi$", loc="left")


def draw_deviation(ax):
    ax.plot([0, 1.0], [0, 0], color=GREY, linewidth=1.4)
    ax.text(1.05, 0, "stroke plane", color=GREY, va="center")
    arrow(ax, (0, 0), (0, 0.55), "up", GREY, away=0.12)
    tip = np.array([np.cos(np.radians(25)), -np.sin(np.radians(25))])
    ax.plot(*np.transpose([(0, 0), tip]), color=LEFT, linewidth=2)
    arc(ax, (0, 0), 0.7, 0, -25, r"$\theta$", LEFT, 0.12)
    ax.set(xlim=(-0.2, 1.8), ylim=(-0.7, 0.75))
    ax.set_title(r"left wing from the front: $\theta$", loc="left")


def main():
    use_style()
    figure = plt.figure(figsize=(9.6, 5.0), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1.5, 0.8, 0.8], height_ratios=[1.0, 1.0])
    panels = [(figure.add_subplot(grid[:, 0]), draw_frames), (figure.add_subplot(grid[0, 1:]), draw_stroke_plane),
              (figure.add_subplot(grid[1, 1]), draw_position), (figure.add_subplot(grid[1, 2]), draw_deviation)]
    for ax, draw in panels:
        draw(ax)
        ax.set_aspect("equal")
        ax.axis("off")
    save(figure, HERE / "kinematics_frames.png")


if __name__ == "__main__":
    main()
