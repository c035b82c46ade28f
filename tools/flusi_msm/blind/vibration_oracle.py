# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes how visible a hidden effect is in natural modes and records: the signal-to-noise ratio of the part of it that a usual
model cannot explain. snr^2 is the smallest sum of squares, priors included, over

    ln E (sd of a decade), ln D (0.1), ln of the air that moves with the wing (0.3), ln of damping in proportion to the mass (a
    decade), size and trigger of the excitation (their sd), and on the finer mesh the difference of the meshes (1),

found by nonlinear least squares, since a record depends nonlinearly on the frequency. The wing with these values is that
without the effect in its lowest modes (Ritz), so that thousands of evaluations need little time."""
from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Optional

import numpy as np
from scipy import linalg, optimize, sparse
from scipy.sparse.linalg import eigsh

from flusi_msm.blind import vibration_subject as subjects
from flusi_msm.measurement.series import Motion

if TYPE_CHECKING:
    from flusi_msm.blind.vibration import Rig

Shown = tuple[Optional[subjects.Modes], Optional[np.ndarray]]  # modes, record
BASIS = 50       # modes in which the wing moves
STEP = 1e-4      # of differences
PRIORS = {"E": np.log(10), "D": 0.1, "air": 0.3, "damping": np.log(10), "size": 1.0, "trigger": 1.0, "band": 1.0}


class Ritz:
    """The wing of a subject in its lowest modes, for any E, D, air and damping in proportion to its mass."""

    def __init__(self, subject: subjects.Subject, mesh: str, medium: str) -> None:
        wing, coarse, stiffness = subjects.meshed(subject, mesh)
        motion = Motion(wing, subjects.record_case(subject, stiffness, "vacuum"), coarse)
        heavy = motion.m + 1e-12 * motion.m.diagonal().max() * sparse.identity(motion.n)
        _, phi = eigsh(motion.k, BASIS, heavy, sigma=0.0, v0=np.ones(motion.n))

        def small(matrix: sparse.csc_matrix) -> np.ndarray:
            return phi.T @ (matrix @ phi)
        self.k, self.m, self.d = small(motion.k), small(motion.m), subject.damping
        parts = []
        for key in "E", "D":
            twice = Motion(wing, subjects.record_case(subject, replace(stiffness, **{key: 2 * getattr(stiffness, key)}), "vacuum"), coarse)
            parts.append(small(twice.k - motion.k))
        self.k_veins, self.k_membrane = parts
        self.air = np.zeros_like(self.m)
        if medium == "air":
            self.air = small(Motion(wing, subjects.record_case(subject, stiffness, "air"), coarse).m - motion.m)
        self.push = phi.T @ motion.at(subjects.RELEASE, (0, 0, 1)) * subjects.FORCE
        self.looks = np.stack([motion.at(place, (0, 0, 1)) for place in subjects.PLACES]) @ phi
        n_points = len(wing.points)
        nodes = phi.reshape(-1, 3, BASIS)
        moving = np.flatnonzero((motion.place >= 0)[:n_points])
        self.points = np.zeros((n_points, 3, BASIS))
        self.points[moving] = nodes[motion.place[moving]]

    def matrices(self, q: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Returns stiffness and mass for the logarithms q."""
        k = self.k + np.expm1(q.get("E", 0.0)) * self.k_veins + np.expm1(q.get("D", 0.0)) * self.k_membrane
        return k, self.m + np.exp(q.get("air", 0.0)) * self.air

    def modes(self, q: Mapping[str, float], count: int) -> subjects.Modes:
        """Returns the modes in the form of `shown_modes`."""
        values, vectors = linalg.eigh(*self.matrices(q))
        found = []
        for value, vector in zip(values, vectors.T):
            shape = self.points @ vector
            if (shape[:, 2]**2).sum() > 0.1 * (shape**2).sum():
                found.append((np.sqrt(value) / (2 * np.pi), shape[:, 2] / np.abs(shape[:, 2]).max()))
            if len(found) == count:
                break
        return found

    def record(self, q: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Returns the record in the form of `shown_record`, and its derivative in time; the solution in time is exact."""
        k, m = self.matrices(q)
        n, d = len(k), self.d
        c = d.rayleigh_mass * np.exp(q.get("damping", 0.0)) * m + d.rayleigh_stiffness * k
        a = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]])
        step = linalg.expm(a / subjects.RATE)
        state = np.concatenate([np.linalg.solve(k, self.push), np.zeros(n)])
        seen, speed = [], []
        for _ in range(subjects.SAMPLES):
            seen.append(self.looks @ state[:n])
            speed.append(self.looks @ state[n:])
            state = step @ state
        return np.array(seen), np.array(speed)


class Oracle:
    """Computes signal-to-noise ratios for one wing, `bases` by the names of meshes, on one mesh in one kind of experiment."""

    def __init__(self, bases: Mapping[str, subjects.Subject], mesh: str, rig: Rig) -> None:
        base = bases[mesh]
        self.base, self.mesh, self.rig = base, mesh, rig
        self.air = Ritz(base, mesh, "air") if rig.has_modes else None
        self.still = Ritz(base, mesh, rig.medium) if rig.has_record else None
        self.names = ["E", "D"]
        if rig.has_modes or rig.medium == "air":
            self.names.append("air")
        if rig.has_record:
            self.names += ["damping", "size", "trigger"]
        self.offset: np.ndarray | float = 0.0
        self.sd_record = 1.0
        if self.still is not None:  # difference between the sum of few modes and the steps in time
            self.offset = subjects.shown_record(base, mesh, rig.medium) - self.still.record({})[0]
            self.sd_record = rig.motion * np.abs(self.still.record({})[0]).max()
        self.band: np.ndarray | None = None
        if mesh != "same":
            plain = Oracle(bases, "same", rig)
            self.band = self.residual(plain.show(plain.base), {})
            self.names.append("band")

    def show(self, subject: subjects.Subject) -> Shown:
        """Returns what the experiment would show without errors: (modes or None, record or None)."""
        return (subjects.shown_modes(subject, self.mesh) if self.rig.has_modes else None,
                subjects.shown_record(subject, self.mesh, self.rig.medium) if self.rig.has_record else None)

    def residual(self, shown: Shown, q: Mapping[str, float]) -> np.ndarray:
        """Returns the difference between what is shown and the wing with q, in units of the sd."""
        rig, rows = self.rig, []
        if self.air is not None and shown[0] is not None:
            own = self.air.modes(q, subjects.MODES + 2)
            rows += [part for pair in paired(rig, shown[0], own) for part in pair]
        if self.still is not None and shown[1] is not None:
            seen, speed = self.still.record(q)
            seen = (seen + self.offset) * (1 + rig.size * q.get("size", 0.0)) + speed * rig.trigger * q.get("trigger", 0.0)
            rows.append((shown[1] - seen).ravel() / self.sd_record)
        whole = np.concatenate(rows)
        return whole if self.band is None else whole - q.get("band", 0.0) * self.band

    def snr(self, shown: Shown) -> float:
        """Returns the signal-to-noise ratio of a measurement of a subject with an effect."""
        sd = np.array([PRIORS[name] for name in self.names])

        def rows(at: np.ndarray) -> np.ndarray:
            return np.concatenate([self.residual(shown, dict(zip(self.names, sd * at))), at])

        def slopes(at: np.ndarray) -> np.ndarray:
            start = rows(at)
            return np.stack([(rows(at + STEP * unit) - start) / STEP for unit in np.eye(len(at))], 1)
        found = optimize.least_squares(rows, np.zeros(len(sd)), slopes, x_scale="jac", ftol=1e-3, xtol=1e-6)
        return float(np.sqrt(2 * found.cost))


def paired(rig: Rig, shown: subjects.Modes, own: subjects.Modes) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Returns (ln of frequencies, part of the shape across the other one) of the modes that are measured, as differences in
    units of their sd."""
    left = list(range(len(own)))
    for number, (hertz, shape) in enumerate(shown[:subjects.MODES], 1):
        seen = shape[rig.sites]
        others = [own[i][1][rig.sites] for i in left]
        best = int(np.argmax([(seen @ other)**2 / (other @ other) * np.exp(-2 * np.log(own[i][0] / hertz)**2)
                              for i, other in zip(left, others)]))
        other, i = others[best], left.pop(best)
        if number not in rig.missing:
            yield np.array([np.log(hertz / own[i][0]) / rig.frequency]), (seen - other * (seen @ other) / (other @ other)) / rig.shape
