# SPDX-License-Identifier: GPL-3.0-or-later
"""VTKHDF files of a run: `index` reads its XDMF indices, `fields` and `surfaces` write what ParaView opens instead, `command` is
`tools/to_vtkhdf`."""
