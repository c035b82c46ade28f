# SPDX-License-Identifier: GPL-3.0-or-later
"""The readers of the Python tools: headers of several kinds, restarts, damage, spectral derivatives."""
import tempfile
import unittest
from pathlib import Path

import numpy as np

from flusi_msm.results import files as flusi
from synthetic import grid, write_field, write_velocity


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def series(self, text, name="a.t"):
        (self.folder / name).write_text(text)
        return flusi.read_series(self.folder / name)


class TimeSeries(InFolder):
    def test_names_with_units(self):
        s = self.series("%  time [T]   Fx [rho U^2 L^2]  n [-]\n0 1 2\n1 3 4\n")
        self.assertEqual(s.names, ["time", "Fx", "n"])
        self.assertEqual(s.units, ["T", "rho U^2 L^2", ""])
        np.testing.assert_array_equal(s.data, [[0, 1, 2], [1, 3, 4]])

    def test_unitless_words_and_names_with_blanks(self):
        self.assertEqual(self.series("% time a,b\n0 1 2\n").names, ["time", "a", "b"])
        self.assertEqual(self.series("%        time   Aero_Power   Inert power\n0 1 2\n").names,
                         ["time", "Aero_Power", "Inert power"])

    def test_header_is_the_last_line_before_the_numbers(self):
        self.assertEqual(self.series("% made by this\n% time a\n0 1\n% again b\n1 1\n").names, ["time", "a"])

    def test_missing_header(self):
        self.assertEqual(self.series("0 1\n", "ekin.t").names, ["time", "E_kin"])
        self.assertEqual(self.series("0 1 2\n", "my.t").names, ["time", "column2", "column3"])

    def test_known_tables_have_their_number_of_columns(self):
        sizes = {name: len(columns) for name, columns in flusi.KNOWN_COLUMNS.items()}
        self.assertEqual((sizes["forces"], sizes["energy"], sizes["dt"]), (13, 21, 5))

    def test_restart_replaces_what_it_computes_again(self):
        s = self.series("% time v\n0 0\n1 1\n2 2\n3 3\n% time v\n2 20\n3 30\n4 40\n")
        np.testing.assert_array_equal(s.data, [[0, 0], [1, 1], [2, 20], [3, 30], [4, 40]])

    def test_numbers_of_fortran(self):
        s = self.series("% time v\n1.0D0 1.5-101\n2 ********\n3 NaN\n4 -1.0E+02\n")
        self.assertEqual(s.data[0].tolist(), [1.0, 1.5e-101])
        self.assertTrue(np.isnan(s.data[1:3, 1]).all())
        self.assertEqual(s.data[3, 1], -100)

    def test_torn_last_line_is_left_out(self):
        self.assertEqual(len(self.series("% time v\n0 1\n1 2\n2\n").data), 2)

    def test_wrong_input_is_named(self):
        for text in ("", "% time v\n", "0\n1\n"):
            with self.assertRaises(flusi.InputError):
                self.series(text)
        with self.assertRaisesRegex(flusi.InputError, "no column 'Fxx'.*did you mean Fx"):
            self.series("% time Fx\n0 1\n").index("Fxx")
        self.assertEqual(self.series("% time Fx\n0 1\n").index("fX"), 1)


class Fields(InFolder):
    n, length = (16, 12, 10), (2.0, 3.0, 1.5)

    def test_a_field_and_its_attributes(self):
        x, y, z = grid(self.n, self.length)
        write_field(self.folder, "p", "001500", x + 10 * y + 100 * z, self.length, 1.5)
        field = flusi.Field(self.folder / "p_001500.h5")
        self.assertEqual((field.name, field.label, field.time, tuple(field.n)), ("p", "001500", 1.5, self.n))
        np.testing.assert_allclose(field.plane(2, 3), (x + 10 * y + 45)[0], rtol=1e-6)
        np.testing.assert_allclose(field.plane(0, 2), (0.25 + 10 * y + 100 * z)[:, :, 0], rtol=1e-6)

    def test_derivatives_are_exact(self):
        curl = write_velocity(self.folder, "000000", self.n, self.length, 0.0)
        at = flusi.Snapshot(self.folder, "000000")
        for axis in range(3):
            for c in range(3):
                one, two = (c + 1) % 3, (c + 2) % 3
                u = [flusi.load_field(at, name) for name in ("ux", "uy", "uz")]
                got = (flusi.derivative_on_plane(u[two], one, axis, 4)
                       - flusi.derivative_on_plane(u[one], two, axis, 4))
                np.testing.assert_allclose(got, np.take(curl[c], 4, axis=2 - axis), atol=1e-5)

    def test_highest_mode_has_no_derivative(self):
        zigzag = (-1.0)**np.arange(8)
        write_field(self.folder, "ux", "000000", np.broadcast_to(zigzag, (4, 8, 8)), self.length, 0.0)
        field = flusi.Field(self.folder / "ux_000000.h5")
        np.testing.assert_allclose(flusi.derivative_on_plane(field, 0, 2, 1), 0, atol=1e-12)
        np.testing.assert_allclose(flusi.derivative_on_plane(field, 0, 0, 1), 0, atol=1e-12)

    def test_wrong_input_is_named(self):
        write_field(self.folder, "ux", "000", np.zeros((2, 2, 2)), self.length, 0.0)
        (self.folder / "uy_000.h5").write_bytes((self.folder / "ux_000.h5").read_bytes())
        (self.folder / "uz_000.h5").write_text("no HDF5")
        for name, reason in (("ux.h5", "is called"), ("ux_.h5", "is called"), ("p_000.h5", "no such file"),
                             ("uy_000.h5", "no dataset 'uy'; it has ux"), ("uz_000.h5", "not a readable")):
            with self.assertRaisesRegex(flusi.InputError, reason):
                flusi.Field(self.folder / name)

    def test_backups_are_not_snapshots(self):
        (self.folder / "runtime_backup0.h5").touch()
        with self.assertRaisesRegex(flusi.InputError, "no field files"):
            flusi.fields_in(self.folder)

    def test_surfaces_are_not_fields(self):
        """The surface of a body, and wings without a flow, have names like fields: they stand beside them."""
        write_field(self.folder, "ux", "000", np.zeros((2, 2, 2)), self.length, 0.25)
        for name in ("body_000.h5", "body_001.h5", "solid_00000.h5", "static_1.h5"):
            (self.folder / name).touch()
        self.assertEqual(flusi.fields_in(self.folder), {"000": {"ux"}})
        self.assertEqual(flusi.snapshot_times(self.folder), {"000": 0.25})


if __name__ == "__main__":
    unittest.main()
