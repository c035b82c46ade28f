# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens a run of flusi in ParaView: vortices, wings and body.

paraview --script=open_in_paraview.py; pvpython open_in_paraview.py picture.png [TIME] draws without a window."""
import os
import sys
from typing import Any

from paraview import simple as pv

# FACTS: what open_in_paraview knows of the run
FOLDER, FLOW, SOURCE = "", "", "vorticity"
SURFACES: dict = {}  # name of an index: colour
LEVELS: list = []
COLOURS: list = []
OPACITIES: list = []
# END OF FACTS
try:
    FOLDER = os.path.dirname(os.path.abspath(__file__))
except NameError:  # ParaView's own shell does not state where the script is
    pass
VECTOR = "{0}x*iHat + {0}y*jHat + {0}z*kHat"


def path_of(name: str) -> str:
    """Returns the path of a file of the run."""
    return os.path.join(FOLDER, name)


def opened(name: str) -> Any:
    """Returns the reader of an index, with its name in the browser of ParaView."""
    reader = pv.XDMFReader(FileNames=[path_of(name)])
    pv.RenameSource(name, reader)
    return reader


def magnitude(flow: Any) -> Any:
    """Returns the magnitude of the vorticity as the point data "vorticity"."""
    if SOURCE == "velocity":
        flow = pv.Calculator(Input=flow, ResultArrayName="u", Function=VECTOR.format("u"))
        flow = pv.Gradient(Input=flow, ScalarArray=["POINTS", "u"], ComputeGradient=0, ComputeVorticity=1, VorticityArrayName="omega")
        return pv.Calculator(Input=flow, ResultArrayName="vorticity", Function="mag(omega)")
    function = "vorabs" if SOURCE == "vorabs" else "sqrt(vorx*vorx + vory*vory + vorz*vorz)"
    return pv.Calculator(Input=flow, ResultArrayName="vorticity", Function=function)


def coloured(source: Any, view: Any, colour: str, opacity: float) -> Any:
    """Shows a source in one colour."""
    shown = pv.Show(source, view)
    shown.ColorArrayName = ["POINTS", ""]  # one colour
    shown.DiffuseColor = shown.AmbientColor = [int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5)]
    shown.Opacity = opacity
    return shown


def main() -> None:
    """Does what the command line asks for."""
    view = pv.GetActiveViewOrCreate("RenderView")
    view.ViewSize = [1200, 900]
    view.Background = [1.0, 1.0, 1.0]
    view.OrientationAxesLabelColor = [0.2, 0.2, 0.2]
    flow = opened(FLOW)
    vorticity = magnitude(flow)
    for level, colour, opacity in zip(LEVELS, COLOURS, OPACITIES):
        vortices = pv.Contour(Input=vorticity, ContourBy=["POINTS", "vorticity"], Isosurfaces=[level])
        pv.RenameSource("|omega| = %g" % level, vortices)
        coloured(vortices, view, colour, opacity)
    for name, colour in SURFACES.items():
        coloured(opened(name), view, colour, 1.0)
    scene = pv.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    times = list(flow.TimestepValues)
    if times:
        scene.AnimationTime = float(sys.argv[2]) if len(sys.argv) > 2 else times[-1]
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [-1.0, -1.4, 1.2], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    pv.ResetCamera(view)
    pv.Render(view)
    if len(sys.argv) > 1 and sys.argv[1].endswith(".png"):
        pv.SaveScreenshot(sys.argv[1], view)


main()
