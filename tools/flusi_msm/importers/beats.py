# SPDX-License-Identifier: GPL-3.0-or-later
"""Divides long records of a periodic motion into beats that are compared at the same phases."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

GAP = 0.25       # of the beat: longer gaps are not interpolated
DRIFT = 0.05     # of a beat, over all beats: a frequency with a larger error is refused
REPEATS = 0.2    # of the variance that the mean beat should explain at least


@dataclass
class Folded:
    """All beats of a record at the same phases."""
    phase: np.ndarray        # (n)
    beats: np.ndarray        # (beats, n, k), NaN where unknown

    def mean(self) -> np.ndarray:
        """Returns the mean beat (n, k); NaN where fewer than two beats are known."""
        count = self.count()
        total = np.nansum(self.beats, axis=0)
        return np.where(count >= 2, total / np.maximum(count, 1), np.nan)

    def count(self) -> np.ndarray:
        """Returns how many beats are known (n, k)."""
        return np.isfinite(self.beats).sum(axis=0)

    def spread(self) -> np.ndarray:
        """Returns the standard deviation of single beats; NaN where fewer than two are known."""
        rest = self.beats - self.mean()
        count = self.count()
        return np.where(count >= 2, np.sqrt(np.nansum(rest**2, axis=0) / np.maximum(count - 1, 1)), np.nan)

    def explained(self) -> np.ndarray:
        """Returns the share of the variance of each component that the mean beat explains."""
        rest, whole = self.beats - self.mean(), self.beats - np.nanmean(self.beats, axis=(0, 1))
        return 1 - np.nansum(rest**2, axis=(0, 1)) / np.maximum(np.nansum(whole**2, axis=(0, 1)), 1e-300)

    def correlation_time(self) -> float:
        """Returns the time [beats] in which the correlation of errors falls by the factor e, from neighbours; 0 where no
        correlation can be found."""
        rest = (self.beats - self.mean()) / self.spread()
        pairs = rest[:, 1:] * rest[:, :-1]
        known = np.isfinite(pairs)
        if known.sum() < 20:
            return 0.0
        ratio = float(pairs[known].mean())
        if ratio < 3 / np.sqrt(known.sum()):
            return 0.0
        return float((self.phase[1] - self.phase[0]) / -np.log(min(ratio, 0.99)))


def fold(time: np.ndarray, values: np.ndarray, frequency: float, start: float, skip: int, samples: int) -> Folded:
    """Interpolates complete beats after the time `start` and `skip` more beats linearly at `samples` phases."""
    clock = (time - start) * frequency
    first = max(int(np.ceil(clock[0] - 1e-9)), 0) + skip
    last = int(np.floor(clock[-1] + 1 / samples + 1e-9))
    phase = np.arange(samples) / samples
    wanted = (np.arange(first, max(last, first))[:, None] + phase).ravel()
    columns = []
    for column in values.T:
        known = np.isfinite(column)
        if known.sum() < 2:
            columns.append(np.full(len(wanted), np.nan))
            continue
        at = clock[known]
        found = np.interp(wanted, at, column[known])
        after = np.clip(np.searchsorted(at, wanted), 1, len(at) - 1)
        is_far = (at[after] - at[after - 1] > GAP) | (wanted > at[-1] + 1e-9) | (wanted < at[0] - 1e-9)
        columns.append(np.where(is_far, np.nan, found))
    return Folded(phase, np.stack(columns, 1).reshape(-1, samples, values.shape[1]))


def best_frequency(time: np.ndarray, values: np.ndarray, frequency: float, start: float, skip: int, samples: int) -> float:
    """Returns the frequency near the stated one with which the mean beat explains most; over the record it differs by half a
    beat at most."""
    count = max((time[-1] - time[0]) * frequency, 1)
    tried = frequency * (1 + np.linspace(-0.5, 0.5, 41) / count)
    shares = [float(np.mean(fold(time, values, f, start, skip, samples).explained())) for f in tried]
    best = int(np.argmax(shares))
    if 0 < best < len(tried) - 1:
        low, top, high = shares[best - 1:best + 2]
        bend = low - 2 * top + high
        if bend < 0:
            return float(tried[best] + (tried[1] - tried[0]) * 0.5 * (low - high) / bend)
    return float(tried[best])


def strongest_frequency(time: np.ndarray, values: np.ndarray) -> float:
    """Returns the strongest frequency in the spectrum of all components."""
    even = np.linspace(time[0], time[-1], len(time))
    power: np.ndarray | float = 0.0
    for column in values.T:
        known = np.isfinite(column)
        if known.sum() < 8:
            continue
        series = np.interp(even, time[known], column[known])
        power = power + np.abs(np.fft.rfft(series - series.mean()))**2 / max(series.var(), 1e-300)
    return float((np.argmax(power[1:]) + 1) / (time[-1] - time[0])) if isinstance(power, np.ndarray) else 0.0
