# SPDX-License-Identifier: GPL-3.0-or-later
"""A traced wing: outline, veins, joints and root as lines, before there is a mesh.

Readers of drawings make a `Sketch`, in any unit and orientation. `trace_of` turns it into a `Trace`: metres, in the
wing frame, with x from root to tip and y toward the leading edge.
"""
from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from flusi_msm.errors import Problems

NAME = re.compile(r"[A-Za-z0-9_+-]{1,64}")
LARGEST_WING, SMALLEST_WING = 2.0, 5e-5        # m, length
THICK, TOO_THICK = 0.06, 0.25                  # diameter by length of the wing: unusual, impossible
DiameterTable = Sequence[tuple[float, float]]  # (part of the length, diameter [m]), linear in between


@dataclass
class Line:
    """A line of a drawing. `where` names it in messages: file, line of the file, name."""
    name: str
    points: np.ndarray                         # (n, 2) in units of the drawing, y up
    where: str
    closed: bool = False
    width: float | None = None              # of the stroke, in units of the drawing
    diameters: DiameterTable | None = None  # has priority over the width
    free_end: bool = False                     # may end inside the membrane


@dataclass
class JointMark:
    """The mark of a joint in a drawing."""
    name: str
    place: np.ndarray                          # (2,) in units of the drawing
    radius: float
    where: str
    veins: tuple[str, ...] = ()                # the hinge, where veins meet: inside one vein, or from one into another


@dataclass
class Sketch:
    """A drawing in its own units, y up. A list that should have one item keeps all that were found."""
    source: str
    title: str = ""
    outlines: list[Line] = field(default_factory=list)
    veins: list[Line] = field(default_factory=list)
    joints: list[JointMark] = field(default_factory=list)
    roots: list[Line] = field(default_factory=list)
    root_part: float = 0.0                     # > 0: the root is the outline over this part of the length
    axes: list[Line] = field(default_factory=list)      # from the hinge toward the tip
    leading: list[np.ndarray] = field(default_factory=list)  # a point on the side of the leading edge
    scales: list[tuple[float, str]] = field(default_factory=list)  # metres per unit, and where this is stated
    is_in_frame: bool = False                  # coordinates are already those of the wing frame
    z_side: str = ""
    edge: float | None = None               # edge length wanted [m]
    snap: float | None = None               # distance within which lines are joined [m]
    membrane_mass: float | None = None      # [kg]
    mass_source: str = ""                      # where it comes from
    notices: list[str] = field(default_factory=list)


@dataclass
class Trace:
    """A wing in metres in the wing frame. The outline is closed, counter-clockwise, its first point not repeated."""
    title: str
    source: str
    outline: np.ndarray
    outline_where: str
    veins: list[Line]                          # points in metres, `diameters` always set
    joints: list[JointMark]
    root: Line | None                       # None: `root_part`
    root_part: float
    length: float                              # extent in x
    faces_viewer: bool                         # +z points to the viewer of the drawing
    z_side: str = ""
    unit: str = "mm"                           # of lengths in messages, which are 1e3 times those here


def polygon_area(points: np.ndarray) -> float:
    """Returns the area; it is positive if the polygon is counter-clockwise."""
    x, y = points.T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def parse_diameters(text: str) -> DiameterTable | None:
    """Reads diameters. '100 78 24': at equal parts of the length; '0:100 0.45:78 1:24': at these parts. Micrometres; None if it
    is neither."""
    words = re.split(r"[\s,;]+", text.strip())
    try:
        pairs = [tuple(float(v) for v in word.split(":")) for word in words]
    except ValueError:
        return None
    if all(len(pair) == 1 for pair in pairs):
        n = max(1, len(pairs) - 1)
        pairs = [(k / n, pair[0]) for k, pair in enumerate(pairs)]
        pairs = pairs * 2 if len(pairs) == 1 else pairs
        pairs[-1] = (1.0, pairs[-1][1])
    if not all(len(pair) == 2 for pair in pairs):
        return None
    return [(part, 1e-6 * diameter) for part, diameter in pairs]


def diameter_at(table: DiameterTable, part: np.ndarray) -> np.ndarray:
    """Returns diameters [m] at parts of the length."""
    return np.interp(part, [p for p, _ in table], [d for _, d in table])


def _scale_of(sketch: Sketch, problems: Problems) -> float:
    if not sketch.scales:
        problems.error(f"{sketch.source}: no scale: draw a line as long as a known length and call it for instance 'scale "
                       "1 mm', or give --metres-per-unit, or --true-size if the page is as large as the wing")
        return 1e-3                             # for the messages of the checks that follow
    values = [value for value, _ in sketch.scales]
    if max(values) > 1.01 * min(values):
        problems.error(f"{sketch.source}: the scales disagree: " + ", ".join(f"{who} gives {value:.4g} m per unit"
                                                                               for value, who in sketch.scales))
    return float(np.mean(values))


def _one(kind: str, found: list[Line], source: str, advice: str, problems: Problems) -> Line | None:
    if not found:
        problems.error(f"{source}: no {kind}: {advice}")
        return None
    if len(found) > 1:
        problems.error(f"{source}: {len(found)} lines are called {kind} ({'; '.join(item.where for item in found)}): "
                       f"leave one of them, or give the others another name")
    return found[0]


def _frame(sketch: Sketch, outline: Line, root: Line | None, problems: Problems) -> tuple[np.ndarray, np.ndarray, bool]:
    """Returns origin (2,) and rows x, y of the wing frame in the drawing; and whether z = x cross y points to the viewer."""
    if sketch.is_in_frame:
        return np.zeros(2), np.eye(2), True
    if len(sketch.axes) > 1:
        problems.error(f"{sketch.source}: two lines are called axis ({'; '.join(a.where for a in sketch.axes)}): leave one")
    if sketch.axes:
        origin = sketch.axes[0].points[0]
        x = sketch.axes[0].points[-1] - origin
        if not np.any(x):
            problems.error(f"{sketch.axes[0].where}: has no length: draw it from the hinge toward the tip")
            x = np.array([1.0, 0.0])
    else:
        middle = outline.points.mean(0)
        origin = root.points.mean(0) if root is not None else middle
        away = middle - origin
        x = np.array([-1.0 if away[0] < 0 else 1.0, 0.0])
        if abs(away[0]) < abs(away[1]):
            problems.error(f"{sketch.source}: the wing does not lie along the page: turn it so that its tip points to the "
                           "right or to the left, or draw a straight line called 'axis' from the hinge toward the tip")
    x = x / np.linalg.norm(x)
    y = np.array([-x[1], x[0]])
    up = y if sketch.axes else np.array([0.0, 1.0])
    if sketch.leading:
        up = sketch.leading[0] - origin
    elif not sketch.axes:
        sketch.notices.append("the leading edge is taken to be up on the page (a circle called 'leading' says otherwise)")
    elif abs(y[1]) > 0.3:
        up = np.array([0.0, 1.0])
        sketch.notices.append("the leading edge is taken to be up on the page (a circle called 'leading' says otherwise)")
    else:
        problems.error(f"{sketch.source}: the wing points up or down the page: mark the side of its leading edge with a circle "
                       "called 'leading'")
    faces_viewer = bool(up @ y > 0)
    return origin, np.array([x, y if faces_viewer else -y]), faces_viewer


def _check_names(kind: str, items: Sequence, problems: Problems) -> None:
    seen: dict[str, str] = {}
    for item in items:
        if not NAME.fullmatch(item.name):
            problems.error(f"{item.where}: a name of a {kind} has 1 to 64 letters, digits, '_', '+' and '-': rename it")
        elif item.name in seen:
            problems.error(f"{item.where}: another {kind} has this name ({seen[item.name]}): rename one, or join the two "
                           "lines into one")
        seen.setdefault(item.name, item.where)


def _check_diameters(vein: Line, length: float, problems: Problems) -> None:
    table = vein.diameters or []
    parts = [p for p, _ in table]
    if not table:
        problems.error(f"{vein.where}: has no diameter: give the line a stroke, or the table 'diameters'")
        vein.diameters = [(0.0, 1e-3 * length), (1.0, 1e-3 * length)]
    elif parts != sorted(parts) or parts[0] < 0 or parts[-1] > 1:
        problems.error(f"{vein.where}: the parts of its length in 'diameters' must rise from 0 to 1")
    elif not all(np.isfinite(d) and d > 0 for _, d in table):
        problems.error(f"{vein.where}: diameters must be positive")
    else:
        largest = max(d for _, d in table)
        if largest > TOO_THICK * length:
            problems.error(f"{vein.where}: a diameter of {1e6 * largest:.0f} um is {100 * largest / length:.0f} % of the wing's "
                           "length: strokes must be as wide as the veins at the scale of the drawing, tables are in um")
        elif largest > THICK * length:
            problems.notice(f"{vein.where}: a diameter of {1e6 * largest:.0f} um is {100 * largest / length:.0f} % of the "
                            "wing's length; are strokes as wide as the veins?")


def trace_of(sketch: Sketch, problems: Problems) -> Trace | None:
    """Returns the sketch in metres in the wing frame; mistakes are added to `problems`. None if there is no outline."""
    for text in sketch.notices:
        problems.notice(text)
    metres = _scale_of(sketch, problems)
    unit = "mm" if sketch.scales else "units"
    outline = _one("outline", sketch.outlines, sketch.source, "draw the margin of the wing as one closed path and call it "
                   "'outline'", problems)
    root = None
    if sketch.root_part <= 0:
        root = _one("root", sketch.roots, sketch.source, "draw a line along the part of the outline that is held by the body "
                    "and call it 'root'", problems)
    _check_names("vein", sketch.veins, problems)
    _check_names("joint", sketch.joints, problems)
    if outline is not None and not outline.closed:
        gap = float(np.linalg.norm(outline.points[-1] - outline.points[0]))
        problems.error(f"{outline.where}: is open, its ends are {1e3 * gap * metres:.3g} {unit} apart: close the path (in Inkscape: select both end nodes, "
                       "then 'Join selected nodes')")
    if outline is None or len(outline.points) < 3:
        return None
    n_notices = len(sketch.notices)
    origin, axes, faces_viewer = _frame(sketch, outline, root, problems)
    for text in sketch.notices[n_notices:]:
        problems.notice(text)

    def placed(points: np.ndarray) -> np.ndarray:
        return metres * (np.asarray(points, float) - origin) @ axes.T

    line = placed(outline.points)
    if np.allclose(line[0], line[-1], rtol=0, atol=1e-9 * np.ptp(line[:, 0])):
        line = line[:-1]
    line = line if polygon_area(line) > 0 else line[::-1].copy()
    length = float(np.ptp(line[:, 0]))
    if sketch.scales and not SMALLEST_WING < length < LARGEST_WING:
        problems.error(f"{sketch.source}: the wing would be {length:.3g} m long: is the scale right "
                       f"({', '.join(f'{who} gives {value:.4g} m per unit' for value, who in sketch.scales)})?")
    veins = []
    for vein in sketch.veins:
        table = vein.diameters
        if table is None and vein.width:
            table = [(0.0, vein.width * metres), (1.0, vein.width * metres)]
        veins.append(Line(vein.name, placed(vein.points), vein.where, vein.closed, None, table, vein.free_end))
        _check_diameters(veins[-1], length, problems)
    joints = [JointMark(j.name, placed(j.place), j.radius * metres, j.where, j.veins) for j in sketch.joints]
    if root is not None:
        root = Line(root.name, placed(root.points), root.where, root.closed)
    return Trace(sketch.title, sketch.source, line, outline.where, veins, joints, root, sketch.root_part, length, faces_viewer,
                 sketch.z_side, unit)
