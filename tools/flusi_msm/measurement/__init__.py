# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes synthetic bending tests with the errors of an instrument, and writes measurement files."""
