#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Means over time: against an exact solution, over a restart to the bit, on any number of ranks.

usage: flusi_averages.py <flusi> <h5dump> [tests]
"""
import math

from whole_program import check, close, main, merged

NU, START, END, DT = 0.5, 0.2, 1.0, 0.02
# A vortex u = (sin y cos z, -cos y sin z) exp(-2 nu t) in the plane, whose energy density falls as exp(-4 nu t).
VORTEX = {
    "Resolution": {"nx": 1, "ny": 16, "nz": 16},
    "Time": {"Tmax": END, "dt_fixed": DT},
    "ReynoldsNumber": {"nu": NU},
    "InitialCondition": {"inicond": "taylor_green_2d"},
    "MeanFlow": {"ux": 0.0},
    "Saving": {"tsave": 0.5, "field_precision": "double", "iSaveVelocity": "yes"},
    "Averaging": {"time_avg": "yes", "vel_avg": "yes", "ekin_avg": "yes", "enstrophy_avg": "yes", "tstart_avg": START},
}
NAMES = ("uavgx", "uavgy", "uavgz", "ekinavg", "zavg")


def mean_decay(rate):
    """Mean of exp(-rate t) from START to END, by the trapezoidal rule with the step DT; the rule is the program's."""
    n = round((END - START) / DT)
    values = [math.exp(-rate * (START + i * DT)) for i in range(n + 1)]
    return (sum(values) - (values[0] + values[-1]) / 2) / n


def test_exact(case):
    case.write("run.ini", VORTEX)
    case.run("run.ini", ranks=2)
    h = 2 * math.pi / 16
    points = [(j * h, k * h) for k in range(16) for j in range(16)]
    velocity, energy = mean_decay(2 * NU), mean_decay(4 * NU)
    exact = (1 - math.exp(-2 * NU * (END - START))) / (2 * NU * (END - START)) * math.exp(-2 * NU * START)
    check(abs(velocity - exact) < 2e-4 * exact, f"the rule is close to the integral: {velocity}, {exact}")
    want = {
        "uavgx": [0.0 for _ in points],
        "uavgy": [velocity * math.sin(y) * math.cos(z) for y, z in points],
        "uavgz": [-velocity * math.cos(y) * math.sin(z) for y, z in points],
        "ekinavg": [energy / 2 * (math.sin(y) ** 2 * math.cos(z) ** 2 + math.cos(y) ** 2 * math.sin(z) ** 2)
                    for y, z in points],
        "zavg": [energy / 2 * (2 * math.sin(y) * math.sin(z)) ** 2 for y, z in points],
    }
    for name in NAMES:
        worst = max(abs(a - b) for a, b in zip(case.field(f"{name}_000.h5"), want[name]))
        check(worst < 1e-12, f"{name} is the mean of the exact solution: {worst:.1e}")
        check(abs(case.attribute(f"{name}_000.h5", "time")[0] - END) < 1e-12, f"{name} ends with the run")


def test_restart(case):
    """One file each, or one for every save; and what a restart makes of them."""
    ini = merged(VORTEX, {"Averaging": {"save_one_only": "no"}, "Resolution": {"nx": 8, "ny": 8, "nz": 12},
                          "InitialCondition": {"inicond": "taylor_green"}})
    whole, parts, three = case.sub("whole"), case.sub("parts"), case.sub("three")
    for folder, steps, ranks in ((whole, 50, 2), (parts, 31, 2), (three, 50, 3)):
        folder.write("run.ini", merged(ini, {"Time": {"nt": steps}}))
        folder.run("run.ini", ranks=ranks)
    parts.write("run.ini", ini)
    parts.run("run.ini", "--restart", ranks=2)
    saved = [n for n in whole.files() if n.startswith("ekinavg_")]
    check(saved == ["ekinavg_000500.h5", "ekinavg_001000.h5"], f"means are saved with the fields, not before: {saved}")
    for name in (f"{n}_001000.h5" for n in NAMES):
        check(whole.field(name) == parts.field(name), f"{name} is the same after a restart, to the bit")
        close(whole.field(name), three.field(name), 1e-12, f"{name} on three ranks")
    whole.check_index("run.xmf")


if __name__ == "__main__":
    main(globals())
