# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the report of a diagnosis as one HTML page that needs no other file: the verdict in words with its probability, the
extension of the model, pictures, candidates, tests of the residuals, and recommendations for the next measurement."""
from __future__ import annotations

import math
import re
from collections.abc import Sequence
from html import escape
from typing import Any

from flusi_msm.diagnosis.comparison import compared_html
from flusi_msm.diagnosis.values import Value, in_text, said_of
from flusi_msm.page_parts import badge, document, figure_html, table_html

CLASSES = {"adequate": "determined", "named": "determined", "consistent_with_set": "roughly",
           "unknown_cause": "failed", "data_insufficient": "unknown"}
WORDS = {"adequate": "The model is adequate", "named": "The cause has a name",
         "consistent_with_set": "Several causes are possible", "unknown_cause": "A cause that is not in the catalogue",
         "data_insufficient": "Not enough data"}
SMALL = 0.05  # p below which something was found
STUDY = ("A study of cases whose causes were hidden from the program has told how often it is right when the odds are these "
         "(docs/results/blind-tests.md).")
NO_STUDY = "It is that of the odds."
# What the stated probability refers to.
SURE = {"adequate": "that nothing which these data could show is missing from the model",
        "named": "that this cause is really there",
        "together": "that these causes are there, and no other",
        "consistent_with_set": "that one of these causes at least is there",
        "unknown_cause": "that the cause is none of those in the catalogue"}
REASONS = {"alias": "Another cause does nearly the same to the wing, so that these data cannot tell them apart.",
           "not_rejectable": "The data are too weak to exclude a cause that nobody thought of.",
           "probability": "It is not sure enough for a name.",
           "no_fit": "The wing could not be fitted with it.",
           "null_not_excluded": "Its interval holds the value at which it does nothing.",
           "at_bound": "Its fit stands at the end of the range that was searched.",
           "no_gain": "With it the model predicts loads that the fit has not seen no better than without."}


def pretty(text: str) -> str:
    """Replaces signs that the program writes in ASCII by those used in print."""
    return escape(re.sub(r"(?<=\d )u(?=(m|N|g)\b)", "µ", re.sub(r"\buN m\b", "µN m", text)).replace("m/s^2", "m/s²"))


def share(p: float) -> str:
    """Writes a probability in per cent; never as 100."""
    return f"{100 * p:.0f} %" if p < 0.995 else "over 99 %"


def power(p: float | None) -> str:
    """Writes a p-value in full."""
    if p is None:
        return "–"
    if p >= 1e-3:
        return f"{p:.3f}"
    return "below 10<sup>−300</sup>" if p <= 0 else f"10<sup>{str(math.floor(math.log10(p))).replace('-', '−')}</sup>"


def one_in(p: float) -> str:
    """Writes how rarely something happens by chance: '1 in 300'."""
    if p >= 0.1:
        return f"{100 * p:.0f} of 100"
    if p >= 1e-5:
        return f"1 in {float(f'{1 / p:.2g}'):.0f}"
    return "less than 1 in 10<sup>300</sup>" if p <= 0 else f"less than 1 in 10<sup>{math.floor(-math.log10(p))}</sup>"


def titles_of(diagnosis: dict[str, Any]) -> dict[str, str]:
    """Returns {name: title} of all effects."""
    return {e["name"]: e["title"] for e in diagnosis["effects"]}


def is_together(verdict: dict[str, Any]) -> bool:
    """Returns whether the verdict says that several causes are there at once."""
    return verdict["is_together"] or (verdict["word"] == "named" and len(verdict["causes"]) > 1)


def lead(diagnosis: dict[str, Any]) -> str:
    """Writes the verdict in one to three sentences."""
    verdict, word = diagnosis["verdict"], diagnosis["verdict"]["word"]
    titles = titles_of(diagnosis)
    if word == "adequate":
        return "The model explains these data within their errors: chance alone makes differences like those that remain " \
               f"in {one_in(verdict['global_p'])} experiments."
    if word == "data_insufficient":
        return "There are too few data to test anything: more loads or more heights than unknowns are needed."
    if word == "unknown_cause":
        return "Something makes the wing differ from the model, and nothing in the catalogue explains it."
    told = [one.get("finding") or titles.get(one["effect"], one["effect"]) for one in verdict["causes"]]
    text = " ".join(f"{pretty(one)}." for one in told)
    wider = " or ".join(pretty(titles[name]) for name in verdict.get("wider", []))
    if wider:
        text += f" It may be a part of a wider change, which explains the data as well: {wider}."
    if word != "consistent_with_set":
        return text
    names = "; ".join(pretty(titles[name]) for name in verdict["set"])
    if verdict["is_together"]:
        return f"These data agree with several causes at once: {names}. Other causes are not excluded. If it is these: {text}"
    if len(verdict["set"]) > 1:
        return f"These data cannot tell apart: {names}; nor something that is not in the catalogue. If it is the first: {text}"
    return f"These data agree with {names}, but other causes are not excluded, nor something that is not in the catalogue. " \
           f"If it is this cause: {text}"


def meaning(diagnosis: dict[str, Any]) -> str:
    """Describes the causes in general."""
    verdict = diagnosis["verdict"]
    if verdict["word"] not in ("named", "consistent_with_set"):
        return ""
    known = {e["name"]: e for e in diagnosis["effects"]}
    sentences = dict.fromkeys(f"{known[c['effect']]['title'].capitalize()}: {known[c['effect']]['sentence']}"
                              for c in verdict["causes"] if c["effect"] in known)
    return "".join(f"<p>{pretty(text)}</p>" for text in sentences)


def sureness(diagnosis: dict[str, Any]) -> str:
    """Writes the stated probability, what it refers to, and the reasons why the answer is not more certain."""
    verdict, word = diagnosis["verdict"], diagnosis["verdict"]["word"]
    if word not in SURE:
        return ""
    text = f"<b>How sure is that? {share(verdict['probability'])}</b> is the probability " \
           f"{SURE['together' if is_together(verdict) and word == 'named' else word]}. " + (NO_STUDY if verdict.get("probability_map", "").startswith("none") else STUDY)
    if word == "named":
        text += " Of an unknown cause that is as strong the same rules would hardly have said this name."
    if word == "consistent_with_set":
        text += " It gets no name of its own: " + REASONS.get(verdict.get("set_because", ""), "other causes are not excluded.")
        text += " Causes outside the catalogue are not excluded either."
    return f"<p class=sure>{text}</p>"


def hidden_cause(diagnosis: dict[str, Any]) -> str:
    """Explains why a sum of squares that agrees with noise can hide a cause; '' where it does not agree, or nothing was found."""
    verdict, base = diagnosis["verdict"], diagnosis["baseline"]
    n, chi2 = base.get("observations", 0), base.get("chi2", 0)
    if not n or verdict["global_p"] > SMALL or verdict["word"] == "data_insufficient" or chi2 > n + 2 * math.sqrt(2 * n):
        return ""
    return (f"<p>The baseline, the usual model with its parameters fitted, has χ² = {chi2:.1f} for {n} numbers, and so looks good. χ² is "
            "the sum of the squared differences in units of their errors, about one for each number that is only noise. It adds up "
            "the noise of all numbers, and a cause moves only a few combinations of them: in the sum it drowns, while tests "
            f"that look along these combinations find it at {verdict['snr']:.0f} times the noise.</p>")


def boxes_of(diagnosis: dict[str, Any]) -> list[tuple[str, str]]:
    """Returns (value, description) of the boxes at the top."""
    verdict, validation = diagnosis["verdict"], diagnosis["validation"]
    if verdict["word"] == "data_insufficient":
        return []
    boxes = [(one_in(verdict["global_p"]), "experiments in which chance alone makes differences like these, all tests "
                                           "together")]
    if verdict["word"] != "adequate":
        boxes.append((f"{verdict['snr']:.1f}", "signal-to-noise ratio: what the cause does to the data over what their "
                                               "errors do"))
    if validation["has_gain"]:
        base, extended = validation["baseline"], validation["extended"]
        n = sum(extended["observations"])
        boxes.append((f"{math.sqrt(sum(base['chi2']) / n):.2f} → {math.sqrt(sum(extended['chi2']) / n):.2f}",
                      "difference at loads that the fit has not seen, in units of its errors, without and with the cause"))
    band = diagnosis.get("mesh_band", {})
    if band.get("is_found"):
        boxes.append((f"{band['snr']:.1f}", "signal-to-noise ratio that the mesh alone would mimic; it is counted as an error"))
    return boxes


def unknown_html(verdict: dict[str, Any]) -> str:
    """Describes where an unknown cause is, and which known causes come nearest to it; '' for other verdicts."""
    text, region = "", verdict.get("region")
    if region:
        what = {"stiffness": "a stiffness that differs", "force": "further forces",
                "scans": "bent scans", "veins": "veins of another stiffness", "flight": "waves over the beat",
                "sensors": "errors of sensors"}[region["of"]]
        parts = [f"around ({1e3 * p['centre_m'][0]:.1f}, {1e3 * p['centre_m'][1]:.1f}) mm, radius {1e3 * p['radius_m']:.1f} mm "
                 f"({share(p['share'])})" for p in region["parts"]]
        text = f"<p>As {what}, it would be " + ("at one place; the share is that of this place among all: "
                                                if region["form"] == "one_place" else
                                                "a field over the wing; the shares are of all that stands out: ") \
            + "; ".join(parts) + ".</p>"
        if region["of"] == "scans":
            text = "<p>It is not on the wing: scans are bent, each in another way, as if the rig bent or the wing kept " \
                   "something of the scan before.</p>"
        elif region["of"] == "flight":
            text = "<p>It is in the records over the beat, and has no place on the wing.</p>"
        elif region["of"] == "sensors":
            text = "<p>It is not on the wing: sensors of the records of motion have another gain, a delay, or a filter that the " \
                   "file does not state.</p>"
        elif not parts:
            text = f"<p>As {what}, it would be a field over the wing in which no place stands out.</p>"
    if verdict.get("related"):
        text += "<p>Related, but not sufficient: " + "; ".join(
            f"{pretty(one['name'])} ({share(one['explained'])} of the misfit)" for one in verdict["related"]) + ".</p>"
    return text


def extension(diagnosis: dict[str, Any]) -> str:
    """Lists what was added to the model: value, interval and sentence of each parameter, but no value of a parameter that is not
    determined."""
    extended = diagnosis["extended"]
    before = {one["name"] for one in diagnosis["baseline"]["parameters"]}
    intervals = {one["name"]: one for one in extended.get("intervals_90", [])}
    sentences = {one["name"]: one["sentence"] for one in extended.get("findings", [])}
    is_too_little = not intervals and diagnosis["verdict"]["word"] == "unknown_cause"
    rows = []
    for parameter in extended.get("parameters", []):
        if parameter["name"] in before:
            continue
        value = Value.of(parameter, intervals.get(parameter["name"]))
        words = sentences.get(parameter["name"], "")
        if is_too_little:
            words = "It explains too little for an interval."
        rows.append((escape(value.label), escape("–" if is_too_little else value.shown()), escape(value.interval()),
                     badge(value.kind, value.word()), pretty(words)))
    if not rows:
        return ""
    return ("<h2>What was added to the model</h2><p>A 90 % interval holds the true value in nine of ten experiments, if model and "
            "errors are right; all other parameters were fitted again at each of its ends.</p>"
            + table_html(("parameter", ("value", True), ("90 % interval", True), "verdict", "in words"), rows, "added"))


def alternatives(diagnosis: dict[str, Any]) -> str:
    """Lists the causes that the data cannot distinguish; '' if the verdict is no set."""
    verdict = diagnosis["verdict"]
    if verdict["word"] != "consistent_with_set" or verdict["is_together"]:
        return ""
    known = {e["name"]: e for e in diagnosis["effects"]}
    first = {c["effect"] for c in verdict["causes"]}
    rows = []
    for name in verdict["set"]:
        found = pretty(known[name].get("finding", "")) or "It was not fitted alone."
        rows.append((pretty(known[name]["title"]), badge("roughly", "the first") if name in first
                     else badge("open", "cannot be excluded"), pretty(known[name]["sentence"]), found))
    note = ("<p>What fits worse stays a candidate if it does nearly the same to the wing as the first: only what was assumed of "
            "other parameters beforehand, or chance, speaks against it. Another measurement decides, see the end of this page.</p>"
            if len(rows) > 1 else "")
    return ("<h2>What these data cannot tell apart</h2>"
            + table_html(("cause", "standing", "in words", "what it would be"), rows, "set") + note)


def shifts(diagnosis: dict[str, Any]) -> str:
    """Lists the usual parameters of the model with the cause; '' if the model was not extended. A parameter that the data do not
    determine has no value."""
    if not diagnosis["extended"]["is_found"]:
        return ""
    before = {p["name"]: p for p in diagnosis["baseline"]["parameters"]}
    rows = []
    for parameter in diagnosis["extended"]["parameters"]:
        if parameter["name"] not in before:
            continue
        first, second = before[parameter["name"]], parameter
        rows.append((escape(Value.of(second).label), escape(said_of(first)), escape(said_of(second))))
    return ("<h2>What becomes of the other parameters</h2><p>A value with its 90 % error by the curvature of the fit; "
            "“not determined” where the data say less about it than was assumed before, or leave a range of ten times.</p>"
            + table_html(("parameter", ("without the cause", True), ("with it", True)), rows, "shifts"))


def standing(effect: dict[str, Any], diagnosis: dict[str, Any]) -> tuple[str, str]:
    """Returns (class, words) that describe the role of an entry of the catalogue in this verdict."""
    verdict = diagnosis["verdict"]
    if effect["status"] != "tested":
        return ("unknown", "cannot be seen" if effect["status"] == "absorbed" else "not testable")
    if verdict["word"] in ("named", "consistent_with_set"):
        if effect["name"] in {c["effect"] for c in verdict["causes"]}:
            return ("determined" if verdict["word"] == "named" else "roughly", "the cause" if verdict["word"] == "named" else "fits best")
        if effect["name"] in verdict["set"]:
            return ("roughly", "cannot be excluded")
        if effect["name"] in verdict.get("wider", []):
            return ("roughly", "may contain the cause")
    if effect["name"] in {one["effect"] for one in verdict.get("related", [])}:
        return ("open", "related, not sufficient")
    if effect["p"] > SMALL:
        return ("open", "not needed")
    return ("open", "explains less") if verdict["word"] != "adequate" else ("open", "not needed")


def smallest(effect: dict[str, Any]) -> str:
    """Writes from which strength on the data would show an effect."""
    if "shows_from" in effect:
        return pretty(effect["shows_from"]) or "at no strength"
    found = [in_text(name, value) for name, value in zip(effect["parameters"], effect["detectable"])
             if value is not None and 0 < value < 1e30]
    return escape("; ".join(found)) or "–"


def candidates(diagnosis: dict[str, Any]) -> str:
    """Lists all entries of the catalogue, the most probable first, and their tests in numbers."""
    order = {"tested": 0, "absorbed": 1, "not_testable": 2}
    rows, numbers = [], []
    for e in sorted(diagnosis["effects"], key=lambda e: (order[e["status"]], -(e.get("log_evidence") or 0))):
        where = f" ({pretty(e['variant'])})" if e.get("variant") else ""
        missing = "too few data" if diagnosis["verdict"]["word"] == "data_insufficient" and e["status"] == "absorbed" else \
            "other values of the baseline's parameters do the same" if e["status"] == "absorbed" else e["missing"]
        rows.append((pretty(e["title"]) + where, badge(*standing(e, diagnosis)),
                     smallest(e) if e["status"] == "tested" else pretty(missing), pretty(e["sentence"])))
        if e["status"] == "tested":
            numbers.append((pretty(e["title"]) + where, power(e["local_p"]), power(e["p"]), f"{100 * e['retained']:.0f} %",
                            f"{e['log_evidence']:.1f}"))
    detail = ("<details><summary>The tests of the candidates in numbers</summary><p>p: how often chance alone makes a cause look at "
              "least so good, at this position, and at the best of all positions that were tried. Seen: how much of what it does "
              "the baseline cannot imitate by other values of its parameters. Evidence: the natural logarithm of how much more "
              "probable it makes the data than the baseline alone.</p>"
              + table_html(("cause", ("p here", True), ("p anywhere", True), ("seen", True), ("evidence", True)), numbers,
                           "tests") + "</details>" if numbers else "")
    return ("<h2>All candidates</h2><p>The catalogue of what may be wrong with the model or the measurement. “Would show "
            "from” is the smallest strength that these data would show in nine of ten experiments.</p>"
            + table_html(("cause", "standing", "would show from, or what is missing", "in words"), rows, "candidates") + detail)


def questions(diagnosis: dict[str, Any]) -> str:
    """Lists the plain questions and their answers; '' without any."""
    rows = [(pretty(q["name"]), power(q["p"]), pretty(q["sentence"])) for q in diagnosis["questions"]]
    return ("<h2>Plain questions to what the baseline leaves</h2><p>p is how often noise alone would answer so clearly. All checks "
            "together may alarm in 1 % of wings without a cause: one of them counts if its p times their number is below 0.01.</p>"
            + table_html(("question", ("p", True), "answer"), rows, "questions") if rows else "")


MEDIA = {"vacuum": "a vacuum", "air": "air"}
KINDS = {"bending": "bending tests", "modes": "natural modes", "series": "records of motion", "flight": "forces over the beat",
         "landmarks": "landmarks over the beat"}


def data_table(diagnosis: dict[str, Any]) -> str:
    """Lists what each kind of data says about both models; '' without numbers of kinds, as in files of version 1."""
    rows = []
    for entry in diagnosis["data"]:
        if "baseline_chi2" not in entry:
            continue
        n = entry["observations"]
        left_out = entry.get("left_out", {})
        predicted = [rms_of(left_out[which]) for which in ("baseline", "extended") if which in left_out]
        rows.append((KINDS[entry["kind"]], str(n), f"{entry['baseline_chi2']:.1f}",
                     f"{entry['extended_chi2']:.1f}" if "extended_chi2" in entry else "–", " → ".join(filter(None, predicted)) or "–"))
    if not rows:
        return ""
    return ("<h2>What each kind of data says</h2><p>χ² is about the number of numbers if a model is right. Left out: the difference at "
            "places and records that the fit has not seen, in units of its errors, without and with the cause.</p>"
            + table_html(("data", ("numbers", True), ("χ² without the cause", True), ("with it", True), ("left out", True)), rows, "data"))


def rms_of(predicted: dict[str, Any]) -> str:
    """Writes the root mean square of a prediction in units of its errors; '' without numbers."""
    n = predicted["observations"]
    return f"{math.sqrt(predicted['chi2'] / n):.2f}" if n else ""


def what_of(one: dict[str, Any]) -> str:
    """Describes a measurement that may be next."""
    if "repeat" in one:
        kind = "" if one["kind"] == "bending" else f" ({KINDS[one['kind']]})"
        return f"once more: {one['repeat']}{kind}"
    if one["kind"] == "modes":
        return f"natural modes 1 to {len(one['frequencies_hz'])} in {MEDIA[one['medium']]}, near {', '.join(f'{f:.0f}' for f in one['frequencies_hz'])} Hz"
    if one["kind"] == "series":
        return (f"release a force of {1e3 * one['released_n']:.3g} mN at ({1e3 * one['place_m'][0]:.2f}, {1e3 * one['place_m'][1]:.2f}) mm in "
                f"{MEDIA[one['medium']]}, {one['samples']} samples at {one['rate_hz']:.0f} Hz")
    way = "up" if one["direction"][2] >= 0 else "down"
    return (f"push {way} at ({1e3 * one['place_m'][0]:.2f}, {1e3 * one['place_m'][1]:.2f}) mm with "
            f"{1e3 * one['force_n']:.3g} mN")


def next_measurement(diagnosis: dict[str, Any]) -> str:
    """Lists the measurements that would separate the causes best, of all kinds of data; '' without any."""
    measurements = diagnosis["next"]["measurements"]
    if not measurements:
        return ""
    shown = [one for is_new in (False, True) for one in [m for m in measurements if ("repeat" not in m) == is_new][:5]]
    shown += [one for kind in KINDS for one in [m for m in measurements if m["kind"] == kind][:2] if one not in shown]
    titles = titles_of(diagnosis)
    rows = [(pretty(what_of(one)), f"{one['separation_sd']:.1f} sd", pretty(", ".join(titles.get(name, name) for name in one.get("tells_apart", []))))
            for one in sorted(shown, key=lambda one: -one["separation_sd"])]
    reason = diagnosis["next"].get("motion_not_ranked")
    note = f"<p>New natural modes and records of motion are not in the table: {pretty(reason)}.</p>" if reason else ""
    return ("<h2>What to measure next</h2>" + rivals(diagnosis) + "<p>By how much the first cause differs from the nearest of all "
            "others with one of these measurements more. One sd is the size of a usual error: below 2 sd causes cannot be told apart, "
            "above 3 they can.</p>" + table_html(("measurement", ("it then differs by", True), "and is told from"), rows, "next") + note)


def rivals(diagnosis: dict[str, Any]) -> str:
    """Tells how far other causes are from the first; '' without any."""
    titles = titles_of(diagnosis)
    near = [f"{pretty(titles[r['effect']])}{' (' + pretty(r['variant']) + ')' if r['variant'] else ''} by "
            f"{r['separation_now_sd']:.1f} sd" for r in diagnosis.get("rivals", [])[:4]]
    return ("<p>What others can imitate of the first cause is taken from it; it now differs from " + ", from ".join(near)
            + ".</p>" if near else "")


def flight_html(flight: tuple[str, bytes] | None) -> str:
    """Describes how the cause changes a flight; '' without flights."""
    if flight is None:
        return ""
    text, picture = flight
    return f"<h2>What it changes in flight</h2>{text}" + figure_html(
        ("", "Lift, drag and aerodynamic power over the last beat.", picture))


def warnings_of(diagnosis: dict[str, Any]) -> str:
    """Writes the warnings about the data; '' without any."""
    noise = diagnosis["noise"]
    warning, tails = noise["warning"], noise.get("heavy_tails")  # files of earlier versions have none
    if tails and tails["is_found"]:
        least, most = tails["share_90"]
        warning = ". ".join(filter(None, (warning, f"{tails['heights_left_out']} of {tails['heights_tested']} heights stand out "
                                          f"from those around them ({100 * least:.2g} to {100 * most:.2g} % do) and were left "
                                          f"out. {tails['sentence'].rstrip('.')}")))
    return f"<div class=warnings>{pretty(warning)}.</div>" if warning else ""


GLOSSARY = """<h2>How to read this</h2>
<dl>
<dt>Baseline</dt><dd>The usual model of the wing, with those parameters fitted that the input asks for, and nothing of the
catalogue. The extended wing is the same with the causes of the verdict.</dd>
<dt>sd</dt><dd>Standard deviation, the size of a usual error. Nine of ten errors are below 1.6 sd.</dd>
<dt>Why a good χ² can hide a cause</dt><dd>χ² adds up the squared differences of all numbers, each about one if it is noise. A
cause moves only a few combinations of the numbers. Tests that look along these find it when the sum is still good.</dd>
<dt>Probability</dt><dd>It holds if one of the hypotheses is true: nothing, an entry of the catalogue, several together, or an
unknown smooth cause.</dd>
</dl>"""


def page(diagnosis: dict[str, Any], pictures: Sequence[tuple[str, str, bytes | list[bytes]]], flight: tuple[str, bytes] | None = None) \
        -> str:
    """Returns the whole page. `pictures` are (heading, caption, png bytes or a list of them)."""
    verdict = diagnosis["verdict"]
    boxes = "".join(f"<li><b>{value}</b><span>{escape(what)}</span></li>" for value, what in boxes_of(diagnosis))
    return document(f"Diagnosis: {WORDS[verdict['word']]}", f"""<h1>{escape(WORDS[verdict["word"]])} {
        badge(CLASSES[verdict["word"]], verdict["word"].replace("_", " "))}</h1>
<p class=lead>{lead(diagnosis)}</p>
{meaning(diagnosis)}{unknown_html(verdict)}
{sureness(diagnosis)}
<p class=quiet>Wing {escape(diagnosis["wing"])}, measured in {escape(diagnosis["measurement"])}.</p>
{f"<ul class=numbers>{boxes}</ul>" if boxes else ""}
{hidden_cause(diagnosis)}
{warnings_of(diagnosis)}
{alternatives(diagnosis)}
{data_table(diagnosis)}
{extension(diagnosis)}
{shifts(diagnosis)}
{compared_html(diagnosis)}{flight_html(flight)}
{"".join(figure_html(picture) for picture in pictures)}
{candidates(diagnosis)}
{questions(diagnosis)}
{next_measurement(diagnosis)}
{GLOSSARY}
<p class=quiet>{escape(diagnosis["program"])}, seed {diagnosis["seed"]}.</p>""")
