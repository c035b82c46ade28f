# SPDX-License-Identifier: GPL-3.0-or-later
"""Repeats the comparison of rigid and flexible blowfly wings of Truong et al. with wings without thickness, on several grids.
Writes FOLDER/paper.html, with its numbers in paper.json: their Table 2 and ours, convergence, forces over the beat, deformation,
sections, pressure, and in words what agrees and what does not.

usage: reproduce_paper [--grids 96 128 160 192 256 288] [--beats 4] [--individuals POINTS] [--ranks 2] [--folder runs/paper]
                       [--ensemble POINTS [--members 27] [--joint-factor 3]]
                       [--kinematics POINTS [--scan 3 3 3] [--scan-steps 10 15 10] [--scan-beats 2]]
                       [--dry-run | --page] [--hours 14] [--anew] [--ini FILE] [--flusi PROGRAM]

--ensemble flies flexible wings whose E and joints are drawn, and writes FOLDER/ensemble_POINTS.html; --kinematics scans the
angles that the paper does not print, and writes FOLDER/kinematics_POINTS.html. With either, the pairs of --grids are flown
only if --grids is given, too.

First it estimates how long all flights will take. A finished flight is not repeated, and an interrupted one continues from its
last backup when the same command is given again. Ctrl-C stops with a backup, and so do SIGTERM, the end of the session and a file
STOP in the folder of the flight.
The page is written after every flight, those of --ensemble and --kinematics every five minutes. Exit code: 0 done, 2 mistake,
3 a flight failed, 4 stopped.
"""
from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import flusi_msm.one_thread  # noqa: F401  (before numpy)
from flusi_msm.errors import InputError, run_command, tell_new_name
from flusi_msm.project_python import INSTALLED, ROOT, program

if TYPE_CHECKING:
    from flusi_msm.paper.flights import Estimate
    from flusi_msm.paper.studies import Study

NINE = [ROOT / f"ini/individuals/{number}.ini" for number in range(1, 10)]
GRIDS = [96, 128, 160, 192, 256, 288]


def arguments() -> argparse.Namespace:
    """Returns the options of the command line, checked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grids", nargs="+", type=int, metavar="N", help="N x N x N/2 points (default 96 128 160 192 256 288)")
    parser.add_argument("--beats", type=int, default=4, help="of every flight (default 4); the last two are averaged")
    parser.add_argument("--individuals", type=int, metavar="POINTS", help="also fly the nine individuals, on this grid")
    parser.add_argument("--ensemble", type=int, metavar="POINTS", help="fly wings whose stiffness is drawn, on this grid")
    parser.add_argument("--members", type=int, default=27, help="of the ensemble (default 27)")
    parser.add_argument("--joint-factor", type=float, default=3.0, metavar="F", help="joints are drawn log-normally, two thirds of "
                        "them within this factor of their values in the input (default 3)")
    parser.add_argument("--kinematics", type=int, metavar="POINTS", help="scan mean pitch, stroke amplitude and tilt of the stroke "
                        "plane, on this grid")
    parser.add_argument("--scan", nargs=3, type=int, default=[3, 3, 3], metavar="N", help="values of each angle, odd numbers "
                        "(default 3 3 3)")
    parser.add_argument("--scan-steps", nargs=3, type=float, default=[10.0, 15.0, 10.0], metavar="DEG", help="between the values, in "
                        "degrees (default 10 15 10); the amplitude is from peak to peak")
    parser.add_argument("--scan-beats", type=int, default=2, help="of every flight of the scan (default 2); the last is averaged")
    parser.add_argument("--ranks", type=int, default=2, help="of MPI (default 2)")
    parser.add_argument("--folder", type=Path, default=(Path() if INSTALLED else ROOT) / "runs/paper",
                        help="of all flights (default runs/paper)")
    parser.add_argument("--ini", type=Path, default=ROOT / "ini/wing.ini", help="flexible wings (default ini/wing.ini); the rigid "
                        "ones are the same file with wings = rigid")
    parser.add_argument("--flusi", type=Path, default=program("flusi"), help="the program")
    parser.add_argument("--hours", type=float, default=14.0, help="refuse to begin what would take longer (default 14)")
    parser.add_argument("--anew", action="store_true", help="fly again what has been flown with another input; that is kept")
    only = parser.add_mutually_exclusive_group()
    only.add_argument("--dry-run", action="store_true", help="say what would be flown and how long it takes")
    only.add_argument("--page", action="store_true", help="only write the pages of what there is")
    options = parser.parse_args()
    check(options)
    return options


def check(options: argparse.Namespace) -> None:
    """Refuses impossible numbers and decides whether the pairs are flown."""
    for key in ("beats", "ranks", "individuals", "members", "scan_beats"):
        value = getattr(options, key)
        if value is not None and value < 1:
            raise InputError(f"--{key.replace('_', '-')} must be positive")
    if options.grids is None:
        options.grids = [] if options.ensemble or options.kinematics else GRIDS
    grids = options.grids + [n for n in (options.individuals, options.ensemble, options.kinematics) if n is not None]
    if any(n < 16 or n % 4 for n in grids):
        raise InputError("grids need 16 points or more, and a multiple of 4")
    if not options.joint_factor >= 1:
        raise InputError("--joint-factor must be 1 or more")


def studies_of(options: argparse.Namespace, folder: Path) -> list[Study]:
    """What is flown, each with `cases`, `lines` (whether each flight has a line in the plan) and `write_page`."""
    from flusi_msm.paper import studies
    made: list[Study] = []
    if options.grids or options.individuals:
        made.append(studies.Comparison(folder, options.ini, set(options.grids), options.beats, NINE, options.individuals))
    if options.ensemble:
        made.append(studies.EnsembleStudy(folder, options.ini, options.ensemble, options.members, options.beats, options.joint_factor))
    if options.kinematics:
        made.append(studies.ScanStudy(folder, options.ini, options.kinematics, options.scan, options.scan_steps,
                                      options.scan_beats))
    return made


def print_plan(studies: Sequence[Study], estimate: Estimate, hours: float) -> None:
    """The flights and how long each takes; refuses what takes too long."""
    from flusi_msm.paper.flights import in_hours
    finest = max(case.points for study in studies for case in study.cases)
    print(f"{estimate.flusi.version}, {estimate.flusi.ranks} ranks; about {estimate.steps_per_beat_and_point(finest):.1f} N steps per "
          f"beat on N x N x N/2 points, N = {finest}", flush=True)
    total = 0.0
    for study in studies:
        left = [estimate.left(case) for case in study.cases]
        total += sum(left)
        if study.lines:
            for case, seconds in zip(study.cases, left):
                print(f"  {case.name:24} {'is there' if case.is_finished() else 'about ' + in_hours(seconds)}", flush=True)
        else:
            there = sum(case.is_finished() for case in study.cases)
            print(f"  {study.name:24} {len(study.cases)} flights, {there} {'is' if there == 1 else 'are'} there, about "
                  f"{in_hours(sum(left))}", flush=True)
    print(f"about {in_hours(total)} in all", flush=True)
    if total > 3600 * hours:
        raise InputError(f"this would take about {in_hours(total)}, more than {hours:g} h: leave out grids, or allow it with "
                         "--hours")


def stop_at_signals() -> None:
    """Makes the end of a session or of a job the same as Ctrl-C; what is ignored, as by nohup, stays ignored."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.default_int_handler)


def main() -> None:
    """Does what the command line asks for."""
    options = arguments()
    from flusi_msm.paper.cases import refuse_changed
    from flusi_msm.paper.flights import Estimate, Flusi, fly_all
    from flusi_msm.paper.studies import Pages
    folder = options.folder.resolve()
    studies = studies_of(options, folder)
    cases = [case for study in studies for case in study.cases]
    pages = Pages(studies)
    if options.page:
        pages.write_all()
        return
    folder.mkdir(parents=True, exist_ok=True)
    flusi = Flusi(options.flusi, options.ranks)
    refuse_changed(cases, options.anew and not options.dry_run)
    estimate = Estimate(flusi, folder, options.ini)
    print_plan(studies, estimate, options.hours)
    if options.dry_run:
        return
    stop_at_signals()
    failed, stopped = fly_all(flusi, cases, estimate, pages.write_some)
    pages.write_all()
    if stopped:
        print("stopped; give the same command again to go on")
        sys.exit(4)
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
        sys.exit(3)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("reproduce_paper", main)


def old_command() -> None:
    """Runs the tool under its old name."""
    tell_new_name("reproduce-paper", "reproduce_paper")
    command()
