# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes how visible a hidden effect is: the signal-to-noise ratio of the part of it that cannot be explained by E, the joints
and the declared errors.

With d the change of all heights, C the covariance of the heights' errors (those of the unloaded scan are common to all
loads), columns A of everything that a usual model may adjust and their prior covariance P,

    snr^2 = d C^-1 d - d C^-1 A (A C^-1 A + P^-1)^-1 A C^-1 d.

Columns of A: ln E, and ln k of the joints (priors of a decade); ln D of the membrane (MEMBRANE_SD, because its effective value
depends on the mesh); the force, its place, tilt and height of each scan and the gain of all forces (their declared sd); and the
change of all heights between the two meshes (sd 1). Derivatives are exact: forces are proportional to stiffness, and the tangent
gives the change of a shape with the forces. Where stiffness explains much of d, shapes with that stiffness replace the
derivatives (Individual.visibility). For example, other stiffness explains a gain of 1.1 up to 0.4 um, but the second derivatives
are 2.6 um."""
from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from flusi_msm.bending.mesh import locate
from flusi_msm.bending.statics import NoEquilibrium, Path
from flusi_msm.measurement.noise import Noise
from flusi_msm.measurement.scan import look
from flusi_msm.measurement.synthesis import Bench, Load
from flusi_msm.results.files import InputError

STEP = 1e-5  # [m] of a load's place, for its derivative
FILLS = 4    # iterations for the values of what is not seen; they change by a few thousandths
MEMBRANE_SD = 0.1  # of ln D: the value that a measurement of one wing on one mesh takes as known


class Base:
    """The wing of an experiment without hidden effects under all loads: its shapes, and the derivatives of its heights."""

    def __init__(self, bench: Bench, x: np.ndarray | None = None, y: np.ndarray | None = None) -> None:
        """Computes the shapes; without grid lines x, y there are no derivatives."""
        self.x, self.y = x, y
        self.model = bench.model()
        self.path = Path(self.model)
        self.loads = bench.loads()
        self.shapes: dict[str, np.ndarray] = {}   # by the name of the load
        self.columns: dict[str, np.ndarray] = {}
        for load in sorted(self.loads, key=lambda load: (load.point, abs(load.level))):
            self._solve(load)

    def _solve(self, load: Load) -> None:
        m = self.model
        force = m.point_load(load.point, load.vector)
        start = self._start(load)
        u, report = self.path.solve(force, start)
        if report.snaps:
            raise NoEquilibrium(f"load {load.name}: the wing snaps")
        self.shapes[load.name] = u
        if self.x is None or self.y is None:
            return
        local, _ = m.turns.derivatives(u, with_hessian=False)
        numbers = [k for k, h in enumerate(m.hinge_plan) if h.joint]
        groups = [[k for k in range(len(m.hinge_plan)) if k not in numbers]] + [[k] for k in numbers]
        sides = []
        for group in groups:
            g = m.zeros()
            np.add.at(g, m.turns.local[group].ravel(), local[group].reshape(-1, 3))
            sides.append(-g)
        g = m.zeros()
        m.bending.add_gradient(u, g)  # proportional to D
        sides += [-g, force / np.linalg.norm(load.vector), force]
        for k in range(2):
            step = np.zeros(2)
            step[k] = STEP
            sides.append(self._moved(load, step))
        moves = np.stack([self.path._step(side)[:m.n_points] for side in sides], 2)  # (points, 3, columns)
        positions = m.wing.points + u[:m.n_points]
        z, seen = look(positions, m.triangles, self.x, self.y)
        rows = np.argwhere(seen >= 0)
        columns = np.full(z.shape + (len(sides) + 3,), np.nan)
        for (j, i) in rows:
            corners = m.triangles[seen[j, i]]
            a = positions[corners[0]]
            e, f = positions[corners[1:]] - a
            gx, gy = self.x[i] - a[0], self.y[j] - a[1]
            n = np.cross(e, f)
            one, two = (gx * f[1] - gy * f[0]) / n[2], (gy * e[0] - gx * e[1]) / n[2]
            normal = n / n[2]  # dz at a fixed place is the displacement along it
            mixed = np.einsum("k,kcm->cm", [1 - one - two, one, two], moves[corners])
            columns[j, i] = np.concatenate([normal @ mixed, [self.y[j], -self.x[i], 1.0]])
        self.columns[load.name] = columns

    def _start(self, load: Load) -> np.ndarray | None:
        """Returns the known shape under a similar force at the same place, mirrored if the force was the opposite one."""
        solved = [other for other in self.loads if other.name in self.shapes and other.point == load.point]
        if not solved:
            return None
        near = max(solved, key=lambda other: abs(other.level))
        u = self.shapes[near.name].copy()
        if np.dot(near.vector, load.vector) < 0:
            if any(abs(v) > 0 for v in load.vector[:2]) or not self.model.is_flat:
                return None
            u[:, 2] *= -1
        return u

    def _moved(self, load: Load, step: np.ndarray) -> np.ndarray:
        """Returns the change of the forces per distance when the force acts elsewhere; near the edge the difference is
        one-sided."""
        places, here = [], np.array(load.point)
        for sign in (1, -1):
            try:
                locate(self.model.wing.points, self.model.triangles, here + sign * step)
                places.append(here + sign * step)
            except InputError:
                places.append(here)
        forces = [self.model.point_load(place, load.vector) for place in places]
        length = np.linalg.norm(places[0] - places[1])
        return (forces[0] - forces[1]) / length if length > 0 else self.model.zeros()


class Oracle:
    """Computes signal-to-noise ratios of changes. `clean` is the measurement of the base without errors, as from `observe`;
    `band` is the same on the other mesh; both are deformations (loads, ny, nx). `fringe` has the amplitude, length and direction
    of waves with another phase in every scan."""

    def __init__(self, base: Base, noise: Noise, declared: Mapping[str, float], clean: np.ndarray, band: np.ndarray,
                 fringe: tuple[float, float, float] = (0.0, 1.0, 0.0)) -> None:
        self.clean, n_loads = clean, len(base.loads)
        assert base.x is not None and base.y is not None  # an oracle needs derivatives
        columns = np.stack([base.columns[load.name] for load in base.loads])
        self.known = np.isfinite(clean) & np.isfinite(columns).all(3) & np.isfinite(band)
        y, x = np.meshgrid(base.y, base.x, indexing="ij")
        places = np.stack([x, y], 2)
        any_load = self.known.any(0)
        union = places[any_load]
        number = np.full(any_load.shape, -1)
        number[any_load] = np.arange(len(union))
        self.rows = [number[known] for known in self.known]
        whole = self._covariance(noise, union, fringe)
        self.factors = [cho_factor(whole[np.ix_(r, r)]) for r in self.rows]
        # Errors of the unloaded scan: a common unknown height at every place, with the covariance whole/n.
        common = noise.reference_scans * np.linalg.inv(whole)
        for rows, factor in zip(self.rows, self.factors):
            common[np.ix_(rows, rows)] += cho_solve(factor, np.eye(len(rows)))
        self.common, self.size = cho_factor(common), len(union)
        n_own = 6  # of each load: force, place (2), tilt (2), height
        own = [columns.shape[3] - k for k in (7, 5, 4, 3, 2, 1)]
        n_stiff = own[0]  # E, joints, D
        a = np.zeros((sum(map(len, self.rows)), n_stiff + 2 + n_own * n_loads))
        sd = np.concatenate([np.full(n_stiff - 1, np.log(10)), [MEMBRANE_SD, declared["force_gain"], 1.0],
                             np.tile([declared["force"], declared["position"], declared["position"], declared["tilt"],
                                      declared["tilt"], declared["piston"]], n_loads)])
        first = 0
        for k, known in enumerate(self.known):
            rows = slice(first, first + known.sum())
            c = columns[k][known]
            a[rows, :n_stiff] = c[:, :n_stiff]
            a[rows, n_stiff] = c[:, n_stiff + 1]
            a[rows, n_stiff + 1] = (band - clean)[k][known]
            at = n_stiff + 2 + n_own * k
            a[rows, at:at + n_own] = c[:, own]
            first = rows.stop
        self.a = a * sd  # in units of their sd
        self.weighted = self.weigh(self.a)
        self.matrix = cho_factor(self.a.T @ self.weighted + np.eye(len(sd)))
        self.band_column, self.n_stiff = n_stiff + 1, n_stiff
        self.stiff = self.a[:, :n_stiff] / sd[:n_stiff]
        self.stiff_sd = sd[:n_stiff]

    @staticmethod
    def _covariance(noise: Noise, places: np.ndarray, fringe: tuple[float, float, float]) -> np.ndarray:
        c = noise.height**2 * np.eye(len(places))
        if noise.correlated > 0:
            square = ((places[:, None] - places[None])**2).sum(2)
            c += noise.correlated**2 * np.exp(-square / (2 * noise.correlation_length**2))
        amplitude, length, angle = fringe
        if amplitude > 0:
            along = 2 * np.pi / length * (places @ [np.cos(angle), np.sin(angle)])
            c += 0.5 * amplitude**2 * np.cos(along[:, None] - along[None])
        return c

    def weigh(self, d: np.ndarray) -> np.ndarray:
        """Returns C^-1 d for columns d."""
        parts, first = [], 0
        total = np.zeros((self.size, d.shape[1]))
        for rows, factor in zip(self.rows, self.factors):
            part = cho_solve(factor, d[first:first + len(rows)])
            total[rows] += part
            parts.append(part)
            first += len(rows)
        correction = cho_solve(self.common, total)
        for k, (rows, factor) in enumerate(zip(self.rows, self.factors)):
            parts[k] = parts[k] - cho_solve(factor, correction[rows])
        return np.concatenate(parts)

    def change(self, seen: np.ndarray) -> np.ndarray:
        """Returns the change of deformations (loads, ny, nx) at all places of the usual wing; not a number where `seen` has no
        value."""
        return seen[self.known] - self.clean[self.known]

    def filled(self, d: np.ndarray) -> np.ndarray:
        """Fills in the change where it is not seen: there it gets the value that explains it elsewhere, so that it adds no
        information."""
        unseen = ~np.isfinite(d)
        d = np.where(unseen, 0.0, d)
        if unseen.any():
            for _ in range(FILLS):
                d[unseen] = self.a[unseen] @ cho_solve(self.matrix, self.weighted.T @ d)
        return d

    def explain(self, d: np.ndarray) -> np.ndarray:
        """Returns the changes of ln E, ln k of the joints and ln D in the best explanation of a change d."""
        return cho_solve(self.matrix, self.weighted.T @ self.filled(d))[:self.n_stiff] * self.stiff_sd

    def snr(self, d: np.ndarray) -> float:
        """Returns the signal-to-noise ratio of a change d."""
        d = self.filled(d)[:, None]
        weighted = self.weigh(d)
        g = self.weighted.T @ d
        return float(np.sqrt(max(0.0, (d * weighted).sum() - (g * cho_solve(self.matrix, g)).sum())))

    def band_snr(self) -> float:
        """Returns the signal-to-noise ratio of the difference of the meshes against noise alone, that is, the visibility of an
        error of discretisation."""
        keep = np.arange(self.a.shape[1]) != self.band_column
        d = self.a[:, [self.band_column]]
        gram = (self.a.T @ self.weighted + np.eye(len(keep)))[np.ix_(keep, keep)]
        g = self.weighted[:, keep].T @ d
        square = (d * self.weighted[:, [self.band_column]]).sum() - (g * np.linalg.solve(gram, g)).sum()
        return float(np.sqrt(max(0.0, square)))
