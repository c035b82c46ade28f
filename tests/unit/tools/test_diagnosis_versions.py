# SPDX-License-Identifier: GPL-3.0-or-later
"""The tools read diagnosis.json of both versions: stored files of version 1 become what the schema of version 2 asks for."""
import json
import shutil
import tempfile
import unittest
from pathlib import Path

from flusi_msm.blind.verdict import flat_verdict
from flusi_msm.diagnosis.report import page
from flusi_msm.diagnosis.versions import entry_of, upgraded
from flusi_msm.errors import InputError
from flusi_msm.tables import read_diagnosis
from synthetic import run_tool

SOURCE = Path(__file__).resolve().parents[3]
DATA = SOURCE / "tests/data"


def stored(kind):
    return json.loads((DATA / f"diagnosis-version-1-{kind}.json").read_text())


class Versions(unittest.TestCase):
    def test_modes(self):
        old = stored("modes")
        new = upgraded(old, "x")
        self.assertEqual(old["schema_version"], 1, "the file itself stays as it is")
        self.assertEqual(new["schema_version"], 2)
        self.assertEqual([entry["kind"] for entry in new["data"]], ["modes"])
        entry = entry_of(new, "modes")
        self.assertEqual(entry["sets"], old["modes"])
        self.assertEqual(entry["observations"], old["baseline"]["observations"])
        self.assertEqual((entry["baseline_chi2"], entry["extended_chi2"]), (old["baseline"]["chi2"], old["extended"]["chi2"]))
        self.assertEqual({one["kind"] for one in new["next"]["measurements"]}, {"modes"})
        self.assertEqual(entry_of(new, "flight")["sets"], [])
        finding = old["verdict"]["causes"][0]["finding"]
        self.assertTrue(finding)
        self.assertEqual(new["verdict"]["statement"], f"{old['verdict']['sentence']}. {finding}")

    def test_bending(self):
        new = upgraded(stored("bending"), "x")
        self.assertEqual([entry["kind"] for entry in new["data"]], ["bending"])
        values = [one["separation_sd"] for one in new["next"]["measurements"]]
        self.assertEqual(values, sorted(values, reverse=True))
        self.assertEqual(len({"repeat" in one for one in new["next"]["measurements"]}), 2, "repeats and new loads are in one list")
        for removed in "next_measurements", "new_loads", "modes", "series", "flight":
            self.assertNotIn(removed, new)

    def test_page(self):
        for kind in "modes", "bending":
            text = page(upgraded(stored(kind), "x"), [])
            self.assertIn("What to measure next", text)
            self.assertIn("What each kind of data says", text)

    def test_tools(self):
        """plot_diagnosis, the package and the scores of blind cases read a stored file of version 1."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "diagnosis.json"
            shutil.copy(DATA / "diagnosis-version-1-modes.json", path)
            done = run_tool("plot_diagnosis", path)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(read_diagnosis(path).data["schema_version"], 2)
            self.assertIn("Something sits on the wing", read_diagnosis(path).statement)
            self.assertEqual(flat_verdict(json.loads(path.read_text())), flat_verdict(read_diagnosis(path).data))

    def test_unknown_version(self):
        for version in 0, 3, None:
            with self.assertRaises(InputError):
                upgraded({**stored("modes"), "schema_version": version}, "x")


if __name__ == "__main__":
    unittest.main()
