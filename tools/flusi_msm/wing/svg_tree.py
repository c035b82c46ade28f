# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the shapes in an SVG file as Bezier curves in the units of the page, with their names, layers and lines.

Transforms, view boxes, clones (use) and inherited styles are applied. Path data are read by svgelements.
"""
from __future__ import annotations

import re
import xml.sax
from collections.abc import Iterator
from dataclasses import dataclass, field
from types import ModuleType

import numpy as np

from flusi_msm.errors import InputError

PPI = 96.0                                     # of a page, as in CSS and Inkscape
CONTAINERS = {"svg", "g", "a", "switch"}
INVISIBLE = {"defs", "symbol", "clipPath", "mask", "pattern", "marker", "metadata", "namedview", "style", "title", "desc",
             "linearGradient", "radialGradient", "filter", "script"}
INHERITED = ("stroke", "stroke-width", "visibility")
AUTOMATIC = re.compile(r"(path|line|polyline|polygon|circle|ellipse|rect|g|use|svg|image|text|layer|XMLID|Layer|Ebene)"
                       r"[-_]?[\d_-]*")
CLASS = re.compile(r"([^{}]+)\{([^{}]*)\}")
MOST_CLONES = 8                                # of clones inside clones


@dataclass
class Node:
    """An element of the file; names without their name space."""
    tag: str
    attributes: dict[str, str]
    line: int
    children: list["Node"] = field(default_factory=list)
    text: str = ""

    def child_text(self, tag: str) -> str:
        """Returns the texts of all children with this tag."""
        return " ".join(child.text.strip() for child in self.children if child.tag == tag)


@dataclass
class Subpath:
    """A connected piece of a path: arrays (2, 2), (3, 2) or (4, 2) of control points, end to end."""
    curves: list[np.ndarray]
    closed: bool

    def flatten(self, tolerance: float) -> np.ndarray:
        """Returns points (n, 2) on the piece whose polygon differs from it by less than `tolerance`."""
        points = [self.curves[0][:1]]
        for curve in self.curves:
            second = np.abs(np.diff(curve, 2, axis=0)).max() if len(curve) > 2 else 0.0
            degree = len(curve) - 1
            pieces = max(1, int(np.ceil(np.sqrt(degree * (degree - 1) / 8 * 1.5 * second / tolerance))))
            t = np.arange(1, pieces + 1)[:, None] / pieces
            stage = [control[None, :] for control in curve]
            while len(stage) > 1:
                stage = [(1 - t) * a + t * b for a, b in zip(stage, stage[1:])]
            points.append(np.broadcast_to(stage[0], (pieces, 2)) if degree else stage[0])
        path = np.concatenate(points)
        keep = np.concatenate([[True], np.any(np.abs(np.diff(path, axis=0)) > 1e-9 * (1 + np.abs(path[1:])), axis=1)])
        return path[keep]


@dataclass
class Shape:
    """A visible shape. `page` is the size of one unit of the drawing on the page, in pixels of the page."""
    tag: str
    label: str                                 # the name that the user gave it; "" if it has only automatic names
    layers: list[str]                          # names of the groups around it, innermost first
    line: int
    subpaths: list[Subpath] = field(default_factory=list)
    stroke_width: float | None = None       # in pixels of the page
    note: str = ""                             # description and the attribute data-diameters

    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Returns the smallest and largest coordinates of the points on it."""
        points = np.concatenate([path.flatten(1e-2) for path in self.subpaths])
        return points.min(0), points.max(0)


@dataclass
class SvgDrawing:
    """A drawing that was read."""
    shapes: list[Shape]
    title: str
    unit: float                                # one unit of the file in pixels of the page; nan: two different ones
    is_physical: bool                          # whether the page has a size in mm or another real unit
    ignored: dict[str, int]                    # elements that were left out: {tag: number}


class _Builder(xml.sax.ContentHandler):
    def __init__(self) -> None:
        super().__init__()
        self.root: Node | None = None
        self.locator: "xml.sax.xmlreader.Locator" | None = None
        self.stack: list[Node] = []

    def setDocumentLocator(self, locator: "xml.sax.xmlreader.Locator") -> None:
        self.locator = locator

    def startElement(self, name: str, attrs: "xml.sax.xmlreader.AttributesImpl") -> None:
        attributes = {}
        for key, value in attrs.items():
            attributes["label" if key == "inkscape:label" else key.split(":")[-1] if key.startswith("xlink") else key] = value
        node = Node(name.split(":")[-1], attributes, (self.locator and self.locator.getLineNumber()) or 0)
        if self.stack:
            self.stack[-1].children.append(node)
        else:
            self.root = node
        self.stack.append(node)

    def endElement(self, name: str) -> None:
        self.stack.pop()

    def characters(self, content: str) -> None:
        self.stack[-1].text += content


def _read_tree(path: str) -> Node:
    builder = _Builder()
    parser = xml.sax.make_parser()
    parser.setFeature(xml.sax.handler.feature_external_ges, False)
    parser.setContentHandler(builder)
    try:
        with open(path, "rb") as file:
            parser.parse(file)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except xml.sax.SAXParseException as error:
        raise InputError(f"{path}:{error.getLineNumber()}: not a readable SVG file: {error.getMessage()}") from None
    if builder.root is None or builder.root.tag != "svg":
        raise InputError(f"{path}: not an SVG file: its outermost element is not <svg>")
    return builder.root


def _svgelements() -> ModuleType:
    try:
        import svgelements
    except ModuleNotFoundError:
        raise InputError("SVG files need the Python package svgelements: 'tools/quickstart deps' installs it, or "
                         "python -m pip install svgelements") from None
    return svgelements


class _Reader:
    """Goes through the tree of one file."""

    def __init__(self, path: str) -> None:
        self.path, self.root, self.lib = path, _read_tree(path), _svgelements()
        self.shapes: list[Shape] = []
        self.ignored: dict[str, int] = {}
        self.named = {node.attributes["id"]: node for node in self.every(self.root) if "id" in node.attributes}
        self.classes: dict[str, dict[str, str]] = {}
        for node in self.every(self.root):
            if node.tag == "style":
                for names, body in CLASS.findall(re.sub(r"/\*.*?\*/", "", node.text, flags=re.S)):
                    for name in names.split(","):
                        self.classes.setdefault(name.strip(), {}).update(self.declarations(body))

    def every(self, node: Node) -> Iterator[Node]:
        yield node
        for child in node.children:
            yield from self.every(child)

    @staticmethod
    def declarations(text: str) -> dict[str, str]:
        pairs = (part.split(":", 1) for part in text.split(";") if ":" in part)
        return {key.strip(): value.strip() for key, value in pairs}

    def complain(self, node: Node, text: str) -> InputError:
        return InputError(f"{self.path}:{node.line}: <{node.tag}>: {text}")

    def length(self, node: Node, key: str, default: float = 0.0) -> float:
        """Returns a length in units of the drawing."""
        text = node.attributes.get(key, "")
        if not text:
            return default
        try:
            return float(self.lib.Length(text).value(ppi=PPI))
        except (TypeError, ValueError, AttributeError):
            raise self.complain(node, f"{key} = '{text}' is not a length") from None

    def matrix(self, node: Node) -> np.ndarray:
        text = node.attributes.get("transform", "")
        try:
            m = self.lib.Matrix(text)
            found = np.array([[m.a, m.c, m.e], [m.b, m.d, m.f], [0, 0, 1]], float)
        except (TypeError, ValueError, AttributeError, IndexError):
            raise self.complain(node, f"transform = '{text}' cannot be understood") from None
        return found

    def view_box(self, node: Node) -> np.ndarray:
        """Returns the transform from the units of an <svg> to those around it."""
        move = np.eye(3)
        move[:2, 2] = self.length(node, "x"), self.length(node, "y")
        text = node.attributes.get("viewBox", "")
        if not text:
            return move
        try:
            x, y, width, height = (float(v) for v in re.split(r"[\s,]+", text.strip()))
        except ValueError:
            raise self.complain(node, f"viewBox = '{text}' are not four numbers") from None
        if not (width > 0 and height > 0):
            raise self.complain(node, f"viewBox = '{text}' has no size")
        size = [node.attributes.get(key, "100%") for key in ("width", "height")]
        wide, high = (None if "%" in text else self.length(node, key) for key, text in zip(("width", "height"), size))
        sx = wide / width if wide else None
        sy = high / height if high else None
        sx, sy = sx or sy or 1.0, sy or sx or 1.0
        if node.attributes.get("preserveAspectRatio", "").split(" ")[0] != "none" and wide and high:
            sx = sy = max(sx, sy) if "slice" in node.attributes.get("preserveAspectRatio", "") else min(sx, sy)
        return move @ np.array([[sx, 0, -sx * x], [0, sy, -sy * y], [0, 0, 1.0]])

    def style(self, node: Node, inherited: dict[str, str]) -> dict[str, str]:
        own = {key: node.attributes[key] for key in (*INHERITED, "display") if key in node.attributes}
        for key in [node.tag, *("." + name for name in node.attributes.get("class", "").split()),
                    "#" + node.attributes.get("id", "")]:
            own.update(self.classes.get(key, {}))
        own.update(self.declarations(node.attributes.get("style", "")))
        return {**{key: inherited[key] for key in INHERITED if key in inherited}, **own}

    @staticmethod
    def label(node: Node) -> str:
        text = node.attributes.get("label", "").strip()
        if text:
            return text
        text = node.attributes.get("id", "")
        return "" if AUTOMATIC.fullmatch(text) else text

    def curves(self, node: Node) -> list[Subpath]:
        """Returns the geometry of a shape in its own units."""
        try:
            path = self.lib.Path(self.path_data(node))
        except InputError:
            raise
        except Exception as error:  # svgelements raises plain exceptions of Python
            raise self.complain(node, f"its path data cannot be understood ({error})") from None
        found: list[Subpath] = []
        for part in path:
            kind = type(part).__name__
            if kind == "Move":
                found.append(Subpath([], False))
            elif kind == "Arc":
                for cubic in part.as_cubic_curves():
                    found[-1].curves.append(self.controls(cubic))
            else:
                if found[-1].closed:           # drawing continues after a Z without an M
                    found.append(Subpath([], False))
                if kind == "Close":
                    found[-1].closed = True
                    if part.end is None or part.start == part.end:
                        continue
                found[-1].curves.append(self.controls(part))
        found = [path for path in found if path.curves]
        for path in found:
            first, last = path.curves[0][0], path.curves[-1][-1]
            path.closed = path.closed or bool(len(path.curves) > 1 and np.abs(first - last).max() <= 1e-9 * (1 + np.abs(first).max()))
        return found

    @staticmethod
    def controls(part: object) -> np.ndarray:
        names = {"CubicBezier": ("start", "control1", "control2", "end"), "QuadraticBezier": ("start", "control", "end")}
        return np.array([[getattr(part, name).x, getattr(part, name).y]
                         for name in names.get(type(part).__name__, ("start", "end"))], float)

    def path_data(self, node: Node) -> str:
        """Returns any shape as path data."""
        tag, a = node.tag, node.attributes
        if tag == "path":
            return a.get("d", "")
        if tag == "line":
            x1, y1, x2, y2 = (self.length(node, key) for key in ("x1", "y1", "x2", "y2"))
            return f"M {x1!r} {y1!r} L {x2!r} {y2!r}"
        if tag in ("polyline", "polygon"):
            return f"M {a.get('points', '')}" + (" Z" if tag == "polygon" else "") if a.get("points", "").strip() else ""
        if tag == "rect":
            x, y, w, h = (self.length(node, key) for key in ("x", "y", "width", "height"))
            return f"M {x!r} {y!r} h {w!r} v {h!r} h {-w!r} Z"
        cx, cy = self.length(node, "cx"), self.length(node, "cy")
        rx = self.length(node, "r") if tag == "circle" else self.length(node, "rx")
        ry = self.length(node, "r") if tag == "circle" else self.length(node, "ry")
        return f"M {cx - rx!r} {cy!r} a {rx!r} {ry!r} 0 1 0 {2 * rx!r} 0 a {rx!r} {ry!r} 0 1 0 {-2 * rx!r} 0 Z"

    def ignore(self, what: str) -> None:
        self.ignored[what] = self.ignored.get(what, 0) + 1

    def visit(self, node: Node, matrix: np.ndarray, inherited: dict[str, str], layers: list[str], clones: int = 0,
              called: str = "") -> None:
        """Visits a node. `called`: the name of a clone of this node."""
        style = self.style(node, inherited)
        if node.tag in INVISIBLE:
            return
        if style.get("display") == "none":
            self.ignore("hidden item")
            return
        matrix = matrix @ self.matrix(node)
        if node.tag in CONTAINERS:
            if node.tag == "svg":
                matrix = matrix @ self.view_box(node)
            name = called or (self.label(node) if node is not self.root else "")
            for child in node.children:
                self.visit(child, matrix, style, [name, *layers] if name else layers, clones)
        elif node.tag == "use":
            target = self.named.get(node.attributes.get("href", "").lstrip("#"))
            if target is None or clones >= MOST_CLONES:
                raise self.complain(node, f"is a clone of '{node.attributes.get('href', '')}', which does not exist or "
                                          "contains itself: unlink the clone")
            move = np.eye(3)
            move[:2, 2] = self.length(node, "x"), self.length(node, "y")
            self.visit(target, matrix @ move, style, layers, clones + 1, called or self.label(node))
        elif node.tag in ("path", "line", "polyline", "polygon", "rect", "circle", "ellipse"):
            if style.get("visibility") in ("hidden", "collapse"):
                self.ignore("hidden item")
            else:
                self.add_shape(node, matrix, style, layers, called or self.label(node))
        else:
            self.ignore(node.tag)

    def add_shape(self, node: Node, matrix: np.ndarray, style: dict[str, str], layers: list[str], label: str) -> None:
        subpaths = self.curves(node)
        for path in subpaths:
            path.curves = [curve @ matrix[:2, :2].T + matrix[:2, 2] for curve in path.curves]
        width = None
        if style.get("stroke", "none") != "none" or "stroke-width" in style:
            text = style.get("stroke-width", "1")
            try:
                width = float(self.lib.Length(text).value(ppi=PPI)) * np.sqrt(abs(np.linalg.det(matrix[:2, :2])))
            except (TypeError, ValueError, AttributeError):
                raise self.complain(node, f"stroke-width = '{text}' is not a length") from None
        note = " ".join(filter(None, (node.child_text("desc"), node.attributes.get("data-diameters", "") and
                                      "diameters " + node.attributes["data-diameters"])))
        self.shapes.append(Shape(node.tag, label, layers, node.line, subpaths, width, note))

    def read(self) -> SvgDrawing:
        matrix = self.view_box(self.root)
        self.visit(self.root, np.eye(3), {}, [])
        sx, sy = np.hypot(*matrix[:2, 0]), np.hypot(*matrix[:2, 1])
        unit = float(sx) if abs(sx - sy) <= 1e-3 * sx else float("nan")
        is_physical = bool(re.search(r"(mm|cm|in|pt|pc|Q)\s*$", self.root.attributes.get("width", "")))
        return SvgDrawing(self.shapes, self.root.child_text("title"), unit, is_physical, self.ignored)


def read_svg_shapes(path: str) -> SvgDrawing:
    """Returns all visible shapes of an SVG file. Raises InputError with file and line for what cannot be understood."""
    return _Reader(str(path)).read()
