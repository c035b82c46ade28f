# SPDX-License-Identifier: GPL-3.0-or-later
"""Imported first by every tool: begins it again with the Python of tools/quickstart where this one lacks packages."""
import os
import sys
from importlib.util import find_spec
from pathlib import Path

EVERYWHERE = ("numpy", "h5py", "matplotlib")
PACKAGES = (*EVERYWHERE, "scipy")  # those of requirements.txt; the last is for what bends wings
ROOT = Path(__file__).resolve().parent.parent


def stop_without(script, missing):
    """Ends a tool that lacks packages with a message and exit code 2."""
    print(f"{script}: {sys.executable} has no {', '.join(missing)}. 'tools/quickstart deps' installs what tools need in "
          f".venv, where they find it; or: pip install -r tools/requirements.txt", file=sys.stderr)
    sys.exit(2)


def use_project_python():
    missing = [name for name in PACKAGES if find_spec(name) is None]
    script = Path(sys.argv[0]).resolve()
    if not missing or ROOT not in script.parents:  # another program that imports a tool finds its packages itself
        return
    own = ROOT / ".venv"
    python = own / "bin/python"
    if python.exists() and Path(sys.prefix).resolve() != own:
        os.execv(python, [str(python), *sys.argv])
    if set(missing) & set(EVERYWHERE):
        stop_without(script.name, missing)


use_project_python()
