# SPDX-License-Identifier: GPL-3.0-or-later
"""Blind cases: wings that hide something, their sealed truths, and the scores of the verdicts on them."""
