# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulates a profilometer above a deformed wing, which measures the upper surface at the points of a regular grid."""
from __future__ import annotations

import numpy as np


def scan(positions: np.ndarray, triangles: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Returns the heights (ny, nx) [m] of the surface of triangles over the grid lines x, y, NaN outside the wing. Where the
    surface is folded over itself the upper sheet is measured; vertical triangles are ignored."""
    return look(positions, triangles, x, y)[0]


def look(positions: np.ndarray, triangles: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the same heights, and the number of the triangle that is seen (ny, nx), -1 outside the wing."""
    heights, seen = np.full((len(y), len(x)), -np.inf), np.full((len(y), len(x)), -1)
    corners = positions[triangles]                       # (m, 3, 3)
    low, high = corners[:, :, :2].min(1), corners[:, :, :2].max(1)
    slack = 1e-12 * np.ptp(positions, axis=0).max()
    i0, i1 = np.searchsorted(x, low[:, 0] - slack), np.searchsorted(x, high[:, 0] + slack, "right")
    j0, j1 = np.searchsorted(y, low[:, 1] - slack), np.searchsorted(y, high[:, 1] + slack, "right")
    a = corners[:, 0]
    e, f = corners[:, 1] - a, corners[:, 2] - a
    normal = np.cross(e, f)
    for t in np.flatnonzero((i1 > i0) & (j1 > j0)):
        nx, ny, nz = normal[t]
        if abs(nz) <= 1e-9 * np.sqrt(nx * nx + ny * ny + nz * nz):
            continue
        gx, gy = x[i0[t]:i1[t]][None, :] - a[t, 0], y[j0[t]:j1[t]][:, None] - a[t, 1]
        one = (gx * f[t, 1] - gy * f[t, 0]) / nz
        two = (gy * e[t, 0] - gx * e[t, 1]) / nz
        inside = (one >= -1e-9) & (two >= -1e-9) & (one + two <= 1 + 1e-9)
        z = a[t, 2] - (nx * gx + ny * gy) / nz
        part = heights[j0[t]:j1[t], i0[t]:i1[t]]
        higher = inside & (z > part)
        part[higher] = z[higher]
        seen[j0[t]:j1[t], i0[t]:i1[t]][higher] = t
    return np.where(seen >= 0, heights, np.nan), seen
