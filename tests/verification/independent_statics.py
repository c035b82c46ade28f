#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Two solvers of the bent wing that share no code, flusi --static and the one of tools/make_measurement, find the same
shapes.

usage: independent_statics.py <flusi>
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.bending.model import Model, Stiffness
from flusi_msm.bending.statics import Path as LoadingPath
from flusi_msm.wing.file import read_wing

SOURCE = Path(__file__).resolve().parents[2]
WING = SOURCE / "wings/calliphora_small.h5"
PLACES = [(0.00405, 0.00066, 2.0e-3), (0.00721, -0.00032, 5.5e-4), (0.00496, -0.00228, -2.7e-4)]
# Both end within 1e-8 of the load; soft directions turn that into some 1e-7 of the movement.
AGREE = 1e-6
# The membrane as sums over edges and as Morley's triangles with the same law differ by their errors of discretisation.
# Halving the edges moves the loaded places of this mesh by 2 to 6 % more; the two forms may differ by half of that.
SAME_LAW = 0.03
INI = """[Wing]
file = {wing};
E = {E!r};
D = {D!r};
parameters = {parameters};
cross_springs = {crossed};
[Mass]
membrane_law = uniform;
[Loads]
gravity = 0 0 {gravity!r};
forces = (/ {forces} /);
[Saving]
name = static;
"""


def solver(folder, parameters="", crossed="no", E=12.58e9, D=2e-7, gravity=0.0):
    """Displacements (points, 3) of flusi --static under all loads."""
    forces = "\n".join(" ".join(repr(v) for v in row) for row in PLACES)
    (folder / "run.ini").write_text(INI.format(wing=WING, E=E, D=D, parameters=parameters, crossed=crossed,
                                               gravity=gravity, forces=forces))
    done = subprocess.run([PROGRAM, "--static", "run.ini"], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(done.stdout + done.stderr)
    shapes = []
    for k in range(len(PLACES)):
        with h5py.File(folder / f"static_{k + 1:02d}.h5") as file:
            shapes.append(file["displacement"][:])
    return shapes


def own(gravity=0.0, **stiffness):
    """The same of the generator; the paths must be free of snaps, behind which shapes may differ."""
    model = Model(read_wing(WING), Stiffness(**stiffness))
    shapes = []
    for x, y, force in PLACES:
        weight = model.weights((0, 0, gravity), 1300.0, 3e-3)
        u, report = LoadingPath(model).solve(model.point_load((x, y), (0, 0, force)) + weight)
        assert report.converged and report.snaps == 0
        shapes.append(u[:model.n_points])
    return shapes


def difference(ours, theirs):
    """Largest over all loads of the largest difference at a point, relative to the largest movement."""
    return max(np.abs(a - b).max() / np.abs(b).max() for a, b in zip(ours, theirs))


class IndependentStatics(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.place = Path(self.folder.name)

    def test_usual_wing(self):
        theirs = solver(self.place)
        found = difference(own(plate="edges"), theirs)
        print(f"usual wing: {found:.1e}")
        self.assertLess(found, AGREE)
        found = difference(own(plate="morley"), theirs)
        print(f"membrane as Morley's triangles: {found:.1e}")
        self.assertLess(found, SAME_LAW)

    def test_every_parameter(self):
        theirs = solver(self.place, "joint:C_Sc 1e-6, joint:M1+2_bend 5e-7, joint:R4+5_base 2e-5, root 0.3, E:C 1.7, "
                        "diameter_exponent 3.5, k_vein 8e4, k_membrane 5e4, k_cross 2e4", "yes", E=9e9, D=3e-7,
                        gravity=-200.0)
        ours = own(-200.0, plate="edges", E=9e9, D=3e-7, root=0.3, diameter_exponent=3.5, k_vein=8e4, k_membrane=5e4,
                   k_cross=2e4, cross_springs=True, veins={"C": 1.7},
                   joints={"C_Sc": 1e-6, "M1+2_bend": 5e-7, "R4+5_base": 2e-5})
        found = difference(ours, theirs)
        print(f"every parameter: {found:.1e}")
        self.assertLess(found, AGREE)


if __name__ == "__main__":
    PROGRAM = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()
