# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools that are begun with a Python without packages: the project's own takes over, or one line says what is missing."""
import ast
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import venv
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]


class ProjectPython(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name).resolve()
        shutil.copytree(SOURCE / "tools", self.root / "tools", ignore=shutil.ignore_patterns("__pycache__"))

    def run_tool(self, tool, *words, python=sys.executable, **environment):
        """Without what is installed for the interpreter: -S finds the standard library alone."""
        clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        return subprocess.run([str(python), "-B", "-S", str(self.root / "tools" / tool), *words], capture_output=True,
                              text=True, timeout=300, cwd=self.root, env={**clean, **environment})

    def check_message(self, done, *packages):
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(f"has no {', '.join(packages)}. 'tools/quickstart deps'", done.stderr)

    def test_no_packages(self):
        for tool in ("plot_cycle", "make_measurement", "import_prepazy"):
            done = self.run_tool(tool, "--help")
            self.check_message(done, "numpy", "h5py", "matplotlib", "scipy", "svgelements")
            self.assertTrue(done.stderr.startswith(f"{tool}: "), done.stderr)

    def make_own(self, *packages):
        """A Python of the project, which tells its arguments, with packages."""
        own = self.root / "environment/bin/python"  # .venv may be elsewhere
        own.parent.mkdir(parents=True)
        own.write_text("#!/bin/sh\nprintf '<%s>' \"$@\"\nexit 7\n")
        own.chmod(0o755)
        for name in packages:
            (self.root / "environment/lib/python3/site-packages" / name).mkdir(parents=True)
        (self.root / ".venv").symlink_to("environment")

    def test_taken_over(self):
        self.make_own("numpy", "h5py", "matplotlib")
        n_tools = 0
        for tool in sorted(path.name for path in (self.root / "tools").iterdir()):
            text = "" if (self.root / "tools" / tool).is_dir() else (self.root / "tools" / tool).read_text()
            if "__main__" not in text or "flusi_msm" not in text:
                continue
            n_tools += 1
            with self.subTest(tool):
                done = self.run_tool(tool, "a file", "--option")
                self.assertEqual((done.returncode, done.stdout),
                                 (7, f"<{self.root}/tools/{tool}><a file><--option>"), done.stderr)
        self.assertGreaterEqual(n_tools, 15)
        done = self.run_tool("plot_cycle", FLUSI_MSM_BEGUN_AGAIN="yes")  # once is enough
        self.check_message(done, "numpy", "h5py", "matplotlib", "scipy", "svgelements")
        for words in ["-c", "import flusi_msm.project_python"], ["-"]:  # not a tool
            done = subprocess.run([sys.executable, "-B", "-S", *words], capture_output=True, text=True, timeout=300,
                                  cwd=self.root / "tools", input="import flusi_msm.project_python")
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_own_is_worse(self):
        """One that pip has left without packages, or one that has not what is missing, does not take over."""
        for packages in (), ("numpy",), ("scipy",):
            with self.subTest(packages):
                self.make_own(*packages)
                self.check_message(self.run_tool("plot_cycle"), "numpy", "h5py", "matplotlib", "scipy", "svgelements")
                shutil.rmtree(self.root / "environment")
                (self.root / ".venv").unlink()

    def test_own_without_packages(self):
        venv.create(self.root / ".venv", symlinks=True)
        own = self.root / ".venv/bin/python"
        done = subprocess.run([own, "-B", self.root / "tools/plot_cycle"], capture_output=True, text=True, timeout=300,
                              env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"})
        self.check_message(done, "numpy", "h5py", "matplotlib", "scipy", "svgelements")

    def test_without_scipy(self):
        """Pictures do not need it; what does says so."""
        packages = self.root / "packages"
        packages.mkdir()
        real = Path(importlib.util.find_spec("numpy").origin).parent
        for folder in (real, real.with_name("numpy.libs")):
            (packages / folder.name).symlink_to(folder)
        for name in ("h5py", "matplotlib"):
            (packages / name).mkdir()
        shutil.copy(SOURCE / "ini/diagnose.json", self.root / "case.json")
        done = self.run_tool("import_heights", "--help", PYTHONPATH=str(packages))
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.run_tool("make_measurement", "case.json", "-o", "out.h5", PYTHONPATH=str(packages))
        self.check_message(done, "scipy")

    def test_an_old_python_reads_it(self):
        """It says which packages are missing, so that a Python older than that of the tools must be able to run it."""
        tree = ast.parse((SOURCE / "tools/flusi_msm/project_python.py").read_text(), feature_version=(3, 7))
        first = next(node for node in tree.body if isinstance(node, ast.ImportFrom))
        self.assertEqual((first.module, first.names[0].name), ("__future__", "annotations"))


if __name__ == "__main__":
    unittest.main()
