# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes blind cases: measurement files of bending tests or flights that hide one effect, two or none, and their truths, sealed
until the verdicts on all of them are written (tools/blind_score).

usage: blind_generate DESIGN.json FOLDER --cases N [--seed S] [--mix null=1,single=2] [--snr LOW HIGH] [--jobs N]
       blind_generate DESIGN.json FOLDER --fixed [NAME ...]

A design is a case of make_measurement (docs/guide/synthetic-measurements.md), whose mechanics are used, or, for flights, a case
of make_flight (docs/guide/synthetic-flights.md), which is recognised by its section "kinematics". Nothing is shared with flusi or
with the programs that fit or diagnose. Without --seed the operating system gives one. The same seed gives the same bytes; a batch
that was interrupted is completed, and a larger N adds cases to it. --fixed makes the cases in the design's section "fixed", with
open truths. docs/results/blind-tests.md describes all of this.
"""
from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import flusi_msm.one_thread  # noqa: F401  (before numpy)
from flusi_msm.errors import InputError, run_command, tell_new_name

if TYPE_CHECKING:
    from flusi_msm.blind.cases import Options


def mix_of(text: str) -> dict[str, float]:
    """Returns {kind: share} of the text of --mix."""
    from flusi_msm.blind.cases import KINDS
    mix = {}
    for part in text.split(","):
        kind, equals, share = part.partition("=")
        try:
            mix[kind.strip()] = float(share)
        except ValueError:
            equals = ""
        if not equals or kind.strip() not in KINDS or not mix[kind.strip()] >= 0:
            raise InputError(f"--mix {text}: write kind=fraction,...; kinds are {', '.join(KINDS)}")
    if not sum(mix.values()) > 0:
        raise InputError(f"--mix {text}: all fractions are 0")
    return mix


def check_options(options: argparse.Namespace) -> None:
    """Raises an InputError for impossible options."""
    if options.fixed is None and options.cases < 1 or options.individuals < 1 or options.jobs < 1:
        raise InputError("--cases, --individuals and --jobs must be at least 1")
    if not 0 < options.snr[0] < options.snr[1]:
        raise InputError("--snr needs two positive numbers, the smaller one first")
    if options.seed is not None and options.seed < 0:
        raise InputError("--seed must not be negative")


def make_flights(options: argparse.Namespace, choice: Options, tell: Callable[[str], None]) -> None:
    """Makes a batch of flights."""
    from flusi_msm.blind import flights
    from flusi_msm.measurement.flight import read_case
    if options.fixed is not None:
        raise InputError("--fixed: flights have no fixed cases; tools/make_flight makes open ones")
    flights.make_flights(read_case(options.design), options.folder, options.cases, options.seed, choice, options.jobs, tell)


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("design", metavar="DESIGN", help="JSON file")
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="of the batch")
    parser.add_argument("--cases", type=int, default=0, metavar="N", help="numbers 1 to N")
    parser.add_argument("--seed", type=int, help="of everything; default: from the operating system, sealed")
    parser.add_argument("--mix", default="null=0.25,single=0.45,double=0.15,outside=0.15", help="shares of the kinds")
    parser.add_argument("--snr", type=float, nargs=2, default=(2.0, 30.0), metavar=("LOW", "HIGH"),
                        help="signal-to-noise ratios, log-uniform")
    parser.add_argument("--individuals", type=int, default=8, metavar="N", help="different wings in a batch")
    parser.add_argument("--meshes", nargs="+", choices=("same", "finer"), default=["same", "finer"])
    parser.add_argument("--fixed", nargs="*", metavar="NAME", help="the fixed cases of the design, all or some")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="wings to be bent at the same time")
    parser.add_argument("--quiet", action="store_true", help="print nothing")
    options = parser.parse_args()
    from flusi_msm.blind import batch as batch
    from flusi_msm.blind import cases as blind
    tell = (lambda text: None) if options.quiet else (lambda text: print(text, flush=True))
    check_options(options)
    if batch.is_flight(options.design):
        make_flights(options, blind.Options(mix_of(options.mix), tuple(options.snr), options.individuals, ("same",)), tell)
        return
    design, fixed = batch.read_design(options.design)
    if options.fixed is not None:
        batch.make_fixed(design, fixed, options.fixed or sorted(fixed), options.folder, tell)
        return
    choice = blind.Options(mix_of(options.mix), tuple(options.snr), options.individuals, tuple(options.meshes))
    batch.make_batch(design, options.folder, options.cases, options.seed, choice, options.jobs, tell)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("blind_generate", main)


def old_command() -> None:
    """Runs the tool under its old name."""
    tell_new_name("blindgen", "blind_generate")
    command()
