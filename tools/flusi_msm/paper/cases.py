# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines the flights of the comparison with Truong et al.: their inputs, and the state that their folders show."""
from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from flusi_msm.results.files import InputError
from flusi_msm.results.ini import differences, values_of, with_values

RIGID, FLEXIBLE, INDIVIDUAL = "rigid", "flexible", "individual"
INI = "wing.ini"
STATE = "case.json"
SNAPSHOT_PHASES = (0.25, 0.5, 0.75, 1.0)  # of the last beat, when fields and surfaces are saved

Values = dict[str, dict[str, Any]]  # {section: {key: value}} of an input


def _resolved(text: str, folder: Path) -> str:
    """Returns the input with absolute names of the files that it reads."""
    text = re.sub(r"(from_file::)(?!/)([^;\s]+)", lambda m: m[1] + str((folder / m[2]).resolve()), text)
    return re.sub(r"(?m)^(\s*file\s*=\s*)(?!/)([^;\s]+)", lambda m: m[1] + str((folder / m[2]).resolve()), text)


def _digest_of(word: str) -> str:
    """Returns the name of a file with the digest of its content instead of the folder, so that folders may be moved."""
    path = Path(word.split("from_file::")[-1])
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    return f"{path.name} {hashlib.sha256(path.read_bytes()).hexdigest()[:16]}"


def fingerprint(text: str) -> dict[str, dict[str, str]]:
    """Returns the values of an input, files by their content: they are equal for two inputs that give the same flight."""
    values = values_of(text)
    for section, keys in values.items():
        for key, value in keys.items():
            if value.startswith("from_file::") or (section, key) == ("Wing", "file"):
                keys[key] = _digest_of(value)
    return values


def read_text(path: str | Path) -> str:
    """Returns the text of a file; raises an InputError if there is none."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None


class Case:
    """One flight: `text` is its input, `folder` is where it is computed; it has `points` along x and lasts `beats`. `speed` is the
    speed of the wings divided by that in the file."""
    speed = 1.0

    def __init__(self, folder: str | Path, ini: str | Path, kind: str, points: int, beats: float) -> None:
        self.kind, self.points, self.beats = kind, points, beats
        self.label = Path(ini).stem if kind == INDIVIDUAL else kind
        self.name = f"{kind}_{self.label}_{points}" if kind == INDIVIDUAL else f"{kind}_{points}"
        self.folder = Path(folder) / self.name
        self.base = _resolved(read_text(ini), Path(ini).resolve().parent)
        self.text = with_values(self.base, self.changes())
        self.input = fingerprint(self.text)

    def changes(self) -> Values:
        """Returns the values of this flight that differ from its file: grid, sponge of the same length, times, and what is
        saved."""
        own = values_of(self.base)
        try:
            before = {key: int(own["Resolution"][key]) for key in ("nx", "ny", "nz")}
            units = own.get("units", {})
            beat = 1 / float(units["frequency"]) if units.get("input") == "SI" else 1.0
            sponge = int(own.get("Sponge", {}).get("sponge_thickness", 0))
        except (KeyError, ValueError) as error:
            raise InputError(f"the input must have nx, ny, nz and the frequency of the beat: {error}") from None
        scale = self.points / before["nx"]
        values: Values = {"Resolution": {key: round(n * scale / 2) * 2 for key, n in before.items()},
                  "Time": {"Tmax": f"{self.beats * beat:.12g}"},
                  "Saving": {"tsave": f"{beat / 4:.12g}", "tsave_first": f"{(self.beats - 0.9) * beat:.12g}",
                             "tintegral": f"{beat / 100:.12g}", "iSaveVelocity": 0, "iSavePress": 0, "iSaveMagVorticity": 0,
                             "iSaveVorticity": int(self.kind != INDIVIDUAL),
                             "iSaveWingSides": int(self.kind != INDIVIDUAL), "truntime": 0.25}}
        if sponge:
            values["Sponge"] = {"sponge_thickness": max(2, round(sponge * scale))}
        if self.kind != INDIVIDUAL:
            values["Insects"] = {"wings": self.kind}
        return values

    # ---- what is in the folder ---------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """Returns what was noted about the flight, {} if it was never begun."""
        path = self.folder / STATE
        if not path.is_file():
            return {}
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise InputError(f"{path}: damaged: {error}") from None

    def note(self, **news: Any) -> None:
        """Adds news to what is noted about the flight."""
        state = {"name": self.name, **self.state(), **news, "input": self.input}
        part = self.folder / f"{STATE}.part"
        part.write_text(json.dumps(state, indent=1) + "\n", encoding="utf-8")
        part.replace(self.folder / STATE)

    def is_finished(self) -> bool:
        """Returns whether the flight has been made with this input."""
        return self.state().get("status") == "finished" and not self.changed()

    def changed(self) -> list[str]:
        """Returns the values in which the input differs from that of the flight in the folder; empty if there are none."""
        part = f"{STATE}.part"  # of a first note that was interrupted
        if not self.folder.exists() or all(path.name == part for path in self.folder.iterdir()):
            return []
        if not self.state():
            return ["the folder holds something else"]
        return differences(self.state()["input"], json.loads(json.dumps({
            section: {key: str(value) for key, value in keys.items()} for section, keys in self.input.items()})))

    def has_backup(self) -> bool:
        """Returns whether the flight can be continued."""
        return any(self.folder.glob("runtime_backup*.h5"))

    def set_aside(self) -> Path:
        """Renames an earlier flight to NAME.1, NAME.2, ..."""
        number = 1
        while (aside := self.folder.with_name(f"{self.name}.{number}")).exists():
            number += 1
        self.folder.rename(aside)
        return aside


class Variant(Case):
    """A flight of a study: `values`, {section: {key: value}}, replace those of its file. It saves time series only."""

    def __init__(self, folder: str | Path, ini: str | Path, kind: str, points: int, beats: float, name: str, values: Values,
                 speed: float = 1.0) -> None:
        self.values = values
        super().__init__(folder, ini, kind, points, beats)
        self.name = self.label = name
        self.folder, self.speed = Path(folder) / name, speed

    def changes(self) -> Values:
        """Returns the values that differ from the file, those of the study included."""
        changes = super().changes()
        changes["Saving"] |= {"tsave": 9e9, "iSaveVorticity": 0, "iSaveWingSides": 0}
        del changes["Saving"]["tsave_first"]
        for section, keys in self.values.items():
            changes.setdefault(section, {}).update(keys)
        return changes


def pair_cases(folder: str | Path, ini: str | Path, grids: Iterable[int], beats: float) -> list[Case]:
    """Returns rigid and flexible wings on every grid, the coarsest first."""
    return [Case(folder, ini, kind, n, beats) for n in sorted(grids) for kind in (RIGID, FLEXIBLE)]


def individual_cases(folder: str | Path, inis: Iterable[str | Path], points: int, beats: float) -> dict[str, Case]:
    """Returns {label: case}; individuals whose inputs are the same share one flight, that of the first."""
    cases = {}
    flown: list[Case] = []
    for ini in inis:
        case = Case(folder, ini, INDIVIDUAL, points, beats)
        case_like_it = next((other for other in flown if other.input == case.input), case)
        if case_like_it is case:
            flown.append(case)
        cases[case.label] = case_like_it
    return cases


def refuse_changed(cases: Iterable[Case], anew: bool) -> None:
    """Ends with a message if a flight was made with another input; with `anew` that flight is kept under another name."""
    problems = []
    for case in cases:
        changed = case.changed()
        if changed and anew:
            print(f"{case.name}: the input differs; the earlier flight was moved to {case.set_aside().name}")
        elif changed:
            problems.append(f"{case.folder} was flown with another input: {'; '.join(changed[:4])}"
                            + (f" and {len(changed) - 4} more" if len(changed) > 4 else ""))
    if problems:
        raise InputError("\n".join(problems) + "\n--anew flies again and keeps what is there; or take another --folder")
