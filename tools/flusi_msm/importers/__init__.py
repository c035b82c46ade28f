# SPDX-License-Identifier: GPL-3.0-or-later
"""Wings and measurements from files of other programs and instruments."""
