# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads tables with named columns, cell by cell: every mistake is reported with the file, the line and the column."""
from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from flusi_msm.errors import InputError, Problems
from flusi_msm.importers.tables import read_table

NAME = re.compile(r"^[A-Za-z0-9_+-]{1,64}$")
WHAT_NAMES_ARE = "1 to 64 letters, digits, _, + and - are valid"


class Cells:
    """A table of text below the names of its columns, which are in lower case."""

    def __init__(self, path: str | Path, problems: Problems) -> None:
        self.path, self.problems = Path(path), problems
        self.table = read_table(self.path)
        self.columns = [name.lower() for name in self.table.rows[0]]
        self.rows = self.table.rows[1:]
        if not self.rows:
            raise InputError(f"{path}: has no line below the names of the columns")
        for name in sorted({name for name in self.columns if self.columns.count(name) > 1}):
            problems.error(f"{self.path}:{self.table.lines[0]}: two columns are called {name!r}")
        for k, row in enumerate(self.rows):
            if len(row) > len(self.columns):
                problems.error(f"{self.path}:{self.line(k)}: has {len(row)} cells, the first line {len(self.columns)} "
                               f"({self.table.spelling()})")

    def line(self, k: int) -> int:
        """Returns the number of the line of a row."""
        return self.table.lines[k + 1]

    def place(self, k: int, column: str) -> str:
        """Returns the words that say where a cell is."""
        return f"{self.path}:{self.line(k)}: column {column}"

    def check_columns(self, required: Sequence[str], optional: Sequence[str] = ()) -> None:
        """Reports columns that are unknown or missing."""
        known = [*required, *optional]
        for name in self.columns:
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                self.problems.error(f"{self.path}:{self.table.lines[0]}: unknown column {name!r}"
                                    + (f"; did you mean {near[0]}?" if near else "") + f" Columns are {', '.join(known)}")
        for name in required:
            if name not in self.columns:
                self.problems.error(f"{self.path}:{self.table.lines[0]}: has no column {name}; columns are {', '.join(known)}")

    def text(self, k: int, column: str) -> str:
        """Returns what a cell holds; an empty text where the table lacks the column or the cell."""
        if column not in self.columns:
            return ""
        i = self.columns.index(column)
        return self.rows[k][i] if i < len(self.rows[k]) else ""

    def number(self, k: int, column: str, lowest: float = -math.inf, highest: float = math.inf, is_open: bool = False,
               is_required: bool = True) -> float:
        """Returns the number of a cell, NaN where it is empty, or after a mistake. With `is_open` the lowest value is not valid."""
        cell = self.text(k, column)
        try:
            value = self.table.number(cell)
        except ValueError:
            self.problems.error(f"{self.place(k, column)} is {cell!r}, not a number ({self.table.spelling()})")
            return math.nan
        if math.isnan(value):
            if is_required and column in self.columns:
                self.problems.error(f"{self.place(k, column)} is empty; it must hold a number")
            return math.nan
        if math.isinf(value):
            self.problems.error(f"{self.place(k, column)} is infinite; leave the cell empty if the value is missing")
            return math.nan
        if value < lowest or value > highest or is_open and value <= lowest:
            least = f"{'above' if is_open else 'at least'} {lowest:g}" if math.isfinite(lowest) else ""
            most = f"at most {highest:g}" if math.isfinite(highest) else ""
            self.problems.error(f"{self.place(k, column)} is {value:g}; valid: {', '.join(word for word in (least, most) if word)}")
            return math.nan
        return value

    def word(self, k: int, column: str, choices: Iterable[str]) -> str:
        """Returns the word of a cell that is one of `choices`; empty after a mistake."""
        found = self.text(k, column)
        if found in choices:
            return found
        self.problems.error(f"{self.place(k, column)} is {found!r}; valid: {', '.join(choices)}")
        return ""

    def name(self, k: int, column: str) -> str:
        """Returns the name that a cell holds; empty after a mistake."""
        found = self.text(k, column)
        if NAME.match(found):
            return found
        self.problems.error(f"{self.place(k, column)} is {found!r}; {WHAT_NAMES_ARE}")
        return ""


def unit(options: object, key: str, choices: Mapping[str, float], why: str, problems: Problems) -> float:
    """Returns the size in SI of the unit that an option states; a missing one is a mistake."""
    stated = getattr(options, key.replace("-", "_"))
    if stated is None:
        problems.error(f"--{key}: required, {why}; one of {', '.join(choices)}")
        return math.nan
    return choices[stated]
