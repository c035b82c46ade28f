# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts the output of msm_diagnose to the verdict that blind cases are scored by (docs/results/blind-tests.md)."""
from __future__ import annotations

from collections.abc import Iterable
from typing import Any

SCHEMA = "flusi-msm diagnosis"


def flat_verdict(data: Any) -> Any:
    """Reads the verdict in a JSON file: that of msm_diagnose is converted to the flat form, any other is left as it is."""
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        return data
    verdict = data["verdict"]
    named = {"named": [{"names": [cause["effect"]]} for cause in verdict["causes"]],
             "consistent_with_set": [{"names": list(verdict["set"])}]}
    if verdict.get("is_together"):  # several causes at once and not a choice: each of them, with the others
        named["consistent_with_set"] = named["named"]
    flat = {"verdict": verdict["word"], "probability": verdict["probability"],
            "probability_raw": verdict.get("probability_raw", verdict["probability"]),
            "causes": named.get(verdict["word"], []),
            "catalogue": [effect["name"] for effect in data["effects"] if effect["status"] != "not_testable"],
            "intervals": {}, "folds": {}}
    for one in data["extended"].get("intervals_90", []):
        lower, _, upper = one["lower_best_upper"]
        flat["intervals"][one["name"]] = {"lower": lower if one["has_lower"] else None,
                                          "upper": upper if one["has_upper"] else None}
    for name in ("baseline", "extended"):
        if name in data["validation"]:
            flat["folds"][name] = data["validation"][name]
    if len(flat["folds"]) == 2:
        flat["gain"] = {name: float(sum(folds["chi2"])) for name, folds in flat["folds"].items()}
        flat["gain"]["residuals"] = float(sum(flat["folds"]["baseline"]["observations"]))
    flat["extension"] = [[cause["effect"], cause["variant"]] for cause in verdict["causes"]] \
        if data["extended"]["is_found"] else []
    return flat


def density_gain(base: dict[str, Any], other: dict[str, Any]) -> float:
    """Returns the sum, over the locations that both predict, of the gain of `other` in log predictive density."""
    one, two = (dict(zip(folds["location"], folds["log_density"])) for folds in (base, other))
    return float(sum(two[place] - one[place] for place in one if place in two))


def effect_lines(truth: dict[str, Any]) -> dict[str, dict[str, str]] | None:
    """Returns lines for the input of msm_diagnose that give its wing or instrument the true effects of a case; None if that is
    not possible."""
    wing, instrument, sections = [], [], {}
    made = truth["generator"]["case"]
    for cause in truth["causes"]:
        name, values = cause["name"], cause["parameters"]
        if not cause["is_known"] or name == "camber":
            return None
        if name == "damage":
            x, y, radius, factor = made["stiffness"]["damage"]
            sections["damage_disc"] = f"{x!r} {y!r} {radius!r}"
            wing.append(("damage", factor))
        elif name == "soft_place":
            vein, share, _ = made["hidden"]["soft_places"][0]
            sections["soft_place"] = f"{vein} {share!r}"
            wing.append(("soft", 1 / (1 + cause["strength"])))
        elif name == "membrane_bending":
            sections["D"] = repr(values["D"])
        elif name in ("E_gradient", "E_per_vein", "taper", "root_compliance", "orthotropy", "pretension",
                      "vein_torsion", "joint_hardening", "cuticle", "one_way_joint"):
            wing += values.items()
            if name == "vein_torsion":
                sections["sided_veins"] = "yes"
            if name == "one_way_joint":
                sections["sided_joints"] = "yes"
        else:
            instrument += values.items()

    def pairs(rows: Iterable[tuple[str, float]]) -> str:
        return ", ".join(f"{name} {value!r}" for name, value in rows)

    if wing:
        sections["parameters"] = pairs(wing)
    return {"Wing": sections, "Instrument": {"parameters": pairs(instrument)} if instrument else {}}
