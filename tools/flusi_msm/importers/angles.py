# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts wing angles of other conventions to FLUSI's, and fits periodic functions to them. Degrees.

FLUSI's matrix from the stroke plane to the (left) wing is Ry(alpha) Rz(theta) Rx(phi), all passive (docs/guide/kinematics.md).
"""
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flusi_msm.plots.kinematics import ANGLES, cubic, fourier, rotation

FOURIER, HERMITE = "fourier", "hermite"
MOST_HARMONICS = 12
# How the angles of a convention are converted to FLUSI's: {FLUSI's: (column, factor, offset)}.
CONVENTIONS = {
    "flusi": {"phi": ("phi", 1, 0), "alpha": ("alpha", 1, 0), "theta": ("theta", 1, 0)},
    "SISC": {"phi": ("phi", 1, 0), "alpha": ("alpha", 1, 0), "theta": ("theta", -1, 0)},
    "stroke-dorsal": {"phi": ("stroke", 1, 0), "alpha": ("rotation", -1, 90), "theta": ("deviation", -1, 0)},
    "stroke-ventral": {"phi": ("stroke", -1, 0), "alpha": ("rotation", -1, 90), "theta": ("deviation", -1, 0)},
}
ORDERS = {"phi-theta-alpha": ("phi", "theta", "alpha"), "phi-alpha-theta": ("phi", "alpha", "theta"),
          "theta-phi-alpha": ("theta", "phi", "alpha")}
AXIS = {"phi": 0, "alpha": 1, "theta": 2}


def matrices(angles: dict[str, np.ndarray], order: Iterable[str]) -> np.ndarray:
    """Returns the matrices from the stroke plane to the wing (n, 3, 3), turned by the angles one after another in this order."""
    total = np.eye(3)[None]
    for name in order:
        total = rotation(AXIS[name], angles[name]) @ total
    return total


def flusi_angles(m: np.ndarray) -> dict[str, np.ndarray]:
    """Returns the angles of Ry(alpha) Rz(theta) Rx(phi) = m, theta within 90 degrees, phi and alpha without jumps."""
    theta = -np.arcsin(np.clip(m[:, 1, 0], -1, 1))
    phi = np.arctan2(m[:, 1, 2], m[:, 1, 1])
    turned = m @ np.swapaxes(matrices({"phi": np.degrees(phi), "theta": np.degrees(theta)}, ("phi", "theta")), 1, 2)
    alpha = np.arctan2(-turned[:, 0, 2], turned[:, 0, 0])
    return {"phi": np.degrees(np.unwrap(phi)), "alpha": np.degrees(np.unwrap(alpha)), "theta": np.degrees(theta)}


@dataclass
class Fit:
    """One angle over the cycle. `mean`, `a`, `b` are as in FLUSI's files, where a0 = 2 mean; or it has values and slopes at
    nodes (mean 0)."""
    kind: str
    mean: float
    a: np.ndarray
    b: np.ndarray
    residual: float      # sd of the residuals, with the degrees of freedom

    def __call__(self, x: np.ndarray) -> np.ndarray:
        if self.kind == FOURIER:
            return fourier(self.mean, self.a, self.b)(x)
        return cubic(np.arange(len(self.a) + 1) / len(self.a), np.append(self.a, self.a[0]), np.append(self.b, self.b[0]), True)(x)


def columns_of(x: np.ndarray, harmonics: int) -> np.ndarray:
    """Returns the values of a Fourier series' functions at x (n, 2 harmonics + 1)."""
    k = 2 * np.pi * np.arange(1, harmonics + 1)
    return np.hstack([np.ones((len(x), 1)), np.cos(np.multiply.outer(x, k)), np.sin(np.multiply.outer(x, k))])


def fit_fourier(x: np.ndarray, values: np.ndarray, harmonics: int) -> Fit:
    """Fits a Fourier series by least squares. There must be more samples than unknowns."""
    solution, *_ = np.linalg.lstsq(columns_of(x, harmonics), values, rcond=None)
    left = values - columns_of(x, harmonics) @ solution
    residual = np.sqrt((left**2).sum() / (len(x) - len(solution)))
    return Fit(FOURIER, solution[0], solution[1:1 + harmonics], solution[1 + harmonics:], float(residual))


def choose_harmonics(x: np.ndarray, values: np.ndarray, most: int) -> int:
    """Chooses the number of harmonics by Schwarz's criterion."""
    n, best = len(x), (np.inf, 0)
    for harmonics in range(most + 1):
        unknowns = 2 * harmonics + 1
        if unknowns >= n:
            break
        squares = fit_fourier(x, values, harmonics).residual**2 * (n - unknowns)
        best = min(best, (n * np.log(max(squares, 1e-20) / n) + unknowns * np.log(n), harmonics))
    return best[1]


def fit_hermite(x: np.ndarray, values: np.ndarray, nodes: int) -> Fit:
    """Fits the values and slopes at equidistant nodes by least squares."""
    i = np.minimum((x * nodes).astype(int), nodes - 1)
    s = x * nodes - i
    after, rows = (i + 1) % nodes, np.arange(len(x))
    system = np.zeros((len(x), 2 * nodes))
    system[rows, i] += 1 - 3 * s**2 + 2 * s**3
    system[rows, after] += 3 * s**2 - 2 * s**3
    system[rows, nodes + i] += (s - 2 * s**2 + s**3) / nodes
    system[rows, nodes + after] += (s**3 - s**2) / nodes
    solution, *_ = np.linalg.lstsq(system, values, rcond=None)
    residual = np.sqrt(((values - system @ solution)**2).sum() / (len(x) - 2 * nodes))
    return Fit(HERMITE, 0.0, solution[:nodes], solution[nodes:], float(residual))


def motion_text(fits: dict[str, Fit], head: str) -> str:
    """Returns the text of a motion file; `head` is its comment."""
    def words(values: Iterable[float]) -> str:
        return " ".join(f"{v:.10g}" for v in values)

    lines = [f"; {line}".rstrip() for line in head.split("\n")]
    lines += ["", "[kinematics]", f"type = {fits['phi'].kind};", "units = degree;", "convention = flusi;"]
    for name in ANGLES:
        fit = fits[name]
        lines += ["", f"nfft_{name} = {len(fit.a)};"]
        if fit.kind == FOURIER:
            lines.append(f"a0_{name} = {2 * fit.mean:.10g}; twice the mean")
        if len(fit.a):
            lines += [f"ai_{name} = {words(fit.a)};", f"bi_{name} = {words(fit.b)};"]
        else:
            lines += [f"ai_{name} = ;", f"bi_{name} = ;"]
    return "\n".join(lines) + "\n"
