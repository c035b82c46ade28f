#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares with published numbers the drag of a circular disk and the lift and drag of a rectangular plate, both of them wings
at rest in a uniform flow. docs/results/verification-wings.md holds the table and describes the comparisons.

usage: plates.py <flusi> <folder> [case ...]     runs the cases (all of them without names), then prints
       plates.py --table <folder>                prints what is there
       plates.py --list                          names the cases

A case that has finished in <folder> is not run again.
"""
import math
import subprocess
import sys
from pathlib import Path

# Bodies of unit size: the disk's diameter, the plate's chord (span 2). Box, Re and end time in these units and U.
# name: body, Re, points per unit, thickness in points (0: a surface without thickness), C_eta, box, end time
CASES = {
    "disk-100-16": ("disk", 100, 16, 4.0, 1e-2, (6, 4, 4), 12),
    "disk-100-16-wide": ("disk", 100, 16, 4.0, 1e-2, (6, 6, 6), 8),
    "disk-100-16-thin": ("disk", 100, 16, 2.0, 1e-2, (6, 4, 4), 8),
    "disk-100-24": ("disk", 100, 24, 4.0, 1e-2, (6, 4, 4), 8),
    "disk-100-24-thin": ("disk", 100, 24, 3.0, 1e-2, (6, 4, 4), 8),
    "disk-100-32": ("disk", 100, 32, 4.0, 1e-2, (6, 4, 4), 8),
    "disk-20-16": ("disk", 20, 16, 4.0, 1e-2, (6, 4, 4), 8),
    "disk-20-16-wide": ("disk", 20, 16, 4.0, 1e-2, (6, 6, 6), 5),
    "disk-20-24": ("disk", 20, 24, 4.0, 1e-2, (6, 4, 4), 8),
    "plate-30-16": ("plate30", 100, 16, 4.0, 1e-2, (6, 5, 4), 8),
    "plate-30-16-wide": ("plate30", 100, 16, 4.0, 1e-2, (10, 7, 7), 8),
    "plate-30-16-stiff": ("plate30", 100, 16, 4.0, 2.5e-3, (6, 5, 4), 5),
    "plate-30-16-thin": ("plate30", 100, 16, 2.0, 1e-2, (6, 5, 4), 8),
    "plate-30-16-thin-stiff": ("plate30", 100, 16, 2.0, 2.5e-3, (6, 5, 4), 5),
    "plate-90-16": ("plate90", 100, 16, 4.0, 1e-2, (6, 5, 4), 5),
    "plate-30-24": ("plate30", 100, 24, 4.0, 1e-2, (6, 5, 4), 8),
    "plate-30-24-thin-stiff": ("plate30", 100, 24, 2.0, 2.5e-3, (6, 5, 4), 5),
    "plate-30-24-thin": ("plate30", 100, 24, 2.0, 1e-2, (6, 5, 4), 8),
    "plate-30-12-sheet": ("plate30", 100, 12, 0.0, 1e-2, (6, 5, 4), 15),
    "plate-30-16-sheet": ("plate30", 100, 16, 0.0, 1e-2, (6, 5, 4), 15),
    "plate-30-16-sheet-wide": ("plate30", 100, 16, 0.0, 1e-2, (10, 7, 7), 15),
    "plate-30-24-sheet": ("plate30", 100, 24, 0.0, 1e-2, (6, 5, 4), 15),
    "plate-90-16-sheet": ("plate90", 100, 16, 0.0, 1e-2, (6, 5, 4), 15),
    "disk-100-12-sheet": ("disk", 100, 12, 0.0, 1e-2, (6, 4, 4), 12),
    "disk-100-16-sheet": ("disk", 100, 16, 0.0, 1e-2, (6, 4, 4), 12),
    "disk-100-24-sheet": ("disk", 100, 24, 0.0, 1e-2, (6, 4, 4), 5),
    "disk-100-16-sheet-wide": ("disk", 100, 16, 0.0, 1e-2, (6, 6, 6), 12),
    "disk-20-16-sheet": ("disk", 20, 16, 0.0, 1e-2, (6, 4, 4), 8),
    "disk-20-12-sheet": ("disk", 20, 12, 0.0, 1e-2, (6, 4, 4), 8),
    "disk-20-24-sheet": ("disk", 20, 24, 0.0, 1e-2, (6, 4, 4), 5),
    "disk-20-16-sheet-wide": ("disk", 20, 16, 0.0, 1e-2, (6, 6, 6), 8),
}
# C_D and C_L of the plate (aspect ratio 2, Re = 100) over its incidence in degrees.
TAIRA = {30: (0.639, 0.758), 90: (1.527, 0.0)}

INI = """\
[Resolution]
nx = {nx}
ny = {ny}
nz = {nz}
[Geometry]
xl = {xl}
yl = {yl}
zl = {zl}
[Time]
Tmax = {end}
CFL = {cfl}
[ReynoldsNumber]
nu = {nu}
[InitialCondition]
inicond = MeanFlow
[Penalization]
iPenalization = yes
iMask = Insect
eps = {eps}
[Insects]
WingShape = from_file::planform.ini
{surface}
RightWing = no
x0 = 2.0 {yc} {zc}
; The wing at rest stands at 45 degrees in the stroke plane: eta0 turns it to the wanted incidence.
eta0 = {eta}
[MeanFlow]
iMeanFlow = 1
ux = 1.0
uy = 0.0
uz = 0.0
[Sponge]
iVorticitySponge = yes
iSpongeType = outlet_x
eps_sponge = 0.05
sponge_thickness = {points}
[Saving]
tintegral = 0.05
iDoBackup = no
progress_interval = 300
"""


def planform(body, thickness):
    """Returns the planform. The mask's rounded edge reaches t/2 beyond it: the whole body has unit size, not the planform."""
    if body == "disk":
        radius = (1 - thickness) / 2
        return (f"[Wing]\ntype = ellipse\nroot = {-radius!r}\nlength = {radius!r}\n"
                f"mean_chord = {math.pi / 2 * radius!r}\nfront = 0.5\n")
    return (f"[Wing]\ntype = rectangular\nroot = {-(1 - thickness / 2)!r}\nlength = {1 - thickness / 2!r}\n"
            f"mean_chord = {1 - thickness!r}\nfront = 0.5\n")


def write(folder, body, re, points, cells, c_eta, box, end):
    folder.mkdir(parents=True, exist_ok=True)
    thickness = cells / points
    incidence = 90 if body == "disk" else int(body[5:])
    (folder / "planform.ini").write_text(planform(body, thickness))
    (folder / "run.ini").write_text(INI.format(
        nx=box[0] * points, ny=box[1] * points, nz=box[2] * points, xl=float(box[0]), yl=float(box[1]),
        zl=float(box[2]), end=float(end), nu=1 / re, eps=c_eta, cfl=0.5 if cells else 0.45,
        surface=f"WingThickness = {thickness!r}" if cells else "surface = thin", yc=box[1] / 2, zc=box[2] / 2,
        eta=incidence - 45, points=points))


def mask_profile(distance, h):
    if distance <= -h:
        return 1.0
    return 0.0 if distance >= h else (1 + math.cos(math.pi * (distance + h) / (2 * h))) / 2


def wall_shift(nu, c_eta, h):
    """Returns the distance from the surface of the mask (chi = 1/2) to the wall that the outer flow sees: the place where the
    extrapolated outer line of the boundary layer nu u'' = chi/C_eta u of the penalized equation becomes zero, as in
    test_sphere_drag."""
    steps, y = 4000, -2 * h
    dy, u, v = 3 * h / steps, 1.0, math.sqrt(1 / (nu * c_eta))

    def rate(y, u):
        return mask_profile(y, h) / (nu * c_eta) * u
    for _ in range(steps):
        a, b = v, rate(y, u)
        c, d = v + dy / 2 * b, rate(y + dy / 2, u + dy / 2 * a)
        e, f = v + dy / 2 * d, rate(y + dy / 2, u + dy / 2 * c)
        g, k = v + dy * f, rate(y + dy, u + dy * e)
        u, v, y = u + dy / 6 * (a + 2 * c + 2 * e + g), v + dy / 6 * (b + 2 * d + 2 * f + k), y + dy
        u, v = u / max(abs(u), abs(v)), v / max(abs(u), abs(v))  # the equation is linear
    return y - u / v


def disk_drag(re):
    """Returns the drag of Clift, Grace & Weber 1978 for thin disks normal to the flow, 1.5 < Re <= 133."""
    return 64 / (math.pi * re) * (1 + 0.138 * re**0.792)


def margin(re, points, measured):
    """Returns by how many cells a disk must be larger on every side to have a measured drag per area of the disk drawn."""
    low, high = 0.5, 2.0
    while high - low > 1e-9:
        size = (low + high) / 2
        low, high = (low, size) if disk_drag(re * size) * size**2 > measured else (size, high)
    return (low - 1) / 2 * points


def last_force(path):
    """Returns the time and the force of the last record but one, and the force one time unit before it. The last step is shorter than
    the others, and the force on a surface without thickness jumps by 1 % in it."""
    rows = [[float(x) for x in line.split()] for line in path.read_text().splitlines()
            if line.strip() and not line.lstrip().startswith("%")][:-1]
    before = min(rows, key=lambda row: abs(row[0] - (rows[-1][0] - 1)))
    return rows[-1][0], rows[-1][1:4], before[1:4]


def blockage(root, name, wide, component):
    """Returns how much larger a force is in the box of `name` than in an unbounded flow: to first order in the blocked part of
    the cross-section, from two boxes that differ in nothing else."""
    forces = [last_force(root / n / "forces.t")[1][component] for n in (name, wide)]
    sections = [CASES[n][5][1] * CASES[n][5][2] for n in (name, wide)]
    unbounded = (forces[1] * sections[1] - forces[0] * sections[0]) / (sections[1] - sections[0])
    return forces[0] / unbounded


def row(root, name):
    """Returns a line of the table: the force, the force without blockage per hydrodynamic area, and the expected value."""
    body, re, points, cells, c_eta, box, _ = CASES[name]
    time, force, before = last_force(root / name / "forces.t")
    size = 1 + 2 * wall_shift(1 / re, c_eta, 1 / points) if cells else 1.0
    text = (f"{name:23s}{re:4d} {points:5d} {cells:6.1f} {cells / points:7.4f} {c_eta:8.1e} {box[1]}x{box[2]} {size:8.4f}  ")
    first = (f"disk-{re}-16" if body == "disk" else f"plate-{body[5:]}-16") + ("" if cells else "-sheet")
    for component in (0, 2) if body == "plate30" else (0,):
        raw = force[component] / (math.pi / 8 if body == "disk" else 1)
        area = size**2 if body == "disk" else size * (size + 1) / 2
        expected = disk_drag(re * size) if body == "disk" else TAIRA[int(body[5:])][component // 2]
        text += f"{'C_D' if component == 0 else '   C_L'} {raw:7.4f}"
        if not (root / (first + "-wide") / "done").exists() or time < 4.9:
            continue
        factor = 1.0 if name.endswith("-wide") else blockage(root, first, first + "-wide", component)
        if name.endswith("-wide"):
            factor = raw * (math.pi / 8 if body == "disk" else 1) / (
                last_force(root / first / "forces.t")[1][component] / blockage(root, first, name, component))
        measured = raw / factor / area
        text += f" /{factor:6.3f} -> {measured:6.3f} ({expected:5.3f}: {100 * (measured / expected - 1):+5.1f} %)"
        if body == "disk":
            text += f"  margin {margin(re, points, raw / factor):+5.2f} dx"
    return text + f"   {100 * (force[0] / before[0] - 1):+5.2f} % in the last of {time:g}"


def table(root):
    print("case                     Re  n/unit t/dx   t/unit   C_eta box     size   force, /blockage -> per hydrodynamic "
          "area (published)   drift\n"
          "margin: by how much the disk must be larger on every side to have the published drag")
    for name in CASES:
        if (root / name / "done").exists():
            print(row(root, name))


def main():
    arguments = sys.argv[1:]
    if arguments == ["--list"]:
        print("\n".join(CASES))
    elif len(arguments) == 2 and arguments[0] == "--table":
        table(Path(arguments[1]))
    elif len(arguments) >= 2 and not arguments[0].startswith("-") and set(arguments[2:]) <= set(CASES):
        program, root = str(Path(arguments[0]).resolve()), Path(arguments[1])
        for name in arguments[2:] or CASES:
            folder = root / name
            if (folder / "done").exists():
                continue
            write(folder, *CASES[name])
            with open(folder / "log", "w") as log:
                subprocess.run([program, "run.ini", "--overwrite"], cwd=folder, stdout=log, stderr=log, check=True)
            (folder / "done").touch()
        table(root)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
