# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes force and torque of a flow on its ellipse.

The pressure along the surface changes as dp/deta = -(a_wall . dr/deta) + nu domega/dxi, and the shear is nu (omega - 2 rate).
Both integrals need only the modes 0 to 2 of the vorticity at the surface and of its slope there. The density is 1.
"""
from __future__ import annotations

import numpy as np

from flusi_msm.flow2d.flow import Flow

SLOPE = np.array([-11.0, 18.0, -9.0, 2.0]) / 6   # of third order


def surface_force(flow: Flow) -> tuple[float, float, float]:
    """Returns the force along the body's x and y on the body, and the torque about its centre."""
    grid, nu, motion = flow.grid, flow.nu, flow.motion
    omega = flow.vorticity[0, :3]
    slope = SLOPE @ flow.vorticity[:4, :3] / grid.step
    a, b = grid.a, grid.b
    fx = grid.area * motion.acceleration[0] + 2 * np.pi * nu * (a * omega[1].imag - b * slope[1].imag)
    fy = grid.area * motion.acceleration[1] + 2 * np.pi * nu * (b * omega[1].real - a * slope[1].real)
    torque = np.pi * nu * (2 * a * b * (omega[0].real - 2 * motion.rate) - grid.focus2 / 2 * slope[2].real)
    return float(fx), float(fy), float(torque)


def impulse(flow: Flow) -> tuple[float, float]:
    """Returns the integral of (y, -x) omega over the fluid, in the axes of the body."""
    grid = flow.grid
    source = grid.times_j(flow.vorticity)[:, 1] * grid.step
    source[0] /= 2
    return float(-4 * np.pi * grid.y1 @ source.imag), float(-4 * np.pi * grid.x1 @ source.real)
