# SPDX-License-Identifier: GPL-3.0-or-later
"""One file with all that a study has found, a line per case, from which it is scored again, or continued on another
machine, without its measurements."""
import json
from pathlib import Path

from _blind_ledger import digest, read, write
from _blind_study import Study
from _flusi_io import InputError

SCHEMA, VERSION = "flusi-msm study of msm_diagnose", 1
DIGITS = 9  # of numbers
RECORD = ("exit_code", "cpu_seconds", "seconds", "problem", "verdict", "mesh_band", "chi2")
DETAILS = ("causes", "global_p", "log_global_p", "is_together", "posterior_none", "posterior_unknown", "probability_map",
           "rejection_power", "related", "remainder_log_p", "set_because", "snr")
LEADER = ("name", "variant", "log_evidence", "p", "posterior", "retained")


def program_digest(root):
    """Of the sources that decide about verdicts, but for the map that is learned from them: tells whether verdicts on two
    machines are those of one program."""
    folders = ("base", "parallel", "io", "solid_msm", "measurement", "diagnosis")
    files = [path for folder in folders for path in Path(root, "src", folder).rglob("*.f90")]
    files += Path(root, "src/app").glob("app_diagnose*.f90")
    return digest(b"".join(path.read_bytes() for path in sorted(files) if path.name != "diagnosis_stated_table.f90"))


def rounded(value):
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    return [rounded(one) for one in value] if isinstance(value, list) else value


def short(record):
    """What scores and readers need of the record of a diagnosis."""
    kept = {key: record[key] for key in RECORD if key in record}
    if "details" in record:
        kept["details"] = {key: record["details"][key] for key in DETAILS if key in record["details"]}
        kept["noise"] = {"warning": record["noise"]["warning"]}
        kept["leaders"] = [{key: one[key] for key in LEADER if key in one} for one in record.get("leaders", [])[:3]]
    return kept


class Archive:
    """The lines of the file: {number: {"truth", "record", "oracle" if there is one}}, and what they are of."""

    def __init__(self, path):
        self.path, self.facts, self.rows = path, {}, {}
        if path is None or not path.exists():
            return
        lines = path.read_text().splitlines()
        try:
            self.facts, *rows = map(json.loads, lines)
            self.rows = {row["number"]: row for row in rows}
        except (ValueError, KeyError, TypeError):
            raise InputError(f"{path}: not an archive of a study") from None
        if (self.facts.get("schema"), self.facts.get("version")) != (SCHEMA, VERSION):
            raise InputError(f"{path}: not an archive of a study of version {VERSION}")

    def begin(self, facts):
        """What is archived must be of the same study and program."""
        for key, value in facts.items():
            if self.rows and self.facts.get(key) != value:
                raise InputError(f"{self.path}: holds verdicts of another {key}; give another file, or --only score")
        self.facts = {"schema": SCHEMA, "version": VERSION, **facts}

    def save(self, study, folder, count):
        """Everything that is finished in the folder joins what is there. A line is complete when the gain of the true
        cause, where it is asked for, has been looked for."""
        for number in range(1, count + 1):
            place, other = folder / f"{number:04d}.json", folder / f"{number:04d}.oracle.json"
            if number in self.rows or not place.exists():
                continue
            truth = study.truth(number)
            if truth["kind"] == "single" and truth["snr"] >= 8 and not other.exists():
                continue
            row = {"number": number, "truth": {key: value for key, value in truth.items() if key != "generator"},
                   "record": short(read(place))}
            if other.exists():
                row["oracle"] = read(other)
            self.rows[number] = rounded(row)
        lines = [json.dumps(row, sort_keys=True) for row in (self.facts, *(self.rows[n] for n in sorted(self.rows)))]
        write(self.path, "\n".join(lines) + "\n")


class ArchivedStudy(Study):
    """A study some of whose cases are known from an archive only."""

    def __init__(self, folder, designs, seed, archive):
        super().__init__(folder, designs, seed)
        self.archive = archive

    def truth(self, number):
        return self.archive.rows[number]["truth"] if number in self.archive.rows else super().truth(number)
