#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A run that gets too little memory ends with a message and exit code 6, and one that will is told before it begins.

usage: flusi_memory.py <flusi> <h5dump> [tests]
"""
import re
import resource

from whole_program import EXIT_OK, check, main, merged, no_crash, ring

EXIT_MEMORY = 6


def limited(case, megabytes, ini):
    """A run whose addresses are limited, as by ulimit -v."""
    case.write("run.ini", ini)
    old = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (megabytes * 1000000, old[1]))  # a child inherits that
    try:
        case.start("run.ini")
    finally:
        resource.setrlimit(resource.RLIMIT_AS, old)
    return case.wait(120)


def meets_small_array(done):
    """Whether the limit struck an array far smaller than a field, or one of the compiler's library. Such an array has no message of
    its own, and the compiler lets the program crash where it is made by an assignment."""
    found = re.search(r"(?:Error allocating|rank 0 cannot allocate) (\S+) bytes", done.err)
    return float(found.group(1)) < 1e6 if found else "SIGSEGV" in done.err or "Memory allocation failed" in done.err


def test_allocation_fails(case):
    """If a field does not fit into the memory, the program names the size of the field. The limit rises by half a field at a time.
    Small arrays may meet some limits: where a library takes more as soon as it fits, those before the first field meet two or three
    in a row again. Most limits meet a field."""
    ini = ring(128, Time={"nt": 0}, Saving={"iSavePress": "yes", "iSaveVorticity": "yes"})
    told, named, small, in_row = set(), 0, 0, 0
    for megabytes in range(240, 800, 8):  # programs and libraries take some 250 to 400; a field takes 17
        done = limited(case.sub(str(megabytes)), megabytes, ini)
        if not told and done.code != EXIT_OK and "flusi-msm: rank" not in done.err:
            continue  # at the start MPI or another library meets the limit
        if done.code != EXIT_OK and meets_small_array(done):
            small, in_row = small + 1, in_row + 1
            check(in_row <= 3, f"at {megabytes} MB a field does not fit, and the program names its size: {done}")
            continue
        in_row = 0
        no_crash(done)
        if done.code == EXIT_OK:
            break
        if "flusi-msm: rank" not in done.err:
            continue  # another library
        check(done.code == EXIT_MEMORY, f"exit code 6 at {megabytes} MB: {done}")
        found = re.search(r"flusi-msm: rank 0 cannot allocate (\S+) bytes \((.+?)\): use more machines", done.err)
        check(found, f"the size is told: {done.err}")
        check(float(found.group(1)) < 3e8, f"the size is that of a field or a few: {found.group(1)}")
        told.add(found.group(2))
        named += 1
    check(len(told) >= 2 and named >= 2 * small, f"at least two arrays meet the limit, in most runs: {told}, {named} and {small} small ones")
    print(f"      {sorted(told)}; {named} runs, {small} with small arrays", flush=True)


def system(case, total, available, group=None):
    """A folder with files like those of Linux: kB in /proc/meminfo, bytes of the control group."""
    root = case.folder / "system"
    (root / "proc/self").mkdir(parents=True, exist_ok=True)
    (root / "proc/meminfo").write_text(f"MemTotal: {total} kB\nMemFree: 1 kB\nMemAvailable: {available} kB\nSwapTotal: 0 kB\n")
    (root / "proc/self/cgroup").write_text("0::/job/step\n")
    (root / "sys/fs/cgroup/job/step").mkdir(parents=True, exist_ok=True)
    if group:
        (root / "sys/fs/cgroup/job/memory.max").write_text(f"{group}\n")
        (root / "sys/fs/cgroup/job/memory.current").write_text("1000000\n")
        (root / "sys/fs/cgroup/job/memory.stat").write_text("anon 5\ninactive_file 400000\n")
    (root / "sys/fs/cgroup/job/step/memory.max").write_text("max\n")
    return {"FLUSI_TEST_SYSTEM": str(root)}


def test_machine(case):
    """A flow of 32^3 needs 2 MB or so at its start: more than the machine has, more than is free, and enough."""
    ini = ring(32, Time={"nt": 1})
    for name, env, code, words in (
            ("none", system(case.sub("a"), 1000, 500), EXIT_MEMORY, r"flusi: 1 ranks on \S+ need about 0?\.0\d GB .* are all that"),
            ("busy", system(case.sub("b"), 2000000, 1000), EXIT_OK, r"notice: 1 ranks on .* free: the run may be ended"),
            ("job", system(case.sub("c"), 2000000, 2000000, 1200000), EXIT_MEMORY, r"0?\.00 GB are all that"),
            ("enough", system(case.sub("d"), 2000000, 2000000, 1000000000), EXIT_OK, None),
            ("unknown", {"FLUSI_TEST_SYSTEM": "/no/such/folder"}, EXIT_OK, None)):
        run = case.sub(name)
        run.write("run.ini", ini)
        done = run.run("run.ini", ranks=0, code=code, env=env)
        check(re.search(words, done.err) if words else "GB" not in done.err, f"{name}: {done.err}")
        check(code == EXIT_OK or run.files() == ["run.ini"], f"{name}: a refused run writes nothing: {run.files()}")
    two = case.sub("two")
    two.write("run.ini", ini)
    done = two.run("run.ini", ranks=2, code=EXIT_MEMORY, env=system(case.sub("e"), 1000, 500))
    check(done.err.count("flusi: 2 ranks on ") == 1, f"one rank speaks for both: {done.err}")


def test_huge(case):
    """This machine, whatever it is, has not 1 TB for a flow."""
    case.write("run.ini", merged(ring(2048), {"Time": {"nt": 1}}))
    done = case.flusi("run.ini", ranks=0)
    no_crash(done)
    check(done.code in (2, EXIT_MEMORY), f"refused: {done}")


main(globals())
