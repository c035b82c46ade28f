# SPDX-License-Identifier: GPL-3.0-or-later
"""The command postprocess: finds the tool and the arguments and options of a call, and runs it."""
from __future__ import annotations

import difflib
import sys

from flusi_msm.errors import InputError, run_command

# The modules add their tools to TOOLS.
from flusi_msm.postprocess import point_tools, size_tools, sum_tools, vector_tools  # noqa: F401
from flusi_msm.postprocess.registry import PRECISIONS, TOOLS, Call, Tool

ABOUT = """postprocess TOOL ARGUMENTS   computes with field files (*.h5), under the names of FLUSI's postprocessing tools
postprocess TOOL --help      what a tool does
postprocess --help           this list

Every tool that writes fields takes --single-precision or --double-precision; without them a result has the precision of the
first input. Tools said to need fields keep that many in memory, in double precision; the others read slabs.
"""


def overview() -> str:
    lines, seen = [ABOUT], set()
    for entry in TOOLS.values():
        if id(entry) not in seen:
            seen.add(id(entry))
            lines.append(f"  {entry.name:24}{entry.about} [{entry.memory}]")
    return "\n".join(lines)


def page(entry: Tool) -> str:
    lines = [entry.usage(), "", f"{entry.about}.", f"Memory: {entry.memory}."]
    lines += [f"  --{name:20}{about}" for name, (_, about) in entry.options.items()]
    return "\n".join(lines)


def find(name: str) -> Tool:
    """Returns the tool of that name; FLUSI's leading dashes are allowed."""
    key = name.lstrip("-")
    if key not in TOOLS:
        near = difflib.get_close_matches(key, TOOLS, 1, 0.5)
        raise InputError(f"'{key}' is not a tool" + (f"; do you mean {near[0]}?" if near else "")
                         + " (postprocess --help lists all; docs/guide/post-processing.md tells FLUSI's that are not offered)")
    return TOOLS[key]


def parse(entry: Tool, arguments: list[str]) -> Call:
    """Returns the arguments and options of a call after a check of their number."""
    known = {**entry.options, **({name: (0, "") for name in PRECISIONS} if entry.writes_fields else {})}
    words, options, rest = [], {}, list(arguments)
    while rest:
        word = rest.pop(0)
        if not word.startswith("--"):
            words.append(word)
            continue
        name = word[2:]
        if name not in known:
            near = difflib.get_close_matches(name, known, 1, 0.5)
            raise InputError(f"{entry.name}: --{name} is not an option" + (f"; do you mean --{near[0]}?" if near else ""))
        values, rest = _take(entry, name, known, rest)
        options[name] = values
    least = len(entry.words) - entry.optional
    most = None if any(word.endswith("...") for word in entry.words) else len(entry.words)
    if len(words) < least or (most is not None and len(words) > most):
        raise InputError(f"{entry.name}: {len(words)} arguments are given; use: {entry.usage()}")
    return Call(entry, words, options)


def _take(entry: Tool, name: str, known: dict[str, tuple[int, str]], rest: list[str]) -> tuple[list[str], list[str]]:
    count = known[name][0]
    if len(rest) < count:
        raise InputError(f"{entry.name}: --{name} needs {count} value{'s' * (count > 1)}")
    return rest[:count], rest[count:]


def run(arguments: list[str]) -> None:
    if not arguments or arguments[0] in ("--help", "-h", "help"):
        print(overview())
        return
    if arguments[0] in ("-p", "--postprocess") and len(arguments) > 1:
        arguments = arguments[1:]  # FLUSI's command lines begin in this way
    entry = find(arguments[0])
    if any(word in ("--help", "-h") for word in arguments[1:]):
        print(page(entry))
        return
    entry.run(parse(entry, arguments[1:]))


def command() -> None:
    """Does what the command line asks for."""
    run_command("postprocess", lambda: run(sys.argv[1:]))


if __name__ == "__main__":
    command()
