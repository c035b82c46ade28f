# SPDX-License-Identifier: GPL-3.0-or-later
"""What goes before and after a run of flusi-msm: wings, measurements, results, pictures.

`wing` makes, reads and draws wings. Functions take and return numpy arrays in SI units unless they say otherwise.
A mistake in what a user gave is an `InputError` whose text is meant for the user.
"""
from flusi_msm.errors import InputError

__all__ = ["InputError"]
__version__ = "0.1.0"
