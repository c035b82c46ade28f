#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces on a plate that hovers in a plane flow, in msm_diagnose. The data come from flusi on a finer grid, with noise that covers what
the grids differ by, so that a cause is found through another discretisation than that of the diagnosis.

usage: flight_records.py <msm_diagnose> <h5dump> <flusi> [tests]
"""
import functools
import json
import math
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
from synthetic_bending import ADEQUATE, NAMED, SET, UNKNOWN, measure, seal
from whole_program import ALIVE, EXIT_STOPPED, SOURCE, check, main, series

from flusi_msm.hovering_plate import write_plate, write_stroke
from json_schema import validate

RE, STROKE, BOX, BEATS = 75, 2.0, 6, 2
PERIOD = math.pi * STROKE  # c/U, with U = pi f A0 = 1
LENGTH, FREQUENCY, DENSITY = 0.01, 50.0, 1.2  # SI values of chord and beat; of the case: one T is c/U
UNIT_FREQUENCY = FREQUENCY * PERIOD
TIMES = (np.arange(30) + 0.5) / 30
ERROR = 0.12  # of the root mean square of each component
# A plate of four cells on 16 points in a chord has a thickness of a quarter chord. It differs from one without thickness by this share of
# the root mean square, and in the same way for this share of the beat.
BODY_ERROR, BODY_TIME = 0.3, 0.06
FORCE = DENSITY * LENGTH**3 * UNIT_FREQUENCY**2  # N/m

INI = """\
[units]
length = {length!r}
frequency = {unit!r}
density = {density!r}
[Resolution]
nx = 1;
ny = {cells}
nz = {cells}
[Geometry]
yl = {box}.0
zl = {box}.0
[Time]
Tmax = {end!r}
dt_fixed = {dt!r}
[ReynoldsNumber]
nu = {nu!r}
[InitialCondition]
inicond = quiescent
[Penalization]
iPenalization = yes
iMask = Insect
eps = {eps!r}
[Insects]
WingShape = from_file::plate.ini
surface = {surface}
{thickness}RightWing = no
x0 = 0.0 {middle} {middle}
BodyMotion = from_file::stroke.t
FlappingMotion_left = from_file::pitch.ini
wing_frequency = {beat!r}
{more}[MeanFlow]
iMeanFlow = 1;
ux = 0.0
uy = 0.0
uz = 0.0
[Saving]
tintegral = {record!r}
iDoBackup = no
progress_interval = 300
"""


def flight_of(found):
    """The records of forces among the data of a diagnosis, with the facts of their flight."""
    return next(one for one in found["data"] if one["kind"] == "flight")


def write_case(folder, points, surface="thin", more="", step=0.2, half=0.5):
    """A case with so many points per unit of length and steps of `step` dx/U; the plate is 2 `half` long."""
    folder.mkdir(parents=True, exist_ok=True)
    middle = BOX / 2
    write_plate(folder, half, 45.0)
    write_stroke(folder, STROKE, PERIOD, BEATS + 1, middle, 200)  # for one more beat
    dt = step / points
    (folder / "hover.ini").write_text(INI.format(
        length=LENGTH, unit=UNIT_FREQUENCY, density=DENSITY, cells=BOX * points, box=BOX, end=BEATS * PERIOD, dt=dt, nu=1 / RE, eps=1.2 * dt,
        surface=surface, thickness="" if surface == "thin" else f"WingThickness = {4 / points!r}\n", middle=middle, beat=1 / PERIOD,
        more=more, record=PERIOD / 200))


def write_third_harmonic(folder, share):
    """Replaces the stroke of a case by y = A0/2 (cos w + share cos 3w), w = 2 pi f t."""
    w = 2 * np.pi * np.arange(200 * BEATS + 41) / 200
    y = BOX / 2 + STROKE / 2 * (np.cos(w) + share * np.cos(3 * w))
    v = -np.pi * STROKE / PERIOD * (np.sin(w) + 3 * share * np.sin(3 * w))
    (folder / "stroke.t").write_text("".join(f"{t:.12e} 0 {a:.12e} {BOX / 2} 0 {b:.12e} 0  1 0 0 0  0 0 0\n"
                                             for t, a, b in zip(w * PERIOD / (2 * np.pi), y, v)))


@functools.lru_cache(maxsize=None)
def flown(points, more="", surface="thin", third=0.0, half=0.5):
    """Fy, Fz [N/m] and power [W/m] at TIMES of the last beat of a flight of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_case(folder, points, surface, more, half=half)
        if third:
            write_third_harmonic(folder, third)
        subprocess.run([FLUSI, "hover.ini"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        rows = np.array(series(folder / "forces.t").rows)
    t = rows[:, 0] / PERIOD - (BEATS - 1)
    columns = [rows[:, 2] + rows[:, 5], rows[:, 3] + rows[:, 6], LENGTH * UNIT_FREQUENCY * rows[:, 13]]
    return FORCE * np.stack([np.interp(TIMES, t, column) for column in columns], axis=1)


@functools.lru_cache(maxsize=None)
def flown_means(points, more):
    """Mean lift, drag [N/m] and power [W/m] over the last beat of a flight of its own."""
    return np.mean(flown(points, more), axis=0)[[1, 0, 2]]


def check_comparison(found, text):
    """Flights with the lead at the ends of its interval have the means that the table says: their intervals come from the same flights
    by a parabola, and the ends by a Gaussian posterior in place of the profile."""
    table = found["flights"]
    check(table["is_known"] and not table["wings_were_flown"] and table["directions"] == 1, f"both flights are compared: {table}")
    check("compared  the flight of the case, and with what was found: means over the beat" in text, text)
    means = {one["name"]: one for one in table["means"]}
    before = flown_means(8, "")
    ends = [flown_means(8, f"kinematics_lead = {lead!r} 0 0\n") for lead in found["extended"]["intervals_90"][0]["lower_best_upper"]]
    for k, name in enumerate(("lift", "drag", "power")):
        one = means[name]
        size = max(abs(one["baseline"]), abs(means["lift"]["baseline"]) if k < 2 else 0)
        check(abs(one["baseline"] - before[k]) < 0.01 * size and abs(one["extended"] - ends[1][k]) < 0.01 * size,
              f"{name}: {one} {before[k]} {ends[1][k]}")
        low, high = sorted((ends[0][k], ends[2][k]))
        below, above = one["interval_90"]
        print(f"    {name}: {below:.5g} to {above:.5g}, flown {low:.5g} to {high:.5g}")
        # Places and widths are compared apart, because an interval is narrower than the error of its middle. The slope of a parabola
        # through flights that are steps of the prior apart stands for that between the ends, and a Gaussian width for a profile. They
        # differ by up to 6 % here. An interval of one sd in place of 90 % would be 39 % narrower.
        check(abs((below + above) / 2 - (low + high) / 2) < 0.01 * size, f"{name}: the middle of {one['interval_90']}, flown {low} to {high}")
        check(abs((above - below) / (high - low) - 1) < 0.3, f"{name}: the width of {one['interval_90']}, flown {low} to {high}")
    ratio = means["lift/power"]
    check(abs(ratio["extended"] - means["lift"]["extended"] / means["power"]["extended"]) < 1e-12 * abs(ratio["extended"]), f"{ratio}")
    change = means["power"]["extended"] / means["power"]["baseline"] - 1
    check(abs(means["power"]["change"] - change) < 1e-12, f"{means['power']}")


def write_data(path, mean, seed, error=ERROR, noise=1.0, **attributes):
    """A measurement of nothing else, with errors that cover what grids of 8 and 12 points per chord differ by. `noise` is the share of
    the stated errors that scatters."""
    rng = np.random.default_rng(seed)
    sd = error * np.sqrt(np.mean(mean**2, axis=0)) * np.ones_like(mean)
    with h5py.File(path, "w", libver=("v108", "v108")) as f:
        f.attrs.update(schema="flusi-msm measurement", version=1)
        flight = f.create_group("flight/hover")
        flight.attrs.update(frequency=FREQUENCY, beats=16, frame="lab", reference=np.zeros(3),
                            components="Fy, Fz, power", units="N/m, N/m, W/m", per_length=1)
        flight.attrs.update(attributes)
        flight["time"] = TIMES
        flight["mean"] = mean + noise * sd * rng.standard_normal(mean.shape)
        flight["sd"] = sd


def write_input(case, data, name, more="", cache="../flights", options="", has_file=True):
    case_folder = case.folder / "case"
    if not case_folder.exists():
        write_case(case_folder, 8)
    (case.folder / f"{name}.ini").write_text(
        f"[Wing]\nfile = {SOURCE}/wings/calliphora_small.h5\nE = 12.58e9\nD = 2e-7\n[Measurement]\nfile = {data}\n"
        # The data come from the same box, wing and start, so that the simulation errs by its grid alone.
        f"[Flight]\n{'file = case/hover.ini' + chr(10) if has_file else ''}beats = {BEATS}\nharmonics = 12\nfolder = {cache}\n"
        f"{'' if 'model_sd' in more else 'model_sd = 0' + chr(10)}{'' if 'refine' in more else 'refine = grid' + chr(10)}{more}"
        f"[Diagnose]\n{'' if 'noise' in options else 'noise = declared' + chr(10)}draws = 1000\nstarts = 1\n{options}"
        f"[Saving]\nname = {name}\n")


def diagnose(case, data, name, more="", ranks=0, flags=(), cache="../flights", options="", has_file=True):
    """Exit code, JSON (or none) and what was printed."""
    write_input(case, data, name, more, cache, options, has_file)
    done = case.flusi(f"{name}.ini", "--exit-code", *flags, ranks=ranks, timeout=300)
    path = case.folder / f"{name}.json"
    found = json.loads(path.read_text()) if path.exists() else None
    print(f"    {name}: {done.code} {found['verdict']['sentence'] if found else done.err}", flush=True)
    return done.code, found, done.out + done.err


def axes_about_x(degrees):
    """The axes of a record that are turned by this angle from y toward z."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])


def test_axes(case):
    """A record along axes that are turned by 90 degrees about x, with this attribute, gives the same diagnosis: its Fy is Fz of the
    case, and its Fz is -Fy, each with its own sd. Without the attribute the case does not explain it."""
    few = "effects = pitch_lead, balance_gain, balance_turn\nrefine = no\nrounds = 0\n"
    write_data(case.folder / "data.h5", flown(8, "kinematics_lead = 0.04 0 0\n"), 4)
    _, straight, _ = diagnose(case, "data.h5", "straight", few)
    with h5py.File(case.folder / "data.h5", "r+") as file:
        flight = file["flight/hover"]
        mean, sd = flight["mean"][...], flight["sd"][...]
        flight["mean"][...] = np.stack([mean[:, 1], -mean[:, 0], mean[:, 2]], 1)
        flight["sd"][...] = sd[:, [1, 0, 2]]
        flight.attrs["axes"] = axes_about_x(90)
    seal(case.folder / "data.h5")
    _, turned, _ = diagnose(case, "data.h5", "turned", few)
    check(names(straight) == ["pitch_lead"] and straight["verdict"]["sentence"] == turned["verdict"]["sentence"], f"{turned['verdict']}")
    one, two = (np.array(found["extended"]["intervals_90"][0]["lower_best_upper"]) for found in (straight, turned))
    check(np.allclose(one, two, rtol=1e-10), f"the interval of the lead: {one} {two}")
    for seen, of, sign in ((0, 1, 1), (1, 0, -1), (2, 2, 1)):
        other, own = (np.array(found["simulated"]) for found in (flight_of(straight)["sets"][of], flight_of(turned)["sets"][seen]))
        check(np.allclose(own, sign * other, atol=1e-12 * np.abs(other).max()), f"simulated along the axes of the record: {own} {other}")
    with h5py.File(case.folder / "data.h5", "r+") as file:
        del file["flight/hover"].attrs["axes"]
    seal(case.folder / "data.h5")
    code, ignored, _ = diagnose(case, "data.h5", "ignored", few)
    check(code != ADEQUATE and names(ignored) != ["pitch_lead"], f"without the attribute: {ignored['verdict']['sentence']}")
    with h5py.File(case.folder / "data.h5", "r+") as file:
        file["flight/hover"].attrs["axes"] = np.eye(3)[[1, 2, 0]]
    seal(case.folder / "data.h5")
    code, _, text = diagnose(case, "data.h5", "about-another", few)
    check(code == 2 and "attribute axes turns about another axis than x, but per_length is 1" in text, text)


def names(found):
    return found["verdict"]["set"] or [cause["effect"] for cause in found["verdict"]["causes"]]


def test_lead(case):
    """The plate turns 0.04 beats before its time, seen through a finer grid. Flown again at what was found, the interval holds it."""
    lead = 0.04
    write_data(case.folder / "data.h5", flown(12, f"kinematics_lead = {lead} 0 0\n"), 1)
    code, found, text = diagnose(case, "data.h5", "lead")
    check(code == NAMED and names(found) == ["pitch_lead"], found["verdict"]["sentence"])
    check("The pitch was early by" in text, "the terminal says where and how much")
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    check(lower <= lead <= upper and upper - lower < 0.01, f"a lead of {lower} {best} {upper} beats")
    moved = flight_of(found)["moved_sd"]
    check(moved[0] > 0.1 and moved[-1] < 0.1 and flight_of(found)["has_settled"] and "not settled" not in text,
          f"what was found is flown until it stays: {moved} sd")
    check("then up to 3 rounds if a cause is clear, each of 2 flights with the fitted values and up to 2 more for each of its parameters" in text
          and text.index("then up to") < text.index("flight    "), f"the cost is told before anything is flown: {text}")
    terminal = text
    text = (case.folder / "lead_extended_flight.ini").read_text()
    check(abs(float(text.split("kinematics_lead =")[1].split()[0]) - best) < 1e-3, f"the case with that lead: {text}")
    done = subprocess.run([FLUSI, "../lead_extended_flight.ini", "--check"], cwd=case.folder / "case", capture_output=True, text=True,
                          check=False)
    check(done.returncode == 0 and "kinematics_lead" in done.stdout, done.stderr)
    mistakes = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not mistakes, f"the JSON file is what the schema says: {mistakes}")
    check_comparison(found, terminal)
    for record in flight_of(found)["sets"]:
        sd = np.array(record["sd"])
        before, after = (np.mean(((np.array(record[name]) - record["measured"]) / sd) ** 2) for name in ("simulated", "extended"))
        check(after < 4 and (after < before or before < 4), f"{record['component']}: mean squares over sd {before} and {after}")


def test_gain(case):
    """A balance that shows a quarter too much; power, which grows otherwise with a faster beat, tells it from that."""
    write_data(case.folder / "data.h5", 1.25 * flown(12), 2)
    code, found, _ = diagnose(case, "data.h5", "gain")
    check(code in (NAMED, SET) and "balance_gain" in names(found), found["verdict"]["sentence"])


def test_null(case):
    """Another grid alone is no discovery."""
    write_data(case.folder / "data.h5", flown(12), 3)
    code, found, _ = diagnose(case, "data.h5", "null", options="validation = no\n")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    # The data come from the grid of this refinement: it changes forces by their difference, whatever error follows from that.
    # Harmonics beyond the last one, which records keep, are below 2 % of it.
    for record, finer in zip(flight_of(found)["sets"], flown(12).T):
        change = np.sqrt(np.mean(((finer - record["simulated"]) / np.array(record["sd"])) ** 2))
        check(abs(record["grid_difference_sd"] / change - 1) < 0.02, f"{record['component']}: {record['grid_difference_sd']} {change}")


def test_body(case):
    """The data come from the other representation of the plate on twice the points. With errors that cover its thickness a null is
    adequate, and a lead of 0.08 beats is named alone; with errors that do not cover it the cause is unknown. If the thickness of the
    plate is stated, the flight with the other representation covers it, and much smaller stated errors do."""
    facts = {"correlation_time": BODY_TIME / FREQUENCY}
    write_data(case.folder / "data.h5", flown(16, surface="penalized"), 1, BODY_ERROR, 0.1, **facts)
    code, found, _ = diagnose(case, "data.h5", "body", "model_sd = 0.05\n")
    check(code == ADEQUATE, found["verdict"]["sentence"])
    write_data(case.folder / "data.h5", flown(16, surface="penalized"), 1)
    code, found, _ = diagnose(case, "data.h5", "thick", "model_sd = 0.05\nrounds = 0\n")
    check(code == UNKNOWN, f"another thickness is not in the catalogue: {found['verdict']['sentence']}")
    write_data(case.folder / "data.h5", flown(16, "kinematics_lead = 0.08 0 0\n", "penalized"), 1, BODY_ERROR, 0.1, **facts)
    code, found, _ = diagnose(case, "data.h5", "body_lead", "model_sd = 0.05\n")
    check(code == NAMED and names(found) == ["pitch_lead"], found["verdict"]["sentence"])
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    check(lower < best < upper and abs(best - 0.08) < upper - lower, f"a lead of {lower} {best} {upper} beats")
    known = f"model_sd = 0.05\nrefine = grid, surface\nwing_thickness = {4 / 16 * LENGTH!r}\n"
    write_data(case.folder / "data.h5", flown(16, surface="penalized"), 1, ERROR, 0.1, **facts)
    code, found, _ = diagnose(case, "data.h5", "known", known)
    check(code == ADEQUATE, found["verdict"]["sentence"])
    write_data(case.folder / "data.h5", flown(16, "kinematics_lead = 0.08 0 0\n", "penalized"), 1, ERROR, 0.1, **facts)
    code, found, _ = diagnose(case, "data.h5", "known_lead", known)
    check(code == NAMED and names(found) == ["pitch_lead"], found["verdict"]["sentence"])
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    check(lower < 0.08 < upper and upper - lower < 0.015, f"a lead of {lower} {best} {upper} beats")


def test_surface(case):
    """The other representation of the plate on the same grid is one flight, and its change one error, which is in proportion to the stated
    thickness. Its mask has four points, or the stated thickness if that is more. The default has it where this is stated."""
    few = "effects = balance_gain\nrounds = 0\n"
    cases = {surface: case.sub(surface) for surface in ("thin", "penalized")}
    for surface, other in (("thin", "penalized"), ("penalized", "thin")):
        here = cases[surface]
        write_case(here.folder / "case", 8, surface)
        write_data(here.folder / "data.h5", flown(8, surface=other), 5, noise=0.1)
        code, found, _ = diagnose(here, "data.h5", "other", few + "refine = surface\n")
        check(code == ADEQUATE and flight_of(found)["refinements"] == "surface", found["verdict"]["sentence"])
        for record, seen in zip(flight_of(found)["sets"], flown(8, surface=other).T):
            change = np.sqrt(np.mean(((seen - record["simulated"]) / np.array(record["sd"])) ** 2))
            # harmonics beyond the last one are below 2 % of it
            check(abs(record["refinement_differences_sd"][0] / change - 1) < 0.02, f"{record['component']}: {record} {change}")
    thin, thick = cases["thin"], cases["penalized"]
    own = f"wing_thickness = {4 / 8 * LENGTH!r}\n"
    code, _, text = diagnose(thick, "data.h5", "same", few + "refine = thickness\n" + own)
    check(code == 2 and "the case cannot be flown so: its wings have the thickness of those of the experiment" in text, text)
    code, found, _ = diagnose(thin, "data.h5", "stated", few + "refine = surface\n" + own)
    check(code == ADEQUATE, f"the stated thickness is that of the mask: {found['verdict']['sentence']}")
    code, found, _ = diagnose(thin, "data.h5", "thin", few + f"refine = surface\nwing_thickness = {0.04 / 8 * LENGTH!r}\n")
    check(code != ADEQUATE, f"a plate of a hundredth of the mask does not differ so much: {found['verdict']['sentence']}")
    _, _, text = diagnose(thin, "data.h5", "usual", few + "refine = yes\n" + own, flags=("--plan",))
    check("beats 1.5, surface 1.0" in text, text)
    _, _, text = diagnose(thin, "data.h5", "unknown", few + "refine = yes\n", flags=("--plan",))
    check("beats 1.5" in text and "surface 1" not in text, text)


def test_outside(case):
    """A third harmonic in the stroke, which no entry of the catalogue is."""
    write_data(case.folder / "data.h5", flown(12, third=0.15), 8)
    code, found, _ = diagnose(case, "data.h5", "outside", "rounds = 0\n", options="validation = no\nintervals = no\n")
    check(code == UNKNOWN and found["verdict"]["word"] == "unknown_cause", found["verdict"]["sentence"])


def shown_by(name, mean):
    """(what a balance with this error shows of forces and power, the size of the error)."""
    size, shown = np.sqrt(np.mean(mean**2, axis=0)), mean.copy()
    fy, fz = mean[:, 0], mean[:, 1]
    beat = np.fft.fftfreq(len(TIMES), TIMES[1] - TIMES[0])
    if name == "balance_offset":
        shown[:, 1] -= 0.4 * size[1]
        return shown, -0.4 * size[1]
    if name == "balance_turn":  # 8 degrees about x
        angle = math.radians(8)
        shown[:, :2] = np.stack([fy * math.cos(angle) + fz * math.sin(angle), fz * math.cos(angle) - fy * math.sin(angle)], 1)
        return shown, 8
    if name == "cross_talk":
        shown[:, 1] += 0.25 * fy
        return shown, 0.25
    if name == "balance_lowpass":
        return np.fft.ifft(np.fft.fft(mean, axis=0) / (1 + 2j * np.pi * beat * 0.05)[:, None], axis=0).real, 0.05 / FREQUENCY
    mass = 0.3 * size[0] / (math.sqrt(0.5) * STROKE / 2 * LENGTH * (2 * np.pi * FREQUENCY)**2)  # y = A0/2 cos(2 pi f t)
    shown[:, 0] += mass * STROKE / 2 * LENGTH * (2 * np.pi * FREQUENCY)**2 * np.cos(2 * np.pi * TIMES)
    return shown, mass


def test_balance(case):
    """Errors of the balance, which need no flight more: a zero, a turn, cross-talk, a filter, and the inertia of the plate. The truth
    is asked to be within twice the width of a 90 % interval, as in diagnosis_entries.py."""
    parameters = {"balance_offset": "balance_offset:Fz", "balance_turn": "balance_turn:x", "cross_talk": "cross_talk:Fy-Fz",
                  "balance_lowpass": "balance_lowpass", "wing_inertia": "inertia_mass"}
    alike = {"balance_turn": ["cross_talk"], "balance_lowpass": ["balance_delay"]}
    for seed, (name, parameter) in enumerate(parameters.items()):
        shown, truth = shown_by(name, flown(12))
        write_data(case.folder / "data.h5", shown, 10 + seed)
        code, found, _ = diagnose(case, "data.h5", name, "rounds = 0\n", options="validation = no\n")
        check(code in (NAMED, SET) and names(found)[0] == name and set(names(found)) <= {name, *alike.get(name, [])},
              f"{name}: {found['verdict']['sentence']}")
        lower, best, upper = {one["name"]: one["lower_best_upper"] for one in found["extended"]["intervals_90"]}[parameter]
        check(2 * lower - best <= truth <= 2 * upper - best, f"{parameter} is {best} ({lower} to {upper}), not {truth}")


def test_stated(case):
    """An error of the kinematics that the record states is an error of the data, the sd of the prior and the step of the flights. A
    lead of one sd is no cause, whether it is sought or not; one of six sd is."""
    lead, few = 0.04, "effects = pitch_lead, balance_gain\nrounds = 0\n"
    data = flown(12, f"kinematics_lead = {lead} 0 0\n")
    write_data(case.folder / "data.h5", data, 1, pitch_lead_sd=lead)
    for name, more in ("one", few), ("unsought", few.replace("pitch_lead, ", "")):
        code, found, _ = diagnose(case, "data.h5", name, more, options="validation = no\n")
        check(code == ADEQUATE, f"a lead of one sd is {found['verdict']['sentence']}")
    sd = round(lead / 6, 4)
    write_data(case.folder / "data.h5", data, 1, pitch_lead_sd=sd)
    code, found, _ = diagnose(case, "data.h5", "stated", few.replace("rounds = 0", "rounds = 1"))
    check(code == NAMED and names(found) == ["pitch_lead"], f"a lead of six sd is {found['verdict']['sentence']}")
    prior, = [one["prior_sd"] for one in found["extended"]["parameters"] if one["name"] == "pitch_lead"]
    check(abs(prior / sd - 1) < 1e-9, f"the sd of the prior is {prior}")
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    # The data alone determine a lead to less than 0.01 (test_lead), the stated error is 2 x 1.64 sd = 0.022 wide.
    check(lower < lead < upper and upper - lower > 0.01, f"the interval has the stated error: {lower} {best} {upper}")
    flights = [path.read_text() for path in (case.folder / "../flights").glob("*/flight.ini")]
    leads = [float(text.split("kinematics_lead =")[1].split()[0]) for text in flights if "kinematics_lead =" in text]
    check(sum(abs(one - sd) < 1e-9 for one in leads) == 1, f"a flight has that lead: {leads}")


def test_declared(case):
    """Errors that are declared three times too small, with `noise = estimated`: no null, and the reason is given."""
    write_data(case.folder / "data.h5", flown(12), 3)
    options = "noise = estimated\nvalidation = no\nintervals = no\nrefits = 1\n"
    code, found, _ = diagnose(case, "data.h5", "honest", "rounds = 0\n", options=options)
    check(code == ADEQUATE, found["verdict"]["sentence"])
    with h5py.File(case.folder / "data.h5", "r+") as data:
        data["flight/hover/sd"][...] = data["flight/hover/sd"][...] / 3
    seal(case.folder / "data.h5")
    code, found, _ = diagnose(case, "data.h5", "small", "rounds = 0\n", options=options)
    chi2, = (one for one in found["questions"] if one["name"] == "chi2")
    check(code == UNKNOWN and chi2["takes_part"] and "times as large as the declared errors" in chi2["sentence"],
          f"{found['verdict']['sentence']}; {chi2}")


def test_surroundings(case):
    """The data have a wall, at the distance that the input states, and the simulation has none. The program says what the case cannot
    show, and refuses a refinement that the case does not permit and a wall in the way of the wings."""
    few = "effects = wing_area, wall, body, balance_gain\nwall_distance = 0.02\nrounds = 1\n"
    wall = f"[Penalization]\niChannel = xy\npos_wall = {BOX / 2 - 2.0}\nthick_wall = 0.5\n"
    write_data(case.folder / "data.h5", flown(12, wall), 9)
    _, found, text = diagnose(case, "data.h5", "wall", few)
    check("flights   3 of" in text, f"the case, a finer grid, and one for the wall: {text}")
    check(names(found) == ["wall"], found["verdict"]["sentence"])
    lower, best, upper = found["extended"]["intervals_90"][0]["lower_best_upper"]
    check(lower <= 1 <= upper, f"a wall as stated: {lower} {best} {upper}")
    reasons = {one["name"]: one["missing"] for one in found["effects"]}
    check("needs 16 points in a chord" in reasons["wing_area"] and "three-dimensional" in reasons["body"], f"{reasons}")
    _, found, _ = diagnose(case, "data.h5", "near", few.replace("0.02", "0.004"))
    reasons = {one["name"]: one["missing"] for one in found["effects"]}
    check("in the way of the wings: state a larger [Flight] wall_distance" in reasons["wall"], f"{reasons}")
    code, _, text = diagnose(case, "data.h5", "wrong", few + "refine = thickness\n")
    check(code == 2 and "names thickness, but the case cannot be flown so: needs wings in the mask" in text, text)


def test_stretch(case):
    """A wing that is stretched is the wing of the longer outline, to the bit."""
    longer, stretched = flown(8, half=0.57), flown(8, "wing_stretch = 1.14 1\n")
    check(np.array_equal(longer, stretched), f"{np.abs(longer - stretched).max()}")


def test_joint(case):
    """Bending tests and forces in one file: both are adequate, and a lead is found beside the stiffness of the veins."""
    measure(case, "data.h5", protocol={"levels": [1]})
    write_data(case.folder / "forces.h5", flown(12, "kinematics_lead = 0.05 0 0\n"), 6)
    with h5py.File(case.folder / "data.h5", "r+") as data, h5py.File(case.folder / "forces.h5") as other:
        other.copy("flight", data)
    seal(case.folder / "data.h5")
    code, found, text = diagnose(case, "data.h5", "joint", "effects = pitch_lead, balance_gain, balance_delay\nrounds = 1\n",
                                 options="parameters = E\nrefine = no\nvalidation = no\n")
    check(code in (NAMED, SET) and "pitch_lead" in names(found), text)
    check(found["baseline"]["observations"] > 90, "heights and forces are observations")
    check([one["name"] for one in found["baseline"]["parameters"]] == ["E"], "the stiffness is fitted beside")
    leads = [one["value"] for one in found["extended"].get("parameters", []) if one["name"] == "pitch_lead"]
    check(code == SET or len(leads) == 1 and 0.03 < leads[0] < 0.07, f"the plate turns 0.05 beats early: {leads}")
    moved = flight_of(found)["moved_sd"]
    check(len(moved) == 1 and moved[0] > 0.1 and not flight_of(found)["has_settled"], f"one round is not enough: {moved} sd")
    check("not settled: the last simulation with the fitted values still changed them by" in found["verdict"]["sentence"], "the verdict says so")


def test_modes_beside(case):
    """Natural modes and forces in one file: both are adequate with the stiffness of the veins, and a lead is found beside them that no
    mode depends on."""
    modes = {"wing": str(SOURCE / "wings/calliphora_small.h5"), "modes": 3, "missing": [], "sites": 6, "seed": 4, "medium": "vacuum",
             "stiffness": {"plate": "edges", "E": 1.1e10}, "noise": {"frequency": 0.003, "shape": 0.02}}
    (case.folder / "modes.json").write_text(json.dumps(modes))
    subprocess.run([sys.executable, "-B", SOURCE / "tools/make_modes", "modes.json", "-o", "data.h5"], cwd=case.folder, check=True,
                   stdout=subprocess.DEVNULL)
    write_data(case.folder / "forces.h5", flown(12, "kinematics_lead = 0.05 0 0\n"), 6)
    with h5py.File(case.folder / "data.h5", "r+") as data, h5py.File(case.folder / "forces.h5") as other:
        other.copy("flight", data)
    seal(case.folder / "data.h5")
    code, found, text = diagnose(case, "data.h5", "beside", "effects = pitch_lead, balance_gain, balance_delay\nrounds = 1\n",
                                 options="parameters = E\nrefine = no\nvalidation = no\nrefits = 1\n")
    check(code == NAMED and names(found) == ["pitch_lead"], text)
    entries = {one["kind"]: one for one in found["data"]}
    check(list(entries) == ["modes", "flight"], f"both are data: {list(entries)}")
    of_modes, of_flight = entries["modes"], entries["flight"]
    check(abs(of_modes["extended_chi2"] - of_modes["baseline_chi2"]) < 0.1 < of_flight["baseline_chi2"] - of_flight["extended_chi2"],
          f"modes do not depend on the lead: {of_modes['baseline_chi2']} {of_modes['extended_chi2']}")
    young, = [one["value"] for one in found["baseline"]["parameters"] if one["name"] == "E"]
    check(abs(young / 1.1e10 - 1) < 0.05, f"modes tell the stiffness: {young}")
    lead, = [one["value"] for one in found["extended"]["parameters"] if one["name"] == "pitch_lead"]
    check(0.03 < lead < 0.07, f"the plate turns 0.05 beats early: {lead}")
    problems = validate(found, SOURCE / "docs/formats/diagnosis.schema.json")
    check(not problems, f"the JSON file is what the schema says: {problems}")


def minutes(text, before, after):
    """The number of minutes that stands between two parts of a text; one hour has 60."""
    number, unit = text.split(before)[1].split(after)[0].split()[-2:]
    return int(number) * {"min": 1, "h": 60}[unit]


def test_cost(case):
    """A flight on the finer grid is counted with its points and steps: 1.5^3 flights of the case in a plane flow, 1.5^4 in space. Times
    are rounded up to minutes."""
    write_case(case.folder / "case", 64)
    write_data(case.folder / "data.h5", np.random.default_rng(7).standard_normal((30, 3)), 7)
    for refine, finer in (("no", 0), ("grid", 1.5**3)):
        _, _, text = diagnose(case, "data.h5", refine, f"effects = pitch_lead\nrefine = {refine}\nrounds = 2\n", flags=("--plan",))
        alone = 6e-7 * (BOX * 64)**2 * BEATS * PERIOD * 64 / 0.2 / 60  # one flight, as the program estimates it
        for seen in minutes(text, "steps", " for all"), minutes(text, "more for each of its parameters:", " with one parameter"):
            check(seen == math.ceil((3 + finer) * alone), f"three flights of {alone:.2f} min and {finer} more: {text}")
    with h5py.File(case.folder / "data.h5", "r+") as file:
        file["flight/hover"].attrs.update(frequency=158.0, per_length=0, components="Fx, Fy, Fz", units="N, N, N")
    seal(case.folder / "data.h5")
    found = []
    for refine in "no", "grid":
        write_input(case, "data.h5", refine, f"effects = pitch_lead\nrefine = {refine}\n")
        name = case.folder / f"{refine}.ini"
        text = name.read_text().replace("case/hover.ini", str(SOURCE / "ini/wing-rigid.ini"))
        name.write_text(text.replace(f"beats = {BEATS}", "beats = 1"))
        done = case.flusi(name.name, "--plan")
        found.append(minutes(done.out, "steps", " for all"))
    check(abs(found[1] / found[0] - (3 + 1.5**4) / 3) < 2 / found[0], f"minutes without and with the finer grid: {found}: {done}")


def forces(folder):
    """The numbers of all flights in a cache, by name."""
    return {path.parent.name: path.read_text() for path in sorted(folder.glob("*/forces.t"))}


def flies(text):
    """How many flights the program says that it simulates."""
    return sum(line.startswith("flight    ") for line in text.splitlines())


def test_cache(case):
    """What was flown is not flown again, what did not end is; groups, ranks and their number change nothing."""
    few = "effects = pitch_lead, balance_gain\nrefine = no\nrounds = 1\n"
    write_data(case.folder / "data.h5", flown(8, "kinematics_lead = 0.04 0 0\n"), 4)  # three more with what is found
    code, _, text = diagnose(case, "data.h5", "plan", few, flags=("--plan",), cache="mine")
    check(code == 0 and "3 are still to be simulated" in text, f"a plan tells what flights there are: {text}")
    check(not (case.folder / "mine").exists(), "a plan flies nothing")
    _, _, text = diagnose(case, "data.h5", "one", few + "ranks = 1\n", ranks=2, cache="mine")
    check("3 are still to be simulated, 2 at a time on 1 ranks" in text, text)
    flights = forces(case.folder / "mine")
    check(len(flights) == 6, f"three flights, and three with what was found: {list(flights)}")
    _, _, text = diagnose(case, "data.h5", "one", few, flags=("--exit-code",), cache="mine")
    check("0 are still to be simulated" in text and not flies(text), f"nothing is flown again: {text}")
    first = (case.folder / "one.json").read_bytes()
    diagnose(case, "data.h5", "one", few, ranks=2, cache="mine")
    check((case.folder / "one.json").read_bytes() == first, "the same flights make the same diagnosis on two ranks, to the bit")
    again = case.folder / "mine" / sorted(flights)[0]
    (again / "ended").unlink()
    _, _, text = diagnose(case, "data.h5", "one", few, cache="mine")
    check(flies(text) == 1, f"what did not end is flown again: {text}")
    check((case.folder / "one.json").read_bytes() == first and forces(case.folder / "mine") == flights, "with the same numbers")
    diagnose(case, "data.h5", "one", few, ranks=2, cache="shared")
    shared = forces(case.folder / "shared")
    check(list(shared) == list(flights), "the name of a flight does not depend on ranks")
    for name, text in shared.items():
        for line, other in zip(text.splitlines(), flights[name].splitlines()):
            if not line.lstrip().startswith("%"):
                check(np.allclose(np.array(line.split(), float), np.array(other.split(), float), rtol=1e-7, atol=1e-9), f"{line} {other}")


def stopped_in_flight(case):
    """Starts a diagnosis, sends SIGTERM in its first flight, and returns how it ended. If the flight ended first, tries again."""
    for _ in range(20):
        case.start("parts.ini", "--exit-code")
        end = time.monotonic() + ALIVE
        while case.process.poll() is None and not list(case.folder.glob("parts-flights/*/forces.t")):
            check(time.monotonic() < end, f"a flight begins: {case.out.read_text()}")
            time.sleep(0.02)
        case.process.send_signal(signal.SIGTERM)  # nothing, if the program has ended
        done = case.wait()
        has_ended = bool(list(case.folder.glob("parts-flights/*/ended")))
        if done.code == EXIT_STOPPED and not has_ended:
            return done
        check(has_ended, f"nothing but the end of the flight prevents a stop: {done}")
        shutil.rmtree(case.folder / "parts-flights")
    raise AssertionError("never in time")


def test_stop(case):
    """A stop while a flight is flown has the exit code of a stop; called again, the program goes on and ends with the same flight."""
    few = "effects = balance_gain\nrefine = no\n"
    write_data(case.folder / "data.h5", flown(12), 6)
    diagnose(case, "data.h5", "whole", few, cache="whole-flights")
    write_input(case, "data.h5", "parts", few, cache="parts-flights")
    done = stopped_in_flight(case)
    check("Start the program again to continue" in done.err, f"stopped: {done}")
    _, _, text = diagnose(case, "data.h5", "parts", few, cache="parts-flights")
    check("1 are still to be simulated" in text, f"it goes on: {text}")
    check(forces(case.folder / "parts-flights") == forces(case.folder / "whole-flights"), "and ends with the same numbers")


def lock_of_this_process():
    """The text of a lock file that this process would write."""
    birth = Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19]
    return f"% locked\nhost = {socket.gethostname()}\nprocess = {os.getpid()}\nbirth = {birth}\nsince = now\n"


def test_shared(case):
    """Two diagnoses share the folder of flights. One waits while the other simulates a flight that both need, and takes it then: no
    file of the flight changes. Two at the same time simulate each flight once."""
    few = "effects = pitch_lead, balance_gain\nrefine = no\nrounds = 0\n"
    write_data(case.folder / "data.h5", flown(8, "kinematics_lead = 0.04 0 0\n"), 4)
    diagnose(case, "data.h5", "one", few, cache="ours")
    first = (case.folder / "one.json").read_bytes()
    folder = sorted((case.folder / "ours").iterdir())[0]
    ended = (folder / "ended").read_text()
    (folder / "ended").unlink()
    (folder / "flight.lock").write_text(lock_of_this_process())
    before = {path.name: (path.stat().st_mtime_ns, path.stat().st_ino) for path in folder.iterdir()}
    case.start("one.ini", "--exit-code")
    end = time.monotonic() + ALIVE
    while "waiting   " not in case.out.read_text():
        check(case.process.poll() is None and time.monotonic() < end, f"it waits: {case.out.read_text()}")
        time.sleep(0.02)
    (folder / "ended").write_text(ended)
    (folder / "flight.lock").unlink()
    done = case.wait()
    check(done.code in (NAMED, SET) and not flies(done.out), f"it takes the flight: {done}")
    check(f"process {os.getpid()} on {socket.gethostname()}" in done.out, f"it says for whom it waits: {done.out}")
    after = {path.name: (path.stat().st_mtime_ns, path.stat().st_ino) for path in folder.iterdir()}
    check({**after, "ended": 0} == {**{k: v for k, v in before.items() if k != "flight.lock"}, "ended": 0}, f"{before} {after}")
    check((case.folder / "one.json").read_bytes() == first, "with the same result")
    both = [case, case.sub("other")]
    shutil.copy(case.folder / "data.h5", both[1].folder)
    for one, cache in zip(both, ("both", "../both")):
        write_input(one, "data.h5", "one", few, cache)
        (one.folder / "case/hover.ini").touch()
        name = one.folder / "one.ini"
        name.write_text(name.read_text().replace("case/hover.ini", str(case.folder.resolve() / "case/hover.ini")))
        one.start("one.ini", "--exit-code")
    told = [one.wait() for one in both]
    check(all(done.code in (NAMED, SET) for done in told), f"{told}")
    check(sum(flies(done.out) for done in told) == 3, f"each flight once: {told}")
    check(len(forces(case.folder / "both")) == 3 and forces(case.folder / "both") == forces(case.folder / "ours"), "the same flights")


def test_refused(case):
    """Records that are not of the case, and a case that cannot be flown."""
    good = flown(12)
    write_data(case.folder / "data.h5", good, 5)
    code, _, text = diagnose(case, "data.h5", "wrong", "effects = pitch_lad\n")
    check(code == 2 and "there is no effect 'pitch_lad'; did you mean 'pitch_lead'?" in text, text)
    write_data(case.folder / "data.h5", good, 5, frequency=60.0)
    code, _, text = diagnose(case, "data.h5", "wrong")
    check(code == 2 and "attribute frequency is 60.0 Hz, but the wings of" in text and "beat with 50.0 Hz" in text, text)
    write_data(case.folder / "data.h5", good, 5, components="Fy, Fx, power")
    code, _, text = diagnose(case, "data.h5", "wrong")
    check(code == 2 and "component Fx does not exist for a section; valid: Fy, Fz, Mx, power" in text, text)
    write_data(case.folder / "data.h5", good, 5, components="Fy, Fz, Mx", units="N/m, N/m, N")
    (case.folder / "none.ini").write_text(f"[Wing]\nfile = {SOURCE}/wings/calliphora_small.h5\n[Measurement]\nfile = data.h5\n")
    done = case.flusi("none.ini")
    check(done.code == 2 and "[Flight] file: is missing: the measurement holds records of a flight in /flight" in done.err, done.err)
    write_case(case.folder / "case", 8, step=2.5)
    code, _, text = diagnose(case, "data.h5", "wild", "effects = balance_gain\nrefine = no\n", cache="wild-flights")
    check(code == 3 and "cannot be compared with the records: a flight failed" in text, text)
    code, _, text = diagnose(case, "data.h5", "wild", "effects = balance_gain\nrefine = no\n", cache="wild-flights")
    check(code == 3 and "0 are still to be simulated" in text, f"a flight that diverged has ended: {text}")


if __name__ == "__main__":
    shutil.rmtree("flights", ignore_errors=True)  # those of this program alone
    FLUSI = str(Path(sys.argv.pop(3)).resolve())
    main(globals())
