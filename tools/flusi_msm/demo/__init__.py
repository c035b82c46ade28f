# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole way once: a drawn wing is bent, trained, diagnosed and flown."""
