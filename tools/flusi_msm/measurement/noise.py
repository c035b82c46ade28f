# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes errors of synthetic measurements: of heights, forces, places and whole scans. Every kind of error of every load has its
own random stream, so that adding one does not change the others."""
from __future__ import annotations

from dataclasses import dataclass
from zlib import crc32

import numpy as np

from flusi_msm.results.files import InputError


@dataclass
class Noise:
    """Standard deviations [SI] and fractions; 0 means that there is no such error."""
    height: float = 10e-6            # white, independent at every grid point
    correlated: float = 0.0          # smooth, with the correlation exp(-(r/length)^2/2)
    correlation_length: float = 1e-3
    missing: float = 0.0             # fraction of the measured points that is lost, in discs
    patch: float = 5e-4              # [m] radius of these discs
    outliers: float = 0.0            # fraction of points with an error of Student's t (3 degrees of freedom)
    outlier_scale: float = 1e-4      # [m] its scale
    tilt: float = 0.0                # [rad] of each scan, about x and about y
    piston: float = 0.0              # [m] of each scan
    shift: float = 0.0               # [m] of each scan in x and y
    force: float = 0.0               # [N] of each force
    force_gain: float = 0.0          # relative, the same for all forces
    position: float = 0.0            # [m] of x and y of each point of application
    reference_scans: int = 1         # of the unloaded wing, averaged


def check_noise(noise: Noise) -> None:
    """Raises an InputError for values that make no sense."""
    for name, value in vars(noise).items():
        if not value >= 0:
            raise InputError(f"noise.{name} = {value}: must not be negative")
    for name in ("missing", "outliers"):
        if getattr(noise, name) > 0.9:
            raise InputError(f"noise.{name} = {getattr(noise, name)}: a fraction of at most 0.9")
    for name in ("correlation_length", "patch"):
        if not getattr(noise, name) > 0:
            raise InputError(f"noise.{name}: must be positive")
    if noise.reference_scans < 1:
        raise InputError("noise.reference_scans: at least 1")


class Streams:
    """Random streams by the name of the error and the number of the scan (0: the unloaded wing)."""

    def __init__(self, seed: int) -> None:
        self.seed = int(seed)

    def __call__(self, name: str, scan: int = 0) -> np.random.Generator:
        return np.random.default_rng([self.seed, crc32(name.encode()), scan])


def square_root(points: np.ndarray, length: float) -> np.ndarray:
    """Returns a matrix S with S S^T = exp(-((p_i - p_j)/length)^2/2)."""
    values, vectors = np.linalg.eigh(np.exp(-0.5 * ((points[:, None] - points[None, :]) / length)**2))
    return vectors * np.sqrt(np.maximum(values, 0))


class HeightErrors:
    """Errors of height maps on a grid x (nx), y (ny)."""

    def __init__(self, noise: Noise, x: np.ndarray, y: np.ndarray, streams: Streams) -> None:
        self.noise, self.x, self.y, self.streams = noise, x, y, streams
        self.shape = len(y), len(x)
        if noise.correlated > 0:  # the correlation is a product of one in x and one in y
            self.root_x, self.root_y = square_root(x, noise.correlation_length), square_root(y,
                                                                                             noise.correlation_length)

    def one_scan(self, scan: int) -> np.ndarray:
        """Returns white and correlated errors (ny, nx) [m]; scans of the unloaded wing have negative numbers."""
        index = 2 * scan if scan >= 0 else -2 * scan + 1
        error = self.noise.height * self.streams("height", index).standard_normal(self.shape)
        if self.noise.correlated > 0:
            field = self.streams("correlated", index).standard_normal(self.shape)
            error += self.noise.correlated * (self.root_y @ field @ self.root_x.T)
        return error

    def reference(self) -> np.ndarray:
        """Returns errors of the unloaded heights, the mean of several scans."""
        n = self.noise.reference_scans
        return sum((self.one_scan(-k - 1) for k in range(n)), np.zeros(self.shape)) / n

    def outliers(self, scan: int) -> np.ndarray:
        """Returns the errors of outliers (ny, nx) [m] of a scan."""
        rng = self.streams("outliers", scan)
        hit = rng.random(self.shape) < self.noise.outliers
        return hit * self.noise.outlier_scale * rng.standard_t(3, self.shape)

    def missing(self, scan: int, known: np.ndarray) -> np.ndarray:
        """Returns the grid points (ny, nx) that are lost: whole discs, until the fraction of the `known` points is reached."""
        lost = np.zeros(self.shape, bool)
        wanted = self.noise.missing * known.sum()
        if wanted == 0:
            return lost
        rng = self.streams("missing", scan)
        places = np.argwhere(known)
        while (lost & known).sum() < wanted:
            j, i = places[rng.integers(len(places))]
            radius = self.noise.patch * rng.uniform(0.3, 1.0)
            lost |= (self.x[None, :] - self.x[i])**2 + (self.y[:, None] - self.y[j])**2 <= radius**2
        return lost

    def plane(self, scan: int) -> tuple[np.ndarray, float]:
        """Returns tilt about x and y [rad] and piston [m] of a scan."""
        rng = self.streams("tilt", scan)
        return self.noise.tilt * rng.standard_normal(2), self.noise.piston * self.streams("piston",
                                                                                          scan).standard_normal()

    def shift(self, scan: int) -> np.ndarray:
        """Returns the shift (2) [m] of a scan."""
        return self.noise.shift * self.streams("shift", scan).standard_normal(2)
