#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes wing files from drawings, tables and numbers: see --help and docs/make-wing.md."""
import _project_python  # noqa: F401

from flusi_msm.wing.command import main

if __name__ == "__main__":
    main()
