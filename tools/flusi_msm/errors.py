# SPDX-License-Identifier: GPL-3.0-or-later
"""Collects mistakes of the user, so that all of them are reported at once."""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Callable

from flusi_msm.project_python import PACKAGES, stop_without


class InputError(Exception):
    """A mistake in the user's input; its text contains everything that the user needs to know."""


class Problems:
    """Collects mistakes, so that the user sees all of them at once."""

    def __init__(self) -> None:
        self.errors: list[str] = []
        self.notices: list[str] = []

    def error(self, text: str) -> None:
        """Adds a mistake, once."""
        if text not in self.errors:
            self.errors.append(text)

    def notice(self, text: str) -> None:
        """Adds a notice, once."""
        if text not in self.notices:
            self.notices.append(text)

    def stop_if_any(self) -> None:
        """Raises an InputError that lists all mistakes, if there is one."""
        if self.errors:
            raise InputError("\n".join(self.errors))


def check_folder(*paths: str | Path | None) -> None:
    """Raises an InputError if a file to be written is in a folder that does not exist, before anything is computed for it."""
    for path in paths:
        if path is not None and not Path(path).parent.is_dir():
            raise InputError(f"{path}: cannot be written: there is no folder {Path(path).parent}")


def run_command(name: str, main: Callable[[], None]) -> None:
    """Runs main(). An InputError, or a package that is not installed, becomes a message for each of its lines and exit code 2."""
    try:
        main()
    except ModuleNotFoundError as error:
        if error.name not in PACKAGES:
            raise
        stop_without(name, [error.name])
    except InputError as error:
        for line in str(error).split("\n"):
            print(f"{name}: {line}", file=sys.stderr)
        sys.exit(2)


def tell_new_name(old: str, new: str) -> None:
    """Prints the present name of a tool that was called by an older name, which works too."""
    print(f"{old}: this tool is called {new}; the older name works too", file=sys.stderr)
