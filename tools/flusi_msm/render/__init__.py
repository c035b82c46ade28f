# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws vortices, wings and bodies in perspective."""
