# SPDX-License-Identifier: GPL-3.0-or-later
"""The runner of the demo on small commands: what is done is skipped, what was stopped goes on, what fails is told."""
import contextlib
import io
import re
import shlex
import sys
import tempfile
import unittest
import unittest.mock
from pathlib import Path

from flusi_msm.demo.command import prepare, verdict
from flusi_msm.demo.runner import Runner
from flusi_msm.demo.steps import STEPS, Step
from flusi_msm.errors import InputError

SOURCE = Path(__file__).resolve().parents[3]
COUNT = "import sys; open('calls', 'a').write(' '.join(sys.argv[1:]) + ';'); "


class Demo(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def step(self, text, **settings):
        """A step that runs Python text; it reads `in` and makes `out`."""
        return Step("one", "Do one thing", shlex.join(["python", "-c", COUNT + text]), ("in",), ("out",), **settings)

    def run_step(self, step):
        runner = Runner(self.folder, 3, 1)
        runner.resolved = lambda words: [sys.executable, *words[1:]]
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            runner.run(1, step)
        return told.getvalue()

    def calls(self):
        return (self.folder / "calls").read_text().split(";")[:-1]

    def test_done_once(self):
        step = self.step("open('out', 'w'); print('hello')")
        self.assertIn("==> 1 of 1  Do one thing\n", self.run_step(step))
        self.assertEqual((self.folder / "logs/one.log").read_text(), "hello\n")
        self.assertIn("done before", self.run_step(step))
        self.assertEqual(len(self.calls()), 1)

    def test_repeated_where_an_input_a_file_or_the_command_differs(self):
        self.run_step(self.step("open('out', 'w')"))
        (self.folder / "in").write_text("changed")
        self.run_step(self.step("open('out', 'w')"))
        (self.folder / "out").unlink()
        self.run_step(self.step("open('out', 'w')"))
        self.run_step(self.step("open('out', 'w'); 1"))
        self.assertEqual(len(self.calls()), 4)

    def test_stopped_run_goes_on_and_one_of_other_inputs_begins_again(self):
        step = self.step("open('backup', 'w'); sys.exit(4)", backups="backup")
        for _ in range(2):
            with self.assertRaisesRegex(InputError, "exit code 4"):
                self.run_step(step)
        (self.folder / "in").write_text("changed")
        with self.assertRaises(InputError):
            self.run_step(step)
        self.assertEqual(self.calls(), ["", "--restart", "--overwrite"])

    def test_verdicts_count_as_success(self):
        for code in (0, 10, 11, 12):
            self.run_step(self.step(f"open('out', 'w'); sys.exit({code})", good_codes=(0, 10, 11, 12)))
        with self.assertRaisesRegex(InputError, "exit code 20"):
            self.run_step(self.step("open('out', 'w'); sys.exit(20)", good_codes=(0, 10, 11, 12)))

    def test_interrupted_step_is_ended(self):
        step = self.step("print('begun', flush=True); import time; time.sleep(60); open('out', 'w')")

        def interrupt(lines, log, is_live):
            next(iter(lines))
            raise SystemExit(143)  # as on SIGTERM

        with unittest.mock.patch.object(Runner, "follow", staticmethod(interrupt)), self.assertRaises(SystemExit):
            self.run_step(step)
        self.assertFalse((self.folder / "out").exists())  # which its end would make

    def test_failure_shows_the_end_of_the_log(self):
        with self.assertRaisesRegex(InputError, "it made no out.*\n.*the reason\n"):
            self.run_step(self.step("print('the reason')"))

    def test_inputs_are_copied_once(self):
        prepare(self.folder)
        (self.folder / "train.ini").write_text("mine")
        prepare(self.folder)
        self.assertEqual((self.folder / "train.ini").read_text(), "mine")
        self.assertTrue((self.folder / "kinematics/calliphora.ini").exists())

    def test_steps_fit_together(self):
        """Whatever a step reads is copied or was made before it, and its files are named in its command or its input."""
        prepare(self.folder)
        there = {str(path.relative_to(self.folder)) for path in self.folder.rglob("*") if path.is_file()}
        for step in STEPS:
            self.assertLessEqual(set(step.reads), there, step.name)
            there |= set(step.makes)

    def test_commands_are_those_of_the_tutorial(self):
        lines = (SOURCE / "docs/guide/tutorial.md").read_text(encoding="utf-8").split("\n")
        for step in STEPS:
            command = step.command.replace(" --quiet", "")
            self.assertIn(command if step.folder == "." else f"({'cd ' + step.folder}; {command})", lines)

    def test_verdict(self):
        (self.folder / "logs").mkdir()
        log = "data  1\nverdict   named: a thing\n          It is torn.\ngain  2\nfiles  x\n"
        (self.folder / "logs/diagnose.log").write_text(log)
        self.assertEqual(verdict(self.folder), ["verdict   named: a thing", "          It is torn.", "gain  2"])

    def test_truth_that_is_told_is_that_of_the_case(self):
        told = re.search(r"truth +damage ([\d.]+) around \(([\d.]+), (-?[\d.]+)\) mm, radius ([\d.]+) mm",
                         (SOURCE / "tools/flusi_msm/demo/command.py").read_text(encoding="utf-8"))
        factor, x, y, radius = map(float, told.groups())
        case = (SOURCE / "ini/demo/bending.json").read_text(encoding="utf-8")
        self.assertIn(f'"damage": [{x / 1e3:g}, {y / 1e3:g}, {radius / 1e3:g}, {factor:g}]', case)


if __name__ == "__main__":
    unittest.main()
