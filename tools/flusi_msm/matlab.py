# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the time series of a run, and if wanted fields, to a file for Matlab or Octave (version 5 of MAT, at most 2 GB).

A series NAME.t is the struct NAME with a column for each quantity, and NAME_units with their units. A field ux_000500.h5 is the struct
ux_000500 with data (z, y, x), x, y, z and time. Wing, measurement and history files are HDF5, which Matlab reads itself (h5read).
"""
from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

import numpy as np

from flusi_msm.errors import InputError, run_command
from flusi_msm.results.files import Field, read_series

LONGEST, LARGEST = 63, 2**31 - 1 - 2**20   # letters of a name in Matlab; bytes of an array in MAT


def identifier(text: str) -> str:
    """Converts a name to one that Matlab accepts."""
    name = re.sub(r"\W+", "_", text).strip("_")[:LONGEST]
    return name if name[:1].isalpha() else f"x{name}"[:LONGEST]


def unique(names: list[str]) -> list[str]:
    """Returns identifiers of all names, numbered if two are the same."""
    found: list[str] = []
    for name in map(identifier, names):
        number, made = 1, name
        while made in found:
            number += 1
            made = f"{name[:LONGEST - 4]}_{number}"
        found.append(made)
    return found


def content_of(folder: Path, fields: list[str]) -> dict[str, Any]:
    """Returns the variables by name: all series of the folder, and the fields of these quantities."""
    paths = sorted(folder.glob("*.t"))
    chosen = sorted(path for name in fields for path in folder.glob(f"{name}_*.h5") if re.fullmatch(rf"{re.escape(name)}_\d+", path.stem))
    lacking = [name for name in fields if not any(path.name.startswith(name + "_") for path in chosen)]
    if not folder.is_dir() or lacking or not paths + chosen:
        raise InputError(f"{folder}: " + ("no such folder" if not folder.is_dir() else
                         f"no fields of {', '.join(lacking)}" if lacking else "no time series (*.t) in this folder"))
    content: dict[str, Any] = {}
    for path in paths:
        series = read_series(path)
        names = unique(series.names)
        content[identifier(path.stem)] = {name: series.data[:, k:k + 1] for k, name in enumerate(names)}
        content[identifier(path.stem + "_units")] = {name: unit or "1" for name, unit in zip(names, series.units)}
    for path in chosen:
        field = Field(path)
        if field.data.dtype.itemsize * field.data.size > LARGEST:
            raise InputError(f"{path}: is larger than 2 GB, which MAT files of version 5 cannot hold; Matlab reads it with h5read")
        content[identifier(path.stem)] = {"data": field.data[...], "time": field.time,
                                          **{a: field.origin[k] + field.spacing[k] * np.arange(field.n[k]) for k, a in enumerate("xyz")}}
    return content


def main() -> None:
    """Does what the command line asks for."""
    from scipy.io import savemat
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="of the run")
    parser.add_argument("-o", "--output", type=Path, help="file to write (default: FOLDER/run.mat)")
    parser.add_argument("--fields", nargs="+", default=[], metavar="QUANTITY", help="for instance ux uy uz mask")
    options = parser.parse_args()
    output = options.output or options.folder / "run.mat"
    content = content_of(options.folder, options.fields)
    try:
        savemat(output, content, do_compression=True, long_field_names=True, oned_as="row")
    except OSError as error:
        raise InputError(f"{output}: cannot be written: {error}") from None
    print(f"{output}: {', '.join(name for name in content if not name.endswith('_units'))}")


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("to_mat", main)
