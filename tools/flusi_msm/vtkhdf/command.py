# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes VTKHDF files, which ParaView opens without a choice of readers, next to the XDMF indices of a run. The flow refers to
the files of the run and is not copied; the surfaces of wings and body are copied. Needs ParaView 5.12 or later."""
from __future__ import annotations

import argparse
import os
from pathlib import Path

from flusi_msm.errors import InputError, Problems, run_command
from flusi_msm.vtkhdf.fields import write_fields
from flusi_msm.vtkhdf.index import Step, check_sources, read_index
from flusi_msm.vtkhdf.surfaces import write_surface


def convert(folder: Path, vectors: bool = True) -> None:
    """Writes NAME.vtkhdf for every NAME.xmf of a run, with or without the vectors of the flow, and prints their contents. All
    mistakes are reported at once, before any file is written."""
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder")
    indices = sorted(folder.glob("*.xmf"))
    if not indices:
        raise InputError(f"{folder}: no index (*.xmf) in this folder; the folder of a run has one")
    problems, found = Problems(), []
    for path in indices:
        try:
            steps = read_index(path)
        except InputError as mistake:
            problems.error(str(mistake))
            continue
        if not steps:
            problems.notice(f"{path}: left out, neither flow nor surface of a run of flusi")
        else:
            check_sources(folder, steps, problems)
            found.append((path, steps))
    problems.stop_if_any()
    for text in problems.notices:
        print(text)
    if not found:
        raise InputError(f"{folder}: no flow and no surface in the indices of this folder")
    for path, steps in found:
        write(path.with_suffix(".vtkhdf"), steps if vectors else without_vectors(steps))


def without_vectors(steps: list[Step]) -> list[Step]:
    """Returns the flow without the vectors that are joined from components; surfaces have none of this kind."""
    return [step._replace(quantities={name: quantity for name, quantity in step.quantities.items() if len(quantity.sources) == 1})
            for step in steps]


def write(path: Path, steps: list[Step]) -> None:
    """Writes one file completely or not at all."""
    part = path.with_name(path.name + ".part")
    is_flow = steps[0].points is None
    try:
        names = (write_fields if is_flow else write_surface)(str(part), steps)
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error}") from None
    finally:
        part.unlink(missing_ok=True)
    times = f"t = {steps[0].time:g}" + (f" to {steps[-1].time:g}, {len(steps)} times" if len(steps) > 1 else "")
    print(f"{path}: {'flow' if is_flow else 'surface'}, {times}, {', '.join(names)}")


def command() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(prog="to_vtkhdf", description=__doc__)
    parser.add_argument("folder", metavar="RUN", type=Path, help="folder of a run with its *.xmf")
    parser.add_argument("--no-vectors", action="store_true", help="leave the vectors u and vor out, which are read much slower than "
                        "ux, uy, uz and vorx, vory, vorz, as they lie in three files")
    options = parser.parse_args()
    run_command("to_vtkhdf", lambda: convert(options.folder, not options.no_vectors))


if __name__ == "__main__":
    command()
