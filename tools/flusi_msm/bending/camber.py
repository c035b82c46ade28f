# SPDX-License-Identifier: GPL-3.0-or-later
"""Wings that are not flat when they are unloaded.

The shape without a load is z0(x, y) above the plane of the wing file. With v the displacement from the plane, m the
unit vector that turns with a triangle and is e_z at rest, and K the plate's form of the triangle, the energy of bending
is (v - z0 m) K (v - z0 m)/2: quadratic about a rest shape that rotates with the membrane."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from flusi_msm.bending.jets import Number, cross, dot, unit, variables

if TYPE_CHECKING:
    from flusi_msm.bending.elements import Plate


def heights(camber: Sequence[float], x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns z0 and its derivatives in x and y: an arch across the chord, a bend along the span and a twist [m]; x is relative
    to the root, y to the leading and trailing edges, both run from 0 to 1."""
    arch, bend, twist = camber
    return (arch * 4 * y * (1 - y) + bend * x**2 + twist * x * (2 * y - 1),
            2 * bend * x + twist * (2 * y - 1), arch * 4 * (1 - 2 * y) + 2 * twist * x)


class Camber:
    """The part -(K z0 . v) m and constants that the rest shape z0 (nodes of the plate, with slopes) adds to the energy of a
    plate."""

    def __init__(self, plate: Plate, positions: np.ndarray, triangles: np.ndarray, z0: np.ndarray) -> None:
        self.plate, self.positions, self.triangles, self.z0 = plate, positions, triangles, z0
        local = z0[plate.nodes]
        self.pull = np.einsum("eij,ej->ei", plate.blocks, local)
        self.constant = (self.pull * local).sum() / 2
        e, f = self._sides(np.zeros((len(z0), 3)))
        frame = self._frame([e[:, k] for k in range(3)], [f[:, k] for k in range(3)])
        self.share = [axis[2] for axis in frame]  # of e_z in the frame of the resting triangle
        self.nodes, self.pairs = plate.nodes, plate.pairs

    def _sides(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x = self.positions + u[:len(self.positions)]
        a, b, c = (x[self.triangles[:, k]] for k in range(3))
        return b - a, c - a

    def _frame(self, e: Sequence[Number], f: Sequence[Number]) -> tuple[list[Number], list[Number], list[Number]]:
        t, n = unit(e), unit(cross(e, f))
        return t, cross(n, t), n

    def _turned(self, e: Sequence[Number], f: Sequence[Number]) -> list[Number]:
        one, two, three = self._frame(e, f)
        return [one[k] * self.share[0] + two[k] * self.share[1] + three[k] * self.share[2] for k in range(3)]

    def _moved(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns v at the nodes of the triangles, and q = K z0 . v."""
        v = u[self.nodes].copy()
        v[:, :, 2] += self.z0[self.nodes]
        return v, (self.pull[:, :, None] * v).sum(1)

    def energy(self, u: np.ndarray) -> float:
        """Returns the energy of plate and camber."""
        v, q = self._moved(u)
        e, f = self._sides(u)
        whole = 0.5 * (v * np.einsum("eij,ejk->eik", self.plate.blocks, v)).sum()
        return whole - dot(list(q.T), self._turned(list(e.T), list(f.T))).sum() + self.constant

    def derivatives(self, u: np.ndarray, with_hessian: bool = True) -> tuple[np.ndarray, np.ndarray | None]:
        """Returns the gradient (triangles, 6, 3) and the part of the Hessian (triangles, 6, 3, 6, 3) that is added to the
        plate's own."""
        v, q = self._moved(u)
        e, f = self._sides(u)
        jets = variables(np.concatenate([e, f, q], 1), with_hessian)
        out = dot(jets[6:], self._turned(jets[:3], jets[3:6])) * -1.0
        count = len(q)
        basis = np.zeros((count, 9, 6, 3))
        for k in range(3):
            basis[:, k, 0, k], basis[:, k, 1, k] = -1, 1
            basis[:, 3 + k, 0, k], basis[:, 3 + k, 2, k] = -1, 1
            basis[:, 6 + k, :, k] = self.pull
        flat = basis.reshape(count, 9, 18)
        g = np.matmul(out.g[:, None, :], flat).reshape(count, 6, 3)
        g = g + np.einsum("eij,ejk->eik", self.plate.blocks, v)
        h = np.matmul(flat.transpose(0, 2, 1), np.matmul(out.h, flat)).reshape(count, 6, 3, 6, 3) \
            if out.h is not None else None
        return g, h

    def add_gradient(self, u: np.ndarray, g: np.ndarray) -> None:
        """Adds the gradient of the energy to g (nodes, 3)."""
        np.add.at(g, self.nodes.ravel(), self.derivatives(u, False)[0].reshape(-1, 3))

    def hessian(self, u: np.ndarray) -> np.ndarray:
        """Returns the part of the Hessian that is added to the plate's own, as blocks (pairs, 3, 3)."""
        _, h = self.derivatives(u)
        assert h is not None
        return h.transpose(0, 1, 3, 2, 4).reshape(-1, 3, 3)
