# SPDX-License-Identifier: GPL-3.0-or-later
"""The look of all figures, under the name by which the scripts of this folder know it."""
from flusi_msm.style import COLOURS, plt, save, use_style  # noqa: F401
