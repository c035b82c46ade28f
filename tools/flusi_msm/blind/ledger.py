# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the ledger of blind cases and their sealed truths.

    FOLDER/ledger.json          every case that was ever made, with the hashes of its measurement and of its truth
    FOLDER/NNNN.h5              measurements
    FOLDER/sealed/NNNN.json     salt and truth; the ledger has the SHA-256 of both together
    FOLDER/opened.json          hashes of the verdicts that were there when the seals were broken

Truths are opened only when the verdicts exist. A verdict that changes afterwards is not blind, and is refused."""
from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flusi_msm.results.files import InputError

SCHEMA, VERSION = "flusi-msm blind cases", 1


def digest(data: bytes | str) -> str:
    """Returns the SHA-256 of bytes, or of a text."""
    return hashlib.sha256(data if isinstance(data, bytes) else data.encode()).hexdigest()


def dump(data: Any) -> str:
    """Returns the text of a JSON file."""
    return json.dumps(data, indent=1, sort_keys=True, default=lambda value: value.tolist()) + "\n"


def write(path: Path, text: str) -> None:
    """Writes a file completely or not at all, also if others write the same one."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        part.write_text(text)
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None


def read(path: Path) -> Any:
    """Returns what a JSON file holds."""
    try:
        return json.loads(path.read_text())
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: not JSON: {error}") from None


class Ledger:
    """The ledger of a folder."""

    def __init__(self, folder: str | Path) -> None:
        self.folder, self.path = Path(folder), Path(folder) / "ledger.json"
        self.cases, self.facts = {}, {}
        if self.path.exists():
            data = read(self.path)
            if data.get("schema") != SCHEMA or data.get("version") != VERSION:
                raise InputError(f"{self.path}: not a ledger of version {VERSION}")
            self.cases, self.facts = {row["case"]: row for row in data["cases"]}, data["facts"]

    def begin(self, facts: dict[str, Any]) -> None:
        """Enters the facts about the whole batch; those of a batch that exists must be the same."""
        if self.cases and facts != self.facts:
            raise InputError(f"{self.folder}: holds a batch with other settings; use another folder")
        self.facts = facts
        try:
            (self.folder / "sealed").mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.folder}: cannot be made: {error.strerror}") from None
        self.save()

    def save(self) -> None:
        """Writes ledger.json."""
        write(self.path, dump({"schema": SCHEMA, "version": VERSION, "facts": self.facts,
                               "cases": [self.cases[name] for name in sorted(self.cases)]}))

    def seal(self, name: str, truth: dict[str, Any], salt: str) -> None:
        """Seals the truth of a case whose measurement is written, and enters both in the ledger."""
        text = dump(truth)
        write(self.folder / "sealed" / f"{name}.json", dump({"salt": salt, "truth": text}))
        self.cases[name] = {"case": name, "measurement": f"{name}.h5", "truth_sha256": digest(salt + text),
                            "measurement_sha256": digest((self.folder / f"{name}.h5").read_bytes())}
        self.save()

    def open(self, verdicts: Mapping[str, Path]) -> dict[str, tuple[dict[str, Any], Any]]:
        """Returns {case: (truth, verdict)} of all cases, for the verdicts {case: path}. All verdicts must exist, and every seal
        is checked."""
        missing = sorted(set(self.cases) - set(verdicts))
        if not self.cases:
            raise InputError(f"{self.path}: there are no cases")
        if missing:
            raise InputError(f"{len(missing)} of {len(self.cases)} verdicts are missing, the first is that of "
                             f"{missing[0]}; truths stay sealed until all are there")
        texts = {}
        for name in sorted(self.cases):
            try:
                texts[name] = verdicts[name].read_text()
            except OSError as error:
                raise InputError(f"{verdicts[name]}: {error.strerror}") from None
        hashes = {name: digest(text) for name, text in texts.items()}
        place = self.folder / "opened.json"
        if place.exists():
            before = read(place)
            changed = [name for name in sorted(before) if before[name] != hashes.get(name)]
            if changed:
                raise InputError(f"the verdict of {changed[0]} was changed after the truths had been opened: it is not "
                                 "blind")
            hashes = {**hashes, **before}
        write(place, dump(hashes))
        return {name: (self.truth(name), read(verdicts[name])) for name in sorted(self.cases)}

    def truth(self, name: str) -> dict[str, Any]:
        """Returns the truth of a case, after its seal and its measurement have been checked."""
        row, sealed = self.cases[name], read(self.folder / "sealed" / f"{name}.json")
        if digest(sealed["salt"] + sealed["truth"]) != row["truth_sha256"]:
            raise InputError(f"case {name}: the truth is not the one that was sealed")
        if digest((self.folder / row["measurement"]).read_bytes()) != row["measurement_sha256"]:
            raise InputError(f"case {name}: the measurement is not the one that was made")
        return json.loads(sealed["truth"])
