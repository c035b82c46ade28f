#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes a flexible plate in a stream whose front part heaves: the plates of Heathcote & Gursul (2007), and small motions of a plate
that is clamped at its front edge, beside the theory of an inviscid flow. docs/results/heaving-plate.md holds the tables and describes the
comparisons.

usage: run_heaving [--program FLUSI] [--picture FILE] FOLDER [CASE ...]   runs the cases (all of them without names), prints the tables
       run_heaving --list                                                 names the cases

The last line is JSON. A case that has finished in FOLDER is not run again.
"""
import json
import math

import numpy as np
from heaving_theory import heaving, pitch
from plane_plate import mean_over, read_options, run_flusi, series

from flusi_msm.wing.file import write_wing
from flusi_msm.wing.shapes import make_strip

LONG, HIGH, FRONT = 6, 4, 2.0                # of the box, and the distance of the plate from its begin, in chords
CELLS = 48                                   # of the mesh along the plate
SPARS = 2 * math.pi * 0.1**4 / 64            # moment of area of the spars of the strip, m^4 per metre of width
BEATS, JUDGED = 7, 3                         # all, and the last ones, of which means are taken

# Heathcote & Gursul: a plate of steel, 60 of 90 mm, in water of 0.1 m/s; the front of 30 mm heaves by 17.5 mm.
YOUNG, STEEL, WATER, CHORD, SPEED = 2.05e11, 7850.0, 1000.0, 0.09, 0.1
HEAVE = 17.5 / 90
# Thickness of the plate over the chord, in thousandths; Strouhal number 2 f a/U: amplitude of the pitch, degrees, by the text, and
# amplitude of pitch and thrust coefficient as the figures were read.
MEASURED = {(0.56, 0.56): (17.0, 16.9, 1.88), (1.41, 0.56): (6.0, 5.5, None), (4.23, 0.56): (None, None, 2.11),
            (0.85, 0.345): (None, 5.35, 1.008), (4.23, 0.345): (None, None, 0.398)}


def steel(thickness, strouhal, points, stiffer=1.0, re=9000):
    """Returns the arguments of a run of Heathcote & Gursul's plate, in units of water density, chord and speed; E b^3/12 may be
    `stiffer`."""
    rigidity = stiffer * YOUNG * (1e-3 * thickness * CHORD)**3 / 12 / (WATER * SPEED**2 * CHORD**3)
    return {"frequency": strouhal / 2 / HEAVE, "amplitude": HEAVE, "rigidity": rigidity, "mass": STEEL / WATER * 1e-3 * thickness,
            "begin": 1 / 3, "re": re, "points": points}


def small(rigidity, points, re=1000, amplitude=0.05):
    """Returns the arguments of a run with a small motion: reduced frequency 2 on the half chord, mass rho c/10."""
    return {"frequency": 2 / math.pi, "amplitude": amplitude, "rigidity": rigidity, "mass": 0.1, "begin": 0.0, "re": re, "points": points}


CASES = {
    **{f"steel-{b}-{strouhal}-{n}": steel(b, strouhal, n) for b, strouhal in MEASURED for n in (32, 64)},
    **{f"steel-{b}-{strouhal}-32-wide": steel(b, strouhal, 32, 1 / (1 - 0.29**2)) for b, strouhal in MEASURED if b < 4},
    **{f"small-{b:g}-{n}": small(b, n) for b in (1000.0, 3.0, 1.0) for n in (16, 32, 64)},
}

INI = """\
; A plate in a stream along y whose front heaves along z. Units: chord, speed of the stream, density of the fluid.
[units]
length = 1.0
frequency = 1.0
density = 1.0
[Resolution]
nx = 1; two-dimensional
ny = {ny}
nz = {nz}
[Geometry]
yl = {yl}
zl = {zl}
[Time]
Tmax = {end!r}
CFL = 0.45
dt_max = {longest!r}
[ReynoldsNumber]
nu = {nu!r}
[InitialCondition]
inicond = MeanFlow
[Penalization]
iPenalization = yes
iMask = Insect
eps = 1e-2
[Insects]
wings = flexible
RightWing = no
x0 = 0.0 {front!r} {middle!r}
yawpitchroll_0 = 0.0 0.0 0.0
eta0 = -45.0; turns the wing at rest into the plane of body x and y
BodyMotion = from_file::heave.t
surface = thin
[Flexible_wing]
largest_deflection = 3.0
[Wing]
file = plate.h5
E = {young!r}
D = {membrane!r}
[Mass]
membrane_law = uniform
areal_density = {mass!r}
vein_density = 1e-9
[MeanFlow]
iMeanFlow = 1
ux = 0.0
uy = 1.0
uz = 0.0
[Sponge]
iVorticitySponge = yes
iSpongeType = 2D_frame
eps_sponge = 0.05
sponge_thickness = {sponge}
[Saving]
tintegral = {record!r}
iDoBackup = no
progress_interval = 300
"""


def heave(t, frequency, amplitude):
    """Returns the place of the front and its velocity at the time t: sin(2 pi f t), which grows over the first beat."""
    w, part = 2 * math.pi * frequency, min(t * frequency, 1.0)
    grown, rate = (1 - math.cos(math.pi * part)) / 2, math.pi * frequency * math.sin(math.pi * part) / 2
    return amplitude * grown * math.sin(w * t), amplitude * (rate * math.sin(w * t) + grown * w * math.cos(w * t))


def write(folder, frequency, amplitude, rigidity, mass, begin, re, points):
    """Writes the files of a run."""
    folder.mkdir(parents=True, exist_ok=True)
    wing = make_strip(1000.0, 1000.0, CELLS, 1e5)
    wing.root = [i for i, place in enumerate(wing.points) if place[0] <= begin + 1e-9]
    write_wing(folder / "plate.h5", wing)
    period = 1 / frequency
    rows = []
    for i in range(BEATS * 400 + 41):
        t = i * period / 400
        place, speed = heave(t, frequency, amplitude)
        rows.append(f"{t:.12e} 0 {FRONT} {HIGH / 2 + place:.12e} 0 0 {speed:.12e}  1 0 0 0  0 0 0\n")
    (folder / "heave.t").write_text("".join(rows))
    (folder / "run.ini").write_text(INI.format(
        ny=LONG * points, nz=HIGH * points, yl=float(LONG), zl=float(HIGH), end=BEATS * period, longest=period / 200, nu=1 / re,
        front=FRONT, middle=HIGH / 2, young=0.98 * rigidity / SPARS, membrane=0.02 * rigidity, mass=mass, sponge=points // 2,
        record=period / 100))


def harmonic(t, x, frequency):
    """Returns the complex amplitude of x at the frequency, over whole beats, relative to sin(2 pi f t)."""
    wave = np.exp(-2j * math.pi * frequency * t)
    return 2j * complex(mean_over(t, (x * wave).real), mean_over(t, (x * wave).imag))


def measure(folder, case):
    """Returns numbers of the last beats: amplitude and lead of the pitch in degrees, complex displacement of the rear edge over the
    amplitude of the heave, mean thrust, mean power, and the largest difference of the thrust between two beats."""
    frequency, amplitude = case["frequency"], case["amplitude"]
    end = BEATS / frequency
    tip = series(folder / "bending_left.t")
    inside = tip[:, 0] >= end - JUDGED / frequency - 1e-9
    t, along, across = tip[inside, 0], tip[inside, 1], -tip[inside, 3]
    angle = np.degrees(np.arctan2(across, 1 + along))
    bend = harmonic(t, across, frequency)
    forces, power = series(folder / "forces.t"), series(folder / "aero_power.t")
    time, thrust = forces[:, 0], -2 * (forces[:, 2] + forces[:, 5])
    work = 2 * np.interp(time, power[:, 0], power[:, 1])
    beats = [(time >= end - (k + 1) / frequency) & (time <= end - k / frequency) for k in range(JUDGED)]
    means = [mean_over(time[beat], thrust[beat]) for beat in beats]
    late = time >= end - JUDGED / frequency
    return {"pitch": float(np.ptp(angle) / 2), "lead": math.degrees(np.angle(bend)), "tip": abs(1 + bend / amplitude),
            "tip_lead": math.degrees(np.angle(1 + bend / amplitude)), "thrust": mean_over(time[late], thrust[late]),
            "power": mean_over(time[late], work[late]), "spread": max(means) - min(means)}


def table(root):
    found = {name: measure(root / name, case) for name, case in CASES.items() if (root / name / "done").exists()}
    print(f"{'case':22s}{'pitch':>8s}{'lead':>8s}{'tip/a':>8s}{'lead':>8s}{'thrust':>9s}{'power':>9s}{'spread':>8s}   theory: the same")
    for name, f in found.items():
        case = CASES[name]
        theory = heaving(*(case[key] for key in ("frequency", "amplitude", "rigidity", "mass", "begin")))
        angle, lead = pitch(theory, case["amplitude"])
        tip = theory["tip"] / case["amplitude"]
        f["theory"] = {"pitch": angle, "lead": lead, "tip": abs(tip), "tip_lead": math.degrees(np.angle(tip)),
                       "thrust": theory["thrust"], "power": theory["power"]}
        print(f"{name:22s}" + "".join(f"{f[key]:{w}}" for key, w in (("pitch", "8.2f"), ("lead", "8.1f"), ("tip", "8.3f"),
              ("tip_lead", "8.1f"), ("thrust", "9.3f"), ("power", "9.3f"), ("spread", "8.3f"))) + "   " + " ".join(
              f"{value:.4g}" for value in f["theory"].values()))
    return found


def draw(root, found, path):
    """Draws the pitch of the measured plates over the last beat, and the tip of those with small motions over the grid."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from flusi_msm.style import COLOURS, save, use_style
    use_style()
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.4))
    for (thickness, strouhal), colour in zip([key for key in MEASURED if key[1] == 0.56], COLOURS):
        for points, width in ((32, 1.0), (64, 2.0)):
            name = f"steel-{thickness}-{strouhal}-{points}"
            if name in found:
                tip, frequency = series(root / name / "bending_left.t"), CASES[name]["frequency"]
                late = tip[:, 0] >= (BEATS - 1) / frequency
                left.plot(tip[late, 0] * frequency - BEATS + 1, np.degrees(np.arctan2(-tip[late, 3], 1 + tip[late, 1])), color=colour,
                          lw=width, label=f"b/c = {thickness}e-3, c/dx = {points}")
        if MEASURED[thickness, strouhal][0]:
            for sign in (1, -1):
                left.axhline(sign * MEASURED[thickness, strouhal][0], color=colour, ls=":")
    left.set(xlabel="t/T", ylabel="pitch, degrees", title="dotted: measured amplitudes")
    left.legend(fontsize=7, loc="lower center")
    for rigidity, colour in zip((1.0, 3.0), COLOURS):
        names = [name for name in found if name.startswith(f"small-{rigidity:g}-")]
        if names:
            right.plot([1 / CASES[name]["points"] for name in names], [found[name]["tip"] for name in names], "o-", color=colour,
                       label=f"E I = {rigidity:g} $\\rho U^2c^3$")
            right.axhline(found[names[0]]["theory"]["tip"], color=colour, ls="--")
    right.set(xlabel="dx/c", ylabel="tip over heave", title="small motions; dashed: inviscid theory", xlim=(0, None))
    right.legend(fontsize=8)
    figure.tight_layout()
    save(figure, path)


def main():
    options = read_options(__doc__, CASES)
    for name in options.cases or CASES:
        folder = options.folder / name
        if not (folder / "done").exists():
            write(folder, **CASES[name])
            run_flusi(options.program, folder)
    found = table(options.folder)
    if options.picture:
        draw(options.folder, found, options.picture)
    print(json.dumps({name: {key: value if isinstance(value, dict) else round(value, 5) for key, value in f.items()}
                      for name, f in found.items()}))


if __name__ == "__main__":
    main()
