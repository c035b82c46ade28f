# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a training of msm_train and collects everything in one page, NAME_report.html, which needs no other file: how well the
measurements determine every parameter, convergence, intervals, profiles, and for every load the measured and the simulated
deformation and their difference.

usage: plot_training RUN_FOLDER [--name NAME] [-o HTML] [--pictures FOLDER] [--wing WING]

RUN_FOLDER holds NAME_history.h5, and NAME.log if the log shall be part of the page; the wing's outline and veins are drawn if the
wing file is still where the training found it, or in the folder of the history.
"""
from __future__ import annotations

import argparse
import io
from collections.abc import Iterator
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from flusi_msm.errors import InputError, run_command
from flusi_msm.style import use_style
from flusi_msm.training.maps import draw_loads
from flusi_msm.training.plots import draw_convergence, draw_parameters, draw_profiles, draw_readings
from flusi_msm.training.report import page
from flusi_msm.training.run import Training, find_history, read_training
from flusi_msm.wing.file import read_wing

CAPTIONS = {
    "loads": "Measured, simulated, and their difference, for every load. The dot marks where the force acts, on the "
             "unloaded wing; white lines are lines of equal deformation, the same in both maps; grey areas were not "
             "measured. A difference without structure is noise; structure tells what the wing model cannot do.",
    "parameters": "Grey: the range that was searched. Blue: 90 % intervals of parameters that the measurements "
                  "determine, orange: of those known only roughly. Arrows: parameters for which the measurements set "
                  "no end on that side.",
    "profiles": "How much worse the best fit becomes if one parameter is held at another value and all others are "
                "fitted again. Where a curve stays below the dashed line is the 90 % interval (shaded).",
    "convergence": "From above: the cost of the candidates, the step of the search, the condition of its covariance "
                   "matrix, and candidates that could not be used. The star is the trained wing after the polish.",
    "readings": "Single readings and what the trained wing gives; below, the difference in units of the declared "
                "error, with the range of 90 % shaded.",
}
HEADINGS = {"loads": "Measured and simulated deformation", "parameters": "The parameters and their intervals",
            "profiles": "Profiles of the likelihood", "convergence": "How the search went",
            "readings": "Single readings"}


def pictures_of(training: Training) -> Iterator[tuple[str, str, str, Figure]]:
    """Returns (name, heading, caption, figure) in the order of the page."""
    made = []
    if training.is_complete:
        made.append(("parameters", draw_parameters(training)))
    for k, figure in enumerate(draw_loads(training), 1):
        made.append((f"loads_{k}", figure))
    made += [("readings", draw_readings(training)), ("profiles", draw_profiles(training))]
    if training.generations:
        made.append(("convergence", draw_convergence(training)))
    for name, figure in made:
        kind = name.split("_")[0]
        is_first = name == kind or name.endswith("_1")
        if figure is not None:
            yield name, HEADINGS[kind] if is_first else "", CAPTIONS[kind] if is_first else "Further loads.", figure


def png_of(figure: Figure) -> bytes:
    """Returns a figure as PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", bbox_inches="tight", pad_inches=0.05)
    plt.close(figure)
    return buffer.getvalue()


def write(path: Path, content: bytes) -> None:
    """Writes a file; raises an InputError if that is not possible."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    print(path)


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="RUN_FOLDER", help="where msm_train ran, or a NAME_history.h5")
    parser.add_argument("--name", metavar="NAME", help="which training, if the folder holds several")
    parser.add_argument("-o", "--output", metavar="HTML", help="page to write (default: NAME_report.html in the folder)")
    parser.add_argument("--pictures", metavar="FOLDER", help="write the pictures there too, as NAME_<picture>.png")
    parser.add_argument("--wing", metavar="WING", help="wing file to draw, if it has moved")
    options = parser.parse_args()
    use_style()
    path = find_history(options.folder, options.name)
    training = read_training(path)
    if options.wing:
        training.wing = read_wing(options.wing)
    pictures = []
    for name, heading, caption, figure in pictures_of(training):
        png = png_of(figure)
        pictures.append((heading, caption, png))
        if options.pictures:
            write(Path(options.pictures) / f"{training.name}_{name}.png", png)
    write(Path(options.output) if options.output else path.parent / f"{training.name}_report.html", page(training, pictures).encode())


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_training", main)
