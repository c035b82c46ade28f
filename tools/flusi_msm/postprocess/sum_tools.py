# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools that compute numbers or tables from fields: norms, spectra, distributions, scales of a turbulent flow."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Callable

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.postprocess.fields import XYZ, Field
from flusi_msm.postprocess.registry import Call, as_count, as_number, tool, write_text
from flusi_msm.postprocess.spectral import curl_component, shell_energies, shell_width


def _mean(fields: Sequence[Field], function: Callable[..., np.ndarray]) -> float:
    """Returns the mean over the points of function(values of the first field, of the second, ...)."""
    total = 0.0
    for box in fields[0].slabs():
        total += float(np.sum(function(*(f.read(box) for f in fields))))
    return total / float(np.prod(fields[0].n, dtype=float))


@tool("statistics", "FIELD", "smallest and largest value, mean, standard deviation, L1, L2 and largest norm of a field "
      "(norms are means over the points)", writes_fields=False)
def statistics(call: Call) -> None:
    f, = call.fields(call.words)
    low = min(float(f.read(box).min()) for box in f.slabs())
    high = max(float(f.read(box).max()) for box in f.slabs())
    mean = _mean([f], lambda v: v)
    spread = np.sqrt(_mean([f], lambda v: (v - mean)**2))
    for name, value in (("smallest", low), ("largest", high), ("mean", mean), ("standard deviation", spread),
                        ("L1 norm", _mean([f], np.abs)), ("L2 norm", np.sqrt(_mean([f], np.square))),
                        ("largest |f|", max(abs(low), abs(high)))):
        print(f"{name:20}{value:24.16e}")


@tool("difference", "FIELD REFERENCE OUT", "norms of FIELD - REFERENCE, alone and relative to those of the reference; with OUT the "
      "difference is saved", optional=1)
def difference(call: Call) -> None:
    one, two = call.fields(call.words[:2], call.words[2:])
    square = np.sqrt(_mean([one, two], lambda a, b: (a - b)**2)), np.sqrt(_mean([two], np.square))
    largest = (max(float(np.abs(one.read(box) - two.read(box)).max()) for box in one.slabs()),
               max(float(np.abs(two.read(box)).max()) for box in two.slabs()))
    print(f"{'':20}{'difference':>24}{'reference':>24}{'relative':>24}")
    for name, (error, scale) in (("L2 norm", square), ("largest |f|", largest)):
        relative = f"{error / scale:24.16e}" if scale > 0 else f"{'(reference is 0)':>24}"
        print(f"{name:20}{error:24.16e}{scale:24.16e}{relative}")
    if len(call.words) > 2:
        with call.output(call.words[2], one) as out:
            for box in one.slabs():
                out.write(one.read(box) - two.read(box), box)


@tool("pdf", "FIELD OUT.txt", "probability density of the values of a field", writes_fields=False,
      options={"bins": (1, "number of bins (100)"), "range": (2, "smallest and largest value; values beyond are counted in no bin")})
def density(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:])
    bins = as_count(call.options.get("bins", ["100"])[0], "--bins", 1)
    if call.has("range"):
        low, high = (as_number(text, "--range") for text in call.options["range"])
    else:
        low = min(float(f.read(box).min()) for box in f.slabs())
        high = max(float(f.read(box).max()) for box in f.slabs())
    if not low < high:
        raise InputError(f"{f.path}: all values are {low:g}, or --range is empty: there is nothing to distribute")
    edges = np.linspace(low, high, bins + 1)
    counts = np.sum([np.histogram(f.read(box), edges)[0] for box in f.slabs()], axis=0)
    values = counts / np.prod(f.n, dtype=float) / np.diff(edges)
    lines = ["% value (middle of the bin)  probability density"]
    lines += [f"{0.5 * (a + b):24.16e}{v:24.16e}" for a, b, v in zip(edges[:-1], edges[1:], values)]
    write_text(call.words[1], lines, call.words[:1], show=False)
    print(f"{call.words[1]}: {bins} bins from {low:.6g} to {high:.6g}, {100 * counts.sum() / np.prod(f.n, dtype=float):.4g} % of the points")


@tool("spectrum", "UX [UY UZ] OUT.txt", "energy spectrum: what the shells of wavenumbers have of the mean of |u|^2/2, as iSaveSpectrae "
      "writes it (all modes of the grid); of one field alone: of the mean of f^2/2", "2 fields", optional=2, writes_fields=False)
def spectrum(call: Call) -> None:
    *inputs, path = call.words
    if len(inputs) not in (1, 3):
        raise InputError("spectrum: needs UX UY UZ OUT.txt, or FIELD OUT.txt")
    u = call.fields(inputs, [path], same_time=True)
    parts = [shell_energies(f) for f in u]
    lines = ["% k [1/L]  of u  of ux  of uy  of uz" if len(u) == 3 else f"% k [1/L]  of {u[0].dataset.lstrip('/')}"]
    for i, row in enumerate(zip(*parts)):
        values = (sum(row), *row) if len(u) == 3 else row
        lines.append("".join(f"{value:24.16e}" for value in (i * shell_width(u[0]), *values)))
    write_text(path, lines, inputs, show=False)
    print(f"{path}: {len(parts[0])} shells, mean {'kinetic energy' if len(u) == 3 else 'of f^2/2'} {sum(map(np.sum, parts)):.8g}")


@tool("mean-2D", "AXIS FIELD OUT.txt", "means over the planes across AXIS (x, y, z), one for each point along it; all: three files "
      "OUT.txt_x, OUT.txt_y, OUT.txt_z", writes_fields=False)
def mean_profile(call: Call) -> None:
    word, source, path = call.words
    if word not in ("x", "y", "z", "all"):
        raise InputError(f"mean-2D AXIS: '{word}' is not x, y, z or all")
    outputs = {c: f"{path}_{c}" if word == "all" else path for c in (XYZ if word == "all" else word)}
    f, = call.fields([source], list(outputs.values()))
    for c, name in outputs.items():
        _write_profile(name, f, c, np.mean, "mean")


@tool("max-over-x", "FIELD OUT.txt", "largest value on each plane across x", writes_fields=False)
def max_profile(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:])
    _write_profile(call.words[1], f, "x", np.max, "largest value")


def _write_profile(path: str, f: Field, c: str, reduce: Callable[..., np.ndarray], what: str) -> None:
    """Writes `reduce` of the values on each plane across an axis, and the coordinate of the plane; slabs contain whole planes."""
    direction = XYZ.index(c)
    axis = 2 - direction
    others = tuple(a for a in range(3) if a != axis)
    values = np.concatenate([reduce(f.read(box), axis=others) for box in f.slabs(axis)])
    place = f.origin[direction] + f.spacing[direction] * np.arange(len(values))
    lines = [f"% {what} of {f.dataset.lstrip('/')} on the plane  {c}"]
    write_text(path, lines + [f"{value:24.16e}{x:24.16e}" for value, x in zip(values, place)], [str(f.path)], show=False)
    print(f"{path}: {len(values)} planes, from {values.min():.6g} to {values.max():.6g}")


def _energy_and_enstrophy(u: list[Field]) -> tuple:
    energy = _mean(u, lambda x, y, z: 0.5 * (x * x + y * y + z * z))
    return energy, sum(0.5 * float(np.mean(curl_component(u, c)**2)) for c in range(3))


def _viscosity(call: Call, text: str, u: list[Field]) -> float:
    nu = as_number(text, f"{call.tool.name} NU") if text else u[0].number("viscosity" if "viscosity" in u[0].attributes else "nu")
    if nu <= 0:
        raise InputError(f"{call.tool.name}: the viscosity is {nu:g}, but must be positive")
    return nu


@tool("field-analysis", "UX UY UZ OUT.txt", "kinetic energy, enstrophy and dissipation (the viscosity is an attribute of the files)",
      "2 fields", writes_fields=False)
def analysis(call: Call) -> None:
    u = call.fields(call.words[:3], call.words[3:], same_time=True)
    nu, volume = _viscosity(call, "", u), float(np.prod(u[0].length))
    energy, enstrophy = _energy_and_enstrophy(u)
    rows = [("viscosity", nu)]
    for name, factor in (("total", volume), ("mean", 1.0)):
        rows += [(f"{name} kinetic energy", energy * factor), (f"{name} enstrophy, |curl u|^2/2", enstrophy * factor),
                 (f"{name} dissipation", 2 * nu * enstrophy * factor)]
    write_text(call.words[3], [f"{value:24.16e}  {name}" for name, value in rows], call.words[:3])


@tool("turbulence-analysis", "UX UY UZ NU OUT.txt", "scales of homogeneous turbulence: dissipation, Kolmogorov's and Taylor's scales, "
      "integral scale, Reynolds numbers, kmax eta", "2 fields", writes_fields=False)
def turbulence(call: Call) -> None:
    u = call.fields(call.words[:3], call.words[4:], same_time=True)
    nu = _viscosity(call, call.words[3], u)
    energy, enstrophy = _energy_and_enstrophy(u)
    if enstrophy <= 0:
        raise InputError(f"{u[0].path}: the flow is at rest, or uniform: it has no scales")
    eps, rms = 2 * nu * enstrophy, np.sqrt(2 / 3 * energy)
    shells = np.sum([shell_energies(f) for f in u], axis=0)
    k = shell_width(u[0]) * np.arange(len(shells))
    integral = np.pi / (2 * rms**2) * float(np.sum(shells[1:] / k[1:]))
    taylor, eta = np.sqrt(15 * nu * rms**2 / eps), (nu**3 / eps)**0.25
    kmax = min(2 / 3 * (m / 2 - 1) * 2 * np.pi / edge for m, edge in zip(u[0].n, u[0].length) if m > 1)
    rows = [("mean kinetic energy", energy), ("mean dissipation, 2 nu |curl u|^2/2", eps), ("Kolmogorov's length", eta),
            ("Kolmogorov's time", np.sqrt(nu / eps)), ("Kolmogorov's velocity", (nu * eps)**0.25), ("rms velocity, sqrt(2 E/3)", rms),
            ("Taylor's length, sqrt(15 nu/eps) rms", taylor), ("integral length, pi/(2 rms^2) sum E(k)/k", integral),
            ("Reynolds number of Taylor's length", rms * taylor / nu), ("Reynolds number of the integral length", rms * integral / nu),
            ("turnover time, integral length over rms", integral / rms), ("largest wavenumber kept, kmax", kmax),
            ("kmax times Kolmogorov's length", kmax * eta)]
    write_text(call.words[4], [f"{value:24.16e}  {name}" for name, value in rows], call.words[:3])


@tool("compare-timeseries", "SERIES REFERENCE", "largest difference of each column of two *.t files, and over the largest value of the reference; "
      "they must have the same times", writes_fields=False)
def compare_series(call: Call) -> None:
    one, two = (_read_series(path) for path in call.words)
    if one.shape != two.shape:
        raise InputError(f"{call.words[0]} has {one.shape[0]} records of {one.shape[1]} numbers, {call.words[1]} has {two.shape[0]} of "
                         f"{two.shape[1]}: only series with the same times can be compared")
    if np.abs(one[:, 0] - two[:, 0]).max() > 1e-6 * np.abs(two[:, 0]).max():
        raise InputError(f"{call.words[0]} and {call.words[1]} are of different times (first column)")
    print(f"{'column':>6}{'difference':>24}{'relative':>24}")
    for c in range(1, one.shape[1]):
        error, scale = np.abs(one[:, c] - two[:, c]).max(), np.abs(two[:, c]).max()
        print(f"{c + 1:6}{error:24.16e}" + (f"{error / scale:24.16e}" if scale > 0 else f"{'(reference is 0)':>24}"))


def _read_series(path: str) -> np.ndarray:
    try:
        values = np.loadtxt(path, comments="%", ndmin=2)
    except OSError:
        raise InputError(f"{path}: there is no such file") from None
    except ValueError:
        raise InputError(f"{path}: is not a series: rows of numbers, all of the same length") from None
    if values.size == 0:
        raise InputError(f"{path}: has no records")
    return values
