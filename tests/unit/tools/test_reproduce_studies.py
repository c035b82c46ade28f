# SPDX-License-Identifier: GPL-3.0-or-later
"""The ensemble of stiffnesses and the scan of the kinematics of tools/reproduce_paper: what their flights are, and tables, sentences
and pages of stored series whose means are known; no flights, but for a few steps that show what a drawn joint means.

usage: test_reproduce_studies.py [FLUSI [TESTS]]
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from flusi_msm.paper import ensemble as ensembles
from flusi_msm.paper import scan as scans
from flusi_msm.paper import scan_pictures
from flusi_msm.paper.cases import FLEXIBLE, INI, RIGID, Variant
from flusi_msm.paper.command import check as check_options
from flusi_msm.paper.ensemble_page import write_page as write_ensemble_page
from flusi_msm.paper.flights import Estimate, mpi_environment
from flusi_msm.paper.numbers import PAPER, TABLE_2
from flusi_msm.paper.scan_page import write_page as write_scan_page
from flusi_msm.paper.scan_words import ranges, sentences, slopes
from flusi_msm.paper.studies import PAGE_INTERVAL, Pages
from flusi_msm.results.files import InputError, read_series
from flusi_msm.results.ini import values_of, with_values
from synthetic import UNITS, picture, write_table

SOURCE = Path(__file__).resolve().parents[3]
INPUT = SOURCE / "ini/wing.ini"
FLUSI = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 and Path(sys.argv[1]).is_file() else None
FORCE, POWER = 0.200600, 0.285300  # mN and mW of one unit, as UNITS says


def finish(case, lift, drag, power, beats=None):
    """Stores series with these means [mN, mW] in the last beat of two or the last two of more, and twice as much before; the flight is
    then finished."""
    case.folder.mkdir(parents=True)
    t = np.arange(1, 100 * (beats or case.beats) + 1) / 100
    zero, wave = 0 * t, np.sin(2 * np.pi * t)
    factor = np.where(t >= case.beats - (1 if case.beats == 2 else 2), 1.0, 2.0)
    names = [f"{q}{c}{u}" for q in "FM" for u in ("", " unsteady") for c in "xyz"]
    forces = [factor * drag / FORCE + wave, zero, factor * lift / FORCE + wave] + 9 * [zero]
    write_table(case.folder / "forces.t", ["time [T]", *names], np.column_stack([t, *forces]), UNITS)
    write_table(case.folder / "aero_power.t", ["time [T]", "aerodynamic power", "inertial power"],
                np.column_stack([t, factor * power / POWER + wave, zero]), UNITS)
    case.note(status="finished", versions=["flusi-msm 0"], seconds=10.0, ranks=1)


class Numbers(unittest.TestCase):
    def test_numbers(self):
        self.assertEqual(ensembles.number("12.58d9", "E"), 12.58e9)
        with self.assertRaisesRegex(InputError, "[Wing] E: 'soft' is not a number".replace("[", r"\[").replace("]", r"\]")):
            ensembles.number("soft", "E")

    def test_parameters(self):
        self.assertEqual(ensembles.parameters_of({"parameters": "joint:A 1D-6, slack = 0.5"}), {"joint:A": 1e-6, "slack": 0.5})
        for text, said in (("joint:A soft", "'soft' is not a number"), ("joint:* 1e-6", "stands for several")):
            with self.assertRaisesRegex(InputError, said):
                ensembles.parameters_of({"parameters": text})

    def test_nothing_to_fly(self):
        for key in "beats", "ranks", "members", "scan_beats":
            options = SimpleNamespace(**{"beats": 4, "ranks": 1, "individuals": None, "members": 27, "scan_beats": 2, key: 0})
            with self.assertRaisesRegex(InputError, "must be positive"):
                check_options(options)

    def test_steps(self):
        """Steps per beat and point were counted: 3.3 on 32 points, 3.5 on 96, 4.2 on 288."""
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "estimate.json").write_text(json.dumps({"steps per beat and point, 2 ranks, stub": 3.3125}))
            estimate = Estimate(SimpleNamespace(ranks=2, version="stub"), folder, INPUT)
            for points, counted in ((32, 3.31), (96, 3.53), (288, 4.22)):
                case = SimpleNamespace(points=points, beats=4, speed=1.0)
                self.assertAlmostEqual(estimate.steps(case) / (4 * points * counted), 1, delta=0.06)


class Temporary(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def input(self, changes):
        """ini/wing.ini with other values."""
        path = self.folder / "own.ini"
        text = with_values(INPUT.read_text(), {"Wing": {"file": SOURCE / "wings/calliphora.h5"}, "Insects": {
            f"FlappingMotion_{side}": f"from_file::{SOURCE}/ini/kinematics/calliphora.ini" for side in ("left", "right")}})
        path.write_text(with_values(text, changes))
        return path


class ScanOfKinematics(Temporary):
    def test_flights(self):
        """The shipped kinematics come first; the keys of the inputs say the angles."""
        scan = scans.Scan(self.folder, INPUT, 32)
        self.assertEqual(len(scan.cases), 54)
        self.assertEqual(scan.points[0][0], (0, 135, 20))
        self.assertEqual([case.kind for case in scan.cases[:2]], [RIGID, FLEXIBLE])
        insects = values_of(scan.cases[0].text)["Insects"]
        self.assertEqual((insects["kinematics_factor"], insects["kinematics_offset"], insects["eta0"], insects["wings"]),
                         ("1 1 1", "0 0 0", "-70", "rigid"))
        cases = {case.name: case for case in scan.cases}
        own = values_of(cases["flexible_pitch-10_stroke150_tilt30"].text)
        self.assertEqual(own["Insects"]["kinematics_offset"], "0 -10 0")
        self.assertEqual(own["Insects"]["eta0"], "-60")
        self.assertEqual(own["Insects"]["wings"], "flexible")
        factors = [float(x) for x in own["Insects"]["kinematics_factor"].split()]
        np.testing.assert_allclose(factors, [150 / 135, 1, 1], rtol=1e-9)
        self.assertEqual((own["Time"]["Tmax"], own["Resolution"]["nz"], own["Saving"]["iSaveVorticity"]), ("2", "16", "0"))
        self.assertAlmostEqual(cases["flexible_pitch-10_stroke150_tilt30"].speed, 150 / 135)
        distances = [sum(abs(x - c) / s for x, c, s in zip(angles, (0, 135, 20), scans.STEPS)) for angles, _ in scan.points]
        self.assertEqual(distances, sorted(distances))

    def test_sizes(self):
        """A finer scan has the flights of a coarser one among its own."""
        coarse = {case.name: case.input for case in scans.Scan(self.folder, INPUT, 32, (3, 1, 1)).cases}
        fine = {case.name: case.input for case in scans.Scan(self.folder, INPUT, 32, (5, 1, 1), (5.0, 15.0, 10.0)).cases}
        self.assertEqual((len(coarse), len(fine)), (6, 10))
        self.assertEqual({name: fine[name] for name in coarse}, coarse)
        for sizes, steps, text in (((2, 3, 3), scans.STEPS, "odd"), ((3, 3, 3), (0, 15, 10), "positive angles"),
                                   ((1, 3, 1), (1, 140, 1), "smallest stroke")):
            with self.assertRaisesRegex(InputError, text):
                scans.Scan(self.folder, INPUT, 32, sizes, steps)

    def test_own_kinematics(self):
        """The scan is about what the input has: its factor and offset, and the pitch of its body."""
        ini = self.input({"Insects": {"kinematics_factor": "0.8 1.1 1", "kinematics_offset": "1 5 2", "yawpitchroll_0": "180 -15 0"}})
        shipped = scans.Shipped(ini)
        np.testing.assert_allclose(shipped.angles, (5, 108, 5))
        insects = shipped.values(shipped.angles)["Insects"]
        self.assertEqual(insects, {"kinematics_factor": "0.8 1.1 1", "kinematics_offset": "1 5 2", "eta0": "-70"})
        with self.assertRaisesRegex(InputError, "eta0 must be 1 number"):
            scans.Shipped(self.input({"Insects": {"eta0": "steep"}}))
        with self.assertRaisesRegex(InputError, "Fourier series of phi"):
            scans.Shipped(self.input({"Insects": {"FlappingMotion_left": f"from_file::{INPUT}"}}))

    def fly(self, scan, but=()):
        """Rigid wings give 1.1 of the paper's numbers everywhere; flexible ones have the paper's at pitch -10, amplitude 150, tilt
        30 alone, and drag without sign at pitch 10."""
        for (pitch, stroke, tilt), pair in scan.points:
            near = (pitch, stroke, tilt) == (-10, 150, 30)
            for kind, case in pair.items():
                lift, drag, power = (TABLE_2[kind][key] for key in scans.OWN)
                if kind == RIGID:
                    lift, drag, power = 1.1 * lift, 1.1 * drag, 1.1 * power
                elif not near:
                    lift, drag, power = lift * (1 + stroke / 1000), drag + 0.002 * tilt, 1.5 * power
                    drag = -0.01 if pitch == 10 else drag
                if case.name not in but:
                    finish(case, lift, drag, power)

    def test_numbers(self):
        scan = scans.Scan(self.folder, INPUT, 32)
        self.fly(scan)
        found = scans.collect(scan)
        self.assertEqual((len(found["scan"]), found["missing"]), (27, []))
        nearest = found["nearest"]
        self.assertEqual([nearest[axis] for axis in scans.AXES], [-10, 150, 30])
        self.assertAlmostEqual(nearest["distance"], 0.1 / np.sqrt(2), delta=1e-4)
        self.assertAlmostEqual(nearest[FLEXIBLE]["lift_mN"], 0.513, delta=1e-4, msg="the last beat alone")
        self.assertAlmostEqual(nearest["change_percent"]["lift_to_power"], PAPER["change_percent"]["lift_to_power"], delta=0.2)
        self.assertEqual(found["both_signs"], [{"pitch": -10, "stroke": 150, "tilt": 30}])
        away = next(p for p in found["scan"] if p["pitch"] == 10)
        self.assertIsNone(away[FLEXIBLE]["lift_to_drag"])
        self.assertIsNone(away["change_percent"]["lift_to_drag"])
        self.assertIsNotNone(away["change_percent"]["lift_to_power"])
        told = {row["quantity"]: row for row in ranges(found)}
        self.assertFalse(told[RIGID, "lift_mN"]["inside"])
        self.assertTrue(told[FLEXIBLE, "drag_mN"]["inside"])
        self.assertAlmostEqual(told[FLEXIBLE, "drag_mN"]["shipped"], 0.102, delta=1e-4)
        self.assertAlmostEqual(slopes(found)[FLEXIBLE, "drag_mN"]["tilt"], 0.02, delta=1e-5)
        text = " ".join(sentences(found))
        for words in ("All 27 points", "Nearest to the paper is mean pitch -10°, amplitude 150°, tilt 30°", "7 % away",
                      "1 of 27 points has the signs of both changes", "At 9 points the mean drag"):
            self.assertIn(words, text)

    def test_no_point_has_both_signs(self):
        scan = scans.Scan(self.folder, INPUT, 32, (1, 1, 1))
        for kind, case in scan.points[0][1].items():
            finish(case, *((0.8, 0.2, 5.0) if kind == RIGID else (0.72, 0.1, 5.0)))
        text = " ".join(sentences(scans.collect(scan)))
        self.assertIn("No point has the signs of both changes", text)
        self.assertIn("lift to drag by +80 % and lift to power by -10 %", text)
        self.assertIn("these are the shipped kinematics", text)
        self.assertNotIn("All other numbers", text)

    def test_page(self):
        """A page of a part of the scan says what is missing; maps are pictures with contents."""
        scan = scans.Scan(self.folder, INPUT, 32)
        self.assertNotIn("<img", write_scan_page(self.folder, scan).read_text(), "a page before any flight")
        self.fly(scan, but=("rigid_pitch+10_stroke150_tilt30",))
        page = write_scan_page(self.folder, scan).read_text()
        for words in ("Not finished yet: 1 flights", "26 of 27 points", "Nothing is tuned", "data:image/png", "What one step of each angle",
                      "within the scan"):
            self.assertIn(words, page)
        self.assertNotIn("http", page.replace("http-equiv", ""))
        found = json.loads((self.folder / "kinematics_32.json").read_text())
        self.assertEqual(found["missing"], ["rigid_pitch+10_stroke150_tilt30"])
        for kind in ("change", RIGID, FLEXIBLE):
            self.assertGreater(picture(self.folder / f"kinematics_32/pictures/map_{kind}.png")[2], 10, kind)


    def test_panels(self):
        """With one amplitude the maps are over pitch and tilt; cells hold the values of their points."""
        scan = scans.Scan(self.folder, INPUT, 32, (3, 1, 3))
        self.fly(scan, but=("rigid_pitch+10_stroke135_tilt30",))
        found = scans.collect(scan)
        self.assertEqual(scan_pictures.axes_of(found), ["pitch", "tilt", "stroke"])
        self.assertEqual(scan_pictures.axes_of({"values": {"pitch": [0, 1], "stroke": [1, 2], "tilt": [1]}}), list(scans.AXES))
        values = scan_pictures.field(found, lambda point: point["rigid"]["lift_mN"] if "rigid" in point else None, 135)
        self.assertTrue(np.isnan(values[2, 2]))
        np.testing.assert_allclose(np.nan_to_num(values, nan=0.8294), 0.8294, atol=1e-4)
        drag = scan_pictures.field(found, lambda point: point["flexible"]["drag_mN"], 135)
        np.testing.assert_allclose(drag, [[0.082, 0.082, -0.01], [0.102, 0.102, -0.01], [0.122, 0.122, -0.01]], atol=1e-4)
        pictures = scan_pictures.all_maps(found, self.folder / "pictures")
        self.assertEqual(len(pictures), 3)
        for _, _, path in pictures:
            height, width, colours = picture(path)
            self.assertGreater(width, 1.5 * height)
            self.assertGreater(colours, 10)


class EnsembleOfStiffness(Temporary):
    def test_design(self):
        """Member k does not depend on how many there are; the laws are those that the page tells."""
        few, many = (ensembles.uniform_design(n, 11) for n in (5, 256))
        np.testing.assert_array_equal(few, many[:5])
        for column in many.T:
            counts = np.bincount((column * 16).astype(int), minlength=16)
            self.assertLess(np.ptp(counts), 10, "even in every dimension")
        E = np.array([ensembles.young_modulus(u) for u in many[:, 0]])
        self.assertAlmostEqual(E.mean() / 12.58e9, 1, delta=0.005)
        self.assertAlmostEqual(E.std() / 3.03e9, 1, delta=0.03)
        self.assertGreater(ensembles.young_modulus(0.0), 0)
        self.assertLess(ensembles.young_modulus(1.0), 40e9)
        within = np.array([abs(np.log(ensembles.joint_ratio(u, 3.0))) < np.log(3) for u in many[:, 1]])
        self.assertAlmostEqual(within.mean(), 0.683, delta=0.02)
        self.assertLess(ensembles.largest_correlation(ensembles.uniform_design(27, 11)), 0.271)
        self.assertEqual(ensembles.uniform_design(3, 13).shape, (3, 13))
        self.assertAlmostEqual(ensembles.largest_correlation([[1, 3], [2, 4], [3, 2], [4, 1]]), 0.8)
        self.assertEqual(ensembles.joint_ratio(0.9, 1.0), 1.0)

    def test_members(self):
        """Inputs have what was drawn, beside the parameters of the file that are no joints."""
        ini = self.input({"Wing": {"parameters": "joint:C_h 1e-4, k_cross 9e4"}})
        made = ensembles.Ensemble(self.folder, ini, 32, 3, 4, 3.0)
        self.assertEqual([case.name for case in made.cases], ["member_01", "member_02", "member_03"])
        self.assertEqual(made.joints["C_h"], 1e-4)
        self.assertEqual(len(made.joints), 10)
        again = ensembles.Ensemble(self.folder, ini, 32, 2, 4, 3.0)
        self.assertEqual(again.cases[1].input, made.cases[1].input)
        for case, drawn in zip(made.cases, made.drawn):
            own = values_of(case.text)["Wing"]
            self.assertAlmostEqual(float(own["E"]) / drawn["E"], 1, delta=1e-6)
            given = ensembles.parameters_of(own)
            self.assertEqual(given.pop("k_cross"), 9e4)
            self.assertEqual(set(given), {name for name in drawn if name != "E"})
            self.assertAlmostEqual(given["joint:C_h"] / drawn["joint:C_h"], 1, delta=1e-6)
            self.assertEqual(values_of(case.text)["Insects"]["wings"], "flexible")
        for_all = ensembles.joints_of(self.input({"Wing": {"joint_stiffness": "2e-5"}}))
        self.assertEqual(set(for_all.values()), {2e-5})
        plain, stiff = (ensembles.joints_of(self.input({"Wing": {"E": E}})) for E in ("1e10", "2e10"))
        self.assertAlmostEqual(stiff["R1_Rs"] / plain["R1_Rs"], 2)
        large = ensembles.joints_of(self.input({"Wing": {"E": "1e10", "length": "18e-3", "mean_chord": "6.008e-3"}}))
        self.assertAlmostEqual(large["R1_Rs"] / plain["R1_Rs"], 8)

    def test_statistics(self):
        np.testing.assert_array_equal(ensembles.ranks([3, 1, 2, 2]), [3, 0, 1.5, 1.5])
        x = np.arange(10.0)
        self.assertAlmostEqual(ensembles.rank_correlation(x, -np.exp(x)), -1)
        self.assertEqual(ensembles.rank_correlation(x, 0 * x), 0)
        self.assertAlmostEqual(ensembles.rank_correlation([1, 2, 3, 4], [1, 3, 2, 4]), 0.8)
        found = ensembles.spread([9, 9.5, 10, 10.5, 11, 20])
        self.assertAlmostEqual(found["whiskers_percent"], 100 * 2 / 10.25)
        self.assertAlmostEqual(found["all_percent"], 100 * 11 / 10.25)
        self.assertAlmostEqual(ensembles.spread([2, 9.5, 10, 10.5, 11, 11.5])["whiskers_percent"], 100 * 2 / 10.25)
        self.assertNotIn("nine_percent", found)
        self.assertLess(ensembles.spread(np.arange(100.0, 127))["nine_percent"], ensembles.spread(np.arange(100.0, 127))["all_percent"])

    def test_page(self):
        """Lift follows E, drag one joint, power nothing."""
        made = ensembles.Ensemble(self.folder, INPUT, 32, 12, 4, 3.0)
        self.assertIn("0 of 12 members", write_ensemble_page(self.folder, made).read_text())
        for number, (case, drawn) in enumerate(list(zip(made.cases, made.drawn))[:-1]):
            joint = np.log(drawn["joint:C_Sc"] / made.joints["C_Sc"])
            finish(case, 0.5 * drawn["E"] / 12.58e9, 0.06 * (1 - 0.1 * joint), 3.1 * (1 + 0.01 * (-1)**number))
        page = write_ensemble_page(self.folder, made).read_text()
        for words in ("11 of 12 members", "Not finished yet: member_12", "45.16 %", "Lift goes with E (+1.00)",
                      "Drag goes with C_Sc (-1.00)", "within a factor of\n3", "data:image/png", "member k is the"):
            self.assertIn(words, page)
        found = json.loads((self.folder / "ensemble_32.json").read_text())
        first = found["members"][0]
        self.assertAlmostEqual(first["means"]["lift_mN"], 0.5 * first["drawn"]["E"] / 12.58e9, delta=1e-4, msg="the last two beats")
        done = np.array([m["means"]["lift_mN"] for m in found["members"] if "means" in m])
        self.assertAlmostEqual(found["spread"]["lift_mN"]["all_percent"], 100 * np.ptp(done) / np.median(done), delta=1e-6)
        self.assertAlmostEqual(found["spread"]["power_mW"]["all_percent"], 2.0, delta=0.05)
        for name in ("boxes", "rank_correlation"):
            self.assertGreater(picture(self.folder / f"ensemble_32/pictures/{name}.png")[2], 10, name)


class WhenPagesAreWritten(unittest.TestCase):
    def test_intervals(self):
        now, written = [0.0], []

        def study(name, lines):
            return SimpleNamespace(name=name, lines=lines, write_page=lambda: written.append(name))
        pages = Pages([study("paper", True), study("scan", False)], lambda: now[0])
        for now[0], expected in ((10, ["paper"]), (PAGE_INTERVAL, ["paper", "scan"]), (PAGE_INTERVAL + 10, ["paper"])):
            written.clear()
            pages.write_some()
            self.assertEqual(written, expected, now)


@unittest.skipUnless(FLUSI, "needs the program")
class Flights(Temporary):
    def test_joints_of_the_input(self):
        """Joints that are named with their values in the input give the same wing as the input; twice as stiff ones do not."""
        ini = self.input({"Wing": {"file": SOURCE / "wings/calliphora_small.h5"}, "Time": {"nt": 4}})
        bent = []
        for factor in (None, 1, 2):
            listed = ", ".join(f"joint:{name} {factor * k:.9e}" for name, k in ensembles.joints_of(ini).items()) if factor else ""
            case = Variant(self.folder, ini, FLEXIBLE, 16, 1, f"factor_{factor}", {"Wing": {"parameters": listed}} if factor else {})
            case.folder.mkdir()
            (case.folder / INI).write_text(case.text)
            subprocess.run([os.environ.get("MPIEXEC", "mpirun"), "-n", "1", FLUSI, INI], cwd=case.folder, check=True,
                           capture_output=True, env=mpi_environment())
            bent.append(read_series(case.folder / "bending_left.t").data[-1])
        np.testing.assert_allclose(bent[1], bent[0], rtol=1e-5, atol=1e-9)
        self.assertGreater(np.max(np.abs(bent[2] - bent[0])), 1e-5)


if __name__ == "__main__":
    unittest.main()
