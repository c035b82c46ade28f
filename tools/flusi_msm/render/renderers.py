# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws triangulated surfaces in perspective: with PyVista if this works, else with numpy alone. Both take the same surfaces and
camera and return colours and coverage, (height, width, 4) of 0 to 1."""
from __future__ import annotations

import os
import subprocess
import sys
from collections import namedtuple
from collections.abc import Sequence
from typing import Callable

import numpy as np

from flusi_msm.results.files import InputError

# points (n, 3), triangles (m, 3), normals (n, 3); opacity 1 is solid
Surface = namedtuple("Surface", "points triangles normals colour opacity")

FIELD_OF_VIEW = 25.0  # degrees, of the height
AMBIENT, DIFFUSE = 0.5, 0.5


class Camera:
    """A camera that looks at `points` from a direction (azimuth from x toward y, elevation from the plane of x and y; degrees).
    Its distance is such that all of them fill a picture with the ratio of width over height."""

    def __init__(self, azimuth: float, elevation: float, points: np.ndarray, aspect: float) -> None:
        a, e = np.radians([azimuth, np.clip(elevation, -89.99, 89.99)])
        self.backward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        self.right = np.array([-np.sin(a), np.cos(a), 0.0])
        self.up = np.cross(self.backward, self.right)
        self.aspect = aspect
        self.slope = np.tan(np.radians(FIELD_OF_VIEW / 2))
        self.focus = (points.min(axis=0) + points.max(axis=0)) / 2
        self.distance = 1.0
        for _ in range(4):  # centring and distance depend on each other weakly
            x, y, depth = ((points - self.focus) @ axis for axis in (self.right, self.up, self.backward))
            self.distance = 1.04 * np.max(depth + np.maximum(np.abs(y), np.abs(x) / aspect) / self.slope)
            scale = 1 / (self.distance - depth)
            for axis, place in ((self.right, x * scale), (self.up, y * scale)):
                self.focus = self.focus + axis * (place.min() + place.max()) / 2 * self.distance

    @property
    def position(self) -> np.ndarray:
        """Returns the place of the camera."""
        return self.focus + self.distance * self.backward

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns (x, y) in the picture, y from -1 to 1, x from -aspect to aspect; and the distance along the view."""
        seen = points - self.position
        depth = -(seen @ self.backward)
        scale = 1 / (self.slope * np.maximum(depth, 1e-9 * self.distance))
        return np.stack([seen @ self.right * scale, seen @ self.up * scale], axis=-1), depth

    def light(self) -> np.ndarray:
        """Returns the direction to the light: from above the left shoulder."""
        direction = self.backward - 0.5 * self.right + 0.6 * self.up
        return direction / np.linalg.norm(direction)


def shaded(surface: Surface, camera: Camera) -> np.ndarray:
    """Returns the colours (n, 3) of the points of a surface that is bright on both sides."""
    bright = AMBIENT + DIFFUSE * np.abs(surface.normals @ camera.light())
    return np.clip(np.asarray(surface.colour) * bright[:, None], 0, 1)


def merged(surfaces: Sequence[Surface], camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns several surfaces as one: (points, triangles, colours with opacity of the points)."""
    first = np.cumsum([0] + [len(s.points) for s in surfaces])
    return (np.concatenate([s.points for s in surfaces]),
            np.concatenate([s.triangles + n for s, n in zip(surfaces, first)]),
            np.concatenate([np.column_stack([shaded(s, camera), np.full(len(s.points), s.opacity)]) for s in surfaces]))


# ---- numpy ---------------------------------------------------------------------------------------

MOST_FRAGMENTS = 1_000_000  # candidates at a time
EDGES = ((1, 2), (2, 0), (0, 1))  # each opposite to its corner


def render_numpy(surfaces: Sequence[Surface], camera: Camera, height: int) -> np.ndarray:
    """Draws with exact transparency: all layers of each pixel are found and blended from far to near. The picture is computed
    with twice the resolution and averaged."""
    fine = 2
    rows, columns = fine * height, fine * int(round(camera.aspect * height))
    image = np.zeros((rows * columns, 4))
    if surfaces:
        points, triangles, colours = merged(surfaces, camera)
        pixel, depth, corners, weights = fragments(points, triangles, camera, rows, columns)
        # The nearest comes first in each pixel: one sort of both in one number.
        nearness = (depth - depth.min(initial=np.inf)) / max(np.ptp(depth) if len(depth) else 0.0, 1e-300)
        order = np.argsort(pixel * 2**36 + (nearness * (2**36 - 1)).astype(np.int64))
        pixel, corners, weights = pixel[order], corners[:, order], weights[:, order]
        number = np.arange(len(pixel))
        layer = number - np.maximum.accumulate(np.where(np.diff(pixel, prepend=-1) > 0, number, 0))
        by_layer = np.argsort(layer, kind="stable")
        ends = np.searchsorted(layer[by_layer], np.arange(layer.max(initial=-1) + 2))
        for begin, end in zip(ends[-2::-1], ends[:0:-1]):
            chosen = by_layer[begin:end]
            colour = sum(weights[c, chosen, None] * colours[corners[c, chosen]] for c in range(3))
            alpha = colour[:, 3:]
            below = image[pixel[chosen]]
            image[pixel[chosen]] = np.column_stack([alpha * colour[:, :3] + (1 - alpha) * below[:, :3],
                                                    alpha + (1 - alpha) * below[:, 3:]])
    image = image.reshape(height, fine, columns // fine, fine, 4).mean(axis=(1, 3))
    image[..., :3] /= np.maximum(image[..., 3:], 1e-12)
    return np.clip(image, 0, 1)


def fragments(points: np.ndarray, triangles: np.ndarray, camera: Camera, rows: int, columns: int) -> tuple[np.ndarray, ...]:
    """Returns the pixels whose middle a triangle covers: number of the pixel, depth, the points (3, m) of the triangle and their
    weights (3, m)."""
    place, depth = camera.project(points)
    x = (place[:, 0] / camera.aspect + 1) / 2 * columns - 0.5
    y = (1 - place[:, 1]) / 2 * rows - 0.5
    corners = triangles.T.copy()
    a, b, c = corners
    clockwise = (x[b] - x[a]) * (y[c] - y[a]) < (x[c] - x[a]) * (y[b] - y[a])
    corners[1:, clockwise] = corners[:0:-1, clockwise]
    x, y, depth = x[corners], y[corners], depth[corners]
    # A pixel exactly on an edge belongs to one of the two triangles there.
    takes_edge = [(y[j] < y[i]) | ((y[j] == y[i]) & (x[j] > x[i])) for i, j in EDGES]
    left, right = (np.clip(edge, 0, columns).astype(int) for edge in (np.ceil(x.min(0)), np.floor(x.max(0)) + 1))
    top, bottom = (np.clip(edge, 0, rows).astype(int) for edge in (np.ceil(y.min(0)), np.floor(y.max(0)) + 1))
    width = right - left
    count = np.where(depth.min(0) > 1e-3 * camera.distance, width * (bottom - top), 0)
    total = np.append(0, np.cumsum(count))
    ends = np.searchsorted(total, np.arange(MOST_FRAGMENTS, total[-1] + MOST_FRAGMENTS, MOST_FRAGMENTS), "left")
    ends = np.unique(np.clip(ends, 0, len(count)))
    found = [(np.zeros(0, int), np.zeros(0), np.zeros((3, 0), int), np.zeros((3, 0)))]
    for begin, end in zip(np.append(0, ends[:-1]), ends):
        t = np.repeat(np.arange(begin, end), count[begin:end])
        number = np.arange(len(t)) + total[begin] - total[t]
        row = number // width[t]
        px, py = left[t] + number - row * width[t], top[t] + row
        dx, dy = x[:, t] - px, y[:, t] - py
        parts = [dx[i] * dy[j] - dx[j] * dy[i] for i, j in EDGES]
        inside = np.all([(part > 0) | ((part == 0) & takes[t]) for part, takes in zip(parts, takes_edge)], axis=0)
        t = t[inside]
        # Perspective: what is linear in space is not linear in the picture.
        weights = np.array([part[inside] for part in parts]) / depth[:, t]
        area = sum(part[inside] for part in parts)
        inverse = weights.sum(axis=0)
        good = area > 0
        found.append(((py * columns + px)[inside][good], (area / np.where(good, inverse, 1))[good], corners[:, t[good]],
                      weights[:, good] / inverse[good]))
    return tuple(np.concatenate(part, axis=-1) for part in zip(*found))


# ---- PyVista -------------------------------------------------------------------------------------

PROBE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
plotter.add_mesh(pyvista.Sphere(), color="red")
assert (plotter.screenshot(return_img=True)[32, 32] != 255).any()
"""


def why_no_pyvista() -> str:
    """Returns '' if PyVista can draw here, otherwise the reason. This is tried in a separate process, since without a graphics
    system it can crash."""
    try:
        done = subprocess.run([sys.executable, "-c", PROBE], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              timeout=120, text=True, errors="replace",
                              env={**os.environ, "PYVISTA_OFF_SCREEN": "true"})
    except (OSError, subprocess.TimeoutExpired):
        return "it does not answer"
    if done.returncode == 0:
        return ""
    if "No module named 'pyvista'" in done.stderr:
        return "it is not installed"
    return "it cannot draw off-screen here"


def render_pyvista(surfaces: Sequence[Surface], camera: Camera, height: int) -> np.ndarray:
    """Returns the picture (height, width, 4) that PyVista draws."""
    import pyvista
    import vtk
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_OFF)
    plotter = pyvista.Plotter(off_screen=True, window_size=[int(round(camera.aspect * height)), height])
    plotter.set_background("black")  # type: ignore[arg-type]  # PyVista's decorator hides that it is a method
    for solid in (True, False):
        chosen = [s for s in surfaces if (s.opacity >= 1) == solid and len(s.triangles)]
        if chosen:
            points, triangles, colours = merged(chosen, camera)
            # They are drawn from far to near, because depth peeling fails with some software renderers.
            _, depth = camera.project(points)
            triangles = triangles[np.argsort(-depth[triangles].mean(axis=1), kind="stable")]
            mesh = pyvista.PolyData(points, np.column_stack([np.full(len(triangles), 3), triangles]).ravel())
            mesh.point_data["rgba"] = np.round(255 * colours[:, :3 if solid else 4]).astype("u1")
            plotter.add_mesh(mesh, scalars="rgba", rgb=True, lighting=False)
    plotter.enable_anti_aliasing("ssaa")
    plotter.camera.position, plotter.camera.focal_point = camera.position, camera.focus
    plotter.camera.up, plotter.camera.view_angle = camera.up, FIELD_OF_VIEW
    plotter.reset_camera_clipping_range()
    pixels = np.asarray(plotter.screenshot(return_img=True, transparent_background=True)) / 255
    plotter.close()
    pixels[..., :3] /= np.maximum(pixels[..., 3:], 1 / 255)  # it is already blended with the black background
    return np.clip(pixels, 0, 1)


def choose_renderer(wanted: str) -> tuple[Callable[..., np.ndarray], str]:
    """Returns (function, note which one is used) for auto, pyvista or numpy."""
    if wanted == "numpy":
        return render_numpy, "drawn with numpy"
    reason = why_no_pyvista()
    if not reason:
        return render_pyvista, "drawn with PyVista"
    if wanted == "pyvista":
        raise InputError(f"--with pyvista: {reason} (pip install -r tools/requirements-render.txt)")
    return render_numpy, f"drawn with numpy, as for PyVista {reason}"


if __name__ == "__main__":  # tools/quickstart runs this to see whether the installed packages can draw
    reason = why_no_pyvista()
    sys.exit(f"PyVista: {reason}" if reason else 0)
