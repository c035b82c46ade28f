# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the flight of an elliptic section from rest through some beats. Forces y, z and the torque about x are in axes at
rest."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flusi_msm.flow2d.beat import Beat
from flusi_msm.flow2d.flow import Flow, Motion
from flusi_msm.flow2d.forces import surface_force
from flusi_msm.flow2d.grid import Resolution


@dataclass
class Section:
    """A section and its fluid, in the units of the motion."""
    chord: float = 1.0
    ratio: float = 0.05      # of thickness to chord
    hinge: float = 0.5       # from the leading end, in chords
    nu: float = 0.01         # kinematic viscosity
    density: float = 1.0
    wind: tuple[float, float] = (0.0, 0.0)   # of the fluid far away, along y and z


@dataclass
class Effort:
    """How finely the flow is computed."""
    steps: int = 0           # of time in a beat; 0: as many as are stable
    resolution: Resolution = field(default_factory=Resolution)


STABLE = 0.7   # times nu over the square of the speed
TRIES = 4


def largest_speed(section: Section, beat: Beat) -> float:
    """Returns the largest speed of the hinge against the fluid, or of an end of a chord that only turns."""
    _, rate, _ = beat.at(np.linspace(0, beat.period, 400))
    return max(float(np.hypot(rate[:, 0] - section.wind[0], rate[:, 1] - section.wind[1]).max()),
               float(0.5 * section.chord * np.abs(rate[:, 2]).max()))


def steps_of(section: Section, speed: float, period: float, effort: Effort) -> int:
    """Returns the number of steps in a beat. Because the flux is extrapolated, a step must not be longer than about nu/speed^2,
    on any grid, so that diffusion keeps it stable."""
    return effort.steps or max(400, int(np.ceil(period * speed**2 / (STABLE * section.nu))))


def fly(section: Section, beat: Beat, beats: int, effort: Effort) -> dict[str, np.ndarray]:
    """Does the same as fly_in_steps. If the usual number of steps is not enough it tries again with more, unless the number is
    given."""
    steps = steps_of(section, largest_speed(section, beat), beat.period, effort)
    for attempt in range(TRIES):
        try:
            return fly_in_steps(section, beat, beats, steps, effort.resolution)
        except ArithmeticError:
            if effort.steps or attempt == TRIES - 1:
                raise
            steps = int(1.5 * steps)
    raise ArithmeticError


def fly_in_steps(section: Section, beat: Beat, beats: int, steps: int, resolution: Resolution) -> dict[str, np.ndarray]:
    """Computes a flight with a given number of steps. Returns at every step after the start: `time`, `force` (n, 2) of the fluid
    on the section, `torque` about its hinge, `power` that the section gives to the flow, and `place` (n, 3) and `acceleration`
    (n, 3) of hinge and angle; all in the units of the motion."""
    length, speed = section.chord, largest_speed(section, beat)
    clock = length / speed
    time = np.arange(steps * beats + 1) * (beat.period / steps)
    place, rate, acceleration = beat.at(time)
    flow = Flow(1.0, section.ratio, section.nu / (speed * length), time[1] / clock, resolution)
    offset = section.hinge - 0.5   # of the centre from the hinge, toward the leading end
    force, torque = np.zeros((len(time), 2)), np.zeros(len(time))
    for n in range(1, len(time)):
        c, s = np.cos(place[n, 2]), np.sin(place[n, 2])
        turn = np.array([[c, s], [-s, c]])
        spin, spin_up = rate[n, 2] * clock, acceleration[n, 2] * clock**2
        velocity = turn @ (rate[n, :2] - section.wind) / speed + [0, spin * offset]
        pull = turn @ acceleration[n, :2] * clock / speed + [-spin**2 * offset, spin_up * offset]
        flow.step(Motion(tuple(velocity), tuple(pull), spin, spin_up))
        fx, fy, m = surface_force(flow)
        force[n], torque[n] = np.array([fx, fy]) @ turn, m + offset * fy
    force *= section.density * speed**2 * length
    torque *= section.density * speed**2 * length**2
    power = -(force * rate[:, :2]).sum(1) - torque * rate[:, 2]
    return {name: values[1:] for name, values in (("time", time), ("force", force), ("torque", torque), ("power", power),
                                                  ("place", place), ("acceleration", acceleration))}
