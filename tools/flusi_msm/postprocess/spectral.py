# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes derivatives, pressure, shells and resampling of periodic fields.

Derivatives work line by line, so that slabs of the input suffice. Arrays have the shape (nz, ny, nx).
"""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Callable

import numpy as np

from flusi_msm.postprocess.fields import Field, slabs_of

SCHEMES = ("spectral", "second-order", "fourth-order", "second-order-nonper")


def differentiate(values: np.ndarray, axis: int, spacing: float, scheme: str = "spectral") -> np.ndarray:
    """Returns the derivative along an axis of the array. The highest mode of an even number of points has none.

    second-order and fourth-order are central differences of a periodic field, second-order-nonper has one-sided ones
    at both ends. A direction of one point has no derivative.
    """
    n = values.shape[axis]
    if n == 1:
        return np.zeros_like(values)
    if scheme == "second-order-nonper":
        return np.gradient(values, spacing, axis=axis, edge_order=min(2, n - 1))
    if scheme == "spectral":
        k = 2 * np.pi / (n * spacing) * np.arange(n // 2 + 1)
        if n % 2 == 0:
            k[-1] = 0
        shape = [1, 1, 1]
        shape[axis] = -1
        return np.fft.irfft(1j * k.reshape(shape) * np.fft.rfft(values, axis=axis), n=n, axis=axis)
    near = np.roll(values, -1, axis) - np.roll(values, 1, axis)
    if scheme == "second-order":
        return near / (2 * spacing)
    far = np.roll(values, -2, axis) - np.roll(values, 2, axis)
    return (8 * near - far) / (12 * spacing)


def add_derivative(out: np.ndarray, field: Field, direction: int, factor: float = 1.0, scheme: str = "spectral") -> None:
    """Computes out = out + factor d field/d direction; the field is read in slabs."""
    axis, spacing = 2 - direction, float(field.spacing[direction])
    for box in slabs_of(field.shape, 1 if axis == 0 else 0):
        out[box] += factor * differentiate(field.read(box), axis, spacing, scheme)


def derivative(field: Field, direction: int, scheme: str = "spectral") -> np.ndarray:
    """Returns the derivative of a field along a direction."""
    out = np.zeros(field.shape)
    add_derivative(out, field, direction, 1.0, scheme)
    return out


def curl_component(u: Sequence[Field], c: int, scheme: str = "spectral") -> np.ndarray:
    """Returns component c of the curl of a vector field."""
    a, b = (c + 1) % 3, (c + 2) % 3
    out = derivative(u[b], a, scheme)
    add_derivative(out, u[a], b, -1.0, scheme)
    return out


def q_criterion(u: Sequence[Field], scheme: str = "spectral") -> np.ndarray:
    """Returns Q = -1/2 A_ij A_ji with A_ij = d u_i/d x_j."""
    q = np.zeros(u[0].shape)
    for i in range(3):
        q -= 0.5 * derivative(u[i], i, scheme)**2
        for j in range(i):
            q -= derivative(u[i], j, scheme) * derivative(u[j], i, scheme)
    return q


# ---- modes ---------------------------------------------------------------------------------------

def mode_numbers(n: Sequence[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns numbers jx, jy, jz of the modes of rfftn, as arrays that broadcast to (nz, ny, nx/2+1)."""
    jx = np.arange(n[0] // 2 + 1.0)
    jy, jz = (np.fft.fftfreq(m, 1 / m) for m in n[1:])
    return jx[None, None, :], jy[None, :, None], jz[:, None, None]


def wavenumbers(n: Sequence[int], length: np.ndarray, odd: bool = False) -> list[np.ndarray]:
    """Returns kx, ky, kz; with `odd` the highest mode of an even number of points is 0, as first derivatives need it."""
    ks = []
    for j, m, edge in zip(mode_numbers(n), n, length):
        k = 2 * np.pi / edge * j
        ks.append(np.where(2 * np.abs(j) == m, 0.0, k) if odd else k)
    return ks


def square(parts: Iterable[np.ndarray]) -> np.ndarray:
    """Returns the sum of the squares of the components of a vector."""
    return sum((part**2 for part in parts), np.zeros(()))


def is_kept(n: Sequence[int]) -> np.ndarray:
    """Returns which modes the truncation of the solver keeps (iDealias = 1): those inside of an ellipsoid."""
    radius = square(j / (2 / 3 * (m / 2 - 1)) for j, m in zip(mode_numbers(n), n) if m > 2)
    return np.broadcast_to(radius < 1 - 1e-12, (n[2], n[1], n[0] // 2 + 1))


def pressure(u: Sequence[Field], force: Callable[[int], np.ndarray] | None = None, truncate: bool = True) -> np.ndarray:
    """Returns p/density with -laplace p = d_i d_j u_i u_j - div f, periodic; its mean is -mean |u|^2/2, as in a run. force(i) is
    component i of the force f per mass on the fluid. With `truncate`, p has the modes that the solver keeps."""
    n, shape = u[0].n, u[0].shape
    odd = wavenumbers(n, u[0].length, odd=True)
    k2 = square(wavenumbers(n, u[0].length))
    k2[0, 0, 0] = 1
    total = np.zeros(k2.shape, complex)
    energy = 0.0
    product = np.empty(shape)
    for i in range(3):
        for j in range(i + 1):
            for box in slabs_of(shape):
                product[box] = u[i].read(box) * u[j].read(box)
            if i == j:
                energy += 0.5 * product.mean()
            total -= (1 if i == j else 2) * odd[i] * odd[j] * np.fft.rfftn(product)
        if force is not None:
            total -= 1j * odd[i] * np.fft.rfftn(force(i))
    total /= k2
    if truncate:
        total *= is_kept(n)
    total[0, 0, 0] = -energy * np.prod(n, dtype=float)
    return np.fft.irfftn(total, s=shape, axes=(0, 1, 2))


def inverse_curl(w: Sequence[Field], c: int) -> np.ndarray:
    """Returns component c of the velocity without divergence and mean whose curl is w (the law of Biot and Savart)."""
    n, a, b = w[0].n, (c + 1) % 3, (c + 2) % 3
    odd = wavenumbers(n, w[0].length, odd=True)
    k2 = square(wavenumbers(n, w[0].length))
    k2[0, 0, 0] = 1
    u = 1j * odd[a] * np.fft.rfftn(w[b].read())
    u -= 1j * odd[b] * np.fft.rfftn(w[a].read())
    return np.fft.irfftn(u / k2, s=w[0].shape, axes=(0, 1, 2))


def laplacian(field: Field) -> np.ndarray:
    """Returns the Laplacian of a field."""
    k2 = square(wavenumbers(field.n, field.length))
    return np.fft.irfftn(-k2 * np.fft.rfftn(field.read()), s=field.shape, axes=(0, 1, 2))


def shell_width(field: Field) -> float:
    """Returns dk: 2 pi over the longest side of the box that has more than one point."""
    return 2 * np.pi / max([edge for edge, m in zip(field.length, field.n) if m > 1], default=float(field.length.max()))


def shell_energies(field: Field) -> np.ndarray:
    """Returns the part of the mean of f^2/2 in each shell i = 0, 1, ...: that of the modes whose |k|/dk is nearest to i."""
    n, total = field.n, float(np.prod(field.n, dtype=float))
    k = np.sqrt(square(wavenumbers(n, field.length)))
    shells = np.floor(k / shell_width(field) + 0.5).astype(int)
    energy = np.abs(np.fft.rfftn(field.read()) / total)**2
    jx = np.arange(n[0] // 2 + 1)
    energy *= np.where((jx == 0) | (2 * jx == n[0]), 0.5, 1.0)  # other modes represent their conjugates, too
    return np.bincount(shells.ravel(), weights=energy.ravel())


# ---- resampling ----------------------------------------------------------------------------------

def resample_axis(values: np.ndarray, axis: int, n: int) -> np.ndarray:
    """Returns the trigonometric interpolant through the points along an axis, at n points.

    Exact for fields without modes above those of both numbers of points; to fewer points the higher modes are left out.
    """
    old = values.shape[axis]
    if old == n:
        return values
    modes = np.fft.rfft(values, axis=axis)
    few = min(old, n)
    kept = few // 2 + 1
    new = np.zeros([n // 2 + 1 if a == axis else m for a, m in enumerate(values.shape)], dtype=complex)
    part = tuple(slice(kept) if a == axis else slice(None) for a in range(3))
    new[part] = modes[part]
    if few % 2 == 0:  # only in the shorter row the highest mode is its own conjugate
        last = tuple(slice(kept - 1, kept) if a == axis else slice(None) for a in range(3))
        new[last] *= 0.5 if n > old else 2.0
    return np.fft.irfft(new, n=n, axis=axis) * (n / old)


def resample(field: Field, n: Sequence[int]) -> np.ndarray:
    """Returns the field at n = (nx, ny, nz) points of the same box, direction by direction; those with fewer new points go
    first."""
    values = field.read()
    for direction in sorted(range(3), key=lambda d: n[d] / field.n[d]):
        values = resample_axis(values, 2 - direction, n[direction])
    return values
