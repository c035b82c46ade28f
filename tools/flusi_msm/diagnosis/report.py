# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a diagnosis as one HTML page that needs nothing else: verdict and gain first, then pictures, candidates,
questions to the residuals, and what to measure next."""
import base64
import math
from html import escape

from flusi_msm.training.report import STYLE

CLASSES = {"adequate": "determined", "named": "determined", "consistent_with_set": "roughly",
           "unknown_cause": "failed", "data_insufficient": "unknown"}
WORDS = {"adequate": "The model is adequate", "named": "The cause has a name",
         "consistent_with_set": "Several causes are possible", "unknown_cause": "A cause that is not in the catalogue",
         "data_insufficient": "Not enough data"}
SMALL = 0.05  # posterior probability: 3 units of log evidence, the bound of an alias


def probability(p):
    """A p-value for people."""
    if p is None:
        return "–"
    if p >= 1e-3:
        return f"{p:.3f}"
    return "below 10⁻³⁰⁰" if p <= 0 else f"10<sup>{math.floor(math.log10(p))}</sup>"


def boxes_of(diagnosis):
    """(value, what it is) of the boxes at the top."""
    verdict, validation = diagnosis["verdict"], diagnosis["validation"]
    boxes = [(probability(verdict["global_p"]), "probability that chance alone makes differences like these (all tests "
                                                "together)")]
    if verdict["word"] != "adequate":
        boxes.append((share(verdict["probability"]), "probability of what the verdict says"))
        boxes.append((f"{verdict['snr']:.1f}", "signal-to-noise ratio of the cause"))
    if validation["has_gain"]:
        boxes.append((f"{validation['gain_per_location']:.2f} ± {validation['standard_error']:.2f}",
                      "gain of log probability for a location that the fit has not seen"))
        base, extended = validation["baseline"], validation["extended"]
        n = sum(extended["observations"])
        boxes.append((f"{math.sqrt(sum(base['chi2']) / n):.2f} → {math.sqrt(sum(extended['chi2']) / n):.2f}",
                      "difference at such locations in units of its errors, before and after"))
    return boxes


GRADES = {"A": "one answer, which an unknown cause of the same strength would not have got",
          "B": "the data agree with this, and other causes are not excluded"}


def grade_html(verdict):
    grade = verdict.get("grade", "")
    return f"<p>Grade {grade}: {GRADES[grade]}.</p>" if grade in GRADES else ""


def unknown_html(verdict):
    """Where an unknown cause is, and what comes nearest to it; '' for other verdicts."""
    text, region = "", verdict.get("region")
    if region:
        what = {"stiffness": "a stiffness that differs", "force": "further forces",
                "scans": "bent scans", "veins": "veins of another stiffness"}[region["of"]]
        parts = [f"around ({1e3 * p['centre_m'][0]:.1f}, {1e3 * p['centre_m'][1]:.1f}) mm, radius {1e3 * p['radius_m']:.1f} mm "
                 f"({share(p['share'])})" for p in region["parts"]]
        text = f"<p>As {what}, it would be " + ("at one place, with these probabilities: " if region["form"] == "one_place"
                                                else "a field over the wing, with these shares: ") + "; ".join(parts) + ".</p>"
        if region["of"] == "scans":
            text = "<p>It is not on the wing: scans are bent, each in another way, as if the rig bent or the wing kept " \
                   "something of the scan before.</p>"
        elif not parts:
            text = f"<p>As {what}, it would be a field over the wing in which no place stands out.</p>"
    if verdict.get("related"):
        text += "<p>Related, but not sufficient: " + "; ".join(
            f"{escape(one['name'])} ({share(one['explained'])} of the misfit)" for one in verdict["related"]) + ".</p>"
    return text


def extension(diagnosis):
    """What was added to the model, with intervals if there are any: what leaves most of the misfit has none."""
    extended = diagnosis["extended"]
    before = {one["name"] for one in diagnosis["baseline"]["parameters"]}
    intervals = {one["name"]: one for one in extended.get("intervals_90", [])}
    rows = []
    for parameter in extended.get("parameters", []):
        name, value = parameter["name"], parameter["value"]
        if name in before:
            continue
        interval = "not sought"
        if "intervals_90" not in extended and diagnosis["verdict"]["word"] == "unknown_cause":
            interval = "none, as this explains too little"
        if name in intervals:
            one = intervals[name]
            lower, value, upper = one["lower_best_upper"]
            interval = (f"{lower:.4g} to {upper:.4g}" if one["has_lower"] and one["has_upper"] else
                        f"more than {lower:.4g} (95 %)" if one["has_lower"] else
                        f"less than {upper:.4g} (95 %)" if one["has_upper"] else "the data set no end")
            jumps = [end for end in ("lower", "upper") if one.get(f"{end}_is_jump")]
            if jumps:
                interval += f"; the shape of the wing jumps at the {' and the '.join(jumps)} end"
        rows.append(f"<tr><td class=name>{escape(name)}</td><td class=number>{value:.4g}</td>"
                    f"<td class=number>{interval}</td></tr>")
    if not rows:
        return ""
    return ("<h2>What was added to the model</h2><table><thead><tr><th>parameter</th><th class=number>value</th>"
            "<th class=number>90 % interval</th></tr></thead><tbody>" + "".join(rows) + "</tbody></table>")


def alternatives(diagnosis):
    """What the data cannot tell apart; '' if the verdict is no set."""
    verdict = diagnosis["verdict"]
    if verdict["word"] != "consistent_with_set" or verdict["is_together"]:
        return ""
    known = {e["name"]: e for e in diagnosis["effects"]}
    rows = [f"<tr><td class=name>{escape(known[name]['title'])}</td><td class=number>{share(known[name]['posterior'])}</td>"
            f"<td>{escape(known[name]['sentence'])}</td></tr>" for name in verdict["set"]]
    note = ""
    if verdict["set_because"] == "alias" and min(known[name]["posterior"] for name in verdict["set"]) < SMALL:
        note = ("<p>What is improbable here stays a candidate: if the other parameters may have any value, it does nearly what "
                "the first cause does. Only what was known of them beforehand, or chance, speaks against it.</p>")
    return ("<h2>What these data cannot tell apart</h2><table><thead><tr><th>cause</th><th class=number>alone, with "
            "probability</th><th>in words</th></tr></thead><tbody>" + "".join(rows) + "</tbody></table>" + note)


def shifts(diagnosis):
    """What the usual parameters become if the model has the cause; '' if it was not extended."""
    if not diagnosis["extended"]["is_found"]:
        return ""
    before = {p["name"]: p for p in diagnosis["baseline"]["parameters"]}
    rows = [f"<tr><td class=name>{escape(p['name'])}</td><td class=number>{before[p['name']]['value']:.4g}</td>"
            f"<td class=number>{p['value']:.4g}</td><td>{escape(p['unit'])}</td></tr>"
            for p in diagnosis["extended"]["parameters"] if p["name"] in before]
    return ("<h2>What becomes of the other parameters</h2><table><thead><tr><th>parameter</th><th class=number>without the "
            "cause</th><th class=number>with it</th><th>unit</th></tr></thead><tbody>" + "".join(rows) + "</tbody></table>")


def smallest(effect):
    """From which strength on the data would show an effect."""
    found = [f"{name} {value:.3g}" for name, value in zip(effect["parameters"], effect["detectable"])
             if value is not None and 0 < value < 1e30]
    return escape("; ".join(found)) or "–"


def candidates(effects):
    """All entries of the catalogue, the most probable first."""
    order = {"tested": 0, "absorbed": 1, "not_testable": 2}
    rows = []
    for e in sorted(effects, key=lambda e: (order[e["status"]], -(e.get("log_evidence") or 0))):
        if e["status"] == "tested":
            cells = (f"<td class=number>{probability(e['local_p'])}</td><td class=number>{probability(e['p'])}</td>"
                     f"<td class=number>{share(e['posterior'])}</td><td class=number>{e['retained']:.2f}</td>"
                     f"<td>{smallest(e)}</td>")
            where = f" ({escape(e['variant'])})" if e["variant"] else ""
        else:
            word = "absorbed by the baseline" if e["status"] == "absorbed" else f"not testable: {e['missing']}"
            cells, where = f"<td colspan=5>{escape(word)}</td>", ""
        rows.append(f"<tr><td class=name>{escape(e['title'])}{where}</td>{cells}<td>{escape(e['sentence'])}</td></tr>")
    return ("<h2>All candidates</h2><div class=scroll><table><thead><tr><th>cause</th><th class=number>local p</th>"
            "<th class=number>p with its positions</th><th class=number>alone, with probability</th>"
            "<th class=number>seen beside baseline</th><th>found with 90 % from</th><th>in words</th></tr></thead><tbody>"
            + "\n".join(rows) + "</tbody></table></div>")


def questions(diagnosis):
    rows = [f"<tr><td class=name>{escape(q['name'])}</td><td class=number>{probability(q['p'])}</td>"
            f"<td>{escape(q['sentence'])}</td></tr>" for q in diagnosis["questions"]]
    return ("<h2>Plain questions to what the baseline leaves</h2><table><tbody>" + "".join(rows) + "</tbody></table>"
            if rows else "")


def next_measurement(diagnosis):
    if not diagnosis["next_measurements"]:
        return ""
    rows = [f"<tr><td class=name>{escape(n['repeat'])}</td><td class=number>{n['separation_sd']:.2f} sd</td></tr>"
            for n in diagnosis["next_measurements"][:5]]
    return ("<h2>What to measure next</h2>" + rivals(diagnosis) + "<p>By how much the first cause differs from the nearest "
            "of all others with one of these loads once more:</p><table><tbody>" + "".join(rows) + "</tbody></table>"
            + new_loads(diagnosis.get("new_loads", [])))


def rivals(diagnosis):
    titles = {e["name"]: e["title"] for e in diagnosis["effects"]}
    near = [f"{escape(titles[r['effect']])}{' (' + escape(r['variant']) + ')' if r['variant'] else ''} by "
            f"{r['separation_now_sd']:.2f} sd" for r in diagnosis.get("rivals", [])[:4]]
    return ("<p>What others can imitate of the first cause is taken from it; it then differs from " + ", from ".join(near)
            + ". Below 2 sd they cannot be told apart, above 3 they can.</p>" if near else "")


def new_loads(loads):
    rows = [f"<tr><td class=number>{1e3 * n['place_m'][0]:.2f}</td><td class=number>{1e3 * n['place_m'][1]:.2f}</td>"
            f"<td class=number>{1e3 * n['force_n'] * (1 if n['direction'][2] >= 0 else -1):.4g}</td>"
            f"<td class=number>{n['separation_sd']:.2f} sd</td></tr>" for n in loads[:5]]
    return ("<p>With one load at a new place:</p><table><thead><tr><th>x [mm]</th><th>y [mm]</th><th>force, up [mN]</th>"
            "<th>it differs by</th></tr></thead><tbody>" + "".join(rows) + "</tbody></table>" if rows else "")


def figure_html(picture):
    heading, caption, data = picture
    code = base64.b64encode(data).decode()
    return (f"<h2>{escape(heading)}</h2><figure><img alt=\"{escape(heading)}\" src=\"data:image/png;base64,{code}\">"
            f"<figcaption>{escape(caption)}</figcaption></figure>")


def share(p):
    """A probability in per cent; never quite 100."""
    return f"{100 * p:.0f} %" if p < 0.995 else "over 99 %"


def flight_html(flight):
    """What the cause changes in flight; '' without flights."""
    if flight is None:
        return ""
    text, picture = flight
    return f"<h2>What it changes in flight</h2>{text}" + figure_html(
        ("", "Lift, drag and aerodynamic power over the last beat.", picture)).replace("<h2></h2>", "")


def page(diagnosis, pictures, flight=None):
    """The whole page."""
    verdict = diagnosis["verdict"]
    boxes = "".join(f"<li><b>{value}</b><span>{escape(what)}</span></li>" for value, what in boxes_of(diagnosis))
    sentences = [e["sentence"] for c in verdict["causes"] for e in diagnosis["effects"]
                 if e["name"] == c["effect"] and verdict["word"] in ("named", "consistent_with_set")]
    warning = diagnosis["noise"]["warning"]
    tails = diagnosis["noise"].get("heavy_tails")  # files of earlier versions have none
    if tails and tails["is_found"]:
        least, most = tails["share_90"]
        warning = ". ".join(filter(None, (warning, f"{tails['heights_left_out']} of {tails['heights_tested']} heights stand out "
                                          f"from those around them ({100 * least:.2g} to {100 * most:.2g} % do) and were left "
                                          f"out. {tails['sentence'].rstrip('.')}")))
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Diagnosis</title><style>{STYLE}</style></head><body>
<h1>{escape(WORDS[verdict["word"]])} <span class="verdict {CLASSES[verdict["word"]]}">{escape(verdict["word"])}</span></h1>
<p><b>{escape(verdict["sentence"])}.</b> {escape(" ".join(sentences))}</p>
{grade_html(verdict)}{unknown_html(verdict)}
<p class=quiet>Wing {escape(diagnosis["wing"])}, measured in {escape(diagnosis["measurement"])}.</p>
<ul class=numbers>{boxes}</ul>
{f'<div class=warnings>{escape(warning)}.</div>' if warning else ''}
{alternatives(diagnosis)}
{extension(diagnosis)}
{shifts(diagnosis)}
{flight_html(flight)}
{"".join(figure_html(picture) for picture in pictures)}
{candidates(diagnosis["effects"])}
{questions(diagnosis)}
{next_measurement(diagnosis)}
<h2>How to read this</h2>
<dl>
<dt>local p, p</dt><dd>How often chance alone makes a cause look at least so good: at this position, and at the best of all
positions that were tried. With many causes one of them looks good by chance; the number at the top allows for it.</dd>
<dt>seen beside baseline</dt><dd>How much of what a cause does to the deformations the baseline cannot imitate by other
values of its parameters. Below 0.05 a cause is absorbed.</dd>
<dt>found with 90 % from</dt><dd>The change of a parameter that these data would show in nine of ten experiments; in units of the
parameter, of its natural logarithm for stiffnesses.</dd>
<dt>probability</dt><dd>Holds if one of the hypotheses is true: nothing, an entry of the catalogue, several, or an unknown
smooth cause.</dd>
</dl>
<p class=quiet>{escape(diagnosis["program"])}, seed {diagnosis["seed"]}.</p>
</body></html>
"""
