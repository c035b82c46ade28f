# SPDX-License-Identifier: GPL-3.0-or-later
"""The effects that blind cases of vibration hide, in addition to those effects of stiffness that bending tests have too. An
effect that needs a record is marked as such."""
from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flusi_msm.blind import effects as bending
from flusi_msm.blind.effects import DrawEffect, Effect, plain, sign_of
from flusi_msm.measurement.modes import densities, triangle_areas

if TYPE_CHECKING:
    from flusi_msm.blind.vibration_subject import Subject
    from flusi_msm.wing.file import Wing


def mass(subject: Subject, **changes: Any) -> Subject:
    """Returns the subject with other keys of its mass."""
    return replace(subject, mass=replace(subject.mass, **changes))


def damping(subject: Subject, **changes: Any) -> Subject:
    """Returns the subject with other keys of its damping."""
    return replace(subject, damping=replace(subject.damping, **changes))


def unstated(subject: Subject, **changes: Any) -> Subject:
    """Returns the subject with other unstated disturbances."""
    return replace(subject, unstated=replace(subject.unstated, **changes))


def factor_of_mass(key: str, parameter: str, sign: float) -> Effect:
    """Returns an effect that multiplies a part of the mass."""

    def value(s: float) -> float:
        return float(np.exp(sign * s))
    return Effect(parameter, lambda subject, s: mass(subject, **{key: value(s)}), lambda s: {parameter: value(s)}, 0.05, np.log(8))


# ---- in the catalogue ----------------------------------------------------------------------------

def vein_mass(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Changes the mass of the veins."""
    return factor_of_mass("veins", "vein_mass", sign_of(rng))


def membrane_mass(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Changes the mass of the membrane."""
    return factor_of_mass("membrane", "membrane_mass", sign_of(rng))


def membrane_gradient(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Lets the mass of the membrane grow or fall from root to tip."""
    return plain("membrane_gradient", mass, 0.05, 4.0, sign_of(rng))


def thickness_gradient(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Lets the thickness of the membrane, and with it its mass and its stiffness, grow or fall from root to tip."""
    sign = sign_of(rng)

    def apply(subject: Subject, s: float) -> Subject:
        return bending.stiffness(mass(subject, membrane_gradient=sign * s), thickness_gradient=sign * s)
    return Effect("thickness_gradient", apply, lambda s: {"thickness_gradient": sign * s}, 0.05, 2.0)


def point_mass(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Adds a point mass on the outer three quarters of the wing: near the root it hardly moves."""
    triangles = np.asarray(wing.triangles)
    areas, middle = triangle_areas(wing), wing.points[triangles].mean(1)
    root = wing.points[list(wing.root), 0].mean()
    areas = np.where(middle[:, 0] - root > 0.25 * np.ptp(wing.points[:, 0]), areas, 0)
    share = rng.dirichlet((1, 1, 1))
    x, y = map(float, share @ wing.points[triangles[rng.choice(len(triangles), p=areas / areas.sum())]][:, :2])
    whole = float((densities(wing, subject.mass)[1](middle[:, :2]) * triangle_areas(wing)).sum())
    return Effect("point_mass", lambda subject, s: mass(subject, point=(x, y, s)), lambda s: {"point_mass": s}, 1e-3 * whole,
                  whole, place=(x, y))


def stiffness_damping(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Adds damping in proportion to the stiffness."""
    effect = plain("rayleigh_stiffness", damping, 2e-6, 1e-3, 1.0)
    return replace(effect, name="stiffness_damping")


def joint_friction(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Adds friction in the joints."""
    return plain("joint_friction", damping, 1e-5, 5e-3, 1.0)


def viscoelasticity(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Lets the stiffness relax."""
    tau = float(10**rng.uniform(-4.3, -3.0))
    return Effect("viscoelasticity", lambda subject, s: damping(subject, relaxation=s, relaxation_time=tau),
                  lambda s: {"relaxation": s}, 0.02, 3.0)


def air_drag(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Adds a drag that grows with the square of the speed. In a vacuum it is not visible, and another effect is drawn."""
    return replace(plain("drag", damping, 0.5, 100.0, 1.0), name="air_drag")


def base_shake(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Lets the clamp continue to move after the release."""
    hertz, phase = float(rng.uniform(150.0, 900.0)), float(rng.uniform(0.0, 2 * np.pi))
    return Effect("base_shake", lambda subject, s: unstated(subject, shake=(s, hertz, phase)), lambda s: {}, 0.1, 1e3)


def membrane_bending(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Changes the membrane's bending stiffness. Since springs are not stretched near the flat rest shape, it is the only elastic
    property that is not fitted."""
    return replace(bending.membrane_bending(rng, wing, subject), also=("elasticity",))


def joint_stiffness(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Makes a joint softer by the factor 1 + s, where the baseline takes the joints as known. Its stiffness [N m/rad] is that of the
    mesh of the data."""
    joint = str(rng.choice(sorted(wing.joints)))
    k = subject.stiffness.joints[joint]
    def softer(s: float) -> float:
        return k / (1 + s)
    return Effect("joint_stiffness", lambda subject, s: bending.stiffness(subject, joints={**subject.stiffness.joints, joint: softer(s)}),
                  lambda s: {"joint:" + joint: softer(s)}, 0.1, 300.0,
                  place=tuple(map(float, wing.points[wing.joint_nodes(joint)[1]][:2])))


# ---- outside -------------------------------------------------------------------------------------

def membrane_wave(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Makes the membrane's mass go up and down over the wing."""
    lx, ly = map(float, np.ptp(wing.points[:, :2], axis=0) / rng.uniform(0.7, 2.5, 2))
    return Effect("membrane_wave", lambda subject, s: mass(subject, membrane_wave=(s, lx, ly)), lambda s: {}, 0.05, 0.95, False)


def lag(rng: np.random.Generator, wing: Wing, subject: Subject) -> Effect:
    """Adds a filter that no file states."""
    return replace(plain("lag", unstated, 2e-6, 1e-3, 1.0), is_known=False)


STRUCTURE = (bending.E_gradient, bending.E_per_vein, joint_stiffness, bending.taper, bending.soft_place, bending.vein_torsion,
             bending.damage, membrane_bending)
INERTIA = (vein_mass, membrane_mass, membrane_gradient, thickness_gradient, point_mass)
DAMPING = (stiffness_damping, joint_friction, viscoelasticity, air_drag, base_shake)  # only records show them
OUTSIDE = (bending.E_wave, bending.D_wave, membrane_wave)
OUTSIDE_OF_RECORDS = (lag,)


def menu(kind: str, has_record: bool) -> tuple[DrawEffect, ...]:
    """Returns the effects that a case of this kind can have."""
    if kind == "outside":
        return OUTSIDE + (OUTSIDE_OF_RECORDS if has_record else ())
    return STRUCTURE + INERTIA + (DAMPING if has_record else ())
