# SPDX-License-Identifier: GPL-3.0-or-later
"""Blind cases of bending tests and natural modes of the same wing. One stiffness has to explain both."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.blind import effects, vibration, vibration_effects
from flusi_msm.blind import vibration_subject as subjects
from flusi_msm.blind.cases import Individual, numbers
from flusi_msm.blind.effects import DrawEffect
from flusi_msm.blind.vibration_oracle import paired
from flusi_msm.measurement import modes, series
from flusi_msm.measurement.case import Case
from flusi_msm.measurement.file import write_test
from flusi_msm.wing.file import read_wing

STEP = 1e-4
# The modes of the generator are those of a wing that is flat, without stress and on a stiff clamp, and that moves little.
LEFT_OUT = (effects.camber, effects.pretension, effects.root_compliance, effects.one_way_joint)
KNOWN = tuple(e for e in effects.KNOWN if e not in LEFT_OUT) + vibration_effects.INERTIA
OUTSIDE = (*effects.OUTSIDE, vibration_effects.membrane_wave)


@dataclass
class JointCase(Case):
    """A bending test of a wing that has a mass; see `Subject`."""
    mass: modes.Mass = field(default_factory=modes.Mass)
    damping: series.Damping = field(default_factory=series.Damping)
    unstated: subjects.Unstated = field(default_factory=subjects.Unstated)
    air_ratio: float = 0.8


class JointIndividual(Individual):
    """One wing; its modes are those in air."""

    def __init__(self, design: Case, seed: int, number: int) -> None:
        rng = numbers(seed, "joint", number)
        free = np.setdiff1d(np.arange(len(read_wing(design.wing).points)), list(read_wing(design.wing).root))
        self.vibration = vibration.Rig("modes", "air", np.sort(rng.choice(free, subjects.SITES, replace=False)), ())
        self.known: dict[str, tuple[subjects.Modes, np.ndarray, np.ndarray]] = {}  # by mesh: modes without effects, and their slopes
        super().__init__(JointCase(**vars(design)), seed, number)

    def menu(self, kind: str) -> Sequence[DrawEffect]:
        """Returns the effects that a case of this kind can have."""
        return OUTSIDE if kind == "outside" else KNOWN

    def finish(self, content: dict[str, Any], case: Any, mesh: str) -> None:
        """Adds the modes to the content of a bending test."""
        errors = np.random.default_rng([case.seed, 1])
        content["modes"] = vibration.measure(errors, case, mesh, self.vibration)[0]

    def residual(self, shown: subjects.Modes, own: subjects.Modes) -> np.ndarray:
        """Returns the difference of two sets of modes, in units of its sd."""
        return np.concatenate([part for pair in paired(self.vibration, shown, own) for part in pair])

    def modes_of(self, mesh: str) -> tuple[subjects.Modes, np.ndarray, np.ndarray]:
        """Returns (modes without effects, slopes of the residual with respect to stiffness and air, difference of the meshes)."""
        if mesh not in self.known:
            case = self.case(mesh, self.design.noise)
            base, model = subjects.shown_modes(case, mesh), self.bases[mesh].model
            joints = {h.joint: model.hinge_stiffness(h) for h in model.hinge_plan if h.joint}
            factor, s = 1 + STEP, replace(self.stiffness, joints=joints)
            near = [replace(s, E=s.E * factor)] + [replace(s, joints={**joints, name: k * factor}) for name, k in joints.items()] + \
                [replace(s, D=s.D * factor)]
            moved = [replace(case, stiffness=one) for one in near] + [replace(case, air_ratio=case.air_ratio * factor)]
            start = subjects.shown_modes(replace(case, stiffness=s), mesh)
            slopes = np.stack([self.residual(subjects.shown_modes(one, mesh), start) / STEP for one in moved], 1)
            other = next((m for m in self.clean if m != mesh), mesh)
            band = self.residual(subjects.shown_modes(self.case(other, self.design.noise), other), base)
            self.known[mesh] = base, slopes, band
        return self.known[mesh]

    def visibility(self, mesh: str, rig: str, case: Any, seen: np.ndarray, least: float = 0.0) -> float:
        """Returns the signal-to-noise ratio of the effect whose shapes were computed last: see `Individual.deformations`."""
        oracle = self.oracle(mesh, rig, case)
        base, slopes, band = self.modes_of(mesh)
        d, n = oracle.filled(oracle.change(seen))[:, None], oracle.n_stiff
        e = self.residual(subjects.shown_modes(self.latest_case, mesh), base)[:, None]
        a = np.zeros((len(e), oracle.a.shape[1] + 1))
        a[:, :n] = slopes[:, :n] * oracle.stiff_sd
        a[:, oracle.band_column] = band
        a[:, -1] = 0.3 * slopes[:, -1]
        gram, right = np.eye(a.shape[1]) + a.T @ a, a.T @ e
        gram[:-1, :-1] += oracle.a.T @ oracle.weighted
        right[:-1] += oracle.weighted.T @ d
        square = (d * oracle.weigh(d)).sum() + (e * e).sum() - (right * np.linalg.solve(gram, right)).sum()
        return float(np.sqrt(max(0.0, square)))


def write_joint(path: str | Path, content: dict[str, Any]) -> None:
    """Writes bending tests and modes in one file."""
    write_test(path, content)
    modes.write_modes(path, modes.Case(""), content["modes"])
