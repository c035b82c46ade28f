# SPDX-License-Identifier: GPL-3.0-or-later
"""compare_runs: the table of two runs whose means are known."""
import csv
import tempfile
import unittest
from pathlib import Path

from synthetic import CYCLE_MEANS, picture, run_tool, write_flapping_run


class Comparison(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        write_flapping_run(self.folder / "rigid")
        write_flapping_run(self.folder / "flexible", drift=0.5)

    def test_table(self):
        done = run_tool("compare_runs", self.folder / "rigid", self.folder / "flexible", "--cycles", "3-4",
                        "-o", self.folder / "both")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.folder / "both.csv", encoding="utf-8") as file:
            rows = {row["quantity"]: row for row in csv.DictReader(file)}
        lift, drag, power = (CYCLE_MEANS[q] for q in ("lift", "drag", "aerodynamic power"))
        # The ramp of the other run adds 0.5 n to the mean lift of cycle n and nothing to the rest.
        for name, rigid, flexible in (("mean lift", lift, lift + 1.75), ("mean drag", drag, drag),
                                      ("lift / drag", lift / drag, (lift + 1.75) / drag),
                                      ("lift / power", lift / power, (lift + 1.75) / power)):
            self.assertAlmostEqual(float(rows[name]["rigid"]), rigid, delta=1e-5 * abs(rigid))
            self.assertAlmostEqual(float(rows[name]["flexible"]), flexible, delta=1e-5 * abs(flexible))
            self.assertAlmostEqual(float(rows[name]["change"]), flexible / rigid - 1, delta=2e-5)
        self.assertAlmostEqual(float(rows["mean lift"]["spread flexible"]), 0.25, delta=1e-3)
        self.assertIn("lift / drag", done.stdout)
        self.assertIn((self.folder / "both.txt").read_text(encoding="utf-8"), done.stdout)
        self.assertGreater(picture(self.folder / "both.png")[2], 10)

    def test_mistakes(self):
        (self.folder / "empty").mkdir()
        done = run_tool("compare_runs", self.folder / "rigid", self.folder / "empty")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("forces.t", done.stderr)
        done = run_tool("compare_runs", self.folder / "rigid", self.folder / "flexible", "--labels", "one")
        self.assertIn("two names", done.stderr)


if __name__ == "__main__":
    unittest.main()
