# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes blind flights: records of make_flight that hide one effect, two or none, in a batch with sealed truths."""
from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.blind.batch import begin_batch, described, end_batch, salt_of, workers
from flusi_msm.blind.cases import CLOSE, DRAWS, STATED, Options, numbers
from flusi_msm.blind.effects import Effect
from flusi_msm.blind.flight_effects import KNOWN, OUTSIDE
from flusi_msm.blind.ledger import digest, dump, write
from flusi_msm.errors import InputError
from flusi_msm.measurement.balance import check_names, shown
from flusi_msm.measurement.case_file import build
from flusi_msm.measurement.flight import Case, check, clean, in_last_beat, stated_time, synthesise, write_flight

Menu = Sequence[Callable[[np.random.Generator, Case], Effect]]
FLOWN = ("wing", "kinematics", "fluid", "hidden", "flow")   # sections on which the flow depends
# The second rig, relative to the noise of the design; the declared spread is wrong by up to STATED.
BUSY = {"amplitude": 0.02, "timing": 0.002}


@lru_cache(maxsize=8)
def _flight(text: str) -> dict[str, np.ndarray]:
    """Computes the forces on the wing of a case; the key contains everything that they depend on."""
    return clean(build(Case, json.loads(text), ""))


def flight_of(case: Case) -> dict[str, np.ndarray]:
    """Returns the same as clean(case), but computes a flight only once."""
    sections = {key: asdict(getattr(case, key)) for key in FLOWN}
    return _flight(json.dumps({**sections, "balance": {"reference": list(case.balance.reference)}}, sort_keys=True))


def curve(case: Case) -> np.ndarray:
    """Returns the values (n, k) that the balance shows at the phases of the record, without noise."""
    exact = flight_of(case)
    seen = shown(exact, case.balance)
    return np.stack([in_last_beat(case, exact, seen[name]) for name in check_names(case.components)], 1)


def covariance(base: Case) -> np.ndarray:
    """Returns the covariance (n, n) of the errors of a component whose rms is 1. If the error of the model stays the same for some
    time, all errors are those that the file states: the times of a beat are then neighbours around the beat."""
    noise, n = base.noise, base.samples
    period = 1 / base.kinematics.frequency
    step = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) * (period / n)
    free = noise.white**2 / base.beats + noise.model**2
    if noise.model and noise.model_time:
        return (free + noise.correlated**2 / base.beats) * np.exp(-np.minimum(step, period - step) / stated_time(noise))
    found = free * np.eye(n)
    if noise.correlated:
        found += noise.correlated**2 / base.beats * np.exp(-step / noise.correlation_time)
    return found


def visibility(case: Case, base: Case, factor: float = 0.0) -> float:
    """Returns the signal-to-noise ratio of the change d of the record, where C is the covariance of its errors, including the error
    of the model. With `factor`, a simulation may be wrong by this share of all forces and of each component:
    snr^2 = d C^-1 d - d C^-1 A (A C^-1 A + 1)^-1 A C^-1 d, where the columns of A are these errors."""
    before = curve(base)
    d = (curve(case) - before) / np.sqrt(np.mean(before**2, axis=0))
    root = np.linalg.cholesky(covariance(base))
    parts = np.linalg.solve(root, d)
    errors = factor * np.linalg.solve(root, before / np.sqrt(np.mean(before**2, axis=0)))
    total = float((parts**2).sum())
    if factor > 0:
        one, shared = (errors**2).sum(0), (errors * parts).sum(0)
        gram = np.eye(1 + len(one)) + np.block([[one.sum(), one[None, :]], [one[:, None], np.diag(one)]])
        right = np.concatenate([[shared.sum()], shared])
        total -= float(right @ np.linalg.solve(gram, right))
    return float(np.sqrt(max(0.0, total)))


def make_strong(case: Case, effect: Effect, wanted: float, factor: float = 0.0, bounds: tuple[float, float] = (0.0, np.inf)) \
        -> tuple[float, float] | None:
    """Returns (strength, snr) near the wanted ratio and within bounds, measured against the case as it is so far, or None if there
    is no such strength."""
    s = effect.first
    for _ in range(6):
        s = min(s, effect.most)
        changed = effect.apply(case, s)
        try:
            check(changed)
            snr = visibility(changed, case, factor)
        except InputError:
            return None
        if 1 / CLOSE <= snr / wanted <= CLOSE and bounds[0] <= snr < bounds[1]:
            return s, snr
        if snr <= 1e-6 or s >= effect.most and snr < wanted:
            return None
        s *= float(np.clip(wanted / snr, 0.02, 50))
    return None


def individual(design: Case, seed: int, number: int, count: int) -> Case:
    """Returns the design, or, if there are several individuals, a section with another motion that is stated in the files."""
    if count == 1:
        return design
    rng, k = numbers(seed, "flight individual", number), design.kinematics
    return replace(design, kinematics=replace(k, stroke=float(k.stroke * rng.uniform(0.85, 1.2)), pitch=float(rng.uniform(35, 50)),
                                              lead=float(rng.uniform(-10, 10))))


def hide(rng: np.random.Generator, base: Case, menus: Sequence[Menu], snr: tuple[float, float], factor: float = 0.0,
         bounds: tuple[float, float] = (0.0, np.inf)) -> tuple[Case, list[tuple[Effect, float, float]]]:
    """Hides one effect of each menu, with a ratio that is log-uniform in `snr`; returns the case and [(effect, strength, ratio)]."""
    case = base
    found: list[tuple[Effect, float, float]] = []
    for _ in range(DRAWS):
        if len(found) == len(menus):
            return case, found
        menu = menus[len(found)]
        effect = menu[int(rng.integers(len(menu)))](rng, base)
        wanted = float(np.exp(rng.uniform(*np.log(snr))))
        if any(effect.name == other.name or effect.name in other.also for other, *_ in found):
            continue
        made = make_strong(case, effect, wanted, factor, bounds)
        if made is not None:
            found.append((effect, *made))
            case = effect.apply(case, made[0])
    raise InputError(f"{DRAWS} effects in a row cannot be made as visible as wanted: is the noise of the design too large?")


def with_errors(rng: np.random.Generator, case: Case, head: dict[str, Any], number: int) -> Case:
    """Returns the case with the noise of its rig."""
    noise = case.noise if head["rig"] == "quiet" else replace(case.noise, **BUSY, stated=float(rng.uniform(1 - STATED, 1 + STATED)))
    return replace(case, seed=head["errors"], noise=noise, title=f"Blind flight {number:04d}")


def draw(seed: int, number: int, design: Case, options: Options) -> tuple[Case, dict[str, Any]]:
    """Draws the hidden effects and the noise of a case; returns the case and its truth so far."""
    rng = numbers(seed, "flight", number)
    kinds = list(options.mix)
    shares = np.array([options.mix[kind] for kind in kinds], float)
    head: dict[str, Any] = {"kind": str(rng.choice(kinds, p=shares / shares.sum())), "mesh": "same", "rig": str(rng.choice(["quiet", "busy"])),
            "individual": int(rng.integers(options.individuals)), "errors": int(rng.integers(2**53))}
    base = individual(design, seed, head["individual"], options.individuals)
    menus: dict[str, list[Menu]] = {"null": [], "double": [KNOWN, KNOWN], "outside": [OUTSIDE]}
    case, found = hide(rng, base, menus.get(head["kind"], [KNOWN]), options.snr)
    case = with_errors(rng, case, head, number)
    return case, {**head, "snr": visibility(case, base) if found else 0.0,
                  "causes": [{"name": effect.name, "strength": float(s), "snr": snr, "is_known": effect.is_known, "also": list(effect.also),
                              "parameters": effect.parameters(s), "place": []} for effect, s, snr in found]}


def _make(task: tuple[Case, int, int, Options, Path]) -> tuple[str, dict[str, Any]]:
    design, seed, number, options, folder = task
    case, truth = draw(seed, number, design, options)
    record, generator = synthesise(case, flight_of(case))
    path = folder / f"{number:04d}.h5"
    path.unlink(missing_ok=True)
    write_flight(path, case, record)
    write(folder / f"{number:04d}.stated.json", dump({key: asdict(getattr(case, key)) for key in ("wing", "kinematics", "fluid")}))
    return f"{number:04d}", {"case": f"{number:04d}", "seed": int(seed), **truth, "generator": generator}


def make_flights(design: Case, folder: Path, count: int, seed: int | None, options: Options, jobs: int, tell: Callable[[str], None]) \
        -> None:
    """Makes those of the cases 1 to `count` that do not exist yet."""
    ledger, seed = begin_batch(folder, seed, {"design": digest(dump(asdict(design))), "kind": "flight", "options": described(options)})
    tasks = [(design, seed, number, options, folder) for number in range(1, count + 1) if f"{number:04d}" not in ledger.cases]
    with workers(jobs) as pool:
        for done, (name, truth) in enumerate(pool.imap_unordered(_make, tasks), 1):
            ledger.seal(name, truth, salt_of(seed, name))
            tell(f"{done} of {len(tasks)} cases")
    end_batch(folder, ledger, tell)
