# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of natural modes and of motion become measurement files that the programs accept; what cannot be one is refused with the
file, the line, the column and what is valid.

usage: test_import_vibration.py [reader of measurement files] [msm_diagnose]
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.seal import check_seal
from synthetic import SOURCE, run_tool

PROGRAMS = [str(Path(sys.argv.pop(1)).resolve()) for _ in sys.argv[1:3] if Path(sys.argv[1]).is_file()]
WING = SOURCE / "wings/calliphora_small.h5"
INPUT = f"[Wing]\nfile = {WING};\n[Measurement]\nfile = out.h5;\n[Diagnose]\nparameters = E;\nrefine = no;\nnoise = declared;\n"


class Import(unittest.TestCase):
    tool = ""
    table = ""       # the first argument

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def run_import(self, *options, code=0):
        """Runs the tool. In options, names of files of the test are those that end in .csv."""
        words = [self.folder / word if str(word).endswith(".csv") else word for word in options]
        run = run_tool(self.tool, self.folder / self.table, "-o", self.folder / "out.h5", *words)
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        return run.stdout if code == 0 else run.stderr

    def read(self, group):
        """Returns what the file holds, after the programs accepted it."""
        path = self.folder / "out.h5"
        self.assertTrue(check_seal(path))
        if PROGRAMS:
            done = subprocess.run([PROGRAMS[0], WING, path], capture_output=True, text=True)
            self.assertIn("out.h5 is accepted", done.stdout)
        if len(PROGRAMS) > 1:
            (self.folder / "case.ini").write_text(INPUT)
            done = subprocess.run([PROGRAMS[1], "case.ini", "--check"], cwd=self.folder, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with h5py.File(path) as file:
            held = file[group]
            return {**{k: v[()] for k, v in held.items()}, **dict(held.attrs)}

    def refuse(self, words, *options):
        """Asserts that the tool says all of `words`, and leaves no file."""
        said = self.run_import(*options, code=2)
        for word in words:
            self.assertIn(word, said)
        self.assertFalse((self.folder / "out.h5").exists())


class Modes(Import):
    tool, table = "import_modes", "modes.csv"
    BASE = ("--frequency-units", "Hz", "--frequencies", "undamped", "--medium", "air")
    SHAPES = ("--shapes", "shapes.csv", "--length-units", "mm")
    GOOD = "name,frequency,frequency_sd\nfirst,152,1.5\nsecond,300,3\n"
    PLACES = "mode,x,y,shape,sd\nfirst,3,0,0.11,0.02\nfirst,5,0.2,0.35,0.02\nfirst,8,-0.5,1,0.02\nsecond,5,0,1,0.1\nsecond,8,-0.5,-1,0.1\n"

    def refuse_modes(self, table, words, *options, base=BASE):
        self.write("modes.csv", table)
        self.refuse(words, *base, *options)

    def refuse_shapes(self, shapes, words, *options):
        self.write("shapes.csv", shapes)
        self.refuse_modes(self.GOOD, words, *(options or self.SHAPES))

    def test_shapes(self):
        self.write("modes.csv", self.GOOD)
        self.write("shapes.csv", self.PLACES)
        self.run_import(*self.BASE, *self.SHAPES, "--air-density", 1.1, "--wing", WING)
        found = self.read("modes/first")
        self.assertEqual((found["frequency"], found["frequency_sigma"], found["medium"]), (152.0, 1.5, b"air"))
        np.testing.assert_allclose(found["points"], 1e-3 * np.array([[3, 0], [5, 0.2], [8, -0.5]]), rtol=1e-14)
        np.testing.assert_array_equal(found["shape"], [0.11, 0.35, 1])
        np.testing.assert_array_equal(found["sigma"], 3 * [0.02])
        self.assertNotIn("damping", found)
        with h5py.File(self.folder / "out.h5") as file:
            self.assertEqual(file["modes"].attrs["air_density"], 1.1)

    def test_damped(self):
        """A ring-down has the frequency f sqrt(1 - d^2). The errors of f and d are independent; those of d count d/(1 - d^2)^1.5. Decimal
        commas, kHz, percent, media in a column, modes that have numbers in the place of shapes."""
        self.write("modes.csv", "name;frequency;frequency_sd;damping;damping_sd;number;medium\na;0,152;0,0015;20;4;1;air\n"
                                "b;0,3;0,001;5;1;2;air\nc;0,16;0,001;1;0,5;1;vacuum\n")
        out = self.run_import("--frequency-units", "kHz", "--frequencies", "damped", "--damping-units", "percent")
        self.assertIn("decimal comma", out)
        found, rest = self.read("modes/a"), 1 - 0.2**2
        self.assertAlmostEqual(found["frequency"], 152 / np.sqrt(rest), places=10)
        self.assertAlmostEqual(found["frequency_sigma"], np.hypot(1.5 / np.sqrt(rest), 152 * 0.2 * 0.04 / rest**1.5), places=10)
        self.assertAlmostEqual(found["damping"], 0.2, places=14)
        self.assertAlmostEqual(found["damping_sigma"], 0.04, places=14)
        self.assertEqual((found["number"], self.read("modes/c")["medium"]), (1, b"vacuum"))

    def test_radians(self):
        self.write("modes.csv", "name,frequency,frequency_sd,number\na,1000,10,1\n")
        self.run_import("--frequency-units", "rad/s", "--frequencies", "undamped", "--medium", "vacuum")
        self.assertAlmostEqual(self.read("modes/a")["frequency"], 500 / np.pi, places=10)

    def test_added(self):
        self.write("modes.csv", "name,frequency,frequency_sd,number\na,152,1,1\n")
        self.run_import(*self.BASE)
        self.write("modes.csv", "name,frequency,frequency_sd,number\nb,180,1,1\n")
        said = self.run_import(*self.BASE, "--add", code=2)
        self.assertIn("mode a has the number 1 in air already", said)
        self.run_import(*self.BASE[:-1], "vacuum", "--add")
        self.assertEqual((self.read("modes/a")["frequency"], self.read("modes/b")["frequency"]), (152, 180))
        self.assertIn("has a mode b already", self.run_import(*self.BASE[:-1], "vacuum", "--add", code=2))
        self.write("modes.csv", "name,frequency,frequency_sd,number\nc,180,1,2\n")
        self.assertIn("has 1.2 kg/m^3", self.run_import(*self.BASE, "--add", "--air-density", 1.0, code=2))

    def test_gravity(self):
        """Modes about the shape under the weight have numbers of their own."""
        self.write("modes.csv", "name,frequency,frequency_sd,number\na,152,1,1\n")
        self.run_import(*self.BASE)
        self.write("modes.csv", "name,frequency,frequency_sd,number\nb,153,1,1\n")
        self.run_import(*self.BASE, "--gravity", 0, 0, -9.81, "--add")
        np.testing.assert_array_equal(self.read("modes/b")["gravity"], [0, 0, -9.81])
        self.assertNotIn("gravity", self.read("modes/a"))
        self.write("modes.csv", "name,frequency,frequency_sd,number\nc,153,1,1\n")
        self.assertIn("mode b has the number 1", self.run_import(*self.BASE, "--gravity", 0, 0, -9.81, "--add", code=2))
        self.assertIn("--gravity: is out of range", self.run_import(*self.BASE, "--gravity", 0, 0, 0, code=2))

    def test_refused_options(self):
        """No unit, kind of frequency or medium has a default."""
        self.write("modes.csv", self.GOOD)
        self.refuse(["--frequency-units", "--frequencies"])
        self.refuse_modes("name,frequency,frequency_sd,damping,damping_sd,number\na,1,0.1,0.1,0.1,1\n",
                          ["--damping-units: required", "one of ratio, percent"], base=self.BASE)
        self.refuse_modes("name,frequency,frequency_sd,number\na,1,0.1,1\n", ["--medium: state it here or in a column", "one of air, vacuum"],
                          base=self.BASE[:-2])
        self.refuse_modes("name,frequency,frequency_sd,number,medium\na,1,0.1,1,air\n", ["--medium: state it either"])
        self.refuse_modes("name,frequency,frequency_sd,number\na,1,0.1,1\n", ["--air-density: is out of range"], "--air-density", 0)
        self.refuse_shapes(self.PLACES, ["--length-units: required", "one of m, mm, um"], "--shapes", "shapes.csv")

    def test_refused_columns(self):
        self.refuse_modes("name,frequenzy,frequency_sd\na,1,1\n", ["modes.csv:1: unknown column 'frequenzy'; did you mean frequency?",
                                                                   "modes.csv:1: has no column frequency;"])
        self.refuse_modes("name,frequency,frequency,frequency_sd\na,1,1,1\n", ["two columns are called 'frequency'"])
        self.refuse_modes("name,frequency,frequency_sd\na,1,1,5,6\n", ["modes.csv:2: has 5 cells, the first line 3"])
        self.refuse_modes("name,frequency,frequency_sd\n", ["has no line below"])
        self.refuse_shapes("mode,x,y,value,sd\nfirst,3,0,1,1\n", ["shapes.csv:1: unknown column 'value'", "has no column shape"])

    def test_refused_cells(self):
        """All mistakes at once, each with its line and column; comments count as lines."""
        self.refuse_modes("# of a blowfly\nname,frequency,frequency_sd,number\na b,-3,1,1\nb,fast,1,2.5\nc,,1,3\nd,10,11,4\nd,10,0,1001\n"
                          "f,inf,1,4\n",
                          ["modes.csv:3: column name is 'a b'; 1 to 64 letters", "modes.csv:3: column frequency is -3; valid: above 0",
                           "modes.csv:4: column frequency is 'fast', not a number", "modes.csv:4: column number is 2.5; a whole",
                           "modes.csv:5: column frequency is empty", "modes.csv:6: column frequency_sd is more than the frequency",
                           "modes.csv:7: column name is d, as in line 6", "modes.csv:7: column frequency_sd is 0; valid: above 0",
                           "modes.csv:7: column number is 1001; valid: at least 1, at most 1000", "modes.csv:8: column frequency is infinite",
                           "modes.csv:8: column number is 4, as in line 6"])
        self.refuse_modes("name,frequency,frequency_sd,number,medium\na,1,0.1,1,water\n", ["column medium is 'water'; valid: air, vacuum"],
                          base=self.BASE[:-2])

    def test_refused_damping(self):
        ratio, damped = ("--damping-units", "ratio"), ("--frequency-units", "Hz", "--frequencies", "damped", "--medium", "air")
        head = "name,frequency,frequency_sd,number,damping,damping_sd\n"
        self.refuse_modes(head + "a,9,1,1,5,1\nb,9,1,2,0.1,\nc,9,1,3,,0.1\n",
                          ["modes.csv:2: column damping is 5; valid: at least 0, at most 1", "modes.csv:3: column damping_sd is empty",
                           "modes.csv:4: column damping is empty, but damping_sd is not"], *ratio)
        self.refuse_modes("name,frequency,frequency_sd,number,damping\na,9,1,1,0.1\n", ["modes.csv:2: has no column damping_sd"], *ratio)
        self.refuse_modes(head + "a,9,1,1,1,0.1\nb,9,1,2,,\n", ["modes.csv:2: column damping is 1 or more", "modes.csv:3: --frequencies damped"],
                          *ratio, base=damped)

    def test_refused_shapes(self):
        self.refuse_modes(self.GOOD, ["modes.csv:2: mode first cannot be recognised", "modes.csv:3: mode second"])
        self.refuse_shapes(self.PLACES + "third,3,0,1,1\n", ["shapes.csv:7: column mode is 'third'; the modes of", "are first, second"])
        self.refuse_shapes("mode,x,y,shape,sd\nfirst,3,0,1,0\nfirst,3,,1,1\nsecond,3,0,0,1\nsecond,4,0,0,1\n",
                           ["shapes.csv:2: column sd is 0; valid: above 0", "shapes.csv:3: column y is empty",
                            "modes.csv:3: mode second has a shape that is 0 everywhere"])
        self.refuse_shapes("mode,x,y,shape,sd\nfirst,3,0,1,1\n", ["mode first has a shape of one place"])
        self.refuse_shapes(self.PLACES, ["shapes.csv:2: columns x, y: (3, 0) m is not on the wing", "is --length-units right?"],
                           "--shapes", "shapes.csv", "--length-units", "m", "--wing", WING)


class Series(Import):
    tool, table = "import_series", "record.csv"
    BASE = ("--points", "points.csv", "--length-units", "mm", "--time-units", "ms", "--medium", "air", "--axis", 0, 0, 1)
    RELEASE = ("--units", "um", "--excitation", "release", "--direction", 0, 0, 2, "--point", 8, -0.5, "--size", 10, "--size-sd", 1,
               "--size-units", "uN", "--zero", 2.0, "--trigger-sd", 0.02)
    SHAKE = ("--units", "mm/s", "--excitation", "base", "--direction", 0, 0, 1, "--base-units", "g")
    POINTS = "name,x,y,sd\nTip,8,-0.5,0.5\nmid,5,-0.5,0.4\n"
    TIME = np.arange(0, 50, 0.25)

    def setUp(self):
        super().setUp()
        self.write("points.csv", self.POINTS)
        self.ring(self.TIME)

    def ring(self, time, head="time,Tip,mid", more=""):
        late = np.maximum(time - 2, 0)
        swing = 50 * np.exp(-0.04 * late) * np.cos(2 * np.pi * 0.15 * late)
        rows = [f"{t:.6g},{v:.6g},{'' if k == 20 else f'{0.4 * v:.6g}'}{more}" for k, (t, v) in enumerate(zip(time, swing))]
        self.write("record.csv", "\n".join([head, *rows]) + "\n")

    def refuse_series(self, words, *options, base=BASE + RELEASE, filtered=("--lowpass", "none")):
        self.refuse(words, *base, *filtered, *options)

    def test_release(self):
        """Samples before the release are left out; time counts from there."""
        out = self.run_import(*self.BASE, *self.RELEASE, "--lowpass", 2000, "--order", 2, "--until", 42.1, "--wing", WING)
        self.assertIn("161 of 200 samples at 4000 Hz", out)
        line = float(out.split("strongest line at ")[1].split()[0])  # 150 Hz, in a window of 6 periods
        self.assertAlmostEqual(line, 150, delta=5)
        found = self.read("series/ring")
        facts = {key: found[key] for key in ("excitation", "medium", "units", "order")}
        self.assertEqual(facts, {"excitation": b"release", "medium": b"air", "units": b"m", "order": 2})
        for key, value in dict(size=1e-5, size_sigma=1e-6, rate=4000, start=0, trigger_sigma=2e-5, lowpass=2000, point=[8e-3, -5e-4],
                               sigma=[5e-7, 4e-7], points=[[8e-3, -5e-4], [5e-3, -5e-4]], direction=[0, 0, 2], axis=[0, 0, 1]).items():
            np.testing.assert_allclose(found[key], value, rtol=1e-12, atol=1e-15, err_msg=key)
        late = self.TIME[8:169] - 2
        np.testing.assert_allclose(found["values"][:, 0], 5e-5 * np.exp(-0.04 * late) * np.cos(0.3 * np.pi * late), atol=1e-10)
        self.assertTrue(np.isnan(found["values"][12, 1]) and np.isfinite(found["values"][:, 0]).all())

    def test_between_samples(self):
        """A release between two samples, and every second sample: the record begins with the first one after it."""
        options = [2.1 if word == 2.0 else word for word in self.RELEASE]
        self.run_import(*self.BASE, *options, "--lowpass", "none", "--every", 2)
        found = self.read("series/ring")
        self.assertAlmostEqual(found["start"], 1.5e-4, places=12)
        self.assertAlmostEqual(found["rate"], 2000, places=7)
        self.assertNotIn("lowpass", found)

    def test_tap(self):
        options = ("--units", "mm/s", "--excitation", "tap", "--direction", 0, 0, -1, "--point", 8, -0.5, "--size", 10, "--size-sd", 1,
                   "--size-units", "nNs", "--zero", 0, "--trigger-sd", 0)
        self.run_import(*self.BASE, *options, "--lowpass", "none")
        found = self.read("series/ring")
        self.assertEqual((found["excitation"], found["units"]), (b"tap", b"m/s"))
        np.testing.assert_allclose([found["size"], found["values"][0, 0]], [1e-8, 0.05], rtol=1e-12)

    def test_base(self):
        self.ring(self.TIME, "time,Tip,mid,base", ",0.5")
        self.run_import(*self.BASE, *self.SHAKE, "--lowpass", "none")
        found = self.read("series/ring")
        np.testing.assert_allclose(found["base"], np.full(200, 0.5 * 9.80665))
        self.assertNotIn("start", found)
        self.assertIn("has a record ring already", self.run_import(*self.BASE, *self.SHAKE, "--lowpass", "none", "--add", code=2))
        self.run_import(*self.BASE, *self.SHAKE, "--lowpass", "none", "--add", "--name", "again")
        np.testing.assert_array_equal(self.read("series/again")["base"], found["base"])

    def test_refused_excitation(self):
        self.refuse_series([f"--{key}: required with --excitation tap" for key in ("point", "size", "size-sd", "zero", "trigger-sd")]
                           + ["--size-units: required with --excitation tap; one of Ns, mNs, uNs, nNs"],
                           base=self.BASE + ("--units", "um", "--excitation", "tap", "--direction", 0, 0, 1))
        self.refuse_series(["--size-units uN: --excitation tap has an impulse; valid: Ns"], "--excitation", "tap")
        self.refuse_series(["--size: is -1; valid: above 0", "--size-sd: is -2", "--trigger-sd: is -3"], "--size", -1, "--size-sd", -2,
                           "--trigger-sd", -3)
        self.refuse_series(["--point: not with --excitation base", "--zero: not with", "--base-units: required", "one of m/s2, mm/s2, g"],
                           "--excitation", "base")
        self.refuse_series(["--base-units: only with --excitation base"], "--base-units", "g")
        self.refuse_series(["--direction: must be a vector", "--axis: must be a vector"], "--direction", 0, 0, 0, "--axis", 0, 0, 0)
        self.refuse_series(["invalid choice: 'pluck'"], "--excitation", "pluck")

    def test_refused_options(self):
        self.refuse_series(["--lowpass"], filtered=())
        self.refuse_series(["--order: required with --lowpass"], filtered=("--lowpass", 2000))
        self.refuse_series(["--order: not with --lowpass none"], "--order", 1)
        self.refuse_series(["--lowpass: is 'no'"], filtered=("--lowpass", "no"))
        self.refuse_series(["--lowpass: is '0'"], filtered=("--lowpass", "0"))
        self.refuse_series(["--every: is out of range", "--name: is 'a b'", "--air-density: is out of range"], "--every", 0, "--name", "a b",
                           "--air-density", -1)
        self.refuse_series(["at least 2 make a record"], "--until", 2.1)
        self.refuse_series(["--units", "--medium", "--time-units", "--axis"], base=("--points", "points.csv", "--length-units", "mm"))

    def test_refused_points(self):
        self.write("points.csv", "name,x,y,sd\ntip,8,-0.5,0\nmid,8,,0.1\nMid,8,0,1\n")
        self.refuse_series(["points.csv:2: column sd is 0; valid: above 0", "points.csv:3: column y is empty", "points.csv:4: column name is 'mid'"])
        self.write("points.csv", "name,x,y,sd\ntip,8,-0.5,1\n")
        self.refuse_series(["record.csv:1: unknown column 'mid'"])
        self.write("points.csv", self.POINTS + "root,1,0,1\n")
        self.refuse_series(["record.csv:1: has no column root"])
        self.write("points.csv", self.POINTS)
        self.refuse_series(["points.csv:2: columns x, y: (8, -0.5) m is not on the wing", "is --length-units right?", "--point: (8, -0.5) m"],
                           "--length-units", "m", "--wing", WING)

    def test_refused_times(self):
        self.ring(np.delete(self.TIME, 50))
        self.refuse_series(["record.csv:52: column time: times must be at equal steps: this one is 0.5 after", "most are 0.25"])
        back = self.TIME.copy()
        back[50] = back[48]
        self.ring(back)
        self.refuse_series(["record.csv:52: column time: times must increase"])
        self.write("record.csv", "time,tip,mid\n0,1,1\n,1,1\n2,x,1\n")
        self.refuse_series(["record.csv:3: column time is empty", "record.csv:4: column tip is 'x', not a number"])
        self.write("record.csv", "time,tip,mid\n3,1,1\n")
        self.refuse_series(["has one sample"])

    def test_refused_values(self):
        self.ring(self.TIME, "time,Tip,mid,base", ",0")
        self.refuse_series(["column base: only valid with --excitation base"])
        self.ring(self.TIME)
        self.refuse_series(["record.csv:1: has no column base"], base=self.BASE + self.SHAKE)
        self.write("record.csv", "time,tip,mid,base\n0,1,1,0\n1,1,1,\n")
        self.refuse_series(["record.csv:3: column base is empty"], base=self.BASE + self.SHAKE)
        self.write("record.csv", "time,tip,mid\n0,1,9\n1,1,8\n2,1,\n3,inf,\n4,1,\n")
        self.refuse_series(["record.csv:5: column tip is infinite"])
        self.write("record.csv", "time,tip,mid\n0,1,9\n1,1,8\n2,1,\n3,2,\n4,1,\n")
        self.refuse_series(["record.csv: column mid: has no number after --zero"])
        self.write("record.csv", "time,tip,mid\n" + "\n".join(f"{k},1,2" for k in range(10003)) + "\n")
        self.refuse_series(["would hold 20002 numbers of records; at most 20000"])


if __name__ == "__main__":
    unittest.main()
