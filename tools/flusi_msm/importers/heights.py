# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a measurement file (docs/formats/measurement-format.md) from height maps in CSV, NPZ, TIFF or MAT files.

usage: import_heights LIST.csv|FOLDER -o measurement.h5 --height-units um --axis-units mm --force-units mN --height-sd 5

LIST.csv has a line of column names and one line for each map. The line whose id is `reference` is the unloaded wing; if there are
several such lines their mean is used.

    id,file,force,direction_x,direction_y,direction_z,point_x,point_y,order,time,hold,replicate
    reference,rest.csv
    tip,tip.npz,0.3,0,0,1,8.1,-0.5,1,60,30,1

force is in --force-units, point_x and point_y in --axis-units, time and hold in seconds; the columns from order on
may be left out. Names of files are relative to LIST.csv. A FOLDER holds list.csv, or loads.csv (the same table without `file`),
reference.* or reference_1.*, reference_2.*, ..., a map ID.* for every line, and if wanted landmarks.csv.

Maps are one of these: a table with x in its first line and y in the first cell of every other line (CSV; the separator and the
decimal sign are recognised and printed); a line `x,y,z` for every height (CSV); arrays x, y, z with z[j, i] at (x[i], y[j]), and
if wanted sigma (NPZ, MAT); grey pictures (TIFF, 16 or 32 bit; --pixel, --height-per-count). All maps of a set have the same grid.

Coordinates of the maps are those of the wing file (x from root to tip, y toward the leading edge, z normal to both), or
--landmarks or --outline with --wing turn and shift the scan into that frame. Check the picture that shows the result.
docs/guide/import-data.md explains all of this.
"""
from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.errors import InputError, Problems, run_command
from flusi_msm.importers.height_sets import REFERENCE, HeightSet, attempt, read_height_set
from flusi_msm.importers.landmarks import read_landmarks
from flusi_msm.importers.maps import Pixels
from flusi_msm.importers.registration import Registration, by_landmarks, by_outline, find_outliers, is_inside, outline_of, resampled
from flusi_msm.measurement.file import write_measurement
from flusi_msm.measurement.grid import grid_lines
from flusi_msm.wing.file import Wing, read_wing

LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
FORCES = {"N": 1.0, "mN": 1e-3, "uN": 1e-6}
FACTS = ["force_by_weight", "height_by_gauge", "position_by_marks", "order_is_random"]
STILL = 1e-9  # of the extent: a rotation that moves no point by more is ignored


def calibration_of(texts: Iterable[str], problems: Problems) -> dict[str, int]:
    """Returns the facts `name=0` or `name=1` that are known."""
    facts = {}
    for text in texts:
        name, _, value = text.partition("=")
        if name not in FACTS or value not in ("0", "1"):
            problems.error(f"--calibration {text}: write NAME=0 or NAME=1, NAME one of {', '.join(FACTS)}")
        else:
            facts[name] = int(value)
    return facts


def in_si(found: HeightSet, options: argparse.Namespace, height_sd: float) -> HeightSet:
    """Returns the set in SI units, after --flip, and with the sd of every height."""
    axis, height = LENGTHS[options.axis_units], LENGTHS[options.height_units]
    signs = {"x": 1.0, "y": 1.0, "z": 1.0, **{name: -1.0 for name in options.flip}}
    order = tuple(slice(None, None, int(signs[name])) for name in "yx")
    sigma = {name: height * found.sigma.get(name, np.full(z.shape, height_sd / height))[order] for name, z in found.z.items()}
    if REFERENCE not in found.sigma:
        sigma[REFERENCE] = sigma[REFERENCE] / np.sqrt(np.maximum(found.scans[order], 1))
    facts = {name: {**load, "force": load["force"] * FORCES[options.force_units],
                    "direction": [signs[a] * v for a, v in zip("xyz", load["direction"])],
                    "point": [signs[a] * axis * v for a, v in zip("xy", load["point"])]} for name, load in found.facts.items()}
    return replace(found, x=np.sort(signs["x"] * axis * found.x), y=np.sort(signs["y"] * axis * found.y),
                   z={name: signs["z"] * height * z[order] for name, z in found.z.items()}, sigma=sigma, facts=facts)


def register(found: HeightSet, wing: Wing | None, options: argparse.Namespace, problems: Problems) -> Registration:
    """Returns how the scan lies on the wing."""
    landmarks = options.landmarks or found.landmarks
    if options.outline and wing is not None:
        return by_outline(found.x, found.y, np.isfinite(found.z[REFERENCE]), wing, problems)
    if not landmarks:
        return Registration()
    names, scan, places = read_landmarks(Path(landmarks), wing, LENGTHS[options.axis_units], problems)
    if problems.errors:
        return Registration()
    return by_landmarks(names, scan * [-1 if a in options.flip else 1 for a in "xy"], places, problems)


def mask_outside(found: HeightSet, line: np.ndarray, registration: Registration) -> tuple[HeightSet, int]:
    """Removes the heights outside the wing; returns how many of them the unloaded wing had."""
    gx, gy = np.meshgrid(found.x, found.y)
    inside = is_inside(line, registration(np.stack([gx.ravel(), gy.ravel()], 1))).reshape(gx.shape)
    dropped = int((np.isfinite(found.z[REFERENCE]) & ~inside).sum())
    return replace(found, z={name: np.where(inside, z, np.nan) for name, z in found.z.items()}), dropped


def placed(found: HeightSet, registration: Registration, line: np.ndarray | None, options: argparse.Namespace) -> tuple[HeightSet, bool]:
    """Returns the set on grid lines of the wing's frame. Heights are only interpolated if the scan is turned."""
    extent = np.hypot(np.ptp(found.x), np.ptp(found.y))
    facts = {}
    for name, load in found.facts.items():
        direction = [*(registration.turn @ load["direction"][:2]), load["direction"][2]]
        facts[name] = {**load, "direction": [float(v) for v in direction],
                       "point": [float(v) for v in registration(np.array(load["point"]))]}
    if abs(registration.angle()) < STILL and not options.spacing:
        return replace(found, x=found.x + registration.shift[0], y=found.y + registration.shift[1], facts=facts), False
    step = (np.ptp(found.x) / (found.x.size - 1) * np.ptp(found.y) / (found.y.size - 1))**0.5
    spacing = LENGTHS[options.axis_units] * options.spacing if options.spacing else 2 * step
    if line is None:
        gx, gy = np.meshgrid(found.x, found.y)
        known = np.isfinite(found.z[REFERENCE])
        line = registration(np.stack([gx[known], gy[known]], 1))
    (x0, y0), (x1, y1) = line.min(0), line.max(0)
    if min(x1 - x0, y1 - y0) < spacing or extent / spacing > 5000:
        raise InputError(f"--spacing: {1e3 * spacing:.4g} mm gives less than two or more than 5000 lines")
    x, y = grid_lines(x0, x1, spacing), grid_lines(y0, y1, spacing)
    z, sigma = {}, {}
    for name, heights in found.z.items():
        z[name], sigma[name] = resampled(found.x, found.y, heights, found.sigma[name], x, y, registration,
                                         options.correlation_length > 0)
        sigma[name] = np.where(np.isfinite(z[name]), sigma[name], 1.0)
    return replace(found, x=x, y=y, z=z, sigma=sigma, facts=facts), True


def find_all_outliers(found: HeightSet, height_sd: float) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Returns the marks of the outliers of every map and their places (n, 2) [m]. For maps of loads the changes of the heights
    are tested, where they are known."""
    rest = found.z[REFERENCE]
    marks = {REFERENCE: find_outliers(rest, height_sd)}
    for name, z in found.z.items():
        if name != REFERENCE:
            marks[name] = find_outliers(z - np.where(marks[REFERENCE], np.nan, rest), height_sd * np.sqrt(2))
    gx, gy = np.meshgrid(found.x, found.y)
    return marks, {name: np.stack([gx[mark], gy[mark]], 1) for name, mark in marks.items()}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Adds all options to the parser."""
    parser.add_argument("list", metavar="LIST.csv|FOLDER")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="measurement file to write")
    parser.add_argument("--height-units", required=True, choices=LENGTHS, help="of z")
    parser.add_argument("--axis-units", required=True, choices=LENGTHS, help="of x, y, points of application and landmarks")
    parser.add_argument("--force-units", required=True, choices=FORCES)
    parser.add_argument("--height-sd", type=float, required=True, metavar="SD",
                        help="standard deviation of one height, in --height-units")
    for name, words in (("force-gain", "relative standard deviation of all forces together"), ("force", "of each force, in --force-units"),
                        ("position", "of points of application, in --axis-units"),
                        ("tilt", "of the tilt of each scan about x and about y [rad]"),
                        ("piston", "of a constant added to each scan, in --height-units")):
        parser.add_argument(f"--{name}-sd", type=float, default=0, metavar="SD", help=words + " (default: 0)")
    parser.add_argument("--correlation-length", type=float, default=0, metavar="LENGTH",
                        help="of the errors of neighbouring heights, in --axis-units (default: 0)")
    parser.add_argument("--calibration", action="append", default=[], metavar="NAME=0|1",
                        help=f"what is known of it, may be repeated: {', '.join(FACTS)}")
    parser.add_argument("--title", default="", help="for people")
    group = parser.add_argument_group("frame of the scan")
    group.add_argument("--wing", metavar="WING.h5", help="wing file; heights beside the wing are taken away")
    where = group.add_mutually_exclusive_group()
    where.add_argument("--landmarks", metavar="FILE.csv", help="places in the scan and in the wing: columns name, x, y, and wing_x, wing_y "
                       "unless the name is a place of --wing (root, tip, joint:NAME, vein:NAME:first, vein:NAME:last)")
    where.add_argument("--outline", action="store_true", help="lay the margin of the heights on the outline of --wing")
    group.add_argument("--flip", action="append", default=[], choices=["x", "y", "z"],
                       help="this axis of the scan runs the other way; may be repeated. Pictures whose rows run downward: y")
    group.add_argument("--spacing", type=float, metavar="LENGTH", help="of the grid lines, in --axis-units (default: as scanned; if the scan "
                       "must be turned, twice that, which keeps errors of neighbours independent)")
    group = parser.add_argument_group("pictures (TIFF)")
    group.add_argument("--pixel", type=float, nargs="+", metavar="SIZE", help="size of a pixel, in --axis-units (along x, along y)")
    group.add_argument("--height-per-count", type=float, metavar="H", help="height of one step of an integer, in --height-units")
    group.add_argument("--zero-count", type=float, default=0, metavar="N", help="number that means height 0 (default: 0)")
    group.add_argument("--missing-count", type=float, metavar="N", help="number that means no height")
    group = parser.add_argument_group("what is shown")
    group.add_argument("--drop-outliers", action="store_true", help="take heights away that differ from their neighbours by more than 6 sd")
    group.add_argument("--picture", metavar="FILE.png", help="picture of maps, mask, outliers (default: beside the output)")
    group.add_argument("--no-picture", action="store_true")


def accuracy_of(options: argparse.Namespace, problems: Problems) -> dict[str, float]:
    """Returns the declared errors in SI units."""
    height, axis = LENGTHS[options.height_units], LENGTHS[options.axis_units]
    accuracy = {"height": height * options.height_sd, "force": FORCES[options.force_units] * options.force_sd,
                "force_gain": float(options.force_gain_sd), "position": axis * options.position_sd,
                "tilt": float(options.tilt_sd), "piston": height * options.piston_sd,
                "correlation_length": axis * options.correlation_length}
    for name, value in accuracy.items():
        if not (np.isfinite(value) and (value > 0 if name == "height" else value >= 0)):
            option = name if name == "correlation_length" else name + "_sd"
            problems.error(f"--{option.replace('_', '-')} must {'be positive' if name == 'height' else 'not be negative'}")
    return accuracy


def check_options(options: argparse.Namespace, problems: Problems) -> tuple[Wing | None, Pixels]:
    """Checks that options do not contradict each other; returns the wing or None, and the data that pictures do not contain."""
    wing = attempt(problems, lambda: read_wing(options.wing)) if options.wing else None
    if options.outline and not options.wing:
        problems.error("--outline needs --wing WING.h5")
    if options.pixel and (len(options.pixel) > 2 or not min(options.pixel) > 0):
        problems.error("--pixel takes one positive size, or two, along x and along y")
    if options.spacing is not None and not options.spacing > 0:
        problems.error("--spacing must be positive")
    size = (options.pixel[0], options.pixel[-1]) if options.pixel else None
    return wing, Pixels(size, options.height_per_count, options.zero_count, options.missing_count)


def notes_of(found: HeightSet) -> list[str]:
    """Describes how the files were understood, in one line for maps that are alike."""
    by_note: dict[str, list[str]] = {}
    for name, notes in found.notes.items():
        by_note.setdefault(", ".join(notes), []).append(name)
    return [f"{', '.join(names[:4])}{' and others' if len(names) > 4 else ''}: {note}" for note, names in by_note.items() if note]


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser)
    options = parser.parse_args()
    problems = Problems()
    accuracy = accuracy_of(options, problems)
    calibration = calibration_of(options.calibration, problems)
    wing, pixels = check_options(options, problems)
    found = read_height_set(Path(options.list), pixels, problems)
    problems.stop_if_any()
    assert found is not None  # without it there are mistakes
    raw = found
    found = in_si(found, options, accuracy["height"])
    registration = register(found, wing, options, problems)
    problems.stop_if_any()
    line = outline_of(wing) if wing is not None and len(wing.triangles) else None
    dropped = 0
    if line is not None:
        found, dropped = mask_outside(found, line, registration)
    marks, outliers = find_all_outliers(found, accuracy["height"])
    outliers = {name: registration(places) for name, places in outliers.items()}
    if options.drop_outliers:
        found = replace(found, z={name: np.where(marks[name], np.nan, z) for name, z in found.z.items()})
    found, is_turned = placed(found, registration, line, options)
    unloaded = found.z[REFERENCE]
    loads = {name: (found.z[name], facts) for name, facts in found.facts.items()}
    for name, (z, facts) in loads.items():
        if not np.isfinite(z - unloaded).any():
            problems.error(f"{name}: no place has a height in its map and in that of the unloaded wing"
                           + (" on the wing" if line is not None else ""))
        if line is not None and not is_inside(line, np.array([facts["point"]]))[0]:
            problems.notice(f"{name}: its force acts beside the outline of the wing, at ({1e3 * facts['point'][0]:.3f}, "
                            f"{1e3 * facts['point'][1]:.3f}) mm")
    problems.stop_if_any()
    sigmas = {name: found.sigma[name] for name in loads if is_turned or name in raw.sigma}
    has_own = is_turned or REFERENCE in raw.sigma or found.scans.max() > 1
    write_measurement(options.output, found.x, found.y, unloaded, loads, accuracy, calibration, options.title,
                      found.sigma[REFERENCE] if has_own else None, sigmas)
    tell(options, found, loads, registration, notes_of(raw), problems.notices, dropped, outliers, is_turned)
    if not options.no_picture:
        from flusi_msm.importers.preview import draw_preview
        draw_preview(options.picture or Path(options.output).with_suffix(".png"), found.x, found.y, found.z,
                     {name: np.array(facts["point"]) for name, (_, facts) in loads.items()}, outliers, line, registration)


def tell(options: argparse.Namespace, found: HeightSet, loads: Mapping[str, tuple[np.ndarray, dict[str, Any]]],
         registration: Registration, notes: Iterable[str], notices: Iterable[str], dropped: int, outliers: Mapping[str, np.ndarray],
         is_turned: bool) -> None:
    """Prints how the files were understood, and what was written."""
    unloaded = found.z[REFERENCE]
    known = np.isfinite(unloaded)
    for text in notes:
        print(text)
    if registration.how != "axes as they are":
        print("\n".join(registration.report()))
    for text in notices:
        print("notice: " + text)
    if dropped:
        print(f"{dropped} heights of the unloaded scan lie beside the wing and are left out")
    if is_turned:
        print(f"heights are interpolated to a grid of {1e3 * np.diff(found.x).mean():.4g} mm; their sd are those of the interpolation")
    for name, places in outliers.items():
        if len(places):
            print(f"{name}: {len(places)} outliers (more than 6 sd), {'left out' if options.drop_outliers else 'kept: see --drop-outliers'}")
    print(f"{options.output}: {len(loads)} loads on a grid of {found.x.size} x {found.y.size} points, "
          f"{1e3 * np.ptp(found.x):.3g} mm x {1e3 * np.ptp(found.y):.3g} mm, {known.mean():.0%} of the unloaded heights known")
    for name, (z, facts) in sorted(loads.items()):
        deformation = (z - unloaded)[known & np.isfinite(z)]
        print(f"  {name}: {1e3 * facts['force']:.4g} mN at ({1e3 * facts['point'][0]:.3f}, {1e3 * facts['point'][1]:.3f}) mm, largest "
              f"deformation {1e6 * np.abs(deformation).max():.4g} um")


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("import_heights", main)
