#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""postprocess against fields that are known exactly. Sums of a few modes are band-limited: what the tools do with them is exact
up to the rounding of double precision, 1e-12 of the largest value."""
import contextlib
import io
import os
import resource
import tempfile
import tracemalloc
import unittest
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.postprocess import spectral
from flusi_msm.postprocess.command import overview, run
from flusi_msm.postprocess.registry import TOOLS

N, L = (16, 20, 24), (2.0, 3.0, 2.5)
TOLERANCE = 1e-12


def axes(n=N):
    """x, y, z as arrays that broadcast to (nz, ny, nx), and the first wavenumbers."""
    x, y, z = (np.arange(m) * edge / m for m, edge in zip(n, L))
    return x[None, None, :], y[None, :, None], z[:, None, None], *(2 * np.pi / edge for edge in L)


def flow(n=N):
    """A velocity without divergence, its curl and its pressure are known: u = (sin(az) + cos(by), 0, 0) and a mode more."""
    x, y, z, a, b, c = axes(n)
    one = np.ones((n[2], n[1], n[0]))
    u = (np.sin(c * z) + np.cos(b * y)) * one
    v = np.sin(a * x) * one
    w = np.cos(2 * a * x) * one
    return [u, v, w]


def curl(n=N):
    x, y, z, a, b, c = axes(n)
    one = np.ones((n[2], n[1], n[0]))
    return [0 * one, (c * np.cos(c * z) + 2 * a * np.sin(2 * a * x)) * one, (a * np.cos(a * x) + b * np.sin(b * y)) * one]


def save(name, values, time=0.5, length=L, **attributes):
    with h5py.File(name, "w") as file:
        data = file.create_dataset(Path(name).stem.split("_")[0], data=values)
        data.attrs["time"] = np.array([time])
        data.attrs["domain_size"] = np.array(length)
        data.attrs["nxyz"] = np.array(values.shape[::-1], dtype="i4")
        for key, value in attributes.items():
            data.attrs[key] = np.array([value])


def load(name):
    with h5py.File(name) as file:
        return file[Path(name).stem.split("_")[0]][:]


def call(*words):
    """What a tool prints."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        run([str(word) for word in words])
    return out.getvalue()


class Postprocess(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.before = os.getcwd()
        os.chdir(self.folder.name)
        for c, values in zip("xyz", flow()):
            save(f"u{c}_01.h5", values, nu=0.1)
        self.u = ["ux_01.h5", "uy_01.h5", "uz_01.h5"]

    def tearDown(self):
        os.chdir(self.before)
        self.folder.cleanup()

    def near(self, found, exact, tolerance=TOLERANCE):
        self.assertEqual(found.shape, exact.shape)
        self.assertLess(np.abs(found - exact).max(), tolerance * max(1.0, np.abs(exact).max()))

    def refused(self, text, *words):
        with self.assertRaises(InputError) as caught:
            call(*words)
        self.assertIn(text, str(caught.exception))

    def test_curl(self):
        names = ["vorx_01.h5", "vory_01.h5", "vorz_01.h5"]
        call("vorticity", *self.u, *names)
        for name, exact in zip(names, curl()):
            self.near(load(name), exact)
        call("--vor-abs", *self.u, "vorabs_01.h5")
        self.near(load("vorabs_01.h5"), np.sqrt(sum(w**2 for w in curl())))
        call("helicity", *self.u, "hel_01.h5")
        self.near(load("hel_01.h5"), sum(u * w for u, w in zip(flow(), curl())))
        call("vor2u", *names, "--outfiles", "a_01.h5", "b_01.h5", "c_01.h5")
        for name, u in zip("abc", flow()):
            self.near(load(f"{name}_01.h5"), u)

    def test_derivatives(self):
        x, y, z, a, b, c = axes()
        save("f_01.h5", np.sin(a * x) * np.cos(2 * b * y) * np.sin(3 * c * z))
        call("gradient", "f_01.h5", "fx_01.h5", "fy_01.h5", "fz_01.h5")
        self.near(load("fx_01.h5"), a * np.cos(a * x) * np.cos(2 * b * y) * np.sin(3 * c * z))
        self.near(load("fy_01.h5"), -2 * b * np.sin(a * x) * np.sin(2 * b * y) * np.sin(3 * c * z))
        self.near(load("fz_01.h5"), 3 * c * np.sin(a * x) * np.cos(2 * b * y) * np.cos(3 * c * z))
        call("divergence", "fx_01.h5", "fy_01.h5", "fz_01.h5", "div_01.h5")
        self.near(load("div_01.h5"), -(a**2 + 4 * b**2 + 9 * c**2) * load("f_01.h5"))
        # Differences of second and fourth order see sin(h k)/h and their combination in place of k.
        h = L[0] / N[0]
        second, far = np.sin(a * h) / h, np.sin(2 * a * h) / (2 * h)
        for option, k in (("second-order", second), ("fourth-order", (4 * second - far) / 3)):
            call("gradient", "f_01.h5", "fx_02.h5", "fy_02.h5", "fz_02.h5", f"--{option}")
            self.near(load("fx_02.h5"), k * np.cos(a * x) * np.cos(2 * b * y) * np.sin(3 * c * z))

    def test_q(self):
        x, y, z, a, b, c = axes()
        call("Q", *self.u, "Q_01.h5")
        # Q = -(du/dy dv/dx + du/dz dw/dx): all other products vanish.
        exact = b * np.sin(b * y) * a * np.cos(a * x) + c * np.cos(c * z) * 2 * a * np.sin(2 * a * x)
        self.near(load("Q_01.h5"), exact * np.ones((N[2], N[1], N[0])))
        # Taylor and Green's vortex, whose diagonal derivatives do not vanish: Q = -(ux_x^2 + ux_y uy_x).
        save("ux_02.h5", np.sin(a * x) * np.cos(b * y) * np.ones_like(z))
        save("uy_02.h5", -a / b * np.cos(a * x) * np.sin(b * y) * np.ones_like(z))
        save("uz_02.h5", np.zeros((N[2], N[1], N[0])))
        call("Q", "ux_02.h5", "uy_02.h5", "uz_02.h5", "Q_02.h5")
        self.near(load("Q_02.h5"), -a**2 * ((np.cos(a * x) * np.cos(b * y))**2 - (np.sin(a * x) * np.sin(b * y))**2) * np.ones_like(z))

    def test_pressure(self):
        """-laplace p = d_i d_j u_i u_j = -2 Q for a flow without divergence; every product of the two modes is one mode."""
        x, y, z, a, b, c = axes()
        call("pressure", *self.u, "p_01.h5", "--zero-mean", "--all-modes")
        exact = (2 * a * b * np.sin(b * y) * np.cos(a * x) / -(a**2 + b**2)
                 + 4 * a * c * np.cos(c * z) * np.sin(2 * a * x) / -(4 * a**2 + c**2)) * np.ones((N[2], N[1], N[0]))
        self.near(load("p_01.h5"), exact)
        call("p2Q", "p_01.h5", "Q_02.h5")
        call("Q", *self.u, "Q_01.h5")
        self.near(load("Q_02.h5"), load("Q_01.h5"))
        call("pressure", *self.u, "p_02.h5")
        self.assertAlmostEqual(load("p_02.h5").mean(), -0.5 * sum(np.mean(u**2) for u in flow()), places=12)

    def test_pressure_of_solids(self):
        """A fluid at rest in a solid that moves with a gradient everywhere, mask = epsi: -laplace p = -div us, p is its potential."""
        x, y, z, a, b, c = axes()
        p = np.sin(a * x) * np.cos(2 * b * y) * np.sin(c * z)
        save("mask_01.h5", np.full(p.shape, 0.01), epsi=0.01)
        save("p_00.h5", p)
        call("gradient", "p_00.h5", "usx_01.h5", "usy_01.h5", "usz_01.h5", "--double-precision")
        for c in "xyz":
            save(f"u{c}_02.h5", np.zeros(p.shape))
        call("pressure", "ux_02.h5", "uy_02.h5", "uz_02.h5", "p_01.h5", "mask_01.h5", "usx_01.h5", "usy_01.h5", "usz_01.h5", "--all-modes")
        self.near(load("p_01.h5"), p)

    def test_spectrum(self):
        call("spectrum", *self.u, "E.txt")
        k, total, ux, uy, uz = np.loadtxt("E.txt", comments="%").T
        dk = 2 * np.pi / max(L)
        self.near(k, dk * np.arange(len(k)))
        self.assertAlmostEqual(total.sum(), 0.5 * sum(np.mean(u**2) for u in flow()), places=13)
        self.near(total, ux + uy + uz)
        expected = np.zeros((3, len(k)))
        for row, edge, number in ((0, L[2], 1), (0, L[1], 1), (1, L[0], 1), (2, L[0], 2)):
            expected[row, round(2 * np.pi / edge * number / dk)] += 0.25  # a mode of amplitude 1 has the mean square 1/2
        self.near(np.array([ux, uy, uz]), expected)
        call("spectrum", "ux_01.h5", "Ex.txt")
        self.near(np.loadtxt("Ex.txt", comments="%"), np.array([k, ux]).T)
        self.refused("UX UY UZ OUT.txt, or FIELD OUT.txt", "spectrum", "ux_01.h5", "uy_01.h5", "E.txt")
        # The highest mode of an even number of points stands alone.
        save("ux_02.h5", (-1.0)**np.arange(16) * np.ones((N[2], N[1], N[0])))
        call("spectrum", "ux_02.h5", "uy_01.h5", "uz_01.h5", "E.txt")
        self.assertAlmostEqual(np.loadtxt("E.txt", comments="%")[:, 2].sum(), 0.5, places=13)

    def test_scales(self):
        energy = 0.5 * sum(np.mean(u**2) for u in flow())
        dissipation = 0.1 * sum(np.mean(w**2) for w in curl())
        call("field-analysis", *self.u, "a.txt")
        call("turbulence-analysis", *self.u, "0.1", "t.txt")
        rows = {line[26:]: float(line[:24]) for name in "at" for line in Path(f"{name}.txt").read_text().splitlines()}
        self.assertAlmostEqual(rows["mean dissipation"], dissipation, places=12)
        self.assertAlmostEqual(rows["total kinetic energy"], energy * np.prod(L), places=12)
        self.assertAlmostEqual(rows["mean kinetic energy"], energy, places=12)
        self.assertAlmostEqual(rows["Kolmogorov's length"], (0.1**3 / dissipation)**0.25, places=12)
        self.assertAlmostEqual(rows["Taylor's length, sqrt(15 nu/eps) rms"], np.sqrt(15 * 0.1 / dissipation * 2 / 3 * energy), places=12)
        self.refused("must be positive", "turbulence-analysis", *self.u, "-1", "t.txt")

    def test_sizes(self):
        for n in ((32, 30, 24), (16, 20, 25), (8, 10, 12), (9, 11, 13)):
            call("upsample", "ux_01.h5", "ux_02.h5", *n)
            self.near(load("ux_02.h5"), flow(n)[0])
        # The highest mode: cos(8 a x) on 16 points, and cos(4 a x) when 8 are left.
        x, _, _, a, _, _ = axes((32, 20, 24))
        save("f_01.h5", (-1.0)**np.arange(16) * np.ones((N[2], N[1], N[0])))
        call("upsample", "f_01.h5", "f_02.h5", 32, 20, 24)
        self.near(load("f_02.h5"), np.cos(8 * a * x) * np.ones((24, 20, 32)))
        save("f_01.h5", np.cos(4 * a * x[:, :, ::2]) * np.ones((N[2], N[1], N[0])))
        call("upsample", "f_01.h5", "f_02.h5", 8, 20, 24)
        self.near(load("f_02.h5"), (-1.0)**np.arange(8) * np.ones((24, 20, 8)))
        call("extract-subset", "ux_01.h5", "ux_03.h5", "2:3:14", "0:1:9999", "5:5")
        self.near(load("ux_03.h5"), flow()[0][5:6, :, 2:15:3], 1e-300)
        with h5py.File("ux_03.h5") as file:
            attributes = file["ux"].attrs
            self.near(attributes["domain_size"], np.array([5 * 3 * L[0] / 16, L[1], L[2] / 24]))
            self.near(attributes["origin"], np.array([2 * L[0] / 16, 0, 5 * L[2] / 24]))
            self.assertEqual(list(attributes["nxyz"]), [5, 20, 1])
        call("extract-slice", "uy_01.h5", "uy_03.h5", "x", 3)
        self.near(load("uy_03.h5"), flow()[1][:, :, 3:4], 1e-300)
        call("mean-over", "ux_01.h5", "ux_04.h5", "z")
        self.near(load("ux_04.h5"), flow()[0].mean(axis=0, keepdims=True))
        call("mean-2D", "all", "ux_01.h5", "profile")
        call("-p", "--max-over-x", "uy_01.h5", "largest.txt")
        x, y, z, a, b, c = axes()
        for name, mean, place in (("profile_x", 0 * x, x), ("profile_y", np.cos(b * y), y), ("profile_z", np.sin(c * z), z),
                                  ("largest.txt", np.sin(a * x), x)):
            self.near(np.loadtxt(name, comments="%"), np.array([mean.ravel(), place.ravel()]).T)
        call("shift", "uy_01.h5", "uy_05.h5", 0.3, L[1] / 20, 0)
        self.near(load("uy_05.h5"), np.sin(a * (x - 0.3)) * np.ones((N[2], N[1], N[0])))

    def test_points(self):
        u = flow()
        call("magnitude", *self.u, "m_01.h5")
        self.near(load("m_01.h5"), np.sqrt(sum(v**2 for v in u)))
        for word, exact in (("+", u[0] + u[1]), ("-", u[0] - u[1]), ("multiply", u[0] * u[1])):
            call("simple-field-operation", "ux_01.h5", word, "uy_01.h5", "o_01.h5")
            self.near(load("o_01.h5"), exact)
        self.refused("is 0 at some points", "simple-field-operation", "ux_01.h5", "/", "uy_01.h5", "o_01.h5")
        call("simple-field-operation", "ux_01.h5", "/", "uy_01.h5", "o_01.h5", "--where-zero", "7")
        self.assertEqual(load("o_01.h5")[0, 0, 0], 7)
        save("f_00.h5", u[0], 0.0)
        save("f_01.h5", -2 * u[0], 1.0)
        save("f_02.h5", u[1], 3.0)
        call("time-avg", "f_00.h5", "f_01.h5", "f_02.h5", "mean_00.h5")
        self.near(load("mean_00.h5"), (u[1] - u[0]) / 3)
        Path("list.txt").write_text("f_02.h5\nf_00.h5\nf_01.h5\n")
        call("time-avg", "list.txt", "mean_01.h5", "--trapezoidal")
        self.near(load("mean_01.h5"), (0.5 * u[0] - 1.5 * 2 * u[0] + u[1]) / 3)
        call("max-over-time", "list.txt", "largest_00.h5")
        self.near(load("largest_00.h5"), np.maximum(np.abs(2 * u[0]), np.abs(u[1])))

    def test_many_files(self):
        """Means over time hold two slabs and one open file, however many files there are."""
        names, field = [f"f_{i:02}.h5" for i in range(60)], 8 * np.prod(N)
        for i, name in enumerate(names):
            save(name, np.full((N[2], N[1], N[0]), i - 40.0))
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (40, hard))
        tracemalloc.start()
        try:
            call("time-avg", *names, "mean_00.h5")
            call("max-over-time", *names, "largest_00.h5")
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        self.near(load("mean_00.h5"), np.full((N[2], N[1], N[0]), -10.5))
        self.near(load("largest_00.h5"), np.full((N[2], N[1], N[0]), 40.0))
        self.assertLess(peak, 10 * field)

    def test_numbers(self):
        save("g_01.h5", flow()[0] + 1e-3)
        lines = {line[:20].strip(): line[20:].split() for line in call("difference", "g_01.h5", "ux_01.h5").splitlines()}
        self.assertAlmostEqual(float(lines["L2 norm"][0]), 1e-3, places=15)
        self.assertAlmostEqual(float(lines["L2 norm"][2]), 1e-3, places=15)  # the mean square of ux is 1
        self.assertAlmostEqual(float(lines["largest |f|"][0]), 1e-3, places=15)
        lines = {line[:20].strip(): float(line[20:]) for line in call("statistics", "ux_01.h5").splitlines()}
        self.assertAlmostEqual(lines["standard deviation"], 1.0, places=13)
        self.assertEqual(lines["largest"], flow()[0].max())
        save("h_01.h5", np.arange(2.0 * 3 * 4).reshape(2, 3, 4))
        call("pdf", "h_01.h5", "pdf.txt", "--bins", 4)
        self.near(np.loadtxt("pdf.txt", comments="%")[:, 1], np.full(4, 1 / 23))

    def test_series(self):
        Path("a.t").write_text("% t a b\n0.0 1.0 0.0\n0.5 -4.0 0.0\n")
        Path("b.t").write_text("% t a b\n0.0 1.0 0.0\n0.5 -4.5 0.0\n")
        row = call("compare-timeseries", "b.t", "a.t").splitlines()[1].split()
        self.assertEqual([float(v) for v in row], [2, 0.5, 0.125])
        Path("b.t").write_text("0.0 1.0 0.0\n0.6 -4.5 0.0\n")
        self.refused("different times", "compare-timeseries", "b.t", "a.t")
        Path("b.t").write_text("0.0 1.0 0.0\n")
        self.refused("1 records", "compare-timeseries", "b.t", "a.t")
        self.refused("no such file", "compare-timeseries", "c.t", "a.t")

    def test_files(self):
        """Names and attributes are FLUSI's, precision stays, and a failed tool leaves nothing behind."""
        save("ux_09.h5", flow()[0].astype("f4"))
        call("cp", "ux_09.h5", "v_09.h5")
        with h5py.File("v_09.h5") as file:
            self.assertEqual(list(file), ["v"])
            self.assertEqual(file["v"].dtype, "f4")
            self.assertEqual(file["v"].attrs["time"][0], 0.5)
        call("cp", "ux_09.h5", "v_10.h5", "--double-precision")
        self.assertEqual(load("v_10.h5").dtype, "f8")
        call("set-hdf5-attribute", "v_10.h5", "origin", 3, "1,2,3.5")
        with h5py.File("v_10.h5") as file:
            self.assertEqual(list(file["v"].attrs["origin"]), [1, 2, 3.5])
        before = sorted(os.listdir())
        save("bad_01.h5", np.full(flow()[0].shape, np.nan))
        self.refused("not finite", "cp", "bad_01.h5", "out_01.h5")
        self.assertEqual(sorted(os.listdir()), sorted([*before, "bad_01.h5"]))

    def test_mistakes(self):
        save("ux_05.h5", flow((8, 20, 24))[0])
        save("uy_06.h5", flow()[1], time=0.7)
        self.refused("do you mean vorticity?", "vorticty")
        self.refused("no such file", "remove-mean", "gone_01.h5", "x_01.h5")
        self.refused("has 8 x 20 x 24 points", "magnitude", "uy_01.h5", "ux_05.h5", "uz_01.h5", "m_01.h5")
        self.refused("give files of one time", "magnitude", "ux_01.h5", "uy_06.h5", "uz_01.h5", "m_01.h5")
        self.refused("would overwrite an input", "remove-mean", "ux_01.h5", "./ux_01.h5")
        self.refused("end in .h5", "remove-mean", "ux_01.h5", "out.dat")
        self.refused("2 arguments are given; use: postprocess upsample", "upsample", "ux_01.h5", "ux_02.h5")
        self.refused("do you mean --trapezoidal?", "time-avg", "ux_01.h5", "m_01.h5", "--trapezoid")
        self.refused("holds none of the points 0 to 15", "crop", "ux_01.h5", "ux_07.h5", "16:20", "0:1", "0:1")
        self.refused("is not x, y or z", "extract-slice", "ux_01.h5", "ux_07.h5", "xy", "3")
        self.refused("epsi", "pressure", *self.u, "p_01.h5", "uy_01.h5", *self.u)

    def test_help(self):
        text = overview()
        for name in TOOLS:
            self.assertIn(f"postprocess {TOOLS[name].name}", call(name, "--help"))
            self.assertIn(TOOLS[name].about, text)

    def test_slabs(self):
        """Cutting a field into slabs changes nothing but the order of sums."""
        from flusi_msm.postprocess import fields
        whole, kept = [spectral.derivative(fields.Field(name), c) for c, name in ((0, "uz_01.h5"), (2, "ux_01.h5"))], fields.SLAB_BYTES
        try:
            fields.SLAB_BYTES = 8 * 16 * 20 * 5
            for exact, c, name in zip(whole, (0, 2), ("uz_01.h5", "ux_01.h5")):
                self.near(spectral.derivative(fields.Field(name), c), exact, 1e-300)
        finally:
            fields.SLAB_BYTES = kept


if __name__ == "__main__":
    unittest.main()
