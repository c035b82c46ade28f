# SPDX-License-Identifier: GPL-3.0-or-later
"""The history of a training as msm_train writes it, with contents known in closed form."""
from pathlib import Path

import h5py
import numpy as np

NAMES = ["E", "joint:base", "joint:bend", "joint:tip", "joint:free", "zero:scale"]
UNITS = ["Pa", "N m/rad", "N m/rad", "N m/rad", "N m/rad", "m"]
LOWER = np.array([1e8, 1e-6, 1e-6, 1e-6, 1e-6, -1e-3])
UPPER = np.array([1e11, 1e-2, 1e-2, 1e-2, 1e-2, 1e-3])
VALUES = np.array([8e9, 3e-5, 7.7e-4, 4.4e-6, 5.5e-5, 1.2e-4])
# Well known, roughly known, a lower limit, an upper limit, nothing, and a number that may be negative.
INTERVALS = np.array([[7.9e9, 8e9, 8.1e9, 1, 1], [1e-5, 3e-5, 9e-5, 1, 1], [2e-4, 1e-2, 1e-2, 1, 0],
                      [1e-6, 1e-6, 3e-5, 0, 1], [1e-6, 5e-5, 1e-2, 0, 0], [1e-4, 1.2e-4, 1.4e-4, 1, 1]])
DIFFERENCE = 12e-6  # [m] between simulated and measured heights, of alternating sign


def generations():
    """Two runs of one stage, the second with twice the candidates: a restart at 60 of 180."""
    rows, done = [], 0
    for run, size, count in ((0, 6, 10), (1, 12, 10)):
        for k in range(1, count + 1):
            done += size
            best = 1e-4 * 0.9**len(rows)
            rows.append([1, run, k, size, done, best, 1.1 * best, 2 * best, 0.3 * 0.9**k, 10.0**(0.2 * k),
                         2 if k < 3 else 0, 1 if k < 4 else 0, *VALUES])
    rows = np.array(rows)
    rows[0, 5:8] = np.nan  # nothing was feasible yet
    return rows


def surface(nx=21, ny=9):
    """Rows x, y, measured, simulated in an order that is not that of a grid, with a hole."""
    x, y = np.meshgrid(np.linspace(0, 9e-3, nx), np.linspace(-3e-3, 1e-3, ny))
    measured = 1e-3 * (x / 9e-3)**2
    sign = np.where(np.arange(x.size) % 2 == 0, 1.0, -1.0).reshape(x.shape)
    rows = np.column_stack([x.ravel(), y.ravel(), measured.ravel(), (measured + DIFFERENCE * sign).ravel()])
    rows = rows[np.hypot(rows[:, 0] - 4.5e-3, rows[:, 1] + 1e-3) > 6e-4]
    return rows[np.random.default_rng(5).permutation(len(rows))]


def table(file, name, rows, columns):
    made = file.create_dataset(name, data=np.asarray(rows, "<f8"))
    made.attrs["columns"] = np.bytes_(columns)
    return made


def write_training(folder, name="train", loads=3, outcome=True, intervals=True, readings=False, changes=()):
    """NAME_history.h5 and NAME.log. `changes` are functions of the open file."""
    folder = Path(folder)
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}_history.h5"
    with h5py.File(path, "w") as file:
        for key, text in (("schema", "flusi-msm training history"), ("unknowns", " ".join(NAMES)),
                          ("units", ", ".join(UNITS)), ("cost", "h"), ("wing", "no/such/wing.h5"),
                          ("measurement", "bending <test>.h5")):
            file.attrs[key] = np.bytes_(text)
        file.attrs["version"] = np.array([1], "i4")
        file.attrs["lower"], file.attrs["upper"] = LOWER, UPPER
        table(file, "generations", generations(), "stage run generation ...")
        if outcome:
            write_outcome(file, loads, intervals, readings)
        for change in changes:
            change(file)
    (folder / f"{name}.log").write_text("search    CMA-ES\npolish    8 evaluations & <6> steps\n")
    return path


def write_outcome(file, n_loads, intervals, readings):
    rows = surface()
    group = file.create_group("outcome")
    group.attrs["values"] = VALUES
    h = np.sqrt(n_loads) * DIFFERENCE
    facts = {"h": h, "chi2": n_loads * len(rows) * (DIFFERENCE / 10e-6)**2, "cold_difference": 1e-15}
    for key, value in facts.items():
        group.attrs[key] = np.array([value])
    for key, value in (("residuals", n_loads * len(rows)), ("evaluations_behind_the_search", 77), ("is_polished", 1)):
        group.attrs[key] = np.array([value], "i4")
    group.attrs["singular_values"] = np.array([7e4, 300.0, 40.0, 3.0, 0.2, 0.01])
    sd = np.array([0.01, 0.7, 3, 3, 3, 1e-5])
    r = np.eye(len(sd))
    r[0, 1] = r[1, 0] = -0.97
    table(group, "covariance", r * np.outer(sd, sd), "as unknowns")
    table(group, "path", [[1, 900, 4, 30], [2, 700, 3, 30], [4, 640, 2, 3], [7, 610, 2, 1]],
          "evaluations chi2 prior_chi2 stage_errors")
    if intervals:
        table(group, "intervals", INTERVALS, "lower best upper has_lower has_upper")
        for name, (low, best, high, *_), is_log in zip(NAMES, INTERVALS, LOWER > 0):
            t = np.linspace(-1.2, 1.2, 9)
            width = np.log(high / low) / 2 if is_log else (high - low) / 2
            value = best * np.exp(t * width) if is_log else best + t * width
            table(file, f"profiles/{name}", np.column_stack([value, 2.7055 * t**2]), "value chi2_above_minimum") \
                .attrs["is_complete"] = np.array([1], "i4")
    for k in range(n_loads):
        made = table(file, f"loads/load_{k + 1}", rows, "x y measured computed")
        made.attrs.update(point=np.array([7e-3, -1e-3]), force=np.array([5e-4]), direction=np.array([0.0, 0, 1]),
                          chi2=np.array([len(rows) * 1.44]), is_solved=np.array([1], "i4"), violation=np.zeros(2))
    if readings:
        rows = [[1, 1e-3, 1.01e-3, 1e-5, 0], [1, 2e-3, 1.98e-3, 1e-5, 0], [2, 0.1, 0.11, 1e-2, 1]]
        made = table(file, "readings", rows,
                     "load measured computed sd is_rotation")
        made.attrs["names"], made.attrs["loads"] = np.bytes_("tip middle turn"), np.bytes_("load_1 load_2")
