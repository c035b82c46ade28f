# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads landmarks: places that are known in a scan and on the wing."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from flusi_msm.errors import InputError, Problems
from flusi_msm.importers.tables import read_table
from flusi_msm.wing.file import Wing

COLUMNS = ("name", "x", "y", "wing_x", "wing_y")


def places_of(wing: Wing) -> dict[str, np.ndarray]:
    """Returns the places of a wing that have names, (2) [m]: root, tip, joint:NAME, vein:NAME:first, vein:NAME:last."""
    xy = wing.points[:, :2]
    root = xy[list(wing.root)].mean(0)
    places = {"root": root, "tip": xy[((xy - root)**2).sum(1).argmax()]}
    for name in wing.joints:
        places[f"joint:{name}"] = xy[wing.joint_nodes(name)[1]]
    for name, (nodes, _) in wing.veins.items():
        places[f"vein:{name}:first"], places[f"vein:{name}:last"] = xy[nodes[0]], xy[nodes[-1]]
    return places


def read_landmarks(path: Path, wing: Wing | None, unit: float, problems: Problems) -> tuple[list, np.ndarray, np.ndarray]:
    """Returns names, places in the scan and on the wing (n, 2) [m]; `unit` is that of the file [m]. All mistakes are added to
    `problems`."""
    nothing: tuple[list, np.ndarray, np.ndarray] = [], np.zeros((0, 2)), np.zeros((0, 2))
    try:
        table = read_table(path)
    except InputError as error:
        problems.error(str(error))
        return nothing
    columns = table.rows[0]
    wrong = [f"no column {name}" for name in COLUMNS[:3] if name not in columns]
    wrong += [f"unknown column {name}" for name in columns if name not in COLUMNS]
    if wrong:
        problems.error(f"{path}: {'; '.join(wrong)}; columns are {', '.join(COLUMNS)}")
        return nothing
    known = places_of(wing) if wing else {}
    names, scan = [], []
    places: list[np.ndarray] = []
    for line, cells in zip(table.lines[1:], table.rows[1:]):
        row = {**dict.fromkeys(COLUMNS, ""), **dict(zip(columns, cells))}
        name = row["name"]
        try:
            here, stated = ([unit * table.number(row[key]) for key in keys] for keys in (("x", "y"), ("wing_x", "wing_y")))
            if not np.isfinite(here).all():
                raise ValueError
        except ValueError:
            problems.error(f"{path}:{line}: {name}: its coordinates are no numbers ({table.spelling()})")
            continue
        if np.isfinite(stated).all():
            places.append(np.array(stated))
        elif name in known:
            places.append(known[name])
        else:
            problems.error(f"{path}:{line}: {name!r} needs wing_x and wing_y"
                           + (f", or is one of {', '.join(known)}" if known else ", or --wing and a name of its places"))
            continue
        names.append(name)
        scan.append(here)
    return names, np.reshape(scan, (-1, 2)), np.reshape(places, (-1, 2))
