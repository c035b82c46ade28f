#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths of landmarks on wings, which [Saving] landmarks_left and landmarks_right ask for.

usage: flusi_landmarks.py <flusi> <h5dump> [tests]

The grid is far too coarse for physics; what is tested is that landmarks are where the wings are.
"""
import h5py
import numpy as np
from flight_case import FLIGHT
from whole_program import EXIT_USER, SOURCE, check, ini_text, main, merged

LENGTH = FLIGHT["units"]["length"]
with h5py.File(SOURCE / "wings/calliphora_small.h5") as wing_file:
    NODES = wing_file["points"][:, :2] / LENGTH
CHOSEN = [int(np.argmax(NODES[:, 0])), len(NODES) // 2]  # the tip, and one more
OTHER = NODES[CHOSEN].mean(axis=0)
LAST_DIGIT = 1e-8  # series hold nine digits, of numbers up to 4


def rows_of(sites):
    return "(/ " + "\n".join(f"{x!r} {y!r}" for x, y in np.asarray(sites).tolist()) + " /)"


def write(case, steps, **sections):
    saving = {"landmarks_left": rows_of([*NODES[CHOSEN], OTHER]), "landmarks_right": rows_of(NODES[CHOSEN[:1]]), "tintegral": 4e-3}
    ini = merged(FLIGHT, {"Time": {"nt": steps}, "Saving": saving})
    case.write("run.ini", ini_text(merged(ini, sections)))


def tracks(case, side):
    """Times, and places (n, landmarks, 3)."""
    rows = np.array(case.series(f"landmarks_{side}.t").rows)
    return rows[:, 0], rows[:, 1:].reshape(len(rows), -1, 3)


def test_bent_wing(case):
    """Landmarks at points of the mesh are where the saved surface has these points, on both wings, which have bent by much more than
    the last digit. One between them is on the same side of the body."""
    write(case, 13, Saving={"tsave": 0.02})
    case.run("run.ini")
    for side, n in ("left", 3), ("right", 1):
        time, places = tracks(case, side)
        check(places.shape[1] == n, f"{n} landmarks on the {side} wing: {places.shape}")
        surfaces = sorted(case.folder.glob(f"wing_{side}_*.h5"))
        compared = 0
        for path in surfaces:
            with h5py.File(path) as file:
                at, points, bent = float(np.ravel(file.attrs["time"])[0]), file["points"][:], file["displacement"][:]
            k = int(np.argmin(np.abs(time - at)))
            if abs(time[k] - at) > 1e-9:
                continue
            compared += 1
            for mark, node in enumerate(CHOSEN[:n]):
                apart = np.abs(places[k, mark] - points[node]).max()
                check(apart < LAST_DIGIT, f"{path.name}, landmark {mark + 1}: {apart} L apart")
            check(at < 0.01 or np.abs(bent).max() > 1e3 * LAST_DIGIT, f"the wing has bent by {np.abs(bent).max()} L")
        check(compared >= 2, f"surfaces are saved when landmarks are: {len(surfaces)}")
    header = case.series("landmarks_left.t").header[0]
    check("z of landmark 3 [L]" in header, header)


def test_restart(case):
    """4 steps, restart, 3 steps are 7 steps to the last digit."""
    whole, parts = case.sub("whole"), case.sub("parts")
    for run, steps in (whole, 7), (parts, 4):
        write(run, steps)
        run.run("run.ini")
    write(parts, 7)
    parts.run("run.ini", "--restart")
    for name in "landmarks_left.t", "landmarks_right.t":
        check(whole.series(name).lines == parts.series(name).lines, f"{name} is the same")
        check(len(whole.series(name).lines) == 8, f"{name} has a record of the start and of every step")


def test_mistakes(case):
    """Points that are not on the wing, and a wing that is not there."""
    write(case, 1, Saving={"landmarks_left": rows_of([OTHER, (1.3, 0.2)])})
    done = case.flusi("run.ini", "--check")
    check(done.code == EXIT_USER and "[Saving] landmarks_left: point 2 is not on the wing, which reaches from" in done.err, done.err)
    write(case, 1, Insects={"LeftWing": "no"})
    done = case.flusi("run.ini", "--check")
    check(done.code == EXIT_USER and "[Saving] landmarks_left: there is no left wing" in done.err, done.err)
    write(case, 1, Saving={"landmarks_left": "(/ 0.1 0.2 0.3 /)"})
    done = case.flusi("run.ini", "--check")
    check(done.code == EXIT_USER and "landmarks_left" in done.err and "2" in done.err, done.err)
    write(case, 1, Saving={"landmark_left": "(/ 0.1 0.2 /)"})
    done = case.flusi("run.ini", "--check")
    check(done.code == EXIT_USER and "landmarks_left" in done.err, done.err)


if __name__ == "__main__":
    main(globals())
