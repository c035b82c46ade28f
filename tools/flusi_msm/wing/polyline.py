# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of straight pieces in the plane: arc length, nearest points, crossings, and the points inside."""
from __future__ import annotations

import numpy as np


class Polyline:
    """A line through points (n, 2); a closed one continues from its last point to its first. `s` is the arc length from the
    first point."""

    def __init__(self, points: np.ndarray, closed: bool = False) -> None:
        points = np.asarray(points, float)
        self.closed = closed
        self.corners = np.concatenate([points, points[:1]]) if closed else points
        self.steps = np.linalg.norm(np.diff(self.corners, axis=0), axis=1)
        self.s = np.concatenate([[0.0], np.cumsum(self.steps)])
        self.length = float(self.s[-1])

    def at(self, s: float) -> np.ndarray:
        """Returns the point at arc length `s`; beyond the ends of an open line its end."""
        s = s % self.length if self.closed else min(max(s, 0.0), self.length)
        return np.array([np.interp(s, self.s, self.corners[:, k]) for k in (0, 1)])

    def cosine(self, s: float, reach: float) -> float:
        """Returns the cosine of the angle by which the line turns at `s`, measured over `reach` before and after."""
        before, after = self.at(s) - self.at(s - reach), self.at(s + reach) - self.at(s)
        size = float(np.linalg.norm(before) * np.linalg.norm(after))
        return float(before @ after) / size if size > 0 else 1.0

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the distance (m,) and arc length (m,) of the nearest points of the line to `points` (m, 2)."""
        points = np.atleast_2d(points)
        a, along = self.corners[:-1], np.diff(self.corners, axis=0)
        square = np.maximum((along**2).sum(1), 1e-300)
        best, place = np.full(len(points), np.inf), np.zeros(len(points))
        for first in range(0, len(points), 256):   # bounds the memory
            p = points[first:first + 256]
            t = np.clip(((p[:, None] - a) * along).sum(2) / square, 0, 1)
            distance = np.linalg.norm(p[:, None] - (a + t[..., None] * along), axis=2)
            k = distance.argmin(1)
            rows = np.arange(len(p))
            best[first:first + 256] = distance[rows, k]
            place[first:first + 256] = self.s[k] + t[rows, k] * self.steps[k]
        return best, place

    def piece(self, s0: float, s1: float) -> np.ndarray:
        """Returns the points from `s0` to `s1`, both ends included; on a closed line always forward."""
        if self.closed and s1 <= s0:
            s1 += self.length
        knots = np.concatenate([self.s[:-1], self.s[:-1] + self.length]) if self.closed else self.s
        corners = np.concatenate([self.corners[:-1], self.corners[:-1]]) if self.closed else self.corners
        eps = 1e-12 * self.length
        inner = (knots > s0 + eps) & (knots < s1 - eps)
        return np.concatenate([[self.at(s0)], corners[inner], [self.at(s1)]])

    def samples(self, spacing: float) -> tuple[np.ndarray, np.ndarray]:
        """Returns all corners and points between them at most `spacing` apart, and their arc lengths."""
        s = np.concatenate([np.linspace(a, b, max(1, int(np.ceil((b - a) / spacing))) + 1)[:-1]
                            for a, b in zip(self.s, self.s[1:])] + [self.s[-1:]])
        return np.stack([np.interp(s, self.s, self.corners[:, k]) for k in (0, 1)], axis=1), s

    def crossings(self, other: "Polyline") -> list[tuple[float, float]]:
        """Returns arc lengths (on this line, on the other) where the lines cross, touch included, in the order of this line."""
        a, u = self.corners[:-1], np.diff(self.corners, axis=0)
        b, v = other.corners[:-1], np.diff(other.corners, axis=0)
        low_a, high_a = np.minimum(a, a + u), np.maximum(a, a + u)
        low_b, high_b = np.minimum(b, b + v), np.maximum(b, b + v)
        near = ((low_a[:, None] <= high_b) & (low_b <= high_a[:, None])).all(2)
        i, j = np.nonzero(near)
        if not len(i):
            return []
        det = u[i, 0] * v[j, 1] - u[i, 1] * v[j, 0]
        w = b[j] - a[i]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (w[:, 0] * v[j, 1] - w[:, 1] * v[j, 0]) / det
            r = (w[:, 0] * u[i, 1] - w[:, 1] * u[i, 0]) / det
        eps = 1e-9
        hit = np.isfinite(t) & np.isfinite(r) & (t >= -eps) & (t <= 1 + eps) & (r >= -eps) & (r <= 1 + eps)
        found = sorted(zip(self.s[i[hit]] + np.clip(t[hit], 0, 1) * self.steps[i[hit]],
                           other.s[j[hit]] + np.clip(r[hit], 0, 1) * other.steps[j[hit]]))
        return [(float(p), float(q)) for k, (p, q) in enumerate(found)
                if k == 0 or abs(p - found[k - 1][0]) > 1e-9 * self.length]

    def crosses_itself(self) -> list[np.ndarray]:
        """Returns places where pieces cross that are not neighbours."""
        found, n = [], len(self.steps)
        a, u = self.corners[:-1], np.diff(self.corners, axis=0)
        low, high = np.minimum(a, a + u), np.maximum(a, a + u)
        i, j = np.nonzero(np.triu(((low[:, None] <= high) & (low <= high[:, None])).all(2), 2))
        for p, q in zip(i, j):
            if self.closed and p == 0 and q == n - 1:
                continue
            det = u[p, 0] * u[q, 1] - u[p, 1] * u[q, 0]
            if det == 0:
                continue
            w = a[q] - a[p]
            t, r = (w[0] * u[q, 1] - w[1] * u[q, 0]) / det, (w[0] * u[p, 1] - w[1] * u[p, 0]) / det
            if 0 <= t <= 1 and 0 <= r <= 1:
                found.append(a[p] + t * u[p])
        return found

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Returns whether points (m, 2) lie inside the closed line."""
        points = np.atleast_2d(points)
        a, b = self.corners[:-1], self.corners[1:]
        x, y = points[:, :1], points[:, 1:]
        spans = (a[:, 1] > y) != (b[:, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            cut = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        return (spans & (x < cut)).sum(1) % 2 == 1


def runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """Returns the first and last index of every run of True, in order."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(flags).astype(int), [0]])))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2])]
