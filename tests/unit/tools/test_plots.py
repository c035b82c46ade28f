# SPDX-License-Identifier: GPL-3.0-or-later
"""plot_series and plot_slice make pictures of files like those of a run, and name mistakes."""
import tempfile
import unittest
from pathlib import Path

import numpy as np

from synthetic import picture, run_tool, write_ball, write_field, write_velocity


class Tool(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def assert_picture(self, tool, *arguments, out="out.png", given=True):
        """The tool succeeds and the picture has a sensible size and more than a few colours."""
        options = ("-o", self.folder / out) if given else ()
        done = run_tool(tool, *arguments, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        height, width, colours = picture(self.folder / out)
        self.assertGreater(height, 200)
        self.assertGreater(width, 400)
        self.assertGreater(colours, 20)
        return height, width, colours

    def assert_refused(self, tool, *arguments, because):
        """Exit code 2 and a message that names the reason."""
        done = run_tool(tool, *arguments)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn(because, done.stderr)


class PlotSeries(Tool):
    def write(self, name, columns, n=50, header=None):
        t = np.linspace(0, 5, n)
        rows = np.column_stack([t] + [np.sin(t + i) for i in range(columns - 1)])
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(header or "% " + " ".join(["time"] + [f"q{i}" for i in range(1, columns)]) + "\n")
            np.savetxt(file, rows, fmt="%15.8e")
        return path

    def test_known_files(self):
        for name, columns in (("forces.t", 13), ("energy.t", 21), ("ekin.t", 2), ("dt.t", 5),
                              ("timesteps_info.t", 5), ("forces_part1.t", 15), ("own.t", 30)):
            with self.subTest(name):
                self.assert_picture("plot_series", self.write(name, columns))

    def test_wing_in_motion(self):
        names = "tip_x tip_y tip_z largest E_kin E_kin_rel E_elastic W_loads W_weight W_frame Q_damping imbalance"
        header = "% time [s]  " + "  ".join(f"{name} [J]" for name in names.split()) + "\n"
        wing = self.assert_picture("plot_series", self.write("any_name.t", 13, header=header))
        one = self.assert_picture("plot_series", self.write("ekin.t", 2))
        self.assertGreater(wing[0], 2 * one[0], "displacement, energy, work")

    def test_two_panels_are_higher_than_one(self):
        one = self.assert_picture("plot_series", self.write("ekin.t", 2))
        two = self.assert_picture("plot_series", self.write("ekin.t", 2), self.write("forces.t", 13))
        self.assertGreater(two[0], 1.5 * one[0])

    def test_same_file_of_two_runs_in_one_panel(self):
        files = self.write("a/ekin.t", 2), self.write("b/ekin.t", 2)
        one = self.assert_picture("plot_series", files[0])
        both = self.assert_picture("plot_series", *files)
        self.assertAlmostEqual(both[0], one[0], delta=20)

    def test_columns_and_default_name(self):
        self.write("x.t", 3, header="% time [s] Fx [N] Fy [N]\n")
        self.assert_picture("plot_series", self.folder / "x.t", "--columns", "Fx, fy", out="x_Fx_fy.png", given=False)

    def test_refusals(self):
        one = self.folder / "one.t"
        one.write_text("% time v\n0 1\n")
        empty = self.folder / "empty.t"
        empty.write_text("")
        good = self.write("ekin.t", 2)
        self.assert_refused("plot_series", one, because="1 line(s) of numbers")
        self.assert_refused("plot_series", empty, because="no numbers")
        self.assert_refused("plot_series", self.folder / "absent.t", because="No such file")
        self.assert_refused("plot_series", good, "--columns", "q2", because="did you mean q1")
        self.assert_refused("plot_series", good, "-o", self.folder / "no" / "x.png", because="cannot write")


class PlotSlice(Tool):
    n, length = (48, 32, 24), (6.0, 4.0, 3.0)

    def setUp(self):
        super().setUp()
        for label, time, amplitude in (("000500", 0.5, 1.0), ("001000", 1.0, 2.0)):
            write_velocity(self.folder, label, self.n, self.length, time, amplitude)
        write_ball(self.folder, "001000", self.n, self.length, 1.0, 0.6)

    def test_default_is_the_last_time(self):
        self.assert_picture("plot_slice", self.folder, out="vorz_001000_z.png", given=False)

    def test_time_and_label_choose_the_snapshot(self):
        for option, value in (("--time", 0.6), ("--label", "500")):
            with self.subTest(option):
                self.assert_picture("plot_slice", self.folder, option, value, out="vorz_000500_z.png", given=False)
                (self.folder / "vorz_000500_z.png").unlink()

    def test_quantities_and_planes(self):
        for arguments in (("--quantity", "vorabs"), ("--quantity", "speed", "--plane", "y"), ("--quantity", "ux"),
                          ("--plane", "x", "--index", 3), ("--plane", "y", "--position", 1.0, "--limit", 2),
                          ("--quantity", "mask")):
            with self.subTest(arguments):
                self.assert_picture("plot_slice", self.folder, *arguments)

    def test_a_file_is_drawn_as_it_is(self):
        self.assert_picture("plot_slice", self.folder / "uy_000500.h5", out="uy_000500_z.png", given=False)

    def test_body_is_drawn(self):
        from matplotlib.image import imread
        with_body = self.folder / "with.png"
        run_tool("plot_slice", self.folder, "-o", with_body)
        pixels = np.round(imread(str(with_body))[..., :3] * 255).astype(int)
        grey = np.all(np.abs(pixels - 217) <= 1, axis=-1).sum()
        (self.folder / "mask_001000.h5").unlink()
        run_tool("plot_slice", self.folder, "-o", with_body)
        without = np.round(imread(str(with_body))[..., :3] * 255).astype(int)
        self.assertGreater(grey, 500)
        self.assertLess(np.all(np.abs(without - 217) <= 1, axis=-1).sum(), 50)

    def test_stored_vorticity_is_preferred(self):
        write_field(self.folder, "vorz", "001000", np.zeros(self.n[::-1]), self.length, 1.0)
        flat = self.assert_picture("plot_slice", self.folder)
        self.assertGreater(self.assert_picture("plot_slice", self.folder, "--time", 0.5)[2], flat[2])

    def test_two_dimensional_run(self):
        flat = self.folder / "flat"
        flat.mkdir()
        write_velocity(flat, "000100", (1, 32, 32), (1.0, 2.0, 2.0), 0.1)
        done = run_tool("plot_slice", flat)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((flat / "vorx_000100_x.png").exists())

    def test_refusals(self):
        empty = self.folder / "empty"
        empty.mkdir()
        bad = self.folder / "p_000500.h5"
        bad.write_text("no HDF5")
        self.assert_refused("plot_slice", empty, because="no field files")
        self.assert_refused("plot_slice", bad, because="not a readable HDF5 file")
        bad.unlink()
        self.assert_refused("plot_slice", self.folder, "--quantity", "q", because="there is mask, ux, uy, uz")
        self.assert_refused("plot_slice", self.folder, "--index", 24, because="outside 0 to 23")
        self.assert_refused("plot_slice", self.folder, "--label", "7", because="nothing with label 7")
        self.assert_refused("plot_slice", self.folder, "--label", "x", because="takes digits")
        self.assert_refused("plot_slice", self.folder, self.folder, "-o", self.folder / "x.png", because="-o takes one")
        (self.folder / "uy_001000.h5").unlink()
        self.assert_refused("plot_slice", self.folder, because="missing: uy")


if __name__ == "__main__":
    unittest.main()
