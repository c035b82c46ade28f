# SPDX-License-Identifier: GPL-3.0-or-later
"""Files like those of a run, with contents known in closed form, for the tests of the Python tools."""
import contextlib
import io
import runpy
import sys
from collections import namedtuple
from pathlib import Path
from unittest import mock

import numpy as np

SOURCE = Path(__file__).resolve().parents[2]
TOOLS = SOURCE / "tools"


Finished = namedtuple("Finished", "returncode stdout stderr")


def run_tool(name, *arguments):
    """Runs a Python tool with its command line, in this process (importing matplotlib once saves time)."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    with mock.patch.object(sys, "argv", [name, *map(str, arguments)]), \
            contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            runpy.run_path(str(TOOLS / name), run_name="__main__")
        except SystemExit as stop:
            code = stop.code or 0
    return Finished(code, out.getvalue(), err.getvalue())


def grid(n, length):
    """x, y, z as arrays that broadcast to (nz, ny, nx)."""
    x, y, z = (np.arange(n[a]) * length[a] / n[a] for a in range(3))
    return x[None, None, :], y[None, :, None], z[:, None, None]


def write_field(folder, name, label, values, length, time, viscosity=0.01):
    """A field file as the solver writes it; `values` has the shape (nz, ny, nx)."""
    import h5py
    with h5py.File(Path(folder) / f"{name}_{label}.h5", "w") as file:
        data = file.create_dataset(name, data=np.asarray(values, dtype="f4"))
        data.attrs["time"] = np.array([time])
        data.attrs["viscosity"] = np.array([viscosity])
        data.attrs["epsi"] = np.array([1e-3])
        data.attrs["domain_size"] = np.array(length, dtype=float)
        data.attrs["origin"] = np.zeros(3)
        data.attrs["nxyz"] = np.array(values.shape[::-1], dtype="i4")


def write_velocity(folder, label, n, length, time, amplitude=1.0):
    """u = A (sin Y cos Z, sin Z cos X, sin X cos Y), capitals scaled by 2 pi/length; returns the exact curl."""
    kx, ky, kz = (2 * np.pi / value for value in length)
    x, y, z = grid(n, length)
    one = np.ones(n[::-1])
    u = [np.sin(ky * y) * np.cos(kz * z) * one, np.sin(kz * z) * np.cos(kx * x) * one,
         np.sin(kx * x) * np.cos(ky * y) * one]
    for name, values in zip(("ux", "uy", "uz"), u):
        write_field(folder, name, label, amplitude * values, length, time)
    curl = [-ky * np.sin(kx * x) * np.sin(ky * y) - kz * np.cos(kz * z) * np.cos(kx * x),
            -kz * np.sin(ky * y) * np.sin(kz * z) - kx * np.cos(kx * x) * np.cos(ky * y),
            -kx * np.sin(kz * z) * np.sin(kx * x) - ky * np.cos(ky * y) * np.cos(kz * z)]
    return [amplitude * c * one for c in curl]


def write_ball(folder, label, n, length, time, radius):
    """A smooth ball in the middle of the box as the mask."""
    x, y, z = grid(n, length)
    r = np.sqrt((x - length[0] / 2)**2 + (y - length[1] / 2)**2 + (z - length[2] / 2)**2)
    write_field(folder, "mask", label, np.clip(0.5 + (radius - r) * n[0] / length[0] / 3, 0, 1), length, time)


def picture(path):
    """(height, width, number of distinct colours) of a png."""
    from matplotlib.image import imread
    pixels = imread(str(path))
    packed = np.round(pixels[..., :3] * 255).astype(int) @ (65536, 256, 1)
    return pixels.shape[0], pixels.shape[1], len(np.unique(packed))


# ---- a run with flapping wings --------------------------------------------------------------------

UNITS = ("% units: L = 9.00000E-03 m, 1/T = 1.58000E+02 1/s, rho = 1.22500E+00 kg/m^3, "
         "force rho L^4/T^2 = 2.00600E-04 N, power rho L^5/T^3 = 2.85300E-04 W\n")
CYCLE_MEANS = {"lift": 3.5, "drag": 0.8, "aerodynamic power": 17.0, "inertial power": 0.0}


def write_table(path, columns, rows, units=UNITS):
    with open(path, "w", encoding="utf-8") as file:
        file.write("% " + "  ".join(f"{name:>14}" for name in columns) + "\n" + units)
        np.savetxt(file, rows, fmt="%16.8e")


def write_flapping_run(folder, cycles=4.0, steps=200, factor=1.0, drift=0.0, units=UNITS):
    """forces.t, aero_power.t, kinematics.t of wings that beat once per unit of time, with the cycle means
    factor CYCLE_MEANS, to which cycle n adds drift n to the lift. The force is split into two columns."""
    folder = Path(folder)
    folder.mkdir(exist_ok=True)
    t = np.arange(1, int(cycles * steps) + 1) / steps  # like a run: nothing at t = 0
    turn = 2 * np.pi * t
    zero = 0 * t
    unsteady = 0.4 * np.cos(turn)
    # A ramp with the same slope in all cycles: its mean in cycle n is drift n.
    lift = factor * (3.5 + 5 * np.sin(turn)) + drift * (t + 0.5)
    drag = factor * (0.8 + 2 * np.cos(2 * turn))
    force = [f"F{c}{u} [rho L^4/T^2]" for u in ("", " unsteady") for c in "xyz"]
    moment = [f"M{c}{u} [rho L^5/T^2]" for u in ("", " unsteady") for c in "xyz"]
    write_table(folder / "forces.t", ["time [T]", *force, *moment],
                np.column_stack([t, drag, zero, lift - unsteady, zero, zero, unsteady] + 6 * [zero]), units)
    write_table(folder / "aero_power.t",
                ["time [T]", "aerodynamic power [rho L^5/T^3]", "inertial power [rho L^5/T^3]"],
                np.column_stack([t, factor * (17 + 20 * np.sin(turn)**3), 12 * np.sin(2 * turn)]), units)
    names = ["time [T]", "xc [L]", "yc [L]", "zc [L]", "roll [rad]", "pitch [rad]", "yaw [rad]", "eta [rad]"]
    names += [f"{angle} {side} [rad]" for side in ("left", "right") for angle in ("alpha", "phi", "theta")]
    names += [f"{q}{c} {side} [{unit}]" for q, unit in (("omega", "rad/T"), ("omega rate ", "rad/T^2"))
              for side in ("left", "right") for c in "xyz"]
    phi = 1.18 * np.cos(turn)
    rows = np.column_stack([t] + 7 * [zero] + 2 * [0.8 * np.sin(turn), phi, zero] + 12 * [zero])
    write_table(folder / "kinematics.t", names, rows, units)


def axes_of(span, chord):
    """Rows x to the tip, y toward the leading edge, z of a wing frame."""
    span = np.asarray(span, dtype=float) / np.linalg.norm(span)
    chord = np.asarray(chord, dtype=float) - span * np.dot(span, chord)
    chord /= np.linalg.norm(chord)
    return np.array([span, chord, np.cross(span, chord)])


def write_wing(folder, label, side, local, triangles, hinge, matrix, time, bent=None):
    """The surface of a wing whose points are `local` in its frame, or with `bent` (n, 3) were `local` + `bent`."""
    import h5py
    with h5py.File(Path(folder) / f"wing_{side}_{label}.h5", "w") as file:
        file["points"] = (np.asarray(local) + (0 if bent is None else bent)) @ matrix + hinge
        if bent is not None:
            file["displacement"] = np.asarray(bent) @ matrix
        file["velocities"] = np.zeros_like(local, dtype=float)
        file["triangles"] = np.asarray(triangles, dtype="i4")
        file.attrs["time"], file.attrs["hinge"] = time, np.array(hinge)
        for c, axis in zip("xyz", matrix):
            file.attrs[f"axis_{c}"] = axis


def rectangle(span, chord, n_span=8, n_chord=4):
    """(points, triangles) of a flat wing with its leading edge at y = chord/3."""
    x, y = np.meshgrid(np.linspace(0, span, n_span + 1), np.linspace(-2 * chord / 3, chord / 3, n_chord + 1),
                       indexing="ij")
    corner = np.arange((n_span + 1) * (n_chord + 1)).reshape(x.shape)
    a, b, c, d = (corner[:-1, :-1].ravel(), corner[1:, :-1].ravel(), corner[1:, 1:].ravel(), corner[:-1, 1:].ravel())
    return np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]), np.vstack([np.column_stack([a, b, c]),
                                                                               np.column_stack([a, c, d])])
