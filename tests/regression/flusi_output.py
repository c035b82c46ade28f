#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields, slices, their index and the series of whole runs.

usage: flusi_output.py <flusi> <h5dump> [tests]
"""
import math
import os
import re
import shutil
import signal

from whole_program import ALIVE, EXIT_USER, check, close, main, ring, sphere

ALL_FIELDS = {"iSaveVelocity": "yes", "iSaveVorticity": "yes", "iSavePress": "yes", "iSaveMask": "yes",
              "iSaveMagVorticity": "yes", "iSaveSolidVelocity": "yes", "iSaveQ": "yes", "iSaveSpectrae": "yes"}
PREFIXES = ["ux", "uy", "uz", "vorx", "vory", "vorz", "vorabs", "p", "mask", "usx", "usy", "usz", "Q"]
SINGLE = 6e-8  # half a unit in the last place of single precision, relative
SERIES = 1e-8  # series have nine digits


def fields_of(case, prefix):
    """Files of a prefix, in the order of their names."""
    return [n for n in case.files() if re.fullmatch(rf"{prefix}_\d+\.h5", n)]


def times_of(case, prefix):
    return [case.attribute(n, "time")[0] for n in fields_of(case, prefix)]


def test_precision_and_attributes(case):
    """Every field is there, with FLUSI's attributes; single precision is double precision rounded."""
    runs = {}
    for precision, width in (("single", 4), ("double", 8)):
        part = runs[precision] = case.sub(precision)
        part.write("run.ini", sphere(Saving={**ALL_FIELDS, "field_precision": precision, "tsave": 0.12}))
        part.run("run.ini", ranks=2)
        part.check_index("run.xmf")
        for prefix in PREFIXES:
            names = fields_of(part, prefix)
            check(len(names) >= 3, f"{prefix} is saved several times: {names}")
            check(len(part.raw(names[-1], prefix)) == width * 16**3, f"{prefix} has {width} bytes per number")
            for which, value in (("viscosity", [1e-2]), ("epsi", [5e-3]), ("domain_size", [2.5] * 3),
                                 ("origin", [0.0] * 3), ("nxyz", [16.0] * 3)):
                check(part.attribute(names[-1], which) == value, f"{which} of {names[-1]} is {value}")
    one, two = runs["single"], runs["double"]
    check(one.files() == two.files(), "the same files")
    for prefix in PREFIXES:
        name = fields_of(one, prefix)[-1]
        x, y = one.field(name), two.field(name)
        check(all(abs(a - b) <= SINGLE * abs(b) + 1e-45 for a, b in zip(x, y)), f"{name} is the same but for rounding")
        check(one.attribute(name, "time") == two.attribute(name, "time"), f"{name} has the same time")
    # Fields are consistent with each other and with the series.
    name = {p: fields_of(two, p)[-1] for p in PREFIXES}
    vorticity = [two.field(name[p]) for p in ("vorx", "vory", "vorz")]
    magnitude = [math.sqrt(x * x + y * y + z * z) for x, y, z in zip(*vorticity)]
    close(magnitude, two.field(name["vorabs"]), 1e-15, "vorabs")
    volume = 2.5**3
    u = [two.field(name[p]) for p in ("ux", "uy", "uz")]
    energy = 0.5 * volume * sum(sum(v * v for v in c) for c in u) / 16**3
    last = two.series("energy.t").rows[-1]
    check(abs(last[0] - two.attribute(name["ux"], "time")[0]) <= SERIES * last[0], "the last fields are of the end")
    check(abs(energy - last[9]) <= SERIES * energy, f"the energy of the saved field is that of energy.t: {energy}")
    spectra = {which: two.series(f"spectrum_{which}.t").rows for which in ("tot", "x", "y", "z")}
    for row, wanted in zip(spectra["tot"], two.series("energy.t").rows):
        check(row[0] == wanted[0] and abs(volume * sum(row[1:]) - wanted[9]) <= 3 * SERIES * wanted[9],
              f"the spectrum at {row[0]} has the energy of the flow")
    check(len(spectra["tot"]) == len(two.series("energy.t").rows), "spectra come with the other integrals")
    parts = [sum(values) for values in zip(*(spectra[which][-1][1:] for which in "xyz"))]
    close(parts, spectra["tot"][-1][1:], SERIES, "the components of the spectrum add up")
    waves = [2 * math.pi / 2.5 * i for i in range(len(parts))]
    close([float(word) for word in (two.folder / "spectrum_k.t").read_text().splitlines()[1].split()], waves, SERIES,
          "wavenumbers of the shells")
    # Q averages to zero in a periodic box, and is (|vorticity|^2 - 2 S_ij S_ij)/4.
    q = two.field(name["Q"])
    check(abs(sum(q)) < 1e-10 * sum(abs(value) for value in q) and max(q) > 0.1, "Q averages to zero")
    mask = two.field(name["mask"])
    check(min(mask) >= 0 and max(mask) == 1, "the mask is between 0 and 1")
    total = two.series("mask_volume.t").rows[-1][1]
    check(abs(volume * sum(mask) / 16**3 - total) <= SERIES * total, "its integral is that of mask_volume.t")


def test_striding(case):
    """Every second point of the same field."""
    for stride in (1, 2):
        part = case.sub(f"stride_{stride}")
        part.write("run.ini", sphere(Resolution={"ny": 12, "nz": 20}, Geometry={"yl": 1.875, "zl": 3.125},
                                     Saving={**ALL_FIELDS, "striding": stride, "tsave": 0.12}))
        part.run("run.ini", ranks=3)
        part.check_index("run.xmf")
    whole, part = case.folder / "stride_1", case.folder / "stride_2"
    names = [n for n in os.listdir(part) if n.endswith(".h5") and not n.startswith("runtime")]
    check(len(names) >= 36, "many files")
    for name in (max(n for n in names if n.startswith(p + "_")) for p in PREFIXES):
        fine = case_field(case, "stride_1", name)
        picked = tuple(fine[x + 16 * (y + 12 * z)] for z in range(0, 20, 2) for y in range(0, 12, 2)
                       for x in range(0, 16, 2))
        check(picked == case_field(case, "stride_2", name), f"{name} holds every second point")
    check(whole != part, "two folders")
    case.write("run.ini", sphere(Resolution={"nx": 18}, Saving={"striding": 4}))
    done = case.run("--check", "run.ini", ranks=0, code=EXIT_USER)
    check("[Saving] striding: must divide nx, ny and nz" in done.err, f"a stride that does not divide:\n{done.err}")


def case_field(case, folder, name):
    return case.field(f"{folder}/{name}")


def test_names(case):
    """Numbers in file names: thousandths of time, finer if needed, or the step."""
    for naming, saving in (("time", {}), ("step", {"naming": "step"}), ("micro", {"tsave": 5e-4})):
        part = case.sub(naming)
        part.write("run.ini", sphere(Time={"nt": None, "Tmax": 0.0035 if naming == "micro" else 0.121,
                                           "dt_fixed": 2.5e-4 if naming == "micro" else 0.004}, Saving=saving))
        part.run("run.ini", ranks=2)
        part.check_index("run.xmf")
        rows = {round(r[0], 9): int(r[2]) - 1 for r in part.series("timesteps_info.t").rows}
        rows[0.0035 if naming == "micro" else 0.121] = len(rows)
        for name in fields_of(part, "ux"):
            label, now = name[3:-3], part.attribute(name, "time")[0]
            expected = {"time": f"{round(1000 * now):06d}", "step": f"{rows[round(now, 9)]:06d}",
                        "micro": f"{round(1e6 * now):09d}"}[naming]
            check(label == expected, f"{name} belongs to t = {now}: {expected}")
        check(len(fields_of(part, "ux")) == (8 if naming == "micro" else 4), f"{naming}: {fields_of(part, 'ux')}")


def test_output_times(case):
    """Without intelligent_dt output comes with the first step at or after its time, and at the end; the step
    is only clipped at the end."""
    case.write("run.ini", ring(Time={"nt": None, "Tmax": 0.2}, Saving={"tsave": 0.06, "tsave_first": 0.05}))
    case.run("run.ini", ranks=2)
    case.check_index("run.xmf")
    times = [r[0] for r in case.series("dt.t").rows] + [0.2]
    expected = [min(t for t in times if t >= k * 0.06 - 1e-9) for k in (1, 2, 3)] + [0.2]
    close(times_of(case, "ux"), expected, SERIES, "the times of the fields")
    steps = [r[1] for r in case.series("dt.t").rows]
    check(all(abs(dt - float(f"{dt:.1e}")) < 1e-12 for dt in steps[:-1]),
          "steps have two digits, so none but the last was clipped")
    check(abs(times[-2] + steps[-1] - 0.2) < 1e-8, "the last step ends at Tmax")


def test_intelligent_dt(case):
    """Output times are hit to round-off. AB2 extrapolates over the ratio of two steps: no step is more than
    twice the one before, whatever the intervals; with commensurate intervals none is less than half of it."""
    for name, saving, slices in (("fields", {"tsave": 0.05, "tintegral": 0.01}, {}),
                                 ("odd", {"tsave": 0.037, "tintegral": 0.01}, {}),
                                 ("close", {"tsave": 0.0501, "tintegral": 0.01}, {}),
                                 ("slices", {"tsave": 0.04, "tintegral": 0.02},
                                  {"use_slicing": "yes", "slice1": 5, "tslice": 0.016})):
        part = case.sub(name)
        part.write("run.ini", ring(Time={"nt": None, "Tmax": 0.2, "intelligent_dt": "yes"}, Saving=saving,
                                   SaveSlices=slices))
        part.run("run.ini", ranks=2)
        part.check_index("run.xmf")
        interval = saving["tsave"]
        times = times_of(part, "ux")
        expected = [k * interval for k in range(int(0.2 / interval + 1e-9) + 1)]
        if abs(expected[-1] - 0.2) > 1e-9:
            expected.append(0.2)
        check(len(times) == len(expected), f"{name}: {times} are {expected}")
        check(all(abs(a - b) <= 1e-12 for a, b in zip(times, expected)), f"{name}: {times} are {expected}")
        integrals = [r[0] for r in part.series("energy.t").rows]
        wanted = sorted({round(k * saving["tintegral"], 9) for k in range(int(0.2 / saving["tintegral"] + 1e-9) + 1)})
        check(all(min(abs(t - w) for t in integrals) < 1e-9 for w in wanted), f"{name}: integrals at {integrals}")
        if slices:
            got = sorted(part.attribute(n, "time")[0] for n in part.files() if n.startswith("sliceu1"))
            check(all(min(abs(t - k * 0.016) for t in got) <= 1e-12 for k in range(13)), f"slices at {got}")
        steps = [r[1] for r in part.series("dt.t").rows]
        growth = [b / a for a, b in zip(steps, steps[1:])]
        check(max(growth) <= 2.0 * (1 + 1e-6), f"{name}: steps grow by a factor {max(growth):.3g}")
        check(name != "fields" or min(growth) >= 0.5 * (1 - 1e-6), f"{name}: steps shrink by {min(growth):.3g}")


def test_slices(case):
    """Slices are planes of the fields."""
    case.write("run.ini", sphere(Time={"dt_fixed": 0.004, "nt": 25}, Saving={"tsave": 0.04},
                                 SaveSlices={"use_slicing": "yes", "slice1": 0, "slice2": 7, "slice4": 15,
                                             "tslice": 0.02, "tslice_first": 0.03}))
    case.run("run.ini", ranks=4)
    names = [n for n in case.files() if n.startswith("slice")]
    check(len(names) == 3 * 3 * 4, f"3 components of 3 planes at t = 0.04 0.06 0.08 0.1: {names}")
    for component, prefix in enumerate(("ux", "uy", "uz"), 1):
        for plane in (0, 7, 15):
            data = case.field(f"sliceu{component}-ix{plane:04d}_000040.h5")
            field = case.field(f"{prefix}_000040.h5")
            check(data == field[plane::16], f"plane {plane} of {prefix}")
    case.write("wrong.ini", sphere(SaveSlices={"use_slicing": "yes", "slice1": 16}))
    done = case.run("--check", "wrong.ini", ranks=0, code=EXIT_USER)
    check("[SaveSlices] slice1: there is no such plane" in done.err, f"a plane outside:\n{done.err}")


def test_stacked_slices(case):
    """With ncache_slices the planes of several times are one file, as FLUSI writes them; the last one is shorter. A backup
    ends a file, and a restart begins the next one."""
    slices = {"use_slicing": "yes", "slice1": 3, "slice3": 15, "itslice": 2}
    one, stacked, parts = case.sub("one"), case.sub("stacked"), case.sub("parts")
    for folder, steps, most in ((one, 18, 1), (stacked, 18, 4), (parts, 11, 4), (parts, 18, 4)):
        folder.write("run.ini", sphere(Time={"dt_fixed": 0.004, "nt": steps}, Saving={"naming": "step"},
                                       SaveSlices={**slices, "ncache_slices": most}))
        folder.run("run.ini", *(("--restart",) if folder is parts and steps == 18 else ()), ranks=3)
    for folder, sizes in ((stacked, (4, 4, 2)), (parts, (4, 2, 4))):
        names = [n for n in folder.files() if n.startswith("slice") and n.endswith(".h5")]
        check(len(names) == 3 * 2 * len(sizes), f"3 components of 2 planes in {len(sizes)} files each: {names}")
        check([int(row[1]) for row in folder.series("slice_times.t").rows] ==
              [number for number, size in enumerate(sizes) for _ in range(size)], "slice_times.t tells the file")
        for plane in (3, 15):
            step = 0
            for number, size in enumerate(sizes):
                stack = folder.field(f"sliceu2-ix{plane:04d}_{number:06d}.h5")
                check(folder.attribute(f"sliceu2-ix{plane:04d}_{number:06d}.h5", "nxyz") == [size, 16, 16], "its size")
                for i in range(size):
                    check(stack[i::size] == one.field(f"sliceu2-ix{plane:04d}_{step:06d}.h5"), f"plane of step {step}")
                    step += 2


def test_two_dimensions(case):
    """nx = 1: all fields, with a sponge and a cylinder, on 1 and 3 ranks."""
    ini = sphere(Resolution={"nx": 1, "ny": 24, "nz": 24}, Penalization={"iMask": "cylinder"},
                 MeanFlow={"ux": 0.0, "uy": 1.0}, Saving=ALL_FIELDS,
                 Sponge={"iVorticitySponge": "yes", "iSpongeType": "2D_frame", "eps_sponge": 0.05,
                         "sponge_thickness": 3})
    ini["Saving"]["tsave"] = 0.12
    for ranks in (1, 3):
        part = case.sub(f"ranks_{ranks}")
        part.write("run.ini", ini)
        part.run("run.ini", ranks=ranks)
        part.check_index("run.xmf")
    for prefix in PREFIXES:
        name = fields_of(part, prefix)[-1]
        one, two = case.field(f"ranks_1/{name}"), case.field(f"ranks_3/{name}")
        check(len(one) == 24 * 24, f"{name} is a plane")
        close(one, two, 2e-7, name)  # neighbours in single precision
    forces = case.sub("ranks_1_again")
    forces.write("run.ini", ini)
    forces.run("run.ini")
    check(any(abs(r[2]) > 1e-3 for r in forces.series("forces.t").rows), "the cylinder feels the flow")


def test_one_period(case):
    """save_only_one_period: the fields of a period replace those of the one before, in the index too."""
    case.write("run.ini", ring(Time={"nt": None, "Tmax": 0.27, "dt_fixed": 0.01},
                                 Saving={"tsave": 0.02, "save_only_one_period": "yes", "tsave_period": 0.1}))
    case.run("run.ini", ranks=2)
    times = {n: case.attribute(n, "time")[0] for n in fields_of(case, "ux")}
    for name, now in times.items():
        check(abs(int(name[3:-3]) / 1000 - (now - 0.1 * int(now / 0.1 + 1e-9))) < 1e-6, f"{name} is of t = {now}")
        check(now > 0.17 - 1e-9, f"{name}, t = {now}, is of the last period")
    case.check_index("run.xmf")


def test_infile(case):
    """A saved velocity is an initial condition: the run starts at its time and saves it again at once, but for
    the round-off of making it solenoidal."""
    for precision, round_off in (("single", 2e-7), ("double", 1e-14)):
        first, second = case.sub(f"{precision}_1"), case.sub(f"{precision}_2")
        first.write("run.ini", ring(Saving={"field_precision": precision}))
        first.run("run.ini", ranks=2)
        last = fields_of(first, "ux")[-1][3:]
        for c in "xyz":
            shutil.copy(first.folder / f"u{c}_{last}", second.folder / f"start_{c}.h5")
        keys = {f"file_u{c}": f"start_{c}.h5" for c in "xyz"}
        second.write("run.ini", ring(InitialCondition={"inicond": "infile", **keys},
                                     Saving={"field_precision": precision}))
        second.run("run.ini", ranks=3)
        for c in "xyz":
            close(first.field(f"u{c}_{last}"), second.field(f"u{c}_{last}"), round_off, f"u{c} at the start")


def test_series(case):
    """Headers name every column; energies agree; records end in the right places."""
    case.write("run.ini", sphere(Time={"nt": None, "Tmax": 0.15}, Penalization={"unst_corrections": "yes"}))
    case.run("run.ini", ranks=2)
    columns = {
        "forces.t": ["time", "Fx", "Fy", "Fz", "Fx unsteady", "Fy unsteady", "Fz unsteady", "Mx", "My", "Mz",
                     "Mx unsteady", "My unsteady", "Mz unsteady"],
        "ekin.t": ["time", "kinetic energy"],
        "dt.t": ["time", "dt", "CFL", "dt*nu/dx^2", "dt/eps"],
        "meanflow.t": ["time", "mean ux", "mean uy", "mean uz"],
        "mask_volume.t": ["time", "int chi", "int chi usx", "int chi usy", "int chi usz"],
        "divu.t": ["time", "max |div u|", "max |div u|(1-chi)"],
    }
    columns["forces_part1.t"] = columns["forces.t"]
    for name in [n for n in case.files() if n.endswith(".t")]:
        series = case.series(name)
        check(len(series.header) == 1, f"{name} has one header line")
        titles = [t for t in re.split(r"  +", series.header[0].lstrip("% ")) if t]
        check(all(re.fullmatch(r".+ \[.+\]|step|ranks", t) for t in titles), f"{name} has units: {titles}")
        if name in columns:
            check([re.sub(r" \[.*", "", t) for t in titles] == columns[name], f"{name} has the columns {titles}")
        check(all(len(r) == len(titles) for r in series.rows), f"{name} has {len(titles)} columns everywhere")
        times = [r[0] for r in series.rows]
        check(times == sorted(set(times)) and times[0] == 0, f"the times of {name} grow from 0")
    ekin = {r[0]: r[1] for r in case.series("ekin.t").rows}
    energy = case.series("energy.t").rows
    common = [r for r in energy if r[0] in ekin]
    check(len(common) >= 15, f"many records are common: {len(common)}")
    for row in common:
        # Both are printed from one number.
        check(abs(row[9] - ekin[row[0]]) <= 1e-10 * row[9], f"ekin.t and energy.t agree at t = {row[0]}")
        check(abs(sum(row[10:13]) - row[9]) <= SERIES * row[9], "the energy is the sum over its components")
        check(row[1] <= row[9], "the energy of the fluid is not above that of the box")
    check(case.series("forces_part1.t").rows == case.series("forces.t").rows, "one body: its forces are all forces")
    check(abs(energy[-1][0] - 0.15) < 1e-9, "the last record is at Tmax")
    wanted = [0.01 * k for k in range(16)]
    every = [r[0] for r in case.series("ekin.t").rows] + [0.15]
    due = [min(t for t in every if t >= w - 1e-9) for w in wanted]
    check(due == [r[0] for r in energy], "records are where they are due")


def test_killed(case):
    """A run that is killed has left every record but the last step's: whole lines, whole fields."""
    case.write("run.ini", sphere(Time={"nt": 999999}, Saving={"tsave": 0.02, "iSavePress": "yes"},
                                 SaveSlices={"use_slicing": "yes", "slice1": 3, "itslice": 1}))
    case.start("run.ini")
    case.wait_for_steps(40)
    case.process.send_signal(signal.SIGKILL)
    case.process.wait(ALIVE)
    steps = {}
    for name in [n for n in case.files() if n.endswith(".t")]:
        text = (case.folder / name).read_text()
        check(text.endswith("\n"), f"{name} ends with a whole line")
        series = case.series(name)
        width = len(series.rows[0])
        check(all(len(r) == width for r in series.rows), f"{name} holds whole records")
        steps[name] = len(series.rows)
    check(steps["timesteps_info.t"] >= 40, f"nothing is lost: {steps}")
    check(abs(steps["ekin.t"] - steps["timesteps_info.t"]) <= 1, f"the series end with the same step: {steps}")
    case.check_index("run.xmf")
    now = case.series("ekin.t").rows[-1][0]
    due = int(now / 0.01 - 1e-9)  # the default of tintegral
    check(len(case.series("energy.t").rows) >= due, "the integrals are there up to the end")
    written = sorted((n for n in case.files() if n.endswith(".h5")), key=lambda n: (case.folder / n).stat().st_mtime_ns)
    for name in written[-10:]:
        check(len(case.field(name)) in (16**3, 16**2), f"{name} is whole")


def test_same_label(case):
    """Two saves whose times round to the same name: the index never points to a field of another time."""
    case.write("run.ini", ring(Time={"nt": None, "Tmax": 0.0503, "dt_fixed": 0.01}, Saving={"tsave": 0.05}))
    case.run("run.ini", ranks=2)
    case.check_index("run.xmf")
    check(abs(times_of(case, "ux")[-1] - 0.0503) < 1e-12, "the later one is kept")


main(globals())
