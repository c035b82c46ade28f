# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes in plain words, from the numbers of `numbers.collect`, what agrees with Truong et al. and what does not."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flusi_msm.paper.cases import FLEXIBLE, RIGID
from flusi_msm.paper.numbers import COLUMNS, MID_DOWN, MID_UP, PAPER, PEAK_LIFT, SUCTION, TABLE_2, TIP_DEFLECTION
from flusi_msm.results.cycles import QUANTITIES

NAMES = dict(zip(COLUMNS, ("lift", "drag", "power", "lift to drag", "lift to power")))
NEAR = 10.0       # %, by which a value may differ to agree with the paper
CONVERGED = 5.0   # %, between the two finest grids
REVERSAL = 0.12   # of a beat, about 0 and 0.5
WORDS = {True: "agrees", False: "differs", None: "open"}


def statement(topic: str, paper: str, here: str, agrees: object, sentence: str) -> dict[str, Any]:
    """Returns a statement as it is stored; `agrees` is None if it is open."""
    return {"topic": topic, "paper": paper, "here": here, "agrees": None if agrees is None else bool(agrees),
            "sentence": sentence}


def pairs_of(found: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns the grids on which both kinds of wings have flown."""
    return [grid for grid in found["grids"] if "change_percent" in grid]


def signed(value: float) -> str:
    """Writes a change with its sign."""
    return f"{value:+.0f} %"


def sign_statements(pairs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """States whether bending changes every quantity in the same direction as in the paper."""
    made = []
    for key, name in NAMES.items():
        here, paper = pairs[-1]["change_percent"][key], PAPER["change_percent"][key]
        agrees = here * paper > 0
        verb = "raises" if here > 0 else "lowers"
        if agrees:
            text = f"Bending {verb} {name} by {abs(here):.0f} %, in the paper by {abs(paper):.0f} %: the sign is the paper's"
        else:
            text = f"Bending {verb} {name} by {abs(here):.0f} %, in the paper it {'raises' if paper > 0 else 'lowers'} it " \
                   f"by {abs(paper):.0f} %: the sign is not the paper's"
        if key == "lift_to_drag" and min(pairs[-1][kind]["drag_mN"] for kind in (RIGID, FLEXIBLE)) <= 0:
            made.append(statement(f"change of {name} by bending", signed(paper), "no drag", None,
                                  "The mean drag of one of the wings is not positive: lift to drag tells nothing."))
            continue
        before = [grid["change_percent"][key] for grid in pairs[:-1]]
        if before:
            same = before[-1] * here > 0
            text += (", and the same" if same else ", and another one") + f" on the next coarser grid ({signed(before[-1])})"
        made.append(statement(f"change of {name} by bending", signed(paper), signed(here), agrees, text + "."))
    return made


def value_statements(pairs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """States how near all values are to the paper's."""
    made = []
    for kind in (RIGID, FLEXIBLE):
        for key, name in NAMES.items():
            here, paper = pairs[-1][kind][key], TABLE_2[kind][key]
            away = 100 * (here / paper - 1)
            made.append(statement(f"{name}, {kind} wings", f"{paper:.3g}", f"{here:.3g}", abs(away) <= NEAR,
                                  f"{name.capitalize()} of the {kind} wings is {here:.3g}, {abs(away):.0f} % "
                                  f"{'above' if away > 0 else 'below'} the paper's {paper:.3g}."))
    return made


def convergence_statement(pairs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """States by how much the two finest grids differ."""
    if len(pairs) < 2:
        return statement("grid", "1024 points", f"{pairs[-1]['points']} points", None,
                         "One grid alone tells nothing about convergence.")
    coarse, fine = pairs[-2:]
    moved = {f"{name} of the {kind} wings": 100 * abs(fine[kind][key] / coarse[kind][key] - 1)
             for kind in (RIGID, FLEXIBLE) for key, name in NAMES.items()}
    worst = max(moved, key=moved.__getitem__)
    agrees = moved[worst] <= CONVERGED
    return statement("grid", "1024 points", f"{coarse['points']} and {fine['points']} points", agrees,
                     f"From {coarse['points']} to {fine['points']} points the largest change is {moved[worst]:.1f} %, in {worst}: "
                     f"{'' if agrees else 'not '}converged to {CONVERGED:.0f} %.")


def force_statements(pairs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """States how the forces over the beat compare."""
    made = []
    finest = pairs[-1]
    rigid, flexible = (finest[kind]["peak_lift_mN"] for kind in (RIGID, FLEXIBLE))
    paper = 100 * (PEAK_LIFT[FLEXIBLE] / PEAK_LIFT[RIGID] - 1)
    here = 100 * (flexible / rigid - 1)
    made.append(statement("peak of the lift", f"{PEAK_LIFT[RIGID]} and {PEAK_LIFT[FLEXIBLE]} mN",
                          f"{rigid:.3g} and {flexible:.3g} mN", here * paper > 0,
                          f"The largest lift of a beat is {rigid:.3g} mN of rigid and {flexible:.3g} mN of flexible wings "
                          f"({signed(here)}); the paper has {PEAK_LIFT[RIGID]} and {PEAK_LIFT[FLEXIBLE]} mN ({signed(paper)})."))
    parts = [finest[kind]["lift_in_downstroke"] for kind in (RIGID, FLEXIBLE)]
    if all(part is not None for part in parts):
        text = " and ".join(f"{100 * part:.0f} %" for part in parts)
        made.append(statement("lift in the downstroke", "most", text, min(parts) > 0.5,
                              f"The downstroke gives {text} of the lift of rigid and of flexible wings; in the paper most of "
                              "it. Above 100 % the upstroke pulls down."))
    return made


def near_reversal(phase: float) -> bool:
    """Returns whether a phase is near a reversal of the stroke."""
    return min(abs(phase - place) for place in (0.0, 0.5, 1.0)) <= REVERSAL


def shape_statements(grid: dict[str, Any]) -> list[dict[str, Any]]:
    """States how the deformation compares."""
    shape = grid["deformation"]
    tip, twist, trailing = shape["tip"], shape["twist_75"], shape["trailing_edge_50"]
    low, high = TIP_DEFLECTION
    here = tip["middle_of_downstroke"]
    made = [statement(
        "tip in the middle of the downstroke", f"{low:.2f} R (text), 10° = {high:.2f} R (caption)", f"{here:+.3f} R",
        (1 - NEAR / 100) * low <= here <= (1 + NEAR / 100) * high,
        f"In the middle of the downstroke the tip is bent by {abs(here):.3f} R toward the {'dorsal' if here > 0 else 'ventral'} "
        f"side; over the beat it goes from {tip['lowest']:+.3f} to {tip['highest']:+.3f} R. The paper's largest "
        f"deflection, {low:.2f} R in its text and 10 degrees, {high:.2f} R, in a caption, is at this moment.")]
    made.append(statement(
        "when the tip is bent most", f"phase {MID_DOWN}", f"phase {tip['phase_of_largest']:.2f}",
        abs(tip["phase_of_largest"] - MID_DOWN) <= REVERSAL,
        f"The tip is bent most, by {tip['largest']:+.3f} R, at the phase {tip['phase_of_largest']:.2f}; in the paper in the "
        f"middle of the downstroke, {MID_DOWN}."))
    ratio = abs(tip["middle_of_upstroke"]) / max(abs(here), 1e-12)
    made.append(statement(
        "tip in the middle of the upstroke", "almost as the rigid wing", f"{tip['middle_of_upstroke']:+.3f} R", ratio < 0.5,
        f"In the middle of the upstroke the tip is at {tip['middle_of_upstroke']:+.3f} R, {ratio:.1f} times as far from the "
        "rigid wing as in the middle of the downstroke; in the paper both wings almost coincide then."))
    made.append(statement(
        "twist", "chordwise deformation at the reversals", f"largest {twist['largest']:+.2f} rad at {twist['phase_of_largest']:.2f}",
        near_reversal(twist["phase_of_largest"]),
        f"The twist at 75 % of the span goes from {twist['lowest']:+.2f} to {twist['highest']:+.2f} rad and is largest at the "
        f"phase {twist['phase_of_largest']:.2f}; reversals are at 0 and 0.5, where the paper sees the chords deform most."))
    edge = trailing["middle_of_downstroke"]
    made.append(statement(
        "trailing edge in the middle of the downstroke", "pushed upward", f"{edge:+.3f} R", edge > 0,
        f"At half span the trailing edge is {abs(edge):.3f} R {'above' if edge > 0 else 'below'} where it is on the rigid wing; "
        "the paper's is pushed upward."))
    return made


def pressure_statements(pressure: dict[str, Any]) -> list[dict[str, Any]]:
    """States how the pressure compares; nothing without pressure."""
    if not pressure:
        return []
    down, up = (pressure[str(phase)] for phase in (MID_DOWN, MID_UP))
    return [statement("suction on the dorsal side", f"p <= {SUCTION:.0f} on a large part",
                      f"on {100 * down['part_in_suction']:.0f} % of the wing", down["part_in_suction"] >= 0.25,
                      f"In the middle of the downstroke p <= {SUCTION:.0f} on {100 * down['part_in_suction']:.0f} % of the dorsal "
                      f"side, the lowest is {down['lowest_dorsal']:.1f} (in rho R^2 f^2)."),
            statement("difference of the pressures", "high in the downstroke, weak in the upstroke",
                      f"{down['mean_difference']:.2f} and {up['mean_difference']:.2f}",
                      abs(up["mean_difference"]) < abs(down["mean_difference"]),
                      f"Ventral minus dorsal pressure, mean over the wing: {down['mean_difference']:.2f} in the middle of the "
                      f"downstroke, {up['mean_difference']:.2f} in that of the upstroke.")]


def individual_statements(individuals: dict[str, Any]) -> list[dict[str, Any]]:
    """States how the spread over individuals compares."""
    made, paper = [], PAPER["spread_of_individuals_percent"]
    here = individuals["spread_percent"]
    largest = max(QUANTITIES[:3], key=here.get)
    made.append(statement(
        "spread over individuals", ", ".join(f"{paper[q]:.0f} %" for q in paper), ", ".join(f"{here[q]:.0f} %" for q in here),
        largest == "drag",
        f"(Largest - smallest)/median over the individuals is {here['lift']:.1f} % in lift, {here['drag']:.1f} % in drag, "
        f"{here['aerodynamic power']:.1f} % in power, in the paper {paper['lift']}, {paper['drag']} and "
        f"{paper['aerodynamic power']} %. Here individuals differ in size alone: the paper does not print the stiffness of "
        "each."))
    return made


def statements_of(found: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns all statements, for the finest grid on which both kinds of wings have flown; none if there is no such grid."""
    pairs, made = pairs_of(found), []
    if pairs:
        made = sign_statements(pairs) + [convergence_statement(pairs)] + force_statements(pairs)
        made += shape_statements(pairs[-1]) + pressure_statements(pairs[-1]["pressure"]) + value_statements(pairs)
    if "individuals" in found:
        made += individual_statements(found["individuals"])
    return made


def verdict_of(found: dict[str, Any]) -> str:
    """Answers in two sentences whether bending helps, as the paper says."""
    pairs = pairs_of(found)
    if not pairs:
        return "No grid has both rigid and flexible wings yet."
    here, paper = pairs[-1]["change_percent"], PAPER["change_percent"]
    parts = [f"{NAMES[key]} {signed(here[key])} (paper {signed(paper[key])})" for key in ("lift_to_drag", "lift_to_power")]
    good = [here[key] * paper[key] > 0 for key in ("lift_to_drag", "lift_to_power")]
    end = {2: "Both signs are the paper's", 1: "One sign is the paper's, the other is not", 0: "Neither sign is the paper's"}
    return (f"On {pairs[-1]['points']} x {pairs[-1]['points']} x {pairs[-1]['points'] // 2} points flexible wings change "
            f"{' and '.join(parts)} against rigid ones. {end[sum(good)]}.")
