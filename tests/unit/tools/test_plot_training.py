# SPDX-License-Identifier: GPL-3.0-or-later
"""plot_training: the page needs nothing else, its numbers are those of the run, nothing that the measurements do not
determine is printed as a plain number, and mistakes are named."""
import base64
import re
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np

import synthetic_training as made
from flusi_msm.training import command as plot_training  # noqa: F401  (chooses the backend)
from flusi_msm.training.maps import edges_of, grid_of
from flusi_msm.training.plots import begins_of_fits, draw_parameters, runs_of
from flusi_msm.training.report import page
from flusi_msm.training.judgement import warnings_of
from flusi_msm.training.run import in_words, read_training
from browser import find_browser, look_at
from synthetic import picture, run_tool


class Page(HTMLParser):
    """Tags in their order, rows of tables by their id, and all text."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.open, self.tables, self.text = [], [], {}, ""
        self.table = None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags.append((tag, attributes))
        if tag == "table":
            self.table = self.tables.setdefault(attributes.get("id"), [])
        elif tag == "tr":
            self.table.append([])
        elif tag in ("td", "th"):
            self.table[-1].append("")
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"</{tag}> closes something else"

    def handle_data(self, data):
        self.text += data
        if self.table and self.open and {"td", "th"} & set(self.open):
            self.table[-1][-1] += data


class PlotTraining(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def report(self, *arguments, **choices):
        made.write_training(self.folder, **choices)
        done = run_tool("plot_training", self.folder, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        made_page = Page((self.folder / "train_report.html").read_text(encoding="utf-8"))
        self.assertEqual(made_page.open, [])
        return made_page

    def text_page(self, **choices):
        """The page without pictures, which take most of the time."""
        return Page(page(read_training(made.write_training(self.folder, **choices)), []))

    def assert_refused(self, *arguments, because):
        done = run_tool("plot_training", *arguments)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn(because, done.stderr)

    def warnings(self, *changes, **choices):
        return " ".join(warnings_of(read_training(made.write_training(self.folder, changes=changes, **choices))))

    def test_page_needs_nothing_else(self):
        done = self.report(readings=True, loads=6)
        text = (self.folder / "train_report.html").read_text(encoding="utf-8")
        self.assertIsNone(re.search(r"https?:|<script|<link|@import|url\(", text))
        tags = [tag for tag, _ in done.tags]
        self.assertLess(tags.index("table"), tags.index("img"), "verdicts first")
        images = [attributes["src"] for tag, attributes in done.tags if tag == "img"]
        self.assertEqual(len(images), 6, "parameters, two pages of loads, readings, profiles, convergence")
        for source in images:
            kind, _, data = source.partition(",")
            self.assertEqual(kind, "data:image/png;base64")
            path = self.folder / "one.png"
            path.write_bytes(base64.b64decode(data))
            height, width, colours = picture(path)
            self.assertTrue(height > 250 and width > 700 and colours > 30, (height, width, colours))
        self.assertIn("8 evaluations & <6> steps", done.text, "the log")
        self.assertIn("bending <test>.h5", done.text)

    @unittest.skipUnless(find_browser(), "no Chromium is found: apt-get install chromium-headless-shell, or set FLUSI_BROWSER")
    def test_nothing_reaches_beyond_the_page(self):
        """On a desk and on a phone, with pictures, everything open, and names without a blank to break at."""
        def lengthen(file):
            file.attrs["measurement"] = np.bytes_("z" * 120)
            file.attrs["unknowns"] = np.bytes_(" ".join(["E", "joint:" + "b" * 60, *made.NAMES[2:]]))

        self.report(changes=[lengthen], readings=True)
        text = (self.folder / "train_report.html").read_text(encoding="utf-8").replace("<details>", "<details open>")
        self.assertIn("b" * 60, text)
        for width in 1280, 390:
            seen = look_at(find_browser(), text, width)
            self.assertEqual((seen["found"], seen["width"] <= width), ([], True), seen)
            self.assertGreater(seen["text"], 2000, "the page was there")
        self.assertTrue(look_at(find_browser(), text.replace("<h1>", "<h1><pre style='white-space: pre'>" + 99 * "wide "), 390)["found"],
                        "what reaches beyond is seen")

    def test_verdicts_come_first(self):
        rows = self.text_page().tables["verdicts"][1:]
        self.assertEqual([row[0] for row in rows], ["E of all veins", "joint base", "joint bend", "joint tip",
                                                    "joint free", "zero of scale"])
        self.assertEqual([row[3] for row in rows], ["determined", "roughly known", "only a lower limit",
                                                    "only an upper limit", "not determined", "determined"])
        self.assertEqual([row[1] for row in rows], ["8.00 GPa", "30.0 µN m/rad", "> 200 µN m/rad", "< 30.0 µN m/rad",
                                                    "not determined", "120 µm"])
        self.assertEqual(rows[0][2], "7.90 to 8.10 GPa")
        self.assertIn("± 1.3 %", rows[0][4])
        self.assertIn("stiffer than 200", rows[2][4])
        self.assertIn("softer than 30", rows[3][4])
        self.assertIn("every value from 1.00 µN m/rad to 10.0 mN m/rad", rows[4][4])

    def test_undetermined_numbers_are_not_shown(self):
        """Where the fit happens to stand says nothing: 770, 4.4 and 55 µN m/rad."""
        rows = self.text_page().tables["verdicts"]
        for row, number in zip(rows[3:6], ("77", "4.4", "55")):
            self.assertNotIn(number, " ".join(row))

    def test_search_of_an_interval_that_failed(self):
        """Neither end was found because the search broke off: that is not "every value is as good"."""
        def change(file):
            file["profiles/joint:free"].attrs["is_complete"] = np.array([0], "i4")

        row = self.text_page(changes=[change]).tables["verdicts"][5]
        self.assertEqual(row[1:4], ["–", "–", "interval not found"])
        self.assertIn("did not finish", row[4])
        figure = draw_parameters(read_training(made.write_training(self.folder, changes=[change])))
        arrows = [text for axes in figure.axes for text in axes.texts if getattr(text, "arrow_patch", None)]
        self.assertEqual(len(arrows), 2, "no arrow for it")

    def test_numbers_of_the_run(self):
        done = self.text_page()
        for text in ("12.0 µm", "20.8 µm", "7e+04, 300, 40, 3, 0.2, 0.01", "257", "180 candidates", "77 evaluations",
                     "3 of 6"):
            self.assertIn(text, done.text)
        row = done.tables["loads"][1]
        self.assertEqual(row[:3] + row[5:], ["load_1", "0.5 mN", "(7.00, -1.00)", "12.0 µm", "12.0 µm", "1.20"])

    def test_pictures_are_written_if_wanted(self):
        self.report("--pictures", self.folder / "p", loads=1)
        names = sorted(path.name for path in (self.folder / "p").iterdir())
        self.assertEqual(names, [f"train_{kind}.png" for kind in ("convergence", "loads_1", "parameters", "profiles")])

    def test_arrows_end_at_the_bounds(self):
        figure = draw_parameters(read_training(made.write_training(self.folder)))
        arrows = {round(-np.log10(text.xyann[0]), 6): text.xy[0] for axes in figure.axes for text in axes.texts
                  if getattr(text, "arrow_patch", None)}
        self.assertEqual(arrows[round(-np.log10(2e-4), 6)], 1e-2, "from the lower limit to the bound")
        self.assertEqual(arrows[6], 1e-2, "from bound to bound")
        self.assertEqual(len(figure.axes), 3, "an axis for every unit")

    def test_history_without_end_or_intervals(self):
        done = self.report(outcome=False)
        self.assertIn("has not reached its end", done.text)
        self.assertEqual([row[1] for row in done.tables["verdicts"][1:]], ["–"] * 6)
        done = self.text_page(intervals=False)
        self.assertEqual({row[3] for row in done.tables["verdicts"][1:]}, {"not examined"})
        self.assertIn("There are no intervals", done.text)

    def test_warnings(self):
        def scaled(factor):
            def change(file):
                file["outcome"].attrs["chi2"] = file["outcome"].attrs["chi2"] * factor**2
            return change

        def at_bound(file):
            file["outcome"].attrs["values"] = [1.0001e8, *made.VALUES[1:]]

        def unsolved(file):
            file["loads/load_2"].attrs["is_solved"] = np.array([0], "i4")

        def other_branch(file):
            file["outcome"].attrs["cold_difference"] = np.array([1e-5])

        def failing(file):
            file["generations"][:, 11] = 0.3 * file["generations"][:, 3]

        def folded(file):
            file["loads/load_1"].attrs["violation"] = [0.0, 0.1]

        usual = self.warnings()
        self.assertIn("joint base and E of all veins are determined only together (correlation -0.97)", usual)
        for change, sentence in ((scaled(2.5), "differ 3 times as much"), (scaled(0.25), "3.3 times less"),
                                 (at_bound, "E of all veins lies at a bound"),
                                 (unsolved, "Load load_2: no equilibrium"),
                                 (other_branch, "the shapes differ by 10.0 µm"),
                                 (failing, "30 % of the candidates had"),
                                 (folded, "Load load_1: the final shape lies")):
            with self.subTest(sentence):
                self.assertNotIn(sentence, usual)
                self.assertIn(sentence, self.warnings(change))

    def test_chance(self):
        """chi^2 of n values has the sd sqrt(2 n)."""
        for sd, is_told in ((-3.0, False), (2.2, False), (2.5, True)):
            def change(file, sd=sd):
                n = float(file["outcome"].attrs["residuals"][0])
                file["outcome"].attrs["chi2"] = np.array([n + sd * np.sqrt(2 * n)])

            with self.subTest(sd):
                self.assertEqual("larger than chance allows" in self.warnings(change), is_told)

    def test_maps_put_heights_where_they_were_measured(self):
        training = read_training(made.write_training(self.folder))
        x, y, field = grid_of(training.loads[0], training.loads[0].rows[:, 2])
        self.assertEqual(field.shape, (9, 21))
        expected = np.broadcast_to(1e-3 * (x / 9)**2, field.shape)
        known = ~np.isnan(field)
        self.assertTrue(0 < (~known).sum() < 12, "the hole")
        np.testing.assert_allclose(field[known], expected[known], rtol=1e-12)
        np.testing.assert_allclose(edges_of(np.array([0.0, 1, 3])), [-0.5, 0.5, 2, 4])

    def test_fits_are_told_apart(self):
        """A fit begins where the errors grow, or where the sum of squares grows with the same errors; a stage with smaller errors may
        begin with a larger sum."""
        rows = [[1, 90, 1, 3], [2, 50, 1, 3], [3, 60, 1, 1], [4, 20, 1, 1],   # a fit of two stages
                [5, 70, 1, 1], [6, 20, 1, 1], [7, 400, 1, 3], [8, 20, 1, 1]]  # from a further start, and of a move
        self.assertEqual(begins_of_fits(SimpleNamespace(polish=np.array(rows, float))), [0, 4, 6])

    def test_runs_are_told_apart(self):
        runs = runs_of(read_training(made.write_training(self.folder)))
        self.assertEqual([(part.start, part.stop) for part in runs], [(0, 10), (10, 20)])

    def test_quantities_in_words(self):
        for arguments, text in (((8e9, "Pa"), "8.00 GPa"), ((12.346e-6, "m", 1e-7), "12.35 µm"), ((0.0, "m"), "0.0 m"),
                                ((1e-6, "N m/rad"), "1.00 µN m/rad"), ((999.9, "1", 5.0), "999.9"),
                                ((3e-15, "m"), "0.00300 pm"), ((-1.2e-4, "m", 2e-5), "-120 µm")):
            with self.subTest(text):
                self.assertEqual(in_words(*arguments), text)

    def test_refusals(self):
        self.assert_refused(self.folder / "none", because="no such folder")
        self.assert_refused(self.folder, because="no NAME_history.h5")
        (self.folder / "bad_history.h5").write_text("no HDF5")
        self.assert_refused(self.folder, because="not a readable history")
        made.write_training(self.folder)
        self.assert_refused(self.folder, because="choose with --name: bad, train")
        self.assert_refused(self.folder, "--name", "x", because="x_history.h5: no such file")
        made.write_training(self.folder, outcome=False)
        self.assert_refused(self.folder, "--name", "train", "-o", "/dev/null/x.html", because="cannot be written")
        made.write_training(self.folder, changes=[lambda file: file.attrs.__setitem__("units", "Pa, m")])
        self.assert_refused(self.folder, "--name", "train", because="different numbers of parameters")
        made.write_training(self.folder, changes=[lambda file: file.attrs.__setitem__("version", 2)])
        self.assert_refused(self.folder, "--name", "train", because="not a history of version 1")


if __name__ == "__main__":
    unittest.main()
