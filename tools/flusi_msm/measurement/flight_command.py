# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a record of the forces on a synthetic flapping section over the beat. Writes a measurement file
(docs/formats/measurement-format.md), and the truth about it in a separate file.

usage: make_flight CASE.json -o flight.h5 [--truth truth.json] [--set section.key=value ...] [--add]

The flow is plane, about a thin ellipse, and computed by a method that shares nothing with flusi; the same is true for the balance
and its errors. All keys of a case are in docs/guide/synthetic-flights.md. The same case and seed give the same numbers.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import flusi_msm.one_thread
import flusi_msm.project_python  # noqa: F401
from flusi_msm.errors import run_command
from flusi_msm.measurement.case_command import make_part

if TYPE_CHECKING:
    from flusi_msm.measurement.flight import Case


def load() -> tuple[Callable[..., Any], Callable[..., Any], Callable[..., Any]]:
    """Returns what `make_part` needs."""
    from flusi_msm.measurement.flight import read_case, synthesise, write_flight
    return read_case, synthesise, write_flight


def tell(case: Case, record: dict[str, Any]) -> Iterator[str]:
    """Yields a line for each component."""
    for name, mean, sd in zip(case.components.split(","), record["mean"].T, record["sd"].T):
        yield f"{case.name}  {name.strip():5s}  mean {mean.mean():10.3e}  rms {(mean**2).mean()**0.5:10.3e}  sd {sd.mean():9.2e}"


def main() -> None:
    """Does what the command line asks for."""
    make_part(__doc__, ".flight.json", "the record to what", "hidden.lead=5", load, tell)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("make_flight", main)
