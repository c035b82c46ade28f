# SPDX-License-Identifier: GPL-3.0-or-later
"""Imported before numpy where a result must be the same to the bit on every machine: sums of one thread have one order."""
import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
