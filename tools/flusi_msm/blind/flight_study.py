# SPDX-License-Identifier: GPL-3.0-or-later
"""Blind flights of a study: a section whose motion is stated, and a record of forces that hides one effect or none."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.blind.cases import numbers
from flusi_msm.blind.effects import Effect
from flusi_msm.blind.flight_effects import BALANCE, FLOW, KINEMATICS, OUTSIDE, wing_area
from flusi_msm.blind.flights import Menu, flight_of, hide, individual, with_errors
from flusi_msm.blind.ledger import dump, write
from flusi_msm.blind.strata import Stratum
from flusi_msm.measurement.flight import Case, synthesise, write_flight

INDIVIDUALS = 3
RIGS = ("quiet", "busy")
# Of the catalogue, in turn. The cases have too few points in a chord to show another area.
FAMILIES = (KINEMATICS, tuple(make for make in FLOW if make is not wing_area), BALANCE)
FACTOR = 0.05   # relative error of simulated forces over the whole beat that msm_diagnose allows for ([Flight] model_sd)
STATED = ("wing", "kinematics", "fluid")  # sections of a case that an experimenter knows


class Individual:
    """A section with the motion that is stated, without hidden effects."""

    def __init__(self, design: Case, seed: int, number: int) -> None:
        self.base = individual(design, seed, number, INDIVIDUALS)

    def write_stated(self, path: Path) -> None:
        """Writes what the experimenter knows, once."""
        if not path.exists():
            write(path, dump({**{key: asdict(getattr(self.base, key)) for key in STATED}, "beats": self.base.flow.beats}))


def turn_of(stratum: Stratum, before: int) -> int:
    """Returns the turn of a case, given how many cases of its stratum precede it: ranges of visibility begin with other turns."""
    return before + int(stratum.snr[0]) // 5


def number_of(stratum: Stratum, before: int) -> int:
    """Returns the number of the individual of a case."""
    return turn_of(stratum, before) % INDIVIDUALS


def draw_case(study_seed: int, number: int, stratum: Stratum, before: int, individual: Individual) \
        -> tuple[Callable[[Path], None], dict[str, Any]]:
    """Draws a case of a study: returns (write, truth); write(path) makes the measurement."""
    rng = numbers(study_seed, "flight study", number)
    lap = before // INDIVIDUALS
    head = {"kind": stratum.kind, "mesh": "same", "rig": RIGS[lap % len(RIGS)], "individual": number_of(stratum, before),
            "errors": int(rng.integers(2**53))}
    family = FAMILIES[(turn_of(stratum, before) + lap) % len(FAMILIES)]
    menus: dict[str, list[Menu]] = {"null": [], "outside": [OUTSIDE]}
    bounds = stratum.snr if stratum.kind == "single" else (0.0, np.inf)
    case, found = hide(rng, individual.base, menus.get(stratum.kind, [family]), stratum.snr, FACTOR, bounds)
    case = with_errors(rng, case, head, number)
    record, generator = synthesise(case, flight_of(case))

    def write_record(path: Path) -> None:
        write_flight(path, case, record)
    return write_record, {"case": f"{number:04d}", "seed": int(study_seed), **head, "snr": found[0][2] if found else 0.0,
                          "causes": [fact_of(case, *one) for one in found], "generator": generator}


def fact_of(case: Case, effect: Effect, strength: float, snr: float) -> dict[str, Any]:
    """Returns what the truth says about a hidden effect, with its parameters as msm_diagnose has them."""
    return {"name": effect.name, "strength": float(strength), "snr": snr, "is_known": effect.is_known, "also": list(effect.also),
            "parameters": as_sought(case, effect.parameters(strength)), "place": []}


def as_sought(case: Case, values: dict[str, Any]) -> dict[str, float]:
    """Returns parameters of hidden effects by the names and in the units of msm_diagnose (docs/theory/flight-records.md). What
    it does not have is left out."""
    period = 1 / case.kinematics.frequency
    one = {"hidden.stroke": ("stroke_amplitude", lambda x: x - 1), "hidden.pitch": ("pitch_amplitude", lambda x: x - 1),
           "hidden.lead": ("pitch_lead", lambda x: x / 360), "hidden.mean_angle": ("pitch_mean", lambda x: x),
           "hidden.plane": ("balance_turn:x", lambda x: -x), "hidden.frequency": ("beat_frequency", lambda x: x),
           "hidden.phase": ("balance_delay", lambda x: -x * period), "hidden.viscosity": ("viscosity", lambda x: x),
           "hidden.chord": ("wing_area", lambda x: x),
           "balance.gain": ("balance_gain", lambda x: x), "balance.misalignment": ("balance_turn:x", lambda x: x),
           "balance.lowpass": ("balance_lowpass", lambda x: 1 / (2 * np.pi * x)), "balance.delay": ("balance_delay", lambda x: x),
           "balance.inertia": ("inertia_mass", lambda x: x)}
    several = {"hidden.wind": ("wind:y", "wind:z"), "balance.offset": ("balance_offset:Fy", "balance_offset:Fz"),
               "balance.cross_talk": ("cross_talk:Fz-Fy", "cross_talk:Fy-Fz")}
    found = {}
    for key, value in values.items():
        if key in one:
            name, change = one[key]
            found[name] = float(change(value))
        found.update({name: float(x) for name, x in zip(several.get(key, ()), np.atleast_1d(value)) if x})
    return found
