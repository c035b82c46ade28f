#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What documents name exists: links, pages named in sources and messages, pages of the site and its index, files, sections and keys;
tables whose rows have as many cells as their heads."""
import collections
import re
import subprocess
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]
PAGES = sorted((SOURCE / "docs").rglob("*.md"))
TEXTS = [*SOURCE.glob("*.md"), *PAGES]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", flags=re.M | re.S)
SPAN = re.compile(r"`([^`\n]+)`")
FOLDERS = "ini|tools|wings|bench|tests|src|cmake|docs|packaging"
# Sections of other files: a motion of FLUSI, the table of a wing.
OTHER_SECTIONS = {"kinematics", "outline", "root"}
# Files that a command makes, and files of FLUSI's source.
MADE = {"ini/modes.h5", "ini/series.h5", "ini/bending.h5", "src/flexible_solver/mesh/Revolving_bumblebee_wing/params_prescribed_revolving_wing.ini",
        "src/flexible_solver/mesh/Zimmerman/params_Zimmerman-test.ini"}
LINK = re.compile(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)")


class Documents(unittest.TestCase):
    def test_links(self):
        self.assertGreater(len(PAGES), 30)
        for page in [*PAGES, *SOURCE.glob("*.md")]:
            for target in LINK.findall(page.read_text(encoding="utf-8")):
                self.assertTrue((page.parent / target).exists(), f"{page.relative_to(SOURCE)}: there is no {target}")

    def test_site_and_index_hold_every_page(self):
        pages = {str(page.relative_to(SOURCE / "docs")) for page in PAGES}
        site = re.findall(r"- (?:\w+: )?(\S+\.md)$", (SOURCE / "mkdocs.yml").read_text(encoding="utf-8"), flags=re.M)
        self.assertEqual(len(site), len(set(site)))
        self.assertEqual(set(site), pages)
        index = set(LINK.findall((SOURCE / "docs/index.md").read_text(encoding="utf-8"))) - {"../README.md"}
        self.assertEqual(index, pages - {"index.md"})

    def test_named_pages(self):
        """A page that a source, a message, an input or a tool names is there."""
        files = subprocess.run(["git", "ls-files"], cwd=SOURCE, capture_output=True, text=True).stdout.split("\n") \
            if (SOURCE / ".git").exists() else [str(path.relative_to(SOURCE)) for path in (SOURCE / "src").rglob("*.f90")]
        checked = 0
        for name in files:
            path = SOURCE / name
            if path.suffix in (".f90", ".py", ".ini", ".md", ".txt", ".cmake", "") and path.is_file() and name != "CHANGELOG.md":
                for page in re.findall(r"(?<![\w/.-])docs/[\w/.-]*?\.(?:md|json|png)\b", path.read_text(encoding="utf-8")):
                    checked += 1
                    self.assertTrue((SOURCE / page).exists(), f"{name} names {page}")
        self.assertGreater(checked, 40)

    def test_named_files(self):
        """A path in the source that a page names is there; a star stands for anything."""
        checked = 0
        for page in TEXTS:
            if page.name == "CHANGELOG.md":
                continue
            for path in re.findall(rf"(?<![\w/.$-])((?:{FOLDERS})/[\w/.*-]*[\w*/])", page.read_text(encoding="utf-8")):
                places = [SOURCE, page.parent] if page.parent != SOURCE else [SOURCE]
                checked += 1
                self.assertTrue(any(list(place.glob(path.rstrip("/"))) for place in places) or path in MADE,
                                f"{page.relative_to(SOURCE)} names {path}")
        self.assertGreater(checked, 200)

    def test_tables(self):
        """Every row of a table has as many cells as its head. A bar with a backslash is part of a cell."""
        rows = 0
        for page in TEXTS:
            text = FENCE.sub(lambda block: "\n" * block[0].count("\n"), page.read_text(encoding="utf-8"))
            head = None
            for number, line in enumerate(text.split("\n"), 1):
                bars = len(re.findall(r"(?<!\\)\|", line)) if line.lstrip().startswith("|") else None
                if bars is not None and head is not None:
                    rows += 1
                    self.assertEqual(bars, head, f"{page.relative_to(SOURCE)}, line {number}: {line}")
                head = None if bars is None else head or bars
        self.assertGreater(rows, 1000)

    def test_named_keys(self):
        """`[Section] key` in a page, and the keys of an example, are those of a program."""
        keys = reference()
        checked = 0
        for page in TEXTS:
            text = page.read_text(encoding="utf-8")
            if page.name in ("CHANGELOG.md", "parameters.md", "mistakes.md"):  # the last one has wrong keys on purpose
                continue
            for section, names in named_keys(text):
                for name in names:
                    checked += 1
                    self.assertIn(name, keys.get(section, ()), f"{page.relative_to(SOURCE)} names [{section}] {name}")
        self.assertGreater(checked, 60)


def reference():
    """The keys of all programs by section, as the reference of parameters has them."""
    keys = collections.defaultdict(set)
    section = None
    for line in (SOURCE / "docs/formats/parameters.md").read_text(encoding="utf-8").split("\n"):
        if line.startswith("## "):
            section = line[4:-1]
        elif section and re.match(r"\| `", line):
            keys[section].add(line.split("`")[1])
        elif section and line.startswith("Accepted from FLUSI"):
            keys[section].update(SPAN.findall(line))
    return keys


def named_keys(text):
    """Pairs of a section and its keys, of spans such as `[Time] CFL, nt` and of blocks that look like an input."""
    blocks = [block for kind, block in FENCE.findall(text) if kind not in ("toml", "python", "json")]
    blocks += re.findall(r"(?:^ {4}.*\n)+", text, flags=re.M)
    for span in SPAN.findall(FENCE.sub("", text)):
        found = re.match(r"\[([A-Za-z]\w*)\] (\w+(?:, \w+)*)", span)
        if found and found[1] not in OTHER_SECTIONS:
            yield found[1], found[2].split(", ")
    for block in blocks:
        section = None
        for line in block.split("\n"):
            head = re.match(r"\s*\[([A-Za-z]\w*)\]\s*(?:;.*)?$", line)
            key = re.match(r"\s*(\w+) *= *\S", line)
            if head:
                section = head[1]
            elif section and key and section not in OTHER_SECTIONS:
                yield section, [key[1]]


if __name__ == "__main__":
    unittest.main()
