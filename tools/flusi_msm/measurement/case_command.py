# SPDX-License-Identifier: GPL-3.0-or-later
"""The common part of the commands make_modes and make_series, which make a part of a measurement file from a case."""
from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from flusi_msm.errors import InputError, check_folder


def make_part(description: str | None, suffix: str, added: str, example: str,
              load: Callable[[], tuple[Callable[..., Any], Callable[..., Any], Callable[..., Any]]], tell: Callable[..., Iterable[str]]) \
        -> None:
    """Reads the case of the command line, writes the measurement file and its truth, and prints what tell(case, part) yields.

    suffix is that of the truth; added says what --add adds, example is a change of a key. load() imports and returns
    read_case(path, changes), synthesise(case) and write(path, case, part): --help works without the packages they need.
    """
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", metavar="CASE", help="JSON file")
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help="measurement file to write")
    parser.add_argument("--add", action="store_true", help=f"add {added} the file holds")
    parser.add_argument("--truth", metavar="FILE", help=f"truth to write (default: as the output, {suffix})")
    parser.add_argument("--set", dest="changes", metavar="KEY=VALUE", action="append", default=[],
                        help=f"change a key of the case, such as {example}")
    options = parser.parse_args()
    check_folder(options.output, options.truth)
    read_case, synthesise, write = load()
    case = read_case(options.case, options.changes)
    part, truth = synthesise(case)
    if not options.add:
        Path(options.output).unlink(missing_ok=True)
    write(options.output, case, part)
    place = Path(options.truth or Path(options.output).with_suffix(suffix))
    try:
        place.write_text(json.dumps(truth, indent=1) + "\n")
    except OSError as error:
        raise InputError(f"{place}: cannot be written: {error.strerror}") from None
    for line in tell(case, part):
        print(line)
    print(f"{options.output}\n{place}")
