# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the report of a training as one HTML page that needs no other file: verdicts first, then pictures, then the log."""
from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from flusi_msm.page_parts import badge, document, figure_html, table_html
from flusi_msm.training.judgement import error_ratio, warnings_of
from flusi_msm.training.run import Training, in_words

WORDS = {"determined": "determined", "roughly": "roughly known", "lower": "only a lower limit",
         "upper": "only an upper limit", "open": "not determined", "failed": "interval not found",
         "unknown": "not examined"}


def numbers_of(training: Training) -> list[tuple[str, str]]:
    """Returns (value, description) of the boxes at the top."""
    out, loads = training.outcome, training.loads
    boxes = []
    if loads:
        rms = float(np.sqrt(np.mean([load.rms**2 for load in loads])))
        boxes.append((in_words(rms, "m"), f"typical difference between simulated and measured surface "
                                          f"({100 * rms / max(load.largest for load in loads):.2g} % of the largest "
                                          "deformation)"))
        boxes.append((in_words(out["h"], "m"), "h, the cost of the paper: all loads together"))
    known = sum(p.verdict in ("determined", "roughly") for p in training.parameters)
    if training.is_complete:
        boxes.append((f"{known} of {len(training.parameters)}", "parameters known from these measurements"))
    behind = int(out.get("evaluations_behind_the_search", 0))
    text = f"{training.evaluations} candidates of the search"
    if behind:
        text += f", {behind} evaluations for polish and intervals"
    boxes.append((f"{training.evaluations + behind}", text))
    ratio = error_ratio(training)
    if np.isfinite(ratio):
        boxes.append((f"{ratio:.3g}", "difference in units of the declared errors; 1 is as it should be"))
    return boxes


def verdict_table(training: Training) -> str:
    """Returns the table of all parameters as HTML."""
    rows = [(escape(p.label), escape(p.shown()), escape(p.interval_text()), badge(p.verdict, WORDS[p.verdict]),
             escape(p.sentence())) for p in training.parameters]
    return table_html(("parameter", ("value", True), ("90 % interval", True), "verdict", "in words"), rows, "verdicts")


def load_table(training: Training) -> str:
    """Returns the table of all loads as HTML."""
    rows = []
    for load in training.loads:
        chi = f"{np.sqrt(load.chi2 / len(load.rows)):.2f}" if np.isfinite(load.chi2) else "–"
        rows.append((escape(load.name), f"{1e3 * load.force:.4g} mN",
                     f"({1e3 * load.point[0]:.2f}, {1e3 * load.point[1]:.2f})", f"{len(load.rows)}",
                     f"{1e3 * load.largest:.3g} mm", in_words(load.rms, "m"),
                     in_words(float(np.abs(load.difference).max()), "m"), chi))
    heads = ("load", "force", "applied at [mm]", "points", "largest deformation", "rms difference",
             "largest difference", "over declared error")
    return table_html([(head, k > 0) for k, head in enumerate(heads)], rows, "loads") if rows else ""


def warning_box(training: Training) -> str:
    """Returns the warnings as HTML."""
    found = warnings_of(training)
    if not found:
        return "<p class=fine>No warnings.</p>"
    return ("<div class=warnings><strong>Please note</strong><ul>"
            + "".join(f"<li>{escape(text)}</li>" for text in found) + "</ul></div>")


def page(training: Training, pictures: Sequence[tuple[str, str, bytes | list[bytes]]]) -> str:
    """Returns the whole page. `pictures` are (heading, caption, png bytes)."""
    title = f"Training report: {training.name}"
    boxes = "".join(f"<li><b>{escape(value)}</b><span>{escape(text)}</span></li>"
                    for value, text in numbers_of(training))
    log = f"<details><summary>The log of the run</summary><pre>{escape(training.log)}</pre></details>" if training.log \
        else ""
    singular = ""
    if training.singular_values is not None:
        values = ", ".join(f"{value:.3g}" for value in training.singular_values)
        singular = ("<dt>Singular values</dt><dd>Of the derivatives of everything that was measured, in units of the "
                    "declared errors, with respect to the logarithms of the parameters: as many combinations of "
                    f"parameters are determined within about a factor of e as there are values well above 1. {values}</dd>\n")
    cost = "h" if training.cost == "h" else "the sum of squares in units of the declared errors"
    return document(title, f"""<h1>{escape(title)}</h1>
<p class=quiet>Wing {escape(training.wing_path)}, measured in {escape(training.measurement)}. The search made {cost}
small.</p>
<h2>What the measurements say</h2>
{verdict_table(training)}
<ul class=numbers>{boxes}</ul>
{warning_box(training)}
{"".join(figure_html(picture) for picture in pictures)}
{"<h2>The loads in numbers</h2>" if training.loads else ""}
{load_table(training)}
<h2>How to read this</h2>
<dl>
<dt>90 % interval</dt><dd>If the wing model and the declared errors are right, nine of ten such intervals contain the
true value. It was found by holding the parameter at other values and fitting all others again (profile likelihood), so
that what one parameter can do in the place of another is counted.</dd>
<dt>only a lower (upper) limit</dt><dd>The loads do not bend this part enough to tell its stiffness: all values beyond
the limit, up to the end of the range that was searched, fit equally well. Do not use such a parameter as a number;
a load that acts closer to this part would help.</dd>
<dt>h</dt><dd>The square root of the sum over loads of the mean squared difference between simulated and measured
deformation. It grows with the number of loads; the rms difference of each load does not.</dd>
<dt>χ²</dt><dd>The sum of the squared differences in units of the declared errors. It should be near the number of
measured points.</dd>
{singular}</dl>
{log}""")
