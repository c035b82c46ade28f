# SPDX-License-Identifier: GPL-3.0-or-later
"""Bending tests of the small wing for tests of msm_diagnose: made by tools/make_measurement, joined, diagnosed."""
import json
import subprocess
import sys

import h5py
from whole_program import MOST_LINES, SOURCE, check

WING = str(SOURCE / "wings/calliphora_small.h5")
BENDING = {
    "wing": WING, "seed": 5, "spacing": 6e-4,
    "loads": [[0.00405, 0.00066, 2.0e-3], [0.00541, 0.00005, 6.0e-4], [0.00721, -0.00032, 1.6e-4],
              [0.00856, -0.00078, 1.0e-4]],
    "protocol": {"levels": [0.5, 1, -1], "random_order": True}, "noise": {"height": 1.0e-5, "reference_scans": 4},
}
ADEQUATE, NAMED, SET, UNKNOWN = 0, 10, 11, 12


def measure(case, file, **sections):
    """A measurement with these sections added to those of BENDING."""
    test = {**BENDING}
    for name, content in sections.items():
        test[name] = {**test.get(name, {}), **content} if isinstance(content, dict) else content
    (case.folder / "case.json").write_text(json.dumps(test))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_measurement", "case.json", "-o", file], cwd=case.folder,
                   check=True, stdout=subprocess.DEVNULL)


def seal(path):
    """Seals a measurement file that was changed."""
    subprocess.run([sys.executable, "-B", SOURCE / "tools/seal", path], check=True, stdout=subprocess.DEVNULL)


def append_loads(case, file, other, interval=120.0):
    """The loads of another measurement, done after those of `file`."""
    with h5py.File(case.folder / file, "r+") as first, h5py.File(case.folder / other) as second:
        n = len(first["loads"])
        for name in second["loads"]:
            second.copy(f"loads/{name}", first["loads"], name=f"{name}_later")
            facts = first[f"loads/{name}_later"].attrs
            facts["order"] = facts["order"] + n
            facts["time"] = facts["time"] + n * interval
            facts["replicate"] = facts["replicate"] + 1


def diagnose(case, file, name, options, before="", parameters="E, joint:*", refine="no"):
    """Exit code and JSON of a diagnosis with these lines in [Diagnose], behind the sections `before`. Without a section [Next] no new
    modes and records are ranked, which takes half as long again."""
    if "[Next]" not in before + options:
        options += "[Next]\nmodes = 0;\n"
    text = f"""{before}[Wing]
file = {WING};
[Measurement]
file = {file};
[Diagnose]
parameters = {parameters};
refine = {refine};
{options}[Saving]
name = {name};
"""
    done = case.flusi(case.write(f"{name}.ini", text), "--exit-code", timeout=300)
    check(done.code in (ADEQUATE, NAMED, SET, UNKNOWN), done.err)
    check(len((done.out + done.err).splitlines()) <= MOST_LINES, f"at most {MOST_LINES} lines on the terminal: {done.out}{done.err}")
    found = json.loads((case.folder / f"{name}.json").read_text())
    print(f"    {name}: {done.code} {found['verdict']['sentence']}", flush=True)
    return done.code, found
