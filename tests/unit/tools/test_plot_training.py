# SPDX-License-Identifier: GPL-3.0-or-later
"""plot_training.py: a page with all pictures of a finished training and of one that is under way; mistakes by name."""
import base64
import re
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

SOURCE = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(SOURCE / "tests" / "support"), str(SOURCE / "tools")]
from synthetic import picture, run_tool  # noqa: E402


def write_history(path, finished=True):
    """Five generations of two unknowns and, if finished, an outcome with one interval that has no upper end."""
    with h5py.File(path, "w") as file:
        file.attrs.update(schema="flusi-msm training history", unknowns="E joint:a", units="Pa, N m/rad", cost="h",
                          lower=[1e8, 1e-6], upper=[1e11, 1e-2])
        g = np.arange(1, 6)
        rows = np.column_stack([g * 0 + 1, g * 0, g, g * 0 + 6, 6 * g, 1e-3 / g, 1e-3 / g, 2e-3 / g, 0.3 / g, g, 0 * g,
                                0 * g, 1e10 + 0 * g, 1e-4 + 0 * g]).astype(float)
        rows[0, 5:8] = np.nan  # nothing was feasible yet
        file["generations"] = rows
        if not finished:
            return
        file.create_group("outcome").attrs.update(values=[8e9, 3e-5], h=1e-6, chi2=12.0, singular_values=[10.0, 1.0])
        file["outcome/intervals"] = [[7e9, 8e9, 9e9, 1, 1], [2e-5, 3e-5, 1e-2, 1, 0]]
        x, y = np.meshgrid(np.linspace(0, 9e-3, 9), np.linspace(-2e-3, 1e-3, 5))
        z = 1e-4 * (x / 9e-3) ** 2
        for name in ("one", "two"):
            file[f"loads/{name}"] = np.column_stack([a.ravel() for a in (x, y, z, z + 1e-6)])
            file[f"loads/{name}"].attrs.update(force=1e-4, point=[5e-3, 0.0])


class PlotTraining(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.history, self.report = self.folder / "train_history.h5", self.folder / "report.html"

    def pictures(self):
        text = self.report.read_text(encoding="utf-8")
        found = re.findall(r'src="data:image/png;base64,([^"]+)"', text)
        for i, data in enumerate(found):
            path = self.folder / f"{i}.png"
            path.write_bytes(base64.b64decode(data))
            height, width, colours = picture(path)
            self.assertGreater(min(height, width, colours), 20)
        self.assertNotIn("http", text)  # nothing is loaded from elsewhere
        return len(found), text

    def test_finished(self):
        write_history(self.history)
        done = run_tool("plot_training.py", self.history, "-o", self.report)
        self.assertEqual(done.returncode, 0, done.stderr)
        n, text = self.pictures()
        self.assertEqual(n, 4)  # search, parameters, two loads
        self.assertIn("Singular values", text)

    def test_under_way(self):
        write_history(self.history, finished=False)
        self.assertEqual(run_tool("plot_training.py", self.history, "-o", self.report).returncode, 0)
        n, text = self.pictures()
        self.assertEqual(n, 1)
        self.assertIn("not reached its end", text)

    def test_mistakes(self):
        done = run_tool("plot_training.py", self.folder / "none.h5")
        self.assertNotEqual(done.returncode, 0)
        with h5py.File(self.history, "w"):
            pass
        done = run_tool("plot_training.py", self.history)
        self.assertIn("is not the history of a training", f"{done.returncode}{done.stderr}")
        write_history(self.history)
        done = run_tool("plot_training.py", self.history, "-o", self.folder / "no" / "report.html")
        self.assertIn("cannot be written", f"{done.returncode}{done.stderr}")


if __name__ == "__main__":
    unittest.main()
