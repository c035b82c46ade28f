# SPDX-License-Identifier: GPL-3.0-or-later
"""The elastic elements of the synthetic wing; each family computes all its members at once.

Displacements are arrays (nodes, 3) [m]. A family gives its energy [J], its gradient, and its Hessian as blocks
(pairs, 3, 3) that belong to the pairs of nodes `pairs`. Energies are functions of the displacements alone; large
rotations are exact."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from flusi_msm.bending.jets import Jet, Number, cross, dot, softened_sign, squared_angle, unit, variables

if TYPE_CHECKING:
    from flusi_msm.bending.mesh import Edges

ONE = np.eye(3)
# Hinges, their first and second segments, and the areas beside them if these matter.
Group = tuple[np.ndarray, np.ndarray, np.ndarray, Optional[np.ndarray]]
# Rows of the variables of an area vector, corners (elements, 3, 3) of its triangle, place of the first one among the nodes.
Area = tuple[slice, np.ndarray, int]


class Springs:
    """Springs with the energy k (l - l0)^2/2 between two points. The elongation is computed from displacements, so that strains
    of 1e-9 keep their digits."""

    def __init__(self, positions: np.ndarray, ends: np.ndarray, k: np.ndarray) -> None:
        self.ends, self.k = ends, k
        self.d0 = positions[ends[:, 1]] - positions[ends[:, 0]]
        self.l0 = np.sqrt((self.d0**2).sum(1))
        i, j = ends.T
        self.pairs = np.concatenate([np.stack(p, 1) for p in ((i, i), (j, j), (i, j), (j, i))])

    def state(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Returns elongations, lengths and directions."""
        du = u[self.ends[:, 1]] - u[self.ends[:, 0]]
        d = self.d0 + du
        length = np.sqrt((d * d).sum(1))
        return (du * (self.d0 + d)).sum(1) / (length + self.l0), length, d / length[:, None]

    def energy(self, u: np.ndarray) -> float:
        """Returns the energy of all springs [J]."""
        return 0.5 * (self.k * self.state(u)[0]**2).sum()

    def forces(self, u: np.ndarray) -> np.ndarray:
        """Returns the axial forces [N], positive where a spring is stretched."""
        return self.k * self.state(u)[0]

    def forces_after(self, u: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Returns the axial forces that the law, linearised at u, gives at u + step."""
        stretch, _, t = self.state(u)
        return self.k * (stretch + (t * (step[self.ends[:, 1]] - step[self.ends[:, 0]])).sum(1))

    def add_gradient(self, u: np.ndarray, g: np.ndarray) -> None:
        """Adds the gradient of the energy to g (nodes, 3)."""
        stretch, _, t = self.state(u)
        pull = (self.k * stretch)[:, None] * t
        np.add.at(g, self.ends[:, 1], pull)
        np.add.at(g, self.ends[:, 0], -pull)

    def hessian(self, u: np.ndarray, axial: np.ndarray) -> np.ndarray:
        """Returns the Hessian; it is exact if `axial` are the forces of the law."""
        _, length, t = self.state(u)
        across = (axial / length)[:, None, None]
        block = (self.k[:, None, None] - across) * t[:, :, None] * t[:, None, :] + across * ONE
        return np.concatenate([block, block, -block, -block])


class Turns:
    """Hinges with the energy k Theta^2/2 + k3 Theta^4/4, where Theta is the angle between the second segment and its rest
    direction. The rest direction is that of the first segment turned by the rest angle about the membrane's normal, which is the
    direction of the summed areas of `triangles` (hinges, 4, 3), padded with empty ones; without triangles the normal is fixed.
    `is_flat` is False if the wing is not flat: then the turned segment is also raised toward the normal by the difference of
    elevation at rest.

    A one-sided hinge (hinges) is 1 + `sided` times as stiff when its second segment bends toward the normal, 1 - `sided`
    times when away from it; in between, over KINK, the factor follows a hyperbolic tangent."""

    KINK = 0.01  # [rad]

    def __init__(self, positions: np.ndarray, nodes: np.ndarray, angles: np.ndarray, triangles: np.ndarray, normal: np.ndarray,
                 k: np.ndarray, k3: np.ndarray, is_flat: bool = True, sided: np.ndarray | None = None) -> None:
        self.positions, self.nodes, self.k, self.k3 = positions, nodes, k, k3
        self.sided = np.zeros(len(nodes)) if sided is None else sided
        self.cosine, self.sine, self.raised = np.cos(angles), np.sin(angles), None
        self.bent, self.triangles, self.normal = (angles != 0) | (self.sided != 0), triangles, normal
        corners = triangles.reshape(len(nodes), 12)
        self.local = np.concatenate([nodes, corners], 1)
        n = self.local.shape[1]
        self.pairs = np.stack([np.repeat(self.local, n, 1), np.tile(self.local, (1, n))], 2).reshape(-1, 2)
        if not is_flat:
            self.bent, self.raised = np.ones(len(nodes), bool), np.zeros(len(nodes))
            for which, e, f, area in self._groups(np.zeros(positions.shape)):
                te, tf = unit(list(e.T)), unit(list(f.T))
                n = self._normal(which, None if area is None else list(area.T))
                assert n is not None  # all hinges are bent
                angle = np.arctan2(dot(n, cross(te, tf)), dot(te, tf) - dot(n, te) * dot(n, tf))
                self.cosine[which], self.sine[which] = np.cos(angle), np.sin(angle)
                self.raised[which] = np.arcsin(dot(n, tf)) - np.arcsin(dot(n, te))

    def _law(self, which: np.ndarray, e: Sequence[Number], f: Sequence[Number], n: Sequence[Any] | None) -> Number:
        """Returns the energies of some hinges; e, f are the segments, n the unit normal, or nothing for straight hinges."""
        te, tf = unit(e), unit(f)
        if n is not None:
            c, s = self.cosine[which], self.sine[which]
            side, along = cross(n, te), dot(n, te)
            te = [te[k] * c + side[k] * s + along * n[k] * (1 - c) for k in range(3)]
        if n is not None and self.raised is not None:
            along = dot(n, te)
            up = unit([n[k] - along * te[k] for k in range(3)])
            te = [te[k] * np.cos(self.raised[which]) + up[k] * np.sin(self.raised[which]) for k in range(3)]
        w = [tf[k] - te[k] for k in range(3)]
        square = squared_angle(dot(w, w) * 0.25)
        law = square * (0.5 * self.k[which]) + square * square * (0.25 * self.k3[which])
        if n is None or not self.sided[which].any():
            return law
        return law + square * softened_sign(dot(n, w) * (1 / self.KINK)) * (0.5 * self.k[which] * self.sided[which])

    def _groups(self, u: np.ndarray) -> Iterator[Group]:
        """Returns three groups: straight hinges, hinges with a normal carried by triangles, and hinges with a fixed normal. Each
        has its hinges, their segments, and their areas if these matter."""
        x = self.positions + u[:len(self.positions)]
        e, f = x[self.nodes[:, 1]] - x[self.nodes[:, 0]], x[self.nodes[:, 2]] - x[self.nodes[:, 1]]
        has = self.bent & (self.triangles[:, 0, 0] != self.triangles[:, 0, 1])
        a, b, c = (x[self.triangles[:, :, k]] for k in range(3))
        area = np.cross(b - a, c - a).sum(1)
        for chosen, carried in ((~self.bent, False), (has, True), (self.bent & ~has, False)):
            which = np.flatnonzero(chosen)
            if len(which):
                yield which, e[which], f[which], area[which] if carried else None

    def _normal(self, which: np.ndarray, area: Sequence[Any] | None) -> list[Any] | None:
        if area is not None:
            return unit(area)
        return [np.full(len(which), q) for q in self.normal] if self.bent[which[0]] else None

    def energy(self, u: np.ndarray) -> float:
        """Returns the energy of all hinges [J]."""
        total = 0.0
        for which, e, f, area in self._groups(u):
            normal = self._normal(which, None if area is None else list(area.T))
            total = total + self._law(which, list(e.T), list(f.T), normal).sum()
        return total

    def derivatives(self, u: np.ndarray, with_hessian: bool = True) -> tuple[np.ndarray, np.ndarray | None]:
        """Returns the gradient (hinges, local nodes, 3) and the Hessian (hinges, local nodes, 3, local nodes, 3)."""
        count, n = self.local.shape
        g = np.zeros((count, n, 3), u.dtype)
        h = np.zeros((count, n, 3, n, 3), u.dtype) if with_hessian else None
        x = (self.positions + u[:len(self.positions)])[self.triangles]  # (hinges, 4, 3 corners, 3)
        for which, e, f, area in self._groups(u):
            jets = variables(np.concatenate([e, f] + ([] if area is None else [area]), 1), with_hessian)
            out = self._law(which, jets[:3], jets[3:6], self._normal(which, None if area is None else jets[6:]))
            basis = np.zeros((len(which), out.g.shape[1], n, 3), u.dtype)  # d(e, f, A)/d(local nodes)
            for k in range(3):
                basis[:, k, 0, k], basis[:, k, 1, k] = -1, 1
                basis[:, 3 + k, 1, k], basis[:, 3 + k, 2, k] = -1, 1
            areas = () if area is None else [(slice(6, 9), x[which, t], 3 + 3 * t) for t in range(4)]
            g[which], part = gather(out, basis, areas)
            if h is not None:
                h[which] = part
        return g, h

    def add_gradient(self, u: np.ndarray, g: np.ndarray) -> None:
        """Adds the gradient of the energy to g (nodes, 3)."""
        local, _ = self.derivatives(u, with_hessian=False)
        np.add.at(g, self.local.ravel(), local.reshape(-1, 3))

    def hessian(self, u: np.ndarray) -> np.ndarray:
        """Returns the Hessian as blocks (pairs, 3, 3)."""
        _, h = self.derivatives(u)
        assert h is not None
        return h.transpose(0, 1, 3, 2, 4).reshape(-1, 3, 3)


def gather(out: Jet, basis: np.ndarray, areas: Sequence[Area]) -> tuple[np.ndarray, np.ndarray | None]:
    """Returns the gradient (elements, n, 3) and, if jets have one, the Hessian (elements, n, 3, n, 3) with respect to the positions
    of n nodes, from jets `out` of some vectors. basis (elements, variables, n, 3) are the derivatives of the vectors, to which those of area
    vectors are added: (rows of the variables, corners (elements, 3, 3) of a triangle, place of the first one among the nodes)."""
    m, _, n, _ = basis.shape
    for rows, x, first in areas:
        for k in range(3):
            basis[:, rows, first + k] += _cross_matrix(x[:, (k + 2) % 3] - x[:, (k + 1) % 3])
    flat = basis.reshape(m, -1, 3 * n)
    g = np.matmul(out.g[:, None, :], flat).reshape(m, n, 3)
    if out.h is None:
        return g, None
    h = np.matmul(flat.transpose(0, 2, 1), np.matmul(out.h, flat)).reshape(m, n, 3, n, 3)
    for rows, _, first in areas:  # areas are quadratic in the positions
        twist = _cross_matrix(out.g[:, rows])
        for k in range(3):
            i, j = first + k, first + (k + 1) % 3
            h[:, i, :, j, :] -= twist
            h[:, j, :, i, :] += twist
    return g, h


def _cross_matrix(v: np.ndarray) -> np.ndarray:
    """Returns (..., 3, 3) matrices M with M x = v cross x."""
    m = np.zeros(v.shape + (3,), v.dtype)
    m[..., 0, 1], m[..., 0, 2], m[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    m[..., 1, 0], m[..., 2, 0], m[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return m


class Plate:
    """Bending of the flat membrane, quadratic in the displacements: the sum over x, y, z of
    D/2 ((tr C)^2 - 2 (1 - nu) det C) integrated over the wing, C the second derivatives of the component. The wing
    hardly stretches, so it bends into developable shapes, for which this is D kappa^2/2 in any orientation.

    `morley`: the element of Morley (1968): C is constant in a triangle and follows from the points and, as unknowns of
    their own, from the slopes across the middles of the edges. `edges`: no slopes, the energy of an edge is
    D |length x dihedral angle|^2/(2 (A1 + A2)); on equilateral triangles that is the same law for nu = -1/3."""

    def __init__(self, kind: str, positions: np.ndarray, triangles: np.ndarray, edges: Edges, first_slope: int, stiffness: np.ndarray,
                 poisson: float) -> None:
        xy = positions[:, :2]
        self.kind, self.n_slopes = kind, len(edges.ends) if kind == "morley" else 0
        a, b, c = (xy[triangles[:, k]] for k in range(3))
        self.area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
        rows = self._morley(xy, triangles, edges, first_slope, stiffness, poisson) if kind == "morley" else \
            self._edges(xy, triangles, edges, stiffness)
        blocks, nodes = rows
        n = nodes.shape[1]
        self.nodes, self.blocks = nodes, blocks
        self.pairs = np.stack([np.repeat(nodes, n, 1), np.tile(nodes, (1, n))], 2).reshape(-1, 2)

    def _morley(self, xy: np.ndarray, triangles: np.ndarray, edges: Edges, first_slope: int, stiffness: np.ndarray, poisson: float) \
            -> tuple[np.ndarray, np.ndarray]:
        m = len(triangles)
        # Slopes are multiplied by a length, so that they are unknowns like displacements.
        self.scale = float(np.sqrt(self.area.mean())) if m else 1.0
        b = np.zeros((m, 3, 6))  # (xx, yy, 2 xy) from three points and three slopes
        for k in range(3):
            i, j = triangles[:, (k + 1) % 3], triangles[:, (k + 2) % 3]
            side = xy[j] - xy[i]
            length = np.sqrt((side**2).sum(1))
            t = side / length[:, None]
            n = np.stack([t[:, 1], -t[:, 0]], 1)  # outward, the triangle is counter-clockwise
            along = np.stack([t[:, 0] * n[:, 0], t[:, 1] * n[:, 1], t[:, 0] * n[:, 1] + t[:, 1] * n[:, 0]], 1)
            across = np.stack([n[:, 0]**2, n[:, 1]**2, 2 * n[:, 0] * n[:, 1]], 1) * length[:, None]
            sign = np.where(i < j, 1.0, -1.0)  # the slope belongs to the edge
            b[:, :, (k + 1) % 3] -= along
            b[:, :, (k + 2) % 3] += along
            b[:, :, 3 + k] = across * (sign / self.scale)[:, None]
        b /= self.area[:, None, None]
        law = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
        weight = (stiffness * self.area)[:, None, None]
        return weight * np.matmul(b.transpose(0, 2, 1), law @ b), np.concatenate(
            [triangles, first_slope + edges.of_triangle], 1)

    def _edges(self, xy: np.ndarray, triangles: np.ndarray, edges: Edges, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        inner = np.flatnonzero(edges.sides[:, 1] >= 0)
        sides, ends = edges.sides[inner], edges.ends[inner]
        apex = np.stack([triangles[sides[:, s]].sum(1) - ends.sum(1) for s in range(2)], 1)
        nodes = np.concatenate([ends, apex], 1)
        q = np.zeros((len(inner), 4))
        side = xy[ends[:, 1]] - xy[ends[:, 0]]
        length = np.sqrt((side**2).sum(1))
        for s in range(2):  # slope of each triangle away from the edge, times the length of the edge
            arm = xy[apex[:, s]] - xy[ends[:, 0]]
            place = (arm * side).sum(1) / length**2
            height = np.abs(side[:, 0] * arm[:, 1] - side[:, 1] * arm[:, 0]) / length
            q[:, 0] -= (1 - place) * length / height
            q[:, 1] -= place * length / height
            q[:, 2 + s] += length / height
        weight = stiffness[sides].mean(1) / (self.area[sides].sum(1))
        return weight[:, None, None] * q[:, :, None] * q[:, None, :], nodes

    def energy(self, u: np.ndarray) -> float:
        """Returns the energy of bending [J]."""
        local = u[self.nodes]
        return 0.5 * (local * np.einsum("eij,ejk->eik", self.blocks, local)).sum()

    def add_gradient(self, u: np.ndarray, g: np.ndarray) -> None:
        """Adds the gradient of the energy to g (nodes, 3)."""
        np.add.at(g, self.nodes.ravel(), np.einsum("eij,ejk->eik", self.blocks, u[self.nodes]).reshape(-1, 3))

    def hessian(self) -> np.ndarray:
        """Returns the Hessian, which is the same for all displacements, as blocks (pairs, 3, 3)."""
        return self.blocks.reshape(-1)[:, None, None] * ONE
