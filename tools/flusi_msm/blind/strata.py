# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines the cases of a study: fixed numbers of cases of each kind and visibility. They are mixed so that the first cases have
about the same proportions as all of them."""
from __future__ import annotations

from dataclasses import dataclass

WHOLE = (2.0, 30.0)  # signal-to-noise ratios


@dataclass(frozen=True)
class Stratum:
    """Cases of one kind and one range of visibility."""
    name: str
    count: int      # in the whole study
    kind: str
    snr: tuple[float, float] = WHOLE
    wing: str = "small"


BENDING = (Stratum("null", 250, "null"), Stratum("outside", 200, "outside"),
           *(Stratum(f"single {low} to {high}", 60, "single", (float(low), float(high)))
             for low, high in ((2, 5), (5, 8), (8, 12), (12, 20), (20, 30))),
           Stratum("large null", 4, "null", wing="large"), Stratum("large single", 4, "single", wing="large"),
           Stratum("large outside", 4, "outside", wing="large"))
VIBRATION = (Stratum("null", 100, "null"), Stratum("outside", 50, "outside", (3.0, 30.0)),
             *(Stratum(f"single {low} to {high}", count, "single", (float(low), float(high)))
               for low, high, count in ((3, 5, 25), (5, 8, 30), (8, 12, 35), (12, 20, 35), (20, 30, 25))))
JOINT = (Stratum("null", 50, "null"), Stratum("outside", 25, "outside", (3.0, 30.0)),
         *(Stratum(f"single {low} to {high}", count, "single", (float(low), float(high)))
           for low, high, count in ((3, 8, 25), (8, 12, 20), (12, 20, 15), (20, 30, 15))),
         Stratum("double", 24, "double", (8.0, 30.0)))
FLIGHT = (Stratum("null", 20, "null"), Stratum("outside", 10, "outside", (3.0, 30.0)),
          *(Stratum(f"single {low} to {high}", count, "single", (float(low), float(high)))
            for low, high, count in ((3, 8, 9), (8, 12, 8), (12, 20, 8), (20, 30, 5))))
STRATA = {"bending": BENDING, "vibration": VIBRATION, "joint": JOINT, "flight": FLIGHT}


def whole_study(kind: str = "bending") -> int:
    """Returns the number of cases in the whole study of this kind."""
    return sum(stratum.count for stratum in STRATA[kind])


def plan(count: int, kind: str = "bending") -> list[tuple[Stratum, int]]:
    """Returns [(stratum, how many of it came before)] of the cases 1 to count: the next case is always of the stratum that is
    most behind."""
    strata, whole = STRATA[kind], whole_study(kind)
    before, rows = [0] * len(strata), []
    for number in range(1, count + 1):
        behind = [number * stratum.count / whole - n for stratum, n in zip(strata, before)]
        k = behind.index(max(behind))
        rows.append((strata[k], before[k]))
        before[k] += 1
    return rows
