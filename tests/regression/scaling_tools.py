# SPDX-License-Identifier: GPL-3.0-or-later
"""bench/scaling: the command for clusters counts what the model of the predictions says, on slabs and on pencils; rates
that are hidden in measurements are found again.

usage: scaling_tools.py FOLDER-OF-BENCH/SCALING BUILD-FOLDER
"""

import json
import subprocess
import sys
from pathlib import Path

HERE, BUILD = Path(sys.argv[1]), sys.argv[2]
sys.dont_write_bytecode = True
import scaling_model as model

FAILED = []


def check(holds, sentence):
    print(("pass  " if holds else "FAIL  ") + sentence)
    if not holds:
        FAILED.append(sentence)


def call(tool, *arguments):
    return subprocess.run([sys.executable, "-B", str(HERE / tool), *arguments], capture_output=True, text=True)


# 4 planes for 6 ranks: two rows. 22 x 18 x 20: shares with remainders.
for grid, ranks in (("22,18,20", "1,3,4"), ("24,18,4", "6")):
    done = call("run", "--build", BUILD, "--strong", grid, "--ranks", ranks, "--steps", "2")
    lines = done.stdout.splitlines()
    check(done.returncode == 0 and json.loads(lines[-1])["agrees_with_model"], f"counts are those of the model on {grid}")
    runs = json.loads(lines[-1])["strong"]
    check([r["ranks"] for r in runs] == [int(r) for r in ranks.split(",")], "every number of ranks was run")
    check(runs[-1]["rows"] == (2 if ranks == "6" else 1), "process grid as expected")

# A machine whose rates are known, seen through the times of its steps.
true = {**model.MACHINE, "rate": 3.0e9, "memory": 2.0e10, "network": 4.0e9, "cores": 64, "latency": 0.0}
seen = []
for ranks in (1, 32, 64, 128, 256):
    grid = [512, 512, 512]
    parts = model.fluid_seconds(grid, ranks, true)
    exchange = parts["network"] + parts["memory"]
    sent = model.traffic(grid, ranks)["bytes"]
    seen.append({"grid": grid, "ranks": ranks, "wall_ms": 1e3 * (parts["compute"] + exchange), "exchange_ms": 1e3 * exchange,
                 "bytes": sent})
Path("measured.txt").write_text("a table\n" + json.dumps({"strong": seen, "weak": []}) + "\n", encoding="utf-8")
done = call("predict", "--fit", "measured.txt", "--set", "cores=64", "--set", "latency=0", "--grid", "512,512,512",
            "--ranks", "128", "--surface", "none")
answer = json.loads(done.stdout.splitlines()[-1])
for name in ("rate", "memory", "network"):
    check(abs(answer["machine"][name] / true[name] - 1) < 1e-9, f"{name} is found again")
check(abs(answer["predictions"][0]["fluid_ms"] / seen[3]["wall_ms"] - 1) < 1e-9, "the prediction is what was measured")
check(call("predict", "--set", "speed=1").returncode == 2, "a rate that does not exist is refused")
sys.exit(1 if FAILED else 0)
