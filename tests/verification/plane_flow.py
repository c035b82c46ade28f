#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The plane flow of tools/make_flight against exact solutions, published drag and itself on finer grids.

usage: plane_flow.py
"""
import unittest

import numpy as np

from flusi_msm.flow2d.beat import Beat
from flusi_msm.flow2d.flow import Flow, Motion
from flusi_msm.flow2d.forces import impulse, surface_force
from flusi_msm.flow2d.grid import Resolution
from flusi_msm.flow2d.hover import Effort, Section, fly

ROUND = 0.9999


def hover(period: float, lead: float = 0.0) -> Beat:
    """Stroke of 2.8 chords, chord at 90 + 45 sin degrees."""
    def turn(phase):
        return 2 * np.pi * phase
    return Beat(lambda p: (1.4 * np.cos(turn(p)), 0 * p), lambda p: np.pi / 2 + np.pi / 4 * np.sin(turn(p) + lead), period)


def difference(one, other, key):
    """Relative rms difference where both have records."""
    step = len(other["time"]) // len(one["time"])
    a, b = one[key], other[key][step - 1::step]
    late = one["time"] > 0.1 * one["time"][-1]
    return float(np.sqrt(np.mean((a - b)[late]**2) / np.mean(b[late]**2)))


class Start(unittest.TestCase):
    def accelerated(self, ratio, direction, spin, nu=1e-2, steps=160):
        """Times, and what a section gets that begins to move with the acceleration 1: force along the direction, or torque."""
        flow = Flow(1.0, ratio, nu, 5e-4, Resolution(16, 300, 1.5))
        times, found = [], []
        for n in range(1, steps + 1):
            t = n * flow.dt
            u, v = direction
            flow.step(Motion((u * t, v * t), (float(u), float(v)), spin * t, float(spin)))
            fx, fy, m = surface_force(flow)
            times.append(t)
            found.append(u * fx + v * fy + spin * m)
        return np.array(times), np.array(found)

    def test_circle(self):
        """A circle that is accelerated from rest: Stokes' solution at small times, -pi a^2 (1 + 8 sqrt(nu t/pi)/a + 2 nu t/a^2). The
        rest of the series and the flow that the motion carries along are below a thousandth by then."""
        t, force = self.accelerated(ROUND, (0, 1), 0)
        a, nu = 0.5, 1e-2
        exact = -np.pi * a**2 * (1 + 8 * np.sqrt(nu * t / np.pi) / a + 2 * nu * t / a**2)
        np.testing.assert_allclose(force[80:], exact[80:], rtol=2e-3)

    def test_added_mass(self):
        """The force of an ellipse goes to that of its added mass, pi b^2 along it, pi a^2 across it, pi/8 (a^2 - b^2)^2 about it, with the
        root of time: the straight line through two times ends there."""
        for ratio in (0.3, 0.6):
            a, b = 0.5, 0.5 * ratio
            for direction, spin, mass in (((1, 0), 0, np.pi * b**2), ((0, 1), 0, np.pi * a**2),
                                          ((0, 0), 1, np.pi / 8 * (a**2 - b**2)**2)):
                t, force = self.accelerated(ratio, direction, spin)
                root = np.sqrt(t)
                line = np.polyfit(root[39:], force[39:], 2)
                self.assertLess(abs(line[-1] + mass), 0.01 * abs(force[-1]), (ratio, direction, spin))


class Cylinder(unittest.TestCase):
    def stream(self, re, end, dt, resolution):
        """Time, drag and lift coefficient of a circle that is started at once, with a sideways push."""
        flow = Flow(1.0, ROUND, 1 / re, dt, resolution)
        rows = []
        for n in range(1, int(end / dt) + 1):
            t = n * dt
            push = 0.3 * np.exp(-(t - 3)**2) if re > 50 else 0.0
            flow.step(Motion((-1.0, push), (0.0, -2 * (t - 3) * push)))
            rows.append((t, *surface_force(flow)[:2]))
        return np.array(rows) @ np.diag([1, 2, 2])

    def test_steady_drag(self):
        """Re = 40: 1.52 (Dennis & Chang 1970), within 2 %; after 20 diameters it still falls by as much."""
        rows = self.stream(40, 20, 0.02, Resolution(24, 100, 40.0))
        self.assertAlmostEqual(rows[-1, 1], 1.52, delta=0.03)

    def test_vortex_street(self):
        """Re = 100: drag 1.33, Strouhal number 0.165, lift +- 0.33 of many published computations, within 3, 3 and 12 %."""
        rows = self.stream(100, 48, 0.008, Resolution(28, 100, 60.0))
        late = rows[rows[:, 0] > 28]
        t, lift = late[:, 0], late[:, 2]
        up = np.flatnonzero((lift[1:] > 0) & (lift[:-1] <= 0))
        crossings = t[up] - lift[up] * (t[up + 1] - t[up]) / (lift[up + 1] - lift[up])
        self.assertAlmostEqual(late[:, 1].mean(), 1.33, delta=0.04)
        self.assertAlmostEqual(1 / np.diff(crossings).mean(), 0.165, delta=0.005)
        self.assertAlmostEqual(np.ptp(lift) / 2, 0.33, delta=0.04)


class Hover(unittest.TestCase):
    def test_impulse(self):
        """The force is what the impulse of the vorticity loses, and the fluid of the section's size gains: two different integrals."""
        section, beat = Section(ratio=0.12, nu=1 / 75), hover(2.8 * np.pi)
        dt = 2.8 * np.pi / 1600
        flow, rows, t = Flow(1.0, section.ratio, section.nu, dt, Resolution(48, 120, 12.0)), [], 0.0
        for _ in range(600):
            t += dt
            place, rate, acceleration = (row[0] for row in beat.at(np.array([t])))
            c, s = np.cos(place[2]), np.sin(place[2])
            turn = np.array([[c, s], [-s, c]])
            flow.step(Motion(tuple(turn @ rate[:2]), tuple(turn @ acceleration[:2]), rate[2], acceleration[2]))
            # About the centre; what the turning section adds elsewhere takes away the circulation of the fluid.
            rows.append([*(np.array(impulse(flow)) @ turn), *(np.array(surface_force(flow)[:2]) @ turn),
                         *(flow.grid.area * acceleration[:2])])
        rows = np.array(rows)
        lost = -(rows[2:, :2] - rows[:-2, :2]) / (2 * dt) + rows[1:-1, 4:]
        late = slice(200, None)
        error = np.sqrt(np.mean((lost - rows[1:-1, 2:4])[late]**2) / np.mean(rows[1:-1, 2:4][late]**2))
        self.assertLess(error, 0.01)

    def test_second_order(self):
        """Errors fall fourfold where step and spacing are halved."""
        section, beat = Section(ratio=0.12, nu=1 / 75), hover(2.8 * np.pi)
        runs = [fly(section, beat, 1, Effort(600 * n, Resolution(24, 36 * n, 10.0))) for n in (1, 2, 4)]
        for key in ("force", "torque"):
            coarse, fine = difference(runs[0], runs[1], key), difference(runs[1], runs[2], key)
            self.assertGreater(coarse / fine, 3.0, key)
            self.assertLess(fine, 0.01, key)

    def test_units(self):
        """The same flight in other units."""
        period, effort = 2.8 * np.pi, Effort(600, Resolution(24, 40, 10.0))
        beat = hover(period)
        base = fly(Section(ratio=0.12, nu=1 / 75), beat, 1, effort)
        length, clock, density = 3e-3, 2e-4, 1.2
        small = Beat(lambda p: (length * 1.4 * np.cos(2 * np.pi * p), 0 * p), lambda p: np.pi / 2 + np.pi / 4 * np.sin(2 * np.pi * p),
                     period * clock)
        found = fly(Section(length, 0.12, 0.5, length**2 / clock / 75, density), small, 1, effort)
        np.testing.assert_allclose(found["force"], base["force"] * density * length**3 / clock**2, rtol=1e-8, atol=1e-12)
        np.testing.assert_allclose(found["power"], base["power"] * density * length**4 / clock**3, rtol=1e-8, atol=1e-12)

    def test_steps(self):
        """Where the steps that should do do not, as for a thin section that reverses fast, more are taken; given ones are not changed."""
        period = 2.8 * np.pi
        def turn(s):
            return 2 * np.pi * s
        fast = Beat(lambda s: (1.4 * (np.cos(turn(s)) + 0.06 * np.cos(3 * turn(s))), 0 * s),
                    lambda s: np.pi / 2 + np.pi / 4 * np.sin(turn(s)), period)
        section, coarse = Section(ratio=0.02, nu=1 / 75), Resolution(24, 40, 10.0)
        found = fly(section, fast, 1, Effort(0, coarse))
        self.assertTrue(np.isfinite(found["force"]).all())
        with self.assertRaises(ArithmeticError):
            fly(section, fast, 1, Effort(300, coarse))

    def test_hinge(self):
        """The hinge is where the motion is given: a plate held at its leading end and one held at its centre that move alike."""
        period, effort, offset = 6.0, Effort(600, Resolution(24, 40, 10.0)), -0.5
        def angle(p):
            return 0.5 * np.sin(2 * np.pi * p)
        at_end = Beat(lambda p: (0 * p, 0.3 * np.cos(2 * np.pi * p)), angle, period)
        centre = Beat(lambda p: (offset * np.cos(angle(p)), 0.3 * np.cos(2 * np.pi * p) + offset * np.sin(angle(p))), angle, period)
        a = fly(Section(ratio=0.2, nu=0.02, hinge=0.0), at_end, 1, effort)
        b = fly(Section(ratio=0.2, nu=0.02, hinge=0.5), centre, 1, effort)
        scale = np.abs(a["force"]).max()
        np.testing.assert_allclose(a["force"], b["force"], atol=1e-6 * scale)
        np.testing.assert_allclose(a["power"], b["power"], atol=1e-6 * scale)


if __name__ == "__main__":
    unittest.main()
