# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps everything that a study has found in one file, a line per case. The study can be scored again from it, or continued on
another machine, without its measurements."""
from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flusi_msm.blind.ledger import digest, read, write
from flusi_msm.blind.study import Study
from flusi_msm.results.files import InputError

SCHEMA, VERSION = "flusi-msm study of msm_diagnose", 1
DIGITS = 9  # of numbers
RECORD = ("program", "exit_code", "cpu_seconds", "seconds", "problem", "verdict", "mesh_band", "chi2")
DETAILS = ("causes", "global_p", "log_global_p", "is_together", "posterior_none", "posterior_unknown", "probability_map",
           "rejection_power", "imitation", "related", "remainder_log_p", "set", "set_because", "snr", "wider")
LEADER = ("name", "variant", "log_evidence", "p", "posterior", "retained")


def program_digest(root: str | Path) -> str:
    """Returns a digest of everything that decides about verdicts: the sources of the programs with the map of probabilities, and
    the code that reads their files. It shows whether verdicts on two machines are those of one program, if that was built from
    these sources."""
    files = [*Path(root, "src").rglob("*.f90"), *Path(root, "src").rglob("*.c"), *Path(root, "cmake").rglob("*.cmake"),
             Path(root, "tools/flusi_msm/blind/verdict.py"), Path(root, "bench/diagnosis/study.py")]
    return digest(b"".join(path.read_bytes() for path in sorted(files)))


def rounded(value: Any) -> Any:
    """Returns the same with all numbers rounded to DIGITS."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    return [rounded(one) for one in value] if isinstance(value, list) else value


def short(record: dict[str, Any]) -> dict[str, Any]:
    """Returns the part of a diagnosis' record that scores and readers need."""
    kept = {key: record[key] for key in RECORD if key in record}
    if "details" in record:
        kept["details"] = {key: record["details"][key] for key in DETAILS if key in record["details"]}
        kept["noise"] = {"warning": record["noise"]["warning"]}
        kept["leaders"] = [{key: one[key] for key in LEADER if key in one} for one in record.get("leaders", [])[:3]]
    return kept


def read_lines(path: Path) -> tuple[dict[str, Any], dict[int, dict[str, Any]]]:
    """Returns (facts, {number: row}) of an archive."""
    try:
        facts, *lines = map(json.loads, path.read_text().splitlines())
        rows = {row["number"]: row for row in lines}
        kind = facts["schema"], facts["version"]
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(f"{path}: not an archive of a study") from None
    if kind != (SCHEMA, VERSION):
        raise InputError(f"{path}: not an archive of a study of version {VERSION}")
    return facts, rows


class Archive:
    """The lines of the file, {number: {"truth", "record", "oracle" if there is one}}, and the facts about their study. They are
    empty without a file, or if it does not exist yet."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.facts: dict[str, Any] = {}
        self.rows: dict[int, dict[str, Any]] = {}
        if path is not None and path.exists():
            self.facts, self.rows = read_lines(path)

    def begin(self, facts: dict[str, Any]) -> None:
        """Checks that the archive is of the same study and program."""
        if self.path is not None and not self.path.parent.is_dir():
            raise InputError(f"{self.path.parent}: there is no such folder")
        for key, value in facts.items():
            if self.rows and self.facts.get(key) != value:
                raise InputError(f"{self.path}: holds verdicts of another {key}; give another file, or --only score")
        self.facts = {"schema": SCHEMA, "version": VERSION, **facts}

    def save(self, study: Study, folder: Path, count: int) -> list[str]:
        """Adds everything that is finished in the folder to the present contents of the file. A line is complete when the gain
        of the true cause, where it is wanted, has been computed. Returns a sentence for each case that could not be archived."""
        assert self.path is not None  # there is a file to save to
        problems = []
        for number in range(1, count + 1):
            place, other = folder / f"{number:04d}.json", folder / f"{number:04d}.oracle.json"
            if number in self.rows or not place.exists():
                continue
            try:
                truth = study.truth(number)
                if study.wants_oracle(truth) and not other.exists():
                    continue
                row = {"number": number, "truth": {key: value for key, value in truth.items() if key != "generator"},
                       "record": short(read(place))}
                if other.exists():
                    row["oracle"] = read(other)
            except (InputError, OSError) as error:
                problems.append(f"case {number:04d}: {error}")
                continue
            self.rows[number] = rounded(row)
        lock = os.open(self.path.parent, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if self.path.exists():
                facts, rows = read_lines(self.path)
                if rows and facts != self.facts:
                    raise InputError(f"{self.path}: holds verdicts of another study")
                self.rows = {**rows, **self.rows}
            lines = [json.dumps(row, sort_keys=True) for row in (self.facts, *(self.rows[n] for n in sorted(self.rows)))]
            write(self.path, "\n".join(lines) + "\n")
        finally:
            os.close(lock)
        return problems


class ArchivedStudy(Study):
    """A study some of whose cases are known from an archive only."""

    def __init__(self, folder: Path, designs: Mapping[str, Any], seed: int, archive: Archive, kind: str = "bending") -> None:
        super().__init__(folder, designs, seed, kind)
        self.archive = archive

    def truth(self, number: int) -> dict[str, Any]:
        """Returns the truth of a case, from the archive if it is there."""
        return self.archive.rows[number]["truth"] if number in self.archive.rows else super().truth(number)
