# SPDX-License-Identifier: GPL-3.0-or-later
"""Blind flights: as visible as drawn, sealed, the same for the same seed, and scored like the others."""
import json
import tempfile
import unittest
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from flusi_msm.blind.cases import CLOSE, Options
from flusi_msm.blind.flight_effects import KNOWN, OUTSIDE, balance_gain
from flusi_msm.blind.flights import curve, draw, individual, make_flights, make_strong, visibility
from flusi_msm.blind.ledger import Ledger
from flusi_msm.measurement.balance import Scatter
from flusi_msm.measurement.flight import Case, Flow, read_case
from synthetic import SOURCE, run_tool

DESIGN = Case(samples=30, flow=Flow(beats=1, modes=24, radial=30, radius=8.0), noise=Scatter(white=0.1, model=0.02))
MIX = {"null": 1.0, "single": 1.0, "double": 1.0, "outside": 1.0}


class Flights(unittest.TestCase):
    def test_visibility(self):
        """A gain of 1 + g changes all samples by g of themselves: the ratio is g sqrt(2 n)/sqrt(0.1^2/beats + 0.02^2)."""
        case = replace(DESIGN, balance=replace(DESIGN.balance, gain=1.05))
        self.assertAlmostEqual(visibility(case, DESIGN), 0.05 * np.sqrt(60) / np.sqrt(0.01 / 20 + 0.0004), 8)
        shifted = replace(DESIGN, noise=replace(DESIGN.noise, white=1e-4, model=0.0, correlated=0.1, correlation_time=1.0))
        constant = replace(shifted, balance=replace(DESIGN.balance, offset=(1e-5, 0.0, 0.0)))
        self.assertLess(visibility(constant, shifted), 1.1e-5 / (0.1 / np.sqrt(20) * np.sqrt((curve(DESIGN)[:, 0]**2).mean())))

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


if __name__ == "__main__":
    unittest.main()
