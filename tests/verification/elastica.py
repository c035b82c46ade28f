# SPDX-License-Identifier: GPL-3.0-or-later
"""The heavily bent cantilever under a weight at its tip, from its exact solution: EI theta'' = -F cos(theta).

With theta1 the tip's angle, sqrt(F L^2/EI) = int_0^theta1 dt/sqrt(2 (sin theta1 - sin t)), and the displacement
over L is the mean of sin t under the same weight; t = theta1 (1 - s^2) takes the singularity away.
"""
import numpy as np

NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)
S, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2


def integrals(angle):
    t = angle * (1 - S**2)
    f = WEIGHTS * 2 * angle * S / np.sqrt(2 * (np.sin(angle) - np.sin(t)))
    return f.sum(), (f * np.sin(t)).sum()


def deflection(alpha):
    """Displacement of the tip across the unloaded beam over its length, for alpha = F L^2/EI."""
    if alpha == 0:
        return 0.0
    low, high = 1e-9, np.pi / 2 - 1e-9
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if integrals(middle)[0] < np.sqrt(alpha) else (low, middle)
    length, height = integrals(low)
    return height / length


def fit(force, reading, loading, sd, length):
    """EI, its standard deviation, zeros and the sum of squares of readings (down is negative) with a zero of every
    loading (0, 1, ...): Gauss and Newton with differences in ln EI."""
    log_ei = np.log(force.max() * length**2 / 3)
    zeros = np.eye(loading.max() + 1)[loading]
    for _ in range(12):
        def tip(x):
            return np.array([-length * deflection(f * length**2 / np.exp(x)) for f in force])
        columns = np.column_stack([(tip(log_ei + 1e-4) - tip(log_ei - 1e-4)) / 2e-4, zeros])
        solution = np.linalg.lstsq(columns, reading - tip(log_ei), rcond=None)[0]
        log_ei += solution[0]
    left = reading - tip(log_ei) - zeros @ solution[1:]
    covariance = sd**2 * np.linalg.inv(columns.T @ columns)
    return np.exp(log_ei), np.exp(log_ei) * covariance[0, 0]**0.5, solution[1:], (left**2).sum() / sd**2
