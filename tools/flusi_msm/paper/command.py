# SPDX-License-Identifier: GPL-3.0-or-later
"""Repeats the comparison of rigid and flexible blowfly wings of Truong et al. with wings without thickness, on several
grids, and writes FOLDER/paper.html with its numbers in paper.json: their Table 2 beside ours, convergence, forces over the
beat, deformation, sections, pressure, and in words what agrees and what does not.

usage: reproduce_paper [--grids 96 128 160 192] [--beats 4] [--individuals POINTS] [--ranks 2] [--folder runs/paper]
                       [--dry-run | --page] [--hours 14] [--anew] [--ini FILE] [--flusi PROGRAM]

First it measures how long all will take. A finished flight is not repeated, an interrupted one goes on from its last backup:
give the same command again. Ctrl-C stops with a backup, and so does a file STOP in the folder of the flight. The page is
written after every flight. Exit code: 0 done, 2 mistake, 3 a flight failed, 4 stopped.
"""
import argparse
import sys
from pathlib import Path

import flusi_msm.one_thread  # noqa: F401  (before numpy)
from flusi_msm.errors import InputError, run_command
from flusi_msm.project_python import INSTALLED, ROOT, program

NINE = [ROOT / f"ini/individuals/{number}.ini" for number in range(1, 10)]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grids", nargs="+", type=int, metavar="N", default=[96, 128, 160, 192], help="N x N x N/2 points")
    parser.add_argument("--beats", type=int, default=4, help="of every flight (default 4); the last two are averaged")
    parser.add_argument("--individuals", type=int, metavar="POINTS", help="also fly the nine individuals, on this grid")
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
    only.add_argument("--page", action="store_true", help="only write the page of what there is")
    options = parser.parse_args()
    for key in ("beats", "ranks", "individuals"):
        if (getattr(options, key) or 1) < 1:
            raise InputError(f"--{key} must be positive")
    grids = options.grids + ([options.individuals] if options.individuals else [])
    if any(n < 16 or n % 4 for n in grids):
        raise InputError("grids need 16 points or more, and a multiple of 4")
    return options


def print_plan(cases, estimate, hours):
    """The flights and how long each takes; refuses what takes too long."""
    print(f"{estimate.flusi.version}, {estimate.flusi.ranks} ranks; about "
          f"{estimate.steps_per_beat_and_point():.1f} N steps per beat on N x N x N/2 points", flush=True)
    total = 0.0
    for case in cases:
        left = estimate.left(case)
        total += left
        print(f"  {case.name:24} {'is there' if case.is_finished() else 'about ' + _in_hours(left)}", flush=True)
    print(f"about {_in_hours(total)} in all", flush=True)
    if total > 3600 * hours:
        raise InputError(f"this would take about {_in_hours(total)}, more than {hours:g} h: leave out grids, or allow it with "
                         "--hours")


def _in_hours(seconds):
    from flusi_msm.paper.flights import in_hours
    return in_hours(seconds)


def main():
    options = arguments()
    from flusi_msm.paper.cases import individual_cases, pair_cases, refuse_changed
    from flusi_msm.paper.flights import Estimate, Flusi, fly_all
    folder = options.folder.resolve()
    pairs = pair_cases(folder, options.ini, set(options.grids), options.beats)
    individuals = individual_cases(folder, NINE, options.individuals, options.beats) if options.individuals else {}
    cases = list({case.name: case for case in [*pairs, *individuals.values()]}.values())

    def write_page():
        from flusi_msm.paper.page import write_page as write  # draws, which a plan does not need
        return write(folder, pairs, individuals)

    if options.page:
        print(write_page())
        return
    folder.mkdir(parents=True, exist_ok=True)
    flusi = Flusi(options.flusi, options.ranks)
    refuse_changed(cases, options.anew and not options.dry_run)
    estimate = Estimate(flusi, folder, options.ini)
    print_plan(cases, estimate, options.hours)
    if options.dry_run:
        return
    failed, stopped = fly_all(flusi, cases, estimate, write_page)
    print(write_page(), flush=True)
    if stopped:
        print("stopped; give the same command again to go on")
        sys.exit(4)
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
        sys.exit(3)


def command() -> None:
    run_command("reproduce_paper", main)
