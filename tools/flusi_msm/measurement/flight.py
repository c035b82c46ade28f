# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes records of forces and landmarks on a synthetic flapping section with the errors of an experiment, for `make_flight` alone.
Its plane flow and its balance share nothing with the solver in src or with what is fitted to the data."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.flow2d.beat import Beat
from flusi_msm.flow2d.grid import Resolution
from flusi_msm.flow2d.hover import Effort, Section, fly
from flusi_msm.measurement.balance import Balance, Scatter, averaged, check_names, shown, units_of
from flusi_msm.measurement.case_file import build, mistakes_in, read_json


@dataclass
class Wing:
    """The section of the wing, an ellipse."""
    chord: float = 8.0e-4             # [m]
    thickness: float = 0.05           # over the chord
    hinge: float = 0.5                # from the leading end, in chords


@dataclass
class Motion:
    """The motion: the hinge is at centre + stroke/2 cos(2 pi s) along y, the chord at mean_angle + pitch sin(2 pi s + lead) from
    y toward z; s is the time in beats."""
    frequency: float = 200.0          # [Hz]
    stroke: float = 2.24e-3           # [m] from one end to the other
    pitch: float = 45.0               # [deg]
    lead: float = 0.0                 # [deg]
    mean_angle: float = 90.0          # [deg]
    centre: tuple[float, ...] = (0.0, 0.0)  # [m] y and z


@dataclass
class Fluid:
    """The fluid as it is stated."""
    density: float = 1.2              # [kg/m^3]
    viscosity: float = 1.5e-5         # [m^2/s]
    wind: tuple[float, ...] = (0.0, 0.0)  # [m/s] along y and z


@dataclass
class Hidden:
    """Deviations from what `kinematics`, `fluid` and `wing` state."""
    stroke: float = 1.0               # factor
    pitch: float = 1.0                # factor
    lead: float = 0.0                 # [deg] more
    mean_angle: float = 0.0           # [deg] more
    plane: float = 0.0                # [deg] everything is turned from y toward z
    deviation: float = 0.0            # [m] sin(4 pi s) of this size along z: the path is an eight
    frequency: float = 1.0            # factor
    phase: float = 0.0                # of the beat: the wing is ahead of the record by this
    wind: tuple[float, ...] = (0.0, 0.0)  # [m/s] more
    viscosity: float = 1.0            # factor
    chord: float = 1.0                # factor
    hinge: float = 0.0                # [chords] more
    free_play: float = 0.0            # [deg] of the pitch between its stops; this and the next two are in no catalogue
    asymmetry: float = 0.0            # a: the drive is at s + a (1 - cos 2 pi s)/(2 pi)
    third_harmonic: float = 0.0       # h: cos 2 pi s + h cos 6 pi s


@dataclass
class Stated:
    """Errors (sd) of the kinematics that the record states; 0: not stated."""
    stroke_amplitude: float = 0.0     # relative
    pitch_amplitude: float = 0.0      # relative
    pitch_mean: float = 0.0           # [deg]
    pitch_lead: float = 0.0           # [beats]
    beat_frequency: float = 0.0       # relative


@dataclass
class Cameras:
    """Cameras that follow points of the chord, and their errors."""
    points: tuple[float, ...] = ()    # [chords] from the hinge toward the leading end, on the section as stated; none: no landmarks
    samples: int = 40                 # in a beat
    sd: float = 2.0e-6                # [m] of one coordinate in one beat
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)  # [m] from which they measure, as stated
    shift: tuple[float, ...] = (0.0, 0.0)        # [m] along y and z: the origin is there more
    turn: float = 0.0                 # [deg] their axes are turned from y toward z
    offset_sd: float = 0.0            # [m] stated error of the origin
    turn_sd: float = 0.0              # [deg] stated error of the axes


@dataclass
class Flow:
    """How the flow is computed."""
    beats: int = 3                    # from rest; the last one is recorded
    steps: int = 0                    # in a beat; 0: as many as are stable
    modes: int = 64
    radial: int = 100
    radius: float = 15.0              # [chords]


@dataclass
class Case:
    """A record of a flapping section."""
    seed: int = 1
    title: str = ""
    name: str = "hover"               # of the record
    components: str = "Fy, Fz"        # of Fy, Fz, Mx, power
    samples: int = 50                 # in a beat
    beats: int = 20                   # that were averaged
    state: str = "spread"             # or sd
    wing: Wing = field(default_factory=Wing)
    kinematics: Motion = field(default_factory=Motion)
    fluid: Fluid = field(default_factory=Fluid)
    hidden: Hidden = field(default_factory=Hidden)
    balance: Balance = field(default_factory=Balance)
    noise: Scatter = field(default_factory=Scatter)
    stated: Stated = field(default_factory=Stated)
    cameras: Cameras = field(default_factory=Cameras)
    flow: Flow = field(default_factory=Flow)


def read_case(path: str | Path, changes: Sequence[str] = ()) -> Case:
    """Returns the case in a JSON file, with changes `section.key=value`."""
    with mistakes_in(path, changes):
        case = build(Case, read_json(path, changes), "")
        check(case)
    return case


def check(case: Case) -> None:
    """Raises an InputError for values that make no sense."""
    check_names(case.components)
    if case.state not in ("spread", "sd"):
        raise InputError(f"state is spread or sd, not {case.state}")
    for section, keys in (("wing", ("chord",)), ("kinematics", ("frequency",)), ("fluid", ("density", "viscosity")),
                          ("hidden", ("viscosity", "chord", "frequency"))):
        for key in keys:
            if not getattr(getattr(case, section), key) > 0:
                raise InputError(f"{section}.{key}: must be positive")
    cameras = case.cameras
    if cameras.points and (cameras.samples < 4 or not cameras.sd > 0 or case.beats < 2):
        raise InputError("cameras: need at least 4 samples, an sd above 0, and 2 beats")
    ends = case.wing.hinge - 1, case.wing.hinge
    if any(not ends[0] <= x <= ends[1] for x in cameras.points):
        raise InputError(f"cameras.points: the section reaches from {ends[0]:g} to {ends[1]:g} chords from its hinge")
    for section in "kinematics", "fluid", "hidden", "balance", "cameras":
        for key, value in vars(getattr(case, section)).items():
            wanted = 3 if key in ("offset", "reference", "origin") else 2
            if isinstance(value, tuple) and key != "points" and len(value) != wanted:
                raise InputError(f"{section}.{key}: needs {wanted} numbers")
    if not 0.01 <= case.wing.thickness <= 0.9:
        raise InputError("wing.thickness: between 0.01 and 0.9 of the chord")
    if not 0 <= case.wing.hinge + case.hidden.hinge <= 1:
        raise InputError("wing.hinge: between 0, the leading end, and 1")
    if case.samples < 4 or case.beats < (2 if case.state == "spread" else 1) or case.flow.beats < 1 or case.seed < 0:
        raise InputError("samples at least 4, beats at least 2 for a spread, flow.beats at least 1, seed not negative")
    if case.noise.model_time < 0:
        raise InputError("noise.model_time: must not be negative")
    if case.flow.modes < 16 or case.flow.radial < 20 or case.flow.radius < 4 or case.flow.steps < 0:
        raise InputError("flow: at least 16 modes, 20 radial intervals and a radius of 4 chords")
    for key, value in vars(case.stated).items():
        if value < 0:
            raise InputError(f"stated.{key}: is an sd, not negative")
    if abs(case.hidden.asymmetry) >= 1 or case.hidden.free_play < 0:
        raise InputError("hidden: asymmetry between -1 and 1, free_play not negative")


def follow(wanted: np.ndarray, play: float) -> np.ndarray:
    """Returns the motion of a part that is driven with play: it stands still until a stop pushes it. The values are one beat of
    a periodic motion."""
    out, here = np.empty_like(wanted), wanted[0]
    for _ in range(2):
        for n, value in enumerate(wanted):
            here = min(max(here, value - play / 2), value + play / 2)
            out[n] = here
    return out


def beat_of(case: Case) -> Beat:
    """Returns the motion including its hidden deviations."""
    k, hidden = case.kinematics, case.hidden
    tilt = np.radians(hidden.plane)

    def drive(s: np.ndarray) -> np.ndarray:
        s = s + hidden.phase
        return 2 * np.pi * s + hidden.asymmetry * (1 - np.cos(2 * np.pi * s))

    def place(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        w = drive(s)
        along = k.stroke / 2 * hidden.stroke * (np.cos(w) + hidden.third_harmonic * np.cos(3 * w))
        across = hidden.deviation * np.sin(2 * w)
        return (k.centre[0] + along * np.cos(tilt) - across * np.sin(tilt),
                k.centre[1] + along * np.sin(tilt) + across * np.cos(tilt))

    def angle(s: np.ndarray) -> np.ndarray:
        turn = k.pitch * hidden.pitch * np.sin(drive(s) + np.radians(k.lead + hidden.lead))
        return np.radians(k.mean_angle + hidden.mean_angle + hidden.plane + follow(turn, hidden.free_play))

    return Beat(place, angle, 1 / (k.frequency * hidden.frequency))


def beats_of(case: Case, exact: Mapping[str, np.ndarray]) -> np.ndarray:
    """Returns the times of a flight in beats."""
    return exact["time"] * case.kinematics.frequency * case.hidden.frequency


def in_last_beat(case: Case, exact: Mapping[str, np.ndarray], values: np.ndarray) -> np.ndarray:
    """Returns values at the phases of the record."""
    return np.interp(case.flow.beats - 1 + np.arange(case.samples) / case.samples, beats_of(case, exact), values)


def section_of(case: Case) -> Section:
    """Returns the section that flies, including its hidden deviations."""
    wing, fluid, hidden = case.wing, case.fluid, case.hidden
    return Section(wing.chord * hidden.chord, wing.thickness, wing.hinge + hidden.hinge, fluid.viscosity * hidden.viscosity,
                   fluid.density, tuple(np.add(fluid.wind, hidden.wind)))


def clean(case: Case) -> dict[str, np.ndarray]:
    """Returns the output of a perfect balance from the start on: times [s] and, by name, Fy, Fz [N/m], Mx [N], power [W/m]; and
    the motion."""
    flow = case.flow
    try:
        found = fly(section_of(case), beat_of(case), flow.beats, Effort(flow.steps, Resolution(flow.modes, flow.radial, flow.radius)))
    except ArithmeticError as error:
        raise InputError(f"flow.steps: {error}") from None
    y, z = case.balance.reference[1:]
    force = found["force"]
    torque = found["torque"] + (found["place"][:, 0] - y) * force[:, 1] - (found["place"][:, 1] - z) * force[:, 0]
    return {"time": found["time"], "Fy": force[:, 0], "Fz": force[:, 1], "Mx": torque, "power": found["power"],
            "place": found["place"], "acceleration": found["acceleration"]}


def tracked(case: Case, exact: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Returns time, points (m, 2) on the section as stated, and mean, spread and sd (n, 3 m) of what the cameras show of them; x is
    NaN. The spread is that of the beats at each phase; the sd is one number for a coordinate, from all phases."""
    cameras, random = case.cameras, np.random.default_rng([case.seed, 1])
    phase = np.arange(cameras.samples) / cameras.samples
    at = case.flow.beats - 1 + phase
    y, z, angle = (np.interp(at, beats_of(case, exact), column) for column in exact["place"].T)
    c, s = np.cos(np.radians(cameras.turn)), np.sin(np.radians(cameras.turn))
    columns = []
    for point in cameras.points:
        along = case.wing.chord * case.hidden.chord * (point + case.hidden.hinge)
        dy = y + along * np.cos(angle) - cameras.origin[1] - cameras.shift[0]
        dz = z + along * np.sin(angle) - cameras.origin[2] - cameras.shift[1]
        columns += [np.full_like(phase, np.nan), c * dy + s * dz, c * dz - s * dy]
    every = np.stack(columns, 1) + cameras.sd * random.standard_normal((case.beats, len(phase), len(columns)))
    points = np.array([[case.wing.chord * point, 0.0] for point in cameras.points])
    spread = every.std(axis=0, ddof=1)
    pooled = np.sqrt(np.mean(spread**2, axis=0) / case.beats)
    return {"time": phase, "points": points, "mean": every.mean(axis=0), "spread": spread,
            "sd": np.broadcast_to(pooled, spread.shape).copy()}


def synthesise(case: Case, exact: Mapping[str, np.ndarray] | None = None) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Returns the measured record, and the truth. `exact` is clean(case), if it is known."""
    names = check_names(case.components)
    exact = clean(case) if exact is None else exact
    seen = shown(exact, case.balance)
    phase = np.arange(case.samples) / case.samples
    record = averaged(case, beats_of(case, exact), np.stack([seen[name] for name in names], 1), phase)
    truth = {"seed": case.seed, "hidden": asdict(case.hidden), "balance": asdict(case.balance), "kinematics": asdict(case.kinematics),
             "fluid": asdict(case.fluid), "wing": asdict(case.wing), "noise": asdict(case.noise), "components": list(names),
             "reynolds": np.pi * case.kinematics.frequency * case.kinematics.stroke * case.wing.chord / case.fluid.viscosity,
             "on_the_wing": {name: in_last_beat(case, exact, exact[name]).tolist() for name in names},
             "sd": record["sd"].tolist()}
    if case.cameras.points:
        record["landmarks"] = tracked(case, exact)
        truth["cameras"] = asdict(case.cameras)
    return {"time": phase, **record}, truth


def stated_time(noise: Scatter) -> float:
    """Returns the correlation time [s] that the file states: 0 if errors at different times are independent."""
    return max(noise.correlation_time if noise.correlated else 0.0, noise.model_time if noise.model else 0.0)


def write_flight(path: str | Path, case: Case, record: Mapping[str, np.ndarray]) -> None:
    """Writes a measurement file, or adds the record to one that exists (docs/formats/measurement-format.md)."""
    from flusi_msm.measurement.flight_file import write_landmarks, write_record
    names, turn = check_names(case.components), np.radians(case.balance.turn)
    axes = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(turn), np.sin(turn)], [0.0, -np.sin(turn), np.cos(turn)]])
    write_record(path, case.name, {"frequency": case.kinematics.frequency, "beats": case.beats, "reference": case.balance.reference,
                                   "components": ", ".join(names), "units": ", ".join(units_of(names, True)), "per_length": 1,
                                   "correlation_time": stated_time(case.noise), **({"axes": axes} if turn else {}),
                                   **{f"{key}_sd": value for key, value in vars(case.stated).items() if value > 0}},
                 {"time": record["time"], "mean": record["mean"], case.state: record[case.state]})
    if case.cameras.points:
        cameras = {"origin": case.cameras.origin, **{key: value for key in ("offset_sd", "turn_sd")
                                                     if (value := getattr(case.cameras, key)) > 0}}
        wing = {key: record["landmarks"][key] for key in ("time", "points", "mean", case.state)}
        write_landmarks(path, case.name, {"frequency": case.kinematics.frequency}, cameras, {"left": wing})
