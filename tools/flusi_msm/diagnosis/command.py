# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a diagnosis of msm_diagnose and collects everything in one page that needs no other file: the verdict and its gain, the
causes that it cannot be told from, maps of the misfit of the model, all candidates, and recommendations for the next measurement.

usage: plot_diagnosis NAME.json [-o HTML] [--pictures FOLDER] [--flight BASELINE EXTENDED]

The page is NAME_report.html in the folder of NAME.json, and pictures are NAME_<picture>.png. NAME.h5 must be in the same folder.
--flight adds the changes of lift, drag and power by the cause: two folders of runs, which ini/diagnose-flight.ini describes.
"""
from __future__ import annotations

import argparse
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Circle

from flusi_msm.diagnosis.beat import Components, draw_beat, read_beats
from flusi_msm.diagnosis.flight import flight_section
from flusi_msm.diagnosis.tracks import Marks, draw_tracks, read_tracks
from flusi_msm.diagnosis.modes import draw_modes, read_modes
from flusi_msm.diagnosis.report import page
from flusi_msm.diagnosis.series import Record, draw_record, read_series
from flusi_msm.diagnosis.versions import upgraded
from flusi_msm.errors import InputError, run_command
from flusi_msm.style import COLOURS, use_style
from flusi_msm.wing.file import read_wing

SHOWN_LOADS = 6
Loads = dict[str, tuple[np.ndarray, np.ndarray, float]]  # table of heights, point [m], force [N]
LIMIT = 4.0  # sd, of the colours of residuals


def read(path: Path) -> tuple[dict[str, Any], Loads, dict[str, np.ndarray]]:
    """Reads the JSON file, and the tables of the HDF5 file in the same folder."""
    if path.is_dir():
        raise InputError(f"{path}: is a folder; name the file of a diagnosis in it, for instance {path / 'diagnosis.json'}")
    try:
        diagnosis = json.loads(path.read_text())
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except ValueError:
        raise InputError(f"{path}: is not JSON; name the file NAME.json that msm_diagnose writes") from None
    diagnosis = upgraded(diagnosis, path)
    loads, unknown = {}, {}
    tables = path.with_suffix(".h5")
    if tables.exists():
        with h5py.File(tables, "r") as file:
            for name, table in file["loads"].items():
                loads[name] = (np.asarray(table), np.ravel(table.attrs["point"]),
                               float(np.ravel(table.attrs["force"])[0]))
            for name, table in file.get("unknown", {}).items():
                if np.any(table_of(np.asarray(table))[:, :2]):  # errors of scans and sensors, and waves over a beat, have no place
                    unknown[name] = np.asarray(table)
    return diagnosis, loads, unknown


def table_of(values: np.ndarray) -> np.ndarray:
    """Returns the rows of a table, in whichever form it was stored."""
    return values if values.shape[1] in (4, 7) else values.T


def outline_of(diagnosis: dict[str, Any], folder: Path) -> list[np.ndarray]:
    """Returns the lines (n, 2) [mm] of the edge and the veins of the wing, if its file still exists."""
    places = [folder / diagnosis["wing"], Path(diagnosis["wing"])]
    path = next((place for place in places if place.is_file()), None)
    if path is None:
        return []
    try:
        wing = read_wing(str(path))
    except InputError:
        return []
    sides = np.sort(np.concatenate([wing.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
    edges, counts = np.unique(sides, axis=0, return_counts=True)
    points = 1e3 * wing.points[:, :2]
    return [points[edge] for edge in edges[counts == 1]] + [points[nodes] for nodes, _ in wing.veins.values()]


def draw_outline(ax: Axes, lines: Sequence[np.ndarray]) -> None:
    """Draws edge and veins of the wing below a map."""
    for line in lines:
        ax.plot(line[:, 0], line[:, 1], color="0.6", lw=0.6, zorder=0.5)
    ax.set_aspect("equal")
    ax.margins(0.06, 0.12)


def draw_residuals(loads: Loads, outline: Sequence[np.ndarray], is_extended: bool) -> list[tuple[str, Figure]]:
    """Returns [(load, figure)]: residuals of the baseline and the extended wing, in units of their sd, for the loads that show
    the cause best, or that fit worst."""
    def weight(name: str) -> float:
        rows = table_of(loads[name][0])
        return float(np.sum((rows[:, 5] - rows[:, 6])**2 if is_extended else rows[:, 5]**2))

    return [(name, draw_load(name, *loads[name], outline, is_extended))
            for name in sorted(sorted(loads, key=weight, reverse=True)[:SHOWN_LOADS])]


def draw_load(name: str, table: np.ndarray, point: np.ndarray, force: float, outline: Sequence[np.ndarray], is_extended: bool) -> Figure:
    """Draws the maps of one load; they are narrow enough for a phone."""
    rows = table_of(table)
    on = (rows[:, 0] != 0) | (rows[:, 1] != 0)
    x, y = 1e3 * rows[on, 0], 1e3 * rows[on, 1]
    panels = [("measured deformation [µm]", 1e6 * rows[on, 2], "viridis", None), ("baseline leaves [sd]", rows[on, 5], "RdBu_r", LIMIT)]
    if is_extended:
        panels += [("the cause explains [sd]", rows[on, 5] - rows[on, 6], "RdBu_r", LIMIT),
                   ("extended wing leaves [sd]", rows[on, 6], "RdBu_r", LIMIT)]
    figure, axes = plt.subplots(len(panels) // 2, 2, figsize=(6.2, 1.55 * len(panels) // 2 + 0.75), squeeze=False, sharex=True,
                                sharey=True, layout="constrained")
    for ax, (title, values, colours, limit) in zip(axes.ravel(), panels):
        image = ax.scatter(x, y, c=values, s=30, marker="s", cmap=colours, vmin=None if limit is None else -limit, vmax=limit)
        draw_outline(ax, outline)
        ax.plot(*(1e3 * point), "k+", ms=9, mew=1.5)
        ax.tick_params(labelsize=8)
        ax.set_title(title, fontsize=9)
        if limit is None or not is_extended or ax is axes.ravel()[-1]:
            figure.colorbar(image, ax=ax, shrink=0.85).ax.tick_params(labelsize=8)
    for ax in axes[:, 0]:
        ax.set_ylabel("y [mm]", fontsize=8)
    for ax in axes[-1]:
        ax.set_xlabel("x [mm]", fontsize=8)
    figure.suptitle(f"{name}: {1e3 * force:.3g} mN", fontsize=10)
    return figure


def draw_unknown(name: str, values: np.ndarray, outline: Sequence[np.ndarray], region: dict[str, Any] | None = None) -> Figure:
    """Draws where stiffness or forces would have to differ; places in the region of an unknown cause have a thick edge."""
    figure, ax = plt.subplots(figsize=(6.2, 3.4), layout="constrained")
    rows = table_of(values)
    places, ratio = 1e3 * rows[:, :2], rows[:, 2] / np.maximum(rows[:, 3], 1e-300)
    radius = 0.42 * nearest_distance(places)
    image = ax.add_collection(PatchCollection([Circle(place, radius) for place in places], cmap="RdBu_r", edgecolors="#8c8478"))
    image.set_array(ratio)
    image.set_clim(-LIMIT, LIMIT)
    for part in region["parts"] if region and region["of"] == name else []:
        ax.add_collection(PatchCollection([Circle(place, radius) for place in 1e3 * np.array(part["places_m"])], facecolors="none",
                                          edgecolors="k", lw=2.2))
    draw_outline(ax, outline)
    ax.autoscale_view()
    ax.set_title(f"{name}: mean over sd")
    ax.set_xlabel("x [mm]")
    ax.set_ylabel("y [mm]")
    figure.colorbar(image, ax=ax, shrink=0.8)
    return figure


def nearest_distance(places: np.ndarray) -> float:
    """Returns the median distance of a place to its nearest neighbour; 1 for one place."""
    if len(places) < 2:
        return 1.0
    between = np.linalg.norm(places[:, None] - places[None], axis=2)
    return float(np.median(np.min(between + np.diag(np.full(len(places), np.inf)), axis=1))) or 1.0


def draw_evidence(effects: Sequence[dict[str, Any]]) -> Figure:
    """Draws the evidence of all candidates that were tested."""
    tested = sorted((e for e in effects if e["status"] == "tested"), key=lambda e: e["log_evidence"])
    figure, ax = plt.subplots(figsize=(6.2, 0.8 + 0.24 * len(tested)), layout="constrained")
    values = [e["log_evidence"] for e in tested]
    ax.barh([e["title"] for e in tested], values,
            color=[COLOURS[1] if e["is_measurement"] else COLOURS[0] for e in tested])
    ax.axvline(0, color="k", lw=0.8)
    if values:
        ax.axvline(max(values) - 3, color="k", lw=0.8, ls="--")
    ax.tick_params(axis="y", labelsize=8)
    ax.set_xlabel("log evidence over the baseline")
    return figure


def places_of(loads: Loads) -> list[np.ndarray]:
    """Returns the places (x, y) [m] at which loads act, in the order of the loads' names: these are the locations of the
    validation."""
    places: list[np.ndarray] = []
    for name in sorted(loads):
        if not any(np.allclose(loads[name][1], place, rtol=0, atol=1e-9) for place in places):
            places.append(loads[name][1])
    return places


def draw_folds(validation: dict[str, Any], loads: Loads) -> Figure:
    """Draws the log predictive density of every location that was left out."""
    base, extended = validation["baseline"], validation["extended"]
    common = [f for f in base["location"] if f in extended["location"]]
    gains = [extended["log_density"][extended["location"].index(f)] - base["log_density"][base["location"].index(f)]
             for f in common]
    places = places_of(loads)
    labels = [f"{f:.0f}" for f in common]
    if common and len(places) == max(common):
        labels = [f"{f:.0f}\n({1e3 * places[int(f) - 1][0]:.1f}, {1e3 * places[int(f) - 1][1]:.1f})" for f in common]
    figure, ax = plt.subplots(figsize=(max(4.0, 0.9 * len(common) + 1), 2.8), layout="constrained")
    ax.bar(labels, gains, color=COLOURS[2])
    ax.axhline(0, color="k", lw=0.8)
    ax.axhline(np.mean(gains), color="k", lw=0.8, ls="--")
    ax.set_xlabel("location left out (x, y) [mm]" if "\n" in "".join(labels) else "location left out")
    ax.set_ylabel("gain of log density")
    return figure


def pictures_of(diagnosis: dict[str, Any], loads: Loads, unknown: dict[str, np.ndarray], outline: Sequence[np.ndarray],
                modes: Sequence[tuple[dict[str, Any], np.ndarray]] = (), records: Sequence[Record] = (),
                beats: Sequence[tuple[str, Components]] = (), tracks: Sequence[tuple[str, Marks]] = ()) \
        -> list[tuple[str, str, str, list[tuple[str, Figure]]]]:
    """Returns the pictures as (name, heading, caption, [(part, figure)])."""
    made = []
    if loads:
        is_extended = diagnosis["extended"]["is_found"]
        which = "at which the cause shows best" if is_extended else "that fit worst"
        caption = f"For the loads {which}: the measured deformation, and what the baseline, the usual model with its parameters " \
                  "fitted, leaves of it, in units of its errors (sd). White is noise; patches of one colour are a shape."
        if is_extended:
            caption += " What the cause explains is the difference to the extended wing, which has it; what that leaves should " \
                       "be noise. A shape that is weaker than the noise of one square can still be sure when all loads " \
                       "show it."
        made.append(("residuals", "What the model misses", caption + " The cross marks the force.",
                     draw_residuals(loads, outline, is_extended)))
    if modes:
        made.append(("modes", "Natural modes", "Frequencies of the models against the measured ones, with their sd, and for "
                     "each mode the measured shape and what the models leave of it.",
                     [("", draw_modes(modes, outline, draw_outline, diagnosis["extended"]["is_found"]))]))
    if records:
        is_extended = diagnosis["extended"]["is_found"]
        made.append(("series", "Records of motion", "What was recorded, with its sd, and what the models do there, with the errors of the "
                     "excitation's size and time that are then most probable; below, what they leave in units of the sd. In the grey "
                     "band it is noise.", [(facts["name"], draw_record(facts, traces, is_extended)) for facts, traces in records]))
    if beats:
        is_extended = diagnosis["extended"]["is_found"]
        made.append(("beat", "Forces over the beat", "The measured means with a band of one sd, what the simulated case makes of them"
                     + (", and the same with the cause" if is_extended else "") + "; below, what the simulation leaves in units of the sd. "
                     "In the grey band it is noise. An error of the simulation that is allowed for, as that of its grid, is not "
                     "subtracted.", [(name, draw_beat(components, is_extended)) for name, components in beats]))
    if tracks:
        is_extended = diagnosis["extended"]["is_found"]
        made.append(("tracks", "Landmarks over the beat", "The measured places of the landmarks that fit worst, where the simulated case has "
                     "them" + (", and the same with the cause" if is_extended else "") + "; below, what the simulation leaves of all of "
                     "them, as the root mean square in units of the sd. In the grey band it is noise.",
                     [(name, draw_tracks(marks, is_extended)) for name, marks in tracks]))
    if any(e["status"] == "tested" for e in diagnosis["effects"]):
        made.append(("evidence", "The candidates", "How much more probable each cause makes the data than the baseline alone "
                     "(blue: of the wing, orange: of the measurement), as a natural logarithm: 3 means 20 times. What reaches "
                     "beyond the dashed line is less than 20 times less probable than the first.",
                     [("", draw_evidence(diagnosis["effects"]))]))
    if unknown:
        region = diagnosis["verdict"].get("region")
        made.append(("unknown", "Where on the wing", "If nothing but further forces, or nothing but the stiffness, were "
                     "free all over the wing: where they would have to differ from the baseline, in units of what chance "
                     "does. Pale dots say that no single place stands out."
                     + (" The region of the verdict has thick edges." if region and region["parts"] else ""),
                     [(name, draw_unknown(name, values, outline, region)) for name, values in sorted(unknown.items())]))
    if diagnosis["validation"]["has_gain"]:
        made.append(("folds", "Loads that the fit has not seen", "Each location was left out with all its levels and "
                     "predicted from the others. The log density is the natural logarithm of how probable the model makes what was "
                     "measured there. Above zero the extended wing predicts better; the dashed line is the "
                     "mean.", [("", draw_folds(diagnosis["validation"], loads))]))
    return made


def write_picture(options: argparse.Namespace, name: str, data: bytes) -> None:
    """Writes a picture into the folder that the user wants."""
    options.pictures.mkdir(parents=True, exist_ok=True)
    (options.pictures / f"{options.json.stem}_{name}.png").write_bytes(data)


def drawn(figure: Figure, options: argparse.Namespace, *names: str) -> bytes:
    """Returns the figure as PNG; it is also written as a file if the user wants pictures."""
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=130)
    plt.close(figure)
    if options.pictures:
        write_picture(options, "_".join(filter(None, names)), data.getvalue())
    return data.getvalue()


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("json", type=Path)
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--pictures", type=Path, help="also write the pictures into this folder")
    parser.add_argument("--flight", type=Path, nargs=2, metavar=("BASELINE", "EXTENDED"),
                        help="folders of two flights, with the baseline and with the extended wing")
    options = parser.parse_args()
    use_style()
    diagnosis, loads, unknown = read(options.json)
    pictures, flight = [], None
    outline = outline_of(diagnosis, options.json.resolve().parent)
    modes = read_modes(options.json.with_suffix(".h5"), diagnosis)
    records = read_series(options.json.with_suffix(".h5"), diagnosis)
    for name, heading, caption, figures in pictures_of(diagnosis, loads, unknown, outline, modes, records, read_beats(diagnosis),
                                                       read_tracks(diagnosis)):
        pictures.append((heading, caption, [drawn(figure, options, name, part) for part, figure in figures]))
    if options.flight:
        flight = flight_section(options.flight)
        if options.pictures:
            write_picture(options, "flight", flight[1])
    output = options.output or options.json.with_name(f"{options.json.stem}_report.html")
    try:
        output.write_text(page(diagnosis, pictures, flight), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{output}: {error}") from None
    print(output)


def command() -> None:
    """Runs the tool; mistakes become messages."""
    run_command("plot_diagnosis", main)
