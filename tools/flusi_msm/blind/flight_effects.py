# SPDX-License-Identifier: GPL-3.0-or-later
"""The effects that blind flights hide: errors of kinematics, flow and balance, and effects that no catalogue contains. As in
blind/effects.py an effect is drawn at random except for its strength, a number that is 0 where it vanishes. In a fluid at rest a
tilted stroke has the same effect as a turned balance, and an early motion the same as a late balance: each pair has one name."""
from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flusi_msm.blind.effects import Effect, sign_of

if TYPE_CHECKING:
    from flusi_msm.measurement.flight import Case


def part(case: Case, section: str, **changes: Any) -> Case:
    """Returns the case with other keys of a section."""
    return replace(case, **{section: replace(getattr(case, section), **changes)})


def plain(name: str, section: str, key: str, first: float, most: float, sign: float, null: float = 0.0, factor: bool = False, **more: Any) \
        -> Effect:
    """Returns an effect with one key: null + sign s, or null exp(sign s)."""
    def value(s: float) -> float:
        return null * float(np.exp(sign * s)) if factor else null + sign * s
    return Effect(name, lambda case, s: part(case, section, **{key: value(s)}), lambda s: {f"{section}.{key}": value(s)}, first, most, **more)


def vector(name: str, section: str, key: str, place: tuple[int, int], size: float, first: float, most: float, sign: float) -> Effect:
    """Returns an effect on one number of a tuple, s times size."""
    def value(s: float) -> tuple[float, ...]:
        return tuple(sign * s * size if n == place[0] else 0.0 for n in range(place[1]))
    return Effect(name, lambda case, s: part(case, section, **{key: value(s)}), lambda s: {f"{section}.{key}": value(s)}, first, most)


# ---- in the catalogue -----------------------------------------------------------------------------

def stroke_amplitude(rng: np.random.Generator, case: Case) -> Effect:
    """Changes the stroke amplitude."""
    return plain("stroke_amplitude", "hidden", "stroke", 0.02, 0.3, sign_of(rng), 1.0, True)


def pitch_amplitude(rng: np.random.Generator, case: Case) -> Effect:
    """Changes the amplitude of the pitch."""
    return plain("pitch_amplitude", "hidden", "pitch", 0.02, 0.4, sign_of(rng), 1.0, True)


def pitch_lead(rng: np.random.Generator, case: Case) -> Effect:
    """Lets the pitch lead or lag."""
    return plain("pitch_lead", "hidden", "lead", 2.0, 40.0, sign_of(rng))


def pitch_mean(rng: np.random.Generator, case: Case) -> Effect:
    """Changes the mean angle of the chord."""
    return plain("pitch_mean", "hidden", "mean_angle", 1.0, 20.0, sign_of(rng))


def stroke_plane(rng: np.random.Generator, case: Case) -> Effect:
    """Turns the stroke plane."""
    return plain("balance_turn", "hidden", "plane", 1.0, 25.0, sign_of(rng), also=("stroke_plane",))


def beat_frequency(rng: np.random.Generator, case: Case) -> Effect:
    """Changes the frequency of the beat."""
    return plain("beat_frequency", "hidden", "frequency", 0.01, 0.25, sign_of(rng), 1.0, True)


def phase_lag(rng: np.random.Generator, case: Case) -> Effect:
    """Shifts the motion against the record."""
    return plain("balance_delay", "hidden", "phase", 0.003, 0.1, sign_of(rng))


def wind(rng: np.random.Generator, case: Case) -> Effect:
    """Adds a wind along one axis."""
    speed = np.pi * case.kinematics.frequency * case.kinematics.stroke
    return vector("wind", "hidden", "wind", (int(rng.integers(2)), 2), speed, 0.02, 0.4, sign_of(rng))


def viscosity(rng: np.random.Generator, case: Case) -> Effect:
    """Changes the viscosity of the fluid."""
    return plain("viscosity", "hidden", "viscosity", 0.05, 0.6, sign_of(rng), 1.0, True)


def balance_gain(rng: np.random.Generator, case: Case) -> Effect:
    """Multiplies the signals of the balance."""
    return plain("balance_gain", "balance", "gain", 0.02, 0.5, sign_of(rng), 1.0, True)


def balance_offset(rng: np.random.Generator, case: Case) -> Effect:
    """Adds a constant to one component of the balance."""
    speed = np.pi * case.kinematics.frequency * case.kinematics.stroke
    size = 0.5 * case.fluid.density * speed**2 * case.wing.chord
    return vector("balance_offset", "balance", "offset", (int(rng.integers(2)), 3), size, 0.05, 1.0, sign_of(rng))


def balance_turn(rng: np.random.Generator, case: Case) -> Effect:
    """Turns the axes of the balance."""
    return plain("balance_turn", "balance", "misalignment", 1.0, 25.0, sign_of(rng), also=("stroke_plane",))


def cross_talk(rng: np.random.Generator, case: Case) -> Effect:
    """Mixes one component of the balance into the other."""
    return vector("cross_talk", "balance", "cross_talk", (int(rng.integers(2)), 2), 1.0, 0.02, 0.4, sign_of(rng))


def balance_lowpass(rng: np.random.Generator, case: Case) -> Effect:
    """Adds a low-pass filter; the strength is its time constant in beats."""
    def cut_off(s: float) -> float:
        return case.kinematics.frequency / (2 * np.pi * s) if s else 0.0
    return Effect("balance_lowpass", lambda case, s: part(case, "balance", lowpass=cut_off(s)), lambda s: {"balance.lowpass": cut_off(s)},
                  0.005, 0.15)


def balance_delay(rng: np.random.Generator, case: Case) -> Effect:
    """Delays the signals of the balance."""
    return plain("balance_delay", "balance", "delay", 0.003 / case.kinematics.frequency, 0.1 / case.kinematics.frequency, 1.0)


def wing_inertia(rng: np.random.Generator, case: Case) -> Effect:
    """Adds a mass of the wing that is at most ten times that of the fluid in a circle about the chord."""
    return plain("wing_inertia", "balance", "inertia", 0.05 * case.fluid.density * case.wing.chord**2,
                 8 * case.fluid.density * case.wing.chord**2, 1.0)


def wing_area(rng: np.random.Generator, case: Case) -> Effect:
    """Changes the chord, which is the area per length of a section."""
    return plain("wing_area", "hidden", "chord", 0.02, 0.25, sign_of(rng), 1.0, True)


# ---- outside the catalogue -------------------------------------------------------------------------

def deviation(rng: np.random.Generator, case: Case) -> Effect:
    """Lets the path of the hinge be an eight."""
    return plain("deviation", "hidden", "deviation", 0.02 * case.wing.chord, 0.5 * case.wing.chord, sign_of(rng),
                 is_known=False)


def free_play(rng: np.random.Generator, case: Case) -> Effect:
    """Gives the pitch a free play."""
    return plain("free_play", "hidden", "free_play", 2.0, 25.0, 1.0, is_known=False)


def asymmetry(rng: np.random.Generator, case: Case) -> Effect:
    """Makes one half stroke faster than the other."""
    return plain("asymmetry", "hidden", "asymmetry", 0.03, 0.5, sign_of(rng), is_known=False)


def third_harmonic(rng: np.random.Generator, case: Case) -> Effect:
    """Adds a third harmonic to the stroke."""
    return plain("third_harmonic", "hidden", "third_harmonic", 0.01, 0.15, sign_of(rng), is_known=False)


KINEMATICS = (stroke_amplitude, pitch_amplitude, pitch_lead, pitch_mean, stroke_plane, beat_frequency, phase_lag)
FLOW = (wind, viscosity, wing_area)
BALANCE = (balance_gain, balance_offset, balance_turn, cross_talk, balance_lowpass, balance_delay, wing_inertia)
KNOWN = KINEMATICS + FLOW + BALANCE
OUTSIDE = (free_play, asymmetry, third_harmonic, deviation)
