# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a record of landmarks, /flight/<id>/landmarks of a measurement file (docs/formats/measurement-format.md), from points on
flapping wings that cameras tracked.

usage: import_landmarks TRACKS.csv POINTS.csv -o flight.h5 --time-units ms --frequency 158 --length-units mm --origin X Y Z
                        [--yaw-pitch-roll YAW PITCH ROLL] [--sd 0.05] [--offset-sd 0.1] [--turn-sd 1] [--add --name ID]

POINTS.csv has a line of column names, `name,wing,x,y`, and one line for each point: a name of your own, left or right, and its
place on the flat wing in the frame of the wing file. TRACKS.csv has the column time, and NAME_x, NAME_y, NAME_z for each point:
its place in space along the axes of the flusi case that simulates the experiment, or along those of --axes or of the angles. A
coordinate that was not seen is an empty cell, or a column that is not there. --origin is the place in the case, along its axes,
from which the cameras measure. Beats begin at the time --start, in the --time-units of the file, and last 1/frequency. The record
has the mean of all complete beats and its sd, from the spread of the beats, pooled over the beat for each coordinate; if no
coordinate of it was seen twice, the error is --sd. All lengths are in --length-units. docs/guide/import-data.md explains all of
this.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flusi_msm.errors import InputError, Problems, run_command
from flusi_msm.importers.axes import add_options, axes_of
from flusi_msm.importers.beats import DRIFT, Folded, best_frequency, fold
from flusi_msm.importers.forces import LENGTHS, MOST, SAME, TIMES
from flusi_msm.importers.kinematics import read_columns
from flusi_msm.importers.tables import read_table
from flusi_msm.measurement.flight_file import is_record_name, write_landmarks

AXES = "xyz"
WINGS = ("left", "right")
POINT_COLUMNS = ["name", "wing", "x", "y"]
FEWEST = 8          # samples in a beat
MOST_OFFSET = 10.0  # of the sd of the origin [m]
MOST_TURN = 20.0    # of the sd of the axes [degree]
MOST_TIME = 1e6     # of the correlation time [s]


@dataclass
class Point:
    """A point of a wing; lengths are in metres."""
    name: str
    wing: str
    place: tuple[float, float]


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Returns the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tracks", metavar="TRACKS.csv")
    parser.add_argument("points", metavar="POINTS.csv")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="measurement file to write")
    parser.add_argument("--time-units", required=True, choices=TIMES)
    parser.add_argument("--length-units", required=True, choices=LENGTHS)
    parser.add_argument("--frequency", required=True, type=float, metavar="HZ", help="of the beat")
    parser.add_argument("--origin", required=True, type=float, nargs=3, metavar=("X", "Y", "Z"), help="of the cameras' axes, in the case")
    add_options(parser, "the frame of the cameras")
    parser.add_argument("--sd", type=float, metavar="LENGTH", help="of one coordinate in one beat; required with a single beat")
    parser.add_argument("--offset-sd", type=float, metavar="LENGTH", help="of the origin, along each axis")
    parser.add_argument("--turn-sd", type=float, metavar="DEGREES", help="of the cameras' axes, about each axis")
    parser.add_argument("--per-length", action="store_true", help="the case is a two-dimensional section")
    parser.add_argument("--start", type=float, default=0.0, metavar="TIME", help="when a beat begins, in --time-units (default: 0)")
    parser.add_argument("--skip", type=int, default=0, metavar="N", help="beats at the beginning that are left out (default: 0)")
    parser.add_argument("--samples", type=int, default=40, metavar="N", help="phases of the beat (default: 40)")
    parser.add_argument("--correlation-time", type=float, metavar="SECONDS", help="of the errors (default: from the beats)")
    parser.add_argument("--name", default="flight", help="of the record (default: flight)")
    parser.add_argument("--add", action="store_true", help="add the landmarks to what the file holds")
    return parser.parse_args(arguments)


def check_options(options: argparse.Namespace, problems: Problems) -> None:
    """Adds values that are out of range to the mistakes. The limits are those of the format."""
    def is_positive(value: float | None, largest: float = np.inf) -> bool:
        return value is None or bool(np.isfinite(value)) and 0 < value <= largest
    unit = LENGTHS[options.length_units]
    for key, is_right, valid in (
            ("frequency", is_positive(options.frequency), "a positive number"),
            ("origin", np.isfinite(options.origin).all(), "three numbers"),
            ("start", np.isfinite(options.start), "a number"),
            ("samples", options.samples >= 4, "4 or more"), ("skip", options.skip >= 0, "0 or more"),
            ("sd", is_positive(options.sd), "a positive number"),
            ("offset-sd", is_positive(options.offset_sd, MOST_OFFSET / unit), f"above 0, at most {MOST_OFFSET / unit:g} {options.length_units}"),
            ("turn-sd", is_positive(options.turn_sd, MOST_TURN), f"above 0, at most {MOST_TURN:g} degrees"),
            ("correlation-time", options.correlation_time is None or 0 <= options.correlation_time <= MOST_TIME, f"0 to {MOST_TIME:g} s"),
            ("name", is_record_name(options.name), "a name without /")):
        if not is_right:
            problems.error(f"--{key}: is out of range; valid: {valid}")


def read_points(path: Path, unit: float, problems: Problems) -> list[Point]:
    """Returns the points of a file in its order; none if it has other columns."""
    table = read_table(path)
    if [name.lower() for name in table.rows[0]] != POINT_COLUMNS:
        problems.error(f"{path}: the first line must be {','.join(POINT_COLUMNS)}; it is {','.join(table.rows[0])}")
        return []
    points: list[Point] = []
    for line, row in zip(table.lines[1:], table.rows[1:]):
        if len(row) != len(POINT_COLUMNS):
            problems.error(f"{path}:{line}: has {len(row)} cells; valid: {', '.join(POINT_COLUMNS)}")
            continue
        name, wing = row[0].lower(), row[1].lower()
        if wing not in WINGS:
            problems.error(f"{path}:{line}: the wing is {row[1]!r}; valid: left, right")
        if not name or name in (point.name for point in points):
            problems.error(f"{path}:{line}: the name {row[0]!r} is empty or there twice")
        try:
            place = unit * table.number(row[2]), unit * table.number(row[3])
        except ValueError:
            problems.error(f"{path}:{line}: {row[2]!r}, {row[3]!r} are not two numbers")
            continue
        if not np.isfinite(place).all():
            problems.error(f"{path}:{line}: x or y is missing")
        points.append(Point(name, wing, place))
    if not points:
        problems.error(f"{path}: has no point")
    return points


def read_tracks(path: Path, points: Sequence[Point], options: argparse.Namespace, problems: Problems) -> tuple[np.ndarray, np.ndarray, str]:
    """Returns times [s], places (n, 3 points) [m], NaN where unknown, and how the text was understood."""
    columns, spelling = read_columns(path, problems)
    wanted = [f"{point.name}_{axis}" for point in points for axis in AXES]
    if "time" not in columns:
        problems.error(f"{path}: has no column time; it has {', '.join(columns)}")
    elif not np.isfinite(columns["time"]).all() or not (np.diff(columns["time"]) > 0).all():
        problems.error(f"{path}: times must be there and increase")
    for name in columns:
        # Without points no column belongs to one.
        if points and name != "time" and name not in wanted:
            problems.error(f"{path}: column {name}: belongs to no point; columns are time and NAME_x, NAME_y, NAME_z with the names of "
                           f"{options.points}")
    for point in points:
        if not any(f"{point.name}_{axis}" in columns for axis in AXES):
            problems.error(f"{path}: has no column of the point {point.name}")
    problems.stop_if_any()
    time = columns["time"] * TIMES[options.time_units]
    empty = np.full(len(time), np.nan)
    return time, LENGTHS[options.length_units] * np.stack([columns.get(name, empty) for name in wanted], 1), spelling


def check_beats(time: np.ndarray, values: np.ndarray, options: argparse.Namespace, problems: Problems) -> Folded:
    """Divides tracks into beats; refuses those that cannot be divided."""
    f, start = options.frequency, options.start * TIMES[options.time_units]
    in_a_beat = (len(time) - 1) / ((time[-1] - time[0]) * f) if len(time) > 1 else 0.0
    seen = np.isfinite(values).any(axis=0)
    if in_a_beat < FEWEST:
        problems.error(f"{in_a_beat:.3g} samples in a beat of {f:g} Hz: needs at least {FEWEST}. Are --time-units and --frequency right?")
    elif options.samples > in_a_beat + 0.5:
        problems.error(f"--samples {options.samples}: a beat has {in_a_beat:.4g} samples; take at most as many phases")
    elif options.samples * np.count_nonzero(seen) > MOST:
        problems.error(f"--samples {options.samples}: a measurement file holds at most {MOST} numbers of flights")
    if not seen.any():
        problems.error("no point is ever seen")
    problems.stop_if_any()
    found = fold(time, values, f, start, options.skip, options.samples)
    if len(found.beats) < 1 or len(found.beats) < 2 and options.sd is None:
        raise InputError(f"{len(found.beats)} complete beats after --start and --skip: needs at least 2, or 1 with --sd")
    if len(found.beats) > 1:
        best = best_frequency(time, values[:, seen], f, start, options.skip, options.samples)
        if abs(best / f - 1) * len(found.beats) > DRIFT:
            raise InputError(f"--frequency {f:g}: over {len(found.beats)} beats the points drift by "
                             f"{(best / f - 1) * len(found.beats):.2f} of a beat; their frequency is {best:.6g} Hz")
    return found


def record_of(found: Folded, options: argparse.Namespace) -> tuple[np.ndarray, np.ndarray]:
    """Returns the means (n, k) and their sd; means that no error is known of are NaN. The spread of a coordinate is pooled over the
    beat, because few beats determine it badly at each phase."""
    count = found.count()
    with np.errstate(invalid="ignore"):
        mean = np.where(count > 0, np.nansum(found.beats, axis=0) / np.maximum(count, 1), np.nan)
        freedom = np.where(count >= 2, count - 1, 0)
        pooled = np.sqrt(np.nansum(freedom * np.nan_to_num(found.spread())**2, axis=0) / freedom.sum(axis=0))
    spread = np.broadcast_to(pooled, mean.shape)
    if options.sd is not None:
        spread = np.where(np.isfinite(spread), spread, options.sd * LENGTHS[options.length_units])
    smallest = SAME * np.nanmax(np.abs(mean - np.nanmean(mean))) if np.isfinite(mean).any() else 0.0
    mean = np.where(np.isfinite(spread) & (spread > smallest), mean, np.nan)
    if not np.isfinite(mean).any():
        raise InputError("all beats are the same: these are no tracked points, their errors are unknown; give --sd and one beat")
    known = np.isfinite(mean)
    return mean, np.where(known, spread / np.sqrt(np.maximum(count, 1)), 1.0)


def main() -> None:
    """Does what the command line asks for."""
    options, problems = parse(), Problems()
    check_options(options, problems)
    unit = LENGTHS[options.length_units]
    points = read_points(Path(options.points), unit, problems)
    axes = axes_of(options, options.per_length, problems)
    time, values, spelling = read_tracks(Path(options.tracks), points, options, problems)
    found = check_beats(time, values, options, problems)
    mean, sd = record_of(found, options)
    own = found.correlation_time() / options.frequency if len(found.beats) > 1 else 0.0
    cameras = {"origin": unit * np.array(options.origin), "beats": len(found.beats),
               "correlation_time": own if options.correlation_time is None else options.correlation_time}
    if axes is not None:
        cameras["axes"] = axes
    if options.offset_sd:
        cameras["offset_sd"] = unit * options.offset_sd
    if options.turn_sd:
        cameras["turn_sd"] = options.turn_sd
    wings = {}
    for wing in WINGS:
        chosen = [k for k, point in enumerate(points) if point.wing == wing]
        columns = [3 * k + c for k in chosen for c in range(3)]
        if chosen:
            wings[wing] = {"time": found.phase, "points": np.array([points[k].place for k in chosen]), "mean": mean[:, columns],
                           "sd": sd[:, columns]}
    write_landmarks(options.output, options.name, {"frequency": options.frequency, "beats": len(found.beats),
                                                   "per_length": int(options.per_length)}, cameras, wings, not options.add)
    print(f"{options.tracks}: {spelling}")
    print(f"{len(found.beats)} beats of {options.frequency:g} Hz at {options.samples} phases; errors are correlated over "
          f"{1e3 * cameras['correlation_time']:.3g} ms")
    most = found.count().max(axis=0)  # beats that see a coordinate at the same phase
    for k, point in enumerate(points):
        own_mean, own_sd = mean[:, 3 * k:3 * k + 3], sd[:, 3 * k:3 * k + 3]
        known = np.isfinite(own_mean)
        size = f"sd of the mean {1e6 * np.sqrt((own_sd[known]**2).mean()):.3g} um" if known.any() else "no coordinate has a known error"
        if not most[3 * k:3 * k + 3].any():
            size = "never seen"
        once = [axis for axis, n in zip(AXES, most[3 * k:]) if n == 1 and options.sd is None]
        if once:
            size += f"; {', '.join(once)} seen in one beat only: give --sd"
        print(f"{point.name:8s} {point.wing:5s} wing, {known.sum()} of {known.size} coordinates known, {size}")
    print(options.output)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("import_landmarks", main)
