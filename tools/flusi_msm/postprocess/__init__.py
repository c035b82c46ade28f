# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes with field files: derivatives, spectra, means, parts of fields, under the names of FLUSI's tools.

Arrays of fields have the shape (nz, ny, nx), as in the files; directions are counted x, y, z = 0, 1, 2.
"""
