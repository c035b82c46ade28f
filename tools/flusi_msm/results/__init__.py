# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the files that a run writes: series, fields, sections, wing beats."""
