# SPDX-License-Identifier: GPL-3.0-or-later
"""to_vtkhdf: the layout that VTK's reader wants, numbers and times of the run, no copy of the flow, mistakes by name."""
import shutil
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from synthetic import axes_of, run_tool, write_field, write_wing

N, LENGTH, ORIGIN = (6, 5, 4), (3.0, 2.5, 1.0), (0.5, 0.0, -1.0)  # x, y, z
TIMES = {"000000": 0.0, "000104": 0.10377867122068604, "000300": 0.3}
SOME_MESHES = {"000000": ((0, 1, 2), (1, 2, 3)), "000104": ((0, 1, 3),), "000300": ((3, 2, 1), (0, 1, 2), (0, 2, 3))}
INDEX = """<?xml version="1.0" ?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>
<Xdmf Version="3.0">
<Domain>
<Grid Name="fields" GridType="Collection" CollectionType="{kind}">
{grids}</Grid>
</Domain>
</Xdmf>"""


def item(path, dataset, shape, precision):
    return f'<DataItem Format="HDF" NumberType="Float" Precision="{precision}" Dimensions="{" ".join(map(str, shape))}">{path}:/{dataset}' \
           "</DataItem>\n"


def attribute(name, content, kind="Scalar", centre="Node"):
    return f'<Attribute Name="{name}" AttributeType="{kind}" Center="{centre}">\n{content}</Attribute>\n'


def grid(label, content):
    return f'<Grid GridType="Uniform" Name="{label}">\n<Time Value="{TIMES[label]:.17g}"/>\n{content}</Grid>\n'


def flow_grid(label, names, n=N):
    shape = n[::-1]
    spacing = np.array(LENGTH) / n
    triples = "".join('<DataItem Format="XML" Dimensions="3">' + " ".join(f"{x:.17g}" for x in values[::-1]) + "</DataItem>\n"
                      for values in (ORIGIN, spacing))
    text = f'<Topology TopologyType="3DCoRectMesh" Dimensions="{" ".join(map(str, shape))}"/>\n' \
           f'<Geometry GeometryType="ORIGIN_DXDYDZ">\n{triples}</Geometry>\n'
    parts = {name: item(f"{name}_{label}.h5", name, shape, 4) for name in names}
    join = '<DataItem ItemType="Function" Function="JOIN($0, $1, $2)" Dimensions="1">\n'
    text += attribute("u", join + parts["ux"] + parts["uy"] + parts["uz"] + "</DataItem>\n", "Vector")
    return grid(label, text + "".join(attribute(name, part) for name, part in parts.items()))


def wing_grid(label, path, n_points, n_triangles):
    return grid(label, f'<Topology TopologyType="Triangle" NumberOfElements="{n_triangles}">\n'
                + item(path, "triangles", (n_triangles, 3), 4) + '</Topology>\n<Geometry GeometryType="XYZ">\n'
                + item(path, "points", (n_points, 3), 8) + "</Geometry>\n"
                + attribute("velocities", item(path, "velocities", (n_points, 3), 8), "Vector")
                + attribute("pressure_jump", item(path, "pressure_jump", (n_triangles,), 8), centre="Cell"))


def write_run(folder, labels=tuple(TIMES)):
    """A run with its pressure saved later than its velocity, and a wing whose mesh changes. Returns {(name, label): values}."""
    random, known, flow, wing = np.random.default_rng(1), {}, "", ""
    for label in labels:
        names = ("ux", "uy", "uz") + (("p",) if label != "000000" else ())
        for name in names:
            known[name, label] = random.random(N[::-1]).astype("f4")
            write_field(folder, name, label, known[name, label], LENGTH, TIMES[label])
        flow += flow_grid(label, names)
        mesh = SOME_MESHES[label]
        write_wing(folder, label, "left", random.random((4, 3)), mesh, (1, 1, 1), axes_of((1, 0, 0), (0, 1, 0)), TIMES[label])
        with h5py.File(folder / f"wing_left_{label}.h5", "r+") as file:
            file["pressure_jump"] = random.random(len(mesh))
            file["velocities"][...] = random.random((4, 3))
            known.update({(name, label): file[name][...] for name in file})
        wing += wing_grid(label, f"wing_left_{label}.h5", 4, len(mesh))
    (folder / "fly.xmf").write_text(INDEX.format(kind="Temporal", grids=flow), encoding="utf-8")
    (folder / "fly_left.xmf").write_text(INDEX.format(kind="Temporal", grids=wing), encoding="utf-8")
    return known


class ToVtkhdf(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)
        self.run_folder = self.folder / "run"
        self.run_folder.mkdir()

    def convert(self, *words):
        done = run_tool("to_vtkhdf", self.run_folder, *words)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def refused(self, *texts):
        done = run_tool("to_vtkhdf", self.run_folder)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        for text in texts:
            self.assertIn(text, done.stderr)
        self.assertEqual([path.name for path in self.run_folder.glob("*.vtkhdf*")], [])

    def head(self, file, kind, n_steps):
        group = file["VTKHDF"]
        kind_type = group.attrs.get_id("Type").get_type()
        self.assertFalse(kind_type.is_variable_str())
        self.assertEqual(kind_type.get_cset(), h5py.h5t.CSET_ASCII)
        self.assertEqual(group.attrs["Type"], kind.encode())
        self.assertEqual(list(group.attrs["Version"]), [2, 0])
        self.assertEqual(group["Steps"].attrs["NSteps"], n_steps)
        self.assertEqual(list(group["Steps/Values"]), list(TIMES.values())[-n_steps:])
        return group

    def test_the_flow(self):
        known = write_run(self.run_folder)
        self.assertIn("flow, t = 0 to 0.3, 3 times, u, ux, uy, uz, p", self.convert())
        moved = self.folder / "moved"
        shutil.move(self.run_folder, moved)  # file names in it are relative to it
        with h5py.File(moved / "fly.vtkhdf", "r") as file:
            group = self.head(file, "ImageData", 3)
            self.assertEqual(list(group.attrs["WholeExtent"]), [0, N[0] - 1, 0, N[1] - 1, 0, N[2] - 1])
            self.assertEqual(group.attrs["WholeExtent"].dtype.kind, "i")
            np.testing.assert_array_equal(group.attrs["Origin"], ORIGIN)
            np.testing.assert_allclose(group.attrs["Spacing"], np.array(LENGTH) / N, rtol=1e-15)
            np.testing.assert_array_equal(group.attrs["Direction"], np.eye(3).ravel())
            data = group["PointData"]
            self.assertEqual(set(data), {"u", "ux", "uy", "uz", "p"})
            for name, values in data.items():
                self.assertTrue(values.is_virtual, name)
                self.assertEqual((values.dtype, values.shape), ("<f4", (3, *N[::-1]) + ((3,) if name == "u" else ())))
                self.assertEqual(list(group["Steps/PointDataOffsets"][name]), [0, 1, 2])
                self.assertTrue(all("/" not in source.file_name for source in values.virtual_sources()))
            for number, label in enumerate(TIMES):
                for component, name in enumerate(("ux", "uy", "uz")):
                    np.testing.assert_array_equal(data[name][number], known[name, label])
                    np.testing.assert_array_equal(data["u"][number, ..., component], known[name, label])
                np.testing.assert_array_equal(data["p"][number], known.get(("p", label), np.nan))

    def test_a_surface(self):
        known = write_run(self.run_folder)
        self.assertIn("surface, t = 0 to 0.3, 3 times, velocities, pressure_jump", self.convert())
        with h5py.File(self.run_folder / "fly_left.vtkhdf", "r") as file:
            group = self.head(file, "PolyData", 3)
            steps = group["Steps"]
            self.assertEqual(list(group["NumberOfPoints"]), [4, 4, 4])
            self.assertEqual(list(steps["NumberOfParts"]), [1, 1, 1])
            self.assertEqual(list(steps["PartOffsets"]), [0, 1, 2])
            for number, name in enumerate(("Vertices", "Lines", "Polygons", "Strips")):
                cells = group[name]
                wanted = [2, 1, 3] if name == "Polygons" else [0, 0, 0]
                self.assertEqual(list(cells["NumberOfCells"]), wanted)
                self.assertEqual(list(cells["NumberOfConnectivityIds"]), [3 * n for n in wanted])
                self.assertEqual(len(cells["Offsets"]), sum(wanted) + 3)
                self.assertEqual(len(cells["Connectivity"]), 3 * sum(wanted))
                begins = [0, 2, 3] if name == "Polygons" else [0, 0, 0]
                self.assertEqual(list(steps["CellOffsets"][:, number]), begins)
                self.assertEqual(list(steps["ConnectivityIdOffsets"][:, number]), [3 * n for n in begins])
            for number, label in enumerate(TIMES):
                point, cell = steps["PointOffsets"][number], steps["CellOffsets"][number, 2]
                n = group["Polygons/NumberOfCells"][number]
                self.assertEqual(steps["PointDataOffsets/velocities"][number], point)
                self.assertEqual(steps["CellDataOffsets/pressure_jump"][number], cell)
                np.testing.assert_array_equal(group["Points"][point:point + 4], known["points", label])
                np.testing.assert_array_equal(group["PointData/velocities"][point:point + 4], known["velocities", label])
                np.testing.assert_array_equal(group["CellData/pressure_jump"][cell:cell + n], known["pressure_jump", label])
                np.testing.assert_array_equal(group["Polygons/Connectivity"][3 * cell:3 * (cell + n)], np.ravel(SOME_MESHES[label]))
                first = cell + number  # a part has one number more than cells
                np.testing.assert_array_equal(group["Polygons/Offsets"][first:first + n + 1], 3 * np.arange(n + 1))

    def test_one_time_has_no_axis_of_time(self):
        known = write_run(self.run_folder, ["000300"])
        self.convert()
        with h5py.File(self.run_folder / "fly.vtkhdf", "r") as file:
            group = self.head(file, "ImageData", 1)
            np.testing.assert_array_equal(group["PointData/p"][...], known["p", "000300"])
            self.assertEqual(group["PointData/u"].shape, (*N[::-1], 3))
            self.assertEqual(list(group["FieldData/TimeValue"]), [0.3])

    def test_without_vectors(self):
        write_run(self.run_folder)
        self.convert("--no-vectors")
        with h5py.File(self.run_folder / "fly.vtkhdf", "r") as flow, h5py.File(self.run_folder / "fly_left.vtkhdf", "r") as wing:
            self.assertEqual(set(flow["VTKHDF/PointData"]), {"ux", "uy", "uz", "p"})
            self.assertEqual(set(wing["VTKHDF/PointData"]), {"velocities"})

    def test_other_indices_are_left_out(self):
        write_run(self.run_folder)
        (self.run_folder / "static_01.xmf").write_text(INDEX.format(kind="Spatial", grids=""), encoding="utf-8")
        self.assertIn("static_01.xmf: left out", self.convert())

    def test_mistakes(self):
        self.refused("no index (*.xmf)")
        write_run(self.run_folder)
        (self.run_folder / "p_000104.h5").unlink()
        write_field(self.run_folder, "uy", "000300", np.zeros((2, 2, 2)), LENGTH, 0.3)
        (self.run_folder / "broken.xmf").write_text("<Xdmf", encoding="utf-8")
        self.refused("p_000104.h5: no such file", "uy_000300.h5: 'uy' has the shape (2, 2, 2)", "broken.xmf: not an index")

    def test_another_grid(self):
        write_run(self.run_folder)
        for name in ("ux", "uy", "uz"):
            write_field(self.run_folder, name, "000300", np.zeros((8, 8, 8)), LENGTH, 0.3)
        text = flow_grid("000000", ("ux", "uy", "uz")) + flow_grid("000300", ("ux", "uy", "uz"), (8, 8, 8))
        (self.run_folder / "fly.xmf").write_text(INDEX.format(kind="Temporal", grids=text), encoding="utf-8")
        self.refused("the grid at t = 0.3 is another one than at t = 0")


if __name__ == "__main__":
    unittest.main()
