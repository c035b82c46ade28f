# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes natural modes of a synthetic wing with the errors of an experiment, for `make_modes` alone. It uses the stiffness of the
synthetic bending tests, and masses assembled here. Nothing is shared with the solver in src or with what is fitted to the data.
"""
from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh

from flusi_msm.bending.mesh import locate, refine
from flusi_msm.bending.model import Model, Stiffness
from flusi_msm.bending.statics import Path as LoadingPath
from flusi_msm.errors import InputError
from flusi_msm.measurement.case import load_of
from flusi_msm.measurement.case_file import build, mistakes_in, read_json
from flusi_msm.wing.file import Wing, read_wing

DECAYING = 40  # undamped modes in which damped ones are found
LEAST = 0.1    # share of an undamped mode in the motion that is taken for its damped one
Density = Callable[[np.ndarray], np.ndarray]  # areal density [kg/m^2] at places (n, 2)


class Measured(NamedTuple):
    """A measured mode."""
    name: str
    frequency: float       # [Hz]
    frequency_sd: float
    places: np.ndarray     # (n, 2) [m]
    shape: np.ndarray      # (n)
    sd: np.ndarray         # (n) of the shape
    damping: float = -1.0  # ratio; negative: not measured
    damping_sd: float = 0.0


@dataclass
class Mass:
    """The mass of the wing, and a point mass on it."""
    vein_density: float = 0.0         # [kg/m^3]; 0: that of the wing file, or 1300
    membrane_mass: float = 0.0        # [kg]; 0: that of the wing file, or 81.475e-9
    veins: float = 1.0                # factors on both
    membrane: float = 1.0
    membrane_gradient: float = 0.0    # g: exp(g (x/R - 1/2)) on the mass of the membrane
    membrane_wave: tuple[float, ...] = ()  # (a, x length, y length [m]): 1 + a sin(2 pi (x/lx + y/ly)) on it
    point: tuple[float, ...] = ()     # (x, y [m], mass [kg]) on the wing
    consistent: bool = False          # masses of linear elements in the place of lumped ones


@dataclass
class Damping:
    """The causes of damping. Names are those of [Damping] of `flusi` where it has them."""
    rayleigh_mass: float = 0.0        # [1/s]
    rayleigh_stiffness: float = 0.0   # [s]
    joint_friction: float = 0.0       # [s] moment per rate of the elastic moment of joints
    relaxation: float = 0.0           # g: for a sudden force the stiffness is 1 + g times larger
    relaxation_time: float = 1.0e-3   # [s]
    drag: float = 0.0                 # [kg/m^3] force -c a |v| v along z of every node with the area a of membrane, in air

    def check(self) -> None:
        """Refuses a relaxation without a time."""
        if not self.relaxation_time > 0:
            raise InputError(f"damping.relaxation_time: must be positive, not {self.relaxation_time}; set damping.relaxation=0 for none")


@dataclass
class Noise:
    """Relative standard deviations: of frequencies, of shapes over their largest value, and of damping ratios."""
    frequency: float = 0.005
    shape: float = 0.02
    damping: float = 0.05


@dataclass
class Case:
    """A test of natural modes."""
    wing: str
    refine: int = 0
    seed: int = 1
    title: str = ""
    modes: int = 5                    # number of modes across the wing that are measured, the lowest ones
    missing: tuple[int, ...] = ()     # numbers of modes among these that are not detected
    sites: int = 24                   # places of the wing that are measured
    medium: str = "air"
    air_density: float = 1.2          # [kg/m^3]
    air_ratio: float = 0.8            # of the air that moves with the wing to that of strip theory
    loads: list[Any] = field(default_factory=list)  # forces that bend the wing while it vibrates, as in make_measurement
    gravity: tuple[float, ...] = (0.0, 0.0, 0.0)  # [m/s^2] acceleration; the weight bends the wing, too
    name: str = "mode"                # the names of modes in the file are this and a number
    stiffness: Stiffness = field(default_factory=Stiffness)
    mass: Mass = field(default_factory=Mass)
    damping: Damping = field(default_factory=Damping)  # without any, no ratio is measured; drag has no ratio
    noise: Noise = field(default_factory=Noise)


def read_case(path: str | Path, changes: Sequence[str] = ()) -> Case:
    """Returns the case in a JSON file, with changes `section.key=value`; the path of the wing is relative to the file's folder.
    """
    with mistakes_in(path, changes):
        case = build(Case, read_json(path, changes), "")
        if case.medium not in ("air", "vacuum"):
            raise InputError(f"medium is air or vacuum, not {case.medium}")
        case.damping.check()
        if case.damping.drag:
            raise InputError("damping.drag: drag with the square of the speed has no damping ratio; give it to make_series")
        if case.stiffness.pretension or any(case.stiffness.camber):
            raise InputError("modes are those of a wing that is flat and free of stress at rest: no pretension, no camber")
        if any(case.stiffness.root_compliance) and is_loaded(case):
            raise InputError("modes under loads are those of a stiff clamp: no root_compliance")
        case.loads = [load_of(row, number) for number, row in enumerate(case.loads, 1)]
        case.wing = str(Path(path).parent / case.wing)
    return case


def is_loaded(case: Case) -> bool:
    """Returns whether forces or the weight bend the wing."""
    return bool(case.loads) or any(case.gravity)


def densities(wing: Wing, mass: Mass) -> tuple[float, Density]:
    """Returns the density of the veins [kg/m^3], and the areal density [kg/m^2] of the membrane as a function of places (n, 2).
    """
    stated = wing.mass
    vein = mass.vein_density or (stated.vein_density if stated and stated.vein_density else 1300.0)
    total = mass.membrane_mass or (stated.membrane if stated else 81.475e-9)
    weights = (1.0, 0.0, 0.0) if stated and stated.law == "uniform" else \
        stated.weights if stated else (1.75, -147.0, 101.0)
    triangles = np.asarray(wing.triangles)
    middle = wing.points[triangles].mean(1)[:, :2]

    def law(places: np.ndarray) -> np.ndarray:
        return weights[0] + weights[1] * places[:, 0] + weights[2] * places[:, 1]
    scale = total / (law(middle) * triangle_areas(wing)).sum()
    root, span = wing.points[list(wing.root), 0].mean(), np.ptp(wing.points[:, 0])

    def areal(places: np.ndarray) -> np.ndarray:
        value = mass.membrane * scale * law(places) * np.exp(mass.membrane_gradient * ((places[:, 0] - root) / span - 0.5))
        if mass.membrane_wave:
            a, *lengths = mass.membrane_wave
            value = value * (1 + a * np.sin(2 * pi * sum(places[:, k] / length for k, length in enumerate(lengths) if length > 0)))
        return value
    return mass.veins * vein, areal


def triangle_areas(wing: Wing) -> np.ndarray:
    """Returns the areas of all triangles [m^2]."""
    a, b, c = (wing.points[np.asarray(wing.triangles)[:, k], :2] for k in range(3))
    return 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def mass_matrix(wing: Wing, case: Any, n_nodes: int) -> tuple[sparse.csc_matrix, sparse.csc_matrix]:
    """Returns the mass [kg] between nodes for motion in the plane and across it, sparse (n_nodes, n_nodes) each."""
    mass, triangles = case.mass, np.asarray(wing.triangles)
    vein, areal = densities(wing, mass)
    rows, columns, values = [], [], []

    def element(nodes: np.ndarray, matrix: np.ndarray) -> None:
        nodes = np.asarray(nodes)
        rows.append(np.repeat(nodes, nodes.shape[-1], axis=-1).ravel())
        columns.append(np.tile(nodes, (1,) * (nodes.ndim - 1) + (nodes.shape[-1],)).ravel())
        values.append(np.asarray(matrix).ravel())
    area = triangle_areas(wing)
    midpoints = [(wing.points[triangles[:, k], :2] + wing.points[triangles[:, (k + 1) % 3], :2]) / 2 for k in range(3)]
    shape = 0.5 * np.array([[1, 1, 0], [0, 1, 1], [1, 0, 1]])  # of the corners at the midpoints of the sides

    def membrane(density: Density) -> np.ndarray:
        out = np.zeros((len(triangles), 3, 3))
        for k in range(3):
            weight = area / 3 * density(midpoints[k])
            out += weight[:, None, None] * (np.outer(shape[k], shape[k]) if mass.consistent else np.diag(shape[k]))[None]
        return out
    element(triangles, membrane(areal))
    for nodes, diameters in wing.veins.values():
        for a, b, da, db in zip(nodes[:-1], nodes[1:], diameters[:-1], diameters[1:]):
            length = np.linalg.norm(wing.points[b] - wing.points[a])
            moments = np.zeros((2, 2))
            for s, w in zip((0.5 - 0.15**0.5, 0.5, 0.5 + 0.15**0.5), (5 / 18, 8 / 18, 5 / 18)):  # Gauss rule, exact here
                at = np.array([1 - s, s])
                piece = w * vein * pi / 4 * (da + s * (db - da))**2 * length
                moments += piece * (np.outer(at, at) if mass.consistent else np.diag(at))
            element(np.array([[a, b]]), moments)
    if mass.point:
        corners, shares = locate(wing.points, triangles, mass.point[:2])
        element(np.asarray(corners)[None], mass.point[2] * np.diag(shares))

    def assemble() -> sparse.csc_matrix:
        return sparse.csc_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (n_nodes, n_nodes))
    plane = assemble()
    if case.medium == "air":
        chord = strips(wing)
        rows, columns, values = [], [], []
        element(triangles, membrane(lambda places: case.air_density * case.air_ratio * carried(places, chord)))
        return plane, plane + assemble()
    return plane, plane


def strips(wing: Wing) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns stations x [m], and the lower and upper ends y [m] of the wing there."""
    points, triangles = wing.points, np.asarray(wing.triangles)
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    x = np.linspace(points[:, 0].min(), points[:, 0].max(), 801)
    a, b = points[sides[:, 0], :2], points[sides[:, 1], :2]
    low, high = np.full(x.shape, np.inf), np.full(x.shape, -np.inf)
    for k, station in enumerate(x):
        crosses = (a[:, 0] - station) * (b[:, 0] - station) <= 0
        one, two = a[crosses], b[crosses]
        dx = two[:, 0] - one[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            y = np.where(np.abs(dx) > 0, one[:, 1] + (station - one[:, 0]) / dx * (two[:, 1] - one[:, 1]), one[:, 1])
        low[k], high[k] = y.min(), y.max()
    return x, low, high


def carried(places: np.ndarray, chord: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Returns the mass of air per area over its density [m]: the jump of the potential of a plate that moves normal to itself."""
    x, low, high = chord
    below, above = np.interp(places[:, 0], x, low), np.interp(places[:, 0], x, high)
    return 2 * np.sqrt(np.maximum(0, (above - places[:, 1]) * (places[:, 1] - below)))


def is_damped(case: Case) -> bool:
    """Returns whether the wing loses energy."""
    d = case.damping
    return any((d.rayleigh_mass, d.rayleigh_stiffness, d.joint_friction, d.relaxation))


def find_decays(wing: Wing, case: Case, coarse: Wing | None, found: list[tuple[float, np.ndarray]]) -> list[tuple[float, float]]:
    """Returns [(frequency [Hz], damping ratio)] of these modes: |s|/(2 pi) and -Re s/|s| of the roots s of M s^2 + C s
    + K (1 + g s/(s + 1/tau)) in the space of the lowest undamped modes, so that damping also couples the modes. Joints have the friction
    of the flat wing. Refuses a wing of which one of these modes does not swing."""
    every = np.concatenate([d for _, d in (coarse or wing).veins.values()])
    model = Model(wing, case.stiffness, float(np.mean(every)), 2.0 if coarse is not None else 1.0)
    k, m, moving = matrices(wing, case, model)
    values, phi = lowest_modes(k, m, DECAYING)
    d, n = case.damping, len(values)
    c = d.rayleigh_mass * np.eye(n) + d.rayleigh_stiffness * np.diag(values)
    if d.joint_friction:
        joints = {h.joint: 2 * model.hinge_stiffness(h) for h in model.hinge_plan if h.joint}
        twice = Model(wing, replace(case.stiffness, joints=joints), float(np.mean(every)), 2.0 if coarse is not None else 1.0)
        c = c + d.joint_friction * (phi.T @ ((resting_stiffness(twice) - resting_stiffness(model)) @ phi))
    zero, one = np.zeros((n, n)), np.eye(n)
    roots, vectors = np.linalg.eig(np.block([[zero, one, zero], [-np.diag(values), -c, -d.relaxation * np.diag(values)],
                                             [zero, one, -one / d.relaxation_time]]))
    decays = []
    turning = roots.imag > 0
    for number, (hertz, _) in enumerate(found, 1):
        mode = np.argmin(np.abs(values - (2 * pi * hertz)**2))
        share = np.abs(vectors[mode, turning])**2 / (np.abs(vectors[:n, turning])**2).sum(0)
        if share.max(initial=0.0) < LEAST:
            raise InputError(f"mode {number} of {hertz:.4g} Hz is damped so much that it does not swing: make the values of damping "
                             "smaller")
        s = roots[turning][np.argmax(share)]
        decays.append((abs(s) / (2 * pi), -s.real / abs(s)))
    return decays


def matrices(wing: Wing, case: Case, model: Model) -> tuple[sparse.csc_matrix, sparse.csc_matrix, np.ndarray]:
    """Returns stiffness and mass of the wing about its shape under the loads of the case, and the numbers of the nodes that move."""
    plane, across = mass_matrix(wing, case, model.n_nodes)
    moving = np.flatnonzero(model.moves)
    parts = []
    for k, matrix in enumerate((plane, plane, across)):
        m = matrix[moving][:, moving].tocoo()
        parts.append(sparse.csc_matrix((m.data, (3 * m.row + k, 3 * m.col + k)), (3 * len(moving),) * 2))
    bent = loaded_shape(wing, model, case, plane)
    axial = model.springs.forces(bent) if is_loaded(case) else np.zeros(len(model.springs.k))  # no spring is stretched at rest
    return on_clamp(model, sparse.csc_matrix(model.tangent(bent, axial))), sum(parts), moving


def on_clamp(model: Model, k: sparse.csc_matrix) -> sparse.csc_matrix:
    """Returns the stiffness of a wing whose clamp turns about x and y by its compliance C times the moment, from the stiffness k on a
    fixed clamp: the inverse of k^-1 + R C R^T with the rigid rotations R, by the formula of Woodbury. Forces of R are those of hinges and
    springs at the root."""
    flap, twist = model.stiffness.root_compliance
    if not flap and not twist:
        return k
    if model.n_nodes > len(model.positions):
        raise InputError("stiffness.root_compliance: natural modes and records of motion need stiffness.plate=edges with it")
    arm = (model.positions - model.wing.points[list(model.wing.root)].mean(0))[model.moves]
    turns = [(c, np.cross(axis, arm).ravel()) for c, axis in ((twist, [1.0, 0, 0]), (flap, [0, 1.0, 0])) if c]
    r = np.stack([turn for _, turn in turns], 1)
    kr = k @ r
    kr[np.abs(kr) < 1e-13 * abs(k).max() * np.abs(r).max()] = 0.0  # rounding, away from the root
    middle = np.linalg.inv(np.diag([1 / c for c, _ in turns]) + r.T @ kr)
    kr = sparse.csc_matrix(kr)
    return (k - kr @ sparse.csc_matrix(middle) @ kr.T).tocsc()


def resting_stiffness(model: Model) -> sparse.csc_matrix:
    """Returns the stiffness of the flat unloaded wing."""
    return sparse.csc_matrix(model.tangent(model.zeros(), np.zeros(len(model.springs.k))))


def lowest_modes(k: sparse.csc_matrix, m: sparse.csc_matrix, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns omega^2 (count) and shapes (unknowns, count) of the lowest undamped modes, in no order; refuses a wing that has fewer."""
    if count >= k.shape[0]:
        raise InputError(f"the wing moves in {k.shape[0]} unknowns, and more than {count} are needed: use a finer wing or refine=1, or fewer "
                         "modes")
    return eigsh(k, count, m, sigma=0.0, which="LM", v0=np.ones(k.shape[0]))


def loaded_shape(wing: Wing, model: Model, case: Case, plane: sparse.csc_matrix) -> np.ndarray:
    """Returns the displacements (nodes, 3) [m] under the loads and the weight of the masses `plane`, which contain no air."""
    if not is_loaded(case):
        return model.zeros()
    force = np.asarray(plane.sum(1)) * np.asarray(case.gravity)
    for place, vector in case.loads:
        corners, shares = locate(wing.points, np.asarray(wing.triangles), place)
        force[np.asarray(corners)] += np.outer(shares, vector)
    return LoadingPath(model).solve(force)[0]


def find_modes(wing: Wing, case: Case, coarse: Wing | None = None) -> list[tuple[float, np.ndarray]]:
    """Returns [(frequency [Hz], shape along z (points))] of the lowest modes that move across the wing. The wing vibrates about
    its shape under the loads of the case, or about rest if there are none. The largest value of each shape is 1 or -1."""
    every = np.concatenate([d for _, d in (coarse or wing).veins.values()])
    model = Model(wing, case.stiffness, float(np.mean(every)), 2.0 if coarse is not None else 1.0)
    k, m, moving = matrices(wing, case, model)
    values, vectors = lowest_modes(k, m, case.modes + 12)
    order = np.argsort(values)
    found = []
    for i in order:
        shape = np.zeros((model.n_nodes, 3))
        shape[moving] = vectors[:, i].reshape(-1, 3)
        shape = shape[:model.n_points]
        if (shape[:, 2]**2).sum() > 0.1 * (shape**2).sum():
            found.append((np.sqrt(values[i]) / (2 * pi), shape[:, 2] / np.abs(shape[:, 2]).max()))
    return found[:case.modes]


def synthesise(case: Case) -> tuple[list[Measured], dict[str, Any]]:
    """Returns the measured modes and the truth."""
    wing = read_wing(case.wing)
    coarse = wing if case.refine else None
    fine = refine(wing) if case.refine else wing
    if case.refine:
        fine.mass = wing.mass
    found = find_modes(fine, case, coarse)
    decays = find_decays(fine, case, coarse, found) if is_damped(case) else []
    random = np.random.default_rng(case.seed)
    free = np.setdiff1d(np.arange(len(wing.points)), list(wing.root))
    sites = np.sort(random.choice(free, min(case.sites, len(free)), replace=False))
    modes = []
    for number, (frequency, shape) in enumerate(found, 1):
        errors = random.standard_normal(1 + len(sites))
        if number in case.missing:
            continue
        sd = case.noise.shape
        size = 10**random.uniform(-1, 1)  # the strength with which a mode was excited is unknown
        mode = Measured(f"{case.name}{number}", frequency * (1 + case.noise.frequency * errors[0]), case.noise.frequency * frequency,
                        wing.points[sites, :2], size * (shape[sites] + sd * errors[1:]), np.full(len(sites), size * sd))
        if decays:
            ratio, error = decays[number - 1][1], case.noise.damping * random.standard_normal()
            mode = mode._replace(damping=ratio * (1 + error), damping_sd=case.noise.damping * ratio)
            mode = mode._replace(frequency=mode.frequency * decays[number - 1][0] / frequency)
        modes.append(mode)
    truth = {"frequencies": [f for f, _ in decays or found], "damping_ratios": [ratio for _, ratio in decays],
             "loads": [[*place, *vector] for place, vector in case.loads],
             "gravity": list(case.gravity), "stiffness": vars(case.stiffness), "mass": vars(case.mass),
             "air_ratio": case.air_ratio, "seed": case.seed}
    return modes, truth


def write_modes(path: str | Path, case: Case, modes: Iterable[Measured]) -> None:
    """Writes a measurement file, or adds the modes to one that exists (docs/formats/measurement-format.md)."""
    import h5py
    try:
        with h5py.File(path, "a", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_("flusi-msm measurement")
            file.attrs["version"] = np.int32(1)
            file.require_group("modes").attrs["air_density"] = np.float64(case.air_density)
            for mode in modes:
                group = file.create_group(f"modes/{mode.name}")
                group.attrs["frequency"] = np.float64(mode.frequency)
                group.attrs["frequency_sigma"] = np.float64(mode.frequency_sd)
                if mode.damping >= 0:
                    group.attrs["damping"] = np.float64(mode.damping)
                    group.attrs["damping_sigma"] = np.float64(mode.damping_sd)
                group.attrs["medium"] = np.bytes_(case.medium)
                for key, values in (("points", mode.places), ("shape", mode.shape), ("sigma", mode.sd)):
                    group.create_dataset(key, data=np.asarray(values, "<f8"), track_times=False)
                group["points"].attrs["units"] = np.bytes_("m")
                if any(case.gravity):
                    group.attrs["gravity"] = np.asarray(case.gravity, float)
                for load, (place, vector) in enumerate(case.loads, 1):
                    attributes = group.create_group(f"loads/load{load:03d}").attrs
                    attributes["force"] = np.float64(np.linalg.norm(vector))
                    attributes["direction"] = vector / np.linalg.norm(vector)
                    attributes["point"] = np.asarray(place, float)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written: {error}") from error
