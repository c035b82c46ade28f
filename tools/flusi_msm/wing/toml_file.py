# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads wings from tables: a TOML file that holds outline, veins, joints and root, or adds to a drawing
(docs/guide/make-wing.md)."""
from __future__ import annotations

import difflib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.errors import InputError, Problems
from flusi_msm.wing.curves import spline
from flusi_msm.wing.ini_outline import read_fourier_outline
from flusi_msm.wing.svg import read_svg
from flusi_msm.wing.trace import DiameterTable, JointMark, Line, Sketch, parse_diameters

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
TOP = {"title", "drawing", "metres_per_unit", "true_size", "unit", "edge_mm", "snap_mm", "z_side", "membrane_mass_ug", "mass_source",
       "outline",
       "veins", "joints", "root"}
KEYS = {"outline": {"points", "shape", "fourier", "length"}, "veins": {"points", "shape", "diameters_um", "free_end"},
        "joints": {"at", "veins"}, "root": {"points", "part"}}


def _load(path: str) -> dict[str, Any]:
    try:
        import tomllib
    except ModuleNotFoundError:
        try:
            import tomli as tomllib  # type: ignore[no-redef]
        except ModuleNotFoundError:
            raise InputError("TOML files need Python 3.11, or the Python package tomli: python -m pip install tomli") from None
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not a readable TOML file: {error}") from None


class _Table:
    """Reads a TOML file into a Sketch; every mistake is added to `problems`."""

    def __init__(self, path: str, problems: Problems) -> None:
        self.path, self.problems, self.data = path, problems, _load(path)

    def wrong(self, where: str, text: str) -> None:
        self.problems.error(f"{self.path}: {where}: {text}")

    def known(self, where: str, table: Any, names: Sequence[str]) -> dict[str, Any]:
        if not isinstance(table, dict):
            self.wrong(where, f"must be a table [{where}]")
            return {}
        for key in table:
            if key not in names:
                near = difflib.get_close_matches(key, list(names), n=1)
                self.wrong(where or "top", f"unknown key '{key}'" + (f"; did you mean '{near[0]}'?" if near else
                                                                    f"; there are {', '.join(sorted(names))}"))
        return table

    def number(self, where: str, table: dict[str, Any], key: str) -> float | None:
        value = table.get(key)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value) or value <= 0:
            self.wrong(where, f"{key} = {value!r} must be a positive number")
            return None
        return float(value)

    def points(self, where: str, value: Any, least: int) -> np.ndarray | None:
        try:
            points = np.array(value, float)
        except (TypeError, ValueError):
            points = np.zeros(0)
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < least or not np.isfinite(points).all():
            self.wrong(where, f"points must be a list of {least} or more pairs [x, y]")
            return None
        if (np.abs(np.diff(points, axis=0)).sum(1) == 0).any():
            self.wrong(where, "points: two neighbours are the same point")
            return None
        return points

    def line(self, where: str, table: dict[str, Any], least: int = 2) -> np.ndarray | None:
        points = self.points(where, table.get("points"), least)
        shape = table.get("shape", "curve")
        if shape not in ("curve", "polygon"):
            self.wrong(where, f"shape = {shape!r} must be 'curve' or 'polygon'")
        if points is None or shape == "polygon" or len(points) == 2:
            return points
        return np.array(spline([tuple(p) for p in points.tolist()])[0])

    def diameters(self, where: str, value: Any) -> DiameterTable | None:
        if isinstance(value, (int, float)):
            value = [value]
        try:
            if isinstance(value, list) and all(isinstance(v, list) for v in value):
                text = " ".join(f"{float(part)!r}:{float(d)!r}" for part, d in value)
            else:
                text = " ".join(repr(float(v)) for v in value)
        except (TypeError, ValueError):
            text = ""
        table = parse_diameters(text) if text else None
        if table is None:
            self.wrong(where, "diameters_um must be a number, a list of numbers at equal parts of the vein, or a list of pairs "
                       "[part, diameter]")
        return table

    def base(self) -> Sketch:
        """Returns the drawing that the file names, or an empty sketch in the wing frame."""
        data = self.data
        metres = self.number("top", data, "metres_per_unit")
        if "drawing" in data:
            path = Path(self.path).parent / str(data["drawing"])
            sketch = read_svg(str(path), self.problems, metres, bool(data.get("true_size", False)))
            return sketch
        sketch = Sketch(self.path, Path(self.path).stem, is_in_frame=True)
        unit = data.get("unit", "m" if metres is None else None)
        if unit is not None and unit not in UNITS:
            self.wrong("top", f"unit = {unit!r} must be one of {', '.join(UNITS)}")
        elif metres is None and "unit" not in data:
            self.problems.error(f"{self.path}: no scale: give unit = \"mm\" (or m, cm, um), or metres_per_unit")
            sketch.scales.append((1e-3, self.path))
        else:
            sketch.scales.append((UNITS[unit] if unit else float(metres or 1.0), self.path))
        return sketch

    def add_outline(self, sketch: Sketch) -> None:
        if "outline" not in self.data:
            return
        table = self.known("outline", self.data["outline"], sorted(KEYS["outline"]))
        if "fourier" in table:
            points = read_fourier_outline(str(Path(self.path).parent / str(table["fourier"])))
            length = self.number("outline", table, "length")
            if length:
                points = points * length / points[:, 0].max()
        else:
            found = self.line("outline", table, 3)
            if found is None:
                return
            points = found
        if not sketch.is_in_frame:
            self.wrong("outline", "the drawing has the outline: leave out one of them")
            return
        if np.allclose(points[0], points[-1]):
            points = points[:-1]
        sketch.outlines.append(Line("outline", points, f"{self.path}: outline", True))

    def add_veins(self, sketch: Sketch) -> None:
        drawn = {vein.name: vein for vein in sketch.veins}
        for name, entry in self.known("veins", self.data.get("veins", {}), list(self.data.get("veins", {}))).items():
            where = f"veins.{name}"
            table = self.known(where, entry, sorted(KEYS["veins"]))
            vein = drawn.get(name)
            if "points" in table and sketch.is_in_frame:
                points = self.line(where, table)
                if points is None:
                    continue
                vein = Line(name, points, f"{self.path}: vein '{name}'")
                sketch.veins.append(vein)
            elif vein is None:
                self.wrong(where, "is not drawn" + (f"; there are {', '.join(drawn)}" if drawn else ": give its points"))
                continue
            elif "points" in table:
                self.wrong(where, "the drawing has this vein: leave out its points")
            if "diameters_um" in table:
                vein.diameters = self.diameters(where, table["diameters_um"])
            vein.free_end = bool(table.get("free_end", vein.free_end))

    def add_joints(self, sketch: Sketch) -> None:
        drawn = {joint.name: joint for joint in sketch.joints}
        for name, entry in self.known("joints", self.data.get("joints", {}), list(self.data.get("joints", {}))).items():
            where = f"joints.{name}"
            table = self.known(where, entry, sorted(KEYS["joints"]))
            joint = drawn.get(name)
            if "at" in table and sketch.is_in_frame:
                place = self.points(where, [table["at"]], 1)
                if place is None:
                    continue
                joint = JointMark(name, place[0], 0.0, f"{self.path}: joint '{name}'")
                sketch.joints.append(joint)
            elif joint is None:
                self.wrong(where, "is not drawn" + (f"; there are {', '.join(drawn)}" if drawn else ": give its place 'at'"))
                continue
            veins = table.get("veins", list(joint.veins))
            joint.veins = tuple(map(str, [veins] if isinstance(veins, str) else veins))

    def add_root(self, sketch: Sketch) -> None:
        if "root" not in self.data:
            return
        table = self.known("root", self.data["root"], sorted(KEYS["root"]))
        if "part" in table:
            sketch.root_part = self.number("root", table, "part") or 0.03
            if sketch.roots:
                self.wrong("root", "the drawing has a root: leave out 'part'")
        elif sketch.is_in_frame:
            points = self.points("root", table.get("points"), 2)
            if points is not None:
                sketch.roots.append(Line("root", points, f"{self.path}: root"))
        else:
            self.wrong("root", "draw the root, or give its 'part'")

    def read(self) -> Sketch:
        data = self.known("", self.data, sorted(TOP))
        sketch = self.base()
        sketch.title = str(data.get("title", sketch.title))
        sketch.z_side = str(data.get("z_side", ""))
        sketch.mass_source = str(data.get("mass_source", ""))
        for key, name, unit in (("edge_mm", "edge", 1e-3), ("snap_mm", "snap", 1e-3), ("membrane_mass_ug", "membrane_mass", 1e-9)):
            value = self.number("top", data, key)
            if value is not None:
                setattr(sketch, name, value * unit)
        self.add_outline(sketch)
        self.add_veins(sketch)
        self.add_joints(sketch)
        self.add_root(sketch)
        return sketch


def read_toml(path: str, problems: Problems) -> Sketch:
    """Returns the wing in a TOML file; mistakes are added to `problems`, or are raised if a file cannot be read at all."""
    return _Table(str(path), problems).read()


def read_ini(path: str, problems: Problems, length: float | None, root_part: float) -> Sketch:
    """Returns a wing without veins from a Fourier outline, scaled to `length` [m], held over `root_part` of its length."""
    points = read_fourier_outline(path)
    sketch = Sketch(path, Path(path).stem, is_in_frame=True, root_part=root_part)
    sketch.outlines.append(Line("outline", points, f"{path}: outline", True))
    if length is None:
        problems.error(f"{path}: no scale: its unit is the wing length; give --length MM")
    else:
        sketch.scales.append((length / float(points[:, 0].max()), "--length"))
    return sketch
