# SPDX-License-Identifier: GPL-3.0-or-later
"""compare_individuals: the spread of runs whose means are known."""
import csv
import tempfile
import unittest
from pathlib import Path

from synthetic import CYCLE_MEANS, picture, run_tool, write_flapping_run


class Individuals(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        for n, factor in enumerate((1.0, 1.1, 0.95)):
            write_flapping_run(self.folder / f"fly{n}", factor=factor, drift=0.1 * n)

    def compare(self, *arguments):
        return run_tool("compare_individuals", *(self.folder / f"fly{n}" for n in range(3)), "-o",
                        self.folder / "all", *arguments)

    def test_table(self):
        done = self.compare()
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.folder / "all.csv", encoding="utf-8") as file:
            rows = {row["individual"]: row for row in csv.DictReader(file)}
        lift, drag, power = (CYCLE_MEANS[q] for q in ("lift", "drag", "aerodynamic power"))
        # The ramp of a run adds its drift times 3.5 to the mean lift of cycles 3 and 4.
        lifts = [lift, 1.1 * lift + 0.35, 0.95 * lift + 0.7]
        for n, factor in enumerate((1.0, 1.1, 0.95)):
            self.assertAlmostEqual(float(rows[f"fly{n}"]["lift"]), lifts[n], delta=1e-3)
            self.assertAlmostEqual(float(rows[f"fly{n}"]["lift / drag"]), lifts[n] / (factor * drag), delta=2e-3)
        self.assertAlmostEqual(float(rows["spread %"]["lift"]), 100 * (lifts[1] - lifts[0]) / lifts[2], delta=0.05)
        for quantity in ("drag", "aerodynamic power"):
            self.assertAlmostEqual(float(rows["spread %"][quantity]), 15.0, delta=0.05)
        self.assertAlmostEqual(float(rows["median"]["aerodynamic power"]), power, delta=1e-3)
        self.assertEqual(rows["paper, spread %"]["drag"], "45.16")
        self.assertIn((self.folder / "all.txt").read_text(encoding="utf-8"), done.stdout)
        self.assertIn("cycles 3-4", done.stdout)
        self.assertGreater(picture(self.folder / "all.png")[2], 10)

    def test_choice_of_cycles(self):
        done = self.compare("--cycles", "1", "--labels", "a,b,c")
        self.assertIn("cycle 1", done.stdout)
        with open(self.folder / "all.csv", encoding="utf-8") as file:
            rows = {row["individual"]: row for row in csv.DictReader(file)}
        self.assertAlmostEqual(float(rows["b"]["lift"]), 1.1 * CYCLE_MEANS["lift"] + 0.1, delta=2e-3)

    def test_mistakes(self):
        self.assertIn("two runs or more", run_tool("compare_individuals", self.folder / "fly0").stderr)
        self.assertIn("2 names for 3 runs", self.compare("--labels", "a,b").stderr)
        (self.folder / "fly1/aero_power.t").unlink()
        self.assertIn("fly1: aerodynamic power is not", self.compare().stderr)


if __name__ == "__main__":
    unittest.main()
