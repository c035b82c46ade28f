# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangulates a plane region along given curves, with triangles of a given size and good shape.

The method is a constrained Delaunay triangulation of the points on the curves (Bowyer-Watson insertion, flips for missing
segments), then refinement at circumcentres where triangles are larger than the size wanted, then smoothing of the free points
with Delaunay flips in between.

Only + - * / and square roots of Python floats are used, in a fixed order: the result is the same to the last
bit on every machine with IEEE arithmetic.
"""
from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence
from math import sqrt
from typing import Callable

Point = tuple[float, float]
Edge = tuple[int, int]
Corners = tuple[int, int, int]
Size = Callable[[Point], float]   # the edge length wanted at a point
LARGEST_RADIUS = 0.75  # of a circumcircle by the edge length wanted; 0.577 is the equilateral triangle


def ordered(a: int, b: int) -> Edge:
    """Returns the edge with its smaller point first."""
    return (a, b) if a < b else (b, a)


def orientation(a: Point, b: Point, c: Point) -> float:
    """Returns twice the area of the triangle a b c, positive if counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def distance(a: Point, b: Point) -> float:
    """Returns the distance of two points."""
    return sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]))


def in_circle(a: Point, b: Point, c: Point, p: Point) -> float:
    """Returns a number that is positive if p lies inside the circle through the counter-clockwise triangle a b c."""
    ax, ay, bx, by, cx, cy = a[0] - p[0], a[1] - p[1], b[0] - p[0], b[1] - p[1], c[0] - p[0], c[1] - p[1]
    return ((ax * ax + ay * ay) * (bx * cy - cx * by) - (bx * bx + by * by) * (ax * cy - cx * ay)
            + (cx * cx + cy * cy) * (ax * by - bx * ay))


def circumcentre(a: Point, b: Point, c: Point) -> Point:
    """Returns the centre of the circle through three points."""
    bx, by, cx, cy = b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]
    d = 2 * (bx * cy - by * cx)
    bb, cc = bx * bx + by * by, cx * cx + cy * cy
    return a[0] + (cy * bb - by * cc) / d, a[1] + (bx * cc - cx * bb) / d


def shape(a: Point, b: Point, c: Point) -> float:
    """Returns the quality of a triangle: 1 if equilateral, 0 if flat, negative if inverted."""
    edges = ((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1])
             + (c[0] - b[0]) * (c[0] - b[0]) + (c[1] - b[1]) * (c[1] - b[1])
             + (a[0] - c[0]) * (a[0] - c[0]) + (a[1] - c[1]) * (a[1] - c[1]))
    return 2 * sqrt(3.0) * orientation(a, b, c) / edges


class Triangulation:
    """`across[a, b]` is the third corner of the triangle on the left of the directed edge a -> b."""

    def __init__(self, points: Iterable[Sequence[float]], segments: Iterable[Sequence[int]]) -> None:
        self.points: list[Point] = [(p[0], p[1]) for p in points]
        self.fixed = len(self.points)
        self.across: dict[Edge, int] = {}
        self.segments = {ordered(a, b) for a, b in segments}
        self.crossable = True
        xs, ys = [p[0] for p in self.points], [p[1] for p in self.points]
        size, x, y = max(max(xs) - min(xs), max(ys) - min(ys)), min(xs), min(ys)
        corners = len(self.points)
        self.points += [(x - 20 * size, y - 10 * size), (x + 20 * size, y - 10 * size), (x, y + 30 * size)]
        self.add(corners, corners + 1, corners + 2)
        for i in range(self.fixed):
            self.insert(i)
        done: set[Edge] = set()
        for a, b in sorted(self.segments):
            self.recover(a, b, done)
            done.add((a, b))
        self.crossable = False
        self.cut_outside(corners)
        del self.points[self.fixed:]

    def add(self, a: int, b: int, c: int) -> None:
        """Adds a triangle."""
        self.across[a, b], self.across[b, c], self.across[c, a] = c, a, b

    def remove(self, a: int, b: int, c: int) -> None:
        """Removes a triangle."""
        del self.across[a, b], self.across[b, c], self.across[c, a]

    def triangles(self) -> list[Corners]:
        """Returns all triangles, smallest corner first, sorted."""
        return sorted((a, b, c) for (a, b), c in self.across.items() if a < b and a < c)

    def locate(self, p: Point, start: Edge | None = None) -> Corners | None:
        """Returns a triangle that contains p, by going from neighbour to neighbour, at first that at the edge `start`; None if the path leaves the region."""
        a, b = start or next(iter(self.across))
        c = self.across[a, b]
        for _ in range(len(self.across)):
            for u, v in ((a, b), (b, c), (c, a)):
                if orientation(self.points[u], self.points[v], p) < 0:
                    w = self.across.get((v, u))
                    if w is None:
                        return None
                    a, b, c = v, u, w
                    break
            else:
                return a, b, c
        return None

    def insert(self, i: int, triangle: Corners | None = None) -> list[Corners]:
        """Inserts point i by replacing the triangles whose circles contain it; returns the new ones."""
        triangle = triangle or self.locate(self.points[i])
        if triangle is None:
            raise ValueError(f"point {i} lies outside")
        self.remove(*triangle)
        a, b, c = triangle
        stack, made = [(a, b), (b, c), (c, a)], []
        while stack:
            u, v = stack.pop()
            w = self.across.get((v, u))
            blocked = not self.crossable and ordered(u, v) in self.segments
            if w is None or blocked or in_circle(self.points[v], self.points[u], self.points[w], self.points[i]) <= 0:
                self.add(u, v, i)
                made.append((u, v, i))
            else:
                self.remove(v, u, w)
                stack += [(u, w), (w, v)]
        return made

    def recover(self, a: int, b: int, done: set[Edge]) -> None:
        """Makes a-b an edge by flipping the edges that cross it, none of which may be in `done`."""
        p, q = self.points[a], self.points[b]
        waiting = self.crossing(a, b)
        for u, v in waiting:
            if ordered(u, v) in done:
                raise ValueError(f"segment {a}-{b} crosses segment {u}-{v}")
        for _ in range(20 * len(waiting) + 20):
            if not waiting:
                return
            u, v = waiting.pop(0)
            w, x = self.across[u, v], self.across[v, u]
            if orientation(self.points[x], self.points[v], self.points[w]) <= 0 \
                    or orientation(self.points[w], self.points[u], self.points[x]) <= 0:
                waiting.append((u, v))
                continue
            self.flip(u, v)
            sides = [orientation(p, q, self.points[k]) for k in (w, x)]
            if w not in (a, b) and x not in (a, b) and sides[0] * sides[1] < 0:
                waiting.append((w, x))
        raise ValueError(f"segment {a}-{b} cannot be made an edge")

    def crossing(self, a: int, b: int) -> list[Edge]:
        """Returns the edges between a and b in the order in which the segment crosses them."""
        if (a, b) in self.across or (b, a) in self.across:
            return []
        p, q = self.points[a], self.points[b]
        for (u, v), w in self.across.items():
            if w == a and orientation(p, q, self.points[u]) < 0 < orientation(p, q, self.points[v]):
                break
        else:
            raise ValueError(f"segment {a}-{b} passes through a point")
        found = []
        while True:
            found.append((u, v))
            w = self.across[v, u]
            if w == b:
                return found
            side = orientation(p, q, self.points[w])
            if side == 0:
                raise ValueError(f"segment {a}-{b} passes through point {w}")
            u, v = (u, w) if side > 0 else (w, v)

    def flip(self, u: int, v: int) -> None:
        """Replaces edge u-v by the other diagonal of its quadrilateral."""
        w, x = self.across[u, v], self.across[v, u]
        self.remove(u, v, w)
        self.remove(v, u, x)
        self.add(w, u, x)
        self.add(x, v, w)

    def cut_outside(self, corner: int) -> None:
        """Removes what can be reached from a corner of the enclosing triangle without crossing a segment."""
        stack = [next((a, b, c) for (a, b), c in self.across.items() if corner in (a, b, c))]
        while stack:
            a, b, c = stack.pop()
            if self.across.get((a, b)) != c:
                continue
            self.remove(a, b, c)
            for u, v in ((a, b), (b, c), (c, a)):
                if (v, u) in self.across and ordered(u, v) not in self.segments:
                    stack.append((v, u, self.across[v, u]))

    def make_delaunay(self) -> None:
        """Flips edges until every one that may be flipped is a Delaunay edge."""
        stack = sorted(e for e in self.across if e[0] < e[1])
        while stack:
            u, v = stack.pop()
            w, x = self.across.get((u, v)), self.across.get((v, u))
            if w is None or x is None or ordered(u, v) in self.segments:
                continue
            quad = [self.points[k] for k in (u, v, w, x)]
            scale = distance(quad[0], quad[1])
            scale = scale * scale
            if in_circle(quad[0], quad[1], quad[2], quad[3]) <= 1e-9 * scale * scale:
                continue
            if orientation(quad[3], quad[1], quad[2]) <= 0 or orientation(quad[2], quad[0], quad[3]) <= 0:
                continue
            self.flip(u, v)
            stack += [ordered(*e) for e in ((u, x), (x, v), (v, w), (w, u))]

    def refine(self, size: Size) -> None:
        """Inserts circumcentres while a triangle is too large; size(p) is the edge length wanted at p."""
        nearby = self.segment_finder(size)
        heap: list[tuple[float, Corners, Point]] = []

        def push(triangle: Corners) -> None:
            a, b, c = (self.points[k] for k in triangle)
            centre = circumcentre(a, b, c)
            middle = ((a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3)
            excess = distance(centre, a) / size(middle)
            if excess > LARGEST_RADIUS:
                heapq.heappush(heap, (-excess, triangle, centre))

        for triangle in self.triangles():
            push(triangle)
        while heap:
            _, (a, b, c), centre = heapq.heappop(heap)
            if self.across.get((a, b)) != c:
                continue
            place = self.locate(centre, (a, b))
            if place is None or nearby(centre, 0.5 * size(centre)):
                continue
            new = len(self.points)
            self.points.append(centre)
            for triangle in self.insert(new, place):
                push(triangle)

    def segment_finder(self, size: Size) -> Callable[[Point, float], bool]:
        """Returns a function that says whether a point is closer to a segment than some limit <= cell."""
        cell = max(size(p) for p in self.points[:self.fixed])
        table: dict[tuple[int, int], list[tuple[Point, Point]]] = {}
        for u, v in sorted(self.segments):
            a, b = self.points[u], self.points[v]
            spans = [range(int(min(a[k], b[k]) / cell + 1000) - 1, int(max(a[k], b[k]) / cell + 1000) + 2)
                     for k in (0, 1)]
            for i in spans[0]:
                for j in spans[1]:
                    table.setdefault((i, j), []).append((a, b))

        def is_near(p: Point, limit: float) -> bool:
            for a, b in table.get((int(p[0] / cell + 1000), int(p[1] / cell + 1000)), ()):
                ex, ey = b[0] - a[0], b[1] - a[1]
                t = ((p[0] - a[0]) * ex + (p[1] - a[1]) * ey) / (ex * ex + ey * ey)
                t = min(1.0, max(0.0, t))
                if distance(p, (a[0] + t * ex, a[1] + t * ey)) < limit:
                    return True
            return False

        return is_near

    def smooth(self, size: Size, sweeps: int) -> None:
        """Moves the free points to better places, with Delaunay flips between the sweeps."""
        for _ in range(sweeps):
            self.make_delaunay()
            stars: dict[int, list[Edge]] = {}
            for a, b, c in self.triangles():
                for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
                    stars.setdefault(i, []).append((j, k))
            for i in range(self.fixed, len(self.points)):
                self.move(i, stars[i], size)
        self.make_delaunay()

    def move(self, i: int, star: Sequence[Edge], size: Size) -> None:
        """Moves a point to a mean over its triangles, weighted by area and by the density wanted, if their shapes allow it."""
        x = y = total = 0.0
        p = self.points[i]
        for j, k in star:
            a, b = self.points[j], self.points[k]
            centre = circumcentre(p, a, b)
            middle = ((p[0] + a[0] + b[0]) / 3, (p[1] + a[1] + b[1]) / 3)
            h = size(middle)
            weight = orientation(p, a, b) / (h * h * h * h)
            # The mean is that of points between circumcentre and centroid, which is robust near the curves.
            x += weight * (0.5 * centre[0] + 0.5 * middle[0])
            y += weight * (0.5 * centre[1] + 0.5 * middle[1])
            total += weight
        new = (x / total, y / total)
        old_worst = min(shape(p, self.points[j], self.points[k]) for j, k in star)
        for step in (1.0, 0.5, 0.25):
            q = (p[0] + step * (new[0] - p[0]), p[1] + step * (new[1] - p[1]))
            worst = min(shape(q, self.points[j], self.points[k]) for j, k in star)
            if worst > min(0.6, old_worst):
                self.points[i] = q
                return
