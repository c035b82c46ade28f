# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes motion files for FlappingMotion_left and _right (docs/guide/kinematics.md) from measured wing angles.

usage: import_kinematics ANGLES.csv -o beat.ini --angles degrees [--frequency 158] [--convention stroke-dorsal]

ANGLES.csv has a line of column names and one line for each picture: `phase` (0 to 1 within a beat) or `time` [s] with --frequency, and
the angles: phi, alpha, theta (conventions flusi, SISC) or stroke, deviation, rotation (stroke-dorsal, stroke-ventral). A column NAME_left
or NAME_right belongs to that wing, one without to both; with columns of both wings BEAT_left.ini and BEAT_right.ini are written. A wing's
angles may be missing in lines of the other.

  flusi           phi dorsal; alpha 0: chord perpendicular to the stroke plane, positive: leading edge tilted into the downstroke;
                  theta down
  SISC            the same with theta up
  stroke-dorsal   stroke dorsal; deviation up; rotation is the angle of the chord with the stroke plane, 90: perpendicular, less in the
                  downstroke and more in the upstroke
  stroke-ventral  the same with the stroke positive to the ventral side

Both wings are described as mirror images: the same angles are the same motion. The picture next to the file shows samples and
fit, the chords of a beat and the path of the tips: check that the leading edge goes first, and that the wing goes down in the
downstroke.
"""
from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from flusi_msm.errors import InputError, Problems, run_command
from flusi_msm.importers.angles import (
    CONVENTIONS,
    FOURIER,
    HERMITE,
    MOST_HARMONICS,
    ORDERS,
    Fit,
    choose_harmonics,
    fit_fourier,
    fit_hermite,
    flusi_angles,
    matrices,
    motion_text,
)
from flusi_msm.importers.tables import read_table
from flusi_msm.plots.kinematics import ANGLES

SIDES = ("left", "right")
CLOCKS = ("phase", "time")
Rule = tuple[str, float, float]  # column, factor, offset
Measured = tuple[np.ndarray, dict[str, np.ndarray], dict[str, Fit]]  # phases, angles [degrees], their fits


def read_columns(path: Path, problems: Problems) -> tuple[dict[str, np.ndarray], str]:
    """Returns {column: numbers}, NaN where a cell is empty; and how the text was understood. Names do not depend on case; one that is
    there twice is a mistake."""
    table = read_table(path)
    names = [name.lower() for name in table.rows[0]]
    for name in names:
        if names.count(name) > 1:
            problems.error(f"{path}:{table.lines[0]}: the column {name} is there {names.count(name)} times; give each a name of its own")
    values = np.full((len(table.rows) - 1, len(names)), np.nan)
    for j, row in enumerate(table.rows[1:]):
        if len(row) > len(names):
            problems.error(f"{path}:{table.lines[j + 1]}: has {len(row)} cells, the first line {len(names)} ({table.spelling()})")
        for i, cell in enumerate(row[:len(names)]):
            try:
                values[j, i] = table.number(cell)
            except ValueError:
                problems.error(f"{path}:{table.lines[j + 1]}: {names[i]} is {cell!r}, not a number ({table.spelling()})")
    return dict(zip(names, values.T)), table.spelling()


def sides_of(path: Path, columns: Mapping[str, np.ndarray], convention: str, negate: Sequence[str], problems: Problems) \
        -> dict[str, dict[str, Rule]]:
    """Returns {side: {FLUSI's angle: (column, factor, offset)}}, or {"": ...} if both wings move alike."""
    rules = CONVENTIONS[convention]
    bases = [column for column, _, _ in rules.values()]
    known = [*CLOCKS, *bases, *(f"{base}_{side}" for base in bases for side in SIDES)]
    for name in columns:
        if name not in known:
            problems.error(f"{path}: unknown column {name}; with --convention {convention} columns are {', '.join(known)}")
    for name in negate:
        if name not in columns:
            problems.error(f"--negate {name}: there is no such column")
    sides = [side for side in SIDES if any(f"{base}_{side}" in columns for base in bases)] or [""]
    found: dict[str, dict[str, Rule]] = {}
    for side in sides:
        found[side] = {}
        for angle, (base, factor, offset) in rules.items():
            column = f"{base}_{side}" if f"{base}_{side}" in columns else base
            if column not in columns:
                problems.error(f"{path}: no column {base}" + (f"_{side}" if side else "")
                               + ("; if the deviation was not measured give a column of zeros" if angle == "theta" else ""))
            else:
                found[side][angle] = (column, -factor if column in negate else factor, offset)
    return found


def phase_of(path: Path, columns: Mapping[str, np.ndarray], frequency: float | None, problems: Problems) -> np.ndarray | None:
    """Returns the phase of every line within its beat."""
    clocks = [name for name in CLOCKS if name in columns]
    if len(clocks) != 1:
        problems.error(f"{path}: {'both phase and time' if clocks else 'neither phase nor time'} among the columns; one is needed")
        return None
    values = columns[clocks[0]]
    if not np.isfinite(values).all():
        problems.error(f"{path}: {clocks[0]} is missing in line {int(np.argmin(np.isfinite(values))) + 1} of the numbers")
        return None
    if clocks[0] == "time":
        if not frequency:
            problems.error("--frequency is missing: with the column time the number of beats per second is needed")
            return None
        if np.ptp(values) * frequency > 1e4:
            problems.error(f"{path}: {np.ptp(values):.6g} s are {np.ptp(values) * frequency:.4g} beats of {frequency:.6g} per second: is time "
                           "in seconds?")
        elif np.ptp(values) * frequency < 0.5:
            problems.error(f"{path}: {np.ptp(values):.6g} s are only {np.ptp(values) * frequency:.3g} of a beat of {frequency:.6g} per second: "
                           "is time in seconds?")
        values = values * frequency
    elif np.ptp(values) > 1.01 and np.ptp(values) > 100:
        problems.error(f"{path}: phase runs from {values.min():.4g} to {values.max():.4g}; it counts beats, not per cent or degrees")
    return values % 1.0


def check_angles(path: Path, side: str, angles: Mapping[str, np.ndarray], unit: str, problems: Problems) -> None:
    """Returns doubts about units, signs and zeros of FLUSI's angles (degrees) in the order of the phase."""
    name = f" of the {side} wing" if side else ""
    stroke = np.ptp(angles["phi"])
    if unit == "radians" and stroke > 360:
        problems.error(f"{path}: the stroke{name} is {stroke:.4g} degrees: the angles are degrees, not radians")
    elif unit == "degrees" and stroke < 2 * np.pi:
        problems.error(f"{path}: the stroke{name} is {stroke:.3g} degrees: are the angles radians?")
    elif stroke > 200:
        problems.notice(f"the stroke{name} is {stroke:.4g} degrees, more than any wing has")
    if abs(np.mean(angles["alpha"])) > 60:
        problems.notice(f"alpha{name} has the mean {np.mean(angles['alpha']):.0f} degrees, as if counted from the stroke plane: "
                        "is it the rotation of --convention stroke-dorsal?")


def check_tilt(side: str, fits: Mapping[str, Fit], problems: Problems) -> None:
    """Checks that the leading edge is tilted into the stroke, as in most flights: alpha is larger in the downstroke, in which
    phi falls."""
    x = np.linspace(0, 1, 200, endpoint=False)
    rate = np.gradient(fits["phi"](x))
    alpha = fits["alpha"](x)
    if (rate * (alpha - alpha.mean())).sum() > 0:
        problems.notice(f"{side or 'both'}: the trailing edge goes first: alpha is larger in the upstroke. Is the sign of phi or of alpha another "
                        "one (--negate, --convention)? See the picture")


def fit_angles(x: np.ndarray, angles: Mapping[str, np.ndarray], options: argparse.Namespace, problems: Problems) -> dict[str, Fit]:
    """Fits a function to each angle."""
    fits: dict[str, Fit] = {}
    gap = np.diff(np.concatenate([np.sort(x), [np.sort(x)[0] + 1]])).max()
    most = max(1, min(MOST_HARMONICS, int(0.5 / gap), (len(x) - 2) // 4))
    if gap > 0.25 or len(x) < 6:
        problems.error(f"{len(x)} samples leave {gap:.0%} of the beat without any: the motion there is not known")
        return fits
    for name in ANGLES:
        if options.type == HERMITE:
            nodes = options.nodes
            if 2 * nodes >= len(x) or gap > 1 / nodes:
                problems.error(f"--nodes {nodes}: {len(x)} samples with gaps of {gap:.1%} of the beat carry at most "
                               f"{max(2, min((len(x) - 1) // 2, int(1 / gap)))}")
                return fits
            fits[name] = fit_hermite(x, angles[name], nodes)
        else:
            harmonics = options.harmonics
            if harmonics is None:
                harmonics = choose_harmonics(x, angles[name], most)
            elif 2 * harmonics + 1 >= len(x) or harmonics > max(1, int(0.5 / gap)):
                problems.error(f"--harmonics {harmonics}: {len(x)} samples with gaps of {gap:.1%} of the beat carry at most {most}")
                return fits
            fits[name] = fit_fourier(x, angles[name], harmonics)
    return fits


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="ANGLES.csv")
    parser.add_argument("-o", "--output", required=True, metavar="BEAT.ini", help="motion file to write")
    parser.add_argument("--angles", required=True, choices=["degrees", "radians"], help="unit of the angles")
    parser.add_argument("--frequency", type=float, metavar="F", help="beats per second, with the column time")
    parser.add_argument("--convention", choices=CONVENTIONS, default="flusi", help="names, signs and zeros of the angles (default: flusi)")
    parser.add_argument("--order", choices=ORDERS, default="phi-theta-alpha",
                        help="in which order the wing is turned from the stroke plane on (default: as in FLUSI)")
    parser.add_argument("--negate", action="append", default=[], metavar="COLUMN", help="this column has the other sign; may be repeated")
    parser.add_argument("--type", choices=[FOURIER, HERMITE], default=FOURIER)
    parser.add_argument("--harmonics", type=int, metavar="N", help="of the Fourier series (default: as the samples ask for)")
    parser.add_argument("--nodes", type=int, default=20, metavar="N", help="of hermite (default: 20)")
    parser.add_argument("--eta", type=float, default=-90.0, metavar="ANGLE", help="stroke plane of the picture [degrees] (default: -90)")
    parser.add_argument("--no-picture", action="store_true")
    options = parser.parse_args()
    path, problems = Path(options.file), Problems()
    if options.frequency is not None and not options.frequency > 0:
        problems.error("--frequency must be positive")
    if options.harmonics is not None and options.harmonics < 0 or options.nodes < 2:
        problems.error("--harmonics must not be negative, --nodes at least 2")
    columns, spelling = read_columns(path, problems)
    rules = sides_of(path, columns, options.convention, options.negate, problems)
    phase = phase_of(path, columns, options.frequency, problems)
    problems.stop_if_any()
    assert phase is not None  # without it there are mistakes
    motions = {}
    for side, rule in rules.items():
        unit = 1.0 if options.angles == "degrees" else 180 / np.pi
        angles = {name: factor * unit * columns[column] + offset for name, (column, factor, offset) in rule.items()}
        known = np.isfinite(np.sum(list(angles.values()), axis=0))
        order = np.argsort(phase[known], kind="stable")
        x = phase[known][order]
        angles = {name: values[known][order] for name, values in angles.items()}
        if not len(x):
            problems.error(f"{path}: no line has all angles" + (f" of the {side} wing" if side else ""))
            continue
        if options.order != "phi-theta-alpha":
            angles = flusi_angles(matrices(angles, ORDERS[options.order]))
        check_angles(path, side, angles, options.angles, problems)
        motions[side] = (x, angles, fit_angles(x, angles, options, problems))
    problems.stop_if_any()
    write_motions(path, spelling, motions, options, problems)


def write_motions(path: Path, spelling: str, motions: Mapping[str, Measured], options: argparse.Namespace, problems: Problems) -> None:
    """Writes the files, the residuals of every angle, and the picture."""
    print(f"{path}: {spelling}")
    output = Path(options.output)
    for side, (x, angles, fits) in motions.items():
        check_tilt(side, fits, problems)
        target = output.with_name(f"{output.stem}_{side}{output.suffix}") if side else output
        words = [f"{name} {len(fits[name].a)} {'harmonics' if options.type == FOURIER else 'nodes'}, residual {fits[name].residual:.3g} degrees"
                 for name in ANGLES]
        head = f"Made by import_kinematics of {path.name}: convention {options.convention}, {len(x)} samples.\n" + "; ".join(words) + \
            ".\nphi > 0 dorsal, alpha > 0 leading edge tilted into the downstroke, theta > 0 down."
        try:
            target.write_text(motion_text(fits, head))
        except OSError as error:
            raise InputError(f"{target}: cannot be written: {error.strerror}") from None
        print(f"{target}: {len(x)} samples, stroke {np.ptp(fits['phi'](np.linspace(0, 1, 400))):.4g} degrees; {'; '.join(words)}")
    for text in problems.notices:
        print("notice: " + text)
    if not options.no_picture:
        from flusi_msm.importers.motion_picture import draw_motions
        draw_motions(output.with_suffix(".png"), motions, options.eta)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("import_kinematics", main)
