# SPDX-License-Identifier: GPL-3.0-or-later
"""The description of a synthetic bending test, from a JSON file: sections, keys, defaults and checks."""
import difflib
import json
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np

from flusi_msm.bending.model import Stiffness
from flusi_msm.measurement.noise import Noise, check_noise
from flusi_msm.results.files import InputError


@dataclass
class Hidden:
    """What a usual model of the test does not know; beside the last keys of `stiffness`."""
    force_gain: float = 1.0          # applied over stated force
    force_offset: float = 0.0        # [N] added along the force
    force_tilt: tuple = (0.0, 0.0)   # [rad] turns of the direction about x and about y
    drift: float = 0.0               # relative change of all stiffness from one scan to the next, in their order
    drift_veins: float = 0.0         # the same of the veins' E alone
    creep: tuple = (0.0, 1.0)        # (a, tau [s]): stiffness over 1 + a log10(1 + hold/tau)
    gravity: tuple = (0.0, 0.0, 0.0)  # [m/s^2] bends the unloaded wing too
    vein_density: float = 1300.0     # [kg/m^3] for the weight
    areal_density: float = 3.0e-3    # [kg/m^2] of the membrane
    load_shift: tuple = (0.0, 0.0)   # [m] common to all points of application
    height_scale: float = 1.0        # of the profilometer
    map_shift: tuple = (0.0, 0.0)    # [m] of all height maps
    tilt: tuple = (0.0, 0.0)         # [rad] common to all loaded scans, about x and about y
    piston: float = 0.0              # [m] common to all loaded scans
    memory: float = 0.0              # fraction of the deformation in the scan before that is still there
    bow: float = 0.0                 # [m] from one scan to the next: heights grow by this times (x/R)^2
    fringe: tuple = (0.0, 1e-3, 0.0)  # amplitude, length [m] and direction [rad] of waves in all scans
    soft_places: tuple = ()          # (vein, share of its length, N m/rad): hinges that the wing file does not have


@dataclass
class Protocol:
    """Which loads are applied, and how."""
    levels: tuple = (1.0,)           # every load is applied with these multiples of its force; negative: the other way
    repeats: int = 1
    random_order: bool = False
    interval: float = 120.0          # [s] between two scans
    hold: float = 10.0               # [s] from a force to its scan


@dataclass
class Case:
    wing: str
    loads: list                      # of (x, y, force along z) or {point, force, direction}
    seed: int = 1
    refine: int = 0                  # 1: every triangle into four
    spacing: float = 1e-4            # [m] of the height maps
    stiffness: Stiffness = field(default_factory=Stiffness)
    protocol: Protocol = field(default_factory=Protocol)
    noise: Noise = field(default_factory=Noise)
    hidden: Hidden = field(default_factory=Hidden)
    declared: dict = field(default_factory=dict)     # sd to state in place of the true ones
    calibration: dict = field(default_factory=dict)  # 0 or 1 by name
    title: str = "Synthetic bending test"


ACCURACY = ("height", "correlation_length", "force", "force_gain", "position", "tilt", "piston")
NAMED = ("E_wave", "one_way")  # keys whose first value is a name
CALIBRATION = ("force_by_weight", "height_by_gauge", "position_by_marks", "order_is_random")


def read_case(path, changes=(), drop=()):
    """The case in a JSON file, with changes `section.key=value` made to it and the sections `drop` left out. The wing is
    seen from the file's folder."""
    try:
        data = json.loads(Path(path).read_text())
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: not JSON: {error}") from None
    for section in drop if isinstance(data, dict) else ():
        data.pop(section, None)
    for change in changes:
        name, equals, text = change.partition("=")
        if not equals:
            raise InputError(f"--set {change}: write key=value or section.key=value")
        try:
            value = json.loads(text)
        except ValueError:
            value = text
        *sections, key = name.strip().split(".")
        place = data
        for section in sections:
            place = place.setdefault(section, {})
            if not isinstance(place, dict):
                raise InputError(f"--set {change}: {section} is not a section")
        place[key] = value
    case = build(Case, data, "")
    case.wing = str(Path(path).parent / case.wing)
    check(case)
    return case


def build(kind, data, section):
    """A dataclass from a dictionary; unknown keys and values of another kind are refused."""
    if not isinstance(data, dict):
        raise InputError(f"{section or 'the case'}: must be a section {{...}}")
    section += "." if section else ""
    known = {f.name: f for f in fields(kind)}
    for key in data:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            raise InputError(f"{section}{key}: unknown" + (f"; did you mean {near[0]}?" if near else
                                                          f"; known are {', '.join(known)}"))
    values = {}
    for key, value in data.items():
        values[key] = convert(known[key], value, section + key)
    for name in ("wing", "loads"):
        if name in known and name not in values:
            raise InputError(f"{name}: required")
    return kind(**values)


def convert(item, value, name):
    kind = item.type
    if kind in (Stiffness, Protocol, Noise, Hidden):
        return build(kind, value, name)
    if kind is float and is_number(value):
        return float(value)
    if kind is tuple and isinstance(value, list):
        size = len(item.default)
        if name.endswith(("shift", "tilt", "creep", "compliance", "gravity", "fringe")) and len(value) != size:
            raise InputError(f"{name}: needs {size} numbers")
        rows = [v if isinstance(v, list) else [v] for v in (value[1:] if item.name in NAMED else value)]
        rows = [row[1:] for row in rows] if item.name == "soft_places" else rows
        if not all(is_number(v) for row in rows for v in row):
            raise InputError(f"{name} = {value!r}: holds what is no number")
        return tuple(tuple(v) if isinstance(v, list) else v for v in value)
    if kind is dict and isinstance(value, dict) and not all(is_number(v) for v in value.values()):
        raise InputError(f"{name} = {value!r}: holds what is no number")
    if kind in (int, bool, str, dict, list) and type(value) is kind:
        return value
    raise InputError(f"{name} = {value!r}: must be {'a list' if kind is tuple else kind.__name__}")


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and bool(np.isfinite(value))


def check(case):
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


def load_of(row, number):
    """(point, force vector) of a row x, y, force along z or of a dictionary."""
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
