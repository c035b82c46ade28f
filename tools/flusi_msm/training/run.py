# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the files that msm_train writes, NAME_history.h5 and NAME.log, and the wing, and describes the results in words."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import List, Optional, Tuple

import h5py
import numpy as np

from flusi_msm.results.files import InputError
from flusi_msm.wing.file import read_wing

SCHEMA, VERSION = "flusi-msm training history", 1
GENERATION = ("stage", "run", "generation", "lambda", "evaluations", "best", "generation_best", "generation_median",
              "sigma", "condition", "infeasible", "failed")
PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p"}
ROUGHLY = 1.25  # an interval whose ends are farther than this factor from its middle determines only roughly


def prefix_of(value: float, unit: str) -> Tuple[float, str]:
    """Returns (factor, unit with prefix) that make `value` a number from 1 to 1000."""
    if unit in ("", "1") or not np.isfinite(value) or value == 0:
        return 1.0, "" if unit == "1" else unit
    power = int(np.clip(3 * np.floor(np.log10(abs(value)) / 3 + 1e-9), -12, 9))
    return 10.0**-power, PREFIXES[power] + unit


def digits_of(value: float, spread: float) -> int:
    """Returns the number of decimals that show `spread` with two digits and `value` with three."""
    size = min(abs(value) / 10 if value else 1.0, spread if spread > 0 else np.inf)
    if not np.isfinite(size) or size <= 0:
        return 2
    return int(np.clip(1 - np.floor(np.log10(size) + 1e-6), 0, 6))


def in_words(value: float, unit: str, spread: float = 0.0) -> str:
    """Writes a quantity with a prefix: 8.00 GPa."""
    factor, name = prefix_of(value, unit)
    return f"{value * factor:.{digits_of(value * factor, spread * factor)}f} {name}".strip()


@dataclass
class Interval:
    """A 90 % interval by profile likelihood; an end without `has` is the bound of the search."""
    lower: float
    best: float
    upper: float
    has_lower: bool
    has_upper: bool


@dataclass
class Parameter:
    name: str
    unit: str
    low: float                        # bounds of the search
    high: float
    value: float = np.nan             # of the trained wing
    interval: Interval = None
    profile: np.ndarray = None        # (n, 2) value, sum of squares above its minimum
    is_complete: bool = True

    @property
    def is_log(self) -> bool:
        return self.low > 0

    @property
    def label(self) -> str:
        """Returns the name for readers: 'joint R4+5_base'."""
        kind, _, rest = self.name.partition(":")
        if self.name == "E":
            return "E of all veins"
        known = {"joint": "joint ", "E": "E of vein ", "zero": "zero of "}
        return known.get(kind, kind + " ") + rest if rest else self.name

    @property
    def verdict(self) -> str:
        """Returns determined | roughly | lower | upper | open | failed | unknown."""
        one = self.interval
        if not np.isfinite(self.value) or one is None:
            return "unknown"
        if not (one.has_lower and one.has_upper):
            if not (one.has_lower or one.has_upper or self.is_complete):
                return "failed"
            return "lower" if one.has_lower else "upper" if one.has_upper else "open"
        if self.is_log and one.upper / one.lower > ROUGHLY**2:
            return "roughly"
        return "determined"

    def text(self, value: Optional[float] = None) -> str:
        """Writes a value with its unit, with the digits that the interval justifies."""
        value = self.value if value is None else value
        one = self.interval
        both = one is not None and one.has_lower and one.has_upper
        return in_words(value, self.unit, (one.upper - one.lower) / 2 if both else 0.0)

    def shown(self) -> str:
        """Writes the value for a table: never one that the data do not determine."""
        verdict, one = self.verdict, self.interval
        if verdict in ("determined", "roughly"):
            return self.text(one.best)
        if verdict in ("lower", "upper"):
            return "> " + self.text(one.lower) if verdict == "lower" else "< " + self.text(one.upper)
        if verdict == "unknown" and np.isfinite(self.value):
            return self.text()
        return "not determined" if verdict == "open" else "–"

    def interval_text(self) -> str:
        if self.verdict not in ("determined", "roughly"):
            return "–"
        factor, unit = prefix_of(self.interval.best, self.unit)
        ends = np.array([self.interval.lower, self.interval.upper]) * factor
        places = digits_of(self.interval.best * factor, np.ptp(ends) / 2)
        return f"{ends[0]:.{places}f} to {ends[1]:.{places}f} {unit}".strip()

    def uncertainty(self) -> str:
        """Writes '± 3 %', 'factor 2.4' or ''."""
        one = self.interval
        if self.verdict == "roughly":
            return f"factor {np.sqrt(one.upper / one.lower):.2g}"
        if self.verdict != "determined":
            return ""
        if not self.is_log:
            return "± " + in_words((one.upper - one.lower) / 2, self.unit)
        percent = 50 * np.log(one.upper / one.lower)
        return f"± {percent:.2g} %" if percent >= 1e-4 else "± less than 0.0001 %"

    def sentence(self) -> str:
        """Writes a sentence for a reader without knowledge of statistics."""
        one, verdict = self.interval, self.verdict
        joint = self.name.startswith("joint:")
        if verdict == "determined":
            text = f"The measurements determine it: {self.text(one.best)}, {self.uncertainty()}."
        elif verdict == "roughly":
            text = f"Known roughly: about {self.text(one.best)}, and with 90 % confidence {self.interval_text()}."
        elif verdict == "lower":
            text = f"Not determined by these loads; only that it is {'stiffer' if joint else 'larger'} than " \
                   f"{self.text(one.lower)} can be said."
        elif verdict == "upper":
            text = f"Not determined by these loads; only that it is {'softer' if joint else 'smaller'} than " \
                   f"{self.text(one.upper)} can be said."
        elif verdict == "open":
            text = f"Not determined by these loads: every value from {self.text(self.low)} to {self.text(self.high)} " \
                   "fits the measurements equally well."
        elif verdict == "failed":
            return "No statement is possible: the search for its interval did not finish. Fewer parameters or " \
                   "more steps ([Polish] iterations) may help."
        elif np.isfinite(self.value):
            text = "How well the measurements determine it is not known: take the number as one that fits, not as " \
                   "known."
        else:
            text = "The training has not reached its end."
        return text if self.is_complete else text + " (The search for the ends of the interval was cut short.)"


@dataclass
class Load:
    name: str
    rows: np.ndarray                  # (n, 4) x, y, measured, simulated deformation [m]
    point: np.ndarray                 # [m]
    force: float                      # [N]
    direction: np.ndarray = None
    chi2: float = np.nan
    is_solved: bool = True
    is_excluded: bool = False         # the shape lies in one of the excluded zones

    @property
    def difference(self) -> np.ndarray:
        """Returns simulated minus measured [m]."""
        return self.rows[:, 3] - self.rows[:, 2]

    @property
    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.difference**2)))

    @property
    def largest(self) -> float:
        """Returns the largest measured deformation [m]."""
        return float(np.abs(self.rows[:, 2]).max())


@dataclass
class Readings:
    """Scalar observations: rows of load number, measured, simulated, sd, 1 for rotations."""
    names: list
    loads: list
    rows: np.ndarray


@dataclass
class Training:
    path: Path
    name: str
    cost: str                         # h or chi2
    parameters: list
    generations: dict = field(default_factory=dict)  # columns by name
    outcome: dict = field(default_factory=dict)      # numbers by name; empty if the training has not ended
    polish: np.ndarray = None         # (n, 3) evaluations, sum of squares of the data and of the priors
    covariance: np.ndarray = None
    singular_values: np.ndarray = None  # of the derivatives in units of the declared errors
    loads: list = field(default_factory=list)
    readings: Readings = None
    wing: object = None
    wing_path: str = ""
    measurement: str = ""
    log: str = ""

    @property
    def evaluations(self) -> int:
        """Returns the number of candidates of the search."""
        return int(self.generations["lambda"].sum()) if self.generations else 0

    @property
    def is_complete(self) -> bool:
        return bool(self.outcome)


def text_of(value: object) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def find_history(place: Path, name: Optional[str] = None) -> Path:
    """Returns the one history in a folder, that of `name`, or the file itself."""
    place = Path(place)
    if place.is_file():
        return place
    if not place.is_dir():
        raise InputError(f"{place}: no such folder")
    if name:
        path = place / f"{name}_history.h5"
        if not path.is_file():
            raise InputError(f"{path}: no such file")
        return path
    found = sorted(place.glob("*_history.h5"))
    if not found:
        raise InputError(f"{place}: no NAME_history.h5 of msm_train; it is written when the search has ended")
    if len(found) > 1:
        raise InputError(f"{place}: several trainings, choose with --name: " +
                         ", ".join(path.name[:-len("_history.h5")] for path in found))
    return found[0]


def read_training(path: Path) -> Training:
    """Reads everything in a history file, and the log in its folder."""
    path = Path(path)
    try:
        with h5py.File(path, "r") as file:
            version = int(np.ravel(file.attrs.get("version", 0))[0])
            if text_of(file.attrs.get("schema", "")) != SCHEMA or version != VERSION:
                raise InputError(f"{path}: not a history of version {VERSION} of msm_train")
            training = parts_of(file, path)
    except (OSError, KeyError, ValueError, IndexError) as error:
        raise InputError(f"{path}: not a readable history: {error}") from None
    for place in (Path(training.wing_path), path.parent / training.wing_path,
                  path.parent / Path(training.wing_path).name):
        if training.wing is None and place.is_file():
            try:
                training.wing = read_wing(place)
            except InputError:
                continue
    log = path.parent / f"{training.name}.log"
    if log.is_file():
        training.log = log.read_text(errors="replace")
    return training


def parts_of(file: h5py.File, path: Path) -> Training:
    names = text_of(file.attrs["unknowns"]).split()
    units = [unit.strip() for unit in text_of(file.attrs["units"]).split(",")]
    low, high = np.ravel(file.attrs["lower"]), np.ravel(file.attrs["upper"])
    if not len(names) == len(units) == len(low) == len(high):
        raise ValueError("names, units and bounds of different numbers of parameters")
    training = Training(path, path.name[:-len("_history.h5")] if path.name.endswith("_history.h5") else path.stem,
                        text_of(file.attrs["cost"]), [Parameter(*one) for one in zip(names, units, low, high)],
                        wing_path=text_of(file.attrs["wing"]), measurement=text_of(file.attrs["measurement"]))
    if "generations" in file:
        table = file["generations"][:]
        training.generations = {name: table[:, k] for k, name in enumerate(GENERATION)}
    if "outcome" in file:
        read_outcome(file, training)
    return training


def read_outcome(file: h5py.File, training: Training) -> None:
    group = file["outcome"]
    for name, value in group.attrs.items():
        if isinstance(value, (bytes, str)):
            training.outcome[name] = text_of(value)
        elif np.size(value) == 1:
            training.outcome[name] = float(np.ravel(value)[0])
    for parameter, value in zip(training.parameters, np.ravel(group.attrs["values"])):
        parameter.value = float(value)
    if "intervals" in group:
        for parameter, row in zip(training.parameters, group["intervals"][:]):
            parameter.interval = Interval(*map(float, row[:3]), *(row[3:5] > 0.5))
    for parameter in training.parameters:
        if "profiles" in file:
            parameter.is_complete = False
        if f"profiles/{parameter.name}" in file:
            made = file[f"profiles/{parameter.name}"]
            parameter.profile = made[:]
            parameter.is_complete = bool(np.ravel(made.attrs.get("is_complete", 1))[0])
    training.polish = group["path"][:] if "path" in group else None
    if "singular_values" in group.attrs:
        training.singular_values = np.ravel(group.attrs["singular_values"])
    training.covariance = group["covariance"][:] if "covariance" in group else None
    for name, made in sorted(file.get("loads", {}).items()):
        facts = {key: np.ravel(value) for key, value in made.attrs.items()}
        training.loads.append(Load(
            name, made[:], facts["point"], float(facts["force"][0]), facts.get("direction"),
            float(facts["chi2"][0]) if "chi2" in facts else np.nan, bool(facts.get("is_solved", [1])[0]),
            bool(np.any(facts.get("violation", np.zeros(2)) > 0))))
    if "readings" in file:
        made = file["readings"]
        names, loads = (text_of(made.attrs[name]).split() for name in ("names", "loads"))
        training.readings = Readings(names, loads, made[:])


def correlated_pairs(training: Training, limit: float = 0.95) -> List[Tuple[str, str, float]]:
    """Returns (name, name, correlation) of parameters of which the data determine only a combination."""
    c = training.covariance
    if c is None or len(c) != len(training.parameters):
        return []
    sd = np.sqrt(np.diag(c))
    names = [p.label for p in training.parameters]
    known = [p.verdict in ("determined", "roughly") for p in training.parameters]
    with np.errstate(invalid="ignore", divide="ignore"):
        r = c / np.outer(sd, sd)
    return [(names[i], names[j], float(r[i, j])) for i in range(len(names)) for j in range(i)
            if known[i] and known[j] and abs(r[i, j]) > limit]


def warnings_of(training: Training) -> List[str]:
    """Lists what a reader must know to judge the table."""
    found, out = [], training.outcome
    if not training.is_complete:
        found.append("The training has not reached its end: there is no trained wing yet. Go on with "
                     "msm_train --restart.")
    elif all(p.interval is None for p in training.parameters):
        found.append("There are no intervals: whether the measurements determine these numbers is not known. "
                     "Train with polish = yes and intervals = yes in [Polish].")
    ratio = error_ratio(training)
    if ratio > 1.5:
        found.append(f"Simulation and measurement differ {ratio:.2g} times as much as the declared errors allow: the "
                     "wing model or the declared errors miss something, and the intervals are too narrow.")
    elif is_beyond_chance(training):
        found.append(f"The differences are larger than chance allows (χ² = {out['chi2']:.0f} of {out['residuals']:.0f} "
                     "values; with independent errors as declared that happens in less than 1 of 100 cases): the errors "
                     "may be larger than declared, or the search may have ended in a minimum that is not the lowest. "
                     "Train again with another seed and compare χ².")
    elif ratio < 2 / 3:
        found.append(f"Simulation and measurement differ {1 / ratio:.2g} times less than the declared errors: the "
                     "declared errors are larger than the true ones, and the intervals are too wide.")
    for p in training.parameters:
        if p.verdict in ("determined", "roughly", "unknown") and is_at_bound(p):
            found.append(f"{p.label} lies at a bound of the search: a wider range may give another value.")
    for load in training.loads:
        if not load.is_solved:
            found.append(f"Load {load.name}: no equilibrium was found at the final values.")
        elif load.is_excluded:
            found.append(f"Load {load.name}: the final shape lies in an excluded zone.")
    if training.is_complete and out.get("cold_difference", 0) > 0.1 * out.get("h", np.inf) > 0:
        found.append("Solved again from the unloaded wing, the shapes differ by "
                     f"{in_words(out['cold_difference'], 'm')}: the equilibrium may not be the only one.")
    if training.generations:
        share = (training.generations["failed"].sum() / max(1, training.evaluations))
        if share > 0.2:
            found.append(f"{100 * share:.0f} % of the candidates had no solution: the bounds may be too wide, or the "
                         "forces too large.")
    for one, other, r in correlated_pairs(training):
        found.append(f"{one} and {other} are determined only together (correlation {r:+.2f}): a larger value of one "
                     f"goes with a {'larger' if r > 0 else 'smaller'} value of the other.")
    found += [f"The log says: {line.strip()}" for line in training.log.splitlines() if line.startswith("failed ")]
    return found


def is_beyond_chance(training: Training) -> bool:
    """Returns whether chi^2 exceeds its 99 % point; for many values it is normal with the variance 2 n."""
    n, chi2 = training.outcome.get("residuals", 0), training.outcome.get("chi2", 0)
    return bool(n > 0 and chi2 - n > 2.326 * np.sqrt(2 * n))


def is_at_bound(p: Parameter) -> bool:
    """Returns whether a value is within a thousandth of the range of the search from one of its ends."""
    if not np.isfinite(p.value):
        return False
    low, value, high = (np.log([p.low, p.value, p.high]) if p.is_log and p.value > 0 else (p.low, p.value, p.high))
    return min(value - low, high - value) < 1e-3 * (high - low)


def error_ratio(training: Training) -> float:
    """Returns the root of the mean squared difference in units of the declared errors, or NaN."""
    out = training.outcome
    if not out.get("residuals"):
        return np.nan
    return float(np.sqrt(out["chi2"] / out["residuals"]))
