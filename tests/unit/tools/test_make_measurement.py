# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/make_measurement: errors have the declared statistics, seeds reproduce, mistakes are explained, and no code is
shared with the solver or with what fits measurements.

usage: test_make_measurement.py <test_measurements> [tests]
"""
import ast
import json
import re
import subprocess
import sys
import tempfile
import unittest
from dataclasses import fields
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.bending.mesh import locate
from flusi_msm.bending.model import Stiffness
from flusi_msm.measurement.case import Case, Hidden, Protocol, read_case
from flusi_msm.measurement.grid import grid_lines
from flusi_msm.measurement.noise import HeightErrors, Noise, Streams
from flusi_msm.measurement.scan import scan
from flusi_msm.measurement.synthesis import Bench, synthesise
from flusi_msm.results.files import InputError
from flusi_msm.wing.file import read_wing

SOURCE = Path(__file__).resolve().parents[3]
TOOLS = SOURCE / "tools"

WING = SOURCE / "wings/calliphora_small.h5"
# One light load on the stiff front; everything that can go wrong does.
BUSY = {"wing": str(WING), "loads": [[0.00405, 0.00066, 1e-3]], "spacing": 2e-4, "stiffness": {"plate": "edges"},
        "protocol": {"levels": [1, -1], "random_order": True},
        "noise": {"height": 8e-6, "correlated": 6e-6, "tilt": 1e-3, "piston": 5e-6, "missing": 0.2, "outliers": 0.02,
                  "force": 1e-5, "force_gain": 0.02, "position": 5e-5, "shift": 1e-5, "reference_scans": 4},
        "declared": {"height": 12e-6}, "calibration": {"force_by_weight": 1, "order_is_random": 1},
        "hidden": {"force_gain": 1.1, "force_offset": 2e-5, "drift": 0.02}}


class WithFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def case(self, data, *changes):
        (self.folder / "case.json").write_text(json.dumps(data))
        return read_case(self.folder / "case.json", changes)

    def run_tool(self, *arguments, code=0):
        done = subprocess.run([sys.executable, "-B", TOOLS / "make_measurement", *arguments], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done


class Errors(unittest.TestCase):
    """Bounds are four standard errors of the estimates; the seeds are fixed."""
    x, y = np.arange(100) * 1e-4, np.arange(60) * 1e-4

    def maps(self, count, **noise):
        errors = HeightErrors(Noise(**noise), self.x, self.y, Streams(3))
        return np.array([errors.one_scan(k) for k in range(count)])

    def test_white(self):
        z = self.maps(20, height=7e-6)
        self.assertAlmostEqual(z.std() / 7e-6, 1, delta=4 / np.sqrt(2 * z.size))
        for other in (z[:, :, 1:] * z[:, :, :-1], z[:, 1:] * z[:, :-1], z[1:] * z[:-1]):
            self.assertAlmostEqual(other.mean() / 7e-6**2, 0, delta=4 / np.sqrt(other.size))

    def test_correlated(self):
        """Variance and correlation at distances in x, y and across. The maps hold about area/(2 pi l^2) independent
        values each."""
        length, n = 5e-4, 200
        z = self.maps(n, height=0.0, correlated=5e-6, correlation_length=length)
        independent = n * (self.x.size * self.y.size * 1e-8) / (2 * np.pi * length**2)
        delta = 4 / np.sqrt(independent)
        for dx, dy in ((0, 0), (3, 0), (0, 5), (5, 5), (10, 0), (0, 10)):
            pair = z[:, dy:, dx:] * z[:, :z.shape[1] - dy, :z.shape[2] - dx]
            want = np.exp(-0.5 * (dx**2 + dy**2) * 1e-8 / length**2)
            self.assertAlmostEqual(pair.mean() / 5e-6**2, want, delta=1.5 * delta, msg=(dx, dy))

    def test_reference(self):
        """The mean of scans is better by the root of their number and shares nothing with the loads' scans."""
        errors = HeightErrors(Noise(height=1e-5, reference_scans=9), self.x, self.y, Streams(3))
        z, other = errors.reference(), errors.one_scan(0)
        self.assertAlmostEqual(z.std() / (1e-5 / 3), 1, delta=4 / np.sqrt(2 * z.size))
        self.assertAlmostEqual((z * other).mean() / (1e-5**2 / 3), 0, delta=4 / np.sqrt(z.size))

    def test_outliers_and_missing(self):
        errors = HeightErrors(Noise(outliers=0.05, outlier_scale=1e-4, missing=0.25), self.x, self.y, Streams(5))
        hits = np.array([errors.outliers(k) for k in range(20)])
        share = (hits != 0).mean()
        self.assertAlmostEqual(share, 0.05, delta=4 * np.sqrt(0.05 / hits.size))
        # The median of |t| with 3 degrees of freedom is 0.7649; its standard error is about 1.3/sqrt(n).
        self.assertAlmostEqual(np.median(np.abs(hits[hits != 0])) / 1e-4, 0.7649,
                               delta=4 * 1.3 / np.sqrt((hits != 0).sum()))
        known = np.add.outer(self.y, self.x) < 1.2e-2
        for k in range(5):
            lost = (errors.missing(k, known) & known).sum() / known.sum()
            self.assertTrue(0.25 <= lost < 0.25 + np.pi * 5**2 / known.sum(), lost)  # one disc more at most

    def test_streams(self):
        """Errors of different kinds, scans and seeds have nothing to do with each other."""
        draws = [Streams(seed)(name, scan).standard_normal(4000) for seed in (1, 2) for name in ("height", "tilt")
                 for scan in (0, 1)]
        products = np.corrcoef(draws) - np.eye(len(draws))
        self.assertLess(np.abs(products).max(), 4.5 / np.sqrt(4000))

    def test_tilt(self):
        errors = HeightErrors(Noise(tilt=1e-3, piston=5e-6, shift=2e-5), self.x, self.y, Streams(6))
        n = 2000
        planes = [errors.plane(k) for k in range(n)]
        for values, sd in ((np.array([p[0] for p in planes]), 1e-3), (np.array([p[1] for p in planes]), 5e-6),
                           (np.array([errors.shift(k) for k in range(n)]), 2e-5)):
            self.assertAlmostEqual(values.std() / sd, 1, delta=4 / np.sqrt(2 * n))
            self.assertAlmostEqual(values.mean() / sd, 0, delta=4 / np.sqrt(n))


class Scans(unittest.TestCase):
    def test_plane(self):
        """A plane is seen exactly, everywhere on the wing and nowhere else."""
        wing = read_wing(WING)
        moved = wing.points + np.outer(wing.points[:, 0], [0, 0, 0.3]) + [1e-4, -2e-4, 1e-3]
        x, y = (grid_lines(moved[:, k].min(), moved[:, k].max(), 1.5e-4) for k in range(2))
        z = scan(moved, wing.triangles, x, y)
        want = np.broadcast_to(1e-3 + 0.3 * (x - 1e-4), z.shape)
        seen = np.isfinite(z)
        self.assertLess(np.abs(z - want)[seen].max(), 1e-16)
        for j, i in np.ndindex(z.shape):
            try:
                locate(wing.points, wing.triangles, (x[i] - 1e-4, y[j] + 2e-4))
                self.assertTrue(seen[j, i])
            except Exception as error:
                self.assertIn("not on the wing", str(error))
                self.assertFalse(seen[j, i])
        self.assertAlmostEqual(seen.sum() * 1.5e-4**2 / wing.areas().sum(), 1, delta=0.02)

    def test_upper_sheet(self):
        corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1.0]])
        for order in ([[0, 1, 2], [3, 5, 4]], [[3, 4, 5], [0, 2, 1]]):
            z = scan(corners, np.array(order), np.array([0.2, 0.9]), np.array([0.3, 0.9]))
            np.testing.assert_array_equal(z, [[1, np.nan], [np.nan, np.nan]])


class Experiments(WithFolder):
    def test_truth(self):
        """The truth holds what was done: forces, places, drift; the file states what was intended."""
        content, truth = synthesise(self.case(BUSY))
        gains = []
        for stated, true in zip(content["loads"], truth["loads"]):
            self.assertEqual(stated["force"], 1e-3)
            np.testing.assert_array_equal(stated["point"], [0.00405, 0.00066])
            self.assertGreater(np.linalg.norm(np.subtract(true["point"], stated["point"])), 1e-6)
            gains.append(np.linalg.norm(true["force"]) / 1e-3)
            self.assertAlmostEqual(true["stiffness_factor"], 1 + 0.02 * (true["order"] - 1), delta=1e-12)
            self.assertGreater(np.dot(true["force"], stated["direction"]), 0)
            self.assertTrue(0.2 <= true["missing"] < 0.35, true["missing"])
            self.assertEqual(true["snaps"], 0)
        self.assertAlmostEqual(np.mean(gains), 1.12, delta=4 * 0.025)
        self.assertEqual(sorted(t["order"] for t in truth["loads"]), [1, 2])
        self.assertEqual(content["accuracy"]["height"], 12e-6)
        self.assertEqual(content["accuracy"]["tilt"], 1e-3)

    def test_exact_heights(self):
        """Without errors and with the true place, heights are those of the bent wing; the force offset and the gain
        act as a force of that size would; the drift as the softer wing would."""
        quiet = {"height": 0.0}
        base = {**BUSY, "noise": quiet, "hidden": {}, "protocol": {}, "declared": {"height": 1e-6}}
        plain, truth = synthesise(self.case(base))
        bench = Bench(self.case(base))
        shape = bench.bend(bench.loads()[0])
        np.testing.assert_array_equal(plain["loads"][0]["z"], scan(shape[0], bench.wing.triangles, plain["x"],
                                                                   plain["y"]))
        more, _ = synthesise(self.case({**base, "loads": [[0.00405, 0.00066, 1.2e-3]]}))
        gained, _ = synthesise(self.case({**base, "hidden": {"force_gain": 1.1, "force_offset": 1e-4}}))
        self.assertLess(np.nanmax(np.abs(more["loads"][0]["z"] - gained["loads"][0]["z"])), 1e-12)
        s = Bench(self.case({**base, "stiffness": {"joints": {"C_Sc": 1e-6}}})).model(0.9, 0.5).stiffness
        np.testing.assert_allclose([s.D, s.E, s.joints["C_Sc"]], [0.9 * 2e-7, 0.45 * 12.58e9, 0.9e-6], rtol=1e-14)
        # Softer by 1 - 0.1: the change against the straight ratio is that of the springs, far below a per cent.
        soft, _ = synthesise(self.case({**base, "hidden": {"creep": [0.1 / 0.9, 10 / 9]}}))  # 1 + a log10(10)
        less, _ = synthesise(self.case({**base, "loads": [[0.00405, 0.00066, 1e-3 / 0.9]]}))
        ratio = np.nanmax(soft["loads"][0]["z"]) / np.nanmax(less["loads"][0]["z"])
        self.assertAlmostEqual(ratio, 1, delta=2e-3)
        self.assertGreater(np.nanmax(soft["loads"][0]["z"]) / np.nanmax(plain["loads"][0]["z"]), 1.05)

    def test_memory(self):
        """What is left of the deformation before is left of all points of the wing, also where the scan before did not
        see any: the change of the heights is as smooth as the shape. A load that turns the tip by 20 degrees draws it back
        from the grid points at the edge; the next one is light."""
        base = {**BUSY, "noise": {"height": 0.0}, "hidden": {}, "declared": {"height": 1e-6},
                "loads": [[0.00856, -0.00078, 3e-4]], "protocol": {"levels": [1, 0.01]}}
        plain, _ = synthesise(self.case(base))
        marked, _ = synthesise(self.case({**base, "hidden": {"memory": 0.02}}))
        np.testing.assert_array_equal(marked["loads"][0]["z"], plain["loads"][0]["z"])
        strong, light = (load["z"] for load in plain["loads"])
        change = marked["loads"][1]["z"] - light
        unseen = np.isfinite(change) & ~np.isfinite(strong)
        self.assertGreater(unseen.sum(), 3)
        left = 0.02 * (strong - plain["z"])
        # At the tip heights beside each other differ by 20 degrees x 0.2 mm x 0.02 = 1.5 um; that many may differ here too.
        seen = np.isfinite(change) & np.isfinite(left)
        self.assertGreater(np.abs(left[seen]).max(), 1.5e-5)
        self.assertLess(np.abs(change - left)[seen].max(), 3e-6)
        for j, i in np.argwhere(unseen):
            near = left[max(0, j - 1):j + 2, max(0, i - 1):i + 2]
            near = near[np.isfinite(near)]
            if len(near):
                self.assertLess(abs(change[j, i] - near.mean()), 3e-6)

    def test_camber(self):
        """The unloaded wing is scanned with its camber: z0 at the grid points up to the error of straight triangles,
        h^2/8 times its curvature."""
        content, _ = synthesise(self.case({**BUSY, "noise": {"height": 0.0}, "hidden": {}, "protocol": {},
                                           "declared": {"height": 1e-6}, "stiffness": {"camber": [2e-4, 0, 0]}}))
        wing = read_wing(WING)
        low, chord = wing.points[:, 1].min(), np.ptp(wing.points[:, 1])
        y = (content["y"] - low) / chord
        want = np.broadcast_to((2e-4 * 4 * y * (1 - y))[:, None], content["z"].shape)
        seen = np.isfinite(content["z"])
        self.assertGreater(seen.sum(), 400)
        longest = np.linalg.norm(np.diff(wing.points[wing.edges()[0]], axis=1), axis=2).max()
        self.assertLess(np.abs(content["z"] - want)[seen].max(), longest**2 / 8 * 8 * 2e-4 / chord**2)

    def test_soft_place(self):
        """A hidden hinge in a vein softens; its stiffness on the wing file's mesh is told."""
        base = {**BUSY, "noise": {}, "hidden": {"soft_places": [["C", 0.3, 2e-6]]}, "protocol": {}}
        _, soft = synthesise(self.case(base))
        _, plain = synthesise(self.case({**base, "hidden": {}}))
        self.assertGreater(soft["loads"][0]["moved"], 1.02 * plain["loads"][0]["moved"])
        self.assertEqual(soft["joints"]["soft1"], {"stiffness": 2e-6, "on_wing_file": 2e-6})
        fine = Bench(self.case(base, "refine=1"))
        self.assertEqual(len(fine.wing.triangles), 4 * 348)

    def test_reproducible(self):
        """The same case gives the same bytes, another seed other errors; errors of one kind do not depend on others."""
        (self.folder / "case.json").write_text(json.dumps(BUSY))
        for name, arguments in (("a", ()), ("b", ("--jobs", "2")), ("c", ("--seed", "2")),
                                ("d", ("--set", "noise.outliers=0", "--set", "noise.missing=0"))):
            self.run_tool("case.json", "-o", f"{name}.h5", "--quiet", *arguments)
        self.assertEqual((self.folder / "a.h5").read_bytes(), (self.folder / "b.h5").read_bytes())
        self.assertEqual((self.folder / "a.truth.json").read_text(), (self.folder / "b.truth.json").read_text())
        heights = {}
        for name in "acd":
            with h5py.File(self.folder / f"{name}.h5") as file:
                self.assertEqual(bytes(file.attrs["schema"]), b"flusi-msm measurement")
                self.assertEqual(file["accuracy"].attrs["height"], 12e-6)
                self.assertEqual(file["reference/sigma"][0, 0], 6e-6)
                self.assertEqual(file["calibration"].attrs["force_by_weight"], 1)
                heights[name] = file["loads/P01_L2/z"][:]
                self.assertEqual(file["reference/z"].shape, (file["reference/y"].size, file["reference/x"].size))
                self.assertEqual(list(file["loads/P01_L2"].attrs["direction"]), [0, 0, -1])
        if READER:  # that of what fits measurements
            done = subprocess.run([READER, WING, *[self.folder / f"{name}.h5" for name in "acd"]], capture_output=True,
                                  text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(done.stdout.count("P01_L2:  1.0000E-03 N at  4.0500E-03  6.6000E-04 m"), 3, done.stdout)
        known = np.isfinite(heights["a"])
        same = heights["a"][known] == heights["d"][known]
        self.assertAlmostEqual(1 - same.mean(), 0.02, delta=4 * np.sqrt(0.02 / known.sum()))
        self.assertGreater(np.nanmax(np.abs(heights["a"] - heights["c"])), 1e-6)

    def test_plan(self):
        """A plan states what the experiment states, and has nothing that is measured, and no truth."""
        (self.folder / "case.json").write_text(json.dumps(BUSY))
        self.run_tool("case.json", "-o", "done.h5", "--quiet")
        self.assertEqual(self.run_tool("case.json", "-o", "plan.h5", "--plan").stdout, "plan.h5\n")
        self.assertFalse((self.folder / "plan.truth.json").exists())
        found = {}
        for name in "done", "plan":
            with h5py.File(self.folder / f"{name}.h5") as file:
                found[name] = {}
                file.visititems(lambda place, item: found[name].update({place: (
                    item[()].tolist() if isinstance(item, h5py.Dataset) else None,
                    {key: np.asarray(value).tolist() for key, value in item.attrs.items()})}))
        measured = {"reference/z", "loads/P01_L1/z", "loads/P01_L2/z"}
        self.assertLessEqual(measured, set(found["done"]))
        self.assertEqual({place: item for place, item in found["done"].items() if place not in measured}, found["plan"])

    def test_mistakes(self):
        """A mistake is told in a sentence, with the key."""
        def refused(pattern, data, *changes):
            with self.assertRaisesRegex(InputError, pattern):
                synthesise(self.case(data, *changes))

        refused("noise.hight: unknown; did you mean height", BUSY, "noise.hight=1")
        refused(r"(?s)^--set noise.hight: unknown; did you mean height\?\n\S+\.json: loadz: unknown.*\n--set seed = 'x': must",
                {**BUSY, "loadz": []}, "noise.hight=1", "seed=x")
        refused("^--set noise: write key=value", BUSY, "noise")
        refused("noise.height = '10um': must be a number, in SI units and without a unit", BUSY, "noise.height=10um")
        refused("seed = 'x': must be a whole number", BUSY, "seed=x")
        refused("wing: required", {"loads": [[0, 0, 1]]})
        refused("load P01.*not on the wing", BUSY, "loads=[[0.02, 0, 1e-3]]")
        refused("no joint X", BUSY, 'stiffness.joints={"X": 1}')
        refused("load 1: needs x, y", BUSY, "loads=[[0.005, 0]]")
        refused("noise.missing", BUSY, "noise.missing=2")
        refused("declared.hight: unknown", BUSY, "declared.hight=1")
        refused("sd of the heights", {**BUSY, "declared": {}}, "noise.height=0", "noise.correlated=0")
        refused("noise: must be a section", BUSY, "noise=3")
        refused("stiffness.damage.*no number", BUSY, 'stiffness.damage=["x", 0, 0, 1]')
        refused("protocol.levels.*no number", BUSY, 'protocol.levels=["x"]')
        refused("stiffness.joints.*no number", BUSY, 'stiffness.joints={"C_Sc": "soft"}')
        refused("none.h5: not a readable wing", BUSY, 'wing="none.h5"')
        (self.folder / "broken.json").write_text("{")
        done = self.run_tool("broken.json", "-o", "m.h5", code=2)
        self.assertRegex(done.stderr, "^make_measurement: broken.json: not JSON.*\n$")
        done = self.run_tool("broken.json", "-o", "gone/m.h5", code=2)
        self.assertEqual(done.stderr, "make_measurement: gone/m.h5: cannot be written: there is no folder gone\n")
        self.assertFalse((self.folder / "m.h5").exists())


class Documentation(WithFolder):
    text = (SOURCE / "docs/guide/synthetic-measurements.md").read_text()

    def test_example(self):
        data = json.loads(re.search("```json\n(.*?)```", self.text, re.S).group(1))
        data["wing"] = str(WING)
        case = self.case(data)
        self.assertEqual(len(Bench(case).loads()), 15)

    def test_keys(self):
        """Every key is named."""
        for kind in (Case, Stiffness, Protocol, Noise, Hidden):
            for item in fields(kind):
                self.assertIn(f"`{item.name}`", self.text.replace("` ", "` ").replace("**", ""), item.name)


def imported(text):
    """Dotted names of what a module imports; `from a import b` counts as a.b."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


class Independence(unittest.TestCase):
    def test_imports(self):
        """The generator imports its own modules, the reader of wing files, the choice of a Python and public libraries;
        nothing it runs is the solver, and nothing of the fitter imports it."""
        package = TOOLS / "flusi_msm"
        own = {f"flusi_msm.{folder}.{path.stem}" for folder in ("bending", "flow2d", "measurement") for path in (package / folder).glob("*.py")}
        own |= {f"flusi_msm.blind.{name}" for name in (
            "batch", "cases", "effects", "flight_effects", "flight_study", "flights", "generate", "joint", "ledger", "oracle", "strata", "study", "vibration",
            "vibration_effects", "vibration_oracle", "vibration_subject")}
        own -= {f"flusi_msm.{folder}.__init__" for folder in ("bending", "flow2d", "measurement")}
        libraries = {"numpy", "scipy", "h5py"} | set(getattr(sys, "stdlib_module_names", ()))
        allowed = own | {f"flusi_msm.{name}" for name in ("errors", "one_thread", "project_python", "results.files", "seal", "wing.file")}
        self.assertGreater(len(own), 15)
        for name in own:
            path = TOOLS / (name.replace(".", "/") + ".py")
            text = path.read_text()
            for module in imported(text):
                if module.split(".")[0] == "flusi_msm":
                    self.assertTrue(module in allowed or module.rpartition(".")[0] in allowed, f"{path}: {module}")
                elif hasattr(sys, "stdlib_module_names"):
                    self.assertIn(module.split(".")[0], libraries, path)
                self.assertNotIn(module.split(".")[0], {"subprocess", "ctypes", "f2py", "importlib"}, path)
            self.assertNotRegex(text, r"msm_train|os\.system|popen", path)
        mechanics = {name for name in own if ".bending." in name} | {"flusi_msm.blind.cases", "flusi_msm.blind.oracle"} \
            | {f"flusi_msm.measurement.{name}" for name in ("noise", "scan", "synthesis")}
        flies = {"flusi_msm.paper.ensemble"}  # draws stiffness for flights and fits nothing
        for path in package.rglob("*.py"):
            if ".".join(path.relative_to(TOOLS).with_suffix("").parts) not in own | flies:
                taken = {name for module in imported(path.read_text()) for name in (module, module.rpartition(".")[0])}
                self.assertFalse(taken & mechanics, path)
        for path in (SOURCE / "src").rglob("*.f90"):
            self.assertFalse(re.search("make_measurement|bending/model|blind_generate|sealed/", path.read_text()), path)


if __name__ == "__main__":
    READER = str(Path(sys.argv.pop(1)).resolve()) if sys.argv[1:] and Path(sys.argv[1]).is_file() else ""
    unittest.main()
