# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes regular grids of heights."""
from __future__ import annotations

import numpy as np


def grid_lines(low: float, high: float, spacing: float) -> np.ndarray:
    """Returns grid lines that cover low to high with a margin, symmetric about their middle."""
    count = int(np.ceil((high - low) / spacing)) + 2
    return (low + high) / 2 + spacing * (np.arange(count) - (count - 1) / 2)
