# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of rigid and flexible wings: flights, numbers, sentences, page."""
