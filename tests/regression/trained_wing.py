#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shipped case of training, ini/train.json and ini/train.ini, on the small wing and three of its loads: the measurement of
a program that shares nothing with the solver fits, and trained.ini is the same wing in flusi, msm_train and msm_diagnose.

The measured wing is smaller and broader than the file that is trained: [Wing] length and mean_chord say how large it is. They are
a part of trained.ini, and every use of it counts them.

usage: trained_wing.py <msm_train> <h5dump> <flusi> <msm_diagnose> [tests]
"""
import json
import math
import re
import shutil
import subprocess
import sys

import h5py
import numpy as np
from whole_program import EXIT_USER, SOURCE, Case, check, main, no_crash

from flusi_msm.measurement.scan import scan

FLUSI, MSM_DIAGNOSE = sys.argv.pop(3), sys.argv.pop(3)
WING = SOURCE / "wings/calliphora_small.h5"
TURNED = "turned.h5"  # the same wing, of which its file says that z points to the dorsal side
SIZED = "sized.h5"  # the same wing at the size of the experiment
SMALLER, BROADER = 0.96, 1.06  # factors of lengths and diameters, and then of y
LOADS = (2, 3, 6)  # of ten; they leave some joints open
SHIPPED = json.loads((SOURCE / "ini/train.json").read_text())
VERDICTS = (0, 10, 11, 12)
TRAINED = """[Wing]
z_side = right dorsal;
E = 7.123e9; Pa
D = 2e-7; N m
cross_springs = no;
parameters = diameter_exponent 4.0, k_vein 100000.0, joint:C_Sc 2.96e-4; N m/rad of joints, N/m of springs, factors
"""
STATIC = """[include]
file = trained.ini;
[Wing]
file = {wing};
[Loads]
forces = (/ {forces} /);
[Saving]
name = static;
shapes = yes;
"""
DIAGNOSE = """[include]
file = trained.ini;
[Wing]
file = {wing};
[Measurement]
file = measurement.h5;
[Diagnose]
parameters = E;
observations = 20000;
refine = no;
noise = declared;
starts = 1;
draws = 1000;
refits = 1;
validation = no;
intervals = no;
"""


def changed(text, **lines):
    """`text` with other values of the keys `lines`, each of which must be there once."""
    for key, value in lines.items():
        text, n = re.subn(rf"^{key} = [^;]*;", f"{key} = {value};", text, flags=re.M)
        check(n == 1, f"ini/train.ini has the key {key} once")
    return text


def write_turned(case):
    shutil.copy(WING, case.folder / TURNED)
    with h5py.File(case.folder / TURNED, "r+") as file:
        file.attrs["z_side"] = "right dorsal"


def area_over_length(points, triangles):
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return (ux * vy - uy * vx).sum() / 2 / np.ptp(points[:, 0])


def write_sized(case):
    """The wing as it is measured; its length and mean chord [m]."""
    shutil.copy(WING, case.folder / SIZED)
    with h5py.File(case.folder / SIZED, "r+") as file:
        points = file["points"][:] * SMALLER
        points[:, 1] *= BROADER
        file["points"][:] = points
        for vein in file["veins"].values():
            vein["diameters"][:] *= SMALLER
        return points[:, 0].max(), area_over_length(points, file["triangles"][:] - int(np.ravel(file.attrs["index_base"])[0]))


def measure(case):
    """measurement.h5 from the shipped description."""
    loads = [SHIPPED["loads"][k] for k in LOADS]
    # The path of the wing is seen from the folder of the description.
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_measurement", SOURCE / "ini/train.json", "-o",
                    "measurement.h5", "--set", f"wing={case.folder / SIZED}", "--set", f"loads={loads}", "--set", "spacing=5e-4"],
                   cwd=case.folder, check=True, stdout=subprocess.DEVNULL)


def train(case):
    """The shipped training with one generation of search, and without intervals."""
    text = (SOURCE / "ini/train.ini").read_text()
    check("file = ../wings/calliphora.h5;" in text, "ini/train.ini names the wing of the blowfly")
    write_turned(case)
    length, chord = write_sized(case)
    measure(case)
    text = text.replace("file = ../wings/calliphora.h5;", f"file = {TURNED};\nlength = {float(length)!r};\nmean_chord = {float(chord)!r};")
    text = changed(text, restarts="none; \nmax_generations = 1", intervals="no")
    case.write("train.ini", text)
    return case.run("train.ini", ranks=0, timeout=300)


def number(pattern, text):
    found = re.search(pattern, text)
    check(found is not None, f"'{pattern}' is told:\n{text}")
    return float(found.group(1))


def told_by_training(case):
    """h [m], chi^2, E and its sd (ln), and for every load x, y, measured and computed deformation [m]."""
    with h5py.File(case.folder / "train_history.h5") as file:
        outcome = file["outcome"].attrs
        loads = {name: (np.ravel(made.attrs["point"]), float(np.ravel(made.attrs["force"])[0]), made[:])
                 for name, made in sorted(file["loads"].items())}
        return (*(float(np.ravel(outcome[key])[0]) for key in ("h", "chi2", "values", "sd")), loads)


def heights_of_static(case, loads):
    """Deformations [m] at the places of the heights, from the shapes of flusi --static."""
    with h5py.File(case.folder / "measurement.h5") as file:
        x, y = file["reference/x"][:], file["reference/y"][:]
    forces = "\n".join(" ".join(repr(float(v)) for v in (*point, force)) for point, force, _ in loads.values())
    case.write("static.ini", STATIC.format(wing=WING, forces=forces))
    flusi = Case(FLUSI, case.h5dump, case.folder / "static")
    for name in ("static.ini", "trained.ini"):
        (flusi.folder / name).write_text((case.folder / name).read_text())
    flusi.run("--static", "static.ini", ranks=0)
    found = []
    for number_of_load, (_, _, rows) in enumerate(loads.values(), 1):
        with h5py.File(flusi.folder / f"static_{number_of_load:02d}.h5") as file:
            points, u, triangles = file["points"][:], file["displacement"][:], file["triangles"][:]
        model = scan(points, triangles, x, y) - scan(points - u, triangles, x, y)
        i, j = (np.abs(axis[None, :] - rows[:, k:k + 1]).argmin(1) for k, axis in enumerate((x, y)))
        found.append(model[j, i])
    return found


def squares_with_shared_scan(case, loads):
    """chi^2 of what msm_train leaves if the unloaded scan of every place, with the sd of the others, is subtracted from all
    loads: of n differences r of one place the covariance is sigma^2 (1 + ones)."""
    with h5py.File(case.folder / "measurement.h5") as file:
        sigma = float(np.ravel(file["accuracy"].attrs["height"])[0])
    places = {}
    for _, _, rows in loads.values():
        for x, y, measured, computed in rows:
            places.setdefault((x, y), []).append(computed - measured)
    return sum(r @ np.linalg.solve(sigma**2 * (np.eye(len(r)) + 1), r) for r in map(np.array, places.values()))


def refuse_other_wing(case, diagnose):
    """What was found for the small wing, by training and by diagnosis, is refused with the fine mesh of the same wing, and with the same
    mesh with a thicker vein, by all three programs; allow_other_wing takes it with a notice. The size is the user's."""
    shutil.copy(diagnose.folder / "diagnosis_baseline.ini", case.folder / "diagnosed.ini")
    fine = SOURCE / "wings/calliphora.h5"
    thick = case.folder / "thick.h5"
    shutil.copy(WING, thick)
    with h5py.File(thick, "r+") as file:
        file["veins/C/diameters"][0] *= 1.01
    inputs = {FLUSI: ("--static", (case.folder / "static.ini").read_text()), case.program: ("", (case.folder / "train.ini").read_text()),
              MSM_DIAGNOSE: ("", (diagnose.folder / "diagnose.ini").read_text())}
    for program, (mode, text) in inputs.items():
        user = Case(program, case.h5dump, case.folder / "other")
        shutil.copy(case.folder / "measurement.h5", user.folder)
        shutil.copy(case.folder / TURNED, user.folder)
        for found in "trained.ini", "diagnosed.ini":
            shutil.copy(case.folder / found, user.folder)
            text = re.sub(r"\[include\]\nfile = [^;\n]*;?\n", "", text)
            text = re.sub(r"^\[Wing\]\n", "[include]\nfile = " + found + ";\n[Wing]\n", text, count=1, flags=re.M)
            text = re.sub(r"^(result = )[^;]*;", r"\1new.ini;", text, flags=re.M)
            own = re.sub(r"^file = \S*(?:turned|calliphora)\S*;", f"file = {WING};", text, flags=re.M)
            check(str(WING) in own and found in own, own)
            arguments = [mode] if mode else []
            user.write("run.ini", own)
            done = user.run(*arguments, "run.ini", "--check", ranks=0)
            check("found for another wing" not in done.out + done.err, f"{found} is for this wing:\n{done.out}{done.err}")
            user.write("run.ini", re.sub(r"^(length|mean_chord) = .*\n", "", own, flags=re.M).replace("[Wing]\n", "[Wing]\nlength = 9.1e-3;\n", 1))
            user.run(*arguments, "run.ini", "--check", ranks=0)
            for other in (own.replace(str(WING), str(fine)), own.replace(str(WING), str(thick))):
                user.write("run.ini", other)
                done = user.run(*arguments, "run.ini", "--check", ranks=0, code=EXIT_USER)
                check(re.search(rf"{found}:\d+: \[Wing\] fingerprint: these values were found for another wing", done.err),
                      f"{program} refuses {found}:\n{done.out}{done.err}")
                user.write("run.ini", other.replace("[Wing]\n", "[Wing]\nallow_other_wing = yes;\n", 1))
                done = user.flusi(*arguments, "run.ini", "--check")
                told = done.out + done.err
                check("allow_other_wing = yes accepts them nevertheless" in told and "give the wing file" not in told, told)
    user.write("run.ini", own.replace("[Wing]\n", "[Wing]\nfingerprint = 12;\n", 1))
    done = user.run("run.ini", "--check", ranks=0, code=EXIT_USER)
    check("'12' is no fingerprint: valid are the 16 digits" in done.err, done.err)


def test_shipped(case):
    """Data of other mechanics under the same law fit within their errors, and every program sees the trained wing."""
    done = train(case)
    h, chi2, young, sd, loads = told_by_training(case)
    fragment = (case.folder / "trained.ini").read_text()
    check("\nz_side = right dorsal;\n" in fragment, "the side of +z is that of the wing file")
    size = [number(f"(?m)^{key} = ([^;\\s]+)", fragment) for key in ("length", "mean_chord")]
    told = [float(v) for v in re.search("(?m)^found_size = ([^;]+);", fragment).group(1).split()]
    check(np.allclose(size, told, rtol=1e-12) and size[0] < 8.8e-3, f"the size of the wing is told: {fragment}")
    n = sum(len(rows) for _, _, rows in loads.values())
    check(len(loads) == len(LOADS) and n > 300, f"{n} heights")
    # chi^2 has the mean n and the variance 2 n; 11 parameters take at most 11 of it.
    check(abs(chi2 - n) < 3 * math.sqrt(2 * n) + 11, f"it fits: chi^2 = {chi2} of {n}")
    check("does not fit" not in done.out, f"and that is not denied:\n{done.out}")
    truth = SHIPPED["stiffness"]["E"]
    check(abs(math.log(young / truth)) < 4 * sd < 0.1, f"E is {truth} within its errors, not {young}, {sd}")

    # flusi solves the same equations on the same path, from numbers with all their digits: rounding, which the path may
    # multiply by the condition of its tangents, 1e7 at most.
    worst, squares = 0, 0
    for (_, _, rows), model in zip(loads.values(), heights_of_static(case, loads)):
        worst = max(worst, np.abs(model - rows[:, 3]).max() / np.abs(rows[:, 3]).max())
        squares += ((model - rows[:, 2])**2).mean()
    print(f"heights of flusi --static differ by {worst:.1e} of the largest")
    check(worst < 1e-9, f"flusi --static has the heights of msm_train: {worst}")
    check(abs(math.sqrt(squares) / h - 1) < 1e-9, f"and its h: {math.sqrt(squares)}, {h}")

    # msm_diagnose begins at the trained wing and seeks E alone. It also knows that all loads share the errors of the one
    # unloaded scan, for which the trained E is not quite the best: the sum of squares falls by that of one parameter, by more
    # than 10.8 in one of a thousand cases.
    shared = squares_with_shared_scan(case, loads)
    case.write("diagnose.ini", DIAGNOSE.format(wing=WING))
    diagnose = Case(MSM_DIAGNOSE, case.h5dump, case.folder / "diagnose")
    for name in ("diagnose.ini", "trained.ini", "measurement.h5"):
        (diagnose.folder / name).write_bytes((case.folder / name).read_bytes())
    seen = diagnose.flusi("diagnose.ini", timeout=300)
    no_crash(seen)
    check(seen.code in VERDICTS, seen.err)
    baseline = json.loads((diagnose.folder / "diagnosis.json").read_text())["baseline"]
    check(baseline["observations"] == n, f"it counts the same {n} heights, not {baseline['observations']}")
    gain = shared - baseline["chi2"] - baseline["prior_chi2"]
    print(f"chi^2 of msm_train {chi2}, {shared} with one unloaded scan; of msm_diagnose {baseline['chi2']}")
    check(-1e-6 * shared < gain < 10.8, f"msm_diagnose begins where msm_train ends: {gain}")
    values = {one["name"]: one["value"] for one in baseline["parameters"]}
    check(abs(math.log(values["E"] / young)) < 4 * sd, f"with its E: {values['E']}, {young}")
    check("\nz_side = right dorsal;\n" in (diagnose.folder / "diagnosis_baseline.ini").read_text(),
          "and with the side of +z that the trained wing says, not its file")

    refuse_other_wing(case, diagnose)

    # A load that was pressed elsewhere is another measurement, for which the checkpoint of this one is not.
    with h5py.File(case.folder / "measurement.h5", "r+") as file:
        first = file["loads"][sorted(file["loads"])[0]]
        first.attrs["point"] = np.ravel(first.attrs["point"]) + [1e-5, 0]
    done = case.run("train.ini", "--restart", ranks=0, code=EXIT_USER)
    check("does not fit this input" in done.err, f"its checkpoint is refused:\n{done.err}")


def test_flight(case):
    """The wing that a training writes is one that flusi flies: ini/wing.ini with it in the place of its own material."""
    text = (SOURCE / "ini/wing.ini").read_text().replace("from_file::", f"from_file::{SOURCE}/ini/")
    text = re.sub(r"^file = .*", f"file = {WING}", text, flags=re.M)
    text, found = re.subn(r"^preset = paper.*\n", "", text, flags=re.M)
    check(found == 1, "ini/wing.ini has its material from the preset of the paper")
    flusi = Case(FLUSI, case.h5dump, case.folder / "flight")
    flusi.write("fly.ini", text + "\n[include]\nfile = trained.ini\n")
    flusi.write("trained.ini", TRAINED.replace("E = 7", "found_size = 9.9e-3 2.7e-3; m\nlength = 9.9e-3; m\nmean_chord = 2.7e-3; m\nE = 7"))
    done = flusi.run("fly.ini", "--dry-run", ranks=0)
    check("E =  7.123E+09 Pa" in done.out, f"the trained E is flown:\n{done.out}")
    check("R = 1.0000" in done.out and "found for a wing of length 9.9 mm and mean chord 2.7 mm, but this wing has 9.0 mm and" in done.out + done.err,
          f"ini/wing.ini has a size of its own, and that is said:\n{done.out}{done.err}")
    text, found = re.subn(r"(?m)^length = 9.0e-3;.*\n", "", text)
    text, more = re.subn(r"(?m)^mean_chord = .*\n", "", text)
    check(found + more == 2, "ini/wing.ini has the size of its wing")
    flusi.write("fly.ini", text + "\n[include]\nfile = trained.ini\n")
    done = flusi.run("fly.ini", "--dry-run", ranks=0)
    check("R = 1.1000, mean chord .3000" in done.out and "found for" not in done.out + done.err, f"without one the trained size counts:\n{done.out}{done.err}")
    check("+z of [Wing] is the dorsal side" in done.out, f"with the side that it was trained for:\n{done.out}")
    write_turned(flusi)
    sides = {"right dorsal": ("dorsal", 0), "left dorsal": ("dorsal", 0), "left ventral": ("ventral", 1), "file": ("dorsal", 0)}
    for stated, (side, notices) in sides.items():
        flusi.write("trained.ini", TRAINED.replace("right dorsal", stated))
        flusi.write("fly.ini", text.replace(str(WING), TURNED) + "\n[include]\nfile = trained.ini\n")
        done = flusi.run("fly.ini", "--dry-run", ranks=0)
        check(f"+z of [Wing] is the {side} side" in done.out, f"{stated}:\n{done.out}")
        check((done.out + done.err).count(f"[Wing] z_side: left ventral replaces right dorsal of {TURNED}") == notices,
              f"{stated}:\n{done.err}")


main(globals())
