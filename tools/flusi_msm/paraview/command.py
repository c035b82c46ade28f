# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes open_in_paraview.py next to the XDMF indices of a run: a script that opens the whole run in ParaView, with iso-surfaces
of the magnitude of the vorticity and the surfaces of wings and body.

usage: open_in_paraview RUN [--levels 100,150,200] [--frequency 1]

    paraview --script=RUN/open_in_paraview.py                   # to look around
    pvpython RUN/open_in_paraview.py picture.png [TIME]          # without a window

Levels are those of tools/render. The script expects its files in its own folder, and may be edited and moved together with them.
"""
from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from matplotlib.colors import to_hex

from flusi_msm.errors import InputError, run_command
from flusi_msm.render.command import BODY, VELOCITY, VORTICITY, WING, Scene, choose_levels, colours_of, drawable
from flusi_msm.results.files import Snapshot, fields_in

NAME = "open_in_paraview.py"
PARTS = ("_left", "_right", "_body")
SCRIPT = Path(__file__).with_name("scene.py")


def indices_of(folder: Path) -> tuple[str, dict[str, str]]:
    """Returns (index of the flow, {index of a surface: colour})."""
    surfaces = {}
    flows = []
    for path in sorted(folder.glob("*.xmf")):
        part = next((part for part in PARTS if path.stem.endswith(part)), None)
        if part is None:
            flows.append(path.name)
        else:
            surfaces[path.name] = BODY if part == "_body" else WING
    if len(flows) != 1:
        raise InputError(f"{folder}: {'no index of a flow, NAME.xmf' if not flows else 'several runs: ' + ', '.join(flows)}")
    return flows[0], surfaces


def source_of(have: set[str]) -> str:
    """Returns the stored quantities from which the magnitude of the vorticity is computed."""
    for kind, names in (("vorabs", {"vorabs"}), ("vorticity", VORTICITY), ("velocity", VELOCITY)):
        if have.issuperset(names):
            return kind
    raise InputError("neither vorabs, nor vorx, vory and vorz, nor ux, uy and uz were saved")


def script_of(folder: Path, levels: Sequence[float] | None, frequency: float) -> str:
    """Returns the text of the script."""
    flow, surfaces = indices_of(folder)
    label = drawable(folder)[-1]
    if levels is None:
        scene = Scene(Snapshot(folder, label), None)
        levels = choose_levels(scene.values, scene.fluid(), frequency)
    colours, opacities = colours_of(len(levels))
    facts = {"FOLDER": str(folder.resolve()), "FLOW": flow, "SURFACES": surfaces, "SOURCE": source_of(fields_in(folder)[label]),
             "LEVELS": [float(level) for level in levels], "COLOURS": [to_hex(colour) for colour in colours], "OPACITIES": [float(o) for o in opacities]}
    head = "".join(f"{name} = {json.dumps(value)}\n" for name, value in facts.items())
    text = SCRIPT.read_text(encoding="utf-8")
    begin, end = text.index("# FACTS"), text.index("# END OF FACTS\n")
    return text[:begin] + head + text[end + len("# END OF FACTS\n"):]


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="RUN", type=Path, help="folder of a run")
    parser.add_argument("--levels", help="of |omega|, separated by commas (default: as tools/render)")
    parser.add_argument("--frequency", type=float, default=1.0, help="wing beats per unit of time of the run (default 1)")
    a = parser.parse_args()
    try:
        levels = sorted(float(word) for word in a.levels.split(",")) if a.levels else None
    except ValueError:
        raise InputError(f"--levels takes numbers like 100,150,200, not '{a.levels}'") from None
    out = a.folder / NAME
    text = script_of(a.folder, levels, a.frequency)
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror}") from None
    print(out)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("open_in_paraview", main)
