# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a plane of a field: by default the vorticity normal to the mid plane, at the last time. With --section it
draws the vorticity along the span of a wing on planes normal to it."""
from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.axes_grid1 import make_axes_locatable

from flusi_msm.errors import InputError, run_command
from flusi_msm.results.files import Field, Snapshot, choose_snapshot, derivative_on_plane, field_path, fields_in, has_field, has_rings, load_field
from flusi_msm.results.flow import vorticity_files
from flusi_msm.results.section import draw_sections, parse_section
from flusi_msm.style import SMOOTHED, name_of, save, use_style

AXES = "xyz"
VELOCITY = ("ux", "uy", "uz")
SYMBOLS = {"vorx": r"$\omega_x$", "vory": r"$\omega_y$", "vorz": r"$\omega_z$", "vorabs": r"$|\omega|$",
           "ux": "$u_x$", "uy": "$u_y$", "uz": "$u_z$", "speed": "$|u|$", "p": "$p$", "mask": r"$\chi$",
           "usx": "$u_{s,x}$", "usy": "$u_{s,y}$", "usz": "$u_{s,z}$"}
COMPONENTS = {"vorx": 0, "vory": 1, "vorz": 2}
COMPUTED = (*COMPONENTS, "vorabs", "speed")  # from the velocity


# ---- what to draw --------------------------------------------------------------------------------

def choose_plane(field: Field, plane: str | None, index: int | None, position: float | None) -> tuple[int, int]:
    """Returns (axis, index) of the plane to draw."""
    axis = AXES.index(plane) if plane else (0 if field.n[0] == 1 else 2)
    n = int(field.n[axis])
    if position is not None:
        index = int(round((position - field.origin[axis]) / field.spacing[axis]))
    elif index is None:
        index = n // 2
    if not 0 <= index < n:
        raise InputError(f"plane {AXES[axis]}, index {index}: outside 0 to {n - 1}")
    return axis, index


def vorticity(snapshot: Snapshot, component: int, axis: int, index: int, smooth: bool = False) -> np.ndarray:
    """Returns a component of curl u on a plane, with the derivatives of the solver."""
    one, two = (component + 1) % 3, (component + 2) % 3
    return (derivative_on_plane(load_field(snapshot, VELOCITY[two], smooth), one, axis, index)
            - derivative_on_plane(load_field(snapshot, VELOCITY[one], smooth), two, axis, index))


def values_on_plane(snapshot: Snapshot, quantity: str, axis: int, index: int, smooth: bool = False) -> np.ndarray:
    """Returns the quantity on the plane, from its file or else computed from the velocity. With `smooth` it is that of means over
    three grid points in each direction."""
    from_parts = smooth and quantity == "vorabs" and vorticity_files(snapshot, smooth) != ("vorabs",)
    if has_field(snapshot, quantity) and not from_parts:
        return load_field(snapshot, quantity, smooth).plane(axis, index)
    if quantity not in COMPUTED:
        have = ", ".join(sorted(fields_in(snapshot.folder)[snapshot.label]))
        raise InputError(f"no file {field_path(snapshot, quantity)}; at this time there is {have}")
    if quantity == "vorabs":
        parts = [values_on_plane(snapshot, f"vor{c}", axis, index, smooth) for c in AXES]
        return np.sqrt(sum(part**2 for part in parts))
    lacking = [u for u in VELOCITY if not has_field(snapshot, u)
               and not (quantity in COMPONENTS and u == VELOCITY[COMPONENTS[quantity]])]
    if lacking:
        raise InputError(f"{quantity} needs {field_path(snapshot, quantity)} or the velocity; "
                         f"missing: {', '.join(lacking)}")
    if quantity == "speed":
        return np.sqrt(sum(load_field(snapshot, u).plane(axis, index)**2 for u in VELOCITY))
    return vorticity(snapshot, COMPONENTS[quantity], axis, index, smooth)


def colour_range(values: np.ndarray, outside: np.ndarray, quantity: str, limit: float | None) -> tuple[str, float, float]:
    """Returns (colour map, lowest, highest): robust against a few extreme points, symmetric if signed."""
    sample = values[outside & np.isfinite(values)]
    if sample.size == 0:
        raise InputError(f"{quantity}: no finite value on this plane")
    low, high = np.percentile(sample, [0.5, 99.5])
    if quantity in ("vorabs", "speed", "mask"):
        return "viridis", 0.0, limit or (1.0 if quantity == "mask" else high or 1.0)
    if quantity.startswith("vor") or low < 0 < high:
        largest = limit or max(abs(low), abs(high)) or np.max(np.abs(sample)) or 1.0
        return "RdBu_r", -largest, largest
    if high == low:
        low, high = low - 0.5, high + 0.5
    return "viridis", low, high


# ---- drawing -------------------------------------------------------------------------------------

def draw(snapshot: Snapshot, quantity: str | None, plane: str | None, index: int | None, position: float | None, limit: float | None,
         out: str | Path | None, stored: bool = False) -> None:
    """Draws a quantity on a plane; the vorticity without the rings about wings without thickness unless it is to be drawn as it is
    stored."""
    labels = fields_in(snapshot.folder)[snapshot.label]
    reference = load_field(snapshot, quantity if quantity in labels else sorted(labels)[0])
    is_middle = index is None and position is None
    axis, index = choose_plane(reference, plane, index, position)
    quantity = quantity or f"vor{AXES[axis]}"
    smooth = not stored and quantity in (*COMPONENTS, "vorabs") and has_rings(snapshot)
    values = values_on_plane(snapshot, quantity, axis, index, smooth)
    mask = load_field(snapshot, "mask").plane(axis, index) if has_field(snapshot, "mask") else np.zeros_like(values)
    if mask.shape != values.shape:
        mask = np.zeros_like(values)
    right, up = [a for a in range(3) if a != axis]
    if min(values.shape) < 2:
        raise InputError(f"the plane normal to {AXES[axis]} has only {values.shape[1]} x {values.shape[0]} points")

    colours, low, high = colour_range(values, mask < 0.5, quantity, limit)
    length, origin, h = reference.length, reference.origin, reference.spacing
    edges = [origin[right] - h[right] / 2, origin[right] + length[right] - h[right] / 2,
             origin[up] - h[up] / 2, origin[up] + length[up] - h[up] / 2]
    use_style()
    width, height = picture_size(length[up] / length[right])
    figure, ax = plt.subplots(figsize=(width, height))
    image = ax.imshow(values, origin="lower", extent=edges, cmap=colours, vmin=low, vmax=high,
                      aspect="equal", interpolation="bilinear")
    if mask.max() >= 0.5 and quantity != "mask":
        points = [origin[a] + h[a] * np.arange(reference.n[a]) for a in (right, up)]
        if mask.min() < 0.5:
            ax.contourf(*points, mask, levels=[0.5, np.inf], colors=["0.85"])
            ax.contour(*points, mask, levels=[0.5], colors=["0.15"], linewidths=0.9)
    for spine in ax.spines.values():
        spine.set_visible(True)
    ax.set_xlabel(f"${AXES[right]}$")
    ax.set_ylabel(f"${AXES[up]}$")
    ax.set_title(title(reference, axis, index) + (f",  {SMOOTHED}" if smooth else ""), loc="left")
    bar = figure.colorbar(image, cax=make_axes_locatable(ax).append_axes("right", size=0.12, pad=0.08),
                          extend=extent_of(values[mask < 0.5], low, high))
    bar.set_label(SYMBOLS.get(quantity, quantity))
    bar.outline.set_linewidth(0.6)
    name = name_of(quantity, snapshot.label, AXES[axis], "" if is_middle else index)
    save(figure, out or snapshot.folder / f"{name}.png")


def picture_size(ratio: float) -> tuple[float, float]:
    """Returns the size of a figure in inches, for a domain with this ratio of height to width."""
    width = min(6.4, max(3.6, 5.2 / max(ratio, 1e-3)))
    return width, min(9.0, max(1.8, 0.85 * width * ratio + 0.7))


def extent_of(values: np.ndarray, low: float, high: float) -> str:
    """Returns at which ends values go beyond the colour scale."""
    below, above = bool(np.nanmin(values) < low), bool(np.nanmax(values) > high)
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")


def title(field: Field, axis: int, index: int) -> str:
    """Returns the title: time, place, viscosity, grid."""
    place = field.origin[axis] + index * field.spacing[axis]
    parts = [f"$t = {field.time:.4g}$"] if np.isfinite(field.time) else []
    if field.n[axis] > 1:
        parts.append(f"${AXES[axis]} = {place:.4g}$")
    if np.isfinite(field.viscosity):
        parts.append(rf"$\nu = {field.viscosity:.4g}$")
    parts.append(r" $\times$ ".join(str(n) for n in field.n if n > 1) + " points")
    return ",  ".join(parts)


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sources", nargs="+", metavar="DIR|FILE", help="folder of a run, or field files")
    parser.add_argument("--time", type=float, help="the snapshot nearest to this time")
    parser.add_argument("--label", help="the snapshot of this label, like 000500")
    parser.add_argument("--quantity", help="ux uy uz p mask vorx vory vorz vorabs speed or any stored prefix")
    parser.add_argument("--plane", choices=list(AXES), help="normal of the plane (default z; x if nx = 1)")
    parser.add_argument("--index", type=int, help="number of the plane, from 0 (default: the middle)")
    parser.add_argument("--position", type=float, help="coordinate of the plane instead of its number")
    parser.add_argument("--section", nargs="+", metavar=("SIDE", "FRACTION"), help="spanwise vorticity around the left "
                        "or right wing at fractions of its span (default 0.25 0.5 0.75)")
    parser.add_argument("--limit", type=float, help="end of the colour scale")
    parser.add_argument("--stored", action="store_true", help="draw the vorticity about wings without thickness as it is stored, with "
                        "the rings of the truncation (default: means over three grid points in each direction, which have none)")
    parser.add_argument("-o", "--output", help="picture to write (default: beside the data)")
    a = parser.parse_args()
    if a.output and len(a.sources) > 1:
        raise InputError("-o takes one DIR or FILE; each source gives a picture of its own")
    if a.label is not None and not a.label.isdigit():
        raise InputError(f"--label takes digits like 000500, not '{a.label}'")
    if a.limit is not None and a.limit <= 0:
        raise InputError("--limit must be positive")
    section = parse_section(a.section) if a.section else None
    if section and (a.quantity or a.plane or a.index is not None or a.position is not None):
        raise InputError("--section has a plane and a quantity of its own: leave out --quantity, --plane, --index, "
                         "--position")
    for source in map(Path, a.sources):
        if source.is_dir():
            snapshot, quantity = choose_snapshot(source, a.time, a.label), a.quantity
        else:
            field = Field(source)
            snapshot, quantity = Snapshot(source.parent, field.label), a.quantity or field.name
        if section:
            draw_sections(snapshot, *section, a.limit, a.output, a.stored)
            continue
        draw(snapshot, quantity, a.plane, a.index, a.position, a.limit, a.output, a.stored)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_slice", main)
