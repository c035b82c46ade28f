# SPDX-License-Identifier: GPL-3.0-or-later
"""Corrects the probability that a verdict states by the share of such verdicts that are right. The correction is an isotonic
regression with one map for each kind of verdict; it is learned from the odd cases of a study and tested on the even ones, and
can be written as a Fortran module."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flusi_msm.blind.scores import calibration_error

if TYPE_CHECKING:
    from flusi_msm.blind.scores import Case

CODES = {"adequate": 0, "named": 10, "consistent_with_set": 11, "unknown_cause": 12}  # data_insufficient states no probability
Maps = dict[str, list[tuple[float, float]]]  # verdict: (stated, corrected probability), ascending
LEAST = 20  # odd cases that a kind needs to get a map
LEAST_BLOCK = 7  # verdicts behind each point of a map


def pool(stated: Sequence[float], right: Sequence[int]) -> list[tuple[float, int, int]]:
    """Pool-adjacent-violators algorithm: returns [(mean stated probability, right verdicts, verdicts)] of blocks whose shares of
    right verdicts grow from block to block. Equal probabilities are one block."""
    blocks: list[tuple[float, int, int]] = []  # sum of stated probabilities, right verdicts, verdicts
    for p in sorted(set(stated)):
        same = [r for q, r in zip(stated, right) if q == p]
        blocks.append((p * len(same), sum(same), len(same)))
        while len(blocks) > 1 and blocks[-2][1] * blocks[-1][2] >= blocks[-1][1] * blocks[-2][2]:
            total, hits, n = blocks.pop()
            blocks[-1] = blocks[-1][0] + total, blocks[-1][1] + hits, blocks[-1][2] + n
    return [(total / n, hits, n) for total, hits, n in blocks]


def merged(blocks: Sequence[tuple[float, int, int]]) -> list[tuple[float, int, int]]:
    """Returns blocks of at least LEAST_BLOCK verdicts: as long as there is a smaller one, the smallest joins the neighbour whose
    share of right verdicts is nearest. One verdict tells nearly nothing of a share."""
    left = list(blocks)
    while len(left) > 1 and min(n for _, _, n in left) < LEAST_BLOCK:
        k = min(range(len(left)), key=lambda j: left[j][2])
        near = min((j for j in (k - 1, k + 1) if 0 <= j < len(left)),
                   key=lambda j: abs(left[j][1] / left[j][2] - left[k][1] / left[k][2]))
        (p, hits, n), (q, more, m) = left[min(k, near)], left[max(k, near)]
        left[min(k, near):max(k, near) + 1] = [((p * n + q * m) / (n + m), hits + more, n + m)]
    return left


def knots_of(stated: Sequence[float], right: Sequence[int]) -> list[tuple[float, float]]:
    """Returns [(stated probability, corrected probability)], both ascending. Half a right and half a wrong verdict are added to
    a block (Jeffreys' prior), so that a few verdicts do not give certainty."""
    knots: list[tuple[float, float]] = []
    for p, hits, n in merged(pool(stated, right)):
        value = (hits + 0.5) / (n + 1)
        knots.append((p, max(value, knots[-1][1]) if knots else value))
    return knots


def learn(cases: Sequence[Case]) -> Maps:
    """Returns {verdict: knots} from the cases with odd numbers; kinds of fewer than LEAST cases are left out."""
    maps = {}
    for word in CODES:
        chosen = [case for case in cases if case.verdict == word and case.raw is not None and int(case.name) % 2 == 1]
        if len(chosen) >= LEAST:
            maps[word] = knots_of([case.raw for case in chosen if case.raw is not None], [int(case.is_right()) for case in chosen])
    return maps


def apply(maps: Maps, case: Case) -> float | None:
    """Returns the corrected probability: straight lines between knots, as in inference_probability.f90."""
    if case.raw is None or case.verdict not in maps:
        return case.raw
    stated, corrected = zip(*maps[case.verdict])
    return float(np.interp(case.raw, stated, corrected))


def try_on_even(cases: Sequence[Case]) -> dict[str, Any]:
    """Returns the maps of the odd cases, and the calibration errors of the even ones without and with them."""
    maps = learn(cases)
    even = [case for case in cases if int(case.name) % 2 == 0 and case.raw is not None and case.verdict in CODES]
    return {"maps": maps, "odd": sum(int(case.name) % 2 for case in cases), "even": len(even),
            "ece_raw": calibration_error(even, lambda case: case.raw)[0],
            "ece_mapped": calibration_error(even, lambda case: apply(maps, case))[0]}


def table_of(tried: dict[str, Any]) -> str:
    """Describes the maps and the errors with and without them, in words."""
    if not tried["even"]:
        return "  no even cases to try a map of probabilities on"
    words = [f"{word} ({len(knots)} knots)" for word, knots in tried["maps"].items()] or [f"none (fewer than {LEAST} of each kind)"]
    return (f"  map of probabilities from {tried['odd']} odd cases: {', '.join(words)}; calibration error of {tried['even']} even "
            f"cases {tried['ece_raw']:.3f} without, {tried['ece_mapped']:.3f} with it (bar 0.05)")


def fortran_of(tried: dict[str, Any], facts: dict[str, Any], module: str) -> str:
    """Returns the source of this module of src/inference/probability. facts: {"seed": .., "program": .., "cases": ..}."""
    rows = [(CODES[word], p, value) for word, knots in tried["maps"].items() for p, value in knots]

    def array(values: Iterable[object]) -> str:
        return "[ &\n" + ", &\n".join(f"             {value}" for value in values) + "]"

    ints = array([row[0] for row in rows]) if rows else "[integer ::]"
    raw = array([f"{row[1]:.9f}_rp" for row in rows]) if rows else "[real(rp) ::]"
    right = array([f"{row[2]:.9f}_rp" for row in rows]) if rows else "[real(rp) ::]"
    origin = f"study of seed {facts['seed']}, {tried['odd']} odd of {facts['cases']} cases, program {facts['program'][:12]}" if rows \
        else "none: probabilities as the odds give them"
    error = f"\n!> Calibration error of its {tried['even']} even cases: {tried['ece_raw']:.3f} without, {tried['ece_mapped']:.3f} with " \
            "this map." if rows else " No study: every probability stays as the odds give it."
    return f"""! SPDX-License-Identifier: GPL-3.0-or-later
!> Made by bench/diagnosis/run --write-map; do not edit.{error}
module {module}
  use base_kinds, only: rp
  implicit none
  private
  public :: VERDICT, RAW, RIGHT, PROVENANCE

  integer, parameter :: KNOTS = {len(rows)}
  integer, parameter :: VERDICT(KNOTS) = {ints} !< exit code
  real(rp), parameter :: RAW(KNOTS) = {raw}   !< probability by the odds, ascending for each verdict
  real(rp), parameter :: RIGHT(KNOTS) = {right} !< share of right verdicts
  character(*), parameter :: PROVENANCE = '{origin}'
end module {module}
"""
