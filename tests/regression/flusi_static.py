#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""flusi --static: loads converge, files are complete and refer to each other, mistakes write nothing.

usage: flusi_static.py <flusi> <h5dump> [tests]
"""
import math
import re
import struct
import xml.etree.ElementTree as ET

from whole_program import EXIT_NUMERICAL, EXIT_UNWRITABLE, EXIT_USER, SOLID_REFERENCE, SOURCE, STATIC_REFERENCE, check, live_keys, main, merged

NO_MPI = {"OMPI_MCA_pml": "no_such_component"}
WING = SOURCE / "wings/calliphora_small.h5"
COLUMNS = ("load x y fx fy fz converged residual factors snaps stages rcond at_load tip_x tip_y tip_z largest R "
           "CPU").split()
RESIDUAL = 1e-8  # of the load: the default tolerance


def shipped():
    """ini/static.ini with the small wing."""
    text = (SOURCE / "ini/static.ini").read_text()
    changed = text.replace("file = ../wings/calliphora.h5;", f"file = {WING};")
    check(changed != text, "ini/static.ini names the wing of the blowfly")
    return changed


def two_loads(**sections):
    """A soft and a hard load; `sections` add to them or replace keys."""
    return merged({"Wing": {"file": WING}, "Loads": {"forces": "(/ 0.00721 -0.00032 5e-4\n 0.00315 -0.00078 2e-2 /)"}},
                  sections)


def table(case, name="static_loads.t"):
    """The rows of the table of loads, by column."""
    found = case.series(name)
    names = [n for n in re.split(r"\s{2,}", found.header[0].strip("% ")) if n]
    check([n.split(" ")[0] for n in names] == COLUMNS, f"the columns are named: {names}")
    check(all(re.search(r"\[.+\]$", n) for n in names), "with units")
    return [dict(zip(COLUMNS, row)) for row in found.rows]


def reals(case, file, name):
    data = case.raw(file, name)
    return struct.unpack(f"<{len(data) // 8}d", data)


def integers(case, file, name):
    data = case.raw(file, name)
    return struct.unpack(f"<{len(data) // 4}i", data)


def vectors(case, file, name):
    values = reals(case, file, name)
    return [values[i:i + 3] for i in range(0, len(values), 3)]


def check_index(case, name):
    """Every reference of the index is a dataset of the size and type stated."""
    root = ET.parse(case.folder / name).getroot()
    check(root.get("Version") == "3.0", "the index is XDMF 3")
    grids = {g.get("Name"): g for g in root.findall("./Domain/Grid/Grid")}
    check(list(grids) == ["membrane", "veins"], f"membrane and veins: {list(grids)}")
    kinds = {n: g.find("Topology").get("TopologyType") for n, g in grids.items()}
    check(kinds == {"membrane": "Triangle", "veins": "Mixed"}, f"their cells: {kinds}")
    items = root.findall(".//DataItem")
    for item in items:
        file, dataset = item.text.split(":/")
        check("/" not in file and (case.folder / file).is_file(), f"{file} is beside its index")
        part = case.header(file)
        part = part[part.index(f'DATASET "{dataset}"'):]
        sizes = re.search(r"SIMPLE \{ \(([^)]*)\)", part).group(1).replace(",", "").split()
        check(sizes == item.get("Dimensions").split(), f"{dataset} has the size {sizes} stated")
        stored = re.search(r"H5T_(IEEE_F|STD_I)(\d+)LE", part).groups()
        check(stored == {"Float": ("IEEE_F", "64"), "Int": ("STD_I", "32")}[item.get("NumberType")],
              f"{dataset} has the type stated: {stored}")
    check(len(items) == 8, "four datasets of the membrane and four of the veins")


def test_ten_loads(case):
    case.write("static.ini", shipped())
    done = case.run("--static", "static.ini", ranks=0, env=NO_MPI)
    check(done.err == "", f"nothing to complain about:\n{done.err}")
    for word in ("200 points", "348 triangles", "14 veins", "10 joints", "ug", "its mass means", "D =", "not measured",
                 "(as the vein)", "10 of 10 loads converged"):
        check(word in done.out, f"'{word}' is told:\n{done.out}")
    rows = table(case)
    check([r["load"] for r in rows] == list(range(1, 11)), "one row a load")
    expected = {f"static_{i:02d}.{e}" for i in range(1, 11) for e in ("h5", "xmf")}
    check(set(case.files()) == expected | {"static.ini", "static_loads.t"}, f"all files, no others: {case.files()}")
    rest = vectors_of_wing(case)
    farthest = max(range(len(rest)), key=lambda i: rest[i][0])
    for row in rows:
        number = int(row["load"])
        check(row["converged"] == 1 and 0 < row["residual"] <= RESIDUAL, f"load {number} converged: {row}")
        check(0.02 < row["at_load"] / row["R"] < 0.4, f"load {number} is large: {row}")
        file = f"static_{number:02d}"
        check_index(case, file + ".xmf")
        moved, u = vectors(case, file + ".h5", "points"), vectors(case, file + ".h5", "displacement")
        force = vectors(case, file + ".h5", "force")
        check(all(abs(p[k] - r[k] - d[k]) < 1e-17 for p, r, d in zip(moved, rest, u) for k in range(3)),
              "points are the unloaded ones displaced")
        check(abs(sum(f[2] for f in force) - row["fz"]) < 1e-12 * row["fz"], "the forces sum up to the load")
        at_load = sum(f[2] * d[2] for f, d in zip(force, u)) / row["fz"]
        check(abs(at_load - row["at_load"]) < 1e-7 * row["largest"], f"movement of the loaded place is {at_load}")
        check(abs(u[farthest][2] - row["tip_z"]) < 1e-7 * row["largest"], "movement of the tip")  # nine digits
        cells = list(integers(case, file + ".h5", "vein_cells"))
        nodes, n_veins = [], 0
        while cells:
            check(cells[0] == 2 and cells[1] > 1, "a cell of the veins is a polyline")
            nodes += cells[2:2 + cells[1]]
            cells = cells[2 + cells[1]:]
            n_veins += 1
        points = vectors(case, file + ".h5", "vein_points")
        check(n_veins == 14 and nodes == list(range(len(points))), "14 veins use every point once")
        check(set(points) <= set(moved), "veins move with the membrane")
        diameters = reals(case, file + ".h5", "vein_diameter")
        check(len(diameters) == len(points) and min(diameters) > 1e-6 and max(diameters) < 1e-3, "diameters in m")
        corners = integers(case, file + ".h5", "triangles")
        check(min(corners) == 0 and max(corners) == len(rest) - 1, "triangles count points from 0")


def vectors_of_wing(case):
    here = case.folder / "wing.h5"
    here.write_bytes(WING.read_bytes())
    points = vectors(case, "wing.h5", "points")
    here.unlink()
    return points


def test_full_wing(case):
    """One load on the wing of 1015 points: the number of the README. The bound is that of the printed digits."""
    row = next(line for line in shipped().splitlines() if "0.00856" in line)
    wing = SOURCE / "wings/calliphora.h5"
    case.write("run.ini", two_loads(Wing={"file": wing}, Loads={"forces": f"(/ {row} /)"}))
    done = case.run("--static", "run.ini", ranks=0)
    found = table(case)[0]
    check(abs(found["at_load"] - 1.63236e-3) < 1e-8 and found["snaps"] == 0, f"the place moves by 1.63236 mm: {found}")
    check(abs(found["tip_z"] - 1.91446e-3) < 1e-8, f"the tip moves by 1.91446 mm: {found}")
    check("1015 points" in done.out and "250.12 ug" in done.out, "the wing is that of the paper")
    line = next(line for line in done.out.splitlines() if line.startswith("inertia"))
    jxx, jyy, jzz, jxy, jxz, jyz = (float(x) for x in re.findall(r"J\w\w (-?[\d.E+]+)", line))
    # Of a flat body, whatever its masses; printed with five digits.
    check(abs(jxx + jyy - jzz) < 2e-4 * jzz and jxz == jyz == 0, f"perpendicular axes: {line}")
    # 250 ug about 3.16 mm from the hinge alone make 2500; spread over the wing it is more, at most R^2 of it.
    check(2500 < jyy < 250 * 9.07**2 and 0 < jxy < math.sqrt(jxx * jyy), f"a wing's moments, ug mm^2: {line}")


def test_relative_wing(case):
    """The wing is found beside the input file, and the output has a name of its own."""
    (case.folder / "cases").mkdir()
    (case.folder / "wing.h5").write_bytes(WING.read_bytes())
    (case.folder / "out").mkdir()
    case.write("cases/run.ini", two_loads(Wing={"file": "../wing.h5"}, Saving={"name": "out/soft"},
                                          Loads={"forces": "(/ 0.00721 -0.00032 5e-4 /)"}))
    case.run("--static", "cases/run.ini", ranks=0)
    check(case.sub_files("out") == ["soft_01.h5", "soft_01.xmf", "soft_loads.t"], f"{case.sub_files('out')}")
    check("soft_01.h5:/points" in (case.folder / "out/soft_01.xmf").read_text(), "the index stays in its folder")


def test_failed_load(case):
    """A load that fails is told, the others go on, its old files do not stay."""
    case.write("run.ini", two_loads())
    case.run("--static", "run.ini", ranks=0)
    check("static_02.h5" in case.files() and "static_02.xmf" in case.files(), "both loads converge")
    factors = [r["factors"] for r in table(case)]
    check(factors[0] + 5 < factors[1], f"the second load is harder: {factors}")
    case.write("run.ini", two_loads(Solver={"factorisation_limit": int(factors[0]) + 2},
                                    Loads={"forces": "(/ 0.00315 -0.00078 2e-2\n 0.00721 -0.00032 5e-4 /)"}))
    done = case.run("--static", "run.ini", ranks=0, code=EXIT_NUMERICAL)
    check(re.search(r"^ +failed: \w+", done.out, re.M) and "1 of 2 loads converged" in done.out, done.out)
    rows = table(case)
    check([r["converged"] for r in rows] == [0, 1] and rows[0]["at_load"] != rows[0]["at_load"] and
          rows[1]["at_load"] > 0, f"the table tells, and holds no shape on the way: {rows}")
    check({"static_01.h5", "static_01.xmf"} & set(case.files()) == set(), "the earlier shape is gone")
    check({"static_02.h5", "static_02.xmf"} <= set(case.files()), "the other load is there")


def test_parameters(case):
    """Keys have the effect they promise."""
    def at_load(**sections):
        case.write("run.ini", two_loads(Loads={"forces": "(/ 0.00721 -0.00032 3e-4 /)"}, Saving={"shapes": "no"},
                                        **sections))
        done = case.run("--static", "run.ini", ranks=0)
        return table(case)[0]["at_load"], done

    usual, _ = at_load()
    softer, _ = at_load(Wing={"E": 6e9})
    joints, done = at_load(Wing={"joint_stiffness": 1e-6})
    check(done.out.count("1.0000E-06 N m/rad") == 10 and "as the vein" not in done.out, "every joint is set")
    one, done = at_load(Wing={"parameters": "joint:C_Sc 1e-6, root 0.5"})
    check(done.out.count("(as the vein)") == 9, "one joint is set")
    check(min(softer, joints, one) > 1.001 * usual, f"all of this softens: {usual} {softer} {joints} {one}")
    paper, done = at_load(Wing={"preset": "paper"})
    crossed, _ = at_load(Wing={"cross_springs": "yes"})
    plain, _ = at_load(Wing={"preset": "paper", "cross_springs": "no"})
    check("cross-springs yes" in done.out and paper == crossed < usual == plain, "preset and cross-springs")
    thin, done = at_load(Wing={"D": 5e-8})
    check(thin > usual and "notice: " in done.err and "shapes depend on the loading path" in done.err, "small D is warned of")
    check("static_01.h5" not in case.files(), "shapes = no writes none")
    # The same force at a point, by place and by number.
    points = vectors_of_wing(case)
    number = max(range(len(points)), key=lambda i: points[i][0]) + 1
    x, y, _ = points[number - 1]
    case.write("run.ini", two_loads(Loads={"forces": f"(/ {x!r} {y!r} 1e-4 /)",
                                           "point_forces": f"(/ {number} 0 0 1e-4 /)"}))
    case.run("--static", "run.ini", ranks=0)
    one, two = (r["at_load"] for r in table(case))
    check(abs(one - two) < 1e-7 * abs(one), f"a place and a point are the same load: {one} {two}")


def only(case, loads):
    """Rows of the table of a run with these loads."""
    case.write("run.ini", {"Wing": {"file": WING}, "Loads": loads})
    case.run("--static", "run.ini", ranks=0)
    return table(case)


def same_shape(one, two, what, names=("at_load", "tip_x", "tip_y", "tip_z", "largest")):
    """Both loads are the same up to round-off, and both solutions end at 1e-8 of the load, which soft directions
    turn into some 1e-7 of the movement."""
    for name in names:
        check(abs(one[name] - two[name]) < 1e-6 * abs(two["largest"]), f"{what}: {name} {one[name]} and {two[name]}")


def listed(forces, root=()):
    """Forces at points as one load of named_forces; not at the root, which nothing moves."""
    return " + ".join(f"point:{i + 1} {f[0]!r} {f[1]!r} {f[2]!r}" for i, f in enumerate(forces)
                      if any(f) and i not in root)


def test_combined_loads(case):
    """Several forces in one load are statics of their sum, whatever names their places have."""
    points = vectors_of_wing(case)
    tip = max(range(len(points)), key=lambda i: points[i][0]) + 1
    place, second = (0.00721, -0.00032, 3e-4), (0.00405, 0.00066, 2e-3)
    rows = only(case, {"forces": f"(/ {place[0]} {place[1]} {place[2]}\n {second[0]} {second[1]} {second[2]} /)",
                       "point_forces": f"(/ {tip} 1e-5 0 1e-4 /)"})
    forces = [vectors(case, f"static_0{i}.h5", "force") for i in (1, 2, 3)]
    check([sum(any(f) for f in one) for one in forces] == [3, 3, 1], "three corners, three corners, a point")
    parts = only(case, {"named_forces": f"{listed(forces[0])}, at:{second[0]}:{second[1]} 0 0 {second[2]}, "
                                        "tip 1e-5 0 1e-4"})
    check(len(parts) == 3, "commas separate loads")
    for one, two, what in zip(rows, parts, ("corners", "a place", "the tip")):
        same_shape(one, two, what)
        check(abs(one["fz"] - two["fz"]) < 1e-15, "with the same force")
    total = [[sum(f[k] for f in at) for k in range(3)] for at in zip(*forces)]
    once, twice = only(case, {"named_forces": f"at:{place[0]}:{place[1]} 0 0 {place[2]} + at:{second[0]}:{second[1]} "
                                              f"0 0 {second[2]} + point:{tip} 1e-5 0 1e-4, {listed(total)}"})
    same_shape(once, twice, "three forces")
    check(abs(once["fz"] - 2.4e-3) < 1e-12 and abs(once["fx"] - 1e-5) < 1e-15, f"which add up: {once}")
    check(once["tip_z"] > 1.1 * max(r["tip_z"] for r in rows), "and act together")
    # Points of veins and joints.
    veins = only(case, {"named_forces": "vein:C:last 0 0 1e-4, vein:C:2 0 0 1e-4, joint:C_Sc 0 0 1e-4"})
    here = case.folder / "wing.h5"
    here.write_bytes(WING.read_bytes())
    nodes = integers(case, "wing.h5", "/veins/C/nodes")
    base = 1 - int(re.search(r'"index_base".*?\(0\): (\d)', case.header("wing.h5"), re.S).group(1))
    numbers = [nodes[-1] + base, nodes[1] + base]
    for row, number in zip(veins, numbers):
        x, y, _ = points[number - 1]
        check(abs(row["x"] - x) < 1e-9 and abs(row["y"] - y) < 1e-9, f"point {number} of the wing is meant: {row}")


def test_gravity(case):
    """The weight is a load: alone, and with others."""
    alone, = only(case, {"gravity": "0 3 -9.81"})
    weight = vectors(case, "static_01.h5", "force")
    mass = sum(f[2] for f in weight) / -9.81
    check(abs(mass - 250.03e-9) < 0.01e-9, f"it is that of the mass reported: {mass}")
    check(abs(alone["fz"] + 9.81 * mass) < 1e-14 and abs(alone["fy"] - 3 * mass) < 1e-14, f"and told: {alone}")
    check(abs(alone["x"] - 3.158e-3) < 1e-6 and abs(alone["y"] + 0.223e-3) < 1e-6, "at the centre of mass")
    check(alone["tip_z"] < 0 < alone["at_load"], "the wing sinks")
    (case.folder / "wing.h5").write_bytes(WING.read_bytes())
    first = int(re.search(r'"index_base".*?\(0\): (\d)', case.header("wing.h5"), re.S).group(1))
    forces = listed(weight, [n - first for n in integers(case, "wing.h5", "/root/nodes")])
    moved = ("tip_x", "tip_y", "tip_z", "largest")
    as_forces, = only(case, {"named_forces": forces})
    same_shape(alone, as_forces, "the weight as forces", moved)
    with_tip, = only(case, {"named_forces": "tip 0 0 2e-4", "gravity": "0 3 -9.81"})
    as_forces, = only(case, {"named_forces": f"{forces} + tip 0 0 2e-4"})
    check(abs(with_tip["fz"] - 2e-4) < 1e-15, "the weight is not counted as applied")
    same_shape(with_tip, as_forces, "weight and tip", moved)
    check(abs(with_tip["at_load"] - with_tip["tip_z"]) < 1e-11, "the loaded place is the tip")


def test_stretched_wing(case):
    """A load that no wing can bear without being stretched is doubted."""
    for force, doubted in (("1e4", True), ("1e-4", False)):
        case.write("run.ini", merged(two_loads(), {"Loads": {"forces": f"(/ 0.00721 -0.00032 {force} /)"}}))
        out = case.run("--static", "run.ini", ranks=0).out
        check(("is the force in newtons?" in out) == doubted, f"{force} N:\n{out}")


def test_mistakes(case):
    def forces(text):
        return {"Loads": {"forces": text}}

    mistakes = [
        ({"Wing": {"files": "x"}}, ["run.ini:3: [Wing] files", "did you mean 'file'"]),
        ({"Wings": {"E": 1}}, ["run.ini:6: [Wings]", "Wing"]),
        ({"Wing": {"file": None}}, ["[Wing] file: is missing"]),
        ({"Wing": {"file": "nosuch.h5"}}, ["run.ini:2: [Wing] file: 'nosuch.h5' does not exist"]),
        ({"Wing": {"file": "run.ini"}}, ["run.ini: cannot be opened"]),
        ({"Wing": {"D": 0, "E": -1}}, ["run.ini:3: [Wing] D", "run.ini:4: [Wing] E"]),
        ({"Wing": {"joint_stiffness": 0}}, ["run.ini:3: [Wing] joint_stiffness: must be positive"]),
        ({"Wing": {"parameters": "joint:nose 1, root, root 0, root x, E 5"}},
         ["'joint:nose' is unknown; valid: root", "joint:C_Sc", "'root' is not a pair", "'root' must be positive",
          "'x' is not a number", "'E' has a key of its own: E"]),
        ({"Wing": {"preset": "papers"}}, ["run.ini:3: [Wing] preset"]),
        (forces(None), ["[Loads] forces: there are no loads"]),
        (forces("(/ 1 2 /)"), ["[Loads] forces"]),
        (forces("(/ 0.00721 -0.00032 1e-4\n 0.02 0 1e-4\n 0.00721 -0.00032 0 /)"),
         ["run.ini:4: [Loads] forces: row 2: the place 0.02 0.0 m is not on the membrane; row 3: the force is zero"]),
        ({"Loads": {"point_forces": "(/ 201 0 0 1\n 1.5 0 0 1\n 5 0 0 0 /)"}},
         ["row 1: 201.0 is no point; valid: 1 to 200; row 2: 1.5 is no point", "row 3: the force is zero"]),
        ({"Loads": {"named_forces": "tip 0 0 1e-4 + nose 0 0 1, , tip 0 0 1 +"}},
         ["[Loads] named_forces: 'nose' is no site of the wing; valid: tip", "'' is not SITE FX FY FZ"]),
        ({"Loads": {"named_forces": "tip 0 0 1e-4 + tip 0 0 -1e-4"}}, ["the forces of load 1 cancel"]),
        ({"Loads": {"gravity": "0 -9.81"}}, ["[Loads] gravity"]),
        ({"Modes": {"modes": -1}}, ["[Modes] modes"]),
        ({"Solver": {"tolerance": 1}}, ["[Solver] tolerance"]),
        ({"Saving": {"name": "a<b"}}, ["[Saving] name: must not contain"]),
    ]
    for change, sentences in mistakes:
        case.write("run.ini", two_loads(**change))
        for arguments in (["--static"], ["--check", "--static"]):
            done = case.run(*arguments, "run.ini", ranks=0, code=EXIT_USER)
            for sentence in sentences:
                check(sentence in done.err, f"{change}: {sentence}:\n{done.err}")
            check(done.out == "" and case.files() == ["run.ini"], f"{change} writes nothing: {case.files()}")
    case.write("run.ini", two_loads())
    for arguments, word in ((["--dry-run"], "--static goes with"), (["--restart"], "--restart is valid for a run only"),
                            (["--keyvalues"], "--static goes with")):
        done = case.run("--static", *arguments, "run.ini", ranks=0, code=EXIT_USER)
        check(word in done.err and case.files() == ["run.ini"], f"{arguments}:\n{done.err}")
    case.write("run.ini", two_loads(Saving={"name": "no/such/folder"}))
    done = case.run("--static", "run.ini", ranks=0, code=EXIT_UNWRITABLE)
    check("no/such/folder_loads.t: cannot be written" in done.err, done.err)
    (case.folder / "static_01.h5").mkdir()
    case.write("run.ini", two_loads())
    done = case.run("--static", "run.ini", ranks=0, code=EXIT_UNWRITABLE)
    check("static_01.h5" in done.err and case.files() == ["run.ini", "static_01.h5", "static_loads.t"],
          f"a file in the way: {case.files()}\n{done.err}")


def test_check(case):
    """--check prints every documented key, needs no MPI and writes nothing; behind a launcher all is said once."""
    case.write("static.ini", shipped())
    done = case.run("--static", "--check", "static.ini", ranks=0, env=NO_MPI)
    known = live_keys(case.flusi("--parameters").out.split(STATIC_REFERENCE)[1].split(SOLID_REFERENCE)[0])
    known.discard(("include", "file"))  # what was included is printed in its place
    section, printed = "", set()
    for line in done.out.splitlines():
        section = line.strip("[]") if line.startswith("[") else section
        found = re.match(r"  (\S+) = ", line)
        if found:
            printed.add((section, found.group(1)))
    check(len(known) > 15 and printed == known, f"every key: {printed ^ known}")
    check(re.search(r"  E = 1\.258e10; +Pa, static\.ini:\d+", done.out), f"the origin is told:\n{done.out}")
    once = case.run("--static", "--check", "static.ini", ranks=2)
    check(once.out == done.out and case.files() == ["static.ini"], "once, and nothing is written")


if __name__ == "__main__":
    main(globals())
