# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows what a diagnosed cause changes in flight, with what the fit leaves of it, as a table of the report."""
from __future__ import annotations

import math
from html import escape
from typing import Any

from flusi_msm.page_parts import table_html

MILLI = {"N": "mN", "W": "mW", "N/m": "mN/m", "W/m": "mW/m"}
MOST_DIGITS = 9


def decimals(width: float) -> int:
    """Returns how many digits behind the decimal point show an interval of this width with two digits or three."""
    return max(0, min(MOST_DIGITS, 1 - math.floor(math.log10(width)))) if width > 0 else MOST_DIGITS


def row_of(one: dict[str, Any]) -> tuple[str, ...]:
    """Returns the cells of one mean: name, baseline, extended, interval, change."""
    unit, factor = one["unit"], 1.0
    if unit in MILLI:
        unit, factor = MILLI[unit], 1e3
    name = escape(one["name"] + (f" [{unit}]" if unit != "1" else ""))
    if not one["is_determined"]:
        return name, "–", "–", "not determined: its denominator may be 0", "–"
    ends = [factor * end for end in one["interval_90"]]
    n = decimals(ends[1] - ends[0])
    change = "–"
    if "change" in one:
        low, high = (100 * end for end in one["change_interval_90"])
        m = decimals(high - low)
        change = f"{100 * one['change']:+.{m}f} % ({low:+.{m}f} to {high:+.{m}f})"
    return name, f"{factor * one['baseline']:.{n}f}", f"{factor * one['extended']:.{n}f}", f"{ends[0]:.{n}f} to {ends[1]:.{n}f}", change


def compared_html(diagnosis: dict[str, Any]) -> str:
    """Lists mean lift, drag and power of both flights with intervals; '' if they were not compared."""
    found = diagnosis.get("flights")
    if found is None:
        return ""
    if not found["is_known"]:
        return f"<h2>Both flights</h2><p>They are not compared: {escape(found['reason'])}.</p>"
    if found["wings_were_flown"]:
        which, heads = "The same flight with the wing of the baseline and with the extended wing", ("baseline", "extended wing")
        if found["directions"]:
            have = "directions have" if found["directions"] > 1 else "direction has"
            which += f", of whose errors {found['directions']} {have} {100 * found['variance_share']:.0f} % of the variance"
    else:
        which, heads = "The flight of the case as it is, and with what was found of kinematics and flow", ("the case", "with what was found")
    return ("<h2>Both flights</h2><p>" + which + ": means over the beat. The 90 % intervals are what the fit leaves of the second flight. "
            "The first one is a reference without an error, and errors of the simulation are not among them.</p>"
            + table_html(("mean", (heads[0], True), (heads[1], True), ("90 % interval", True), ("change", True)),
                         [row_of(one) for one in found["means"]], "flights"))
