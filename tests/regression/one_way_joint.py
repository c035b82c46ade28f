# SPDX-License-Identifier: GPL-3.0-or-later
"""A joint that is 1.4 times as stiff upward as downward, as in the wings of house flies (Wehmann et al. 2019,
doi:10.1242/bio.038299), at the joint where the loads show it best, in data of other mechanics: msm_diagnose finds it if
--plan has promised so, says from where on it would if not, and never names one in the same wing without it.

usage: one_way_joint.py MSM_DIAGNOSE
"""
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
STRENGTH = 1.4
LOADS = [[0.00541, 0.00005, 6e-4], [0.00856, -0.00078, 1e-4], [0.0042, -0.0009, 4e-4]]  # x, y [m], force [N]
ADEQUATE, NAMED, SET = 0, 10, 11
INPUT = """[Wing]
file = {wing};
[Measurement]
file = bending.h5;
[Next]
modes = 0;
[Diagnose]
parameters = E, joint:*;
observations = 250;
refine = no;
starts = 1;
draws = 1000;
refits = 1;
validation = no;
intervals = no;
"""


def check(condition, sentence):
    print("ok  " if condition else "FAIL", sentence)
    if not condition:
        sys.exit(1)


def measure(folder, noise, joint=None, further=()):
    """Data with heights of this sd [m]; three loads, each up and down, and further ones."""
    case = {"wing": str(SOURCE / "wings/calliphora_small.h5"), "seed": 5, "spacing": 3e-4,
            "loads": [[x, y, sign * force] for sign in (1, -1) for x, y, force in LOADS] + list(further),
            "protocol": {"random_order": True},
            "stiffness": {"plate": "edges", "E": 9.0e9, "joints": {"C_Sc": 1.0e-6}},
            "noise": {"height": noise, "tilt": 100 * noise, "piston": noise / 2, "reference_scans": 4}}
    if joint:
        case["stiffness"]["one_way"] = [joint, STRENGTH]
    (folder / "case.json").write_text(json.dumps(case))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_measurement", "case.json", "-o", "bending.h5"], cwd=folder,
                   check=True, stdout=subprocess.DEVNULL)
    (folder / "case.ini").write_text(INPUT.format(wing=case["wing"]))


def plan(program, folder):
    """The smallest factor that is found nine times in ten, and the joint that needs it; then the further load [x, y, N]
    that would lower this factor most, and to what."""
    done = subprocess.run([program, "case.ini", "--plan"], cwd=folder, capture_output=True, text=True, check=True)
    # The first two tables of the plan: what the loads show, and one load more. A table on look-alikes follows.
    now, more = [line.split() for line in done.stdout.splitlines() if line.startswith("one_way_joint")][:2]
    return factor(now), now[1].split(":")[1], [float(word) for word in more[1:4]], factor(more)


def factor(words):
    return float(words[words.index("of") + 1])


def diagnose(program, folder):
    done = subprocess.run([program, "case.ini", "--exit-code"], cwd=folder, capture_output=True, text=True, timeout=300)
    print(done.stdout, done.stderr, sep="")
    found = json.loads((folder / "diagnosis.json").read_text())
    entry = {e["name"]: e for e in found["effects"]}["one_way_joint"]
    named = [c["effect"] for c in found["verdict"]["causes"]] + found["verdict"]["set"]
    return done.returncode, "one_way_joint" in named, entry


def main(program):
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for noise, is_seen in (1e-6, True), (1e-5, False):
            if is_seen:
                measure(folder, noise)
                limit, joint, further, promised = plan(program, folder)
                check(limit < STRENGTH, f"with errors of {1e6 * noise:.0f} um {joint} shows from {limit:.2f} on")
                code, is_named, _ = diagnose(program, folder)
                check(code == ADEQUATE and not is_named, "the replicate without one-way joint is adequate")
                measure(folder, noise, further=[further])
                kept = plan(program, folder)[0]
                check(kept < limit, f"one more load lowers that to {kept:.3f}")
                # Joints, levels and noise of the plan are those of the data; what a scan of the new load sees is not.
                check(abs(math.log(kept) / math.log(promised) - 1) < 0.1, f"as was promised: {promised:.3f}")
            measure(folder, noise, joint)
            code, is_named, entry = diagnose(program, folder)
            if is_seen:
                check(code in (NAMED, SET) and is_named and entry["variant"] == joint, "the one-way joint is found")
                # The limit is 3.5 to 4.5 sd, which no estimate is off by but one in thousands.
                sd = math.log(limit) / 3.5
                check(abs(entry["estimate"][0] - math.log(STRENGTH)) < 4 * sd,
                      f"with a factor of {math.exp(entry['estimate'][0]):.2f}")
            else:
                check(code == ADEQUATE, "what is below the limit is not found")
                limit = math.exp(min(entry["detectable"]))
                check(limit > STRENGTH, f"and the limit of {limit:.1f} is told")


if __name__ == "__main__":
    main(sys.argv[1])
