# SPDX-License-Identifier: GPL-3.0-or-later
"""Tracked points of many beats become a record of landmarks; what cannot be one is refused with what to do.

usage: test_import_landmarks.py [reader of measurement files]
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.measurement.flight_file import write_landmarks, write_record
from flusi_msm.seal import check_seal
from synthetic import SOURCE, run_tool

READER = str(Path(sys.argv.pop(1)).resolve()) if len(sys.argv) > 1 and Path(sys.argv[1]).is_file() else ""

F = 50.0
SD = 0.03                 # mm
POINTS = "name,wing,x,y\ntip,left,8.0,-0.5\nmid,left,4.0,0.2\nother,right,8.0,-0.5\n"
BASE = ("--time-units", "ms", "--length-units", "mm", "--frequency", F, "--origin", 0, 15, 20)


def truth(time):
    """Places [mm] of the columns that were seen; nobody looks along x."""
    w = 2 * np.pi * F * time
    return {"tip_y": 8 * np.cos(w), "tip_z": 3 * np.sin(w), "mid_y": 4 * np.cos(w), "mid_z": 1.5 * np.sin(w),
            "other_y": -8 * np.cos(w), "other_z": 3 * np.sin(w)}


class Import(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.rng = np.random.default_rng(7)
        self.time = np.arange(0, 12.3 / F, 1 / F / 80.3)

    def noisy(self, time=None):
        places = truth(self.time if time is None else time)
        return {name: values + SD * self.rng.standard_normal(len(values)) for name, values in places.items()}

    def write(self, columns=None, time=None, points=POINTS):
        time = self.time if time is None else time
        if columns is None:
            columns = self.noisy(time)
        columns = {"time": 1e3 * time, **columns}
        rows = [",".join(columns)] + [",".join("" if np.isnan(v) else f"{v:.9g}" for v in row) for row in zip(*columns.values())]
        (self.folder / "tracks.csv").write_text("\n".join(rows) + "\n")
        (self.folder / "points.csv").write_text(points)

    def run_import(self, *options, code=0):
        run = run_tool("import_landmarks", self.folder / "tracks.csv", self.folder / "points.csv", "-o", self.folder / "flight.h5",
                       *map(str, BASE + options))
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        return run.stdout if code == 0 else run.stderr

    def record(self):
        if READER:  # that of what fits measurements
            done = subprocess.run([READER, SOURCE / "wings/calliphora_small.h5", self.folder / "flight.h5"], capture_output=True, text=True)
            self.assertIn("flight.h5 is accepted", done.stdout + done.stderr)
        self.assertTrue(check_seal(self.folder / "flight.h5"))
        with h5py.File(self.folder / "flight.h5") as file:
            group = file["flight/flight/landmarks"]
            return dict(group.attrs), {side: {k: v[()] for k, v in wing.items()} for side, wing in group.items()}

    def test_mean_and_sd(self):
        """The mean is the truth in metres to 5 sd, x is unknown, and the sd is that of 12 beats, less by up to sqrt 2 between samples."""
        self.write()
        text = self.run_import("--offset-sd", 0.1, "--turn-sd", 2)
        self.assertIn("tip      left  wing, 80 of 120 coordinates known", text)
        facts, wings = self.record()
        self.assertEqual((facts["beats"], facts["turn_sd"]), (12, 2.0))
        np.testing.assert_allclose(facts["origin"], [0, 0.015, 0.02])
        self.assertAlmostEqual(facts["offset_sd"], 1e-4)
        left = wings["left"]
        np.testing.assert_allclose(left["points"], [[8e-3, -5e-4], [4e-3, 2e-4]])
        self.assertTrue(np.isnan(left["mean"][:, [0, 3]]).all())
        exact = 1e-3 * np.stack([values for name, values in truth(left["time"] / F).items() if "other" not in name], 1)
        self.assertLess(np.abs(left["mean"][:, [1, 2, 4, 5]] - exact).max(), 1e-3 * (5 * SD / np.sqrt(12) + 8 * (np.pi / 80)**2))
        sd = np.sqrt((left["sd"][:, [1, 2, 4, 5]]**2).mean())
        self.assertTrue(0.9 * SD / np.sqrt(24) < 1e3 * sd < 1.1 * SD / np.sqrt(12), sd)
        self.assertEqual(wings["right"]["mean"].shape, (40, 3))

    def test_axes(self):
        """The axes of the cameras are those of the landmarks, and not those of the balance."""
        write_record(self.folder / "flight.h5", "flight", {"frequency": F, "beats": 20, "reference": np.zeros(3), "components": "Fz",
                                                           "units": "N", "axes": np.diag([-1.0, -1.0, 1.0])},
                     {"time": np.arange(8) / 8, "mean": np.ones((8, 1)), "sd": np.ones((8, 1))})
        self.write()
        self.run_import("--add", "--yaw-pitch-roll", 90, 0, 0)
        np.testing.assert_allclose(self.record()[0]["axes"], [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-15)
        with h5py.File(self.folder / "flight.h5") as file:
            np.testing.assert_array_equal(file["flight/flight"].attrs["axes"], np.diag([-1.0, -1.0, 1.0]))

    def test_unseen(self):
        """A coordinate that is lost for a third of each beat is unknown there."""
        columns = truth(self.time)
        columns["tip_y"] = np.where((self.time * F) % 1 > 0.66, np.nan, columns["tip_y"] + SD * self.rng.standard_normal(len(self.time)))
        self.write(columns | {"mid_y": columns["mid_y"] + SD * self.rng.standard_normal(len(self.time))})
        self.run_import()
        _, wings = self.record()
        known = np.isfinite(wings["left"]["mean"][:, 1])
        phase = wings["left"]["time"]
        self.assertTrue(known[(phase > 0.05) & (phase < 0.6)].all() and not known[phase > 0.75].any())

    def test_one_beat(self):
        time = self.time[self.time < 1.02 / F]
        self.write(time=time)
        self.assertIn("needs at least 2, or 1 with --sd", self.run_import(code=2))
        self.run_import("--sd", SD)
        facts, wings = self.record()
        self.assertEqual(facts["beats"], 1)
        np.testing.assert_allclose(wings["right"]["sd"][:, 1], 1e-3 * SD)

    def test_beside_forces(self):
        """The landmarks join a record of forces of the same flight; another frequency is refused."""
        self.write()
        force = {"time": np.arange(8) / 8, "mean": np.ones((8, 1)), "sd": np.ones((8, 1))}
        attributes = {"beats": 3, "reference": np.zeros(3), "components": "Fz", "units": "N"}
        write_record(self.folder / "flight.h5", "flight", {"frequency": F, **attributes}, force)
        self.run_import("--add")
        self.assertEqual(sorted(self.record()[1]), ["left", "right"])
        self.assertIn("has landmarks already", self.run_import("--add", code=2))
        (self.folder / "flight.h5").unlink()
        write_record(self.folder / "flight.h5", "flight", {"frequency": F + 1, **attributes}, force)
        self.assertIn("has the frequency 51 Hz, not 50 Hz", self.run_import("--add", code=2))
        (self.folder / "flight.h5").unlink()
        write_record(self.folder / "flight.h5", "flight", {"frequency": F, **attributes}, force)
        self.assertIn("has per_length = 0, the landmarks have 1", self.run_import("--add", "--per-length", code=2))
        (self.folder / "flight.h5").unlink()
        write_record(self.folder / "flight.h5", "flight", {"frequency": F, **attributes, "units": "N/m", "per_length": 1}, force)
        self.assertIn("has per_length = 1, the landmarks have 0", self.run_import("--add", code=2))
        self.run_import("--add", "--per-length")
        self.assertEqual(len(self.record()[1]), 2)

    def test_refused_leaves_file(self):
        """A refused import leaves the file as it was, to the byte, and nothing beside it; so does one that makes the file new."""
        self.write()
        self.run_import()
        before, names = (self.folder / "flight.h5").read_bytes(), sorted(self.folder.iterdir())
        for options in (("--add",), ("--skip", 12), ("--name", "a/b")):
            self.run_import(*options, code=2)
            self.assertEqual((self.folder / "flight.h5").read_bytes(), before)
            self.assertEqual(sorted(self.folder.iterdir()), names)
        with self.assertRaisesRegex(InputError, "cannot be written"):  # in the middle: the second wing has no numbers
            data = {"time": [0.0], "mean": [[0.0] * 3], "sd": [[1.0] * 3]}
            write_landmarks(self.folder / "flight.h5", "flight", {"frequency": F}, {"origin": np.zeros(3)},
                            {"left": data, "right": {"mean": "none"}}, is_new=True)
        self.assertEqual((self.folder / "flight.h5").read_bytes(), before)
        self.assertEqual(sorted(self.folder.iterdir()), names)

    def test_limits(self):
        """All options that are out of range are listed at once, with what is valid, beside the mistakes of both tables."""
        columns = self.noisy()
        self.write({**columns, "tip_Y ": columns["mid_y"]}, points=POINTS.replace("name,wing", "wing,name"))
        text = self.run_import("--turn-sd", 21, "--offset-sd", 10001, "--name", "", "--frequency", "inf", "--origin", "nan", 0, 0,
                               "--start", "nan", "--correlation-time", "inf", code=2)
        for words in ("--turn-sd: is out of range; valid: above 0, at most 20 degrees", "--offset-sd: is out of range; valid: above 0, at most "
                      "10000 mm", "--name: is", "--frequency: is", "--origin: is", "--start: is", "--correlation-time: is",
                      "points.csv: the first line must be name,wing,x,y", "tracks.csv:1: the column tip_y is there 2 times"):
            self.assertIn(words, text)
        self.assertEqual(len(text.splitlines()), 9, text)
        self.write()
        self.run_import("--turn-sd", 20, "--offset-sd", 10000)
        self.record()

    def test_seen_once(self):
        """A coordinate that one beat alone sees has no spread: its error is --sd."""
        columns = self.noisy()
        columns["tip_z"] = np.where(self.time * F < 0.9, columns["tip_z"], np.nan)
        for name in ("mid_y", "mid_z"):
            columns[name] = np.full(len(self.time), np.nan)
        self.write(columns)
        text = self.run_import()
        self.assertRegex(text, "tip .* 40 of 120 coordinates known, .*; z seen in one beat only: give --sd\n")
        self.assertRegex(text, "mid .* 0 of 120 coordinates known, never seen\n")
        self.assertNotIn("give --sd", self.run_import("--sd", SD))
        left = self.record()[1]["left"]
        known = np.isfinite(left["mean"][:, 2])
        self.assertTrue(known[left["time"] < 0.85].all())
        np.testing.assert_allclose(left["sd"][known, 2], 1e-3 * SD)

    def test_refused(self):
        self.write(points=POINTS.replace("left,4", "lefft,4").replace("other,right", "tip,right"))
        text = self.run_import(code=2)
        self.assertIn("points.csv:3: the wing is 'lefft'; valid: left, right", text)
        self.assertIn("points.csv:4: the name 'tip' is empty or there twice", text)
        self.write(points=POINTS.replace("name,wing", "wing,name"))
        self.assertIn("the first line must be name,wing,x,y", self.run_import(code=2))
        self.write(points=POINTS + "root,left,0,0\n")
        self.assertIn("has no column of the point root", self.run_import(code=2))
        columns = truth(self.time)
        self.write({**columns, "tpi_x": columns["tip_y"]})
        self.assertIn("column tpi_x: belongs to no point", self.run_import(code=2))
        time = np.arange(0, 12 * 80) / F / 80
        self.write(truth(time), time)
        self.assertIn("all beats are the same", self.run_import(code=2))
        self.write(time=self.time[::16])
        self.assertIn("needs at least 8", self.run_import(code=2))
        self.write(time=self.time * 1.03)
        self.assertIn("the points drift by", self.run_import("--frequency", 50 * 1.015, code=2))


if __name__ == "__main__":
    unittest.main()
