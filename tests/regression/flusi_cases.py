#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cases with wings in ini/: they are right, start, and are what they say.

usage: flusi_cases.py <flusi> <h5dump> [tests]
"""
import math
import re

from whole_program import EXIT_USER, SOURCE, check, main

INI = SOURCE / "ini"
# Table 1 of Truong et al.: R [mm], mean chord [mm], u_tip [m/s], u_inf [m/s], viscosity [1e-5 m^2/s]; Re = 1542.
TABLE = {1: (9.1, 3.037, 6.775, 1.365, 1.603), 2: (9.1, 3.037, 6.775, 1.365, 1.603), 3: (8.7, 2.903, 6.478, 1.305, 1.465),
         4: (9.1, 3.037, 6.775, 1.365, 1.603), 5: (8.7, 2.903, 6.478, 1.305, 1.465), 6: (9.2, 3.070, 6.850, 1.380, 1.638),
         7: (9.1, 3.037, 6.775, 1.365, 1.603), 8: (9.0, 3.004, 6.701, 1.350, 1.568), 9: (9.1, 3.037, 6.775, 1.365, 1.603)}
REYNOLDS = 1542.0
# Four printed digits of each factor: half a unit in the last place of u_tip + u_inf, chord and viscosity together.
TABLE_ERROR = 1e-3 / 8.1 + 0.5e-3 / 3.0 + 0.5e-3 / 1.5
SMALL = {"nx": 32, "ny": 32, "nz": 16, "nt": 3, "sponge_thickness": 4, "tsave": 1e9, "tintegral": 1e-9}


def settings(name):
    """{(section, key): value} of an ini file, without comments."""
    found, section = {}, ""
    for line in (INI / name).read_text().splitlines():
        line = line.split(";")[0].strip()
        if line.startswith("["):
            section = line
        elif line:
            key, value = line.split("=", 1)
            check((section, key.strip()) not in found, f"{name}: {key} once")
            found[section, key.strip()] = value.strip()
    return found


def replicate(case, name, **other):
    """A coarse replicate of a case that makes a few steps."""
    values, section = {**SMALL, **other}, ""
    lines = []
    for line in (INI / name).read_text().splitlines():
        key = re.match(r"(\w+)\s*=", line)
        if line.startswith("["):
            section = line.strip()
        if key and key.group(1) in values:
            line = f"{key.group(1)} = {values[key.group(1)]}"
        line = re.sub(r"(from_file|kinematics_loader)::", rf"\1::{(INI / name).parent}/", line)
        lines.append(re.sub(r"^file = ", f"file = {(INI / name).parent}/", line))
        if section == "[Time]" and line.startswith("["):
            lines.append(f"nt = {values['nt']}")
    case.write("replicate.ini", "\n".join(lines) + "\n")
    return case.run("replicate.ini")


def header(case, name):
    return case.run(str(INI / name), "--dry-run", ranks=0).out


def number(text, pattern):
    found = re.search(pattern + r"\s*([-+.\dE]+)", text)
    check(found, f"'{pattern}' is printed:\n{text}")
    return float(found.group(1))


def test_check(case):
    """No case has a mistake or an unused setting."""
    names = ["wing.ini", "wing-rigid.ini", "wing-1024.ini", "revolving.ini", "plate.ini", "flag.ini",
             "turek-hron.ini"]
    for name in names + [f"individuals/{n}.ini" for n in TABLE]:
        done = case.run(str(INI / name), "--check", ranks=0)
        check(done.err == "", f"{name} is checked without a remark:\n{done.err}")
    check(case.files() == [], "nothing is written")


def test_rigid_replicate(case):
    """wing-rigid.ini and wing.ini differ in one key."""
    flexible, rigid = settings("wing.ini"), settings("wing-rigid.ini")
    check(flexible.keys() == rigid.keys(), "the same keys")
    different = {key: (flexible[key], rigid[key]) for key in flexible if flexible[key] != rigid[key]}
    check(different == {("[Insects]", "wings"): ("flexible", "rigid")}, f"they differ in wings: {different}")


def test_paper_grid(case):
    """wing-1024.ini is wing.ini on the paper's grid, where penalized wings are thin enough, with the paper's permeability."""
    coarse, fine = settings("wing.ini"), settings("wing-1024.ini")
    for key in [k for k in coarse if k[0] not in ("[Resolution]", "[Saving]", "[Time]", "[Penalization]")]:
        if key != ("[Insects]", "surface"):
            check(coarse[key] == fine[key], f"{key}: {coarse[key]} is {fine[key]}")
    check(fine["[Insects]", "surface"].startswith("penalized"), "wings in the mask")
    check(float(fine["[Penalization]", "eps"]) == 2.476e-4, "the paper's eps")


def test_individuals(case):
    """The rows of the paper's Table 1: size, speeds, viscosity and the Reynolds number of each."""
    for n, (length, chord, u_tip, u_inf, viscosity) in TABLE.items():
        ini = settings(f"individuals/{n}.ini")
        check(float(ini["[ReynoldsNumber]", "nu"]) == float(f"{viscosity}e-5"), f"{n}: viscosity")
        check(float(ini["[MeanFlow]", "ux"]) == u_inf, f"{n}: wind")
        text = header(case, f"individuals/{n}.ini")
        scale = number(text, r"units     L =") * 1e3
        speed = number(text, "velocity")
        found = (number(text, "left: 1909 triangles, R =") * scale, number(text, "mean chord") * scale,
                 number(text, "mean tip speed =") * speed, number(text, "u_inf =") * speed)
        for what, a, b in zip(("R", "chord", "u_tip", "u_inf"), found, (length, chord, u_tip, u_inf)):
            check(abs(a - b) < 4e-4 * b, f"{n}: {what} is {b} of the table, not {a}")
        table = (u_tip + u_inf) * chord * 10 / viscosity * 10
        check(abs(table - REYNOLDS) < TABLE_ERROR * REYNOLDS, f"{n}: the table gives Re = {table}")
        printed = number(text, "chord / nu =")
        check(abs(printed - REYNOLDS) < TABLE_ERROR * REYNOLDS, f"{n}: the run has Re = {printed}")


def test_similarity(case):
    """Wings of all sizes weigh in proportion to R^3."""
    ratios = [number(header(case, f"individuals/{n}.ini"), "Pa, mass") / TABLE[n][0] ** 3 for n in (3, 6, 8)]
    check(max(ratios) - min(ratios) < 1e-3 * ratios[0], f"one mass ratio: {ratios}")  # four printed digits


def test_plane_flow(case):
    """Sheets in a plane flow: the chord is their length. Turek & Hron's beam, 0.35 long and 0.02 thick, ten times as dense
    as the fluid, and a filament of length 1 and mass 1.5: pi/4 c^2 rho of fluid by the mass, of two decimals."""
    for name, ratio in (("turek-hron.ini", math.pi / 4 * 0.35**2 / (10 * 0.02 * 0.35)), ("flag.ini", math.pi / 4 / 1.5)):
        printed = number(header(case, name), "largest added-mass ratio over the wing")
        check(abs(printed - ratio) < 0.006, f"{name}: the fluid weighs {printed} times the sheet, not {ratio}")


def test_revolving(case):
    """Re = 1800 and a constant tip speed of one R per time in which the wing turns by a radian."""
    text = header(case, "revolving.ini")
    check(abs(number(text, "chord / nu =") - 1800) < 1, "Re = 1800")
    check(abs(number(text, "mean tip speed =") - 1) < 1e-3, "tip speed 1")
    rows = [[float(x) for x in line.split()] for line in (INI / "kinematics/revolving.dat").read_text().splitlines()
            if len(line.split()) == 13 and line[0].isdigit()]
    for a, b in zip(rows, rows[1:]):
        # Simpson with the Hermite value in the middle is the cubic itself: values and slopes belong together.
        middle = 1.5 * (b[1] - a[1]) / (b[0] - a[0]) - (a[7] + b[7]) / 4
        t = (a[0] + b[0]) / 2
        rate = -57.29577951308232 * (t**3 * (10 - 15 * t + 6 * t**2) if t < 1 else 1)
        # The slope of a Hermite cubic in the middle errs by h^4 f(5)/1920, here 7e-5.
        check(abs(middle - rate) < 1e-3, f"the rate at t = {t} is {rate}, not {middle}")


def test_replicates(case):
    """Every kind of case starts, on a grid that is too coarse for physics."""
    for name in ("wing.ini", "wing-rigid.ini", "individuals/6.ini", "revolving.ini", "plate.ini"):
        run = case.sub(name.replace("/", "_"))
        replicate(run, name)
        check(len(run.series("forces.t").rows) >= 3, f"{name}: three steps")
        bent = run.folder / "bending_left.t"
        check(bent.exists() == ("rigid" not in name), f"{name}: flexible or rigid")
        check((run.folder / "wing_right.t").exists() == (name not in ("revolving.ini", "plate.ini")), f"{name}: its wings")
        if bent.exists():
            check(max(abs(row[3]) for row in run.series("bending_left.t").rows) > 0, f"{name}: the wing bends")


def test_diagnosed_wing(case):
    """ini/diagnose-flight.ini takes the wing that lies beside the run, whatever a diagnosis put into it; a clamp that turns
    cannot fly."""
    wing = "[Wing]\nE = 9.0e9;\nD = 2e-7;\ncross_springs = no;\nparameters = {}, joint:C_Sc 1.0e-6;\n" \
           "[Instrument]\nparameters = force_gain 1.1;\n"
    case.write("tested.ini", wing.format("E_gradient -0.35"))
    shown = case.run(str(INI / "diagnose-flight.ini"), "--check", ranks=0).out
    check(re.search(r"E = (9e9|9\.0*E\+?0*9|9000000000)", shown), shown)
    check("E_gradient -0.35" in shown, shown)
    case.write("tested.ini", wing.format("root_flap 300"))
    refused = case.run(str(INI / "diagnose-flight.ini"), "--check", ranks=0, code=EXIT_USER).err
    check("root_flap" in refused, refused)


if __name__ == "__main__":
    main(globals())
