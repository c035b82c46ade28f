# SPDX-License-Identifier: GPL-3.0-or-later
"""Restricts sums to one thread, so that they have one order. It is imported before numpy where a result must be the same to the
bit on every machine."""
import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
