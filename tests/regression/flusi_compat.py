#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs as users of FLUSI have them: what they write runs, or is refused by the one reason that counts.

usage: flusi_compat.py <flusi> <h5dump> [tests]
"""
import math
import re

from whole_program import EXIT_USER, SOURCE, check, close, main, merged

INSECT = {
    "Resolution": {"nx": 32, "ny": 34, "nz": 22},
    "Geometry": {"xl": 4.0, "yl": 4.0, "zl": 3.0},
    "Time": {"Tmax": 0.06, "intelligent_dt": "yes", "iTimeMethodFluid": "RK2"},
    "ReynoldsNumber": {"nu": 1e-2},
    "InitialCondition": {"inicond": "MeanFlow"},
    "Penalization": {"iPenalization": 1, "iMoving": 1, "iMask": "Insect", "eps": 1.25e-2},
    "Insects": {"WingShape": f"from_file::{SOURCE}/ini/wings/calliphora.ini", "wing_length": 1.0, "WingThickness": 0.2,
                "FlappingMotion_left": "from_file", "FlappingMotion_right": "Drosophila_hovering_fry",
                "infile": "beat.ini", "x0": "2.0 2.0 4.5", "yawpitchroll_0": "180.0 0.0 0.0", "eta0": -70.0,
                "x_pivot_l": "0.0 0.5 0.0", "x_pivot_r": "0.0 -0.5 0.0", "itkine": ""},
    "MeanFlow": {"iMeanFlow_x": "fixed", "iMeanFlow_y": "fixed", "iMeanFlow_z": "fixed", "ux": 0.5, "uy": 0.0, "uz": 0.0},
    "Sponge": {"iVorticitySponge": "yes", "iSpongeType": "cavity", "eps_sponge": 0.1, "sponge_thickness": 16},
    "SaveSlices": {"nslice_cache": 200},
    "Saving": {"tsave": 0.02, "tintegral": 0.02, "iSaveVelocity": 1, "iSaveMask": 1, "iSaveSolidVelocity": 1,
               "field_precision": "double", "iDoBackup": 0},
}


def make(case, ini, ranks, *arguments, code=0):
    case.write("beat.ini", (SOURCE / "ini/kinematics/calliphora.ini").read_text())
    case.write("run.ini", ini)
    return case.run("run.ini", *arguments, ranks=ranks, code=code)


def test_notices(case):
    """What FLUSI runs is no mistake, but where it is doubtful it is told."""
    done = make(case, INSECT, 1, "--check")
    for text in (r"\[Resolution\] ny: is slow to transform: .* nearest good sizes: 32 and 36",
                 r"\[Resolution\] nz: is slow to transform: .* nearest good sizes: 20 and 24",
                 r"\[Sponge\] sponge_thickness: the sponge fills the box",
                 r"\[Insects\] x0: is outside of the box; .* image, at 2\.0 2\.0 1\.5",
                 r"wing_smoothing: is set to half the thickness"):
        check(re.search(text, done.out + done.err), f"a notice like {text}")


def test_runs(case):
    """An odd grid, a heap of FLUSI's words, wings that hang beside the box: the same flow on any number of ranks, to
    round-off, and a dry run that draws the same masks without a flow."""
    one, three, dry = case.sub("one"), case.sub("three"), case.sub("dry")
    make(one, INSECT, 1)
    make(three, INSECT, 3)
    make(dry, merged(INSECT, {"DryRun": {"dry_run_without_fluid": "yes"}}), 2)
    fields = [n for n in one.files() if re.match(r"(u|us|mask)[xyz]?_\d+\.h5", n)]
    check(len(fields) == 7 * 4, f"fields of four times: {fields}")
    for name in fields:
        close(one.field(name), three.field(name), 1e-12, name)
        if name.startswith("u") and not name.startswith("us"):
            check(name not in dry.files(), f"a dry run has no {name}")
        else:
            check(one.field(name) == dry.field(name), f"{name} of a dry run is that of the flow, to the bit")
    check(one.series("forces.t").rows and "summary.txt" not in dry.files(), "forces belong to a flow")
    dry.check_index("run.xmf")


def test_thin(case):
    """The same with wings without thickness, which only AB2 takes."""
    one, three = case.sub("one"), case.sub("three")
    ini = merged(INSECT, {"Time": {"iTimeMethodFluid": "AB2", "Tmax": 0.04}, "Insects": {"WingThickness": None}})
    make(one, ini, 1)
    make(three, ini, 3)
    check("slip.t" in one.files(), "the wings are thin")
    for c in "xyz":
        close(one.field(f"u{c}_000040.h5"), three.field(f"u{c}_000040.h5"), 1e-12, f"u{c}")


def test_image(case):
    """A body beside the box is the one that hangs inside."""
    inside, beside = case.sub("inside"), case.sub("beside")
    make(inside, merged(INSECT, {"Insects": {"x0": "2.0 2.0 1.5"}}), 2)
    make(beside, INSECT, 2)
    centre = case.sub("centre")
    make(centre, merged(INSECT, {"Insects": {"x0": None}}), 2)
    check(inside.field("ux_000060.h5") == centre.field("ux_000060.h5"), "without x0 it hangs in the centre, as in FLUSI")
    check(inside.field("ux_000060.h5") == beside.field("ux_000060.h5"), "the flow is the same")


def take_off():
    """A table of FLUSI: the angles of a beat, and a body that rises while its nose goes up."""
    rows = []
    for i in range(21):
        t, w = 0.01 * i, 2 * math.pi
        rows.append([t, 60 * math.cos(w * t), 40, 0, 30 + 100 * t, 2 * t ** 2, 3 * t, -60 * w * math.sin(w * t), 0, 0, 100, 4 * t, 3])
    return "1.0\n1.0\n21\n" + "\n".join(" ".join(f"{x:.12e}" for x in row) for row in rows) + "\n"


def test_take_off(case):
    """BodyMotion = takeoff with a table is the motion that the table has, and refused with FLUSI's legs."""
    keys = {"BodyMotion": "takeoff", "FlappingMotion_left": "takeoff", "FlappingMotion_right": "takeoff", "KineFromFile": "yes",
            "infile": None, "x0": None, "yawpitchroll_0": None, "eta_stroke": -20.0, "x_takeoff": 1.5, "z_takeoff": 1.25}
    old = merged(INSECT, {"Insects": keys, "Time": {"iTimeMethodFluid": "AB2_rigid_solid"}})
    table = "kinematics_loader::data_kin.dat"
    plain = merged(INSECT, {"Insects": {"BodyMotion": table, "FlappingMotion_left": table, "FlappingMotion_right": table, "infile": None,
                                        "x0": "1.5 2.0 1.25", "eta0": -20.0, "yawpitchroll_0": None},
                            "Time": {"iTimeMethodFluid": "AB2"}})
    runs = case.sub("old"), case.sub("plain")
    for run, ini in zip(runs, (old, plain)):
        (run.folder / "data_kin.dat").write_text(take_off())
        make(run, ini, 2)
    check(runs[0].field("ux_000060.h5") == runs[1].field("ux_000060.h5"), "the flow is the same")
    last = runs[0].series("kinematics.t").rows[-1]
    close(last[:6], [0.06, 1.5 + 0.18, 2, 1.25 + 0.0072, 0, -math.radians(36)], 1e-6, "it rises with its nose up")
    done = make(case.sub("legs"), merged(old, {"Insects": {"KineFromFile": "simplified_dynamic"}}), 1, "--check", code=EXIT_USER)
    mistakes = [line for line in done.err.splitlines() if line.startswith("run.ini:")]
    check(len(mistakes) == 1 and "legs that push off" in mistakes[0], f"legs are refused by one message: {done.err}")


def test_refused(case):
    """One reason, and what to give instead."""
    beam = merged(INSECT, {"Penalization": {"iMask": "Flexibility"}, "SolidModel": {"ns": 32},
                           "Time": {"iTimeMethodFluid": "FSI_AB2_iteration"}})
    for name, ini, text in (
            ("beam", beam, "iMask: 'Flexibility' is a value of FLUSI"),
            ("wing", merged(INSECT, {"Penalization": {"iMask": "Flexible_wing"}, "Flexible_wing": {
                "use_flexible_wing_model": "yes", "EIy": 1e-5}, "units": {"length": 0.01, "frequency": 100.0,
                                                                       "density": 1.2},
                "Insects": {"wing_length": None}}), r"[Wing] file: is missing"),
            ("channel", merged(beam, {"SolidModel": {"use_solid_model": "yes"}, "Penalization": {"iChannel": "turek"}}),
             "[SolidModel] use_solid_model: 'yes' asks for FLUSI's elastic beam"),
            ("mhd", merged({"MHD": {"eta": 0.1}}, merged(INSECT, {"InitialCondition": {"inicond": "orszagtang"}})),
             "[MHD]: asks for magnetohydrodynamics"),
            ("small", merged(INSECT, {"Geometry": {"xl": 0.1, "yl": 0.1, "zl": 0.1}, "Flexible_wing": {
                "t_wing": 0.01, "wing_smoothing": 0.016}, "Insects": {"BodyType": "drosophila", "WingThickness": None}}),
             "[Insects] BodyType: is larger than the box: it extends over 1."),
            ("far", merged(INSECT, {"Insects": {"x0": "2.0 2.0 18.0"}}), "[Insects] x0: is outside of the box")):
        mistakes = mistakes_of(case.sub(name), ini)
        check(len(mistakes) == 1 and text in mistakes[0], f"{name} has one mistake: {mistakes}")


def mistakes_of(case, ini):
    done = make(case, ini, 1, "--check", code=EXIT_USER)
    return [line for line in done.err.splitlines() if re.search(r": \[[\w-]+\]( \w+)?: ", line)
            and not line.startswith("notice")]


def test_mesh(case):
    """A file for one of FLUSI's meshes: what is missing and what is wrong is told at once, and not again in another way when the
    wing file is there."""
    ini = merged(INSECT, {"Time": {"iTimeMethodFluid": "FSI_AB2_staggered"}, "Penalization": {"iMask": "Flexible_wing"},
                          "Insects": {"wing_length": None, "infile": "gone.ini"},
                          "Flexible_wing": {"use_flexible_wing_model": "yes", "EIy": 1e-5, "load_distance": 1e-6}})
    common = "[units] length: is missing", "gone.ini", "[Flexible_wing] load_distance: lies inside"
    beam = {"Wing": {"file": f"{SOURCE}/wings/beam.h5"}, "Mass": {"membrane_law": "bilinear"}}
    for name, more, text in (("without", {}, "[Wing] file: is missing"),
                             ("with", beam, "[Mass] membrane_law: mass: the areal density")):
        mistakes = mistakes_of(case.sub(name), merged(ini, more))
        check(len(mistakes) == 4 and all(any(t in m for m in mistakes) for t in (text, *common)), f"{name} mesh: {mistakes}")


if __name__ == "__main__":
    main(globals())
