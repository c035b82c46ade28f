# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a measurement file (docs/formats/measurement-format.md) from height maps in CSV or NPZ files.

usage: import_heights LIST.csv -o measurement.h5 --height-units um --axis-units mm --force-units mN --height-sd 5

LIST.csv has a line of column names and one line for each map. The line whose id is `reference` is the unloaded wing.

    id,file,force,direction_x,direction_y,direction_z,point_x,point_y,order,time,hold,replicate
    reference,rest.csv
    tip,tip.npz,0.3,0,0,1,8.1,-0.5,1,60,30,1

force is in --force-units, point_x and point_y in --axis-units, time and hold in seconds; the columns from order on
may be left out. Names of files are relative to LIST.csv.

A CSV map has x in its first line (the first cell is ignored) and y in the first cell of every other line; empty cells
and `nan` are missing heights. An NPZ map holds arrays x, y and z, z[j, i] at (x[i], y[j]), and if wanted sigma, the
standard deviation of every height, in the units of z. All maps of a list lie on the same grid. Coordinates are those of
the wing file: x from root to tip, y toward the leading edge, z normal to both.
"""
import argparse
import csv
from pathlib import Path

import numpy as np

from flusi_msm.errors import InputError, run_command
from flusi_msm.measurement.file import write_measurement

LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
FORCES = {"N": 1.0, "mN": 1e-3, "uN": 1e-6}
NEEDED = ["id", "file", "force", "direction_x", "direction_y", "direction_z", "point_x", "point_y"]
OPTIONAL = ["order", "time", "hold", "replicate"]
FACTS = ["force_by_weight", "height_by_gauge", "position_by_marks", "order_is_random"]
SAME_GRID = 1e-9  # of the extent: how far grid lines of two maps may differ


def read_csv_map(path):
    """x, y, z of a CSV map, and None."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file) if row]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    if len(rows) < 3 or len(rows[0]) < 3:
        raise InputError(f"{path}: a map has at least two columns and two rows of heights")
    values = np.full((len(rows), len(rows[0])), np.nan)
    for j, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise InputError(f"{path}: line {j + 1} has {len(row)} cells, the first one {len(rows[0])}")
        for i, cell in enumerate(row):
            if (j, i) == (0, 0) or not cell.strip():
                continue
            try:
                values[j, i] = float(cell)
            except ValueError:
                raise InputError(f"{path}: line {j + 1}, cell {i + 1}: {cell.strip()!r} is not a number") from None
    return values[0, 1:], values[1:, 0], values[1:, 1:], None


def read_npz_map(path):
    """x, y, z of an NPZ map, and sigma or None."""
    try:
        with np.load(path) as arrays:
            missing = [name for name in "xyz" if name not in arrays]
            if missing:
                raise InputError(f"{path}: has no array {', '.join(missing)}")
            return *(np.asarray(arrays[name], float) for name in "xyz"), \
                np.asarray(arrays["sigma"], float) if "sigma" in arrays else None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error


def read_map(path):
    """x and y, increasing, and z[j, i] of a map; the standard deviations of z or None."""
    reader = {".csv": read_csv_map, ".npz": read_npz_map}.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path}: is neither a .csv nor a .npz file")
    x, y, z, sigma = reader(path)
    if x.ndim != 1 or y.ndim != 1 or z.shape != (y.size, x.size):
        raise InputError(f"{path}: z has the shape {z.shape}; {y.size} y and {x.size} x ask for ({y.size}, {x.size})")
    if sigma is not None and (sigma.shape != z.shape or not (np.isfinite(sigma) & (sigma > 0))[np.isfinite(z)].all()):
        raise InputError(f"{path}: sigma must have the shape of z, and be positive where there is a height")
    for name, axis in (("x", x), ("y", y)):
        steps = np.diff(axis)
        if not np.isfinite(axis).all() or not (np.all(steps > 0) or np.all(steps < 0)):
            raise InputError(f"{path}: {name} neither increases nor decreases from grid line to grid line")
    along_x, along_y = slice(None, None, -1 if x[0] > x[-1] else 1), slice(None, None, -1 if y[0] > y[-1] else 1)
    if np.isinf(z).any():
        raise InputError(f"{path}: has infinite heights; missing ones are empty or nan")
    if sigma is not None:
        sigma = np.where(np.isfinite(z), sigma, 1.0)[along_y, along_x]  # without a height it does not count
    return x[along_x], y[along_y], z[along_y, along_x], sigma


def read_list(path):
    """The rows of the list as dictionaries of texts."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file, skipinitialspace=True))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    names = set(rows[0]) if rows else set()
    wrong = [f"no column {name}" for name in NEEDED if name not in names]
    wrong += [f"unknown column {name}" for name in sorted(map(str, names - set(NEEDED + OPTIONAL)))]
    if wrong or not rows:
        raise InputError(f"{path}: {'; '.join(wrong) or 'is empty'}; columns are {','.join(NEEDED + OPTIONAL)}")
    return rows


def number(row, name, kind, path):
    try:
        return kind(row[name])
    except (TypeError, ValueError):
        raise InputError(f"{path}: {row['id']}: {name} is {row[name]!r}, not a number") from None


def facts_of(row, axis_unit, force_unit, path):
    """The attributes of a load."""
    facts = {"force": force_unit * number(row, "force", float, path),
             "direction": [number(row, "direction_" + axis, float, path) for axis in "xyz"],
             "point": [axis_unit * number(row, "point_" + axis, float, path) for axis in "xy"]}
    for name in OPTIONAL:
        if row.get(name):
            facts[name] = number(row, name, float if name in ("time", "hold") else int, path)
    return facts


def import_heights(path, axis_unit, height_unit, force_unit):
    """x, y, unloaded heights, loads and standard deviations by name (where the maps have them), in SI units, for
    write_measurement."""
    path = Path(path)
    x = y = unloaded = None
    loads, sigmas = {}, {}
    for row in sorted(read_list(path), key=lambda row: row["id"] != "reference"):
        name = row["id"]
        if not row["file"]:
            raise InputError(f"{path}: {name}: no file")
        this_x, this_y, z, sigma = read_map(path.parent / row["file"])
        if sigma is not None:
            sigmas[name] = height_unit * sigma
        if unloaded is None:
            if name != "reference":
                raise InputError(f"{path}: no line has the id reference")
            x, y, unloaded = this_x, this_y, z
            continue
        if name in loads or name == "reference":
            raise InputError(f"{path}: {name} is listed twice")
        for letter, axis, first in (("x", this_x, x), ("y", this_y, y)):
            if axis.size != first.size or np.abs(axis - first).max() > SAME_GRID * np.ptp(first):
                raise InputError(f"{path}: {name}: {letter} of its map differs from that of the reference")
        loads[name] = (height_unit * z, facts_of(row, axis_unit, force_unit, path))
    if not loads:
        raise InputError(f"{path}: lists no load")
    return axis_unit * x, axis_unit * y, height_unit * unloaded, loads, sigmas


def calibration_of(texts):
    """The facts `name=0` or `name=1` that are known."""
    facts = {}
    for text in texts:
        name, _, value = text.partition("=")
        if name not in FACTS or value not in ("0", "1"):
            raise InputError(f"--calibration {text}: write NAME=0 or NAME=1, NAME one of {', '.join(FACTS)}")
        facts[name] = int(value)
    return facts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("list", metavar="LIST.csv")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="measurement file to write")
    parser.add_argument("--height-units", required=True, choices=LENGTHS, help="of z")
    parser.add_argument("--axis-units", required=True, choices=LENGTHS, help="of x, y and points of application")
    parser.add_argument("--force-units", required=True, choices=FORCES)
    parser.add_argument("--height-sd", type=float, required=True, metavar="SD",
                        help="standard deviation of one height, in --height-units")
    parser.add_argument("--force-gain-sd", type=float, default=0, metavar="SD",
                        help="relative standard deviation of all forces together (default: 0)")
    parser.add_argument("--force-sd", type=float, default=0, metavar="SD",
                        help="of each force, in --force-units (default: 0)")
    parser.add_argument("--position-sd", type=float, default=0, metavar="SD",
                        help="of points of application, in --axis-units (default: 0)")
    parser.add_argument("--tilt-sd", type=float, default=0, metavar="SD",
                        help="of the tilt of each scan about x and about y [rad] (default: 0)")
    parser.add_argument("--piston-sd", type=float, default=0, metavar="SD",
                        help="of a constant added to each scan, in --height-units (default: 0)")
    parser.add_argument("--correlation-length", type=float, default=0, metavar="LENGTH",
                        help="of the errors of neighbouring heights, in --axis-units (default: 0)")
    parser.add_argument("--calibration", action="append", default=[], metavar="NAME=0|1",
                        help=f"what is known of it, may be repeated: {', '.join(FACTS)}")
    parser.add_argument("--title", default="", help="for people")
    options = parser.parse_args()
    height_unit, axis_unit = LENGTHS[options.height_units], LENGTHS[options.axis_units]
    force_unit = FORCES[options.force_units]
    accuracy = {"height": height_unit * options.height_sd, "force": force_unit * options.force_sd,
                "force_gain": float(options.force_gain_sd), "position": axis_unit * options.position_sd,
                "tilt": float(options.tilt_sd), "piston": height_unit * options.piston_sd,
                "correlation_length": axis_unit * options.correlation_length}
    for name, value in accuracy.items():
        if not (np.isfinite(value) and (value > 0 if name == "height" else value >= 0)):
            option = name if name == "correlation_length" else name + "_sd"
            raise InputError(f"--{option.replace('_', '-')} must {'be positive' if name == 'height' else 'not be negative'}")
    calibration = calibration_of(options.calibration)
    x, y, unloaded, loads, sigmas = import_heights(options.list, axis_unit, height_unit, force_unit)
    write_measurement(options.output, x, y, unloaded, loads, accuracy, calibration, options.title,
                      sigmas.pop("reference", None), sigmas)
    known = np.isfinite(unloaded)
    print(f"{options.output}: {len(loads)} loads on a grid of {x.size} x {y.size} points, "
          f"{1e3 * np.ptp(x):.3g} mm x {1e3 * np.ptp(y):.3g} mm, {known.mean():.0%} of the unloaded heights known")
    for name, (z, facts) in sorted(loads.items()):
        deformation = (z - unloaded)[known & np.isfinite(z)]
        largest = f"{1e6 * np.abs(deformation).max():.4g} um" if deformation.size else "unknown"
        print(f"  {name}: {1e3 * facts['force']:.4g} mN, largest deformation {largest}")


def command() -> None:
    run_command("import_heights", main)
