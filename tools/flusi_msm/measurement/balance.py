# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the signals of a synthetic force balance from the forces on a flapping section, with errors that differ from beat to
beat."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flusi_msm.errors import InputError

if TYPE_CHECKING:
    from flusi_msm.measurement.flight import Case

COMPONENTS = {"Fy": "N/m", "Fz": "N/m", "Mx": "N", "power": "W/m"}          # of a section, per metre of span
OF_A_WING = {"Fx": "N", "Fy": "N", "Fz": "N", "Mx": "N m", "My": "N m", "Mz": "N m", "power": "W"}
PER_LENGTH = {"N": "N/m", "N m": "N", "W": "W/m"}


@dataclass
class Balance:
    """Errors of the balance, in this order: the force on the wing minus the inertia, delayed, filtered, turned, mixed, times the
    gain, plus the offset. The power has none of these errors."""
    inertia: float = 0.0              # [kg/m] that was not subtracted, at the hinge
    delay: float = 0.0                # [s]
    lowpass: float = 0.0              # [Hz] cut-off of a filter of first order; 0: none
    turn: float = 0.0                 # [deg] the axes of the record are turned from y toward z, which the file states
    misalignment: float = 0.0         # [deg] the axes of the balance are turned from y toward z, more than the file states
    cross_talk: tuple[float, ...] = (0.0, 0.0)  # share of Fz in Fy, and of Fy in Fz
    gain: float = 1.0
    offset: tuple[float, ...] = (0.0, 0.0, 0.0)  # [N/m, N/m, N] of Fy, Fz, Mx
    reference: tuple[float, ...] = (0.0, 0.0, 0.0)  # [m] point about which the torque is


@dataclass
class Scatter:
    """Standard deviations in one beat, relative to the rms of each component."""
    white: float = 0.1                # independent of everything
    correlated: float = 0.0           # with the correlation exp(-dt/correlation_time)
    correlation_time: float = 2.0e-4  # [s]
    amplitude: float = 0.0            # of a beat, all components alike
    timing: float = 0.0               # of a beat, in beats
    stated: float = 1.0               # factor on the spread and sd that are written to the file
    model: float = 0.0                # of rms: adds to the stated sd, not to the data; difference of two simulations of one flow
    model_time: float = 0.0           # [s] over which this error stays the same; the file then states it for the whole sd


def check_names(text: str) -> tuple[str, ...]:
    """Returns the names in a list such as `Fy, Fz`."""
    names = tuple(word.strip() for word in text.split(","))
    for name in names:
        if name not in COMPONENTS:
            raise InputError(f"components: {name or 'an empty name'} is none of {', '.join(COMPONENTS)}")
    if len(set(names)) != len(names):
        raise InputError("components: a name is there twice")
    return names


def units_of(names: Iterable[str], is_per_length: bool) -> list[str]:
    """Returns the units of components."""
    return [PER_LENGTH[OF_A_WING[name]] if is_per_length else OF_A_WING[name] for name in names]


def filtered(time: np.ndarray, values: np.ndarray, cut_off: float) -> np.ndarray:
    """Returns the output of a filter of first order whose input was 0 before the first time; values between the times are
    interpolated linearly."""
    if not cut_off:
        return values
    step = time[1] - time[0]
    x = 2 * np.pi * cut_off * step
    keep = np.exp(-x)
    late = 1 - (1 - keep) / x      # weight of the newer value
    out, here = np.empty_like(values), values[0] * 0
    before = values[0] * 0
    for n, value in enumerate(values):
        here = keep * here + (1 - keep - late) * before + late * value
        before = value
        out[n] = here
    return out


def shown(exact: Mapping[str, np.ndarray], balance: Balance) -> dict[str, np.ndarray]:
    """Returns the signal of the balance for each component over the whole flight."""
    time = exact["time"]
    rows = np.stack([exact["Fy"], exact["Fz"], exact["Mx"]], 1)
    rows[:, :2] -= balance.inertia * exact["acceleration"][:, :2]
    y, z = exact["place"][:, 0] - balance.reference[1], exact["place"][:, 1] - balance.reference[2]
    rows[:, 2] -= balance.inertia * (y * exact["acceleration"][:, 1] - z * exact["acceleration"][:, 0])
    if balance.delay:
        rows = np.stack([np.interp(time - balance.delay, time, column, left=0.0) for column in rows.T], 1)
    rows = filtered(time, rows, balance.lowpass)
    angle = np.radians(balance.turn + balance.misalignment)
    c, s = np.cos(angle), np.sin(angle)
    fy, fz = c * rows[:, 0] + s * rows[:, 1], c * rows[:, 1] - s * rows[:, 0]
    mixed = fy + balance.cross_talk[0] * fz, fz + balance.cross_talk[1] * fy, rows[:, 2]
    out = {name: balance.gain * column + offset for name, column, offset in zip(("Fy", "Fz", "Mx"), mixed, balance.offset)}
    return {**out, "power": exact["power"]}


def one_beat(random: np.random.Generator, noise: Scatter, beats: np.ndarray, values: np.ndarray, phase: np.ndarray, period: float,
             rms: np.ndarray) -> np.ndarray:
    """Returns one beat with its errors, at the phases of the last beat of the flight; values(beats) (n, k) are those of the
    flight."""
    last = np.floor(beats[-1] + 0.5) - 1
    at = last + phase + noise.timing * random.standard_normal()
    at = np.where(at > beats[-1], at - 1, at)
    out = np.stack([np.interp(at, beats, column) for column in values.T], 1) * (1 + noise.amplitude * random.standard_normal())
    out += noise.white * rms * random.standard_normal(out.shape)
    if noise.correlated:
        keep = np.exp(-np.diff(phase) * period / noise.correlation_time)
        x = random.standard_normal(out.shape)
        for n in range(1, len(phase)):
            x[n] = keep[n - 1] * x[n - 1] + np.sqrt(1 - keep[n - 1]**2) * x[n]
        out += noise.correlated * rms * x
    return out


def averaged(case: Case, beats: np.ndarray, values: np.ndarray, phase: np.ndarray) -> dict[str, np.ndarray]:
    """Returns mean, spread and sd of many beats, {mean, spread, sd: (n, k)}, and all beats (beats, n, k). The spread is that of
    the beats at each phase; the sd is one number for a component, from all phases."""
    noise, random = case.noise, np.random.default_rng(case.seed)
    inside = beats > beats[-1] - 1
    rms = np.sqrt(np.mean(values[inside]**2, axis=0))
    all_beats = np.stack([one_beat(random, noise, beats, values, phase, 1 / case.kinematics.frequency, rms) for _ in range(case.beats)])
    if case.beats > 1:
        spread = all_beats.std(axis=0, ddof=1)
    else:
        spread = np.full(all_beats.shape[1:], 1.0) * rms * np.hypot(noise.white, noise.correlated)
    model = noise.model * rms
    spread = np.sqrt((noise.stated * spread)**2 + case.beats * model**2)
    pooled = np.sqrt(np.mean(spread**2, axis=0) / case.beats)
    if not (spread > 0).all():
        raise InputError("noise: nothing scatters; give at least noise.white or noise.model")
    return {"mean": all_beats.mean(axis=0), "spread": spread, "sd": np.broadcast_to(pooled, spread.shape).copy(), "all": all_beats}
