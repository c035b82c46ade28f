# SPDX-License-Identifier: GPL-3.0-or-later
"""Wings from drawings: what SVG can say, how lines are joined, what is refused, whether the mesh is one.

usage: pytest test_make_wing.py     WING_READER in the environment: the program test_wings, which reads as the solver does
"""
import builtins
import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from drawings import PARTS, make, mistakes, sound, svg, vein_length, write
from flusi_msm.errors import InputError, Problems
from flusi_msm.wing.command import traced_wing
from flusi_msm.wing.file import WingMass, read_wing, write_wing
from flusi_msm.wing.mesh import load_gmsh
from flusi_msm.wing.picture import draw_wing
from flusi_msm.wing.report import quality_of, report
from flusi_msm.wing.svg import read_svg
from flusi_msm.wing.svg_tree import read_svg_shapes
from flusi_msm.wing.toml_file import read_ini, read_toml
from flusi_msm.wing.trace import parse_diameters
from synthetic import SOURCE, run_tool

MM, UM = 1e-3, 1e-6
DRAWN = ("calliphora", "bee", "fly", "rectangle")


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The wing of drawings.PARTS."""
    return make(tmp_path_factory.mktemp("plain"), svg())[0]


def assert_read(wing, folder):
    """The solver's reader accepts the wing."""
    write_wing(folder / "read.h5", wing)
    if "WING_READER" in os.environ:
        done = subprocess.run([os.environ["WING_READER"], str(folder / "read.h5")], capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr


def same(one, other, tolerance=1e-9):
    """The same lines. What is between them depends on the last digit: squares can be cut in two ways."""
    assert one.veins.keys() == other.veins.keys()
    for name, (nodes, diameters) in one.veins.items():
        np.testing.assert_allclose(one.points[nodes], other.points[other.veins[name][0]], rtol=0, atol=tolerance)
        np.testing.assert_allclose(diameters, other.veins[name][1], rtol=1e-5)
    assert one.joints.keys() == other.joints.keys()
    for name, joint in one.joints.items():
        assert joint[:-1] == other.joints[name][:-1] or len(joint) == 3
        np.testing.assert_allclose(one.points[one.joint_nodes(name)], other.points[other.joint_nodes(name)], rtol=0, atol=tolerance)
    held = (np.sort(wing.points[wing.root], axis=0) for wing in (one, other))
    np.testing.assert_allclose(*held, rtol=0, atol=tolerance)
    for wing in (one, other):
        assert sound(wing) == []
    assert one.areas().sum() == pytest.approx(other.areas().sum(), rel=1e-5)


# ---- the wings that are shipped

def test_drawing_of_the_shipped_wing_remakes_it(tmp_path):
    shipped = read_wing(SOURCE / "wings/calliphora.h5")
    problems = Problems()
    wing = traced_wing(read_svg(str(SOURCE / "wings/calliphora.svg"), problems), problems, 0.183 * MM, mesher="auto")
    assert sound(wing) == []
    assert wing.smallest_angle() > 15
    assert abs(len(wing.points) / len(shipped.points) - 1) < 0.1
    # Margins are polygons in both, cut at other places: the area between them is that of segments of height h^2/(8 R).
    assert wing.areas().sum() == pytest.approx(shipped.areas().sum(), rel=1e-3)
    assert np.ptp(wing.points[:, 0]) == pytest.approx(np.ptp(shipped.points[:, 0]), rel=1e-3)
    assert wing.vein_mass() == pytest.approx(shipped.vein_mass(), rel=1e-3)
    assert wing.veins.keys() == shipped.veins.keys()
    for name in shipped.veins:
        assert vein_length(wing, name) == pytest.approx(vein_length(shipped, name), rel=1e-3), name
        for end in (0, -1):  # the drawing has three digits behind the point: 0.05 um
            np.testing.assert_allclose(wing.points[wing.veins[name][0][end]], shipped.points[shipped.veins[name][0][end]],
                                       atol=0.1 * UM)
            assert wing.veins[name][1][end] == pytest.approx(shipped.veins[name][1][end], rel=1e-9), name
    assert wing.joints.keys() == shipped.joints.keys()
    for name, joint in shipped.joints.items():
        assert len(wing.joints[name]) == len(joint)
        assert len(joint) == 3 or wing.joints[name][0] == joint[0]
        drawn, made = (np.array([w.points[k] for k in w.joint_nodes(name)]) for w in (wing, shipped))
        np.testing.assert_allclose(drawn[1], made[1], atol=0.1 * UM)
        for k in (0, 2):  # the hinge lies between the same segments
            a, b = drawn[k] - drawn[1], made[k] - made[1]
            assert a @ b > 0.99 * np.linalg.norm(a) * np.linalg.norm(b), name
    assert_read(wing, tmp_path)


@pytest.mark.parametrize("name", DRAWN)
def test_drawn_wings_are_sound(name, tmp_path):
    problems = Problems()
    wing = traced_wing(read_svg(str(SOURCE / f"wings/{name}.svg"), problems), problems,
                       edge={"fly": 0.12 * MM}.get(name, 0.5 * MM), mesher="own")
    assert sound(wing) == []
    assert wing.smallest_angle() > 12
    assert_read(wing, tmp_path)


def test_gmsh_makes_the_same_wing(tmp_path, plain):
    pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    wing, _ = make(tmp_path, svg(), mesher="gmsh")
    assert sound(wing) == []
    assert wing.smallest_angle() > 25
    assert wing.areas().sum() == pytest.approx(40 * MM**2, rel=1e-12)
    for name in plain.veins:  # lines are divided before the membrane is filled
        np.testing.assert_allclose(wing.points[wing.veins[name][0]], plain.points[plain.veins[name][0]], atol=1e-12)
    assert_read(wing, tmp_path)


def test_without_gmsh(tmp_path, monkeypatch):
    real = builtins.__import__

    def refuse(error):
        def replaced(name, *rest):
            if name == "gmsh":
                raise error
            return real(name, *rest)
        return replaced
    for error, words in ((ModuleNotFoundError("gmsh"), "requirements-mesh.txt"), (OSError("libGLU.so.1: none"), "libglu1-mesa")):
        monkeypatch.setattr(builtins, "__import__", refuse(error))
        problems = Problems()
        assert load_gmsh(problems) is None
        assert words in problems.notices[0]
        assert sound(make(tmp_path, svg(), mesher="auto")[0]) == []
        assert words in mistakes(tmp_path, svg(), mesher="gmsh")


# ---- numbers

def test_numbers_of_the_plain_wing(plain, tmp_path):
    assert sound(plain) == []
    assert plain.areas().sum() == pytest.approx(40 * MM**2, rel=1e-12)
    np.testing.assert_allclose(np.ptp(plain.points[:, :2], axis=0), (10 * MM, 4 * MM))
    assert plain.points[:, 0].min() == pytest.approx(0, abs=1e-15)  # the hinge is the middle of the root
    assert plain.points[:, 1].max() == pytest.approx(2 * MM)
    assert {name: round(vein_length(plain, name) / MM, 9) for name in plain.veins} == {"front": 10, "rear": 10, "cross": 2}
    assert {name: round(d[0] / UM, 6) for name, (_, d) in plain.veins.items()} == {"front": 80, "rear": 50, "cross": 40}
    assert plain.points[plain.veins["front"][0][0], 1] == pytest.approx(1 * MM)  # above: y is up
    np.testing.assert_allclose(plain.points[plain.joint_nodes("elbow")[1]], (3 * MM, -1 * MM, 0), atol=1e-15)
    assert plain.joints["elbow"][0] == "rear"
    np.testing.assert_allclose(plain.points[plain.root, 0], 0, atol=1e-15)
    for end, name in ((0, "front"), (-1, "rear")):  # T junctions share the point
        assert plain.veins["cross"][0][end] in plain.veins[name][0]
    assert_read(plain, tmp_path)


def test_mass_and_centre(plain, tmp_path):
    weighed = replace(plain, mass=WingMass("uniform", 100e-9, "a balance"))
    quality = quality_of(weighed)
    cylinder = {"front": 10 * 0.08**2, "rear": 10 * 0.05**2, "cross": 2 * 0.04**2}  # length d^2 [mm^3]
    mass = {name: 1300 * np.pi / 4 * v * MM**3 for name, v in cylinder.items()}
    for name, expected in mass.items():
        assert quality.veins[name].mass == pytest.approx(expected, rel=1e-9)
    whole = sum(mass.values()) + 100e-9
    x = (5 * (mass["front"] + mass["rear"] + 100e-9) + 6 * mass["cross"]) / whole
    y = (mass["front"] - mass["rear"]) / whole
    np.testing.assert_allclose(quality.centre, (x * MM, y * MM), rtol=1e-9)
    text = "\n".join(report(weighed, quality))
    assert "uniform membrane, as stated by: a balance" in text
    # 1 + x/10 mm: two thirds of 10 mm more than half of it lies behind the middle.
    bare = replace(plain, veins={}, joints={}, mass=WingMass("bilinear", 100e-9, "a balance", (1.0, 100.0, 0.0), 1200.0))
    np.testing.assert_allclose(quality_of(bare).centre, ((1 / 2 + 1 / 3) / (3 / 2) * 10 * MM, 0), rtol=1e-9, atol=1e-12)
    for wing in (weighed, bare):
        write_wing(tmp_path / "mass.h5", wing)
        assert read_wing(tmp_path / "mass.h5").mass == wing.mass
    assert_read(weighed, tmp_path)
    assert f"veins of 1300 kg/m^3: {1e9 * sum(mass.values()):.4g} ug, membrane 100 ug (2.5 g/m^2)" in text
    assert "of which veins" in text and "front" in text
    assert "--membrane-mass" in "\n".join(report(plain, quality_of(plain)))


def test_masses_in_other_units_are_named(tmp_path):
    """81 ug typed in mg or kg, and a mass without a source; what is right is not doubted."""
    def told(*options):
        done = subprocess.run([sys.executable, SOURCE / "tools/make_wing", SOURCE / "wings/rectangle.svg", "-o", tmp_path / "w.h5", "--edge", "0.7",
                               "--mesher", "own", "--no-picture", *options], check=True, stdout=subprocess.PIPE, text=True)
        return [line for line in done.stdout.splitlines() if "mass" in line and line.startswith("notice")]
    assert told("--membrane-mass", "50", "--mass-source", "a balance") == []
    assert "--mass-source TEXT" in told("--membrane-mass", "50")[0]
    for typed, words in (("0.05", "is too small for membranes of insects"), ("5e4", "is too large for membranes of insects")):
        (line,) = told("--membrane-mass", typed, "--mass-source", "a balance")
        assert words in line and "would be usual" in line, line
    from flusi_msm.magnitude import YOUNG, magnitude_doubt
    assert magnitude_doubt(12.58, YOUNG, "Pa", "veins") == \
        "12.58 Pa is too small for veins, which have 1e+07 to 1e+11 Pa; if the value is in GPa, write 1.258e+10"
    assert magnitude_doubt(1e22, YOUNG, "Pa", "veins").endswith("Pa") and magnitude_doubt(9e9, YOUNG, "Pa", "veins") == ""


def test_mass_of_a_cone(tmp_path):
    """A vein that tapers from 80 um to 20 um: d^2 averaged over its length is (a^2 + a b + b^2)/3, its centre is nearer to
    the thick end."""
    table = PARTS["front"].replace("/>", "><desc>diameters 80 20</desc></path>")
    wing, _ = make(tmp_path, svg(front=table, cross=None, rear=None, joint=None))
    quality = quality_of(wing)
    assert quality.vein_mass == pytest.approx(1300 * np.pi / 12 * 10e-3 * (80**2 + 80 * 20 + 20**2) * UM**2, rel=1e-9)
    part = (80**2 + 2 * 80 * 20 + 3 * 20**2) / (4 * (80**2 + 80 * 20 + 20**2))
    np.testing.assert_allclose(quality.centre, (10e-3 * part, 1e-3), rtol=1e-9)


def test_diameters():
    assert parse_diameters("100 60 20") == [(0.0, 100 * UM), (0.5, 60 * UM), (1.0, 20 * UM)]
    assert parse_diameters("0:100, 0.3:60; 1:20") == [(0.0, 100 * UM), (0.3, 60 * UM), (1.0, 20 * UM)]
    assert parse_diameters("40") == [(0.0, 40 * UM), (1.0, 40 * UM)]
    for text in ("thick", "1:2:3", "0:1 2"):
        assert parse_diameters(text) is None


# ---- what SVG can say

@pytest.mark.parametrize("changed", [
    {"outline": '<rect id="outline" width="100" height="40"/>', "front": '<line id="front" stroke="#000" '
     'stroke-width="0.8" x1="0" y1="10" x2="100" y2="10"/>', "root": '<polyline id="root" points="0,0 0 40"/>'},
    {"outline": '<polygon id="outline" points="0,0 100,0 100,40 0,40"/>'},
    {"outline": '<path id="outline" d="m 0,0 100,0 0,40 h -100 v -40"/>'},      # closed without Z
    {"outline": '<path id="outline" d="M0 0L100 0 100 40 0 40z"/>'},
    {"front": '<g inkscape:label="veins"><path stroke="#000" style="stroke-width:0.8px" id="path7" '
     'inkscape:label="front" d="M 0 10 H 100"/></g>'},
    {"front": '<g inkscape:label="front" stroke="#000" stroke-width="0.8"><path id="path7" d="M 0 10 H 100"/></g>'},
    {"front": '<style>.thick{stroke:#000;stroke-width:.8}</style><path class="thick" id="front" d="M 0 10 H 100"/>'},
    {"front": '<path inkscape:label="vein front" data-diameters="80" d="M 0 10 H 100"/>'},
    {"front": '<path id="front" stroke="#000" stroke-width="0.4" transform="matrix(2 0 0 2 -4 6)" d="M 2 2 H 52"/>'},
    {"front": '<g transform="translate(100 20) rotate(180)"><path id="front" stroke="#000" stroke-width="0.08" '
     'transform="translate(100,10) rotate(90) scale(10)" d="M 0 0 V 10"/></g>'},
    {"front": '<path id="front" stroke="#000" stroke-width="0.8" d="M 0 10 C 20 10 30 10 50 10 S 90 10 100 10"/>'},
    {"front": '<path id="front" stroke="#000" stroke-width="0.8" d="M 0 10 Q 20 10 50 10 T 100 10"/>'},
    {"joint": '<g inkscape:label="joints"><rect id="elbow" x="29" y="29" width="2" height="2"/></g>'},
    {"joint": '<defs><circle id="mark" r="1"/></defs><use inkscape:label="joint elbow" xlink:href="#mark" x="30" y="30"/>'},
    {"joint": '<defs><circle id="mark" r="1"/><use id="use1" xlink:href="#mark"/></defs>'
     '<use inkscape:label="joint elbow" xlink:href="#use1" x="30" y="30"/>'},
    {"joint": '<ellipse inkscape:label="elbow @ rear" cx="30" cy="30" rx="1" ry="2"/>'},
    {"scale": '<g inkscape:label="scale 0,2 cm"><rect x="5" y="50" width="20" height="1"/></g>'},
    {"scale": '<line id="scale_2000_um" x1="5" y1="50" x2="5" y2="70"/>'},
    {"photo": '<image xlink:href="wing.jpg" width="120" height="80"/><text>a note</text>'
     '<g style="display:none"><path d="M 0 0 H 3"/></g><g inkscape:label="notes"><path d="M 0 0 H 3"/></g>'},
])
def test_many_ways_to_draw_the_same(plain, tmp_path, changed):
    wing, notices = make(tmp_path, svg(**changed))
    same(wing, plain)
    if "photo" in changed:
        assert any("left out: 1 hidden item, 1 image, 1 text, 1 shape in layers to ignore" in text for text in notices)


@pytest.mark.parametrize("head, options", [
    ('viewBox="0 0 240 160" width="300mm" height="200mm"', {}),
    ('width="500" height="300" viewBox="-10 -10 120 80"', {}),                      # room at the sides
    ('viewBox="-10 -10 120 80"', {"metres": 1e-4}),
    ('viewBox="-10 -10 120 80" width="999px"', {"metres": 1e-4}),
    ('viewBox="-10 -10 120 80" width="12mm" height="8mm"', {"true_size": True}),
    ('viewBox="-10 -10 120 80" width="12mm" height="9mm"', {"true_size": True}),    # the wing is as large as the narrower side allows
])
def test_pages_and_scales(plain, tmp_path, head, options):
    wing, _ = make(tmp_path, svg(head, scale=None if options else PARTS["scale"]), **options)
    same(wing, plain, tolerance=2e-6 * 10 * MM)  # svgelements has six digits for the pixels of a millimetre


def test_curves_are_followed(tmp_path):
    """Arcs and Bezier curves against their equations."""
    text = svg(outline='<path id="outline" d="M 0 20 A 50 20 0 0 1 100 20 A 50 20 0 1 1 0 20"/>',
               root='<circle id="root" cx="0" cy="20" r="5"/>', joint=None, cross=None, rear=None,
               front='<path id="front" stroke="#000" d="M 0 20 c 20 -30 40 30 60 0 s 20 5 40 0"/>')
    drawing = read_svg_shapes(write(tmp_path, text))
    shapes = {shape.label: shape.subpaths[0].flatten(1e-3) - (10, 10) for shape in drawing.shapes}
    ellipse = shapes["outline"] - (50, 20)
    on_it = np.hypot(ellipse[:, 0] / 50, ellipse[:, 1] / 20)
    np.testing.assert_allclose(on_it, 1, atol=1e-3)  # svgelements draws arcs by cubics
    t = np.linspace(0, 1, 2001)[:, None]
    exact = [np.array(p, float) for p in ((0, 20), (20, -10), (40, 50), (60, 20))]
    for controls in (exact, [np.array(p, float) for p in ((60, 20), (80, -10), (80, 25), (100, 20))]):
        a, b, c, d = controls
        curve = (1 - t)**3 * a + 3 * t * (1 - t)**2 * b + 3 * t**2 * (1 - t) * c + t**3 * d
        inside = (shapes["front"][:, 0] >= a[0] - 1e-9) & (shapes["front"][:, 0] <= d[0] + 1e-9)
        gap = np.linalg.norm(shapes["front"][inside][:, None] - curve, axis=2).min(1)
        assert gap.max() < 0.05  # points on the curve, between the samples of `curve`
    wing, _ = make(tmp_path, text, edge=0.3 * MM)
    assert sound(wing) == []
    # A polygon of edges h in a curve of radius R lacks the part h^2/(6 R^2); R of the ellipse is 0.8 mm at its ends.
    assert wing.areas().sum() == pytest.approx(np.pi * 5 * 2 * MM**2, rel=0.01)


def test_turned_and_mirrored_pages(plain, tmp_path):
    """The wing frame follows the axis and the leading edge, whichever way the page lies."""
    marks = {"axis": '<path id="axis" d="M 0 20 H 100"/>', "leading": '<circle id="leading" cx="50" cy="-5" r="1"/>'}
    for transform, words in (("rotate(150)", "points to"), ("rotate(-80) scale(-1 1)", "points away from"),
                             ("scale(1 -1)", "points away from")):
        group = {"outline": f'<g transform="{transform}">' + PARTS["outline"], "end": "</g>"}
        wing, notices = make(tmp_path, svg(**{"outline": group["outline"], **marks, "end": group["end"]}))
        same(wing, plain)
        assert any(f"+z of the wing {words} who looks" in text for text in notices)
    # Without marks the tip is away from the root, and the leading edge is up.
    wing, notices = make(tmp_path, svg(outline='<g transform="scale(-1 1)">' + PARTS["outline"], end="</g>"))
    same(wing, plain)
    assert any("leading edge is taken to be up" in text for text in notices)


# ---- how lines are joined

def test_loose_ends_are_joined(plain, tmp_path):
    """Ends up to the snapping distance of 0.1 mm short of their goal, or beyond it."""
    for off in (-0.9, 0.9):
        wing, _ = make(tmp_path, svg(front=PARTS["front"].replace("M 0 10 H 100", f"M {-off} 10 H {100 + off}"),
                                     cross=PARTS["cross"].replace("M 60 10 V 30", f"M 60 {10 - off} V {30 + off}")))
        same(wing, plain)
    for off in (-1.3, 1.3):
        text = mistakes(tmp_path, svg(cross=PARTS["cross"].replace("M 60 10", f"M 60 {10 - off}"),
                                      front=PARTS["front"].replace("H 100", f"H {100 + off}")))
        word = "leaves the wing by 0.13 mm" if off > 0 else "ends in the air at (9.87, 1) mm, 0.13 mm from the outline"
        assert f"vein 'front': {word}" in text, text
        if off < 0:
            assert "vein 'cross': ends in the air at (6, 0.87) mm, 0.13 mm from vein 'front'" in text
    same(make(tmp_path, svg(cross=PARTS["cross"].replace("M 60 10", "M 60 11.3")), snap=0.14 * MM)[0], plain)


def test_overshoot_at_a_small_angle(tmp_path):
    """A vein that crosses its goal and goes on for 0.17 mm beside it, 0.07 mm away: it ends where it crosses."""
    wing, _ = make(tmp_path, svg(cross='<path id="cross" stroke="#000" d="M 20 30 L 50 16 L 64.7 9.3"/>'))
    assert sound(wing) == []
    x = 50 + 14.7 * (16 - 10) / (16 - 9.3)
    np.testing.assert_allclose(wing.points[wing.veins["cross"][0][-1]], (x / 10 * MM, 1 * MM, 0), atol=1e-9)


def test_ends_that_meet(tmp_path):
    """A vein in two pieces whose ends are 0.05 mm apart: one point, and the joint there is the hinge between them."""
    wing, _ = make(tmp_path, svg(front='<g stroke="#000"><path id="a" d="M 0 10 L 50 10"/><path id="b" d="M 100 10 L '
                                 '50.5 10"/></g>', joint='<circle id="elbow" cx="50" cy="10" r="1"/>'))
    assert wing.veins["a"][0][-1] == wing.veins["b"][0][-1]
    assert wing.joints["elbow"] == (wing.veins["a"][0][-2], wing.veins["a"][0][-1], wing.veins["b"][0][-2])
    assert_read(wing, tmp_path)


def test_lines_that_cross(tmp_path):
    wing, notices = make(tmp_path, svg(cross=PARTS["cross"].replace("M 60 10 V 30", "M 60 0 V 40")))
    assert any("veins 'front' and 'cross' cross at (6, 1) mm" in text for text in notices)
    for name in ("front", "rear"):
        assert len(set(wing.veins["cross"][0]) & set(wing.veins[name][0])) == 1
    assert_read(wing, tmp_path)


def test_vein_along_the_margin(tmp_path):
    """A vein that is traced 0.05 mm inside the margin is the margin; where it turns inward it leaves it."""
    wing, _ = make(tmp_path, svg(cross=None, front='<path id="front" stroke="#000" d="M 0 0.5 L 100 0.5 L 100 15 L 70 30"/>'))
    nodes = wing.veins["front"][0]
    edges, count = wing.edges()
    margin = {tuple(e) for e in edges[count == 1].tolist()}
    on_it = [tuple(sorted(pair)) in margin for pair in zip(nodes, nodes[1:])]
    assert on_it == sorted(on_it, reverse=True)                      # along the margin, then inside
    corner = wing.points[nodes[on_it.index(False)]]
    np.testing.assert_allclose(corner, (10 * MM, 0.5 * MM, 0), atol=0.02 * MM)
    np.testing.assert_allclose(wing.points[nodes[0]], (0, 2 * MM, 0), atol=1e-9)
    assert vein_length(wing, "front") == pytest.approx((10 + 1.5 + np.hypot(3, 1.5)) * MM, rel=0.01)
    assert_read(wing, tmp_path)


def test_lines_that_the_mesh_would_cross(tmp_path):
    """A bow around the end of a vein: with long edges its chord passes through the vein, with short ones it does not."""
    text = svg(front='<path id="front" stroke="#000" stroke-width="0.1" d="M 0 20 C 27 20 31 20 35 16 S 37 12 41 12 S 45 12 47 16 '
               'S 55 20 100 20"/>', rear=None, joint=None,
               cross='<path id="cross" stroke="#000" stroke-width="0.1" d="M 41 13 V 40"/>')

    def made(edge):
        problems = Problems()
        sketch = read_svg(write(tmp_path, text), problems)
        sketch.veins[1].free_end = True
        return traced_wing(sketch, problems, edge, 0.02 * MM, "own")
    with pytest.raises(InputError) as stop:
        made(5 * MM)
    assert "veins 'cross' and 'front' would cross in the mesh near (" in str(stop.value)
    assert "choose --edge smaller" in str(stop.value)
    assert sound(made(0.5 * MM)) == []


def test_free_end(tmp_path):
    short = svg(front=PARTS["front"].replace("H 100", "H 80"))
    assert "ends in the air" in mistakes(tmp_path, short)
    path = write(tmp_path, short)
    problems = Problems()
    sketch = read_svg(path, problems)
    sketch.veins[0].free_end = True
    wing = traced_wing(sketch, problems, 0.83 * MM, mesher="own")
    assert vein_length(wing, "front") == pytest.approx(8 * MM)
    assert_read(wing, tmp_path)


def test_hinges(tmp_path):
    """Where veins meet the label says which hinge is meant."""
    def joint(text):
        return svg(joint=f'<circle inkscape:label="{text}" cx="60" cy="10.5" r="1"/>')
    assert "lies where the veins front, cross meet" in mistakes(tmp_path, joint("knee"))
    wing, _ = make(tmp_path, joint("knee @ front"))
    at = wing.veins["cross"][0][0]
    assert wing.joints["knee"] == ("front", at)
    wing, _ = make(tmp_path, joint("knee @ front &gt; cross"))
    nodes = wing.veins["front"][0]
    assert wing.joints["knee"] == (nodes[nodes.index(at) - 1], at, wing.veins["cross"][0][1])
    assert "lies at the end of vein 'cross'" in mistakes(tmp_path, joint("knee @ cross"))
    assert "vein 'rear' does not pass there" in mistakes(tmp_path, joint("knee @ front &gt; rear"))
    assert "names vein 'fore', which is not drawn" in mistakes(tmp_path, joint("knee @ fore"))


# ---- what is refused

@pytest.mark.parametrize("changed, words", [
    ({"outline": '<path id="outline" d="M 0 0 H 100 V 40 H 0 V 2"/>'}, ":2: outline 'outline': is open, its ends are 0.2 mm apart: close"),
    ({"outline": None}, "no outline: draw the margin"),
    ({"second": '<rect id="outline" width="9" height="9"/>'}, "2 lines are called outline"),
    ({"outline": '<path id="outline" d="M 0 0 H 100 L 0 40 H 100 Z"/>'}, "the outline crosses itself at (5, 0) mm"),
    ({"root": None}, "no root: draw a line along the part of the outline that is held"),
    ({"second": '<path id="root" d="M 100 0 V 40"/>'}, "2 lines are called root"),
    ({"root": '<path id="root" d="M 5 0 V 40"/>'}, "root 'root': is 0.5 mm off the outline"),
    ({"root": '<path id="root" d="M 0 20 V 20.5"/>'}, "root 'root': holds only 0.05 mm of the outline"),
    ({"scale": None}, "no scale: draw a line as long as a known length"),
    ({"scale": '<path id="scale" d="M 5 50 h 20"/>'}, "scale bar 'scale': does not say how long it is"),
    ({"second": '<path id="scale-1-mm" d="M 5 60 h 20"/>'}, "the scales disagree"),
    ({"scale": '<path inkscape:label="scale 2 m" d="M 5 50 h 20"/>'}, "the wing would be 10 m long: is the scale right"),
    ({"front": '<path id="front" stroke="#000" d="M 0 10 H 108"/>'}, "vein 'front': leaves the wing by 0.8 mm at (10.8, 1) mm"),
    ({"front": '<path id="front" stroke="#000" d="M 0 10 H 70"/>'}, "vein 'front': ends in the air at (7, 1) mm, 1 mm from the outline: "
     "draw it to there, or allow it with --free-end front"),
    ({"front": '<path id="front" stroke="#000" d="M 0 10 H 45 L 50 -0.5 L 55 10 H 100"/>'}, "vein 'front': touches the outline"),
    ({"front": '<path id="front" d="M 0 10 H 100"/>'}, "vein 'front': has no diameter"),
    ({"front": PARTS["front"].replace("0.8", "40")}, "vein 'front': a diameter of 4000 um is 40 % of the wing's length"),
    ({"front": PARTS["front"].replace("/>", "><desc>diameters 1:2:3</desc></path>")}, "its diameters '1:2:3' are not a table"),
    ({"front": PARTS["front"].replace("/>", "><desc>diameters 0.5:20 0.1:9</desc></path>")}, "must rise from 0 to 1"),
    ({"front": PARTS["front"].replace("H 100", "H 100 M 0 12 H 3")}, "vein 'front': has 2 pieces"),
    ({"front": '<path id="front" stroke="#000" d="M 10 5 H 20 V 15 H 10"/>', "cross": None, "rear": None, "joint": None},
     "vein 'front': ends in the air"),
    ({"front": '<path id="front" stroke="#000" d="M 0 10 H 50 V 20 H 40 V 5 H 100"/>'}, "vein 'front': crosses itself at (4, 1) mm"),
    ({"front": '<path id="front" stroke="#000" d="M 10 10 H 50 V 20 Z"/>'}, "closed shape 'front': is no outline"),
    ({"front": '<g inkscape:label="veins"><path id="front" stroke="#000" d="M 10 10 H 50 V 20 Z"/></g>'}, "vein 'front': is closed"),
    ({"twin": PARTS["front"].replace("M 0 10", "M 0 10.1").replace('id="front"', 'id="twin"')},
     "vein 'front': runs along vein 'twin' from (0, 1) mm to (10, 1) mm"),
    ({"second": PARTS["front"].replace("10 H", "18 H")}, "another vein has this name"),
    ({"front": '<path stroke="#000" d="M 0 10 H 100"/>'}, ":4: line <path>: has no name"),
    ({"front": PARTS["front"].replace('id="front"', 'id="Ä"')}, "a name of a vein has 1 to 64 letters"),
    ({"joint": '<circle id="elbow" cx="30" cy="27" r="1"/>'}, "joint 'elbow': is off its vein, 0.3 mm from vein 'rear'"),
    ({"joint": '<circle cx="30" cy="30" r="1"/>'}, "joint <circle>: has no name"),
    ({"joint": '<circle id="elbow" cx="0" cy="30" r="1"/>'}, "lies at the end of vein 'rear', where there is nothing to bend"),
    ({"thing": '<rect id="thing" width="9" height="9"/>'}, "closed shape 'thing': is no outline"),
    ({"axis": '<path id="axis" d="M 0 0 V 9"/>'}, "mark the side of its leading edge"),
    ({"front": PARTS["front"].replace("H 100", "C 3 4")}, "its path data cannot be understood"),
])
def test_mistakes_are_named(tmp_path, changed, words):
    text = mistakes(tmp_path, svg(**changed))
    assert words in text and str(tmp_path) in text, text


def test_all_mistakes_at_once(tmp_path):
    text = mistakes(tmp_path, svg(
        outline='<path id="outline" d="M 0 0 H 100 V 40 H 0 V 2"/>', root=None, scale=None,
        front='<path id="front" stroke="#000" d="M 0 10 H 108"/>', rear='<path id="rear" stroke="#000" d="M 0 30 H 70"/>',
        joint='<circle id="elbow" cx="30" cy="27" r="1"/>'))
    lines = text.split("\n")
    assert len(lines) == 6, text
    for words in ("is open, its ends are 2 units apart", "no root", "no scale", "leaves the wing by 8 units", "vein 'rear': ends in the air at",
                  "'elbow': is off its vein, 3 units"):
        assert sum(words in line for line in lines) == 1, (words, text)


def test_files_that_are_none(tmp_path):
    for name, content, words in (("a.svg", "no XML", "a.svg:1: not a readable SVG file"), ("b.svg", "<html/>", "outermost element"),
                                 ("c.svg", svg(front='<path id="front" transform="matrix(1 2)" d="M 0 0 H 1"/>'), "transform"),
                                 ("d.svg", svg(front='<use href="#nothing"/>'), "is a clone of '#nothing'"),
                                 ("e.svg", svg('viewBox="0 0 10"'), "viewBox = '0 0 10' are not four numbers"),
                                 ("f.png", "", "is no .svg, .toml or .ini file"), ("g.toml", "a = ", "not a readable TOML file")):
        path = write(tmp_path, content, name)
        done = run_tool("make_wing", path)
        assert (done.returncode, done.stdout) == (2, ""), name
        assert words in done.stderr, done.stderr
        assert done.stderr.startswith("make_wing: ")
    done = run_tool("make_wing", tmp_path / "none.svg")
    assert done.returncode == 2 and "cannot be read" in done.stderr
    done = run_tool("make_wing", "moth")
    assert done.returncode == 2 and "no built-in wing of this name" in done.stderr


# ---- tables and Fourier outlines

TOML = """title = "the same in a table"
unit = "mm"
edge_mm = 0.83
membrane_mass_ug = 90
mass_source = "a balance"
z_side = "right dorsal"
[outline]
shape = "polygon"
points = [[0, 2], [10, 2], [10, -2], [0, -2]]
[root]
points = [[0, 2], [0, -2]]
[veins.front]
points = [[0, 1], [10, 1]]
diameters_um = 80
[veins.rear]
points = [[0, -1], [10, -1]]
diameters_um = [[0, 50], [1, 50]]
[veins.cross]
points = [[6, 1], [6, -1]]
diameters_um = [40, 40, 40]
[joints.elbow]
at = [3, -1]
"""


def test_table(plain, tmp_path):
    problems = Problems()
    sketch = read_toml(write(tmp_path, TOML, "wing.toml"), problems)
    wing = traced_wing(sketch, problems, mesher="own")
    same(wing, plain)
    assert (wing.z_side, wing.title) == ("right dorsal", "the same in a table")
    assert (wing.mass.law, wing.mass.source) == ("uniform", "a balance") and wing.mass.membrane == pytest.approx(90e-9)


def test_table_beside_a_drawing(plain, tmp_path):
    write(tmp_path, svg(front=PARTS["front"].replace("0.8", "0.1"), joint='<circle id="elbow" cx="60" cy="30" r="1"/>'))
    text = 'drawing = "wing.svg"\nedge_mm = 0.83\n[veins.front]\ndiameters_um = 80\n[joints.elbow]\nveins = ["rear", "cross"]\n'
    problems = Problems()
    wing = traced_wing(read_toml(write(tmp_path, text, "wing.toml"), problems), problems, mesher="own")
    assert wing.veins["front"][1][0] == pytest.approx(80 * UM)
    assert len(wing.joints["elbow"]) == 3
    assert vein_length(wing, "front") == pytest.approx(vein_length(plain, "front"))


@pytest.mark.parametrize("old, new, words", [
    ("diameters_um = 80", "diameter_um = 80", "veins.front: unknown key 'diameter_um'; did you mean 'diameters_um'?"),
    ("diameters_um = 80", 'diameters_um = "thick"', "veins.front: diameters_um must be a number"),
    ('unit = "mm"', "", "no scale: give unit"),
    ('unit = "mm"', 'unit = "inch"', "unit = 'inch' must be one of m, cm, mm, um"),
    ("edge_mm = 0.83", "edge_mm = -1", "edge_mm = -1 must be a positive number"),
    ("[[0, 1], [10, 1]]", "[[0, 1]]", "veins.front: points must be a list of 2 or more pairs"),
    ("[[0, 1], [10, 1]]", "[[0, 1], [0, 1]]", "two neighbours are the same point"),
    ("[root]", "[roots]", "unknown key 'roots'; did you mean 'root'?"),
    ('"right dorsal"', '"up"', "z_side = 'up' must be one of"),
    ('shape = "polygon"', 'shape = "round"', "shape = 'round' must be 'curve' or 'polygon'"),
    ("at = [3, -1]", "", "joints.elbow: is not drawn: give its place 'at'"),
])
def test_mistakes_in_tables(tmp_path, old, new, words):
    assert old in TOML
    with pytest.raises(InputError) as stop:
        problems = Problems()
        traced_wing(read_toml(write(tmp_path, TOML.replace(old, new), "wing.toml"), problems), problems, mesher="own")
    assert words in str(stop.value), stop.value


FOURIER = "[Wing]\ntype=fourier;\na0_wings=0.6; twice the mean\nai_wings=(/0.05\n 0.0/);\nbi_wings=0.0 0.02;\nx0w=-0.1; y0w=0.7;\n" \
          .replace("x0w=-0.1; y0w", "x0w=-0.1;\ny0w")


def test_fourier_outline(tmp_path):
    """R = 0.3 + 0.05 cos(theta) + 0.02 sin(2 theta): its area is pi (0.3^2 + (0.05^2 + 0.02^2)/2) wing lengths squared."""
    problems = Problems()
    sketch = read_ini(write(tmp_path, FOURIER, "wing.ini"), problems, 5 * MM, 0.05)
    points = sketch.outlines[0].points
    assert points[:, 1].max() == pytest.approx(-0.1 + 0.25, abs=0.02)   # cos(pi): the leading edge is nearer to the centre
    assert points[:, 1].min() == pytest.approx(-0.1 - 0.35, abs=0.02)
    scale = 5 * MM / points[:, 0].max()
    wing = traced_wing(sketch, problems, 0.15 * MM, mesher="own")
    assert sound(wing) == []
    exact = np.pi * (0.3**2 + (0.05**2 + 0.02**2) / 2) * scale**2
    assert wing.areas().sum() == pytest.approx(exact, rel=2e-3)          # h^2/(6 R^2) = 1e-3
    assert wing.points[:, 0].max() == pytest.approx(5 * MM, rel=1e-3)
    assert wing.points[wing.root, 0].max() <= wing.points[:, 0].min() + 0.06 * np.ptp(wing.points[:, 0])
    assert_read(wing, tmp_path)
    text = FOURIER + "length = 5\n"
    toml = 'unit = "mm"\nedge_mm = 0.2\n[outline]\nfourier = "wing.ini"\nlength = 5\n[root]\npart = 0.05\n' \
           '[veins.C]\npoints = [[2.8, -0.5], [4.5, -0.6]]\ndiameters_um = 30\nfree_end = true\n'
    write(tmp_path, text, "wing.ini")
    problems = Problems()
    veined = traced_wing(read_toml(write(tmp_path, toml, "wing.toml"), problems), problems, mesher="own")
    assert veined.areas().sum() == pytest.approx(exact, rel=5e-3)
    assert list(veined.veins) == ["C"]


@pytest.mark.parametrize("text, words", [
    ("[Wings]\na=1\n", "has no section [Wing]"),
    ("[Wing]\ntype=linear\n", "type = linear: only fourier"),
    ("[Wing]\ntype=fourier\nai_wings=0.1 x\nbi_wings=1\n", "a0_wings: is missing\n"),
    ("[Wing]\na0_wings=1\nx0w=0\ny0w=0\nai_wings=0.1\nbi_wings=0 0\n", "bi_wings: has 2 numbers, ai_wings has 1"),
    ("[Wing]\na0_wings=0.1\nx0w=0\ny0w=0\nai_wings=0.1\nbi_wings=0\n", "R(theta) of the outline is not positive"),
])
def test_mistakes_in_fourier_outlines(tmp_path, text, words):
    with pytest.raises(InputError) as stop:
        read_ini(write(tmp_path, text, "wing.ini"), Problems(), 5 * MM, 0.05)
    assert words in str(stop.value)


# ---- the command

def test_command(tmp_path):
    path = write(tmp_path, svg())
    done = run_tool("make_wing", path, "-o", tmp_path / "made.h5", "--edge", "0.83", "--mesher", "own", "--membrane-mass", "100",
                    "--z-side", "right dorsal")
    assert done.returncode == 0, done.stderr
    assert "membrane 100 ug" in done.stdout and f"written   {tmp_path / 'made.h5'}" in done.stdout
    assert read_wing(tmp_path / "made.h5").z_side == "right dorsal"
    assert (tmp_path / "made.png").stat().st_size > 20000
    for words, message in ((("--edge", "80"), "--edge 80: is in mm and must lie between"), (("--free-end", "x"), "there is no such vein"),
                           (("--edge", "0.011"), "choose --edge larger"), (("--true-size",), "has no true size")):
        done = run_tool("make_wing", path, "-o", tmp_path / "other.h5", *words)
        assert done.returncode == 2 and message in done.stderr, done.stderr
        assert not (tmp_path / "other.h5").exists()


def test_picture_names_everything(plain):
    import matplotlib
    matplotlib.use("Agg")
    figure = draw_wing(plain, quality_of(replace(plain, mass=WingMass("uniform", 100e-9, "a balance"))))
    words = [text.get_text() for text in figure.axes[0].texts] + [text.get_text() for text in figure.texts]
    for word in ("front", "rear", "cross", "centre of mass", "root", "2 mm", " 1  elbow"):
        assert word in words, words
    matplotlib.pyplot.close(figure)


def test_package_lists_its_modules():
    """What pip installs is all there is, and the command of the package exists."""
    text = (SOURCE / "tools/pyproject.toml").read_text(encoding="utf-8")
    folders = {".".join(path.parent.relative_to(SOURCE / "tools").parts) for path in (SOURCE / "tools/flusi_msm").rglob("*.py")}
    listed = text.split("packages = [")[1].split("]")[0]
    assert {word.strip().strip('"') for word in listed.split(",")} == folders
    assert 'flusi-make-wing = "flusi_msm.wing.command:command"' in text
    done = subprocess.run([sys.executable, "-B", "-m", "flusi_msm.wing.command", "--help"], capture_output=True, text=True,
                          cwd=SOURCE / "tools")
    assert done.returncode == 0 and "DRAWING.svg" in done.stdout, done.stderr


def test_examples_of_the_document(tmp_path, monkeypatch):
    """The table and the Python of docs/guide/make-wing.md do what they say, and the options that it names exist."""
    text = (SOURCE / "docs/guide/make-wing.md").read_text(encoding="utf-8")
    problems = Problems()
    table = text.split("```toml\n")[1].split("```")[0]
    wing = traced_wing(read_toml(write(tmp_path, table, "wing.toml"), problems), problems, mesher="own")
    assert sound(wing) == [] and sorted(wing.veins) == ["C", "M"] and wing.joints["C_break"][0] == "C"
    assert_read(wing, tmp_path)
    code = text.split("```python\n")[1].split("```")[0].replace("wings/bee.svg", str(SOURCE / "wings/bee.svg"))
    monkeypatch.chdir(tmp_path)
    exec(code, {})  # the document of this project
    assert len(read_wing(tmp_path / "bee.h5").veins) == 13
    told = run_tool("make_wing", "--help").stdout
    for option in set(re.findall(r"--[a-z][a-z-]+", text)):
        assert option in told, option
