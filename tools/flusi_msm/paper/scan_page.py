# SPDX-License-Identifier: GPL-3.0-or-later
"""The scan of the kinematics as one HTML page that needs nothing else, and its numbers as JSON."""
from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flusi_msm.page_parts import STYLE, Head, figure_html, table_html
from flusi_msm.paper.cases import FLEXIBLE, RIGID
from flusi_msm.paper.numbers import COLUMNS
from flusi_msm.paper.scan import AXES, CHANGES, collect, complete
from flusi_msm.paper.scan_pictures import LABELS, all_maps
from flusi_msm.paper.scan_words import name_of, place_of, ranges, sentences, slopes, value_text
from flusi_msm.paper.study_files import write_study

if TYPE_CHECKING:
    from flusi_msm.paper.scan import Scan
    from flusi_msm.paper.study_files import Picture

TITLE = "Blowfly wings over the angles that the paper does not print"
MEANING = """<ul>
<li>Mean pitch is added to the feathering angle alpha over the whole beat. A positive one tilts the leading edge into the
downstroke: the chord then makes a smaller angle with the stroke plane in the downstroke and a larger one in the upstroke.</li>
<li>Amplitude is that of phi from peak to peak. The paper states 135°.</li>
<li>Tilt is the angle of the stroke plane to the horizontal, downstroke forward and down, into the wind.</li>
<li>Nothing is tuned: the shipped kinematics stay what they are.</li></ul>"""


def range_table(found: dict[str, Any]) -> str:
    """Returns the paper's numbers and the range of the scan as HTML."""
    heads: list[Head] = ["", *((head, True) for head in ("paper", "shipped", "nearest point", "lowest", "highest")), "within the scan"]
    rows = [[escape(name_of(row["quantity"])), *(value_text(row["quantity"], row[key])
                                                 for key in ("paper", "shipped", "nearest", "lowest", "highest")),
             "yes" if row["inside"] else "no"] for row in ranges(found)]
    return table_html(heads, rows, "ranges")


def slope_table(found: dict[str, Any]) -> str:
    """What one step of each angle does, at the shipped values of the others."""
    steps = {axis: values[1] - values[0] for axis, values in found["values"].items() if len(values) > 1}
    if not steps:
        return ""
    names = {"pitch": "mean pitch", "stroke": "amplitude", "tilt": "tilt"}
    heads: list[Head] = ["", *((f"{names[axis]} {step:+g}°", True) for axis, step in steps.items())]
    rows = []
    for quantity, by_axis in slopes(found).items():
        unit = " [%]" if quantity[0] == "change" else ""
        form = "{:+.1f}" if quantity[0] == "change" else "{:+.3f}"
        rows.append([escape(name_of(quantity)) + unit, *(form.format(by_axis[axis]) if axis in by_axis else "–" for axis in steps)])
    return ("<h2>What one step of each angle does</h2><p>About the shipped kinematics, from end to end of the scan, over the number "
            "of steps.</p>" + table_html(heads, rows, "slopes"))


def point_table(found: dict[str, Any]) -> str:
    """Returns all points as HTML, the nearest to the paper first."""
    heads: list[Head] = ["mean pitch, amplitude, tilt [°]", *((f"{LABELS[key]}, {kind}", True) for kind in (RIGID, FLEXIBLE) for key in COLUMNS),
             *((f"change of {LABELS[key].split(' [')[0]} [%]", True) for key in CHANGES), ("away from the paper [%]", True)]
    rows = []
    for point in sorted(complete(found), key=lambda point: point["distance"]):
        cells = [value_text((kind, key), point[kind][key]) for kind in (RIGID, FLEXIBLE) for key in COLUMNS]
        cells += [value_text(("change", key), point["change_percent"][key]).removesuffix(" %") for key in CHANGES]
        rows.append([", ".join(f"{point[axis]:g}" for axis in AXES), *cells, f"{100 * point['distance']:.0f}"])
    return f"<div class=scroll>{table_html(heads, rows, 'scan')}</div>"


def page(found: dict[str, Any], pictures: Sequence[Picture]) -> str:
    """Returns the whole page."""
    notes = [f"Not finished yet: {len(found['missing'])} flights."] if found["missing"] else []
    if len(found["versions"]) > 1:
        notes.append(f"Flights were made by several versions of the program: {', '.join(found['versions'])}.")
    warnings = "".join(f"<li>{escape(note)}</li>" for note in notes)
    warnings = f"<div class=warnings><ul>{warnings}</ul></div>" if notes else ""
    said = "".join(f"<li>{escape(text)}</li>" for text in sentences(found))
    figures = "\n".join(figure_html((heading, caption, path.read_bytes())) for heading, caption, path in pictures)
    n = found["points_along_x"]
    tables = ("<h2>The paper's numbers and the scan</h2>" + range_table(found) + slope_table(found)
              + "<h2>All points, the nearest to the paper first</h2>" + point_table(found)) if complete(found) else ""
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{TITLE}</title><style>{STYLE}</style></head><body>
<h1>{TITLE}</h1>
<p class=quiet>Rigid and flexible wings without thickness on {n} x {n} x {n // 2} points, {found['beats']} beats, the last one
averaged, by tools/reproduce_paper --kinematics. {escape(', '.join(found['versions']))}. Shipped: {escape(place_of(found['shipped']))}.</p>
{warnings}
<ul id=sentences>{said}</ul>
{figures}
{tables}
<h2>What the angles mean</h2>
{MEANING}
</body></html>
"""


def write_page(folder: Path, scan: Scan) -> Path:
    """Writes NAME.json and NAME.html of the flights that are finished, and pictures into the folder of the scan."""
    found = collect(scan)
    found["sentences"] = sentences(found)
    return write_study(folder, scan, found, all_maps, page)
