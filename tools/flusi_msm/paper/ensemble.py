# SPDX-License-Identifier: GPL-3.0-or-later
"""Flexible wings whose stiffness is drawn from what Truong et al. state of their nine individuals."""
from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from flusi_msm.paper.cases import FLEXIBLE, Variant, read_text
from flusi_msm.paper.numbers import COLUMNS, PAPER, last_two, means_of
from flusi_msm.plots.individuals import spread_of
from flusi_msm.results.cycles import FlappingRun
from flusi_msm.results.files import InputError
from flusi_msm.results.ini import values_of
from flusi_msm.wing.file import read_wing

if TYPE_CHECKING:
    from flusi_msm.wing.file import Wing

SCHEMA = "flusi-msm ensemble of stiffnesses"
E_MEAN, E_DEVIATION = 12.58e9, 3.03e9  # Pa, over the paper's nine individuals
# Of the design: of 20000 sets of primes below 400, one with weak correlations between columns among 16, 27 and 54 members.
PRIMES = (13, 43, 61, 83, 137, 173, 233, 283, 337, 359, 373)
SEED = 26                              # of the sets of nine members
NINE = 9                               # individuals in the paper
SUBSETS = 2000                         # of nine members, of which the usual spread is taken
OWN = {"lift_mN": "lift", "drag_mN": "drag", "power_mW": "aerodynamic power"}


# ---- the design ------------------------------------------------------------------------------------

def uniform_design(members: int, dimensions: int) -> np.ndarray:
    """(members, dimensions) numbers between 0 and 1 that fill the cube evenly: row k is (1/2 + k sqrt(p)) mod 1, with one prime p
    per column, for any number of members. Between two of eleven columns the rank correlation is 0.27 at most among 27 members, where
    random numbers have 0.47 and Sobol's sequence 0.7."""
    primes = [*PRIMES, *itertools.islice(_primes_above(PRIMES[-1]), max(dimensions - len(PRIMES), 0))][:dimensions]
    return (0.5 + np.arange(1, members + 1)[:, None] * np.sqrt(primes)) % 1.0


def _primes_above(number: int) -> Iterator[int]:
    return (n for n in itertools.count(number + 1) if all(n % k for k in range(2, int(n**0.5) + 1)))


def young_modulus(u: float) -> float:
    """Pa; normal with the paper's mean and deviation, of which only what is positive."""
    law = NormalDist(E_MEAN, E_DEVIATION)
    none = law.cdf(0.0)
    return max(law.inv_cdf(_inside(none + u * (1 - none))), 1e-3 * E_MEAN)


def joint_ratio(u: float, factor: float) -> float:
    """Log-normal: two thirds within `factor` of 1, 95 % within its square."""
    return float(factor**NormalDist().inv_cdf(_inside(u)))


def _inside(u: float) -> float:
    return min(max(float(u), 1e-9), 1 - 1e-9)


# ---- the wing of the input ---------------------------------------------------------------------------

def scaled_wing(ini: str | Path) -> Wing:
    """The wing of an input at the size that it asks for."""
    own = values_of(read_text(ini)).get("Wing", {})
    if "file" not in own:
        raise InputError(f"{ini}: [Wing] file names no wing")
    wing = read_wing(Path(ini).resolve().parent / own["file"])
    try:
        length, chord = (float(own.get(key, 0)) for key in ("length", "mean_chord"))
    except ValueError as error:
        raise InputError(f"{ini}: [Wing] length and mean_chord must be numbers: {error}") from None
    if length > 0:
        scale = length / wing.points[:, 0].max()
        wing.points = scale * wing.points
        wing.veins = {name: (nodes, scale * np.asarray(diameters)) for name, (nodes, diameters) in wing.veins.items()}
    here = wing.areas().sum() / np.ptp(wing.points[:, 0])
    if chord > 0 and here > 0:
        wing.points = wing.points * np.array([1.0, chord / here, 1.0])
    return wing


def number(text: str, key: str) -> float:
    """Returns the number that a key of [Wing] states; Fortran's exponents with d are numbers, too."""
    try:
        return float(text.lower().replace("d", "e"))
    except ValueError:
        raise InputError(f"[Wing] {key}: '{text}' is not a number") from None


def parameters_of(own: Mapping[str, str]) -> dict[str, float]:
    """{name: value} of the list of [Wing] parameters."""
    found = {}
    for pair in filter(str.strip, own.get("parameters", "").split(",")):
        words = re.split(r"[\s=]+", pair.strip())
        if len(words) != 2:
            raise InputError(f"[Wing] parameters: '{pair.strip()}' is not a name and a value")
        if '*' in words[0]:
            raise InputError(f"[Wing] parameters: '{words[0]}' stands for several; the ensemble needs a value for each joint")
        found[words[0]] = number(words[1], f"parameters, {words[0]}")
    return found


def joints_of(ini: str | Path) -> dict[str, float]:
    """{joint: stiffness in the input [N m/rad]}: its own value, joint_stiffness, or that of the vein without the joint."""
    try:
        from flusi_msm.bending.model import Model, Stiffness
    except ImportError as error:
        raise InputError(f"--ensemble needs scipy, which 'tools/quickstart deps' installs: {error}") from None
    own = values_of(read_text(ini)).get("Wing", {})
    wing, given = scaled_wing(ini), parameters_of(own)
    E, for_all = number(str(own.get("E", E_MEAN)), "E"), number(str(own.get("joint_stiffness", -1)), "joint_stiffness")
    model = Model(wing, Stiffness(E=E, diameter_exponent=given.get("diameter_exponent", 4.0)))
    plain = {hinge.joint: float(model.hinge_stiffness(hinge)) for hinge in model.hinge_plan if hinge.joint}
    named = {name: given.get(f"joint:{name}", for_all) for name in plain}
    return {name: named[name] if named[name] > 0 else plain[name] for name in sorted(plain)}


# ---- the flights -------------------------------------------------------------------------------------

class Ensemble:
    """`drawn` is a list of {"E": Pa, "joint:NAME": N m/rad}; `cases` are the flights of the members, in the same order."""

    def __init__(self, folder: str | Path, ini: str | Path, grid: int, members: int, beats: float, joint_factor: float) -> None:
        self.name, self.grid, self.beats, self.joint_factor = f"ensemble_{grid}", grid, beats, joint_factor
        self.folder = Path(folder) / self.name
        self.joints, given = joints_of(ini), parameters_of(values_of(read_text(ini)).get("Wing", {}))
        kept = {name: value for name, value in given.items() if name.removeprefix("joint:") not in self.joints}
        self.drawn, self.cases = [], []
        for number, u in enumerate(uniform_design(members, 1 + len(self.joints)), 1):
            drawn = {"E": young_modulus(u[0])}
            drawn |= {f"joint:{name}": k * joint_ratio(x, joint_factor) for (name, k), x in zip(self.joints.items(), u[1:])}
            listed = {**kept, **{name: value for name, value in drawn.items() if name != "E"}}
            values = {"Wing": {"E": f"{drawn['E']:.6e}",
                               "parameters": ", ".join(f"{name} {value:.6e}" for name, value in listed.items())}}
            self.drawn.append(drawn)
            self.cases.append(Variant(self.folder, ini, FLEXIBLE, grid, beats, f"member_{number:02d}", values))


# ---- numbers -----------------------------------------------------------------------------------------

def ranks(values: Sequence[float] | np.ndarray) -> np.ndarray:
    """From 0; equal values share their mean rank."""
    values = np.asarray(values, float)
    return np.array([(np.sum(values < x) + np.sum(values <= x) - 1) / 2 for x in values])


def rank_correlation(x: Sequence[float] | np.ndarray, y: Sequence[float] | np.ndarray) -> float:
    """Spearman's; 0 if one of them does not vary."""
    a, b = (r - r.mean() for r in (ranks(x), ranks(y)))
    size = np.sqrt((a @ a) * (b @ b))
    return float(a @ b / size) if size > 0 else 0.0


def largest_correlation(rows: Sequence[Sequence[float]] | np.ndarray) -> float:
    """The largest |rank correlation| between two columns."""
    columns = np.array([ranks(column) for column in np.transpose(rows)])
    return float(np.max(np.abs(np.corrcoef(columns) - np.eye(len(columns))))) if len(columns) > 1 else 0.0


def chance(members: int) -> float:
    """What |rank correlation| has in one of twenty samples without any relation."""
    return 1.96 / np.sqrt(members - 1)


def whiskers(values: np.ndarray) -> tuple[float, float]:
    """The ends of the whiskers of a box plot: what is farthest within 1.5 boxes of the box."""
    low, high = np.percentile(values, [25, 75])
    inside = values[(values >= low - 1.5 * (high - low)) & (values <= high + 1.5 * (high - low))]
    return float(inside.min()), float(inside.max())


def spread(values: Sequence[float] | np.ndarray) -> dict[str, float | None]:
    """Percent of the median: from end to end of the whiskers, over all members, and what nine members usually have."""
    values = np.asarray(values, float)
    median, over_all = spread_of(values)
    low, high = whiskers(values)
    found = {"median": median, "whiskers_percent": 100 * (high - low) / abs(median) if median else None, "all_percent": over_all}
    if len(values) > NINE:
        rng = np.random.default_rng(SEED)
        found["nine_percent"] = float(np.median([spread_of(rng.choice(values, NINE, replace=False))[1] for _ in range(SUBSETS)]))
    return found


def collect(ensemble: Ensemble) -> dict[str, Any]:
    """What goes into the JSON file, of the flights that are finished."""
    members = []
    for number, (case, drawn) in enumerate(zip(ensemble.cases, ensemble.drawn), 1):
        member: dict[str, Any] = {"member": number, "drawn": drawn}
        if case.is_finished():
            run = FlappingRun(case.folder)
            member["means"] = means_of(run, last_two(run))[0]
        members.append(member)
    found = {"schema": SCHEMA, "schema_version": 1, "points_along_x": ensemble.grid, "beats": ensemble.beats,
             "E_Pa": {"mean": E_MEAN, "standard_deviation": E_DEVIATION}, "joint_factor": ensemble.joint_factor,
             "joints_of_the_input": ensemble.joints, "members": members,
             "paper_spread_percent": PAPER["spread_of_individuals_percent"],
             "versions": sorted({v for case in ensemble.cases if case.is_finished() for v in case.state().get("versions", [])}),
             "missing": [case.name for case in ensemble.cases if not case.is_finished()]}
    done = [member for member in members if "means" in member]
    if len(done) > 2:
        found["spread"] = {key: spread([member["means"][key] for member in done]) for key in OWN}
        found["rank_correlation"] = {
            key: {name: rank_correlation([member["drawn"][name] for member in done], [member["means"][key] for member in done])
                  for name in ensemble.drawn[0]} for key in COLUMNS}
        found["design_correlation"] = largest_correlation([list(member["drawn"].values()) for member in done])
    return found
