#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mutated parameter files through `flusi --check`: accepted, or refused with a message that names the
place; never a crash, a hang or a backtrace.

usage: flusi_check_fuzz.py <flusi> <h5dump> [seed [files]]
"""
import random
import re
import subprocess
import sys
import time
from pathlib import Path

from whole_program import ALIVE, CRASH_MARKS, EXIT_OK, EXIT_USER, SOURCE

JUNK = ["", "0", "-1", "1e999", "nan", "-inf", "1e-400", "99999999999999999999", "2147483648", "yes", "no", "(/ 1 2 /)",
        "(/", "/)", "1;2", "3*dx", "*dx", "1 2 3", "é", "\0", "\t", "%", "!", ";", "=", "[", "]", "[Time]", "nx",
        "backup::", "from_file::", "from_file::/", "infile", "'", '"', "x" * 5000, "1.0d0", "1d", "--1", "0x10", ".",
        "..", "/", "RK4", "none", "\r", "\r\n", "\xff"]


def mutate(text, dice):
    """A few random changes to the lines, words and characters of a file; bytes."""
    lines = text.split("\n")
    for _ in range(dice.choice([1, 1, 1, 2, 3, 6])):
        i = dice.randrange(len(lines))
        kind = dice.randrange(11)
        if kind == 0:
            lines[i] = re.sub(r"=[^;]*", lambda m: "=" + dice.choice(JUNK), lines[i], count=1)
        elif kind == 1:
            lines.insert(i, dice.choice(lines))
        elif kind == 2:
            del lines[i]
        elif kind == 3 and lines[i]:
            j = dice.randrange(len(lines[i]))
            lines[i] = lines[i][:j] + chr(dice.randrange(256)) + lines[i][j + 1:]
        elif kind == 4:
            lines[i] = dice.choice(JUNK) + lines[i]
        elif kind == 5:
            lines[i] = lines[i].replace(";", "")
        elif kind == 6:
            lines[i] = lines[i].replace("=", dice.choice(["", "==", " = ", ";", ":"]))
        elif kind == 7:
            lines = lines[:i + 1]
        elif kind == 8:
            dice.shuffle(lines)
        elif kind == 9:
            lines[i] = lines[i].swapcase()
        else:
            lines[i] = re.sub(r"\d+", lambda m: str(dice.choice([0, 1, 3, 4, 7, 11, 16, 10**dice.randrange(12), -5])),
                              lines[i])
        lines = lines or [""]
    data = "\n".join(lines).encode("latin-1", "replace")
    if dice.randrange(10) == 0:
        data = data[:dice.randrange(len(data) + 1)]  # the last line lacks its end
    if dice.randrange(20) == 0:
        data = b"\xef\xbb\xbf" + data
    return data


def problem(program, file):
    """Runs one check; returns what is wrong with the answer."""
    folder = set(Path.cwd().iterdir())
    try:
        done = subprocess.run([program, "--check", file.name], capture_output=True, timeout=ALIVE)
    except subprocess.TimeoutExpired:
        return "it hangs", None
    out, err = done.stdout.decode("latin-1"), done.stderr.decode("latin-1")
    if done.returncode not in (EXIT_OK, EXIT_USER):
        return f"exit code {done.returncode}: {err}", done.returncode
    if any(mark in out + err for mark in CRASH_MARKS):
        return f"a crash: {err}", done.returncode
    if set(Path.cwd().iterdir()) != folder:
        return "files were written", done.returncode
    if done.returncode == EXIT_OK:
        only_notices = all(line.startswith("notice: ") for line in err.rstrip("\n").split("\n") if err)
        return ("" if "[Resolution]" in out and only_notices else f"an odd answer: {out[:200]}{err}"), done.returncode
    messages = err.rstrip("\n").split("\n")
    # file:line: problem; file: [section] key: problem for what is missing; or the file as a whole.
    for message in messages:
        if not re.match(rf"{re.escape(file.name)}:(\d+:| \[| is empty)", message) and not message.startswith(" "):
            return f"no place in: {message}", done.returncode
    return "", done.returncode


def main():
    program = str(Path(sys.argv[1]).resolve())
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else int(time.time())
    count = int(sys.argv[4]) if len(sys.argv) > 4 else 100
    dice = random.Random(seed)
    print(f"seed {seed}, {count} files", flush=True)
    texts = [p.read_text() for p in sorted((SOURCE / "ini").rglob("*.ini"))]
    texts.append(subprocess.run([program, "--check", str(SOURCE / "ini/flusi/sphere.ini")], capture_output=True,
                                text=True, check=True).stdout)
    tally, failed = {EXIT_OK: 0, EXIT_USER: 0}, 0
    file = Path("mutant.ini")
    # Both answers occur (one file in 20 to 30 is accepted), or the mutations are too weak or too strong.
    most = 5*count if count >= 100 else count
    for i in range(most):
        if i >= count and min(tally.values()) > 0:
            break
        data = mutate(dice.choice(texts), dice)
        file.write_bytes(data)
        wrong, code = problem(program, file)
        if wrong:
            failed += 1
            kept = Path(f"failing_{seed}_{i}.ini")
            kept.write_bytes(data)
            print(f"FAIL  file {i}, kept as {kept}: {wrong}")
        else:
            tally[code] += 1
    print(f"{tally[EXIT_OK]} accepted, {tally[EXIT_USER]} refused, {failed} wrong")
    enough = count < 100 or min(tally.values()) > 0
    if not enough:
        print("FAIL  the mutations test nothing")
    sys.exit(1 if failed or not enough else 0)


main()
