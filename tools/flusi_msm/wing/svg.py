# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads wings that were traced in Inkscape or another editor of SVG files: finds what each shape means
(docs/guide/make-wing.md)."""
from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from flusi_msm.errors import Problems
from flusi_msm.wing.svg_tree import PPI, Shape, SvgDrawing, read_svg_shapes
from flusi_msm.wing.trace import JointMark, Line, Sketch, parse_diameters

INCH = 0.0254
FLAT = 2e-5                                     # error of flattened curves by the size of the drawing
ROLES = {"outline": "outline", "margin": "outline", "vein": "vein", "veins": "vein", "joint": "joint", "joints": "joint",
         "root": "root", "scale": "scale", "axis": "axis", "leading": "leading"}
IGNORED = {"ignore", "ignored", "photo", "photograph", "background", "notes", "guides", "image"}
SCALE = re.compile(r"(\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)[\s_-]*(nm|um|µm|μm|mm|cm|m)\b")
METRES = {"nm": 1e-9, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
WORD = re.compile(r"([A-Za-z]+)(?:[\s:_-]+(.*))?", re.S)
ROUND = {"circle", "ellipse"}


def _layer_role(text: str) -> str:
    """Returns the word by which a layer says what is in it, or ''."""
    name = text.lower().strip()
    return name if name in ROLES or name in IGNORED else "scale" if re.match(r"scale\b", name) else ""


def _role_of(shape: Shape) -> tuple[str, str]:
    """Returns the meaning of the shape, and its name without the word for it. The meaning is one of ROLES, 'ignored', or ''."""
    found = WORD.fullmatch(shape.label)
    word, rest = (found[1].lower(), (found[2] or "").strip()) if found else ("", "")
    if word in IGNORED:
        return "ignored", ""
    if word in ("scale", "outline", "axis", "leading") or (word == "root" and not rest.strip("0123456789")):
        return ROLES[word], rest
    layer = next((name for name in map(_layer_role, shape.layers) if name), "")
    if layer in IGNORED:
        return "ignored", ""
    if word in ("joint", "vein") and rest:
        return word, rest
    named = shape.label or next((text for text in shape.layers if not _layer_role(text)), "")
    if layer:
        return ROLES[layer], named
    if shape.tag in ROUND:
        return "joint", named
    return ("vein" if shape.subpaths and not all(path.closed for path in shape.subpaths) else ""), named


def _clean(name: str) -> str:
    return re.sub(r"\s+", "_", name.strip())


class _Sorter:
    """Adds the shapes of one drawing to a Sketch."""

    def __init__(self, path: str, drawing: SvgDrawing, problems: Problems) -> None:
        self.path, self.drawing, self.problems = path, drawing, problems
        self.sketch = Sketch(path, drawing.title or Path(path).stem)
        corners = [shape.corners() for shape in drawing.shapes if shape.subpaths]
        size = max(np.max([c[1] for c in corners], axis=0) - np.min([c[0] for c in corners], axis=0)) if corners else 1.0
        self.tolerance = FLAT * float(size or 1.0)

    def where(self, shape: Shape, kind: str, name: str) -> str:
        return f"{self.path}:{shape.line}: {kind}" + (f" '{name}'" if name else f" <{shape.tag}>")

    def line(self, shape: Shape, kind: str, name: str) -> Line | None:
        """Returns the one connected piece of the shape, y up."""
        where = self.where(shape, kind, name)
        if not shape.subpaths:
            self.problems.error(f"{where}: is empty: delete it")
            return None
        if len(shape.subpaths) > 1:
            self.problems.error(f"{where}: has {len(shape.subpaths)} pieces that are not connected: join their nodes, or split "
                                "it (in Inkscape: Path > Break Apart) and name every piece")
            return None
        points = shape.subpaths[0].flatten(self.tolerance) * (1, -1)
        if len(points) < 2:
            self.problems.error(f"{where}: has no length: delete it")
            return None
        return Line(name, points, where, shape.subpaths[0].closed, shape.stroke_width)

    def middle(self, shape: Shape) -> tuple[np.ndarray, float]:
        low, high = shape.corners()
        return (low + high) / 2 * (1, -1), float(max(high - low)) / 2

    def add_scale(self, shape: Shape, rest: str) -> None:
        where = self.where(shape, "scale bar", shape.label)
        found = SCALE.search(rest) or SCALE.search(shape.note) or next(filter(None, map(SCALE.search, shape.layers)), None)
        bar = self.line(shape, "scale bar", shape.label)
        if not found:
            self.problems.error(f"{where}: does not say how long it is: call it for instance 'scale 1 mm'")
        elif bar is not None:
            low, high = bar.points.min(0), bar.points.max(0)
            drawn = float(max(high - low)) if bar.closed else float(np.linalg.norm(bar.points[-1] - bar.points[0]))
            if drawn > 0:
                self.sketch.scales.append((float(found[1].replace(",", ".")) * METRES[found[2]] / drawn, where))
            else:
                self.problems.error(f"{where}: has no length")

    def add_vein(self, shape: Shape, name: str) -> None:
        name = _clean(name)
        if not name:
            self.problems.error(f"{self.where(shape, 'line', '')}: has no name: give it a label (in Inkscape: Object > Object "
                                "Properties), or put it into a layer called 'ignore'")
            return
        vein = self.line(shape, "vein", name)
        if vein is None:
            return
        text = re.search(r"diameters?(?:\s*\[[^\]]*\])?\s*[:=]?\s*([-+\d.:,;\seE]+)", shape.note)
        if text:
            vein.diameters = parse_diameters(text[1])
            if vein.diameters is None:
                self.problems.error(f"{vein.where}: its diameters '{text[1].strip()}' are not a table: write for instance "
                                    "'diameters 100 60 20' or 'diameters 0:100 0.3:60 1:20', in um from its first point on")
        self.sketch.veins.append(vein)

    def add_joint(self, shape: Shape, text: str) -> None:
        name, _, veins = text.partition("@")
        name = _clean(name)
        where = self.where(shape, "joint", name)
        if not name:
            self.problems.error(f"{where}: has no name: give it a label")
            return
        if not shape.subpaths:
            self.problems.error(f"{where}: is empty: delete it")
            return
        place, radius = self.middle(shape)
        chosen = tuple(_clean(v) for v in re.split(r">", veins) if v.strip())
        self.sketch.joints.append(JointMark(name, place, radius, where, chosen))

    def sort(self) -> Sketch:
        n_ignored = 0
        for shape in self.drawing.shapes:
            role, rest = _role_of(shape)
            if role == "ignored":
                n_ignored += 1
            elif role == "scale":
                self.add_scale(shape, rest)
            elif role == "vein":
                self.add_vein(shape, rest)
            elif role == "joint":
                self.add_joint(shape, rest)
            elif role == "leading":
                self.sketch.leading.append(self.middle(shape)[0])
            elif role in ("outline", "root", "axis"):
                line = self.line(shape, role, shape.label)
                if line is not None:
                    {"outline": self.sketch.outlines, "root": self.sketch.roots, "axis": self.sketch.axes}[role].append(line)
            else:
                self.problems.error(f"{self.where(shape, 'closed shape', shape.label)}: is no outline (call it 'outline'), no "
                                    "joint (a circle) and no vein (an open line): name it, or put it into a layer called "
                                    "'ignore'")
        left = [f"{count} {tag}" + ("s" if count > 1 else "") for tag, count in sorted(self.drawing.ignored.items())]
        left += [f"{n_ignored} shape" + ("s" if n_ignored > 1 else "") + " in layers to ignore"] if n_ignored else []
        if left:
            self.sketch.notices.append(f"{self.path}: left out: {', '.join(left)}")
        return self.sketch


def read_svg(path: str, problems: Problems, metres_per_unit: float | None = None, is_true_size: bool = False) -> Sketch:
    """Returns the wing in an SVG file; mistakes are added to `problems`, or are raised if the file cannot be read at all.
    `metres_per_unit`: of the coordinates in the file; `is_true_size`: the page is as large as the wing."""
    drawing = read_svg_shapes(path)
    sketch = _Sorter(str(path), drawing, problems).sort()
    if metres_per_unit is not None:
        if np.isnan(drawing.unit):
            problems.error(f"{path}: a unit is not the same along x and y on this page (preserveAspectRatio = none): use a "
                           "scale bar, or set the page's ratio right")
        else:
            sketch.scales.append((metres_per_unit / drawing.unit, "metres per unit"))
    if is_true_size:
        if drawing.is_physical:
            sketch.scales.append((INCH / PPI, "the size of the page"))
        else:
            problems.error(f"{path}: its page has no width in mm or another real unit, so that it has no true size: set it, or "
                           "draw a scale bar")
    return sketch
