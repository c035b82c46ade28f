# SPDX-License-Identifier: GPL-3.0-or-later
"""The wing of a blowfly (Calliphora), drawn by hand after its venation: not a digitised specimen.

The named veins, their order along the margin, their branchings, the bend of M1+2 and the cross-veins are those
of the family; positions are rounded to what a drawing allows. Length 9.01 mm and mean chord 3.0 mm are the
means of nine wings in Truong et al.; the drawing is scaled to them. The diameters taper from 100 um at the root
to 20 um and were chosen so that solid veins of 1300 kg/m^3 weigh 67.41 % of 250 ug, as theirs do.
"""
from flusi_msm.wing.curves import Drawing, polygon_area
from flusi_msm.wing.file import WingMass

LENGTH, MEAN_CHORD = 9.01, 3.0  # mm

# Where veins meet each other or the margin (mm before scaling).
PLACES = {
    "root C": (0.0, 0.34), "root Sc": (0.0, 0.17), "root R": (0.0, -0.02), "root M": (0.0, -0.22),
    "root A": (0.0, -0.44),
    "C h": (0.95, 0.66), "Sc h": (1.02, 0.40), "C Sc": (4.15, 1.03), "C R1": (5.55, 0.97),
    "C R2+3": (7.55, 0.50), "C R4+5": (8.72, -0.30), "C M1+2": (8.90, -0.56), "tip": (9.01, -0.98),
    "R Rs": (1.35, 0.17), "Rs fork": (2.15, -0.03), "R r-m": (4.55, -0.47), "M r-m": (4.62, -1.10),
    "M CuA": (0.75, -0.32), "M bm-cu": (2.35, -0.72), "CuA bm-cu": (2.42, -1.18), "M dm-cu": (6.15, -1.27),
    "CuA dm-cu": (5.42, -2.20), "M bend": (7.28, -1.40), "CuA margin": (6.10, -2.78),
    "CuA CuA2": (1.62, -0.80), "A CuA2": (1.62, -1.16), "A margin": (3.12, -2.47), "A A2": (0.70, -0.68),
    "notch": (1.46, -1.50),
}

# Leading edge to the tip, then back along the trailing edge, then the root edge; the veins.
CURVES = {
    "C": ("root C", (0.45, 0.50), "C h", (1.8, 0.82), (2.9, 0.95), "C Sc", (4.85, 1.03), "C R1", (6.3, 0.86),
          (7.0, 0.68), "C R2+3", (8.0, 0.27), (8.4, 0.02), "C R4+5", "C M1+2"),
    "margin": ("C M1+2", "tip", (8.96, -1.32), (8.75, -1.68), (8.38, -2.02), (7.8, -2.35), (7.0, -2.63),
               "CuA margin", (5.2, -2.83), (4.1, -2.72), "A margin", (2.50, -2.24), (1.98, -1.93), (1.66, -1.70),
               "notch", (1.28, -1.55), (1.00, -1.62), (0.68, -1.50), (0.36, -1.14), (0.13, -0.74), "root A"),
    "edge": ("root A", "root M", "root R", "root Sc", "root C"),
    "Sc": ("root Sc", (0.5, 0.30), "Sc h", (1.8, 0.52), (2.8, 0.62), (3.6, 0.75), "C Sc"),
    "R1": ("root R", (0.65, 0.07), "R Rs", (2.3, 0.27), (3.4, 0.34), (4.3, 0.46), (5.0, 0.68), "C R1"),
    "R4+5": ("R Rs", (1.62, 0.03), "Rs fork", (2.45, -0.17), (3.0, -0.29), (3.7, -0.39), "R r-m", (5.5, -0.49), (6.6, -0.46), (7.7, -0.40),
             "C R4+5"),
    "R2+3": ("Rs fork", (2.6, 0.01), (3.2, 0.03), (4.2, 0.06), (5.4, 0.15), (6.5, 0.27), "C R2+3"),
    "M1+2": ("root M", "M CuA", (1.5, -0.50), "M bm-cu", (3.5, -0.96), "M r-m", (5.4, -1.19), "M dm-cu",
             (6.75, -1.35), (7.08, -1.40), "M bend", (7.42, -1.25), (7.62, -0.98), (7.95, -0.79), (8.4, -0.68),
             "C M1+2"),
    "CuA1": ("M CuA", (1.02, -0.49), (1.3, -0.63), "CuA CuA2", "CuA bm-cu", (3.3, -1.52), (4.4, -1.88), "CuA dm-cu",
             (5.82, -2.48), "CuA margin"),
    "A1+CuA2": ("root A", (0.36, -0.54), "A A2", (1.2, -0.93), "A CuA2", (2.3, -1.66), (2.78, -2.08), "A margin"),
    "A2": ("A A2", (0.90, -0.96), (1.18, -1.26), "notch"),
    "h": ("C h", "Sc h"),
    "r-m": ("R r-m", "M r-m"),
    "bm-cu": ("M bm-cu", "CuA bm-cu"),
    "dm-cu": ("M dm-cu", (6.02, -1.58), (5.64, -1.88), "CuA dm-cu"),
    "CuA2": ("CuA CuA2", "A CuA2"),
}
# The wing of 250 ug of Truong et al., whose veins are 67.41 % of it, and their law of its membrane.
MASS = WingMass("bilinear", 81.475e-9, "Truong et al.: blowfly wing of 250 ug, veins 67.41 %", (1.75, -147.0, 101.0), 1300.0)

NOT_VEINS = ("margin", "edge")

# Diameters [um] at parts of the length of a vein, linear in between.
DIAMETERS = {
    "C": ((0, 100), (0.45, 78), (0.8, 47), (1, 24)),
    "Sc": ((0, 62), (1, 28)),
    "R1": ((0, 98), (0.3, 84), (1, 34)),
    "R4+5": ((0, 70), (0.15, 62), (1, 22)),
    "R2+3": ((0, 54), (1, 22)),
    "M1+2": ((0, 80), (0.3, 62), (0.75, 39), (1, 20)),
    "CuA1": ((0, 66), (0.5, 48), (1, 20)),
    "A1+CuA2": ((0, 64), (1, 20)),
    "A2": ((0, 30), (1, 20)),
    "h": ((0, 45), (1, 40)),
    "r-m": ((0, 40), (1, 40)),
    "bm-cu": ((0, 36), (1, 34)),
    "dm-cu": ((0, 38), (1, 32)),
    "CuA2": ((0, 34), (1, 30)),
}

# Ten joints. (vein, place): at that place of the vein. (vein, vein, place): where the second vein begins on the
# first one, from the first one's point before the place into the second one.
JOINTS = {
    "C_h": ("C", "C h"),                    # humeral break
    "C_Sc": ("C", "C Sc"),                  # subcostal break
    "R1_Rs": ("R1", "R Rs"),
    "R4+5_base": ("R1", "R4+5", "R Rs"),
    "R2+3_base": ("R4+5", "R2+3", "Rs fork"),
    "R4+5_r-m": ("R4+5", "R r-m"),
    "M1+2_bm-cu": ("M1+2", "M bm-cu"),
    "M1+2_bend": ("M1+2", "M bend"),
    "CuA1_base": ("M1+2", "CuA1", "M CuA"),
    "A1+CuA2_CuA2": ("A1+CuA2", "A CuA2"),
}


def drawing() -> Drawing:
    """Returns the wing scaled to LENGTH and to the area LENGTH * MEAN_CHORD."""
    wing = Drawing()
    for name, place in PLACES.items():
        wing.place(name, *place)
    for name, curve in CURVES.items():
        wing.curve(name, *curve)
    outline = [p for name in ("C", "margin", "edge") for p in wing.dense(name)[0][:-1]]
    sx = LENGTH / max(p[0] for p in outline)
    sy = LENGTH * MEAN_CHORD / (sx * abs(polygon_area(outline)))
    wing.scale(sx, sy)
    return wing


def diameter(vein: str, part: float) -> float:
    """Returns the diameter [m] of a vein at a part of its length."""
    table = DIAMETERS[vein]
    for (s0, d0), (s1, d1) in zip(table, table[1:]):
        if part <= s1:
            return 1e-6 * (d0 + (d1 - d0) * (part - s0) / (s1 - s0))
    return 1e-6 * table[-1][1]
