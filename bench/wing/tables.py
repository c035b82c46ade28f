# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes tables of cycle-mean lift, drag and power of the rigid blowfly wings (ini/wing-rigid.ini) with the exact planform
and without ramp.

usage: bench/wing/run TABLE [--beats 4] [--ranks 2] [--flusi PROGRAM] [--folder runs/bench_wing] [--only NAME ...]

  grid          dx varies; thickness, smoothing, sponge length and C_eta are fixed
  thickness     the thickness varies; everything else is fixed
  permeability  C_eta varies; everything else is fixed
  kinematics    two numbers vary that the paper does not give: the angle of the stroke plane, and that of the chord in the
                downstroke

Every case runs in its own folder, and a finished case is not run again. The last line is one JSON object.
"""
import argparse
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

from flusi_msm.results.ini import with_values

ROOT = Path(__file__).resolve().parents[2]
PAPER = (0.754, 0.167, 5.228)  # mN, mN, mW: Truong et al., Table 2, rigid wings
LENGTH = 4.0                   # of the box


def grid_of(n):
    """Returns the overrides for a box of n x n x n/2 points whose sponge keeps the length it has at 160 points."""
    return {"Resolution": {"nx": n, "ny": n, "nz": n // 2}, "Sponge": {"sponge_thickness": round(n / 8)}}


def sheet(thickness, smoothing, c_eta):
    return {"Insects": {"surface": "penalized", "WingThickness": thickness}, "Flexible_wing": {"wing_smoothing": smoothing},
            "Penalization": {"eps": c_eta}}


def merged(*parts):
    whole = {}
    for part in parts:
        for section, keys in part.items():
            whole.setdefault(section, {}).update(keys)
    return whole


def cases_of(table):
    """Returns (name, overrides) of every case; lengths in R, times in 1/f."""
    if table == "grid":
        h = LENGTH / 160
        return [(f"grid_{n}", merged(grid_of(n), sheet(4 * h, h, 1.0e-3))) for n in (96, 128, 160, 192, 240)]
    h = LENGTH / 128
    base = merged(grid_of(128), sheet(4 * h, h, 1.0e-3))
    if table == "thickness":
        return [(f"thickness_{k}", merged(base, sheet(k * h, h, 1.0e-3))) for k in (2, 3, 4, 6)]
    if table == "permeability":
        return [(f"permeability_{c:g}", merged(base, {"Penalization": {"eps": c}}))
                for c in (1.585e-2, 4.0e-3, 1.0e-3, 5.0e-4)]
    base = merged(grid_of(96), sheet(4 * h, h, 1.0e-3))  # differences are wanted, not values
    rows = [(f"eta_{-eta}", merged(base, {"Insects": {"eta0": eta}})) for eta in (-90, -80, -70, -60)]
    for alpha in (35, 55):
        name = f"alpha_{alpha}"
        rows.append((name, merged(base, {"Insects": {f"FlappingMotion_{side}": f"from_file::{name}.ini"
                                                     for side in ("left", "right")}})))
    return rows


def write_motion(folder, alpha_down):
    """Writes ini/kinematics/calliphora.ini with another angle between chord and stroke plane in the downstroke [deg]."""
    text = (ROOT / "ini/kinematics/calliphora.ini").read_text()
    down, up = 90.0 - alpha_down, -70.0  # alpha is measured from the normal of the stroke plane
    text = re.sub(r"a0_alpha = .*", f"a0_alpha = {down + up};", text)
    b = [4 / (math.pi * k) * (down - up) / 2 * math.exp(-(2 * math.pi * k * 0.05) ** 2 / 2) if k % 2 else 0.0
         for k in range(1, 12)]
    text = re.sub(r"bi_alpha = .*", "bi_alpha = " + " ".join(f"{x:.10g}" for x in b) + ";", text)
    (folder / f"alpha_{alpha_down}.ini").write_text(text)


def write_ini(path, overrides, beats):
    """Writes ini/wing-rigid.ini with other values; names of files are made absolute, no fields are saved."""
    overrides = merged({"Insects": {"WingShape": "from_file::wings/calliphora.ini", "wing_length": 1.0, "wing_ramp": 0.0}},
                       overrides, {"Time": {"Tmax": beats, "CFL": 0.5}, "Saving": {
        "tsave": "9.0e9", "iSaveVelocity": 0, "iSaveVorticity": 0, "iSaveWingSides": 0, "truntime": 0.25}})
    text = (ROOT / "ini/wing-rigid.ini").read_text()
    text = text[:text.index("[Wing]")] + text[text.index("[MeanFlow]"):]
    path.write_text(re.sub(r"from_file::(?!/|alpha_)", f"from_file::{ROOT}/ini/", with_values(text, overrides)))


def means(folder):
    """Reads lift [mN], drag [mN], power [mW] and their spreads over the averaged beats from summary.txt."""
    found = {}
    for line in (folder / "summary.txt").read_text().splitlines():
        m = re.match(r"(lift|drag|aerodynamic power) +(-?[\d.]+) +(-?[\d.]+) +(-?[\d.]+) +(-?[\d.]+) +(-?[\d.]+)", line)
        if m:
            mean, spread, si = float(m.group(2)), float(m.group(3)), float(m.group(6))
            found[m.group(1)] = (si, spread * si / mean if mean else 0.0)
    return [found[k] for k in ("lift", "drag", "aerodynamic power")]


def steps_and_time(folder):
    rows = [r for r in (folder / "timesteps_info.t").read_text().splitlines() if not r.strip().startswith("%")]
    seconds = sum(float(r.split()[1]) for r in rows)
    return len(rows), seconds


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("table", choices=["grid", "thickness", "permeability", "kinematics"])
    parser.add_argument("--beats", type=int, default=4)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--flusi", default=str(ROOT / "build/release/bin/flusi"))
    parser.add_argument("--folder", default=str(ROOT / "runs/bench_wing"))
    parser.add_argument("--only", nargs="*")
    args = parser.parse_args()
    results = []
    for name, overrides in cases_of(args.table):
        if args.only and name not in args.only:
            continue
        folder = Path(args.folder) / f"{name}_{args.beats}"
        if not (folder / "summary.txt").exists():
            folder.mkdir(parents=True, exist_ok=True)
            write_ini(folder / "wing.ini", overrides, args.beats)
            if name.startswith("alpha_"):
                write_motion(folder, int(name[6:]))
            command = ["mpirun", "-n", str(args.ranks), args.flusi, "wing.ini"]
            command.append("--restart" if list(folder.glob("runtime_backup*.h5")) else "--overwrite")
            with open(folder / "log", "a") as log:
                if subprocess.run(command, cwd=folder, stdout=log, stderr=subprocess.STDOUT, env=os.environ).returncode:
                    print(f"{name}: failed, see {folder}/log", file=sys.stderr)
                    continue
        steps, seconds = steps_and_time(folder)
        (lift, d_lift), (drag, d_drag), (power, d_power) = means(folder)
        results.append({"case": name, "lift_mN": lift, "drag_mN": drag, "power_mW": power})
        print(f"| {name} | {lift:.4f} ({d_lift:.4f}) | {drag:.4f} ({d_drag:.4f}) | {power:.3f} ({d_power:.3f}) | "
              f"{lift / drag:.2f} | {lift / power:.4f} | {steps} | {seconds:.0f} s |", flush=True)
    print(json.dumps({"table": args.table, "beats": args.beats, "paper": PAPER, "cases": results}))


if __name__ == "__main__":
    main()
