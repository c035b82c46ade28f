# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes records of forces and landmarks over the beat to measurement files (docs/formats/measurement-format.md)."""
from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
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


def is_record_name(name: str) -> bool:
    """Tells whether a record of a flight may have this name: a slash or a point alone is a place in the file to HDF5."""
    return name not in ("", ".") and "/" not in name


@contextmanager
def measurement_file(path: str | Path, is_new: bool) -> Iterator[Any]:
    """Gives an HDF5 file to write: a copy of `path` if that exists, or an empty one. It is sealed and takes the place of `path` when
    all is written; otherwise `path` stays as it was."""
    import h5py
    part = Path(f"{path}.part")
    try:
        part.unlink(missing_ok=True)
        if Path(path).exists() and not is_new:
            shutil.copyfile(path, part)
        with h5py.File(part, "a", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_("flusi-msm measurement")
            file.attrs["version"] = np.int32(1)
            yield file
        write_seal(part)
        os.replace(part, path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be written: {error}") from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def write_record(path: str | Path, name: str, attributes: Mapping[str, Any], data: Mapping[str, np.ndarray], is_new: bool = False) -> None:
    """Makes a measurement file, or adds the record `name` to one that exists and is not to be made new, and seals it."""
    with measurement_file(path, is_new) as file:
        if f"flight/{name}" in file:
            raise InputError(f"{path}: has a flight {name} already; give another name")
        group = file.create_group(f"flight/{name}")
        for key, value in {"frame": "lab", **attributes}.items():
            group.attrs[key] = stored(key, value)
        for key, numbers in data.items():
            group.create_dataset(key, data=np.asarray(numbers, "<f8"), track_times=False)


def check_same_flight(path: str | Path, name: str, found: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Refuses facts that contradict those of a record that exists. Without `per_length` a record is of a whole wing."""
    if not np.isclose(found["frequency"], wanted["frequency"], rtol=1e-9):
        raise InputError(f"{path}: the flight {name} has the frequency {found['frequency']:g} Hz, not {wanted['frequency']:g} Hz; give another "
                         "name")
    own = int(found.get("per_length", 0))
    other = int(wanted.get("per_length", own))
    if own != other:
        raise InputError(f"{path}: the flight {name} has per_length = {own}, the landmarks have {other}; give --per-length for both or for none, "
                         "or another name")


def write_landmarks(path: str | Path, name: str, attributes: Mapping[str, Any], cameras: Mapping[str, Any],
                    wings: Mapping[str, Mapping[str, np.ndarray]], is_new: bool = False) -> None:
    """Adds landmarks to the record `name` of a measurement file, and seals the file; makes file and record if they are missing, and
    the file also if `is_new`. `attributes` are those of the record, `cameras` those of its group `landmarks`, and wings[side] has time,
    points, mean, and sd or spread."""
    with measurement_file(path, is_new) as file:
        record = file.require_group(f"flight/{name}")
        if "landmarks" in record:
            raise InputError(f"{path}: the flight {name} has landmarks already; give another name")
        if "frequency" in record.attrs:
            check_same_flight(path, name, record.attrs, attributes)
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
