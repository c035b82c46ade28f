# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes regular grids of heights."""
import numpy as np


def grid_lines(low, high, spacing):
    """Returns grid lines that cover low to high with a margin, symmetric about their middle."""
    count = int(np.ceil((high - low) / spacing)) + 2
    return (low + high) / 2 + spacing * (np.arange(count) - (count - 1) / 2)
