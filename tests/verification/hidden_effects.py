#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_train finds effects that tools/make_measurement has hidden in a bending test, though the two share no code.

usage: hidden_effects.py <msm_train> <flusi>
"""
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from flusi_msm.bending.model import Model, Stiffness
from flusi_msm.wing.file import read_wing
from synthetic import run_tool

SOURCE = Path(__file__).resolve().parents[2]
WING = SOURCE / "wings/calliphora_small.h5"
JOINT = 2e-6  # [N m/rad] of all joints: they bend as much as the veins beside them
LOADS = [[0.00721, -0.00032, 2.8e-4], [0.00496, -0.00228, -1.4e-4], [0.00856, -0.00078, 1.6e-4]]
# Without noise both programs see the same heights to some 1e-13 m. Errors of 1 nm are declared; then the priors, whose sd
# is of the size of the effects, draw by the square of the ratio of both standard deviations, below 1e-6 for each.
FOUND = 1e-6
INI = """[Wing]
file = {wing};
E = 9e9;
joint_stiffness = {joint!r};
{keys}
[Mass]
membrane_law = uniform;
[Measurement]
file = test.h5;
[Train]
parameters = {sought};
start = wing;
[CMAES]
max_generations = 1; the polish is tested, from a place near the wing
sigma0 = 0.01;
[Polish]
intervals = no;
starts = 1;
[Solver]
tolerance = 1e-10;
"""


def hide(folder, stiffness, hidden, levels=(1.0,), loads=LOADS):
    """A measurement with hidden effects, without noise."""
    wing = read_wing(WING)
    case = {"wing": str(WING), "loads": loads, "spacing": 2e-4, "protocol": {"levels": levels, "random_order": True},
            "stiffness": {"E": 9e9, "plate": "edges", "joints": {name: JOINT for name in wing.joints}, **stiffness},
            "noise": {"height": 0.0}, "declared": {"height": 1e-9}, "hidden": hidden}
    (folder / "case.json").write_text(json.dumps(case))
    done = run_tool("make_measurement", folder / "case.json", "-o", folder / "test.h5", "--quiet")
    assert done.returncode == 0, done


def seek(folder, sought, keys=""):
    """What msm_train finds, by name, beginning where nothing happens."""
    (folder / "train.ini").write_text(INI.format(wing=WING, joint=JOINT, sought=", ".join(sought), keys=keys))
    done = subprocess.run([PROGRAM, "train.ini", "--overwrite"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    text = (folder / "trained.ini").read_text()
    lists = ", ".join(line.partition("=")[2].partition(";")[0] for line in text.splitlines() if line.startswith("param"))
    return {name: float(value) for name, value in (pair.split() for pair in lists.split(","))}, text


class HiddenEffects(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.place = Path(self.folder.name)

    def compare(self, truth, found, null):
        for name, value in truth.items():
            error = abs(found[name] - value) / abs(value - null.get(name, 0))
            print(f"{name}: hidden {value:g}, found {found[name]:.9g}, off by {error:.1e} of the effect")
            self.assertLess(error, FOUND, name)

    def test_wing(self):
        """Of the wing: a gradient, damage, hardening joints a clamp that gives way and large deflections, all at once."""
        hide(self.place, {"E_gradient": -0.6, "damage": [4.5e-3, -0.5e-3, 1.2e-3, 0.4], "joint_hardening": 6.0,
                          "root_compliance": [3000, 8000]}, {})
        truth = {"E_gradient": -0.6, "damage": 0.4, "joint_hardening": 6.0, "root_flap": 3000, "root_twist": 8000}
        truth["nonlinearity"] = 1.0  # sought from small deflections
        found, text = seek(self.place, truth,
                           "damage_disc = 4.5e-3 -0.5e-3 1.2e-3;\n[Instrument]\nparameters = nonlinearity 0")
        self.compare(truth, found, {"damage": 1})
        # The fragment is a wing for flusi --static, on the same clamp.
        self.assertIn("damage_disc", text)
        (self.place / "static.ini").write_text(f"[include]\nfile = trained.ini\n[Wing]\nfile = {WING};\n[Loads]\n"
                                               f"forces = (/ {' '.join(map(repr, LOADS[0]))} /);\n")
        done = subprocess.run([FLUSI, "--static", "static.ini"], cwd=self.place, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        moved = float(done.stdout.split("CPU [ms]\n")[1].split("\n")[0].split()[8])
        true = json.loads((self.place / "test.truth.json").read_text())["loads"][0]["moved"]
        self.assertLess(abs(moved / (1e3 * true) - 1), 1e-4)
        # A flight is held by its frame.
        (self.place / "solid.ini").write_text(f"[include]\nfile = trained.ini\n[Wing]\nfile = {WING};\n")
        done = subprocess.run([FLUSI, "--solid", "solid.ini", "--check"], cwd=self.place, capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn("root_flap and root_twist", done.stderr)

    def test_instrument(self):
        """Of the experiment, and one more soft place in the wing."""
        vein, share, soft = "R4+5", 0.4, 1e-6
        hide(self.place, {}, {"force_gain": 1.06, "force_offset": 8e-6, "force_tilt": [0.05, -0.03], "drift": -0.015,
                              "load_shift": [4e-5, -6e-5], "height_scale": 0.97, "map_shift": [5e-5, 3e-5],
                              "creep": [0.05, 3.0], "gravity": [0, 0, -9.81], "soft_places": [[vein, share, soft]]},
             levels=(1.0, -0.5), loads=LOADS[:2])
        found, text = seek(self.place, ["force_gain", "force_offset", "force_tilt_x", "force_tilt_y", "drift",
                                        "load_shift_x", "load_shift_y", "height_scale", "map_shift_x", "map_shift_y",
                                        "gravity_z", "soft"],
                           f"soft_place = {vein} {share};\n[Instrument]\nparameters = creep 0.05, creep_time 3")
        truth = {"force_gain": 1.06, "force_offset": 8e-6, "force_tilt_x": 0.05, "force_tilt_y": -0.03, "drift": -0.015,
                 "load_shift_x": 4e-5, "load_shift_y": -6e-5, "height_scale": 0.97, "map_shift_x": 5e-5,
                 "map_shift_y": 3e-5, "gravity_z": -9.81, "soft": soft / self.stiffness_at(vein, share)}
        self.compare(truth, found, {"force_gain": 1, "height_scale": 1, "soft": 1})
        self.assertIn("creep 0.05", text)
        self.assertIn("[Instrument]", text)

    @staticmethod
    def stiffness_at(vein, share):
        """Of the hinge inside a vein nearest to a share of its length."""
        from types import SimpleNamespace

        from flusi_msm.measurement.synthesis import with_soft_places
        case = SimpleNamespace(hidden=SimpleNamespace(soft_places=[(vein, share, 1.0)]))
        model = Model(with_soft_places(read_wing(WING), case), Stiffness(E=9e9, plate="edges"))
        return next(model.hinge_stiffness(h, with_joint=False) for h in model.hinge_plan if h.joint == "soft1")


if __name__ == "__main__":
    PROGRAM, FLUSI = (str(Path(sys.argv.pop(1)).resolve()) for _ in range(2))
    unittest.main()
