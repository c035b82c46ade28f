# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a record of a synthetic wing that rings after a release, after a tap or on a moving base: a measurement file
(docs/formats/measurement-format.md), and the truth about it in a file of its own.

usage: make_series CASE.json -o series.h5 [--truth truth.json] [--set section.key=value ...] [--add]

The mechanics and the integration in time are its own: nothing is shared with flusi or with what is fitted to the data. All keys
of a case are in docs/theory/ring-down.md. The same case and seed give the same numbers.
"""
import argparse
import json
from pathlib import Path

import flusi_msm.one_thread
import flusi_msm.project_python  # noqa: F401
from flusi_msm.errors import InputError, run_command


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", metavar="CASE", help="JSON file")
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help="measurement file to write")
    parser.add_argument("--add", action="store_true", help="add the record to what the file holds")
    parser.add_argument("--truth", metavar="FILE", help="truth to write (default: as the output, .series.json)")
    parser.add_argument("--set", dest="changes", metavar="KEY=VALUE", action="append", default=[],
                        help="change a key of the case, such as damping.relaxation=0.1")
    options = parser.parse_args()
    from flusi_msm.measurement.series import read_case, synthesise, write_series
    case = read_case(options.case, options.changes)
    record, truth = synthesise(case)
    if not options.add:
        Path(options.output).unlink(missing_ok=True)
    write_series(options.output, case, record)
    place = Path(options.truth or Path(options.output).with_suffix(".series.json"))
    try:
        place.write_text(json.dumps(truth, indent=1) + "\n")
    except OSError as error:
        raise InputError(f"{place}: cannot be written: {error.strerror}") from None
    print(f"{case.name}  {record['values'].shape[0]} samples of {record['values'].shape[1]} points, sd {record['sigma'].max():.3g}")
    print(f"{options.output}\n{place}")


def command() -> None:
    run_command("make_series", main)
