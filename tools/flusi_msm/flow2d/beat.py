# SPDX-License-Identifier: GPL-3.0-or-later
"""A periodic motion of a section: the place of its hinge and the angle of its chord as Fourier series of the phase of the beat.
"""
from __future__ import annotations

from typing import Callable

import numpy as np

SAMPLES = 2048
HARMONICS = 40   # Fourier series of motions with corners are cut off here


class Beat:
    """A motion: place(phase) -> (y, z) and angle(phase) -> radians from +y to the chord's leading end, counter-clockwise seen
    from +x. Both take an array of phases in [0, 1) and give arrays."""

    def __init__(self, place: Callable, angle: Callable, period: float) -> None:
        phase = np.arange(SAMPLES) / SAMPLES
        y, z = place(phase)
        values = np.stack([y + 0 * phase, z + 0 * phase, angle(phase) + 0 * phase])
        self.series = np.fft.rfft(values, axis=1)[:, :HARMONICS + 1] / SAMPLES
        self.series[:, 1:] *= 2
        self.rates = 2j * np.pi * np.arange(HARMONICS + 1) / period
        self.period = period

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Returns value, rate and acceleration of y, z and the angle: three arrays (times, 3)."""
        wave = np.exp(np.outer(np.atleast_1d(time), self.rates))
        return tuple((wave * self.rates**n @ self.series.T).real for n in range(3))
