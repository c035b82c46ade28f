#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A wing that is bent and scanned in a turned and shifted frame, whose maps are exported and imported again, costs msm_train what the same
wing costs that was scanned in its own frame.

usage: imported_heights.py <msm_train>

Both scans are of the same shapes, bent by another program, so that only the grid differs. E is wrong by a quarter: h is then large
against every error of the import.
"""
import json
import re
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from flusi_msm.importers.registration import turn_by
from flusi_msm.wing.file import read_wing, write_wing

MSM_TRAIN = str(Path(sys.argv[1]).resolve())
SOURCE = Path(__file__).resolve().parents[2]
TOOLS = SOURCE / "tools"
ANGLE, SHIFT = np.radians(200.0), np.array([5e-3, 3e-3])
LOADS = [[0.00541, 0.00005, 1.0e-3], [0.00721, -0.00032, 1.4e-4]]
SPACING = 1e-4
INI = """[Wing]
file = {wing};
E = {young};
D = 2e-7;
[Measurement]
file = {measurement};
[Train]
parameters = E;
"""


def tool(folder, name, *arguments):
    done = subprocess.run([sys.executable, "-B", TOOLS / name, *map(str, arguments)], cwd=folder, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    return done.stdout


def measure(folder, name, wing, loads):
    case = {"title": name, "wing": str(wing), "loads": loads, "spacing": SPACING, "noise": {"height": 1e-9},
            "stiffness": {"E": 8e9, "D": 2e-7, "plate": "edges"}, "declared": {"height": 2e-6}}
    (folder / f"{name}.json").write_text(json.dumps(case))
    tool(folder, "make_measurement", f"{name}.json", "-o", f"{name}.h5")


def export(folder):
    """scan.h5 as a folder of CSV maps with decimal commas, one NPZ map, and landmarks."""
    with h5py.File(folder / "scan.h5") as file:
        x, y, rest = (file["reference/" + k][:] for k in "xyz")
        loads = {name: (group["z"][:], {k: np.ravel(v) for k, v in group.attrs.items()}) for name, group in file["loads"].items()}
    (folder / "set").mkdir()
    rows = [";".join([""] + [f"{1e3 * v:.7f}" for v in x])]
    rows += [";".join([f"{1e3 * v:.7f}"] + ["" if np.isnan(h) else f"{1e6 * h:.5f}" for h in line]) for v, line in zip(y, rest)]
    (folder / "set/reference.csv").write_text("\n".join(rows).replace(".", ","))
    lines = ["id,force,direction_x,direction_y,direction_z,point_x,point_y"]
    for name, (z, facts) in loads.items():
        np.savez(folder / f"set/{name}.npz", x=1e3 * x, y=1e3 * y, z=1e6 * z)
        lines.append(",".join([name, *(repr(float(v)) for v in (1e3 * facts["force"][0], *facts["direction"], *(1e3 * facts["point"])))]))
    (folder / "set/loads.csv").write_text("\n".join(lines))
    wing = read_wing(SOURCE / "wings/calliphora_small.h5")
    rows = ["name,x,y"]
    for name in ("C_Sc", "R2+3_base", "R1_Rs", "C_h"):
        place = 1e3 * (turn_by(ANGLE) @ wing.points[wing.joint_nodes(name)[1], :2] + SHIFT)
        rows.append(f"joint:{name},{place[0]:.6f},{place[1]:.6f}")
    (folder / "set/landmarks.csv").write_text("\n".join(rows))


def cost(folder, measurement, young):
    """h [m] of the wing of this E."""
    (folder / "train.ini").write_text(INI.format(wing=SOURCE / "wings/calliphora_small.h5", measurement=measurement, young=young))
    done = subprocess.run([MSM_TRAIN, "--evaluate", "train.ini"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    return float(re.search(r"^h =\s*(\S+) m", done.stdout, re.M).group(1))


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wing = read_wing(SOURCE / "wings/calliphora_small.h5")
        points = wing.points.copy()
        points[:, :2] = points[:, :2] @ turn_by(ANGLE).T + SHIFT
        write_wing(folder / "turned.h5", replace(wing, points=points))
        measure(folder, "straight", SOURCE / "wings/calliphora_small.h5", LOADS)
        measure(folder, "scan", folder / "turned.h5", [[*(float(v) for v in turn_by(ANGLE) @ load[:2] + SHIFT), load[2]] for load in LOADS])
        export(folder)
        print(tool(folder, "import_heights", "set", "-o", "imported.h5", "--wing", SOURCE / "wings/calliphora_small.h5", "--height-units", "um",
                   "--axis-units", "mm", "--force-units", "mN", "--height-sd", "2"))
        # A surface of triangles has kinks where they meet. A bilinear interpolation errs by a quarter of the kink times the step of the
        # scan there at most, and by nothing inside a triangle: with kinks up to 0.1 rad by 2.5 um, at the third of all places whose cell
        # of 0.1 mm meets an edge (of 0.5 mm long ones): 1 um (rms) at most.
        exact, error = (cost(folder, name, 8e9) for name in ("straight.h5", "imported.h5"))
        print(f"with the true E: h = {1e6 * exact:.5f} um, imported {1e6 * error:.3f} um")
        assert exact < 0.01e-6 and error < 1e-6, (exact, error)
        # A wrong E: the grids differ in how they count the margin, of which a cell of 0.1 to 0.2 mm is 3 % of the area, where the
        # deformation is up to twice its mean: 3 % of h.
        straight, imported = (cost(folder, name, 10e9) for name in ("straight.h5", "imported.h5"))
        print(f"with a wrong E: h = {1e6 * straight:.3f} um, imported {1e6 * imported:.3f} um")
        assert straight > 50e-6, "a wrong E is seen"
        assert abs(imported - straight) < 0.03 * straight, (straight, imported)


if __name__ == "__main__":
    main()
