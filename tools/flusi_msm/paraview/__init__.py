# SPDX-License-Identifier: GPL-3.0-or-later
"""A script that opens a run in ParaView."""
