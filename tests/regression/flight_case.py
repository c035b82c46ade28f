# SPDX-License-Identifier: GPL-3.0-or-later
"""A flight of two flexible wings, small enough for a test. The grid is far too coarse for physics."""
from whole_program import SOURCE, check

LAST_DIGIT = 2e-8  # series hold nine digits: a number may be rounded to its neighbour

FLIGHT = {
    "units": {"length": 9.0e-3, "frequency": 158, "density": 1.225},
    "Resolution": {"nx": 32, "ny": 32, "nz": 16},
    "Geometry": {"xl": 4.0, "yl": 4.0, "zl": 2.0},
    "Time": {"nt": 24, "dt_fixed": 4e-3},
    "ReynoldsNumber": {"nu": 1.2e-3},
    "InitialCondition": {"inicond": "MeanFlow"},
    "Penalization": {"iPenalization": 1, "iMask": "Insect", "eps": 5e-3},
    "Insects": {
        "wings": "flexible", "surface": "penalized", "x0": "2.0 2.0 1.0", "yawpitchroll_0": "180.0 0.0 0.0", "eta0": -70.0,
        "x_pivot_l": "0.0 0.5 0.0", "x_pivot_r": "0.0 -0.5 0.0", "wing_ramp": 0.05,
        "FlappingMotion_left": f"from_file::{SOURCE}/ini/kinematics/calliphora.ini",
        "FlappingMotion_right": f"from_file::{SOURCE}/ini/kinematics/calliphora.ini"},
    "Wing": {"file": f"{SOURCE}/wings/calliphora_small.h5", "preset": "paper"},
    "MeanFlow": {"iMeanFlow": 1, "ux": 0.95, "uy": 0.0, "uz": 0.0},
    "Saving": {"tintegral": 4e-3, "tsave": 0.05},
}


def largest(rows, column):
    return max(abs(row[column]) for row in rows)


def differences(one, other, n):
    """How far the first n steps of two flights are apart, by series and column of forces and bending, in the size of each."""
    apart = {}
    for name in ("forces.t", "bending_left.t", "bending_right.t"):
        b = other.series(name).rows
        a = one.series(name).rows[:len(b)]
        check(len(b) > n, f"{name} has a record of every step: {len(b)}")
        for column in range(10):
            # Small components are round-off of large ones: y forces of mirrored wings cancel. 2e-13 of the large
            # ones is left to them; the accelerations in the unsteady force amplify round-off by T/dt = 250.
            size = max(largest(a, column), 1e-5 * max(largest(a, c) for c in range(1, 10)))
            apart[f"{name}, column {column}"] = max(abs(x[column] - y[column]) for x, y in zip(a, b)) / size
    return apart


def same_flight(one, other, n, tolerance=LAST_DIGIT):
    """The n steps of `other` are those of `one`, by forces and bending: equal but for what another number of ranks changes."""
    for place, apart in differences(one, other, n).items():
        check(apart <= tolerance, f"{place}: {apart:.1e}")
