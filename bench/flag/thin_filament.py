#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the flapping filament of Huang, Shin & Sung (2007) independently, by the immersed boundary method for a filament
without thickness. This program shares no line and no numerical method for the solid with the program that it is compared to: it
uses vorticity instead of velocity, forces spread by Peskin's four-point function instead of a penalized mask and a sampled
pressure (so that friction acts on the filament, too), and points on a line instead of triangles.

Massless markers X move with the flow, and points Y with mass obey the equation of the filament; a stiff spring and damper between
them, F = K (Y - X) + C (dY/dt - dX/dt) per length, couples them and drives the flow (Kim & Peskin 2007, DOI 10.1063/1.2734674,
and the feedback forcing of Huang et al.). The flow uses Adams-Bashforth with exact viscosity, the filament BDF2 with Newton's
method. Box, sponge and start are those of flag.py.

usage: thin_filament.py POINTS END FILE [--rigidity EI] [--box LY LZ] [--normal] [--inset CELLS]

POINTS is the number of points per length of the filament; time and place of the tail, relative to the root, are written to FILE.
With --normal the friction of the flow along the filament does not act on it, as on a wing under pressure alone. With --inset the
filament has no forces on the flow on the last CELLS grid spacings before its tail, and none from it.
"""
import argparse

import numpy as np
from numpy.fft import irfft2, rfft2

NU, MASS, GRAVITY, TILT = 1 / 200, 1.5, 0.5, 0.1 * np.pi
STRETCH, SPRING, DAMPER = 1.0e3, 2.5e3, 8.0
SPONGE_TIME = 0.05


class Flow:
    """The vorticity of a flow in a periodic box with the mean velocity (1, 0), and its steps in time."""

    def __init__(self, points, box, dt):
        self.n, self.h, self.dt = tuple(int(points * length) for length in box), 1 / points, dt
        ky = 2 * np.pi * np.fft.fftfreq(self.n[0], self.h)[:, None]
        kz = 2 * np.pi * np.fft.rfftfreq(self.n[1], self.h)[None, :]
        k2 = ky**2 + kz**2
        self.iky, self.ikz = 1j * ky, 1j * kz
        self.inverse = np.where(k2 > 0, 1 / np.where(k2 > 0, k2, 1), 0)
        self.keep = (np.abs(ky) < np.pi / self.h * 2 / 3) & (np.abs(kz) < np.pi / self.h * 2 / 3)
        self.decay = np.exp(-NU * k2 * dt)
        self.sponge = np.zeros(self.n)
        for axis in (0, 1):
            i = np.arange(self.n[axis])
            edge = ((i < points // 2) | (i >= self.n[axis] - points // 2)) / SPONGE_TIME
            self.sponge = np.maximum(self.sponge, edge[:, None] if axis == 0 else edge[None, :])
        self.vorticity, self.old = np.zeros((self.n[0], self.n[1] // 2 + 1), complex), None

    def velocity(self):
        stream = self.vorticity * self.inverse
        return np.array([1 + irfft2(self.ikz * stream, self.n), irfft2(-self.iky * stream, self.n)])

    def step(self, velocity, force):
        w = self.vorticity
        advection = velocity[0] * irfft2(self.iky * w, self.n) + velocity[1] * irfft2(self.ikz * w, self.n)
        rhs = rfft2(-advection - self.sponge * irfft2(w, self.n))
        rhs = self.keep * (rhs + self.iky * rfft2(force[1]) - self.ikz * rfft2(force[0]))
        if self.old is None:
            self.vorticity = self.decay * (w + self.dt * rhs)
        else:
            self.vorticity = self.decay * (w + self.dt * (1.5 * rhs - 0.5 * self.decay * self.old))
        self.old = rhs

    def stencil(self, places):
        """Returns the indices and weights of the 4 x 4 points around each place."""
        s = places / self.h
        first = np.floor(s).astype(int)
        index = (first[:, :, None] + np.arange(-1, 3)) % np.array(self.n)[None, :, None]
        r = np.abs(s[:, :, None] - first[:, :, None] - np.arange(-1, 3))
        inner = (3 - 2 * r + np.sqrt(np.maximum(0, 1 + 4 * r - 4 * r**2))) / 8
        outer = (5 - 2 * r - np.sqrt(np.maximum(0, -7 + 12 * r - 4 * r**2))) / 8
        w = np.where(r < 1, inner, outer)
        return index[:, 0, :, None], index[:, 1, None, :], w[:, 0, :, None] * w[:, 1, None, :]


class Filament:
    """A filament: points of equal mass on a line that hardly stretches, the first one pinned; its steps in time use BDF2."""

    def __init__(self, cells, root, rigidity, dt):
        self.n, self.h, self.dt = cells, 1 / cells, dt
        s = np.arange(cells + 1)[:, None] * self.h
        self.y = root + s * np.array([np.cos(TILT), np.sin(TILT)])
        self.old, self.v = self.y.copy(), np.zeros_like(self.y)
        self.old_v = self.v.copy()
        self.share = np.full(cells + 1, self.h)
        self.share[[0, -1]] /= 2
        second = np.zeros((cells - 1, cells + 1))
        for i in range(cells - 1):
            second[i, i:i + 3] = np.array([1, -2, 1]) / self.h**2
        self.bending = np.kron(rigidity * self.h * second.T @ second, np.eye(2))

    def forces(self, y):
        """Returns the elastic forces (n + 1, 2) and their Jacobian."""
        d = np.diff(y, axis=0)
        length = np.sqrt((d**2).sum(1))
        t = d / length[:, None]
        pull = STRETCH * (length / self.h - 1)
        force = -(self.bending @ y.ravel()).reshape(-1, 2)
        force[:-1] += pull[:, None] * t
        force[1:] -= pull[:, None] * t
        jacobian = -self.bending.copy()
        tt = t[:, :, None] * t[:, None, :]
        block = (STRETCH / self.h) * tt + (pull / length)[:, None, None] * (np.eye(2) - tt)
        for i in range(self.n):
            a, b = slice(2 * i, 2 * i + 2), slice(2 * i + 2, 2 * i + 4)
            jacobian[a, a] -= block[i]
            jacobian[b, b] -= block[i]
            jacobian[a, b] += block[i]
            jacobian[b, a] += block[i]
        return force, jacobian

    def step(self, load):
        """Moves the filament over the time dt under `load` (n + 1, 2) per point."""
        dt, mass = self.dt, MASS * self.share[:, None]
        y = self.y + dt * self.v
        y[0] = self.y[0]
        for _ in range(20):
            v = (3 * y - 4 * self.y + self.old) / (2 * dt)
            a = (3 * v - 4 * self.v + self.old_v) / (2 * dt)
            elastic, jacobian = self.forces(y)
            residual = mass * a - elastic - load
            residual[:, 0] -= mass[:, 0] * GRAVITY
            matrix = np.kron(np.diag(mass[:, 0]), np.eye(2)) * 9 / (4 * dt**2) - jacobian
            change = np.linalg.solve(matrix[2:, 2:], -residual.ravel()[2:])
            y[1:] += change.reshape(-1, 2)
            if np.abs(change).max() < 1e-10:
                break
        else:
            raise SystemExit("the filament cannot be advanced")
        v = (3 * y - 4 * self.y + self.old) / (2 * dt)
        self.old, self.y, self.old_v, self.v = self.y, y, self.v, v


def run(points, end, rigidity, box, normal, inset):
    """Yields records of the time, the position of the tail, the largest |Y - X| and the force along the stream."""
    dt = 0.064 / points
    flow = Flow(points, box, dt)
    filament = Filament(max(32, points), np.array([box[0] / 3, box[1] / 2]), rigidity, dt)
    markers = filament.y.copy()
    meets = np.linspace(0, 1, filament.n + 1) <= 1 - inset / points + 1e-9
    share = (filament.share * meets)[:, None]
    for step in range(int(end / dt + 0.5)):
        velocity = flow.velocity()
        index_y, index_z, weights = flow.stencil(markers)
        local = np.stack([(weights * u[index_y, index_z]).sum((1, 2)) for u in velocity], axis=1)
        force = (SPRING * (filament.y - markers) + DAMPER * (filament.v - local)) * share
        spread = np.zeros_like(velocity)
        for c in (0, 1):
            np.add.at(spread[c], (index_y, index_z), weights * force[:, c, None, None] / flow.h**2)
        if step % 10 == 0:
            yield step * dt, *(filament.y[-1] - filament.y[0]), np.abs(filament.y - markers)[meets].max(), -force.sum(0)[0]
        flow.step(velocity, spread)
        if normal:
            along = np.gradient(filament.y, axis=0)
            along /= np.sqrt((along**2).sum(1))[:, None]
            force = force - (force * along).sum(1)[:, None] * along
        filament.step(-force)
        markers = markers + dt * local


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("points", type=int, metavar="POINTS")
    parser.add_argument("end", type=float, metavar="END")
    parser.add_argument("file", metavar="FILE")
    parser.add_argument("--rigidity", type=float, default=0.0015, metavar="EI", help="over rho U^2 L^3 (0.0015)")
    parser.add_argument("--box", type=float, nargs=2, default=(6.0, 4.0), metavar=("LY", "LZ"))
    parser.add_argument("--normal", action="store_true", help="no friction on the filament")
    parser.add_argument("--inset", type=float, default=0.0, metavar="CELLS", help="end of the flow's forces before the tail (0)")
    options = parser.parse_args()
    with open(options.file, "w", buffering=1) as file:
        file.write("# time y_tail z_tail largest|Y-X| F_y\n")
        for record in run(options.points, options.end, options.rigidity, options.box, options.normal, options.inset):
            file.write(" ".join(f"{x:.8e}" for x in record) + "\n")


if __name__ == "__main__":
    main()
