# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts a tool again with the Python of tools/quickstart if this one lacks packages. Every tool imports it first."""
from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path
from shutil import which

EVERYWHERE = ("numpy", "h5py", "matplotlib")
PACKAGES = (*EVERYWHERE, "scipy", "svgelements")  # of requirements.txt; the last two bend wings and read drawings
ROOT = Path(__file__).resolve().parents[2]  # of the source, or share/flusi-msm of an installation
INSTALLED = not (ROOT / "tools/quickstart").exists()
BEGUN = "FLUSI_MSM_BEGUN_AGAIN"  # environment variable of a tool that was started again


def stop_without(script: str, missing: Iterable[str]) -> None:
    """Ends a tool that lacks packages with a message and exit code 2."""
    remedy = f"Install them: pip install -r {ROOT / 'tools/requirements.txt'}" if INSTALLED else \
        "'tools/quickstart deps' installs what tools need in .venv, where they find it; or: pip install -r tools/requirements.txt"
    print(f"{script}: {sys.executable} has no {', '.join(missing)}. {remedy}", file=sys.stderr)
    sys.exit(2)


def is_better(own: Path, missing: Iterable[str]) -> bool:
    """Returns whether the Python in `own` has the packages that all tools need, and at least one that is missing here."""
    def has(name: str) -> bool:
        return any(own.glob(f"lib*/python*/site-packages/{name}"))

    return (own / "bin/python").exists() and all(map(has, EVERYWHERE)) and any(map(has, missing))


def program(name: str) -> Path:
    """Returns where flusi, msm_train or msm_diagnose is: in the build of the source, next to the installation, or in PATH."""
    if not INSTALLED:
        return ROOT / f"build/release/bin/{name}"
    beside = ROOT.parents[1] / f"bin/{name}"
    return beside if beside.exists() else Path(which(name) or name)


def use_project_python() -> None:
    """Goes on with the Python of the project if this one lacks packages."""
    was_begun_again = os.environ.pop(BEGUN, "") != ""
    missing = [name for name in PACKAGES if find_spec(name) is None]
    script = Path(sys.argv[0])
    if not missing or not script.is_file() or ROOT not in script.resolve().parents:
        return  # another program that imports a tool has to find its packages itself
    own = ROOT / ".venv"
    if not was_begun_again and is_better(own, missing):
        python = str(own / "bin/python")
        os.execve(python, [python, *sys.argv], {**os.environ, BEGUN: "yes"})
    if set(missing) & set(EVERYWHERE):
        stop_without(script.name, missing)


use_project_python()
