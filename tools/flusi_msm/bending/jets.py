# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers that carry their first and second derivatives, for many elements at once. They give the exact gradient and Hessian of
an energy whose formula is written only once. Values may be complex, so that derivatives can be checked with complex steps."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar, final

import numpy as np


@final
class Jet:
    """A value (n,), its gradient (n, m) and, unless it is left out, its Hessian (n, m, m) with respect to m variables."""
    __slots__ = ("v", "g", "h")
    __array_ufunc__ = None  # so that an array leaves its product and difference with a jet to the jet

    def __init__(self, v: np.ndarray, g: np.ndarray, h: np.ndarray | None) -> None:
        self.v, self.g, self.h = v, g, h

    def __add__(self, other: Jet | np.ndarray | float) -> Jet:
        if isinstance(other, Jet):
            return Jet(self.v + other.v, self.g + other.g, None if self.h is None else self.h + other.h)
        return Jet(self.v + other, self.g, self.h)

    def __sub__(self, other: Jet | np.ndarray | float) -> Jet:
        if isinstance(other, Jet):
            return Jet(self.v - other.v, self.g - other.g, None if self.h is None else self.h - other.h)
        return Jet(self.v - other, self.g, self.h)

    def __rsub__(self, other: np.ndarray | float) -> Jet:
        return self * -1.0 + other

    def __mul__(self, other: Jet | np.ndarray | float) -> Jet:
        if not isinstance(other, Jet):
            factor = np.broadcast_to(other, self.v.shape)
            return Jet(self.v * factor, self.g * factor[:, None],
                       None if self.h is None else self.h * factor[:, None, None])
        v = self.v * other.v
        g = self.v[:, None] * other.g + other.v[:, None] * self.g
        if self.h is None:
            return Jet(v, g, None)
        h = self.g[:, :, None] * other.g[:, None, :]
        h = h + h.transpose(0, 2, 1)
        h += self.v[:, None, None] * other.h
        h += other.v[:, None, None] * self.h
        return Jet(v, g, h)

    __rmul__ = __mul__

    def through(self, f0: np.ndarray, f1: np.ndarray, f2: np.ndarray) -> Jet:
        """Returns f(self), given f and its first two derivatives at the value."""
        g = f1[:, None] * self.g
        if self.h is None:
            return Jet(f0, g, None)
        return Jet(f0, g, f1[:, None, None] * self.h + (f2[:, None] * self.g)[:, :, None] * self.g[:, None, :])


Number = TypeVar("Number", Jet, np.ndarray)  # what formulas are written for: jets, or plain values


def variables(values: np.ndarray, with_hessian: bool = True) -> list[Jet]:
    """Returns jets of the columns of values (n, m) as independent variables."""
    n, m = values.shape
    flat = np.zeros((n, m, m), values.dtype) if with_hessian else None
    unit = np.eye(m, dtype=values.dtype)
    return [Jet(values[:, k], np.broadcast_to(unit[k], (n, m)), flat) for k in range(m)]


def through(x: Number, f0: np.ndarray, f1: Callable[[], np.ndarray], f2: Callable[[], np.ndarray]) -> Number:
    """Returns f(x) of a jet or of plain values; f1 and f2 are functions without arguments."""
    if isinstance(x, Jet):
        return x.through(f0, f1(), f2())
    return f0


def value(x: Jet | np.ndarray) -> np.ndarray:
    """Returns the value of a jet, or the plain values themselves."""
    return x.v if isinstance(x, Jet) else x


def inverse_root(x: Number) -> Number:
    """Returns x**(-1/2)."""
    r = value(x)**-0.5
    return through(x, r, lambda: -0.5 * r**3, lambda: 0.75 * r**5)


def dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    """Returns the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Number], b: Sequence[Number]) -> list[Number]:
    """Returns the vector product of two vectors."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a: Sequence[Number]) -> list[Number]:
    """Returns the vector divided by its length."""
    scale = inverse_root(dot(a, a))
    return [c * scale for c in a]


TERMS = np.array([4.0, 4 / 3, 32 / 45, 16 / 35, 512 / 1575, 512 / 2079])  # of (2 asin sqrt s)^2 in powers of s


def squared_angle(s: Number) -> Number:
    """Returns (2 asin sqrt s)^2: the square of the angle between two unit vectors whose difference has the length 2 sqrt s."""
    v = value(s)
    small = np.abs(v) < 1e-3
    q = np.where(small, 0.25, np.minimum(v.real, 1 - 1e-10) + 1j * v.imag if np.iscomplexobj(v)
                 else np.minimum(v, 1 - 1e-10))
    a, r = np.arcsin(np.sqrt(q)), q * (1 - q)
    p = np.arange(1, len(TERMS) + 1)
    powers = [np.where(small, v, 0) ** k for k in range(len(TERMS) + 1)]

    def series(coefficients: np.ndarray, shift: int) -> np.ndarray:
        return sum(c * powers[k - shift] for c, k in zip(coefficients, p) if k >= shift)

    return through(s, np.where(small, series(TERMS, 0), 4 * a**2),
                   lambda: np.where(small, series(TERMS * p, 1), 4 * a / np.sqrt(r)),
                   lambda: np.where(small, series(TERMS * p * (p - 1), 2), 2 / r - 2 * a * (1 - 2 * q) / r**1.5))


def softened_sign(x: Number) -> Number:
    """Returns tanh x."""
    t = np.tanh(value(x))
    return through(x, t, lambda: 1 - t**2, lambda: -2 * t * (1 - t**2))
