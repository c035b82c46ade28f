# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns a FLUSI mesh, a set of .dat files with one vein and one root vein, into a wing file.

usage: import_flusi_mesh FOLDER WING --unit METRES --root-vein D_ROOT D_TIP --vein D_ROOT D_TIP [--number 1]
                            [--areal-density KG_PER_M2] [--z-side "WING SIDE"]

FLUSI's sets contain lengths in their own unit (often the wing length), no diameters and no masses. Give the unit in metres, the
diameters of both veins in um at the end nearest to the root and at the other end, and the mass of a square metre of the membrane,
which is the same everywhere, as in FLUSI.

Files that are read: points_coor, mesh_triangle_elements, veins, veins_BC. Files that are compared with them if they exist:
veins_bending(_BC), veins_extension(_BC), membranes_extension, membrane_edge. vein_connectors become joints. Names of the newer
branch (triangle_elements, membranes_edge, joints) are accepted. Files that are not read: membranes (its points are those of the
triangles) and files of masses, which follow from diameters and area. Stored rest lengths and angles are not used, and springs
follow from triangles and veins. The span of the set must be along its x, the membrane in its x-y plane (or x-z, newer branch).
The wing is clamped at the first point of the root vein.
"""
from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from flusi_msm.errors import InputError, run_command
from flusi_msm.wing.file import Wing, WingMass, add_z_side, write_wing

TRIANGLE = 203  # type code of a triangle in these files
AREAL_DENSITY = 3e-3  # of a membrane [kg/m^2] if nothing is known: about 2.5 um of cuticle


class Folder:
    """The tables of one wing; all mistakes are collected in `mistakes`."""

    def __init__(self, path: str | Path, number: int) -> None:
        self.path, self.number = Path(path), number
        self.mistakes: list[str] = []
        self.notes: list[str] = []
        if not self.path.is_dir():
            raise InputError(f"{path}: no such folder")

    def wrong(self, text: str) -> None:
        """Adds a mistake."""
        self.mistakes.append(text)

    def table(self, names: Sequence[str], columns: tuple[int, int], needed: bool = True) -> tuple[np.ndarray | None, str]:
        """Returns the rows of a table without those that only fill it up (first column 0); None if there is no such file."""
        for name in names:
            file = self.path / f"{name}{self.number}.dat"
            if file.exists():
                break
        else:
            if needed:
                self.wrong(f"{self.path}: no file {names[0]}{self.number}.dat")
            return None, ""
        try:
            rows = [[float(word.replace("D", "E").replace("d", "e")) for word in line.split()]
                    for line in file.read_text().splitlines() if line.strip()]
        except (ValueError, OSError) as error:
            self.wrong(f"{file.name}: not a table of numbers: {error}")
            return None, file.name
        for i, row in enumerate(rows, 1):
            if len(row) < columns[0] or len(row) > columns[1] or not np.isfinite(row).all():
                self.wrong(f"{file.name}: row {i} has {len(row)} numbers; {columns[0]} to {columns[1]} expected")
                return None, file.name
        table = np.array([row[:columns[0]] for row in rows]).reshape(-1, columns[0])
        return table[table[:, 0] != 0], file.name

    def integers(self, rows: np.ndarray, name: str, columns: Sequence[int]) -> np.ndarray:
        """Returns columns of a table as integers."""
        part = rows[:, columns]
        if np.any(part != np.rint(part)):
            self.wrong(f"{name}: row {np.argwhere(part != np.rint(part))[0][0] + 1} has a fraction where a number "
                       "of a point belongs")
        return np.rint(part).astype(int)

    def check_index(self, rows: np.ndarray, name: str) -> bool:
        """Checks that rows are counted 1, 2, 3 ...; otherwise several veins are mixed in one table."""
        if np.array_equal(rows[:, 0], np.arange(1, len(rows) + 1)):
            return True
        self.wrong(f"{name}: rows are not counted 1 to {len(rows)}; sets with several veins are stored in scrambled "
                   "order and cannot be imported")
        return False


def read_points(folder: Folder) -> np.ndarray | None:
    """Returns the points (n, 3) in the unit of the set; None after a mistake."""
    rows, name = folder.table(["points_coor"], (4, 4))
    if rows is None or not folder.check_index(rows, name):
        return None
    xyz = rows[:, 1:]
    if np.ptp(xyz[:, 1]) == 0 < np.ptp(xyz[:, 2]):
        folder.notes.append(f"{name}: columns 3 and 4 are z and y (the newer branch swaps them)")
        xyz = xyz[:, [0, 2, 1]]
    return xyz


def read_triangles(folder: Folder, xyz: np.ndarray | None) -> np.ndarray | None:
    """Returns the triangles (m, 3), counter-clockwise; None after a mistake."""
    rows, name = folder.table(["mesh_triangle_elements", "triangle_elements"], (5, 5))
    if rows is None or xyz is None:
        return None
    if np.any(rows[:, 1] != TRIANGLE):
        folder.wrong(f"{name}: row {np.argmax(rows[:, 1] != TRIANGLE) + 1} is of type "
                     f"{rows[np.argmax(rows[:, 1] != TRIANGLE), 1]:g}, not a triangle ({TRIANGLE})")
    triangles = folder.integers(rows, name, [2, 3, 4]) - 1
    if not in_range(folder, triangles, len(xyz), name):
        return None
    a, b, c = (xyz[triangles[:, k], :2] for k in range(3))
    area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    if np.any(np.abs(area) < 1e-9 * np.ptp(xyz[:, 0])**2):
        folder.wrong(f"{name}: row {np.argmin(np.abs(area)) + 1} is a triangle without area")
    turned = area < 0
    if turned.any():
        folder.notes.append(f"{name}: {turned.sum()} of {len(area)} triangles turned counter-clockwise")
        triangles[turned] = triangles[turned][:, [0, 2, 1]]
    return triangles


def in_range(folder: Folder, numbers: np.ndarray, n: int, name: str) -> bool:
    """Returns whether all points exist."""
    bad = (numbers < 0) | (numbers >= n)
    if bad.any():
        folder.wrong(f"{name}: names point {numbers[bad].ravel()[0] + 1}; there are {n} points")
    return not bad.any()


def read_vein(folder: Folder, kind: str, n: int | None) -> list[int] | None:
    """Returns the points of the vein veins<kind>, checked against its springs."""
    rows, name = folder.table([f"veins{kind}"], (2, 2))
    if rows is None or n is None or not folder.check_index(rows, name):
        return None
    nodes = folder.integers(rows, name, [1])[:, 0] - 1
    if not in_range(folder, nodes, n, name):
        return None
    if len(nodes) < 2 or len(set(nodes.tolist())) < len(nodes):
        folder.wrong(f"{name}: a vein has at least two points, and no point twice")
        return None
    for spring, width, columns in ((f"veins_extension{kind}", 2, (3, 5)), (f"veins_bending{kind}", 3, (4, 8))):
        table, spring_name = folder.table([spring], columns, needed=False)
        if table is None or not folder.check_index(table, spring_name):
            continue
        stored = folder.integers(table, spring_name, list(range(1, width + 1))) - 1
        wanted = np.array([nodes[i:i + width] for i in range(len(nodes) - width + 1)]).reshape(-1, width)
        if not np.array_equal(stored, wanted):
            folder.wrong(f"{spring_name}: its springs are not those between the points of {name}")
    return nodes.tolist()


def check_springs(folder: Folder, wing: Wing) -> None:
    """Checks that springs of the membrane lie on edges of the mesh; in the wing file every edge has a spring."""
    edges = {tuple(e) for e in wing.edges()[0].tolist()}
    listed: dict[tuple[int, ...], int] = {}
    for names in (["membranes_extension"], ["membrane_edge", "membranes_edge"]):
        rows, name = folder.table(names, (3, 5), needed=False)
        if rows is None:
            continue
        for i, pair in enumerate(np.sort(folder.integers(rows, name, [1, 2]) - 1, axis=1).tolist(), 1):
            if tuple(pair) not in edges:
                folder.wrong(f"{name}: row {i} joins points {pair[0] + 1} and {pair[1] + 1}, which are not an edge of "
                             "a triangle")
                break
            listed[tuple(pair)] = listed.get(tuple(pair), 0) + 1
    for nodes, _ in wing.veins.values():
        for pair in zip(nodes, nodes[1:]):
            listed[tuple(sorted(pair))] = listed.get(tuple(sorted(pair)), 0) + 1
    twice = sum(count > 1 for count in listed.values())
    if twice:
        folder.notes.append(f"{twice} edges have two springs in the set, one in the wing file")
    if len(edges - listed.keys()):
        folder.notes.append(f"{len(edges - listed.keys())} edges have no spring in the set, one in the wing file")


def check_veins(folder: Folder, wing: Wing) -> dict[tuple[int, ...], str]:
    """Returns {segment: vein}; every segment must be an edge, and of one vein."""
    edges = {tuple(e) for e in wing.edges()[0].tolist()}
    seen: dict[tuple[int, ...], str] = {}
    for name, (nodes, _) in wing.veins.items():
        for pair in (tuple(sorted(p)) for p in zip(nodes, nodes[1:])):
            if pair not in edges:
                folder.wrong(f"vein {name}: points {pair[0] + 1} and {pair[1] + 1} are not an edge of a triangle")
            if pair in seen:
                folder.wrong(f"vein {name}: segment {pair[0] + 1}-{pair[1] + 1} is also in vein {seen[pair]}")
            seen[pair] = name
    return seen


def read_joints(folder: Folder, wing: Wing, segments: Mapping[tuple[int, ...], str]) -> None:
    """Adds the joints of the set to the wing."""
    rows, name = folder.table(["vein_connectors", "joints"], (4, 8), needed=False)
    if rows is None:
        folder.notes.append("no vein_connectors: the veins are not joined in bending")
        return
    triples = folder.integers(rows, name, [1, 2, 3]) - 1
    if not in_range(folder, triples, len(wing.points), name):
        return
    for i, (a, b, c) in enumerate(triples.tolist(), 1):
        if tuple(sorted((a, b))) in segments and tuple(sorted((b, c))) in segments and a != c:
            wing.joints[f"connector_{i}"] = (a, b, c)
        else:
            folder.wrong(f"{name}: row {i} (points {a + 1}, {b + 1}, {c + 1}) does not join two segments of veins")


def import_mesh(folder: Folder, unit: float, root_diameters: Sequence[float], diameters: Sequence[float]) -> Wing:
    """Returns the wing, in metres. Raises InputError with all mistakes."""
    xyz = read_points(folder)
    n = None if xyz is None else len(xyz)
    triangles = read_triangles(folder, xyz)
    root_vein, vein = read_vein(folder, "_BC", n), read_vein(folder, "", n)
    wing = None
    if not folder.mistakes and xyz is not None and triangles is not None and root_vein is not None and vein is not None:
        veins = {}
        for name, nodes, (first, last) in (("root_vein", root_vein, root_diameters), ("vein", vein, diameters)):
            at = np.concatenate([[0], np.cumsum(np.sqrt((np.diff(xyz[nodes], axis=0)**2).sum(1)))])
            veins[name] = (nodes, 1e-6 * (first + (last - first) * at / at[-1]))
        wing = Wing(unit * xyz, triangles, veins, {}, [root_vein[0]], f"Imported from {folder.path.name}")
        segments = check_veins(folder, wing)
        read_joints(folder, wing, segments)
        check_springs(folder, wing)
        unused = np.setdiff1d(np.arange(len(xyz)), triangles)
        if len(unused):
            folder.wrong(f"point {unused[0] + 1} and {len(unused) - 1} more belong to no triangle")
    if folder.mistakes or wing is None:
        raise InputError("\n  ".join([f"{folder.path}: the set cannot be imported:"] + folder.mistakes))
    return wing


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", help="with the .dat files")
    parser.add_argument("wing", metavar="WING", help="wing file to write")
    parser.add_argument("--unit", type=float, required=True, metavar="METRES", help="length unit of the set")
    parser.add_argument("--root-vein", type=float, nargs=2, required=True, metavar=("D_ROOT", "D_TIP"),
                        help="diameters of the vein veins_BC [um]")
    parser.add_argument("--vein", type=float, nargs=2, required=True, metavar=("D_ROOT", "D_TIP"),
                        help="diameters of the vein veins [um]")
    parser.add_argument("--number", type=int, default=1, help="of the wing, in the names of the files (default: 1)")
    parser.add_argument("--areal-density", type=float, metavar="KG_PER_M2",
                        help=f"of the membrane (default: {AREAL_DENSITY:g}, about 2.5 um of cuticle)")
    add_z_side(parser)
    options = parser.parse_args()
    density = AREAL_DENSITY if options.areal_density is None else options.areal_density
    numbers = [options.unit, density] + options.root_vein + options.vein
    if not (np.isfinite(numbers).all() and min(numbers) > 0):
        raise InputError("--unit, --areal-density and the diameters must be positive")
    folder = Folder(options.folder, options.number)
    wing = import_mesh(folder, options.unit, options.root_vein, options.vein)
    wing.z_side = options.z_side
    source = "assumed: about 2.5 um of cuticle" if options.areal_density is None else "--areal-density"
    wing.mass = WingMass("uniform", density * wing.areas().sum(), source)
    if options.areal_density is None:
        folder.notes.append(f"the membrane weighs {density:g} kg/m^2 as nothing else is said (--areal-density)")
    write_wing(options.wing, wing)
    for note in folder.notes:
        print(f"note: {note}")
    print(f"{options.wing}: {wing.title}\n{wing.summary()}")


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("import_flusi_mesh", main)
