# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads wing surfaces that a run writes in addition to its fields: wing_left_<label>.h5, wing_right_<label>.h5.

The wing frame has x from root to tip, y toward the leading edge, z to the lower side of the left wing and to the
upper side of the right one (docs/guide/kinematics.md)."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from flusi_msm.results.files import InputError, Snapshot

SIDES = ("left", "right")
UPPER_SIDE = {"left": -1, "right": 1}  # sign of z there


class WingSurface:
    """points (n, 3) in space; triangles (m, 3) of point numbers from 0; hinge (3); the rows of
    matrix (3, 3) are the axes of the wing frame in space, axis_x, axis_y and axis_z of the file. rigid_points (n, 3)
    are those of its rigid twin, or None of a rigid wing."""

    def __init__(self, path: Path, side: str) -> None:
        import h5py
        self.path, self.side = path, side
        try:
            with h5py.File(path, "r") as file:
                self.points = file["points"][...].astype(float)
                self.triangles = file["triangles"][...].astype(int)
                self.rigid_points = self.points - file["displacement"][...] if "displacement" in file else None
                self.time = float(np.ravel(file.attrs["time"])[0])
                self.hinge = np.ravel(file.attrs["hinge"]).astype(float)
                self.matrix = np.array([np.ravel(file.attrs[f"axis_{c}"]) for c in "xyz"], dtype=float)
        except OSError:
            reason = "not a readable HDF5 file" if path.exists() else "no such file"
            raise InputError(f"{path}: {reason}") from None
        except (KeyError, ValueError, IndexError) as error:
            raise InputError(f"{path}: not a wing surface: {str(error).strip(chr(39))}") from None
        if self.hinge.shape != (3,) or self.matrix.shape != (3, 3):
            raise InputError(f"{path}: the attributes hinge, axis_x, axis_y and axis_z must have three numbers each")
        if (self.points.ndim != 2 or self.points.shape[1] != 3 or len(self.points) < 3 or self.triangles.ndim != 2
                or self.triangles.shape[1] != 3):
            raise InputError(f"{path}: points must be (n, 3) and triangles (m, 3)")
        if self.triangles.min(initial=0) < 0 or self.triangles.max(initial=0) >= len(self.points):
            raise InputError(f"{path}: a triangle names a point that is not there")

    def in_wing_frame(self, points: np.ndarray | None = None) -> np.ndarray:
        """Returns points in the frame of the wing."""
        return ((self.points if points is None else points) - self.hinge) @ self.matrix.T

    def in_space(self, points: np.ndarray) -> np.ndarray:
        """Returns points in space."""
        return np.asarray(points) @ self.matrix + self.hinge

    def length(self) -> float:
        """Returns the length from the hinge to the outermost point along the span."""
        return self.in_wing_frame()[:, 0].max()

    def cut(self, x: float, points: np.ndarray | None = None) -> np.ndarray:
        """Returns the cut of the wing, or of its rigid twin if `points` are rigid_points, with the plane normal to the span at
        x: segments (k, 2, 2) of ends (y, z)."""
        corners = self.in_wing_frame(points)[self.triangles]
        height = corners[:, :, 0] - x
        height[height == 0] = 1e-12 * max(self.length(), 1e-300)  # a corner in the plane counts as outboard
        segments = np.full((len(corners), 3, 2), np.nan)
        for i in range(3):
            j = (i + 1) % 3
            crossed = height[:, i] * height[:, j] < 0
            s = (height[crossed, i] / (height[crossed, i] - height[crossed, j]))[:, None]
            segments[crossed, i] = (1 - s) * corners[crossed, i, 1:] + s * corners[crossed, j, 1:]
        hit = np.isfinite(segments[:, :, 0])
        through = hit.sum(axis=1) == 2
        return segments[through][hit[through]].reshape(-1, 2, 2)


def load_body(snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray] | None:
    """Returns (points (n, 3), triangles (m, 3)) of body_<label>.h5, the surface of a body, or None if there is none."""
    import h5py
    path = snapshot.folder / f"body_{snapshot.label}.h5"
    if not path.is_file():
        return None
    try:
        with h5py.File(path, "r") as file:
            points, triangles = file["points"][...].astype(float), file["triangles"][...].astype(int)
    except (OSError, KeyError, ValueError) as error:
        raise InputError(f"{path}: not the surface of a body: {str(error).strip(chr(39))}") from None
    if points.ndim != 2 or triangles.ndim != 2 or points.shape[1] != 3 or triangles.shape[1] != 3 or \
            triangles.min(initial=0) < 0 or triangles.max(initial=0) >= len(points):
        raise InputError(f"{path}: not the surface of a body: points must be (n, 3) and triangles (m, 3) of them")
    return points, triangles


def surface_path(snapshot: Snapshot, side: str) -> Path:
    """Returns the path of the surface of a wing."""
    return snapshot.folder / f"wing_{side}_{snapshot.label}.h5"


def load_surface(snapshot: Snapshot, side: str) -> WingSurface:
    """Reads the surface of a wing."""
    return WingSurface(surface_path(snapshot, side), side)


def surfaces_of(snapshot: Snapshot) -> list[WingSurface]:
    """Returns the surfaces that exist."""
    return [load_surface(snapshot, side) for side in SIDES if surface_path(snapshot, side).is_file()]
