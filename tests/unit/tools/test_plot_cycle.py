# SPDX-License-Identifier: GPL-3.0-or-later
"""plot_cycle: cycle means, strokes, units and mistakes, from series whose means are known."""
import csv
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from flusi_msm.plots import cycle as plot_cycle
from flusi_msm.results import cycles as beats
from flusi_msm.results.files import InputError, read_series
from synthetic import CYCLE_MEANS, picture, run_tool, write_flapping_run, write_table


class Cycle(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.run_folder = self.folder / "rigid"
        write_flapping_run(self.run_folder, drift=0.5)


class Numbers(Cycle):
    def test_means_of_every_cycle(self):
        run = beats.FlappingRun(self.run_folder)
        self.assertEqual(run.cycles(), [1, 2, 3, 4])
        # The trapezoidal rule is exact for these sums of sines and for the ramp. Only cycle 1 is not sampled at
        # its beginning, where a constant continues the record over one interval.
        for n in run.cycles():
            for quantity, mean in CYCLE_MEANS.items():
                with self.subTest(cycle=n, quantity=quantity):
                    wanted = mean + (0.5 * n if quantity == "lift" else 0)
                    self.assertAlmostEqual(run.means(quantity, [n])[0], wanted, delta=2e-3 if n == 1 else 1e-7)

    def test_several_cycles(self):
        run = beats.FlappingRun(self.run_folder)
        mean, half_range = run.means("lift", [2, 4])
        self.assertAlmostEqual(mean, 3.5 + 0.5 * 3, places=6)
        self.assertAlmostEqual(half_range, 0.5, places=6)
        curve = run.phase_average("lift", [3, 4])
        exact = 3.5 + 5 * np.sin(2 * np.pi * beats.PHASES) + 0.5 * (beats.PHASES + 3.0)
        # linear interpolation: curvature times interval squared over 8
        np.testing.assert_allclose(curve, exact, atol=5 * (2 * np.pi / 200)**2 / 8 + 1e-7)

    def test_choice_of_cycles(self):
        run = beats.FlappingRun(self.run_folder)
        for text, cycles in (("last", [4]), ("all", [1, 2, 3, 4]), ("2", [2]), ("3-4", [3, 4]), ("1,3", [1, 3])):
            self.assertEqual(run.choose(text), cycles)
        for text, reason in (("5", "cycle 5 is not complete; there is 1, 2, 3, 4"), ("x", "--cycles takes"),
                             ("4-3", "4-3 is not complete")):
            with self.assertRaisesRegex(InputError, reason):
                run.choose(text)

    def test_a_cycle_that_is_not_complete_is_left_out(self):
        write_flapping_run(self.folder / "short", cycles=2.9)
        self.assertEqual(beats.FlappingRun(self.folder / "short").cycles(), [1, 2])

    def test_frequency_and_wind(self):
        run = beats.FlappingRun(self.run_folder, frequency=0.5, wind="-x")
        self.assertEqual(run.cycles(), [1, 2])
        self.assertAlmostEqual(run.means("drag", [2])[0], -CYCLE_MEANS["drag"], places=6)

    def test_downstroke_is_where_phi_falls(self):
        down = beats.FlappingRun(self.run_folder).downstroke(3)
        np.testing.assert_array_equal(down, beats.PHASES < 0.5)

    def test_power_of_the_wings_if_there_is_no_total(self):
        (self.run_folder / "aero_power.t").unlink()
        t = np.arange(801) / 200
        for side, power in (("left", 3.0), ("right", 4.0)):
            names = ["time"] + [f"c{i}" for i in range(12)] + ["aerodynamic power", "aerodynamic power unsteady",
                                                               "inertial power"]
            write_table(self.run_folder / f"wing_{side}.t", [f"{name} [-]" for name in names],
                        np.column_stack([t] + 12 * [0 * t] + [0 * t + power, 0 * t + 0.1, np.sin(2 * np.pi * t)]))
        run = beats.FlappingRun(self.run_folder)
        self.assertAlmostEqual(run.means("aerodynamic power", [2])[0], 7.0, places=9)
        self.assertAlmostEqual(run.means("inertial power", [2])[0], 0.0, places=9)

    def test_units(self):
        run = beats.FlappingRun(self.run_folder)
        self.assertEqual(read_series(self.run_folder / "forces.t").scales, {
            "length": 0.009, "frequency": 158, "density": 1.225, "force": 2.006e-4, "power": 2.853e-4})
        self.assertAlmostEqual(run.si_factor("lift")[0], 0.2006)
        self.assertEqual(run.si_factor("inertial power"), (0.2853, "mW"))
        run.scales = {"length": 0.009, "frequency": 158.0, "density": 1.225}  # rho R^4 f^2 and rho R^5 f^3
        self.assertAlmostEqual(run.si_factor("lift")[0], 0.2006, places=4)
        self.assertAlmostEqual(run.si_factor("aerodynamic power")[0], 0.2853, places=4)
        run.scales = {}
        self.assertEqual(run.si_factor("lift"), (None, ""))

    def test_columns_of_flusi_without_names(self):
        write_table(self.run_folder / "forces.t", [], np.column_stack(
            [np.arange(401) / 100] + [np.full(401, float(i)) for i in range(1, 13)]), units="")
        run = beats.FlappingRun(self.run_folder)
        self.assertAlmostEqual(run.means("lift", [1])[0], 3 + 6)
        self.assertAlmostEqual(run.means("drag", [1])[0], 1 + 4)


class Pictures(Cycle):
    def assert_picture(self, *arguments, out):
        done = run_tool("plot_cycle", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        height, width, colours = picture(out)
        self.assertGreater(height, 500)
        self.assertGreater(width, 800)
        self.assertGreater(colours, 50)
        return done

    def test_one_run_beside_its_data(self):
        done = self.assert_picture(self.run_folder, "--cycles", "3-4", out=self.run_folder / "cycle_3-4.png")
        self.assertIn("mean lift               5.25 \u00b1 0.25 = 1.053 mN", done.stdout)

    def test_the_start_of_the_flow_is_beyond_the_axes(self):
        """A spike in the first tenth of cycle 1 does not scale the panel, and the picture says so."""
        for spike in (0.0, 1e3):
            run = beats.FlappingRun(self.run_folder)
            run.signals["lift"].values[run.signals["lift"].x < 0.05] += spike
            figures = []
            with mock.patch.object(plot_cycle, "save", lambda figure, out: figures.append(figure)):
                plot_cycle.draw([(run, [1], "rigid")], None)
            lift = figures[0].axes[0]
            _, high = lift.get_ylim()
            self.assertLess(high, 15)  # 3.5 + 5 sin and the drift of 0.5 a cycle, with room
            self.assertEqual(any(plot_cycle.NOTE in ax.get_xlabel() for ax in figures[0].axes), spike > 0)

    def test_two_runs_and_their_numbers(self):
        write_flapping_run(self.folder / "flexible", factor=0.5)
        table = self.folder / "cycle.csv"
        self.assert_picture(self.run_folder, self.folder / "flexible", "--labels", "stiff, soft", "--csv", table,
                            "-o", self.folder / "both.png", out=self.folder / "both.png")
        with open(table, encoding="utf-8") as file:
            lines = file.readlines()
        notes = [line for line in lines if line.startswith("#")]
        self.assertIn("# soft, cycle 4, mean drag: 0.4 = 0.08024 mN\n", notes)
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        self.assertEqual(len(rows), len(beats.PHASES))
        self.assertEqual(len(rows[0]), 1 + 2 * 2 * 4)
        mean = np.mean([float(row["lift soft [mN]"]) for row in rows])
        self.assertAlmostEqual(mean, 0.5 * 3.5 * 0.2006, places=4)

    def test_less_data_makes_a_smaller_picture(self):
        (self.run_folder / "aero_power.t").unlink()
        (self.run_folder / "kinematics.t").unlink()
        write_flapping_run(self.folder / "plain", units="")
        done = run_tool("plot_cycle", self.run_folder, self.folder / "plain")
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.folder / "plain" / "kinematics.t").unlink()
        done = run_tool("plot_cycle", self.folder / "plain")
        self.assertIn("not shaded", done.stderr)

    def test_start_of_the_flow(self):
        """The first tenth of cycle 1 does not set the scale; that of another cycle does."""
        phases, curve = np.array([0.0, 0.09, 0.11, 1.0]), np.array([70.0, 9.0, -2.0, 3.0])
        self.assertEqual(plot_cycle.settled(phases, curve, [1, 2]).max(), 3)
        self.assertEqual(plot_cycle.settled(phases, curve, [2]).max(), 70)

    def test_refusals(self):
        def refused(*arguments, because):
            done = run_tool("plot_cycle", *arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(because, done.stderr)
        short = self.folder / "short"
        write_flapping_run(short, cycles=0.7)
        refused(self.folder / "absent", because="not the folder of a run")
        refused(short, because="no complete cycle, the forces go from t f = 0.005 to 0.7")
        (short / "forces.t").unlink()
        refused(short, because="no such file; the folder has aero_power.t, kinematics.t")
        refused(self.run_folder, "--labels", "a,b", because="2 name(s) for 1 folder(s)")
        refused(self.run_folder, "--frequency", 0, because="must be positive")
        refused(self.run_folder, "--csv", self.folder / "no" / "x.csv", because="No such file")
        write_table(self.run_folder / "forces.t", ["time", "a", "b"], np.ones((5, 3)))
        refused(self.run_folder, because="no column 'Fz'; it has time, a, b")


if __name__ == "__main__":
    unittest.main()
