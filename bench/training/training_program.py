#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs one training of the paper's validation: E and ten joints from ten loads on a measurement without noise from the same
mesh and model, from a random start. The last line is JSON.

usage: training_program.py BUILD [--wing FILE] [--seed N] [--ranks N] [--folder DIR] [--set SECTION.KEY=VALUE ...]

A joint is identifiable if its stiffness is predicted to be known to 1e-3 (sd of the logarithm) at the declared error of
1 nm; all ten are printed.
"""
import argparse
import json
import math
import os
import re
import resource
import subprocess
import sys
import time
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
TRUTH = {"E": 8e9, "joint:R4+5_base": 3e-5, "joint:R1_Rs": 2e-4, "joint:A1+CuA2_CuA2": 8e-5, "joint:C_Sc": 4e-4,
         "joint:C_h": 1e-3, "joint:CuA1_base": 2e-5, "joint:M1+2_bend": 6e-5, "joint:M1+2_bm-cu": 1.5e-4,
         "joint:R2+3_base": 5e-5, "joint:R4+5_r-m": 1e-5}
SIGMA = 1e-9     # m
LIMIT = 1e-3     # sd of the logarithm of an identifiable joint
FORCE = 0.25     # of the forces of ini/static.ini, so that no load snaps


def write_input(folder, sections, changes, name="train.ini"):
    """Writes an input of this name into the folder, with changes of the form SECTION.KEY=VALUE."""
    for change in changes:
        place, value = change.split("=", 1)
        section, key = place.split(".")
        sections.setdefault(section, {})[key] = value
    (folder / name).write_text("".join(f"[{section}]\n" + "".join(f"{k} = {v};\n" for k, v in keys.items())
                                       for section, keys in sections.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("--wing", type=Path, default=SOURCE / "wings/calliphora.h5")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=Path("runs/training"))
    parser.add_argument("--set", dest="changes", action="append", default=[])
    options = parser.parse_args()
    folder = options.folder / f"seed{options.seed}"
    folder.mkdir(parents=True, exist_ok=True)
    build = options.build.resolve()
    words = [str(word) for pair in {**TRUTH, "force": FORCE}.items() for word in pair]
    subprocess.run([build / "tests/bin/write_replicate", options.wing.resolve(), folder / "replicate.h5", "10", str(SIGMA), "46",
                    "21", *words], check=True)
    sections = {"Wing": {"file": options.wing.resolve()}, "Measurement": {"file": "replicate.h5"},
                "Train": {"parameters": "E, joint:*", "seed": options.seed}, "Polish": {"intervals": "no"}}
    write_input(folder, sections, options.changes)
    begun = time.monotonic()
    done = subprocess.run(["mpirun", "-n", str(options.ranks), build / "bin/msm_train", "train.ini",
                           "--overwrite"], cwd=folder, stdout=subprocess.PIPE, text=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
    wall = time.monotonic() - begun
    print(done.stdout, end="")
    if done.returncode != 0:
        sys.exit(done.returncode)
    text = (folder / "trained.ini").read_text()
    errors, identifiable = {}, []
    for name, value in TRUTH.items():
        pattern = r"\nE = (\S+);" if name == "E" else re.escape(name) + r" ([^,;\s]+)[,;]"
        errors[name] = abs(math.log(float(re.search(pattern, text).group(1)) / value))
        found = re.search(r"; " + re.escape(name) + r": .*predicted sd of the logarithm +(\S+)", text)
        sd = float(found.group(1)) if found else math.nan
        print(f"{name:24} relative error {errors[name]:9.2e}   predicted sd {sd:9.2e}")
        if name != "E" and sd <= LIMIT:
            identifiable.append(name)
    print(json.dumps({
        "evaluations": int(re.search(r"\nevaluations (\d+) in all", done.stdout).group(1)),
        "E_rel": errors["E"], "joints_rel_max_identifiable": max((errors[n] for n in identifiable), default=math.nan),
        "identifiable": len(identifiable), "h": float(re.search(r"; h = +(\S+) m", text).group(1)),
        "cpu_s": round(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime, 1), "wall_s": round(wall, 1)}))


if __name__ == "__main__":
    main()
