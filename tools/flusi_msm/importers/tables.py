# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads tables of text as spreadsheets and instruments write them: the characters that separate cells and decimals are
recognised."""
from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from flusi_msm.errors import InputError

ENCODINGS = ("utf-8-sig", "utf-16", "cp1252")
NAMES = {",": "comma", ";": "semicolon", "\t": "tab", " ": "blanks"}
DECIMAL_COMMA = re.compile(r"^[+-]?(\d+,\d*|,\d+)([eE][+-]?\d+)?$")


@dataclass
class Table:
    """The cells of a file line by line, and how they were recognised."""
    rows: list[list[str]]
    lines: list[int]            # number of the line of each row
    separator: str
    has_decimal_comma: bool

    def spelling(self) -> str:
        """Describes how the text was understood."""
        return f"cells separated by {NAMES[self.separator]}, decimal {'comma' if self.has_decimal_comma else 'point'}"

    def number(self, text: str) -> float:
        """Returns the number that a cell contains; an empty cell is NaN."""
        text = text.strip()
        if not text:
            return float("nan")
        return float(text.replace(",", ".") if self.has_decimal_comma else text)


def read_text(path: Path) -> str:
    """Returns the text of a file in the encoding that it seems to have."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
    if b"\0" in data and not data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError(f"{path}: is not a text file")
    for encoding in ENCODINGS:
        if encoding == "utf-16" and not data.startswith((b"\xff\xfe", b"\xfe\xff")):
            continue
        try:
            return data.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise InputError(f"{path}: is not a text file")


def split(line: str, separator: str) -> list[str]:
    """Returns the cells of a line."""
    if separator == " ":
        return line.split()
    return next(csv.reader([line], delimiter=separator, skipinitialspace=True))


def find_separator(lines: list[str]) -> str:
    """Finds the separator: a semicolon or tab wherever there is one, otherwise commas, unless blanks separate numbers with
    decimal commas."""
    for candidate in (";", "\t"):
        if any(candidate in line for line in lines):
            return candidate
    words = [word for line in lines for word in line.split()]
    is_decimal = sum(bool(DECIMAL_COMMA.match(word)) for word in words)
    if any("," in line for line in lines) and not (is_decimal > len(words) / 2 and len(words) > len(lines)):
        return ","
    return " "


def read_table(path: Path) -> Table:
    """Returns every line that is not empty and no comment (# or %)."""
    kept = [(number, line) for number, line in enumerate(read_text(path).splitlines(), 1)
            if line.strip(" ;,\t") and line.lstrip()[0] not in "#%"]
    if not kept:
        raise InputError(f"{path}: is empty")
    separator = find_separator([line for _, line in kept])
    rows = [[cell.strip() for cell in split(line, separator)] for _, line in kept]
    has_comma = separator != "," and any(DECIMAL_COMMA.match(cell) for row in rows for cell in row)
    return Table(rows, [number for number, _ in kept], separator, has_comma)
