#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws layers.svg, the picture of the layers, from the CMakeLists.txt of src; counts files and lines.

usage: docs/developer/layers.py              write layers.svg
       docs/developer/layers.py --check      exit code 1 if layers.svg is not what would be written
       docs/developer/layers.py --counts     print a table of files and lines of all layers
"""
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
SRC = HERE.parents[1] / "src"
# Where a layer is drawn from left to right, its colour, and what it is for. Its height follows from its USES.
BLUE, GREEN, ORANGE, GREY = "#d6e6f5", "#dcefd8", "#fbe5cd", "#ececec"
LAYERS = {
    "base": (1.65, GREY, "kinds, errors, text"),
    "parallel": (0.65, GREY, "MPI, tasks for many ranks"),
    "io": (0.9, GREY, "ini, HDF5, series, XDMF"),
    "cmaes": (2.35, ORANGE, "global search"),
    "least_squares": (3.4, ORANGE, "fits and intervals"),
    "solid_msm": (0.9, GREEN, "the wing: masses, springs"),
    "measurement": (1.9, ORANGE, "measured shapes"),
    "inference": (3.4, ORANGE, "statistics of causes"),
    "training": (2.45, ORANGE, "finds the stiffness"),
    "diagnosis": (3.4, ORANGE, "finds what is missing"),
    "spectral": (0.0, BLUE, "Fourier transforms"),
    "fluid": (0.0, BLUE, "Navier-Stokes"),
    "fsi": (0.0, BLUE, "wings in the flow"),
    "common": (0.9, GREY, "what programs share"),
    "simulation": (0.0, BLUE, "a flow from an ini file"),
    "flusi": (0.0, BLUE, "program: flow, wing alone"),
    "msm_train": (2.3, ORANGE, "program: training"),
    "msm_diagnose": (3.4, ORANGE, "program: diagnosis"),
}
COLUMN, ROW, WIDTH, HEIGHT, MARGIN = 220, 95, 180, 50, 20
CALL = re.compile(r"add_(?:layer|part)\((\w+)\s+(?:\w+\s+)?SOURCES\s+(.*?)\s+USES\s+(.*?)\)", re.S)


def read_layers(src):
    """{layer: (folder, its sources, the layers that it names in USES)}; a layer of parts names what one of them names."""
    found = {}
    for path in sorted(src.rglob("CMakeLists.txt")):
        for name, sources, uses in CALL.findall(path.read_text(encoding="utf-8")):
            names = [word[len("flusi_"):] for word in uses.split()
                     if word.startswith("flusi_") and not word.startswith(f"flusi_{name}_")]
            _, before, others = found.get(name, (path.parent, [], []))
            found[name] = (path.parent, before + sources.split(), others + [one for one in names if one not in others])
    return found


def below(layers, name):
    """All layers that `name` sees, also through others."""
    seen = set()
    for other in layers[name][2]:
        seen |= {other} | below(layers, other)
    return seen


def direct(layers, name):
    """The layers that `name` uses and that none of the others brings along."""
    uses = layers[name][2]
    return sorted(one for one in set(uses) if not any(one in below(layers, other) for other in uses if other != one))


def height(layers, name):
    """Longest way down to a layer that uses none."""
    return max((1 + height(layers, other) for other in layers[name][2]), default=0)


def picture(layers):
    """The text of the SVG file. An arrow points from a layer to one that it uses; those that follow are left out."""
    missing = sorted(set(layers) ^ set(LAYERS))
    if missing:
        sys.exit(f"layers.py: {', '.join(missing)}: in src or in the table LAYERS, but not in both")
    top = max(height(layers, name) for name in layers)
    place = {name: (MARGIN + WIDTH / 2 + COLUMN * column, MARGIN + HEIGHT / 2 + ROW * (top - height(layers, name)))
             for name, (column, _, _) in LAYERS.items()}
    width = max(x for x, _ in place.values()) + WIDTH / 2 + MARGIN
    depth = max(y for _, y in place.values()) + HEIGHT / 2 + MARGIN
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {depth:.0f}" '
             'font-family="sans-serif" text-anchor="middle">',
             '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" '
             'orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="#555"/></marker></defs>',
             f'<rect width="{width:.0f}" height="{depth:.0f}" fill="white"/>']
    for name in sorted(layers):
        for other in direct(layers, name):
            (x, y), (u, v) = place[name], place[other]
            shift = max(-WIDTH / 3, min(WIDTH / 3, (u - x) / 6))
            lines.append(f'<path d="M{x + shift:.0f},{y + HEIGHT / 2:.0f} L{u - shift:.0f},{v - HEIGHT / 2:.0f}" '
                         'stroke="#555" fill="none" marker-end="url(#tip)"/>')
    for name in sorted(layers):
        (x, y), (_, colour, text) = place[name], LAYERS[name]
        lines += [f'<rect x="{x - WIDTH / 2:.0f}" y="{y - HEIGHT / 2:.0f}" width="{WIDTH}" height="{HEIGHT}" rx="6" '
                  f'fill="{colour}" stroke="#555"/>',
                  f'<text x="{x:.0f}" y="{y - 4:.0f}" font-size="15" font-weight="bold">{name}</text>',
                  f'<text x="{x:.0f}" y="{y + 15:.0f}" font-size="12">{text}</text>']
    return "\n".join([*lines, "</svg>", ""])


def counts(layers):
    """Rows of a Markdown table: files, lines, files in the largest folder."""
    yield "| layer | files | lines | files in its largest folder |"
    yield "|---|---|---|---|"
    total = [0, 0, 0]
    for name in sorted(layers, key=lambda one: (height(layers, one), one)):
        files = [path for path in layers[name][0].rglob("*.f90")]
        folders = [path.parent for path in files]
        row = [len(files), sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files),
               max(folders.count(folder) for folder in folders)]
        total = [total[0] + row[0], total[1] + row[1], max(total[2], row[2])]
        yield f"| {name} | {row[0]} | {row[1]} | {row[2]} |"
    yield f"| all | {total[0]} | {total[1]} | {total[2]} |"


def main():
    layers = read_layers(SRC)
    target = HERE / "layers.svg"
    if sys.argv[1:] == ["--counts"]:
        print("\n".join(counts(layers)))
    elif sys.argv[1:] == ["--check"]:
        if not target.exists() or target.read_text(encoding="utf-8") != picture(layers):
            print("docs/developer/layers.svg does not show the layers of src: run docs/developer/layers.py")
            return 1
    elif sys.argv[1:]:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    else:
        target.write_text(picture(layers), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
