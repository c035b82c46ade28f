# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a record of the vibration of a synthetic wing after a release, after a tap or on a moving base. Writes a measurement file
(docs/formats/measurement-format.md), and the truth about it in a separate file.

usage: make_series CASE.json -o series.h5 [--truth truth.json] [--set section.key=value ...] [--add]

The mechanics and the integration in time share nothing with flusi or with what is fitted to the data. All keys of a case are in
docs/theory/ring-down.md. The same case and seed give the same numbers.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import flusi_msm.one_thread
import flusi_msm.project_python  # noqa: F401
from flusi_msm.errors import run_command
from flusi_msm.measurement.case_command import make_part

if TYPE_CHECKING:
    from flusi_msm.measurement.series import Case


def load() -> tuple[Callable[..., Any], Callable[..., Any], Callable[..., Any]]:
    """Returns what `make_part` needs."""
    from flusi_msm.measurement.series import read_case, synthesise, write_series
    return read_case, synthesise, write_series


def tell(case: Case, record: dict[str, Any]) -> Iterator[str]:
    """Yields a line about the record."""
    samples, points = record["values"].shape
    yield f"{case.name}  {samples} samples of {points} points, sd {record['sigma'].max():.3g}"


def main() -> None:
    """Does what the command line asks for."""
    make_part(__doc__, ".series.json", "the record to what", "damping.relaxation=0.1", load, tell)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("make_series", main)
