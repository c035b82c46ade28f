# SPDX-License-Identifier: GPL-3.0-or-later
"""A plan of tools/reproduce_paper that is killed again and again, and goes on each time with the same command. A stub takes the place of
flusi; it writes series whose means are known."""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]
STUB = SOURCE / "tests/support/flusi_stub.py"
# The page without its pictures, which take most of the time.
TOOL = """import flusi_msm.paper.page, flusi_msm.paper.scan_page
from flusi_msm.paper.command import command
flusi_msm.paper.page.all_pictures = lambda *_: []
flusi_msm.paper.scan_page.all_maps = lambda *_: []
command()
"""
PLAN = ["--grids", "16", "20", "--beats", "4", "--kinematics", "16", "--scan", "1", "1", "1"]
SCAN = [f"{kind}_pitch+0_stroke135_tilt20" for kind in ("rigid", "flexible")]
FORCE, POWER = 0.2006, 0.2853  # mN and mW of one unit, as the stub writes them


class Resume(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(dir=".")).resolve()
        self.addCleanup(shutil.rmtree, self.folder)
        launcher = self.folder / "mpirun"
        launcher.write_text('#!/bin/sh\nshift 2\nexec "$@"\n')
        launcher.chmod(0o755)
        self.runs, self.starts = self.folder / "runs", self.folder / "starts"
        self.environment = {**os.environ, "MPIEXEC": str(launcher), "STARTS": str(self.starts), "OPENBLAS_NUM_THREADS": "1",
                            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}

    def start(self, hang=""):
        """The tool with this plan; flusi hangs where `hang` says."""
        return subprocess.Popen([sys.executable, "-B", "-c", TOOL, *PLAN, "--ranks", "1", "--flusi", STUB, "--folder", self.runs],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
                                env={**self.environment, "HANG": hang})

    def wait_for(self, path, tool):
        """Waits until flusi hangs."""
        end = time.monotonic() + 120
        while not path.exists():
            self.assertIsNone(tool.poll(), "the tool has ended")
            self.assertLess(time.monotonic(), end, "flusi does not hang")
            time.sleep(0.02)

    def kill(self, hang):
        """Starts the plan and ends tool and flusi, as when the machine fails."""
        tool, path = self.start(hang), self.runs / hang.split(":")[0] / "hangs"
        self.wait_for(path, tool)
        os.killpg(tool.pid, signal.SIGKILL)
        os.killpg(int(path.read_text()), signal.SIGKILL)
        tool.communicate()
        path.unlink()

    def test_kills(self):
        self.kill("estimate:begin")
        self.kill("flexible_16:backup")
        self.assertEqual(json.loads((self.runs / "flexible_16/case.json").read_text())["status"], "begun")
        self.kill("rigid_20:begin")
        # Between the folder of a flight and the note about it.
        (self.runs / "flexible_20").mkdir()
        (self.runs / "flexible_20/case.json.part").write_text('{"na')
        # The end of a session or of a job is like Ctrl-C.
        tool = self.start("flexible_20:backup")
        self.wait_for(self.runs / "flexible_20/hangs", tool)
        tool.send_signal(signal.SIGTERM)
        told = tool.communicate()[0]
        self.assertEqual(tool.returncode, 4, told)
        self.assertIn("give the same command again", told)
        tool = self.start()
        told = tool.communicate()[0]
        self.assertEqual(tool.returncode, 0, told)
        self.check(told)

    def check(self, told):
        """No flight is made twice, each goes on from its backup, and the numbers are those of whole flights."""
        starts = self.starts.read_text().splitlines()
        flights = ["rigid_16 begins", "flexible_16 begins", "flexible_16 goes on", "rigid_20 begins", "rigid_20 begins",
                   "flexible_20 begins", "flexible_20 goes on", *(f"{name} begins" for name in SCAN)]
        self.assertEqual([line for line in starts if not line.startswith("estimate")], flights)
        self.assertEqual(len(starts) - len(flights), 6, "one run to be timed was killed, the other five are not repeated")
        for text in ("1 of 6, rigid_16: is there", "3 of 6, rigid_20: is there", "4 of 6, flexible_20: goes on", "6 of 6, "):
            self.assertIn(text, told)
        found = json.loads((self.runs / "paper.json").read_text())
        self.assertEqual(found["missing"], [])
        for grid in found["grids"]:
            for kind, lift in (("rigid", 3), ("flexible", 2)):
                self.assertEqual(grid[kind]["beats"], [3, 4])
                for key, value in (("lift_mN", lift * FORCE), ("drag_mN", FORCE), ("power_mW", 10 * POWER)):
                    self.assertAlmostEqual(grid[kind][key], value, delta=1e-4 * value, msg=f"{kind} {key}")
        self.assertEqual(json.loads((self.runs / "kinematics_16.json").read_text())["missing"], [])


if __name__ == "__main__":
    unittest.main()
