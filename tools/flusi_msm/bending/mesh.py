# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of the synthetic bending tests: their refinement, their edges, and the pairs of vein segments that bend against each
other."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flusi_msm.results.files import InputError
from flusi_msm.wing.file import Wing

Arm = tuple[str, int, float]     # a segment at a point: its vein, its other end, the diameter [m] at the point
Half = tuple[str, float, float]  # vein, half-length [m], diameter [m] at the hinge


def refine(wing: Wing) -> Wing:
    """Returns the same wing with every triangle divided into four and every vein segment into two. Diameters are interpolated
    linearly, a joint stays at its point, and the middle of an edge between two root points is a root point."""
    made, points = {}, [tuple(p) for p in wing.points]

    def middle(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in made:
            made[key] = len(points)
            points.append(tuple((wing.points[a] + wing.points[b]) / 2))
        return made[key]

    triangles = []
    for a, b, c in wing.triangles.tolist():
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        triangles += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    veins = {}
    for name, (nodes, diameters) in wing.veins.items():
        fine, widths = [nodes[0]], [float(diameters[0])]
        for a, b, da, db in zip(nodes[:-1], nodes[1:], diameters[:-1], diameters[1:]):
            fine += [middle(a, b), b]
            widths += [(da + db) / 2, float(db)]
        veins[name] = (fine, np.array(widths))
    joints = {}
    for name, joint in wing.joints.items():
        joints[name] = joint if len(joint) == 2 else (middle(*joint[:2]), joint[1], middle(*joint[1:]))
    clamped = set(wing.root)
    root = sorted(clamped | {m for (a, b), m in made.items() if a in clamped and b in clamped})
    return Wing(np.array(points), np.array(triangles, int).reshape(-1, 3), veins, joints, root, wing.title)


@dataclass
class Edges:
    """The edges of a triangulation: ends[k] = (a, b) with a < b; `inner` are those with two triangles."""
    ends: np.ndarray      # (k, 2)
    of_triangle: np.ndarray  # (m, 3) the edge opposite each corner
    sides: np.ndarray     # (k, 2) triangles at the edge, -1 where there is none
    number: dict[tuple[int, int], int]  # (a, b): k

    def triangles_at(self, a: int, b: int) -> list[int]:
        """Returns the triangles at the edge between two points; none if it is no edge."""
        k = self.number.get((min(a, b), max(a, b)))
        return [] if k is None else [int(t) for t in self.sides[k] if t >= 0]


def find_edges(triangles: np.ndarray) -> Edges:
    """Returns the edges of triangles (m, 3)."""
    m = len(triangles)
    if m == 0:
        return Edges(np.zeros((0, 2), int), np.zeros((0, 3), int), np.zeros((0, 2), int), {})
    pairs = np.sort(np.stack([triangles[:, [1, 2]], triangles[:, [2, 0]], triangles[:, [0, 1]]], 1), axis=2)
    ends, where = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    of_triangle = where.reshape(m, 3)
    sides = np.full((len(ends), 2), -1)
    for t, row in enumerate(of_triangle):
        for k in row:
            sides[k, 0 if sides[k, 0] < 0 else 1] = t
    return Edges(ends, of_triangle, sides, {(int(a), int(b)): k for k, (a, b) in enumerate(ends)})


@dataclass
class Hinge:
    """Two segments a-b and b-c that resist bending; half of each segment belongs to the hinge."""
    nodes: tuple[int, int, int]  # (a, b, c)
    halves: tuple[Half, Half]    # half-length 0 on a clamped side
    joint: str = ""
    at_root: bool = False


def plan_hinges(wing: Wing) -> tuple[list[Hinge], np.ndarray]:
    """Returns the hinges of a wing, and the positions of ghost points, which are numbered after the points of the wing: a vein
    that ends at the clamped root is prolonged backwards. Where veins meet, joints come first, and then a spanning tree of the
    arms, straightest pairs first."""
    clamped, points = set(wing.root), wing.points
    names = sorted(wing.veins)
    ghosts: list[np.ndarray] = []
    hinges: list[Hinge] = []
    arms: dict[int, list[Arm]] = {}  # by point
    for name in names:
        nodes, diameters = wing.veins[name]
        for k, node in enumerate(nodes):
            for other in ([nodes[k - 1]] if k > 0 else []) + ([nodes[k + 1]] if k + 1 < len(nodes) else []):
                arms.setdefault(node, []).append((name, other, float(diameters[k])))

    def half(node: int, arm: Arm) -> Half:
        name, other, diameter = arm
        fixed = node in clamped and other in clamped
        return name, 0.0 if fixed else float(np.linalg.norm(points[other] - points[node])) / 2, diameter

    def add(node: int, one: Arm, other: Arm, joint: str = "") -> None:
        halves = half(node, one), half(node, other)
        still = [h[1] == 0 for h in halves]
        if not all(still):
            hinges.append(Hinge((one[1], node, other[1]), halves, joint, any(still)))

    for name in names:
        nodes, diameters = wing.veins[name]
        for k in range(1, len(nodes) - 1):
            d = float(diameters[k])
            add(nodes[k], (name, nodes[k - 1], d), (name, nodes[k + 1], d))
        for end, following, d in ((nodes[0], nodes[1], diameters[0]), (nodes[-1], nodes[-2], diameters[-1])):
            if end in clamped and following not in clamped:
                ghost = len(points) + len(ghosts)
                ghosts.append(2 * points[end] - points[following])
                hinges.append(Hinge((ghost, end, following), ((name, 0.0, float(d)), half(end, (name, following,
                                                                                                float(d)))), "", True))
    for joint in sorted(wing.joints):
        a, b, c = wing.joint_nodes(joint)
        known = [h for h in hinges if h.nodes[1] == b and {h.nodes[0], h.nodes[2]} == {a, c}]
        if known:
            known[0].joint = joint
            continue
        ends = {arm[1]: arm for arm in arms.get(b, [])}
        if a not in ends or c not in ends:
            raise InputError(f"joint {joint}: its points are not two segments of veins")
        add(b, ends[a], ends[c], joint)
    for node in sorted(arms):
        meeting = arms[node]
        if len(meeting) > 2 or len({arm[0] for arm in meeting}) > 1 or _listed_twice(wing, node):
            if node not in clamped:
                _span(node, meeting, hinges, add, points)
    return hinges, np.array(ghosts).reshape(-1, 3)


def _listed_twice(wing: Wing, node: int) -> bool:
    return sum(nodes.count(node) for nodes, _ in wing.veins.values()) > 1


def _span(node: int, arms: Sequence[Arm], hinges: Sequence[Hinge], add: Callable[[int, Arm, Arm], None], points: np.ndarray) -> None:
    """Connects the arms at a point that no hinge connects yet, pairs with the smallest turning angle first."""
    group = list(range(len(arms)))

    def unite(a: int, b: int) -> None:
        old, new = group[b], group[a]
        group[:] = [new if g == old else g for g in group]

    for hinge in hinges:
        if hinge.nodes[1] == node:
            ends = [[k for k, arm in enumerate(arms) if arm[1] == n] for n in (hinge.nodes[0], hinge.nodes[2])]
            if all(ends):
                unite(ends[0][0], ends[1][0])
    towards = [points[arm[1]] - points[node] for arm in arms]
    towards = [d / np.linalg.norm(d) for d in towards]
    pairs = sorted(((float(towards[a] @ towards[b]), a, b) for a in range(len(arms)) for b in range(a + 1, len(arms))))
    for _, a, b in pairs:
        if group[a] != group[b]:
            add(node, arms[a], arms[b])
            unite(a, b)


def locate(points: np.ndarray, triangles: np.ndarray, place: Sequence[float] | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the triangle of the unloaded wing that contains (x, y), and the barycentric weights of its corners."""
    a, b, c = (points[triangles[:, k], :2] for k in range(3))

    def turn(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    spot = np.broadcast_to(np.asarray(place, float), a.shape)
    shares = np.stack([turn(spot, b, c), turn(a, spot, c), turn(a, b, spot)], 1) / turn(a, b, c)[:, None]
    best = int(shares.min(1).argmax())
    if shares[best].min() < -1e-9:
        raise InputError(f"the place {place[0]:g}, {place[1]:g} m is not on the wing")
    return triangles[best], shares[best]
