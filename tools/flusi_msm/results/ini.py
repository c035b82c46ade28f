# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads input files of flusi as text: returns their values, and the same file with other values."""
from __future__ import annotations

import re
from collections.abc import Mapping

_SECTION = re.compile(r"\s*\[([^\]]+)\]")
_KEY = re.compile(r"\s*([\w:]+)\s*=\s*([^;]*)")


def values_of(text: str) -> dict[str, dict[str, str]]:
    """Returns {section: {key: value}} without comments; values are text."""
    values: dict[str, dict[str, str]] = {}
    section = ""
    for line in text.splitlines():
        line = line.split(";")[0] if line.lstrip().startswith(";") else line
        header, key = _SECTION.match(line), _KEY.match(line)
        if header:
            section = header[1].strip()
        elif key:
            values.setdefault(section, {})[key[1]] = key[2].strip()
    return values


def with_values(text: str, changes: Mapping[str, Mapping[str, object]]) -> str:
    """Returns the text with the values {section: {key: value}} instead of its own, or added if it has none."""
    left = {section: dict(keys) for section, keys in changes.items()}
    lines: list[str] = []
    section = ""

    def add_missing() -> None:
        lines.extend(f"{key} = {value};" for key, value in left.pop(section, {}).items())

    for line in text.splitlines():
        header, key = _SECTION.match(line), _KEY.match(line)
        if header:
            add_missing()
            section = header[1].strip()
        elif key and key[1] in left.get(section, {}):
            line = f"{key[1]} = {left[section].pop(key[1])};"
        lines.append(line)
    add_missing()
    for section in list(left):
        lines.append(f"[{section}]")
        add_missing()
    return "\n".join(lines) + "\n"


def differences(before: Mapping[str, Mapping[str, str]], after: Mapping[str, Mapping[str, str]]) -> list[str]:
    """Lists the differences between two results of values_of: '[Time] CFL: 0.45, now 0.4'."""
    found = []
    for section in sorted({*before, *after}):
        old, new = before.get(section, {}), after.get(section, {})
        found += [f"[{section}] {key}: {old.get(key, 'none')}, now {new.get(key, 'none')}"
                  for key in sorted({*old, *new}) if old.get(key) != new.get(key)]
    return found
