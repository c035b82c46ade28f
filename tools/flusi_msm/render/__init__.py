# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices, wings and bodies in perspective."""
