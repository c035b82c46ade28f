# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the wings and iso-surfaces of the magnitude of the vorticity in perspective: of the last snapshot of a run, of
the one nearest to a time, or of all. Uses vorabs, or else vorx, vory, vorz, or else the velocity; wings and body are those
of wing_left_<label>.h5, wing_right_<label>.h5 and body_<label>.h5, or else the surface of the mask. Over a flexible wing its rigid twin is
drawn, where the wing would be if it did not bend; --wings draws wings and twins without vortices."""
from __future__ import annotations

import argparse
import io
import sys
import tempfile
from collections.abc import Sequence
from contextlib import redirect_stdout
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch

from flusi_msm.errors import run_command
from flusi_msm.render.isosurface import iso_surface
from flusi_msm.render.movie import choose_movie, write_movie
from flusi_msm.render.renderers import Camera, Surface, choose_renderer
from flusi_msm.render.wing_surface import load_body, surfaces_of
from flusi_msm.results.files import (
    InputError,
    Snapshot,
    choose_snapshot,
    fields_in,
    has_field,
    has_rings,
    load_field,
    snapshot_times,
)
from flusi_msm.results.flow import VELOCITY, VORTICITY, every, vorticity_files, vorticity_magnitude
from flusi_msm.style import SMOOTHED, name_of, save, use_style

LEVELS = (100.0, 150.0, 200.0)  # of the paper, in units of the wing beat frequency
COLOURS = ("#8ec7e8", "#1f4e9e", "#d7301f")  # light blue, dark blue, red
OPACITIES = (0.2, 0.3, 1.0)
WING = "#c9b48a"
BODY = "#7a6a55"
TWIN, TWIN_OPACITY = "#0072B2", 0.35  # the rigid twin of a flexible wing
VIEWS = {"perspective": (-125.0, 35.0), "top": (-90.0, 90.0), "side": (-90.0, 0.0), "front": (180.0, 0.0),
         "behind": (0.0, 20.0)}
ASPECT = 4 / 3
MOST_CELLS = 2e7  # of a field that is drawn with all its points


# ---- what to show --------------------------------------------------------------------------------

def round_two(value: float) -> float:
    """Rounds to two significant digits."""
    return float(f"{value:.1e}")


def choose_levels(values: np.ndarray, fluid: np.ndarray, frequency: float) -> tuple[float, ...]:
    """Returns the levels of the paper if enough of the flow reaches them, else three levels of the same proportions, the highest
    of which encloses a thousandth of the fluid."""
    high = float(np.quantile(values[fluid], 0.999)) if fluid.any() else 0.0
    if high >= LEVELS[-1] * frequency:
        return tuple(level * frequency for level in LEVELS)
    if not high > 0:
        raise InputError("the vorticity vanishes or is not finite; nothing to draw")
    return tuple(round_two(level / LEVELS[-1] * high) for level in LEVELS)


def colours_of(n: int) -> tuple[Sequence[str | tuple[float, ...]], Sequence[float]]:
    """Returns (colours, opacities) of n levels, the lowest first."""
    if n == 1:
        return COLOURS[1:2], (0.8,)
    if n == 3:
        return COLOURS, OPACITIES
    x = np.linspace(0, 2, n)
    rgb = np.array([to_rgb(colour) for colour in COLOURS])
    return ([tuple(np.interp(x_i, (0, 1, 2), rgb[:, c]) for c in range(3)) for x_i in x],
            tuple(np.interp(x, (0, 1, 2), OPACITIES)))


def vertex_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Returns unit normals at the points of a surface."""
    a, b, c = (points[triangles[:, n]] for n in range(3))
    face = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for n in range(3):
        np.add.at(normals, triangles[:, n], face)
    return normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]


class Scene:
    """Fields and wings of one snapshot, at every `stride`-th point of the grid."""

    def __init__(self, snapshot: Snapshot, stride: int | None, twins: bool = True, stored: bool = False) -> None:
        self.snapshot = snapshot
        self.smooth = has_rings(snapshot) and not stored
        field = load_field(snapshot, vorticity_files(snapshot, self.smooth)[0])
        self.stride = stride or max(1, int(np.ceil((field.data.size / MOST_CELLS)**(1 / 3))))
        self.values = vorticity_magnitude(snapshot, self.stride, self.smooth)
        self.origin, self.spacing, self.length = field.origin, field.spacing * self.stride, field.length
        self.time = field.time
        self.mask = None
        if has_field(snapshot, "mask"):
            mask = every(load_field(snapshot, "mask"), self.stride)
            self.mask = mask if mask.shape == self.values.shape else None
        self.wings = [(wing.points, wing.triangles, vertex_normals(wing.points, wing.triangles))
                      for wing in surfaces_of(snapshot)]
        self.twins = [(wing.rigid_points, wing.triangles, vertex_normals(wing.rigid_points, wing.triangles))
                      for wing in surfaces_of(snapshot) if twins and wing.rigid_points is not None]
        body = load_body(snapshot)
        self.body = [] if body is None else [(*body, vertex_normals(*body))]
        if not self.wings and not self.body and self.mask is not None:
            self.wings = [iso_surface(self.mask, 0.5, self.origin, self.spacing)]

    def fluid(self) -> np.ndarray:
        """Returns which points are in the fluid."""
        return np.isfinite(self.values) if self.mask is None else np.isfinite(self.values) & (self.mask < 0.01)

    def surfaces(self, levels: Sequence[float]) -> list[Surface]:
        """Returns everything that is drawn, with iso-surfaces of these levels."""
        found = [Surface(*wing, to_rgb(WING), 1.0) for wing in self.wings]
        found += [Surface(*body, to_rgb(BODY), 1.0) for body in self.body]
        found += [Surface(*twin, to_rgb(TWIN), TWIN_OPACITY) for twin in self.twins]
        for level, colour, opacity in zip(levels, *colours_of(len(levels))):
            found.append(Surface(*iso_surface(self.values, level, self.origin, self.spacing), to_rgb(colour), opacity))
        return [surface for surface in found if len(surface.triangles)]

    def box(self) -> np.ndarray:
        """Returns the twelve edges of the box, (12, 2, 3)."""
        corners = np.array(list(np.ndindex(2, 2, 2)), dtype=float)
        pairs = [(a, b) for a in corners for b in corners if b.sum() == a.sum() + 1 and np.abs(a - b).sum() == 1]
        return self.origin + np.array(pairs) * self.length

    def box_behind(self, camera: Camera) -> np.ndarray:
        """Returns the edges of the box, in short pieces (k, 2, 3), except for the three that may cover something."""
        edges = self.box()
        corners = edges.reshape(-1, 3)
        nearest = corners[np.argmin(np.linalg.norm(corners - camera.position, axis=1))]
        edges = edges[~(edges == nearest).all(axis=2).any(axis=1)]
        s = np.linspace(0, 1, 65)[None, :, None]
        points = (1 - s) * edges[:, :1] + s * edges[:, 1:]
        pieces = np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3)
        return pieces[camera.project(pieces)[1].min(axis=1) > 0.05 * camera.distance]


# ---- drawing -------------------------------------------------------------------------------------

def compose(pixels: np.ndarray, scene: Scene, levels: Sequence[float], camera: Camera, out: Path) -> None:
    """Draws the picture with its legend."""
    use_style()
    height, width = pixels.shape[:2]
    dpi = height / 6
    figure = plt.figure(figsize=(width / dpi, 6.35), dpi=dpi)
    ax = figure.add_axes((0, 0, 1, 6 / 6.35))
    ax.set(xlim=(0, width), ylim=(height, 0))
    ax.axis("off")
    lines = camera.project(scene.box_behind(camera))[0] / (camera.aspect, -1)
    ax.add_collection(LineCollection((1 + lines) / 2 * (width, height), colors="0.8", linewidths=0.8, zorder=0))
    ax.imshow(pixels, interpolation="none", aspect="auto", extent=(0, width, height, 0))
    draw_axes(ax, camera, width, height)
    handles = [Patch(facecolor=colour, alpha=0.35 + 0.65 * opacity, label=rf"$|\omega|$ = {level:g}")
               for level, colour, opacity in zip(levels, *colours_of(len(levels)))]
    if scene.wings:
        handles.append(Patch(facecolor=WING, label="wings"))
    if scene.body:
        handles.append(Patch(facecolor=BODY, label="body"))
    if scene.twins:
        handles.append(Patch(facecolor=TWIN, alpha=0.35 + 0.65 * TWIN_OPACITY, label="rigid wings"))
    figure.legend(handles=handles, loc="upper right", ncols=len(handles), borderaxespad=0.3, handlelength=1.2,
                  columnspacing=1.2)
    if np.isfinite(scene.time):
        figure.text(0.01, 0.985, f"$t = {scene.time:.4g}$", va="top")
    matplotlib.rcParams["savefig.dpi"] = dpi
    save(figure, out)


def draw_axes(ax: Axes, camera: Camera, width: float, height: float) -> None:
    """Draws the directions of x, y, z in the lower left corner."""
    centre, size = np.array([0.08 * width, height - 0.08 * width]), 0.045 * width
    for axis, name in enumerate("xyz"):
        direction = np.array([camera.right[axis], -camera.up[axis]])
        if np.linalg.norm(direction) < 0.15:
            continue  # it points toward the viewer
        ax.annotate("", xy=centre + size * direction, xytext=centre,
                    arrowprops={"arrowstyle": "->", "color": "0.3", "shrinkA": 0, "shrinkB": 0, "linewidth": 1.0})
        ax.text(*(centre + 1.35 * size * direction), f"${name}$", ha="center", va="center", color="0.3")


def view_of(text: str) -> tuple[float, float]:
    """Returns (azimuth, elevation) of a name or of '-60,30'."""
    if text in VIEWS:
        return VIEWS[text]
    try:
        azimuth, elevation = (float(word) for word in text.split(","))
    except ValueError:
        raise InputError(f"--view takes {', '.join(VIEWS)} or azimuth,elevation in degrees, not '{text}'") from None
    return azimuth, elevation


def drawable(folder: Path) -> list[str]:
    """Returns labels of the snapshots from which the vorticity is known, in the order of time."""
    times = snapshot_times(folder)
    labels = [label for label, have in fields_in(folder).items()
              if "vorabs" in have or have.issuperset(VORTICITY) or have.issuperset(VELOCITY)]
    if not labels:
        raise InputError(f"{folder}: no snapshot with vorabs, with vorx, vory and vorz or with ux, uy and uz")
    return sorted(labels, key=lambda label: (times[label], int(label)))


def arguments() -> argparse.ArgumentParser:
    """Returns the parser of the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", metavar="DIR", type=Path, help="folder of a run")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=float, help="the snapshot nearest to this time (default: the last)")
    which.add_argument("--label", help="the snapshot of this label, like 000500")
    which.add_argument("--all", action="store_true", help="a picture of every snapshot, with the "
                       "levels of the last and one camera")
    which.add_argument("--movie", action="store_true", help="a movie of every snapshot, as with --all: .mp4 by ffmpeg where it is "
                       "found, else .gif")
    parser.add_argument("--rate", type=float, default=10.0, help="pictures per second of a movie (default 10)")
    parser.add_argument("--levels", help="levels of the vorticity, separated by commas (default: 100,150,200 times the "
                        "frequency where the flow reaches them, else from the data)")
    parser.add_argument("--frequency", type=float, default=1.0, help="wing beats per unit of time of the run "
                        "(default 1)")
    parser.add_argument("--view", default="perspective", help=f"{', '.join(VIEWS)} or azimuth,elevation in degrees: "
                        "--view=-125,35 is perspective")
    parser.add_argument("--stride", type=int, help="use every n-th point of the grid (default: by its size)")
    parser.add_argument("--height", type=int, default=900, help="of the picture in pixels (default 900)")
    parser.add_argument("--wings", action="store_true", help="draw wings and body only")
    parser.add_argument("--no-twin", action="store_true", help="do not draw the rigid twins of flexible wings")
    parser.add_argument("--stored", action="store_true", help="draw the vorticity about wings without thickness as it is stored, with "
                        "the rings of the truncation (default: means over three grid points in each direction, which have none)")
    parser.add_argument("--with", dest="renderer", choices=("auto", "pyvista", "numpy"), default="auto")
    parser.add_argument("-o", "--output", type=Path, help="picture to write, with --all the folder for the pictures, with "
                        "--movie the movie (default: beside the data, render_LABEL.png, with _wings and the view where they were asked "
                        "for; movie.mp4 or movie.gif)")
    return parser


def check_options(a: argparse.Namespace) -> list[float]:
    """Returns the levels that the command line names, in order. Raises InputError if an option is not valid."""
    if a.label is not None and not a.label.isdigit():
        raise InputError(f"--label takes digits like 000500, not '{a.label}'")
    if (a.stride is not None and a.stride < 1) or a.frequency <= 0:
        raise InputError("--stride and --frequency must be positive")
    if not 0 < a.rate <= 100:
        raise InputError("--rate takes up to 100 pictures per second")
    if not 100 <= a.height <= 10000:
        raise InputError("--height takes 100 to 10000 pixels")
    try:
        wanted = sorted(float(word) for word in a.levels.split(",")) if a.levels else []
    except ValueError:
        raise InputError(f"--levels takes numbers like 100,150,200, not '{a.levels}'") from None
    if wanted and wanted[0] <= 0:
        raise InputError("--levels must be positive")
    return wanted


def camera_for(chosen: Sequence[Snapshot], surfaces: Sequence[Surface], view: tuple[float, float], has_twins: bool) -> Camera:
    """Returns the camera that sees these surfaces and wings and bodies of all snapshots."""
    shown = [s.points for s in surfaces] + [wing.points for at in chosen for wing in surfaces_of(at)]
    shown += [wing.rigid_points for at in chosen for wing in surfaces_of(at) if wing.rigid_points is not None and has_twins]
    shown += [body[0] for body in map(load_body, chosen) if body is not None]
    return Camera(*view, np.concatenate(shown), ASPECT)


def main() -> None:
    """Does what the command line asks for."""
    a = arguments().parse_args()
    view = view_of(a.view)
    wanted = check_options(a)
    movie = choose_movie(a.folder, a.output) if a.movie else None
    labels = drawable(a.folder)
    if a.time is None and a.label is None:
        chosen = [Snapshot(a.folder, label) for label in (labels if a.all or a.movie else labels[-1:])]
    else:
        chosen = [choose_snapshot(a.folder, a.time, a.label)]
    last = Scene(chosen[-1], a.stride, not a.no_twin, a.stored)
    levels: Sequence[float] = [] if a.wings else wanted or choose_levels(last.values, last.fluid(), a.frequency)
    surfaces = last.surfaces(levels)
    if not surfaces:
        raise InputError(f"nothing to draw: |omega| is at most {np.nanmax(last.values):.4g} and there are no wings")
    camera = camera_for(chosen, surfaces, view, not a.no_twin)
    render, note = choose_renderer(a.renderer)
    what = f"|omega| = {', '.join(f'{level:g}' for level in levels)} (largest {np.nanmax(last.values):.4g})" \
        + (f", {SMOOTHED}" if last.smooth else "")
    print(("wings only" if a.wings else what) + f"; {note}" + (f"; every {last.stride}. point" if last.stride > 1 else ""))
    if a.all and a.output:
        a.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        drawn = []
        for snapshot in chosen:
            scene = last if snapshot == chosen[-1] else Scene(snapshot, a.stride, not a.no_twin, a.stored)
            name = name_of("render", snapshot.label, "wings" if a.wings else "", a.view if a.view != "perspective" else "") + ".png"
            drawn.append(Path(place) / name if a.movie else
                         (a.output or a.folder) / name if a.all else a.output or a.folder / name)
            with redirect_stdout(io.StringIO() if a.movie else sys.stdout):
                compose(render(scene.surfaces(levels), camera, a.height), scene, levels, camera, drawn[-1])
            if not scene.wings and not scene.body:
                print(f"note: no wing surfaces and no mask at {snapshot.label}", file=sys.stderr)
        if movie:
            write_movie(drawn, movie, a.rate)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("render", main)
