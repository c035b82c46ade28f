# SPDX-License-Identifier: GPL-3.0-or-later
"""Says along which axes a balance or cameras measured: options of the command line, and the attribute `axes` of a measurement file
(docs/formats/measurement-format.md), whose rows are the axes of the record along those of the flusi case."""
from __future__ import annotations

import argparse

import numpy as np

from flusi_msm.errors import Problems

LEAST_EXACT = 1e-4   # of products of two axes, as in the format
YAW, PITCH, ROLL, STROKE = (2, 1, 0, 1)  # the axes of the turns


def turned(axis: int, degrees: float) -> np.ndarray:
    """Returns FLUSI's (passive) matrix of a turn about an axis: v_new = M v_old."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = s, -s
    return matrix


def add_options(parser: argparse.ArgumentParser, of_what: str) -> None:
    """Adds the options that say along which axes `of_what` measured."""
    parser.add_argument("--axes", type=float, nargs=9, metavar="A", help=f"unit vectors x, y and z of {of_what}, one after another, along the "
                        "axes of the case (default: the same axes)")
    parser.add_argument("--yaw-pitch-roll", type=float, nargs=3, metavar=("YAW", "PITCH", "ROLL"), help=f"instead: {of_what} has the axes of a "
                        "body with this [Insects] yawpitchroll_0 [degree]")
    parser.add_argument("--stroke-plane", type=float, metavar="ETA0", help=f"and {of_what} is turned on into the stroke plane of this [Insects] "
                        "eta0 [degree]")


def axes_of(options: argparse.Namespace, is_section: bool, problems: Problems) -> np.ndarray | None:
    """Returns the axes (3, 3), which are orthonormal and right-handed, or None if they are those of the case. A section can be
    turned about x alone."""
    angles = options.yaw_pitch_roll is not None or options.stroke_plane is not None
    if options.axes is None and not angles:
        return None
    if options.axes is not None and angles:
        problems.error("--axes: give either the axes, or --yaw-pitch-roll and --stroke-plane")
        return None
    if options.axes is not None:
        axes = np.reshape(options.axes, (3, 3))
    else:
        yaw, pitch, roll = options.yaw_pitch_roll or (0.0, 0.0, 0.0)
        axes = turned(STROKE, options.stroke_plane or 0.0) @ turned(ROLL, roll) @ turned(PITCH, pitch) @ turned(YAW, yaw)
    wrong = np.abs(axes @ axes.T - np.eye(3)).max()
    if not wrong <= LEAST_EXACT:
        problems.error(f"--axes: are no unit vectors at right angles, by {wrong:.2g}; valid up to {LEAST_EXACT:g}")
    elif np.linalg.det(axes) < 0:
        problems.error("--axes: are left-handed; z must be the cross product of x and y")
    elif is_section and axes[0, 0] < 1 - LEAST_EXACT:
        problems.error("axes: a section per metre of span can be turned about x alone")
    return axes
