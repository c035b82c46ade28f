# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces of many beats become a record of their mean and spread; what cannot be one is refused with what to do.

usage: test_import_forces.py [reader of measurement files]
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.seal import check_seal
from synthetic import SOURCE, run_tool

READER = str(Path(sys.argv.pop(1)).resolve()) if len(sys.argv) > 1 and Path(sys.argv[1]).is_file() else ""

F = 158.0
STEP = 1 / 158 / 96.3     # no whole number of samples in a beat
SD = 0.02                 # of one sample, beside forces of about 1
BASE = ("--time-units", "s", "--frequency", F, "--no-picture")


def truth(time):
    w = 2 * np.pi * F * time
    return {"Fy": np.cos(w) + 0.2 * np.sin(3 * w), "Fz": 0.4 - 0.5 * np.cos(2 * w)}


class Import(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.rng = np.random.default_rng(5)
        self.time = np.arange(0, 40.2 / F, STEP)

    def noisy(self, correlated=0.0):
        rows = {}
        for name, values in truth(self.time).items():
            noise = SD * self.rng.standard_normal(len(values))
            if correlated:
                keep = np.exp(-STEP / correlated)
                for n in range(1, len(noise)):
                    noise[n] = keep * noise[n - 1] + np.sqrt(1 - keep**2) * noise[n]
            rows[name] = values + noise
        return rows

    def write(self, columns, time=None, separator=","):
        columns = {"time": self.time if time is None else time, **columns}
        rows = [separator.join(columns)] + [separator.join("" if np.isnan(v) else f"{v:.9g}" for v in row) for row in zip(*columns.values())]
        text = "\n".join(rows) + "\n"
        (self.folder / "forces.csv").write_text(text.replace(".", ",") if separator == ";" else text)

    def run_import(self, *options, base=BASE, code=0):
        run = run_tool("import_forces", self.folder / "forces.csv", "-o", self.folder / "flight.h5", *map(str, base + options))
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        return run.stdout if code == 0 else run.stderr

    def record(self, name="flight"):
        if READER:  # that of what fits measurements
            done = subprocess.run([READER, SOURCE / "wings/calliphora_small.h5", self.folder / "flight.h5"], capture_output=True, text=True)
            self.assertIn("flight.h5 is accepted", done.stdout)
        with h5py.File(self.folder / "flight.h5") as file:
            group = file[f"flight/{name}"]
            return {**{k: v[()] for k, v in group.items()}, **dict(group.attrs)}

    def test_mean_and_spread(self):
        """The mean is the truth in mN to 5 sd, the spread the noise: of samples halfway between two it is smaller by up to sqrt 2."""
        self.write(self.noisy())
        self.run_import("--force-units", "mN")
        found = self.record()
        self.assertTrue(check_seal(self.folder / "flight.h5"))
        self.assertEqual((found["beats"], found["components"], found["units"], found["frame"]), (40, b"Fy, Fz", b"N, N", b"lab"))
        exact = np.stack(list(truth(found["time"] / F).values()), 1)
        self.assertLess(np.abs(1e3 * found["mean"] - exact).max(), 5 * SD / np.sqrt(40) + 1e-3)
        self.assertGreater(1e3 * np.sqrt((found["spread"]**2).mean()), SD / np.sqrt(2))
        self.assertLess(1e3 * np.sqrt((found["spread"]**2).mean()), SD)
        self.assertEqual(found["correlation_time"], 0)
        self.assertNotIn("per_length", {k for k, v in found.items() if k == "per_length" and v})

    def test_correlation_time(self):
        """Errors that are correlated over 0.3 ms, half of them lost by nothing: found within 20 %."""
        self.write(self.noisy(correlated=3e-4))
        self.run_import("--force-units", "N")
        self.assertAlmostEqual(self.record()["correlation_time"] / 3e-4, 1, delta=0.2)
        self.run_import("--force-units", "N", "--correlation-time", "1e-3")
        self.assertEqual(self.record()["correlation_time"], 1e-3)

    def test_columns_signs_start(self):
        """Other names, a sign, a beat that begins later, decimal commas, milliseconds, units per metre, torque about a place in mm."""
        noisy = self.noisy()
        self.write({"lift": noisy["Fz"], "drag": -noisy["Fy"], "mx": noisy["Fy"], "temperature": 0 * self.time}, 1e3 * self.time, ";")
        out = self.run_import("--force-units", "uN/m", "--torque-units", "mNm/m", "--column", "lift=Fz", "--column", "drag=-Fy", "--ignore",
                              "temperature", "--start", 250 / F, "--skip", 3, "--reference", 0, 1, 2, "--length-units", "mm",
                              base=("--time-units", "ms", "--frequency", F, "--samples", 40))
        self.assertIn("decimal comma", out)
        self.assertTrue((self.folder / "flight.png").exists())
        found = self.record()
        self.assertEqual((found["units"], found["per_length"], found["beats"]), (b"N/m, N/m, N", 1, 36))
        np.testing.assert_allclose(found["reference"], [0, 1e-3, 2e-3])
        exact = truth((found["time"] + 0.25) / F)
        scale = np.array([1e6, 1e6, 1e3])
        exact = np.stack([exact["Fy"], exact["Fz"], exact["Fy"]], 1)
        self.assertLess(np.abs(scale * found["mean"] - exact).max(), 5 * SD / np.sqrt(36) + 1e-3)

    def test_missing(self):
        """Lost samples: the sd of a phase is that of the beats in which it is known; what is never known is no number."""
        noisy = self.noisy()
        for name in noisy:
            noisy[name][(self.time * F > 5.05) & (self.time * F < 9.6)] = np.nan
        noisy["Fz"][(self.time * F) % 1 > 0.7] = np.nan
        self.write(noisy)
        self.run_import("--force-units", "N")
        found = self.record()
        self.assertNotIn("spread", found)
        known = np.isfinite(found["mean"])
        self.assertTrue(known[:, 0].all())
        self.assertFalse(known[40:48, 1].any())
        self.assertTrue((found["sd"] > 0).all())
        self.assertAlmostEqual(np.sqrt((found["sd"][:, 0]**2).mean()) * np.sqrt(35.5), 0.82 * SD, delta=0.15 * SD)

    def test_two_records(self):
        self.write(self.noisy())
        self.run_import("--force-units", "N", "--name", "first")
        self.run_import("--force-units", "N", "--name", "second", "--add")
        np.testing.assert_array_equal(self.record("first")["mean"], self.record("second")["mean"])
        self.assertIn("has a flight second", self.run_import("--force-units", "N", "--name", "second", "--add", code=2))

    def test_axes(self):
        """Axes are stored as given, or from the angles of the case: a body that looks along -x with its left to -y, and then its
        stroke plane, whose x is that body's z after -90 degrees about y."""
        self.write(self.noisy())
        self.run_import("--force-units", "mN")
        self.assertNotIn("axes", self.record())
        any_axes = np.array([[0.0, 0.0, 1.0], [0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]])
        text = self.run_import("--force-units", "mN", "--axes", *any_axes.ravel())
        self.assertIn("y      of the balance is along   0.60000   0.80000   0.00000 of the case", text)
        np.testing.assert_array_equal(self.record()["axes"], any_axes)
        self.run_import("--force-units", "mN", "--yaw-pitch-roll", 180, 0, 0)
        np.testing.assert_allclose(self.record()["axes"], np.diag([-1, -1, 1]), atol=1e-15)
        self.run_import("--force-units", "mN", "--yaw-pitch-roll", 180, 0, 0, "--stroke-plane", -90)
        np.testing.assert_allclose(self.record()["axes"], [[0, 0, 1], [0, -1, 0], [1, 0, 0]], atol=1e-15)
        self.run_import("--force-units", "mN", "--yaw-pitch-roll", 0, 0, 90)  # roll: y of the body is z of the case
        np.testing.assert_allclose(self.record()["axes"], [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-15)
        self.run_import("--force-units", "mN/m", "--yaw-pitch-roll", 0, 0, 30)
        self.assertAlmostEqual(self.record()["axes"][1, 2], 0.5)

    def test_refused_axes(self):
        self.write(self.noisy())
        for words, *options in (("no unit vectors at right angles, by 0.0002", "--axes", 1.0001, 0, 0, 0, 1, 0, 0, 0, 1),
                                ("no unit vectors at right angles", "--axes", "nan", 0, 0, 0, 1, 0, 0, 0, 1),
                                ("left-handed", "--axes", 1, 0, 0, 0, 1, 0, 0, 0, -1),
                                ("give either the axes, or", "--axes", 1, 0, 0, 0, 1, 0, 0, 0, 1, "--stroke-plane", 0)):
            self.assertIn(words, self.run_import("--force-units", "mN", *options, code=2))
        self.assertIn("a section per metre of span can be turned about x alone",
                      self.run_import("--force-units", "mN/m", "--yaw-pitch-roll", 180, 0, 0, code=2))

    def test_refused_units(self):
        """No unit has a default, and per metre is all or nothing."""
        self.write({**self.noisy(), "Mx": truth(self.time)["Fy"]})
        said = self.run_import(code=2)
        for words in "--force-units: required", "--torque-units: required", "--reference: required":
            self.assertIn(words, said)
        said = self.run_import("--force-units", "N/m", "--torque-units", "Nm", "--reference", 0, 0, 0, code=2)
        self.assertIn("all are per metre", said)
        self.assertIn("--length-units", said)
        self.assertIn("--time-units", self.run_import("--force-units", "N", base=("--frequency", "158"), code=2))

    def test_refused_columns(self):
        self.write({"Fyy": self.time, "Fz": truth(self.time)["Fz"]})
        self.assertIn("did you mean Fy?", self.run_import("--force-units", "N", code=2))
        self.assertIn("no column lift", self.run_import("--force-units", "N", "--column", "lift=Fz", code=2))
        self.assertIn("two columns", self.run_import("--force-units", "N", "--column", "fyy=Fz", code=2))
        self.assertIn("one of Fx", self.run_import("--force-units", "N", "--column", "fyy=lift", code=2))
        (self.folder / "forces.csv").write_text("t,Fy\n0,1\n1,2\n")
        self.assertIn("no column time", self.run_import("--force-units", "N", code=2))

    def test_refused_twice(self):
        """Two columns of the same name, of which nobody knows which one is right."""
        rows = self.noisy()
        self.write({**rows, "FZ": rows["Fy"]})
        self.assertIn("forces.csv:1: the column fz is there 2 times", self.run_import("--force-units", "N", code=2))

    def test_refused_beats(self):
        """Wrong units of time, a wrong frequency, one that is off by a thousandth, forces that are not those of a beat, times that
        run back, too many phases, no noise."""
        self.write(self.noisy())
        self.assertIn("needs at least 2 beats", self.run_import("--force-units", "N", base=(
            "--time-units", "us", "--frequency", F, "--no-picture"), code=2))
        said = self.run_import("--force-units", "N", base=("--time-units", "s", "--frequency", 131.0, "--no-picture"), code=2)
        self.assertIn("do not repeat", said)
        self.assertAlmostEqual(float(said.split(" at ")[-1].split()[0]) / F, 1, delta=0.03)
        said = self.run_import("--force-units", "N", base=("--time-units", "s", "--frequency", F * 1.003, "--no-picture"), code=2)
        self.assertIn("drift", said)
        self.assertAlmostEqual(float(said.split(" is ")[-1].split()[0]) / F, 1, delta=2e-4)
        self.assertIn("at most as many phases", self.run_import("--force-units", "N", "--samples", 97, code=2))
        self.assertIn("complete beats", self.run_import("--force-units", "N", "--skip", 39, code=2))
        self.write({name: SD * self.rng.standard_normal(len(self.time)) for name in ("Fy", "Fz")})
        self.assertIn("do not repeat", self.run_import("--force-units", "N", code=2))
        back = self.time.copy()
        back[50] = back[48]
        self.write(self.noisy(), back)
        self.assertIn("near line 52", self.run_import("--force-units", "N", code=2))
        even = np.arange(0, 10, 1 / 100) / F
        self.write(truth(even), even)
        self.assertIn("all beats are the same", self.run_import("--force-units", "N", code=2))


if __name__ == "__main__":
    unittest.main()
