# SPDX-License-Identifier: GPL-3.0-or-later
"""The recipes in packaging name what the project needs: packages, versions, limits of Python packages."""
import ast
import re
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]
PACKAGING = SOURCE / "packaging"
VERSION = re.search(r"project\(flusi_msm VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8"))[1]


def read(name):
    return (PACKAGING / name).read_text(encoding="utf-8")


def limits():
    """name -> (lowest, below) of the Python packages that tools need, as tools/requirements.txt has them."""
    rows = re.findall(r"^(\w+)>=([\d.]+),<(\d+)", (SOURCE / "tools/requirements.txt").read_text(encoding="utf-8"), re.M)
    return {name: (lowest, below) for name, lowest, below in rows}


def run_dependencies():
    """Names of the Python packages without which the package of tools/ is not whole."""
    text = (SOURCE / "tools/pyproject.toml").read_text(encoding="utf-8")
    return set(re.findall(r'"(\w+)>=', re.search(r"^dependencies = \[(.*?)\]", text, re.M | re.S)[1])) - {"tomli"}


class Packaging(unittest.TestCase):
    def test_every_python_package_is_named(self):
        self.assertLessEqual({"numpy", "pandas", "pillow"}, run_dependencies())
        for name in run_dependencies():
            self.assertRegex(read("conda/meta.yaml"), rf"(?m)^    - {name}(-base)? ")
            self.assertIn({"pillow": "python3-pil", "svgelements": '"svgelements>='}.get(name, f"python3-{name}"), read("Dockerfile"))
            if name != "svgelements":  # no package there
                self.assertIn(f'"py-{name}@', read("spack/flusi-msm/package.py"))
                bundled = {"numpy": "SciPy-bundle", "scipy": "SciPy-bundle", "pandas": "SciPy-bundle", "pillow": "Pillow"}
                self.assertIn(f"('{bundled.get(name, name)}', ", read(f"easybuild/flusi-msm-{VERSION}-foss-2023b.eb"))

    def test_docker_installs_what_quickstart_installs(self):
        quickstart = (SOURCE / "tools/quickstart").read_text(encoding="utf-8")
        components = re.search(r"^components='(.*)'", quickstart, re.M)[1].split()
        told = dict(re.findall(r"^ +apt:([\w-]+)\) +echo (.*?) ;;", quickstart, re.M))
        told["ninja"] = "ninja-build"  # its row is shared with dnf
        wanted = {package for c in components if c != "git" for package in told.get(c, c).split()}
        first = read("Dockerfile").split("FROM debian:12\n")[0]
        self.assertLessEqual(wanted, set(first.split()))
        self.assertGreater(len(wanted), 12)

    def test_easybuild(self):
        recipe = {}
        exec(compile(read(f"easybuild/flusi-msm-{VERSION}-foss-2023b.eb"), "eb", "exec"), recipe)  # a list of assignments
        self.assertEqual((recipe["name"], recipe["version"]), ("flusi-msm", VERSION))
        self.assertGreaterEqual(dict(recipe["builddependencies"])["CMake"], "3.25")
        self.assertLessEqual({"HDF5", "SuiteSparse", "Python", "h5py", "matplotlib"}, set(dict(recipe["dependencies"])))

    def test_conda(self):
        text = read("conda/meta.yaml")
        self.assertIn(f'set version = "{VERSION}"', text)
        for name, (lowest, below) in limits().items():
            if name != "tomli":
                self.assertRegex(text, rf"- {name}(-base)? >={re.escape(lowest)},<{below}\b")

    def test_spack(self):
        text = read("spack/flusi-msm/package.py")
        self.assertTrue(any(isinstance(node, ast.ClassDef) and node.name == "FlusiMsm" for node in ast.parse(text).body))
        for name, (lowest, below) in limits().items():
            if name not in ("svgelements", "tomli"):
                self.assertIn(f"py-{name}@{lowest}:{int(below) - 1}", text)
        self.assertIn("cmake@3.25:", text)


if __name__ == "__main__":
    unittest.main()
