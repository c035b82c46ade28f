# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers of what a run writes: series, fields, sections, wing beats."""
