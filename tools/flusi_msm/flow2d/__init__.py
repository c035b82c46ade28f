# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the plane flow about a moving ellipse by a method that shares nothing with `flusi`: vorticity and stream function on a
grid of elliptic coordinates that moves with the body."""
