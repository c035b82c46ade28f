# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the stream function of a vorticity outside an ellipse, and the condition on this vorticity that follows from no slip.

Every mode obeys psi'' - k^2 psi = -(J omega)_k =: -s with second differences. Beyond the outer line there is no vorticity, so
that psi falls as r^i there; r is the decaying root of the differences. The value and the slope of psi at the surface are both
given. Both are possible only if
    h (s_0/2 + sum_i r^i s_i) = psi'(0) + (1 + k^2 h^2/2 - r)/h psi(0),
which is the discrete form of the integral of s exp(-k xi) (Quartapelle 1981). It is one condition for each mode of the vorticity
at the surface. For k = 0 it determines the circulation, and the value at the surface is free.
"""
from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from flusi_msm.flow2d.grid import Grid


class Stream:
    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        h, k, rows = grid.step, grid.k, len(grid.xi)
        half = 1 + (k * h)**2 / 2
        self.root = half - np.sqrt(half**2 - 1)
        self.weights = h * self.root[None, :]**np.arange(rows)[:, None]
        self.weights[0] *= 0.5
        self.of_value = (half - self.root) / h
        diagonal = np.repeat(2 * half, rows - 1).reshape(len(k), rows - 1)
        diagonal[:, -1] -= self.root
        beside = -np.ones((len(k), rows - 1))
        beside[:, -1] = 0
        self.factors = lapack.dpttrf(diagonal.ravel(), beside.ravel()[:-1])[:2]

    def condition(self, source: np.ndarray) -> np.ndarray:
        """Returns the left side of the condition, for s (rows, modes)."""
        return np.einsum("ik,ik->k", self.weights, source)

    def wanted(self, value: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Returns the right side, for modes of value and slope at the surface; the flow has no slope of mode 0 far outside."""
        return slope + self.of_value * value

    def solve(self, source: np.ndarray, value: np.ndarray, slope_outside: float = 0.0) -> np.ndarray:
        """Returns psi (rows, modes) with the given value at the surface."""
        h = self.grid.step
        right = h**2 * source[1:].T
        right[:, 0] += value
        right[0, -1] += h * slope_outside
        shape = right.shape
        parts = np.stack([right.real.ravel(), right.imag.ravel()], 1)
        found, _ = lapack.dpttrs(*self.factors, parts)
        psi = np.empty_like(source)
        psi[0] = value
        psi[1:] = (found[:, 0] + 1j * found[:, 1]).reshape(shape).T
        return psi
