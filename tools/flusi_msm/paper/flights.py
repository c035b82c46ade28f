# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the flights of the comparison with Truong et al.: estimates how long they will take, makes them one after the other, and
continues those that were interrupted."""
from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from flusi_msm.paper.cases import INI, RIGID, Case
from flusi_msm.results.files import InputError, read_series
from flusi_msm.results.ini import with_values

PILOT_POINTS = 32  # of the flight that counts the time steps of a beat
STEPS_GROWTH = 0.1  # steps per beat and point go with this power of N: 3.3 on 32, 3.5 on 96, 4.2 on 288 points were counted
TIMED_STEPS = 8    # of every grid, to be timed
EXIT_STOPPED = 4
WHY = {2: "a mistake in its input", 3: "a numerical failure", EXIT_STOPPED: "it was stopped, with a backup"}


def in_hours(seconds: float) -> str:
    """Writes a time as '45 s', '12 min', '5 h 10 min'."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60:02d} min"


def mpi_environment() -> dict[str, str]:
    """Returns the environment of a run: one thread per rank, and ranks of two runs never bound to the same core. For root, which
    usually means a container, MPI must be told to run."""
    wanted = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
              "OMPI_MCA_hwloc_base_binding_policy": "none",
              # Open MPI 5 has other names for these two.
              "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe", "PRTE_MCA_hwloc_default_binding_policy": "none"}
    if os.geteuid() == 0:
        wanted |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                   "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
    return {**wanted, **os.environ}


class Flusi:
    """The program and how it is started."""

    def __init__(self, program: str | Path, ranks: int) -> None:
        self.program, self.ranks = Path(program).resolve(), ranks
        if not os.access(self.program, os.X_OK):
            raise InputError(f"{program}: no such program; 'tools/quickstart build' makes it, or name one with --flusi")
        first = subprocess.run([self.program, "--version"], capture_output=True, text=True, check=False,
                               env=mpi_environment()).stdout.splitlines()
        self.version = first[0].strip() if first else "of unknown version"

    def start(self, folder: Path, *options: str) -> subprocess.Popen[str]:
        """Starts a run in its own session: Ctrl-C does not reach it, so that it can write a backup when it is asked to stop."""
        command = [os.environ.get("MPIEXEC", "mpirun"), "-n", str(self.ranks), str(self.program), INI, *options]
        return subprocess.Popen(command, cwd=folder, env=mpi_environment(), stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, start_new_session=True)

    def run(self, folder: Path, text: str) -> None:
        """Makes a short run from its beginning to its end."""
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / INI).write_text(text, encoding="utf-8")
        process = self.start(folder)
        output = process.communicate()[0]
        if process.returncode:
            raise InputError(f"the run that is timed ended with exit code {process.returncode}, in {folder}:\n"
                             + "\n".join(output.splitlines()[-8:]))


# ---- how long it will take -------------------------------------------------------------------------

class Estimate:
    """Estimates the seconds of every flight: a few of its first steps are timed, and a beat of a small grid shows how many steps
    there are. All results are kept in `folder`/estimate.json and not measured again. Steps that a flight has already made have
    priority."""

    def __init__(self, flusi: Flusi, folder: str | Path, ini: str | Path) -> None:
        self.flusi, self.folder, self.ini = flusi, Path(folder), ini
        self.path = self.folder / "estimate.json"
        try:
            self.kept = json.loads(self.path.read_text(encoding="utf-8")) if self.path.is_file() else {}
        except ValueError:
            self.kept = {}

    def _measured(self, key: str, measure: Callable[[Path], float]) -> float:
        key = f"{key}, {self.flusi.ranks} ranks, {self.flusi.version}"
        if key not in self.kept:
            place = self.folder / "estimate"
            self.kept[key] = measure(place)
            shutil.rmtree(place, ignore_errors=True)
            self.path.write_text(json.dumps(self.kept, indent=1) + "\n", encoding="utf-8")
        return self.kept[key]

    def steps_per_beat_and_point(self, points: int = PILOT_POINTS) -> float:
        """Returns the number of steps of a beat over the number of points along x. The CFL number makes it nearly equal on all grids;
        fine ones resolve larger velocities at the edges of the wings. In the first half of the first beat the wings accelerate, and
        steps are longer."""
        def measure(place: Path) -> float:
            self.flusi.run(place, with_values(Case(self.folder, self.ini, RIGID, PILOT_POINTS, 1.5).text, {
                "Saving": {"tsave": 9e9, "iDoBackup": 0}}))
            return int(np.sum(read_series(place / "timesteps_info.t").time >= 0.5)) / PILOT_POINTS
        return self._measured("steps per beat and point", measure) * (points / PILOT_POINTS)**STEPS_GROWTH

    def steps(self, case: Case) -> float:
        """Returns the number of time steps of a flight."""
        return self.steps_per_beat_and_point(case.points) * case.points * case.beats * case.speed

    def seconds_per_step(self, case: Case) -> float:
        """Returns the seconds of one time step of a flight."""
        done = steps_of(case)
        if done is not None and done[0] > 2 * TIMED_STEPS:
            return done[1]

        def measure(place: Path) -> float:
            self.flusi.run(place, with_values(case.text, {"Time": {"nt": TIMED_STEPS},
                                                          "Saving": {"tsave": 9e9, "iDoBackup": 0}}))
            return float(np.median(read_series(place / "timesteps_info.t").data[2:, 1]))
        return self._measured(f"seconds per step, {case.kind}, {case.points} points", measure)

    def left(self, case: Case) -> float:
        """Returns the seconds that the flight will still take; 0 for a finished one."""
        if case.is_finished():
            return 0.0
        done = steps_of(case) if case.has_backup() else None
        return self.seconds_per_step(case) * max(self.steps(case) - (done[0] if done else 0), 0)


def steps_of(case: Case) -> tuple[int, float] | None:
    """Returns (steps made, seconds of one) of the flight in its folder, or None."""
    try:
        series = read_series(case.folder / "timesteps_info.t")
    except InputError:
        return None
    return len(series.time), float(np.median(series.data[:, 1]))


# ---- the flights -----------------------------------------------------------------------------------

def fly(flusi: Flusi, case: Case, tell: Callable[[str], None]) -> int:
    """Makes the flight or continues it. `tell` is called with flusi's lines about progress. Returns the exit code; 4 if it was
    stopped by Ctrl-C, with a backup. The note about the flight is the first file in its folder, so that a kill at any time leaves
    one that the same command continues or begins again."""
    restart = case.has_backup()
    if not restart:
        shutil.rmtree(case.folder, ignore_errors=True)  # of a flight that was stopped before its first backup
    case.folder.mkdir(parents=True, exist_ok=True)
    versions = case.state().get("versions", [])
    case.note(status="begun", versions=versions + [flusi.version] * (flusi.version not in versions))
    (case.folder / INI).write_text(case.text, encoding="utf-8")
    (case.folder / "STOP").unlink(missing_ok=True)
    begun = time.monotonic()
    process = flusi.start(case.folder, *(["--restart"] if restart else []))
    with open(case.folder / "run.log", "a", encoding="utf-8") as log:
        while True:
            try:
                for line in process.stdout or ():
                    log.write(line)
                    log.flush()
                    if line.startswith("step "):
                        tell(line.strip())
                code = process.wait()
                break
            except KeyboardInterrupt:
                (case.folder / "STOP").touch()
                tell("stops after this step, with a backup")
    seconds = case.state().get("seconds", 0.0) + time.monotonic() - begun
    case.note(status="finished" if code == 0 else "begun" if code == EXIT_STOPPED else "failed", exit_code=code,
              seconds=round(seconds, 1), ranks=flusi.ranks)
    return code


def progress_of(line: str) -> tuple[str, float, float] | tuple[str, None, None]:
    """Returns ('t 1.2, 30 %, 0.1 s a step', seconds of a step, part done) for a line of flusi's about progress; (line, None,
    None) for another one."""
    match = re.search(r"t\s+(\S+)\s.*s/step\s+(\S+)\s+(\S+) %", line)
    if not match:
        return line, None, None
    seconds, percent = float(match[2]), float(match[3])
    return f"t {float(match[1]):.3f}, {percent:g} %, {seconds:.3g} s a step", seconds, percent / 100


def fly_all(flusi: Flusi, cases: Sequence[Case], estimate: Estimate, after_each: Callable[[], None]) -> tuple[list[str], bool]:
    """Makes all flights that are not finished, in order. A flight that fails is reported, and the next ones are made. Returns
    the names of those that failed, and whether all have been stopped."""
    failed: list[str] = []
    for number, case in enumerate(cases, 1):
        head = f"{number} of {len(cases)}, {case.name}"
        if case.is_finished():
            print(f"{head}: is there", flush=True)
            continue
        later = sum(estimate.left(other) for other in cases[number:])
        print(f"{head}: {'goes on' if case.has_backup() else 'begins'}, about {in_hours(estimate.left(case))}", flush=True)

        def tell(line: str, head: str = head, later: float = later, steps: float = estimate.steps(case)) -> None:
            # flusi's own estimate of the remaining time is wrong while the wings accelerate and steps are long.
            text, seconds, part = progress_of(line)
            left = f", all done in about {in_hours(seconds * steps * (1 - part) + later)}" if seconds and part is not None else ""
            print(f"{head}: {text}{left}", flush=True)

        code = fly(flusi, case, tell)
        if code == EXIT_STOPPED:
            return failed, True
        if code:
            print(f"{head}: failed, {WHY.get(code, f'exit code {code}')}; see {case.folder}/run.log", flush=True)
            failed.append(case.name)
        else:
            print(f"{head}: done in {in_hours(case.state()['seconds'])}", flush=True)
        if number < len(cases):
            after_each()
    return failed, False
