# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the comparison with Truong et al. as one HTML page that needs no other file, and its numbers as JSON."""
from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flusi_msm.page_parts import STYLE, figure_html
from flusi_msm.paper.cases import FLEXIBLE
from flusi_msm.paper.flights import in_hours
from flusi_msm.paper.numbers import COLUMNS, KINDS, PAPER, SHAPES, TABLE_2, collect
from flusi_msm.paper.pictures import all_pictures
from flusi_msm.paper.statements import WORDS, pairs_of, signed, statements_of, verdict_of
from flusi_msm.results.files import InputError

if TYPE_CHECKING:
    from flusi_msm.paper.cases import Case
    from flusi_msm.paper.study_files import Picture

HEADS = ("lift [mN]", "drag [mN]", "power [mW]", "lift / drag", "lift / power [mN/mW]")
OWN_STYLE = """
.agrees { background: #009E73; color: #fff; } .differs { background: #D55E00; color: #fff; }
tr.paper td { background: #f8f5ee; } #verdict { font-size: 1.1rem; }
"""
LIMITS = """<ul>
<li>The paper prints no stroke plane, angles of attack or timing of the rotations: those here are assumptions, listed in
<code>ini/kinematics/calliphora.ini</code> and <code>ini/wing.ini</code>. Drag and lift to drag depend on them most.</li>
<li>The paper's wing 8 has joints fitted to it, whose stiffness is not printed. Here joints are as stiff as the veins, and E is the
mean over the paper's nine individuals.</li>
<li>The paper's wings are sheets of four cells, 0.0156 R, whose force it takes from the penalization; here wings have no
thickness, and the force is that of their markers on the flow.</li>
<li>Nothing was fitted to bring numbers nearer to the paper's.</li></ul>"""


def table(name: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Returns a table. Rows are lists of text; a row that begins with 'paper' is shaded."""
    head = "".join(f"<th{' class=number' if k else ''}>{escape(text)}</th>" for k, text in enumerate(heads))
    body = "\n".join(f"<tr{' class=paper' if row[0].startswith('paper') else ''}>"
                     + "".join(f"<td class={'number' if k else 'name'}>{escape(text)}</td>" for k, text in enumerate(row))
                     + "</tr>" for row in rows)
    return f"<div class=scroll><table id={name}><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table></div>"


def number(value: float, half: float | None = None) -> str:
    """Writes a number, with half its range in brackets."""
    text = f"{value:.3f}" if abs(value) < 10 else f"{value:.2f}"
    return text + (f" ({half:.3f})" if half is not None else "")


def table_2(grids: Sequence[dict[str, Any]]) -> str:
    """Returns Table 2 of the paper and ours as HTML."""
    rows = []
    for kind in KINDS:
        rows.append([f"paper, {kind}", *(number(TABLE_2[kind][key]) for key in COLUMNS)])
        for grid in grids:
            if kind in grid:
                row = grid[kind]
                rows.append([f"{grid['points']} points, {kind}",
                             *(number(row[key], row["half_range"].get(key)) for key in COLUMNS)])
    rows.append(["paper, change", *(signed(PAPER["change_percent"][key]) for key in COLUMNS)])
    rows += [[f"{grid['points']} points, change", *(signed(grid["change_percent"][key]) for key in COLUMNS)]
             for grid in grids if "change_percent" in grid]
    return table("table2", ("", *HEADS), rows)


def statement_table(statements: Sequence[dict[str, Any]]) -> str:
    """Returns what agrees and what does not as HTML."""
    rows = "\n".join(f'<tr><td><span class="verdict {WORDS[s["agrees"]]}">{WORDS[s["agrees"]]}</span></td>'
                     f'<td class=name>{escape(s["topic"])}</td><td>{escape(s["sentence"])}</td></tr>' for s in statements)
    return f"<div class=scroll><table id=statements><tbody>\n{rows}\n</tbody></table></div>"


def shape_table(grids: Sequence[dict[str, Any]]) -> str:
    """Returns the deformation on all grids as HTML; '' without any."""
    there = [grid for grid in grids if "deformation" in grid]
    if not there:
        return ""
    rows = [[name.replace("_", " ") + (" %" if name != "tip" else ""),
             *(f"{shape['lowest']:+.3f} to {shape['highest']:+.3f}; {shape['middle_of_downstroke']:+.3f}"
               for shape in (grid["deformation"][name] for grid in there))] for name in SHAPES]
    return ("<p>Lowest to highest over the beat; in the middle of the downstroke. Tip and trailing edge in R, twist in rad, camber "
            "in chords, at parts of the span, positive toward the dorsal side.</p>"
            + table("shapes", ("", *(f"{grid['points']} points" for grid in there)), rows))


def case_table(grids: Sequence[dict[str, Any]]) -> str:
    """Returns facts about the flights as HTML."""
    rows = []
    for grid in grids:
        for kind in (k for k in KINDS if k in grid):
            row = grid[kind]
            rows.append([f"{grid['points']} points, {kind}", str(row.get("steps_in_last_beat", "–")),
                         f"{in_hours(row['seconds'])} on {row['ranks']}" if row.get("seconds") else "–",
                         *(f"{row[key]:g}" if key in row else "–" for key in ("slip_percent", "power_balance"))])
    return table("cases", ("", "steps in the last beat", "time, ranks", "slip, % of the tip speed",
                           "power lost by the wings / received by the flow"), rows)


def individual_table(individuals: dict[str, Any]) -> str:
    """Returns the individuals and their spread as HTML."""
    means, spreads = individuals["means"], individuals["spread_percent"]
    rows = [[label, *(f"{values[label]:.4g}" for values in means.values())] for label in individuals["flights"]]
    rows.append(["spread", *(f"{spreads[name]:.1f} %" if name in spreads else "" for name in means)])
    paper = PAPER["spread_of_individuals_percent"]
    rows.append(["paper, spread", *(f"{paper[name]} %" if name in paper else "" for name in means)])
    return "<p>Normalised by rho R^4 f^2 and rho R^5 f^3.</p>" + table("individuals", ("individual", *means), rows)


def page(found: dict[str, Any], pictures: Sequence[Picture], missing: Sequence[str]) -> str:
    """Returns the whole page."""
    grids, statements = found["grids"], statements_of(found)
    versions = sorted({v for grid in grids for kind in KINDS if kind in grid for v in grid[kind]["versions"]})
    beats = sorted({str(grid[kind]["beats"]) for grid in grids for kind in KINDS if kind in grid})
    notes = [f"Not finished yet: {', '.join(missing)}."] if missing else []
    if pairs_of(found) and not pairs_of(found)[-1]["pressure"]:
        notes.append("The files of the wings' surfaces have no pressure and traction on both sides, so that these cannot be "
                     "drawn.")
    if len(versions) > 1:
        notes.append(f"Flights were made by several versions of the program: {', '.join(versions)}.")
    warnings = "".join(f"<li>{escape(note)}</li>" for note in notes)
    warnings = f"<div class=warnings><ul>{warnings}</ul></div>" if notes else ""
    figures = "\n".join(figure_html((heading, caption, path.read_bytes())) for heading, caption, path in pictures)
    individuals = individual_table(found["individuals"]) if "individuals" in found else ""
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Rigid and flexible blowfly wings beside the paper</title><style>{STYLE}{OWN_STYLE}</style></head><body>
<h1>Rigid and flexible blowfly wings beside the paper</h1>
<p class=quiet>Truong et al., "An experimental data-driven mass-spring model of flexible Calliphora wings", repeated with wings
without thickness by tools/reproduce_paper. {escape(', '.join(versions))}; beats averaged: {escape(' '.join(beats))}.</p>
<p id=verdict>{escape(verdict_of(found))}</p>
{warnings}
<h2>Table 2 of the paper and ours</h2>
<p>Both wings together. In brackets half the range over the beats averaged. Change: flexible against rigid.</p>
{table_2(grids)}
<h2>What agrees and what does not</h2>
<p class=quiet>From the numbers of the finest grid with both kinds of wings. A value agrees if it is within 10 % of the paper's, a
change if it has the paper's sign.</p>
{statement_table(statements)}
{figures}
<h2>Shapes of the {FLEXIBLE} wings</h2>
{shape_table(grids)}
{'<h2>Individuals in numbers</h2>' if individuals else ''}{individuals}
<h2>The flights</h2>
{case_table(grids)}
<h2>What has no right to agree</h2>
{LIMITS}
</body></html>
"""


def write_page(folder: Path, pairs: Sequence[Case], individuals: Mapping[str, Case]) -> Path:
    """Writes paper.json and paper.html from the flights that are finished; returns the path of the page."""
    found = collect(pairs, individuals)
    found["statements"], found["verdict"] = statements_of(found), verdict_of(found)
    missing = [case.name for case in {c.name: c for c in [*pairs, *individuals.values()]}.values() if not case.is_finished()]
    found["missing"] = missing
    try:
        (folder / "paper.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        pictures = all_pictures(found, pairs, individuals, folder / "pictures")
        (folder / "paper.html").write_text(page(found, pictures, missing), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from None
    return folder / "paper.html"
