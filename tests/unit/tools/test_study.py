# SPDX-License-Identifier: GPL-3.0-or-later
"""bench/diagnosis/run: any first part of a study has the proportions of the whole, cases do not depend on what was made before,
and the verdicts of msm_diagnose are read as they are meant."""
import importlib.util
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np

from flusi_msm.blind.archive import Archive, ArchivedStudy
from flusi_msm.blind.batch import read_design
from flusi_msm.blind.report import collect, gain_of, print_report
from flusi_msm.blind.scores import Case
from flusi_msm.blind.strata import STRATA, Stratum, plan, whole_study
from flusi_msm.blind.verdict import density_gain, effect_lines, flat_verdict
from flusi_msm.results.files import InputError

SOURCE = Path(__file__).resolve().parents[3]
DESIGN = {"wing": str(SOURCE / "wings/calliphora_small.h5"), "loads": [[0.00676, -0.00150, 2.0e-4]], "spacing": 6e-4,
          "protocol": {"levels": [1, -1]}, "stiffness": {"plate": "edges"}, "noise": {"height": 1.0e-5}}
FOLDS = {"location": [1.0, 2.0], "observations": [50.0, 60.0], "log_density": [10.0, 20.0], "chi2": [80.0, 90.0],
         "sum_of_squares": [1.0, 2.0]}


def diagnosis(word, causes=(), members=()):
    """What msm_diagnose writes, as far as it is read."""
    return {"schema": "flusi-msm diagnosis", "schema_version": 1,
            "verdict": {"word": word, "probability": 0.97, "set": list(members),
                        "causes": [{"effect": name, "variant": variant} for name, variant in causes]},
            "effects": [{"name": "E_per_vein", "status": "tested"}, {"name": "creep", "status": "not_testable"},
                        {"name": "drift", "status": "absorbed"}],
            "extended": {"is_found": bool(causes), "intervals_90": [
                {"name": "E:C", "lower_best_upper": [0.5, 0.6, 0.7], "has_lower": True, "has_upper": False}]},
            "validation": {"has_gain": True, "gain_per_location": 1.0, "standard_error": 1.0, "baseline": FOLDS,
                           "extended": {**FOLDS, "location": [2.0, 1.0], "log_density": [23.0, 11.0]}}}


class Plans(unittest.TestCase):
    def test_proportions(self):
        """The counts of every stratum in the first N cases are within 1.5 of its share: the one that is most behind is
        always taken, so nobody gets more than one ahead, and ten cannot all be behind."""
        for kind, strata, whole in (("bending", STRATA["bending"], 762), ("vibration", STRATA["vibration"], 300),
                                    ("joint", STRATA["joint"], 174), ("flight", STRATA["flight"], 60)):
            self.assertEqual(whole_study(kind), whole)
            rows = plan(whole, kind)
            counts = {stratum.name: 0 for stratum in strata}
            for number, (stratum, before) in enumerate(rows, 1):
                self.assertEqual(before, counts[stratum.name])
                counts[stratum.name] += 1
                for other in strata:
                    self.assertLess(abs(counts[other.name] - number * other.count / whole), 1.5, (number, other.name))
            self.assertEqual(counts, {stratum.name: stratum.count for stratum in strata})
            self.assertEqual(plan(50, kind), rows[:50])
            self.assertEqual(counts["null"], {"bending": 250, "vibration": 100, "joint": 50, "flight": 20}[kind])
            self.assertEqual(counts.get("double", 0), 24 if kind == "joint" else 0)


class Cases(unittest.TestCase):
    def test_made(self):
        """The same case whatever was made before it; a changed measurement is noticed; no wing is bent twice."""
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "design.json").write_text(json.dumps(DESIGN))
            design = read_design(folder / "design.json")[0]
            made = {}
            for name, numbers in (("a", (1, 2)), ("b", (2,))):
                for part in ("sealed", "measured", "individuals"):
                    (folder / name / part).mkdir(parents=True)
                study = made[name] = ArchivedStudy(folder / name, {"small": design}, 3, Archive(None))
                for number in numbers:
                    study.make(number, Stratum("null", 1, "null") if number == 1 else
                               Stratum("single", 1, "single", (4.0, 6.0)), 0)
            one, two = (made[name].truth(2) for name in "ab")
            for truth in one, two:
                for key in ("cpu_seconds", "cpu_seconds_individual"):
                    truth.pop(key)
            self.assertEqual(one, two)
            self.assertTrue(4 <= one["snr"] < 6, one["snr"])
            before = made["a"].measurement(2).read_bytes()
            self.assertEqual(before, made["b"].measurement(2).read_bytes())
            made["a"].make(2, None, 0)  # it is there
            verdicts = folder / "a/verdicts"
            verdicts.mkdir()
            (verdicts / "0001.json").write_text(json.dumps({"verdict": {"verdict": "adequate"}, "cpu_seconds": 1.0}))
            (verdicts / "0002.json").write_text(json.dumps({"exit_code": 3, "problem": "none", "cpu_seconds": 1.0}))
            cases, records, _ = collect(made["a"], verdicts, 5)
            self.assertEqual([case.verdict for case in cases], ["adequate", "data_insufficient"])
            self.assertEqual(sorted(records), ["0001", "0002"])
            print_report(made["a"], verdicts, 5)
            self.assertEqual(json.loads((verdicts / "scores.json").read_text())["failed"], ["0002"])
            self.check_archive(folder, made["a"], verdicts)
            made["a"].measurement(2).write_bytes(before + b"x")
            with self.assertRaisesRegex(InputError, "is not the measurement"):
                made["a"].truth(2)

    @staticmethod
    def score(path, folder):
        return subprocess.run([sys.executable, "-B", SOURCE / "bench/diagnosis/study.py", "--only", "score", "--archive", path, "--folder",
                               folder, "--program", folder / "no-program"], capture_output=True, text=True, check=False)

    def check_archive(self, folder, study, verdicts):
        """What is archived is scored as it was, without the measurements; it is of one study and program."""
        (verdicts / "0002.oracle.json").write_text(json.dumps({"gain": 1.0, "oracle": 2.0}))
        print_report(study, verdicts, 5)
        before = json.loads((verdicts / "scores.json").read_text())
        one, path = {"seed": 3, "program": "p"}, folder / "archive.jsonl"
        archive = Archive(path)
        archive.begin(one)
        archive.save(study, verdicts, 1)
        archive = Archive(path)
        archive.begin(one)  # is continued
        late = Archive(path)
        late.begin(one)
        self.assertEqual(archive.save(study, verdicts, 5), [])
        late.save(study, folder / "none", 5)
        self.assertEqual(sorted(late.rows), [1, 2], "what others have archived meanwhile stays")
        (folder / "elsewhere").mkdir()
        other = ArchivedStudy(folder / "elsewhere", {}, 3, Archive(path))
        self.assertEqual(sorted(other.archive.rows), [1, 2])
        print_report(other, folder / "elsewhere", 5)
        self.assertEqual(json.loads((folder / "elsewhere/scores.json").read_text()), before)
        self.assertEqual(before["gain_cases"], 1)
        done = self.score(path, folder / "new")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout.splitlines()[-1])["false_alarm_rate"], 0.0)
        self.assertFalse((folder / "new/study.json").exists())
        self.assertIn("no archive", self.score(folder / "nowhere.jsonl", folder / "new").stderr)
        with self.assertRaisesRegex(InputError, "of another program"):
            Archive(path).begin({**one, "program": "q"})
        path.write_text("no archive")
        with self.assertRaisesRegex(InputError, "not an archive"):
            Archive(path)


class Wings(unittest.TestCase):
    """bench/diagnosis/run_wings."""

    def test_cases(self):
        """The stroke gets a third harmonic and nothing else changes; what is right for each case; errors of a balance."""
        spec = importlib.util.spec_from_file_location("wings", SOURCE / "bench/diagnosis/wings.py")
        wings = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(wings)
        before, after = (dict(line.split(";")[0].split(" = ") for line in text.splitlines() if " = " in line.split(";")[0])
                         for text in (wings.KINEMATICS.read_text(), wings.with_wave(wings.KINEMATICS.read_text())))
        self.assertEqual({key for key in before if before[key] != after[key]}, {"nfft_phi", "ai_phi", "bi_phi"})
        self.assertEqual([float(x) for x in after["ai_phi"].split()], [float(before["ai_phi"]), 0.0, wings.WAVE])
        self.assertEqual([float(x) for x in after["bi_phi"].split()], [0.0, 0.0, 0.0])
        for word, names, right in (("adequate", [], {None}), ("unknown_cause", [], {"outside"}),
                                   ("consistent_with_set", ["pitch_lead", "wind"], {"pitch_lead"})):
            found = {"verdict": {"word": word, "set": names, "causes": []}}
            self.assertEqual({cause for _, _, _, cause in wings.CASES.values() if wings.judged(cause, found)}, right)
        exact = np.random.default_rng(2).standard_normal((len(wings.TIMES), len(wings.NAMES)))
        with tempfile.TemporaryDirectory() as folder:
            wings.write_data(Path(folder) / "data.h5", exact, wings.GAIN, 1)
            with h5py.File(Path(folder) / "data.h5") as file:
                seen, sd = file["flight/wings/mean"][:], file["flight/wings/sd"][:]
        rms = np.sqrt((exact**2).mean(0))
        size = np.array([*3 * [rms[:3].max()], rms[3]])  # of the errors: those of all axes are alike
        for k, gain in enumerate((wings.GAIN, wings.GAIN, wings.GAIN, 1.0)):
            self.assertAlmostEqual(seen[:, k] @ exact[:, k] / (exact[:, k] @ exact[:, k]), gain,
                                   delta=4 * wings.WHITE * size[k] / rms[k] / len(exact)**0.5)
        self.assertTrue((np.abs(sd / size - np.hypot(wings.WHITE, wings.MODEL)) < 1e-12).all())


class Verdicts(unittest.TestCase):
    def test_flat(self):
        flat = flat_verdict(diagnosis("named", [("E_per_vein", "C")], ["E_per_vein"]))
        self.assertEqual(flat["causes"], [{"names": ["E_per_vein"]}])
        self.assertEqual(flat["catalogue"], ["E_per_vein", "drift"])
        self.assertEqual(flat["intervals"], {"E:C": {"lower": 0.5, "upper": None}})
        self.assertEqual(flat["gain"], {"baseline": 170.0, "extended": 170.0, "residuals": 110.0})
        self.assertEqual(density_gain(flat["folds"]["baseline"], flat["folds"]["extended"]), 4.0)
        self.assertEqual(flat_verdict(flat), flat)
        flat = flat_verdict(diagnosis("consistent_with_set", [("E_per_vein", "C")], ["E_per_vein", "drift"]))
        self.assertEqual(flat["causes"], [{"names": ["E_per_vein", "drift"]}])
        flat = flat_verdict(diagnosis("unknown_cause", [("E_per_vein", "C")]))
        self.assertEqual(flat["causes"], [])
        truth = {"kind": "single", "mesh": "same", "rig": "quiet", "snr": 9.0,
                 "causes": [{"name": "E_per_vein", "is_known": True, "parameters": {"E:C": 0.6}}]}
        case = Case("1", truth, diagnosis("named", [("E_per_vein", "C")], ["E_per_vein"]))
        self.assertTrue(case.is_named("E_per_vein") and case.is_right())

    def test_oracle(self):
        """Input that gives msm_diagnose the truth, and the ratio of gains."""
        made = {"stiffness": {"damage": [0.004, -0.001, 8e-4, 0.6]}, "hidden": {"soft_places": [["C", 0.25, 1e-6]]}}

        def lines(name, strength=1.0, **parameters):
            return effect_lines({"generator": {"case": made}, "causes": [
                {"name": name, "is_known": True, "strength": strength, "parameters": parameters}]})

        self.assertEqual(lines("damage"), {"Wing": {"damage_disc": "0.004 -0.001 0.0008", "parameters": "damage 0.6"},
                                           "Instrument": {}})
        self.assertEqual(lines("soft_place", 3.0)["Wing"], {"soft_place": "C 0.25", "parameters": "soft 0.25"})
        self.assertEqual(lines("drift", drift=1e-3)["Instrument"], {"parameters": "drift 0.001"})
        self.assertEqual(lines("membrane_bending", D=3e-7)["Wing"], {"D": "3e-07"})
        self.assertIn("sided_joints", lines("one_way_joint", **{"one_way:C_h": 2.0})["Wing"])
        oracles = {"1": {"gain": 9.0, "oracle": 10.0}, "2": {"gain": 0.0, "oracle": 2.0}, "3": {"gain": 1, "oracle": None},
                   "4": {"gain": 5.0, "oracle": 6.0}}
        verdicts = {"1": "named", "2": "adequate", "3": "named", "4": "unknown_cause"}
        cases = [SimpleNamespace(name=name, verdict=verdict) for name, verdict in verdicts.items()]
        fraction, (low, high), n = gain_of(oracles, cases)
        self.assertEqual((fraction, n), (9 / 18, 3))
        self.assertTrue(low <= fraction <= high)


if __name__ == "__main__":
    unittest.main()
