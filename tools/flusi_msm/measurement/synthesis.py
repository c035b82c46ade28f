# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes synthetic bending tests: shapes under loads, measured in an imperfect experiment."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from multiprocessing import Pool
from typing import Any

import numpy as np

from flusi_msm.bending.mesh import Hinge, locate, refine
from flusi_msm.bending.model import Model
from flusi_msm.bending.statics import NoEquilibrium, Path, Report
from flusi_msm.measurement.case import ACCURACY, Case
from flusi_msm.measurement.grid import grid_lines
from flusi_msm.measurement.noise import HeightErrors, Streams
from flusi_msm.measurement.scan import scan
from flusi_msm.results.files import InputError
from flusi_msm.wing.file import Wing, read_wing

ROOT_TOLERANCE = 1e-11  # [rad] of the rotation of a compliant clamp

# Positions of a bent wing's points, displacement of the loaded place along the force, report, turn of the clamp.
Shape = tuple[np.ndarray, float, Report, np.ndarray]


@dataclass
class Load:
    """One measurement as it is stated, and as it really was."""
    name: str
    point: tuple[float, ...]  # [m] stated
    vector: np.ndarray  # [N] stated
    replicate: int
    level: float
    order: int = 0
    true_point: tuple[float, ...] = ()
    true_vector: np.ndarray = field(default_factory=lambda: np.full(3, np.nan))
    factor: float = 1.0        # on all stiffness
    factor_veins: float = 1.0  # on E of the veins, in addition to it


def rotation(v: np.ndarray) -> np.ndarray:
    """Returns the matrix of a rotation vector."""
    angle = float(np.linalg.norm(v))
    m = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    if angle < 1e-8:
        return np.eye(3) + m + m @ m / 2
    return np.eye(3) + np.sin(angle) / angle * m + (1 - np.cos(angle)) / angle**2 * (m @ m)


def rest_on_clamp(model: Model, path: Path, load: np.ndarray, start: np.ndarray | None = None) -> tuple[np.ndarray, Report, np.ndarray]:
    """Returns displacements under load (nodes, 3) of a wing whose clamp turns about y and x by its compliance times the moment,
    and a report. The clamped wing is solved in the frame of the turned clamp until the angles stay the same."""
    flap, twist = model.stiffness.root_compliance
    u, report = path.solve(load, start)
    if flap == 0 and twist == 0:
        return u, report, np.zeros(3)
    n = len(model.positions)
    centre = model.wing.points[list(model.wing.root)].mean(0)
    arm, turn = model.positions - centre, np.zeros(3)
    for _ in range(60):
        matrix = rotation(turn)
        lever = (arm + u[:n]) @ matrix.T
        moment = np.cross(lever, load[:n]).sum(0)
        wanted = np.array([twist * moment[0], flap * moment[1], 0.0])
        if np.abs(wanted - turn).max() < ROOT_TOLERANCE:
            moved = u.copy()
            moved[:n] = lever - arm
            return moved, report, turn
        turn = wanted
        if np.linalg.norm(turn) > 1:
            break
        snaps, factors = report.snaps, report.factorisations
        u, report = path.solve(load @ rotation(turn), u)
        report.snaps, report.factorisations = report.snaps + snaps, report.factorisations + factors
    raise NoEquilibrium("the clamp turns too far: root_compliance is too large for this load")


class Bench:
    """The experiment: a wing and the loads on it."""

    def __init__(self, case: Case) -> None:
        self.case, wing = case, with_soft_places(read_wing(case.wing), case)
        if len(wing.triangles) == 0:
            raise InputError(f"{case.wing}: has no triangles, so it has no surface to measure")
        self.mean_diameter = float(np.mean(np.concatenate([d for _, d in wing.veins.values()]))) if wing.veins else None
        self.coarse, self.wing = wing, refine(wing) if case.refine else wing
        self.streams = Streams(case.seed)
        self._bent: tuple[tuple[float, float], Path] | None = None  # factors on the stiffness, and the loading path of the wing with them

    def model(self, factor: float = 1.0, factor_veins: float = 1.0) -> Model:
        """Returns the wing with all its bending stiffness, and with that of its veins, multiplied by factors."""
        s = self.case.stiffness
        joints = {**s.joints, **{soft_name(k): row[2] for k, row in enumerate(self.case.hidden.soft_places)}}
        joints = {name: factor * value for name, value in joints.items() if value >= 0}
        s = replace(s, E=s.E * factor * factor_veins, D=s.D * factor, joints=joints)
        return Model(self.wing, s, self.mean_diameter, 2.0**self.case.refine)

    def loads(self) -> list[Load]:
        """Returns all measurements in the order of their names, with their true forces and places."""
        case, hidden, noise, result = self.case, self.case.hidden, self.case.noise, []
        for k, (point, vector) in enumerate(case.loads):
            for i, level in enumerate(case.protocol.levels):
                for r in range(case.protocol.repeats):
                    name = f"P{k + 1:02d}" + (f"_L{i + 1}" if len(case.protocol.levels) > 1 else "") \
                        + (f"_R{r + 1}" if case.protocol.repeats > 1 else "")
                    result.append(Load(name, point, level * vector, r + 1, level))
        places = np.arange(len(result))
        if case.protocol.random_order:
            places = self.streams("order").permutation(len(result))
        gain = hidden.force_gain * (1 + noise.force_gain * self.streams("force gain").standard_normal())
        a, tau = hidden.creep
        for number, load in enumerate(result):
            load.order = int(places[number]) + 1
            size = float(np.linalg.norm(load.vector))
            true = gain * size + hidden.force_offset + noise.force * self.streams("force", number).standard_normal()
            turn = rotation(np.array([*hidden.force_tilt, 0.0]))
            load.true_vector = turn @ load.vector * (true / size)
            load.true_point = self.true_point(load, number)
            load.factor = (1 + hidden.drift * (load.order - 1)) / (1 + a * np.log10(1 + case.protocol.hold / tau))
            load.factor_veins = 1 + hidden.drift_veins * (load.order - 1)
            if min(load.factor, load.factor_veins) <= 0:
                raise InputError("hidden.drift: leaves no stiffness")
        return result

    def true_point(self, load: Load, number: int) -> tuple[float, ...]:
        """Returns the place where the force really acts; a place off the wing is drawn again."""
        rng, wing = self.streams("position", number), self.wing
        try:
            locate(wing.points, wing.triangles, load.point)
            for _ in range(100):
                place = np.array(load.point) + self.case.hidden.load_shift \
                    + self.case.noise.position * rng.standard_normal(2)
                try:
                    locate(wing.points, wing.triangles, place)
                    return tuple(map(float, place))
                except InputError:
                    if self.case.noise.position == 0:
                        raise
        except InputError as error:
            raise InputError(f"load {load.name}: {error}") from None
        raise InputError(f"load {load.name}: its place is too close to the edge for noise.position")

    def bend(self, load: Load, start: np.ndarray | None = None) -> Shape:
        """Returns positions of the bent wing's points, the displacement of the loaded place along the force, and a report.
        `start` are displacements of all nodes for nearly this load and this wing."""
        factors = load.factor, load.factor_veins
        if self._bent is None or self._bent[0] != factors:
            self._bent = factors, Path(self.model(*factors))
        path = self._bent[1]
        model = path.model
        force = model.point_load(load.true_point, load.true_vector)
        try:
            u, report, turn = rest_on_clamp(model, path, force + self.weight(model), start)
        except NoEquilibrium as error:
            raise NoEquilibrium(f"load {load.name}: {error}") from None
        moved = float((force * u).sum() / np.linalg.norm(load.true_vector))
        return model.wing.points + u[:model.n_points], moved, report, turn

    def weight(self, model: Model) -> np.ndarray:
        """Returns the forces (nodes, 3) [N] of the weight."""
        hidden = self.case.hidden
        return model.weights(hidden.gravity, hidden.vein_density, hidden.areal_density)

    def rest(self) -> np.ndarray:
        """Returns positions of the points of the wing without a load: as in the wing file, with its camber, bent by its weight.
        """
        model = self.model()
        if not any(self.case.hidden.gravity):
            return model.wing.points
        return model.wing.points + rest_on_clamp(model, Path(model), self.weight(model))[0][:model.n_points]


def soft_name(k: int) -> str:
    """Returns the name of the joint at a soft place."""
    return f"soft{k + 1}"


def with_soft_places(wing: Wing, case: Any) -> Wing:
    """Returns the wing with additional hinges at hidden places; each is at the point inside the vein that is nearest to the
    given part of its length."""
    joints = dict(wing.joints)
    for k, (vein, share, _) in enumerate(case.hidden.soft_places):
        if vein not in wing.veins:
            raise InputError(f"hidden.soft_places: no vein {vein}; the wing has {', '.join(sorted(wing.veins))}")
        nodes = wing.veins[vein][0]
        way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(wing.points[nodes], axis=0), axis=1))])
        if len(nodes) < 3:
            raise InputError(f"hidden.soft_places: vein {vein} has no inner point")
        at = 1 + int(np.abs(way[1:-1] / way[-1] - share).argmin())
        taken = [j for j in wing.joints if wing.joint_nodes(j)[1] == nodes[at]]
        if taken:
            raise InputError(f"hidden.soft_places: joint {taken[0]} is already there")
        joints[soft_name(k)] = (vein, nodes[at])
    return Wing(wing.points, wing.triangles, wing.veins, joints, wing.root, wing.title)


def _bend(task: tuple[Bench, Load]) -> Shape:
    bench, load = task
    return bench.bend(load)


def synthesise(case: Case, jobs: int = 1, tell: Callable[[str], None] = lambda text: None) -> tuple[dict[str, Any], dict[str, Any]]:
    """Makes the test: returns a dictionary for `write_test`, and the truth about it."""
    bench = Bench(case)
    loads = bench.loads()
    tasks = [(bench, load) for load in loads]
    shapes = []
    with Pool(jobs) if jobs > 1 else _Alone() as pool:
        for load, shape in zip(loads, pool.imap(_bend, tasks)):
            shapes.append(shape)
            tell(f"{load.name:10s} {1e3 * np.linalg.norm(load.true_vector):10.4f} mN  moves its place by "
                 f"{1e3 * shape[1]:8.4f} mm  {shape[2].factorisations:4d} factorisations  {shape[2].snaps} snaps")
    return observe(bench, loads, shapes, bench.rest())


def plan(bench: Bench, loads: Sequence[Load]) -> dict[str, Any]:
    """Returns what is stated before anything is measured: a dictionary for `write_test`."""
    case = bench.case
    low, high = bench.wing.points.min(0), bench.wing.points.max(0)
    x, y = (grid_lines(low[k], high[k], case.spacing) for k in range(2))
    stated = []
    for load in loads:
        size = float(np.linalg.norm(load.vector))
        stated.append({"name": load.name, "z": None, "force": size, "direction": load.vector / size, "point": load.point,
                       "order": load.order, "replicate": load.replicate,
                       "time": (load.order - 1) * case.protocol.interval, "hold": case.protocol.hold})
    return {"x": x, "y": y, "z": None, "loads": stated, "accuracy": declare(case), "calibration": case.calibration,
            "title": case.title, "reference_scans": case.noise.reference_scans}


def observe(bench: Bench, loads: Sequence[Load], shapes: Sequence[Shape], unloaded: np.ndarray) -> tuple[dict[str, Any], dict[str, Any]]:
    """Simulates the measurement of the shapes (as from `bend`) and of the positions of the unloaded wing: returns a dictionary
    for `write_test`, and the truth about it."""
    case, hidden = bench.case, bench.case.hidden
    content = plan(bench, loads)
    x, y = content["x"], content["y"]
    errors = HeightErrors(case.noise, x, y, bench.streams)
    rest = scan(unloaded, bench.wing.triangles, x - hidden.map_shift[0], y - hidden.map_shift[1])
    content["z"] = rest * hidden.height_scale + errors.reference() + fringes(bench, x, y, 0)
    truth: dict[str, Any] = {"case": asdict(case), "mesh": {"points": len(bench.wing.points), "triangles": len(bench.wing.triangles)},
             "joints": joint_truth(bench), "loads": []}
    # A part of the previous deformation remains at every point of the wing, also at points that were not measured then.
    remains, past = {}, 0.0
    for number in sorted(range(len(loads)), key=lambda k: loads[k].order):
        remains[number] = past
        past = hidden.memory * (shapes[number][0] - unloaded)
    span = (x - bench.wing.points[list(bench.wing.root), 0].mean()) / np.ptp(bench.wing.points[:, 0])
    for number, (load, (positions, moved, report, turn)) in enumerate(zip(loads, shapes)):
        tilt, piston = errors.plane(number)
        tilt, piston = tilt + hidden.tilt, piston + hidden.piston
        shift = errors.shift(number) + hidden.map_shift
        z = scan(positions + remains[number], bench.wing.triangles, x - shift[0], y - shift[1])
        known = np.isfinite(z)
        z = z * hidden.height_scale + tilt[0] * y[:, None] - tilt[1] * x[None, :] + piston
        z = z + errors.one_scan(number) + errors.outliers(number) + fringes(bench, x, y, number + 1)
        z += hidden.bow * (load.order - 1) * span**2
        z[errors.missing(number, known)] = np.nan
        content["loads"][number]["z"] = z
        truth["loads"].append({
            "name": load.name, "order": load.order, "force": load.true_vector.tolist(), "point": list(load.true_point),
            "stiffness_factor": load.factor, "vein_factor": load.factor_veins, "moved": moved, "snaps": report.snaps,
            "residual": report.residual, "factorisations": report.factorisations, "clamp_turn": turn.tolist(),
            "tilt": tilt.tolist(), "piston": piston, "shift": shift.tolist(),
            "missing": float(1 - np.isfinite(z[known]).mean())})
    return content, truth


def fringes(bench: Bench, x: np.ndarray, y: np.ndarray, scan_number: int) -> np.ndarray | float:
    """Returns the waves of a profilometer's light on the grid, with another phase in every scan; scan 0 is the unloaded wing."""
    amplitude, length, angle = bench.case.hidden.fringe
    if amplitude == 0:
        return 0.0
    along = np.add.outer(y * np.sin(angle), x * np.cos(angle))
    return amplitude * np.sin(2 * np.pi * (along / length + bench.streams("fringe", scan_number).random()))


class _Alone:
    """A pool with one worker, which is this process."""

    def __enter__(self) -> _Alone:
        self.imap = map
        return self

    def __exit__(self, *_: object) -> None:
        """Leaves exceptions as they are."""


def declare(case: Case) -> dict[str, float]:
    """Returns the declared accuracy: the true sd unless `declared` has another one."""
    n = case.noise
    true = {"height": float(np.hypot(n.height, n.correlated)),
            "correlation_length": n.correlation_length if n.correlated > 0 else 0.0, "force": n.force,
            "force_gain": n.force_gain, "position": n.position, "tilt": n.tilt, "piston": n.piston}
    stated = {key: float(case.declared.get(key, true[key])) for key in ACCURACY}
    if not stated["height"] > 0:
        raise InputError("the sd of the heights to be stated is 0: set declared.height")
    return stated


def joint_truth(bench: Bench) -> dict[str, dict[str, float]]:
    """Returns the stiffness of all joints [N m/rad]: on the mesh of the computation, and the stiffness that a hinge of the wing
    file's mesh needs for the same bending of the vein around it."""
    fine, coarse = bench.model(), Model(bench.coarse, replace(bench.case.stiffness, joints={}))
    def compliance(hinge: Hinge, model: Model) -> float:
        return 1 / model.hinge_stiffness(hinge, with_joint=False)

    plain = {h.joint: compliance(h, coarse) for h in coarse.hinge_plan if h.joint}
    result = {}
    for h in fine.hinge_plan:
        if h.joint:
            k, own = fine.hinge_stiffness(h), compliance(h, fine)
            result[h.joint] = {"stiffness": k, "on_wing_file": 1 / (1 / k + plain[h.joint] - own)}
    return result
