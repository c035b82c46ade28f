# SPDX-License-Identifier: GPL-3.0-or-later
"""One start of the paper's validation on the small wing: E and ten joints of a noise-free replicate from anywhere in the box.

usage: training_validation.py BENCH_TRAINING WING.h5
"""
import json
import subprocess
import sys

# The bars that were set beforehand (docs/results/training-results.md).
BARS = {"evaluations": 3000, "E_rel": 1e-6, "joints_rel_max_identifiable": 1e-3, "h": 1e-8}
SEED = 2


def main():
    run = subprocess.run([sys.argv[1], sys.argv[2], "--seed", str(SEED)], capture_output=True, text=True)
    print(run.stdout, run.stderr)
    if run.returncode != 0:
        sys.exit(f"the exit code is {run.returncode}")
    record = json.loads(run.stdout.splitlines()[-1])
    missed = [f"{key} = {record[key]}, at most {bar}" for key, bar in BARS.items() if not record[key] <= bar]
    if missed or run.stdout.count("joint:") != 10 or "not identifiable" in run.stdout:
        sys.exit("; ".join(missed) or "ten identifiable joints were expected")


if __name__ == "__main__":
    main()
