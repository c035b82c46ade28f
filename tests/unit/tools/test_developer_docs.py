#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of docs/developer keep up with the sources: links lead to files, names exist, the picture shows the layers."""
import re
import subprocess
import sys
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]
PAGES = sorted((SOURCE / "docs/developer").glob("*.md"))
LINK = re.compile(r"\]\(([^)#:]+)\)")
NAME = re.compile(r"`([a-z][a-z0-9]*(?:_[a-z0-9]+)+)`")
FOLDERS = ("src", "tests", "cmake", "tools")


def names_in_sources():
    """Every word with an underscore in the sources, and every name of a file without its ending."""
    words = set()
    for folder in FOLDERS:
        for path in (SOURCE / folder).rglob("*"):
            if path.suffix in (".f90", ".py", ".cmake") or path.name == "CMakeLists.txt":
                words |= set(re.findall(r"\b[a-z][a-z0-9]*(?:_[a-z0-9]+)+\b", path.read_text(encoding="utf-8")))
                words.add(path.stem)
            elif path.is_file():
                words.add(path.name)
    return words | {"test_environment", "lower_case"}  # a file of the build directory, a way to write names


class Pages(unittest.TestCase):
    def test_links(self):
        self.assertGreater(len(PAGES), 3)
        for page in PAGES:
            for target in LINK.findall(page.read_text(encoding="utf-8")):
                self.assertTrue((page.parent / target).exists(), f"{page.name}: there is no {target}")

    def test_module_links(self):
        """A link whose text is a name leads to the file of this name."""
        for page in PAGES:
            for text, target in re.findall(r"\[(\w+)\]\(([^)]+\.f90)\)", page.read_text(encoding="utf-8")):
                self.assertEqual(Path(target).stem, text, page.name)

    def test_names(self):
        known = names_in_sources()
        for page in PAGES:
            for name in NAME.findall(page.read_text(encoding="utf-8")):
                self.assertTrue(name in known, f"{page.name}: nothing in {', '.join(FOLDERS)} has the name {name}")

    def test_names_in_linked_modules(self):
        """`name` in [module](file): the procedure or type is in that file."""
        for page in PAGES:
            for name, target in re.findall(r"`(\w+)` in\s+\[\w+\]\(([^)]+)\)", page.read_text(encoding="utf-8")):
                text = (page.parent / target).read_text(encoding="utf-8")
                is_there = re.search(rf"\b(subroutine|function|type\b.*::) {name}\b", text)
                self.assertTrue(is_there, f"{page.name}: {name} is not in {target}")

    def test_named_tests(self):
        """Behind `tests/.../file.py` in a command: every test_name is a function of that file."""
        checked = 0
        for page in PAGES:
            for path, rest in re.findall(r"`[^`\n]*?(tests/[\w/]+\.py)\b([^`\n]*)`", page.read_text(encoding="utf-8")):
                functions = re.findall(r"^def (\w+)", (SOURCE / path).read_text(encoding="utf-8"), flags=re.M)
                for name in re.findall(r"\btest_\w+", rest):
                    checked += 1
                    self.assertIn(name, functions, f"{page.name}: {path} has no such test")
        self.assertGreater(checked, 0)

    def test_picture(self):
        run = subprocess.run([sys.executable, "-B", SOURCE / "docs/developer/layers.py", "--check"], capture_output=True,
                             text=True)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
