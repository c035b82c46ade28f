# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares rigid and flexible wings: flights, numbers, sentences, page."""
