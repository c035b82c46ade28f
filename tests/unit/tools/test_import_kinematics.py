# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured angles become the motion that they are samples of, whatever their convention.

usage: test_import_kinematics.py FLUSI
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

from flusi_msm.importers.angles import ORDERS, flusi_angles, matrices
from flusi_msm.plots.kinematics import ANGLES, read_motion
from synthetic import SOURCE, run_tool

FLUSI = str(Path(sys.argv.pop(1)).resolve()) if len(sys.argv) > 1 and Path(sys.argv[1]).is_file() else None
NOISE = 1.5   # degrees
N = 600


def truth(x):
    """Angles [degrees] in FLUSI's convention, of at most three harmonics."""
    w = 2 * np.pi * x
    return {"phi": 5 + 65 * np.cos(w) + 3 * np.sin(2 * w), "alpha": -10 + 50 * np.sin(w) + 8 * np.sin(3 * w) - 4 * np.cos(2 * w),
            "theta": 3 + 6 * np.cos(2 * w) - 2 * np.sin(w)}


class Import(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.rng = np.random.default_rng(3)

    def write(self, columns, decimals=6):
        rows = [",".join(columns)] + [",".join("" if np.isnan(v) else f"{v:.{decimals}f}" for v in row) for row in zip(*columns.values())]
        (self.folder / "angles.csv").write_text("\n".join(rows) + "\n")

    def run_import(self, *options, code=0):
        run = run_tool("import_kinematics", self.folder / "angles.csv", "-o", self.folder / "beat.ini", *options)
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        return run.stdout if code == 0 else run.stderr

    def check(self, name="beat.ini", noise=NOISE, expected=truth, n=N, unknowns=9):
        """A least squares fit errs by sigma sqrt(unknowns / n) (rms over the beat); five of it anywhere is next to impossible."""
        x = np.linspace(0, 1, 301)
        found, known = read_motion(self.folder / name)(x), expected(x)
        for angle in ANGLES:
            worst = np.abs(found[angle] - known[angle]).max()
            self.assertLess(worst, 5 * noise * np.sqrt(unknowns / n) + 1e-4, f"{name} {angle}")

    def noisy(self, x, noise=NOISE):
        return {name: values + noise * self.rng.standard_normal(len(x)) for name, values in truth(x).items()}

    def test_fourier_of_many_beats(self):
        """Samples of ten beats in seconds; the residual that is told is the noise."""
        time = np.linspace(0, 10 / 158, N)
        self.write({"time": time, **self.noisy(time * 158 % 1)}, 9)
        told = self.run_import("--angles", "degrees", "--frequency", "158")
        self.check()
        for name in ANGLES:
            residual = float(told.split(name + " ")[1].split("residual ")[1].split()[0])
            self.assertLess(abs(residual / NOISE - 1), 4 / np.sqrt(2 * N), told)
        self.assertIn("phi 2 harmonics", told)
        self.assertIn("alpha 3 harmonics", told)
        self.assertNotIn("notice", told)
        self.assertGreater((self.folder / "beat.png").stat().st_size, 30000)

    def test_hermite(self):
        """20 cubic pieces err by h^4/384 of the fourth derivative, 0.03 degrees here, beside the noise of 40 unknowns."""
        x = np.sort(self.rng.uniform(0, 1, N))
        self.write({"phase": x, **self.noisy(x, 0.3)})
        self.run_import("--angles", "degrees", "--type", "hermite", "--no-picture")
        fourth = (2 * np.pi)**4 * (50 + 8 * 81 + 4 * 16)
        self.check(noise=0.3 + fourth / 384 / 20**4, unknowns=40)

    def test_two_wings_in_radians_of_another_convention(self):
        """Stroke, deviation and rotation of both wings, recorded in turn; the right one beats 10 degrees further."""
        x = np.linspace(0, 1, N, endpoint=False)
        angles = {name: np.radians(values) for name, values in self.noisy(x).items()}
        is_left = np.arange(N) % 2 == 0
        columns = {"phase": x}
        for side, mark, more in (("left", is_left, 0.0), ("right", ~is_left, np.radians(10))):
            columns[f"stroke_{side}"] = np.where(mark, -(angles["phi"] + more), np.nan)
            columns[f"deviation_{side}"] = np.where(mark, -angles["theta"], np.nan)
            columns[f"rotation_{side}"] = np.where(mark, np.pi / 2 - angles["alpha"], np.nan)
        self.write(columns, 9)
        self.run_import("--angles", "radians", "--convention", "stroke-ventral")
        self.check("beat_left.ini", n=N / 2)
        self.check("beat_right.ini", n=N / 2, expected=lambda x: {**truth(x), "phi": truth(x)["phi"] + 10})

    def test_order_of_turns(self):
        """Angles of any order describe the same wing: tip and chord are those of the matrices."""
        x = np.linspace(0, 1, 50, endpoint=False)
        angles = truth(x)
        for order in ORDERS.values():
            m = matrices(angles, order)
            found = flusi_angles(m)
            np.testing.assert_allclose(matrices(found, ORDERS["phi-theta-alpha"]), m, atol=1e-12)
        for name in ANGLES:
            np.testing.assert_allclose(flusi_angles(matrices(angles, ORDERS["phi-theta-alpha"]))[name], angles[name], atol=1e-10)
        m = matrices(angles, ORDERS["phi-alpha-theta"])
        found = flusi_angles(m)
        self.assertGreater(np.abs(found["alpha"] - angles["alpha"]).max(), 0.1)
        self.write({"phase": x, **angles})
        self.run_import("--angles", "degrees", "--order", "phi-alpha-theta", "--no-picture", "--harmonics", "10")
        motion = read_motion(self.folder / "beat.ini")(x)
        # Of the eleventh harmonic on nothing is left that counts.
        self.assertLess(np.abs(matrices(motion, ORDERS["phi-theta-alpha"]) - m).max(), 2e-3)

    def test_doubts(self):
        x = np.linspace(0, 1, 100, endpoint=False)
        angles = truth(x)
        self.write({"phase": x, **angles})
        self.assertIn("the angles are degrees, not radians", self.run_import("--angles", "radians", code=2))
        self.assertIn("the trailing edge goes first", self.run_import("--angles", "degrees", "--negate", "alpha", "--no-picture"))
        self.write({"phase": x, **{name: np.radians(v) for name, v in angles.items()}})
        self.assertIn("are the angles radians?", self.run_import("--angles", "degrees", code=2))
        self.write({"phase": x, **{**angles, "alpha": 90 - angles["alpha"]}})
        self.assertIn("as if counted from the stroke plane", self.run_import("--angles", "degrees", "--no-picture"))
        self.write({"time": 1e3 * x / 158, **angles})
        self.assertIn("--frequency is missing", self.run_import("--angles", "degrees", code=2))
        self.write({"time": 1e6 * x / 158, **angles})
        self.assertIn("is time in seconds?", self.run_import("--angles", "degrees", "--frequency", "158", code=2))
        self.write({"phase": x[:60], **{name: v[:60] for name, v in angles.items()}})
        self.assertIn("leave 41% of the beat without any", self.run_import("--angles", "degrees", code=2))
        (self.folder / "angles.csv").write_text("phase;phi;alpha;yaw\n0,1;1;much;2\n0,2;2;3;3\n")
        told = self.run_import("--angles", "degrees", code=2)
        for words in ("unknown column yaw", "no column theta", "angles.csv:2: alpha is 'much'"):
            self.assertIn(words, told)

    @unittest.skipUnless(FLUSI, "needs flusi")
    def test_flusi_reads_it(self):
        x = np.linspace(0, 1, 60, endpoint=False)
        for kind in "fourier", "hermite":
            self.write({"phase": x, **truth(x)})
            self.run_import("--angles", "degrees", "--type", kind, "--no-picture")
            text = (SOURCE / "ini/wing-rigid.ini").read_text().replace("from_file::kinematics/calliphora.ini", f"from_file::{self.folder}/beat.ini")
            self.assertIn(f"{self.folder}/beat.ini", text)
            (self.folder / "fly.ini").write_text(text.replace("../wings/", f"{SOURCE}/wings/"))
            run = subprocess.run([FLUSI, "fly.ini", "--dry-run"], cwd=self.folder, capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
