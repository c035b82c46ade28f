# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a record of motion, /series/<id> of a measurement file (docs/formats/measurement-format.md), of tables of what was measured.

usage: import_series RECORD.csv -o ring.h5 --points POINTS.csv --length-units mm --time-units ms --units um --medium air
                     --excitation release --point 8 -0.5 --direction 0 0 1 --size 10 --size-sd 1 --size-units uN
                     --axis 0 0 1 --zero 0 --trigger-sd 0.02 --lowpass none [--wing wing.h5] [--name ID --add]
       import_series RECORD.csv ... --excitation base --direction 0 0 1 --base-units g --lowpass 2000 --order 2

RECORD.csv has a line of column names and one line for each sample: time, a column for each point, with an empty cell where a
value is missing, and with --excitation base the acceleration of the clamp as column base. Samples are at equal times. POINTS.csv
has a line for each point: name (of its column), x, y, sd (of one value, in --units). Values are displacements from rest, or
velocities, along --axis, and with base relative to the clamp. --zero is the time of the excitation, --trigger-sd its sd, in
--time-units; samples before it are left out. --lowpass is the cut-off [Hz] of the filter through which the motion was seen.
docs/guide/import-data.md explains all of this.
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.errors import InputError, Problems, run_command
from flusi_msm.importers.cells import NAME, WHAT_NAMES_ARE, Cells, unit
from flusi_msm.importers.vibration_file import LENGTHS, MEDIA, OnWing, held, write_groups

TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
UNITS = {f"{name}{end}": size for end in ("", "/s") for name, size in {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}.items()}
SIZES = {"release": {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "nN": 1e-9}, "tap": {"Ns": 1.0, "mNs": 1e-3, "uNs": 1e-6, "nNs": 1e-9}}
ALL_SIZES = {name: size for choices in SIZES.values() for name, size in choices.items()}
BASES = {"m/s2": 1.0, "mm/s2": 1e-3, "g": 9.80665}
EXCITATIONS = ("release", "tap", "base")
MOST = 20000   # numbers of all records of a file
JITTER = 0.01  # of a step: the largest deviation of a time from equal steps


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Returns the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add, three = parser.add_argument, ("X", "Y", "Z")
    add("record", metavar="RECORD.csv")
    add("-o", "--output", required=True, metavar="FILE", help="measurement file to write")
    add("--points", required=True, metavar="POINTS.csv", help="places of the columns and sd of their values")
    add("--length-units", required=True, choices=LENGTHS, help="of x and y, and of --point")
    add("--time-units", required=True, choices=TIMES)
    add("--units", required=True, choices=UNITS, help="of the values: displacements or velocities")
    add("--medium", required=True, choices=MEDIA)
    add("--air-density", type=float, metavar="KG/M3", help="(default: 1.2)")
    add("--excitation", required=True, choices=EXCITATIONS)
    add("--direction", required=True, type=float, nargs=3, metavar=three, help="of the force, of the impulse, or of the base's motion")
    add("--axis", required=True, type=float, nargs=3, metavar=three, help="along which the motion was seen")
    add("--point", type=float, nargs=2, metavar=("X", "Y"), help="where the wing was held or tapped")
    add("--size", type=float, help="of the force or of the impulse")
    add("--size-sd", type=float, help="its sd")
    add("--size-units", choices=ALL_SIZES, help="of both")
    add("--base-units", choices=BASES, help="of the column base")
    add("--zero", type=float, metavar="TIME", help="when the wing was released or tapped")
    add("--trigger-sd", type=float, metavar="TIME", help="sd of that time; 0 if it is exact")
    add("--lowpass", required=True, metavar="HZ", help="cut-off of the filter of the instrument, or none")
    add("--order", type=int, choices=(1, 2), help="of that filter (2: Butterworth's); required with one")
    add("--until", type=float, metavar="TIME", help="leave later samples out")
    add("--every", type=int, default=1, metavar="N", help="take every N-th sample; filter the record before (default: 1)")
    add("--wing", metavar="FILE", help="wing file: places that are not on it are refused")
    add("--name", default="ring", help="of the record (default: ring)")
    add("--add", action="store_true", help="add the record to what the file holds")
    return parser.parse_args(arguments)


def check_direction(options: argparse.Namespace, key: str, problems: Problems) -> None:
    """Reports a direction without a length, or with an extreme one."""
    if not 1e-6 <= np.abs(getattr(options, key)).max() <= 1e6:
        problems.error(f"--{key}: must be a vector of a length between 1e-6 and 1e6")


def check_excitation(options: argparse.Namespace, problems: Problems) -> None:
    """Reports options that are missing, or that this excitation does not have."""
    own = ("point", "size", "size-sd", "size-units", "zero", "trigger-sd")
    for key in own:
        stated = getattr(options, key.replace("-", "_")) is not None
        if stated and options.excitation == "base":
            problems.error(f"--{key}: not with --excitation base")
        elif not stated and options.excitation != "base":
            problems.error(f"--{key}: required with --excitation {options.excitation}"
                           + (f"; one of {', '.join(SIZES[options.excitation])}" if key == "size-units" else ""))
    if options.excitation != "base":
        units = SIZES[options.excitation]
        if options.size_units is not None and options.size_units not in units:
            what = "a force" if options.excitation == "release" else "an impulse"
            problems.error(f"--size-units {options.size_units}: --excitation {options.excitation} has {what}; valid: {', '.join(units)}")
        if options.base_units is not None:
            problems.error("--base-units: only with --excitation base")
        if options.size is not None and not 0 < options.size < np.inf:
            problems.error(f"--size: is {options.size:g}; valid: above 0 (--direction has the sign)")
    elif options.base_units is None:
        problems.error(f"--base-units: required with --excitation base; one of {', '.join(BASES)}")
    for key in ("size_sd", "trigger_sd"):
        value = getattr(options, key)
        if value is not None and not 0 <= value < np.inf:
            problems.error(f"--{key.replace('_', '-')}: is {value:g}; valid: at least 0")


def lowpass_of(options: argparse.Namespace, problems: Problems) -> float:
    """Returns the cut-off [Hz]; 0 without a filter."""
    if options.lowpass == "none":
        if options.order is not None:
            problems.error("--order: not with --lowpass none")
        return 0.0
    try:
        value = float(options.lowpass)
    except ValueError:
        value = np.nan
    if not 0 < value < 1e9:
        problems.error(f"--lowpass: is {options.lowpass!r}; valid: a frequency [Hz] above 0, or none")
    if options.order is None:
        problems.error("--order: required with --lowpass; 1 or 2")
    return value


def check_options(options: argparse.Namespace, problems: Problems) -> float:
    """Reports options that are missing or out of range; returns the cut-off of the filter."""
    check_direction(options, "direction", problems)
    check_direction(options, "axis", problems)
    check_excitation(options, problems)
    if options.every < 1:
        problems.error("--every: is out of range; valid: at least 1")
    if options.air_density is not None and not 0 < options.air_density <= 1000:
        problems.error("--air-density: is out of range; valid: above 0, at most 1000 kg/m^3")
    if not NAME.match(options.name):
        problems.error(f"--name: is {options.name!r}; {WHAT_NAMES_ARE}")
    return lowpass_of(options, problems)


def read_points(options: argparse.Namespace, problems: Problems) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Returns names, places (m, 2) [m] and sd (m) in SI."""
    cells = Cells(options.points, problems)
    cells.check_columns(("name", "x", "y", "sd"))
    wing, size, names, places, sd = OnWing(options.wing), LENGTHS[options.length_units], [], [], []
    for k in range(len(cells.rows)):
        name = cells.text(k, "name").lower()
        if not name or name in ("time", "base") or name in names:
            problems.error(f"{cells.place(k, 'name')} is {name!r}; names are those of columns of {options.record}, each once")
        place = size * np.array([cells.number(k, "x"), cells.number(k, "y")])
        mistake = wing.mistake(place)
        if mistake:
            problems.error(f"{cells.path}:{cells.line(k)}: columns x, y: {mistake}")
        names.append(name)
        places.append(place)
        sd.append(UNITS[options.units] * cells.number(k, "sd", 0, is_open=True))
    if options.point is not None and options.excitation != "base":
        mistake = wing.mistake(size * np.array(options.point))
        if mistake:
            problems.error(f"--point: {mistake}")
    return names, np.array(places), np.array(sd)


def check_times(cells: Cells, time: np.ndarray, problems: Problems) -> None:
    """Reports times that are missing, do not increase, or are not at equal steps."""
    if len(time) < 2:
        problems.error(f"{cells.path}: has one sample; at least 2 make a record")
        return
    if not np.isfinite(time).all():
        return  # reported with its line
    steps = np.diff(time)
    if not (steps > 0).all():
        problems.error(f"{cells.place(int(np.argmin(steps > 0)) + 1, 'time')}: times must increase")
        return
    off = np.abs(time - np.linspace(time[0], time[-1], len(time))) / steps.mean()
    if off.max() > JITTER:
        k = int(np.argmax(np.abs(steps - np.median(steps)))) + 1
        problems.error(f"{cells.place(k, 'time')}: times must be at equal steps: this one is {steps[k - 1]:g} after the one before it, most are "
                       f"{np.median(steps):g} (a gap? give its samples empty cells)")


def read_record(options: argparse.Namespace, names: Sequence[str], problems: Problems) -> tuple[np.ndarray, np.ndarray, np.ndarray, Cells]:
    """Returns times [s], values (n, m) in SI, the acceleration of the base (n, or 0) [m/s^2], and the table."""
    cells = Cells(options.record, problems)
    is_base = options.excitation == "base"
    cells.check_columns(["time", *(name for name in names if name), *(["base"] if is_base else [])])
    if not is_base and "base" in cells.columns:
        problems.error(f"{cells.path}: column base: only valid with --excitation base")
    n = range(len(cells.rows))
    time = np.array([cells.number(k, "time") for k in n])
    values = np.array([[cells.number(k, name, is_required=False) for name in names] for k in n])
    base = np.array([cells.number(k, "base") for k in n]) if is_base else np.zeros(0)
    if "time" in cells.columns:
        check_times(cells, time, problems)
    problems.stop_if_any()
    return TIMES[options.time_units] * time, UNITS[options.units] * values, BASES.get(options.base_units, 1.0) * base, cells


def cut(options: argparse.Namespace, time: np.ndarray, values: np.ndarray, base: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns the samples from the excitation to --until, every N-th; times begin at the excitation."""
    size = TIMES[options.time_units]
    zero = time[0] if options.excitation == "base" else size * options.zero
    late = np.inf if options.until is None else size * options.until
    step = (time[-1] - time[0]) / (len(time) - 1)
    keep = np.flatnonzero((time >= zero - 1e-6 * step) & (time <= late))[::options.every]
    if len(keep) < 2:
        raise InputError(f"{len(keep)} samples between --zero and --until, at times from {time[0] / size:g} to {time[-1] / size:g} "
                         f"{options.time_units}; at least 2 make a record")
    return np.maximum(time[keep] - zero, 0), values[keep], base[keep] if len(base) else base


def check_numbers(options: argparse.Namespace, names: Sequence[str], values: np.ndarray, problems: Problems) -> None:
    """Reports columns without a number, records that are too long, and names that the file has."""
    for name, column in zip(names, values.T):
        if not np.isfinite(column).any():
            problems.error(f"{options.record}: column {name}: has no number after --zero; leave the point out")
    others = held(options.output, "series") if options.add else {}
    if options.name in others:
        problems.error(f"{options.output}: has a record {options.name} already; give another --name")
    total = np.isfinite(values).sum() + sum(int(np.prod(facts.get("values.shape", (0,)))) for facts in others.values())
    if total > MOST:
        problems.error(f"the file would hold {total} numbers of records; at most {MOST} are valid: filter the record and use --every, or "
                       "--until")
    problems.stop_if_any()


def attributes_of(options: argparse.Namespace, time: np.ndarray, lowpass: float) -> dict[str, Any]:
    """Returns the attributes of the record, in SI."""
    found: dict[str, Any] = {"excitation": options.excitation, "direction": options.direction, "axis": options.axis, "medium": options.medium,
                             "units": "m/s" if options.units.endswith("/s") else "m", "rate": (len(time) - 1) / (time[-1] - time[0])}
    if options.excitation != "base":
        size = unit(options, "size-units", ALL_SIZES, "", Problems())
        found.update(point=LENGTHS[options.length_units] * np.array(options.point), size=size * options.size,
                     size_sigma=size * options.size_sd, start=float(time[0]), trigger_sigma=TIMES[options.time_units] * options.trigger_sd)
    if lowpass:
        found.update(lowpass=lowpass, order=options.order)
    return found


def main() -> None:
    """Does what the command line asks for."""
    options, problems = parse(), Problems()
    lowpass = check_options(options, problems)
    names, places, sd = read_points(options, problems)
    every_time, every_value, every_base, cells = read_record(options, names, problems)
    time, values, base = cut(options, every_time, every_value, every_base)
    check_numbers(options, names, values, problems)
    attributes = attributes_of(options, time, lowpass)
    data = {"points": places, "values": values, "sigma": sd, **({"base": base} if len(base) else {})}
    write_groups(options.output, "series", {options.name: (attributes, data)}, options.air_density, options.add)
    print(f"{options.record}: {cells.table.spelling()}")
    filtered = f"a low-pass filter of order {options.order} at {lowpass:g} Hz" if lowpass else "no filter"
    print(f"{len(time)} of {len(every_time)} samples at {attributes['rate']:.6g} Hz, from {1e3 * time[0]:.4g} to {1e3 * time[-1]:.4g} ms after "
          f"the {'first one' if len(base) else 'excitation'}; {filtered}")
    for name, column, error in zip(names, values.T, sd):
        print(f"{name}: from {np.nanmin(column):.3e} to {np.nanmax(column):.3e} +- {error:.1e} {attributes['units']}, "
              f"{np.isnan(column).sum()} missing; strongest line at {strongest(column, attributes['rate']):.4g} Hz")
    print(Path(options.output))


def strongest(column: np.ndarray, rate: float) -> float:
    """Returns the frequency [Hz] of the strongest line of a spectrum; missing values count as the mean."""
    change = np.nan_to_num(column - np.nanmean(column))
    power = np.abs(np.fft.rfft(change * np.hanning(len(change)), 8 * len(change)))
    return float(np.argmax(power) * rate / (8 * len(change)))


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("import_series", main)
