# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes parameters of a diagnosis as text: with units and errors, and without a value if the data do not determine one."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flusi_msm.training.run import Interval, Parameter, in_words

SIGMA_90 = 1.6448536269514722  # of a normal distribution, two-sided 90 %
WORDS = {"determined": "determined", "roughly": "roughly known", "lower": "only a lower limit", "upper": "only an upper limit",
         "open": "not determined", "unknown": "no interval"}
NAMES = {"E": "E of all veins", "E_gradient": "E toward the tip, logarithm", "D": "bending stiffness D of the membrane",
         "added_mass": "air that moves with the wing, over strip theory", "point_mass": "mass at one place",
         "force_gain": "gain of the forces", "force_offset": "added force", "height_scale": "scale of the heights",
         "root_flap": "root: flapping per moment", "root_twist": "root: twisting per moment", "soft": "stiffness at one place, factor",
         "damage": "stiffness of the region, factor", "torsion": "stiffness of veins against twist over bend",
         "diameter_exponent": "exponent of the diameter", "vein_mass": "mass of the veins, factor",
         "membrane_mass": "mass of the membrane, factor", "membrane_gradient": "mass of the membrane toward the tip, logarithm",
         "one_way": "stiffness upward over downward,", "hardening": "hardening of joint"}


def label_of(name: str) -> str:
    """Returns the name of a parameter for readers."""
    kind, _, rest = name.partition(":")
    known = {"joint": "joint", "E": "E of vein", "zero": "zero of"}
    if rest:
        return f"{known.get(kind, NAMES.get(kind, kind))} {rest}"
    return NAMES.get(name, name.replace("_", " "))


def grams(unit: str, value: float) -> tuple[str, float]:
    """Converts masses to grams, whose prefixes readers know."""
    return ("g", 1e3 * value) if unit == "kg" else (unit, value)


def in_text(name: str, value: float) -> str:
    """Writes a name and a number."""
    return f"{label_of(name)} {value:.3g}"


@dataclass
class Value:
    """A parameter with its interval, if one was computed."""
    label: str
    parameter: Parameter

    @classmethod
    def of(cls, facts: dict[str, Any], interval: dict[str, Any] | None = None) -> Value:
        """Returns the value of facts of the JSON file, with their interval."""
        unit, value = grams(facts["unit"], facts["value"])
        made = Parameter(facts["name"], unit, 1.0 if facts.get("is_log") else -np.inf, np.inf, value)
        if interval is not None:
            lower, best, upper = (np.nan if end is None else grams(facts["unit"], end)[1] for end in interval["lower_best_upper"])
            made.interval = Interval(lower, best, upper, interval["has_lower"], interval["has_upper"])
        return cls(label_of(facts["name"]), made)

    @property
    def kind(self) -> str:
        """Returns the class of the badge."""
        return self.parameter.verdict

    def word(self) -> str:
        """Returns the word of the badge."""
        return WORDS[self.kind]

    def shown(self) -> str:
        """Writes the value for a table."""
        return self.parameter.shown()

    def interval(self) -> str:
        """Writes both ends of the interval, or none."""
        return self.parameter.interval_text()


def said_of(facts: dict[str, Any]) -> str:
    """Writes a fitted parameter: '8.01 GPa ± 2 %', 'about 30 µN m/rad (within a factor of 1.6)', or 'not determined'. It is not
    determined if its sd is above 1/√2 of that of its prior, or if the data leave it a range of a factor of ten."""
    sd, prior = facts.get("sd"), facts.get("prior_sd", 0)
    if sd is None or (prior > 0 and sd > prior / np.sqrt(2)):
        return "not determined"
    unit, value = grams(facts["unit"], facts["value"])
    error = SIGMA_90 * sd
    if facts.get("is_log") and error > np.log(10) / 2:
        return "not determined"
    if not facts.get("is_log"):
        error = grams(facts["unit"], error)[1]
        return f"{in_words(value, unit, error)} ± {in_words(error, unit)}"
    if error <= np.log(1.25):
        return f"{in_words(value, unit, value * error)} ± {100 * error:.2g} %"
    return f"about {in_words(value, unit, value * error)} (within a factor of {np.exp(error):.2g})"
