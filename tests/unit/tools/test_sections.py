# SPDX-License-Identifier: GPL-3.0-or-later
"""Wing surfaces and the spanwise vorticity on their sections, where both are known."""
import shutil
import tempfile
import unittest
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.plots.slice import values_on_plane
from flusi_msm.render.command import Scene
from flusi_msm.render.wing_surface import load_surface
from flusi_msm.results import flow
from flusi_msm.results import section as sections
from flusi_msm.results.files import InputError, Snapshot, load_field
from flusi_msm.results.wing_sides import WingSides, draw_sides
from synthetic import axes_of, grid, picture, rectangle, run_tool, write_ball, write_field, write_velocity, write_wing

N, LENGTH, LABEL = (40, 32, 24), (4.0, 4.0, 2.0), "000500"
MATRIX = axes_of((0.2, 1.0, 0.3), (-1.0, 0.1, 0.5))
HINGE = np.array([2.0, 3.2, 1.7])  # the wing crosses two faces of the box


class Section(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.at = Snapshot(self.folder, LABEL)
        for side in ("left", "right"):
            write_wing(self.folder, LABEL, side, *rectangle(1.2, 0.6), HINGE, MATRIX, 0.5)

    def constant_vorticity(self, vector):
        """That of a solid body rotation with half of this angular velocity."""
        for c, value in zip("xyz", vector):
            write_field(self.folder, f"vor{c}", LABEL, np.full(N[::-1], value), LENGTH, 0.5)


class Surface(Section):
    def test_frames(self):
        wing = load_surface(self.at, "left")
        np.testing.assert_allclose(wing.in_wing_frame(), rectangle(1.2, 0.6)[0], atol=1e-14)
        np.testing.assert_allclose(wing.in_space(wing.in_wing_frame()), wing.points, atol=1e-14)
        self.assertAlmostEqual(wing.length(), 1.2)

    def test_cut_of_a_flat_wing(self):
        wing = load_surface(self.at, "left")
        for x in (0.3, 0.45, 0.5 * 1.2):  # between points and through points
            cut = wing.cut(x)
            self.assertAlmostEqual(np.sum(np.linalg.norm(cut[:, 1] - cut[:, 0], axis=1)), 0.6, places=9)
            self.assertAlmostEqual(cut[..., 0].min(), -0.4, places=9)
            self.assertAlmostEqual(cut[..., 0].max(), 0.2, places=9)
            np.testing.assert_allclose(cut[..., 1], 0, atol=1e-12)
        self.assertEqual(len(wing.cut(1.3)), 0)

    def test_cut_of_a_twisted_wing(self):
        points, triangles = rectangle(1.2, 0.6, 60, 2)
        twisted = points.copy()  # y, z turn with the span: the chord at x lies at the angle x
        twisted[:, 1], twisted[:, 2] = points[:, 1] * np.cos(points[:, 0]), points[:, 1] * np.sin(points[:, 0])
        write_wing(self.folder, LABEL, "left", twisted, triangles, HINGE, MATRIX, 0.5)
        cut = load_surface(self.at, "left").cut(0.61).reshape(-1, 2)
        angle = np.arctan2(-cut[:, 1], -cut[:, 0])[cut[:, 0] < -0.1]
        # between rows of points: on the chordwise edge exact to the second order, on a diagonal to half a row
        np.testing.assert_allclose(angle, 0.61, atol=0.01)
        self.assertGreater(len(angle), 1)

    def test_the_rigid_twin(self):
        """The wing without its displacement; rigid wings have none."""
        points, triangles = rectangle(1.2, 0.6)
        bent = np.column_stack([0 * points[:, 0], 0 * points[:, 0], 0.3 * points[:, 0]**2])
        write_wing(self.folder, LABEL, "left", points, triangles, HINGE, MATRIX, 0.5, bent)
        wing = load_surface(self.at, "left")
        np.testing.assert_allclose(wing.in_wing_frame(wing.rigid_points), points, atol=1e-14)
        np.testing.assert_allclose(wing.cut(0.6, wing.rigid_points)[..., 1], 0, atol=1e-12)
        np.testing.assert_allclose(wing.cut(0.6)[..., 1], 0.108, atol=1e-9)
        self.assertIsNone(load_surface(self.at, "right").rigid_points)

    def test_files_that_are_wrong(self):
        import h5py
        path = self.folder / f"wing_left_{LABEL}.h5"
        with h5py.File(path, "a") as file:
            file["triangles"][0] = (0, 1, 1000)
        with self.assertRaisesRegex(InputError, "names a point that is not there"):
            load_surface(self.at, "left")
        with h5py.File(path, "a") as file:
            del file["points"]
        with self.assertRaisesRegex(InputError, "not a wing surface.*points"):
            load_surface(self.at, "left")
        path.write_text("no HDF5")
        with self.assertRaisesRegex(InputError, "not a readable HDF5 file"):
            load_surface(self.at, "left")
        path.unlink()
        with self.assertRaisesRegex(InputError, "wing_left_000500.h5: no such file"):
            load_surface(self.at, "left")


class Interpolation(Section):
    points = np.random.default_rng(5).uniform(-5, 9, (300, 3))

    def test_what_is_linear_between_grid_points_is_exact_around_the_box(self):
        values = np.random.default_rng(7).normal(size=N[::-1]).astype("f4")
        write_field(self.folder, "p", LABEL, values, LENGTH, 0.5)
        for points in (self.points, self.points[:2], np.array([[3.95, -0.03, 1.97]])):
            got = flow.at_points(self.at, "p", points)
            place = points / (np.array(LENGTH) / N)
            lower = np.floor(place).astype(int)
            wanted = np.zeros(len(points))
            for m, (index, part) in enumerate(zip(lower, place - lower)):
                for corner in np.ndindex(2, 2, 2):
                    i, j, k = (index + corner) % N
                    wanted[m] += np.prod([p if c else 1 - p for c, p in zip(corner, part)]) * values[k, j, i]
            np.testing.assert_allclose(got, wanted, atol=1e-12)

    def test_vorticity_from_the_velocity(self):
        curl = write_velocity(self.folder, LABEL, N, LENGTH, 0.5)
        points = np.array([(i * LENGTH[0] / N[0], j * LENGTH[1] / N[1], k * LENGTH[2] / N[2])
                           for i, j, k in ((39, 31, 23), (40, 33, 24), (41, 34, 26))])  # grid points around a corner
        for direction in np.vstack([np.eye(3), [0.6, 0.0, -0.8]]):
            got = flow.vorticity_at(self.at, points, direction)
            wanted = [sum(d * c[k % N[2], j % N[1], i % N[0]] for d, c in zip(direction, curl))
                      for i, j, k in ((39, 31, 23), (40, 33, 24), (41, 34, 26))]
            np.testing.assert_allclose(got, wanted, atol=1e-5)  # single precision in the files
        exact = np.sqrt(sum(c**2 for c in curl))
        np.testing.assert_allclose(flow.vorticity_magnitude(self.at), exact, atol=2e-5)
        np.testing.assert_allclose(flow.vorticity_magnitude(self.at, 3), exact[::3, ::3, ::3], atol=2e-5)
        for c, values in zip("xyz", curl):
            write_field(self.folder, f"vor{c}", LABEL, values, LENGTH, 0.5)
        np.testing.assert_allclose(flow.vorticity_magnitude(self.at, 3), exact[::3, ::3, ::3], atol=1e-5)
        write_field(self.folder, "vorabs", LABEL, 2 * exact, LENGTH, 0.5)
        np.testing.assert_allclose(flow.vorticity_magnitude(self.at, 2), 2 * exact[::2, ::2, ::2], atol=1e-5)

    def test_files_that_are_missing(self):
        write_field(self.folder, "ux", LABEL, np.zeros(N[::-1]), LENGTH, 0.5)
        with self.assertRaisesRegex(InputError, "missing: uy, uz"):
            flow.vorticity_at(self.at, self.points, (1, 0, 0))


class SpanwiseVorticity(Section):
    def sections(self, side="left"):
        wing = load_surface(self.at, side)
        return sections.sections_of(self.at, wing, (0.25, 0.5, 0.75), 0.1)

    def test_solid_body_rotation(self):
        vector = np.array([3.0, -5.0, 7.0])
        self.constant_vorticity(vector)
        for section in self.sections():
            np.testing.assert_allclose(section.vorticity, MATRIX[0] @ vector, rtol=1e-12)

    def test_the_right_place_in_space(self):
        curl = write_velocity(self.folder, LABEL, N, LENGTH, 0.5)
        for section, fraction in zip(self.sections(), (0.25, 0.5, 0.75)):
            z, y = np.meshgrid(section.z, section.y, indexing="ij")
            x = HINGE + 1.2 * fraction * MATRIX[0] + y[..., None] * MATRIX[1] + z[..., None] * MATRIX[2]
            k = 2 * np.pi / np.array(LENGTH)
            s, c = np.sin(k * x), np.cos(k * x)
            exact = np.stack([-k[1] * s[..., 0] * s[..., 1] - k[2] * c[..., 2] * c[..., 0],
                              -k[2] * s[..., 1] * s[..., 2] - k[0] * c[..., 0] * c[..., 1],
                              -k[0] * s[..., 2] * s[..., 0] - k[1] * c[..., 1] * c[..., 2]], axis=-1) @ MATRIX[0]
            # of linear interpolation: h^2 k^2/8 of the largest value, summed over directions
            largest = max(np.abs(part).max() for part in curl) * np.sum(np.abs(MATRIX[0]))
            h = np.array(LENGTH) / N
            np.testing.assert_allclose(section.vorticity, exact, atol=largest * np.sum((h * k)**2) / 8)

    def test_the_mean_outside_of_the_wing(self):
        self.constant_vorticity((1.0, 1.0, 1.0))
        write_ball(self.folder, LABEL, N, LENGTH, 0.5, 0.6)
        x, _, _ = grid(N, LENGTH)
        write_field(self.folder, "mask", LABEL, np.broadcast_to(x < 2, N[::-1]).astype(float), LENGTH, 0.5)
        section = self.sections()[0]
        inside = section.vorticity.size - section.outside().size
        self.assertGreater(inside, 0.2 * section.vorticity.size)
        self.assertLess(inside, 0.8 * section.vorticity.size)


class Pictures(Section):
    def test_pictures(self):
        write_velocity(self.folder, LABEL, N, LENGTH, 0.5)
        write_ball(self.folder, LABEL, N, LENGTH, 0.5, 0.6)
        one = self.folder / "section_right_000500_0.5.png"
        done = run_tool("plot_slice", self.folder, "--section", "right", 0.5)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("span 0.5: spanwise vorticity", done.stdout)
        three = self.folder / "three.png"
        done = run_tool("plot_slice", self.folder, "--section", "left", "-o", three)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(picture(three)[1], 1.8 * picture(one)[1])
        self.assertGreater(picture(three)[2], 100)

    def test_the_leading_edge_is_left_and_the_upper_side_up(self):
        from matplotlib.image import imread
        for side, upper in (("left", -1), ("right", 1)):
            x, y, z = grid(N, LENGTH)
            place = np.stack(np.broadcast_arrays(x, y, z), axis=-1) - HINGE
            place -= np.round(place / LENGTH) * LENGTH
            local = place @ MATRIX.T
            vortex = np.exp(-((local[..., 1] - 0.35)**2 + (local[..., 2] - 0.25 * upper)**2) / 0.15**2)
            for c in range(3):
                write_field(self.folder, f"vor{'xyz'[c]}", LABEL, vortex * MATRIX[0][c], LENGTH, 0.5)
            out = self.folder / f"{side}.png"
            run_tool("plot_slice", self.folder, "--section", side, 0.5, "--limit", 1, "-o", out)
            pixels = imread(str(out))[:, :-200]  # without the bar
            rows, columns = np.nonzero((pixels[..., 0] > 0.5) & (pixels[..., 1] < 0.4))
            self.assertGreater(len(rows), 500)
            self.assertLess(rows.mean(), 0.5 * pixels.shape[0])
            self.assertLess(columns.mean(), 0.45 * pixels.shape[1])

    def test_refusals(self):
        write_velocity(self.folder, LABEL, N, LENGTH, 0.5)

        def refused(*arguments, because):
            done = run_tool("plot_slice", *arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(because, done.stderr)
        refused(self.folder, "--section", "middle", because="takes left or right")
        refused(self.folder, "--section", "left", 1.5, because="between 0 and 1")
        refused(self.folder, "--section", "left", "half", because="not 'left half'")
        refused(self.folder, "--section", "left", "--plane", "x", because="has a plane and a quantity of its own")
        (self.folder / "wing_left_000500.h5").unlink()
        refused(self.folder, "--section", "left", because="wing_left_000500.h5: no such file")


class Rings(Section):
    """Waves of three grid spacings, the shortest that a run with wings without thickness keeps, are not drawn."""

    def waves(self, lengths):
        """A sum of waves of so many points along x, y and z."""
        return sum(np.cos(2 * np.pi * at / length) for at, length in zip(np.indices(N[::-1])[::-1], lengths))

    def test_waves(self):
        """The shortest ones vanish, others keep (1 + 2 cos)/3 of their height, and the mean stays."""
        n = [n - n % 3 for n in N]
        wave = 5 + sum(np.cos(2 * np.pi * at / 3) for at in np.indices(n[::-1]))
        write_field(self.folder, "vorx", LABEL, wave, LENGTH, 0.5)
        np.testing.assert_allclose(load_field(self.at, "vorx", True).data, 5, atol=1e-6)
        write_field(self.folder, "vorx", LABEL, self.waves(N), LENGTH, 0.5)
        expected = sum((1 + 2 * np.cos(2 * np.pi / n)) / 3 * np.cos(2 * np.pi * at / n) for at, n in zip(np.indices(N[::-1])[::-1], N))
        np.testing.assert_allclose(load_field(self.at, "vorx", True).data, expected, atol=1e-6)
        write_field(self.folder, "vorx", LABEL, self.waves(N)[:, :, :1], LENGTH, 0.5)
        self.assertEqual(load_field(self.at, "vorx", True).data.shape, (N[2], N[1], 1), "a plane flow")

    def test_vorticity(self):
        """Means commute with derivatives, so that velocity and vorticity give the same; the magnitude is that of the means."""
        curl = write_velocity(self.folder, LABEL, N, LENGTH, 0.5)
        points = Interpolation.points[:20]
        from_velocity = flow.vorticity_at(self.at, points, MATRIX[0], True)
        size, plane = flow.vorticity_magnitude(self.at, 2, True), values_on_plane(self.at, "vorabs", 1, 4, True)
        write_field(self.folder, "vorabs", LABEL, 0 * curl[0], LENGTH, 0.5)
        for c, values in zip("xyz", curl):
            write_field(self.folder, f"vor{c}", LABEL, values, LENGTH, 0.5)
        np.testing.assert_allclose(flow.vorticity_at(self.at, points, MATRIX[0], True), from_velocity, atol=1e-5)
        parts = [load_field(self.at, f"vor{c}", True).data for c in "xyz"]
        corner = flow.vorticity_at(self.at, np.zeros((1, 3)), MATRIX[0], True)
        np.testing.assert_allclose(corner, MATRIX[0] @ [part[0, 0, 0] for part in parts], atol=2e-5)
        means = np.sqrt(sum(part**2 for part in parts))
        np.testing.assert_allclose(size, means[::2, ::2, ::2], atol=2e-5)
        np.testing.assert_allclose(flow.vorticity_magnitude(self.at, 2, True), means[::2, ::2, ::2], atol=2e-5)
        np.testing.assert_allclose(plane, means[:, 4], atol=2e-5)
        np.testing.assert_allclose(values_on_plane(self.at, "vorabs", 1, 4, True), means[:, 4], atol=2e-5)
        self.assertEqual(flow.vorticity_magnitude(self.at, 2).max(), 0, "as it is stored")

    def test_where_wings_have_no_thickness(self):
        """Their runs have a slip.t; --stored draws what is stored, as in other runs."""
        write_velocity(self.folder, LABEL, N, LENGTH, 0.5)
        stored = flow.vorticity_magnitude(self.at)

        def shots(name, *options):
            for kind, arguments in (("plane", ()), ("section", ("--section", "left", 0.5))):
                path = self.folder / f"{name}_{kind}.png"
                self.assertEqual(run_tool("plot_slice", self.folder, *arguments, *options, "-o", path).returncode, 0)
                yield path.read_bytes()
        before = list(shots("before"))
        np.testing.assert_array_equal(Scene(self.at, None).values, stored)
        (self.folder / "slip.t").touch()
        for one, other, as_stored in zip(before, shots("smooth"), shots("stored", "--stored")):
            self.assertEqual(one, as_stored)
            self.assertNotEqual(one, other)
        np.testing.assert_array_equal(Scene(self.at, None, stored=True).values, stored)
        np.testing.assert_allclose(Scene(self.at, None).values, flow.vorticity_magnitude(self.at, smooth=True))
        self.assertGreater(np.abs(Scene(self.at, None).values - stored).max(), 0.01)


class Sides(Section):
    """Pressure and traction on both sides of a wing."""

    def write_sides(self, lacking=None):
        """Pressure x on the dorsal side, -x on the other one; traction (y, 2, 3) and (0, -1, 0) in the wing frame, at the middles of
        the triangles."""
        points, triangles = rectangle(1.2, 0.6)
        middle = points[triangles].mean(axis=1)
        traction = {"dorsal": np.column_stack([middle[:, 1], 0 * middle[:, 0] + 2, 0 * middle[:, 0] + 3]),
                    "ventral": np.tile([0.0, -1.0, 0.0], (len(triangles), 1))}
        path = self.folder / f"wing_left_{LABEL}.h5"
        with h5py.File(path, "a") as file:
            for side, sign in (("dorsal", 1), ("ventral", -1)):
                file[f"pressure_{side}"] = sign * middle[:, 0]
                file[f"traction_{side}"] = traction[side] @ MATRIX
            file.attrs["side_distance"] = 0.1
            if lacking:
                del file[lacking]
        return path, middle, traction

    def test_values(self):
        """Tractions are in the frame of the wing; arrows are means over triangles, which keep what is linear."""
        path, middle, traction = self.write_sides()
        sides = WingSides(path)
        self.assertEqual(sides.distance, 0.1)
        for side in traction:
            np.testing.assert_allclose(sides.traction[side], traction[side], atol=1e-14)
        places, vectors = sides.arrows("dorsal", 0.2)
        self.assertEqual(len(places), 6 * 3, "squares of the rectangle")
        np.testing.assert_allclose(vectors, np.column_stack([places[:, 1], 0 * places[:, 1] + 2]), atol=1e-14)

    def test_picture(self):
        """Columns are times; two rows have the pressure, two the magnitude of the traction with its arrows."""
        path, middle, traction = self.write_sides()
        figure = draw_sides(2 * [WingSides(path)])
        self.addCleanup(plt.close, figure)
        axes = np.array(figure.axes[:8]).reshape(4, 2)
        shown = [ax.collections[0].get_array() for ax in axes[:, 1]]
        for values, expected in zip(shown, (middle[:, 0], -middle[:, 0], *(np.linalg.norm(t, axis=1) for t in traction.values()))):
            np.testing.assert_allclose(values, expected, atol=1e-14)
        self.assertEqual([len(ax.collections) for ax in axes[:, 0]], [1, 1, 2, 2])
        np.testing.assert_allclose(axes[3, 0].collections[1].V, -1)
        np.testing.assert_allclose(axes[2, 0].collections[1].V, 2)

    def test_tool(self):
        path = self.write_sides()[0]
        done = run_tool("plot_wing", "--sides", path, path)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertGreater(picture(self.folder / f"wing_left_{LABEL}_sides.png")[2], 100)
        done = run_tool("plot_wing", "--sides", path, "--shape", path)
        self.assertEqual(done.returncode, 2)

    def test_start(self):
        """The surface at the start of a run has neither pressure nor traction and is left out."""
        path = self.write_sides()[0]
        start = Path(path).with_name("wing_left_000000.h5")
        shutil.copy(path, start)
        with h5py.File(start, "r+") as file:
            for name in [name for name in file if name.startswith(("pressure", "traction"))]:
                del file[name]
        done = run_tool("plot_wing", "--sides", start, path)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("wing_left_000000.h5: left out", done.stderr)

    def test_lacking(self):
        path = self.write_sides("traction_ventral")[0]
        done = run_tool("plot_wing", "--sides", path)
        self.assertEqual(done.returncode, 2)
        self.assertIn("no traction_ventral; a run with [Saving] iSaveWingSides = 1 writes them", done.stderr)


if __name__ == "__main__":
    unittest.main()
