# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools for velocities and derivatives of fields."""
from __future__ import annotations

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.postprocess.fields import slabs_of
from flusi_msm.postprocess.registry import ORDERS, Call, tool
from flusi_msm.postprocess.spectral import add_derivative, curl_component, derivative, inverse_curl, is_kept, laplacian, pressure, q_criterion, wavenumbers

SCHEME_OPTIONS = {"second-order": (0, "central differences of a periodic field"),
                  "fourth-order": (0, "the same, with five points"),
                  "second-order-nonper": (0, "one-sided at the ends: for fields that are parts of a box")}
ONE, TWO, THREE = "1 field", "2 fields", "3 fields"


def scheme_of(call: Call) -> str:
    """Returns the method of differentiation; the tools named ...-FD take second-order if none is given."""
    chosen = [order for order in ORDERS if call.has(order)]
    if len(chosen) > 1:
        raise InputError(f"--{chosen[0]} and --{chosen[1]} exclude each other: give one of them")
    return chosen[0] if chosen else "second-order" if call.tool.name.endswith("-FD") else "spectral"


def _vorticity(call: Call) -> None:
    u = call.fields(call.words[:3], call.words[3:], same_time=True)
    for c in range(3):
        call.save(call.words[3 + c], u[0], curl_component(u, c, scheme_of(call)))


def _vor_abs(call: Call) -> None:
    u = call.fields(call.words[:3], call.words[3:], same_time=True)
    total = np.zeros(u[0].shape)
    for c in range(3):
        total += curl_component(u, c, scheme_of(call))**2
    call.save(call.words[3], u[0], np.sqrt(total, out=total))


def _q(call: Call) -> None:
    u = call.fields(call.words[:3], call.words[3:], same_time=True)
    call.save(call.words[3], u[0], q_criterion(u, scheme_of(call)))


for _end, _how in (("", "spectral"), ("-FD", "by differences (second order unless an option says otherwise)")):
    tool(f"vorticity{_end}", "UX UY UZ VORX VORY VORZ", f"curl of a velocity, {_how}", ONE, SCHEME_OPTIONS)(_vorticity)
    tool(f"vor-abs{_end}", "UX UY UZ VORABS", f"magnitude of the curl of a velocity, {_how}", TWO, SCHEME_OPTIONS,
         [f"vor_abs{_end}"])(_vor_abs)
    tool(f"Q{_end}", "UX UY UZ Q", f"Q = -1/2 A_ij A_ji with A_ij = du_i/dx_j, {_how}", THREE, SCHEME_OPTIONS)(_q)


@tool("divergence", "UX UY UZ DIV", "divergence of a vector field", ONE, SCHEME_OPTIONS)
def divergence(call: Call) -> None:
    u = call.fields(call.words[:3], call.words[3:], same_time=True)
    out = np.zeros(u[0].shape)
    for c in range(3):
        add_derivative(out, u[c], c, 1.0, scheme_of(call))
    call.save(call.words[3], u[0], out)


@tool("gradient", "FIELD DX DY DZ", "gradient of a field", ONE, SCHEME_OPTIONS)
def gradient(call: Call) -> None:
    f, = call.fields(call.words[:1], call.words[1:])
    for c in range(3):
        call.save(call.words[1 + c], f, derivative(f, c, scheme_of(call)))


@tool("helicity", "UX UY UZ HELICITY", "u.curl u", TWO,
      {"normalized": (0, "over |u| |curl u|, 0 where that is below 1e-5: the cosine of the angle between them")})
def helicity(call: Call) -> None:
    u = call.fields(call.words[:3], call.words[3:], same_time=True)
    out = np.zeros(u[0].shape)
    squares = np.zeros(u[0].shape) if call.has("normalized") else None
    for c in range(3):
        curl = curl_component(u, c)
        for box in slabs_of(out.shape):
            out[box] += u[c].read(box) * curl[box]
        if squares is not None:
            squares += curl**2
    if squares is not None:
        for box in slabs_of(out.shape):
            norm = np.sqrt(squares[box] * sum(f.read(box)**2 for f in u))
            out[box] = np.where(norm >= 1e-5, out[box] / np.maximum(norm, 1e-5), 0.0)
    call.save(call.words[3], u[0], out)


@tool("pressure", "UX UY UZ P MASK USX USY USZ", "pressure of a periodic velocity; with mask and velocity of the solids that "
      "of the penalized flow (epsi is read from the mask's file)", "5 fields", {
          "zero-mean": (0, "with mean 0, as FLUSI's tool writes it; else -mean |u|^2/2, as runs save it"),
          "all-modes": (0, "keep all modes of the grid; else those inside the truncation, as runs save it")}, optional=4)
def pressure_of(call: Call) -> None:
    if len(call.words) not in (4, 8):
        raise InputError("pressure: needs UX UY UZ P, or these and MASK USX USY USZ (a parameter file is not read: run flusi with "
                         "iSavePress = yes, or give the mask)" if call.words[0].endswith(".h5") else
                         "pressure: parameter files are not read: give UX UY UZ P MASK USX USY USZ, with mask and usx, usy, usz of a run")
    solids = call.words[4:]
    u = call.fields(call.words[:3] + solids, call.words[3:4], same_time=True)
    force = None
    if solids:
        mask, us, epsi = u[3], u[4:], u[3].number("epsi")
        if epsi <= 0:
            raise InputError(f"{mask.path}: epsi = {epsi:g} must be positive")

        def force(i: int) -> np.ndarray:
            out = np.empty(mask.shape)
            for box in slabs_of(out.shape):
                out[box] = -mask.read(box) / epsi * (u[i].read(box) - us[i].read(box))
            return out
    p = pressure(u[:3], force, not call.has("all-modes"))
    if call.has("zero-mean"):
        p -= p.mean()
    call.save(call.words[3], u[0], p)


@tool("p2Q", "P Q", "Q of a flow without forces from its pressure: laplace p / 2", THREE)
def q_of_pressure(call: Call) -> None:
    p, = call.fields(call.words[:1], call.words[1:])
    call.save(call.words[1], p, 0.5 * laplacian(p))


@tool("vor2u", "VORX VORY VORZ", "velocity without divergence and mean that has a given vorticity (the law of Biot and Savart); "
      "without options written beside VORX as ux, uy, uz", "5 fields",
      {"outfiles": (3, "names of the three files"), "outputprefix": (1, "NAME gives NAMEx_..., NAMEy_..., NAMEz_...")})
def velocity_of(call: Call) -> None:
    prefix = call.options.get("outputprefix", ["u"])[0]
    outputs = call.options.get("outfiles")
    if outputs is None:
        folder, _, name = call.words[0].rpartition("/")
        label = name.split("_", 1)[1] if "_" in name else "0.h5"
        outputs = [f"{folder + '/' if folder else ''}{prefix}{c}_{label}" for c in "xyz"]
    w = call.fields(call.words[:3], outputs, same_time=True)
    for c in range(3):
        call.save(outputs[c], w[0], inverse_curl(w, c))


@tool("ux-from-uyuz", "UX UY UZ", "writes the ux that makes the velocity free of divergence; its mean over x is 0", "4 fields")
def complete(call: Call) -> None:
    u = call.fields(call.words[1:3], call.words[:1], same_time=True)
    k = wavenumbers(u[0].n, u[0].length, odd=True)
    total = k[1] * np.fft.rfftn(u[0].read()) + k[2] * np.fft.rfftn(u[1].read())
    kx = np.where(k[0] == 0, np.inf, k[0])
    call.save(call.words[0], u[0], np.fft.irfftn(-total / kx * is_kept(u[0].n), s=u[0].shape, axes=(0, 1, 2)))
