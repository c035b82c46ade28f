# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes records of forces and landmarks over the beat to measurement files (docs/formats/measurement-format.md)."""
from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.seal import write_seal

WORDS = ("components", "units", "frame")
WHOLE = ("beats", "per_length")


def stored(key: str, value: Any) -> Any:
    """Returns the value of an attribute in the type of the format."""
    return np.bytes_(value) if key in WORDS else np.int32(value) if key in WHOLE else np.asarray(value, "<f8")


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
                group.attrs[key] = stored(key, value)
            for key, numbers in data.items():
                group.create_dataset(key, data=np.asarray(numbers, "<f8"), track_times=False)
        write_seal(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written: {error}") from error


def write_landmarks(path: str | Path, name: str, attributes: Mapping[str, Any], cameras: Mapping[str, Any],
                    wings: Mapping[str, Mapping[str, np.ndarray]]) -> None:
    """Adds landmarks to the record `name` of a measurement file, and seals the file; makes file and record if they are missing.
    `attributes` are those of the record, `cameras` those of its group `landmarks`, and wings[side] has time, points, mean, and sd or
    spread."""
    import h5py
    try:
        with h5py.File(path, "a", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_("flusi-msm measurement")
            file.attrs["version"] = np.int32(1)
            record = file.require_group(f"flight/{name}")
            if "landmarks" in record:
                raise InputError(f"{path}: the flight {name} has landmarks already; give another name")
            if "frequency" in record.attrs and not np.isclose(record.attrs["frequency"], attributes["frequency"], rtol=1e-9):
                raise InputError(f"{path}: the flight {name} has the frequency {record.attrs['frequency']:g} Hz, not "
                                 f"{attributes['frequency']:g} Hz; give another name")
            for key, value in {"frame": "lab", **attributes}.items():
                if key not in record.attrs:
                    record.attrs[key] = stored(key, value)
            group = record.create_group("landmarks")
            for key, value in cameras.items():
                group.attrs[key] = stored(key, value)
            for side, data in wings.items():
                for key, numbers in data.items():
                    found = group.create_dataset(f"{side}/{key}", data=np.asarray(numbers, "<f8"), track_times=False)
                    if key == "points":
                        found.attrs["units"] = np.bytes_("m")
        write_seal(path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written: {error}") from error
