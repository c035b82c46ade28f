# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the description of a synthetic bending test from a JSON file: sections, keys, defaults and checks."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.bending.model import Stiffness
from flusi_msm.errors import InputError
from flusi_msm.measurement.case_file import build, mistakes_in, read_json
from flusi_msm.measurement.noise import Noise, check_noise

PointLoad = tuple[tuple[float, ...], np.ndarray]  # point (2) [m] and force (3) [N]


@dataclass
class Hidden:
    """Properties that a usual model of the test does not know, in addition to the last keys of `stiffness`."""
    force_gain: float = 1.0          # applied over stated force
    force_offset: float = 0.0        # [N] added along the force
    force_tilt: tuple[float, ...] = (0.0, 0.0)   # [rad] turns of the direction about x and about y
    drift: float = 0.0               # relative change of all stiffness from one scan to the next, in their order
    drift_veins: float = 0.0         # the same of the veins' E alone
    creep: tuple[float, ...] = (0.0, 1.0)        # (a, tau [s]): stiffness over 1 + a log10(1 + hold/tau)
    gravity: tuple[float, ...] = (0.0, 0.0, 0.0)  # [m/s^2] it bends the unloaded wing, too
    vein_density: float = 1300.0     # [kg/m^3] for the weight
    areal_density: float = 3.0e-3    # [kg/m^2] of the membrane
    load_shift: tuple[float, ...] = (0.0, 0.0)   # [m] common to all points of application
    height_scale: float = 1.0        # of the profilometer
    map_shift: tuple[float, ...] = (0.0, 0.0)    # [m] of all height maps
    tilt: tuple[float, ...] = (0.0, 0.0)         # [rad] common to all loaded scans, about x and about y
    piston: float = 0.0              # [m] common to all loaded scans
    memory: float = 0.0              # fraction of the deformation in the previous scan that remains
    bow: float = 0.0                 # [m] from one scan to the next: heights grow by this times (x/R)^2
    fringe: tuple[float, ...] = (0.0, 1e-3, 0.0)  # amplitude, length [m] and direction [rad] of waves in all scans
    soft_places: tuple[tuple[str, float, float], ...] = ()  # (vein, share of its length, N m/rad): hinges that the wing file does not have


@dataclass
class Protocol:
    """The loads that are applied, and how."""
    levels: tuple[float, ...] = (1.0,)  # every load is applied with these multiples of its force; negative: the other way
    repeats: int = 1
    random_order: bool = False
    interval: float = 120.0          # [s] between two scans
    hold: float = 10.0               # [s] from a force to its scan


@dataclass
class Case:
    """A bending test."""
    wing: str
    loads: list[Any]                 # of (x, y, force along z) or {point, force, direction}; of a PointLoad after `check`
    seed: int = 1
    refine: int = 0                  # 1: every triangle into four
    spacing: float = 1e-4            # [m] of the height maps
    stiffness: Stiffness = field(default_factory=Stiffness)
    protocol: Protocol = field(default_factory=Protocol)
    noise: Noise = field(default_factory=Noise)
    hidden: Hidden = field(default_factory=Hidden)
    declared: dict[str, float] = field(default_factory=dict)   # sd to state in place of the true ones
    calibration: dict[str, int] = field(default_factory=dict)  # 0 or 1 by name
    title: str = "Synthetic bending test"


ACCURACY = ("height", "correlation_length", "force", "force_gain", "position", "tilt", "piston")
CALIBRATION = ("force_by_weight", "height_by_gauge", "position_by_marks", "order_is_random")


def read_case(path: str | Path, changes: Sequence[str] = (), drop: Sequence[str] = ()) -> Case:
    """Returns the case in a JSON file, with changes `section.key=value` and without the sections `drop`. The path of the wing is
    relative to the file's folder."""
    with mistakes_in(path, changes):
        case = build(Case, read_json(path, changes, drop), "")
        case.wing = str(Path(path).parent / case.wing)
        check(case)
    return case


def check(case: Case) -> None:
    """Raises an InputError for values that make no sense, and converts the loads."""
    check_noise(case.noise)
    if case.refine not in (0, 1):
        raise InputError("refine is 0 or 1")
    if not case.spacing > 0:
        raise InputError("spacing must be positive")
    if case.seed < 0:
        raise InputError("seed must not be negative")
    if case.protocol.repeats < 1 or not case.protocol.levels or 0 in case.protocol.levels:
        raise InputError("protocol: repeats at least 1, levels not zero")
    for names, section in ((ACCURACY, "declared"), (CALIBRATION, "calibration")):
        for key in getattr(case, section):
            if key not in names:
                raise InputError(f"{section}.{key}: unknown; known are {', '.join(names)}")
    case.loads = [load_of(row, k + 1) for k, row in enumerate(case.loads)]
    if not case.loads:
        raise InputError("loads: none")
    if not (case.hidden.force_gain > 0 and case.hidden.height_scale > 0 and case.hidden.creep[1] > 0
            and case.hidden.fringe[1] > 0):
        raise InputError("hidden: force_gain, height_scale, the time of creep and the length of fringes must be positive")
    for row in case.hidden.soft_places:
        if not (isinstance(row, tuple) and len(row) == 3 and 0 < row[1] < 1 and row[2] > 0):
            raise InputError("hidden.soft_places: rows of [vein, share of its length in (0, 1), N m/rad]")


def load_of(row: Any, number: int) -> PointLoad:
    """Returns (point, force vector) of a row x, y, force along z or of a dictionary."""
    try:
        if isinstance(row, dict):
            if set(row) - {"point", "force", "direction"}:
                raise InputError(f"load {number}: keys are point, force, direction")
            direction = np.array(row.get("direction", (0, 0, 1)), float)
            point, vector = tuple(map(float, row["point"])), float(row["force"]) * direction / np.linalg.norm(direction)
        else:
            x, y, force = map(float, row)
            point, vector = (x, y), np.array([0, 0, force])
        if len(point) != 2 or vector.shape != (3,) or not np.isfinite([*point, *vector]).all() or not vector.any():
            raise ValueError
    except (TypeError, ValueError, KeyError):
        raise InputError(f"load {number}: needs x, y [m] and a force [N] that is not zero") from None
    return point, vector
