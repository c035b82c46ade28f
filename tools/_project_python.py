# SPDX-License-Identifier: GPL-3.0-or-later
"""Imported first by every tool: begins it again with the Python of tools/quickstart where this one lacks packages."""
import os
import sys
from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("numpy", "h5py", "matplotlib", "scipy")  # those of requirements.txt
ROOT = Path(__file__).resolve().parent.parent


def use_project_python():
    missing = [name for name in PACKAGES if find_spec(name) is None]
    script = Path(sys.argv[0]).resolve()
    if not missing or ROOT not in script.parents:  # another program that imports a tool finds its packages itself
        return
    own = ROOT / ".venv"
    python = own / "bin/python"
    if python.exists() and Path(sys.prefix).resolve() != own:
        os.execv(python, [str(python), *sys.argv])
    sys.exit(f"{script.name}: {sys.executable} has no {', '.join(missing)}. 'tools/quickstart deps' installs what tools need "
             f"in .venv, where they find it; or: pip install -r tools/requirements.txt")


use_project_python()
