# SPDX-License-Identifier: GPL-3.0-or-later
"""The mechanics of bent wings for synthetic measurements; they share no code with the solver."""
