#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes by how many grid spacings the markers of a surface without thickness act as a wider surface, as a function of the thickness of
the boundary layer. docs/theory/thin-wings-derivation.md has the equations and the table.

A strip moves normal to itself in a plane unsteady Stokes flow, nu (k^2 + 1/layer^2) u = force. Its markers meet the flow through the
filter and the band limit of the program; the exact strip does so at all points. The margin is the one with which the exact strip has the
force of the markers. A thin layer gives the added mass, a thick one the drag of a creeping flow.

usage: edge_margin.py          prints the tables
"""
import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.special import j0, j1, k0, k1

EULER = 0.5772156649015329
NODES, WEIGHTS = np.polynomial.legendre.leggauss(400)


def regular(z):
    """Returns 2 pi times the normal velocity at the distance z layers from a unit force, plus ln(z)/2, which is smooth."""
    far = np.maximum(z, 0.05)
    log = np.log(np.maximum(z, 1e-300) / 2) + EULER
    # K0(z) + K1(z)/z - 1/z^2 and its series
    near = z**2 / 4 * (1 - log) - log / 2 - 0.25 + z**2 / 16 * (log - 1.25) + np.log(np.maximum(z, 1e-300)) / 2
    return np.where(z < 0.05, near, k0(far) + k1(far) / far - 1 / far**2 + np.log(far) / 2)


def exact_force(width, cells=360):
    """Returns the force on a strip over viscosity and speed; `width` is in layers. The force per length times sin(theta), with
    x = cos(theta)/2 in widths, is smooth: a sum of cosines, at the middles of equal cells."""
    theta = (np.arange(cells) + 0.5) * math.pi / cells
    x = np.cos(theta) / 2
    smooth = regular(width * np.abs(x[:, None] - x[None, :])) - math.log(width / 2) / 2
    n = np.arange(cells)
    waves = np.cos(np.outer(theta, n))
    back = 2 * waves.T / cells
    back[0] /= 2
    # integral of ln|cos theta - cos theta'| cos(n theta') over theta'
    logs = -math.pi * np.where(n == 0, math.log(2), 1 / np.maximum(n, 1))
    kernel = smooth * math.pi / cells - (waves * logs) @ back / 2
    return float(np.linalg.solve(kernel, np.full(cells, 2 * math.pi)).sum() * math.pi / cells)


def marker_force(points, gaps, layer, diffusion=0.0, inset=0.0):
    """Returns the force on the markers of a strip with `points` spacings of the grid and `gaps` between markers. `layer` is in
    spacings, `diffusion` = nu dt/dx^2 is that of a step: the flow decays in it before it gets the forces. The last markers are `inset`
    spacings inside the edges."""
    band = 2 * math.pi / 3
    k, weight = band * (NODES + 1) / 2, band / 2 * WEIGHTS
    rate = k**2 + 1 / layer**2
    response = diffusion / -np.expm1(-diffusion * rate) if diffusion else 1 / rate
    places = np.linspace(inset, points - inset, gaps + 1)
    z = k * np.abs(places[:, None] - places[None, :])[:, :, None]
    across = np.where(z < 1e-6, 0.5, j0(z) - j1(np.maximum(z, 1e-6)) / np.maximum(z, 1e-6))
    velocity = (across * (weight * (1 + (k / band)**2) * k * response)).sum(2) / (2 * math.pi)
    return float(np.linalg.solve(velocity, np.ones(gaps + 1)).sum())


WIDTHS = np.geomspace(0.1, 60, 60)  # in layers
FORCE = CubicSpline(np.log(WIDTHS), [math.log(exact_force(width)) for width in WIDTHS])


def margin(points, gaps, layer, **keys):
    """Returns the margin in spacings of the grid. At most 40 layers may make up the strip."""
    force = math.log(marker_force(points, gaps, layer, **keys))
    return points / 2 * (brentq(lambda width: FORCE(math.log(points / layer * width)) - force, 0.5, 1.45) - 1)


def main():
    print("layer [dx]" + "".join(f"{f'{n}/{gaps}':>8s}" for n, gaps in ((12, 6), (24, 12), (48, 24), (48, 28), (48, 22), (48, 20)))
          + "   points/gaps; spacing 2, 2, 2, 1.71, 2.18, 2.4")
    for layer in (20.0, 5.0, 3.0, 2.0, 1.0):
        print(f"{layer:10g}" + "".join(f"{margin(n, gaps, layer):8.3f}"
                                       for n, gaps in ((12, 6), (24, 12), (48, 24), (48, 28), (48, 22), (48, 20))))
    print("nu dt/dx^2 with a layer of 20 dx: " + ", ".join(
        f"{diffusion:g}: {margin(24, 12, 20.0, diffusion=diffusion):.3f}" for diffusion in (0.0, 0.02, 0.05, 0.1, 0.2, 0.3)))
    print("markers inside the edges: " + ", ".join(f"{inset:g}: {margin(24, 12, 20.0, inset=inset):.3f}" for inset in (0.0, 0.2, 0.37, 0.5)))


if __name__ == "__main__":
    main()
