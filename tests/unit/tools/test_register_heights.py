# SPDX-License-Identifier: GPL-3.0-or-later
"""Heights that were scanned in another frame and stored in any format arrive on the wing: against shapes known in closed form."""
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
from PIL import Image

from flusi_msm.errors import InputError, Problems
from flusi_msm.importers.maps import Pixels, read_map
from flusi_msm.importers.registration import by_landmarks, find_outliers, turn_by
from flusi_msm.importers.tables import read_table
from flusi_msm.wing.file import read_wing
from synthetic import SOURCE, run_tool

WING = SOURCE / "wings/calliphora_small.h5"
ANGLE, SHIFT = np.radians(23.0), np.array([4e-3, -7e-3])    # p of the scan = turn_by(ANGLE) @ p of the wing + SHIFT
STEP = 5e-5
POINT, DIRECTION = np.array([7.2e-3, -3e-4]), np.array([0.1, 0.0, 1.0])
# z = 1 m^-1 x^2 / 2 + ...: second derivatives [1/m] of the shapes below, along any direction at most.
BEND = 3.0
UNITS = ["--height-units", "um", "--axis-units", "mm", "--force-units", "mN", "--height-sd", "1"]
COUNT = 0.05                                                # um of a step of a 16 bit picture


def rest_shape(x, y):
    return 2e-5 + 0.01 * x - 0.02 * y


def bent_shape(x, y):
    return rest_shape(x, y) + BEND / 2 * (x**2 + 0.3 * x * y)


class Scan:
    """The wing scanned from above in its turned and shifted frame."""

    def __init__(self, step=STEP):
        wing = read_wing(WING)
        self.wing, self.outline = wing, None
        corners = wing.points[:, :2] @ turn_by(ANGLE).T + SHIFT
        (x0, y0), (x1, y1) = corners.min(0), corners.max(0)
        self.x, self.y = np.arange(x0 - 5e-4, x1 + 5e-4, step), np.arange(y0 - 5e-4, y1 + 5e-4, step)
        gx, gy = np.meshgrid(self.x, self.y)
        on_wing = (np.stack([gx.ravel(), gy.ravel()], 1) - SHIFT) @ turn_by(ANGLE)
        from flusi_msm.importers.registration import is_inside, outline_of
        inside = is_inside(outline_of(wing), on_wing).reshape(gx.shape)
        u, v = (on_wing[:, k].reshape(gx.shape) for k in (0, 1))
        self.maps = {"reference": np.where(inside, rest_shape(u, v), np.nan), "tip": np.where(inside, bent_shape(u, v), np.nan)}
        self.point = turn_by(ANGLE) @ POINT + SHIFT
        self.direction = [*(turn_by(ANGLE) @ DIRECTION[:2]), DIRECTION[2]]

    def loads_line(self, file=None, comma=False):
        cells = ["tip", *([file] if file else []), *(repr(float(v)) for v in (0.3, *self.direction, *(1e3 * self.point))), "1"]
        return ";".join(c.replace(".", ",") if comma and k > 1 else c for k, c in enumerate(cells)) + "\n"


HEAD = "id;file;force;direction_x;direction_y;direction_z;point_x;point_y;order\n"


class Formats(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scan = Scan()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.landmarks()

    def landmarks(self, error=0.0):
        wing = self.scan.wing
        rows = ["name,x,y,wing_x,wing_y"]
        root = wing.points[wing.root, :2].mean(0)
        tip = wing.points[((wing.points[:, :2] - root)**2).sum(1).argmax(), :2]
        for name, place, stated in (("root", root, None), ("tip", tip, None), ("mark", np.array([4e-3, 1e-3]), [4, 1])):
            x, y = 1e3 * (turn_by(ANGLE) @ place + SHIFT) + error * (name == "mark")
            rows.append(f"{name},{x!r},{y!r}".replace("np.float64(", "").replace(")", "") + (f",{stated[0]},{stated[1]}" if stated else ",,"))
        (self.folder / "landmarks.csv").write_text("\n".join(rows) + "\n")

    def write(self, kind, flip=False):
        for name, z in self.scan.maps.items():
            x, y, z = 1e3 * self.scan.x, 1e3 * self.scan.y, 1e6 * z
            path = self.folder / f"{name}.{kind}"
            if kind == "csv":      # as a German spreadsheet writes it
                rows = [";".join([""] + [f"{v:.9f}" for v in x])]
                rows += [";".join([f"{v:.9f}"] + ["" if np.isnan(h) else f"{h:.6f}" for h in row]) for v, row in zip(y[::-1], z[::-1])]
                path.write_text("# exported\n" + "\n".join(rows).replace(".", ",") + "\n", encoding="cp1252")
            elif kind == "npz":
                np.savez(path, x=x, y=y, z=z)
            elif kind == "mat":
                from scipy.io import savemat
                gx, gy = np.meshgrid(x, y)
                savemat(path, {"x": gx, "y": gy, "z": z})
            elif kind == "tiff":   # 32 bit
                Image.fromarray(z[::-1].astype("f4")).save(path)
            elif kind == "tif":    # 16 bit
                counts = np.where(np.isnan(z), 0, np.round(z / COUNT) + 1000)
                self.assertTrue(0 < counts.max() < 65535)
                Image.fromarray(counts[::-1].astype("u2")).save(path)
        (self.folder / "list.csv").write_text(HEAD + f"reference;reference.{kind}\n" + self.scan.loads_line(f"tip.{kind}", kind == "csv"))

    def imported(self, *options):
        run = run_tool("import_heights", self.folder, "-o", self.folder / "m.h5", "--wing", WING, *UNITS, *options)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stdout

    def check_truth(self, rounding, registration=0.0):
        """What arrives is the shape at the grid points. A bilinear interpolation errs by h^2/8 of the second derivatives along both
        axes, a registration by its error times the slope, a picture by half a step."""
        with h5py.File(self.folder / "m.h5") as file:
            x, y = np.meshgrid(file["reference/x"][:], file["reference/y"][:])
            facts = dict(file["loads/tip"].attrs)
            found = {"reference": file["reference/z"][:], "tip": file["loads/tip/z"][:]}
            sd = file["loads/tip/sigma"][:]
        slope = BEND * 1.15 * 9.1e-3 + 0.0224
        tolerance = STEP**2 / 8 * 2 * BEND * 1.15 + rounding + registration * slope + 1e-12
        for name, shape in (("reference", rest_shape), ("tip", bent_shape)):
            known = np.isfinite(found[name])
            self.assertGreater(known.sum() * np.diff(x[0]).mean()**2, 0.9 * self.scan.wing.areas().sum())
            worst = np.abs(found[name] - shape(x, y))[known].max()
            self.assertLess(worst, tolerance, name)
        known = np.isfinite(found["tip"])
        # The mean of four errors of sd 1 um has half of it at the middle of a cell.
        self.assertTrue(0.499e-6 <= sd[known].min() < 0.55e-6 and 0.9e-6 < sd[known].max() <= 1e-6, (sd[known].min(), sd[known].max()))
        np.testing.assert_allclose(facts["point"], POINT, atol=registration + 1e-9)
        np.testing.assert_allclose(facts["direction"], DIRECTION, atol=registration / 4e-3 + 1e-9)

    def test_csv_with_decimal_commas(self):
        self.write("csv")
        told = self.imported()
        self.assertIn("reference, tip: cells separated by semicolon, decimal comma", told)
        self.assertIn("turned by -23.000 degrees", told)
        self.check_truth(1e-12)
        self.assertTrue((self.folder / "m.png").stat().st_size > 20000)

    def test_npz_and_mat(self):
        for kind in "npz", "mat":
            self.write(kind)
            self.imported("--no-picture")
            self.check_truth(1e-14)

    def test_mat_of_version_7_3(self):
        """HDF5 with the axes of Matlab, which come the other way round."""
        self.write("npz")
        for name, z in self.scan.maps.items():
            with h5py.File(self.folder / f"{name}.mat", "w") as file:
                file["x"], file["y"], file["z"] = 1e3 * self.scan.x[:, None], 1e3 * self.scan.y[:, None], 1e6 * z.T
        text = (self.folder / "list.csv").read_text()
        (self.folder / "list.csv").write_text(text.replace(".npz", ".mat"))
        self.imported("--no-picture")
        self.check_truth(1e-14)

    def test_tiff_pictures(self):
        """Pictures have no origin: the scan is shifted by that of its lowest pixel, and so are landmarks and loads."""
        scan = Scan()
        origin = np.array([scan.x[0], scan.y[0]])
        self.scan.point = scan.point - origin
        self.addCleanup(setattr, self.scan, "point", scan.point)
        text = (self.folder / "landmarks.csv").read_text().splitlines()
        rows = [text[0]]
        for line in text[1:]:
            name, x, y, *more = line.split(",")
            rows.append(",".join([name, repr(float(x) - 1e3 * origin[0]), repr(float(y) - 1e3 * origin[1]), *more]).replace("np.float64(", "").replace(")", ""))
        (self.folder / "landmarks.csv").write_text("\n".join(rows) + "\n")
        pixel = ["--pixel", str(1e3 * STEP)]
        self.write("tiff")
        self.imported("--no-picture", *pixel)
        self.check_truth(1e-10)    # 24 bits of 130 um
        self.write("tif")
        told = self.imported("--no-picture", *pixel, "--height-per-count", str(COUNT), "--zero-count", "1000", "--missing-count", "0")
        self.assertIn("16 bit integers", told)
        self.check_truth(1e-6 * COUNT / 2)

    def test_outline(self):
        """The margin of the heights lies on the outline to a part of a pixel: errors of n = 400 independent points of at most half a pixel."""
        self.write("npz")
        (self.folder / "landmarks.csv").unlink()
        told = self.imported("--no-picture", "--outline")
        self.assertIn("points of it, turned by", told)
        self.check_truth(1e-14, registration=STEP / 4)

    def test_flip(self):
        """A scan whose y runs downward is a mirror image, which landmarks tell; --flip y mends it."""
        self.write("npz")
        for name, z in self.scan.maps.items():
            np.savez(self.folder / f"{name}.npz", x=1e3 * self.scan.x, y=-1e3 * self.scan.y, z=1e6 * z)
        rows = (self.folder / "landmarks.csv").read_text().splitlines()
        cells = [row.split(",") for row in rows[1:]]
        (self.folder / "landmarks.csv").write_text("\n".join([rows[0]] + [",".join([c[0], c[1], str(-float(c[2])), *c[3:]]) for c in cells]))
        head, rest, load = (self.folder / "list.csv").read_text().splitlines()
        load = load.split(";")
        load[4], load[7] = str(-float(load[4])), str(-float(load[7]))
        (self.folder / "list.csv").write_text("\n".join([head, rest, ";".join(load)]))
        run = run_tool("import_heights", self.folder, "-o", self.folder / "m.h5", "--wing", WING, *UNITS)
        self.assertEqual(run.returncode, 2)
        self.assertIn("they are those of a mirror image", run.stderr)
        self.imported("--no-picture", "--flip", "y")
        self.check_truth(1e-14)

    def test_outliers(self):
        """Every height that was moved by 20 sd is found, and no other; the others arrive as they are without them."""
        rng = np.random.default_rng(1)
        self.write("npz")
        known = np.isfinite(self.scan.maps["tip"])
        noise = {name: 1e-6 * rng.standard_normal(known.shape) for name in self.scan.maps}
        j, i = np.nonzero(known)
        chosen = rng.choice(len(j), 12, replace=False)
        noise["tip"][j[chosen], i[chosen]] += 30e-6
        for name, z in self.scan.maps.items():
            np.savez(self.folder / f"{name}.npz", x=1e3 * self.scan.x, y=1e3 * self.scan.y, z=1e6 * (z + noise[name]))
        told = self.imported("--drop-outliers")
        self.assertIn("tip: 12 outliers (more than 6 sd), left out", told)
        self.assertNotIn("reference: 1", told)

    def test_all_faults_at_once(self):
        self.write("npz")
        self.landmarks(error=2.0)
        np.savez(self.folder / "wide.npz", x=1e3 * self.scan.x[:-1], y=1e3 * self.scan.y, z=1e6 * self.scan.maps["tip"][:, :-1])
        (self.folder / "words.csv").write_text(",1,2\n1,a,2\n2,b,3\n")
        text = (self.folder / "list.csv").read_text() + "wide;wide.npz;0;0;0;1;much;0;1\nwords;words.csv;1;0;0;0;1;1;1.5\ngone;gone.npz;1;0;0;1;1;1\n"
        (self.folder / "list.csv").write_text(text)
        run = run_tool("import_heights", self.folder, "-o", self.folder / "m.h5", "--wing", "no.h5", *UNITS, "--outline", "--tilt-sd=-1")
        self.assertEqual(run.returncode, 2)
        for words in ("--tilt-sd must not be negative", "no.h5: not a readable wing file", "list.csv:4: wide: the force must be positive",
                      "list.csv:4: wide: point_x is 'much', not a number", "list.csv:5: words: the direction is 0 0 0",
                      "list.csv:5: words: order is '1.5', not a whole number", "wide.npz: x of its map differs",
                      "words.csv: line 2, cell 2: 'a' is not a number", "words.csv: line 3, cell 2: 'b'", "gone.npz: cannot be read"):
            self.assertEqual(run.stderr.count(words), 1, f"{words}:\n{run.stderr}")
        self.assertFalse((self.folder / "m.h5").exists())
        self.write("npz")
        run = run_tool("import_heights", self.folder, "-o", self.folder / "m.h5", "--wing", WING, *UNITS)
        self.assertIn("landmarks: do not fit", run.stderr)
        self.landmarks()
        run = run_tool("import_heights", self.folder, "-o", self.folder / "m.h5", "--wing", WING, *UNITS[:3], "um", *UNITS[4:])
        self.assertRegex(run.stderr, r"landmarks are 0\.000\d+ times as large in the scan as in the wing file: are --axis-units right")


class Folder(unittest.TestCase):
    def test_convention(self):
        """loads.csv without names of files, two scans of the unloaded wing."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            x, y = np.arange(4.0), np.arange(3.0)
            rest = np.zeros((3, 4))
            rest[0, 0] = np.nan
            np.savez(folder / "reference_1.npz", x=x, y=y, z=rest)
            np.savez(folder / "reference_2.npz", x=x, y=y, z=np.full((3, 4), 2.0))
            np.savez(folder / "tip.npz", x=x, y=y, z=np.full((3, 4), 5.0))
            (folder / "loads.csv").write_text("id,force,direction_x,direction_y,direction_z,point_x,point_y\ntip,1,0,0,1,2,1\n")
            run = run_tool("import_heights", folder, "-o", folder / "out.h5", "--no-picture", *UNITS)
            self.assertEqual(run.returncode, 0, run.stderr)
            with h5py.File(folder / "out.h5") as file:
                np.testing.assert_allclose(file["reference/z"][0], 1e-6 * np.array([2, 1, 1, 1]))
                np.testing.assert_allclose(file["reference/sigma"][0], 1e-6 / np.sqrt([1, 2, 2, 2]))
            (folder / "other.npz").write_bytes((folder / "tip.npz").read_bytes())
            (folder / "tip.npz").unlink()
            run = run_tool("import_heights", folder, "-o", folder / "out.h5", "--no-picture", *UNITS)
            self.assertIn("there is no map tip.*", run.stderr)
            self.assertIn("other.npz belongs to no line of loads.csv", run.stderr)


class Parts(unittest.TestCase):
    def test_separators(self):
        """Every way in which a spreadsheet writes the same numbers."""
        with tempfile.TemporaryDirectory() as name:
            for text, told in ((",1.5,2.5\n1,0.1,-0.2\n2,0.3,4e-1\n", "comma, decimal point"),
                               (";1,5;2,5\n1;0,1;-0,2\n2;0,3;4e-1\n", "semicolon, decimal comma"),
                               (";1.5;2.5\n1;0.1;-0.2\n2;0.3;0.4\n", "semicolon, decimal point"),
                               ("\t1,5\t2,5\n1\t0,1\t-0,2\n2\t0,3\t0,4\n", "tab, decimal comma"),
                               ("y/x 1,5 2,5\n1,0 0,1 -0,2\n2,0 0,3 0,4\n", "blanks, decimal comma"),
                               ("x,y,z\n1.5,1,0.1\n2.5,1,-0.2\n1.5,2,0.3\n2.5,2,0.4\n", "comma, decimal point")):
                path = Path(name) / "map.csv"
                path.write_text(text)
                self.assertIn(told, read_table(path).spelling())
                found = read_map(path)
                np.testing.assert_array_equal(found.x, [1.5, 2.5])
                np.testing.assert_array_equal(found.y, [1, 2])
                np.testing.assert_array_equal(found.z, [[0.1, -0.2], [0.3, 0.4]])

    def test_pictures_ask_for_what_they_do_not_say(self):
        with tempfile.TemporaryDirectory() as name:
            path = Path(name) / "a.tif"
            Image.fromarray(np.arange(12, dtype="u2").reshape(3, 4)).save(path)
            with self.assertRaises(InputError) as told:
                read_map(path, Pixels())
            for words in "--pixel SIZE", "--height-per-count":
                self.assertIn(words, str(told.exception))
            found = read_map(path, Pixels((0.5, 2.0), 10.0, 4.0, 11))
            np.testing.assert_array_equal(found.x, [0, 0.5, 1, 1.5])
            np.testing.assert_array_equal(found.z[0], [40, 50, 60, np.nan])  # the lowest row is the last one of the picture

    def test_landmarks_with_errors(self):
        """The turn has the least squares: with errors of known size, the residual has that size times sqrt((2 n - 3)/(2 n))."""
        rng = np.random.default_rng(5)
        wing = rng.uniform(-1, 1, (400, 2))
        problems = Problems()
        scan = wing @ turn_by(0.3).T + 2 + rng.normal(0, 0.01, wing.shape)
        found = by_landmarks([str(k) for k in range(400)], scan, wing, problems)
        self.assertEqual(problems.errors, [])
        self.assertLess(abs(found.angle() + 0.3), 4 * 0.01 / np.sqrt((wing**2).sum()))
        self.assertLess(abs(found.rms() / (0.01 * np.sqrt(2)) - 1), 4 / np.sqrt(2 * 800))

    def test_no_outliers_on_a_slope_or_at_an_edge(self):
        x, y = np.meshgrid(np.arange(40.0), np.arange(30.0))
        z = np.where(x + y < 50, 3 * x - 2 * y, np.nan)
        self.assertFalse(find_outliers(z, 1e-3).any())
        z[4, 7] += 1
        self.assertEqual(np.argwhere(find_outliers(z, 1e-3)).tolist(), [[4, 7]])


if __name__ == "__main__":
    with mock.patch.dict("os.environ", {"MPLBACKEND": "Agg"}):
        unittest.main()
