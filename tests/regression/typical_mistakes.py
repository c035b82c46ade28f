# SPDX-License-Identifier: GPL-3.0-or-later
"""Typical mistakes, and what the programs answer: each is made here, and docs/guide/mistakes.md has the answers to the letter.

usage: typical_mistakes.py <folder of the programs> [--write]

With --write the page is written anew.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Optional, Tuple

import h5py
import whole_program
from whole_program import SOURCE

PROGRAMS = Path(sys.argv[1])
PAGE = SOURCE / "docs/guide/mistakes.md"
FLY, TRAIN, STATIC = "flusi fly.ini --check", "msm_train train.ini --check", "flusi --static static.ini --check"
SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 1000 500">
<path id="outline" d="M 100,200 L 500,100 L 900,250 L 500,400 L 100,300 Z"/>
<path id="root" d="M 100,200 L 100,300"/>
<path id="front" style="stroke-width:8" d="M 100,220 L 500,150 L 893,250"/>
<path id="scale 1 mm" d="M 100,450 h 100"/>
</svg>
"""
INTRODUCTION = """# Typical mistakes

This page shows what the programs and tools answer to typical mistakes. The test `typical_mistakes` makes each of them and compares the
answers with this page to the letter. If there is a mistake, a program lists all mistakes of the input at once and ends with exit code 2. It
has then computed and overwritten nothing. If a number is possible but improbable, the program prints a notice and continues. Answers are
shortened at `...`.
"""


@dataclass(frozen=True)
class Mistake:
    """A change of the files in the folder (arguments: file, what is replaced, by what, or a function), and the command."""
    what: str
    command: str
    changes: Tuple[Tuple, ...] = ()
    before: Optional[Callable] = None
    code: int = 2


def change(old, new, file="fly.ini"):
    return ((file, old, new),)


def thousandfold(folder, names):
    """bending.h5 with the datasets of these names times 1000."""
    with h5py.File(folder / "bending.h5", "r+") as file:
        found = []
        file.visititems(lambda name, item: found.append(item) if name.split("/")[-1] in names else None)
        for item in found:
            item[...] *= 1e3
    run("seal bending.h5", folder)


def to_millimetres(folder):
    thousandfold(folder, ("x", "y"))


def heights_to_millimetres(folder):
    thousandfold(folder, ("z",))


def forces_to_millinewtons(folder):
    with h5py.File(folder / "bending.h5", "r+") as file:
        for load in file["loads"].values():
            load.attrs["force"] = load.attrs["force"] * 1e3
    run("seal bending.h5", folder)


def in_wing(folder, dataset, place, value):
    """wing.h5 with another value at a place of a dataset."""
    with h5py.File(folder / "wing.h5", "r+") as file:
        file[dataset][place] = value(file[dataset][place]) if callable(value) else value
    run("seal wing.h5", folder)


def missing_corner(folder):
    in_wing(folder, "triangles", (3, 0), 9999)


def diameters_to_micrometres(folder):
    in_wing(folder, "veins/C/diameters", slice(None), lambda diameters: diameters * 1e6)


def points_to_millimetres(folder):
    in_wing(folder, "points", slice(None), lambda points: points * 1e3)


def sd_to_micrometres(folder):
    with h5py.File(folder / "bending.h5", "r+") as file:
        file["accuracy"].attrs["height"] = 10.0
    run("seal bending.h5", folder)


def earlier_run(folder):
    run("flusi fly.ini", folder)
    (folder / "fly2.ini").write_text((folder / "fly.ini").read_text())


MISTAKES = (
    Mistake("a key is misspelt", FLY, change("CFL =", "CLF =")),
    Mistake("a section is misspelt", FLY, change("[Penalization]", "[Penalisation]")),
    Mistake("a key stands in the wrong section", FLY, change("[ReynoldsNumber]\n", "[ReynoldsNumber]\nxl = 4.0;\n")),
    Mistake("a key stands twice", FLY, change("nx = 16", "nx = 16;\nnx = 32")),
    Mistake("a decimal comma", FLY, change("nu = 0.005", "nu = 0,005")),
    Mistake("a grid that the transform does not take", FLY, change("nx = 16", "nx = 17")),
    Mistake("a choice that does not exist", FLY, change("inicond = quiescent", "inicond = quiet")),
    Mistake("the wing file is not there", FLY, change("wing.h5", "wings.h5")),
    Mistake("the kinematics file is not there", FLY, change("kinematics/calliphora.ini", "kinematics/bee.ini")),
    Mistake("a measurement in place of a wing", FLY, change("file = wing.h5", "file = bending.h5")),
    Mistake("a triangle of the wing file names a point that is not there", FLY, before=missing_corner),
    Mistake("the wing file has its points in mm", FLY, before=points_to_millimetres),
    Mistake("the wing file has diameters in um", FLY, before=diameters_to_micrometres),
    Mistake("an input of another program", "flusi train.ini --check"),
    Mistake("the input of a flight for training", "msm_train fly.ini --check"),
    Mistake("the input of a training for diagnosis", "msm_diagnose train.ini --check"),
    Mistake("the trained wing as an input", "flusi trained.ini --check"),
    Mistake("a wing file as an input", "flusi wing.h5 --check"),
    Mistake("a drawing as an input", "msm_train drawing.svg --check"),
    Mistake("a motion of wings as an input", "flusi kinematics/calliphora.ini --check"),
    Mistake("the hinge lies outside the box", FLY, change("x0 = 2.0 2.0 1.0", "x0 = 2.0 2.0 5.0")),
    Mistake("a box that is too flat for the wings", FLY, change("zl = 2.0", "zl = 1.2")),
    Mistake("E in GPa", FLY, change("E = 12000000000.0", "E = 12.0"), code=0),
    Mistake("the length of the wing in mm", FLY, change("file = wing.h5", "file = wing.h5;\nlength = 9")),
    Mistake("the unit of length in mm", FLY, change("length = 0.009", "length = 9")),
    Mistake("a mass in ug", FLY, change("[Saving]\n", "[Mass]\nmembrane_mass = 81;\n[Saving]\n"), code=0),
    Mistake("a viscosity in m^2/s among numbers without dimension", FLY, change("nu = 0.005", "nu = 1.5e-5"), code=0),
    Mistake("a unit behind a number", FLY, change("length = 0.009", "length = 9 mm")),
    Mistake("wings without thickness, and a method of time that they do not take", FLY,
            (*change("CFL = 0.45", "CFL = 0.45;\niTimeMethodFluid = RK4"),
             *change("wings = flexible", "wings = flexible;\nsurface = thin"))),
    Mistake("the input does not exist", "flusi flight.ini --check"),
    Mistake("no input is named", "flusi"),
    Mistake("an option is misspelt", "flusi fly.ini --dryrun"),
    Mistake("nothing to go on from", "flusi fly.ini --restart"),
    Mistake("the folder holds another run", "flusi fly2.ini", before=earlier_run),
    Mistake("the load is applied beside the wing", STATIC, change("at:0.005:0.0", "at:5:0.0", "static.ini")),
    Mistake("the vein has another name", STATIC, change("at:0.005:0.0", "vein:M3:last", "static.ini")),
    Mistake("the measurement is not there", TRAIN, change("bending.h5", "bendings.h5", "train.ini")),
    Mistake("a joint that the wing does not have", TRAIN, change("joint:C_Sc", "joint:C_Sd", "train.ini")),
    Mistake("the box of a parameter is upside down", TRAIN, change("E, joint:C_Sc", "E 5e10 1e9 log", "train.ini")),
    Mistake("the bounds of E in MPa", TRAIN, change("E, joint:C_Sc", "E 1e3 1e5 log", "train.ini"), code=0),
    Mistake("the maps of heights have their axes in mm", TRAIN, before=to_millimetres),
    Mistake("heights in mm", TRAIN, before=heights_to_millimetres),
    Mistake("the sd of heights in um", TRAIN, before=sd_to_micrometres),
    Mistake("forces in mN", TRAIN, before=forces_to_millinewtons),
    Mistake("a wing in place of a measurement", TRAIN, change("file = bending.h5", "file = wing.h5", "train.ini")),
    Mistake("a misspelt key of the diagnosis", "msm_diagnose diagnose.ini --check", change("starts", "start", "diagnose.ini")),
    Mistake("a flight that the diagnosis does not need", "msm_diagnose diagnose.ini --check",
            change("[Diagnose]", "[Flight]\nfile = fly.ini;\n[Diagnose]", "diagnose.ini"), code=0),
    Mistake("a folder in place of a diagnosis", "plot_diagnosis ."),
    Mistake("the outline is open", "make_wing drawing.svg -o new.h5", change(" Z\"", "\"", "drawing.svg")),
    Mistake("the drawing has no scale", "make_wing drawing.svg -o new.h5", change("scale 1 mm", "bar", "drawing.svg")),
    Mistake("the drawing has no root", "make_wing drawing.svg -o new.h5", change("root", "base", "drawing.svg")),
    Mistake("a vein ends in the air", "make_wing drawing.svg -o new.h5", change("893,250", "700,220", "drawing.svg")),
    Mistake("pictures of a folder without a run", "plot_cycle ."),
    Mistake("the report of something else", "plot_training wing.h5"),
)


def ini_text(ini):
    return whole_program.ini_text(ini).replace("=", " = ")


def flight():
    motion = "from_file::kinematics/calliphora.ini"
    return ini_text({
        "units": {"length": 9e-3, "frequency": 158, "density": 1.225},
        "Resolution": {"nx": 16, "ny": 16, "nz": 8}, "Geometry": {"xl": 4.0, "yl": 4.0, "zl": 2.0},
        "Time": {"nt": 1, "CFL": 0.45}, "ReynoldsNumber": {"nu": 5e-3}, "InitialCondition": {"inicond": "quiescent"},
        "Penalization": {"iPenalization": 1, "iMask": "Insect", "eps": 5e-3},
        "Insects": {"wings": "flexible", "x0": "2.0 2.0 1.0", "yawpitchroll_0": "180.0 0.0 0.0", "eta0": -70.0,
                    "x_pivot_l": "0.0 0.5 0.0", "x_pivot_r": "0.0 -0.5 0.0", "wing_ramp": 0.05,
                    "FlappingMotion_left": motion, "FlappingMotion_right": motion},
        "Wing": {"file": "wing.h5", "E": 12e9, "D": 2e-7}, "Saving": {"tintegral": 4e-3, "tsave": 1.0}})


def prepare(folder):
    """Inputs without a mistake."""
    shutil.copy(SOURCE / "wings/calliphora_small.h5", folder / "wing.h5")
    shutil.copytree(SOURCE / "ini/kinematics", folder / "kinematics")
    (folder / "fly.ini").write_text(flight())
    (folder / "static.ini").write_text(ini_text({"Wing": {"file": "wing.h5", "E": 12e9, "D": 2e-7},
                                                 "Loads": {"named_forces": "at:0.005:0.0 0 0 1e-4"}}))
    model = {"Wing": {"file": "wing.h5", "E": 12e9, "D": 2e-7}, "Measurement": {"file": "bending.h5"}}
    (folder / "train.ini").write_text(ini_text({**model, "Train": {"parameters": "E, joint:C_Sc"}}))
    (folder / "diagnose.ini").write_text(ini_text({**model, "Diagnose": {"parameters": "E", "starts": 1}}))
    (folder / "trained.ini").write_text(ini_text({"Wing": {"E": 12e9, "D": 2e-7}}))
    (folder / "drawing.svg").write_text(SVG)
    (folder / "case.json").write_text('{"wing": "wing.h5", "loads": [[0.0054, 0.0, 1e-4]], "spacing": 4e-4}')
    done = run("make_measurement case.json -o bending.h5 --quiet", folder)
    assert done.returncode == 0, done.stdout


def confused_programs(folder):
    """What is wrong where each program gets the input of each other one."""
    shutil.copy(SOURCE / "ini/solid.ini", folder)
    inputs = {"flusi": "fly.ini", "flusi --static": "static.ini", "flusi --solid": "solid.ini", "msm_train": "train.ini",
              "msm_diagnose": "diagnose.ini"}
    for program in inputs:
        for owner, ini in inputs.items():
            done = run(f"{program} {ini} --check", folder)
            message = f"this is an input of {owner}, and not of {program}; run: "
            # Loads are what --static and --solid have both.
            if owner != program and (program, owner) != ("flusi --solid", "flusi --static") and \
                    (done.returncode != 2 or message not in done.stdout or done.stdout.count("\n") != 1 or not done.stdout.endswith(f" {ini}\n")):
                yield f"{program} {ini}: {done.stdout}"


def run(command, folder):
    words = command.split()
    if words[0] in ("flusi", "msm_train", "msm_diagnose"):
        words[0] = str(PROGRAMS / words[0])
    else:
        words = [sys.executable, "-B", str(SOURCE / "tools" / words[0]), *words[1:]]
    return subprocess.run(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300,
                          env={**os.environ, "COLUMNS": "100"})


def answer(mistake, good):
    """What is printed, and the exit code, in a copy of the folder without mistakes."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "wing-work"
        shutil.copytree(good, folder)
        for file, old, new in mistake.changes:
            text = (folder / file).read_text()
            assert old in text, (mistake.what, old)
            (folder / file).write_text(text.replace(old, new, 1))
        if mistake.before:
            mistake.before(folder)
        done = run(mistake.command, folder)
        text = done.stdout.replace(str(folder) + "/", "").replace(str(folder), ".").replace(place, ".")
        text = re.sub(r"run [0-9A-F]{16} \((.*?), begun [\d: -]+\)", r"run 0123456789ABCDEF (\1, begun 2026-01-01 12:00:00)", text)
    return done.returncode, text


def shortened(text):
    """The lines that tell mistakes: those of the end, without what was printed before; 220 letters each."""
    lines = [line.rstrip() for line in text.strip().split("\n") if line.strip()]
    lines = [line if len(line) <= 220 else line[:217] + "..." for line in lines]
    return "\n".join(lines[:6] + (["..."] if len(lines) > 6 else []))


def page(answers):
    rows = "".join(f"\n| [{m.what}](#{anchor(m)}) | {gist(text)} |" for m, text in answers)
    parts = [INTRODUCTION, f"| mistake | answer |\n|---|---|{rows}\n"]
    for mistake, text in answers:
        change_told = "".join(f", `{old.strip()}` is `{new.strip()}`".replace("\n", " ") for _, old, new in mistake.changes)
        parts.append(f"## {mistake.what[0].upper() + mistake.what[1:]}\n\n`{mistake.command}`{change_told}:\n\n```text\n{text}\n```\n")
    return "\n".join(parts)


def gist(text):
    """The beginning of an answer, for a table."""
    line = text.split("\n")[0]
    return "`" + (line if len(line) <= 120 else line[:117] + "...").replace("|", "\\|") + "`"


def anchor(mistake):
    return re.sub(r"[^\w -]", "", mistake.what.lower()).replace(" ", "-")


def main():
    wrong = []
    with tempfile.TemporaryDirectory() as place:
        good = Path(place) / "good"
        good.mkdir()
        prepare(good)
        for command in (FLY, TRAIN, STATIC, "msm_diagnose diagnose.ini --check", "make_wing drawing.svg -o new.h5 --no-picture"):
            done = answer(Mistake("none", command), good)
            if done[0] != 0:
                wrong.append(f"without a mistake: {command}: {done[1]}")
        wrong += confused_programs(good)
        answers = []
        for mistake in MISTAKES:
            code, text = answer(mistake, good)
            answers.append((mistake, shortened(text)))
            if code != mistake.code:
                wrong.append(f"{mistake.what}: exit code {code}\n{shortened(text)}")
    text = page(answers)
    if "--write" in sys.argv:
        PAGE.write_text(text, encoding="utf-8")
    elif text != PAGE.read_text(encoding="utf-8"):
        told = PAGE.read_text(encoding="utf-8").split("\n## ")
        wrong += [f"docs/guide/mistakes.md has other answers (--write writes it anew):\n{part}"
                  for part in text.split("\n## ") if part not in told and part + "\n" not in told]
    print("\n".join(wrong) or f"pass  {len(MISTAKES)} mistakes are answered as the page says")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
