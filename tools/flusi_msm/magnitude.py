# SPDX-License-Identifier: GPL-3.0-or-later
"""Doubts about numbers that are orders of magnitude off, as they are where units were mixed up: the ranges and words of the programs."""
from math import log10

POWERS = {3: "k", 6: "M", 9: "G", -3: "m", -6: "u", -9: "n"}
# Ranges in which insects lie, with a decade of room (src/programs/common/common_wing_doubts.f90).
YOUNG = (1e7, 1e11)        # cuticle of veins [Pa]
AREAL = (1e-4, 1e-1)       # membranes [kg/m^2]
DIAMETERS = (1e-6, 1e-3)   # veins [m]


def magnitude_doubt(value: float, usual: tuple, unit: str, whose: str) -> str:
    """'' if `value` lies in the range `usual`; otherwise a sentence that tells the range, and the power of a thousand with which the
    value lies nearest to its middle, if one brings it into the range."""
    least, most = usual
    if least <= value <= most:
        return ""
    text = f"{value:.4g} {unit} is too {'large' if value > most else 'small'} for {whose}, which have {least:g} to {most:g} {unit}"
    if value <= 0:
        return text
    middle = log10(least * most) / 2
    power = min(POWERS, key=lambda p: abs(log10(value) + p - middle))
    if abs(log10(value) + power - middle) > log10(most / least) / 2:
        return text
    usual_value = f"{value * 10.0**power:.4g}"
    if "/" in unit:
        return f"{text}; is it in another unit? {usual_value} would be usual"
    return f"{text}; if it is in {POWERS[power]}{unit}, write {usual_value}"
