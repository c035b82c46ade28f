#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of a wing that rings in msm_diagnose: data of tools/make_series, whose mechanics and integration in time share nothing with
the program.

usage: ring_down_diagnose.py <msm_diagnose> <h5dump> [tests]

Intervals are of 90 %; the truth is asked to be within twice their width, as in diagnosis_entries.py.
"""
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy
from synthetic_bending import ADEQUATE, NAMED, SET, UNKNOWN, WING, diagnose, measure
from whole_program import SOURCE, check, main

from json_schema import validate

RING = {"wing": WING, "seed": 3, "excitation": "release", "point": [8.0e-3, -0.6e-3], "size": 2.0e-5,
        "places": [[8.4e-3, -0.7e-3], [6.5e-3, 0.1e-3], [5.5e-3, -1.6e-3]], "rate": 10000, "samples": 100,
        "stiffness": {"plate": "edges"}, "damping": {"rayleigh_mass": 200},
        "noise": {"motion": 0.01, "trigger": 5.0e-6, "size": 0.05}}
OPTIONS = "noise = declared;\nstarts = 1;\ndraws = 1000;\n"


def ring(case, file, *more, **sections):
    """A record with these sections added to those of RING."""
    test = {**RING}
    for name, content in sections.items():
        test[name] = {**test.get(name, {}), **content} if isinstance(content, dict) else content
    (case.folder / "series.json").write_text(json.dumps(test))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_series", "series.json", "-o", file, *more], cwd=case.folder, check=True,
                   stdout=subprocess.DEVNULL)


def interval(found, name):
    return {one["name"]: one["lower_best_upper"] for one in found["extended"]["intervals_90"]}[name]


def names(found):
    return found["verdict"]["set"] or [cause["effect"] for cause in found["verdict"]["causes"]]


def test_null(case):
    """Damping in proportion to the mass, a filter, an error of the trigger: all that is no discovery."""
    ring(case, "data.h5", lowpass=4000, order=2)
    code, found = diagnose(case, "data.h5", "null", OPTIONS + "validation = no;\n", parameters="E")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    damping = {one["name"]: one["value"] for one in found["baseline"]["parameters"]}["rayleigh_mass"]
    check(abs(damping / 200 - 1) < 0.1, f"damping is {damping} 1/s")


def test_membrane(case):
    """A membrane that is stiffer by one sd of what is known of D: the phase of the record turns by many times its errors, but that is
    no discovery."""
    ring(case, "data.h5", stiffness={"D": 2.2e-7})
    code, found = diagnose(case, "data.h5", "membrane", OPTIONS + "validation = no;\n", parameters="E")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    error = {one["name"]: one["value"] for one in found["baseline"]["parameters"]}["membrane_error"]
    check(abs(error / 1.1 - 1) < 0.03, f"D is {error} times as large as stated")
    stated = float(re.search(r"^D = (\S+);", (case.folder / "membrane_baseline.ini").read_text(), re.MULTILINE)[1])
    check(abs(stated / (error * 2e-7) - 1) < 1e-12, "flusi's file of the baseline has this D")


def test_finer(case):
    """A record of a viscoelastic wing of a finer mesh: all fits use this mesh, because its error could decide, and the cause has its
    name."""
    ring(case, "data.h5", refine=1, damping={"relaxation": 0.2, "relaxation_time": 2.0e-4}, samples=60)
    few = "noise = declared;\nstarts = 1;\ndraws = 500;\nvalidation = no;\nintervals = no;\nrefits = 1;\n"
    code, found = diagnose(case, "data.h5", "finer", few, parameters="E", refine="auto")
    band = found["mesh_band"]
    check(band["is_fitted_on"] and band["points"] == 747 and band["snr"] > 6**0.5, f"all fits use the finer mesh: {band}")
    check(code in (NAMED, SET) and names(found)[0] == "viscoelasticity", found["verdict"]["sentence"])


def test_long(case):
    """A record of many periods: the fit of the baseline begins with the first of them, and does not lose count."""
    ring(case, "data.h5", damping={"relaxation": 0.2, "relaxation_time": 2.0e-4}, samples=3000)
    few = OPTIONS + "validation = no;\nintervals = no;\nrefits = 2;\n"
    code, found = diagnose(case, "data.h5", "long", few, parameters="E")
    baseline = found["baseline"]
    check(baseline["chi2"] < 1.2 * baseline["observations"], f"chi^2 of the baseline is {baseline['chi2']}")
    check(code in (NAMED, SET) and "viscoelasticity" in names(found), found["verdict"]["sentence"])


def test_stiffness(case):
    """A cuticle that loses energy at every rate."""
    ring(case, "data.h5", damping={"rayleigh_stiffness": 2.0e-5})
    code, found = diagnose(case, "data.h5", "stiffness", OPTIONS, parameters="E")
    check(code in (NAMED, SET) and "stiffness_damping" in names(found), found["verdict"]["sentence"])
    if names(found) == ["stiffness_damping"]:
        lower, best, upper = interval(found, "rayleigh_stiffness")
        check(2 * lower - best <= 2.0e-5 <= 2 * upper - best, f"{best} s ({lower} to {upper})")
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")


def shipped(case):
    """What the head of ini/ring-down.ini says to do, with one start and a thousand draws: exit code and JSON."""
    for path in ("ini/ring-down.ini", "ini/ring-down.json", "wings/calliphora_small.h5"):
        (case.folder / path).parent.mkdir(exist_ok=True)
        shutil.copy(SOURCE / path, case.folder / path)
    text = (SOURCE / "ini/ring-down.ini").read_text()
    check(text.count("[Diagnose]\n") == 1, "ini/ring-down.ini has the section")
    (case.folder / "ini/ring-down.ini").write_text(text.replace("[Diagnose]\n", "[Diagnose]\nstarts = 1;\ndraws = 1000;\n"))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_series", "ini/ring-down.json", "-o", "ini/series.h5"], cwd=case.folder,
                   check=True, stdout=subprocess.DEVNULL)
    done = case.flusi("ini/ring-down.ini", "--exit-code")
    print(f"    {done.out}{done.err}", flush=True)
    return done.code, json.loads((case.folder / "ring-down.json").read_text())


def test_relaxation(case):
    """The shipped case, a viscoelastic wing: what, how much, and flusi's section with it."""
    code, found = shipped(case)
    check(code == NAMED and names(found) == ["viscoelasticity"], found["verdict"]["sentence"])
    lower, best, upper = interval(found, "relaxation")
    check(2 * lower - best <= 0.2 <= 2 * upper - best, f"share {best} ({lower} to {upper})")
    check(found["validation"]["gain_per_location"] > 0, "places that were left out are predicted better")
    check_record(case, found)
    left = {name: sag(case, name, change) for name, change in (("relaxing", ""), ("elastic", "[Damping]\nrelaxation = 0.0;\n"))}
    check(left["relaxing"] < 0.5 * left["elastic"], f"flusi runs the extended wing, which comes to rest by its relaxation: {left}")


def check_record(case, found):
    """What the report says of the record is what its table shows: the extended wing leaves noise, and the force is corrected by less
    than two of its sd."""
    record, = next(one["sets"] for one in found["data"] if one["kind"] == "series")
    with h5py.File(case.folder / "ring-down.h5") as file:
        tables = [numpy.asarray(file[f"series/ring/{number}"]) for number in range(1, 4)]
    rows = numpy.concatenate([table if table.shape[1] == 5 else table.T for table in tables])
    check(len(rows) == record["observations"] == 360, "all numbers are there")
    for column, which in ((3, "baseline"), (4, "extended")):
        rms = float(numpy.sqrt((((rows[:, column] - rows[:, 1]) / rows[:, 2]) ** 2).mean()))
        check(abs(rms / record[f"{which}_rms"] - 1) < 1e-6, f"the {which} leaves {record[f'{which}_rms']}, and {rms} by its table")
    check(record["extended_rms"] < 1.1 < record["baseline_rms"], f"the cause explains what was measured: {record}")
    check(abs(record["extended_size_error"]) < 0.1 and abs(record["extended_late_s"]) < 1e-5, f"{record}")


def sag(case, name, change):
    """The largest kinetic energy of the extended wing in the last third of six turns of its lowest mode, through which its weight has
    acted, of the work of its weight; the balance of energy is closed."""
    case.write(f"{name}.ini", f"""[include]
file = ring-down_extended.ini;
{change}[Wing]
file = {WING};
[Loads]
gravity = 0 0 -9.81;
[Time]
dt = 2.0e-5;
t_max = 1.2e-2;
[Saving]
name = {name};
""")
    subprocess.run([Path(case.program).with_name("flusi"), "--solid", f"{name}.ini"], cwd=case.folder, check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    rows = [[float(word) for word in line.split()] for line in (case.folder / f"{name}.t").read_text().splitlines()[1:]]
    weight, imbalance = rows[-1][9], rows[-1][12]
    # BDF2 takes (omega dt)^3/2 of the energy in a radian, 2e-4 of it here at the lowest mode, and more from higher ones.
    check(abs(imbalance) < 0.05 * abs(weight), f"the balance of energy is open by {imbalance / weight:.3f} of the work")
    return max(row[6] for row in rows if row[0] > 8.0e-3) / weight


def test_drag(case):
    """Drag of the air with the square of the speed."""
    ring(case, "data.h5", medium="air", damping={"rayleigh_mass": 60, "drag": 12.0})
    code, found = diagnose(case, "data.h5", "drag", OPTIONS, parameters="E")
    check(code == NAMED and names(found) == ["air_drag"], found["verdict"]["sentence"])
    lower, best, upper = interval(found, "drag")
    check(2 * lower - best <= 12.0 <= 2 * upper - best, f"{best} kg/m^3 ({lower} to {upper})")
    check(f"drag = {best}"[:9] in (case.folder / "drag_extended.ini").read_text(), "flusi gets the drag")


def test_shake(case):
    """A clamp that moves after the release, which the file does not state."""
    ring(case, "data.h5", shake=[3.0, 430.0, 0.7])
    code, found = diagnose(case, "data.h5", "shake", OPTIONS, parameters="E")
    check(code in (NAMED, SET) and "base_shake" in names(found), found["verdict"]["sentence"])
    if names(found) == ["base_shake"]:
        lower, best, upper = interval(found, "base_sine")
        check(2 * lower - best <= 3.0 * numpy.cos(0.7) <= 2 * upper - best, f"sine {best} m/s2 ({lower} to {upper})")


def test_outside(case):
    """A filter that the file does not state, which no entry of the catalogue is."""
    ring(case, "data.h5", lag=2.0e-4)
    code, found = diagnose(case, "data.h5", "outside", OPTIONS, parameters="E")
    check(code in (UNKNOWN, SET), found["verdict"]["sentence"])


def test_lag(case):
    """A shorter lag, which looks like damping: the sensors have it."""
    ring(case, "data.h5", lag=5.0e-5)
    code, found = diagnose(case, "data.h5", "lag", OPTIONS, parameters="E")
    check(code == UNKNOWN, found["verdict"]["sentence"])
    region = found["verdict"]["region"]
    check(region["of"] == "sensors" and not region["parts"], f"{region}")
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")


def test_trigger(case):
    """A time of the excitation that is as wrong as the file says is no discovery."""
    ring(case, "data.h5", noise={"trigger": 2.0e-5})
    code, found = diagnose(case, "data.h5", "trigger", OPTIONS + "validation = no;\n", parameters="E")
    check(code == ADEQUATE, found["verdict"]["sentence"])


def test_both(case):
    """The force sensor reads 1.25 times too little. The record of a motion, which needs no force, says that the wing is not softer."""
    measure(case, "bending.h5", stiffness={"plate": "edges"}, hidden={"force_gain": 1.25})
    ring(case, "bending.h5", "--add", samples=60)
    code, found = diagnose(case, "bending.h5", "both", OPTIONS + "observations = 150;\n", parameters="E")
    check(code == NAMED and names(found) == ["force_gain"], found["verdict"]["sentence"])
    lower, best, upper = interval(found, "force_gain")
    check(2 * lower - best <= 1.25 <= 2 * upper - best, f"{best} ({lower} to {upper})")


if __name__ == "__main__":
    main(globals())
