# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves the implicit part of a step in time: (c J - nu (d2/dxi2 - k^2)) omega = right side between the surface and the outer
line.

J couples only the modes k and k +- 2, so that even and odd modes and their real and imaginary parts are four independent systems.
Each of them is symmetric, positive definite and banded, and is factored only once. The change of the no-slip condition that a
vorticity at the surface causes is also computed only once (influence matrix).
"""
from __future__ import annotations

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded, lu_factor, lu_solve

from flusi_msm.flow2d.grid import Grid
from flusi_msm.flow2d.stream import Stream


class Part:
    """The even or odd modes, real or imaginary part."""

    def __init__(self, grid: Grid, is_odd: bool, is_imaginary: bool, rate: float, nu: float, sponge: np.ndarray) -> None:
        self.grid, self.nu, self.is_imaginary = grid, nu, is_imaginary
        k = grid.k[int(is_odd)::2]
        if not is_odd and is_imaginary:
            k = k[1:]   # mode 0 is real
        self.k, rows = k, len(grid.xi) - 2
        self.scale = np.where(k == 0, 0.5, 1.0)   # makes the system symmetric: mode 0 is coupled to mode 2 and its conjugate
        beside = grid.focus2 / 4
        c = (rate + sponge[1:-1])[:, None]
        diagonal = c * grid.sizes[1:-1, None] + nu * (2 / grid.step**2 + k**2)
        if is_odd:
            diagonal[:, 0] += c[:, 0] * beside * (1 if is_imaginary else -1)   # mode 1 is coupled to its own conjugate
        band = np.zeros((len(k) + 1, rows * len(k)))
        band[0] = (diagonal * self.scale).ravel()
        next_mode = np.repeat(-c * beside, len(k), axis=1)
        next_mode[:, -1] = 0
        band[1] = next_mode.ravel()
        band[len(k)] += np.tile(-nu / grid.step**2 * self.scale, rows)
        self.factor = cholesky_banded(band, lower=True, check_finite=False)

    def solve(self, right: np.ndarray, wall: np.ndarray) -> np.ndarray:
        """Returns (rows, modes of the part) for a right side and the values at the surface."""
        right = right.copy()
        right[0] += self.nu / self.grid.step**2 * wall
        flat = cho_solve_banded((self.factor, True), (right * self.scale).ravel(), overwrite_b=True, check_finite=False)
        return flat.reshape(right.shape)

    def of(self, field: np.ndarray) -> np.ndarray:
        """Returns this part of a complex array whose last axis contains all modes."""
        return (field.imag if self.is_imaginary else field.real)[..., self.k]

    def add_to(self, field: np.ndarray, part: np.ndarray) -> None:
        field[..., self.k] += 1j * part if self.is_imaginary else part


class Diffusion:
    """rate: c of the method in time [1/time]; sponge (rows): takes vorticity away, at this rate [1/time]."""

    def __init__(self, grid: Grid, stream: Stream, rate: float, nu: float, sponge: np.ndarray) -> None:
        self.grid, self.stream = grid, stream
        self.parts = [Part(grid, odd, imaginary, rate, nu, sponge) for odd in (False, True) for imaginary in (False, True)]
        self.influence = [lu_factor(self._influence(part)) for part in self.parts]

    def _influence(self, part: Part) -> np.ndarray:
        """Returns the change of the condition of every mode (rows) with every mode at the surface (columns)."""
        matrix = np.zeros((len(part.k), len(part.k)))
        nothing = np.zeros((len(self.grid.xi) - 2, len(part.k)))
        for column in range(len(part.k)):
            wall = np.zeros(len(part.k))
            wall[column] = 1
            field = np.zeros((len(self.grid.xi), len(self.grid.k)), complex)
            inside = np.zeros_like(field[1:-1])
            part.add_to(inside, part.solve(nothing, wall))
            field[1:-1] = inside
            part.add_to(field[:1], wall[None])
            matrix[:, column] = part.of(self.stream.condition(self.grid.times_j(field)))
        return matrix

    def solve(self, right: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """Returns the vorticity (rows, modes) that satisfies the no-slip condition, for a right side between surface and outer
        line."""
        field = np.zeros((len(self.grid.xi), len(self.grid.k)), complex)
        inside = np.zeros_like(field[1:-1])
        for part in self.parts:
            part.add_to(inside, part.solve(part.of(right), np.zeros(len(part.k))))
        field[1:-1] = inside
        missing = wanted - self.stream.condition(self.grid.times_j(field))
        inside[:] = 0
        for part, influence in zip(self.parts, self.influence):
            wall = lu_solve(influence, part.of(missing), check_finite=False)
            part.add_to(inside, part.solve(part.of(right), wall))
            part.add_to(field[:1], wall[None])
        field[1:-1] = inside
        return field
