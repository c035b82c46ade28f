# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes records of a freely vibrating synthetic wing with the errors of an experiment, for `make_series` alone. It uses the
stiffness of the synthetic bending tests, the masses of the synthetic modes, and an integration in time of all nodes (trapezoidal
rule, Newmark 1959). Nothing is shared with the solver in src or with what is fitted to the data."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from flusi_msm.bending.mesh import locate, refine
from flusi_msm.bending.model import Model, Stiffness
from flusi_msm.errors import InputError
from flusi_msm.measurement.case_file import build, mistakes_in, read_json
from flusi_msm.measurement.modes import Damping, Mass, mass_matrix, on_clamp, resting_stiffness, triangle_areas
from flusi_msm.wing.file import read_wing

if TYPE_CHECKING:
    from flusi_msm.wing.file import Wing

UNITS = {"release": "N", "tap": "N s"}


@dataclass
class Noise:
    """Standard deviations."""
    motion: float = 0.01              # of the largest value of a record
    trigger: float = 0.0              # [s] of the time of the excitation
    size: float = 0.05                # relative, of the force that was released or of the impulse


@dataclass
class Case:
    """A record of a vibrating wing."""
    wing: str
    refine: int = 0
    seed: int = 1
    title: str = ""
    name: str = "ring"                # of the record
    excitation: str = "release"       # release, tap or base
    point: tuple[float, ...] = (0.0, 0.0)  # [m] where the wing is held or tapped
    direction: tuple[float, ...] = (0.0, 0.0, 1.0)
    size: float = 1.0e-5              # [N] or [N s]; of a moving base [m/s2], the sd of a random acceleration
    places: tuple[tuple[float, ...], ...] = ()  # (x, y) [m] that are measured
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    units: str = "m"                  # or m/s
    rate: float = 10000.0             # [Hz]
    samples: int = 120
    start: float = 0.0                # [s]
    lowpass: float = 0.0              # [Hz], 0: no filter
    order: int = 1                    # of the filter, 1 or 2
    lag: float = 0.0                  # [s] of a filter of first order that the file does not state
    shake: tuple[float, ...] = ()     # (size [m/s^2], frequency [Hz], phase [rad]) of a motion of the base along z, the same
    steps: int = 32                   # of time in a sample
    medium: str = "vacuum"
    air_density: float = 1.2          # [kg/m^3]
    air_ratio: float = 0.8            # of the air that moves with the wing to that of strip theory
    stiffness: Stiffness = field(default_factory=Stiffness)
    mass: Mass = field(default_factory=Mass)
    damping: Damping = field(default_factory=Damping)
    noise: Noise = field(default_factory=Noise)


def read_case(path: str | Path, changes: Sequence[str] = ()) -> Case:
    """Returns the case in a JSON file, with changes `section.key=value`; the path of the wing is relative to the file's folder.
    """
    with mistakes_in(path, changes):
        case = build(Case, read_json(path, changes), "")
        for key, valid in ("medium", ("air", "vacuum")), ("excitation", ("release", "tap", "base")), ("units", ("m", "m/s")):
            if getattr(case, key) not in valid:
                raise InputError(f"{key} is {' or '.join(valid)}, not {getattr(case, key)}")
        if not case.places:
            raise InputError("places: needs at least one (x, y)")
        case.damping.check()
        if len(case.shake) not in (0, 3):
            raise InputError(f"shake: needs a size [m/s^2], a frequency [Hz] and a phase [rad], not {len(case.shake)} numbers")
        if case.damping.drag and case.medium == "vacuum":
            raise InputError("damping.drag: there is none in a vacuum; set medium=air, or remove drag")
        if case.lag < 0:
            raise InputError(f"lag: must not be negative, not {case.lag}")
        if case.stiffness.pretension or any(case.stiffness.camber):
            raise InputError("the wing is flat and free of stress at rest: no pretension, no camber")
        case.wing = str(Path(path).parent / case.wing)
    return case


class Motion:
    """A wing that moves near its rest position: M u'' + C u' + K (u + g z) = f, z' = u' - z/tau."""

    def __init__(self, wing: Wing, case: Case, coarse: Wing | None = None) -> None:
        every = np.concatenate([d for _, d in (coarse or wing).veins.values()])
        mean, springs = float(np.mean(every)), 2.0 if coarse is not None else 1.0
        model = Model(wing, case.stiffness, mean, springs)
        plane, across = mass_matrix(wing, case, model.n_nodes)
        moving = np.flatnonzero(model.moves)
        self.place = np.full(model.n_nodes, -1)
        self.place[moving] = np.arange(len(moving))
        n = 3 * len(moving)
        parts = []
        for k, matrix in enumerate((plane, plane, across)):
            m = matrix[moving][:, moving].tocoo()
            parts.append(sparse.csc_matrix((m.data, (3 * m.row + k, 3 * m.col + k)), (n, n)))
        self.m = sum(parts).tocsc()
        fixed = resting_stiffness(model)
        self.k = on_clamp(model, fixed)
        d = case.damping
        self.c = d.rayleigh_mass * self.m + d.rayleigh_stiffness * self.k
        if d.joint_friction:
            joints = {h.joint: 2 * model.hinge_stiffness(h) for h in model.hinge_plan if h.joint}
            twice = Model(wing, replace(case.stiffness, joints=joints), mean, springs)
            self.c = self.c + d.joint_friction * (resting_stiffness(twice) - fixed)
        self.area = np.zeros(model.n_nodes)  # of the membrane around every node, [m^2]
        np.add.at(self.area, np.asarray(wing.triangles), triangle_areas(wing)[:, None] / 3)
        self.area = self.area[moving]
        self.wing, self.case, self.n = wing, case, n

    def at(self, point: Sequence[float], direction: Sequence[float]) -> np.ndarray:
        """Returns the weights (n) of the unknowns in the displacement of a place along a direction."""
        unit = np.asarray(direction, float) / np.linalg.norm(direction)
        corners, shares = locate(self.wing.points, np.asarray(self.wing.triangles), point)
        out = np.zeros(self.n)
        for corner, share in zip(np.asarray(corners), shares):
            if self.place[corner] >= 0:
                out[3 * self.place[corner] + np.arange(3)] += share * unit
        return out

    def inertial(self, b: np.ndarray) -> np.ndarray:
        """Returns M^-1 b of the unknowns that have a mass; the others are not accelerated."""
        heavy = np.flatnonzero(self.m.diagonal() > 0)
        out = np.zeros(self.n)
        out[heavy] = splu(self.m[heavy][:, heavy].tocsc()).solve(b[heavy])
        return out

    def drag_at(self, v: np.ndarray) -> np.ndarray:
        """Returns the force of the drag (n) at velocities v (n); there is none in a vacuum."""
        out = np.zeros(self.n)
        if self.case.damping.drag and self.case.medium == "air":
            out[2::3] = -self.case.damping.drag * self.area * np.abs(v[2::3]) * v[2::3]
        return out

    def record(self, base: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Returns times, and values (times, places) at every step of time."""
        case, d = self.case, self.case.damping
        h = 1 / (case.rate * case.steps)
        count = round((case.start * case.rate + case.samples + 1) * case.steps)
        g, tau = d.relaxation, d.relaxation_time
        keep, gone = 1 - h / (2 * tau), 1 + h / (2 * tau)
        factor = splu((4 / h**2 * self.m + 2 / h * self.c + (1 + g / gone) * self.k).tocsc())
        u, v, z = np.zeros(self.n), np.zeros(self.n), np.zeros(self.n)
        weights = self.m @ np.tile(np.asarray(case.direction, float) / np.linalg.norm(case.direction), self.n // 3)
        size, hertz, phase = case.shake or (0.0, 0.0, 0.0)
        across = self.m @ np.tile([0.0, 0.0, 1.0], self.n // 3)
        if case.excitation == "release":
            u = splu(self.k).solve(case.size * self.at(case.point, case.direction))
        elif case.excitation == "tap":
            v = self.inertial(case.size * self.at(case.point, case.direction))

        def pull(step: int) -> np.ndarray:
            moved = -size * np.sin(2 * np.pi * hertz * step * h + phase) * across
            return moved if base is None else moved - weights * np.interp(step * h * case.rate, np.arange(len(base)), base)
        a = self.inertial(pull(0) + self.drag_at(v) - self.c @ v - self.k @ u)
        looks = np.array([self.at(place, case.axis) for place in case.places])
        seen = np.zeros((count, len(looks)))
        for step in range(count):
            seen[step] = looks @ (v if case.units == "m/s" else u)
            right = pull(step + 1) + self.m @ (4 / h**2 * (u + h * v) + a) + self.c @ (2 / h * u + v)
            right += g / gone * (self.k @ (u - keep * z))
            right += self.drag_at(v + h * a)  # at the predicted velocity
            new = factor.solve(right)
            z = (keep * z + new - u) / gone
            a, v, u = 4 / h**2 * (new - u - h * v) - a, 2 / h * (new - u) - v, new
        return np.arange(count) * h, seen


def filtered(case: Case, times: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Returns the output of a low-pass filter: of first order, or Butterworth's of second, by the trapezoidal rule. Before the
    record its input was the constant bent shape."""
    if not case.lowpass:
        return seen
    c, h = 2 * np.pi * case.lowpass, times[1]
    a = np.array([[-c]]) if case.order == 1 else np.array([[0, c], [-c, -np.sqrt(2) * c]])
    b = np.zeros(len(a))
    b[-1] = c
    left = np.linalg.inv(np.eye(len(a)) - h / 2 * a)
    state = np.zeros((len(a), seen.shape[1]))
    if case.excitation == "release" and case.units == "m":
        state[0] = seen[0]
    out = np.zeros_like(seen)
    out[0] = state[0]
    for k in range(1, len(seen)):
        state = left @ (state + h / 2 * (a @ state) + h / 2 * np.outer(b, seen[k - 1] + seen[k]))
        out[k] = state[0]
    return out


def synthesise(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the measurement: values (samples, places), sd (places), the stated size and its sd, the record of the base; and
    the truth."""
    wing = read_wing(case.wing)
    coarse = wing if case.refine else None
    fine = refine(wing) if case.refine else wing
    if case.refine:
        fine.mass = wing.mass
    random = np.random.default_rng(case.seed)
    base = None
    if case.excitation == "base":
        base = case.size * random.standard_normal(case.samples)
    times, seen = Motion(fine, case, coarse).record(base)
    seen = filtered(case, times, seen)
    if case.lag:
        seen = filtered(replace(case, lowpass=1 / (2 * np.pi * case.lag), order=1), times, seen)
    late = case.noise.trigger * random.standard_normal()
    wanted = case.start + late + np.arange(case.samples) / case.rate
    exact = np.stack([np.interp(np.maximum(wanted, 0), times, column) for column in seen.T], 1)
    sd = np.full(len(case.places), case.noise.motion * np.abs(exact).max())
    values = exact + sd * random.standard_normal(exact.shape)
    stated = case.size * (1 + case.noise.size * random.standard_normal())
    truth = {"stiffness": vars(case.stiffness), "mass": vars(case.mass), "damping": vars(case.damping), "late": late,
             "size": case.size, "air_ratio": case.air_ratio, "seed": case.seed}
    return {"values": values, "sigma": sd, "size": stated, "size_sigma": case.noise.size * stated, "base": base}, truth


def write_series(path: str | Path, case: Case, record: dict[str, Any]) -> None:
    """Writes a measurement file, or adds the record to one that exists (docs/formats/measurement-format.md)."""
    import h5py
    try:
        with h5py.File(path, "a", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_("flusi-msm measurement")
            file.attrs["version"] = np.int32(1)
            file.require_group("series").attrs["air_density"] = np.float64(case.air_density)
            group = file.create_group(f"series/{case.name}")
            for key in "excitation", "medium", "units":
                group.attrs[key] = np.bytes_(getattr(case, key))
            for key in "direction", "axis":
                group.attrs[key] = np.asarray(getattr(case, key), "<f8")
            group.attrs["rate"] = np.float64(case.rate)
            if case.start:
                group.attrs["start"] = np.float64(case.start)
            group.attrs["trigger_sigma"] = np.float64(case.noise.trigger)
            if case.lowpass:
                group.attrs["lowpass"] = np.float64(case.lowpass)
                group.attrs["order"] = np.int32(case.order)
            if case.excitation != "base":
                group.attrs["point"] = np.asarray(case.point, "<f8")
                group.attrs["size"] = np.float64(record["size"])
                group.attrs["size_sigma"] = np.float64(record["size_sigma"])
            data = {"points": np.asarray(case.places, "<f8"), "values": record["values"], "sigma": record["sigma"]}
            if record["base"] is not None:
                data["base"] = record["base"]
            for key, numbers in data.items():
                group.create_dataset(key, data=np.asarray(numbers, "<f8"), track_times=False)
            group["points"].attrs["units"] = np.bytes_("m")
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written: {error}") from error
