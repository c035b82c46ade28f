# SPDX-License-Identifier: GPL-3.0-or-later
"""render: iso-surfaces with known area and volume, pixels with known colours, pictures, mistakes by name."""
import io
import os
import subprocess
import sys
import tempfile
import unittest
from contextlib import redirect_stdout
from pathlib import Path
from unittest import mock

import matplotlib

matplotlib.use("Agg")
import h5py
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from flusi_msm.render import command as render
from flusi_msm.render import renderers
from flusi_msm.render.isosurface import area, iso_surface
from flusi_msm.render.movie import choose_movie, write_movie
from flusi_msm.results.files import InputError
from synthetic import axes_of, grid, picture, rectangle, run_tool, write_ball, write_field, write_velocity, write_wing


def sphere(n, radius=0.3):
    """Iso-surface of the distance from the middle of the unit cube, with twice as many points along z."""
    x, y, z = grid((n, n, 2 * n), (1.0, 1.0, 1.0))
    distance = np.sqrt((x - 0.5)**2 + (y - 0.5)**2 + (z - 0.5)**2)
    return iso_surface(-distance, -radius, (-0.5, -0.5, -0.5), (1 / n, 1 / n, 0.5 / n))


class IsoSurface(unittest.TestCase):
    def test_area_and_volume_converge_in_the_second_order(self):
        errors = []
        for n in (12, 24, 48):
            points, triangles, _ = sphere(n)
            a, b, c = (points[triangles[:, i]] for i in range(3))
            volume = np.sum(np.einsum("ij,ij->i", a, np.cross(b, c))) / 6  # positive: normals point outward
            errors.append((area(points, triangles) / (4 * np.pi * 0.09) - 1, volume / (4 / 3 * np.pi * 0.027) - 1))
        errors = np.array(errors)
        np.testing.assert_allclose(errors[1:] / errors[:-1], 0.25, rtol=0.15)
        self.assertLess(np.abs(errors[-1]).max(), 0.005)

    def test_it_is_closed(self):
        points, triangles, _ = sphere(16)
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        _, count = np.unique(edges, axis=0, return_counts=True)
        self.assertEqual(set(count), {2})
        self.assertEqual(len(points) - len(count) + len(triangles), 2)  # Euler's number of a sphere

    def test_normals_point_to_smaller_values(self):
        points, _, normals = sphere(24)
        np.testing.assert_allclose(normals, points / np.linalg.norm(points, axis=1)[:, None], atol=0.02)

    def test_nothing_at_a_level_beyond_the_field(self):
        for shape in ((4, 4, 4), (1, 4, 4)):
            points, triangles, _ = iso_surface(np.zeros(shape), 1.0, (0, 0, 0), (1, 1, 1))
            self.assertEqual((len(points), len(triangles)), (0, 0))


class Pixels(unittest.TestCase):
    """Squares in front of the camera, which looks along -x."""

    def square(self, x, half, colour, opacity):
        points = np.array([[x, -half, -half], [x, half, -half], [x, half, half], [x, -half, half]], dtype=float)
        return renderers.Surface(points, np.array([[0, 1, 2], [0, 2, 3]]), np.zeros((4, 3)), colour, opacity)

    def camera(self, surfaces, aspect=1.5):
        return renderers.Camera(0, 0, np.concatenate([s.points for s in surfaces]), aspect)

    def test_the_camera_sees_everything_and_not_much_more(self):
        points = np.random.default_rng(3).normal(size=(500, 3)) * (3, 1, 0.5)
        for view in ((0, 0), (-125, 35), (-90, 90), (200, -60)):
            place, depth = renderers.Camera(*view, points, 4 / 3).project(points)
            self.assertGreater(depth.min(), 0)
            extent = np.maximum(np.abs(place[:, 0]).max() / (4 / 3), np.abs(place[:, 1]).max())
            self.assertTrue(0.8 < extent < 1.0, extent)

    def test_layers_are_laid_over_each_other(self):
        # Ambient light only, as the normals are zero; given in an order that is not that of depth.
        surfaces = [self.square(1, 1, (1, 0, 0), 0.25), self.square(-1, 1, (0, 1, 0), 1.0),
                    self.square(0, 1, (0, 0, 1), 0.5), self.square(-2, 3, (1, 1, 1), 1.0)]
        image = renderers.render_numpy(surfaces, self.camera(surfaces), 60)
        self.assertEqual(image.shape, (60, 90, 4))
        np.testing.assert_allclose(image[30, 45], np.append(renderers.AMBIENT * np.array([0.25, 0.375, 0.375]), 1),
                                   atol=1e-12)
        np.testing.assert_array_equal(image[30, 0], 0)

    def test_coverage_where_there_is_nothing_behind(self):
        surfaces = [self.square(1, 1, (1, 0, 0), 0.25), self.square(0, 1, (0, 0, 1), 0.5)]
        image = renderers.render_numpy(surfaces, self.camera(surfaces), 60)
        alpha = 0.25 + 0.75 * 0.5
        np.testing.assert_allclose(image[30, 45], [0.5 * 0.25 / alpha, 0, 0.5 * 0.375 / alpha, alpha], atol=1e-12)

    def test_size_and_seams(self):
        surfaces = [self.square(0, 1, (1, 1, 1), 0.5)]
        camera = self.camera(surfaces)
        image = renderers.render_numpy(surfaces, camera, 200)
        half = camera.project(surfaces[0].points)[0].max() * 100
        # pixels at the rim are covered in part; on the diagonal no pixel may be drawn twice or left out
        self.assertAlmostEqual(image[..., 3].sum() / 0.5, (2 * half)**2, delta=2 * half)
        inner = image[100 - int(half) + 2:100 + int(half) - 2, 150 - int(half) + 2:150 + int(half) - 2, 3]
        np.testing.assert_allclose(inner, 0.5, atol=1e-12)

    def test_a_pixel_on_an_edge_belongs_to_one_triangle(self):
        class Straight:
            aspect, distance = 1.0, 1.0

            @staticmethod
            def project(points):
                return points[:, :2], np.ones(len(points))
        # corners at the middles of the pixels 1 and 6 of 8
        points = np.array([[-0.625, -0.625, 0], [0.625, -0.625, 0], [0.625, 0.625, 0], [-0.625, 0.625, 0]])
        for triangles in ([[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]):
            pixel, _, _, weights = renderers.fragments(points, np.array(triangles), Straight, 8, 8)
            self.assertEqual(len(pixel), 5 * 5)
            self.assertEqual(len(np.unique(pixel)), 5 * 5)
            np.testing.assert_allclose(weights.sum(axis=0), 1)

    def test_perspective_within_a_triangle(self):
        # A strip that leads away: the points found are those which the camera shows in their pixels.
        points = np.array([[0.0, -1, 0], [0, 1, 0], [0, 1, 0.3], [0, -1, 0.3]])
        points[:, 0] = (-20, 0, 0, -20)
        camera = renderers.Camera(0, 0, points, 1.5)
        triangles = np.array([[0, 1, 2], [0, 2, 3]])
        pixel, depth, corners, weights = renderers.fragments(points, triangles, camera, 100, 150)
        place = sum(weights[c, :, None] * points[corners[c]] for c in range(3))
        self.assertGreater(len(pixel), 50)
        seen, distance = camera.project(place)
        np.testing.assert_allclose(depth, distance, rtol=1e-9)
        np.testing.assert_allclose((seen[:, 0] / 1.5 + 1) / 2 * 150 - 0.5, pixel % 150, atol=1e-9)
        np.testing.assert_allclose((1 - seen[:, 1]) / 2 * 100 - 0.5, pixel // 150, atol=1e-9)

    def test_a_tilted_surface_is_nearer_where_it_is_nearer(self):
        tilted = self.square(0, 1, (1, 0, 0), 1.0)
        tilted.points[:, 0] = 0.9 * tilted.points[:, 1]  # the right half is nearer
        flat = self.square(0, 1, (0, 1, 0), 1.0)
        camera = self.camera([tilted, flat])
        image = renderers.render_numpy([tilted, flat], camera, 100)
        border = int(round((camera.project(np.zeros((1, 3)))[0][0, 0] / camera.aspect + 1) / 2 * 150))
        red = image[50, :, 0] > image[50, :, 1]
        covered = image[50, :, 3] > 0.9
        self.assertTrue(red[border + 2:][covered[border + 2:]].all())
        self.assertFalse(red[:border - 2][covered[:border - 2]].any())

    def test_pyvista_draws_the_same(self):
        reason = renderers.why_no_pyvista()
        if reason:
            self.skipTest(f"PyVista: {reason}")
        points, triangles, normals = sphere(24)
        surfaces = [renderers.Surface(points, triangles, normals, (1, 0.5, 0.2), 0.4),
                    renderers.Surface(0.5 * points, triangles, normals, (0.2, 0.5, 1.0), 1.0)]
        camera = renderers.Camera(-125, 35, points, 4 / 3)
        images = [draw(surfaces, camera, 150) for draw in (renderers.render_pyvista, renderers.render_numpy)]
        images = [image[..., :3] * image[..., 3:] for image in images]
        self.assertLess(np.abs(images[0] - images[1]).mean(), 0.01)

    def test_module_tells_by_its_exit_code_whether_pyvista_draws(self):
        """As tools/quickstart asks, with a PyVista that does as it is told."""
        tools = Path(renderers.__file__).parents[2]
        for does, code, says in (("pass", 0, ""), ("raise RuntimeError", 1, "PyVista: it cannot draw off-screen here")):
            with tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "pyvista.py").write_text(f"""
import numpy
def Sphere(): pass
class Plotter:
    def __init__(self, **_): {does}
    def add_mesh(self, *_, **__): pass
    def screenshot(self, **_): return numpy.zeros((64, 64, 3))
""")
                done = subprocess.run([sys.executable, "-m", "flusi_msm.render.renderers"], capture_output=True, text=True, check=False,
                                      env={**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{tools}"})
            self.assertEqual((done.returncode, done.stderr.strip()), (code, says))


class Levels(unittest.TestCase):
    def test_of_the_paper_where_the_flow_reaches_them(self):
        values = np.zeros((20, 20, 20))
        values[:2] = 250.0
        fluid = np.ones_like(values, dtype=bool)
        self.assertEqual(render.choose_levels(values, fluid, 1.0), (100, 150, 200))
        self.assertEqual(render.choose_levels(values, fluid, 1.2), (120, 180, 240))
        self.assertEqual(render.choose_levels(values, fluid, 2.0), (120, 190, 250))
        fluid[:2] = False  # inside of the wing
        with self.assertRaisesRegex(InputError, "vanishes"):
            render.choose_levels(values, fluid, 1.0)


class Pictures(unittest.TestCase):
    n, length = (24, 24, 16), (4.0, 4.0, 2.0)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        for label, time, amplitude in (("000500", 0.5, 1.0), ("001000", 1.0, 2.0)):
            write_velocity(self.folder, label, self.n, self.length, time, amplitude)
            for side, sign in (("left", -1), ("right", 1)):
                write_wing(self.folder, label, side, *rectangle(1.0, 0.4), (2, 2 + 0.4 * sign, 1),
                           axes_of((0, sign, 0.2), (-1, 0, 0.3)), time)

    def assert_picture(self, *arguments, out, says=""):
        done = run_tool("render", self.folder, "--height", 240, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        height, width, colours = picture(self.folder / out)
        self.assertAlmostEqual(height, 240 * 6.35 / 6, delta=20)
        self.assertAlmostEqual(width, 320, delta=20)
        self.assertGreater(colours, 100)
        self.assertIn(says, done.stdout)
        return done

    def test_the_last_time_and_what_was_used(self):
        self.assert_picture("--with", "numpy", out="render_001000.png", says="drawn with numpy")
        self.assertFalse((self.folder / "render_000500.png").exists())

    def test_one_time_with_levels_from_a_view(self):
        self.assert_picture("--with", "numpy", "--time", 0.4, "--levels", "2,1", "--view", "top", "-o",
                            self.folder / "x.png", out="x.png", says="|omega| = 1, 2 (largest")

    def test_all_times_have_the_levels_of_the_last(self):
        done = self.assert_picture("--with", "numpy", "--all", "--stride", 2, "-o", self.folder / "film",
                                   out="film/render_000500.png", says="every 2. point")
        self.assertEqual(done.stdout.count("|omega|"), 1)
        # half the vorticity of the last time: below all of its levels, so that only the wings are drawn
        self.assertLess(picture(self.folder / "film" / "render_000500.png")[2],
                        picture(self.folder / "film" / "render_001000.png")[2])

    def test_names_tell_what_differs(self):
        """Two pictures of one time do not overwrite each other."""
        self.assert_picture("--with", "numpy", out="render_001000.png")
        whole = (self.folder / "render_001000.png").read_bytes()
        self.assert_picture("--with", "numpy", "--wings", out="render_001000_wings.png")
        self.assert_picture("--with", "numpy", "--wings", "--view=10,20", out="render_001000_wings_10,20.png")
        self.assertEqual((self.folder / "render_001000.png").read_bytes(), whole)

    def test_movie(self):
        """As many pictures as times, of one size, as GIF without ffmpeg, and as MP4 with one, which gets them in order."""
        done = run_tool("render", self.folder, "--height", 240, "--with", "numpy", "--movie", "--stride", 2, "--rate", 5,
                        "-o", self.folder / "film.gif")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout.splitlines()[-1], str(self.folder / "film.gif"))
        with Image.open(self.folder / "film.gif") as film:
            self.assertEqual((film.n_frames, film.info["duration"]), (2, 200))
            self.assertAlmostEqual(film.size[0], 320, delta=20)
            first = np.array(film.convert("RGB"), dtype=int)
            film.seek(1)
            self.assertGreater(np.abs(np.array(film.convert("RGB"), dtype=int) - first).mean(), 1, "it moves")
        self.assertEqual(list(self.folder.glob("*.png")), [], "the pictures are not left")
        fake = self.folder / "bin/ffmpeg"
        fake.parent.mkdir()
        fake.write_text(f'#!/bin/sh\nls "$(dirname "$7")" | tr "\\n" " " > {self.folder}/told; for out; do :; done; echo film > "$out"\n')
        fake.chmod(0o755)
        path = os.environ["PATH"]
        for path, name in ((f"{fake.parent}:{path}", "movie.mp4"), (f"{self.folder / 'none'}", "movie.gif")):
            with mock.patch.dict(os.environ, {"PATH": path}):
                self.assertEqual(choose_movie(self.folder, None), self.folder / name)
        frames = [self.folder / f"{number}.png" for number in (10, 9)]
        for number, frame in enumerate(frames):
            Image.new("RGB", (33 + number, 20)).save(frame)
        with mock.patch.dict(os.environ, {"PATH": f"{fake.parent}:{os.environ['PATH']}"}), redirect_stdout(io.StringIO()):
            write_movie(frames, self.folder / "movie.mp4", 10)
        self.assertEqual((self.folder / "told").read_text(), "000000.png 000001.png ")
        with self.assertRaisesRegex(InputError, "a movie is a .mp4 or a .gif"):
            choose_movie(self.folder, self.folder / "film.avi")

    def test_the_mask_replaces_missing_wings(self):
        for path in self.folder.glob("wing_*.h5"):
            path.unlink()
        done = self.assert_picture("--with", "numpy", "--label", 1000, out="render_001000.png")
        self.assertIn("no wing surfaces and no mask", done.stderr)
        write_ball(self.folder, "001000", self.n, self.length, 1.0, 0.6)
        done = self.assert_picture("--with", "numpy", out="render_001000.png")
        self.assertEqual(done.stderr, "")

    def test_rigid_twins(self):
        """Blue and translucent beside bent wings, unless they are not wanted; vortices can be left out."""
        points, triangles = rectangle(1.0, 0.4)
        bent = np.column_stack([0 * points[:, 0], 0 * points[:, 0], 0.5 * points[:, 0]**2])
        for side, sign in (("left", -1), ("right", 1)):
            write_wing(self.folder, "001000", side, points, triangles, (2, 2 + 0.4 * sign, 1),
                       axes_of((0, sign, 0.2), (-1, 0, 0.3)), 1.0, bent)

        def blue(*arguments):
            out = self.folder / "x.png"
            self.assert_picture("--with", "numpy", "--wings", *arguments, "-o", out, out="x.png", says="wings only")
            pixels = plt.imread(out)[40:, :, :3]  # below the legend
            return np.mean(pixels[..., 2] > pixels[..., 0] + 0.1)

        self.assertGreater(blue(), 0.01)
        self.assertEqual(blue("--no-twin"), 0.0)

    def test_a_body(self):
        """Its surface is drawn, covers as much as it should, and is one of the surfaces; a file of something else is named."""
        corners = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]], dtype=float)
        faces = [[a, b, c] for a in (0, 1) for b in (2, 3) for c in (4, 5)]
        with h5py.File(self.folder / "body_001000.h5", "w") as file:
            file["points"], file["triangles"] = 0.4 * corners + (2, 2, 1), np.array(faces, dtype="i4")
        scene = render.Scene(render.Snapshot(self.folder, "001000"), None)
        bodies = [s for s in scene.surfaces([]) if s.colour == render.to_rgb(render.BODY)]
        self.assertEqual([len(s.points) for s in bodies], [6])
        for path in self.folder.glob("wing_*.h5"):
            path.unlink()
        out = self.folder / "x.png"
        self.assert_picture("--with", "numpy", "--wings", "--view", "0,0", "-o", out, out="x.png", says="wings only")
        brown = np.array(render.to_rgb(render.BODY))
        pixels = plt.imread(out)[:, :, :3]
        direction = pixels / np.maximum(np.linalg.norm(pixels, axis=2, keepdims=True), 1e-9)
        share = np.mean(direction @ (brown / np.linalg.norm(brown)) > 0.9995)
        # A square on its corner that fills the height (1/1.04 of it): half of that squared over the width, and the legend.
        self.assertAlmostEqual(share, 0.5 * 0.75 / 1.04**2 * 6 / 6.35, delta=0.06)
        with h5py.File(self.folder / "body_001000.h5", "w") as file:
            file["points"] = corners
        self.assertIn("not the surface of a body", run_tool("render", self.folder).stderr)

    def test_stored_magnitude_and_automatic_choice(self):
        x, y, z = grid(self.n, self.length)
        write_field(self.folder, "vorabs", "002000", np.exp(-(x - 2)**2 - (y - 2)**2 - (z - 1)**2), self.length, 2.0)
        self.assert_picture(out="render_002000.png", says="(largest 1); drawn with")

    def test_refusals(self):
        def refused(*arguments, because, folder=self.folder):
            done = run_tool("render", folder, *arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(because, done.stderr)
        refused("--view", "below", because="--view takes perspective, top")
        refused("--levels", "a", because="--levels takes numbers")
        refused("--levels", "-1", because="--levels must be positive")
        refused("--label", "x", because="--label takes digits")
        refused("--stride", 0, because="must be positive")
        refused("--height", 20, because="--height takes 100")
        refused("--label", 7, because="nothing with label 7")
        empty = self.folder / "empty"
        empty.mkdir()
        refused(because="no field files", folder=empty)
        write_ball(empty, "000000", self.n, self.length, 0.0, 0.5)
        refused(because="no snapshot with vorabs", folder=empty)
        write_field(empty, "vorabs", "000000", np.zeros(self.n[::-1]), self.length, 0.0)
        refused(because="vanishes", folder=empty)
        (empty / "mask_000000.h5").unlink()
        refused("--levels", 1, because="nothing to draw: |omega| is at most 0", folder=empty)


if __name__ == "__main__":
    unittest.main()
