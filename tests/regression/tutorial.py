# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/guide/tutorial.md word by word: its commands run in an empty folder, make its pictures, and find what it says.

usage: tutorial.py <folder of the programs>
"""
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
PAGE = (SOURCE / "docs/guide/tutorial.md").read_text(encoding="utf-8")
BEFORE = ("cd flusi-msm", "tools/quickstart build", "export FLUSI=$PWD")  # the tree that is tested is there and built


def commands():
    """All lines of the blocks for bash, in order."""
    blocks = re.findall(r"^```bash\n(.*?)^```", PAGE, flags=re.M | re.S)
    return [line for block in blocks for line in block.rstrip().split("\n")]


def check(is_true, sentence):
    print(f"{'pass' if is_true else 'FAIL'}  {sentence}", flush=True)
    if not is_true:
        sys.exit(1)


def main():
    lines = [line for line in commands() if line not in BEFORE]
    check(len(lines) > 12, f"the page has {len(lines)} commands")
    lines = [line.replace("$FLUSI/build/release/bin", sys.argv[1]) for line in lines]
    # A verdict of msm_diagnose may be an exit code.
    script = "".join(f"{line} || {{ code=$?; [[ '{line[:30]}' = *msm_diagnose* && $code =~ ^1[012]$ ]] || exit $code; }}\n"
                     for line in lines)
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["bash", "-c", script], cwd=folder, env={**os.environ, "FLUSI": str(SOURCE), "HOME": folder},
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        check(done.returncode == 0, f"all commands run\n{done.stdout if done.returncode else ''}")
        place = Path(folder) / "my-wing"
        check("named: a damaged region" in done.stdout, "the tear is named")
        check("the fit does not agree with the declared errors" in done.stdout, "the training warns")
        found = re.search(r"^E = (\S+);", (place / "diagnosis_extended.ini").read_text(), re.M)
        told = re.search(r"Young's modulus is (\S+) GPa instead", PAGE)
        check(abs(float(found[1]) / 1e9 - float(told[1])) < 0.05, f"E with the tear is {found[1]} Pa, told are {told[1]} GPa")
        subprocess.run([sys.executable, SOURCE / "docs/images/tutorial_pictures.py", place, folder], check=True)
        for picture in re.findall(r"images/(tutorial-[\w-]+\.png)", PAGE):
            check((Path(folder) / picture).stat().st_size > 5000, f"the commands make {picture}")


if __name__ == "__main__":
    main()
