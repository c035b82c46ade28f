# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/make_modes and make_series: friction and drag act as they must, and mistakes are explained."""
import json
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from flusi_msm.bending.model import Model, Stiffness
from flusi_msm.errors import InputError
from flusi_msm.measurement import modes, series
from flusi_msm.wing.file import read_wing

WING = str(Path(__file__).resolve().parents[3] / "wings/calliphora_small.h5")
EDGES = Stiffness(plate="edges")


class MakeModes(unittest.TestCase):
    def test_friction_of_a_bent_wing(self):
        """Weak friction of joints damps each mode about a loaded shape by theta phi K_joints phi/(2 omega), with K_joints the part of the
        flat wing's stiffness that is lost without the joints. Other modes contribute with the square of theta."""
        theta = 1e-8
        case = modes.Case(WING, modes=3, medium="vacuum", stiffness=EDGES, loads=[((8.5e-3, -0.8e-3), np.array([0.0, 0.0, 1e-4]))],
                          damping=modes.Damping(joint_friction=theta))
        wing = read_wing(WING)
        found = modes.find_modes(wing, case)
        decays = modes.find_decays(wing, case, None, found)
        mean = float(np.mean(np.concatenate([d for _, d in wing.veins.values()])))
        model = Model(wing, EDGES, mean, 1.0)
        limp = Model(wing, replace(EDGES, joints={h.joint: 0.0 for h in model.hinge_plan if h.joint}), mean, 1.0)
        rest, none = model.zeros(), np.zeros(len(model.springs.k))
        joints = model.tangent(rest, none) - limp.tangent(rest, none)
        k, m, _ = modes.matrices(wing, case, model)
        values, shapes = modes.lowest_modes(k, m, 15)
        for (hertz, _), (frequency, ratio) in zip(found, decays):
            mode = np.argmin(np.abs(values - (2 * np.pi * hertz)**2))
            expected = theta * shapes[:, mode] @ (joints @ shapes[:, mode]) / (2 * 2 * np.pi * hertz)
            self.assertAlmostEqual(frequency / hertz, 1.0, delta=1e-6)
            self.assertAlmostEqual(ratio / expected, 1.0, delta=1e-5)

    def test_clamp(self):
        """A clamp that gives way adds compliance times R R^T to the inverse of the stiffness, R the rotations about x and y. In a
        record, the wing then hangs lower by the rotation of its moment."""
        wing, compliance = read_wing(WING), (4000.0, 10000.0)
        mean = float(np.mean(np.concatenate([d for _, d in wing.veins.values()])))
        stiff = Model(wing, EDGES, mean, 1.0)
        loose = Model(wing, replace(EDGES, root_compliance=compliance), mean, 1.0)
        k = modes.resting_stiffness(stiff)
        arm = (stiff.positions - wing.points[list(wing.root)].mean(0))[stiff.moves]
        r = np.stack([np.cross(axis, arm).ravel() for axis in ([1.0, 0, 0], [0, 1.0, 0])], 1)
        force = np.random.default_rng(1).standard_normal(k.shape[0])
        wanted = np.linalg.solve(k.toarray(), force) + r @ (np.array(compliance[::-1]) * (r.T @ force))
        given = modes.on_clamp(loose, k)
        self.assertLess(np.abs(given @ wanted - force).max(), 1e-6)
        self.assertLess(given.nnz, 1.2 * k.nnz)
        case = series.Case(WING, stiffness=replace(EDGES, root_compliance=compliance))
        self.assertEqual(abs(series.Motion(wing, case).k - given).max(), 0)
        with self.assertRaisesRegex(InputError, "plate=edges"):
            modes.on_clamp(Model(wing, Stiffness(root_compliance=compliance), mean, 1.0), k)

    def test_mistakes(self):
        for change, problem in (({"rayleigh_mass": 1e6}, "does not swing: make the values of damping"),
                                ({"relaxation": 0.1, "relaxation_time": 0.0}, "relaxation_time: must be positive"),
                                ({"drag": 1.0}, "damping.drag: drag with the square of the speed has no damping ratio")):
            with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(InputError, problem):
                path = Path(folder) / "case.json"
                path.write_text(json.dumps({"wing": WING, "modes": 2, "stiffness": {"plate": "edges"}, "damping": change}))
                modes.synthesise(modes.read_case(path))
        few = modes.sparse.identity(30, format="csc")
        with self.assertRaisesRegex(InputError, "use a finer wing"):
            modes.lowest_modes(few, few, modes.DECAYING)


class MakeSeries(unittest.TestCase):
    def test_drag_of_a_tap(self):
        """Just after a tap, a node has lost c a v^2/m of its velocity v per time, from the first step on."""
        case = series.Case(WING, excitation="tap", point=(8.0e-3, -0.6e-3), size=1e-8, places=((8.0e-3, -0.6e-3),), units="m/s", rate=1e10,
                           samples=1, steps=1, medium="air", stiffness=EDGES)
        wing = read_wing(WING)
        calm = series.Motion(wing, case).record()[1]
        dragged = replace(case, damping=series.Damping(drag=50.0))
        motion = series.Motion(wing, dragged)
        push = motion.at(case.point, case.direction)
        v = motion.inertial(case.size * push)[2::3]
        lost = 50.0 * motion.area * np.abs(v) * v
        expected = np.zeros(motion.n)
        expected[2::3] = lost
        change = (calm - motion.record()[1])[1, 0] * case.rate
        self.assertAlmostEqual(change / (push @ motion.inertial(expected)), 1.0, delta=1e-3)

    def test_mistakes(self):
        for change, problem in (({"shake": [1.0, 2.0]}, "shake: needs a size"), ({"lag": -1e-4}, "lag: must not be negative"),
                                ({"damping": {"drag": 1.0}, "medium": "vacuum"}, "damping.drag: there is none in a vacuum"),
                                ({"damping": {"relaxation_time": 0.0}}, "relaxation_time: must be positive")):
            with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(InputError, problem):
                path = Path(folder) / "case.json"
                path.write_text(json.dumps({"wing": WING, "places": [[8e-3, -0.6e-3]], **change}))
                series.read_case(path)


if __name__ == "__main__":
    unittest.main()
