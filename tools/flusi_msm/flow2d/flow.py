# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the plane flow, from rest, about an ellipse with a given motion in an unbounded fluid.

    J d omega/dt + d(psi_eta omega)/dxi - d(psi_xi omega)/deta = nu (d2/dxi2 + d2/deta2) omega

omega is the vorticity as seen from rest, and psi in the flux is the stream function relative to the body, so that the turning
frame adds no terms. The time steps use backward differences of second order, and the flux is extrapolated. A sponge removes the
vorticity before it leaves through the outer line; its circulation is kept in the condition for the circulation.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flusi_msm.flow2d.diffusion import Diffusion
from flusi_msm.flow2d.grid import Grid, Resolution
from flusi_msm.flow2d.stream import Stream

SPONGE = 0.12       # of the lines
SPONGE_RATE = 1.0   # of its loss at the outer line, in speeds over chords
UNSTABLE = 1e6    # of the largest vorticity that is meaningful


@dataclass
class Motion:
    """Motion of the centre at one time, in the axes of the body, relative to the fluid far away."""
    velocity: tuple[float, float]
    acceleration: tuple[float, float]
    rate: float = 0.0               # of the angle, counter-clockwise
    acceleration_of_angle: float = 0.0


class Flow:
    """State and steps of a flow, in units of a chord of about 1, a speed of about 1 and density 1."""

    def __init__(self, chord: float, ratio: float, nu: float, dt: float, resolution: Resolution = Resolution()) -> None:
        self.grid = Grid(chord, ratio, resolution)
        self.stream = Stream(self.grid)
        self.nu, self.dt = nu, dt
        rows = len(self.grid.xi)
        depth = np.clip((np.arange(rows) / (rows - 1) - 1 + SPONGE) / SPONGE, 0, 1)
        self.sponge = SPONGE_RATE * depth**2
        self.diffusion = Diffusion(self.grid, self.stream, 1.5 / dt, nu, self.sponge)
        shape = rows, len(self.grid.k)
        self.vorticity, self.old = np.zeros(shape, complex), np.zeros(shape, complex)
        self.psi = np.zeros(shape, complex)
        self.flux = np.zeros((rows - 2, len(self.grid.k)), complex)
        self.motion = Motion((0.0, 0.0), (0.0, 0.0))
        self.gone = 0.0     # mean over eta of the circulation that the sponge has removed

    def transport(self) -> np.ndarray:
        """Returns the divergence of the flux between surface and outer line."""
        grid, h = self.grid, self.grid.step
        relative = self.psi.copy()
        relative[:, :3] -= grid.rigid(self.motion.velocity, self.motion.rate)
        slope = np.zeros_like(relative)
        slope[1:-1] = (self.psi[2:] - self.psi[:-2]) / (2 * h)
        slope[:, :3] -= grid.rigid_slope(self.motion.velocity, self.motion.rate)
        omega = grid.to_points(self.vorticity)
        along = grid.to_points(1j * grid.k * relative) * omega
        across = grid.to_modes(grid.to_points(slope[1:-1]) * omega[1:-1])
        return grid.to_modes((along[2:] - along[:-2]) / (2 * h)) - 1j * grid.k * across

    def step(self, motion: Motion) -> None:
        """Makes one step of time; motion is that at its end."""
        grid = self.grid
        flux = self.transport()
        change = (4 * self.vorticity - self.old) / (2 * self.dt)
        right = grid.times_j(change)[1:-1] - 2 * flux + self.flux
        self.flux = flux
        value, slope = np.zeros(len(grid.k), complex), np.zeros(len(grid.k), complex)
        value[:3] = grid.rigid(motion.velocity, motion.rate, slice(0, 1))[0]
        slope[:3] = grid.rigid_slope(motion.velocity, motion.rate, slice(0, 1))[0]
        wanted = self.stream.wanted(value, slope)
        wanted[0] = slope[0] - self.gone
        self.old, self.vorticity = self.vorticity, self.diffusion.solve(right, wanted)
        source = grid.times_j(self.vorticity)
        self.gone += self.dt * grid.step * float(np.sum(self.sponge * source[:, 0].real))
        self.psi = self.stream.solve(source, value, self.gone)
        self.motion = motion
        if not np.abs(self.vorticity).max() < UNSTABLE / self.dt:
            raise ArithmeticError("the flow is not resolved: take smaller steps")
