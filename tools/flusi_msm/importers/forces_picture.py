# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws imported forces: all beats at the same phases, their mean and spread."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from flusi_msm.style import COLOURS, save, use_style

if TYPE_CHECKING:
    from flusi_msm.importers.beats import Folded

MOST_BEATS = 60


def draw(found: Folded, components: Sequence[str], units: Sequence[str], path: Path) -> None:
    """Draws every component in a panel of its own."""
    use_style()
    figure, axes = plt.subplots(len(components), 1, figsize=(8, 2.2 * len(components) + 0.6), sharex=True, squeeze=False)
    mean, spread = found.mean(), found.spread()
    for k, (axis, name, unit) in enumerate(zip(axes[:, 0], components, units)):
        for beat in found.beats[:MOST_BEATS]:
            axis.plot(found.phase, beat[:, k], color="0.8", lw=0.5)
        axis.fill_between(found.phase, mean[:, k] - spread[:, k], mean[:, k] + spread[:, k], color=COLOURS[0], alpha=0.3, lw=0)
        axis.plot(found.phase, mean[:, k], color=COLOURS[0])
        axis.set_ylabel(f"{name} [{unit}]")
    axes[-1, 0].set(xlabel="time in beats", xlim=(0, 1))
    figure.tight_layout()
    save(figure, path)
    plt.close(figure)
