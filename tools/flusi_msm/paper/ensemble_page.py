# SPDX-License-Identifier: GPL-3.0-or-later
"""The ensemble of stiffnesses as one HTML page that needs nothing else, and its numbers as JSON."""
from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib

from flusi_msm.paper.study_files import Picture

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.page_parts import STYLE, Head, figure_html, table_html
from flusi_msm.paper.ensemble import E_DEVIATION, E_MEAN, NINE, OWN, chance, collect
from flusi_msm.paper.numbers import COLUMNS, TABLE_2
from flusi_msm.paper.study_files import write_study
from flusi_msm.style import COLOURS, save, use_style

if TYPE_CHECKING:
    from flusi_msm.paper.ensemble import Ensemble

TITLE = "Blowfly wings whose stiffness is drawn"
LABELS = dict(zip(COLUMNS, ("lift [mN]", "drag [mN]", "power [mW]", "lift / drag", "lift / power [mN/mW]")))
WORDS = dict(zip(COLUMNS, ("lift", "drag", "power", "lift to drag", "lift to power")))


def done_of(found: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns the members that have flown."""
    return [member for member in found["members"] if "means" in member]


# ---- pictures ----------------------------------------------------------------------------------------

def boxes(found: dict[str, Any], folder: Path) -> Picture:
    """Box plots of the means, with the members as points, and the paper's flexible wings."""
    use_style()
    done = done_of(found)
    figure, axes = plt.subplots(1, len(COLUMNS), figsize=(11.5, 3.2), layout="constrained")
    places = 1 + 0.2 * (np.arange(len(done)) / max(1, len(done) - 1) - 0.5)
    for ax, key in zip(axes, COLUMNS):
        values = np.array([member["means"][key] for member in done])
        ax.boxplot(values, whis=1.5, widths=0.5, showfliers=False, medianprops={"color": COLOURS[1]})
        ax.plot(places, values, "o", color=COLOURS[0], markersize=3.5, alpha=0.7)
        ax.axhline(TABLE_2["flexible"][key], color=COLOURS[1], linestyle="--", linewidth=1.0)
        ax.set_xticks([])
        ax.set_xlim(0.6, 1.4)
        ax.set_ylim(min(0.0, 1.1 * values.min()), 1.1 * max(values.max(), TABLE_2["flexible"][key]))
        ax.set_ylabel(LABELS[key])
        if key in OWN:
            ax.set_title(f"spread {found['spread'][key]['whiskers_percent']:.1f} %\npaper {found['paper_spread_percent'][OWN[key]]} %",
                         loc="left")
    path = folder / "boxes.png"
    save(figure, path)
    return (f"Means of {len(done)} members", "Means of the last two beats of both wings. Box: quartiles and median; whiskers: the "
            "farthest member within 1.5 boxes; spread: from end to end of the whiskers over the median. Dashed: flexible wings of the "
            "paper's Table 2 (individual 8).", path)


def correlations(found: dict[str, Any], folder: Path) -> Picture:
    """Rank correlations of the means with what was drawn."""
    use_style()
    table, members = found["rank_correlation"], len(done_of(found))
    names = list(next(iter(table.values())))
    values = np.array([[table[key][name] for key in COLUMNS] for name in names])
    figure, ax = plt.subplots(figsize=(6.4, 0.9 + 0.33 * len(names)), layout="constrained")
    image = ax.imshow(values, cmap="RdBu_r", vmin=-1, vmax=1, aspect="auto")
    for i, row in enumerate(values):
        for j, value in enumerate(row):
            is_sure = abs(value) >= chance(members)
            ax.text(j, i, f"{value:+.2f}", ha="center", va="center", fontweight="bold" if is_sure else "normal",
                    color="w" if abs(value) > 0.6 else "k" if is_sure else "0.45")
    ax.set_xticks(range(len(COLUMNS)), [WORDS[key].replace(" to", "\nto") for key in COLUMNS])
    ax.set_yticks(range(len(names)), [name.removeprefix("joint:") for name in names])
    ax.tick_params(length=0)
    figure.colorbar(image, ax=ax).set_label("rank correlation")
    path = folder / "rank_correlation.png"
    save(figure, path)
    return ("What the means depend on", f"Spearman's rank correlation of the means with E and the joints over {members} members. Grey: "
            f"below {chance(members):.2f}, which chance alone exceeds once in twenty times.", path)


def all_pictures(found: dict[str, Any], folder: Path) -> list[Picture]:
    """Returns all pictures; none before enough members have flown."""
    if "spread" not in found:
        return []
    folder.mkdir(parents=True, exist_ok=True)
    return [boxes(found, folder), correlations(found, folder)]


# ---- words -------------------------------------------------------------------------------------------

def sentences(found: dict[str, Any]) -> list[str]:
    """Returns what the ensemble says, in sentences."""
    done = done_of(found)
    made = [f"{len(done)} of {len(found['members'])} members have flown."]
    if "spread" not in found:
        return made
    spreads, paper = found["spread"], found["paper_spread_percent"]
    made.append("Spread, from end to end of the whiskers over the median: " + ", ".join(
        f"{WORDS[key]} {spreads[key]['whiskers_percent']:.1f} % (paper {paper[name]} %)" for key, name in OWN.items()) + ".")
    if "nine_percent" in spreads["drag_mN"]:
        made.append("Nine members, as many as the paper's individuals, have from the lowest to the highest usually "
                    + ", ".join(f"{spreads[key]['nine_percent']:.1f} % in {WORDS[key]}" for key in OWN)
                    + " (medians over sets of nine).")
    largest = max(OWN, key=lambda key: spreads[key]["whiskers_percent"])
    made.append(f"{WORDS[largest].capitalize()} spreads most"
                + (", as in the paper." if largest == "drag_mN" else "; in the paper it is drag."))
    limit = chance(len(done))
    for key in COLUMNS:
        sure = sorted(((abs(value), name, value) for name, value in found["rank_correlation"][key].items() if abs(value) >= limit),
                      reverse=True)
        listed = ", ".join(f"{name.removeprefix('joint:')} ({value:+.2f})" for _, name, value in sure)
        made.append(f"{WORDS[key].capitalize()} goes with {listed}." if sure else f"{WORDS[key].capitalize()} goes with none of what "
                    "was drawn, by more than chance.")
    return made


def choice(found: dict[str, Any]) -> str:
    """Describes how the stiffness is drawn, as HTML."""
    between = (f" Two of the drawn numbers have a rank correlation of {found['design_correlation']:.2f} at most among the members that "
               "have flown.") if "design_correlation" in found else ""
    return f"""<ul>
<li>E is drawn from a normal distribution with the paper's mean {E_MEAN / 1e9:g} and deviation {E_DEVIATION / 1e9:g} GPa over its nine
individuals, of which only positive values.</li>
<li>Of the joints the paper says that they vary significantly among individuals; the numbers of its box plot are not in its text. Here
each is drawn log-normally about its value in the input (most often that of the vein without the joint), two thirds within a factor of
{found['joint_factor']:g} and 95 % within {found['joint_factor']**2:g}, independently of E and of each other. This factor is an assumption
(<code>--joint-factor</code>), and spreads grow with it.</li>
<li>All members have the size of the input. The design is an additive recurrence with the square roots of primes, without chance: member k is the
same for any number of members.{between}</li></ul>"""


def member_table(found: dict[str, Any]) -> str:
    """Returns what was drawn and the means of all members as HTML."""
    names = list(found["members"][0]["drawn"])
    heads: list[Head] = ["member", ("E [GPa]", True), *((f"{name.removeprefix('joint:')} / input", True) for name in names[1:]),
             *((LABELS[key], True) for key in COLUMNS)]
    rows = []
    for member in found["members"]:
        drawn, means = member["drawn"], member.get("means")
        ratios = [drawn[name] / found["joints_of_the_input"][name.removeprefix("joint:")] for name in names[1:]]
        rows.append([str(member["member"]), f"{drawn['E'] / 1e9:.2f}", *(f"{x:.2f}" for x in ratios),
                     *((f"{means[key]:.3f}" if means else "–") for key in COLUMNS)])
    return f"<div class=scroll>{table_html(heads, rows, 'members')}</div>"


def spread_table(found: dict[str, Any]) -> str:
    """Returns the spreads as HTML."""
    heads: list[Head] = ["", *((head, True) for head in ("median", "whiskers", "all members", f"{NINE} members, usually", "paper, nine individuals"))]
    rows = [[LABELS[key], f"{s['median']:.3f}", f"{s['whiskers_percent']:.1f} %", f"{s['all_percent']:.1f} %",
             f"{s['nine_percent']:.1f} %" if "nine_percent" in s else "–", f"{found['paper_spread_percent'][OWN[key]]} %"]
            for key, s in found["spread"].items()]
    return table_html(heads, rows, "spread")


def page(found: dict[str, Any], pictures: Sequence[Picture]) -> str:
    """Returns the whole page."""
    notes = [f"Not finished yet: {', '.join(found['missing'])}."] if found["missing"] else []
    if len(found["versions"]) > 1:
        notes.append(f"Flights were made by several versions of the program: {', '.join(found['versions'])}.")
    warnings = "".join(f"<li>{escape(note)}</li>" for note in notes)
    warnings = f"<div class=warnings><ul>{warnings}</ul></div>" if notes else ""
    said = "".join(f"<li>{escape(text)}</li>" for text in sentences(found))
    figures = "\n".join(figure_html((heading, caption, path.read_bytes())) for heading, caption, path in pictures)
    n = found["points_along_x"]
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{TITLE}</title><style>{STYLE}</style></head><body>
<h1>{TITLE}</h1>
<p class=quiet>Flexible wings without thickness on {n} x {n} x {n // 2} points, {found['beats']} beats, the last two averaged, by
tools/reproduce_paper --ensemble. {escape(', '.join(found['versions']))}.</p>
{warnings}
<ul id=sentences>{said}</ul>
<h2>How the stiffness is drawn</h2>
{choice(found)}
{spread_table(found) if 'spread' in found else ''}
{figures}
<h2>The members</h2>
{member_table(found)}
</body></html>
"""


def write_page(folder: Path, ensemble: Ensemble) -> Path:
    """Writes NAME.json and NAME.html of the members that are finished, and pictures into the folder of the ensemble."""
    found = collect(ensemble)
    found["sentences"] = sentences(found)
    return write_study(folder, ensemble, found, all_pictures, page)
