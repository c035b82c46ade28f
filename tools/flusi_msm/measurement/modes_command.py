# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes natural modes of a synthetic wing, as a modal test would measure them: a measurement file
(docs/formats/measurement-format.md), and the truth about it in a file of its own.

usage: make_modes CASE.json -o modes.h5 [--truth truth.json] [--set section.key=value ...] [--add]

The mechanics are its own: nothing is shared with flusi or with what is fitted to the data. All keys of a case are in
docs/theory/vibration.md. The same case and seed give the same numbers.
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
    parser.add_argument("--add", action="store_true", help="add the modes to the bending tests that the file holds")
    parser.add_argument("--truth", metavar="FILE", help="truth to write (default: as the output, .modes.json)")
    parser.add_argument("--set", dest="changes", metavar="KEY=VALUE", action="append", default=[],
                        help="change a key of the case, such as mass.point=[8e-3,-0.5e-3,1e-8]")
    options = parser.parse_args()
    from flusi_msm.measurement.modes import read_case, synthesise, write_modes
    case = read_case(options.case, options.changes)
    modes, truth = synthesise(case)
    if not options.add:
        Path(options.output).unlink(missing_ok=True)
    write_modes(options.output, case, modes)
    place = Path(options.truth or Path(options.output).with_suffix(".modes.json"))
    try:
        place.write_text(json.dumps(truth, indent=1) + "\n")
    except OSError as error:
        raise InputError(f"{place}: cannot be written: {error.strerror}") from None
    for name, frequency, sd, *_ in modes:
        print(f"{name}  {frequency:10.3f} Hz +- {sd:.3f}")
    print(f"{options.output}\n{place}")


def command() -> None:
    run_command("make_modes", main)
