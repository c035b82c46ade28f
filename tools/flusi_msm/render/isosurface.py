# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes iso-surfaces of a field on a regular grid by marching tetrahedra: every cell is divided into six tetrahedra around
its diagonal, so that the surface is closed and needs no table of ambiguous cases."""
from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np


def _tetrahedra() -> np.ndarray:
    """Returns (6, 4, 3): corners of the tetrahedra as steps (x, y, z) along the edges from 000 to 111."""
    paths = []
    for order in permutations(range(3)):
        corner, path = [0, 0, 0], [[0, 0, 0]]
        for axis in order:
            corner[axis] = 1
            path.append(list(corner))
        paths.append(path)
    return np.array(paths)


Triangle = tuple[tuple[int, int], tuple[int, int], tuple[int, int]]  # its corners, each on an edge between two corners of the tetrahedron
TETRAHEDRA = _tetrahedra()
# Triangles of a tetrahedron, by the set of its corners that are above the level (bit i: corner i), as pairs of corners whose edge
# is cut. If one corner is on another side than the others there is one triangle, otherwise there are two.
ONE: dict[int, list[Triangle]] = {0: [((0, 1), (0, 2), (0, 3))], 1: [((1, 0), (1, 2), (1, 3))], 2: [((2, 0), (2, 1), (2, 3))],
       3: [((3, 0), (3, 1), (3, 2))]}


def _cases() -> dict[int, list[Triangle]]:
    cases = {}
    for bits in range(1, 15):
        above = [i for i in range(4) if bits >> i & 1]
        below = [i for i in range(4) if i not in above]
        if len(above) == 1:
            cases[bits] = ONE[above[0]]
        elif len(below) == 1:
            cases[bits] = ONE[below[0]]
        else:
            (a, b), (c, d) = above, below
            cases[bits] = [((a, c), (a, d), (b, d)), ((a, c), (b, d), (b, c))]
    return cases


CASES = _cases()


def iso_surface(values: np.ndarray, level: float, origin: Sequence[float] | np.ndarray,
                spacing: Sequence[float] | np.ndarray) \
        -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns (points (n, 3), triangles (m, 3), normals (n, 3)) of values (z, y, x) = level. Normals point to smaller values,
    and the triangles are counter-clockwise seen from there. Triangles share their common points."""
    first, step = np.asarray(origin, dtype=float), np.asarray(spacing, dtype=float)
    nz, ny, nx = values.shape
    if min(values.shape) < 2:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=int), np.zeros((0, 3))
    above = values > level
    count = sum((above[k:nz - 1 + k, j:ny - 1 + j, i:nx - 1 + i].astype("u1") for i, j, k in np.ndindex(2, 2, 2)), np.zeros((), "u1"))
    k, j, i = np.nonzero((count > 0) & (count < 8))
    cells = np.column_stack([i, j, k])
    strides = np.array([1, nx, nx * ny])
    flat, flat_above = values.reshape(-1), above.reshape(-1)
    cuts: list[np.ndarray] = []  # (inner and outer grid point) of the corners of triangles
    for tetrahedron in TETRAHEDRA:
        corners = cells @ strides + (tetrahedron @ strides)[:, None]  # (4, cells)
        bits = sum(flat_above[corner].astype("u1") << n for n, corner in enumerate(corners))
        for case, cut in CASES.items():
            found = np.flatnonzero(bits == case)
            for triangle in cut if len(found) else ():
                cuts.append(np.stack([np.sort(corners[list(edge)][:, found], axis=0).T for edge in triangle], axis=1))
    if not cuts:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=int), np.zeros((0, 3))
    edges = np.concatenate(cuts).astype(np.int64)  # (m, 3, 2)
    keys, number = np.unique(edges[..., 0] * values.size + edges[..., 1], return_inverse=True)
    triangles = number.reshape(-1, 3)
    ends = np.stack([keys // values.size, keys % values.size])
    v = flat[ends].astype(float)
    s = ((level - v[0]) / (v[1] - v[0]))[:, None]
    place = np.stack([ends % nx, ends // nx % ny, ends // (nx * ny)], axis=-1).astype(float)
    points = first + step * ((1 - s) * place[0] + s * place[1])
    slopes = _gradient(values, ends, place.astype(int), step)
    normals = -((1 - s) * slopes[0] + s * slopes[1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    a, b, c = (points[triangles[:, n]] for n in range(3))
    face = np.cross(b - a, c - a)
    turned = np.einsum("ij,ij->i", face, normals[triangles].sum(axis=1)) < 0
    triangles[turned] = triangles[turned][:, ::-1]
    return points, triangles[np.linalg.norm(face, axis=1) > 0], normals


def _gradient(values: np.ndarray, ends: np.ndarray, place: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """Returns central differences, one-sided at the faces of the box, at the grid points `ends`."""
    flat = values.reshape(-1)
    n = values.shape[::-1]
    strides = (1, n[0], n[0] * n[1])
    slopes = np.empty((*ends.shape, 3))
    for axis in range(3):
        up = np.minimum(place[..., axis] + 1, n[axis] - 1) - place[..., axis]
        down = place[..., axis] - np.maximum(place[..., axis] - 1, 0)
        rise = flat[ends + up * strides[axis]].astype(float) - flat[ends - down * strides[axis]]
        slopes[..., axis] = rise / ((up + down) * spacing[axis])
    return slopes


def area(points: np.ndarray, triangles: np.ndarray) -> float:
    """Returns the area of a surface."""
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return float(np.sum(np.linalg.norm(np.cross(b - a, c - a), axis=1)) / 2)
