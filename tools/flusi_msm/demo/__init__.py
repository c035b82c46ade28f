# SPDX-License-Identifier: GPL-3.0-or-later
"""Goes through the whole workflow once: a drawn wing is bent, trained, diagnosed and flown."""
