# SPDX-License-Identifier: GPL-3.0-or-later
"""The style of all figures."""
from __future__ import annotations

import re
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from flusi_msm.errors import InputError

# These colours can be distinguished also by colour-blind readers and in grey.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C6D31"]

SMOOTHED = "means over 3 points"  # of a grid, in each direction


def use_style() -> None:
    """Makes the style that of all following figures."""
    matplotlib.rcParams.update({
        "font.size": 10, "axes.titlesize": 10, "legend.fontsize": 9, "legend.frameon": False,
        "axes.linewidth": 0.8, "lines.linewidth": 1.3, "xtick.direction": "in", "ytick.direction": "in",
        "axes.spines.top": False, "axes.spines.right": False, "mathtext.fontset": "dejavusans",
        "savefig.dpi": 150, "axes.formatter.limits": (-3, 4), "axes.formatter.use_mathtext": True,
    })


def name_of(*parts: object) -> str:
    """Returns a file name without blanks and slashes from the parts that distinguish pictures; parts that are None or empty are
    left out."""
    words = "_".join(str(part) for part in parts if part not in (None, ""))
    return re.sub(r"[^\w.+,=-]+", "-", words)


def save(figure: Figure, path: str | Path) -> None:
    """Writes the figure and prints its path."""
    try:
        figure.savefig(path, bbox_inches="tight", pad_inches=0.05)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot write the picture: {error}") from None
    plt.close(figure)
    print(path)
