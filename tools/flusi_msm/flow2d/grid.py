# SPDX-License-Identifier: GPL-3.0-or-later
"""Elliptic coordinates about an ellipse: x + i y = f cosh(xi + i eta), the surface at xi = xi0.

The map is conformal, with |dz/dzeta|^2 = J = f^2/2 (cosh 2 xi - cos 2 eta), so that the Laplacian is that of the plane (xi, eta)
divided by J. A field is a complex array (radial + 1, modes): rows are lines of constant xi from the surface outward, columns are
Fourier modes exp(i k eta), k = 0 .. modes - 1. The field is real, so that modes with negative k are the conjugates.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft


@dataclass(frozen=True)
class Resolution:
    """How finely the flow is resolved."""
    modes: int = 64          # Fourier modes around the body
    radial: int = 110        # intervals from the surface outward
    radius: float = 15.0     # of the outer boundary, in chords


class Grid:
    """The lines of the grid about an ellipse of length chord and thickness ratio*chord, around its centre, with its length along
    x."""

    def __init__(self, chord: float, ratio: float, resolution: Resolution) -> None:
        if not 0 < ratio < 1:
            raise ValueError("the thickness of an ellipse is above 0 and below its length")
        self.a, self.b = chord / 2, ratio * chord / 2
        self.focus2 = self.a**2 - self.b**2
        inner, outer = np.arctanh(ratio), np.arccosh(resolution.radius * chord / np.sqrt(self.focus2))
        self.xi = np.linspace(inner, outer, resolution.radial + 1)
        self.step = float(self.xi[1] - self.xi[0])
        self.k = np.arange(resolution.modes)
        self.points = 3 * resolution.modes   # so many that products of two fields are exact in all modes
        self.sizes = self.focus2 / 2 * np.cosh(2 * self.xi)
        self.x1 = np.sqrt(self.focus2) * np.cosh(self.xi) / 2        # x = 2 x1 cos eta, y = 2 y1 sin eta
        self.y1 = np.sqrt(self.focus2) * np.sinh(self.xi) / 2

    @property
    def area(self) -> float:
        return float(np.pi * self.a * self.b)

    def times_j(self, field: np.ndarray) -> np.ndarray:
        """Returns J times a field, in the modes that are kept."""
        out = self.sizes[:, None] * field
        quarter = self.focus2 / 4
        out[:, 2:] -= quarter * field[:, :-2]
        out[:, :-2] -= quarter * field[:, 2:]
        out[:, 0] -= quarter * np.conj(field[:, 2])
        out[:, 1] -= quarter * np.conj(field[:, 1])
        return out

    def to_points(self, field: np.ndarray) -> np.ndarray:
        """Returns values at equally spaced eta."""
        return fft.irfft(field, self.points, axis=1) * self.points

    def to_modes(self, values: np.ndarray) -> np.ndarray:
        return fft.rfft(values, axis=1)[:, :len(self.k)] / self.points

    def rigid(self, velocity: tuple[float, float], rate: float, rows: slice = slice(None)) -> np.ndarray:
        """Returns modes 0, 1, 2 (rows, 3) of the stream function of a solid that moves and turns about its centre: u y - v x -
        rate (x^2 + y^2)/2."""
        u, v = velocity
        modes = np.zeros((len(self.xi[rows]), 3), complex)
        modes[:, 0] = -rate / 2 * self.sizes[rows]
        modes[:, 1] = -1j * u * self.y1[rows] - v * self.x1[rows]
        modes[:, 2] = -rate * self.focus2 / 8
        return modes

    def rigid_slope(self, velocity: tuple[float, float], rate: float, rows: slice = slice(None)) -> np.ndarray:
        """Returns the derivative of this stream function along xi."""
        u, v = velocity
        modes = np.zeros((len(self.xi[rows]), 3), complex)
        modes[:, 0] = -rate / 2 * self.focus2 * np.sinh(2 * self.xi[rows])
        modes[:, 1] = -1j * u * self.x1[rows] - v * self.y1[rows]
        return modes
