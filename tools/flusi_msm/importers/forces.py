# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a record of a flight, /flight/<id> of a measurement file (docs/formats/measurement-format.md), from the forces that a
balance measured over many beats.

usage: import_forces FORCES.csv -o flight.h5 --time-units ms --frequency 158 --force-units mN [--torque-units uNm] [--power-units mW]
                     [--reference X Y Z --length-units mm] [--yaw-pitch-roll YAW PITCH ROLL] [--column lift=Fz --column drag=-Fy] [--add --name ID]

FORCES.csv has a line of column names and one line for each sample: time, and some of Fx, Fy, Fz, Mx, My, Mz, power. --column
gives the meaning of other names, with a sign. Forces and torques are those of the air on the wing, along the axes of the flusi
case that simulates the experiment, without weight and inertia of the wing; power is the power of the wing on the air. A balance
whose axes are others says so by --axes or by angles; --reference stays along the axes of the case. Beats begin
at the time --start, in the --time-units of the file, and last 1/frequency. The record has the mean of all complete beats, their
spread, and the time in which the correlation of errors falls by the factor e. Samples of a two-dimensional section have units per
metre: N/m, Nm/m, W/m. docs/guide/import-data.md explains all of this.
"""
from __future__ import annotations

import argparse
import difflib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flusi_msm.errors import InputError, Problems, run_command
from flusi_msm.importers.axes import add_options, axes_of
from flusi_msm.importers.beats import DRIFT, REPEATS, Folded, best_frequency, fold, strongest_frequency
from flusi_msm.importers.kinematics import read_columns
from flusi_msm.measurement.balance import OF_A_WING, units_of
from flusi_msm.measurement.flight_file import is_record_name, write_record

TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
PREFIXES = {"": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9}
KINDS = {"force": ("N", "Fx Fy Fz"), "torque": ("Nm", "Mx My Mz"), "power": ("W", "power")}
FEWEST = 8     # samples in a beat
MOST = 20000   # numbers of a measurement file
SAME = 1e-6    # of the largest force: a component with smaller changes was not measured


def unit_choices(symbol: str) -> dict[str, tuple[float, bool]]:
    """Returns {unit: (size in SI, whether it is per metre)}."""
    return {f"{prefix}{symbol}{end}": (size, bool(end)) for end in ("", "/m") for prefix, size in PREFIXES.items()}


UNITS = {kind: unit_choices(symbol) for kind, (symbol, _) in KINDS.items()}


def kind_of(component: str) -> str:
    """Returns force, torque or power for a component."""
    return next(kind for kind, (_, names) in KINDS.items() if component in names.split())


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Returns the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("forces", metavar="FORCES.csv")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="measurement file to write")
    parser.add_argument("--time-units", required=True, choices=TIMES)
    parser.add_argument("--frequency", required=True, type=float, metavar="HZ", help="of the beat")
    for kind, choices in UNITS.items():
        parser.add_argument(f"--{kind}-units", choices=choices, metavar="UNIT", help=f"required with a {kind}: {', '.join(choices)}")
    parser.add_argument("--reference", type=float, nargs=3, metavar=("X", "Y", "Z"), help="point about which torques are; required with them")
    parser.add_argument("--length-units", choices=LENGTHS, help="of --reference")
    add_options(parser, "the balance")
    parser.add_argument("--column", action="append", default=[], metavar="NAME=[-]COMPONENT", help="what another name stands for")
    parser.add_argument("--ignore", action="append", default=[], metavar="NAME", help="a column that is left out; may be repeated")
    parser.add_argument("--start", type=float, default=0.0, metavar="TIME", help="when a beat begins, in --time-units (default: 0)")
    parser.add_argument("--skip", type=int, default=0, metavar="N", help="beats at the beginning that are left out (default: 0)")
    parser.add_argument("--samples", type=int, default=50, metavar="N", help="phases of the beat (default: 50)")
    parser.add_argument("--correlation-time", type=float, metavar="SECONDS", help="of the errors (default: from the beats)")
    parser.add_argument("--name", default="flight", help="of the record (default: flight)")
    parser.add_argument("--add", action="store_true", help="add the record to what the file holds")
    parser.add_argument("--picture", metavar="FILE.png", help="all beats, mean and spread (default: beside the output)")
    parser.add_argument("--no-picture", action="store_true")
    return parser.parse_args(arguments)


def assign(names: Sequence[str], options: argparse.Namespace, problems: Problems) -> dict[str, tuple[str, float]]:
    """Returns {column: (component, sign)} of the columns of a file other than the time."""
    lower = {component.lower(): component for component in OF_A_WING}
    stated = {}
    for text in options.column:
        name, equals, component = text.partition("=")
        sign, component = (-1.0, component[1:]) if component.startswith("-") else (1.0, component)
        if not equals or component.strip().lower() not in lower:
            problems.error(f"--column {text}: write NAME=COMPONENT or NAME=-COMPONENT, one of {', '.join(OF_A_WING)}")
            continue
        if name.strip().lower() not in names:
            problems.error(f"--column {text}: the file has no column {name.strip()}; it has {', '.join(names)}")
        stated[name.strip().lower()] = lower[component.strip().lower()], sign
    ignored = {name.lower() for name in options.ignore}
    for name in sorted(ignored - set(names)):
        problems.error(f"--ignore {name}: the file has no such column; it has {', '.join(names)}")
    found = {}
    for name in names:
        if name == "time" or name in ignored:
            continue
        if name in stated or name in lower:
            found[name] = stated[name] if name in stated else (lower[name], 1.0)
            continue
        near = difflib.get_close_matches(name, ["time", *lower], 1)
        problems.error(f"column {name}: is no component" + (f"; did you mean {lower.get(near[0], near[0])}? Say" if near else "; say")
                       + f" what it is with --column {name}=COMPONENT, or --ignore {name}")
    components = [component for component, _ in found.values()]
    for component in sorted({c for c in components if components.count(c) > 1}):
        problems.error(f"{component}: two columns stand for it")
    if not found:
        problems.error(f"the file has no component; columns are time and some of {', '.join(OF_A_WING)}")
    return found


def scales(components: Sequence[str], options: argparse.Namespace, problems: Problems) -> tuple[dict[str, float], bool]:
    """Returns the size of the unit of each component in SI, and whether all are per metre."""
    sizes, per_length = {}, {}
    for kind in KINDS:
        unit, has = getattr(options, f"{kind}_units"), [c for c in components if kind_of(c) == kind]
        if has and unit is None:
            problems.error(f"--{kind}-units: required, as the file has {', '.join(has)}; one of {', '.join(UNITS[kind])}")
        if has and unit is not None:
            for component in has:
                sizes[component], per_length[kind] = UNITS[kind][unit]
    if len(set(per_length.values())) > 1:
        problems.error("units: all are per metre of span, or none is")
    has_torque = any(kind_of(c) == "torque" for c in components)
    if has_torque and options.reference is None:
        problems.error("--reference: required, as the file has torques; the point about which they are")
    if options.reference is not None and options.length_units is None:
        problems.error("--length-units: required with --reference")
    return sizes, any(per_length.values())


def check_options(options: argparse.Namespace, problems: Problems) -> None:
    """Adds values that are out of range to the mistakes."""
    for key, is_right in (("frequency", options.frequency > 0), ("samples", options.samples >= 4), ("skip", options.skip >= 0),
                          ("correlation-time", (options.correlation_time or 0) >= 0), ("name", is_record_name(options.name))):
        if not is_right:
            problems.error(f"--{key}: is out of range")


def read_samples(options: argparse.Namespace, problems: Problems) -> tuple[np.ndarray, np.ndarray, list[str], bool, str]:
    """Returns times [s], values (n, k) in SI, names of the components, and whether they are per metre."""
    path = Path(options.forces)
    columns, spelling = read_columns(path, problems)
    if "time" not in columns:
        near = difflib.get_close_matches("time", columns, 1)
        problems.error(f"{path}: has no column time" + (f"; is it {near[0]}?" if near else f"; it has {', '.join(columns)}"))
    found = assign(list(columns), options, problems)
    components = [c for c in OF_A_WING if c in {component for component, _ in found.values()}]
    sizes, is_per_length = scales(components, options, problems)
    problems.stop_if_any()
    time = columns["time"] * TIMES[options.time_units]
    if not np.isfinite(time).all() or not (np.diff(time) > 0).all():
        bad = int(np.argmin(np.diff(time) > 0)) + 3 if np.isfinite(time).all() else int(np.argmin(np.isfinite(time))) + 2
        raise InputError(f"{path}: times must increase; they do not near line {bad}")
    by_component = {component: sign * sizes[component] * columns[name] for name, (component, sign) in found.items()}
    return time, np.stack([by_component[c] for c in components], 1), components, is_per_length, spelling


def check_beats(time: np.ndarray, values: np.ndarray, options: argparse.Namespace, problems: Problems) -> Folded:
    """Refuses records that cannot be divided into equal beats."""
    f, start = options.frequency, options.start * TIMES[options.time_units]
    span = (time[-1] - time[0]) * f
    in_a_beat = (len(time) - 1) / span
    if span < 2 or in_a_beat < FEWEST:
        problems.error(f"{len(time)} samples in {span:.3g} beats of {f:g} Hz: needs at least 2 beats and {FEWEST} samples in each. Are "
                       "--time-units and --frequency right?")
    elif options.samples > in_a_beat + 0.5:
        problems.error(f"--samples {options.samples}: a beat has {in_a_beat:.4g} samples; take at most as many phases")
    elif options.samples * values.shape[1] > MOST:
        problems.error(f"--samples {options.samples}: a measurement file holds at most {MOST} numbers of flights")
    problems.stop_if_any()
    found = fold(time, values, f, start, options.skip, options.samples)
    if len(found.beats) < 2:
        raise InputError(f"{len(found.beats)} complete beats after --start and --skip: needs at least 2")
    if np.isnan(found.beats).all(axis=(0, 1)).any():
        raise InputError("a component is unknown everywhere")
    best = best_frequency(time, values, f, start, options.skip, options.samples)
    if found.explained().max() < REPEATS and fold(time, values, best, start, options.skip, options.samples).explained().max() < REPEATS:
        raise InputError(f"the forces do not repeat with {f:g} Hz: the mean beat explains {100 * found.explained().max():.1f} % of them. The "
                         f"strongest line of their spectrum is at {strongest_frequency(time, values):.5g} Hz")
    if abs(best / f - 1) * len(found.beats) > DRIFT:
        raise InputError(f"--frequency {f:g}: over {len(found.beats)} beats the forces drift by {(best / f - 1) * len(found.beats):.2f} of a "
                         f"beat; their frequency is {best:.6g} Hz")
    return found


def record_of(found: Folded, options: argparse.Namespace) -> tuple[dict[str, np.ndarray], float]:
    """Returns the data of the record, and the way in which it states its errors."""
    mean, spread, count = found.mean(), found.spread(), found.count()
    smallest = SAME * np.nanmax(np.abs(mean), axis=0)
    if (np.nanmax(spread, axis=0) <= smallest).any():
        raise InputError("all beats are the same: these are no measured forces, their errors are unknown")
    spread = np.where(np.isfinite(spread), np.maximum(spread, smallest), 1.0)
    data = {"time": found.phase, "mean": mean}
    if count.min() == len(found.beats):
        data["spread"] = spread
    else:
        data["sd"] = np.where(count >= 2, spread / np.sqrt(np.maximum(count, 1)), 1.0)
    own = found.correlation_time() / options.frequency
    return data, own if options.correlation_time is None else options.correlation_time


def main() -> None:
    """Does what the command line asks for."""
    options, problems = parse(), Problems()
    check_options(options, problems)
    time, values, components, is_per_length, spelling = read_samples(options, problems)
    axes = axes_of(options, is_per_length, problems)
    problems.stop_if_any()
    found = check_beats(time, values, options, problems)
    data, correlation_time = record_of(found, options)
    reference = np.zeros(3) if options.reference is None else LENGTHS[options.length_units] * np.array(options.reference)
    units = units_of(components, is_per_length)
    write_record(options.output, options.name, {"frequency": options.frequency, "beats": len(found.beats), "reference": reference,
                                                **({} if axes is None else {"axes": axes}),
                                                "components": ", ".join(components), "units": ", ".join(units),
                                                "per_length": int(is_per_length), "correlation_time": correlation_time}, data,
                 not options.add)
    print(f"{options.forces}: {spelling}")
    print(f"{len(found.beats)} beats of {options.frequency:g} Hz at {options.samples} phases; errors are correlated over "
          f"{1e3 * correlation_time:.3g} ms")
    for name, unit, mean, spread, share in zip(components, units, found.mean().T, found.spread().T, found.explained()):
        print(f"{name:6s} mean {np.nanmean(mean):10.3e}  from {np.nanmin(mean):10.3e} to {np.nanmax(mean):10.3e}  spread of a beat "
              f"{np.sqrt(np.nanmean(spread**2)):9.2e} {unit}; the mean beat explains {100 * share:.1f} %")
    for name, axis in zip("xyz", [] if axes is None else axes):
        print(f"{name:6s} of the balance is along {axis[0]:9.5f} {axis[1]:9.5f} {axis[2]:9.5f} of the case")
    print(options.output)
    if not options.no_picture:
        from flusi_msm.importers.forces_picture import draw
        picture = Path(options.picture or Path(options.output).with_suffix(".png"))
        draw(found, components, units, picture)
        print(picture)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("import_forces", main)
