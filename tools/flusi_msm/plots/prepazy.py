# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws readings of a beam's tip, the fitted beam and the residuals (docs/results/prepazy.md).

usage: bench_prepazy prepazy.h5 measurement.h5 > fit.txt; plot_prepazy fit.txt -o prepazy.png
"""
from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from flusi_msm.errors import InputError, run_command
from flusi_msm.style import COLOURS, plt, save, use_style


def read_fit(path: str | Path) -> tuple[dict[str, tuple[float, ...]], dict[str, np.ndarray]]:
    """Returns {unknown: (value, lower, upper)} and {loading: array (n, 4) of force [N], reading, computed, sd [m]}."""
    unknowns: dict[str, tuple[float, ...]] = {}
    loadings: dict[str, list[list[float]]] = {}
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
        for line in lines:
            words = line.split()
            if line.startswith("%") and "interval" in line:
                unknowns[words[1]] = tuple(float(word) for word in words[2:5])
            elif words and not line.startswith("%"):
                loadings.setdefault(words[0], []).append([float(word) for word in words[1:5]])
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise InputError(f"{path}: not what bench_prepazy prints: {error}") from error
    if "EI" not in unknowns or not loadings or any(f"zero:{name}" not in unknowns for name in loadings):
        raise InputError(f"{path}: not what bench_prepazy prints: a determined EI and zero of every loading are needed")
    return unknowns, {name: np.array(rows) for name, rows in loadings.items()}


def draw(unknowns: Mapping[str, tuple[float, ...]], loadings: Mapping[str, np.ndarray]) -> Figure:
    """Draws readings, fit and residuals."""
    use_style()
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(6.0, 6.0), sharex=True, height_ratios=(3, 2))
    stiffness, low, high = unknowns["EI"]
    for (name, rows), colour, marker in zip(loadings.items(), COLOURS, "os^vD<"):
        zero = unknowns[f"zero:{name}"][0]
        force, reading, computed, sd = rows.T
        top.plot(force, 1e3 * (reading - zero), marker, color=colour, mfc="none", label=f"{name} loading, "
                 f"zero {1e3 * zero:.1f} mm")
        bottom.errorbar(force, 1e3 * (reading - computed), 1e3 * sd, fmt=marker, color=colour, mfc="none", lw=0.8)
    every = np.concatenate([np.column_stack([rows[:, 0], rows[:, 2] - unknowns[f"zero:{name}"][0]])
                            for name, rows in loadings.items()])
    every = every[np.argsort(every[:, 0])]
    top.plot(every[:, 0], 1e3 * every[:, 1], color="black", lw=1,
             label=f"beam, EI = {stiffness:.3f} N m² ({low:.3f} to {high:.3f})")
    top.set_ylabel("tip displacement [mm]")
    top.legend()
    bottom.axhline(0, color="black", lw=0.8)
    bottom.set_xlabel("weight at the tip [N]")
    bottom.set_ylabel("read minus computed [mm]")
    figure.align_ylabels()
    return figure


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fit", metavar="FIT.txt", help="what bench_prepazy printed")
    parser.add_argument("-o", "--output", required=True, metavar="PICTURE")
    options = parser.parse_args()
    save(draw(*read_fit(options.fit)), options.output)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_prepazy", main)
