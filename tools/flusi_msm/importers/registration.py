# SPDX-License-Identifier: GPL-3.0-or-later
"""Transforms from the frame in which a wing was scanned to the frame of its wing file: a rotation and a shift within the plane,
found from landmarks or from the outline. It also resamples heights on the lines of a grid in that frame. SI units."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from flusi_msm.errors import InputError, Problems
from flusi_msm.wing.file import Wing

SCALE_NOTICE, SCALE_ERROR = 0.02, 0.2     # relative difference of sizes that gives a notice, and that is refused
RESIDUAL_ERROR = 0.05                     # of the extent: a scan with larger residuals is taken for another wing
AMBIGUOUS = 1.3                           # a second fit whose residual is less than so many times that of the best


@dataclass
class Registration:
    """The transformation: p in the wing's frame = turn @ p of the scan + shift."""
    turn: np.ndarray = field(default_factory=lambda: np.eye(2))
    shift: np.ndarray = field(default_factory=lambda: np.zeros(2))
    how: str = "axes as they are"
    residuals: np.ndarray | None = None    # (n, 2) [m], residuals at landmarks or points of the outline
    places: np.ndarray | None = None       # (n, 2) [m], their places in the wing's frame
    names: tuple[str, ...] = ()

    def __call__(self, points: np.ndarray) -> np.ndarray:
        return np.asarray(points) @ self.turn.T + self.shift

    def inverse(self, points: np.ndarray) -> np.ndarray:
        """Returns places of the scan for points in the wing's frame."""
        return (np.asarray(points) - self.shift) @ self.turn

    def angle(self) -> float:
        """Returns the angle by which the scan is turned [rad]."""
        return float(np.arctan2(self.turn[1, 0], self.turn[0, 0]))

    def rms(self) -> float:
        """Returns the root mean square of the residuals [m]."""
        return float(np.sqrt((self.residuals**2).sum(1).mean())) if self.residuals is not None else 0.0

    def report(self) -> list[str]:
        """Describes the transformation and its residuals, in lines."""
        lines = [f"registration: {self.how}, turned by {np.degrees(self.angle()):.3f} degrees, shifted by "
                 f"({1e3 * self.shift[0]:.4f}, {1e3 * self.shift[1]:.4f}) mm"]
        if self.residuals is not None:
            lengths = np.linalg.norm(self.residuals, axis=1)
            lines[0] += f"; residual {1e6 * self.rms():.1f} um (rms), {1e6 * lengths.max():.1f} um at most"
            lines += [f"  {name}: {1e6 * length:.1f} um" for name, length in zip(self.names, lengths)]
        return lines


def turn_by(angle: float) -> np.ndarray:
    """Returns the matrix of a rotation in the plane."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def best_turn(scan: np.ndarray, wing: np.ndarray, is_mirrored: bool = False) -> tuple[np.ndarray, np.ndarray, float]:
    """Returns rotation (or reflection), shift and residual (rms) of the least squares fit of points to points (Kabsch)."""
    a, b = scan - scan.mean(0), wing - wing.mean(0)
    u, _, v = np.linalg.svd(a.T @ b)
    sign = np.sign(np.linalg.det(u @ v)) * (-1 if is_mirrored else 1)
    turn = (u @ np.diag([1, sign]) @ v).T
    shift = wing.mean(0) - turn @ scan.mean(0)
    return turn, shift, float(np.sqrt(((scan @ turn.T + shift - wing)**2).sum(1).mean()))


def by_landmarks(names: Sequence[str], scan: np.ndarray, wing: np.ndarray, problems: Problems) -> Registration:
    """Finds the transformation from two or more places that are known in both frames. Problems are added to the errors of
    `problems`."""
    if len(names) < 2:
        problems.error("landmarks: two or more are needed, better three or more")
        return Registration()
    spread = [float(np.linalg.norm(points - points.mean(0))) for points in (scan, wing)]
    if min(spread) <= 0:
        problems.error("landmarks: all are at the same point; mark points that are far apart")
        return Registration()
    turn, shift, rms = best_turn(scan, wing)
    extent = np.linalg.norm(np.ptp(wing, axis=0))
    mirrored = best_turn(scan, wing, True)[2] if len(names) > 2 else np.inf
    if mirrored < 0.5 * rms and rms > 0.01 * extent:
        problems.error(f"landmarks: they are those of a mirror image (residual {1e6 * mirrored:.0f} um, as it is {1e6 * rms:.0f} um): "
                       "give --flip y if y of the scan runs downward; if the wing was scanned from its other side, --flip z too")
    check_size(spread[0] / spread[1], "landmarks are", problems)
    if rms > RESIDUAL_ERROR * extent and not problems.errors:
        problems.error(f"landmarks: do not fit: {1e6 * rms:.0f} um are left (rms), more than {RESIDUAL_ERROR:.0%} of their extent; "
                       "is one of them another place?")
    return Registration(turn, shift, f"{len(names)} landmarks", scan @ turn.T + shift - wing, wing, tuple(names))


def check_size(ratio: float, what: str, problems: Problems) -> None:
    """Checks that the scan and the wing have the same size."""
    if abs(ratio - 1) > SCALE_ERROR:
        problems.error(f"registration: {what} {ratio:.4g} times as large in the scan as in the wing file: are --axis-units right, and is it "
                       "the file of this wing?")
    elif abs(ratio - 1) > SCALE_NOTICE:
        problems.notice(f"registration: {what} {ratio:.4g} times as large in the scan as in the wing file; nothing is stretched")


def outline_of(wing: Wing) -> np.ndarray:
    """Returns the margin of the membrane as a closed line (n + 1, 2) [m]; the longest one if there are holes."""
    edges, counts = wing.edges()
    neighbours: dict = {}
    for a, b in edges[counts == 1]:
        neighbours.setdefault(int(a), []).append(int(b))
        neighbours.setdefault(int(b), []).append(int(a))
    left, best = set(neighbours), np.zeros((0, 2))
    while left:
        first = before = min(left)
        line, here = [first], neighbours[first][0]
        while here != first:
            line.append(here)
            following = [n for n in neighbours[here] if n != before] or [first]
            before, here = here, following[0]
        left -= set(line)
        points = wing.points[line + [first], :2]
        if np.linalg.norm(np.ptp(points, axis=0)) > (np.linalg.norm(np.ptp(best, axis=0)) if len(best) else 0):
            best = points
    if not len(best):
        raise InputError("the wing has no membrane and so no outline: register it by landmarks")
    return best


def margin_of(x: np.ndarray, y: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, float]:
    """Returns the points (n, 2) half-way between two neighbours of which only one has a height, and the area with heights. Holes
    and specks are ignored."""
    from scipy import ndimage
    labels, n = ndimage.label(known)
    if n == 0:
        raise InputError("registration: the unloaded wing has no heights")
    largest = labels == 1 + np.argmax(ndimage.sum_labels(known, labels, np.arange(1, n + 1)))
    solid = np.pad(ndimage.binary_fill_holes(largest), 1)
    dx, dy = np.diff(x).mean(), np.diff(y).mean()
    gx = np.concatenate([[x[0] - dx], x, [x[-1] + dx]])
    gy = np.concatenate([[y[0] - dy], y, [y[-1] + dy]])
    j, i = np.nonzero(solid[:, 1:] != solid[:, :-1])
    across = np.stack([(gx[i] + gx[i + 1]) / 2, gy[j]], 1)
    j, i = np.nonzero(solid[1:] != solid[:-1])
    along = np.stack([gx[i], (gy[j] + gy[j + 1]) / 2], 1)
    return np.concatenate([across, along]), float(solid.sum() * dx * dy)


def to_line(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Returns the vectors from every point to the nearest point of the line (n, 2)."""
    a, e = line[:-1], np.diff(line, axis=0)
    share = ((points[:, None] - a) * e).sum(2) / (e**2).sum(1)
    near = a + np.clip(share, 0, 1)[..., None] * e
    gaps = near - points[:, None]
    return gaps[np.arange(len(points)), (gaps**2).sum(2).argmin(1)]


def by_outline(x: np.ndarray, y: np.ndarray, known: np.ndarray, wing: Wing, problems: Problems) -> Registration:
    """Finds the transformation from the margin of the heights in the scan of the unloaded wing, which must have none outside the
    wing."""
    from scipy.optimize import least_squares
    line = outline_of(wing)
    margin, area = margin_of(x, y, known)
    check_size(np.sqrt(area / abs(wing.areas().sum())), "the area with heights is (by its root)", problems)
    if problems.errors:
        return Registration()
    extent = np.linalg.norm(np.ptp(line, axis=0))
    few = margin[::max(1, len(margin) // 250)]
    middle = line[:-1].mean(0)

    def gaps(unknowns: np.ndarray, points: np.ndarray) -> np.ndarray:
        angle, *shift = unknowns
        return to_line((points - margin.mean(0)) @ turn_by(angle).T + shift, line)

    found = []
    for start in np.radians(np.arange(0, 360, 30)):
        fit = least_squares(lambda u: gaps(u, few).ravel() / extent, [start, *middle], x_scale=[0.1, extent / 10, extent / 10],
                            loss="soft_l1", f_scale=0.01, max_nfev=40)
        found.append((fit.cost, fit.x))
    found.sort(key=lambda one: one[0])
    best = least_squares(lambda u: gaps(u, margin).ravel() / extent, found[0][1], x_scale=[0.1, extent / 10, extent / 10],
                         loss="soft_l1", f_scale=0.01).x
    left = gaps(best, margin)
    rms = np.sqrt((left**2).sum(1).mean())
    for _, other in found[1:]:
        if abs(np.angle(np.exp(1j * (other[0] - best[0])))) < 0.2:
            continue
        second = np.sqrt((gaps(other, margin)**2).sum(1).mean())
        if second < AMBIGUOUS * rms:
            problems.error(f"registration: the outline fits turned by {np.degrees(best[0]):.0f} and by {np.degrees(other[0]):.0f} degrees "
                           f"({1e6 * rms:.0f} and {1e6 * second:.0f} um): give --landmarks")
            break
    if rms > RESIDUAL_ERROR * extent / 2:
        problems.error(f"registration: the outline does not fit: {1e6 * rms:.0f} um are left (rms). Are there heights beside the wing, "
                       "or is the scan a mirror image (--flip y)?")
    turn = turn_by(best[0])
    shift = best[1:] - turn @ margin.mean(0)
    return Registration(turn, shift, f"the outline, {len(margin)} points of it", -left, margin @ turn.T + shift)


def is_inside(line: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Returns which of the points (n, 2) lie within a closed line."""
    from matplotlib.path import Path as Polygon
    return Polygon(line).contains_points(points)


def resampled(x: np.ndarray, y: np.ndarray, z: np.ndarray, sd: np.ndarray, x_new: np.ndarray, y_new: np.ndarray,
              registration: Registration, is_correlated: bool) -> tuple[np.ndarray, np.ndarray]:
    """Returns heights on other grid lines, in the wing's frame, by bilinear interpolation, and their standard deviations. The
    latter follow from those (`sd`, an array) of the four heights, whose errors are independent or all the same. NaN where one of
    the four is missing."""
    gx, gy = np.meshgrid(x_new, y_new)
    points = registration.inverse(np.stack([gx.ravel(), gy.ravel()], 1))
    total, variance = np.zeros(len(points)), np.zeros(len(points))
    i = np.clip(np.searchsorted(x, points[:, 0], "right") - 1, 0, x.size - 2)
    j = np.clip(np.searchsorted(y, points[:, 1], "right") - 1, 0, y.size - 2)
    u, v = (points[:, 0] - x[i]) / (x[i + 1] - x[i]), (points[:, 1] - y[j]) / (y[j + 1] - y[j])
    slack = 1e-9
    is_there = (u >= -slack) & (u <= 1 + slack) & (v >= -slack) & (v <= 1 + slack)
    u, v = np.clip(u, 0, 1), np.clip(v, 0, 1)
    for di, wx in ((0, 1 - u), (1, u)):
        for dj, wy in ((0, 1 - v), (1, v)):
            weight = wx * wy
            counts = weight > slack
            total[counts] += (weight * z[j + dj, i + di])[counts]
            own = (weight * sd[j + dj, i + di])[counts]
            variance[counts] += own if is_correlated else own**2
    total[~is_there] = np.nan
    spread = variance if is_correlated else np.sqrt(variance)
    return total.reshape(gx.shape), spread.reshape(gx.shape)


def find_outliers(z: np.ndarray, least: float, factor: float = 6.0) -> np.ndarray:
    """Returns which heights differ by more than `factor` sd from the median of the means of opposite neighbours. Up to twelve
    pairs of neighbours are used; slopes cancel in their means. The sd is that of all such differences (from their median), at
    least `least`."""
    wide = np.pad(z, 2, constant_values=np.nan)
    ny, nx = z.shape
    pairs = []
    for dj in range(3):
        for di in range(-2, 3):
            if (dj, di) > (0, 0):
                pairs.append((wide[2 + dj:2 + dj + ny, 2 + di:2 + di + nx] + wide[2 - dj:2 - dj + ny, 2 - di:2 - di + nx]) / 2)
    stack = np.array(pairs)
    enough = np.isfinite(stack).sum(0) >= 3
    stack[:, ~enough] = 0
    difference = np.where(enough & np.isfinite(z), z - np.nanmedian(stack, axis=0), 0.0)
    tested = enough & np.isfinite(z)
    if not tested.any():
        return np.zeros(z.shape, bool)
    spread = max(1.4826 * np.median(np.abs(difference[tested])), least)
    return tested & (np.abs(difference) > factor * spread)
