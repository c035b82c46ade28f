# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawings of wings for tests: a wing of 10 x 4 mm with three veins, in pieces that can be exchanged."""
from pathlib import Path

import numpy as np

from flusi_msm.errors import InputError, Problems
from flusi_msm.wing.command import traced_wing
from flusi_msm.wing.svg import read_svg

XMLNS = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" ' \
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
# Ten units are a millimetre. Two veins from the root to the tip and one between them.
PARTS = {
    "outline": '<path id="outline" d="M 0 0 H 100 V 40 H 0 Z"/>',
    "root": '<path id="root" d="M 0 0 V 40"/>',
    "front": '<path id="front" stroke="#000" stroke-width="0.8" d="M 0 10 H 100"/>',
    "rear": '<path id="rear" stroke="#000" stroke-width="0.5" d="M 0 30 H 100"/>',
    "cross": '<path id="cross" stroke="#000" stroke-width="0.4" d="M 60 10 V 30"/>',
    "joint": '<circle id="elbow" cx="30" cy="30" r="1"/>',
    "scale": '<path inkscape:label="scale 2 mm" d="M 5 50 h 20"/>',
}


def svg(head='viewBox="-10 -10 120 80"', **changed):
    """The text of the drawing with parts exchanged, added, or, if they are None, left out."""
    parts = {**PARTS, **changed}
    body = "\n".join(text for text in parts.values() if text is not None)
    return f'<svg {XMLNS} {head}>\n{body}\n</svg>\n'


def write(folder, text, name="wing.svg"):
    path = Path(folder) / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def make(folder, text, edge=0.83e-3, snap=None, mesher="own", metres=None, true_size=False):
    """The wing and the notices of a drawing."""
    problems = Problems()
    sketch = read_svg(write(folder, text), problems, metres, true_size)
    return traced_wing(sketch, problems, edge, snap, mesher), problems.notices


def mistakes(folder, text, **options):
    """The messages with which a drawing is refused."""
    try:
        make(folder, text, **options)
    except InputError as error:
        return str(error)
    return ""


def sound(wing):
    """What is wrong with a mesh; empty if nothing is."""
    edges, count = wing.edges()
    ends = edges[count == 1].ravel()
    mesh = {tuple(e) for e in edges.tolist()}
    faults = {
        "an inverted triangle": (wing.areas() <= 0).any(),
        "an edge of three triangles": count.max() > 2,
        "holes or pieces": len(wing.points) - len(edges) + len(wing.triangles) != 1,
        "a margin that is no closed line": (np.bincount(ends)[np.unique(ends)] != 2).any(),
        "a vein that is not in the mesh": any(tuple(sorted(pair)) not in mesh for nodes, _ in wing.veins.values()
                                            for pair in zip(nodes, nodes[1:])),
    }
    return [text for text, is_so in faults.items() if is_so]


def vein_length(wing, name):
    nodes, _ = wing.veins[name]
    return float(np.linalg.norm(np.diff(wing.points[nodes], axis=0), axis=1).sum())
