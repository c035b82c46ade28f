#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Natural modes in msm_diagnose: data of tools/make_modes, whose stiffness and masses share nothing with the solver, alone and
beside bending tests of tools/make_measurement.

usage: vibration_diagnose.py <msm_diagnose> <h5dump> [tests]        flusi stands beside msm_diagnose

Intervals are of 90 %; the truth is asked to be within twice their width, as in diagnosis_entries.py.
"""
import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
from synthetic_bending import ADEQUATE, NAMED, SET, UNKNOWN, WING, diagnose, measure, seal
from whole_program import SOURCE, check, main

from json_schema import validate

from flusi_msm.bending.model import Stiffness
from flusi_msm.blind.vibration_subject import Subject, vein_joints

TIP = [8.6e-3, -0.8e-3, 4.0e-9]  # m, m, kg: 1.6 % of the wing
MODES = {"wing": WING, "modes": 6, "missing": [3], "seed": 4, "medium": "air", "air_ratio": 0.8, "stiffness": {"plate": "edges"},
         "noise": {"frequency": 0.003, "shape": 0.02}}
SHORT = "noise = declared;\nstarts = 1;\ndraws = 500;\nrefits = 1;\nvalidation = no;\nintervals = no;\n"
OPTIONS = "noise = declared;\nstarts = 1;\ndraws = 1000;\nobservations = 400;\n"



def modes_of(found):
    """The natural modes among the data of a diagnosis."""
    return next(one["sets"] for one in found["data"] if one["kind"] == "modes")


def vibrate(case, file, *more, **sections):
    """Modes with these sections added to those of MODES."""
    test = {**MODES}
    for name, content in sections.items():
        test[name] = {**test.get(name, {}), **content} if isinstance(content, dict) else content
    (case.folder / "modes.json").write_text(json.dumps(test))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_modes", "modes.json", "-o", file, *more], cwd=case.folder, check=True,
                   stdout=subprocess.DEVNULL)


def interval(found, name):
    return {one["name"]: one["lower_best_upper"] for one in found["extended"]["intervals_90"]}[name]


def test_null(case):
    """Another E, less air than strip theory, the third mode missed: all that is no discovery."""
    vibrate(case, "data.h5", stiffness={"E": 1.1e10})
    code, found = diagnose(case, "data.h5", "null", OPTIONS + "validation = no;\n")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    check([one["baseline_number"] for one in modes_of(found)] == [1, 2, 4, 5, 6], "a mode is missed, and the others keep their place")
    check(min(one["baseline_mac"] for one in modes_of(found)) > 0.98, "shapes are alike")


def test_finer(case):
    """Modes of a wing of a finer mesh, whose membrane is 1.4 times as heavy: all fits use this mesh, because its error could decide.
    The program says that it makes its fits there, and writes joints that bend as their veins do on the mesh of the file."""
    vibrate(case, "data.h5", refine=1, mass={"membrane": 1.4})
    code, found = diagnose(case, "data.h5", "finer", SHORT, parameters="E", refine="auto")
    band = found["mesh_band"]
    check(band["is_fitted_on"] and band["points"] == 747 and band["snr"] > 6**0.5, f"all fits use the finer mesh: {band}")
    check(code in (NAMED, SET) and found["verdict"]["causes"][0]["effect"] == "membrane_mass", found["verdict"]["sentence"])
    text = (case.folder / "finer_extended.ini").read_text()
    for name, stiffness in vein_stiffness().items():
        written = float(text.split(f"joint:{name} ")[1].split(",")[0].split(";")[0])
        check(abs(written / stiffness - 1) < 1e-6, f"joint {name} has {written} N m/rad, and its vein {stiffness}")


def test_loaded(case):
    """Modes about rest and about a shape under two forces and the weight, both by the generator's own statics and tangent: equal to
    2e-6, the size of their noise, with E as the only unknown. A clamp that gives way is refused."""
    noise = {"frequency": 1e-6, "shape": 1e-5}
    loads = [{"point": [8.5e-3, -0.8e-3], "force": 6e-5, "direction": [0.5, 0, 1]}, [5.5e-3, 0.0, -1e-4]]
    same = {"medium": "vacuum", "modes": 2, "missing": [], "sites": 6, "seed": 2, "noise": noise}
    vibrate(case, "data.h5", **same, name="bent", loads=loads, gravity=[0, 0, -9.81])
    truth = json.loads((case.folder / "data.modes.json").read_text())["frequencies"]
    vibrate(case, "data.h5", "--add", **same)
    at_rest = json.loads((case.folder / "data.modes.json").read_text())["frequencies"]
    check(min(abs(one / other - 1) for one, other in zip(truth, at_rest)) > 0.01, "the loads change all frequencies")
    code, found = diagnose(case, "data.h5", "loaded", "refits = 1;\n" + OPTIONS.replace("1000", "500"), parameters="E")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    check([one.get("is_loaded", False) for one in modes_of(found)] == 2 * [True] + 2 * [False], "the JSON file knows them")
    for one, wanted in zip(modes_of(found), truth + at_rest):
        check(abs(one["baseline_hz"] / wanted - 1) < 2e-6, f"{one['name']}: {one['baseline_hz']} Hz, not {wanted} Hz")
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")
    done = case.flusi(case.write("clamp.ini", (case.folder / "loaded.ini").read_text().replace("= E;", "= E, root_flap;")))
    check(done.code == 2 and "the clamp of a wing with natural modes under loads is stiff" in done.err, done.err)


def test_tip(case):
    """Glue at the tip: what, where, how much; and flusi gives the extended wing the frequencies that were measured."""
    vibrate(case, "data.h5", mass={"point": TIP}, medium="vacuum")
    code, found = diagnose(case, "data.h5", "tip", OPTIONS)
    verdict = found["verdict"]
    check(code in (NAMED, SET) and verdict["set"] == ["point_mass"], verdict["sentence"])
    place = verdict["causes"][0]["place"]
    check(max(abs(place[0] - TIP[0]), abs(place[1] - TIP[1])) < 0.3e-3, f"it is at {place}")
    lower, best, upper = interval(found, "point_mass")
    check(2 * lower - best <= TIP[2] <= 2 * upper - best, f"{best} kg ({lower} to {upper})")
    entry, = found["data"]
    check(abs(entry["baseline_chi2"] - found["baseline"]["chi2"]) < 1e-6 > abs(entry["extended_chi2"] - found["extended"]["chi2"]),
          f"all of chi^2 is that of the modes: {entry}")
    check(abs(sum(one["baseline_chi2"] for one in entry["sets"]) - entry["baseline_chi2"]) < 1e-6, "each mode has its part of it")
    check(entry["left_out"]["extended"]["chi2"] < entry["left_out"]["baseline"]["chi2"], "and the cause predicts modes left out")
    check(f"{found['verdict']['sentence']}. Something sits on the wing" in found["verdict"]["statement"], found["verdict"]["statement"])
    check(found["validation"]["gain_per_location"] > 0, "modes that were left out are predicted better")
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")
    case.write("shape.ini", f"[include]\nfile = tip_extended.ini;\n[Wing]\nfile = {WING};\n[Modes]\nmodes = 1;\n[Saving]\nname = s;\n")
    subprocess.run([Path(case.program).with_name("flusi"), "--static", "shape.ini"], cwd=case.folder, check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    frequency = float((case.folder / "s_modes.t").read_text().splitlines()[-1].split()[1])
    stated = modes_of(found)[0]["extended_hz"]
    check(abs(frequency / stated - 1) < 1e-6, f"flusi gives the extended wing {frequency} Hz, the diagnosis {stated} Hz")


def test_between(case):
    """A soft disc of 0.55 mm between the places of the scan, which has discs of 0.9 mm, 1.1 mm apart: with a disc of a lattice a soft
    place has to help. The one that is found leaves nothing but noise alone, and its centre is in the true one."""
    disc = [1.0e-3, -0.95e-3, 0.55e-3, 0.15]
    vibrate(case, "data.h5", stiffness={"damage": disc}, medium="vacuum")
    code, found = diagnose(case, "data.h5", "between", SHORT, parameters="E")
    verdict = found["verdict"]
    check(code in (NAMED, SET) and verdict["set"] == ["damage"], verdict["sentence"])
    place = verdict["causes"][0]["place"]
    check(math.hypot(place[0] - disc[0], place[1] - disc[1]) < disc[2], f"it is at {place}")
    check(verdict["remainder_log_p"] > math.log(0.01), f"what it leaves is noise: log p {verdict['remainder_log_p']}")


def test_thickness(case):
    """A membrane that is thicker toward the tip: its mass and its stiffness, by one number."""
    vibrate(case, "data.h5", stiffness={"thickness_gradient": 1.0}, mass={"membrane_gradient": 1.0}, medium="vacuum")
    code, found = diagnose(case, "data.h5", "thickness", OPTIONS + "validation = no;\n")
    check(code in (NAMED, SET) and "thickness_gradient" in found["verdict"]["set"], found["verdict"]["sentence"])
    if found["verdict"]["set"] == ["thickness_gradient"]:
        lower, best, upper = interval(found, "thickness_gradient")
        check(2 * lower - best <= 1.0 <= 2 * upper - best, f"{best} ({lower} to {upper})")
        text = (case.folder / "thickness_extended.ini").read_text()
        check("thickness_gradient" in text and f"membrane_gradient = {best}"[:24] in text, "flusi gets both")


def test_damping(case):
    """Damping ratios of modes: those of a cuticle that loses energy at every rate grow with the frequency."""
    vibrate(case, "data.h5", damping={"rayleigh_mass": 60.0, "rayleigh_stiffness": 1.2e-5, "joint_friction": 0.0})
    truth = json.loads((case.folder / "data.modes.json").read_text())
    check(0.01 < min(truth["damping_ratios"]) < max(truth["damping_ratios"]) < 0.2, f"{truth['damping_ratios']}")
    code, found = diagnose(case, "data.h5", "damping", OPTIONS + "validation = no;\n")
    check(code in (NAMED, SET) and "stiffness_damping" in found["verdict"]["set"], found["verdict"]["sentence"])
    lower, best, upper = interval(found, "rayleigh_stiffness")
    check(2 * lower - best <= 1.2e-5 <= 2 * upper - best, f"{best} s ({lower} to {upper})")


def test_friction(case):
    """Damping ratios of a wing whose joints lose energy: they do not change with the frequency as those of air or of the cuticle do."""
    vibrate(case, "data.h5", damping={"rayleigh_mass": 60.0, "joint_friction": 1.0e-4})
    code, found = diagnose(case, "data.h5", "friction", OPTIONS + "validation = no;\n", parameters="E")
    check(code in (NAMED, SET) and "joint_friction" in found["verdict"]["set"], found["verdict"]["sentence"])
    lower, best, upper = interval(found, "joint_friction")
    check(2 * lower - best <= 1.0e-4 <= 2 * upper - best, f"{best} s ({lower} to {upper})")


def test_clamp(case):
    """A clamp that turns: modes find both of its compliances."""
    vibrate(case, "data.h5", stiffness={"root_compliance": [4000, 10000]}, medium="vacuum")
    code, found = diagnose(case, "data.h5", "clamp", OPTIONS + "validation = no;\n", parameters="E")
    check(code == NAMED and found["verdict"]["set"] == ["root_compliance"], found["verdict"]["sentence"])
    for name, true in ("root_flap", 4000), ("root_twist", 10000):
        lower, best, upper = interval(found, name)
        check(2 * lower - best <= true <= 2 * upper - best, f"{name}: {best} rad/(N m) ({lower} to {upper})")


JOINT = "C_Sc"


def vein_stiffness():
    """The stiffness [N m/rad] of each joint if it bends as its vein does, by the generator."""
    return vein_joints(Subject(WING, Stiffness()), Stiffness(), "same")


def test_joint(case):
    """A joint with a fifth of the stiffness of its vein, which the baseline takes for known: its name, how stiff it is, and an input
    that flusi takes. The other way round nothing is found: the input states this joint, or all joints."""
    five, soft = {"modes": 5, "missing": [], "noise": {"frequency": 0.001, "shape": 0.005}}, 0.2 * vein_stiffness()[JOINT]
    vibrate(case, "data.h5", **five, stiffness={"joints": {JOINT: soft}})
    code, found = diagnose(case, "data.h5", "joint", OPTIONS + "validation = no;\n", parameters="E")
    cause = found["verdict"]["causes"][0]
    check(code in (NAMED, SET) and found["verdict"]["set"] == ["joint_stiffness"] and cause["variant"] == JOINT,
          f"{found['verdict']['sentence']} {cause}")
    lower, best, upper = interval(found, f"joint:{JOINT}")
    print(f"    {best:.4g} N m/rad ({lower:.4g} to {upper:.4g}), truth {soft:.4g}")
    check(2 * lower - best <= soft <= 2 * upper - best, f"{best} N m/rad ({lower} to {upper}), not {soft}")
    text = (case.folder / "joint_extended.ini").read_text()
    check(f"joint:{JOINT} {best}"[:24] in text, text)
    done = case.flusi(case.write("again.ini", text.replace("[Wing]", f"[Wing]\nfile = {WING};") +
                                 "[Measurement]\nfile = data.h5;\n[Diagnose]\nparameters = E;\nrefine = no;\n" + SHORT + "[Saving]\nname = again;\n"))
    check(json.loads((case.folder / "again.json").read_text())["verdict"]["word"] == "adequate", f"{done.out} {done.err}")


def test_soft_place(case):
    """The same in a wing whose file has no joint there, in data of a finer mesh: a soft place of this vein, fitted on the finer mesh. The
    wing that is written is for the mesh of the file, where a piece of vein is twice as long."""
    five, vein = {"modes": 5, "missing": [], "noise": {"frequency": 0.001, "shape": 0.005}}, vein_stiffness()[JOINT]
    vibrate(case, "data.h5", **five, refine=1, stiffness={"joints": {JOINT: 0.2 * vein}})
    bare = case.folder / "bare.h5"
    shutil.copy(WING, bare)
    with h5py.File(bare, "r+") as file:
        del file[f"joints/{JOINT}"]
    seal(bare)
    case.write("soft.ini", f"[Wing]\nfile = {bare};\n[Measurement]\nfile = data.h5;\n[Next]\nmodes = 0;\n[Diagnose]\nparameters = E;\n"
               f"refine = fit;\n{SHORT}[Saving]\nname = soft;\n")
    done = case.flusi("soft.ini", timeout=300)
    found = json.loads((case.folder / "soft.json").read_text())
    check(found["verdict"]["causes"][0]["effect"] == "soft_place", f"{found['verdict']['sentence']} {done.err}")
    text = (case.folder / "soft_extended.ini").read_text()
    written, truth = float(text.split(", soft ")[1].split(";")[0]), 1 / (1 / 0.2 - 1 / 2 + 1)  # turns by as much more than its vein
    print(f"    {written:.4f} of the vein is written, truth {truth:.4f}")
    check(abs(written / truth - 1) < 0.15, f"{written} of the stiffness of the vein, not {truth}")


def test_known_joints(case):
    """Joints of another stiffness that the input states are no cause; as parameters of the baseline they are none of the catalogue."""
    vibrate(case, "data.h5", modes=5, missing=[], stiffness={"joints": {name: 1e-6 for name in vein_stiffness()}})
    known = "[Wing]\njoint_stiffness = 1e-6;\n"
    code, found = diagnose(case, "data.h5", "known", SHORT, known, parameters="E")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    code, found = diagnose(case, "data.h5", "free", SHORT, known)
    entry, = [one for one in found["effects"] if one["name"] == "joint_stiffness"]
    check(entry["status"] == "not_testable" and "free parameter of the baseline" in entry["missing"], f"{entry}")


def test_outside(case):
    """A membrane whose mass goes up and down, which no entry of the catalogue is."""
    vibrate(case, "data.h5", mass={"membrane_wave": [0.8, 3.0e-3, 0.0]}, noise={"frequency": 0.001, "shape": 0.005})
    code, found = diagnose(case, "data.h5", "outside", OPTIONS)
    check(code == UNKNOWN, found["verdict"]["sentence"])


def test_little_outside(case):
    """The same in short: E as the only unknown, fewer fits and draws, no interval and no prediction."""
    vibrate(case, "data.h5", mass={"membrane_wave": [0.8, 3.0e-3, 0.0]}, noise={"frequency": 0.001, "shape": 0.005})
    code, found = diagnose(case, "data.h5", "outside", SHORT, parameters="E")
    check(code == UNKNOWN, found["verdict"]["sentence"])


def test_both(case):
    """The force sensor reads 1.25 times too little. To bending alone the wing is softer; its modes say that it is not."""
    stiffness = {"plate": "edges", "E": 1.1e10}
    measure(case, "bending.h5", stiffness=stiffness, hidden={"force_gain": 1.25}, noise={"height": 2.0e-6})
    code, found = diagnose(case, "bending.h5", "alone", OPTIONS)
    check("force_gain" not in [cause["effect"] for cause in found["verdict"]["causes"]] or code != NAMED,
          "bending alone does not name it")
    vibrate(case, "bending.h5", "--add", stiffness=stiffness)
    code, found = diagnose(case, "bending.h5", "both", OPTIONS)
    check(code == NAMED and [cause["effect"] for cause in found["verdict"]["causes"]] == ["force_gain"], found["verdict"]["sentence"])
    lower, best, upper = interval(found, "force_gain")
    check(2 * lower - best <= 1.25 <= 2 * upper - best, f"{best} ({lower} to {upper})")


def test_little_both(case):
    """The same in short, with few heights and E as the only unknown."""
    short = SHORT.replace("refits = 1", "refits = 2") + "observations = 120;\n"
    measure(case, "bending.h5", stiffness={"plate": "edges"}, hidden={"force_gain": 1.25})
    code, found = diagnose(case, "bending.h5", "alone", short, parameters="E")
    check(code != NAMED, f"bending alone does not name it: {found['verdict']['sentence']}")
    vibrate(case, "bending.h5", "--add", stiffness={"plate": "edges"})
    code, found = diagnose(case, "bending.h5", "both", short, parameters="E")
    check(code == NAMED and [cause["effect"] for cause in found["verdict"]["causes"]] == ["force_gain"], found["verdict"]["sentence"])
    gain, sd = [(one["value"], one["sd"]) for one in found["extended"]["parameters"] if one["name"] == "force_gain"][0]
    check(abs(math.log(gain / 1.25)) < 3 * sd, f"the gain is {gain}, sd {sd}")


def test_taper(case):
    """Thin veins that are stiffer against thick ones than solid circles would be. Veins are thin toward the tip, so that to bending alone
    it may be a gradient of E as well; modes tell both apart. The true exponent is 3.6, that of the baseline 4."""
    short = SHORT.replace("refits = 1", "refits = 3") + "observations = 120;\n"
    stiffness = {"plate": "edges", "diameter_exponent": 3.6}
    measure(case, "bending.h5", stiffness=stiffness, noise={"height": 3.0e-5})
    code, found = diagnose(case, "bending.h5", "alone", short, parameters="E")
    check(code == SET and {"taper", "E_gradient"} <= set(found["verdict"]["set"]), f"bending alone: {found['verdict']['set']}")
    vibrate(case, "bending.h5", "--add", stiffness=stiffness)
    code, found = diagnose(case, "bending.h5", "both", short, parameters="E")
    check(code == NAMED and [cause["effect"] for cause in found["verdict"]["causes"]] == ["taper"], found["verdict"]["sentence"])
    exponent, sd = [(one["value"], one["sd"]) for one in found["extended"]["parameters"] if one["name"] == "diameter_exponent"][0]
    check(abs(exponent - 3.6) < 3 * sd, f"the exponent is {exponent}, sd {sd}")
    print(f"    exponent {exponent:.4f}, sd {sd:.4f}")


if __name__ == "__main__":
    main(globals())
