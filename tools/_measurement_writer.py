# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes measurement files (docs/measurement-format.md)."""
import h5py
import numpy as np

from _flusi_io import InputError

SCHEMA, VERSION = "flusi-msm measurement", 1


def write_measurement(path, content):
    """Writes what `synthesise` made, in the layout of HDF5 1.8, whose metadata carry checksums."""
    def dataset(group, name, values):
        made = group.create_dataset(name, data=np.asarray(values, "<f8"), track_times=False)
        made.attrs["units"] = np.bytes_("m")

    accuracy = content["accuracy"]
    try:
        with h5py.File(path, "w", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_(SCHEMA)
            file.attrs["version"] = np.int32(VERSION)
            file.attrs["title"] = np.bytes_(content["title"])
            reference = file.create_group("reference")
            for name in "xyz":
                dataset(reference, name, content[name])
            if content["reference_scans"] > 1:
                dataset(reference, "sigma", np.full(content["z"].shape,
                                                    accuracy["height"] / np.sqrt(content["reference_scans"])))
            for load in content["loads"]:
                group = file.create_group("loads/" + load["name"])
                dataset(group, "z", load["z"])
                for name in ("force", "time", "hold"):
                    group.attrs[name] = np.float64(load[name])
                for name in ("direction", "point"):
                    group.attrs[name] = np.asarray(load[name], "<f8")
                for name in ("order", "replicate"):
                    group.attrs[name] = np.int32(load[name])
            group = file.create_group("accuracy")
            for name, value in accuracy.items():
                group.attrs[name] = np.float64(value)
            if content["calibration"]:
                group = file.create_group("calibration")
                for name, value in content["calibration"].items():
                    group.attrs[name] = np.int32(value)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error}") from None
