# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes scores of verdicts on blind cases, with bounds for shares of few cases."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from math import sqrt
from typing import Any

import numpy as np
from scipy.stats import beta

from flusi_msm.blind.verdict import flat_verdict
from flusi_msm.results.files import InputError

VERDICTS = ("adequate", "named", "consistent_with_set", "unknown_cause", "data_insufficient")
FOUND = ("named", "consistent_with_set", "unknown_cause")
BINS = 10  # of probabilities


def wilson(hits: int, n: int, z: float = 1.959963984540054) -> tuple[float, float]:
    """Returns 95 % bounds of Wilson for a share."""
    if n == 0:
        return float("nan"), float("nan")
    share, middle = hits / n, (hits + z * z / 2) / (n + z * z)
    half = z / (n + z * z) * sqrt(n * share * (1 - share) + z * z / 4)
    return max(0.0, middle - half), min(1.0, middle + half)


def clopper_pearson(hits: int, n: int, level: float = 0.95) -> tuple[float, float]:
    """Returns exact bounds of a share."""
    if n == 0:
        return float("nan"), float("nan")
    tail = (1 - level) / 2
    return (float(beta.ppf(tail, hits, n - hits + 1)) if hits > 0 else 0.0,
            float(beta.ppf(1 - tail, hits + 1, n - hits)) if hits < n else 1.0)


class Case:
    """A truth and the verdict on it."""

    def __init__(self, name: str, truth: dict[str, Any], verdict: dict[str, Any]) -> None:
        verdict = flat_verdict(verdict)
        self.name, self.kind, self.mesh, self.rig, self.snr = name, truth["kind"], truth["mesh"], truth["rig"], \
            truth["snr"]
        self.causes = truth["causes"]
        known = verdict.get("catalogue")
        self.true_names = [cause["name"] for cause in self.causes
                           if (cause["is_known"] if known is None else cause["name"] in known)]
        if self.causes and not self.true_names:
            self.kind = "outside"
        same = {other: cause["name"] for cause in self.causes for other in cause.get("also", ())}
        word = verdict.get("verdict")
        if word not in VERDICTS:
            raise InputError(f"case {name}: the verdict is {word!r}; known are {', '.join(VERDICTS)}")
        self.verdict: str = word
        try:
            stated = [{str(n) for n in cause["names"]} for cause in verdict.get("causes") or []]
            self.sets = [sorted({same.get(n, n) for n in names}) for names in stated]
            self.only_same = [len(names) > 1 and len(one) == 1 for names, one in zip(stated, self.sets)]
            self.probability = None if verdict.get("probability") is None else float(verdict["probability"])
            raw = verdict.get("probability_raw", self.probability)
            self.raw = None if raw is None else float(raw)
            self.intervals = dict(verdict.get("intervals") or {})
            self.gain = verdict.get("gain") or None
        except (KeyError, TypeError, ValueError, AttributeError):
            raise InputError(f"case {name}: the verdict's causes, probability, intervals or gain cannot be read") from \
                None
        if self.verdict in ("named", "consistent_with_set") and not any(self.sets):
            raise InputError(f"case {name}: {self.verdict}, but no cause has a name")

    def is_found(self) -> bool:
        """Returns whether the verdict says that something is there."""
        return self.verdict in FOUND

    def holds(self, name: str) -> bool:
        """Returns whether a cause is named, alone or in a set."""
        return self.verdict in ("named", "consistent_with_set") and any(name in names for names in self.sets)

    def is_named(self, name: str) -> bool:
        """Returns whether the verdict names this cause alone, or in a set of names that mean the same."""
        return self.verdict == "named" and [name] in self.sets or self.verdict == "consistent_with_set" and \
            any(is_same and names == [name] for is_same, names in zip(self.only_same, self.sets))

    def names_wrongly(self) -> bool:
        """Returns whether the verdict gives a single name that is not a cause."""
        return self.verdict == "named" and any(len(names) == 1 and names[0] not in self.true_names for names in self.sets)

    def is_right(self) -> bool:
        """Returns whether the verdict as a whole is right."""
        if self.kind == "null":
            return self.verdict == "adequate"
        if self.kind == "outside":
            return self.verdict == "unknown_cause"
        return any(self.holds(name) for name in self.true_names) and not self.names_wrongly()


# name: (title, bar, lower is better, cases that count, what is counted)
SHARES = {
    "false_alarm_rate": ("false alarms on nulls", 0.05, True, lambda c: c.kind == "null", Case.is_found),
    "detection_snr5": ("something found, SNR >= 5", 0.95, False, lambda c: c.kind != "null" and c.snr >= 5,
                       Case.is_found),
    "right_or_in_set_snr8": ("cause named or in the set, single, SNR >= 8", 0.95, False,
                             lambda c: c.kind == "single" and c.snr >= 8, lambda c: c.holds(c.true_names[0])),
    "single_right_snr8": ("cause named alone, single, SNR >= 8", 0.85, False,
                          lambda c: c.kind == "single" and c.snr >= 8, lambda c: c.is_named(c.true_names[0])),
    "found_snr12": ("cause named or in the set, single, SNR >= 12", 1.0, False,
                    lambda c: c.kind == "single" and c.snr >= 12, lambda c: c.holds(c.true_names[0])),
    "wrong_single_name_rate": ("wrong single name, cause in the catalogue", 0.02, True,
                               lambda c: c.kind in ("single", "double"), Case.names_wrongly),
    "wrong_single_name_outside": ("wrong single name, cause outside the catalogue", 0.05, True,
                                  lambda c: c.kind == "outside", Case.names_wrongly),
    "unknown_called_snr12": ("called unknown, cause outside, SNR >= 12", 0.80, False,
                             lambda c: c.kind == "outside" and c.snr >= 12, lambda c: c.verdict == "unknown_cause"),
    "double_one": ("at least one of two causes named or in a set, SNR >= 8", None, False,
                   lambda c: c.kind == "double" and c.snr >= 8, lambda c: any(map(c.holds, c.true_names))),
    "double_both": ("both causes named or in sets, SNR >= 8", None, False,
                    lambda c: c.kind == "double" and c.snr >= 8, lambda c: all(map(c.holds, c.true_names))),
}


def shares_of(cases: Sequence[Case]) -> dict[str, dict[str, Any]]:
    """Returns all SHARES with their bounds."""
    result = {}
    for key, (title, bar, is_low, counts, hit) in SHARES.items():
        chosen = [case for case in cases if counts(case)]
        hits, n = sum(bool(hit(case)) for case in chosen), len(chosen)
        result[key] = {"title": title, "bar": bar, "hits": hits, "n": n, "value": hits / n if n else None,
                       "wilson_95": wilson(hits, n), "clopper_pearson_95": clopper_pearson(hits, n),
                       "is_met": None if bar is None or n == 0 else bool(hits / n <= bar if is_low else hits / n >= bar)}
    return result


def calibration_error(cases: Sequence[Case], stated: Callable[[Case], float | None] = lambda case: case.probability) \
        -> tuple[float, float] | tuple[None, None]:
    """Returns the expected calibration error over bins of the stated probability, and the Brier score; None without any."""
    chosen = [case for case in cases if stated(case) is not None]
    if not chosen:
        return None, None
    p = np.array([stated(case) for case in chosen])
    right = np.array([case.is_right() for case in chosen], float)
    place = np.minimum((p * BINS).astype(int), BINS - 1)
    error = sum(abs(p[place == b].sum() - right[place == b].sum()) for b in range(BINS)) / len(p)
    return float(error), float(((p - right)**2).mean())


def gain_fraction(cases: Sequence[Case], least: float = 8.0) -> tuple[float | None, int]:
    """Returns which part of the misfit on data that the model never saw is removed by the extension. It is a ratio of sums over
    cases with a known cause and at least this signal-to-noise ratio. A perfect model has a misfit of one per residual."""
    removed = missed = n = 0
    for case in cases:
        if case.kind in ("single", "double") and case.snr >= least and case.gain:
            removed += case.gain["baseline"] - case.gain["extended"]
            missed += case.gain["baseline"] - case.gain["residuals"]
            n += 1
    return (removed / missed if missed > 0 else None), n


def interval_coverage(cases: Sequence[Case]) -> tuple[int, int]:
    """Returns (hits, n) of intervals with an end whose parameter belongs to a cause of the case."""
    hits = n = 0
    for case in cases:
        for cause in case.causes:
            for name, value in cause["parameters"].items():
                ends = case.intervals.get(name)
                if not ends or (ends.get("lower") is None and ends.get("upper") is None):
                    continue
                low, high = ends.get("lower"), ends.get("upper")
                n += 1
                hits += (low is None or low <= value) and (high is None or value <= high)
    return hits, n


def scores_of(cases: Sequence[Case]) -> dict[str, Any]:
    """Returns all scores as one dictionary."""
    error, brier = calibration_error(cases)
    fraction, n_gain = gain_fraction(cases)
    hits, n = interval_coverage(cases)
    sets = [len(names) for case in cases for names in case.sets if len(names) > 1]
    return {"cases": len(cases), "shares": shares_of(cases), "ece": error, "brier": brier,
            "gain_fraction_snr8": fraction, "gain_cases": n_gain,
            "interval_coverage": hits / n if n else None, "intervals": n, "intervals_95": clopper_pearson(hits, n),
            "mean_set_size": float(np.mean(sets)) if sets else None,
            "by_snr": by_snr(cases)}


def by_snr(cases: Sequence[Case], edges: Sequence[float] = (2, 4, 6, 8, 12, 20, 1e9)) -> list[dict[str, Any]]:
    """Returns the verdicts on cases with one known cause, by signal-to-noise ratio."""
    rows = []
    for low, high in zip(edges[:-1], edges[1:]):
        chosen = [c for c in cases if c.kind == "single" and low <= c.snr < high]
        rows.append({"from": low, "to": None if high > 1e8 else high, "n": len(chosen),
                     "found": sum(c.is_found() for c in chosen),
                     "named": sum(c.is_named(c.true_names[0]) for c in chosen),
                     "in_set": sum(c.holds(c.true_names[0]) and not c.is_named(c.true_names[0]) for c in chosen),
                     "wrong_name": sum(c.names_wrongly() for c in chosen)})
    return rows


def confusion_of(cases: Sequence[Case]) -> tuple[list[str], list[str], np.ndarray]:
    """Returns (rows, columns, counts): true cause by verdict. A case of two causes is in no row."""
    def row_of(case: Case) -> str:
        return {"null": "none", "outside": "outside: "}.get(case.kind, "") + \
            ("" if case.kind == "null" else case.causes[0]["name"].split(":")[0])

    def column_of(case: Case) -> str:
        if case.verdict == "named":
            return " + ".join(sorted({n.split(":")[0] for names in case.sets for n in names}))
        if case.verdict == "consistent_with_set":
            return "set with it" if any(map(case.holds, case.true_names)) else "set without it"
        return {"unknown_cause": "unknown", "data_insufficient": "too few data"}.get(case.verdict, case.verdict)

    chosen = [case for case in cases if case.kind != "double"]
    rows = sorted({row_of(c) for c in chosen}, key=lambda r: (r != "none", r.startswith("outside"), r))
    fixed = ["adequate", "set with it", "set without it", "unknown", "too few data"]
    names = sorted({column_of(c) for c in chosen} - set(fixed), key=lambda n: (n not in rows, n))
    columns = fixed[:1] + names + fixed[1:]
    counts = np.zeros((len(rows), len(columns)), int)
    for case in chosen:
        counts[rows.index(row_of(case)), columns.index(column_of(case))] += 1
    return rows, columns, counts
