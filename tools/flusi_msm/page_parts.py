# SPDX-License-Identifier: GPL-3.0-or-later
"""Common parts of the pages of all reports: their style, tables that fit a phone, and embedded pictures."""
from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from typing import Union

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.55 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; color: #262019;
       background: #fff; max-width: 68rem; margin: 0 auto; padding: 2rem 1.5rem 4rem; overflow-wrap: break-word; }
h1 { font-size: 1.65rem; line-height: 1.3; margin: 0 0 .2rem; } h2 { font-size: 1.2rem; margin: 2.6rem 0 .5rem; }
p, li { max-width: 50rem; } .quiet { color: #6b6257; } .lead { font-size: 1.15rem; margin: .6rem 0 1rem; }
.numbers { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1.4rem 0; padding: 0; list-style: none; }
.numbers li { flex: 1 1 11rem; border: 1px solid #e2dbcf; border-radius: .5rem; padding: .6rem .9rem; }
.numbers b { display: block; font-size: 1.3rem; } .numbers span { font-size: .85rem; color: #6b6257; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; }
th { text-align: left; font-weight: 600; border-bottom: 2px solid #cfc4ac; padding: .4rem .7rem .4rem 0; }
td { border-bottom: 1px solid #ece6da; padding: .42rem .7rem .42rem 0; vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; } td.number { white-space: nowrap; }
td.name { font-weight: 600; min-width: 8rem; overflow-wrap: anywhere; }
.verdict { display: inline-block; border-radius: 1rem; padding: .05rem .65rem; font-size: .82rem; white-space: nowrap; }
h1 .verdict { vertical-align: .2rem; }
.determined { background: #0072B2; color: #fff; } .roughly { background: #E69F00; color: #2b1e00; }
.lower, .upper, .open, .failed { background: #e4e1dc; color: #4a443c; }
.unknown { background: #fff; border: 1px solid #8c8478; }
.warnings { border-left: 4px solid #D55E00; background: #fdf3ec; padding: .6rem 1rem; margin: 1.2rem 0; }
.warnings ul { margin: .3rem 0; padding-left: 1.1rem; }
.fine { border-left: 4px solid #009E73; background: #eef8f4; padding: .6rem 1rem; margin: 1.2rem 0; }
.sure { border-left: 4px solid #0072B2; background: #eff6fb; padding: .6rem 1rem; margin: 1.2rem 0; }
.scroll { overflow-x: auto; }
figure { margin: 1rem 0 1.6rem; } figure img { max-width: 100%; height: auto; }
figcaption { font-size: .92rem; color: #4a443c; max-width: 50rem; }
.gallery { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); gap: .4rem 1.2rem; }
.gallery img { width: 100%; }
pre { background: #f8f5ee; padding: .8rem 1rem; white-space: pre-wrap; overflow-wrap: anywhere; font-size: .8rem; line-height: 1.4; }
dt { font-weight: 600; margin-top: .6rem; } dd { margin: 0; max-width: 50rem; }
summary { cursor: pointer; margin: 1rem 0 .4rem; }
@media (max-width: 45rem) {
  body { padding: 1.1rem .9rem 3rem; }
  table.stack, table.stack tbody, table.stack tr, table.stack td { display: block; width: auto; }
  table.stack thead { display: none; }
  table.stack tr { border-bottom: 1px solid #cfc4ac; padding: .5rem 0; }
  table.stack td { border: 0; padding: .08rem 0; text-align: left; white-space: normal; }
  table.stack td[data-label]:not(.name)::before { content: attr(data-label) ": "; color: #6b6257; }
}
@media print { body { max-width: none; } figure, tr { break-inside: avoid; } }
"""

Head = Union[str, tuple[str, bool]]  # of a column: its text, or the text and whether the column has numbers


def figure_html(picture: tuple[str, str, bytes | list[bytes]]) -> str:
    """Returns (heading, caption, png) as HTML; the picture is part of the page. Several pngs, in a list, are placed next to each
    other if there is room."""
    heading, caption, pngs = picture
    every = pngs if isinstance(pngs, list) else [pngs]
    images = "".join(f'<img alt="{escape(heading or caption)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'
                     for png in every)
    images = f"<div class=gallery>{images}</div>" if len(every) > 1 else images
    return (f"<h2>{escape(heading)}</h2>\n" if heading else "") + \
        f"<figure>{images}<figcaption>{escape(caption)}</figcaption></figure>"


def table_html(heads: Sequence[Head], rows: Sequence[Sequence[str]], name: str = "") -> str:
    """Returns a table of HTML cells, of which the first is a name. Heads are (text, whether the column has numbers); a head that
    is a plain text has words in its column. On a phone each row becomes a block, with the heads before its cells."""
    columns = [(head, False) if isinstance(head, str) else head for head in heads]
    top = "".join(f"<th{' class=number' if is_number else ''}>{escape(head)}</th>" for head, is_number in columns)
    lines = []
    for row in rows:
        cells = []
        for k, ((head, is_number), cell) in enumerate(zip(columns, row)):
            kind = " class=name" if k == 0 else " class=number" if is_number else ""
            cells.append(f'<td{kind}{f""" data-label="{escape(head)}" """.rstrip() if head else ""}>{cell}</td>')
        lines.append("<tr>" + "".join(cells) + "</tr>")
    return (f'<table class=stack{f" id={name}" if name else ""}><thead><tr>{top}</tr></thead><tbody>\n' + "\n".join(lines)
            + "\n</tbody></table>")


def badge(kind: str, text: str) -> str:
    """Returns a word in a coloured pill; kinds are classes of STYLE."""
    return f'<span class="verdict {kind}">{escape(text)}</span>'


def document(title: str, body: str) -> str:
    """Returns the page around `body`."""
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title><style>{STYLE}</style></head><body>
{body}
</body></html>
"""
