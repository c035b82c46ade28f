# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/blind_generate and tools/blind_score: effects vanish at strength 0, the signal-to-noise ratio is that of its definition,
seeds reproduce bytes, seals hold, scores and their bounds are right."""
import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from flusi_msm.blind.batch import read_design
from flusi_msm.blind.cases import KINDS, Individual, Options, draw_head, make_strong
from flusi_msm.blind.effects import KNOWN, OUTSIDE, E_gradient
from flusi_msm.blind.ledger import Ledger, digest
from flusi_msm.blind.oracle import MEMBRANE_SD, STEP, Base, Oracle
from flusi_msm.blind.scores import Case, calibration_error, clopper_pearson, confusion_of, scores_of, wilson
from flusi_msm.measurement.grid import grid_lines
from flusi_msm.measurement.noise import Noise
from flusi_msm.measurement.synthesis import Bench
from flusi_msm.results.files import InputError

SOURCE = Path(__file__).resolve().parents[3]
TOOLS = SOURCE / "tools"

DESIGN = {"wing": str(SOURCE / "wings/calliphora_small.h5"), "loads": [[0.00676, -0.00150, 2.0e-4]], "spacing": 6e-4,
          "protocol": {"levels": [1, -1], "random_order": True}, "stiffness": {"plate": "edges"},
          "noise": {"height": 1.0e-5, "correlated": 5e-6, "reference_scans": 3},
          "fixed": {"gain": {"hidden": {"force_gain": 1.1}}, "none": {}}}


class WithDesign(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        (cls.folder / "design.json").write_text(json.dumps(DESIGN))
        cls.design, cls.fixed = read_design(cls.folder / "design.json")


class Bent(Individual):
    """An individual on the mesh of the wing file alone."""

    def __init__(self, design):
        self.design, self.stiffness, self.oracles = design, design.stiffness, {}
        bench = Bench(self.case("same", Noise(height=0.0)))
        low, high = bench.wing.points.min(0), bench.wing.points.max(0)
        self.grid = [grid_lines(low[k], high[k], design.spacing) for k in range(2)]
        self.bases = {"same": Base(bench, *self.grid)}
        clean = self.deformations("same", bench.case)
        self.clean = {"same": clean, "finer": 1.02 * clean}


class Effects(WithDesign):
    def test_null(self):
        """At strength 0 the wing and the rig are the usual ones; at a small one they are not."""
        bench = Bench(self.design)
        usual = bench.model()
        for number, draw in enumerate(KNOWN + OUTSIDE):
            effect = draw(np.random.default_rng(number), bench.coarse, self.design)
            null, case = effect.apply(self.design, 0.0), effect.apply(self.design, effect.first)
            model = Bench(null).model()
            np.testing.assert_allclose(np.sort(model.turns.k), np.sort(usual.turns.k), rtol=1e-14, err_msg=effect.name)
            for one, other in ((model.springs.k, usual.springs.k), (model.plate.blocks, usual.plate.blocks),
                               (model.turns.k3, usual.turns.k3), (model.turns.sided, usual.turns.sided)):
                np.testing.assert_allclose(one, other, rtol=1e-14, atol=0, err_msg=effect.name)
            hidden = {**vars(null.hidden), "soft_places": ()}
            for key, value in vars(self.design.hidden).items():
                np.testing.assert_allclose(hidden[key], value, rtol=1e-14, err_msg=effect.name)
            self.assertEqual(null.stiffness.camber, (0, 0, 0))
            self.assertEqual(null.stiffness.root_compliance, (0, 0))
            self.assertNotEqual(case, self.design, effect.name)
            self.assertEqual(effect.is_known, draw in KNOWN)
            self.assertLess(effect.first, effect.most)


class Visibility(WithDesign):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.bent = Bent(cls.design)

    def test_derivatives(self):
        """Columns for E, a joint, the force and its place are those of central differences, at all places that the wing
        covers throughout. Errors: the square of the step, 1e-6, and the solver's tolerance over it, 1e-9/1e-3; for the
        place the square of the step over the mesh's width of 0.5 mm."""
        bent, design = self.bent, self.design
        s, base = design.stiffness, bent.bases["same"]
        joints = [h.joint for h in base.model.hinge_plan if h.joint]
        name = joints[2]
        k = next(base.model.hinge_stiffness(h) for h in base.model.hinge_plan if h.joint == name)
        others = {h.joint: base.model.hinge_stiffness(h) for h in base.model.hinge_plan if h.joint}

        def seen(**changes):
            case = replace(design, **changes)
            return bent.deformations("same", case)

        def of_e(factor):
            return seen(stiffness=replace(s, E=s.E * factor, joints=others))

        def of_joint(factor):
            return seen(stiffness=replace(s, joints={name: k * factor}))

        def of_membrane(factor):
            return seen(stiffness=replace(s, D=s.D * factor, joints=others))

        def of_force(factor):
            return seen(hidden=replace(design.hidden, force_gain=factor))

        def of_place(step):
            return seen(hidden=replace(design.hidden, load_shift=(step, 0.0)))

        columns = np.stack([base.columns[load.name] for load in base.loads])
        for index, function, low, high, width, tolerance in (
                (0, of_e, np.exp(-1e-3), np.exp(1e-3), 2e-3, 1e-5),
                (1 + 2, of_joint, np.exp(-1e-3), np.exp(1e-3), 2e-3, 1e-5),
                (1 + len(joints), of_membrane, np.exp(-1e-3), np.exp(1e-3), 2e-3, 1e-5),
                (3 + len(joints), of_force, 1 - 1e-3, 1 + 1e-3, 2e-3, 1e-5),
                (4 + len(joints), of_place, -STEP, STEP, 2 * STEP, (STEP / 5e-4)**2)):
            slope = (function(high) - function(low)) / width
            both = np.isfinite(slope) & np.isfinite(columns[..., index])
            self.assertGreater(both.sum(), 60)
            largest = np.abs(slope[both]).max()
            error = np.abs(slope - columns[..., index])[both]
            # A grid point may pass an edge of the mesh in between: its slope is then that of two triangles.
            self.assertLess(np.quantile(error, 0.9), tolerance * largest, index)
            self.assertLess(error.max(), 2e-2 * largest, index)

    def test_definition(self):
        """The signal-to-noise ratio against the dense formula: the covariance of all heights with everything that may be
        adjusted added to it."""
        bent, noise = self.bent, self.design.noise
        base, clean = bent.bases["same"], bent.clean["same"]
        sd = {"force_gain": 0.02, "force": 1e-6, "position": 3e-5, "tilt": 1e-3, "piston": 5e-6}
        fringe = (3e-6, 1.3e-3, 0.4)
        oracle = Oracle(base, noise, sd, clean, bent.clean["finer"], fringe)
        known = oracle.known
        y, x = np.meshgrid(*self.bent.grid[::-1], indexing="ij")
        place = [(load, x[j, i], y[j, i]) for load, j, i in np.argwhere(known)]
        load, px, py = (np.array(column) for column in zip(*place))
        square = (px[:, None] - px)**2 + (py[:, None] - py)**2
        one = noise.correlated**2 * np.exp(-square / (2 * noise.correlation_length**2)) \
            + noise.height**2 * (square == 0)
        phase = 2 * np.pi / fringe[1] * (px * np.cos(fringe[2]) + py * np.sin(fringe[2]))
        one += fringe[0]**2 / 2 * np.cos(phase[:, None] - phase)
        covariance = one * ((load[:, None] == load) + 1 / noise.reference_scans)
        columns = np.concatenate([base.columns[item.name][seen] for item, seen in zip(base.loads, known)])
        n = len(base.model.hinge_plan) and sum(bool(h.joint) for h in base.model.hinge_plan)
        own = [(2 + n, sd["force"]), (4 + n, sd["position"]), (5 + n, sd["position"]), (6 + n, sd["tilt"]),
               (7 + n, sd["tilt"]), (8 + n, sd["piston"])]
        band = (bent.clean["finer"] - clean)[known]
        adjusted = [columns[:, k] * np.log(10) for k in range(1 + n)] \
            + [columns[:, 1 + n] * MEMBRANE_SD, columns[:, 3 + n] * sd["force_gain"], band] \
            + [columns[:, k] * size * (load == which) for k, size in own for which in range(len(base.loads))]
        whole = covariance + sum(np.outer(a, a) for a in adjusted)
        rng = np.random.default_rng(3)
        for d in (rng.standard_normal(len(load)) * 1e-5, 0.1 * band, 1e-4 * np.sin(px / 1e-3)):
            seen = clean.copy()
            seen[known] += d
            want = np.sqrt(d @ np.linalg.solve(whole, d))
            # Relative errors of `solve`: round-off times the condition, 1e-16 x 1e6 at most.
            self.assertAlmostEqual(oracle.snr(oracle.change(seen)) / want, 1, delta=1e-7)
        quiet = covariance + sum(np.outer(a, a) for k, a in enumerate(adjusted) if a is not band)
        self.assertAlmostEqual(oracle.band_snr() / np.sqrt(band @ np.linalg.solve(quiet, band)), 1, delta=1e-7)

    def test_strength(self):
        """An effect is made as visible as wanted; E itself is absorbed."""
        case = self.bent.case("same", self.design.noise)
        oracle = self.bent.oracle("same", "quiet", case)
        effect = E_gradient(np.random.default_rng(1), Bench(case).coarse, case)
        s, snr = make_strong(self.bent, "same", "quiet", case, effect, 4.0)
        self.assertTrue(4 / 1.25 <= snr <= 4 * 1.25, snr)
        self.assertEqual(snr, self.bent.visibility("same", "quiet", case, self.bent.deformations("same", effect.apply(case, s))))
        softer = replace(case, stiffness=replace(case.stiffness, E=0.97 * case.stiffness.E))
        self.assertGreater(np.nanmax(np.abs(self.bent.deformations("same", softer) - self.bent.clean["same"])), 5e-6)
        self.assertLess(oracle.snr(oracle.change(self.bent.deformations("same", softer))), 0.2)

    def test_large_changes(self):
        """Stiffness that the usual model may have is hardly visible, although derivatives at the old one miss the squares of
        large changes, which sharp eyes see. What is no longer seen, here the outer tenth of the wing, is no signal."""
        case = self.bent.case("same", Noise(height=2e-7))
        oracle = self.bent.oracle("same", "sharp", case)
        model = self.bent.bases["same"].model
        softer = replace(case.stiffness, E=0.7 * case.stiffness.E,
                         joints={h.joint: 0.5 * model.hinge_stiffness(h) for h in model.hinge_plan if h.joint})
        seen = self.bent.deformations("same", replace(case, stiffness=softer))
        linear = oracle.snr(oracle.change(seen))
        self.assertGreater(linear, 5)
        self.assertLess(self.bent.visibility("same", "sharp", case, seen), 0.5 * linear)
        x = self.bent.grid[0]
        seen[..., x > x.min() + 0.9 * np.ptp(x)] = np.nan
        self.assertLess(oracle.snr(oracle.change(seen)), 1.1 * linear)


class Batches(WithDesign):
    def run_tool(self, name, *arguments, code=0):
        done = subprocess.run([sys.executable, "-B", TOOLS / name, *map(str, arguments)], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def test_batch(self):
        """The same seed gives the same bytes, also in two goes; sealed truths are opened behind the last verdict only."""
        options = ("--seed", 5, "--individuals", 1, "--snr", 2, 4, "--mix", "null=1,single=1", "--quiet")
        self.run_tool("blind_generate", "design.json", "a", "--cases", 2, *options)
        shutil.copytree(self.folder / "a", self.folder / "b")  # a batch that was interrupted behind the first case
        ledger = json.loads((self.folder / "b/ledger.json").read_text())
        ledger["cases"].pop()
        (self.folder / "b/ledger.json").write_text(json.dumps(ledger))
        for name in ("0002.h5", "sealed/0002.json"):
            (self.folder / "b" / name).unlink()
        self.run_tool("blind_generate", "design.json", "b", "--cases", 2, *options)
        files = sorted(p.relative_to(self.folder / "a") for p in (self.folder / "a").rglob("*") if p.is_file())
        self.assertEqual(len(files), 2 + 2 + 2, files)
        for path in files:
            self.assertEqual((self.folder / "a" / path).read_bytes(), (self.folder / "b" / path).read_bytes(), path)
        self.assertIn("with other settings", self.run_tool("blind_generate", "design.json", "b", "--cases", 2, "--seed", 6,
                                                      code=2).stderr)
        ledger = json.loads((self.folder / "a/ledger.json").read_text())
        self.assertNotRegex(json.dumps(ledger["cases"]), "null|single|E_|snr|mesh|salt")
        truth = json.loads(json.loads((self.folder / "a/sealed/0001.json").read_text())["truth"])
        self.assertIn(truth["kind"], ("null", "single"))
        self.assertEqual(len(truth["causes"]), truth["kind"] == "single")
        verdicts = self.folder / "a/verdicts"
        (verdicts / "0002").mkdir(parents=True)
        (verdicts / "0001.json").write_text('{"verdict": "adequate"}')
        self.assertIn("1 of 2 verdicts are missing", self.run_tool("blind_score", "a", code=2).stderr)
        old = self.run_tool("blindscore", "a", code=2).stderr
        self.assertIn("blindscore: this tool is called blind_score", old)
        self.assertIn("1 of 2 verdicts are missing", old)
        self.assertFalse((self.folder / "a/opened.json").exists())
        (verdicts / "0002/diagnosis.json").write_text('{"verdict": "named", "causes": [{"names": ["drift"]}]}')
        done = self.run_tool("blind_score", "a", "-o", "scores.json", "--figure", "confusion.png")
        self.assertEqual(json.loads(done.stdout.splitlines()[-1])["cases"], 2)
        self.assertGreater((self.folder / "confusion.png").stat().st_size, 2000)
        (verdicts / "0001.json").write_text('{"verdict": "unknown_cause"}')
        places = {"0001": verdicts / "0001.json", "0002": verdicts / "0002/diagnosis.json"}
        with self.assertRaisesRegex(InputError, "not blind"):
            Ledger(self.folder / "a").open(places)
        (verdicts / "0001.json").write_text('{"verdict": "adequate"}')
        sealed = self.folder / "a/sealed/0002.json"
        sealed.write_text(sealed.read_text().replace("strength", "Strength").replace("null", "nul"))
        with self.assertRaisesRegex(InputError, "not the one that was sealed"):
            Ledger(self.folder / "a").open(places)

    def test_fixed(self):
        self.run_tool("blind_generate", "design.json", "fixed", "--fixed", "gain", "--quiet")
        self.assertEqual(sorted(p.name for p in (self.folder / "fixed").iterdir()), ["gain.h5", "gain.truth.json"])
        truth = json.loads((self.folder / "fixed/gain.truth.json").read_text())
        self.assertEqual(truth["case"]["hidden"]["force_gain"], 1.1)
        self.assertIn("no fixed case gian", self.run_tool("blind_generate", "design.json", "f", "--fixed", "gian", code=2).stderr)
        self.assertIn("kind=fraction", self.run_tool("blind_generate", "design.json", "f", "--cases", "1", "--mix", "nul=1",
                                                  code=2).stderr)

    def test_heads(self):
        """Kinds come in the shares that were asked for (4 sd of a binomial), and do not depend on how many are drawn."""
        heads = [draw_head(11, k, Options(KINDS))[1] for k in range(1, 2001)]
        for kind, share in KINDS.items():
            n = sum(head["kind"] == kind for head in heads)
            self.assertAlmostEqual(n / 2000, share, delta=4 * np.sqrt(share * (1 - share) / 2000))
        for key, values in (("mesh", 2), ("rig", 2), ("individual", 8), ("errors", 2000)):
            self.assertEqual(len({head[key] for head in heads}), values)


class Seals(unittest.TestCase):
    def test_measurement(self):
        """A measurement that was changed behind the ledger's back is noticed."""
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            ledger = Ledger(folder)
            ledger.begin({})
            (folder / "0001.h5").write_bytes(b"heights")
            ledger.seal("0001", {"kind": "null"}, "salt")
            text = json.loads((folder / "sealed/0001.json").read_text())["truth"]
            self.assertEqual(Ledger(folder).cases["0001"]["truth_sha256"], digest("salt" + text))
            self.assertEqual(Ledger(folder).truth("0001"), {"kind": "null"})
            (folder / "0001.h5").write_bytes(b"Heights")
            with self.assertRaisesRegex(InputError, "not the one that was made"):
                Ledger(folder).truth("0001")


def case(kind, verdict, *names, snr=10.0, cause="drift", mesh="same", **more):
    causes = [] if kind == "null" else [{"name": cause, "is_known": kind != "outside", "parameters": {cause: 1.0},
                                         "also": ["drift_in_time"] if cause == "drift" else []}]
    return Case("1", {"kind": kind, "mesh": mesh, "rig": "quiet", "snr": 0.0 if kind == "null" else snr,
                      "causes": causes}, {"verdict": verdict, "causes": [{"names": list(names)}] if names else [], **more})


class Scores(unittest.TestCase):
    def test_bounds(self):
        """Newcombe (1998), table I: 81 of 263 and 0 of 20."""
        for hits, n, score, exact in ((81, 263, (0.2553, 0.3662), (0.2527, 0.3676)),
                                      (0, 20, (0.0, 0.1611), (0.0, 0.1684))):
            np.testing.assert_allclose(wilson(hits, n), score, atol=5e-5)
            np.testing.assert_allclose(clopper_pearson(hits, n), exact, atol=5e-5)
        self.assertTrue(np.isnan(wilson(0, 0)).all())

    def test_shares(self):
        cases = [case("null", "adequate"), case("null", "named", "drift"), case("null", "data_insufficient"),
                 case("single", "named", "drift"), case("single", "named", "drift_in_time"),
                 case("single", "named", "damage"), case("single", "consistent_with_set", "damage", "drift"),
                 case("single", "adequate", snr=3.0), case("single", "unknown_cause", snr=6.0),
                 case("outside", "unknown_cause", cause="bow", snr=13.0), case("outside", "named", "drift", cause="bow"),
                 case("single", "unknown_cause", cause="one_way_joint", snr=20.0, catalogue=["drift"])]
        shares = scores_of(cases)["shares"]
        for key, hits, n in (("false_alarm_rate", 1, 3), ("detection_snr5", 8, 8), ("right_or_in_set_snr8", 3, 4),
                             ("single_right_snr8", 2, 4), ("wrong_single_name_rate", 1, 6),
                             ("wrong_single_name_outside", 1, 3), ("unknown_called_snr12", 2, 2)):
            self.assertEqual((shares[key]["hits"], shares[key]["n"]), (hits, n), key)
        self.assertFalse(shares["false_alarm_rate"]["is_met"])
        self.assertTrue(shares["detection_snr5"]["is_met"])
        rows, columns, counts = confusion_of(cases)
        self.assertEqual(rows[0], "none")
        self.assertEqual(counts.sum(), len(cases))
        self.assertEqual(counts[rows.index("drift"), columns.index("set with it")], 1)

    def test_rest(self):
        """Calibration, gain and intervals by hand."""
        cases = [case("single", "named", "drift", probability=0.95, gain={"baseline": 300, "extended": 110,
                                                                         "residuals": 100},
                      intervals={"drift": {"lower": 0.5, "upper": 1.5}}),
                 case("single", "named", "damage", probability=0.95, gain={"baseline": 200, "extended": 190,
                                                                          "residuals": 100},
                      intervals={"drift": {"lower": 1.1, "upper": None}}),
                 case("null", "adequate", probability=0.6)]
        # |2 x 0.95 - 1| + |0.6 - 1| over three.
        self.assertAlmostEqual(calibration_error(cases)[0], (0.9 + 0.4) / 3)
        scores = scores_of(cases)
        self.assertAlmostEqual(scores["gain_fraction_snr8"], 200 / 300)
        self.assertEqual((scores["interval_coverage"], scores["intervals"]), (0.5, 2))
        with self.assertRaisesRegex(InputError, "known are adequate"):
            case("null", "guilty")


if __name__ == "__main__":
    unittest.main()
