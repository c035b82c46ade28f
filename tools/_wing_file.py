# SPDX-License-Identifier: GPL-3.0-or-later
"""The wings of the package flusi_msm, under the name by which the scripts of this folder know them."""
from flusi_msm.wing.file import (SCHEMA, VERSION, Z_SIDES, Wing, WingMass, add_z_side, read_wing, sorted_wing,  # noqa: F401
                                 write_wing)
