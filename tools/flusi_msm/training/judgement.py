# SPDX-License-Identifier: GPL-3.0-or-later
"""Judges a training: what a reader must know to trust its numbers."""
from __future__ import annotations

import numpy as np

from flusi_msm.training.run import Parameter, Training, in_words


def correlated_pairs(training: Training, limit: float = 0.95) -> list[tuple[str, str, float]]:
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


def warnings_of(training: Training) -> list[str]:
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
    return bool(min(value - low, high - value) < 1e-3 * (high - low))


def error_ratio(training: Training) -> float:
    """Returns the root of the mean squared difference in units of the declared errors, or NaN."""
    out = training.outcome
    if not out.get("residuals"):
        return np.nan
    return float(np.sqrt(out["chi2"] / out["residuals"]))
