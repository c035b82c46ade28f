#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A run is itself: none over the results of another, none beside another, and a restart of nothing but itself.

usage: flusi_identity.py <flusi> <h5dump> [tests]
"""
import re
import shutil
import signal
import subprocess

from flight_case import FLIGHT
from whole_program import ALIVE, EXIT_OK, EXIT_STOPPED, EXIT_UNWRITABLE, EXIT_USER, SOURCE, check, main, merged, no_crash, sphere

A = sphere(8, Time={"nt": 6, "CFL": None, "dt_fixed": 0.004}, Saving={"tintegral": 0.004})
B = merged(A, {"ReynoldsNumber": {"nu": 2e-2}, "Time": {"nt": 999999}, "Saving": {"tsave": 1e9}})  # ends by a signal alone
BEAT = (SOURCE / "ini/kinematics/calliphora.ini").read_text()
WINGS = {
    "Resolution": {"nx": 16, "ny": 16, "nz": 16}, "Geometry": {"xl": 4.0, "yl": 4.0, "zl": 4.0},
    "Time": {"nt": 2, "dt_fixed": 0.01}, "ReynoldsNumber": {"nu": 1e-2}, "InitialCondition": {"inicond": "MeanFlow"},
    "Penalization": {"iPenalization": "yes", "iMask": "Insect", "eps": 0.05},
    "units": {"length": 9e-3, "frequency": 158, "density": 1.225},
    "Insects": {"surface": "penalized", "WingShape": f"from_file::{SOURCE}/ini/wings/calliphora.ini", "wing_length": 1.0,
                "FlappingMotion_left": "from_file::beat.ini", "FlappingMotion_right": "from_file::beat.ini",
                "x0": "2.0 2.0 2.0", "yawpitchroll_0": "180.0 0.0 0.0", "eta0": -70.0,
                "x_pivot_l": "0.0 0.5 0.0", "x_pivot_r": "0.0 -0.5 0.0"},
    "MeanFlow": {"ux": 0.9, "uy": 0.0, "uz": 0.0}, "Saving": {"tintegral": 0.01},
}


def run(case, *arguments, ini=None, name="run.ini", code=EXIT_OK, **more):
    """Without a launcher, which costs most of the time of so short a run."""
    if ini is not None:
        case.write(name, ini)
    done = case.flusi(name, *arguments, **more)
    check(done.code == code, f"{arguments}: exit code {code}, not {done.code}:\n{done.out}{done.err}")
    no_crash(done)
    return done


def snapshot(case):
    return {p: (p.stat().st_mtime_ns, p.stat().st_size) for p in sorted(case.folder.rglob("*"))
            if p.is_file() and p.name not in (".out", ".err", "runtime.lock")}  # what a killed run leaves goes


def refused(case, *arguments, says, ini=None, name="run.ini"):
    """Exit code 2, every sentence said, and nothing written."""
    if ini is not None:
        case.write(name, ini)
    before = snapshot(case)
    done = run(case, *arguments, name=name, code=EXIT_USER)
    for sentence in says:
        check(sentence in done.err, f"{arguments} says '{sentence}':\n{done.err}")
    after = snapshot(case)
    check(before == after, f"nothing is written: {set(before) ^ set(after)}")
    return done


def kill(case):
    """kill -9 after some steps and before the first backup."""
    check(case.wait_for("earlier_1/runtime_identity.txt"), f"the old run moves aside:\n{case.err.read_text()}")  # the last file
    case.wait_for_steps(5)
    case.process.send_signal(signal.SIGKILL)
    case.wait()


def identity(case, name):
    return {k: "".join(case.contents(name)[k]) for k in ("run_id", "run_fingerprint", "run_version")}


def test_used_folder(case):
    """A new run in a used folder, killed before its first backup, is not continued from the backup of the old run."""
    run(case, ini=A, name="a.ini")
    old = identity(case, "runtime_backup0.h5")
    check(re.search(r"[0-9A-F]{16}", old["run_id"]), f"the checkpoint says which run it is of: {old}")
    refused(case, ini=B, name="b.ini", says=["this folder has the results of run", "a.ini", "--restart continues it", "--overwrite"])
    before = {p.name: p.read_bytes() for p in case.folder.glob("runtime_backup*")}
    case.start("b.ini", "--overwrite")
    kill(case)
    check(not list(case.folder.glob("runtime_backup*")), "no backup is where --restart finds it")
    moved = {p.name: p.read_bytes() for p in (case.folder / "earlier_1").glob("runtime_backup*")}
    check(moved == before, "the old one is kept aside")
    for name in ("ekin.t", "a.xmf", "runtime_identity.txt", "ux_000000.h5"):
        check((case.folder / "earlier_1" / name).exists(), f"{name} of the old run is aside too")
    done = refused(case, "--restart", name="b.ini", says=["there is no valid backup to restart from"])
    check("restart   at" not in done.out, "the new run does not go on from the state of the old one")
    refused(case, name="b.ini", says=["which left no backup"])
    done = run(case, "--overwrite", ini=merged(B, {"Time": {"nt": 3}}), name="b.ini")
    check("earlier_2" in done.err, f"the next one is put aside likewise:\n{done.err}")
    new = identity(case, case.newest_checkpoint())
    check(new["run_id"] != old["run_id"] and new["run_fingerprint"] != old["run_fingerprint"], "another run, other inputs")
    done = run(case, "--restart", ini=merged(B, {"Time": {"nt": 5}}), name="b.ini")
    check(identity(case, case.newest_checkpoint())["run_id"] == new["run_id"], "a restart is the same run")
    check("changed   [Time] nt = 5, was 3" in done.out, f"and tells what differs:\n{done.out}")
    check(len(case.series("ekin.t").rows) == 5, "the series is that of one run")
    shutil.copy(case.folder / "earlier_1" / "runtime_backup0.h5", case.folder / "stray.h5")
    refused(case, "--restart=stray.h5", name="b.ini", says=[f"the checkpoint belongs to run {old['run_id'].strip(chr(34))}"])


def test_lock(case):
    """Two runs do not write in one folder; what a killed run leaves does not hinder the next; a lock of another machine is
    explained."""
    case.write("b.ini", B)
    case.start("b.ini")
    case.wait_for_steps(3)
    out, err, first = case.out, case.err, case.process
    second = subprocess.run([case.program, "b.ini", "--overwrite"], cwd=case.folder, capture_output=True, text=True, timeout=ALIVE)
    check(second.returncode == EXIT_USER and "runtime.lock: another run writes here: process" in second.stderr, second.stderr)
    check(str(first.pid) in second.stderr, f"it is named:\n{second.stderr}")
    check(first.poll() is None and not (case.folder / "earlier_1").exists(), "the first goes on undisturbed")
    first.send_signal(signal.SIGUSR1)
    done = case.wait()
    check(done.code == EXIT_STOPPED and out == case.out and err == case.err, f"and ends in order: {done}")
    check(not list(case.folder.glob("runtime.lock*")), "a run that ends removes its lock")
    case.start("b.ini", "--restart")
    check(case.wait_for("runtime.lock"), "it locks")
    case.process.send_signal(signal.SIGKILL)
    case.wait()
    check((case.folder / "runtime.lock").exists(), "a killed run leaves its lock")
    step = int(case.contents(case.newest_checkpoint())["step"][0])
    done = run(case, "--restart", ini=merged(B, {"Time": {"nt": step + 2}}), name="b.ini")
    check("which has ended" in done.err, f"the next one takes it over, and says so:\n{done.err}")
    case.write("runtime.lock", "% A run\nhost = elsewhere\nprocess = 1\nbirth = 7\njob = 4711\nsince = today\n")
    refused(case, "--restart", name="b.ini", says=["process 1 on elsewhere, job 4711", "if it has ended, remove runtime.lock"])


def test_changes(case):
    """Inputs that differ are told, one line each; those that do not fit the state are refused, unless the user insists."""
    case.write("beat.ini", BEAT)
    run(case, ini=WINGS)
    # One hinge moves with the body, the other one is gone.
    other = {"Insects": {"x0": "2.0 2.2 2.0", "RightWing": "no"}, "units": {"frequency": 150}}
    refused(case, "--restart", ini=merged(WINGS, other),
            says=["the left wing would jump, its hinge by 0.2", "the right wing would disappear",
                  "[Insects] RightWing = no, was yes", "[units] frequency = 150", "was 158",
                  "--accept-changes continues nevertheless"])
    case.write("beat.ini", BEAT.replace("ai_phi = 67.5", "ai_phi = 57.5"))
    check(BEAT != BEAT.replace("ai_phi = 67.5", "ai_phi = 57.5"), "the kinematics change")
    refused(case, "--restart", ini=WINGS, says=["the left wing would jump"])
    done = run(case, "--restart", "--accept-changes", ini=merged(WINGS, {"Time": {"nt": 3}}))
    check("accepted  the left wing would jump" in done.out, f"who insists goes on:\n{done.out}")
    check("the content of this file has changed" in done.out, f"the file is named:\n{done.out}")
    done = run(case, "--restart", ini=merged(WINGS, {"Time": {"nt": 4, "dt_fixed": 0.005}, "ReynoldsNumber": {"nu": 2e-2},
                                                     "Saving": {"tintegral": 0.02}}))
    changed = [line for line in done.out.splitlines() if line.startswith("changed ")]
    check(len(changed) == 4 and any("[ReynoldsNumber] nu = " in line and "was 0.01" in line for line in changed),
          f"each of the others has a line, and nothing else: {changed}")


def test_clock(case):
    """Wings count seconds, and the flow counts beats: with another frequency the wings take up the beat where the flow is."""
    flight = merged(FLIGHT, {"Time": {"nt": 2}})
    run(case, ini=flight)
    units = merged(flight, {"units": {"frequency": 120}, "Time": {"nt": 3}})
    done = run(case, "--restart", "--accept-changes", ini=units)
    check("[units] frequency = 120" in done.out, f"it is told:\n{done.out}")
    state = case.contents(case.newest_checkpoint())
    time = float(state["time"][0])
    for side in "left", "right":
        own = float(state[f"{side}_time"][0])
        check(abs(own * 120 / time - 1) < 1e-12, f"the {side} wing is at {own * 120} beats, the flow at {time}")


def test_nothing_written(case):
    """Where nothing can be written a run ends at once with an exit code of its own; the disk is the reason, not the program."""
    gone = case.sub("gone")
    gone.write("run.ini", A)
    ini = gone.folder.parent / "run.ini"
    shutil.move(gone.folder / "run.ini", ini)
    done = subprocess.run(["/bin/sh", "-c", f'cd "{gone.folder}" && rmdir "{gone.folder}" && exec "{case.program}" "{ini}"'],
                          capture_output=True, text=True)
    check(done.returncode == EXIT_UNWRITABLE, f"exit code 5: {done}")
    check("runtime.lock: cannot be written; is the folder missing or read-only, or the disk full?" in done.stderr, done.stderr)


main(globals())
