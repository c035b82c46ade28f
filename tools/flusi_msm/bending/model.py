# SPDX-License-Identifier: GPL-3.0-or-later
"""The mechanics of the synthetic bending tests: a wing of springs, hinges and a bending membrane, written for
`make_measurement` alone. Nothing here is shared with the solver in src or with what is fitted to the data."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import pi
from typing import Any

import numpy as np
from scipy import sparse

from flusi_msm.bending.camber import Camber, heights
from flusi_msm.bending.elements import Plate, Springs, Turns
from flusi_msm.bending.membrane import Family, Film, Twists
from flusi_msm.bending.mesh import Edges, Hinge, find_edges, locate, plan_hinges
from flusi_msm.results.files import InputError
from flusi_msm.wing.file import Wing

STRAIGHT = 1e-9  # [rad] rest angle below which a hinge needs no normal


@dataclass
class Stiffness:
    """The stiffness of a wing. The names are those of the parameters of `flusi` where it has them."""
    E: float = 12.58e9                # [Pa] of the veins
    D: float = 2.0e-7                 # [N m] of the membrane
    root: float = 1.0                 # factor on the hinges at the root
    diameter_exponent: float = 4.0
    k_vein: float = 1.0e5             # [N/m] of a segment
    k_membrane: float = 1.0e5
    k_cross: float = 1.0e5
    cross_springs: bool = False
    poisson: float = -1 / 3           # of the membrane's bending; see docs/guide/synthetic-measurements.md
    plate: str = "morley"             # or edges
    veins: dict[str, float] = field(default_factory=dict)   # name: factor on E
    joints: dict[str, float] = field(default_factory=dict)  # name: [N m/rad]; the others bend as their vein
    # Properties that a usual model does not know:
    E_gradient: float = 0.0           # E exp(g (x/R - 1/2)), x from the root, R the wing's length
    E_wave: tuple[Any, ...] = ()      # (vein, a, length [m]): E (1 + a sin(2 pi s/length)), s from the vein's beginning
    camber: tuple[float, ...] = (0.0, 0.0, 0.0)  # [m] arch, bend and twist of the unloaded wing; see bending/camber.py
    orthotropy: float = 0.0           # k_membrane (1 + a cos 2 phi), phi the angle of the spring to x
    pretension: float = 0.0           # [N/m] of the membrane in the unloaded wing
    torsion: float = 0.0              # GJ/EI of veins and joints
    thickness_gradient: float = 0.0   # t exp(g (x/R - 1/2)): k_membrane and k_cross with t, D with t^3; the mass is that of make_modes
    D_wave: tuple[float, ...] = ()    # (a, x length, y length [m]): D (1 + a sin(2 pi (x/lx + y/ly))); 0: no wave along it
    joint_hardening: float = 0.0      # [1/rad^2] M = k Theta (1 + h Theta^2) in the joints
    cuticle_hardening: float = 0.0    # [m^2] M = E I kappa (1 + c kappa^2) in all other hinges of veins
    one_way: tuple[Any, ...] = ()     # (joint, ratio): so many times stiffer when bent toward +z than toward -z
    damage: tuple[float, ...] = ()    # (x, y, radius, factor) [m]: all stiffness in a disc
    root_compliance: tuple[float, ...] = (0.0, 0.0)  # [rad/(N m)] of the clamp: flapping about y, twisting about x


class Model:
    """A wing with its stiffness. Nodes are the points, the ghost points, and the slopes of the membrane's edges."""

    def __init__(self, wing: Wing, stiffness: Stiffness, mean_diameter: float | None = None, vein_springs: float = 1.0) -> None:
        """`mean_diameter` [m] and `vein_springs` (a factor on k_vein) are those of the wing before refinement, so that
        a refined wing is the same structure."""
        check_stiffness(wing, stiffness)
        self.stiffness, self.is_flat = stiffness, not any(stiffness.camber)
        self.normal = plane_normal(wing)
        flat, wing = wing, wing if self.is_flat else cambered(wing, stiffness.camber)
        self.wing = wing
        hinges, ghosts = plan_hinges(wing)
        self.hinge_plan = hinges
        self.positions = np.concatenate([wing.points, ghosts])
        self.n_points, n = len(wing.points), len(self.positions)
        self.span = float(np.ptp(wing.points[:, 0]))
        self.root_x = float(wing.points[list(wing.root), 0].mean())
        every = np.concatenate([d for _, d in wing.veins.values()]) if wing.veins else np.ones(1)
        self.mean_diameter = mean_diameter or float(np.mean(every))
        triangles = np.asarray(wing.triangles, int).reshape(-1, 3)
        self.triangles, edges = triangles, find_edges(triangles)
        self.edges = edges
        self.springs = self._springs(edges, vein_springs)
        self.turns = self._turns(hinges, edges)
        d = self._plate_stiffness(self.positions[triangles].mean(1)) if len(triangles) else np.zeros(0)
        self.plate = Plate(stiffness.plate, self.positions, triangles, edges, n, d, stiffness.poisson)
        self.n_nodes = n + self.plate.n_slopes
        self.extras = self._extras(hinges, edges)
        self.bending = self.plate if self.is_flat else Camber(self.plate, self.positions, triangles,
                                                              self._rest_heights(flat, n))
        moves = np.ones(self.n_nodes, bool)
        moves[list(wing.root)] = False
        moves[self.n_points:n] = False
        self.moves = moves
        self._pattern()

    def damaged(self, places: np.ndarray) -> np.ndarray:
        """Returns the factor on the stiffness at places (n, 3): that of the damage inside its disc, whose rim is a tenth of its
        radius wide, and 1 elsewhere."""
        factor = np.ones(len(places))
        if len(self.stiffness.damage):
            x, y, radius, remains = self.stiffness.damage
            r = np.hypot(places[:, 0] - x, places[:, 1] - y) / radius
            rim = np.clip((1.05 - r) / 0.1, 0, 1)
            factor *= 1 - (1 - remains) * rim * rim * (3 - 2 * rim)
        return factor

    def stations(self, places: np.ndarray) -> np.ndarray:
        """Returns x/R - 1/2 at places (n, 3), x from the root."""
        return (places[:, 0] - self.root_x) / self.span - 0.5

    def _plate_stiffness(self, places: np.ndarray) -> np.ndarray:
        """Returns D [N m] at places (n, 3)."""
        d = self.stiffness.D * self.damaged(places) * np.exp(3 * self.stiffness.thickness_gradient * self.stations(places))
        if self.stiffness.D_wave:
            a, *lengths = self.stiffness.D_wave
            waves = sum(places[:, k] / length for k, length in enumerate(lengths) if length > 0)
            d = d * (1 + a * np.sin(2 * pi * waves))
        return d

    def _extras(self, hinges: Sequence[Hinge], edges: Edges) -> list[Family]:
        s = self.stiffness
        families: list[Family] = []
        if s.pretension:
            families.append(Film(self.positions, self.triangles, s.pretension))
        if s.torsion:
            beside = [(edges.triangles_at(*h.nodes[:2]), edges.triangles_at(*h.nodes[1:])) for h in hinges]
            shown = [k for k, (one, two) in enumerate(beside) if one and two]
            corners = np.zeros((len(shown), 2, 2, 3), int)
            for row, k in enumerate(shown):
                corners[row] = hinges[k].nodes[0]
                for side in range(2):
                    for place, t in enumerate(beside[k][side]):
                        corners[row, side, place] = self.triangles[t]
            families.append(Twists(self.positions, self.turns.nodes[shown], corners, s.torsion * self.turns.k[shown]))
        return families

    def _rest_heights(self, flat: Wing, first_slope: int) -> np.ndarray:
        """Returns z0 of the points and, as the plate's unknowns, its slopes across the middles of the edges."""
        a, b = (flat.points[self.edges.ends[:, k], :2] for k in range(2))
        side = b - a
        _, dx, dy = rest_shape(flat, self.stiffness.camber, (a + b) / 2)
        z0 = np.zeros(self.n_nodes)
        z0[:self.n_points] = rest_shape(flat, self.stiffness.camber, flat.points)[0]
        z0[first_slope:] = (dx * side[:, 1] - dy * side[:, 0]) / np.sqrt((side**2).sum(1)) * self.plate.scale
        return z0

    def _springs(self, edges: Edges, vein_springs: float) -> Springs:
        s, ends, k = self.stiffness, [], []
        in_vein: set[tuple[int, int]] = set()
        for name in sorted(self.wing.veins):
            nodes = self.wing.veins[name][0]
            for pair in zip(nodes[:-1], nodes[1:]):
                key = (min(pair), max(pair))
                if key not in in_vein:
                    in_vein.add(key)
                    ends.append(key)
                    k.append(s.k_vein * vein_springs)
        for pair in edges.number:
            if pair not in in_vein:
                ends.append(pair)
                along = self.positions[pair[1]] - self.positions[pair[0]]
                k.append(s.k_membrane * (1 + s.orthotropy * np.cos(2 * np.arctan2(along[1], along[0]))))
        if s.cross_springs:
            for (a, b), (one, two) in zip(edges.ends, edges.sides):
                if two >= 0:
                    ends.append((self.triangles[one].sum() - a - b, self.triangles[two].sum() - a - b))
                    k.append(s.k_cross)
        pairs = np.array(ends, int).reshape(-1, 2)
        middle = self.positions[pairs].mean(1)
        thickness = np.where(np.arange(len(k)) < len(in_vein), 1.0, np.exp(s.thickness_gradient * self.stations(middle)))
        return Springs(self.positions, pairs, np.array(k) * thickness * self.damaged(middle))

    def young(self, vein: str, node: int) -> float:
        """Returns E [Pa] of a vein at one of its points."""
        s, x = self.stiffness, self.wing.points[node, 0]
        young = s.E * s.veins.get(vein, 1.0)
        if s.E_gradient:
            young *= np.exp(s.E_gradient * ((x - self.root_x) / self.span - 0.5))
        if s.E_wave and s.E_wave[0] == vein:
            nodes = self.wing.veins[vein][0]
            steps = np.linalg.norm(np.diff(self.wing.points[nodes[:nodes.index(node) + 1]], axis=0), axis=1)
            young *= 1 + s.E_wave[1] * np.sin(2 * pi * steps.sum() / s.E_wave[2])
        return young

    def hinge_stiffness(self, hinge: Hinge, with_joint: bool = True) -> float:
        """Returns the stiffness [N m/rad]: 1/(sum of l/(2 E I)) over both halves, or that of the joint."""
        s = self.stiffness
        if with_joint and hinge.joint in s.joints and s.joints[hinge.joint] >= 0:
            return s.joints[hinge.joint]
        bends = 0.0
        for vein, length, diameter in hinge.halves:
            moment = pi / 64 * self.mean_diameter**4 * (diameter / self.mean_diameter)**s.diameter_exponent
            bends += length / (self.young(vein, hinge.nodes[1]) * moment)
        return (s.root if hinge.at_root else 1.0) / bends

    def _turns(self, hinges: Sequence[Hinge], edges: Edges) -> Turns:
        nodes = np.array([h.nodes for h in hinges], int).reshape(-1, 3)
        k = np.array([self.hinge_stiffness(h) for h in hinges])
        k *= self.damaged(self.positions[nodes[:, 1]])
        s = self.stiffness
        hardens = np.array([s.joint_hardening if h.joint else s.cuticle_hardening / sum(part[1] for part in h.halves)**2
                            for h in hinges])
        sided = np.array([(s.one_way[1] - 1) / (s.one_way[1] + 1) if s.one_way and h.joint == s.one_way[0] else 0.0
                          for h in hinges])
        e = self.positions[nodes[:, 1]] - self.positions[nodes[:, 0]]
        f = self.positions[nodes[:, 2]] - self.positions[nodes[:, 1]]
        turn = np.cross(e, f)
        along = (e * f).sum(1)
        if self.normal is None:  # no membrane: the plane of the veins
            total = turn.sum(0)
            self.normal = total / np.linalg.norm(total) if np.linalg.norm(total) > 0 else np.array([0.0, 0.0, 1.0])
        angles = np.arctan2(turn @ self.normal, along)
        size = np.sqrt((e**2).sum(1) * (f**2).sum(1))
        angles[(np.sqrt((turn**2).sum(1)) <= STRAIGHT * size) & (along > 0)] = 0
        around = np.zeros((len(hinges), 4, 3), int)
        for row, (a, b, c) in enumerate(nodes.tolist()):
            around[row] = a
            beside = sorted(set(edges.triangles_at(a, b) + edges.triangles_at(b, c)))
            for place, t in enumerate(beside):
                around[row, place] = self.triangles[t]
        return Turns(self.positions, nodes, angles, around, self.normal, k, k * hardens, self.is_flat,
                     sided)

    # ---- energy and its derivatives -------------------------------------------------------------

    def energy(self, u: np.ndarray) -> float:
        """Returns the elastic energy [J]."""
        return self.springs.energy(u) + self.turns.energy(u) + self.bending.energy(u) + \
            sum(family.energy(u) for family in self.extras)

    def gradient(self, u: np.ndarray) -> np.ndarray:
        """Returns the gradient of the energy (nodes, 3) [N]."""
        g = np.zeros(u.shape, u.dtype)
        self.springs.add_gradient(u, g)
        self.turns.add_gradient(u, g)
        for family in (self.bending, *self.extras):
            family.add_gradient(u, g)
        return g

    def _pattern(self) -> None:
        """Finds the places of all element blocks in one symmetric matrix over the moving nodes."""
        number = np.cumsum(self.moves) - 1
        changing = [self.springs.pairs, self.turns.pairs, *(family.pairs for family in self.extras)]
        pairs = np.concatenate([*changing, self.plate.pairs])
        kept = self.moves[pairs].all(1)
        self.n_moving = int(self.moves.sum())
        key = number[pairs[kept, 0]] * self.n_moving + number[pairs[kept, 1]]
        diagonal = np.arange(self.n_moving) * (self.n_moving + 1)
        unique, place = np.unique(np.concatenate([key, diagonal]), return_inverse=True)
        self._block_of = sparse.csr_matrix((np.ones(len(key)), (place[:len(key)], np.flatnonzero(kept))),
                                           shape=(len(unique), len(pairs)))
        rows, columns = unique // self.n_moving, unique % self.n_moving
        self._diagonal = place[len(key):]
        first = np.searchsorted(rows, np.arange(self.n_moving + 1))
        order = sparse.bsr_matrix((np.arange(1, 9 * len(unique) + 1.0).reshape(-1, 3, 3), columns, first)).tocsc()
        self._order, self._indices, self._starts = order.data.astype(int) - 1, order.indices, order.indptr
        n_changing = sum(map(len, changing))
        self._constant = self._block_of[:, n_changing:] @ self.plate.hessian().reshape(-1, 9)
        self._changing = self._block_of[:, :n_changing].tocsr() if self.is_flat else self._block_of

    def tangent(self, u: np.ndarray, axial: np.ndarray, shift: float = 0.0) -> sparse.csc_matrix:
        """Returns the Hessian over the moving nodes as a sparse matrix, with the springs' axial forces [N] in its geometric
        part, plus `shift` [N/m] on the diagonal."""
        parts = [self.springs.hessian(u, axial), self.turns.hessian(u), *(family.hessian(u) for family in self.extras)]
        if isinstance(self.bending, Camber):
            parts.append(self.bending.hessian(u))
        blocks = np.concatenate(parts).reshape(-1, 9)
        data = self._changing @ blocks + self._constant
        if shift:
            data[self._diagonal[:, None], [0, 4, 8]] += shift
        n = 3 * self.n_moving
        return sparse.csc_matrix((data.reshape(-1)[self._order], self._indices, self._starts), shape=(n, n))

    def zeros(self) -> np.ndarray:
        """Returns the displacements (nodes, 3) of the resting wing."""
        return np.zeros((self.n_nodes, 3))

    def weights(self, gravity: Sequence[float], vein_density: float, areal_density: float) -> np.ndarray:
        """Returns the forces (nodes, 3) [N] of the weight under gravity(3) [m/s^2]: veins are conical pieces, divided between
        their ends so that the centre of mass is kept, and the membrane has an even mass per area."""
        mass = np.zeros(self.n_nodes)
        for nodes, diameters in self.wing.veins.values():
            length = np.linalg.norm(np.diff(self.wing.points[nodes], axis=0), axis=1)
            one, two = np.asarray(diameters)[:-1], np.asarray(diameters)[1:]
            volumes = one**2 + one * two + two**2
            far = (one**2 + 2 * one * two + 3 * two**2) / (4 * volumes)  # place of the centre
            piece = vein_density * pi / 12 * volumes * length
            np.add.at(mass, nodes[:-1], piece * (1 - far))
            np.add.at(mass, nodes[1:], piece * far)
        np.add.at(mass, self.triangles.ravel(), np.repeat(areal_density * self.plate.area / 3, 3))
        return mass[:, None] * np.asarray(gravity, float)

    def point_load(self, place: Sequence[float] | np.ndarray, force: Sequence[float] | np.ndarray) -> np.ndarray:
        """Returns the forces (nodes, 3) [N] of a force(3) at (x, y) [m] of the unloaded wing."""
        loads = self.zeros()
        corners, shares = locate(self.wing.points, self.triangles, place)
        loads[corners] += np.outer(shares, force)
        return loads


def plane_normal(wing: Wing) -> np.ndarray | None:
    """Returns the unit normal of the flat wing of the wing file; nothing if it has no membrane."""
    if not len(wing.triangles):
        return None
    a, b, c = (wing.points[np.asarray(wing.triangles)[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a).sum(0)
    normal /= np.linalg.norm(normal)
    if np.abs((wing.points - wing.points[0]) @ normal).max() > 1e-6 * np.ptp(wing.points, axis=0).max():
        raise InputError("the wing of the wing file is not flat")
    return normal


def rest_shape(flat: Wing, camber: Sequence[float], places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns z0 [m] and its derivatives in x and y at places (n, 2 or 3) of the flat wing."""
    root = flat.points[list(flat.root), 0].mean()
    low, size = flat.points[:, 1].min(), np.ptp(flat.points[:, :2], axis=0)
    z, dx, dy = heights(camber, (places[:, 0] - root) / size[0], (places[:, 1] - low) / size[1])
    return z, dx / size[0], dy / size[1]


def cambered(flat: Wing, camber: Sequence[float]) -> Wing:
    """Returns the flat wing raised to its shape without a load."""
    points = flat.points.copy()
    points[:, 2] += rest_shape(flat, camber, flat.points)[0]
    return Wing(points, flat.triangles, flat.veins, flat.joints, flat.root, flat.title)


def check_stiffness(wing: Wing, s: Stiffness) -> None:
    """Raises an InputError if the stiffness does not fit the wing, or makes no sense."""
    for name in s.joints:
        if name not in wing.joints:
            raise InputError(f"no joint {name}; the wing has {', '.join(sorted(wing.joints)) or 'none'}")
    for name in s.veins:
        if name not in wing.veins:
            raise InputError(f"no vein {name}; the wing has {', '.join(sorted(wing.veins)) or 'none'}")
    if s.plate not in ("morley", "edges"):
        raise InputError(f"plate must be morley or edges, not {s.plate}")
    if any(s.camber) and s.plate != "morley":
        raise InputError("camber needs plate = morley")
    if any(s.camber) and (s.pretension or s.torsion):
        raise InputError("pretension and torsion need a flat wing, without camber")
    if s.pretension < 0 or s.torsion < 0 or not abs(s.orthotropy) < 1:
        raise InputError("pretension and torsion must not be negative, orthotropy is between -1 and 1")
    if len(s.camber) != 3:
        raise InputError("camber needs three numbers")
    for name in ("E", "D", "root", "k_vein", "k_membrane", "k_cross"):
        if not getattr(s, name) > 0:
            raise InputError(f"{name} = {getattr(s, name)}: must be positive")
    if not -1 < s.poisson < 1:
        raise InputError(f"poisson = {s.poisson}: must be between -1 and 1")
    if len(s.damage) not in (0, 4) or (len(s.damage) == 4 and not (s.damage[2] > 0 and s.damage[3] > 0)):
        raise InputError("damage needs x y radius factor, with a positive radius and factor")
    if len(s.E_wave) not in (0, 3) or (s.E_wave and not (s.E_wave[0] in wing.veins and abs(s.E_wave[1]) < 1
                                                         and s.E_wave[2] > 0)):
        raise InputError("E_wave needs a vein of the wing, an amplitude below 1 and a positive length")
    if len(s.D_wave) not in (0, 3) or (s.D_wave and not (abs(s.D_wave[0]) < 1 and min(s.D_wave[1:]) >= 0
                                                         and max(s.D_wave[1:]) > 0)):
        raise InputError("D_wave needs an amplitude below 1 and two lengths of which one is positive")
    if len(s.one_way) not in (0, 2) or (s.one_way and not (s.one_way[0] in wing.joints and s.one_way[1] > 0)):
        raise InputError(f"one_way needs a joint of the wing ({', '.join(sorted(wing.joints))}) and a positive ratio")
    if len(s.root_compliance) != 2 or min(s.root_compliance) < 0:
        raise InputError("root_compliance needs two numbers, neither negative")
