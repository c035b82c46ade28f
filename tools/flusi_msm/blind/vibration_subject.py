# SPDX-License-Identifier: GPL-3.0-or-later
"""The wing of a blind case of vibration with its hidden effects, and what an experiment without errors would show of it: natural
modes and a record after a release. The mechanics are those of make_modes and make_series."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flusi_msm.bending.mesh import refine
from flusi_msm.bending.model import Model, Stiffness
from flusi_msm.measurement import modes, series
from flusi_msm.measurement.case import Hidden
from flusi_msm.measurement.synthesis import soft_name, with_soft_places
from flusi_msm.wing.file import read_wing

if TYPE_CHECKING:
    from flusi_msm.wing.file import Wing

Modes = list[tuple[float, np.ndarray]]  # frequency [Hz], shape (points)
MODES, SITES = 6, 24  # of a test of modes
RELEASE, PLACES = (8.0e-3, -0.6e-3), ((8.4e-3, -0.7e-3), (6.5e-3, 0.1e-3), (5.5e-3, -1.6e-3))
FORCE, RATE, SAMPLES = 2.0e-5, 10000.0, 100  # of a record
STEPS = 64  # of time in a sample: with 8 the error of time has a signal-to-noise ratio of 7


@dataclass
class Unstated:
    """Disturbances of a record that no file states."""
    shake: tuple[float, float, float] = (0.0, 300.0, 0.0)  # [m/s^2], [Hz], phase of the clamp, which moves after the release
    lag: float = 0.0             # [s] of a filter of first order


@dataclass
class Subject:
    """A wing; `hidden` is for effects that bending tests have too."""
    wing: str
    stiffness: Stiffness
    hidden: Hidden = field(default_factory=Hidden)
    mass: modes.Mass = field(default_factory=modes.Mass)
    damping: series.Damping = field(default_factory=series.Damping)
    unstated: Unstated = field(default_factory=Unstated)
    air_ratio: float = 0.8


def meshed(subject: Any, mesh: str) -> tuple[Wing, Wing | None, Stiffness]:
    """Returns (wing on that mesh, wing of the wing file if it is another one, stiffness with that of soft places)."""
    plain = read_wing(subject.wing)
    wing = with_soft_places(plain, subject)
    wing.mass = plain.mass
    soft = {soft_name(k): row[2] for k, row in enumerate(subject.hidden.soft_places)}
    stiffness = replace(subject.stiffness, joints={**subject.stiffness.joints, **soft})
    if mesh == "same":
        return wing, None, stiffness
    fine = refine(wing)
    fine.mass = plain.mass
    return fine, wing, stiffness


def vein_joints(subject: Any, stiffness: Stiffness, mesh: str) -> dict[str, float]:
    """Returns the stiffness [N m/rad] of every joint that bends as the veins of this stiffness do on that mesh."""
    wing, coarse, bare = meshed(replace(subject, stiffness=replace(stiffness, joints={})), mesh)
    model = Model(wing, bare, float(np.mean(np.concatenate([d for _, d in (coarse or wing).veins.values()]))), 2.0 if coarse else 1.0)
    return {h.joint: float(model.hinge_stiffness(h)) for h in model.hinge_plan if h.joint}


def modes_case(subject: Any, stiffness: Stiffness, count: int = MODES) -> modes.Case:
    """Returns the case of make_modes for a subject."""
    return modes.Case(subject.wing, modes=count, stiffness=stiffness, mass=subject.mass, air_ratio=subject.air_ratio)


def record_case(subject: Subject, stiffness: Stiffness, medium: str, steps: int = STEPS) -> series.Case:
    """Returns the case of make_series for a subject."""
    return series.Case(subject.wing, point=RELEASE, size=FORCE, places=PLACES, rate=RATE, samples=SAMPLES, steps=steps, medium=medium,
                       air_ratio=subject.air_ratio, stiffness=stiffness, mass=subject.mass, damping=subject.damping,
                       lowpass=1 / (2 * np.pi * subject.unstated.lag) if subject.unstated.lag > 0 else 0.0,
                       shake=subject.unstated.shake)


def shown_modes(subject: Any, mesh: str) -> Modes:
    """Returns [(frequency, shape (points))] of more modes than are measured, so that modes which change their order are still
    among them."""
    wing, coarse, stiffness = meshed(subject, mesh)
    return modes.find_modes(wing, modes_case(subject, stiffness, MODES + 2), coarse)


def shown_record(subject: Subject, mesh: str, medium: str, steps: int = STEPS, late: float = 0.0) -> np.ndarray:
    """Returns the record (samples, places) [m], which begins `late` [s] after the release."""
    wing, coarse, stiffness = meshed(subject, mesh)
    case = record_case(subject, stiffness, medium, steps)
    times, seen = series.Motion(wing, case, coarse).record()
    seen = series.filtered(case, times, seen)
    wanted = np.maximum(late + np.arange(SAMPLES) / RATE, 0)
    return np.stack([np.interp(wanted, times, column) for column in seen.T], 1)
