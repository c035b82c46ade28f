# SPDX-License-Identifier: GPL-3.0-or-later
"""plot_diagnosis: one page with the verdict first, all pictures inside, and what a cause changes in flight."""
import json
import re
import tempfile
import unittest
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from browser import find_browser, look_at
from flusi_msm.diagnosis.beat import draw_beat, read_beats
from flusi_msm.diagnosis.modes import draw_modes
from flusi_msm.diagnosis.report import page, what_of
from flusi_msm.diagnosis.tracks import draw_tracks, read_tracks
from flusi_msm.diagnosis.series import draw_record, read_series
from synthetic import CYCLE_MEANS, run_tool, write_flapping_run

SOURCE = Path(__file__).resolve().parents[3]
EFFECT = {"name": "drift", "title": "a wing that changed", "sentence": "It dried.", "is_measurement": True, "variants": 1,
          "status": "tested", "missing": "", "variant": "", "place": [0.0, 0.0], "local_p": 1e-9, "p": 1e-8,
          "retained": 0.4, "log_evidence": 20.0, "posterior": 0.9999, "parameters": ["drift"],
          "detectable": [0.0012], "shows_from": "0.12 % stiffer each time", "finding": "The wing became stiffer: about 0.20 %"}
FOLDS = {"location": [1.0, 2.0], "observations": [20.0, 20.0], "log_density": [10.0, 11.0], "chi2": [60.0, 50.0],
         "sum_of_squares": [1e-9, 1e-9]}
DIAGNOSIS = {
    "schema": "flusi-msm diagnosis", "schema_version": 2, "program": "msm_diagnose", "seed": 1,
    "wing": str(SOURCE / "wings/calliphora_small.h5"), "measurement": "bending.h5",
    "verdict": {"word": "named", "is_together": False, "sentence": "a wing that changed", "probability": 0.9999, "global_p": 1e-8, "snr": 7.0,
                "grade": "A",
                "causes": [{"effect": "drift", "name": "a wing that changed", "variant": "", "place": [0, 0],
                            "finding": "The wing became stiffer from one measurement to the next: 0.2 % each time"}],
                "set": ["drift"]},
    "noise": {"warning": "", "heavy_tails": {"is_found": False}}, "questions": [], "next": {"sentence": "", "measurements": []},
    "data": [{"kind": "bending", "observations": 1463, "baseline_chi2": 1466.9, "sets": []}],
    "effects": [EFFECT],
    "baseline": {"observations": 1463, "chi2": 1466.9,
                 "parameters": [{"name": "E", "unit": "Pa", "value": 9.1e9, "is_log": True, "sd": 0.01, "prior_sd": 2.3},
                                {"name": "joint:C_h", "unit": "N m/rad", "value": 0.009189, "is_log": True, "sd": 2.2,
                                 "prior_sd": 2.3}]},
    "extended": {"is_found": True, "parameters": [
        {"name": "E", "unit": "Pa", "value": 8.2e9, "is_log": True, "sd": 0.2, "prior_sd": 2.3},
        {"name": "joint:C_h", "unit": "N m/rad", "value": 1.618e-4, "is_log": True, "sd": 1.0, "prior_sd": 2.3},
        {"name": "drift", "unit": "1", "value": 0.002, "is_log": False, "sd": 5e-4, "prior_sd": 0.3}],
                 "findings": [{"name": "drift", "sentence": "The wing became stiffer: 0.2 % each time, 0.1 to 0.3 %"}],
                 "intervals_90": [{"name": "drift", "lower_best_upper": [0.001, 0.002, 0.003], "has_lower": True,
                                   "has_upper": True, "lower_is_jump": False, "upper_is_jump": False}]},
    "validation": {"has_gain": True, "gain_per_location": 5.0, "standard_error": 1.0, "baseline": FOLDS,
                   "extended": {**FOLDS, "log_density": [16.0, 15.0], "chi2": [22.0, 19.0]}}}


class Report(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "diagnosis.json").write_text(json.dumps(DIAGNOSIS))
        rng = np.random.default_rng(1)
        with h5py.File(self.folder / "diagnosis.h5", "w") as file:
            for name, point in (("P01", (0.004, 0.0)), ("P02", (0.006, -0.001))):
                rows = np.concatenate([rng.uniform((0.001, -0.002), (0.008, 0), (20, 2)), rng.normal(size=(20, 5))], 1)
                table = file.create_dataset(f"loads/{name}", data=rows)
                table.attrs["point"], table.attrs["force"] = point, 1e-3
            file["unknown/stiffness"] = np.concatenate([rows[:9, :2], np.ones((9, 2))], 1)

    def page(self, *arguments, diagnosis=None):
        if diagnosis:
            (self.folder / "diagnosis.json").write_text(json.dumps(diagnosis))
        done = run_tool("plot_diagnosis", self.folder / "diagnosis.json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return (self.folder / "diagnosis_report.html").read_text()

    def told(self, **changes):
        """The page without pictures, which take most of the time."""
        return page({**DIAGNOSIS, **changes}, [])

    def test_page(self):
        text = self.page("--pictures", self.folder / "pictures")
        self.assertLess(text.index("The cause has a name"), text.index("from one measurement to the next: 0.2 % each time."))
        self.assertLess(text.index("from one measurement to the next: 0.2 % each time."), text.index("<img"))
        self.assertEqual(text.count("data:image/png;base64,"), 5)
        self.assertFalse(re.search(r"(src|href)=\"(?!data:)", text), "nothing is fetched from elsewhere")
        self.assertEqual(text.count("over 99 %"), 1, "one probability")
        self.assertIn("<b>How sure is that? over 99 %</b> is the probability that this cause is really there", text)
        self.assertIn("less than 1 in 10<sup>8</sup>", text)
        self.assertIn("0.00100 to 0.00300", text)
        self.assertIn("The wing became stiffer: 0.2 % each time, 0.1 to 0.3 %", text)
        self.assertEqual(sorted(p.name for p in (self.folder / "pictures").iterdir()), [f"diagnosis_{n}.png" for n in (
            "evidence", "folds", "residuals_P01", "residuals_P02", "unknown_stiffness")])
        self.assertNotIn("in flight", text)
        self.assertIn("0.12 % stiffer each time", text)
        self.assertNotIn("cannot tell apart", text)

    def test_motion(self):
        """Modes and records have a picture each, a record one of its own; without an extended wing only the baseline is drawn."""
        time = np.arange(30) / 1e4
        with h5py.File(self.folder / "diagnosis.h5", "r+") as file:
            for name in "ring", "tap":
                for number in range(1, 6):
                    seen = np.cos(2e3 * time) * np.exp(-200 * time)
                    table = np.stack([time, seen + 0.01 * number, 0.01 + 0 * time, seen, seen], 1)
                    table[3, 1] = np.nan
                    file[f"series/{name}/{number}"] = table
                    file[f"series/{name}/{number}"].attrs["point"] = (0.008, -0.0005)
            file["modes/one"] = np.concatenate([np.random.default_rng(1).normal(size=(8, 4)) ** 2 + 0.1, np.ones((8, 2))], 1)
        facts = {"medium": "air", "units": "m/s", "observations": 149, "baseline_rms": 3.0, "baseline_size_error": 0.0,
                 "baseline_late_s": 0.0}
        mode = {"name": "one", "medium": "air", "frequency_hz": 400.0, "sd_hz": 2.0, "baseline_number": 1, "baseline_hz": 401.0,
                "baseline_mac": 0.99, "extended_number": 1, "extended_hz": 400.0, "extended_mac": 0.999}
        diagnosis = {**DIAGNOSIS, "data": [{"kind": "series", "sets": [{**facts, "name": "ring"}, {**facts, "name": "tap"}]},
                                          {"kind": "modes", "sets": [mode]}]}
        text = self.page("--pictures", self.folder / "pictures", diagnosis=diagnosis)
        self.assertEqual(text.count("data:image/png;base64,"), 8)
        for name in "series_ring", "series_tap", "modes":
            self.assertTrue((self.folder / f"pictures/diagnosis_{name}.png").exists(), name)
        damped = {**mode, "damping_ratio": 0.02, "damping_sd": 0.001, "baseline_damping_ratio": 0.03, "extended_damping_ratio": 0.021}
        shape = np.ones((4, 6))
        for facts, rows in (mode, 1), (damped, 2):
            figure = draw_modes([(facts, shape)], [], lambda ax, outline: None, True)
            axes = [ax for ax in figure.axes if ax.get_ylabel().endswith("[%]")]
            self.assertEqual(len(axes), rows, "damping ratios have a picture if there are some")
            plt.close(figure)
        self.assertEqual(axes[1].get_xticklabels()[0].get_text(), "one\nratio 0.02")
        drawn = [line.get_ydata()[0] for line in axes[1].lines if line.get_label() in ("baseline", "extended")]
        np.testing.assert_allclose(drawn, [50.0, 5.0], rtol=1e-12)
        records = read_series(self.folder / "diagnosis.h5", diagnosis)
        for is_extended, lines in ((False, 2), (True, 3)):
            figure = draw_record(*records[0], is_extended)
            self.assertEqual(len(figure.axes), 8, "four traces of five, above and below")
            self.assertEqual([axis.get_title().split()[2] for axis in figure.axes[::2]], list("2345"), "those that fit worst")
            self.assertEqual(len(figure.axes[0].get_legend().get_texts()), lines)
            plt.close(figure)

    def test_landmarks(self):
        """Landmarks of each wing have a picture with their tracks in the planes that were seen, and with what is left."""
        time = np.arange(20) / 20

        def coordinate(wing, mark, axis, values):
            return {"name": f"one:{wing}:{mark}:{axis}", "observations": 20, "record": "one", "component": axis, "unit": "m", "wing": wing,
                    "landmark": mark, "point": [8e-3, 0], "time": list(time), "measured": list(values), "sd": [1e-4] * 20,
                    "simulated": list(values + 3e-4 * mark), "extended": list(values - 5e-5)}
        y, z = 8e-3 * np.cos(2 * np.pi * time), 3e-3 * np.sin(2 * np.pi * time)
        sets = [coordinate("left", mark, axis, values) for mark in (1, 2, 3, 4, 5) for axis, values in (("y", y), ("z", z))]
        sets += [coordinate("right", 1, axis, values) for axis, values in (("x", y + z), ("y", -y), ("z", z))]
        diagnosis = {**DIAGNOSIS, "data": [{"kind": "landmarks", "sets": sets, "observations": 260, "baseline_chi2": 300.0}]}
        text = self.page("--pictures", self.folder / "pictures", diagnosis=diagnosis)
        self.assertIn("<h2>Landmarks over the beat</h2>", text)
        self.assertIn("landmarks over the beat</td>", text)
        made = sorted(path.name for path in (self.folder / "pictures").iterdir())
        self.assertEqual([name for name in made if "tracks" in name], ["diagnosis_tracks_one_left.png", "diagnosis_tracks_one_right.png"])
        (name, left), (_, right) = read_tracks(diagnosis)
        self.assertEqual((name, sorted(left), sorted(right[1])), ("one_left", [1, 2, 3, 4, 5], ["x", "y", "z"]))
        for is_extended in (False, True):
            figure = draw_tracks(left, is_extended)
            view, rest = figure.axes
            self.assertEqual([text.get_text() for text in view.get_legend().get_texts()],
                             ["measured", "simulated", "with the cause"][:2 + is_extended])
            self.assertEqual(len(view.lines), 4 * (2 + is_extended), "those that fit worst")
            np.testing.assert_allclose(view.lines[1].get_xdata(), 1e3 * y + 0.6, err_msg="the second landmark is the first of them [mm]")
            np.testing.assert_allclose(rest.lines[0].get_ydata(), 3 * np.sqrt(11), err_msg="root mean square of 3, 6, .. 15 sd")
            plt.close(figure)
        # The first of the landmarks, which nobody saw along z, is in no picture: the second one has the labels.
        figure = draw_tracks({mark: axes if mark > 2 else {"y": axes["y"]} for mark, axes in left.items()}, False)
        self.assertEqual([text.get_text() for text in figure.axes[0].get_legend().get_texts()], ["measured", "simulated"])
        plt.close(figure)
        # No landmark was seen along both axes of a picture.
        figure = draw_tracks({1: {"y": left[1]["y"]}, 2: {"z": left[2]["z"]}}, False)
        self.assertIsNone(figure.axes[0].get_legend())
        plt.close(figure)
        figure = draw_tracks(right, True)
        self.assertEqual([axis.get_ylabel() for axis in figure.axes], ["z [mm]", "z [mm]", "left [sd]"])
        plt.close(figure)

    def test_release_in_vacuum(self):
        """A release says where it is done in the words of the other measurements."""
        one = {"kind": "series", "medium": "vacuum", "released_n": 1e-5, "place_m": [1e-3, 2e-3], "samples": 60, "rate_hz": 5000.0}
        self.assertEqual(what_of(one), "release a force of 0.01 mN at (1.00, 2.00) mm in a vacuum, 60 samples at 5000 Hz")

    def test_forces(self):
        """A record of forces has a picture with its components; without an extended wing only the case is drawn. Waves over the beat
        have no place on the wing."""
        time = np.arange(20) / 20
        force = 2e-3 * np.cos(2 * np.pi * time)

        def component(record, name, unit):
            return {"name": f"{record}:{name}", "observations": 20, "record": record, "component": name, "unit": unit, "time": list(time),
                    "measured": list(force), "sd": [1e-4] * 20, "simulated": list(force + 3e-4), "extended": list(force - 5e-5)}
        sets = [component("one", "Fy", "N/m"), component("one", "power", "W/m"), component("two", "Fz", "N/m")]
        with h5py.File(self.folder / "diagnosis.h5", "r+") as file:
            file["unknown/flight"] = np.concatenate([np.zeros((6, 2)), np.ones((6, 2))], 1)
        diagnosis = {**DIAGNOSIS, "data": [{"kind": "flight", "sets": sets}]}
        text = self.page("--pictures", self.folder / "pictures", diagnosis=diagnosis)
        self.assertIn("<h2>Forces over the beat</h2>", text)
        self.assertEqual(text.count("data:image/png;base64,"), 7, "one for each record beside the five of bending tests")
        made = sorted(path.name for path in (self.folder / "pictures").iterdir())
        self.assertEqual([name for name in made if "beat" in name], ["diagnosis_beat_one.png", "diagnosis_beat_two.png"])
        self.assertNotIn("diagnosis_unknown_flight.png", made)
        record, components = read_beats(diagnosis)[0]
        self.assertEqual((record, [one["component"] for one in components]), ("one", ["Fy", "power"]))
        for is_extended in (False, True):
            figure = draw_beat(components, is_extended)
            above, below = figure.axes[:2]
            self.assertEqual([axis.get_ylabel() for axis in figure.axes[::2]], ["Fy [mN/m]", "power [mW/m]"])
            self.assertEqual([text.get_text() for text in above.get_legend().get_texts()],
                             ["measured, 1 sd", "simulated", "with the cause"][:2 + is_extended])
            band = above.collections[0].get_paths()[0].vertices[:, 1]
            np.testing.assert_allclose((band.min(), band.max()), (-2.1, 2.1), err_msg="one sd about the measured means [mN/m]")
            lines = {line.get_label(): line.get_ydata() for line in above.lines}
            np.testing.assert_allclose(lines["measured, 1 sd"], 1e3 * force)
            np.testing.assert_allclose(lines["simulated"], 1e3 * force + 0.3)
            for line, left in zip(below.lines, (3.0, -0.5)):
                np.testing.assert_allclose(line.get_ydata(), left, err_msg="simulated minus measured [sd]")
            self.assertEqual(len(below.lines), 1 + is_extended)
            plt.close(figure)

    def test_undetermined_numbers_are_not_shown(self):
        """A joint of which the data say less than was assumed, or leave a range of ten times, has no value: 9189 and 162 µN m."""
        text = self.told()
        self.assertIn("E of all veins</td><td class=number data-label=\"without the cause\">9.10 GPa ± 1.6 %</td>"
                      "<td class=number data-label=\"with it\">about 8.20 GPa (within a factor of 1.4)</td>", text)
        row = text[text.index("joint C_h"):]
        row = row[:row.index("</tr>")]
        self.assertEqual(row.count("not determined"), 2)
        self.assertNotRegex(row, r"\d\d|9\.|1\.6")

    def test_other_files(self):
        """The messages for a folder, for a file that is no diagnosis and for a missing file differ."""
        (self.folder / "wing.h5").write_bytes(b"\x89HDF\r\n")
        (self.folder / "fly.ini").write_text("[Wing]\n")
        for name, words in ((".", "is a folder; name the file of a diagnosis in it"), ("wing.h5", "wing.h5: is not JSON; name the file"),
                            ("fly.ini", "fly.ini: is not JSON; name the file"), ("no.json", "no.json: No such file or directory")):
            done = run_tool("plot_diagnosis", self.folder / name)
            self.assertEqual(done.returncode, 2)
            self.assertIn(words, done.stderr)

    def test_good_sum_of_squares(self):
        """It says why a good chi^2 can hide a cause where it does so, in numbers, and not where chi^2 is large."""
        self.assertIn("has χ² = 1466.9 for 1463 numbers, and so looks good", self.told())
        base = {**DIAGNOSIS["baseline"], "chi2": 1700.0}
        self.assertNotIn("looks good", self.told(baseline=base))

    def test_flight(self):
        """The table has the means that the runs were made with; the other run has 0.5 n more lift in cycle n."""
        for name, drift in (("baseline", 0.0), ("extended", 0.5)):
            write_flapping_run(self.folder / name, drift=drift)
        text = self.page("--flight", self.folder / "baseline", self.folder / "extended")
        self.assertEqual(text.count("data:image/png;base64,"), 6)
        lift = CYCLE_MEANS["lift"]
        self.assertIn(f"mean lift by {100 * 2.0 / lift:+.1f} %, the mean drag by {0:+.1f} %", text)
        done = run_tool("plot_diagnosis", self.folder / "diagnosis.json", "--flight", self.folder, self.folder)
        self.assertIn("forces.t", done.stderr)

    def test_compared(self):
        """Means of two flights with what the fit leaves of them; a ratio whose denominator may be 0 has no number."""
        def mean(name, unit, baseline, extended, **more):
            return {"name": name, "unit": unit, "is_determined": bool(more), "baseline": baseline, "extended": extended, **more}
        means = [mean("lift", "N", 1.5e-3, 1.2e-3, interval_90=[1.1e-3, 1.35e-3], change=-0.2, change_interval_90=[-0.2667, -0.1]),
                 mean("lift/drag", "1", 3.0, 2.5)]
        found = {"is_known": True, "case": "hover.ini", "is_section": False, "wings_were_flown": True, "directions": 2,
                 "variance_share": 0.93, "means": means}
        text = self.told(flights=found)
        for part in ("2 directions have 93 % of the variance", ">lift [mN]<", ">1.50<", ">1.20<", ">1.10 to 1.35<",
                     ">-20 % (-27 to -10)<", ">not determined: its denominator may be 0<"):
            self.assertIn(part, text)
        self.assertIn("They are not compared: it diverged.", self.told(flights={"is_known": False, "reason": "it diverged"}))
        self.assertNotIn("Both flights", self.told())

    def test_adequate(self):
        """Nothing was found: no extension, no gain, and a wing file that is gone."""
        text = self.page(diagnosis={**DIAGNOSIS, "wing": "gone.h5", "extended": {"is_found": False},
                                    "verdict": {**DIAGNOSIS["verdict"], "word": "adequate", "causes": [], "set": []},
                                    "validation": {"has_gain": False, "baseline": FOLDS}})
        self.assertIn("The model is adequate", text)
        self.assertEqual(text.count("data:image/png;base64,"), 4)
        self.assertNotIn("It dried.</p>", text)
        self.assertIn("that nothing which these data could show is missing", text)

    def test_wider(self):
        """A wider change that explains the data as well is told beside the cause, and has its own standing in the catalogue."""
        effects = [EFFECT, {**EFFECT, "name": "creep", "title": "creep under load", "posterior": 0.04}]
        sentence = "It may be a part of a wider change, which explains the data as well: creep under load."
        text = self.told(verdict={**DIAGNOSIS["verdict"], "wider": ["creep"]}, effects=effects)
        self.assertIn(sentence, text)
        self.assertIn("may contain the cause", text)
        text = self.told(effects=effects)  # a file without this field
        self.assertNotIn("wider change", text)
        self.assertNotIn("may contain the cause", text)

    def test_odds(self):
        """Only a probability that a study of blind cases has corrected refers to this study."""
        told = "A study of cases whose causes were hidden"
        self.assertIn(told, self.told(verdict={**DIAGNOSIS["verdict"], "probability_map": "study of seed 1"}))
        text = self.told(verdict={**DIAGNOSIS["verdict"], "probability_map": "none: probabilities as the odds give them"})
        self.assertNotIn(told, text)
        self.assertIn("It is that of the odds.", text)

    def test_set(self):
        """What cannot be told apart has a table, and an interval with one end says which."""
        interval = {"name": "drift", "lower_best_upper": [0.001, 0.002, 0.9], "has_lower": True, "has_upper": False,
                    "lower_is_jump": True, "upper_is_jump": False}
        verdict = {**DIAGNOSIS["verdict"], "word": "consistent_with_set", "grade": "B", "set_because": "alias"}
        extended = {**DIAGNOSIS["extended"], "intervals_90": [interval]}
        text = self.told(verdict=verdict, extended=extended)
        self.assertIn("What these data cannot tell apart", text)
        self.assertIn("&gt; 0.001", text)
        self.assertIn("only a lower limit", text)
        self.assertIn("that one of these causes at least is there", text)
        self.assertNotIn("stays a candidate", text)
        effects = [EFFECT, {**EFFECT, "name": "creep", "title": "creep under load", "posterior": 0.04}]
        text = self.told(verdict={**verdict, "set": ["drift", "creep"]}, effects=effects)
        self.assertIn("These data cannot tell apart: a wing that changed; creep under load; nor something that is not in the catalogue. "
                      "If it is the first: The wing became", text)
        self.assertIn("What fits worse stays a candidate", text)
        self.assertIn("The wing became stiffer: about 0.20 %", text)
        self.assertEqual(text.count("over 99 %"), 1)
        self.assertNotIn(">4 %", text, "one probability, not one for each")

    def test_heavy_tails(self):
        """Heights that were left out are told, beside what else there is to say of the noise."""
        tails = {"is_found": True, "heights_left_out": 12, "heights_tested": 930, "share_90": [0.008, 0.021],
                 "sentence": "Specks."}
        text = self.told(noise={"warning": "they scatter", "heavy_tails": tails})
        self.assertIn("they scatter. 12 of 930 heights stand out from those around them (0.8 to 2.1 % do) and were left out. "
                      "Specks.</div>", text)

    def test_unknown(self):
        """An unknown cause has its region and what is related to it; sentences of causes that are not sufficient are left
        out."""
        region = {"of": "stiffness", "form": "one_place", "level": 0.9, "cell_m": 5e-4,
                  "parts": [{"centre_m": [0.0042, -0.0011], "radius_m": 0.0011, "share": 0.93,
                             "places_m": [[0.004, -0.001], [0.0045, -0.0012]]}]}
        related = [{"effect": "drift", "name": "a wing that <changed>", "explained": 0.41}]
        verdict = {**DIAGNOSIS["verdict"], "word": "unknown_cause", "set": [], "grade": "", "related": related}
        text = self.page(diagnosis={**DIAGNOSIS, "verdict": {**verdict, "region": region}})
        self.assertIn("around (4.2, -1.1) mm, radius 1.1 mm (93 %)", text)
        self.assertIn("not sufficient: a wing that &lt;changed&gt; (41 % of the misfit)", text)
        self.assertNotIn("It dried.</p>", text)
        self.assertIn("thick edges", text)
        text = self.told(verdict={**verdict, "region": {**region, "form": "field", "parts": []}})
        self.assertIn("no place stands out", text)
        text = self.told(verdict={**verdict, "region": {**region, "of": "flight"}})
        self.assertIn("It is in the records over the beat, and has no place on the wing.", text)
        self.assertNotIn("mm, radius", text)
        text = self.told(verdict={**verdict, "region": {**region, "of": "sensors", "form": "field", "parts": []}})
        self.assertIn("It is not on the wing: sensors of the records of motion", text)
        self.assertIn("It explains too little for an interval.", self.told(
            verdict=verdict, extended={**DIAGNOSIS["extended"], "intervals_90": []}))

    @unittest.skipUnless(find_browser(), "no Chromium is found: apt-get install chromium-headless-shell, or set FLUSI_BROWSER")
    def test_nothing_reaches_beyond_the_page(self):
        """On a desk and on a phone, also with the tables in numbers open and names without a blank to break at."""
        long = {**EFFECT, "name": "creep", "title": "x" * 80, "status": "not_testable", "missing": "needs " + "y" * 60}
        text = self.page(diagnosis={**DIAGNOSIS, "effects": [EFFECT, long], "measurement": "z" * 120})
        text = text.replace("<details>", "<details open>")
        for width in 1280, 390:
            seen = look_at(find_browser(), text, width)
            self.assertEqual((seen["found"], seen["width"] <= width), ([], True), seen)
            self.assertGreater(seen["text"], 3000, "the page was there")
        self.assertTrue(look_at(find_browser(), text.replace("<h1>", "<h1><pre style='white-space: pre'>" + 99 * "wide "), 390)["found"],
                        "what reaches beyond is seen")


if __name__ == "__main__":
    unittest.main()
