# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangulated surfaces in perspective: with PyVista where it works, else with matplotlib alone (polygons from far to
near). Both take the same surfaces and camera and return the picture as an array (height, width, 3) of 0 to 1."""
import os
import subprocess
import sys
from collections import namedtuple

import numpy as np

from _flusi_io import InputError

# points (n, 3), triangles (m, 3), normals (n, 3); opacity 1 is solid
Surface = namedtuple("Surface", "points triangles normals colour opacity")

FIELD_OF_VIEW = 25.0  # degrees, of the height
AMBIENT, DIFFUSE = 0.5, 0.5


class Camera:
    """Looks from a direction (azimuth from x toward y, elevation from the plane of x and y; degrees) at `points`,
    from where all of them fill a picture of that width over height."""

    def __init__(self, azimuth, elevation, points, aspect):
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
    def position(self):
        return self.focus + self.distance * self.backward

    def project(self, points):
        """(x, y) in the picture, y from -1 to 1, x from -aspect to aspect; and the distance along the view."""
        seen = points - self.position
        depth = -(seen @ self.backward)
        scale = 1 / (self.slope * np.maximum(depth, 1e-9 * self.distance))
        return np.stack([seen @ self.right * scale, seen @ self.up * scale], axis=-1), depth

    def light(self):
        """Direction to the light: from above the left shoulder."""
        direction = self.backward - 0.5 * self.right + 0.6 * self.up
        return direction / np.linalg.norm(direction)


def shaded(surface, camera):
    """Colours (n, 3) of the points of a surface that is bright on both sides."""
    bright = AMBIENT + DIFFUSE * np.abs(surface.normals @ camera.light())
    return np.clip(np.asarray(surface.colour) * bright[:, None], 0, 1)


def merged(surfaces, camera):
    """(points, triangles from far to near, colours with opacity of the points) of several surfaces in one."""
    first = np.cumsum([0] + [len(s.points) for s in surfaces])
    points = np.concatenate([s.points for s in surfaces])
    triangles = np.concatenate([s.triangles + n for s, n in zip(surfaces, first)])
    colours = np.concatenate([np.column_stack([shaded(s, camera), np.full(len(s.points), s.opacity)])
                              for s in surfaces])
    _, depth = camera.project(points)
    return points, triangles[np.argsort(-depth[triangles].mean(axis=1), kind="stable")], colours


# ---- matplotlib ----------------------------------------------------------------------------------

def render_matplotlib(surfaces, lines, camera, height):
    """`lines`: segments (k, 2, 3) behind everything."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.figure import Figure
    fine = 2  # drawn finer and averaged: polygons smoothed one by one would show their edges
    figure = Figure(figsize=(camera.aspect * height / 100, height / 100), dpi=100 * fine)
    canvas = FigureCanvasAgg(figure)
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set(xlim=(-camera.aspect, camera.aspect), ylim=(-1, 1))
    ax.axis("off")
    ax.add_collection(LineCollection(camera.project(lines)[0], colors="0.8", linewidths=0.8))
    if surfaces:
        points, triangles, colours = merged(surfaces, camera)
        place, _ = camera.project(points)
        ax.add_collection(PolyCollection(place[triangles], facecolors=colours[triangles].mean(axis=1),
                                         edgecolors="none", antialiased=False))
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., :3].astype(float) / 255
    rows, columns = (size // fine * fine for size in pixels.shape[:2])
    return pixels[:rows, :columns].reshape(rows // fine, fine, columns // fine, fine, 3).mean(axis=(1, 3))


# ---- PyVista -------------------------------------------------------------------------------------

PROBE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
plotter.add_mesh(pyvista.Sphere(), color="red")
assert (plotter.screenshot(return_img=True)[32, 32] != 255).any()
"""


def why_no_pyvista():
    """'' if PyVista can draw here. Tried in a process of its own: without a graphics system it can crash."""
    try:
        done = subprocess.run([sys.executable, "-c", PROBE], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              timeout=120, text=True, errors="replace", env={**os.environ, "PYVISTA_OFF_SCREEN": "true"})
    except (OSError, subprocess.TimeoutExpired):
        return "it does not answer"
    if done.returncode == 0:
        return ""
    if "No module named 'pyvista'" in done.stderr:
        return "it is not installed"
    return "it cannot draw off-screen here"


def render_pyvista(surfaces, lines, camera, height):
    import pyvista
    import vtk
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_OFF)
    plotter = pyvista.Plotter(off_screen=True, window_size=(int(round(camera.aspect * height)), height))
    plotter.set_background("white")
    if len(lines):
        plotter.add_mesh(pyvista.line_segments_from_points(lines.reshape(-1, 3)), color=(0.8, 0.8, 0.8), line_width=1.5,
                         lighting=False)
    for solid in (True, False):
        chosen = [s for s in surfaces if (s.opacity >= 1) == solid and len(s.triangles)]
        if chosen:
            # Sorted here, for transparency does not work with every software renderer's depth peeling.
            points, triangles, colours = merged(chosen, camera)
            mesh = pyvista.PolyData(points, np.column_stack([np.full(len(triangles), 3), triangles]).ravel())
            mesh.point_data["rgba"] = np.round(255 * colours[:, :3 if solid else 4]).astype("u1")
            plotter.add_mesh(mesh, scalars="rgba", rgb=True, lighting=False)
    plotter.enable_anti_aliasing("ssaa")
    plotter.camera.position, plotter.camera.focal_point = camera.position, camera.focus
    plotter.camera.up, plotter.camera.view_angle = camera.up, FIELD_OF_VIEW
    plotter.reset_camera_clipping_range()
    pixels = plotter.screenshot(return_img=True)[..., :3] / 255
    plotter.close()
    return pixels


def choose_renderer(wanted):
    """(function, note what is used) for auto, pyvista or matplotlib."""
    if wanted == "matplotlib":
        return render_matplotlib, "drawn with matplotlib"
    reason = why_no_pyvista()
    if not reason:
        return render_pyvista, "drawn with PyVista"
    if wanted == "pyvista":
        raise InputError(f"--with pyvista: {reason} (pip install -r tools/requirements-render.txt)")
    return render_matplotlib, f"drawn with matplotlib; PyVista is smoother, but {reason}"
