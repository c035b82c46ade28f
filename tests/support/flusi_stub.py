#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the place of flusi in tests of tools that run it: writes series in closed form at once, in two halves with a backup between
them. A line for every start goes to the file STARTS of the environment. HANG=FOLDER:backup makes it wait in that folder after the
backup, HANG=FOLDER:begin before it; it then writes its process id into the file `hangs`, and ends with exit code 4 and a backup if
there is a file STOP. The lift of rigid wings is 3, that of flexible ones 2, drag 1, power 10."""
import math
import os
import re
import sys
import time
from pathlib import Path

PER_BEAT = 40
UNITS = ("% units: L = 9.00000E-03 m, 1/T = 1.58000E+02 1/s, rho = 1.22500E+00 kg/m^3, force rho L^4/T^2 = 2.00600E-04 N, "
         "power rho L^5/T^3 = 2.85300E-04 W\n")
SHAPES = ["tip uz, wing frame", *(f"{what} at {span} %" for what in ("trailing edge", "twist", "camber") for span in (25, 50, 75))]


def rows_of(kind, t):
    """{file: (columns, values)} at the time t."""
    wave = math.sin(2 * math.pi * t)
    forces = [1 + wave, 0, (2 if kind == "flexible" else 3) + wave] + 9 * [0]
    columns = [f"{q}{c}{part}" for q in "FM" for part in ("", " unsteady") for c in "xyz"]
    found = {"forces.t": (columns, forces), "aero_power.t": (["aerodynamic power", "inertial power"], [10 + wave, 0]),
             "timesteps_info.t": (["wall time per step [s]"], [0.01])}
    if kind == "flexible":
        found["bending_left.t"] = (SHAPES, len(SHAPES) * [0.1 * wave])
    return found


def write(kind, first, last):
    """Appends the steps first + 1 to last to all series."""
    for step in range(first + 1, last + 1):
        for name, (columns, values) in rows_of(kind, step / PER_BEAT).items():
            with open(name, "w" if step == 1 else "a", encoding="utf-8") as file:
                if step == 1:
                    file.write("% " + "  ".join(f"{word:>14}" for word in ["time [T]", *columns]) + "\n" + UNITS)
                file.write(" ".join(f"{value:16.8e}" for value in [step / PER_BEAT, *values]) + "\n")


def hang(at):
    """Waits if it is asked to, for the file STOP or a kill."""
    if os.environ.get("HANG") != f"{Path.cwd().name}:{at}":
        return
    Path("hangs.part").write_text(str(os.getpid()))
    Path("hangs.part").rename("hangs")
    for _ in range(6000):
        if Path("STOP").exists():
            sys.exit(4)
        time.sleep(0.01)
    sys.exit(3)


def main():
    """Makes one run."""
    if "--version" in sys.argv:
        print("flusi-msm stub")
        return
    text = Path(sys.argv[1]).read_text(encoding="utf-8")
    restarted = "--restart" in sys.argv
    with open(os.environ["STARTS"], "a", encoding="utf-8") as file:
        file.write(f"{Path.cwd().name} {'goes on' if restarted else 'begins'}\n")
    kind = re.search(r"(?m)^wings\s*=\s*(\w+)", text)[1]
    beats = float(re.search(r"(?m)^Tmax\s*=\s*([\d.]+)", text)[1])
    steps = re.search(r"(?m)^nt\s*=\s*(\d+)", text)
    end = int(steps[1]) if steps else round(beats * PER_BEAT)
    backup = Path("runtime_backup0.h5")
    done = int(backup.read_text()) if restarted else 0
    if not restarted:
        hang("begin")
        done = end // 2
        write(kind, 0, done)
        backup.write_text(str(done))
        hang("backup")
    write(kind, done, end)
    print(f"step {end:7d}  t {beats:.3E}  dt 1.00E-02  max|u|  1.000  s/step 1.00E-02   100.0 %  ETA 0s")


if __name__ == "__main__":
    main()
