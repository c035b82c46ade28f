# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes natural modes of a synthetic wing, as a modal test would measure them. Writes a measurement file
(docs/formats/measurement-format.md), and the truth about it in a separate file.

usage: make_modes CASE.json -o modes.h5 [--truth truth.json] [--set section.key=value ...] [--add]

The mechanics share nothing with flusi or with what is fitted to the data. All keys of a case are in docs/theory/vibration.md. The
same case and seed give the same numbers.
"""
from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

import flusi_msm.one_thread
import flusi_msm.project_python  # noqa: F401
from flusi_msm.errors import run_command
from flusi_msm.measurement.case_command import make_part

if TYPE_CHECKING:
    from flusi_msm.measurement.modes import Case, Measured


def load() -> tuple[Callable[..., Any], Callable[..., Any], Callable[..., Any]]:
    """Returns what `make_part` needs."""
    from flusi_msm.measurement.modes import read_case, synthesise, write_modes
    return read_case, synthesise, write_modes


def tell(case: Case, modes: Iterable[Measured]) -> Iterator[str]:
    """Yields a line for each mode."""
    for name, frequency, sd, *_ in modes:
        yield f"{name}  {frequency:10.3f} Hz +- {sd:.3f}"


def main() -> None:
    """Does what the command line asks for."""
    make_part(__doc__, ".modes.json", "the modes to the bending tests that", "mass.point=[8e-3,-0.5e-3,1e-8]", load, tell)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("make_modes", main)
