# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a script that opens a run in ParaView."""
