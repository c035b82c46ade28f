#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_diagnose as a user meets it: a hidden change of stiffness along the span is named from data of other mechanics, the
same on one and on two ranks; the files can be used and are those of docs/formats/diagnosis.schema.json, also of a plan and where
there are too few data; the diagnosed wing flies, and the report says what the cause changes; draws are kept; mistakes are
said.

usage: msm_diagnose.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import json
import re
import shutil
import subprocess
import sys

import h5py
import numpy as np
from gradient_case import CASE, input_text, synthesise
from whole_program import ALIVE, EXIT_OK, MOST_LINES, SOURCE, Case, check, main

from json_schema import validate

FLUSI = sys.argv.pop(3)
# ini/diagnose-flight.ini with one wing, one beat and a grid that is too coarse for physics.
COARSE = {"nx": 32, "ny": 32, "nz": 16, "Tmax": 1.0, "CFL": 0.9, "surface": "penalized", "sponge_thickness": 4}
EXIT_NAMED, EXIT_SET, EXIT_USER, EXIT_INSUFFICIENT, EXIT_UNWRITABLE, EXIT_NUMERICAL = 10, 11, 2, 20, 5, 3
SCHEMA = SOURCE / "docs/formats/diagnosis.schema.json"


def test_name(case):
    """One verdict on any number of ranks, and files that tell it."""
    synthesise(case, text=input_text(modes=4))
    texts, kept = [], []
    for ranks, arguments, code in (1, ["--exit-code"], EXIT_NAMED), (2, [], EXIT_OK):
        done = case.run("diagnose.ini", *arguments, ranks=ranks, code=code, timeout=300)
        check(len(done.out.splitlines()) <= MOST_LINES, f"at most {MOST_LINES} lines on the terminal")
        check(re.search(r"E falls toward the tip: about (6|7)\d % lower than at the root\n", done.out), f"size and sign: {done.out}")
        # Open MPI 4 tells of every code but 0 what mpirun has noticed.
        check(code != EXIT_OK or "exit" not in done.err, f"a success has no banner of mpirun: {done.err}")
        texts.append((case.folder / "diagnosis.json").read_text())
        kept.append((case.folder / "diagnosis_draws.h5").stat().st_ino)
    check(kept[0] == kept[1], "two ranks use what one has drawn")
    check(texts[0] == texts[1], "the JSON file is the same to the byte on one and on two ranks")
    found = json.loads(texts[0])
    check(not validate(found, SCHEMA), f"the JSON file is what the schema says: {validate(found, SCHEMA)}")
    verdict = found["verdict"]
    check(verdict["grade"] == "A" and "region" not in verdict and verdict["related"] == [], "a name has grade A, and no region")
    check(verdict["word"] == "named" and [c["effect"] for c in verdict["causes"]] == ["E_gradient"],
          f"the gradient of E is named, not {verdict['sentence']}")
    effects = {e["name"]: e for e in found["effects"]}
    check(all(e["status"] in ("tested", "absorbed", "not_testable") for e in effects.values()), "every entry has a status")
    check(effects["creep"]["status"] == "not_testable" and effects["creep"]["missing"], "creep says what it lacks")
    check(abs(found["noise"]["white_m"] / found["noise"]["declared_m"] - 1) < 0.1, "the noise is that of the generator")
    value = {p["name"]: p["value"] for p in found["extended"]["parameters"]}["E_gradient"]
    check(abs(value + 1.2) < 0.25, f"the gradient is that of the generator, -1.2, not {value}")
    check("E_gradient" in (case.folder / "diagnosis_extended.ini").read_text(), "the extended wing has it")
    fly(case)


def test_refine(case):
    """A wing of a finer mesh, in which nothing is hidden, under exact measurements: with `refine = yes` the difference is
    the mesh's and no cause, the same on one and on two ranks; without it, something is found that is not there. What an
    earlier diagnosis found is not left."""
    synthesise(case, "--refine", "1", stiffness={"plate": "edges", "E": 9.0e9},
               noise={"height": 1.0e-6, "tilt": 3.0e-4, "piston": 1.0e-6, "reference_scans": 4})
    text = input_text().replace("joint:C_Sc, joint:R4+5_r-m", "joint:*")
    text = text.replace("observations = 400", "observations = 300")
    case.write("diagnose.ini", text)
    done = case.flusi("diagnose.ini", "--exit-code", timeout=300)
    blind = json.loads((case.folder / "diagnosis.json").read_text())
    check(done.code in (EXIT_NAMED, EXIT_SET, 12) and 0 < blind["verdict"]["global_p"] < 0.05,
          f"the mesh is taken for a cause: {blind['verdict']['sentence']}, p = {blind['verdict']['global_p']}")
    (case.folder / "diagnosis_extended.ini").write_text("; of an earlier diagnosis\n")
    texts = []
    for ranks in 1, 2:
        done = case.run("diagnose.ini", "--refine=yes", "--exit-code", ranks=ranks, code=EXIT_OK, timeout=300)
        texts.append((case.folder / "diagnosis.json").read_text())
    check(texts[0] == texts[1], "the JSON file is the same to the byte on one and on two ranks")
    band = json.loads(texts[0])["mesh_band"]
    check(band["is_found"] and not band["is_fitted_on"] and band["snr"] > 5 and 1e-7 < band["rms_m"] < 1e-5,
          f"the band is told: {band}")
    check("_extended.ini" not in done.out and "diagnosis_extended.ini" not in case.files(), "nothing is left of another")


def test_relinearisation(case):
    """A membrane of four times the stiffness that is assumed, in a wing of a finer mesh: its fit takes the difference of the
    meshes anew, for which all ranks go to the other mesh and come back. The same on one and on two ranks; D is what it is
    on that mesh but for the 10 % that meshes change."""
    synthesise(case, "--refine", "1", stiffness={"plate": "edges", "E": 9.0e9, "D": 8.0e-7})
    texts = []
    for ranks in 1, 2:
        case.run("diagnose.ini", "--refine=yes", "--exit-code", ranks=ranks, code=EXIT_NAMED, timeout=300)
        texts.append((case.folder / "diagnosis.json").read_text())
    check(texts[0] == texts[1], "a second look is the same to the byte on one and on two ranks")
    found = json.loads(texts[0])
    check([c["effect"] for c in found["verdict"]["causes"]] == ["membrane_bending"]
          and found["verdict"]["wider"] == ["elasticity"], found["verdict"]["sentence"])
    value = {p["name"]: p["value"] for p in found["extended"]["parameters"]}["D"]
    check(abs(value / 8.0e-7 - 1) < 0.1, f"D is that of the generator, 8e-7, not {value}")


def test_rest(case):
    """A wing that snaps: on the way from far stiffness a load follows a shape that it would not come to from rest. The
    baseline is that of shapes from rest all the same: from the usual stiffness it is the one that is found from the true."""
    joints = {"A1+CuA2_CuA2": 1.9e-6, "C_Sc": 4.1e-5, "C_h": 3.84e-5, "CuA1_base": 1.86e-5, "M1+2_bend": 5.5e-7,
              "M1+2_bm-cu": 2.88e-5, "R1_Rs": 7.98e-5, "R2+3_base": 1.05e-5, "R4+5_base": 4.4e-5, "R4+5_r-m": 1.48e-6}
    loads = json.loads((SOURCE / "ini/blind.json").read_text())["loads"]
    synthesise(case, loads=loads, stiffness={"plate": "edges", "E": 1.09e10, "joints": joints},
               noise={"height": 1.0e-5, "reference_scans": 4})
    text = input_text().replace("joint:C_Sc, joint:R4+5_r-m", "joint:*")
    true = ", ".join(f"joint:{name} {value}" for name, value in joints.items())
    found = []
    for wing in "E = 12.58e9;\nD = 2e-7;", f"E = 1.09e10;\nD = 2e-7;\nparameters = {true};":
        case.write("diagnose.ini", text.replace("[Wing]", f"[Wing]\n{wing}"))
        case.run("diagnose.ini", "--exit-code", ranks=0, code=EXIT_OK, timeout=300)
        found.append(json.loads((case.folder / "diagnosis.json").read_text())["baseline"]["chi2"])
    # Both fits end where a hundredth is left to gain; values before them enter by priors of a decade.
    check(abs(found[1] - found[0]) < 1.0, f"both baselines are the same: chi^2 {found}")


def test_load_errors(case, numbers_of_ranks=(2,)):
    """Forces that acted 60 um beside their places, as is stated, on stiff wings near a soft membrane: what that does is not
    linear in it. It is no cause, and the sum of squares is that of the noise (with the tangents at the stated places 1055,
    p = 1e-85). 417 averages, of which what is fitted and the errors of every load are not free."""
    loads = json.loads((SOURCE / "ini/blind.json").read_text())["loads"]
    synthesise(case, seed=1, loads=[loads[k] for k in (0, 1, 6)], stiffness={"plate": "edges", "E": 1.2e10},
               protocol={"levels": [0.5, 1, -1], "random_order": True},
               noise={"height": 3e-6, "position": 6e-5, "tilt": 5e-4, "piston": 5e-6, "reference_scans": 4})
    text = input_text().replace("joint:C_Sc, joint:R4+5_r-m", "joint:*")
    case.write("diagnose.ini", text.replace("observations = 400", "observations = 500"))
    texts = []
    for ranks in numbers_of_ranks:
        case.run("diagnose.ini", "--exit-code", ranks=ranks, code=EXIT_OK)
        texts.append((case.folder / "diagnosis.json").read_text())
    if len(texts) > 1:
        check(len(set(texts)) == 1, "the JSON file is the same to the byte on one and on two ranks")
    found = json.loads(texts[0])
    check(found["baseline"]["chi2"] < 417, f"chi^2 is that of the noise: {found['baseline']['chi2']}")


def test_load_errors_on_ranks(case):
    test_load_errors(case, (1, 2))


def keep_draws(case, *arguments):
    """Draws that are damaged, of other data, or not there give the same result as those that were kept, and are whole again;
    those that were kept are not written again."""
    draws, result = case.folder / "diagnosis_draws.h5", case.folder / "diagnosis_plan.json"
    text, good, kept = result.read_text(), draws.read_bytes(), draws.stat()
    case.run(*arguments, code=EXIT_OK)
    check(draws.stat().st_ino == kept.st_ino and result.read_text() == text, "the same draws are not written again")
    middle = len(good) // 2
    damaged = good[:middle] + bytes(255 - x for x in good[middle:middle + 64]) + good[middle + 64:]
    for what, content in {"cut off": good[:middle], "damaged": damaged}.items():
        draws.write_bytes(content)
        case.run(*arguments, code=EXIT_OK)
        check(result.read_text() == text, f"{what}: the result is the same")
        check(len(draws.read_bytes()) == len(good) and draws.read_bytes() != content, f"{what}: the file is whole again")
    ini = case.folder / arguments[0]
    other = ini.read_text().replace("draws = 1000", "draws = 999")
    ini.write_text(other)
    case.run(*arguments, code=EXIT_OK)
    check(len(draws.read_bytes()) < len(good), "other draws take their place")
    alone = result.read_text()
    ini.write_text(other + "[Saving]\ndraws = none;\n")
    draws.unlink()
    case.run(*arguments, code=EXIT_OK)
    check(result.read_text() == alone, "without a file the result is the same")
    check(not [name for name in case.files() if "draws" in name], f"nothing is left: {case.files()}")


def share_draws(case, ini, *arguments):
    """Three programs that begin at once with one file leave it whole, and nothing else."""
    text = (case.folder / ini).read_text()
    for number in range(3):
        case.write(f"{number}.ini", text + f"[Saving]\nname = run{number};\ndraws = shared.h5;\n")
    running = [subprocess.Popen([case.program, f"{number}.ini", *arguments], cwd=case.folder, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL) for number in range(3)]
    check([program.wait(ALIVE) for program in running] == 3 * [EXIT_OK], "all three end well")
    check([name for name in case.files() if "shared" in name] == ["shared.h5"], f"one file is left: {case.files()}")
    written = (case.folder / "shared.h5").stat().st_ino
    case.flusi("0.ini", *arguments)
    check((case.folder / "shared.h5").stat().st_ino == written, "it is whole: another run uses it")


def coarse_flight():
    text = (SOURCE / "ini/diagnose-flight.ini").read_text()
    text = re.sub(r"from_file::", f"from_file::{SOURCE}/ini/", text)
    text = re.sub(r"^file = \.\./", f"file = {SOURCE}/", text, flags=re.M)
    text = re.sub(r"^(FlappingMotion_right|x_pivot_r) .*\n", "", text, flags=re.M)
    text = text.replace("wings = flexible;", "wings = flexible;\nRightWing = no;")
    for key, value in COARSE.items():
        text, found = re.subn(rf"^{key} = [^;]*", f"{key} = {value}", text, flags=re.M)
        check(found == 1, f"ini/diagnose-flight.ini has {key}")
    return text.replace("[Penalization]", "[Penalization]\neps = 1.0e-2;")


def mean(run, file, column):
    """Time average over the beat by the trapezoidal rule."""
    series = run.series(file)
    names = re.split(r"\s{2,}", series.header[0].lstrip("% "))
    number = next(i for i, name in enumerate(names) if name.split("[")[0].strip() == column)
    rows = [(row[0], row[number]) for row in series.rows if row[0] <= 1]
    check(rows[0][0] == 0 and rows[-1][0] == 1, f"{file} covers the beat")
    return sum((b[0] - a[0]) * (a[1] + b[1]) / 2 for a, b in zip(rows, rows[1:]))


def fly(case):
    """Both wings fly a beat, and the report of the diagnosis tells by how much lift, drag and power change: the same as the
    means here, rounded to 0.1 %."""
    means = {}
    for name in "baseline", "extended":
        run = Case(FLUSI, case.h5dump, case.folder / name)
        shutil.copy(case.folder / f"diagnosis_{name}.ini", run.folder / "tested.ini")
        run.write("flight.ini", coarse_flight())
        run.run("flight.ini", timeout=300)
        lift, drag = (mean(run, "forces.t", f"F{axis}") + mean(run, "forces.t", f"F{axis} unsteady") for axis in "zx")
        means[name] = lift, drag, mean(run, "aero_power.t", "aerodynamic power")
    subprocess.run([sys.executable, "-B", SOURCE / "tools/plot_diagnosis", "diagnosis.json", "--flight", "baseline",
                    "extended"], cwd=case.folder, check=True, stdout=subprocess.DEVNULL)
    told = re.search(r"mean lift by ([-+.\d]+) %, the mean drag by ([-+.\d]+) % and the mean aerodynamic power by ([-+.\d]+) %",
                     (case.folder / "diagnosis_report.html").read_text())
    check(told, "the report tells what changes")
    for number, quantity in enumerate(("lift", "drag", "power")):
        change = 100 * (means["extended"][number] / means["baseline"][number] - 1)
        print(f"    {quantity}: {change:+.2f} % by the series, {told[number + 1]} % by the report", flush=True)
        check(abs(float(told[number + 1]) - change) <= 0.0501, f"the change of the {quantity}")
        check(abs(change) > 1e-4, f"the cause changes the {quantity}")


def test_few(case):
    """Fewer heights than unknowns: a plan is made, and a diagnosis says that it cannot test anything."""
    synthesise(case, loads=CASE["loads"][1:2], spacing=2e-3, protocol={"levels": [1]})
    (case.folder / "diagnose.ini").write_text(input_text().replace("joint:C_Sc, joint:R4+5_r-m", "joint:*"))
    plan = case.run("diagnose.ini", "--plan", code=EXIT_OK)
    earlier = [f"diagnosis{ending}" for ending in (".json", ".h5", "_baseline.ini", "_extended.ini", "_extended_flight.ini",
                                                   "_next_measurements.csv")]
    for name in earlier:
        case.write(name, "of an earlier diagnosis\n")
    done = case.run("diagnose.ini", "--exit-code", code=EXIT_INSUFFICIENT)
    for name in earlier:
        check("earlier" in (case.folder / f"{name}.earlier").read_text(), f"{name} moves aside")
    check("diagnosis_extended.ini" not in case.files(), "and none is there if none is written")
    for name in "diagnosis_plan", "diagnosis":
        found = json.loads((case.folder / f"{name}.json").read_text())
        check(not validate(found, SCHEMA), f"{name}.json is what the schema says: {validate(found, SCHEMA)}")
        words = {effect["name"]: effect["status"] for effect in found["effects"]}
        check(words["creep"] == "not_testable", "every entry of the catalogue is told")
    check(found["verdict"]["grade"] == "" and "too few" in done.out, done.out)
    planned = json.loads((case.folder / "diagnosis_plan.json").read_text())["effects"]
    told = [e for e in planned if e["status"] == "tested"]
    check(told and all(e["name"] in plan.out and e["detectable"] > 0 for e in told), "the plan is the one on the terminal")
    share_draws(case, "diagnose.ini", "--plan")
    keep_draws(case, "diagnose.ini", "--plan")


def test_plan(case):
    """A plan without heights is that of an experiment in which all heights are known, to the byte; of the same loads with what
    was measured it differs by heights that the bent wing has left, up to 1 in 20, and by the draws, up to 1 in 100. With correlated
    errors nothing is found from less than when it is known how they mix, but for the draws. It is not diagnosed."""
    found = {}
    correlated = ("--set", "noise.correlated=1e-5", "--set", "noise.correlation_length=1e-3")
    for name, arguments in ("correlated", correlated), ("mixed", ("--plan", *correlated)), ("measured", ()), ("nothing", ("--plan",)):
        synthesise(case, *arguments)
        case.write("diagnose.ini", (case.folder / "diagnose.ini").read_text() + "noise = declared;\n")
        done = case.run("diagnose.ini", "--plan", code=EXIT_OK)
        check(("their fractions are not known" in done.out) == (name == "mixed"), done.out)
        found[name] = (case.folder / "diagnosis_plan.json").read_text()
    done = case.run("diagnose.ini", ranks=1, code=EXIT_USER)
    check(done.err.count("bending.h5: ") == 1 and "is the plan of an experiment" in done.err, done.err)
    with h5py.File(case.folder / "bending.h5", "r+") as file:
        loads = [f"loads/{name}/" for name in file["loads"]]
        for place in "reference/", *loads:
            file[place + "z"] = np.zeros((file["reference/y"].size, file["reference/x"].size))
            file[place + "z"].attrs["units"] = "m"
    case.run("diagnose.ini", "--plan", ranks=1, code=EXIT_OK)
    check((case.folder / "diagnosis_plan.json").read_text() == found["nothing"], "the plan is that of known heights")
    for plan, measured, lowest, highest in ("nothing", "measured", 0.94, 1.02), ("mixed", "correlated", 0.98, 9.0):
        after = {effect["name"]: effect for effect in json.loads(found[measured])["effects"]}
        tested = [effect for effect in json.loads(found[plan])["effects"] if effect["status"] == "tested"]
        check(len(tested) >= 20, f"{len(tested)} effects can be tested")
        for effect in tested:
            ratio = effect["detectable"] / after[effect["name"]]["detectable"]
            check(lowest < ratio < highest, f"{effect['name']}: {ratio:.3f} of what is found when there are heights ({plan})")


def test_mistakes(case):
    """Unknown keys are named with the nearest one."""
    (case.folder / "wrong.ini").write_text(input_text() + "drows = 5;\n")
    done = case.run("wrong.ini", ranks=1, code=EXIT_USER)
    check("drows" in done.err and "draws" in done.err, done.err)
    (case.folder / "bending.h5").write_bytes((SOURCE / "wings/calliphora_small.h5").read_bytes())
    (case.folder / "over.ini").write_text(input_text() + "[Saving]\nname = bending;\n")
    done = case.run("over.ini", ranks=1, code=EXIT_USER)
    check("bending.h5 is an input file and would be overwritten" in done.err, done.err)


def test_no_shape(case):
    """Forces under which the wing has no shape are a numerical failure: exit code 3, a sentence, and no file of a verdict."""
    synthesise(case, loads=CASE["loads"][1:2], spacing=2e-3, protocol={"levels": [1]})
    case.write("diagnose.ini", input_text())
    with h5py.File(case.folder / "bending.h5", "r+") as file:
        for load in file["loads"].values():
            load.attrs["force"] = 60 * load.attrs["force"]
    done = case.run("diagnose.ini", ranks=0, code=EXIT_NUMERICAL)
    check("the baseline cannot be fitted from any of its starting values" in done.err, done.err)
    check(not [name for name in case.files() if name.startswith("diagnosis") and name.endswith((".json", ".ini"))], f"{case.files()}")


def test_files(case):
    """That nothing can be written, or that another diagnosis writes there, is said before anything is computed."""
    synthesise(case, loads=CASE["loads"][1:2], spacing=2e-3, protocol={"levels": [1]})
    case.write("diagnose.ini", input_text() + "[Saving]\nname = no/such/folder;\n")
    done = case.run("diagnose.ini", ranks=0, code=EXIT_UNWRITABLE)
    check("no/such/folder.lock: cannot be written" in done.err and "verdict" not in done.out, done.err)
    case.write("diagnose.ini", input_text())
    case.write("diagnosis.lock", "% A run\nhost = elsewhere\nprocess = 1\nbirth = 7\nsince = today\n")
    done = case.run("diagnose.ini", ranks=0, code=EXIT_USER)
    check("process 1 on elsewhere, since today; if it has ended, remove diagnosis.lock" in done.err, done.err)


main(globals())
