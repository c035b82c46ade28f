# SPDX-License-Identifier: GPL-3.0-or-later
"""Doubts about numbers with a wrong order of magnitude, as they arise from mixed-up units; ranges and words are those of the
programs."""
from math import log10

POWERS = {3: "k", 6: "M", 9: "G", -3: "m", -6: "u", -9: "n"}
# Ranges of the values of insects, extended by a factor of ten (src/programs/common/common_wing_doubts.f90).
YOUNG = (1e7, 1e11)        # cuticle of veins [Pa]
AREAL = (1e-4, 1e-1)       # membranes [kg/m^2]
DIAMETERS = (1e-6, 1e-3)   # veins [m]


def magnitude_doubt(value: float, usual: tuple, unit: str, whose: str) -> str:
    """Returns '' if `value` lies in the range `usual`; otherwise a sentence with the range and, if a power of a thousand brings
    the value into the range, the one that brings it nearest to the middle."""
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
        return f"{text}; is the value in another unit? {usual_value} would be usual"
    return f"{text}; if the value is in {POWERS[power]}{unit}, write {usual_value}"
