# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes wings that are described by numbers: a blowfly wing, a rectangular plate with spars, a strip for plane flows.

The same numbers give the same wing to the last bit on every machine.
"""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.wing import calliphora
from flusi_msm.wing.file import Wing, sorted_wing

MM = 1e-3


def make_calliphora(edge: float) -> Wing:
    """Returns the blowfly wing with edges of about `edge` [mm], less between veins that are close to each other."""
    if not 0.05 <= edge <= 0.6:
        raise InputError(f"--edge {edge}: must lie between 0.05 and 0.6 mm")
    drawing = calliphora.drawing()
    points, triangles, chains, number = drawing.mesh(edge)
    veins = {}
    for name, (nodes, lengths) in chains.items():
        if name not in calliphora.NOT_VEINS:
            veins[name] = (nodes, np.array([calliphora.diameter(name, s / lengths[-1]) for s in lengths]))
    joints: dict[str, tuple[Any, ...]] = {}
    for name, (vein, *other, place) in calliphora.JOINTS.items():
        node = number[place]
        if other:
            joints[name] = (veins[vein][0][veins[vein][0].index(node) - 1], node, veins[other[0]][0][1])
        else:
            joints[name] = (vein, node)
    root = chains["edge"][0]
    space = np.zeros((len(points), 3))
    space[:, :2] = points
    return sorted_wing(Wing(space * MM, np.array(triangles), veins, joints, root,
                            "Blowfly wing (Calliphora), synthetic", mass=calliphora.MASS))


def make_plate(length: float, chord: float, edge: float, spars: int, diameters: Sequence[float]) -> Wing:
    """Returns a plate: the rectangle 0 <= x <= length, -chord <= y <= 0 [mm] in squares of about `edge`, cut in two by diagonals
    of alternating direction; spars along x from the leading to the trailing edge at equal distances, with diameters [um] at root
    and tip; a joint at the middle of every spar."""
    if not (length > 0 and chord > 0 and 0 < edge <= min(length, chord) / 2):
        raise InputError("--length, --chord and --edge must be positive, and --edge at most half of the others")
    if spars < 0 or spars == 1 or min(diameters) <= 0:
        raise InputError("--spars must be 0 or at least 2, and --diameters positive")
    columns = max(2, int(length / edge + 0.5))
    columns += columns % 2                             # a point at the middle
    gaps = max(1, spars - 1)
    rows = gaps * max(1, int(chord / edge / gaps + 0.5))

    def number(i: int, j: int) -> int:
        return i * (rows + 1) + j

    points = [(length * i / columns, chord * (j / rows - 1), 0.0)
              for i in range(columns + 1) for j in range(rows + 1)]
    triangles = []
    for i in range(columns):
        for j in range(rows):
            a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
            triangles += [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
    veins, joints = {}, {}
    for k in range(spars):
        j, name = rows - k * rows // gaps, f"spar{k + 1}"
        taper = [1e-6 * (diameters[0] + (diameters[1] - diameters[0]) * i / columns) for i in range(columns + 1)]
        veins[name] = ([number(i, j) for i in range(columns + 1)], np.array(taper))
        joints[name + "_middle"] = (name, number(columns // 2, j))
    return sorted_wing(Wing(np.array(points) * MM, np.array(triangles), veins, joints,
                            [number(0, j) for j in range(rows + 1)], "Rectangular plate with spars"))


def make_strip(length: float, width: float, cells: int, diameter: float) -> Wing:
    """Returns a filament for a two-dimensional flow: rectangle 0 <= x <= length, |y| <= width/2 [mm], the mirror image of itself
    about y = 0, `cells` long and two wide. Mass, load and stiffness per width are the same for its three spars along x: those at
    the sides have half the moment of area of the middle one, whose diameter [um] is given."""
    if not (length > 0 and width > 0 and diameter > 0 and cells >= 2):
        raise InputError("--length, --width and --diameter must be positive, and --cells at least 2")
    points = [(length * i / cells, width * (j / 2 - 0.5), 0.0) for i in range(cells + 1) for j in range(3)]
    triangles = []
    for i in range(cells):
        a, b = 3 * i, 3 * i + 3
        triangles += [(a, b, b + 1), (a, b + 1, a + 1), (a + 1, b + 1, a + 2), (b + 1, b + 2, a + 2)]
    veins = {}
    for j, share in enumerate((0.5, 1.0, 0.5)):
        veins[f"spar{j + 1}"] = ([3 * i + j for i in range(cells + 1)], np.array([1e-6 * diameter * share**0.25] * (cells + 1)))
    return sorted_wing(Wing(np.array(points) * MM, np.array(triangles), veins, {}, [0, 1, 2],
                            "Strip for two-dimensional flows"))
