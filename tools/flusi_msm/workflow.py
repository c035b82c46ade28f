# SPDX-License-Identifier: GPL-3.0-or-later
"""Offers training, diagnosis and flight as functions: each runs a program and returns its results.

`source` is the path of an input file, or its sections as {section: {key: value}}, which are written to `folder`
(docs/formats/parameters.md has all keys). Mistakes in it become an InputError that lists all of them; a program that fails
becomes a RunError.
"""
from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Union

import numpy as np

from flusi_msm import tables
from flusi_msm.errors import InputError
from flusi_msm.programs import Finished, Source, prepare, run
from flusi_msm.results.ini import values_of
from flusi_msm.training.run import Training, read_training

if TYPE_CHECKING:
    import pandas

Place = Union[str, os.PathLike]
VERDICTS = (0, 10, 11, 12, 20)   # exit codes of a diagnosis that has ended


@dataclass
class TrainingResult:
    """The results of a training that has ended."""
    folder: Path
    wing: Path              # trained.ini, for [include]
    history: Training       # all of NAME_history.h5
    output: str

    @property
    def parameters(self) -> "pandas.DataFrame":
        """Returns one row for each fitted parameter: value, unit, ends of the 90 % interval (NaN where the data give none)."""
        import pandas
        rows = {}
        for p in self.history.parameters:
            ends = p.interval
            rows[p.name] = {"value": p.value, "unit": p.unit, "lower": ends.lower if ends and ends.has_lower else np.nan,
                            "upper": ends.upper if ends and ends.has_upper else np.nan, "low_bound": p.low, "high_bound": p.high}
        return pandas.DataFrame.from_dict(rows, orient="index")

    @property
    def generations(self) -> "pandas.DataFrame":
        """Returns the search, one row for each generation."""
        import pandas
        return pandas.DataFrame(self.history.generations)


@dataclass
class DiagnosisResult(tables.Diagnosis):
    """The results of a diagnosis that has ended; `extended` is the wing with the cause that was found, for [include], or None."""
    folder: Path = Path()
    baseline: Path = Path()
    extended: Path | None = None
    exit_code: int = 0
    output: str = ""


@dataclass
class FlightResult:
    """The folder of a run of flusi."""
    folder: Path
    output: str = ""

    def names(self) -> list[str]:
        """Returns the names of the time series."""
        return sorted(path.stem for path in self.folder.glob("*.t"))

    def series(self, name: str = "forces") -> "pandas.DataFrame":
        """Returns a time series: forces, energy, aero_power, kinematics, ...: see names()."""
        return tables.read_series(self.folder / f"{name}.t")

    def fields(self) -> dict[str, list[Path]]:
        """Returns {quantity: files}; read one with tables.read_field."""
        return tables.list_fields(self.folder)


def _names(where: Path, path: str, section: str, **defaults: str) -> dict[str, str]:
    """Returns keys of an input file, as far as the file itself states them."""
    given = values_of((where / path).read_text()).get(section, {})
    return {key: given.get(key, default) for key, default in defaults.items()}


def train(source: Source, folder: Place | None = None, ranks: int = 1, timeout: float | None = None, echo: bool = False) -> TrainingResult:
    """Runs msm_train for one individual in `folder`; without it, in that of the input file."""
    where, path = prepare(source, folder, "train.ini")
    named = _names(where, path, "Saving", name="train", result="trained.ini")
    done = run("msm_train", [path], where, ranks, timeout=timeout, echo=echo)
    history = where / f"{named['name']}_history.h5"
    if not history.is_file():
        raise InputError(f"{path}: trains several individuals; read_training reads the history of one of them")
    return TrainingResult(where, where / named["result"], read_training(history), done.output)


def diagnose(source: Source, folder: Place | None = None, ranks: int = 1, timeout: float | None = None,
             echo: bool = False) -> DiagnosisResult:
    """Runs msm_diagnose. Every verdict is a result, also the one that the data are too few."""
    where, path = prepare(source, folder, "diagnose.ini")
    name = _names(where, path, "Saving", name="diagnosis")["name"]
    done = run("msm_diagnose", [path], where, ranks, VERDICTS, timeout, echo)
    found = tables.read_diagnosis(where / f"{name}.json")
    extended = where / f"{name}_extended.ini"
    return DiagnosisResult(found.path, found.data, where, where / f"{name}_baseline.ini", extended if extended.is_file() else None,
                           done.code, done.output)


def fly(source: Source, folder: Place | None = None, ranks: int = 1, timeout: float | None = None, echo: bool = False) -> FlightResult:
    """Runs flusi: a flow with or without wings."""
    where, path = prepare(source, folder, "fly.ini")
    done: Finished = run("flusi", [path], where, ranks, timeout=timeout, echo=echo)
    return FlightResult(where, done.output)
