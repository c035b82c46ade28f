#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_diagnose as a user meets it: a hidden change of stiffness along the span is named from data of other mechanics, the
same on one and on two ranks; the files can be used and are those of docs/diagnosis.schema.json, also of a plan and where
there are too few data; mistakes are said.

usage: msm_diagnose.py <msm_diagnose> <h5dump>
"""
import json
import subprocess
import sys

from whole_program import EXIT_OK, SOURCE, check, main

sys.path.insert(0, str(SOURCE / "tests" / "support"))
from json_schema import validate  # noqa: E402

CASE = {
    "wing": str(SOURCE / "wings/calliphora_small.h5"), "seed": 3, "spacing": 3e-4,
    "loads": [[0.00541, 0.00005, 6.0e-4], [0.00721, -0.00032, 1.6e-4], [0.00856, -0.00078, 1.0e-4]],
    "protocol": {"levels": [1, -1], "random_order": True},
    "stiffness": {"plate": "edges", "E": 9.0e9, "joints": {"C_Sc": 1.0e-6}, "E_gradient": -1.2},
    "noise": {"height": 1.0e-5, "tilt": 1.0e-3, "piston": 5.0e-6, "reference_scans": 4},
}
INPUT = """[Wing]
file = {wing};
[Measurement]
file = bending.h5;
[Diagnose]
parameters = E, joint:C_Sc, joint:R4+5_r-m;
observations = 400;
refine = no;
starts = 1;
draws = 1000;
refits = 2;
validation = no;
intervals = no;
"""
EXIT_NAMED, EXIT_USER, EXIT_INSUFFICIENT = 10, 2, 20
SCHEMA = SOURCE / "docs/diagnosis.schema.json"


def synthesise(case, **changes):
    (case.folder / "case.json").write_text(json.dumps({**CASE, **changes}))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_measurement", "case.json", "-o", "bending.h5"],
                   cwd=case.folder, check=True, stdout=subprocess.DEVNULL)
    (case.folder / "diagnose.ini").write_text(INPUT.format(wing=CASE["wing"]))


def test_name(case):
    """One verdict on any number of ranks, and files that tell it."""
    synthesise(case)
    texts = []
    for ranks in 1, 2:
        done = case.run("diagnose.ini", ranks=ranks, code=EXIT_NAMED, timeout=300)
        check(len(done.out.splitlines()) <= 15, "at most 15 lines on the terminal")
        texts.append((case.folder / "diagnosis.json").read_text())
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


def test_few(case):
    """Fewer heights than unknowns: a plan is made, and a diagnosis says that it cannot test anything."""
    synthesise(case, loads=CASE["loads"][1:2], spacing=2e-3, protocol={"levels": [1]})
    (case.folder / "diagnose.ini").write_text(INPUT.format(wing=CASE["wing"]).replace("joint:C_Sc, joint:R4+5_r-m", "joint:*"))
    plan = case.run("diagnose.ini", "--plan", code=EXIT_OK)
    done = case.run("diagnose.ini", code=EXIT_INSUFFICIENT)
    for name in "diagnosis_plan", "diagnosis":
        found = json.loads((case.folder / f"{name}.json").read_text())
        check(not validate(found, SCHEMA), f"{name}.json is what the schema says: {validate(found, SCHEMA)}")
        words = {effect["name"]: effect["status"] for effect in found["effects"]}
        check(words["creep"] == "not_testable", "every entry of the catalogue is told")
    check(found["verdict"]["grade"] == "" and "too few" in done.out, done.out)
    planned = json.loads((case.folder / "diagnosis_plan.json").read_text())["effects"]
    told = [e for e in planned if e["status"] == "tested"]
    check(told and all(e["name"] in plan.out and e["detectable"] > 0 for e in told), "the plan is the one on the terminal")


def test_mistakes(case):
    """Unknown keys are named with the nearest one."""
    (case.folder / "wrong.ini").write_text(INPUT.format(wing=CASE["wing"]) + "drows = 5;\n")
    done = case.run("wrong.ini", ranks=1, code=EXIT_USER)
    check("drows" in done.err and "draws" in done.err, done.err)
    (case.folder / "bending.h5").write_bytes((SOURCE / "wings/calliphora_small.h5").read_bytes())
    (case.folder / "over.ini").write_text(INPUT.format(wing=CASE["wing"]) + "[Saving]\nname = bending;\n")
    done = case.run("over.ini", ranks=1, code=EXIT_USER)
    check("would be overwritten" in done.err, done.err)


main(globals())
