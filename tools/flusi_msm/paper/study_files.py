# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what a study of many flights found: its numbers as JSON, its pictures, and its page."""
from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flusi_msm.results.files import InputError

if TYPE_CHECKING:
    from flusi_msm.paper.ensemble import Ensemble
    from flusi_msm.paper.scan import Scan

Picture = tuple[str, str, Path]  # heading, caption, file


def write_study(folder: Path, study: Ensemble | Scan, found: dict[str, Any], draw: Callable[[dict[str, Any], Path], list[Picture]],
                page: Callable[[dict[str, Any], list[Picture]], str]) -> Path:
    """Writes NAME.json, NAME.html and the pictures, the last into the folder of the study. `draw(found, folder)` draws them and returns
    what `page(found, pictures)` needs. Returns the path of the page."""
    path = folder / f"{study.name}.html"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.with_suffix(".json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        with contextlib.redirect_stdout(io.StringIO()):
            pictures = draw(found, study.folder / "pictures")
        path.write_text(page(found, pictures), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from None
    return path
