# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the static equilibrium of a synthetic wing at the end of its loading path.

The load grows from zero. A stage extrapolates the last two shapes and corrects the result by Newton's method on the true
residual. There the axial forces of the springs are independent unknowns: otherwise springs 1e5 times stiffer than the bending
would allow only tiny steps. The signs of the pivots show whether a shape is stable. Where the path turns back, the next stable
shape is found by minimising the potential from the last stable one."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from flusi_msm.results.files import InputError

if TYPE_CHECKING:
    from flusi_msm.bending.model import Model


@dataclass
class Report:
    """Whether and how a loading path has reached its end."""
    converged: bool = False
    residual: float = np.inf  # of the load
    factorisations: int = 0
    snaps: int = 0
    reason: str = ""


class NoEquilibrium(InputError):
    """The wing has no equilibrium that can be found under the load."""


class Factors:
    """Triangular factors of symmetric matrices of one pattern; the order of elimination is determined only once."""

    def __init__(self) -> None:
        self.order: np.ndarray | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Returns the state without the factors, which cannot be stored."""
        return {key: value for key, value in vars(self).items() if key != "lu"}

    def __call__(self, matrix: csc_matrix) -> Factors:
        """Factorises a matrix: makes `solve`; `is_stable` says whether all pivots are positive."""
        if self.order is None:
            first = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
            self.order = np.argsort(first.perm_c)
            n = matrix.shape[0]
            tagged = csc_matrix((np.arange(1.0, matrix.nnz + 1), matrix.indices, matrix.indptr), shape=(n, n))
            tagged = tagged[self.order][:, self.order].tocsc()
            tagged.sort_indices()
            self.source, self.pattern = tagged.data.astype(int) - 1, (tagged.indices, tagged.indptr)
        matrix = csc_matrix((matrix.data[self.source], *self.pattern), shape=matrix.shape)
        try:
            self.lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError:  # a pivot is zero
            self.is_stable = False
            return self
        self.is_stable = bool((self.lu.perm_r == self.lu.perm_c).all() and (self.lu.U.diagonal() > 0).all())
        return self

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Returns the solution of the factorised system."""
        x = np.empty_like(b)
        x[self.order] = self.lu.solve(b[self.order])
        return x


class Path:
    """Follows the loading path of one wing; `tolerance` is the final residual relative to the load, `largest` is the longest
    movement in a stage relative to the wing's size."""

    def __init__(self, model: Model, tolerance: float = 1e-9, largest: float = 0.025, limit: int = 600) -> None:
        self.model, self.tolerance, self.limit = model, tolerance, limit
        self.factors = Factors()
        self.size = float(np.linalg.norm(np.ptp(model.positions, axis=0)))
        self.largest = largest * self.size
        self.moves = model.moves

    def solve(self, load: np.ndarray, start: np.ndarray | None = None) -> tuple[np.ndarray, Report]:
        """Returns the displacements (nodes, 3) under load (nodes, 3), and a report. With `start`, the shape for a similar load
        or stiffness, the path leads from there in one stage if possible; the unbalanced forces are removed in proportion."""
        self.report, self.force = Report(), load
        self.scale = float(np.linalg.norm(load[self.moves]))
        m = self.model
        u = m.zeros() if start is None else start.copy()
        if self.scale == 0:
            self.report.converged, self.report.residual = True, 0.0
            return m.zeros(), self.report
        begin = m.gradient(u) - load
        axial = m.springs.forces(u)
        t, dt, previous, rejected = 0.0, 0.05 if start is None else 1.0, None, 0
        while t < 1:
            ahead = min(1.0, t + dt)
            if 1 - ahead < dt / 4:
                ahead = 1.0
            outside = load + (1 - ahead) * begin
            outcome, found, tension, steps = self._stage(u, axial, previous, t, ahead, outside)
            if outcome == "done":
                moved = self._longest(found - u)
                previous, u, axial, t, rejected = (u, axial, t), found, tension, ahead, 0
                dt *= min(2.0, self.largest / max(moved, 1e-300), 2.0 if steps <= 4 else 1.2 if steps <= 6 else 0.7)
            else:
                rejected += 1
                dt *= 0.35
                if rejected > (2 if outcome == "unstable" else 5):
                    u = self._descend(u, outside, self.tolerance if ahead == 1 else 1e-4)
                    axial, previous, t, rejected = m.springs.forces(u), None, ahead, 0
                    self.report.snaps += 1
                    dt = max(dt, 0.02)
        self._factorise(u, m.springs.forces(u))
        if not self.factors.is_stable:
            self._give_up("the path ends in a shape that is not stable")
        self.report.residual = self._residual(u, load)
        self.report.converged = True
        return u, self.report

    def _stage(self, u: np.ndarray, axial: np.ndarray, previous: tuple[np.ndarray, np.ndarray, float] | None, t: float, ahead: float,
               outside: np.ndarray) -> tuple[str, np.ndarray, np.ndarray, int]:
        """Solves for the load `outside` by Newton's method; returns the outcome, shape, axial forces and iterations."""
        m, is_last = self.model, ahead == 1
        w, tension = u, axial
        if previous is not None:
            share = (ahead - t) / (t - previous[2])
            w = u + share * (u - previous[0])
            tension = axial + share * (axial - previous[1])
        target, before = self.tolerance if is_last else 1e-4, np.inf
        for iteration in range(14 if is_last else 9):
            missing = outside - m.gradient(w)
            residual = float(np.linalg.norm(missing[self.moves])) / self.scale
            if residual <= target and iteration > 0:
                return "done", w, tension, iteration
            if not np.isfinite(residual) or (iteration > 2 and residual > 10 * before):
                return "diverged", w, tension, iteration
            before = residual
            self._factorise(w, tension)
            if not self.factors.is_stable:
                return "unstable", w, tension, iteration
            step = self._step(missing)
            if self._longest(w + step - u) > 4 * self.largest:
                return "far", w, tension, iteration
            tension = m.springs.forces_after(w, step)
            w = w + step
        # Rounding errors of stiff springs may keep the residual above the tolerance.
        if is_last and self._residual(w, outside) <= 1e-8:
            return "done", w, tension, iteration
        return "slow", w, tension, iteration

    def _descend(self, u: np.ndarray, outside: np.ndarray, target: float) -> np.ndarray:
        """Finds a minimum of the potential below that of the shape u: Newton steps with tension-only springs and a growing shift
        of the diagonal where the tangent is not definite, and with a search along each step."""
        m = self.model
        potential = m.energy(u) - (outside * u).sum()
        axial, shift = m.springs.forces(u), 0.0
        unit = m.stiffness.D / self.size**2
        while True:
            g = m.gradient(u) - outside
            residual = np.linalg.norm(g[self.moves]) / self.scale
            law = m.springs.forces(u)
            near = residual < 0.05
            self._factorise(u, law if near else np.maximum(axial, 0), shift)
            if residual <= target and shift == 0 and near and self.factors.is_stable:
                return u
            while not self.factors.is_stable:
                shift = max(4 * shift, unit)
                self._factorise(u, law if near else np.maximum(axial, 0), shift)
            step = self._step(-g)
            step *= min(1.0, 6 * self.largest / self._longest(step))
            slope, length = (g * step).sum(), 1.0
            while length > 1e-6:
                trial = u + length * step
                value = m.energy(trial) - (outside * trial).sum()
                if value <= potential + 1e-4 * length * slope:
                    break
                if abs(value - potential) < 1e-10 * abs(potential) and \
                        np.linalg.norm((m.gradient(trial) - outside)[self.moves]) < residual * self.scale:
                    break
                length *= 0.4
            else:
                shift, axial = max(10 * shift, unit), law
                continue
            axial = m.springs.forces_after(u, length * step)
            u, potential = trial, value
            shift = 0.0 if shift < unit else shift / 10

    def _factorise(self, u: np.ndarray, axial: np.ndarray, shift: float = 0.0) -> None:
        if self.report.factorisations >= self.limit:
            self._give_up(f"no shape after {self.limit} factorisations")
        self.report.factorisations += 1
        self.factors(self.model.tangent(u, axial, shift))

    def _step(self, forces: np.ndarray) -> np.ndarray:
        step = self.model.zeros()
        step[self.moves] = self.factors.solve(forces[self.moves].ravel()).reshape(-1, 3)
        return step

    def _residual(self, u: np.ndarray, outside: np.ndarray) -> float:
        return float(np.linalg.norm((self.model.gradient(u) - outside)[self.moves])) / self.scale

    def _longest(self, u: np.ndarray) -> float:
        return float(np.sqrt((u[:self.model.n_points]**2).sum(1).max()))

    def _give_up(self, reason: str) -> NoReturn:
        self.report.reason = reason
        raise NoEquilibrium(reason)
