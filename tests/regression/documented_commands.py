# SPDX-License-Identifier: GPL-3.0-or-later
"""Every command of README and docs is run, or stands in a table with the reason why not, and its options exist.

usage: documented_commands.py <folder of the programs>

A command is a line of a code block whose first word is a program, a tool or a command of the shell that is listed
below. What can run in seconds runs in a prepared folder: a tree whose `ini`, `wings` and `tools` are those of the
source, with two small flights in `runs`.
A new command that is in no table makes this test fail: give it a place.
"""
import fnmatch
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from whole_program import SOURCE, check, ini_text

PROGRAMS = Path(sys.argv[1])
TOOLS = {path.name for path in (SOURCE / "tools").iterdir() if path.is_file() and os.access(path, os.X_OK)}
OTHERS = {"mpirun", "flusi", "msm_train", "msm_diagnose", "cmake", "ctest", "sbatch", "pip", "mkdocs", "module",
          "docker", "apptainer", "spack", "conda", "eb", "ford", "export", "cd", "mkdir", "cp"}
VERDICTS = (0, 10, 11, 12)

# Pages whose commands are run by another test, all of them.
PAGES = {
    "docs/guide/tutorial.md": "the test tutorial runs the page word by word",
    "docs/guide/mistakes.md": "wrong on purpose; the test typical_mistakes",
    "docs/guide/post-processing.md": "test_postprocess compares every tool with numbers",
}
# Patterns of commands that are not run here, and why.
ELSEWHERE = {
    "tools/quickstart *": "builds or flies for minutes; test_quickstart has each of its steps on pretended machines",
    "cmake --preset *": "builds; test_quickstart", "cmake --build *": "builds; test_quickstart", "ctest *": "runs tests",
    "cmake --install *": "test installation", "module *": "test installation reads the module file",
    "python3 -m venv *": "test installation", "~/flusi-python/*": "test installation",
    "*sbatch *": "needs a cluster; test_slurm_chain has a pretended one", "mkdir my_run *": "with the job that follows",
    "mpirun -n 4 msm_diagnose ini/diagnose.ini": "long; test msm_diagnose", "tools/plot_diagnosis *": "reads that; test tutorial",
    "msm_diagnose ini/vibration.ini": "test vibration_diagnose", "tools/make_modes *": "test vibration_diagnose",
    "msm_diagnose ini/ring-down.ini": "long; test ring_down_diagnose",
    "tools/make_measurement ini/diagnose.json -o ini/bending.h5": "test diagnosis_entries",
    "tools/make_flight *": "test_make_flight", "tools/render runs/wing --time 0.25": "with --wings here; test_render",
    "tools/reproduce_paper": "a night",
    "tools/reproduce_paper --dry-run": "measures its time; test_reproduce_paper",
    "tools/reproduce_paper --individuals 128": "a night; test_reproduce_paper",
    "tools/reproduce_paper --ensemble *": "hours; test_reproduce_paper",
    "tools/reproduce_paper --kinematics *": "hours; test_reproduce_paper",
    "tools/plot_flight RUN": "needs a free flight; test flusi_free_flight, test_plots",
    "tools/blind* *": "many diagnoses; test_blind", "bench/*": "benchmarks of minutes to days",
    "tools/import_flusi_mesh *": "needs a mesh of FLUSI; test_wing_tools", "tools/import_prepazy *": "needs that data",
    "tools/plot_prepazy *": "needs that data", "tools/import_heights *": "needs measured maps; test_import_heights",
    "tools/import_forces *": "needs measured forces; test_import_forces",
    "tools/import_landmarks *": "needs tracked points; test_import_landmarks",
    "tools/import_modes *": "needs measured modes; test_import_vibration", "tools/import_series *": "needs a record; test_import_vibration",
    "export P3DFFT_ROOT=*": "needs P3DFFT", "pip install *": "fetches packages", "ford *": "needs FORD",
    "flusi --keyvalues *": "usage; test flusi_reference_keys", "flusi --compare-keys *": "usage",
    "tools/postprocess TOOL *": "usage",
}
# Words of a page that stand for something, and what stands for them here.
STANDS_FOR = {"RUN_FOLDER": ".", "RUN": "runs/wing", "FILE.ini": "tiny.ini", "INI": "tiny.ini", "[FOLDER]": "made"}


def pages():
    return [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", *sorted((SOURCE / "docs").rglob("*.md"))]


def commands(page):
    """Commands of the blocks of a page, with the number of their line; without comments and explanations."""
    fence = None
    for number, line in enumerate(page.read_text(encoding="utf-8").split("\n"), 1):
        mark = re.match(r"```(\w*)", line)
        if mark:
            fence = None if fence is not None else mark[1] or "text"
        elif fence in ("text", "bash") or fence is None and line.startswith("    "):
            text = re.split(r"\s+# |\s{3,}(?=\S)", line.strip())[0]
            word = re.sub(r"^\(?(cd \S+; |[A-Z_0-9]+=\S+ )*", "", text).split(" ")[0]
            if word in OTHERS | TOOLS or re.match(r"(tools|bench|tests)/|python3$|~/", word):
                yield number, text


def reason(text):
    return next((why for pattern, why in ELSEWHERE.items() if fnmatch.fnmatchcase(text, pattern.replace("[", "[[]"))), None)


def flight(**sections):
    """A short flight on a grid that is far too coarse."""
    motion = "from_file::ini/kinematics/calliphora.ini"
    ini = {
        "units": {"length": 9e-3, "frequency": 158, "density": 1.225},
        "Resolution": {"nx": 32, "ny": 32, "nz": 16}, "Geometry": {"xl": 4.0, "yl": 4.0, "zl": 2.0},
        "Time": {"Tmax": 1.0, "CFL": 0.9, "dt_max": 0.02}, "ReynoldsNumber": {"nu": 5e-3}, "InitialCondition": {"inicond": "quiescent"},
        "Penalization": {"iPenalization": 1, "iMask": "Insect", "eps": 5e-3},
        "Insects": {"wings": "flexible", "x0": "2.0 2.0 1.0", "yawpitchroll_0": "180.0 0.0 0.0", "eta0": -70.0,
                    "x_pivot_l": "0.0 0.5 0.0", "x_pivot_r": "0.0 -0.5 0.0", "wing_ramp": 0.25,
                    "FlappingMotion_left": motion, "FlappingMotion_right": motion},
        "Wing": {"file": "wings/calliphora_small.h5", "E": 1.2e10, "D": 2e-7},
        "Saving": {"tintegral": 0.01, "tsave": 0.25, "iSaveVorticity": "yes", "iSaveVelocity": "yes", "iSaveWingSides": 1}}
    for name, keys in sections.items():
        ini.setdefault(name, {}).update(keys)
    return ini_text(ini)


class Tree:
    """The prepared folder."""

    def __init__(self, folder):
        self.folder = folder
        for name in ("tools", "wings", "bench", "docs"):
            (folder / name).symlink_to(SOURCE / name)
        shutil.copytree(SOURCE / "ini", folder / "ini")
        (folder / "build/release").mkdir(parents=True)
        (folder / "build/release/bin").symlink_to(PROGRAMS)
        self.environment = {**os.environ, "PATH": f"{PROGRAMS}:{os.environ['PATH']}:{SOURCE / 'tools'}"}

    def run(self, text, where="."):
        return subprocess.run(["bash", "-c", text], cwd=self.folder / where, env=self.environment, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300)

    def must(self, text, where="."):
        used = sum(os.times()[2:4])
        done = self.run(text, where)
        code = done.returncode
        print(f"      {sum(os.times()[2:4]) - used:5.1f} s of CPU: {text}", flush=True)
        check(code in (VERDICTS if "msm_diagnose" in text else (0,)), f"{text}: exit code {code}\n{done.stdout[-1500:]}")
        return done.stdout

    def prepare(self):
        """Two flights, copies of one as individuals, small measurements."""
        rows = "".join(f"{k / 16},{70 * math.sin(math.pi * k / 8):.3f},0,{90 + 45 * math.cos(math.pi * k / 8):.3f}\n" for k in range(48))
        (self.folder / "ANGLES.csv").write_text("phase,stroke,deviation,rotation\n" + rows)
        (self.folder / "tiny.ini").write_text(flight(Time={"Tmax": 0.02}))
        for name, wings in (("wing", "flexible"), ("wing-rigid", "rigid")):
            (self.folder / f"{name}.ini").write_text(flight(Insects={"wings": wings}))
            (self.folder / "runs" / name).mkdir(parents=True)
            self.must(f"mpirun -n 1 {PROGRAMS}/flusi ../../{name}.ini", f"runs/{name}")
        for number in (1, 2):
            shutil.copytree(self.folder / "runs/wing", self.folder / f"runs/individuals_{number}")
        case = json.loads((self.folder / "ini/diagnose.json").read_text())
        case.update(wing="wings/calliphora_small.h5", loads=case["loads"][:2], spacing=4e-4, protocol={"levels": [1]})
        (self.folder / "case.json").write_text(json.dumps(case))
        self.must("tools/make_measurement ini/diagnose.json -o ini/bending.h5 --plan --quiet")
        self.must("tools/make_measurement case.json -o small.h5 --quiet")
        (self.folder / "train.ini").write_text(ini_text({
            "Wing": {"file": "wings/calliphora_small.h5", "E": 1e10, "D": 2e-7}, "Measurement": {"file": "small.h5"},
            "Train": {"parameters": "E, joint:C_Sc", "seed": 1}, "CMAES": {"max_generations": 1, "restarts": "none"},
            "Polish": {"intervals": "no", "starts": 1}, "Saving": {"name": "train", "result": "trained.ini"}}))
        self.must("flusi --static ini/static.ini")
        self.must("cp static_05.h5 solid_00020.h5; cp static_05.h5 solid_00030.h5; cp runs/wing/energy.t solid.t")


def test_commands_run(tree):
    n_run, wrong, done = 0, [], set()
    for page in pages():
        name = str(page.relative_to(SOURCE))
        if name in PAGES:
            continue
        for number, text in commands(page):
            if reason(text) or "[--" in text:  # the second is a usage: its options are looked for
                continue
            words = [STANDS_FOR.get(word, word) for word in text.split(" | ")[0].split(" ")]
            line = " ".join(words)
            if line in done:
                continue
            done.add(line)
            print(f"run   {name}:{number}: {line}", flush=True)
            try:
                tree.must(line)
            except AssertionError as failure:
                wrong.append(f"{name}:{number}: {failure}")
            n_run += 1
    check(not wrong, "\n".join(wrong))
    check(n_run > 25, f"{n_run} commands have run")


def test_reasons_are_needed():
    """Every row of the tables is about a command that is still there."""
    texts = [text for page in pages() for _, text in commands(page)]
    for pattern in ELSEWHERE:
        check(any(fnmatch.fnmatchcase(text, pattern.replace("[", "[[]")) for text in texts), f"no page has a command '{pattern}'")
    for page in PAGES:
        check((SOURCE / page).exists(), f"{page} is there")


def test_options_exist(tree):
    """Every option behind a program or a tool, in blocks and in the text, is told by its --help."""
    helps, n_options, wrong = {}, 0, []
    names = "|".join(sorted({"flusi", "msm_train", "msm_diagnose", *TOOLS}, key=len, reverse=True))
    for page in pages():
        if page.name == "mistakes.md":
            continue
        text = page.read_text(encoding="utf-8")
        lines = [line for _, line in commands(page)] + re.findall(r"`([^`\n]+)`", text)
        for line in lines:
            found = re.search(rf"(?:^|[ /])({names})(?= |$)(.*)", line)
            if not found or found[1] == "python" or line.startswith("postprocess -p "):  # FLUSI's own
                continue
            for option in re.findall(r"(?<![\w-])(--[a-z][a-z-]*)", found[2].split(" | ")[0]):
                key = found[1]
                if key == "postprocess" and re.match(r" [a-zA-Z]", found[2]) and " TOOL" not in found[2]:
                    key += " " + found[2].split()[0]
                if key not in helps:
                    helps[key] = tree.run(f"{key.replace('quickstart', 'tools/quickstart')} --help").stdout
                    helps[key] += " --help --parameters"
                n_options += 1
                if option not in helps[key]:
                    wrong.append(f"{page.relative_to(SOURCE)}: {found[1]} has no option {option}: {line}")
    check(not wrong, "\n".join(wrong))
    check(n_options > 80, f"{n_options} options exist")


def main():
    with tempfile.TemporaryDirectory() as folder:
        tree = Tree(Path(folder))
        test_reasons_are_needed()
        test_options_exist(tree)
        print(f"      {sum(os.times()[2:4]):5.1f} s of CPU: the help of all programs and tools", flush=True)
        tree.prepare()
        test_commands_run(tree)
    print("pass")


if __name__ == "__main__":
    try:
        main()
    except AssertionError as failure:
        sys.exit(f"FAIL  {failure}")
