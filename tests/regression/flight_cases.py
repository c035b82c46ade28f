#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of several cases in one diagnosis: a plate that hovers, and the same plate in wind. Data and diagnosis have the same grid, so
that only noise and what is hidden are between them.

usage: flight_cases.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import functools
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import flight_records as records
import h5py
import numpy as np
from flight_records import BEATS, BOX, FORCE, FREQUENCY, LENGTH, PERIOD, STROKE, TIMES, UNIT_FREQUENCY
from flight_records import flies, flight_of, names, write_case
from json_schema import validate
from synthetic_bending import ADEQUATE, NAMED, SET, seal
from whole_program import SOURCE, check, main, series

POINTS, WIND = 8, 0.4  # of the grid in a chord; of the second case, in mean speeds of the stroke
SPEED = LENGTH * UNIT_FREQUENCY  # m/s, that of the stroke
NO_REFINEMENT = "refine = no\n"
CAMERA = 2e-5  # m, error of a place


def write_cases(folder):
    """The case of a calm experiment, and forward.ini: the same in wind along y."""
    write_case(folder, POINTS)
    write_forward(folder, WIND)


def write_forward(folder, wind):
    text = (folder / "hover.ini").read_text()
    check(text.count("uy = 0.0") == 1, text)
    (folder / "forward.ini").write_text(text.replace("uy = 0.0", f"uy = {wind!r}"))


@functools.lru_cache(maxsize=None)
def flown(wind, more=""):
    """Fy, Fz [N/m] and power [W/m] at TIMES of the last beat of a flight of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_case(folder, POINTS, more=more)
        write_forward(folder, wind)
        subprocess.run([records.FLUSI, "forward.ini"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        rows = np.array(series(folder / "forces.t").rows)
    t = rows[:, 0] / PERIOD - (BEATS - 1)
    columns = [rows[:, 2] + rows[:, 5], rows[:, 3] + rows[:, 6], SPEED * rows[:, 13]]
    return FORCE * np.stack([np.interp(TIMES, t, column) for column in columns], axis=1)


def write_data(path, means, seed, error=0.05, keep=(0, 1, 2), every=1, noise=1.0):
    """A measurement with the records `means`, by name, of the components `keep` at every so many times. `noise` is the share of the
    stated errors that scatters."""
    rng = np.random.default_rng(seed)
    with h5py.File(path, "w", libver=("v108", "v108")) as f:
        f.attrs.update(schema="flusi-msm measurement", version=1)
        for name, mean in means.items():
            mean = mean[::every, keep]
            sd = error * np.sqrt(np.mean(mean**2, axis=0)) * np.ones_like(mean)
            flight = f.create_group(f"flight/{name}")
            words = [(("Fy", "Fz", "power")[k], ("N/m", "N/m", "W/m")[k]) for k in keep]
            flight.attrs.update(frequency=FREQUENCY, beats=16, frame="lab", reference=np.zeros(3), per_length=1,
                                components=", ".join(word for word, _ in words), units=", ".join(unit for _, unit in words))
            flight["time"] = TIMES[::every]
            flight["mean"] = mean + noise * sd * rng.standard_normal(mean.shape)
            flight["sd"] = sd


def add_landmarks(path, name, places, seed):
    """Adds to a record the paths of points of the plate that are so many chords from its middle, with errors of a camera."""
    rng = np.random.default_rng(seed)
    angle, middle = np.radians(90 + 45 * np.sin(2 * np.pi * TIMES)), BOX / 2
    columns = []
    for r in places:
        columns += [np.full(len(TIMES), np.nan), middle + STROKE / 2 * np.cos(2 * np.pi * TIMES) + r * np.cos(angle),
                    middle + r * np.sin(angle)]
    mean = LENGTH * np.stack(columns, axis=1)
    with h5py.File(path, "r+") as file:
        marks = file.create_group(f"flight/{name}/landmarks")
        marks.attrs.update(origin=np.zeros(3))
        marks["left/time"] = TIMES
        marks["left/points"] = LENGTH * np.array([[r, 0.0] for r in places])
        marks["left/points"].attrs["units"] = "m"
        marks["left/mean"] = mean + CAMERA * rng.standard_normal(mean.shape)
        marks["left/sd"] = np.full_like(mean, CAMERA)
    seal(path)


def diagnose(case, data, name, more, assigned="gust: case/forward.ini", has_file=True, **choices):
    """Exit code, JSON (or none) and what was printed. `assigned`: the records that have a case of their own."""
    if not (case.folder / "case").exists():
        write_cases(case.folder / "case")
    lines = f"records = {assigned}\n" if assigned else ""
    return records.diagnose(case, data, name, more + lines + ("" if "refine" in more else NO_REFINEMENT), has_file=has_file, **choices)


def test_wind_in_one(case):
    """The wind of one record was stronger than its case says. It is found in this record alone, with its size, and only the flight of
    its case is made again. Ranks change nothing, and a plan counts the flights of both cases."""
    few = "effects = wind, balance_gain\nrounds = 1\n"
    write_data(case.folder / "data.h5", {"calm": flown(0.0), "gust": flown(WIND + 0.1)}, 4)
    code, _, text = diagnose(case, "data.h5", "plan", few, flags=("--plan",), cache="mine")
    check(code == 0 and text.count("flights   5 of ") == 2 and "of all 2 cases 10 flights, of which 10 are still to be simulated" in text, text)
    check("each of 2 flights with the fitted values and up to 4 more for each of its parameters" in text, text)
    code, found, text = diagnose(case, "data.h5", "wind", few, cache="mine")
    check(code == NAMED and names(found) == ["wind"], text)
    check(found["verdict"]["causes"][0]["variant"] == "in the record gust" and "(in the record gust)" in text, text)
    lower, _, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    # A fifth of the hidden wind: the interval of a wind that is seen, not of a prior.
    check(lower <= 0.1 * SPEED <= upper and upper - lower < 0.02 * SPEED, f"wind of {lower} to {upper} m/s, hidden {0.1 * SPEED}")
    folder = case.folder
    check((folder / "wind_extended_flight_2.ini").exists() and not (folder / "wind_extended_flight.ini").exists(), "only one case has wind")
    changed = (folder / "wind_extended_flight_2.ini").read_text()
    check(f"file = {(folder / 'case/forward.ini').resolve()}" in changed and "uy = " in changed, changed)
    record = flight_of(found)
    check([Path(one["case"]).name for one in record["cases"]] == ["hover.ini", "forward.ini"], f"{record['cases']}")
    check({(one["record"], Path(one["case"]).name) for one in record["sets"]} == {("calm", "hover.ini"), ("gust", "forward.ini")}, "sets")
    mistakes = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not mistakes, f"the JSON file is what the schema says: {mistakes}")
    again = sum("hover.ini" in (path / "flight.ini").read_text() for path in (folder / "mine").iterdir())
    check(again == 5, f"the calm case is not flown again: {again}")
    before = (folder / "wind.json").read_bytes()
    _, _, text = diagnose(case, "data.h5", "wind", few, ranks=2, cache="mine")
    check(not flies(text) and (folder / "wind.json").read_bytes() == before, "two ranks make the same diagnosis, to the bit")


def test_shared(case):
    """A stroke of 6 % more in both experiments. Lift alone cannot tell it from a gain of the balance, neither that of the calm
    experiment nor that in wind. Both together can, and the cause is one of all records."""
    more = "body_motion_factor = 1.06\n"
    few = "effects = pitch_lead, stroke_amplitude, balance_gain, balance_delay\nrounds = 0\n"
    both = {"calm": flown(0.0, more), "gust": flown(WIND, more)}
    data = {"error": 0.09, "keep": (1,), "every": 2, "noise": 0.3}
    for name in both:
        write_data(case.folder / f"{name}-data.h5", {name: both[name]}, 5, **data)
        assigned = "" if name == "calm" else "gust: case/forward.ini"
        code, found, text = diagnose(case, f"{name}-data.h5", name, few, assigned, has_file=name == "calm", options="validation = no\n")
        check(code == SET and set(names(found)) == {"stroke_amplitude", "balance_gain"}, f"one record alone: {text}")
        check("cases" not in flight_of(found), "one case is one case")
    write_data(case.folder / "data.h5", both, 5, **data)
    code, found, text = diagnose(case, "data.h5", "both", few, options="validation = no\n")
    check(code == NAMED and names(found) == ["stroke_amplitude"] and found["verdict"]["causes"][0]["variant"] == "", text)
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    check(lower <= 0.06 <= upper, f"a stroke of {lower} {best} {upper} more")


def test_landmarks(case):
    """Landmarks of two cases, one beat more as a refinement: a null is adequate, and each record is that of a diagnosis of its case
    alone, with the same residuals and the same numerical errors."""
    few = "effects = pitch_lead, balance_gain\nrounds = 0\nrefine = beats\n"
    write_data(case.folder / "data.h5", {"calm": flown(0.0), "gust": flown(WIND)}, 6)
    add_landmarks(case.folder / "data.h5", "calm", (0.4,), 7)
    add_landmarks(case.folder / "data.h5", "gust", (-0.3, 0.25), 8)
    code, found, text = diagnose(case, "data.h5", "null", few, options="validation = no\n")
    check(code == ADEQUATE, text)
    marks = next(one for one in found["data"] if one["kind"] == "landmarks")
    check([(one["record"], one["landmark"], one["component"]) for one in marks["sets"]] ==
          [("calm", 1, "y"), ("calm", 1, "z"), ("gust", 1, "y"), ("gust", 1, "z"), ("gust", 2, "y"), ("gust", 2, "z")], f"{marks['sets']}")
    # Means 180 +- 19 if the errors are as stated; the flights interpolate places linearly.
    with h5py.File(case.folder / "data.h5", "r+") as file:
        del file["flight/calm"]
    seal(case.folder / "data.h5")
    _, alone, _ = diagnose(case, "data.h5", "alone", few, has_file=False, options="validation = no\n")
    for kind in "flight", "landmarks":
        own, others = ({one["name"]: one for one in next(data for data in result["data"] if data["kind"] == kind)["sets"]}
                       for result in (alone, found))
        for name, one in own.items():
            # The same flights: only the order of sums may differ, and with it rounding errors; 1e-15 is for sums that vanish.
            for key in "measured", "simulated", "refinement_differences_sd":
                check(np.allclose(one[key], others[name][key], rtol=1e-12, atol=1e-15), f"{name}: {key} {one[key]} {others[name][key]}")
    check(marks["observations"] == 180 and marks["baseline_chi2"] < 180 + 5 * 19, f"{marks['baseline_chi2']} of {marks['observations']}")


def test_refused(case):
    """Mistakes in the list of records."""
    write_data(case.folder / "data.h5", {"calm": flown(0.0), "gust": flown(WIND)}, 9)
    forward = "case/forward.ini"
    for assigned, words in ((f"gsut: {forward}", "there is no record 'gsut' in /flight of the measurement; did you mean 'gust'?"),
                            (forward, "has the entry 'case/forward.ini'; valid: RECORD: FILE"),
                            (f"gust: {forward}, gust: case/hover.ini", "names the record 'gust' twice"),
                            (f"gust: {forward}, calm: case/hover.ini", "simulates no record, because records gives a case to each of them"),
                            ("gust: case/none.ini", "[Flight] records: of the record gust: 'case/none.ini' does not exist"),
                            ("gust: none.ini, calm: none.ini", "[Flight] records: of the record calm: 'none.ini' does not exist")):
        code, _, text = diagnose(case, "data.h5", "wrong", "", assigned)
        check(code == 2 and words in text and text.count("does not exist, neither") <= 1, text)
    code, _, text = diagnose(case, "data.h5", "wrong", "", has_file=False)
    check(code == 2 and "[Flight] file: is missing" in text, text)
    for path in (case.folder / "case").iterdir():
        shutil.copy(path, case.folder)
    (case.folder / "forward.ini").rename(case.folder / "wrong_extended_flight.ini")
    code, _, text = diagnose(case, "data.h5", "wrong", "", "gust: wrong_extended_flight.ini", flags=("--plan",))
    check(code == 2 and "[Saving] name: wrong_extended_flight.ini is an input file and would be overwritten" in text, text)
    slow = case.folder / "case/forward.ini"
    slow.write_text(slow.read_text().replace("wing_frequency = ", "wing_frequency = 0.9*").replace("0.9*" + repr(1 / PERIOD), repr(0.9 / PERIOD)))
    code, _, text = diagnose(case, "data.h5", "wrong", "")
    check(code == 2 and "/flight/gust: attribute frequency is" in text and "/flight/calm" not in text, text)


if __name__ == "__main__":
    shutil.rmtree("flights", ignore_errors=True)  # those of this program alone
    records.FLUSI = str(Path(sys.argv.pop(3)).resolve())
    main(globals())
