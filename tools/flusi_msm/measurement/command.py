# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a synthetic bending test of a wing: height maps under point loads, with the errors of a real experiment. Writes a
measurement file (docs/formats/measurement-format.md), and the truth about it in a separate file.

usage: make_measurement CASE.json -o measurement.h5 [--truth truth.json] [--seed N] [--refine 0|1]
                        [--set section.key=value ...] [--jobs N]
       make_measurement CASE.json -o plan.h5 --plan

The mechanics share nothing with flusi or with the programs that fit measurements. All keys of a case are in
docs/guide/synthetic-measurements.md. The same case and seed give the same numbers.
"""
from __future__ import annotations

import argparse
import json
from pathlib import Path

import flusi_msm.one_thread  # noqa: F401  (before numpy)
from flusi_msm.errors import InputError, check_folder, run_command


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", metavar="CASE", help="JSON file")
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help="measurement file to write")
    parser.add_argument("--truth", metavar="FILE", help="truth to write (default: as the output, .truth.json)")
    parser.add_argument("--seed", type=int, help="seed of all random numbers, in place of that of the case")
    parser.add_argument("--refine", type=int, choices=(0, 1), help="1: bend a mesh with four triangles for each")
    parser.add_argument("--set", dest="changes", metavar="KEY=VALUE", action="append", default=[],
                        help="change a key of the case, such as noise.height=5e-6")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="loads to be bent at the same time")
    parser.add_argument("--plan", action="store_true", help="bend nothing: state places, forces and errors of an experiment "
                                                            "that is planned, for msm_diagnose --plan")
    parser.add_argument("--quiet", action="store_true", help="print nothing")
    options = parser.parse_args()
    check_folder(options.output, options.truth)
    changes = options.changes + [f"{key}={value}" for key, value in (("seed", options.seed), ("refine", options.refine))
                                 if value is not None]
    from flusi_msm.measurement.case import read_case
    from flusi_msm.measurement.file import write_test
    from flusi_msm.measurement.synthesis import Bench, plan, synthesise
    tell = (lambda text: None) if options.quiet else (lambda text: print(text, flush=True))
    if options.plan:
        bench = Bench(read_case(options.case, changes))
        write_test(options.output, plan(bench, bench.loads()))
        tell(options.output)
        return
    content, truth = synthesise(read_case(options.case, changes), max(1, options.jobs), tell)
    write_test(options.output, content)
    place = Path(options.truth or Path(options.output).with_suffix(".truth.json"))
    try:
        place.write_text(json.dumps(truth, indent=1, default=lambda value: value.tolist()) + "\n")
    except OSError as error:
        raise InputError(f"{place}: cannot be written: {error.strerror}") from None
    tell(f"{options.output}\n{place}")


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("make_measurement", main)
