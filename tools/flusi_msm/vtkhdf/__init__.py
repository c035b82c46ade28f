# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes VTKHDF files of a run: `index` reads its XDMF indices, `fields` and `surfaces` write the files for ParaView, `command`
is `tools/to_vtkhdf`."""
