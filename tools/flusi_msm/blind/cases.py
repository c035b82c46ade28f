# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws blind cases, makes their effects as strong as wanted, and computes what the experiment then shows."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any
from zlib import crc32

import numpy as np

from flusi_msm.bending.statics import NoEquilibrium
from flusi_msm.blind.effects import KNOWN, OUTSIDE, DrawEffect, Effect
from flusi_msm.blind.oracle import Base, Oracle
from flusi_msm.measurement.case import Case
from flusi_msm.measurement.grid import grid_lines
from flusi_msm.measurement.noise import Noise
from flusi_msm.measurement.synthesis import Bench, Shape, declare, observe
from flusi_msm.results.files import InputError

MESHES = {"same": 0, "finer": 1}  # refine
# Errors of the two rigs in addition to those of the design; sd, or fractions. Those of the second rig are declared with errors up
# to STATED.
QUIET: dict[str, float] = {}
BUSY: dict[str, Any] = {"height": 8e-6, "correlated": 6e-6, "tilt": 5e-4, "piston": 5e-6, "force_gain": 0.01, "position": 3e-5,
        "missing": 0.1}
NONLINEAR = 5e-6    # [m] rms change by the best-fitting stiffness, from which second derivatives matter (0.04 um)
STEPS, LONGEST = 3, 0.5  # to the best-fitting stiffness; of a logarithm
BUSY_FORCE = 0.005  # of the smallest stated force
NO_FRINGE = (0.0, 1e-3, 0.0)
BUSY_FRINGE = (2e-6, 2.2e-3, 0.6)  # of the busy rig; they are not declared
STATED = 0.2        # the declared sd are wrong by up to this
KINDS = {"null": 0.25, "single": 0.45, "double": 0.15, "outside": 0.15}
CLOSE = 1.25        # of the wanted to the reached signal-to-noise ratio
DRAWS = 40          # of effects, before a case is given up


@dataclass
class Options:
    """The options from which a batch is drawn."""
    mix: dict[str, float]  # kind: share
    snr: tuple[float, float] = (2.0, 30.0)
    individuals: int = 8
    meshes: tuple[str, ...] = ("same", "finer")


def numbers(seed: int, *words: object) -> np.random.Generator:
    """Returns an independent random stream for every purpose."""
    return np.random.default_rng([int(seed)] + [crc32(str(word).encode()) for word in words])


class Individual:
    """One wing: its stiffness, and on each mesh its shapes without hidden effects."""

    def __init__(self, design: Case, seed: int, number: int, meshes: Sequence[str] = tuple(MESHES)) -> None:
        self.design, self.meshes = design, meshes
        for attempt in range(20):
            rng = numbers(seed, "individual", number, attempt)
            try:
                self._draw(rng)
                return
            except NoEquilibrium:
                continue
        raise InputError("20 wings in a row snap under the loads of the design: make the forces smaller")

    def _draw(self, rng: np.random.Generator) -> None:
        design = self.design
        plain = Bench(replace(design, stiffness=replace(design.stiffness, joints={}))).model()
        s = design.stiffness
        softer = rng.uniform(-0.7, 0.2, len(plain.hinge_plan))
        joints = {h.joint: float(plain.hinge_stiffness(h) * 10**softer[k])
                  for k, h in enumerate(plain.hinge_plan) if h.joint}
        self.stiffness = replace(s, E=float(s.E * 10**rng.uniform(-0.1, 0.1)), joints={**joints, **s.joints})
        self.bases, self.clean, self.plain = {}, {}, {}
        for mesh in self.meshes:
            bench = Bench(self.case(mesh, Noise(height=0.0)))
            low, high = bench.wing.points.min(0), bench.wing.points.max(0)
            x, y = (grid_lines(low[k], high[k], design.spacing) for k in range(2))
            self.bases[mesh] = Base(bench, x, y)
            self.clean[mesh] = self.deformations(mesh, bench.case)
            self.plain[mesh] = self.latest
        self.oracles: dict[tuple[str, str], Oracle] = {}

    def menu(self, kind: str) -> Sequence[DrawEffect]:
        """Returns the effects that a case of this kind can have."""
        return OUTSIDE if kind == "outside" else KNOWN

    def finish(self, content: dict[str, Any], case: Any, mesh: str) -> None:
        """Adds further measurements to the content of a bending test; here there are none."""

    def case(self, mesh: str, noise: Noise, fringe: tuple[float, float, float] = NO_FRINGE) -> Any:
        """Returns the case of this wing without hidden effects."""
        return replace(self.design, refine=MESHES[mesh], noise=noise, stiffness=self.stiffness,
                       hidden=replace(self.design.hidden, fringe=fringe))

    def bend(self, mesh: str, case: Any) -> tuple[Bench, list[Shape]]:
        """Returns the shapes of a case that is near the base; raises NoEquilibrium if the wing snaps."""
        bench, shapes = Bench(case), []
        for load in bench.loads():
            shape = bench.bend(load, self.bases[mesh].shapes[load.name])
            if shape[2].snaps:
                raise NoEquilibrium(f"load {load.name}: the wing snaps")
            shapes.append(shape)
        return bench, shapes

    def deformations(self, mesh: str, case: Any) -> np.ndarray:
        """Returns the deformations (loads, ny, nx) [m] without any random error; `latest` keeps the shapes, `latest_case` the
        case."""
        quiet = replace(case, noise=Noise(height=0.0), declared={"height": 1e-6},
                        hidden=replace(case.hidden, fringe=NO_FRINGE))
        bench, shapes = self.bend(mesh, quiet)
        self.latest, self.latest_case = shapes, case
        content, _ = observe(bench, bench.loads(), shapes, bench.rest())
        return np.stack([load["z"] - content["z"] for load in content["loads"]])

    def visibility(self, mesh: str, rig: str, case: Any, seen: np.ndarray, least: float = 0.0) -> float:
        """Returns the signal-to-noise ratio of the part of an effect's deformations that a usual model cannot explain. The
        derivatives are those at the wing without the effect. Where second derivatives matter, shapes with the best-fitting
        stiffness are computed, which is found in a few steps; this is left out if the ratio is already below `least`."""
        oracle = self.oracle(mesh, rig, case)
        whole = oracle.change(seen)
        model, latest = self.bases[mesh].model, self.latest
        joints = {h.joint: model.hinge_stiffness(h) for h in model.hinge_plan if h.joint}
        s, at, rest = self.stiffness, np.zeros(oracle.n_stiff), whole
        ratio = oracle.snr(whole)
        for _ in range(STEPS if ratio >= least else 0):
            step = np.clip(oracle.explain(rest) - at, -LONGEST, LONGEST)
            if np.sqrt(((oracle.stiff @ step)**2).mean()) < NONLINEAR:
                break
            at = at + step
            near = replace(s, E=s.E * float(np.exp(at[0])), D=s.D * float(np.exp(at[-1])),
                           joints={name: k * float(np.exp(a)) for (name, k), a in zip(joints.items(), at[1:])})
            try:
                usual = self.deformations(mesh, replace(case, stiffness=near))
            except InputError:  # the wing snaps: the result so far is used
                break
            rest = whole - oracle.change(usual) + oracle.stiff @ at
            ratio = min(ratio, oracle.snr(rest))
        self.latest = latest
        return ratio

    def oracle(self, mesh: str, rig: str, case: Any) -> Oracle:
        """Returns what computes how visible effects are, on a mesh with a rig."""
        if (mesh, rig) not in self.oracles:
            other = next((m for m in self.clean if m != mesh), mesh)  # only one mesh: no error of discretisation
            true = declare(replace(case, declared={}))
            self.oracles[mesh, rig] = Oracle(self.bases[mesh], case.noise, true, self.clean[mesh], self.clean[other],
                                             case.hidden.fringe)
        return self.oracles[mesh, rig]


def rig_noise(design: Case, rig: str) -> Noise:
    """Returns the errors of a rig."""
    if rig == "quiet":
        return design.noise
    least = min(float(np.linalg.norm(vector)) for _, vector in design.loads) * min(map(abs, design.protocol.levels))
    return replace(design.noise, **BUSY, force=BUSY_FORCE * least)


def stated(rng: np.random.Generator, case: Any) -> dict[str, float]:
    """Returns the errors that the experimenter declares: every sd is up to 20 % wrong."""
    true = declare(replace(case, declared={}))
    return {key: value * float(rng.uniform(1 - STATED, 1 + STATED)) for key, value in true.items()
            if value > 0 and key != "correlation_length"}


def next_strength(tried: list[tuple[float, float]], s: float, snr: float, wanted: float, factors: tuple[float, float]) -> float:
    """Returns the strength that should have the wanted signal-to-noise ratio, after strength s had `snr`: it lies on the
    straight line of their logarithms through the last two of `tried`, within the least and the largest of `factors` of s. (s,
    snr) is added to `tried`."""
    slope = 1.0
    if tried and abs(np.log(s / tried[-1][0])) > 0.01:
        slope = float(np.clip(np.log(snr / tried[-1][1]) / np.log(s / tried[-1][0]), 0.3, 3))
    tried.append((s, snr))
    return s * float(np.clip((wanted / snr)**(1 / slope), *factors))


def make_strong(individual: Individual, mesh: str, rig: str, case: Any, effect: Effect, wanted: float,
                bounds: tuple[float, float] = (0.0, np.inf)) -> tuple[float, float] | None:
    """Returns (strength, snr) near the wanted snr and within bounds, or None if there is no such strength; the individual's
    `latest` are then its shapes. The first estimate is made on the mesh of the wing file."""
    tried: list[tuple[float, float]] = []
    s, on = effect.first, "same"
    for _ in range(5):
        s = min(s, effect.most)
        try:
            here = replace(case, refine=MESHES[on])
            snr = individual.visibility(on, rig, here, individual.deformations(on, effect.apply(here, s)), wanted / CLOSE)
        except InputError:  # it snaps, or the effect is not possible on this mesh
            if not tried or s <= 1.05 * tried[-1][0]:
                return None
            s = (s * tried[-1][0])**0.5
            continue
        if snr <= 1e-3:
            return None
        if on == mesh and 1 / CLOSE <= snr / wanted <= CLOSE and bounds[0] <= snr < bounds[1]:
            return s, snr
        if s >= effect.most and snr < wanted:
            return None
        s = next_strength(tried, s, snr, wanted, (1e-3, 1e3))
        on = mesh
    return None


def draw_effects(rng: np.random.Generator, individual: Individual, mesh: str, rig: str, case: Any, kind: str, options: Options,
                 bounds: tuple[float, float] = (0.0, np.inf)) -> list[tuple[Effect, float, float]]:
    """Returns the effects of a case of this kind, [(effect, strength, snr)]. Each strength is chosen by the effect's own
    signal-to-noise ratio, which lies within bounds."""
    wing = Bench(case).coarse
    found: list[tuple[Effect, float, float]] = []
    for _ in range(DRAWS):
        if len(found) == (2 if kind == "double" else 1):
            return found
        menu = individual.menu(kind)
        effect = menu[int(rng.integers(len(menu)))](rng, wing, case)
        wanted = float(np.exp(rng.uniform(*np.log(options.snr))))
        if any(effect.name == other.name for other, _, _ in found):
            continue
        made = make_strong(individual, mesh, rig, case, effect, wanted, bounds)
        if made is not None:
            found.append((effect, *made))
    raise InputError(f"{DRAWS} effects in a row cannot be made as visible as wanted: are the errors of the design too "
                     "large?")


def draw_head(seed: int, number: int, options: Options) -> tuple[np.random.Generator, dict[str, Any]]:
    """Returns the random stream of a case, and what is drawn from it first: kind, mesh, rig, individual, seed of its errors."""
    rng = numbers(seed, "case", number)
    kinds = list(options.mix)
    shares = np.array([options.mix[kind] for kind in kinds], float)
    return rng, {"kind": str(rng.choice(kinds, p=shares / shares.sum())), "mesh": str(rng.choice(options.meshes)),
                 "rig": str(rng.choice(["quiet", "busy"])), "individual": int(rng.integers(options.individuals)),
                 "errors": int(rng.integers(2**53))}


def make_case(seed: int, number: int, individual: Individual, options: Options) -> tuple[dict[str, Any], dict[str, Any]]:
    """Makes case `number` of an individual: returns the content for `write_test`, and the truth. A case is drawn again if its
    wing snaps under the errors of its loads."""
    rng, head = draw_head(seed, number, options)
    for attempt in range(1, DRAWS + 1):
        try:
            return fill_case(rng, seed, number, head, individual, options)
        except NoEquilibrium:
            rng = numbers(seed, "case", number, attempt)
            head["errors"] = int(rng.integers(2**53))
    raise InputError(f"{DRAWS} wings in a row snap: are the forces of the design too large?")


def fill_case(rng: np.random.Generator, seed: int, number: int, head: dict[str, Any], individual: Individual, options: Options,
              bounds: tuple[float, float] = (0.0, np.inf)) -> tuple[dict[str, Any], dict[str, Any]]:
    """Makes the rest of a case whose kind, mesh, rig, individual and seed are drawn."""
    kind, mesh, rig = head["kind"], head["mesh"], head["rig"]
    case = individual.case(mesh, rig_noise(individual.design, rig), BUSY_FRINGE if rig == "busy" else NO_FRINGE)
    case = replace(case, seed=head["errors"], title=f"Blind bending test {number:04d}")
    effects = [] if kind == "null" else draw_effects(rng, individual, mesh, rig, case, kind, options, bounds)
    oracle, usual = individual.oracle(mesh, rig, case), case
    for effect, strength, _ in effects:
        case = effect.apply(case, strength)
    joint = individual.visibility(mesh, rig, usual, individual.deformations(mesh, case)) if len(effects) > 1 else \
        sum(e[2] for e in effects)
    case = replace(case, declared=stated(rng, case) if rig == "busy" else {})
    if case.noise.force or case.noise.force_gain or case.noise.position:
        bench, shapes = individual.bend(mesh, case)
    else:  # forces and places are those of the known shapes
        bench, shapes = Bench(case), individual.latest if effects else individual.plain[mesh]
    content, truth = observe(bench, bench.loads(), shapes, bench.rest())
    individual.finish(content, case, mesh)
    return content, {
        "case": f"{number:04d}", "seed": int(seed), **head, "snr": joint, "band_snr": oracle.band_snr(),
        "causes": [{"name": effect.name, "strength": float(strength), "snr": snr, "is_known": effect.is_known,
                    "also": list(effect.also), "parameters": effect.parameters(strength), "place": list(effect.place)}
                   for effect, strength, snr in effects], "generator": truth}
