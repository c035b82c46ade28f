# SPDX-License-Identifier: GPL-3.0-or-later
"""Height maps that are imported arrive in SI units, and mistakes are named.

usage: test_import_heights.py READER     READER: the program test_measurements, which reads as the solver does
"""
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from synthetic import SOURCE, run_tool

READER = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else None
WING = SOURCE / "wings/calliphora_small.h5"
UNITS = ["--height-units", "um", "--axis-units", "mm", "--force-units", "mN", "--height-sd", "5"]
HEAD = "id,file,force,direction_x,direction_y,direction_z,point_x,point_y,order,time,hold,replicate\n"
TIP = "tip,tip.npz,0.3,0,0,2,7,-0.5,2,60,30,1\n"


class Import(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.x, self.y = np.linspace(0, 9, 10), np.linspace(1.5, -2.5, 9)  # y runs downward, as in pictures
        self.rest = 3.0 + 0 * self.y[:, None] * self.x
        self.rest[2, 1] = np.nan
        self.tip = self.rest + 2 * self.x**2 + self.y[:, None]
        self.write_csv("rest.csv", self.rest)
        np.savez(self.folder / "tip.npz", x=self.x[::-1], y=self.y, z=self.tip[:, ::-1])

    def write_csv(self, name, z):
        rows = [",".join([""] + [repr(float(v)) for v in self.x])]
        for y, row in zip(self.y, z):
            rows.append(",".join([repr(float(y))] + ["" if np.isnan(v) else repr(float(v)) for v in row]))
        (self.folder / name).write_text("\n".join(rows) + "\n")

    def run_import(self, rows, *more, options=UNITS):
        (self.folder / "list.csv").write_text(HEAD + rows)
        return run_tool("import_heights", self.folder / "list.csv", "-o", self.folder / "m.h5", *options, *more)

    def refused(self, text, rows, options=UNITS):
        run = self.run_import(rows, options=options)
        self.assertEqual(run.returncode, 2, run.stdout)
        self.assertIn(text, run.stderr)

    def test_arrives_in_si_units(self):
        run = self.run_import(TIP + "reference,rest.csv\n", "--force-gain-sd", "0.02", "--position-sd", "0.05")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("0.3 mN", run.stdout)
        with h5py.File(self.folder / "m.h5") as file:
            np.testing.assert_allclose(file["reference/x"], 1e-3 * self.x, rtol=1e-15)
            np.testing.assert_allclose(file["reference/y"], 1e-3 * self.y[::-1], rtol=1e-15)
            np.testing.assert_allclose(file["reference/z"], 1e-6 * self.rest[::-1], rtol=1e-15)
            np.testing.assert_allclose(file["loads/tip/z"], 1e-6 * self.tip[::-1], rtol=1e-15)
            facts = dict(file["loads/tip"].attrs)
            self.assertAlmostEqual(facts["force"], 3e-4, delta=1e-18)
            np.testing.assert_allclose(facts["point"], [7e-3, -0.5e-3], rtol=1e-15)
            self.assertEqual((facts["order"], facts["time"], facts["hold"], facts["replicate"]), (2, 60, 30, 1))
            self.assertAlmostEqual(file["accuracy"].attrs["height"], 5e-6, delta=1e-20)
            self.assertAlmostEqual(file["accuracy"].attrs["position"], 5e-5, delta=1e-18)
        if READER:
            run = subprocess.run([READER, str(WING), str(self.folder / "m.h5")], capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
            self.assertIn("89 heights", run.stdout)

    def test_states_what_is_known_of_its_errors(self):
        sigma = 4.0 + 0 * self.tip + 0.1 * self.x
        np.savez(self.folder / "tip.npz", x=self.x[::-1], y=self.y, z=self.tip[:, ::-1], sigma=sigma[:, ::-1])
        run = self.run_import(TIP + "reference,rest.csv\n", "--force-sd", "0.01", "--tilt-sd", "1e-3", "--piston-sd", "2",
                              "--correlation-length", "0.3", "--calibration", "force_by_weight=1", "--calibration",
                              "order_is_random=0")
        self.assertEqual(run.returncode, 0, run.stderr)
        with h5py.File(self.folder / "m.h5") as file:
            for name, value in (("force", 1e-5), ("tilt", 1e-3), ("piston", 2e-6), ("correlation_length", 3e-4)):
                self.assertAlmostEqual(file["accuracy"].attrs[name], value, delta=1e-15 * value)
            self.assertEqual(dict(file["calibration"].attrs), {"force_by_weight": 1, "order_is_random": 0})
            known = np.isfinite(self.tip)[::-1]
            np.testing.assert_allclose(file["loads/tip/sigma"][:][known], 1e-6 * sigma[::-1][known], rtol=1e-15)
            self.assertNotIn("sigma", file["reference"])
        if READER:
            run = subprocess.run([READER, str(WING), str(self.folder / "m.h5")], capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        rows = TIP + "reference,rest.csv\n"
        self.refused("--calibration order=1: write NAME=0 or NAME=1", rows, UNITS + ["--calibration", "order=1"])
        self.refused("--tilt-sd must not be negative", rows, UNITS + ["--tilt-sd=-1"])
        np.savez(self.folder / "tip.npz", x=self.x[::-1], y=self.y, z=self.tip[:, ::-1], sigma=0 * sigma)
        self.refused("tip.npz: sigma must have the shape of z, and be positive", rows)

    def test_names_mistakes(self):
        reference = "reference,rest.csv\n"
        self.refused("no line has the id reference", TIP)
        self.refused("lists no load", reference)
        self.refused("tip is listed twice", reference + TIP + TIP)
        self.refused("tip: force is 'much', not a number", reference + TIP.replace("0.3", "much"))
        self.refused("nothing.csv: cannot be read", reference + TIP.replace("tip.npz", "nothing.csv"))
        self.refused("a.dat: is in no known form; valid: .csv, .txt", reference + TIP.replace("tip.npz", "a.dat"))
        self.x = self.x + 0.01
        self.write_csv("shifted.csv", self.tip)
        self.refused("shifted.csv: x of its map differs from that of the reference",
                     reference + TIP.replace("tip.npz", "shifted.csv"))
        self.x[3] = self.x[1]
        self.write_csv("folded.csv", self.tip)
        self.refused("folded.csv: x neither increases nor decreases", reference + TIP.replace("tip.npz", "folded.csv"))

    def test_asks_for_every_unit(self):
        for unit in "--height-units", "--axis-units", "--force-units":
            k = UNITS.index(unit)
            self.refused(unit, TIP + "reference,rest.csv\n", UNITS[:k] + UNITS[k + 2:])

    @unittest.skipUnless(READER, "needs the reader")
    def test_example_of_the_documentation_is_read(self):
        text = (SOURCE / "docs/formats/measurement-format.md").read_text()
        code = re.search(r"## A measurement in Python\n\n```python\n(.*?)```", text, re.S)[1]
        subprocess.run([sys.executable, "-c", code], check=True, cwd=self.folder)
        run = subprocess.run([READER, str(WING), str(self.folder / "measurement.h5")], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
