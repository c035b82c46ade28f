# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a set of height maps: a list of files with forces, or a folder with conventional names. All mistakes are found at once.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, TypeVar

import numpy as np

from flusi_msm.errors import InputError, Problems
from flusi_msm.importers.maps import READERS, Map, Pixels, read_map
from flusi_msm.importers.tables import Table, read_table

NEEDED = ["id", "file", "force", "direction_x", "direction_y", "direction_z", "point_x", "point_y"]
OPTIONAL = ["order", "time", "hold", "replicate"]
REFERENCE = "reference"
LIST, LOADS, LANDMARKS = "list.csv", "loads.csv", "landmarks.csv"
SAME_GRID = 0.005  # of the distance of grid lines: by so much those of two maps may differ, since coordinates are rounded

Result = TypeVar("Result")
Listed = tuple[list[Path], dict[str, Path], dict[str, dict]]  # files of the reference and of the loads, facts of the loads


@dataclass
class HeightSet:
    """Maps of one wing on one grid, in the units of the files. `sigma` exists where the files have it."""
    x: np.ndarray
    y: np.ndarray
    z: dict[str, np.ndarray]                      # also of `reference`
    sigma: dict[str, np.ndarray]
    facts: dict[str, dict]                        # attributes of the loads: force, direction, point, ...
    scans: np.ndarray                             # number of scans of the unloaded wing that have a height here
    landmarks: Path | None = None              # of the folder
    notes: dict[str, list[str]] = field(default_factory=dict)


def attempt(problems: Problems, what: Callable[[], Result]) -> Result | None:
    """Returns the result of what(), or None if it fails; its mistakes are collected."""
    try:
        return what()
    except InputError as error:
        for line in str(error).split("\n"):
            problems.error(line)
        return None


def read_rows(path: Path, needed: list[str], problems: Problems) -> tuple[list[dict], Table]:
    """Returns the lines of a table with names of columns as dictionaries of texts, and the table; no lines if there is a mistake."""
    nothing = Table([], [], ",", False)
    table = attempt(problems, lambda: read_table(path))
    if table is None:
        return [], nothing
    names = table.rows[0]
    known = needed + [name for name in OPTIONAL if name not in needed]
    wrong = [f"no column {name}" for name in needed if name not in names]
    wrong += [f"unknown column {name}" for name in names if name not in known]
    if wrong or len(table.rows) < 2:
        problems.error(f"{path}: {'; '.join(wrong) or 'lists nothing'} ({table.spelling()}); columns are {', '.join(known)}")
        return [], nothing
    rows = []
    for number, cells in zip(table.lines[1:], table.rows[1:]):
        if len(cells) > len(names):
            problems.error(f"{path}:{number}: has {len(cells)} cells, the first line {len(names)} ({table.spelling()})")
        rows.append({**dict.fromkeys(known, ""), **dict(zip(names, cells)), "line": number})
    return rows, table


def facts_of(row: dict, table: Table, path: Path, problems: Problems) -> dict:
    """Returns the attributes of a load in the units of the list."""
    def number(name: str, kind: type[float] | type[int]) -> float:
        try:
            value = table.number(row[name])
            if not np.isfinite(value) or (kind is int and value != int(value)):
                raise ValueError
            return kind(value)
        except (TypeError, ValueError):
            problems.error(f"{path}:{row['line']}: {row['id']}: {name} is {row[name]!r}, not {'a whole' if kind is int else 'a'} number")
            return kind(1)

    facts: dict[str, Any] = {"force": number("force", float), "direction": [number("direction_" + a, float) for a in "xyz"],
             "point": [number("point_" + a, float) for a in "xy"]}
    if not any(facts["direction"]):
        problems.error(f"{path}:{row['line']}: {row['id']}: the direction is 0 0 0")
    if not facts["force"] > 0:
        problems.error(f"{path}:{row['line']}: {row['id']}: the force must be positive; its direction has the sign")
    for name in OPTIONAL:
        if row.get(name):
            facts[name] = number(name, float if name in ("time", "hold") else int)
    return facts


def in_list(path: Path, problems: Problems) -> Listed:
    """Returns the files of reference and loads, and the loads' attributes, of a list."""
    rows, table = read_rows(path, NEEDED, problems)
    references, files, facts = [], {}, {}
    for row in rows:
        name = row["id"]
        if not row["file"]:
            problems.error(f"{path}:{row['line']}: {name}: no file")
            continue
        if name == REFERENCE:
            references.append(path.parent / row["file"])
        elif name in files:
            problems.error(f"{path}:{row['line']}: {name} is listed twice")
        else:
            files[name] = path.parent / row["file"]
            facts[name] = facts_of(row, table, path, problems)
    if rows and not references:
        problems.error(f"{path}: no line has the id {REFERENCE}")
    if rows and not files:
        problems.error(f"{path}: lists no load; at least one is needed")
    return references, files, facts


def in_folder(folder: Path, problems: Problems) -> Listed:
    """Returns the same for a folder with loads.csv, reference.* or reference_1.*, reference_2.*, ..., and a map ID.* for every
    load."""
    if (folder / LIST).exists():
        return in_list(folder / LIST, problems)
    path = folder / LOADS
    if not path.exists():
        problems.error(f"{folder}: has neither {LIST} nor {LOADS}")
        return [], {}, {}
    maps: dict[str, list[Path]] = {}
    for file in sorted(folder.iterdir()):
        if file.suffix.lower() in READERS and file.name not in (LOADS, LANDMARKS):
            maps.setdefault(file.stem, []).append(file)
    for stem, found in maps.items():
        if len(found) > 1:
            problems.error(f"{folder}: {' and '.join(file.name for file in found)} are both maps of {stem}: leave one")
    references = [found[0] for stem, found in maps.items() if stem == REFERENCE or stem.startswith(REFERENCE + "_")]
    if not references:
        problems.error(f"{folder}: no map is called {REFERENCE}.* or {REFERENCE}_1.*, ...")
    rows, table = read_rows(path, [name for name in NEEDED if name != "file"], problems)
    files, facts = {}, {}
    for row in rows:
        name = row["id"]
        if name in facts:
            problems.error(f"{path}:{row['line']}: {name} is listed twice")
            continue
        facts[name] = facts_of(row, table, path, problems)
        if name in maps:
            files[name] = maps[name][0]
        else:
            problems.error(f"{path}:{row['line']}: {name}: there is no map {name}.* in {folder}")
    for stem in maps:
        if rows and stem not in facts and maps[stem][0] not in references:
            problems.error(f"{folder}: {maps[stem][0].name} belongs to no line of {LOADS}")
    return references, files, facts


def read_height_set(path: Path, pixels: Pixels, problems: Problems) -> HeightSet | None:
    """Reads all maps of a list or folder; every mistake of every file is added to `problems`. Scans of the unloaded wing are
    averaged."""
    is_folder = path.is_dir()
    references, files, facts = (in_folder if is_folder else in_list)(path, problems)
    maps: dict[str, Map] = {}
    first: Map | None = None
    scans: list[Map] = []
    for name, file in [(REFERENCE, file) for file in references] + sorted(files.items()):
        found = attempt(problems, lambda: read_map(file, pixels))
        if found is None:
            continue
        first = first or found
        for letter, axis, other in (("x", found.x, first.x), ("y", found.y, first.y)):
            if axis.size != other.size or np.abs(axis - other).max() > SAME_GRID * np.ptp(other) / (other.size - 1):
                problems.error(f"{file}: {letter} of its map differs from that of the {'reference' if scans else 'first map'}: all maps of a "
                               "set lie on one grid")
        if name == REFERENCE:
            scans.append(found)
        else:
            maps[name] = found
    if problems.errors or first is None:
        return None
    known = np.isfinite([one.z for one in scans])
    counts = known.sum(0)
    mean = np.where(counts > 0, np.nansum([one.z for one in scans], axis=0) / np.maximum(counts, 1), np.nan)
    sigma = {name: one.sigma for name, one in maps.items() if one.sigma is not None}
    errors = [one.sigma for one in scans if one.sigma is not None]
    if len(errors) == len(scans):
        squares = np.nansum([np.where(k, error**2, 0) for k, error in zip(known, errors)], axis=0)
        sigma[REFERENCE] = np.where(counts > 0, np.sqrt(squares) / np.maximum(counts, 1), 1.0)
    z = {REFERENCE: mean, **{name: one.z for name, one in maps.items()}}
    notes = {REFERENCE: scans[0].notes, **{name: one.notes for name, one in maps.items()}}
    landmarks = path / LANDMARKS if is_folder and (path / LANDMARKS).exists() else None
    return HeightSet(first.x, first.y, z, sigma, facts, counts, landmarks, notes)
