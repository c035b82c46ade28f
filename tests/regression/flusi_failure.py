#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that go wrong: exit code 3 for a flow that diverges and 5 for a disk that does not take the output;
the last valid backup stays, the reason is said, nothing hangs.

usage: flusi_failure.py <flusi> <h5dump> [tests]
"""
import math
import shutil

from whole_program import EXIT_NUMERICAL, EXIT_OK, EXIT_UNWRITABLE, check, main, merged, ring


def blow_up(dt=0.5, **sections):
    """A time step far beyond the CFL limit: instability within some steps."""
    return merged(ring(Time={"dt_fixed": dt, "nt": 1000}, ReynoldsNumber={"nu": 0.0},
                       InitialCondition={"omega1": 6.0},
                       Saving={"tsave": 1e9, "iSaveVorticity": "yes", "truntime": 1e-9}), sections)


def failed_fields(case):
    return sorted(n for n in case.files() if n.startswith("failed-"))


def check_failure(case, done):
    check("the velocity is not a number" in done.err or "the flow has diverged: max |u| = " in done.err,
          f"the reason is a reason:\n{done.err}")
    names = failed_fields(case)
    check([n[:9] for n in names] == ["failed-ux", "failed-uy", "failed-uz"], f"the offending field is written: {names}")
    values = [v for n in names for v in case.field(n)]
    check(len(values) == 3 * 16**3, "all of it")
    check(any(not math.isfinite(v) or abs(v) > 500 for v in values), "and it offends")
    check("whole run" in done.out, "the run ends in order: the time table is printed")


def test_blow_up(case):
    """On 1, 2 and 4 ranks. The newest backup is that of a sound state: with a shorter step it goes on."""
    for ranks in (1, 2, 4):
        part = case.sub(f"ranks_{ranks}")
        part.write("run.ini", blow_up())
        done = part.run("run.ini", ranks=ranks, code=EXIT_NUMERICAL)
        check_failure(part, done)
        check("the last valid backup is kept" in done.err, "the user is told that there is a backup")
        steps = [int(float(part.contents(f"runtime_backup{i}.h5")["step"][0])) for i in (0, 1)]
        made = int(part.series("timesteps_info.t").rows[-1][2])
        # A step shows only in the next one: the last step made is the one that failed to be sound.
        check(max(steps) == made - 1 and min(steps) == made - 2, f"{made} steps, the last sound are saved: {steps}")
        state = part.contents(part.newest_checkpoint())
        check(all(math.isfinite(float(v)) for v in state["ux"]), "the backup holds numbers")
        for name in part.all_series():
            check(all(math.isfinite(x) for row in part.series(name).rows for x in row), f"{name} holds numbers")
        part.write("run.ini", merged(ring(), {"Time": {"nt": made + 3, "CFL": 0.05}, "ReynoldsNumber": {"nu": 1.0}}))
        done = part.run("run.ini", "--restart", ranks=ranks)
        check(f"step {made - 1}" in done.out, "the run goes on from the last sound state")


def test_first_step(case):
    """Without any backup the program does not speak of one."""
    case.write("run.ini", blow_up(InitialCondition={"omega1": 1e5}))
    done = case.run("run.ini", ranks=2, code=EXIT_NUMERICAL)
    check_failure(case, done)
    check(not any(n.startswith("runtime_backup") for n in case.files()), "there was nothing to save")
    check("last valid backup is kept" not in done.err, f"and nothing is claimed:\n{done.err}")


def test_last_step(case):
    """The last step of a run is looked at too: its outcome is neither saved nor called a success."""
    case.write("run.ini", blow_up())
    case.run("run.ini", ranks=2, code=EXIT_NUMERICAL)
    made = int(case.series("timesteps_info.t").rows[-1][2])
    for nt, code in ((made, EXIT_NUMERICAL), (made - 1, EXIT_OK)):
        for truntime in (1e-9, 100.0):
            part = case.sub(f"nt_{nt}_{truntime}")
            part.write("run.ini", blow_up(Time={"nt": nt}, Saving={"truntime": truntime}))
            done = part.run("run.ini", ranks=2, code=code)
            if code == EXIT_NUMERICAL:
                check_failure(part, done)
            backups = [n for n in part.files() if n.startswith("runtime_backup")]
            steps = [int(part.contents(n)["step"][0]) for n in backups]
            check(max(steps, default=0) <= made - 1, f"the unsound state is not saved: {steps}")
            check(code == EXIT_NUMERICAL and truntime > 1 or made - 1 in steps, f"the last sound one is: {steps}")


def test_runge_kutta(case):
    case.write("run.ini", blow_up(dt=2.0, Time={"iTimeMethodFluid": "RK4"}))
    done = case.run("run.ini", ranks=2, code=EXIT_NUMERICAL)
    check_failure(case, done)


def test_not_a_number(case):
    """A NaN in the initial field is found in the first step, whichever rank has it."""
    if case.traps():
        print("      skipped: this build traps NaN")
        return
    case.write("make.ini", ring(Saving={"field_precision": "double"}, Time={"nt": 0}))
    case.run("make.ini")
    for point in (0, 16**3 - 1):
        part = case.sub(f"point_{point}")
        for name in "xyz":
            shutil.copy(case.folder / f"u{name}_000000.h5", part.folder)
        data = bytearray((part.folder / "uy_000000.h5").read_bytes())
        start = data.index(part.raw("uy_000000.h5", "uy")) + 8 * point
        data[start:start + 8] = b"\0\0\0\0\0\0\xf8\x7f"
        (part.folder / "uy_000000.h5").write_bytes(data)
        keys = {f"file_u{c}": f"u{c}_000000.h5" for c in "xyz"}
        part.write("run.ini", ring(InitialCondition={"inicond": "infile", **keys}))
        done = part.run("run.ini", ranks=2, code=EXIT_NUMERICAL)
        check("the velocity is not a number" in done.err, f"the reason is said:\n{done.err}")


def test_output_fails(case):
    """Output that cannot be written is not a numerical failure: exit code 5, the file is named, no failed-u*."""
    for obstacle, saving in (("ux_000050.h5", {}), ("runtime_backup1.h5", {"truntime": 1e-9})):
        part = case.sub(obstacle)
        part.write("run.ini", ring(Saving={"naming": "time", "tsave": 0.05, **saving}, Time={"dt_fixed": 0.005}))
        (part.folder / obstacle / "full").mkdir(parents=True)  # a folder cannot be replaced by a file
        done = part.run("run.ini", ranks=2, code=EXIT_UNWRITABLE)
        check(obstacle in done.err, f"the file is named:\n{done.err}")
        check(not failed_fields(part), "the velocity did not fail")


main(globals())
