# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes records of forces over the beat to measurement files (docs/formats/measurement-format.md)."""
from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.seal import write_seal

WORDS = ("components", "units", "frame")
WHOLE = ("beats", "per_length")


def write_record(path: str | Path, name: str, attributes: Mapping[str, Any], data: Mapping[str, np.ndarray]) -> None:
    """Makes a measurement file, or adds the record `name` to one that exists, and seals it."""
    import h5py
    try:
        with h5py.File(path, "a", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_("flusi-msm measurement")
            file.attrs["version"] = np.int32(1)
            if f"flight/{name}" in file:
                raise InputError(f"{path}: has a flight {name} already; give another name")
            group = file.create_group(f"flight/{name}")
            for key, value in {"frame": "lab", **attributes}.items():
                group.attrs[key] = (np.bytes_(value) if key in WORDS else np.int32(value) if key in WHOLE
                                    else np.asarray(value, "<f8"))
            for key, numbers in data.items():
                group.create_dataset(key, data=np.asarray(numbers, "<f8"), track_times=False)
        write_seal(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written: {error}") from error
