#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: mistakes are refused with usage or reason, exit code 2, and nothing is written.

usage: flusi_command_line.py <flusi> <h5dump> [tests]
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from whole_program import EXIT_FAILURE, EXIT_OK, EXIT_USER, SOURCE, STATIC_REFERENCE, check, live_keys, main, merged, no_crash, sphere

# With this in the environment MPI cannot start.
NO_MPI = {"OMPI_MCA_pml": "no_such_component", "OMPI_MCA_mpi_show_mca_params": ""}


def snapshot(case):
    return {n: (case.folder / n).stat().st_mtime_ns for n in case.files() if n not in (".out", ".err")}


def quiet_run(case, *arguments, code=EXIT_OK, ranks=0, env=None):
    """Runs the program, which must write nothing into its folder."""
    before = snapshot(case)
    done = case.run(*arguments, ranks=ranks, code=code, env=env)
    after = snapshot(case)
    check(before == after, f"{arguments} writes nothing: {sorted(set(after) ^ set(before))}")
    return done


def test_usage(case):
    case.write("run.ini", sphere())
    mistakes = {
        (): "the name of a parameter file is missing",
        ("--bogus", "run.ini"): 'unknown argument "--bogus"',
        ("run.ini", "-x"): 'unknown argument "-x"',
        ("run.ini", "--restart", "--chek"): 'unknown argument "--chek"',
        ("run.ini", "other.ini"): "too many file names",
        ("--check",): "the name of a parameter file is missing",
        ("--dry-run",): "the name of a parameter file is missing",
        ("--restart",): "the name of a parameter file is missing",
        ("run.ini", "--restart="): "--restart= needs the name of a backup",
        ("run.ini", "--check", "--restart"): "--restart is valid for a run only",
        ("run.ini", "--check", "--dry-run"): '"--dry-run" contradicts "--check"',
        ("--keyvalues", "--compare-keys", "a", "b"): '"--compare-keys" contradicts "--keyvalues"',
        ("--keyvalues",): "--keyvalues needs the name of an HDF5 field",
        ("--keyvalues", "a.h5", "b.h5"): "too many file names",
        ("--compare-keys", "a.key"): "--compare-keys needs the names of two key files",
        ("--compare-keys", "a.key", "b.key", "c.key"): "too many file names",
        ("--postprocess", "run.ini"): "--postprocess knows --keyvalues and --compare-keys",
    }
    for arguments, sentence in mistakes.items():
        done = quiet_run(case, *arguments, code=EXIT_USER)
        check(f"flusi: {sentence}" in done.err, f"{arguments}: {sentence}:\n{done.err}")
        check("usage: mpirun" in done.err and done.out == "", f"{arguments}: usage, on standard error")
    done = quiet_run(case, "--bogus", "--wrong", code=EXIT_USER)
    check(all(word in done.err for word in ("--bogus", "--wrong", "missing")), "all mistakes are told at once")


def test_help_and_version(case):
    for argument in ("--help", "-h"):
        done = quiet_run(case, argument, env=NO_MPI)
        check(done.out.startswith("usage: mpirun") and done.err == "", "usage goes to standard output")
        for word in ("--check", "--dry-run", "--restart", "--keyvalues", "--compare-keys", "exit codes"):
            check(word in done.out, f"{word} is explained")
    done = quiet_run(case, "--version", env=NO_MPI)
    check(re.search(r"^flusi-msm \d+\.\d+\.\d+ \(\w+.*\)$", done.out, re.M), f"version and commit:\n{done.out}")
    check("compiler" in done.out and "flags" in done.out, "compiler and flags")
    check(re.search(r"^P3DFFT    (yes|no)$", done.out, re.M), f"whether the transform of P3DFFT is there:\n{done.out}")


def test_transform(case):
    """The transform of P3DFFT is refused where it is not built in, and told where it is used."""
    case.write("wrong.ini", sphere(Parallel={"transform": "fftw"}))
    done = quiet_run(case, "--check", "wrong.ini", code=EXIT_USER)
    check("[Parallel] transform" in done.err and "builtin" in done.err, f"the transforms are told:\n{done.err}")
    case.write("run.ini", sphere(Parallel={"transform": "p3dfft"}, Time={"nt": 1}))
    if not case.has_p3dfft():
        done = quiet_run(case, "run.ini", ranks=2, code=EXIT_USER)
        check("run.ini:" in done.err and "[Parallel] transform: this program was built without P3DFFT" in done.err and
              "P3DFFT_ROOT" in done.err, f"what to do is said:\n{done.err}")
        return
    quiet_run(case, "--check", "run.ini")
    done = case.run("run.ini", ranks=2)
    check("transform p3dfft" in done.out, f"the run tells its transform:\n{done.out}")
    case.write("small.ini", sphere(n=4, Parallel={"transform": "p3dfft"}))
    done = case.run("small.ini", ranks=3, code=EXIT_OK)
    done = case.run("small.ini", ranks=5, code=EXIT_USER)
    check("P3DFFT cannot share the grid among 5 ranks" in done.err, f"too many ranks are refused:\n{done.err}")


def test_parameter_files(case):
    """Files that are not there, cannot be read, or hold mistakes, alone and under mpiexec."""
    case.write("wrong.ini", merged(sphere(), {"Resolution": {"nx": 17}, "Time": {"CFL": "fast", "Tmaxx": 1},
                                              "Saving": {"tsave": -1}}))
    case.write("empty.ini", "")
    (case.folder / "binary.ini").write_bytes(bytes(range(256)) * 8)
    (case.folder / "folder.ini").mkdir()
    wrong = {
        "nosuch.ini": ["nosuch.ini: cannot be opened"],
        "folder.ini": ["folder.ini: cannot be read: Is a directory"],
        "no/such/run.ini": ["no/such/run.ini: cannot be opened"],
        "empty.ini": ["empty.ini", "[Resolution] nx"],
        "binary.ini": ["binary.ini"],
        "wrong.ini": ["wrong.ini:", "Tmaxx", "Tmax", "CFL", "fast", "tsave"],
    }
    for name, words in wrong.items():
        calls = [(["--check", name], 0), ([name], 2)]
        if name == "wrong.ini":
            calls += [([name], 0), (["--dry-run", name], 2), (["--restart", name], 1)]
        for arguments, ranks in calls:
            done = quiet_run(case, *arguments, ranks=ranks, code=EXIT_USER)
            for word in words:
                check(word in done.err, f"{arguments} on {ranks} ranks tells {word}:\n{done.err}")
    once = quiet_run(case, "nosuch.ini", ranks=3, code=EXIT_USER)
    check(once.err.count("nosuch.ini: cannot be opened: ") == 1, "one rank speaks for all")
    if os.geteuid() != 0:
        case.write("secret.ini", sphere())
        (case.folder / "secret.ini").chmod(0)
        done = quiet_run(case, "secret.ini", code=EXIT_USER)
        check("secret.ini: cannot be" in done.err, "a file that may not be read")


def test_check(case):
    """--check needs no MPI and prints every key with its value and where it comes from."""
    for name in ("sphere", "vortex_ring"):
        shutil.copy(SOURCE / f"ini/flusi/{name}.ini", case.folder)
        done = quiet_run(case, "--check", f"{name}.ini", env=NO_MPI)
        reference = quiet_run(case, "--parameters", env=NO_MPI).out
        known = live_keys(reference.split(STATIC_REFERENCE)[0])
        check(len(known) > 80, f"the reference has keys: {len(known)}")
        section, printed, given = "", set(), set()
        for line in done.out.splitlines():
            if line.startswith("["):
                section = line.strip("[]")
            found = re.match(r"  (\S+) = (.*?);\s+(.*)$", line)
            if found:
                printed.add((section, found.group(1)))
                check(re.search(r"(default|" + name + r"\.ini:\d+)", found.group(3)), f"the origin is told: {line}")
                if ".ini:" in found.group(3):
                    given.add((section, found.group(1)))
        check(known - printed == set(), f"every key is printed, also {sorted(known - printed)[:5]}")
        check(printed - known == set(), f"every printed key is documented, also {sorted(printed - known)[:5]}")
        check(("Geometry", "Size") in given and ("Time", "nt") not in given, "the file and defaults are told apart")
    control = case.flusi("vortex_ring.ini", env=NO_MPI)
    check(control.code not in (EXIT_OK, EXIT_USER), "a run without MPI is impossible: this test tests something")


def test_checked_is_equivalent(case):
    """What --check prints is itself an input file with the same effect."""
    fixed = {f"iMeanFlow_{c}": "fixed" for c in "xyz"}
    case.write("run.ini", sphere(MeanFlow={"iMeanFlow": None, **fixed}))
    first = quiet_run(case, "--check", "run.ini").out
    for c in "xyz":
        check(re.search(rf"^  {c}0 = ; .* {c}l/2, computed by the program", first, re.M), f"{c}0 is a formula")
    lines = [line for line in first.splitlines() if line[:1] in ("[", " ") and " = ; " not in line]
    case.write("printed.ini", re.sub(r";.*", ";", "\n".join(lines)))
    second = quiet_run(case, "--check", "printed.ini").out

    def values(text):
        return re.findall(r"^  (\S+ = .*?);", text, re.M)

    check(values(first) == values(second), "printed values are read back the same")


def test_dry_run(case):
    ini = sphere(Time={"nt": None, "Tmax": 0.2, "CFL": 0.1}, Saving={"iSaveMask": "yes", "iSaveVorticity": "yes"},
                 SaveSlices={"use_slicing": "yes", "slice1": 3, "tslice": 0.1})
    case.write("run.ini", ini)
    for ranks in (0, 1, 4):
        done = quiet_run(case, "--dry-run", "run.ini", ranks=ranks)
        check(re.search(rf"^ +{max(ranks, 1)} ranks = \d+ x \d+ +[\d.]+ MB", done.out, re.M), "memory for these ranks")
        check(re.search(r"^ +16 ranks = 1 x 16 +[\d.]+ MB", done.out, re.M), "and for others")
    dt = float(re.search(r"time step about +(\S+)", done.out).group(1))
    steps = int(re.search(r"steps +about (\d+)", done.out).group(1))
    case.run("run.ini", ranks=2)
    made = case.series("timesteps_info.t").rows
    # The flow accelerates around the body: up to twice the velocity of the mean flow.
    middle = made[len(made) // 2][3]
    check(middle <= dt <= 2.5 * middle, f"dt is {middle}, about {dt}")
    check(steps <= len(made) <= 2.5 * steps, f"{len(made)} steps, about {steps}")
    listed = done.out.split("files that would be written")[1]
    for name in case.files():
        if name.endswith(".t"):
            check(name in listed or name.startswith("forces_part"), f"{name} was announced")
    for prefix in {n.split("_")[0] for n in case.files() if n.endswith(".h5") and "slice" not in n}:
        check(re.search(rf"\b{prefix}", listed) or prefix == "runtime", f"{prefix} was announced:\n{listed}")
    check("sliceu1" in listed and "runtime_backup0.h5" in listed, "slices and backups were announced")


def test_ranks(case):
    """More ranks than the grid can be shared among."""
    ini = sphere(Resolution={"nx": 8, "ny": 4, "nz": 4, "process_rows": 1})
    case.write("run.ini", ini)
    done = quiet_run(case, "run.ini", ranks=5, code=EXIT_USER)
    check("the grid cannot be shared among 5 ranks" in done.err and "[Resolution] process_rows" in done.err, done.err)
    case.write("run.ini", merged(ini, {"Resolution": {"process_rows": 3}}))
    done = quiet_run(case, "run.ini", ranks=4, code=EXIT_USER)
    check("the grid cannot be shared among 4 ranks" in done.err, done.err)
    case.write("run.ini", merged(ini, {"Resolution": {"process_rows": 0}, "Time": {"nt": 3}}))
    case.run("run.ini", ranks=6)
    rows = case.series("timesteps_info.t").rows
    check(len(rows) == 3 and rows[0][4] == 6, "six ranks share a grid of 4 planes as rows and columns")


def test_compatibility(case):
    """A key given twice is a mistake; with --flusi-compat the first wins, with a warning."""
    text = "[Resolution]\nnx=8;\nny=8;\nnz=8;\nnx=16;\n[InitialCondition]\ninicond=quiescent;\n"
    case.write("run.ini", text)
    done = quiet_run(case, "--check", "run.ini", code=EXIT_USER)
    check("run.ini:5:" in done.err and "nx" in done.err, done.err)
    done = quiet_run(case, "--check", "--flusi-compat", "run.ini")
    check(re.search(r"nx = 8; +run.ini:2", done.out), f"the first wins:\n{done.out}")
    check("run.ini:5" in done.out + done.err, "and it is said")


def test_keys(case):
    """--keyvalues and --compare-keys, here and in FLUSI's way."""
    case.write("run.ini", sphere(Time={"nt": 6}))
    case.run("run.ini", ranks=2)
    last = max(n for n in case.files() if n.startswith("ux_"))
    done = quiet_run(case, "--keyvalues", last, env=NO_MPI)
    keys = [float(w) for w in done.out.split()]
    values = case.field(last)
    n = len(values)
    step = 2.5 / 16
    mean, square = sum(values) / n, sum(v * v for v in values) / n
    place = sum(v * step * (i % 16 + i // 16 % 16 + i // 256) for i, v in enumerate(values)) / n
    for got, want in zip(keys, (case.attribute(last, "time")[0], max(values), min(values), mean, square, place)):
        check(abs(got - want) <= 1e-8 * max(1.0, abs(want)), f"key {got} is {want}")  # nine digits are printed
    # FLUSI's scripts: the key goes beside the field, the verdict to the file `return`.
    done = case.run("--postprocess", "--keyvalues", last, ranks=0, env=NO_MPI)
    key = last.replace(".h5", ".key")
    check((case.folder / key).read_text() == done.out, "the key file holds what is printed")
    first = "ux_000000.h5"
    case.run("-p", "--keyvalues", first, ranks=0)
    done = quiet_run(case, "--compare-keys", key, key)
    check(done.out.count("ok") == 6, f"equal keys:\n{done.out}")
    done = quiet_run(case, "--compare-keys", key, "ux_000000.key", code=EXIT_FAILURE)
    check("different" in done.out, f"different keys:\n{done.out}")
    for other, code, verdict in ((key, EXIT_OK, "0"), ("ux_000000.key", EXIT_FAILURE, "1")):
        case.run("--postprocess", "--compare-keys", key, other, ranks=0, code=code)
        check((case.folder / "return").read_text().strip() == verdict, f"the file return holds {verdict}")
    # FLUSI's tolerance is 1e-4, relative.
    words = (case.folder / key).read_text().split()
    for factor, code in ((1 + 9e-5, EXIT_OK), (1 + 1.1e-4, EXIT_FAILURE)):
        case.write("near.key", " ".join([*words[:4], f"{float(words[4]) * factor:.8E}", words[5]]) + "\n")
        quiet_run(case, "--compare-keys", key, "near.key", code=code)
    case.write("text.key", "not a key\n")
    for arguments, word in ((("--keyvalues", "nosuch.h5"), "nosuch.h5"), (("--keyvalues", "run.ini"), "run.ini"),
                            (("--keyvalues", "."), ".: "), (("--compare-keys", key, "nosuch.key"), "nosuch.key"),
                            (("--compare-keys", key, "text.key"), "text.key"),
                            (("--compare-keys", key, "."), ".: "),
                            (("--keyvalues", "runtime_backup0.h5"), "runtime_backup0.h5")):
        done = quiet_run(case, *arguments, code=EXIT_USER)
        check(f"flusi: {word}" in done.err, f"{arguments}: the file is named:\n{done.err}")


def test_reference_of_parameters(case):
    """docs/formats/parameters.md is what the program says."""
    done = quiet_run(case, "--parameters", env=NO_MPI)
    no_crash(done)
    check(done.out == (SOURCE / "docs/formats/parameters.md").read_text(),
          "docs/formats/parameters.md is current; renew it with `flusi --parameters > docs/formats/parameters.md`")


def test_reference_of_causes(case):
    """docs/formats/causes.md is what msm_diagnose, which stands beside flusi, says."""
    done = subprocess.run([Path(sys.argv[1]).with_name("msm_diagnose"), "--causes"], cwd=case.folder, env={**os.environ, **NO_MPI},
                          capture_output=True, text=True, check=True)
    check(done.stdout == (SOURCE / "docs/formats/causes.md").read_text(),
          "docs/formats/causes.md is current; renew it with `msm_diagnose --causes > docs/formats/causes.md`")


main(globals())
