# SPDX-License-Identifier: GPL-3.0-or-later
"""Blind cases of vibration: natural modes, a record after a release, or both, of a wing that hides one effect or none."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.blind import vibration_subject as subjects
from flusi_msm.blind.cases import CLOSE, DRAWS, MESHES, next_strength, numbers
from flusi_msm.blind.effects import Effect
from flusi_msm.blind.strata import Stratum
from flusi_msm.blind.vibration_effects import menu
from flusi_msm.blind.vibration_oracle import Oracle
from flusi_msm.errors import InputError
from flusi_msm.measurement import modes, series
from flusi_msm.measurement.case import Case
from flusi_msm.wing.file import read_wing

INDIVIDUALS = 4
RIGS = ("modes", "record", "both")
OTHER_MESH = 4  # every so many cases of a stratum have the finer mesh, for each wing in turn


@dataclass
class Rig:
    """An experiment, with the sd of its errors."""
    name: str
    medium: str               # of the record; modes are those in air
    sites: np.ndarray         # points at which modes are seen
    missing: tuple[int, ...]  # numbers of modes that are not measured
    frequency: float = 0.003
    shape: float = 0.02
    motion: float = 0.01
    size: float = 0.05
    trigger: float = 5.0e-6   # [s]

    @property
    def has_modes(self) -> bool:
        """Returns whether natural modes are measured."""
        return self.name != "record"

    @property
    def has_record(self) -> bool:
        """Returns whether a record of motion is measured."""
        return self.name != "modes"


class Individual:
    """One wing without hidden effects; it can compute how visible effects are on it."""

    def __init__(self, design: Case, seed: int, number: int) -> None:
        rng = numbers(seed, "vibration", number)
        s = design.stiffness
        stiffness = replace(s, E=float(s.E * 10**rng.uniform(-0.1, 0.1)))
        base = subjects.Subject(design.wing, stiffness, damping=series.Damping(rayleigh_mass=float(10**rng.uniform(1.8, 2.5))),
                                air_ratio=float(np.exp(0.2 * rng.standard_normal())))
        # E is fitted, and the joints are known from the input: they are those of the veins with its E, on every mesh. Other joints
        # would be a hidden cause.
        self.bases = {mesh: replace(base, stiffness=replace(stiffness, joints={**subjects.vein_joints(base, s, mesh), **s.joints}))
                      for mesh in MESHES}
        wing = read_wing(design.wing)
        free = np.setdiff1d(np.arange(len(wing.points)), list(wing.root))
        sites = np.sort(rng.choice(free, subjects.SITES, replace=False))
        missing = (int(rng.integers(2, subjects.MODES)),) if number % 2 else ()
        self.rigs = {name: Rig(name, ("air", "vacuum")[number // 2 % 2], sites, missing) for name in RIGS}
        self.oracles: dict[tuple[str, str], Oracle] = {}

    def oracle(self, mesh: str, rig: str) -> Oracle:
        """Returns what computes how visible effects are, on a mesh with a rig."""
        if (mesh, rig) not in self.oracles:
            self.oracles[mesh, rig] = Oracle(self.bases, mesh, self.rigs[rig])
        return self.oracles[mesh, rig]


def make_strong(oracle: Oracle, effect: Effect, wanted: float, bounds: tuple[float, float]) -> tuple[float, float] | None:
    """Returns (strength, snr) near the wanted ratio and within bounds, or None if there is no such strength."""
    tried: list[tuple[float, float]] = []
    s = effect.first
    for _ in range(8):
        s = min(s, effect.most)
        snr = oracle.snr(oracle.show(effect.apply(oracle.base, s)))
        if snr <= 1e-3:
            return None
        if 1 / CLOSE <= snr / wanted <= CLOSE and bounds[0] <= snr < bounds[1]:
            return s, snr
        if s >= effect.most and snr < wanted:
            return None
        s = next_strength(tried, s, snr, wanted, (0.02, 50.0))
    return None


def fill_case(rng: np.random.Generator, seed: int, number: int, head: dict[str, Any], individual: Individual, snr: tuple[float, float],
              bounds: tuple[float, float]) -> tuple[Callable[[Path], None], dict[str, Any]]:
    """Returns (write, truth) of a case whose kind and individual are drawn; write(path) makes the measurement."""
    oracle = individual.oracle(head["mesh"], head["rig"])
    subject, chosen = individual.bases[head["mesh"]], None
    if head["kind"] != "null":
        chosen = draw_effect(rng, oracle, head["kind"], snr, bounds)
        subject = chosen[0].apply(subject, chosen[1])
    causes = [] if chosen is None else [
        {"name": chosen[0].name, "strength": float(chosen[1]), "snr": chosen[2], "is_known": chosen[0].is_known,
         "also": list(chosen[0].also), "parameters": chosen[0].parameters(chosen[1]), "place": list(chosen[0].place)}]
    truth = {"case": f"{number:04d}", "seed": int(seed), **head, "snr": chosen[2] if chosen else 0.0, "causes": causes,
             "generator": {"subject": asdict(subject)}}
    rig = individual.rigs[head["rig"]]
    parts = measure(np.random.default_rng(head["errors"]), subject, head["mesh"], rig)

    def write(path: Path) -> None:
        write_parts(path, subject, rig, *parts)
    return write, truth


def draw_effect(rng: np.random.Generator, oracle: Oracle, kind: str, snr: tuple[float, float],
                bounds: tuple[float, float]) -> tuple[Effect, float, float]:
    """Draws an effect: returns (effect, strength, its signal-to-noise ratio)."""
    wing, effects = read_wing(oracle.base.wing), menu(kind, oracle.rig.has_record)
    for _ in range(DRAWS):
        effect = effects[rng.integers(len(effects))](rng, wing, oracle.base)
        made = make_strong(oracle, effect, float(np.exp(rng.uniform(*np.log(snr)))), bounds)
        if made is not None:
            return effect, *made
    raise InputError(f"{DRAWS} effects in a row cannot be made as visible as wanted")


def measure(rng: np.random.Generator, subject: subjects.Subject, mesh: str, rig: Rig) -> tuple[list[modes.Measured], dict[str, Any] | None]:
    """Returns modes as `write_modes` takes them, and a record as `write_series` does; none where the rig has none."""
    found, record = [], None
    if rig.has_modes:
        places = read_wing(subject.wing).points[rig.sites, :2]
        for number, (hertz, shape) in enumerate(subjects.shown_modes(subject, mesh)[:subjects.MODES], 1):
            errors, size = rng.standard_normal(1 + len(places)), 10**rng.uniform(-1, 1)
            if number not in rig.missing:
                found.append(modes.Measured(f"mode{number}", hertz * (1 + rig.frequency * errors[0]), rig.frequency * hertz, places,
                                            size * (shape[rig.sites] + rig.shape * errors[1:]), np.full(len(places), size * rig.shape)))
    if rig.has_record:
        late = rig.trigger * rng.standard_normal()
        exact = subjects.shown_record(subject, mesh, rig.medium, late=late)
        sd = np.full(exact.shape[1], rig.motion * np.abs(exact).max())
        stated = subjects.FORCE * (1 + rig.size * rng.standard_normal())
        record = {"values": exact + sd * rng.standard_normal(exact.shape), "sigma": sd, "size": stated,
                  "size_sigma": rig.size * stated, "base": None}
    return found, record


def write_parts(path: str | Path, subject: subjects.Subject, rig: Rig, found: Sequence[modes.Measured], record: dict[str, Any] | None) \
        -> None:
    """Writes a measurement file, or adds to one that exists."""
    if found:
        modes.write_modes(path, subjects.modes_case(subject, subject.stiffness), found)
    if record:
        stated = replace(subject, unstated=subjects.Unstated())
        case = subjects.record_case(stated, subject.stiffness, rig.medium)
        series.write_series(path, replace(case, noise=series.Noise(rig.motion, rig.trigger, rig.size)), record)


def draw_case(study_seed: int, number: int, stratum: Stratum, before: int, individual: Individual) \
        -> tuple[Callable[[Path], None], dict[str, Any]]:
    """Draws a case of a study: returns (write, truth)."""
    rng = numbers(study_seed, "vibration study", number)
    turn = before // len(RIGS)
    head = {"kind": stratum.kind, "rig": RIGS[before % len(RIGS)],
            "mesh": "finer" if (turn + turn // INDIVIDUALS) % OTHER_MESH == OTHER_MESH - 1 else "same",
            "individual": number_of(before), "errors": int(rng.integers(2**53))}
    bounds = stratum.snr if stratum.kind == "single" else (0.0, float("inf"))
    return fill_case(rng, study_seed, number, head, individual, stratum.snr, bounds)


def number_of(before: int) -> int:
    """Returns the number of the individual of a case, given how many cases of its stratum precede it."""
    return before // len(RIGS) % INDIVIDUALS
