#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Landmarks on a section that hovers in a plane flow, in msm_diagnose. The data come from tools/make_flight, whose section, flow and
cameras share no code with flusi.

usage: flight_landmarks.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import math
import shutil
import subprocess
import sys
from pathlib import Path

import flight_records as records
import h5py
import numpy as np
from flight_records import BEATS, BOX, FREQUENCY, LENGTH, RE, STROKE, UNIT_FREQUENCY, diagnose, names, write_case
from json_schema import validate
from synthetic_bending import ADEQUATE, NAMED, SET, seal
from whole_program import SOURCE, check, main, series

from flusi_msm.measurement.flight import Cameras, Case, Flow, Fluid, Hidden, Motion, Scatter, Wing, beat_of
from flusi_msm.measurement.flight import synthesise, write_flight

# A grid that is as coarse as that of the diagnosis. The stated errors of forces cover by how much the two simulations differ.
COARSE = Flow(beats=BEATS, modes=24, radial=40, radius=8.0)
FORCES = Scatter(white=0.02, model=0.25, model_time=0.06 / FREQUENCY)
SD = 1e-4  # m, of a camera in one beat: a hundredth of the chord
FEW = "effects = stroke_amplitude, pitch_lead, balance_gain, balance_delay\nrefine = no\nrounds = {rounds}\nmodel_sd = 0.05\n"


def experiment(seed, hidden, **cameras):
    middle = BOX / 2 * LENGTH
    return Case(seed=seed, components="Fy, Fz", beats=16, state="sd", wing=Wing(chord=LENGTH, thickness=0.05),
                kinematics=Motion(frequency=FREQUENCY, stroke=STROKE * LENGTH, pitch=45.0, centre=(middle, middle)),
                fluid=Fluid(density=records.DENSITY, viscosity=LENGTH**2 * UNIT_FREQUENCY / RE), hidden=hidden, noise=FORCES,
                cameras=Cameras(points=(0.4, -0.1, -0.4), sd=SD, **cameras), flow=COARSE)


def write_experiment(path, case, has_forces=True, has_landmarks=True):
    """Flies the experiment and writes what it measured."""
    record, _ = synthesise(case)
    path.unlink(missing_ok=True)
    write_flight(path, case, record)
    with h5py.File(path, "r+") as file:
        group = file["flight/hover"]
        if not has_landmarks:
            del group["landmarks"]
        if not has_forces:
            for name in "time", "mean", "sd":
                del group[name]
            for name in "components", "units", "reference":
                del group.attrs[name]
    seal(path)


def kind_of(found, kind):
    return next((one for one in found["data"] if one["kind"] == kind), None)


def test_stroke(case):
    """A stroke that is shorter by 10 %: forces alone cannot tell it from a gain of the balance; with landmarks it is named."""
    flown = experiment(1, Hidden(stroke=0.9))
    write_experiment(case.folder / "data.h5", flown, has_landmarks=False)
    code, found, _ = diagnose(case, "data.h5", "forces", FEW.format(rounds=0), options="validation = no\n")
    check(code == SET and {"stroke_amplitude", "balance_gain"} <= set(names(found)) and kind_of(found, "landmarks") is None,
          f"forces alone name a set: {found['verdict']['sentence']}")
    write_experiment(case.folder / "data.h5", flown)
    code, found, text = diagnose(case, "data.h5", "both", FEW.format(rounds=1))
    check(code == NAMED and names(found) == ["stroke_amplitude"], found["verdict"]["sentence"])
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    check(lower <= -0.1 <= upper and upper - lower < 0.01, f"a stroke longer by {lower} {best} {upper}")
    check("1 records of landmarks (240 numbers)" in text and "of which forces over the beat" in text and "landmarks" in text, text)
    seen, forces = kind_of(found, "landmarks"), kind_of(found, "flight")
    check(seen["observations"] == 240 and seen["baseline_chi2"] > 2 * 240 > seen["extended_chi2"], f"chi^2 of landmarks: {seen}")
    total = found["baseline"]["chi2"]
    check(abs(seen["baseline_chi2"] + forces["baseline_chi2"] - total) < 1e-6 * total, "the kinds add up")
    mistakes = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not mistakes, f"the JSON file is what the schema says: {mistakes}")


def test_lead(case):
    """Landmarks alone: a pitch that is 0.04 beats early is named, and effects of the flow are not testable. Axes that are turned by 2
    degrees and displaced, with errors that are stated, do not hide or change it."""
    flown = experiment(2, Hidden(lead=360 * 0.04), turn=2.0, shift=(4e-4, -3e-4), turn_sd=2.0, offset_sd=5e-4)
    write_experiment(case.folder / "data.h5", flown, has_forces=False)
    few = FEW.format(rounds=1).replace("balance_gain, balance_delay", "pitch_mean, wind")
    code, found, _ = diagnose(case, "data.h5", "lead", few)
    check(code == NAMED and names(found) == ["pitch_lead"], found["verdict"]["sentence"])
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    check(lower <= 0.04 <= upper and upper - lower < 0.01, f"a lead of {lower} {best} {upper} beats")
    reasons = {one["name"]: one["missing"] for one in found["effects"]}
    check("needs records of forces" in reasons["wind"], f"{reasons}")


def test_null(case):
    """The motion is as stated: nothing is found. An error of the axes that is not stated is found."""
    write_experiment(case.folder / "data.h5", experiment(3, Hidden()))
    code, found, _ = diagnose(case, "data.h5", "null", FEW.format(rounds=0), options="validation = no\n")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    seen = kind_of(found, "landmarks")
    check(seen["baseline_chi2"] < 240 + 4 * math.sqrt(2 * 240), f"landmarks are noise: {seen['baseline_chi2']}")
    write_experiment(case.folder / "data.h5", experiment(3, Hidden(), shift=(0.0, 5e-4)), has_forces=False)
    code, found, _ = diagnose(case, "data.h5", "moved", FEW.format(rounds=0), options="validation = no\n")
    check(code not in (ADEQUATE, NAMED), f"no cause displaces all landmarks: {found['verdict']['sentence']}")


def test_exact(case):
    """Both programs agree on where the points of a section are, to what linear interpolation between records leaves."""
    folder = case.folder / "case"
    write_case(folder, 8)
    text = (folder / "hover.ini").read_text().replace("[Saving]\n", "[Saving]\nlandmarks_left = (/ 0.4 0.0\n-0.1 0.1 /)\n")
    (folder / "hover.ini").write_text(text)
    subprocess.run([records.FLUSI, "hover.ini"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    rows = np.array(series(folder / "landmarks_left.t").rows)
    flown = experiment(1, Hidden())
    place, _, _ = beat_of(flown).at(rows[:, 0] / UNIT_FREQUENCY)
    for k, along in enumerate((0.4, -0.1)):
        y = (place[:, 0] / LENGTH + along * np.cos(place[:, 2]), place[:, 1] / LENGTH + along * np.sin(place[:, 2]))
        for c in range(2):
            apart = np.abs(rows[:, 3 * k + 2 + c] - y[c]).max()
            check(apart < 2e-4, f"landmark {k + 1}, {'yz'[c]}: {apart} chords apart")  # stroke.t has 200 points in a beat


def refused(case, change, wanted):
    """A change of the file, which is a mistake."""
    path = case.folder / "data.h5"
    if not (case.folder / "good.h5").exists():
        write_experiment(case.folder / "good.h5", experiment(5, Hidden()), has_forces=False)
    shutil.copy(case.folder / "good.h5", path)
    with h5py.File(path, "r+") as file:
        change(file["flight/hover/landmarks"])
    seal(path)
    code, _, text = diagnose(case, "data.h5", "wrong", FEW.format(rounds=0), flags=("--check",))
    check(code == 2 and wanted in text, text)


def test_refused(case):
    """Landmarks that the case does not have."""
    def outside(group):
        group["left/points"][1] = 0.8 * LENGTH, 0.0

    def with_x(group):
        group["left/mean"][:, 3] = 0.0
        group["left/sd"][:, 3] = 1.0

    def on_the_right(group):
        group.move("left", "right")

    def another_wing(group):
        group.move("left", "lift")
    refused(case, outside, "/flight/hover/landmarks/left: point 2 is not on the wing, which reaches from -0.5 to 0.5 L in x")
    refused(case, with_x, "/flight/hover/landmarks/left/mean: holds x of point 2, but a section lies in the plane of y and z")
    refused(case, on_the_right, "/flight/hover/landmarks/right: there is no right wing")
    refused(case, another_wing, "unknown object 'lift'; did you mean 'left'?")


if __name__ == "__main__":
    shutil.rmtree("flights", ignore_errors=True)  # those of this program alone
    records.FLUSI = str(Path(sys.argv.pop(3)).resolve())
    main(globals())
