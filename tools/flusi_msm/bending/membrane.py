# SPDX-License-Identifier: GPL-3.0-or-later
"""Two further properties of a membrane: it may be stretched like a soap film already in the unloaded wing, and it can resist the
twist of its veins. The families of elements are like those in bending/elements.py."""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flusi_msm.bending.elements import Area, gather
from flusi_msm.bending.jets import Number, cross, dot, inverse_root, squared_angle, unit, variables


class Family:
    """Elements whose energy is a function of some vectors, which are linear or quadratic in the positions of their nodes `local`
    (elements, n)."""

    def _number(self, local: np.ndarray) -> None:
        self.local, n = local, local.shape[1]
        self.pairs = np.stack([np.repeat(local, n, 1), np.tile(local, (1, n))], 2).reshape(-1, 2)

    def _vectors(self, u: np.ndarray) -> tuple[np.ndarray, ...]:
        """Returns the vectors (elements, 3)."""
        raise NotImplementedError

    def _law(self, v: Sequence[Number]) -> Number:
        """Returns the energies; v are the components of all vectors, one after another."""
        raise NotImplementedError

    def _basis(self, u: np.ndarray) -> tuple[np.ndarray, tuple[Area, ...]]:
        """Returns the derivatives of the vectors with respect to the nodes, and the areas among them, as `gather` takes them."""
        raise NotImplementedError

    def energy(self, u: np.ndarray) -> float:
        """Returns the energy of all elements [J]."""
        return self._law(list(np.concatenate(self._vectors(u), 1).T)).sum()

    def derivatives(self, u: np.ndarray, with_hessian: bool = True) -> tuple[np.ndarray, np.ndarray | None]:
        """Returns the gradient (elements, n, 3) and the Hessian (elements, n, 3, n, 3)."""
        vectors = self._vectors(u)
        out = self._law(variables(np.concatenate(vectors, 1), with_hessian))
        return gather(out, *self._basis(u))

    def add_gradient(self, u: np.ndarray, g: np.ndarray) -> None:
        """Adds the gradient of the energy to g (nodes, 3)."""
        np.add.at(g, self.local.ravel(), self.derivatives(u, False)[0].reshape(-1, 3))

    def hessian(self, u: np.ndarray) -> np.ndarray:
        """Returns the Hessian as blocks (pairs, 3, 3)."""
        _, h = self.derivatives(u)
        assert h is not None
        return h.transpose(0, 1, 3, 2, 4).reshape(-1, 3, 3)


class Film(Family):
    """A film with the energy T (A - A0) of the tension T [N/m] and the area A of each triangle: it pulls equally in all
    directions, whatever the triangle's shape. The outline contracts under it by T over the stiffness of its springs."""

    def __init__(self, positions: np.ndarray, triangles: np.ndarray, tension: float) -> None:
        self.positions, self.tension = positions, tension
        self._number(triangles)
        e, f = self._vectors(np.zeros(positions.shape))
        self.area = np.sqrt((np.cross(e, f)**2).sum(1)) / 2

    def _vectors(self, u: np.ndarray) -> tuple[np.ndarray, ...]:
        x = (self.positions + u[:len(self.positions)])[self.local]
        return x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]

    def _law(self, v: Sequence[Number]) -> Number:
        a = cross(v[:3], v[3:])
        square = dot(a, a)
        return (square * inverse_root(square) * 0.5 - self.area) * self.tension

    def _basis(self, u: np.ndarray) -> tuple[np.ndarray, tuple[Area, ...]]:
        basis = np.zeros((len(self.local), 6, 3, 3), u.dtype)
        for k in range(3):
            basis[:, k, 0, k], basis[:, k, 1, k] = -1, 1
            basis[:, 3 + k, 0, k], basis[:, 3 + k, 2, k] = -1, 1
        return basis, ()


class Twists(Family):
    """Resistance to twist, with the energy k tau^2/2, at hinges of veins: tau is the angle about the vein between the membrane
    at its first and at its second segment. The direction of the membrane there is that of the sum of the areas of the triangles
    at the segment, seen along the bisector of both segments. `beside` (hinges, 2, 2, 3) are these triangles, padded with empty
    ones."""

    def __init__(self, positions: np.ndarray, nodes: np.ndarray, beside: np.ndarray, k: np.ndarray) -> None:
        self.positions, self.k = positions, k
        self._number(np.concatenate([nodes, beside.reshape(len(nodes), 12)], 1))

    def _corners(self, u: np.ndarray) -> np.ndarray:
        return (self.positions + u[:len(self.positions)])[self.local]

    def _vectors(self, u: np.ndarray) -> tuple[np.ndarray, ...]:
        x = self._corners(u)
        a, b, c = (x[:, 3 + k::3] for k in range(3))  # (hinges, 4 triangles, 3)
        area = np.cross(b - a, c - a)
        return x[:, 1] - x[:, 0], x[:, 2] - x[:, 1], area[:, :2].sum(1), area[:, 2:].sum(1)

    def _law(self, v: Sequence[Number]) -> Number:
        te, tf = unit(v[:3]), unit(v[3:6])
        p = unit([te[k] + tf[k] for k in range(3)])
        one, two = (unit([area[k] - dot(area, p) * p[k] for k in range(3)]) for area in (v[6:9], v[9:]))
        w = [two[k] - one[k] for k in range(3)]
        return squared_angle(dot(w, w) * 0.25) * (0.5 * self.k)

    def _basis(self, u: np.ndarray) -> tuple[np.ndarray, tuple[Area, ...]]:
        x = self._corners(u)
        basis = np.zeros((len(x), 12, 15, 3), u.dtype)
        for k in range(3):
            basis[:, k, 0, k], basis[:, k, 1, k] = -1, 1
            basis[:, 3 + k, 1, k], basis[:, 3 + k, 2, k] = -1, 1
        return basis, tuple((slice(6 + 3 * (t // 2), 9 + 3 * (t // 2)), x[:, 3 + 3 * t:6 + 3 * t], 3 + 3 * t)
                            for t in range(4))
