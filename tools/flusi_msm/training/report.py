# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a training as one HTML page that needs nothing else: verdicts first, then pictures, then the log."""
import base64
from html import escape

import numpy as np

from flusi_msm.training.run import error_ratio, in_words, warnings_of

WORDS = {"determined": "determined", "roughly": "roughly known", "lower": "only a lower limit",
         "upper": "only an upper limit", "open": "not determined", "failed": "interval not found",
         "unknown": "not examined"}
STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.55 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; color: #262019;
       background: #fff; max-width: 68rem; margin: 0 auto; padding: 2rem 1.5rem 4rem; }
h1 { font-size: 1.65rem; margin: 0 0 .2rem; } h2 { font-size: 1.2rem; margin: 2.6rem 0 .5rem; }
p, li { max-width: 50rem; } .quiet { color: #6b6257; }
.numbers { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1.4rem 0; padding: 0; list-style: none; }
.numbers li { flex: 1 1 10rem; border: 1px solid #e2dbcf; border-radius: .5rem; padding: .6rem .9rem; }
.numbers b { display: block; font-size: 1.3rem; } .numbers span { font-size: .85rem; color: #6b6257; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; }
th { text-align: left; font-weight: 600; border-bottom: 2px solid #cfc4ac; padding: .4rem .7rem .4rem 0; }
td { border-bottom: 1px solid #ece6da; padding: .42rem .7rem .42rem 0; vertical-align: top; }
td.number, th.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
td.name { white-space: nowrap; font-weight: 600; }
.verdict { display: inline-block; border-radius: 1rem; padding: .05rem .65rem; font-size: .82rem; white-space: nowrap; }
.determined { background: #0072B2; color: #fff; } .roughly { background: #E69F00; color: #2b1e00; }
.lower, .upper, .open, .failed { background: #e4e1dc; color: #4a443c; }
.unknown { background: #fff; border: 1px solid #8c8478; }
.warnings { border-left: 4px solid #D55E00; background: #fdf3ec; padding: .6rem 1rem; margin: 1.2rem 0; }
.warnings ul { margin: .3rem 0; padding-left: 1.1rem; }
.fine { border-left: 4px solid #009E73; background: #eef8f4; padding: .6rem 1rem; margin: 1.2rem 0; }
figure { margin: 1rem 0 1.6rem; } figure img { max-width: 100%; height: auto; }
figcaption { font-size: .92rem; color: #4a443c; max-width: 50rem; }
pre { background: #f8f5ee; padding: .8rem 1rem; overflow-x: auto; font-size: .8rem; line-height: 1.4; }
dt { font-weight: 600; margin-top: .6rem; } dd { margin: 0; max-width: 50rem; }
@media print { body { max-width: none; } figure, tr { break-inside: avoid; } }
"""


def numbers_of(training):
    """(value, what it is) of the boxes at the top."""
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


def verdict_table(training):
    rows = []
    for p in training.parameters:
        rows.append(f"<tr><td class=name>{escape(p.label)}</td><td class=number>{escape(p.shown())}</td>"
                    f"<td class=number>{escape(p.interval_text())}</td>"
                    f'<td><span class="verdict {p.verdict}">{WORDS[p.verdict]}</span></td>'
                    f"<td>{escape(p.sentence())}</td></tr>")
    return ("<div class=scroll><table id=verdicts><thead><tr><th>parameter</th><th class=number>value</th>"
            "<th class=number>90 % interval</th><th>verdict</th><th>in words</th></tr></thead><tbody>\n"
            + "\n".join(rows) + "\n</tbody></table></div>")


def load_table(training):
    if not training.loads:
        return ""
    rows = []
    for load in training.loads:
        chi = f"{np.sqrt(load.chi2 / len(load.rows)):.2f}" if np.isfinite(load.chi2) else "–"
        rows.append(f"<tr><td class=name>{escape(load.name)}</td><td class=number>{1e3 * load.force:.4g} mN</td>"
                    f"<td class=number>({1e3 * load.point[0]:.2f}, {1e3 * load.point[1]:.2f})</td>"
                    f"<td class=number>{len(load.rows)}</td><td class=number>{1e3 * load.largest:.3g} mm</td>"
                    f"<td class=number>{in_words(load.rms, 'm')}</td>"
                    f"<td class=number>{in_words(float(np.abs(load.difference).max()), 'm')}</td>"
                    f"<td class=number>{chi}</td></tr>")
    heads = ("load", "force", "applied at [mm]", "points", "largest deformation", "rms difference",
             "largest difference", "over declared error")
    return ("<div class=scroll><table id=loads><thead><tr>"
            + "".join(f"<th{' class=number' if k else ''}>{head}</th>" for k, head in enumerate(heads))
            + "</tr></thead><tbody>\n" + "\n".join(rows) + "\n</tbody></table></div>")


def warning_box(training):
    found = warnings_of(training)
    if not found:
        return "<p class=fine>No warnings.</p>"
    return ("<div class=warnings><strong>Please note</strong><ul>"
            + "".join(f"<li>{escape(text)}</li>" for text in found) + "</ul></div>")


def figure_html(picture):
    """(heading, caption, png) as HTML; the picture is part of the page."""
    heading, caption, png = picture
    data = base64.b64encode(png).decode()
    return (f"<h2>{escape(heading)}</h2>\n" if heading else "") + \
        f'<figure><img alt="{escape(heading or caption)}" src="data:image/png;base64,{data}">' \
        f"<figcaption>{escape(caption)}</figcaption></figure>"


def page(training, pictures):
    """The whole page. `pictures` are (heading, caption, png bytes)."""
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
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title><style>{STYLE}</style></head><body>
<h1>{escape(title)}</h1>
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
{log}
</body></html>
"""
