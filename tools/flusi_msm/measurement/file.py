# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes measurement files (docs/formats/measurement-format.md), in SI units."""
from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flusi_msm.results.files import InputError
from flusi_msm.seal import write_seal

SCHEMA, VERSION = "flusi-msm measurement", 1


def write_measurement(path: str | Path, x: np.ndarray | None, y: np.ndarray | None, unloaded: np.ndarray | None,
                      loads: Mapping[str, tuple[np.ndarray | None, Mapping[str, Any]]], accuracy: Mapping[str, float],
                      calibration: Mapping[str, int] | None = None, title: str = "", unloaded_sigma: np.ndarray | None = None,
                      sigmas: Mapping[str, np.ndarray] | None = None) -> None:
    """Writes a measurement file with a seal in the layout of HDF5 1.8, whose metadata carry checksums.

    x (nx), y (ny), unloaded (ny, nx) [m]; loads: {name: (heights (ny, nx) [m], {attribute: value})}; without heights (None)
    it is the plan of an experiment;
    accuracy, calibration: {attribute: value}; unloaded_sigma (ny, nx), sigmas: {name: (ny, nx)} [m] where they are known.
    """
    def dataset(name: str, values: np.ndarray) -> None:
        made = file.create_dataset(name, data=np.asarray(values, "<f8"), track_times=False)
        made.attrs["units"] = np.bytes_("m")

    def attributes(name: str, values: Mapping[str, Any]) -> None:
        group = file.require_group(name)
        for key, value in values.items():
            whole = isinstance(value, (int, np.integer))
            group.attrs[key] = np.asarray(value, "<i4" if whole else "<f8")

    try:
        with h5py.File(path, "w", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_(SCHEMA)
            file.attrs["version"] = np.int32(VERSION)
            if title:
                file.attrs["title"] = np.bytes_(title)
            for name, values in (("x", x), ("y", y), ("z", unloaded)):
                if values is not None:
                    dataset("reference/" + name, values)
            if unloaded_sigma is not None:
                dataset("reference/sigma", unloaded_sigma)
            for name, (heights, facts) in sorted(loads.items()):
                if heights is not None:
                    dataset(f"loads/{name}/z", heights)
                if sigmas and name in sigmas:
                    dataset(f"loads/{name}/sigma", sigmas[name])
                attributes(f"loads/{name}", facts)
            attributes("accuracy", accuracy)
            if calibration:
                attributes("calibration", calibration)
        write_seal(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error}") from error


def write_test(path: str | Path, content: dict[str, Any]) -> None:
    """Writes the result of `observe` or `plan` of measurement/synthesis.py."""
    sigma = None
    if content["reference_scans"] > 1:
        sigma = np.full((len(content["y"]), len(content["x"])), content["accuracy"]["height"] / np.sqrt(content["reference_scans"]))
    loads = {load["name"]: (load["z"], {key: load[key] for key in ("force", "direction", "point", "order", "replicate",
                                                                   "time", "hold")}) for load in content["loads"]}
    write_measurement(path, content["x"], content["y"], content["z"], loads, content["accuracy"], content["calibration"],
                      content["title"], sigma)
