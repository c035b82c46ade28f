# SPDX-License-Identifier: GPL-3.0-or-later
"""open_in_paraview: the script parses, and what it asks of ParaView are files of the run, levels that the flow has, and arrays
that are stored. A stand-in for ParaView's Python module writes down the calls."""
import runpy
import sys
import tempfile
import types
import unittest
from pathlib import Path
from unittest import mock

from synthetic import run_tool, write_velocity


class Pipeline:
    """What a call has made, with the properties that it got."""

    def __init__(self, kind, **properties):
        self.__dict__.update(properties)
        self.kind, self.TimestepValues = kind, [0.5, 1.0]

    def UpdateAnimationUsingDataTimeSteps(self):
        pass


class ParaView(types.ModuleType):
    """The module paraview.simple: everything that is called is made and kept."""

    def __init__(self):
        super().__init__("paraview.simple")
        self.made = []

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)

        def call(*arguments, **properties):
            self.made.append(Pipeline(name, arguments=arguments, **properties))
            return self.made[-1]
        return call

    def of(self, kind):
        return [one for one in self.made if one.kind == kind]


class OpenInParaview(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        write_velocity(self.folder, "000500", (24, 24, 16), (4.0, 4.0, 2.0), 0.5, 1.0)
        for name in "fly", "fly_left", "fly_right", "fly_body":
            (self.folder / f"{name}.xmf").write_text("<Xdmf/>")

    def run_script(self, *arguments):
        done = run_tool("open_in_paraview", self.folder, *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        script = self.folder / "open_in_paraview.py"
        self.assertEqual(done.stdout.strip(), str(script))
        simple, package = ParaView(), types.ModuleType("paraview")
        package.simple = simple
        with mock.patch.dict(sys.modules, {"paraview": package, "paraview.simple": simple}), \
                mock.patch.object(sys, "argv", [str(script), "picture.png", "0.75"]):
            runpy.run_path(str(script), run_name="__main__")
        return simple

    def test_scene(self):
        scene = self.run_script("--levels", "2,1")
        self.assertEqual([Path(one.FileNames[0]).name for one in scene.of("XDMFReader")],
                         ["fly.xmf", "fly_body.xmf", "fly_left.xmf", "fly_right.xmf"])
        self.assertTrue(all(Path(one.FileNames[0]).is_file() for one in scene.of("XDMFReader")))
        self.assertEqual([one.Isosurfaces for one in scene.of("Contour")], [[1.0], [2.0]])
        self.assertEqual(len(scene.of("Show")), 5)
        self.assertEqual(scene.of("Calculator")[0].Function, "uxx*iHat + uxy*jHat + uxz*kHat".replace("ux", "u"))
        self.assertEqual(scene.of("GetAnimationScene")[0].AnimationTime, 0.75)
        self.assertEqual(scene.of("SaveScreenshot")[0].arguments[0], "picture.png")

    def test_levels_of_the_flow(self):
        """Without --levels they are some that the flow reaches."""
        levels = [one.Isosurfaces[0] for one in self.run_script().of("Contour")]
        self.assertTrue(levels == sorted(levels) and levels[0] > 0, levels)

    def test_refusals(self):
        (self.folder / "other.xmf").write_text("<Xdmf/>")
        self.assertIn("several runs: fly.xmf, other.xmf", run_tool("open_in_paraview", self.folder).stderr)
        for path in self.folder.glob("*.xmf"):
            path.unlink()
        self.assertIn("no index of a flow", run_tool("open_in_paraview", self.folder).stderr)


if __name__ == "__main__":
    unittest.main()
