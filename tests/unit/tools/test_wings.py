# SPDX-License-Identifier: GPL-3.0-or-later
"""Wings made by the tools: the shipped ones can be made again, meshes are good, pictures and imports work.

usage: test_wings.py READER     READER: the program test_wings, which reads wing files as the solver does
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.seal import check_seal, write_seal
from flusi_msm.wing.bent_shape import read_shape, section
from flusi_msm.wing.file import Z_SIDES, Wing, read_wing, sorted_wing
from flusi_msm.wing.shapes import make_calliphora, make_plate, make_strip
from flusi_msm.wing.triangulate import Triangulation, in_circle
from synthetic import SOURCE, TOOLS, run_tool

READER = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else None


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def assert_read(self, path):
        """The solver's reader accepts the file."""
        if READER:
            run = subprocess.run([READER, str(path)], capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


def contents(path):
    """Every attribute and dataset of a file, with its type and its bytes."""
    found = {}
    with h5py.File(path, "r") as file:
        def note(name, thing):
            for key, value in thing.attrs.items():
                found[name, key] = (np.asarray(value).dtype.str, np.asarray(value).tobytes())
            if isinstance(thing, h5py.Dataset):
                found[name] = (thing.dtype.str, thing.shape, thing[()].tobytes())
        note("/", file)
        file.visititems(note)
    return found


class Shipped(InFolder):
    def test_can_be_made_again_to_the_last_bit(self):
        subprocess.run([TOOLS / "make_wings", str(self.folder)], check=True, capture_output=True,
                       env={"PATH": "/usr/bin:/bin", "PYTHON": sys.executable})
        names = sorted(path.name for path in self.folder.iterdir())
        self.assertEqual(names, ["beam.h5", "calliphora.h5", "calliphora_small.h5", "filament.h5", "plate.h5"])
        for name in names:
            new, old = contents(self.folder / name), contents(SOURCE / "wings" / name)
            self.assertEqual(sorted(map(str, new)), sorted(map(str, old)))
            self.assertEqual([key for key in new if new[key] != old[key]], [], name)
            self.assertLess((SOURCE / "wings" / name).stat().st_size, 300000)
            self.assertTrue(check_seal(self.folder / name) and check_seal(SOURCE / "wings" / name), name)

    def test_seal(self):
        """Readers do not see a seal, what changes a file cuts it off, and a changed byte is told."""
        path = self.folder / "wing.h5"
        path.write_bytes((SOURCE / "wings/plate.h5").read_bytes())
        sealed = path.read_bytes()
        path.write_bytes(sealed[:5000] + bytes([sealed[5000] ^ 1]) + sealed[5001:])
        with self.assertRaisesRegex(InputError, "wing.h5: is damaged: its bytes differ from the checksum"):
            read_wing(path)
        path.write_bytes(sealed)
        write_seal(path)
        self.assertEqual(path.read_bytes(), sealed)  # one seal is enough
        with h5py.File(path, "r+") as file:
            file.attrs["title"] = np.bytes_("another")
        self.assertFalse(check_seal(path))
        self.assert_read(path)
        run_tool("seal", path)
        self.assertIn("sealed", run_tool("seal", "--check", path).stdout)
        self.assert_read(path)


class Blowfly(InFolder):
    def check_mesh(self, wing, angle):
        areas = wing.areas()
        edges, count = wing.edges()
        self.assertTrue((areas > 0).all())
        self.assertLessEqual(count.max(), 2)
        self.assertEqual(len(wing.points) - len(edges) + len(wing.triangles), 1)  # Euler: one piece, no holes
        self.assertGreater(wing.smallest_angle(), angle)
        mesh = {tuple(e) for e in edges.tolist()}
        for nodes, _ in wing.veins.values():
            self.assertTrue(all(tuple(sorted(pair)) in mesh for pair in zip(nodes, nodes[1:])))
        # The boundary is one closed line.
        ends = edges[count == 1].ravel()
        self.assertTrue((np.bincount(ends, minlength=1)[np.unique(ends)] == 2).all())

    def test_three_sizes_of_one_geometry(self):
        wings = [make_calliphora(edge) for edge in (0.5, 0.183, 0.12)]
        for wing, points in zip(wings, (200, 1000, 2300)):
            self.check_mesh(wing, 15)
            self.assertLess(abs(len(wing.points) / points - 1), 0.05)
            self.assertAlmostEqual(np.ptp(wing.points[:, 0]), 9.01e-3, delta=2e-6)
            self.assertAlmostEqual(wing.areas().sum(), 27.03e-6, delta=0.15e-6)
            self.assertAlmostEqual(wing.vein_mass() / (wing.vein_mass() + 81.475e-9), 0.6741, delta=5e-4)
            every = np.concatenate([d for _, d in wing.veins.values()])
            self.assertEqual((round(every.min() * 1e6, 6), round(every.max() * 1e6, 6)), (20, 100))
            self.assertEqual((len(wing.veins), len(wing.joints)), (14, 10))
        for name in wings[0].joints:  # joints are at the same places in all of them
            places = [wing.points[wing.joint_nodes(name)[1]] for wing in wings]
            np.testing.assert_array_equal(places[0], places[1])
            np.testing.assert_array_equal(places[0], places[2])

    def test_edges_have_the_length_asked_for(self):
        wing = make_calliphora(0.183)
        edges, _ = wing.edges()
        length = np.sqrt(((wing.points[edges[:, 0]] - wing.points[edges[:, 1]])**2).sum(1))
        self.assertLess(abs(np.median(length) / 0.183e-3 - 1), 0.1)
        self.assertLess(length.max(), 2 * 0.183e-3)

    def test_wrong_edge_is_refused(self):
        run = run_tool("make_wing", "calliphora", self.folder / "a.h5", "--edge", "5")
        self.assertIn("must lie between", str(run.returncode) + run.stderr)


class Plate(InFolder):
    def test_dimensions(self):
        wing = make_plate(6, 2, 0.5, 2, (80, 40))
        self.assertAlmostEqual(wing.areas().sum(), 12e-6, delta=1e-15)
        self.assertAlmostEqual(wing.smallest_angle(), 45, delta=1e-9)
        self.assertEqual(len(wing.points), 13 * 5)
        self.assertEqual(sorted(wing.veins), ["spar1", "spar2"])
        self.assertTrue((wing.points[wing.veins["spar1"][0], 1] == 0).all())
        self.assertTrue((wing.points[wing.root, 0] == 0).all())

    def test_all_kinds_are_read(self):
        for k, options in enumerate((["--spars", "0"], ["--spars", "4", "--edge", "0.4"], ["--chord", "9"])):
            path = self.folder / f"plate{k}.h5"
            self.assertEqual(run_tool("make_wing", "plate", path, *options).returncode, 0)
            if k < 2:
                self.assert_read(path)
            self.assertTrue((read_wing(path).areas() > 0).all())


class Sides(InFolder):
    """Which side +z points to: what the tools write the solver reads, and nothing is written where nothing is said."""

    def test_every_side(self):
        path = self.folder / "plate.h5"
        for side in Z_SIDES:
            run = run_tool("make_wing", "plate", path, "--edge", "1.5", "--z-side", side)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertIn(f"+z points to the side: {side}", run.stdout)
            self.assertEqual(read_wing(path).z_side, side)
            self.assertEqual(sorted_wing(read_wing(path)).z_side, side)
            self.assert_read(path)
        self.assertEqual(run_tool("make_wing", "plate", path, "--edge", "1.5").returncode, 0)
        self.assertNotIn(("/", "z_side"), contents(path))
        self.assertEqual(read_wing(path).z_side, "")

    def test_other_words_are_refused(self):
        run = run_tool("make_wing", "plate", self.folder / "plate.h5", "--z-side", "dorsal")
        self.assertEqual(run.returncode, 2)
        self.assertIn("left ventral, right dorsal", run.stderr.replace("'", ""))  # newer Pythons quote nothing


class Strip(InFolder):
    def test_is_its_own_mirror_image(self):
        wing = make_strip(2000, 1000, 5, 1e5)
        self.assertEqual(len(wing.points), 18)
        self.assertTrue((wing.areas() > 0).all())
        mirror = wing.points * (1, -1, 1)
        number = [int(np.flatnonzero((np.abs(wing.points - p) < 1e-12).all(1))[0]) for p in mirror]
        cells = {tuple(sorted(t)) for t in wing.triangles.tolist()}
        self.assertEqual(cells, {tuple(sorted(number[i] for i in t)) for t in wing.triangles.tolist()})

    def test_every_spar_carries_its_part_of_the_width(self):
        wing = make_strip(1000, 1000, 6, 1e5)
        load = np.bincount(wing.triangles.ravel(), np.repeat(wing.areas() / 3, 3))
        fourth = {name: np.array(d)**4 for name, (_, d) in wing.veins.items()}
        self.assertAlmostEqual(fourth["spar1"][0] / fourth["spar2"][0], 0.5, delta=1e-12)
        for name in ("spar1", "spar3"):  # but for the ends, where a diagonal leaves more to one of two
            np.testing.assert_allclose(load[wing.veins[name][0][1:-1]], 0.5 * load[wing.veins["spar2"][0][1:-1]])

    def test_is_read(self):
        path = self.folder / "strip.h5"
        self.assertEqual(run_tool("make_wing", "strip", path, "--cells", "8").returncode, 0)
        self.assert_read(path)
        run = run_tool("make_wing", "strip", path, "--cells", "1")
        self.assertIn("at least 2", str(run.returncode) + run.stderr)


class Triangulations(unittest.TestCase):
    def test_is_delaunay(self):
        state, points = 1, []
        for _ in range(60):
            state = (1103515245 * state + 12345) % 2**31
            points.append((state / 2**31, (state * 7919 % 2**31) / 2**31))
        points += [(-1, -1), (2, -1), (2, 2), (-1, 2)]
        mesh = Triangulation(points, [(60, 61), (61, 62), (62, 63), (63, 60)])
        self.assertEqual(len(mesh.triangles()), 2 * len(points) - 2 - 4)
        for a, b, c in mesh.triangles():
            corners = [points[k] for k in (a, b, c)]
            self.assertFalse(any(in_circle(*corners, points[k]) > 1e-12 for k in range(60) if k not in (a, b, c)))

    def test_keeps_segments_that_are_not_delaunay(self):
        points = [(0, 0), (10, 0), (10, 1), (0, 1), (5.1, 0.2), (4.9, 0.8), (2, 0.3), (8, 0.7)]
        segments = [(0, 1), (1, 2), (2, 3), (3, 0), (3, 6), (6, 4), (4, 7), (0, 5)]
        with self.assertRaisesRegex(ValueError, "cross|edge"):
            Triangulation(points, segments[:4] + [(0, 2), (1, 3)])
        mesh = Triangulation(points, segments[:4] + [(0, 7)])
        self.assertTrue((0, 7) in mesh.across and (7, 0) in mesh.across)


class Document(InFolder):
    def test_example_in_wing_format(self):
        text = (SOURCE / "docs/formats/wing-format.md").read_text(encoding="utf-8")
        code = text.split("```python\n")[1].split("```")[0].replace('"strip.h5"', "PATH")
        exec(code, {"PATH": self.folder / "strip.h5"})  # the document of this project
        self.assert_read(self.folder / "strip.h5")
        self.assertEqual(read_wing(self.folder / "strip.h5").joints, {"middle": ("front", 4)})


class Pictures(InFolder):
    def test_wing_with_and_without_a_field(self):
        n = len(read_wing(SOURCE / "wings" / "calliphora_small.h5").points)
        with h5py.File(self.folder / "u.h5", "w") as file:
            file["displacement"] = np.linspace(0, 1, 3 * n).reshape(n, 3)
        for options in ([], ["--field", self.folder / "u.h5", "--no-mesh", "--no-names"]):
            picture = self.folder / "a.png"
            run = run_tool("plot_wing", SOURCE / "wings" / "calliphora_small.h5", "-o", picture, *options)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertGreater(picture.stat().st_size, 20000)

    def test_a_picture_has_a_name_of_its_own(self):
        """NAME.png is the picture of make_wing, which stays."""
        (self.folder / "a.h5").write_bytes((SOURCE / "wings" / "plate.h5").read_bytes())
        (self.folder / "a.png").write_text("that of make_wing")
        run = run_tool("plot_wing", self.folder / "a.h5")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertGreater((self.folder / "a_mesh.png").stat().st_size, 10000)
        self.assertEqual((self.folder / "a.png").read_text(), "that of make_wing")

    def write_shape(self, name, wing, bend, **facts):
        """A deformed wing as the solver saves it: z = bend x^2."""
        u = np.zeros_like(wing.points)
        u[:, 2] = bend * wing.points[:, 0]**2
        nodes = [n for chain, _ in wing.veins.values() for n in chain]
        with h5py.File(self.folder / name, "w") as file:
            file.attrs["schema"] = "flusi-msm shape"
            for key, value in facts.items():
                file.attrs[key] = value
            if len(wing.triangles):
                file["points"], file["displacement"], file["triangles"] = wing.points + u, u, wing.triangles
            file["vein_points"], file["vein_displacement"] = (wing.points + u)[nodes], u[nodes]
            cells, at = [], 0
            for chain, _ in wing.veins.values():
                cells += [2, len(chain), *range(at, at + len(chain))]
                at += len(chain)
            file["vein_cells"] = cells
        return self.folder / name

    def test_deformed_wings(self):
        wing = read_wing(SOURCE / "wings" / "calliphora_small.h5")
        bare = Wing(wing.points, np.zeros((0, 3), int), wing.veins, {}, wing.root)
        cases = {"one": [self.write_shape("a.h5", wing, 20.0, load=3)],
                 "small": [self.write_shape("b.h5", wing, 1e-4, frequency=517.0)],
                 "flat": [self.write_shape("c.h5", wing, 0.0, time=0.0)],
                 "many": [self.write_shape(f"d{i}.h5", wing, 3.0 * i - 9, time=1e-3 * i) for i in range(12)],
                 "veins": [self.write_shape("e.h5", bare, 20.0, time=1.0)]}
        for name, files in cases.items():
            picture = self.folder / f"{name}.png"
            run = run_tool("plot_wing", "--shape", *files, "-o", picture)
            self.assertEqual((run.returncode, run.stderr), (0, ""), name)
            self.assertGreater(picture.stat().st_size, 10000, name)
        shape = read_shape(cases["one"][0])
        self.assertEqual(shape.title, "load 3")
        self.assertEqual(len(shape.veins), len(wing.veins))
        np.testing.assert_allclose(shape.rest, 1e3 * wing.points, atol=1e-12)
        cut = section(shape, 4.0)  # all at x = 4 mm, z = 20 x^2, linear between points of the mesh
        np.testing.assert_allclose(cut[:, 0], 4.0, atol=1e-12)
        self.assertTrue(np.all(np.diff(cut[:, 1]) > 0) and np.all(abs(cut[:, 2] - 0.32) < 0.02))

    def test_wrong_shapes_are_named(self):
        for name, word in (("wing.h5", "not a deformed wing"), ("text.h5", "text.h5: ")):
            path = self.folder / name
            path.write_bytes((SOURCE / "wings" / "plate.h5").read_bytes() if name == "wing.h5" else b"no HDF5")
            run = run_tool("plot_wing", "--shape", path)
            self.assertEqual(run.returncode, 2)
            self.assertIn(word, run.stderr)
        self.assertEqual(run_tool("plot_wing").returncode, 2)

    def test_wrong_input_is_named(self):
        (self.folder / "a.h5").write_text("no HDF5")
        run = run_tool("plot_wing", self.folder / "a.h5")
        self.assertEqual(run.returncode, 2)
        self.assertIn("a.h5: not a readable wing file", run.stderr)
        run = run_tool("plot_wing", self.folder / "none.h5")
        self.assertIn("none.h5: not a readable wing file: no such file\n", run.stderr)

    def test_seals_are_for_hdf5(self):
        """A seal behind the end of a text would spoil it."""
        path = self.folder / "fly.ini"
        path.write_text("[Wing]\nfile = wing.h5;\n" * 9)
        before = path.read_bytes()
        run = run_tool("seal", path)
        self.assertEqual((run.returncode, path.read_bytes()), (2, before))
        self.assertIn("fly.ini: is not an HDF5 file", run.stderr)


class Import(InFolder):
    """A FLUSI set of the kind of its bumblebee wing: a plate with root vein and vein along its leading edge."""
    COLUMNS, ROWS = 6, 3

    def number(self, i, j):
        return 1 + i * (self.ROWS + 1) + j

    def write(self, name, rows, padding=0):
        width = len(rows[0])
        rows = [list(row) for row in rows] + [[0.0] * width] * padding
        text = "\n".join(" ".join(f"{value:.16e}" for value in row) for row in rows)
        (self.folder / f"{name}1.dat").write_text(text)  # no newline at the end, as in the originals

    def make_set(self, turned=True, swapped=False):
        points = [(i / self.COLUMNS, -0.5 * j / self.ROWS, 0.0)
                  for i in range(self.COLUMNS + 1) for j in range(self.ROWS + 1)]
        self.write("points_coor", [(k, p[0], p[2], p[1]) if swapped else (k, *p) for k, p in enumerate(points, 1)],
                   padding=3)
        triangles = []
        for i in range(self.COLUMNS):
            for j in range(self.ROWS):
                a, b = self.number(i, j), self.number(i + 1, j)
                triangles += [(a, b, b + 1), (a, b + 1, a + 1)] if turned else [(a, b + 1, b), (a, a + 1, b + 1)]
        self.write("mesh_triangle_elements", [(113 + k, 203, *t) for k, t in enumerate(triangles)])
        root_vein = [self.number(i, 0) for i in range(4)]
        vein = [self.number(i, 0) for i in range(3, self.COLUMNS + 1)]
        for kind, nodes in (("_BC", root_vein), ("", vein)):
            self.write("veins" + kind, list(enumerate(nodes, 1)), padding=2)
            self.write("veins_extension" + kind, [(k + 1, *nodes[k:k + 2], 9.9, 0) for k in range(len(nodes) - 1)])
            self.write("veins_bending" + kind,
                       [(k + 1, *nodes[k:k + 3], 9.9, 9.9, 0, 0) for k in range(len(nodes) - 2)])
        self.write("vein_connectors", [(1, root_vein[-2], root_vein[-1], vein[1], 0, 0, 0, 0)])
        edges = sorted({tuple(sorted(e)) for a, b, c in triangles for e in ((a, b), (b, c), (c, a))})
        self.write("membranes_extension", [(k, *e, 9.9, 0) for k, e in enumerate(edges, 1)])
        self.write("membrane_edge", [(k, self.number(self.COLUMNS, k), self.number(self.COLUMNS, k - 1), 9.9, 0)
                                     for k in range(1, self.ROWS + 1)])
        self.write("membranes", [(k,) for k in range(1, len(points) + 1)])

    def run_import(self, *options):
        return run_tool("import_flusi_mesh", self.folder, self.folder / "wing.h5", "--unit", "0.01",
                        "--root-vein", "100", "60", "--vein", "60", "30", *options)

    def refuse(self, *fragments):
        run = self.run_import()
        self.assertEqual(run.returncode, 2, run.stdout)
        for fragment in fragments:
            self.assertIn(fragment, run.stderr)

    def test_a_set_with_all_its_traps(self):
        for turned, swapped in ((True, False), (False, False), (False, True)):
            self.make_set(turned, swapped)
            run = self.run_import("--z-side", "right dorsal")
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(read_wing(self.folder / "wing.h5").z_side, "right dorsal")
            self.assertEqual("triangles turned" in run.stdout, turned)
            self.assertEqual("columns 3 and 4" in run.stdout, swapped)
            self.assertIn("9 edges have two springs", run.stdout)
            wing = read_wing(self.folder / "wing.h5")
            self.assertEqual((len(wing.points), len(wing.triangles)), (28, 36))
            self.assertAlmostEqual(wing.areas().sum(), 0.5e-4, delta=1e-15)
            self.assertTrue((wing.areas() > 0).all())
            self.assertEqual(wing.veins["root_vein"][0], [0, 4, 8, 12])
            np.testing.assert_allclose(wing.veins["vein"][1], [60e-6, 50e-6, 40e-6, 30e-6], rtol=1e-12)
            self.assertEqual(wing.joints, {"connector_1": (8, 12, 16)})
            self.assertEqual(wing.root, [0])
            self.assertEqual(wing.mass.law, "uniform")
            self.assertAlmostEqual(wing.mass.membrane, 3e-3 * 0.5e-4, delta=1e-20)
            self.assertIn("weighs 0.003 kg/m^2 as nothing else is said", run.stdout)
            self.assert_read(self.folder / "wing.h5")

    def test_mass_of_the_membrane(self):
        self.make_set()
        run = self.run_import("--areal-density", "5e-3")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertNotIn("as nothing else is said", run.stdout)
        self.assertAlmostEqual(read_wing(self.folder / "wing.h5").mass.membrane, 5e-3 * 0.5e-4, delta=1e-20)
        self.assertEqual(self.run_import("--areal-density", "nan").returncode, 2)

    def test_inconsistent_sets_are_refused(self):
        self.make_set()
        self.write("mesh_triangle_elements", [(1, 203, 1, 2, 844)])
        self.refuse("mesh_triangle_elements1.dat: names point 844; there are 28 points")
        self.make_set()
        self.write("mesh_triangle_elements", [(1, 102, 1, 2, 5)])
        self.refuse("row 1 is of type 102, not a triangle")
        self.make_set()
        self.write("veins", [(1, 4), (6, 13), (2, 17)])
        self.refuse("veins1.dat: rows are not counted 1 to 3", "scrambled")
        self.make_set()
        self.write("veins_bending", [(1, 13, 17, 25, 0, 0, 0, 0), (2, 17, 21, 25, 0, 0, 0, 0)])
        self.refuse("veins_bending1.dat: its springs are not those between the points of veins1.dat")
        self.make_set()
        self.write("vein_connectors", [(1, 9, 13, 14, 0, 0, 0, 0)])
        self.refuse("vein_connectors1.dat: row 1 (points 9, 13, 14) does not join two segments of veins")
        self.make_set()
        self.write("membranes_extension", [(1, 1, 12, 0, 0)])
        self.refuse("membranes_extension1.dat: row 1 joins points 1 and 12, which are not an edge")
        self.make_set()
        self.write("points_coor", [(k, k, k * k, 0) for k in (1, 2, 4)])
        self.refuse("points_coor1.dat: rows are not counted 1 to 3")
        self.make_set()
        (self.folder / "veins1.dat").write_text("1 2 3\n")
        (self.folder / "veins_BC1.dat").unlink()
        self.refuse("veins1.dat: row 1 has 3 numbers", "no file veins_BC1.dat")
        self.make_set()
        (self.folder / "points_coor1.dat").write_text("1 0 x 0\n")
        self.refuse("points_coor1.dat: not a table of numbers")
        self.make_set()
        self.write("veins", [(1, 9), (2, 13), (3, 17)])
        self.write("veins_extension", [(1, 9, 13, 0, 0), (2, 13, 17, 0, 0)])
        self.write("veins_bending", [(1, 9, 13, 17, 0, 0, 0, 0)])
        self.refuse("vein vein: segment 9-13 is also in vein root_vein")


if __name__ == "__main__":
    unittest.main()
