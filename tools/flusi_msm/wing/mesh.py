# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a wing from a network: lines are divided into edges of the length wanted, and the membrane is filled with triangles.

Gmsh fills the membrane (C. Geuzaine and J.-F. Remacle 2009, DOI 10.1002/nme.2579), with the edges of all lines embedded in it. If
its shared library cannot be loaded, the triangulation of this package is used.
"""
from __future__ import annotations

from types import ModuleType
from typing import Callable

import numpy as np

from flusi_msm.errors import InputError, Problems
from flusi_msm.wing.file import Wing, sorted_wing
from flusi_msm.wing.network import Network
from flusi_msm.wing.trace import Trace, diameter_at
from flusi_msm.wing.triangulate import Triangulation

POINTS = 1000          # of a wing without a given edge length
MOST_POINTS = 20000    # more is a mistake in the edge length
SMALLEST = 0.25        # edges between lines that are close, by the edge length wanted
SHAKE, SHAKES = 1e-7, 5  # of the wing's size; how often
GROWTH = 0.35          # of the edge length per distance from such places
Size = Callable[[np.ndarray], np.ndarray]


def default_edge(area: float) -> float:
    """Returns the edge length [m] with which a membrane of this area [m^2] has about POINTS points."""
    return float(np.sqrt(area / (POINTS * np.sqrt(3) / 2)))


def size_field(net: Network, edge: float) -> Size:
    """Returns the edge length wanted at points (m, 2): `edge`, but less between lines that are close and do not meet."""
    points: list[np.ndarray] = []
    owners: list[int] = []
    for k, branch in enumerate(net.branches):
        s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(branch.points, axis=0), axis=1))])
        at = np.linspace(0, s[-1], max(2, int(np.ceil(2 * s[-1] / edge)) + 1))
        points.append(np.stack([np.interp(at, s, branch.points[:, i]) for i in (0, 1)], axis=1))
        owners += [k] * len(at)
    p, owner = np.concatenate(points), np.array(owners)
    ends = np.array([(b.first, b.last) for b in net.branches])
    meet = (ends[:, None, :, None] == ends[None, :, None, :]).any((2, 3))
    gap = np.full(len(p), np.inf)
    for first in range(0, len(p), 512):
        rows = slice(first, first + 512)
        distance = np.linalg.norm(p[rows, None] - p, axis=2)
        distance[meet[owner[rows]][:, owner]] = np.inf
        gap[rows] = distance.min(1)
    close = gap < edge
    source, least = p[close], np.maximum(gap[close], SMALLEST * edge)

    def size(places: np.ndarray) -> np.ndarray:
        places = np.atleast_2d(places)
        if not len(source):
            return np.full(len(places), edge)
        distance = np.linalg.norm(places[:, None] - source, axis=2)
        return np.minimum(edge, (least + GROWTH * distance).min(1))

    return size


def divide(points: np.ndarray, size: Size, pieces: int = 0) -> np.ndarray:
    """Returns points on a line, ends included, whose distances are those wanted; with `pieces` that many pieces."""
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    fine = np.unique(np.concatenate([s, np.linspace(0, s[-1], 33)]))
    dense = np.stack([np.interp(fine, s, points[:, i]) for i in (0, 1)], axis=1)
    middle = (dense[:-1] + dense[1:]) / 2
    count = np.concatenate([[0], np.cumsum(np.diff(fine) / size(middle))])
    pieces = pieces or max(1, int(count[-1] + 0.5))
    at = np.interp(np.linspace(0, count[-1], pieces + 1), count, fine)
    made = np.stack([np.interp(at, s, points[:, i]) for i in (0, 1)], axis=1)
    made[0], made[-1] = points[0], points[-1]
    return made


def fill_with_gmsh(gmsh: ModuleType, points: np.ndarray, loop: list[int], inner: list[tuple[int, int]], size: Size) \
        -> tuple[np.ndarray, np.ndarray]:
    """Returns triangles inside the closed line through the points `loop`, among whose edges are the edges `inner`."""
    scale = float(np.ptp(points, axis=0).max())
    was_running = gmsh.isInitialized()
    if not was_running:
        gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.model.add("wing")
        for name, value in (("General.Terminal", 0), ("General.NumThreads", 1), ("Mesh.Algorithm", 6),
                            ("Mesh.MeshSizeExtendFromBoundary", 0), ("Mesh.MeshSizeFromPoints", 0), ("Mesh.RandomSeed", 1)):
            gmsh.option.setNumber(name, value)
        geo = gmsh.model.geo
        for k, p in enumerate(points):
            geo.addPoint(p[0] / scale, p[1] / scale, 0.0, 0.0, k + 1)
        margin = [geo.addLine(a + 1, b + 1) for a, b in zip(loop, loop[1:] + loop[:1])]
        veins = [geo.addLine(a + 1, b + 1) for a, b in inner]
        surface = geo.addPlaneSurface([geo.addCurveLoop(margin)])
        for line in margin + veins:
            geo.mesh.setTransfiniteCurve(line, 2)
        geo.synchronize()
        if veins:
            gmsh.model.mesh.embed(1, veins, 2, surface)
        gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z, lc: float(size(np.array([[x, y]]) * scale)[0]) / scale)
        try:
            gmsh.model.mesh.generate(2)
        except Exception as error:  # gmsh raises plain exceptions
            raise InputError(f"Gmsh could not fill the wing with triangles: {error}") from None
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        number = {int(tag): len(points) + i for i, tag in enumerate(tags)}
        for k in range(len(points)):
            number[int(gmsh.model.mesh.getNodes(0, k + 1)[0][0])] = k
        _, corners = gmsh.model.mesh.getElementsByType(2)
        where = {number[int(tag)]: xyz[:2] * scale for tag, xyz in zip(tags, coordinates.reshape(-1, 3))}
        triangles = np.array([number[int(tag)] for tag in corners]).reshape(-1, 3)
    finally:
        gmsh.model.mesh.removeSizeCallback()
        gmsh.model.remove()
        if not was_running:
            gmsh.finalize()
    used = np.unique(triangles)
    free = used[used >= len(points)]
    renumber = {int(k): len(points) + i for i, k in enumerate(free)}
    triangles = np.vectorize(lambda k: renumber.get(int(k), int(k)), otypes=[int])(triangles)
    return np.concatenate([points, np.array([where[int(k)] for k in free]).reshape(-1, 2)]), triangles


def fill_without_gmsh(points: np.ndarray, segments: list[tuple[int, int]], size: Size) -> tuple[np.ndarray, np.ndarray]:
    """Returns the same by the triangulation of this package."""
    scale = float(np.ptp(points, axis=0).max())
    known: dict[tuple[int, int], float] = {}

    def cached(p: tuple[float, float]) -> float:
        cell = (int(400 * p[0]), int(400 * p[1]))
        if cell not in known:
            known[cell] = float(size((np.array([cell]) + 0.5) / 400 * scale)[0]) / scale
        return known[cell]

    # Points of straight lines and of circles are degenerate for a triangulation: they are slightly displaced while it is made.
    for seed in range(SHAKES):
        shaken = points / scale + SHAKE * np.random.RandomState(seed).uniform(-1, 1, points.shape)
        try:
            mesh = Triangulation([tuple(p) for p in shaken.tolist()], segments)
            mesh.refine(cached)
            mesh.points[:len(points)] = [tuple(p) for p in (points / scale).tolist()]
            mesh.smooth(cached, 24)
        except (ValueError, KeyError, StopIteration, ZeroDivisionError) as error:
            why = str(error)
        else:
            return np.array(mesh.points) * scale, np.array(mesh.triangles())
    raise InputError(f"the wing could not be filled with triangles ({why}): install gmsh, or choose another --edge")


def load_gmsh(problems: Problems) -> ModuleType | None:
    """Returns the module gmsh, or None with a notice if it cannot be loaded."""
    try:
        import gmsh
    except ModuleNotFoundError:
        problems.notice("the Python package gmsh is not installed: the mesh is made without it (python -m pip install -r "
                        "tools/requirements-mesh.txt)")
    except OSError as error:
        problems.notice(f"gmsh cannot be loaded ({error}): the mesh is made without it; on Debian and Ubuntu install libgl1 "
                        "libglu1-mesa libxrender1 libxcursor1 libxfixes3 libxft2 libxinerama1 libgomp1")
    else:
        return gmsh
    return None


def mesh_wing(trace: Trace, net: Network, edge: float, mesher: str, problems: Problems) -> Wing:
    """Returns the wing with edges of about `edge` [m]. `mesher`: gmsh, own, or auto, which uses gmsh if it can be loaded."""
    estimate = abs(_area(net)) / (edge**2 * np.sqrt(3) / 2)
    if estimate > MOST_POINTS:
        raise InputError(f"an edge length of {1e3 * edge:.3g} mm would give about {estimate:.0f} points: choose --edge larger")
    size = size_field(net, edge)
    lines = [divide(branch.points, size) for branch in net.branches]
    ends: dict[tuple[int, int], list[int]] = {}
    for k, branch in enumerate(net.branches):
        if len(lines[k]) == 2:
            ends.setdefault((min(branch.first, branch.last), max(branch.first, branch.last)), []).append(k)
    for twins in ends.values():                       # two straight edges between the same nodes would be one
        for k in sorted(twins, key=lambda k: len(net.branches[k].points))[1:]:
            lines[k] = divide(net.branches[k].points, size, 2)
    points = [p for p in net.nodes]
    numbers = []
    for branch, line in zip(net.branches, lines):
        numbers.append([branch.first, *range(len(points), len(points) + len(line) - 2), branch.last])
        points += list(line[1:-1])
    loop = [i for k in net.outline for i in numbers[k][:-1]]
    on_margin = set(net.outline)
    inner = [pair for k, chain in enumerate(numbers) if k not in on_margin for pair in zip(chain, chain[1:])]
    segments = inner + list(zip(loop, loop[1:] + loop[:1]))
    used = sorted({i for pair in segments for i in pair})
    if len(used) < len(points):
        raise AssertionError("a node belongs to no line")
    array = np.array(points)
    _check_crossings(trace, net, array, numbers, problems)
    problems.stop_if_any()
    gmsh = load_gmsh(problems) if mesher in ("auto", "gmsh") else None
    if gmsh is None and mesher == "gmsh":
        raise InputError(problems.notices.pop())
    xy, triangles = fill_with_gmsh(gmsh, array, loop, inner, size) if gmsh is not None else \
        fill_without_gmsh(array, segments, size)
    space = np.zeros((len(xy), 3))
    space[:, :2] = xy
    turned = _signed_areas(xy, triangles) < 0
    triangles[turned] = triangles[turned][:, ::-1]
    veins = {}
    for vein in trace.veins:
        nodes: list[int] = []
        for k, forward in net.veins[vein.name]:
            nodes += (numbers[k] if forward else numbers[k][::-1])[1 if nodes else 0:]
        s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(xy[nodes], axis=0), axis=1))])
        veins[vein.name] = (nodes, diameter_at(vein.diameters or [], s / s[-1]))
    joints = {}
    for name, (names, node) in net.joints.items():
        joints[name] = (names[0], node) if len(names) == 1 else \
            (_neighbour(veins[names[0]][0], node, False), node, _neighbour(veins[names[1]][0], node, True))
    root = sorted({i for k in net.root for i in numbers[k]})
    return sorted_wing(Wing(space, triangles, veins, joints, root, trace.title, trace.z_side))


def _check_crossings(trace: Trace, net: Network, points: np.ndarray, numbers: list[list[int]], problems: Problems) -> None:
    """Checks that straight edges do not cross where the curves that they replace do not."""
    owner = {k: f"vein '{name}'" for name, chain in net.veins.items() for k, _ in chain}
    pairs = np.array([pair for chain in numbers for pair in zip(chain, chain[1:])])
    line = np.array([k for k, chain in enumerate(numbers) for _ in chain[1:]])
    a, b = points[pairs[:, 0]], points[pairs[:, 1]]
    low, high = np.minimum(a, b), np.maximum(a, b)
    near = ((low[:, None] <= high) & (low <= high[:, None])).all(2)
    i, j = np.nonzero(np.triu(near, 1))
    apart = (pairs[i][:, :, None] != pairs[j][:, None, :]).all((1, 2))
    i, j = i[apart], j[apart]

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        return (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])

    cross = (side(a[i], b[i], a[j]) * side(a[i], b[i], b[j]) <= 0) & (side(a[j], b[j], a[i]) * side(a[j], b[j], b[i]) <= 0)
    for p, q in zip(i[cross], j[cross]):
        names = sorted({owner.get(int(line[k]), "the outline") for k in (p, q)})
        told = " and ".join(names) if len(names) == 2 else f"two pieces of {names[0]}"
        told = told.replace("' and vein '", "' and '").replace("vein", "veins", 1) if told.count("vein") == 2 else told
        x, y = 1e3 * (a[p] + b[p]) / 2
        problems.error(f"{trace.source}: {told} would cross in the mesh near ({x:.3g}, {y:.3g}) mm: choose --edge smaller, or draw "
                       "them further apart")
        break


def _neighbour(nodes: list[int], node: int, is_after: bool) -> int:
    """Returns the point of a vein before or after one of its points; the other one where the vein ends."""
    i = nodes.index(node)
    if is_after:
        return nodes[i + 1] if i + 1 < len(nodes) else nodes[i - 1]
    return nodes[i - 1] if i > 0 else nodes[i + 1]


def _area(net: Network) -> float:
    x, y = np.concatenate([net.branches[k].points[:-1] for k in net.outline]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def _signed_areas(xy: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (xy[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2


def missing_edges(wing: Wing) -> list[tuple[str, np.ndarray]]:
    """Returns segments of veins that are no edges of triangles, as vein and place [m]; none in a good mesh."""
    mesh = {tuple(e) for e in wing.edges()[0].tolist()}
    return [(name, wing.points[list(pair), :2].mean(0)) for name, (nodes, _) in wing.veins.items()
            for pair in zip(nodes, nodes[1:]) if tuple(sorted(pair)) not in mesh]
