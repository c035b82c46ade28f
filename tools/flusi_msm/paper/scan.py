# SPDX-License-Identifier: GPL-3.0-or-later
"""A scan of the angles that the paper does not print: rigid and flexible wings at every point of a lattice about the kinematics
of the input."""
from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Optional

import numpy as np

from flusi_msm.paper.cases import FLEXIBLE, RIGID, Case, Values, Variant, read_text
from flusi_msm.paper.numbers import COLUMNS, KINDS, PAPER, TABLE_2, means_of
from flusi_msm.results.cycles import FlappingRun
from flusi_msm.results.files import InputError
from flusi_msm.results.ini import values_of

Quantity = tuple[str, str]  # rigid, flexible or change, and a column of Table 2
ValueOf = Callable[[dict[str, Any]], Optional[float]]  # the value of a quantity at a point of the scan
SCHEMA = "flusi-msm scan of the kinematics"
AXES = ("pitch", "stroke", "tilt")
SIZES, STEPS, BEATS = (3, 3, 3), (10.0, 15.0, 10.0), 2
CHANGES = ("lift_to_drag", "lift_to_power")       # whose signs are the paper's conclusion
OWN = ("lift_mN", "drag_mN", "power_mW")          # the other columns of Table 2 are their ratios


def _numbers(text: str | None, key: str, count: int, default: Sequence[float]) -> list[float]:
    try:
        values = [float(word) for word in text.split()] if text else list(default)
    except ValueError:
        values = []
    if len(values) != count:
        raise InputError(f"[Insects] {key} must be {count} number{'s' * (count > 1)}, not '{text}'")
    return values


def stroke_of(path: str | Path) -> float:
    """Degrees from the lowest to the highest phi of a file of kinematics."""
    own = values_of(read_text(path)).get("kinematics", {})
    try:
        if own["type"] != "fourier":
            raise KeyError("type = fourier")
        a, b = ([float(word) for word in own[key].split()] for key in ("ai_phi", "bi_phi"))
    except (KeyError, ValueError) as error:
        raise InputError(f"{path}: a scan needs the Fourier series of phi: {error}") from None
    t = 2 * np.pi * np.arange(2000) / 2000
    phi = sum((x * np.cos(k * t) + y * np.sin(k * t) for k, (x, y) in enumerate(zip(a, b), 1)), np.zeros_like(t))
    return float(np.ptp(phi)) * (1.0 if own.get("units", "degree") == "degree" else 180 / np.pi)


class Shipped:
    """The angles of the input, about which the scan is made. Pitch is what is added to alpha, stroke the amplitude of phi from
    peak to peak, tilt the angle of the stroke plane to the horizontal; in degrees."""

    def __init__(self, ini: str | Path) -> None:
        insects = values_of(read_text(ini)).get("Insects", {})
        self.factor = _numbers(insects.get("kinematics_factor"), "kinematics_factor", 3, (1, 1, 1))
        self.offset = _numbers(insects.get("kinematics_offset"), "kinematics_offset", 3, (0, 0, 0))
        eta, = _numbers(insects.get("eta0"), "eta0", 1, (0,))
        attitude = _numbers(insects.get("yawpitchroll_0"), "yawpitchroll_0", 3, (0, 0, 0))
        motion = insects.get("FlappingMotion_left", "").replace("from_file::", "")
        path = Path(ini).resolve().parent / motion
        self.stroke_of_file = stroke_of(path)
        self.eta_of_no_tilt = -90 - attitude[1]
        self.angles = (self.offset[1], self.stroke_of_file * self.factor[0], eta - self.eta_of_no_tilt)

    def values(self, angles: Sequence[float]) -> Values:
        """{section: {key: value}} of the input with these angles."""
        pitch, stroke, tilt = angles
        factor = [stroke / self.stroke_of_file, *self.factor[1:]]
        offset = [self.offset[0], pitch, self.offset[2]]
        return {"Insects": {"kinematics_factor": " ".join(f"{x:.10g}" for x in factor),
                            "kinematics_offset": " ".join(f"{x:.10g}" for x in offset),
                            "eta0": f"{tilt + self.eta_of_no_tilt:.10g}"}}


class Scan:
    """The flights: `points` is a list of ((pitch, stroke, tilt), {kind: case}), the shipped kinematics first and what is near
    them next, so that a part of the scan is of use."""

    def __init__(self, folder: str | Path, ini: str | Path, grid: int, sizes: Sequence[int] = SIZES, steps: Sequence[float] = STEPS,
                 beats: int = BEATS) -> None:
        if any(n < 1 or n % 2 == 0 for n in sizes):
            raise InputError("--scan takes three odd numbers: the shipped kinematics are the middle point")
        if any(step <= 0 for step in steps):
            raise InputError("--scan-steps takes three positive angles")
        self.name, self.grid, self.beats, self.shipped = f"kinematics_{grid}", grid, beats, Shipped(ini)
        self.folder = Path(folder) / self.name
        self.values = [[centre + step * (i - n // 2) for i in range(n)] for centre, n, step in zip(self.shipped.angles, sizes, steps)]
        if self.values[1][0] <= 0:
            raise InputError("--scan-steps: the smallest stroke amplitude must be positive")
        places = sorted(itertools.product(*map(range, sizes)), key=lambda place: sum(abs(i - n // 2) for i, n in zip(place, sizes)))
        self.points = []
        for place in places:
            angles = tuple(values[i] for i, values in zip(place, self.values))
            self.points.append((angles, {kind: self._case(ini, kind, angles) for kind in KINDS}))

    def _case(self, ini: str | Path, kind: str, angles: Sequence[float]) -> Variant:
        pitch, stroke, tilt = angles
        name = f"{kind}_pitch{pitch:+g}_stroke{stroke:g}_tilt{tilt:g}"
        return Variant(self.folder, ini, kind, self.grid, self.beats, name, self.shipped.values(angles),
                       stroke / self.shipped.angles[1])

    @property
    def cases(self) -> list[Case]:
        """Returns all flights."""
        return [case for _, pair in self.points for case in pair.values()]


def row_of(case: Case) -> dict[str, Any]:
    """Table 2's row of the last beat; a ratio to a drag that is not positive is None."""
    run = FlappingRun(case.folder)
    row = means_of(run, run.cycles()[-1:])[0]
    if row["drag_mN"] <= 0:
        row["lift_to_drag"] = None
    return row


def change(rigid: dict[str, Any], flexible: dict[str, Any]) -> dict[str, float | None]:
    """{column: % that bending adds, or None where a ratio is missing}."""
    return {key: 100 * (flexible[key] / rigid[key] - 1) if rigid[key] and flexible[key] is not None else None for key in COLUMNS}


def distance(point: dict[str, Any]) -> float:
    """Root mean square of the relative deviations of lift, drag and power of both wings from the paper's."""
    away = [point[kind][key] / TABLE_2[kind][key] - 1 for kind in KINDS for key in OWN]
    return float(np.sqrt(np.mean(np.square(away))))


def has_both_signs(point: dict[str, Any]) -> bool:
    """Returns whether bending changes both ratios at a point in the paper's direction."""
    return all((point["change_percent"][key] or 0) * PAPER["change_percent"][key] > 0 for key in CHANGES)


def collect(scan: Scan) -> dict[str, Any]:
    """What goes into the JSON file, of the flights that are finished."""
    made = []
    for angles, pair in scan.points:
        point: dict[str, Any] = dict(zip(AXES, angles))
        point |= {kind: row_of(case) for kind, case in pair.items() if case.is_finished()}
        if all(kind in point for kind in KINDS):
            point["change_percent"] = change(point[RIGID], point[FLEXIBLE])
            point["distance"] = distance(point)
        made.append(point)
    versions = sorted({v for case in scan.cases if case.is_finished() for v in case.state().get("versions", [])})
    found = {"schema": SCHEMA, "schema_version": 1, "points_along_x": scan.grid, "beats": scan.beats, "versions": versions,
             "values": dict(zip(AXES, scan.values)), "shipped": dict(zip(AXES, scan.shipped.angles)), "paper": PAPER,
             "scan": made, "missing": [case.name for case in scan.cases if not case.is_finished()]}
    whole = complete(found)
    if whole:
        found["nearest"] = dict(min(whole, key=lambda point: point["distance"]))
        found["both_signs"] = [{axis: point[axis] for axis in AXES} for point in whole if has_both_signs(point)]
    return found


def complete(found: dict[str, Any]) -> list[dict[str, Any]]:
    """Points at which both wings have flown."""
    return [point for point in found["scan"] if "change_percent" in point]


def shipped_of(found: dict[str, Any]) -> dict[str, Any] | None:
    """The point of the shipped kinematics, or None."""
    return next((point for point in complete(found) if all(point[axis] == found["shipped"][axis] for axis in AXES)), None)


def quantities() -> list[tuple[Quantity, ValueOf, float]]:
    """[(name, value of a point or None, the paper's value)]: Table 2 of both wings, then the changes of both ratios."""
    def value_of(part: str, key: str) -> ValueOf:
        return lambda point: point[part][key] if part in point else None

    return [*(((kind, key), value_of(kind, key), TABLE_2[kind][key]) for kind in KINDS for key in COLUMNS),
            *((("change", key), value_of("change_percent", key), PAPER["change_percent"][key]) for key in CHANGES)]
