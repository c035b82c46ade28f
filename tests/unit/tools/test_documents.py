#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Documents that are named exist: links of all pages, pages named in sources and messages, pages of the site and its index."""
import re
import subprocess
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]
PAGES = sorted((SOURCE / "docs").rglob("*.md"))
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


if __name__ == "__main__":
    unittest.main()
