# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/make_flight: the balance does what it says, noise has the size that is stated, motions are hidden where they should be, and
the file holds all of it.

usage: test_make_flight.py [reader of measurement files]
"""
import json
import subprocess
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.measurement.balance import Balance, Scatter, averaged, shown
from flusi_msm.measurement.flight import Cameras, Case, Hidden, Motion, Stated, beat_of, beats_of, check, clean, follow, read_case, synthesise
from flusi_msm.measurement.flight import tracked
from flusi_msm.measurement.flight import Flow as Computed
from flusi_msm.seal import check_seal

SOURCE = Path(__file__).resolve().parents[3]
COARSE = Computed(beats=1, modes=24, radial=40, radius=10.0)
F = 200.0
READER = ""


def sines(beats=6, steps=2000):
    """Forces that are sines for long, and a hinge that is accelerated."""
    time = np.arange(1, beats * steps + 1) / (steps * F)
    w = 2 * np.pi * F * time
    return {"time": time, "Fy": np.sin(w), "Fz": 0.5 * np.cos(w), "Mx": 0 * w + 0.1, "power": np.sin(w)**2,
            "place": np.stack([0.3 * np.cos(w), 0 * w, 0 * w], 1), "acceleration": np.stack([-np.cos(w), 2 * np.sin(w), 0 * w], 1)}


class Shown(unittest.TestCase):
    def late(self, **errors):
        exact = sines()
        found = shown(exact, Balance(**errors))
        last = slice(-2000, None)
        return {name: values[last] for name, values in exact.items()}, {name: values[last] for name, values in found.items()}

    def test_right_balance(self):
        exact, found = self.late()
        for name in "Fy", "Fz", "Mx", "power":
            np.testing.assert_array_equal(found[name], exact[name])

    def test_gain_offset_cross_talk(self):
        exact, found = self.late(gain=1.1, offset=(1.0, 2.0, 3.0), cross_talk=(0.05, -0.02))
        np.testing.assert_allclose(found["Fy"], 1.1 * (exact["Fy"] + 0.05 * exact["Fz"]) + 1)
        np.testing.assert_allclose(found["Fz"], 1.1 * (exact["Fz"] - 0.02 * exact["Fy"]) + 2)
        np.testing.assert_allclose(found["Mx"], 1.1 * exact["Mx"] + 3)
        np.testing.assert_array_equal(found["power"], exact["power"])

    def test_misalignment(self):
        """Axes that are turned by 90 degrees from y toward z: their y is z, their z is -y."""
        exact, found = self.late(misalignment=90.0)
        np.testing.assert_allclose(found["Fy"], exact["Fz"], atol=1e-12)
        np.testing.assert_allclose(found["Fz"], -exact["Fy"], atol=1e-12)

    def test_turn(self):
        """A turn that the file states acts as one that it hides, before the errors of the balance; the axes of the record have it."""
        _, hidden = self.late(misalignment=50.0, cross_talk=(0.05, -0.02), offset=(1.0, 2.0, 3.0))
        _, stated = self.late(turn=40.0, misalignment=10.0, cross_talk=(0.05, -0.02), offset=(1.0, 2.0, 3.0))
        for name in "Fy", "Fz", "Mx", "power":
            np.testing.assert_allclose(stated[name], hidden[name], atol=1e-14)

    def test_inertia(self):
        """The balance bears the wing: it lacks mass times acceleration, at the place of the hinge."""
        exact, found = self.late(inertia=0.2)
        np.testing.assert_allclose(found["Fy"], exact["Fy"] - 0.2 * exact["acceleration"][:, 0])
        np.testing.assert_allclose(found["Mx"], exact["Mx"] - 0.2 * exact["place"][:, 0] * exact["acceleration"][:, 1])

    def test_delay_and_filter(self):
        """A sine comes late, and is made smaller by 1/sqrt(1 + (f/f_c)^2) and later by atan(f/f_c) as by a filter of first order."""
        w = 2 * np.pi * F * sines()["time"][-2000:]
        _, found = self.late(delay=2e-4)
        np.testing.assert_allclose(found["Fy"], np.sin(w - 2 * np.pi * F * 2e-4), atol=1e-5)
        _, found = self.late(lowpass=300.0)
        ratio = F / 300
        np.testing.assert_allclose(found["Fy"], np.sin(w - np.arctan(ratio)) / np.sqrt(1 + ratio**2), atol=1e-5)


class Beats(unittest.TestCase):
    def record(self, noise, beats=400, seed=3):
        exact = sines(3)
        case = SimpleNamespace(noise=noise, seed=seed, beats=beats, kinematics=Motion(frequency=F))
        return averaged(case, exact["time"] * F, np.stack([exact["Fy"], exact["Fz"]], 1), np.arange(40) / 40)

    def test_white(self):
        """Mean, spread and sd of 400 beats: the spread is 10 % of the rms to 4 sd, the mean is within 5 of its sd."""
        found, rms = self.record(Scatter(white=0.1)), np.array([1, 0.5]) / np.sqrt(2)
        phase = 2 * np.pi * np.arange(40) / 40
        exact = np.stack([np.sin(phase), 0.5 * np.cos(phase)], 1)
        np.testing.assert_allclose(found["spread"] / (0.1 * rms), 1, atol=4 / np.sqrt(800))
        np.testing.assert_allclose(found["sd"][0], 0.1 * rms / 20, rtol=0.03)
        self.assertLess((np.abs(found["mean"] - exact) / found["sd"]).max(), 5)

    def test_correlated(self):
        """Neighbours at 1/40 beat have the correlation exp(-dt/time)."""
        found = self.record(Scatter(white=0.0, correlated=0.1, correlation_time=4e-4))
        rest = found["all"] - found["mean"]
        ratio = (rest[:, 1:] * rest[:, :-1]).sum() / (rest[:, 1:]**2).sum()
        self.assertAlmostEqual(ratio, np.exp(-1 / (40 * F * 4e-4)), delta=0.02)
        np.testing.assert_allclose(found["spread"].mean(0) / (0.1 * np.array([1, 0.5]) / np.sqrt(2)), 1, atol=0.05)

    def test_from_beat_to_beat(self):
        found = self.record(Scatter(white=1e-6, amplitude=0.05))
        self.assertAlmostEqual(found["spread"][10, 0], 0.05, delta=0.008)  # where the sine is 1
        self.assertLess(found["spread"][0, 0], 1e-3)
        found = self.record(Scatter(white=1e-6, timing=0.01))
        self.assertAlmostEqual(found["spread"][0, 0], 2 * np.pi * 0.01, delta=0.01)

    def test_stated(self):
        """What is stated may be wrong, and may have the error of a model."""
        right, wrong = self.record(Scatter(white=0.1)), self.record(Scatter(white=0.1, stated=0.5))
        np.testing.assert_allclose(wrong["spread"], 0.5 * right["spread"])
        np.testing.assert_array_equal(wrong["mean"], right["mean"])
        model = self.record(Scatter(white=0.1, model=0.05))
        np.testing.assert_allclose(model["sd"][0]**2, right["sd"][0]**2 + (0.05 * np.array([1, 0.5]) / np.sqrt(2))**2, rtol=1e-3)
        with self.assertRaisesRegex(InputError, "nothing scatters"):
            self.record(Scatter(white=0.0))


class Motions(unittest.TestCase):
    def at(self, when, **hidden):
        case = Case(hidden=Hidden(**hidden))
        value, _, _ = beat_of(case).at(np.atleast_1d(when) / case.kinematics.frequency)
        return value

    def test_as_stated(self):
        y, z, angle = self.at([0.0, 0.25, 0.5]).T
        np.testing.assert_allclose(y, [1.12e-3, 0, -1.12e-3], atol=1e-12)
        np.testing.assert_allclose(z, 0, atol=1e-12)
        np.testing.assert_allclose(np.degrees(angle), [90, 135, 90], atol=1e-6)

    def test_hidden(self):
        self.assertAlmostEqual(np.degrees(self.at(0.0, lead=10)[0, 2]), 90 + 45 * np.sin(np.radians(10)), 6)
        self.assertAlmostEqual(np.degrees(self.at(0.25, pitch=0.9, mean_angle=3)[0, 2]), 93 + 40.5, 6)
        self.assertAlmostEqual(self.at(0.0, stroke=1.1, third_harmonic=0.1)[0, 0], 1.12e-3 * 1.1 * 1.1, 9)
        turned = self.at(0.0, plane=30.0)[0]
        np.testing.assert_allclose(turned, [1.12e-3 * np.cos(np.pi / 6), 0.56e-3, np.pi * 2 / 3], atol=1e-9)
        np.testing.assert_allclose(self.at(0.1, phase=0.05), self.at(0.15), atol=1e-9)
        self.assertAlmostEqual(self.at(0.125, deviation=1e-4)[0, 1], 1e-4, 9)
        early, late = self.at([0.5 - 0.2 / np.pi, 0.9999], asymmetry=0.2)
        self.assertLess(early[0], -1.11e-3)  # the first half stroke ends before half of the beat
        self.assertGreater(late[0], 1.11e-3)

    def test_free_play(self):
        """Behind a play of 10 degrees a sine of 45 has its largest values cut by 5, and comes late."""
        sine = 45 * np.sin(2 * np.pi * np.arange(2048) / 2048)
        found = follow(sine, 10.0)
        self.assertAlmostEqual(found.max(), 40.0, delta=0.01)
        self.assertLessEqual(np.abs(found - sine).max(), 5.0 + 1e-9)
        self.assertLess(found[0], -4.9)
        np.testing.assert_array_equal(follow(sine, 0.0), sine)


class Flights(unittest.TestCase):
    def test_torque_about_the_reference(self):
        """Another point of reference adds its arm times the force."""
        case = Case(flow=COARSE)
        exact = clean(case)
        other = clean(replace(case, balance=Balance(reference=(0.0, 2e-3, -1e-3))))
        np.testing.assert_allclose(other["Mx"], exact["Mx"] - 2e-3 * exact["Fz"] - 1e-3 * exact["Fy"], atol=1e-15)

    def test_frequency(self):
        """A wing that beats faster with the same Reynolds number has the same coefficients: forces grow with the square."""
        case = Case(flow=COARSE)
        slow, fast = clean(case), clean(replace(case, hidden=Hidden(frequency=1.1, viscosity=1.1)))
        at = np.linspace(0.1, 0.9, 50)
        a, b = (np.interp(at, beats_of(c, x), x["Fz"]) for c, x in ((case, slow), (replace(case, hidden=Hidden(frequency=1.1)), fast)))
        np.testing.assert_allclose(b, 1.21 * a, atol=1e-6 * np.abs(a).max())

    def test_wind_is_motion(self):
        """A wind along y is felt as if the hinge moved against it: a faster half stroke drags more, a slower one less."""
        case = Case(flow=COARSE)
        still, windy = (clean(replace(case, hidden=Hidden(wind=(w, 0.0)))) for w in (0.0, 0.3))
        first = slice(len(still["time"]) // 8, len(still["time"]) * 3 // 8)   # moves toward -y
        self.assertGreater(windy["Fy"][first].mean(), 1.2 * still["Fy"][first].mean())

    def test_command(self):
        """The file, its seal and the truth; a second record; the same seed."""
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            (folder / "case.json").write_text(json.dumps({"components": "Fy, Fz, Mx, power", "samples": 32, "flow": vars(COARSE)}))

            def make(*more, code=0):
                done = subprocess.run([sys.executable, "-B", SOURCE / "tools/make_flight", "case.json", "-o", "flight.h5", *more],
                                      cwd=folder, capture_output=True, text=True)
                self.assertEqual(done.returncode, code, done.stderr)
                return done.stderr
            make()
            self.assertTrue(check_seal(folder / "flight.h5"))
            with h5py.File(folder / "flight.h5") as file:
                first = file["flight/hover/mean"][()]
                self.assertEqual(first.shape, (32, 4))
                self.assertEqual(file["flight/hover"].attrs["units"], b"N/m, N/m, N, W/m")
                self.assertEqual(file["flight/hover"].attrs["per_length"], 1)
                self.assertEqual(set(file["flight/hover"]), {"time", "mean", "spread"})
            truth = json.loads((folder / "flight.flight.json").read_text())
            self.assertEqual(truth["hidden"]["lead"], 0)
            self.assertAlmostEqual(truth["reynolds"], 75, delta=0.1)
            self.assertLess(np.abs(np.array(truth["on_the_wing"]["Fz"]) - first[:, 1]).max(), 0.2 * np.abs(first[:, 1]).max())
            make("--add", "--set", "name=turned", "--set", "balance.turn=90")
            with h5py.File(folder / "flight.h5") as file:
                np.testing.assert_allclose(file["flight/turned"].attrs["axes"], [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-15)
                spread = file["flight/hover/spread"][()] + file["flight/turned/spread"][()]
                self.assertLess(np.abs((file["flight/turned/mean"][()] - first[:, [1, 0, 2, 3]] * [1, -1, 1, 1]) / spread).max(), 5)
                self.assertNotIn("axes", file["flight/hover"].attrs)
            make("--add", "--set", "name=again", "--set", "state=sd", "--set", "stated.pitch_lead=0.004")
            self.assertIn("has a flight again", make("--add", "--set", "name=again", code=2))
            with h5py.File(folder / "flight.h5") as file:
                np.testing.assert_array_equal(file["flight/again/mean"][()], first)
                self.assertEqual(set(file["flight/again"]), {"time", "mean", "sd"})
                self.assertEqual(file["flight/again"].attrs["pitch_lead_sd"], 0.004)
                self.assertFalse([key for key in file["flight/hover"].attrs if key.endswith("_sd")], "no error is stated")
            if READER:  # that of what fits measurements
                done = subprocess.run([READER, SOURCE / "wings/calliphora_small.h5", folder / "flight.h5"], capture_output=True, text=True)
                self.assertIn("flight.h5 is accepted", done.stdout)
            self.assertIn("did you mean lead", make("--set", "hidden.led=3", code=2))

    def test_refused(self):
        for change, words in (({"components": "Fy, Fx"}, "none of"), ({"state": "var"}, "spread or sd"), ({"beats": 1}, "beats"),
                              ({"components": "Fy, Fy"}, "twice"), ({"hidden": Hidden(viscosity=0.0)}, "positive"),
                              ({"hidden": Hidden(wind=(1.0,))}, "2 numbers"), ({"stated": Stated(pitch_lead=-0.1)}, "not negative"),
                              ({"hidden": Hidden(hinge=0.6)}, "hinge"), ({"cameras": Cameras(points=(0.7,))}, "-0.5 to 0.5 chords"),
                              ({"cameras": Cameras(points=(0.1,), sd=0.0)}, "an sd above 0"),
                              ({"cameras": Cameras(origin=(0.0, 0.0))}, "3 numbers")):
            with self.assertRaisesRegex(InputError, words):
                check(replace(Case(), **change))
        with self.assertRaisesRegex(InputError, "smaller steps"):
            synthesise(replace(Case(), flow=replace(COARSE, steps=150)))

    def test_landmarks(self):
        """Cameras show points of the chord from their origin; a chord that is longer about a hinge farther back takes them along. Axes
        that are turned by 90 degrees from y toward z see z as y. Noise of 3e-6 m in 20 beats is found within 20 %."""
        exact = sines()
        angle = 0.3 + 0.2 * np.sin(2 * np.pi * F * exact["time"])
        exact["place"] = np.stack([1e-3 * np.cos(2 * np.pi * F * exact["time"]), 0 * angle + 2e-3, angle], 1)
        case = replace(Case(), flow=replace(COARSE, beats=6), hidden=Hidden(chord=1.1, hinge=0.1),
                       cameras=Cameras(points=(0.4, -0.3), sd=3e-6, origin=(0.0, 1e-4, 2e-4)))
        found = tracked(case, exact)
        self.assertTrue(np.isnan(found["mean"][:, ::3]).all())
        np.testing.assert_allclose(found["points"], [[3.2e-4, 0], [-2.4e-4, 0]])
        w = 2 * np.pi * found["time"]
        phi = 0.3 + 0.2 * np.sin(w)
        for k, along in enumerate((0.5, -0.2)):
            y, z = 1e-3 * np.cos(w) + 8.8e-4 * along * np.cos(phi) - 1e-4, 2e-3 + 8.8e-4 * along * np.sin(phi) - 2e-4
            error = np.abs(found["mean"][:, 3 * k + 1:3 * k + 3] - np.stack([y, z], 1)).max()
            self.assertLess(error, 5 * 3e-6 / np.sqrt(20) + 1e-8)
        self.assertAlmostEqual(np.sqrt((found["spread"][:, 1]**2).mean()) / 3e-6, 1, delta=0.2)
        turned = tracked(replace(case, cameras=replace(case.cameras, turn=90.0)), exact)
        np.testing.assert_allclose(turned["mean"][:, 1], found["mean"][:, 2], atol=1e-5)
        np.testing.assert_allclose(turned["mean"][:, 2], -found["mean"][:, 1], atol=1e-5)

    def test_example(self):
        self.assertEqual(read_case(SOURCE / "ini/flight-record.json").hidden.lead, 8.0)


if __name__ == "__main__":
    READER = str(Path(sys.argv.pop(1)).resolve()) if sys.argv[1:] and Path(sys.argv[1]).is_file() else ""
    unittest.main()
