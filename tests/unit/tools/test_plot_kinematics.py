# SPDX-License-Identifier: GPL-3.0-or-later
"""plot_kinematics: pictures of all kinds of files, angles and directions in numbers, mistakes by name."""
import tempfile
import unittest
from pathlib import Path

import numpy as np

from flusi_msm.plots import kinematics as plot_kinematics
from synthetic import picture, run_tool

SOURCE = Path(__file__).resolve().parents[3]
BLOWFLY = SOURCE / "ini" / "kinematics" / "calliphora.ini"
HERMITE = """; a figure of eight
[Other]
type=none;
[kinematics]
type=hermite; comment
units=degree;
convention=SISC;
nfft_phi=2;
ai_phi=60 -60;
bi_phi=0 10;
nfft_alpha=1;
ai_alpha=3.0d1;
bi_alpha=0;
nfft_theta=4;
ai_theta=10, -5, 12, -5;
bi_theta=30 0 -30 0;
"""
ROW = "0 0 0 1 2 3 0 0 0"
TABLE = "4.0\n2.83 ; mm\n3\n" + f"0 60 45 5 {ROW}\n" + f"2 -60 45 5 {ROW}\n" + f"4 60 -45 5 {ROW}\n"


class PlotKinematics(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def assert_picture(self, *arguments, out="out.png"):
        done = run_tool("plot_kinematics", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        height, width, colours = picture(self.folder / out)
        self.assertGreater(height, 500)
        self.assertGreater(width, 900)
        self.assertGreater(colours, 50)

    def assert_refused(self, *arguments, because):
        done = run_tool("plot_kinematics", *arguments)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn(because, done.stderr)

    def test_blowfly(self):
        self.assert_picture(BLOWFLY, "--eta", -70, "-o", self.folder / "out.png")

    def test_hermite_beside_the_file(self):
        self.assert_picture(self.write("k.ini", HERMITE), "--eta", -50, "--pitch", -30, out="k_kinematics.png")

    def test_table(self):
        self.assert_picture(self.write("k.dat", TABLE), "--count", 5, out="k_kinematics.png")

    def test_fourier_angles(self):
        motion = plot_kinematics.read_motion(BLOWFLY)
        angles = motion([0.0, 0.25, 0.5, 0.75])
        np.testing.assert_allclose(angles["phi"], [67.5, 0, -67.5, 0], atol=1e-12)
        np.testing.assert_allclose(angles["alpha"], [-12.5, 45, -12.5, -70], atol=0.01)
        np.testing.assert_allclose(angles["theta"], 0)

    def test_hermite_angles(self):
        motion = plot_kinematics.read_motion(self.write("k.ini", HERMITE))
        angles = motion(np.array([0.0, 0.5, 1.0, 1.5, 0.25]))
        np.testing.assert_allclose(angles["phi"], [60, -60, 60, -60, -0.625])
        np.testing.assert_allclose(angles["theta"], [-10, -12, -10, -12, 5])
        np.testing.assert_allclose(angles["alpha"], 30)
        h = 1e-4
        slope = (motion(np.array([0.5 + h]))["phi"] - motion(np.array([0.5 - h]))["phi"]) / (2 * h)
        np.testing.assert_allclose(slope, 10, atol=1e-2)

    def test_table_angles(self):
        motion = plot_kinematics.read_motion(self.write("k.dat", TABLE))
        self.assertEqual(motion.length, 1.0)
        angles = motion(np.array([0.0, 0.5, 1.0]))
        np.testing.assert_allclose(angles["phi"], [60, -60, 60])
        np.testing.assert_allclose(angles["theta"], -5, atol=1e-12)
        h = 1e-5  # slopes of the table are per unit of its time, of which the period has 4
        slope = (motion(np.array([0.5 + h]))["phi"] - motion(np.array([0.5 - h]))["phi"]) / (2 * h)
        np.testing.assert_allclose(slope, 1 * 4, atol=0.1)

    def test_directions(self):
        def wing(phi, alpha, theta, eta, pitch=0.0):
            return plot_kinematics.left_wing({"phi": [phi], "alpha": [alpha], "theta": [theta]}, eta, pitch)
        for arguments, tip, chord in (((0, 0, 0, 0), (0, 1, 0), (1, 0, 0)), ((90, 0, 0, 0), (0, 0, 1), (1, 0, 0)),
                                      ((0, 90, 0, -90), (0, 1, 0), (1, 0, 0)), ((90, 0, 0, -90), (-1, 0, 0), (0, 0, 1)),
                                      ((0, 0, 90, -90), (0, 0, -1), (0, 1, 0)),
                                      ((0, 0, 0, 0, -90), (0, 1, 0), (0, 0, 1))):
            with self.subTest(arguments):
                got = wing(*arguments)
                np.testing.assert_allclose(got[0][0], tip, atol=1e-15)
                np.testing.assert_allclose(got[1][0], chord, atol=1e-15)

    def test_refusals(self):
        self.assert_refused(self.folder / "absent.ini", because="No such file")
        self.assert_refused(self.write("a.txt", "hello world"), because="neither [kinematics] nor a table")
        self.assert_refused(self.write("b.dat", "1\n1\n2\n1 2 3\n1 2\n"), because="rows of 13 numbers")
        self.assert_refused(self.write("c.dat", TABLE.replace("\n3\n", "\n4\n")), because="3 rows, but the third")
        self.assert_refused(self.write("d.ini", HERMITE.replace("=hermite", "=spline")), because="'spline' is unknown")
        self.assert_refused(self.write("e.ini", HERMITE.replace("60 -60", "60")), because="ai_phi: 1 number(s), not 2")
        self.assert_refused(self.write("f.ini", HERMITE.replace("60 -60", "60 x")), because="ai_phi: '60 x' is not")
        self.assert_refused(self.write("g.ini", HERMITE.replace("nfft_phi=2;", "nfft_phi=0;").replace(
            "ai_phi=60 -60;", "").replace("bi_phi=0 10;", "")), because="hermite needs a value")
        self.assert_refused(BLOWFLY, "--count", 1, because="--count takes 2 or more")
        self.assert_refused(BLOWFLY, "-o", self.folder / "no" / "x.png", because="cannot write")


if __name__ == "__main__":
    unittest.main()
