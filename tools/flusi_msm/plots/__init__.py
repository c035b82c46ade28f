# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands that draw or compare what one or more runs wrote."""
