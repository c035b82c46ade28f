# SPDX-License-Identifier: GPL-3.0-or-later
"""Wings: in memory and in files, made from drawings or from numbers, and drawn as pictures."""
from flusi_msm.wing.file import Wing, read_wing, write_wing

__all__ = ["Wing", "read_wing", "write_wing"]
