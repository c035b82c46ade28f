#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory that a run takes is what --dry-run tells, and no more than 8 numbers per point of the grid, 10 with wings.

usage: flusi_peak_memory.py <flusi> <h5dump> [tests]

The peak of a run is that of the same run on 8^3 points, which is programs and libraries, and what grows with the grid. Of
that the estimate leaves out tables and work arrays of lines and planes: below 3 % of it on 96^3 points. HDF5 takes up to
1 MB for a conversion and MPI as much for a message. So 3 % and 3 MB are allowed on either side. glibc is told to give back
at once what is freed, so that the peak is not that of holes. Wings and their markers are not part of the estimate.
"""
import os
import re

from whole_program import SOURCE, check, main, merged

os.environ["MALLOC_MMAP_THRESHOLD_"] = "100000"
MB = 1e6
N = 96
RING = {
    "Resolution": {"nx": N, "ny": N, "nz": N, "planner": "estimate"},
    "Time": {"Tmax": 1.0, "nt": 2, "CFL": 0.3},
    "ReynoldsNumber": {"nu": 1e-2},
    "Geometry": {"xl": 2.5, "yl": 2.5, "zl": 2.5, "Size": 0.3125},
    "InitialCondition": {"inicond": "VortexRing", "omega1": 12.0},
    "MeanFlow": {"ux": 0.0},
    "Saving": {"tsave": 1.0, "tintegral": 0.5, "iSaveVelocity": "yes", "iSaveVorticity": "yes", "iSavePress": "yes",
               "iDoBackup": "yes"},
}
SMALL = {"Resolution": {"nx": 8, "ny": 8, "nz": 8}}


def estimate(case):
    """Bytes of one rank while running and at the start."""
    line = re.search(r"^ +1 ranks = 1 x 1 +([\d.]+) MB +([\d.]+) MB", case.run("run.ini", "--dry-run", ranks=0).out, re.M)
    check(line, "a dry run tells the memory of one rank")
    return float(line[1]) * MB, float(line[2]) * MB


def peak(done):
    line = re.search(r"^memory +([\d.]+) MB at most on a rank", done.out, re.M)
    check(line, "a run tells its peak")
    return float(line[1]) * MB


def compare(found, told, name):
    allowed = 0.03 * told + 3 * MB
    print(f"{name}: {found / MB:.1f} MB, estimate {told / MB:.1f} MB, {found / 8 / N**3:.2f} numbers per point")
    check(abs(found - told) < allowed, f"{name}: {found / MB:.1f} MB, the estimate is {told / MB:.1f} MB")


def test_ring(case):
    """Start, steps, all fields, backup; then a restart."""
    small, large = case.sub("small"), case.sub("large")
    found = []
    for folder, ini in ((small, merged(RING, SMALL)), (large, RING)):
        folder.write("run.ini", ini)
        found.append([peak(folder.run("run.ini", ranks=1))])
        running, starting = estimate(folder)
        folder.write("run.ini", merged(ini, {"Time": {"nt": 4}}))
        found[-1].append(peak(folder.run("run.ini", "--restart", ranks=1)))
    compare(found[1][0] - found[0][0], starting, "a run from its start")
    compare(found[1][1] - found[0][1], running, "a run that goes on")
    check(starting <= 8 * 8 * N**3, "a vortex ring takes at most 8 numbers per point")
    check(running < starting, "most memory is taken at the start")


def wings(n, sides):
    """Two steps of ini/wing.ini on n^3 points."""
    text = (SOURCE / "ini/wing.ini").read_text().replace("../wings/", f"{SOURCE}/wings/").replace("from_file::", f"from_file::{SOURCE}/ini/")
    for key, value in {"nx": n, "ny": n, "nz": n, "tsave": 1.0, "iSaveWingSides": sides}.items():
        text, count = re.subn(rf"(?m)^{key} = [^;]*;", f"{key} = {value};", text)
        check(count == 1, f"the file has {key}")
    return text.replace("[Resolution]", "[Resolution]\nplanner = estimate;").replace("[Time]", "[Time]\nnt = 2;")


def test_thin(case):
    """Two flexible wings without thickness on the coarsest of the usual grids on which the fields, 97 to 108 MB, take more than programs
    and libraries, 36 MB, and the model of the wings, 38 MB."""
    found, told = {}, {}
    for name, ini in (("programs", merged(RING, SMALL)), ("wings", wings(24, "no")), ("fields", wings(128, "no")),
                      ("all", wings(128, "yes"))):
        folder = case.sub(name)
        folder.write("run.ini", ini)
        found[name] = peak(folder.run("run.ini", ranks=1))
        told[name] = estimate(folder)[1]
    # The estimate leaves out the response of the markers, which grows with the grid: a wing of the area 0.33 has 84 squares of two
    # grid spacings, and with its edges 110 markers, whose matrix has (3 * 110)^2 numbers: 1.7 MB for two wings.
    grows = found["fields"] - found["wings"]
    check(abs(grows - (told["fields"] - told["wings"]) - 1.7 * MB) < 0.03 * told["fields"] + 3 * MB,
          f"what grows with the grid is what is told: {found}, {told}")
    check(found["all"] - found["programs"] <= 10 * 8 * 128**3, f"two wings take at most 10 numbers per point: {found}")
    check(found["all"] - found["wings"] < told["all"] + 3 * MB, f"pictures of both sides take no more than is told: {found}, {told}")


if __name__ == "__main__":
    main(globals())
