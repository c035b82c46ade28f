# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scan of the kinematics says, in sentences computed from the numbers of `scan.collect`."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flusi_msm.paper.numbers import KINDS, PAPER
from flusi_msm.paper.scan import AXES, CHANGES, complete, has_both_signs, quantities, shipped_of
from flusi_msm.paper.statements import NAMES

if TYPE_CHECKING:
    from flusi_msm.paper.scan import Quantity


def place_of(point: dict[str, Any]) -> str:
    """'mean pitch -10°, amplitude 150°, tilt 30°'."""
    return f"mean pitch {point['pitch']:+g}°, amplitude {point['stroke']:g}°, tilt {point['tilt']:g}°"


def name_of(quantity: Quantity) -> str:
    """Returns the name of a quantity for readers."""
    kind, key = quantity
    return f"change of {NAMES[key]}" if kind == "change" else f"{NAMES[key]}, {kind} wings"


def value_text(quantity: Quantity, value: float | None) -> str:
    """Writes a value; a dash if there is none."""
    if value is None:
        return "–"
    return f"{value:+.0f} %" if quantity[0] == "change" else f"{value:.3f}" if abs(value) < 10 else f"{value:.1f}"


def size_of_scan(found: dict[str, Any]) -> str:
    """Tells how many points have both wings."""
    here, flown = len(found["scan"]), len(complete(found))
    return f"{flown} of {here} points of the scan have both wings" if flown < here else f"All {here} points of the scan have both wings"


def nearest_sentence(found: dict[str, Any]) -> str:
    """Tells which point is nearest to the paper."""
    point, shipped = found["nearest"], shipped_of(found)
    text = (f"Nearest to the paper is {place_of(point)}: lift, drag and power of both wings are {100 * point['distance']:.0f} % away "
            "from the paper's (root mean square of the six)")
    if shipped and shipped["distance"] > point["distance"]:
        text += f", those of the shipped kinematics {100 * shipped['distance']:.0f} %"
    elif shipped:
        text += "; these are the shipped kinematics"
    return text + f". There {changes_text(point)}."


def changes_text(point: dict[str, Any]) -> str:
    """Tells what bending changes at a point."""
    parts = []
    for key in CHANGES:
        here = point["change_percent"][key]
        parts.append(f"{NAMES[key]} by {here:+.0f} %" if here is not None else f"{NAMES[key]} by a number that tells nothing "
                     "(the mean drag is not positive)")
    return "bending changes " + " and ".join(parts)


def sign_sentence(found: dict[str, Any]) -> str:
    """Tells at how many points bending changes both ratios in the paper's direction."""
    points = complete(found)
    both = [point for point in points if has_both_signs(point)]
    paper = " and ".join(f"{NAMES[key]} {PAPER['change_percent'][key]:+.0f} %" for key in CHANGES)
    if both:
        best = max(both, key=lambda point: point["change_percent"]["lift_to_power"])
        return (f"{len(both)} of {len(points)} points {'has' if len(both) == 1 else 'have'} the signs of both changes of the paper "
                f"({paper}); most at {place_of(best)}, where {changes_text(best)}.")
    text = f"No point has the signs of both changes of the paper ({paper})."
    largest = max(points, key=lambda point: point["change_percent"]["lift_to_power"])
    return (text + f" Lift to power comes nearest to rising at {place_of(largest)}, where {changes_text(largest)}.")


def undefined_sentence(found: dict[str, Any]) -> str:
    """Points without lift to drag, or ''."""
    count = sum(any(point[kind]["lift_to_drag"] is None for kind in KINDS) for point in complete(found))
    return f"At {count} points the mean drag of one of the wings is not positive: they have no lift to drag." if count else ""


def sentences(found: dict[str, Any]) -> list[str]:
    """Returns what the scan says, in sentences."""
    made = [size_of_scan(found) + "."]
    if complete(found):
        made += [nearest_sentence(found), sign_sentence(found), undefined_sentence(found), range_sentence(found)]
    return [text for text in made if text]


def range_sentence(found: dict[str, Any]) -> str:
    """Which of the paper's numbers lie between the lowest and the highest of the scan."""
    rows = ranges(found)
    outside = [name_of(row["quantity"]) for row in rows if not row["inside"]]
    if not outside:
        return "Each number of the paper lies between the lowest and the highest of the scan, though not all at one point."
    if len(outside) == len(rows):
        return "No number of the paper lies between the lowest and the highest of the scan."
    return f"Outside of what the scan has: {'; '.join(outside)}. All other numbers of the paper lie between its lowest and highest."


def ranges(found: dict[str, Any]) -> list[dict[str, Any]]:
    """[{quantity, paper, shipped, nearest, lowest, highest, inside}] over the points that have both wings."""
    points, shipped, rows = complete(found), shipped_of(found), []
    for quantity, value, paper in quantities():
        there = [v for v in map(value, points) if v is not None]
        low, high = min(there, default=None), max(there, default=None)
        rows.append({"quantity": quantity, "paper": paper, "shipped": value(shipped) if shipped else None,
                     "nearest": value(found["nearest"]), "lowest": low, "highest": high,
                     "inside": low is not None and high is not None and low <= paper <= high})
    return rows


def slopes(found: dict[str, Any]) -> dict[Quantity, dict[str, float]]:
    """{quantity: {axis: change of the value per step of one angle, at the shipped values of the others}}, where there are points."""
    points = complete(found)
    made: dict[Quantity, dict[str, float]] = {}
    for quantity, value, _ in quantities():
        made[quantity] = {}
        for axis in AXES:
            line = sorted((point[axis], here) for point in points
                          if all(point[other] == found["shipped"][other] for other in AXES if other != axis)
                          and (here := value(point)) is not None)
            if len(line) > 1:
                made[quantity][axis] = (line[-1][1] - line[0][1]) / (len(line) - 1)
    return made
