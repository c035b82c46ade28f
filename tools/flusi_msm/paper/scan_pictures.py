# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of the scan of the kinematics: small multiples over mean pitch and amplitude, one column for each tilt."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.paper.cases import FLEXIBLE, RIGID
from flusi_msm.paper.numbers import COLUMNS
from flusi_msm.paper.scan import CHANGES, complete, quantities
from flusi_msm.style import save, use_style

LABELS = dict(zip(COLUMNS, ("lift [mN]", "drag [mN]", "power [mW]", "lift / drag", "lift / power [mN/mW]")))
CHANGE_LABELS = {"lift_to_drag": "lift / drag [%]", "lift_to_power": "lift / power [%]"}
PAPER_COLOUR, SHIPPED_COLOUR = "#D55E00", "#000000"


def field(found, value, tilt):
    """(amplitudes, pitches) of the values at one tilt; NaN where there is none."""
    pitches, strokes = found["values"]["pitch"], found["values"]["stroke"]
    at = {(point["stroke"], point["pitch"]): value(point) for point in found["scan"] if point["tilt"] == tilt}
    return np.array([[np.nan if at.get((s, p)) is None else at[s, p] for p in pitches] for s in strokes], float)


def edges(values):
    """Of the cells about the values."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    half = (values[1] - values[0]) / 2
    return np.append(np.asarray(values) - half, values[-1] + half)


def colours_of(quantity, fields, paper):
    """(colour map, norm): changes are white at 0; the others have the paper's value in their range."""
    there = np.concatenate([f[np.isfinite(f)] for f in fields] + [[paper]])
    if quantity[0] == "change":
        limit = float(np.max(np.abs(there))) or 1.0
        return "RdBu", matplotlib.colors.Normalize(-limit, limit)
    low, high = float(there.min()), float(there.max())
    return "viridis", matplotlib.colors.Normalize(low, high if high > low else low + 1)


def draw_cell_numbers(ax, found, values, colours, norm, is_change):
    for i, stroke in enumerate(found["values"]["stroke"]):
        for j, pitch in enumerate(found["values"]["pitch"]):
            value = values[i, j]
            if not np.isfinite(value):
                ax.text(pitch, stroke, "–", ha="center", va="center", color="0.4")
                continue
            red, green, blue, _ = colours(norm(value))
            dark = 0.3 * red + 0.59 * green + 0.11 * blue < 0.5
            text = f"{value:+.0f}" if is_change else f"{value:#.3g}"
            ax.text(pitch, stroke, text, ha="center", va="center", color="w" if dark else "k", fontsize=8.5, zorder=4)


def draw_map(ax, found, quantity, values, paper, colours, norm):
    pitches, strokes = found["values"]["pitch"], found["values"]["stroke"]
    ax.pcolormesh(edges(pitches), edges(strokes), np.ma.masked_invalid(values), cmap=colours, norm=norm)
    draw_cell_numbers(ax, found, values, colours, norm, quantity[0] == "change")
    whole = len(pitches) > 1 and len(strokes) > 1 and np.isfinite(values).sum() > 3
    if whole and np.nanmin(values) <= paper <= np.nanmax(values):
        ax.contour(pitches, strokes, np.ma.masked_invalid(values), levels=[paper], colors=PAPER_COLOUR, linewidths=2.0)
    if quantity[0] == "change" and whole and np.nanmin(values) < 0 < np.nanmax(values):
        ax.contour(pitches, strokes, np.ma.masked_invalid(values), levels=[0.0], colors="0.2", linewidths=1.2, linestyles="--")
    ax.set_xticks(pitches)
    ax.set_yticks(strokes)
    ax.tick_params(length=0)


def mark(ax, found, tilt):
    """A frame about the shipped kinematics, one about the nearest point."""
    boxes = [(found["shipped"], SHIPPED_COLOUR, "-")] + ([(found["nearest"], PAPER_COLOUR, ":")] if "nearest" in found else [])
    for point, colour, style in boxes:
        if point["tilt"] == tilt:
            width, height = (np.ptp(edges(found["values"][axis])) / len(found["values"][axis]) for axis in ("pitch", "stroke"))
            ax.add_patch(plt.Rectangle((point["pitch"] - 0.47 * width, point["stroke"] - 0.47 * height), 0.94 * width, 0.94 * height,
                                       fill=False, edgecolor=colour, linestyle=style, linewidth=1.6))


def maps(found, kind, folder):
    """The map of all quantities of one kind, 'rigid', 'flexible' or 'change'."""
    use_style()
    rows = [row for row in quantities() if row[0][0] == kind]
    tilts = found["values"]["tilt"]
    figure, axes = plt.subplots(len(rows), len(tilts), squeeze=False, sharex=True, sharey=True, layout="constrained",
                                figsize=(1.9 + 2.3 * len(tilts), 0.6 + 1.75 * len(rows)))
    for line, (quantity, value, paper) in zip(axes, rows):
        fields = [field(found, value, tilt) for tilt in tilts]
        name, norm = colours_of(quantity, fields, paper)
        colours = matplotlib.colormaps[name]
        for ax, values, tilt in zip(line, fields, tilts):
            draw_map(ax, found, quantity, values, paper, colours, norm)
            mark(ax, found, tilt)
        bar = figure.colorbar(matplotlib.cm.ScalarMappable(norm, colours), ax=line[-1], aspect=14, fraction=0.09)
        bar.ax.axhline(paper, color=PAPER_COLOUR, linewidth=2.5)
        bar.set_label((CHANGE_LABELS if kind == "change" else LABELS)[quantity[1]])
        text = f"{paper:+.0f} %" if kind == "change" else f"{paper:#.3g}"
        line[0].annotate(f"paper {text}", (0.0, 1.02), xycoords="axes fraction", color=PAPER_COLOUR, fontsize=8.5)
        line[0].set_ylabel("amplitude [°]")
    for ax, tilt in zip(axes[0], tilts):
        ax.set_title(f"tilt {tilt:g}°", pad=16)
    for ax in axes[-1]:
        ax.set_xlabel("mean pitch [°]")
    path = folder / f"map_{kind}.png"
    save(figure, path)
    return path


def all_maps(found, folder):
    """[(heading, caption, path)]; nothing before a point has both wings."""
    if not complete(found):
        return []
    folder.mkdir(parents=True, exist_ok=True)
    legend = (" Orange line, and mark on the colour bar: the paper's value (linear between the points). Black frame: the shipped "
              "kinematics; dotted orange frame: the point nearest to the paper.")
    grid = f"{found['points_along_x']} points, beat {found['beats']}."
    made = [("What bending changes", f"Flexible against rigid wings, {grid} Blue: bending raises the ratio; dashed: no change." + legend,
             maps(found, "change", folder))]
    assert set(CHANGE_LABELS) == set(CHANGES)
    for kind in (RIGID, FLEXIBLE):
        made.append((f"{kind.capitalize()} wings", f"Both wings together, {grid}" + legend, maps(found, kind, folder)))
    return made
