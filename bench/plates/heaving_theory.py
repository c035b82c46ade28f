# SPDX-License-Identifier: GPL-3.0-or-later
"""Small motions of a plate in an inviscid plane stream that leaves its rear edge smoothly, and of one that bends as a beam.

The pressure of a plate with harmonic motion is that of Wu (1961, J. Fluid Mech. 10, 321) and Theodorsen (1935, NACA report 496): on the
plate x = cos(theta), theta = 0 at the rear edge, the acceleration potential on the upper side is

    phi = a_0/2 tan(theta/2) + sum over n > 0 of a_n sin(n theta),

and the pressure below minus that above is 2 rho U^2 phi. The coefficients follow from those of the velocity normal to the plate,
V = (i s + d/dx) Y = V_0/2 + sum V_n cos(n theta):

    a_0 = V_1 - (V_0 + V_1) C(s),        a_n = -V_n - i s (V_(n-1) - V_(n+1))/(2 n),

with Theodorsen's function C. Lengths are in half chords and times in half chords over U, s is the reduced frequency. The beam is that
of Euler and Bernoulli, clamped where the rigid part ends; its shape is a sum of the modes that it has in a vacuum (Moore 2017, SIAM
J. Appl. Math., arXiv:1612.08448, solves the same equations by collocation).
"""
import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import hankel2

POINTS = 4096   # of the transforms
MODES = 12      # of the beam


def theodorsen(s):
    """Returns Theodorsen's function of the reduced frequency s > 0."""
    first, zeroth = hankel2(1, s), hankel2(0, s)
    return first / (first + 1j * zeroth)


def cosines(values):
    """Returns the coefficients of sum c_n cos(n theta), c_0 twice the mean, of values at theta = (j + 1/2) pi/POINTS."""
    whole = np.concatenate([values, values[::-1]])
    n = np.arange(POINTS)
    return np.fft.fft(whole)[:POINTS] * np.exp(-0.5j * math.pi * n / POINTS) / POINTS


THETA = (np.arange(POINTS) + 0.5) * math.pi / POINTS
PLACE = (1 + np.cos(THETA)) / 2      # in chords, 0 at the front edge
WEIGHT = np.sin(THETA) / 2 * math.pi / POINTS  # the integral over the chord is the sum of values times these


def pressure(s, shape, slope):
    """Returns the pressure below the plate minus that above it in rho U^2 at PLACE, and the coefficient a_0, for the displacement
    `shape` in chords and its derivative along the chord."""
    speed = cosines(2j * s * shape + slope)
    before, at, after = speed[:-2], speed[1:-1], speed[2:]
    n = np.arange(1, POINTS - 1)
    a = -at - 1j * s * (before - after) / (2 * n)
    first = speed[1] - (speed[0] + speed[1]) * theodorsen(s)
    series = np.zeros(2 * POINTS, complex)
    series[1:POINTS - 1] = a * np.exp(0.5j * math.pi * n / POINTS)
    sines = (np.fft.ifft(series)[:POINTS] - np.fft.ifft(series.conj())[:POINTS].conj()) * POINTS / 1j
    return 2 * (first / 2 * np.tan(THETA / 2) + sines), first


def beam_mode(number, begin):
    """Returns shape, slope and curvature at PLACE of a mode of a beam that is clamped at `begin` and free at 1, and the fourth root of
    its stiffness over its mass."""
    length = 1 - begin
    guess = (number + 0.5) * math.pi
    root = brentq(lambda b: math.cos(b) + 1 / math.cosh(b), max(guess - 0.9, 1.0), guess + 0.9)
    ratio = (math.cosh(root) + math.cos(root)) / (math.sinh(root) + math.sin(root))
    z = np.maximum((PLACE - begin) / length, 0) * root
    # cosh(z) - ratio sinh(z), without the difference of two large numbers
    grow, fall = (1 - ratio) / 2 * np.exp(z), (1 + ratio) / 2 * np.exp(-z)
    cosh, sinh = grow + fall, grow - fall
    inside, k = PLACE > begin, root / length
    return (inside * (cosh - np.cos(z) + ratio * np.sin(z)), inside * k * (sinh + np.sin(z) + ratio * np.cos(z)),
            inside * k**2 * (cosh + np.cos(z) - ratio * np.sin(z)), k)


def heaving(frequency, amplitude, rigidity, mass, begin):
    """Returns motion and forces of a plate. Its front part, up to `begin` chords, moves up and down as amplitude cos(2 pi f t); the
    rest bends. Rigidity per width is in rho U^2 c^3, mass per area in rho c; rigidity None: a rigid plate. All lengths are in chords, frequencies in U/c.

    tip: complex displacement of the rear edge; thrust and power: means over rho U^2 c/2 and rho U^3 c/2; suction: the part of the thrust
    that acts on the front edge."""
    s, omega = math.pi * frequency, 2 * math.pi * frequency
    shape, slope = np.full(POINTS, amplitude, complex), np.zeros(POINTS, complex)
    tip = complex(amplitude)
    if rigidity is not None:
        modes = [beam_mode(j, begin) for j in range(MODES)]
        loads = [pressure(s, w, d)[0] for w, d, *_ in modes]
        driven = pressure(s, shape, slope)[0] + mass * omega**2 * amplitude * (PLACE > begin)
        matrix = np.array([[np.sum(WEIGHT * (rigidity * v[2] * w[2] - mass * omega**2 * v[0] * w[0] - v[0] * load))
                            for w, load in zip(modes, loads)] for v in modes])
        share = np.linalg.solve(matrix, [np.sum(WEIGHT * v[0] * driven) for v in modes])
        for q, (w, d, *_) in zip(share, modes):
            shape, slope = shape + q * w, slope + q * d
        ends = [2 * (-1) ** j for j in range(MODES)]
        tip += sum(q * end for q, end in zip(share, ends))
    jump, first = pressure(s, shape, slope)
    suction = math.pi / 4 * abs(first)**2
    thrust = suction + np.sum(WEIGHT * (jump * slope.conj()).real)
    power = -np.sum(WEIGHT * (jump * (1j * omega * shape).conj()).real)
    return {"tip": tip, "thrust": float(thrust), "power": float(power), "suction": suction}


def pitch(motion, amplitude):
    """Returns the amplitude of the angle between the line from the front to the rear edge and the stream, in degrees, and by how many
    degrees it is ahead of the heave."""
    bend = motion["tip"] - amplitude
    return math.degrees(math.atan(abs(bend))), math.degrees(np.angle(bend))
