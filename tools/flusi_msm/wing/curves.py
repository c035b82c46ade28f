# SPDX-License-Identifier: GPL-3.0-or-later
"""Describes wings as curves in the plane, and makes meshes from curves.

Wing frame: x from root to tip, y toward the leading edge, z their right-handed normal. Lengths in mm.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Callable, Union

from flusi_msm.wing.triangulate import Point, Triangulation, distance

DENSE = 40  # pieces of a curve between two of its control points, when it is measured

Control = Union[str, Point]                  # of a curve: the name of a place, or a point
Chain = tuple[list[int], list[float]]        # points of a curve, and their arc lengths


def pair(values: Iterable[float]) -> Point:
    """Returns two numbers as a point."""
    x, y = values
    return x, y


def spline(controls: Sequence[Point]) -> tuple[list[Point], list[int]]:
    """Computes dense points on a smooth curve through the controls (cubic Hermite, slopes by chord length).

    Returns the points and the index of every control among them.
    """
    steps = [distance(a, b) for a, b in zip(controls, controls[1:])]
    slopes = [(0.0, 0.0)] * len(controls)
    for i in range(1, len(controls) - 1):
        s, t = steps[i - 1], steps[i]
        slopes[i] = pair(((controls[i][k] - controls[i - 1][k]) / s * t
                          + (controls[i + 1][k] - controls[i][k]) / t * s) / (s + t) for k in (0, 1))
    # The ends continue with the curvature of the next piece.
    for end, inner, step, sign in ((0, 1, steps[0], 1), (-1, -2, steps[-1], -1)):
        chord = pair((controls[inner][k] - controls[end][k]) / step * sign for k in (0, 1))
        slopes[end] = chord if len(controls) == 2 and end == 0 else \
            pair(1.5 * chord[k] - 0.5 * slopes[inner][k] for k in (0, 1))
    points, places = [pair(controls[0])], [0]
    for i, step in enumerate(steps):
        for m in range(1, DENSE + 1):
            t = m / DENSE
            u = 1 - t
            points.append(pair(u * u * (1 + 2 * t) * controls[i][k] + t * t * (3 - 2 * t) * controls[i + 1][k]
                               + step * t * u * (u * slopes[i][k] - t * slopes[i + 1][k]) for k in (0, 1)))
        points[-1] = pair(controls[i + 1])
        places.append(len(points) - 1)
    return points, places


class SizeField:
    """The edge length wanted at a point: `largest`, but smaller between curves that are close to each other."""

    def __init__(self, branches: Sequence[Branch], largest: float, closeness: float = 1.0, growth: float = 0.35) -> None:
        self.largest, self.sources = largest, []
        samples = [(branch, p) for branch in branches for p in branch.points[::4] + branch.points[-1:]]
        for branch, p in samples:
            gap = largest / closeness
            for other, q in samples:
                if not branch.ends & other.ends and abs(p[0] - q[0]) < gap and abs(p[1] - q[1]) < gap:
                    gap = min(gap, distance(p, q))
            if closeness * gap < largest:
                self.sources.append((p, max(closeness * gap, 0.25 * largest)))
        self.growth = growth
        self.known: dict[tuple[int, int], float] = {}

    def __call__(self, p: Point) -> float:
        """Returns the edge length; it is constant on cells that are small compared with the edges."""
        cell = (int(p[0] / (0.25 * self.largest) + 1000), int(p[1] / (0.25 * self.largest) + 1000))
        if cell not in self.known:
            middle = pair((c - 1000 + 0.5) * 0.25 * self.largest for c in cell)
            self.known[cell] = min([self.largest]
                                   + [h + self.growth * distance(middle, q) for q, h in self.sources])
        return self.known[cell]


class Branch:
    """A piece of a curve between two named places, as dense points."""

    def __init__(self, curve: str, first: str, last: str, points: list[Point]) -> None:
        self.curve, self.ends, self.first, self.last, self.points = curve, {first, last}, first, last, points

    def divide(self, size: Callable[[Point], float]) -> tuple[list[Point], list[float]]:
        """Returns points that divide the branch into edges of the size wanted, and their arc length from its start."""
        lengths, counts = [0.0], [0.0]
        for a, b in zip(self.points, self.points[1:]):
            step = distance(a, b)
            middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
            lengths.append(lengths[-1] + step)
            counts.append(counts[-1] + step / size(middle))
        n = max(1, int(counts[-1] + 0.5))
        points, at, k = [self.points[0]], [0.0], 0
        for m in range(1, n):
            goal = counts[-1] * m / n
            while counts[k + 1] < goal:
                k += 1
            t = (goal - counts[k]) / (counts[k + 1] - counts[k])
            a, b = self.points[k], self.points[k + 1]
            points.append((a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))
            at.append(lengths[k] + t * (lengths[k + 1] - lengths[k]))
        return points + [self.points[-1]], at + [lengths[-1]]


class Drawing:
    """Named places and curves through them; a curve is a list of places (names) and points."""

    def __init__(self) -> None:
        self.places: dict[str, Point] = {}
        self.curves: dict[str, Sequence[Control]] = {}

    def place(self, name: str, x: float, y: float) -> None:
        """Adds a place."""
        self.places[name] = (x, y)

    def curve(self, name: str, *controls: Control) -> None:
        """Adds a curve through places and points."""
        self.curves[name] = controls

    def position(self, control: Control) -> Point:
        """Returns the point of a place, or the point itself."""
        return self.places[control] if isinstance(control, str) else control

    def scale(self, sx: float, sy: float) -> None:
        """Multiplies all coordinates."""
        self.places = {k: (p[0] * sx, p[1] * sy) for k, p in self.places.items()}
        self.curves = {k: [c if isinstance(c, str) else (c[0] * sx, c[1] * sy) for c in cs]
                       for k, cs in self.curves.items()}

    def dense(self, name: str) -> tuple[list[Point], list[int]]:
        """Returns dense points on a curve, and the index of every control among them."""
        return spline([self.position(c) for c in self.curves[name]])

    def branches(self) -> list[Branch]:
        """Returns the pieces of all curves between named places."""
        found = []
        for name, controls in self.curves.items():
            points, at = self.dense(name)
            named = [(i, c) for i, c in enumerate(controls) if isinstance(c, str)]
            for (i, first), (j, last) in zip(named, named[1:]):
                found.append(Branch(name, first, last, points[at[i]:at[j] + 1]))
        return found

    def mesh(self, edge: float, sweeps: int = 24) -> tuple[list[Point], list[tuple[int, int, int]], dict[str, Chain], dict[str, int]]:
        """Returns a mesh of the region that the curves enclose, with all curves as edges.

        These are points [mm], triangles, and for every curve its point numbers, their arc lengths [mm], and the point numbers of
        the places.
        """
        branches = self.branches()
        size = SizeField(branches, edge)
        points: list[Point] = []
        number: dict[str, int] = {}
        segments: list[tuple[int, int]] = []
        chains: dict[str, Chain] = {name: ([], []) for name in self.curves}
        for name in sorted(self.places):
            if any(name in b.ends for b in branches):
                number[name] = len(points)
                points.append(self.places[name])
        for branch in branches:
            inner, at = branch.divide(size)
            ids = [number[branch.first]]
            for p in inner[1:-1]:
                ids.append(len(points))
                points.append(p)
            ids.append(number[branch.last])
            segments += zip(ids, ids[1:])
            nodes, lengths = chains[branch.curve]
            start = lengths[-1] if lengths else 0.0
            skip = 1 if nodes else 0
            nodes += ids[skip:]
            lengths += [start + s for s in at[skip:]]
        mesh = Triangulation(points, segments)
        mesh.refine(size)
        mesh.smooth(size, sweeps)
        return mesh.points, mesh.triangles(), chains, number


def polygon_area(points: Sequence[Point]) -> float:
    """Returns the area; it is positive if the polygon is counter-clockwise."""
    total = 0.0
    for a, b in zip(points, [*points[1:], *points[:1]]):
        total += a[0] * b[1] - a[1] * b[0]
    return total / 2
