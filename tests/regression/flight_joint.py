#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A joint in flights beside fits on the finer mesh: the filament of flight_stiffness.py, a thousand times smaller, with one strong spar
and a joint in it. On the finer mesh the joint has another stiffness for the same rotation; flights have the wing of the file.

usage: flight_joint.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
from flight_stiffness import DENSITY, FILAMENT, HEAVE, PERIOD, PLATE, TIMES, YOUNG, write_case
from synthetic_bending import seal
from whole_program import check, ini_text, main, series

LENGTH, RATE, BEATS = 1e-3, 1e3, 2  # m, Hz: E stays, other quantities follow
NODE, POINTS = 6, 49                # of the joint and in all, along the spar
DIAMETER = 1.18e-4                  # m, of the spar
OF_VEIN = YOUNG * math.pi * DIAMETER**4 / 64 * (POINTS - 1) / LENGTH  # N m/rad: as stiff as the vein on the mesh of the file
STIFFNESS = 0.5 * OF_VEIN
ERROR = 0.01


def write_wing(path):
    """The filament with a joint in its middle spar, which has nearly all of the stiffness."""
    shutil.copy(FILAMENT["Wing"]["file"], path)
    with h5py.File(path, "r+") as f:
        f["points"][...] *= LENGTH
        for name, diameter in (("spar1", DIAMETER), ("spar2", 0.42 * 1e-4), ("spar3", 0.42 * 1e-4)):
            f[f"veins/{name}/diameters"][...] = diameter
        joint = f.create_dataset("joints/knee", data=[f["veins/spar1/nodes"][NODE]])
        joint.attrs["vein"] = np.bytes_(b"spar1")
    seal(path)


def sections(joint):
    """[Wing] and [Mass] of the small filament, with further keys of the joint."""
    wing = {"file": "wing.h5", "E": YOUNG, "D": PLATE * LENGTH**3, "k_e": 1e7 * LENGTH, **joint}
    return {"Wing": wing, "Mass": {"membrane_law": "uniform", "areal_density": 2.5 * DENSITY * LENGTH, "vein_density": 1e-7}}


def write_all(case, stiffness):
    """The case with the joint, its flight, and data: forces of this flight, and a frequency of which little is known."""
    write_case(case.folder)
    write_wing(case.folder / "wing.h5")
    text = {**FILAMENT, **sections({"parameters": f"joint:knee {stiffness!r}"}),
            "units": {"length": LENGTH, "frequency": RATE, "density": DENSITY}, "Time": {"Tmax": PERIOD * BEATS, "dt_fixed": 0.01}}
    (case.folder / "heave.ini").write_text(ini_text(text))
    subprocess.run([FLUSI, "heave.ini"], cwd=case.folder, check=True, stdout=subprocess.DEVNULL)
    rows = np.array(series(case.folder / "forces.t").rows)
    t = rows[:, 0] / PERIOD - (BEATS - 1)
    force = DENSITY * LENGTH**3 * RATE**2
    mean = force * np.stack([np.interp(TIMES, t, rows[:, k] + rows[:, k + 3]) for k in (2, 3)], axis=1)
    sd = ERROR * np.sqrt(np.mean(mean**2, axis=0)) * np.ones_like(mean)
    frequency = 1.8751**2 / (2 * math.pi) * math.sqrt(YOUNG * 2 * math.pi * 0.1**4 / 64 / (2.5 * DENSITY)) * RATE
    with h5py.File(case.folder / "data.h5", "w", libver=("v108", "v108")) as f:
        f.attrs.update(schema="flusi-msm measurement", version=1)
        flight = f.create_group("flight/heave")
        flight.attrs.update(frequency=RATE / PERIOD, beats=16, frame="lab", reference=np.zeros(3), per_length=1, components="Fy, Fz",
                            units="N/m, N/m")
        flight["time"] = TIMES
        flight["mean"] = mean
        flight["sd"] = sd
        f.create_group("modes/first").attrs.update(frequency=frequency, frequency_sigma=0.3 * frequency, medium="vacuum", number=1)
    seal(case.folder / "data.h5")


def joint_of(case, refine, option=""):
    """Stiffness of the joint in the wing of the baseline, the sd of its logarithm, and the JSON file."""
    text = ini_text({**sections({}), "Measurement": {"file": "data.h5"}})
    text += (f"[Flight]\nfile = heave.ini\nbeats = {BEATS}\nharmonics = 12\nfolder = flights\nmodel_sd = 0\nrefine = no\nrounds = 0\n"
             f"effects = joint:*, balance_gain\n[Diagnose]\nnoise = declared\ndraws = 500\nstarts = 1\nvalidation = no\nrefine = {refine}\n"
             f"parameters = joint:*\nmembrane_sd = 0.001\n{option}[Next]\nmodes = 0\n[Saving]\nname = {refine}\n")
    (case.folder / f"{refine}.ini").write_text(text)
    done = case.flusi(f"{refine}.ini", timeout=300)
    check(done.code == 0, f"{done}")
    found = json.loads((case.folder / f"{refine}.json").read_text())
    fitted = {one["name"]: one for one in found["baseline"]["parameters"]}["joint:knee"]
    written = float((case.folder / f"{refine}_baseline.ini").read_text().split("joint:knee")[1].split()[0].strip(",;"))
    print(f"    {refine}: fitted {fitted['value'] / OF_VEIN:.3f} of the vein, sd {fitted['sd']:.3f}, in the file {written / OF_VEIN:.3f}; "
          f"{found['verdict']['sentence']}", flush=True)
    return written, fitted["sd"], found


def test_finer(case):
    """Forces of a wing whose joint is half as stiff as its vein give this joint to the wing of the file, on whatever mesh it is fitted."""
    write_all(case, STIFFNESS)
    for refine in "no", "fit":
        joint, sd, found = joint_of(case, refine)
        # The stiffness for the same rotation differs by 25 % between the meshes.
        check(sd < 0.05 and abs(math.log(joint / STIFFNESS)) < max(3 * sd, 0.01), f"{refine}: {joint / OF_VEIN} of the vein, sd {sd}")


def test_both_meshes(case):
    """A joint that is as stiff as its vein, as one knows to 2 %: on both meshes the same forces, so that the mesh makes no error in them."""
    write_all(case, OF_VEIN)
    _, _, found = joint_of(case, "yes", "prior_decades = 0.01\n")
    print(f"    {found['mesh_band']}", flush=True)
    check(found["mesh_band"]["is_found"] and found["mesh_band"]["snr"] < 0.5, f"{found['mesh_band']}")


if __name__ == "__main__":
    FLUSI = str(Path(sys.argv.pop(3)).resolve())
    main(globals())
