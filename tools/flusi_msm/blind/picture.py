# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the confusion matrix of blind cases."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib

from flusi_msm.blind.scores import Case

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from flusi_msm.blind.scores import confusion_of
from flusi_msm.style import save, use_style


def draw_confusion(path: Path, cases: Sequence[Case]) -> None:
    """Draws the counts of cases by true cause and verdict; colours are shares of the row."""
    rows, columns, counts = confusion_of(cases)
    use_style()
    figure, axes = plt.subplots(figsize=(1.5 + 0.42 * len(columns), 1.5 + 0.3 * len(rows)))
    share = counts / np.maximum(counts.sum(1, keepdims=True), 1)
    axes.imshow(share, cmap="Blues", vmin=0, vmax=1.2, aspect="auto")
    for (i, j), n in np.ndenumerate(counts):
        if n:
            axes.text(j, i, str(n), ha="center", va="center", fontsize=8, color="white" if share[i, j] > 0.7 else "black")
    axes.set_xticks(range(len(columns)), columns, rotation=60, ha="right", fontsize=8)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.set_xlabel("verdict")
    axes.set_ylabel("hidden cause")
    axes.tick_params(length=0)
    save(figure, path)
