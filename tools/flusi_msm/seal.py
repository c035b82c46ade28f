# SPDX-License-Identifier: GPL-3.0-or-later
"""Seals HDF5 files: adds a line of 64 bytes after the end of a file, with the checksum of all bytes before it.

HDF5 does not read beyond the end that a file states, so that every reader opens a sealed file as before. A program that writes
into a sealed file cuts the seal off; the result is a file without a seal, not a damaged one. `src/io/hdf5/io_seal.f90` does the
same in Fortran.
"""
from __future__ import annotations

import argparse
import zlib
from pathlib import Path

import h5py

from flusi_msm.errors import InputError, run_command

LENGTH = 64
MARK = b"\nflusi-msm seal 1 crc32 "


def split(data: bytes) -> tuple[bytes, bytes | None]:
    """Returns the bytes of a file, and its seal if it has one."""
    if len(data) > LENGTH and data[-LENGTH:].startswith(MARK):
        return data[:-LENGTH], data[-LENGTH:]
    return data, None


def seal_of(data: bytes) -> bytes:
    """Returns the seal that these bytes should have."""
    return (MARK + b"%08x bytes %016d" % (zlib.crc32(data), len(data))).ljust(LENGTH - 1) + b"\n"


def check_seal(path: str | Path) -> bool:
    """Returns whether a file has a seal; raises an InputError if the file is damaged."""
    data, seal = split(Path(path).read_bytes())
    if seal is not None and seal != seal_of(data):
        raise InputError(f"{path}: is damaged: its bytes differ from the checksum at its end")
    return seal is not None


def write_seal(path: str | Path) -> None:
    """Seals a closed file; raises an InputError for a damaged one, and for a file that is not HDF5, which a seal would spoil."""
    if not check_seal(path):
        if not h5py.is_hdf5(path):
            raise InputError(f"{path}: is not an HDF5 file; only wing and measurement files have a seal")
        seal = seal_of(Path(path).read_bytes())
        with open(path, "ab") as file:
            file.write(seal)


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(
        prog="seal", description="Seals wing and measurement files, so that damage is found when they are read: a line with "
        "the checksum of all bytes is put behind the end of each, where HDF5 does not look. What our tools write has a seal; "
        "a file that is changed loses it.")
    parser.add_argument("files", metavar="FILE", nargs="+")
    parser.add_argument("--check", action="store_true", help="tell which files are sealed, and change nothing; exit code 2 if "
                        "one is damaged")
    options = parser.parse_args()
    problems = []
    for path in options.files:
        try:
            if options.check:
                print(f"{path}: {'sealed' if check_seal(path) else 'has no seal'}")
            else:
                write_seal(path)
        except InputError as error:
            problems.append(str(error))
        except OSError as error:
            problems.append(f"{path}: {error.strerror}")
    if problems:
        raise InputError("\n".join(problems))


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("seal", main)
