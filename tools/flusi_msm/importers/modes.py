# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes natural modes, /modes of a measurement file (docs/formats/measurement-format.md), of tables of measured modes.

usage: import_modes MODES.csv -o modes.h5 --frequency-units Hz --frequencies damped --medium air [--damping-units percent]
                    [--shapes SHAPES.csv --length-units mm] [--wing wing.h5] [--gravity 0 0 -9.81] [--air-density 1.2] [--add]

MODES.csv has a line of column names and one line for each mode: name, frequency, frequency_sd, and optionally damping (as a share
of the critical one), damping_sd, number (1: the lowest mode of the wing) and medium (in place of --medium). SHAPES.csv has one
line for each place of each mode: mode, x, y, shape, sd; the displacement along z and its sd are in any unit. A mode without a
shape needs a number. A ring-down has the damped frequency, f sqrt(1 - d^2) with the damping ratio d; the file holds the undamped
one, f. docs/guide/import-data.md explains all of this.
"""
from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flusi_msm.errors import Problems, run_command
from flusi_msm.importers.cells import Cells, unit
from flusi_msm.importers.vibration_file import LENGTHS, MEDIA, Group, OnWing, held, write_groups

FREQUENCIES = {"Hz": 1.0, "kHz": 1e3, "rad/s": 1 / (2 * math.pi)}
DAMPINGS = {"ratio": 1.0, "percent": 0.01}
KINDS = ("undamped", "damped")
MOST_FREQUENCY = 1e9  # [Hz]
FEWEST = 2            # places of a shape


@dataclass
class Mode:
    """One line of the table, in SI."""
    name: str
    row: int
    medium: str
    frequency: float                   # [Hz] of the undamped mode
    frequency_sd: float
    damping: float = math.nan          # share of the critical one; NaN: unknown
    damping_sd: float = math.nan
    number: int = 0                    # 0: not stated
    places: list[np.ndarray] = field(default_factory=list)
    shape: list[float] = field(default_factory=list)
    sd: list[float] = field(default_factory=list)
    gravity: Sequence[float] = ()      # [m/s^2] that bends the wing while it vibrates

    def group(self) -> Group:
        """Returns the attributes and datasets of the file."""
        attributes: dict[str, Any] = {"frequency": self.frequency, "frequency_sigma": self.frequency_sd, "medium": self.medium}
        if not math.isnan(self.damping):
            attributes.update(damping=self.damping, damping_sigma=self.damping_sd)
        if self.number:
            attributes["number"] = self.number
        if self.gravity:
            attributes["gravity"] = self.gravity
        return attributes, {"points": self.places, "shape": self.shape, "sigma": self.sd} if self.shape else {}


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Returns the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modes", metavar="MODES.csv")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="measurement file to write")
    parser.add_argument("--frequency-units", required=True, choices=FREQUENCIES)
    parser.add_argument("--frequencies", required=True, choices=KINDS, help="those of the undamped modes, or those of damped oscillations")
    parser.add_argument("--damping-units", choices=DAMPINGS, help="required with a column damping")
    parser.add_argument("--medium", choices=MEDIA, help="required without a column medium")
    parser.add_argument("--air-density", type=float, metavar="KG/M3", help="(default: 1.2)")
    parser.add_argument("--gravity", type=float, nargs=3, default=(), metavar=("X", "Y", "Z"),
                        help="m/s^2, if the weight bends the wing while it vibrates (default: the wing is unloaded)")
    parser.add_argument("--shapes", metavar="SHAPES.csv", help="places and displacements of the modes")
    parser.add_argument("--length-units", choices=LENGTHS, help="of x and y; required with --shapes")
    parser.add_argument("--wing", metavar="FILE", help="wing file: places that are not on it are refused")
    parser.add_argument("--add", action="store_true", help="add the modes to what the file holds")
    return parser.parse_args(arguments)


def undamped(frequency: float, sd: float, damping: float, damping_sd: float) -> tuple[float, float]:
    """Returns the frequency of the undamped mode and its sd, of those of a damped oscillation (Gaussian propagation of errors)."""
    rest = 1 - damping**2
    return frequency / math.sqrt(rest), math.hypot(sd / math.sqrt(rest), frequency * damping * damping_sd / rest**1.5)


def read_mode(cells: Cells, k: int, options: argparse.Namespace, frequency_unit: float, damping_unit: float, problems: Problems) -> Mode:
    """Returns the mode of one line; numbers are NaN after a mistake."""
    name = cells.name(k, "name")
    most = MOST_FREQUENCY / frequency_unit
    frequency = frequency_unit * cells.number(k, "frequency", 0, most, True)
    sd = frequency_unit * cells.number(k, "frequency_sd", 0, most, True)
    if sd > frequency:
        problems.error(f"{cells.place(k, 'frequency_sd')} is more than the frequency")
    damping = damping_sd = math.nan
    if cells.text(k, "damping"):
        damping = damping_unit * cells.number(k, "damping", 0, 1 / damping_unit if damping_unit > 0 else math.inf)
        damping_sd = damping_unit * cells.number(k, "damping_sd", 0, 1 / damping_unit if damping_unit > 0 else math.inf, True)
        if not cells.text(k, "damping_sd") and "damping_sd" not in cells.columns:
            problems.error(f"{cells.path}:{cells.line(k)}: has no column damping_sd; it is required with damping")
    elif cells.text(k, "damping_sd"):
        problems.error(f"{cells.place(k, 'damping')} is empty, but damping_sd is not")
    if options.frequencies == "damped":
        if not cells.text(k, "damping"):
            problems.error(f"{cells.path}:{cells.line(k)}: --frequencies damped needs the damping of every mode; without it state undamped, "
                           "if damping changes the frequency by less than its sd")
        elif damping >= 1:
            problems.error(f"{cells.place(k, 'damping')} is 1 or more: such a mode does not oscillate and has no damped frequency")
        elif not math.isnan(damping + damping_sd):
            frequency, sd = undamped(frequency, sd, damping, damping_sd)
    medium = cells.word(k, "medium", MEDIA) if "medium" in cells.columns else options.medium or ""
    number = cells.number(k, "number", 1, 1000, is_required=False)
    if number != round(number) if not math.isnan(number) else False:
        problems.error(f"{cells.place(k, 'number')} is {number:g}; a whole number is valid")
        number = math.nan
    return Mode(name, k, medium, frequency, sd, damping, damping_sd, 0 if math.isnan(number) else int(number), gravity=options.gravity)


def read_modes(options: argparse.Namespace, problems: Problems) -> tuple[list[Mode], Cells]:
    """Returns the modes of the table, without shapes."""
    cells = Cells(options.modes, problems)
    cells.check_columns(("name", "frequency", "frequency_sd"), ("damping", "damping_sd", "number", "medium"))
    damping_unit = math.nan
    if "damping" in cells.columns:
        damping_unit = unit(options, "damping-units", DAMPINGS, f"as {cells.path} has a column damping", problems)
    if ("medium" in cells.columns) == (options.medium is not None):
        problems.error(f"--medium: state it {'either with the option or in the column medium' if options.medium else 'here or in a column medium'}"
                       f"; one of {', '.join(MEDIA)}")
    modes = [read_mode(cells, k, options, FREQUENCIES[options.frequency_units], damping_unit, problems) for k in range(len(cells.rows))]
    for k, mode in enumerate(modes):
        for other in modes[:k]:
            if mode.name and mode.name == other.name:
                problems.error(f"{cells.place(mode.row, 'name')} is {mode.name}, as in line {cells.line(other.row)}")
            if mode.number and (mode.number, mode.medium) == (other.number, other.medium):
                problems.error(f"{cells.place(mode.row, 'number')} is {mode.number}, as in line {cells.line(other.row)}; modes in the same "
                               "medium need different numbers")
    return modes, cells


def read_shapes(modes: Sequence[Mode], options: argparse.Namespace, problems: Problems) -> None:
    """Gives the modes the shapes of a second table."""
    cells = Cells(options.shapes, problems)
    cells.check_columns(("mode", "x", "y", "shape", "sd"))
    size = unit(options, "length-units", LENGTHS, "with --shapes", problems)
    wing, by_name = OnWing(options.wing), {mode.name: mode for mode in modes}
    for k in range(len(cells.rows)):
        place = size * np.array([cells.number(k, "x"), cells.number(k, "y")])
        value, sd = cells.number(k, "shape"), cells.number(k, "sd", 0, is_open=True)
        mistake = wing.mistake(place)
        if mistake:
            problems.error(f"{cells.path}:{cells.line(k)}: columns x, y: {mistake}")
        mode = by_name.get(cells.text(k, "mode"))
        if mode is None:
            problems.error(f"{cells.place(k, 'mode')} is {cells.text(k, 'mode')!r}; the modes of {options.modes} are {', '.join(by_name)}")
            continue
        mode.places.append(place)
        mode.shape.append(value)
        mode.sd.append(sd)


def check_shapes(modes: Sequence[Mode], cells: Cells, problems: Problems) -> None:
    """Reports modes that cannot be recognised."""
    for mode in modes:
        where = f"{cells.path}:{cells.line(mode.row)}: mode {mode.name}"
        if not mode.shape and not mode.number and not cells.text(mode.row, "number"):
            problems.error(f"{where} cannot be recognised: give it a shape (--shapes), or its place among all modes in the column number")
        elif len(mode.shape) == 1:
            problems.error(f"{where} has a shape of one place; at least {FEWEST} places make a shape")
        elif mode.shape and not np.any(mode.shape):
            problems.error(f"{where} has a shape that is 0 everywhere")


def check_held(modes: Sequence[Mode], path: str, problems: Problems) -> None:
    """Reports modes that a file holds already."""
    for name, facts in held(path, "modes").items():
        for mode in modes:
            if mode.name == name:
                problems.error(f"{path}: has a mode {name} already; give it another name")
                continue
            is_same = not facts["has_loads"] and list(facts.get("gravity", ())) == list(mode.gravity)
            if mode.number and is_same and (facts.get("number"), facts.get("medium")) == (mode.number, mode.medium.encode()):
                problems.error(f"{path}: mode {name} has the number {mode.number} in {mode.medium} already")


def main() -> None:
    """Does what the command line asks for."""
    options, problems = parse(), Problems()
    if options.air_density is not None and not 0 < options.air_density <= 1000:
        problems.error("--air-density: is out of range; valid: above 0, at most 1000 kg/m^3")
    if options.gravity and not 0 < max(abs(value) for value in options.gravity) <= 1000:
        problems.error("--gravity: is out of range; valid: a vector above 0, at most 1000 m/s^2")
    modes, cells = read_modes(options, problems)
    if options.shapes is not None:
        read_shapes(modes, options, problems)
    check_shapes(modes, cells, problems)
    if options.add:
        check_held(modes, options.output, problems)
    problems.stop_if_any()
    write_groups(options.output, "modes", {mode.name: mode.group() for mode in modes}, options.air_density, options.add)
    print(f"{options.modes}: {cells.table.spelling()}; frequencies in the file are those of the undamped modes")
    for mode in modes:
        damping = "" if math.isnan(mode.damping) else f"  damping {100 * mode.damping:.3g} +- {100 * mode.damping_sd:.2g} %"
        print(f"{mode.name}: {mode.frequency:.6g} +- {mode.frequency_sd:.2g} Hz in {mode.medium}{damping}"
              + (f"  number {mode.number}" if mode.number else "") + (f"  {len(mode.shape)} places" if mode.shape else ""))
    print(options.output)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("import_modes", main)
