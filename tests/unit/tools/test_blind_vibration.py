# SPDX-License-Identifier: GPL-3.0-or-later
"""Blind cases of vibration and of bending with modes: what they hide is as visible as they say, and a case does not depend on what
was made before it."""
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.blind import vibration, vibration_effects
from flusi_msm.blind import vibration_subject as subjects
from flusi_msm.blind.archive import Archive, ArchivedStudy
from flusi_msm.blind.cases import CLOSE
from flusi_msm.blind.strata import Stratum
from flusi_msm.measurement.case import Case
from flusi_msm.bending.model import Stiffness
from flusi_msm.wing.file import read_wing

SOURCE = Path(__file__).resolve().parents[3]
WING = str(SOURCE / "wings/calliphora_small.h5")
DESIGN = Case(WING, [((0.00676, -0.00150), np.array([0.0, 0.0, 2.0e-4]))], spacing=6e-4, stiffness=Stiffness(plate="edges"))


def columns_of(oracle):
    """Changes by what a fit may adjust, an sd of each, by finite differences of the generator alone; and the usual residual."""
    base = oracle.base
    s = base.stiffness
    e = 1e-3
    moved = [(replace(base, stiffness=replace(s, E=s.E * (1 + e))), np.log(10)), (replace(base, stiffness=replace(s, D=s.D * (1 + e))), 0.1),
             (replace(base, air_ratio=base.air_ratio * (1 + e)), 0.3)]
    if oracle.rig.has_record:
        moved.append((replace(base, damping=replace(base.damping, rayleigh_mass=base.damping.rayleigh_mass * (1 + e))), np.log(10)))
    start = oracle.residual(oracle.show(base), {})
    columns = [(oracle.residual(oracle.show(one), {}) - start) / e * sd for one, sd in moved]
    if oracle.rig.has_record:
        n = len(start) - subjects.SAMPLES * len(subjects.PLACES)
        seen = oracle.show(base)[1]
        late = subjects.shown_record(base, "same", oracle.rig.medium, late=oracle.rig.trigger)
        for change in (oracle.rig.size * seen, late - seen):
            columns.append(np.concatenate([np.zeros(n), change.ravel() / oracle.sd_record]))
    return np.stack(columns, 1), start


def explained(oracle, subject, a, start):
    """The same ratio of an effect to first order, by these columns."""
    d = oracle.residual(oracle.show(subject), {}) - start
    right = a.T @ d
    return float(np.sqrt(d @ d - right @ np.linalg.solve(np.eye(a.shape[1]) + a.T @ a, right)))


class Visibility(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.individual = vibration.Individual(DESIGN, 3, 0)  # which remembers its oracles

    def test_joints(self):
        """The wing without hidden effects is one whose joints bend as its veins, on each mesh: it has the frequencies of a wing to
        which no joint is stated."""
        for mesh, base in self.individual.bases.items():
            alike = replace(base, stiffness=replace(base.stiffness, E=DESIGN.stiffness.E))
            bare = replace(alike, stiffness=replace(alike.stiffness, joints={}))
            self.assertTrue(base.stiffness.joints)
            for (hertz, _), (other, _) in zip(subjects.shown_modes(alike, mesh), subjects.shown_modes(bare, mesh)):
                self.assertAlmostEqual(hertz / other, 1, delta=1e-9, msg=mesh)

    def test_ratio(self):
        """Of effects that are small it is that of a linear model, whose columns are made without the few modes of the oracle."""
        for rig, effects in (("modes", (vibration_effects.membrane_gradient, vibration_effects.vein_mass)),
                             ("both", (vibration_effects.stiffness_damping, vibration_effects.lag))):
            oracle = self.individual.oracle("same", rig)
            self.assertLess(oracle.snr(oracle.show(oracle.base)), 0.3, "of nothing")
            columns = columns_of(oracle)
            for make in effects:
                effect = make(np.random.default_rng(1), read_wing(WING), oracle.base)
                strength, snr = vibration.make_strong(oracle, effect, 2.5, (2.0, 3.5))
                self.assertAlmostEqual(explained(oracle, effect.apply(oracle.base, strength), *columns) / snr, 1, delta=0.07, msg=effect.name)

    def test_absorbed(self):
        """Another E, air, damping, size of the force are no effect."""
        oracle = self.individual.oracle("same", "both")
        s, damping = oracle.base.stiffness, oracle.base.damping
        other = replace(oracle.base, stiffness=replace(s, E=1.05 * s.E), air_ratio=0.9 * oracle.base.air_ratio,
                        damping=replace(damping, rayleigh_mass=1.2 * damping.rayleigh_mass))
        self.assertLess(oracle.snr(oracle.show(other)), 2.0, "of some hundreds")

    def test_nuisance_of_many_sd(self):
        """A lag of the sensor is first of all a late record: no more of it is visible than what a trigger that is wrong by the same
        time leaves, its improbability included."""
        oracle = self.individual.oracle("same", "record")
        for many in 5, 10:
            lag = many * oracle.rig.trigger
            shown = oracle.show(replace(oracle.base, unstated=subjects.Unstated(lag=lag)))
            late = oracle.residual(shown, {"trigger": -many})
            self.assertLess(oracle.snr(shown), np.sqrt(late @ late + many**2))


class Menu(unittest.TestCase):
    def test_names(self):
        """What is drawn as outside the catalogue says so, and nothing else; a soft joint is a cause of the catalogue."""
        subject, wing = vibration.Individual(DESIGN, 3, 0).bases["same"], read_wing(WING)
        for kind, names in (("single", {"joint_stiffness", "E_per_vein"}), ("outside", {"E_wave", "D_wave", "membrane_wave", "lag"})):
            effects = [make(np.random.default_rng(1), wing, subject) for make in vibration_effects.menu(kind, True)]
            self.assertLessEqual(names, {effect.name for effect in effects})
            self.assertEqual({effect.is_known for effect in effects}, {kind == "single"})
            self.assertEqual(len({effect.name for effect in effects}), len(effects))

    def test_joint_stiffness(self):
        """Its parameter is the stiffness that the wing has, under the name that intervals have; other joints stay."""
        subject = vibration.Individual(DESIGN, 3, 0).bases["finer"]
        effect = vibration_effects.joint_stiffness(np.random.default_rng(1), read_wing(WING), subject)
        (name, value), = effect.parameters(3.0).items()
        joints, joint = subject.stiffness.joints, name[len("joint:"):]
        self.assertEqual(effect.apply(subject, 3.0).stiffness.joints, {**joints, joint: value})
        self.assertAlmostEqual(value / joints[joint], 0.25, delta=1e-12)


class Cases(unittest.TestCase):
    def make(self, folder, kind, cases):
        """A study in a folder with these {number: stratum}."""
        for part in ("sealed", "measured", "individuals"):
            (folder / part).mkdir(parents=True)
        study = ArchivedStudy(folder, {"small": DESIGN}, 3, Archive(None), kind)
        for number, (stratum, before) in cases.items():
            study.make(number, stratum, before)
        return study

    def test_made(self):
        """The same bytes whatever was made before; the ratio is within bounds; rigs take turns; nothing hidden is in the file."""
        single, outside = Stratum("single", 1, "single", (4.0, 6.0)), Stratum("outside", 1, "outside", (5.0, 15.0))
        with tempfile.TemporaryDirectory() as folder:
            one = self.make(Path(folder) / "a", "vibration", {1: (Stratum("null", 1, "null"), 0), 2: (single, 1), 3: (outside, 2)})
            two = self.make(Path(folder) / "b", "vibration", {2: (single, 1)})
            self.assertEqual(one.measurement(2).read_bytes(), two.measurement(2).read_bytes())
            truth = one.truth(2)
            self.assertTrue(4 <= truth["snr"] < 6, truth["snr"])
            self.assertEqual([one.truth(k)["rig"] for k in (1, 2, 3)], ["modes", "record", "both"])
            self.assertEqual([cause["is_known"] for k in (1, 2, 3) for cause in one.truth(k)["causes"]], [True, False])
            for number, groups in ((1, {"modes"}), (2, {"series"}), (3, {"modes", "series"})):
                with h5py.File(one.measurement(number)) as file:
                    self.assertEqual(set(file), groups)
                    if "series" in file:
                        self.assertNotIn("lowpass", file["series/ring"].attrs, "a filter that nobody stated")

    def test_joint(self):
        """Heights and modes of one wing; the ratio is that of both."""
        with tempfile.TemporaryDirectory() as folder:
            study = self.make(Path(folder) / "a", "joint", {1: (Stratum("single", 1, "single", (8.0, 12.0)), 0),
                                                            2: (Stratum("double", 1, "double", (8.0, 30.0)), 0)})
            truth = study.truth(1)
            self.assertTrue(8 <= truth["snr"] < 12, truth["snr"])
            with h5py.File(study.measurement(1)) as file:
                self.assertEqual(set(file) & {"loads", "modes", "reference"}, {"loads", "modes", "reference"})
                self.assertEqual(len(file["modes"]), subjects.MODES)
            truth = study.truth(2)
            self.assertEqual(len({cause["name"] for cause in truth["causes"]}), 2, "two causes")
            for cause in truth["causes"]:
                self.assertTrue(8 / CLOSE <= cause["snr"] <= 30 * CLOSE, "each visible by itself")


if __name__ == "__main__":
    unittest.main()
