# SPDX-License-Identifier: GPL-3.0-or-later
"""Synthetic bending tests with the errors of an instrument, and the measurement file."""
