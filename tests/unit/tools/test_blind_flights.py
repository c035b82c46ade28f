# SPDX-License-Identifier: GPL-3.0-or-later
"""Blind flights: as visible as drawn, sealed, the same for the same seed, and scored like the others."""
import json
import subprocess
import sys
import tempfile
import unittest
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from flusi_msm.blind.cases import CLOSE, Options
from flusi_msm.blind.flight_effects import KNOWN, OUTSIDE, balance_gain
from flusi_msm.blind.flight_input import write_section
from flusi_msm.blind.flight_study import STATED, as_sought
from flusi_msm.blind.flights import curve, draw, individual, make_flights, make_strong, visibility
from flusi_msm.blind.ledger import Ledger
from flusi_msm.measurement.balance import Scatter
from flusi_msm.measurement.flight import Case, Flow, beat_of, read_case
from synthetic import SOURCE, run_tool

DESIGN = Case(samples=30, flow=Flow(beats=1, modes=24, radial=30, radius=8.0), noise=Scatter(white=0.1, model=0.02))
MIX = {"null": 1.0, "single": 1.0, "double": 1.0, "outside": 1.0}

FAKE = """#!{}
import json, pathlib
text = pathlib.Path("diagnose.ini").read_text()
keys = dict(line.rstrip(";").split(" = ") for line in text.split("[Flight]")[1].splitlines() if " = " in line)
name = text.split("[Measurement]")[1].split("file = ")[1].split(";")[0]
assert pathlib.Path(name).exists() and pathlib.Path(keys["file"]).exists() and keys["beats"] == "1"
pathlib.Path(keys["folder"]).mkdir(exist_ok=True)
with open(keys["folder"] + "/told", "a") as told:
    told.write(pathlib.Path(name).name + " ")
pathlib.Path("diagnosis.json").write_text(json.dumps(dict(
    schema="flusi-msm diagnosis", verdict=dict(word="adequate", probability=0.9, causes=[], set=[]), effects=[], noise=dict(warning=""),
    mesh_band=None, baseline=dict(chi2=1.0), extended=dict(is_found=False), validation=dict())))
"""


class Flights(unittest.TestCase):
    def test_visibility(self):
        """A gain of 1 + g changes all samples by g of themselves: the ratio is g sqrt(2 n)/sqrt(0.1^2/beats + 0.02^2)."""
        case = replace(DESIGN, balance=replace(DESIGN.balance, gain=1.05))
        self.assertAlmostEqual(visibility(case, DESIGN), 0.05 * np.sqrt(60) / np.sqrt(0.01 / 20 + 0.0004), 8)
        shifted = replace(DESIGN, noise=replace(DESIGN.noise, white=1e-4, model=0.0, correlated=0.1, correlation_time=1.0))
        constant = replace(shifted, balance=replace(DESIGN.balance, offset=(1e-5, 0.0, 0.0)))
        self.assertLess(visibility(constant, shifted), 1.1e-5 / (0.1 / np.sqrt(20) * np.sqrt((curve(DESIGN)[:, 0]**2).mean())))

    def test_allowed(self):
        """A gain of 1 + g is in all forces: with the relative errors a of both components and b of each, whose sd are f, the least
        sum of squares is 2 c (g - f (a + b))^2 + a^2 + 2 b^2 = 2 c g^2/(1 + 3 c f^2), where c = n/sd^2."""
        case, c = replace(DESIGN, balance=replace(DESIGN.balance, gain=1.05)), 30 / (0.01 / 20 + 0.0004)
        self.assertAlmostEqual(visibility(case, DESIGN, 0.05), 0.05 * np.sqrt(2 * c / (1 + 3 * c * 0.05**2)), 8)
        late = replace(DESIGN, balance=replace(DESIGN.balance, delay=1e-4))
        smooth = replace(DESIGN, noise=replace(DESIGN.noise, model_time=3e-4))
        C = (0.01 / 20 + 0.0004) * np.array([[np.exp(-min(abs(i - j), 30 - abs(i - j)) / 30 / 200 / 3e-4) for j in range(30)] for i in range(30)])
        rows = curve(DESIGN) / np.sqrt((curve(DESIGN)**2).mean(0))
        self.assertAlmostEqual(visibility(replace(smooth, balance=case.balance), smooth), 0.05 * np.sqrt(np.trace(rows.T @ np.linalg.solve(C, rows))), 8)
        self.assertGreater(visibility(late, DESIGN, 0.05), 0.9 * visibility(late, DESIGN), "a shift in time is hardly a factor")

    def test_effects(self):
        """All effects vanish with their strength; what can be had at the design's noise is as visible as wanted."""
        rng, reached = np.random.default_rng(1), []
        for make in (*KNOWN, *OUTSIDE):
            effect = make(rng, DESIGN)
            still = effect.apply(DESIGN, 0.0)
            self.assertEqual({key: value for key, value in asdict(still).items()}, asdict(DESIGN), effect.name)
            self.assertEqual(effect.is_known, make in KNOWN)
            if next(iter(effect.parameters(1.0))).startswith("balance"):  # no flight
                made = make_strong(DESIGN, effect, 8.0)
                if made is not None:
                    reached.append(effect.name)
                    self.assertTrue(1 / CLOSE <= made[1] / 8 <= CLOSE)
        self.assertGreaterEqual(len(reached), 5, reached)
        self.assertIsNone(make_strong(DESIGN, balance_gain(rng, DESIGN), 1e4))

    def test_draws(self):
        options = Options({"double": 1.0}, (6.0, 10.0), 2, ("same",))
        case, truth = draw(5, 1, DESIGN, options)
        self.assertEqual(len(truth["causes"]), 2)
        for cause in truth["causes"]:
            self.assertTrue(6 / CLOSE <= cause["snr"] <= 10 * CLOSE)
        self.assertEqual(draw(5, 1, DESIGN, options)[1], truth)
        self.assertNotEqual(individual(DESIGN, 5, 0, 2).kinematics, individual(DESIGN, 5, 1, 2).kinematics)
        self.assertEqual(individual(DESIGN, 5, 0, 1), DESIGN)
        null, truth = draw(5, 2, DESIGN, replace(options, mix={"null": 1.0}, individuals=1))
        self.assertEqual((truth["causes"], null.hidden, null.balance), ([], DESIGN.hidden, DESIGN.balance))

    def test_batch(self):
        """Three cases, then four; the first ones stay as they are; nothing open tells what they hide; scores."""
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "batch"
            options = Options(MIX, (5.0, 20.0), 1, ("same",))
            make_flights(DESIGN, folder, 2, 11, options, 1, lambda text: None)
            before = {path.name: path.read_bytes() for path in folder.glob("*.h5")}
            make_flights(DESIGN, folder, 3, None, options, 1, lambda text: None)
            other = Path(place) / "other"
            make_flights(DESIGN, other, 1, 11, options, 1, lambda text: None)
            self.assertEqual(before["0001.h5"], (other / "0001.h5").read_bytes())
            for name, data in before.items():
                self.assertEqual(data, (folder / name).read_bytes())
            stated = json.loads((folder / "0003.stated.json").read_text())
            self.assertEqual(set(stated), {"wing", "kinematics", "fluid"})
            self.assertEqual(set(Ledger(folder).cases), {"0001", "0002", "0003"})
            (folder / "verdicts").mkdir()
            for name in Ledger(folder).cases:
                (folder / "verdicts" / f"{name}.json").write_text(json.dumps({"verdict": "adequate", "causes": [], "probability": 0.9}))
            done = run_tool("blind_score", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(json.loads(done.stdout.splitlines()[-1])["cases"], 3)

    def test_command(self):
        """The design in ini is one of flights; what flights have not is refused."""
        read_case(SOURCE / "ini/blind-flight.json")
        with tempfile.TemporaryDirectory() as folder:
            done = run_tool("blind_generate", SOURCE / "ini/blind-flight.json", folder, "--fixed", "one")
            self.assertEqual(done.returncode, 2)
            self.assertIn("flights have no fixed cases", done.stderr)
            (Path(folder) / "design.json").write_text(json.dumps({"samples": 20, "kinematics": {}, "flow": asdict(DESIGN.flow)}))
            done = run_tool("blind_generate", Path(folder) / "design.json", Path(folder) / "batch", "--cases", 1, "--mix", "null=1", "--seed", 1)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((Path(folder) / "batch/0001.h5").exists())


class Studies(unittest.TestCase):
    """bench/diagnosis/run --kind flight."""

    def test_case(self):
        """The case of flusi moves as the flow of the generator does, at the same Reynolds number and frequency."""
        case = replace(DESIGN, kinematics=replace(DESIGN.kinematics, lead=20.0, mean_angle=85.0, pitch=40.0))
        k, chord = case.kinematics, case.wing.chord
        with tempfile.TemporaryDirectory() as place:
            path = write_section(Path(place) / "case", {**{key: asdict(getattr(case, key)) for key in STATED}, "beats": 1})
            text = path.read_text()
            table = np.array([[float(x) for x in line.split()] for line in (path.parent / "stroke.t").read_text().splitlines()])
            turn = dict(line.split(" = ") for line in (path.parent / "pitch.ini").read_text().splitlines() if "=" in line)
        keys = dict(line.split(";")[0].split(" = ") for line in text.splitlines() if " = " in line)
        value = {name: float(keys[name]) for name in ("length", "frequency", "wing_frequency", "nu", "Tmax", "yl")}
        self.assertAlmostEqual(value["frequency"] * value["wing_frequency"], k.frequency, 9)
        self.assertAlmostEqual(1 / value["nu"], np.pi * k.frequency * k.stroke * chord / case.fluid.viscosity, 9)
        phase = np.arange(50) / 50
        exact, rate, _ = beat_of(case).at(phase / k.frequency)
        s = table[:, 0] / value["Tmax"]
        for column, wanted in ((2, exact[:, 0] / chord + value["yl"] / 2), (3, exact[:, 1] / chord + value["yl"] / 2),
                               (5, rate[:, 0] / (chord * value["frequency"]))):
            np.testing.assert_allclose(np.interp(phase, s, table[:, column]), wanted, atol=2e-9, err_msg=str(column))
        angle = float(turn["a0_phi"]) / 2 + float(turn["ai_phi"]) * np.cos(2 * np.pi * phase) + float(turn["bi_phi"]) * np.sin(2 * np.pi * phase)
        np.testing.assert_allclose(angle, np.degrees(exact[:, 2]), atol=1e-9)

    def test_names(self):
        """Every effect of the catalogue has a value by the name that msm_diagnose has; those outside have none."""
        rng = np.random.default_rng(2)
        for make in (*KNOWN, *OUTSIDE):
            effect = make(rng, DESIGN)
            found = as_sought(DESIGN, effect.parameters(effect.first))
            self.assertEqual(len(found), make in KNOWN, effect.name)
            for name in found:
                self.assertEqual(name.split(":")[0], {"wing_inertia": "inertia_mass"}.get(effect.name, effect.name))
        self.assertEqual(as_sought(DESIGN, {"hidden.lead": 9.0}), {"pitch_lead": 0.025})
        self.assertEqual(as_sought(DESIGN, {"hidden.phase": 0.1}), {"balance_delay": -0.1 / 200})

    def run_study(self, folder, name, *more):
        """Runs the first two cases of a study with a program that tells what it was asked; returns the last line."""
        done = subprocess.run([sys.executable, "-B", SOURCE / "bench/diagnosis/study.py", "--kind", "flight", "--seed", "5", "--cases", "2",
                               "--design", folder / "design.json", "--program", folder / "program", "--folder", folder / name, *more],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def test_run(self):
        """Cases do not depend on what was made before; a program gets the measurement and the case of its individual, and is not
        asked again."""
        design = {"samples": 20, "flow": asdict(DESIGN.flow), "noise": {"white": 0.1, "model": 0.05}, "kinematics": {}}
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            (folder / "design.json").write_text(json.dumps(design))
            (folder / "program").write_text(FAKE.format(sys.executable))
            (folder / "program").chmod(0o755)
            self.assertIn("2 cases to make and to diagnose: about ", self.run_study(folder, "a").stderr)
            told = [path.read_text() for path in folder.glob("a/flights-*/of*/told")]
            self.assertEqual(told, ["0001.h5 0002.h5 "], "both cases are of one individual")
            again = self.run_study(folder, "a")
            self.assertIn("0 cases to make", again.stderr)
            self.assertEqual(json.loads(again.stdout.splitlines()[-1])["false_alarm_rate"], 0.0)
            self.assertEqual([path.read_text() for path in folder.glob("a/flights-*/of*/told")], told)
            self.run_study(folder, "b", "--shard", "2/2", "--only", "generate")
            self.assertEqual(*((folder / name / "measured/0002.h5").read_bytes() for name in "ab"))


if __name__ == "__main__":
    unittest.main()
