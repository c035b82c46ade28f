#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Drag of a circular disk and lift and drag of a rectangular plate, both of them wings at rest in a uniform
flow, against published numbers. docs/verification-wings.md holds the table and says what is compared.

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
# name: body, Re, points per unit, thickness in points, C_eta, box, end time
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
    "plate-30-16": ("plate", 100, 16, 4.0, 1e-2, (6, 5, 4), 8),
    "plate-30-16-wide": ("plate", 100, 16, 4.0, 1e-2, (10, 7, 7), 8),
    "plate-30-16-stiff": ("plate", 100, 16, 4.0, 2.5e-3, (6, 5, 4), 5),
    "plate-30-16-thin": ("plate", 100, 16, 2.0, 1e-2, (6, 5, 4), 8),
    "plate-30-16-thin-stiff": ("plate", 100, 16, 2.0, 2.5e-3, (6, 5, 4), 5),
    "plate-30-24": ("plate", 100, 24, 4.0, 1e-2, (6, 5, 4), 8),
    "plate-30-24-thin": ("plate", 100, 24, 2.0, 1e-2, (6, 5, 4), 8),
}
INCIDENCE = 30.0       # of the plate, degrees
TAIRA = (0.758, 0.639)  # C_L and C_D of the plate at 30 degrees

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
CFL = 0.5
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
WingThickness = {thickness}
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
    """The mask's rounded edge stands t/2 outside of the planform: body and not planform have unit size."""
    if body == "disk":
        radius = (1 - thickness) / 2
        return (f"[Wing]\ntype = ellipse\nroot = {-radius!r}\nlength = {radius!r}\n"
                f"mean_chord = {math.pi / 2 * radius!r}\nfront = 0.5\n")
    return (f"[Wing]\ntype = rectangular\nroot = {-(1 - thickness / 2)!r}\nlength = {1 - thickness / 2!r}\n"
            f"mean_chord = {1 - thickness!r}\nfront = 0.5\n")


def write(folder, body, re, points, cells, c_eta, box, end):
    folder.mkdir(parents=True, exist_ok=True)
    thickness = cells / points
    incidence = 90.0 if body == "disk" else INCIDENCE
    (folder / "planform.ini").write_text(planform(body, thickness))
    (folder / "run.ini").write_text(INI.format(
        nx=box[0] * points, ny=box[1] * points, nz=box[2] * points, xl=float(box[0]), yl=float(box[1]),
        zl=float(box[2]), end=float(end), nu=1 / re, eps=c_eta, thickness=repr(thickness), yc=box[1] / 2, zc=box[2] / 2,
        eta=incidence - 45, points=points))


def mask_profile(distance, h):
    if distance <= -h:
        return 1.0
    return 0.0 if distance >= h else (1 + math.cos(math.pi * (distance + h) / (2 * h))) / 2


def wall_shift(nu, c_eta, h):
    """Distance from the surface of the mask (chi = 1/2) to the wall that the outer flow sees: where the outer line
    of the boundary layer nu u'' = chi/C_eta u of the penalized equation meets zero, as in test_sphere_drag."""
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
    """Clift, Grace & Weber 1978 for thin disks normal to the flow, 1.5 < Re <= 133."""
    return 64 / (math.pi * re) * (1 + 0.138 * re**0.792)


def last_force(path):
    """Time and force at the last record, and one time unit before it."""
    rows = [[float(x) for x in line.split()] for line in path.read_text().splitlines()
            if line.strip() and not line.lstrip().startswith("%")]
    before = min(rows, key=lambda row: abs(row[0] - (rows[-1][0] - 1)))
    return rows[-1][0], rows[-1][1:4], before[1:4]


def row(folder, body, re, points, cells, c_eta, box):
    """A line of the table: what is measured, what is expected, and their ratio."""
    time, force, before = last_force(folder / "forces.t")
    shift = wall_shift(1 / re, c_eta, 1 / points)
    section = box[1] * box[2]
    drift = force[0] / before[0] - 1
    if body == "disk":
        diameter = 1 + 2 * shift
        area = math.pi / 4 * diameter**2
        c_d = disk_drag(re * diameter)
        speed = 1 + area / section + c_d * area / section / 2
        expected = disk_drag(re * diameter * speed) * area / 2 * speed**2
        raw = force[0] / (math.pi / 8)
        return (f"{re:4d} {points:5d} {cells:6.1f} {cells / points:7.4f} {c_eta:7.1e} {box[1]}x{box[2]}   {diameter:7.4f} {speed:7.4f} "
                f"{raw:8.4f} {force[0] / (area / 2 * speed**2):8.4f} {expected / (area / 2 * speed**2):8.4f} "
                f"{100 * (force[0] / expected - 1):+7.1f} %  {100 * drift:+6.2f} % at t = {time:g}")
    chord, span = 1 + 2 * shift, 2 + 2 * shift
    area = chord * span
    front = area * math.sin(math.radians(INCIDENCE))
    speed = 1 + front / section + TAIRA[1] * area / section / 2
    scale = area / 2 * speed**2
    lift, drag = force[2] / scale, force[0] / scale
    return (f"{re:4d} {points:5d} {cells:6.1f} {cells / points:7.4f} {c_eta:7.1e} {box[1]}x{box[2]}   {chord:7.4f} {speed:7.4f} "
            f"C_L {force[2]:7.4f} -> {lift:7.4f} ({TAIRA[0]}: {100 * (lift / TAIRA[0] - 1):+5.1f} %)  "
            f"C_D {force[0]:7.4f} -> {drag:7.4f} ({TAIRA[1]}: {100 * (drag / TAIRA[1] - 1):+5.1f} %)  "
            f"{100 * drift:+6.2f} % at t = {time:g}")


def table(root):
    print("  Re  D/dx   t/dx     t/D   C_eta  box    D_hydro   speed  C_D raw      C_D  Clift..  difference  last time unit")
    for name, (body, re, points, cells, c_eta, box, _) in CASES.items():
        if (root / name / "done").exists():
            print(row(root / name, body, re, points, cells, c_eta, box))


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
                subprocess.run([program, "run.ini"], cwd=folder, stdout=log, stderr=log, check=True)
            (folder / "done").touch()
        table(root)
    else:
        sys.exit(__doc__)


main()
