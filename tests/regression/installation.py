# SPDX-License-Identifier: GPL-3.0-or-later
"""cmake --install gives a tree that works without the source: programs, examples, tools, manual pages, completion, module
file, CMake package. usage: installation.py CMAKE BUILD"""
import filecmp
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
CMAKE, BUILD = sys.argv[1], sys.argv[2]
PROGRAMS = ("flusi", "msm_train", "msm_diagnose")
COMPILED = (*PROGRAMS, "msm_probe")  # which the others start


class Installation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        first = Path(cls.folder.name, "first")
        done = subprocess.run([CMAKE, "--install", BUILD, "--prefix", first], capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "WARNING" not in done.stderr.upper(), done.stderr
        cls.prefix = Path(cls.folder.name, "moved elsewhere")  # nothing may remember where it was installed
        first.rename(cls.prefix)
        cls.share = cls.prefix / "share/flusi-msm"

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def run_installed(self, *words, **more):
        path = f"{self.prefix / 'bin'}:{os.environ['PATH']}"
        clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        return subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=300, cwd=self.folder.name,
                              env={**clean, "PATH": path, **more})

    def test_example_inputs(self):
        """Every example passes --check where it is, so that the files that it names are found."""
        for program, name in (("flusi", "sphere"), ("flusi", "wing"), ("flusi", "individuals/7"), ("flusi", "free-flight"),
                              ("msm_train", "train")):
            done = self.run_installed(program, self.share / f"ini/{name}.ini", "--check")
            if name == "train":  # its measurement is made first: docs/guide/training.md
                self.assertRegex(done.stdout + done.stderr, "measurement")
            else:
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_tools(self):
        """Every command of tools is there under its name, starts, and draws with the files of the installation."""
        thin = {path.name for path in (SOURCE / "tools").iterdir() if path.is_file() and not path.is_symlink()
                and not path.suffix and "flusi_msm.project_python" in path.read_text()}
        self.assertGreater(len(thin), 15)
        commands = {path.name for path in (self.prefix / "bin").iterdir()} - set(COMPILED)
        self.assertEqual(commands, {"flusi-" + name.replace("_", "-") for name in thin})
        interpreter = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        done = self.run_installed(self.prefix / "bin/flusi-make-wing", "plate", "plate.h5", **interpreter)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        done = self.run_installed(self.prefix / "bin/flusi-reproduce-paper", "--dry-run", "--grids", "7", **interpreter)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn("reproduce", done.stderr)

    def test_manual_pages_and_completion(self):
        for program in PROGRAMS:
            options = set(re.findall(r"^  (--[a-z][-a-z]*)", self.run_installed(program, "--help").stdout, flags=re.M))
            self.assertGreater(len(options), 4)
            page = (self.prefix / f"share/man/man1/{program}.1").read_text()
            shown = {option.replace("\\-", "-") for option in re.findall(r"^\.B (\\-\\-[a-z][-a-z\\]*)", page, flags=re.M)}
            self.assertEqual(shown, options)
            for heading in ("NAME", "SYNOPSIS", "OPTIONS", "EXIT STATUS", "SEE ALSO"):
                self.assertEqual(page.count(f".SH {heading}\n"), 1, f"{program}: {heading}")
            completion = self.prefix / f"share/bash-completion/completions/{program}"
            done = self.run_installed("bash", "-c", f'. "{completion}"; COMP_WORDS=({program} --ver); COMP_CWORD=1; '
                                      f'_complete_{program}; echo "${{COMPREPLY[@]}}"')
            self.assertEqual(done.stdout.strip(), "--version", done.stderr)
            self.assertEqual(sorted(p.name for p in completion.parent.iterdir()), sorted(PROGRAMS))

    def test_cmake_package(self):
        project = Path(self.folder.name, "project")
        project.mkdir()
        (project / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(user LANGUAGES NONE)\n"
            "find_package(flusi-msm 0.1 REQUIRED CONFIG)\nget_target_property(where flusi-msm::flusi LOCATION)\n"
            'message(STATUS "flusi: ${where}; share: ${flusi-msm_SHARE}")\n')
        done = self.run_installed(CMAKE, "-S", project, "-B", project / "b", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"flusi: {self.prefix}/bin/flusi; share: {self.share}", done.stdout)

    def test_module_file_and_documents(self):
        (module,) = (self.share / "modulefiles/flusi-msm").iterdir()
        version = re.search(r"^version: ([0-9.]+)", (SOURCE / "CITATION.cff").read_text(), flags=re.M).group(1)
        self.assertEqual(module.name, version)
        self.assertTrue(module.read_text().startswith("#%Module"))
        self.assertTrue((self.prefix / "share/doc/flusi-msm/docs/formats/parameters.md").exists())
        for name in ("flusi.sbatch", "individuals.sbatch"):
            self.assertTrue(filecmp.cmp(self.share / "slurm" / name, SOURCE / "tools/slurm" / name, shallow=False))

    def test_nothing_names_the_source(self):
        for path in self.prefix.rglob("*"):
            if path.is_file() and path.suffix != ".h5" and path.name not in COMPILED:
                text = path.read_bytes()
                self.assertNotIn(str(SOURCE).encode() + b"/", text, path)
                self.assertNotIn(str(BUILD).encode(), text, path)
        self.assertEqual([p for p in self.prefix.rglob("__pycache__") if "share/doc" in str(p)], [])

    def test_individuals_are_found_without_the_source(self):
        stubs = Path(self.folder.name, "stubs")
        stubs.mkdir()
        (stubs / "srun").write_text('#!/bin/sh\necho "$@"\n')
        (stubs / "srun").chmod(0o755)
        script = Path(self.folder.name, "slurm_script")  # SLURM runs a copy
        shutil.copy(self.share / "slurm/individuals.sbatch", script)
        done = self.run_installed("bash", script, SLURM_ARRAY_TASK_ID="2",
                                  PATH=f"{stubs}:{self.prefix / 'bin'}:{os.environ['PATH']}")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"flusi {self.share.resolve()}/ini/individuals/2.ini", done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
