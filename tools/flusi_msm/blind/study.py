# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the cases of a study of msm_diagnose, each with its own random numbers: of bending, of vibration, of both on the same
wing, or of flights."""
from __future__ import annotations

import hashlib
import os
import pickle
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from flusi_msm.bending.statics import NoEquilibrium
from flusi_msm.blind import flight_study, joint, vibration
from flusi_msm.blind.cases import Individual, Options, fill_case, numbers
from flusi_msm.blind.ledger import digest, dump, read, write
from flusi_msm.blind.strata import Stratum
from flusi_msm.measurement.case import Case
from flusi_msm.measurement.file import write_test
from flusi_msm.results.files import InputError

PACKAGE = Path(__file__).resolve().parents[1]
INDIVIDUALS = 8
DRAWS = 10


def sources_digest(kind: str = "bending") -> str:
    """Returns a digest of the generator: of all files that decide about the bytes of a case."""
    folders = ("flow2d", "measurement") if kind == "flight" else ("bending", "measurement")
    files = [path for folder in folders for path in (PACKAGE / folder).glob("*.py")]
    files += [PACKAGE / "wing/file.py", *(PACKAGE / f"blind/{part}.py" for part in ("cases", "effects", "oracle", "strata", "study"))]
    if kind == "flight":
        files += PACKAGE.glob("blind/flight*.py")
    elif kind != "bending":
        files += PACKAGE.glob("blind/vibration*.py")
    if kind == "joint":
        files.append(PACKAGE / "blind/joint.py")
    return digest(b"".join(path.read_bytes() for path in sorted(files)))


class Study:
    """The measurements and sealed truths of a study in a folder."""

    def __init__(self, folder: Path, designs: Mapping[str, Any], seed: int, kind: str = "bending") -> None:
        """designs: {"small": design, "large": design}."""
        self.folder, self.designs, self.seed, self.kind = folder, designs, seed, kind
        self.latest: tuple[tuple[str, int], Any] | None = None

    def made(self, number: int) -> bool:
        """Returns whether a case exists."""
        return (self.folder / "sealed" / f"{number:04d}.json").exists()

    def measurement(self, number: int) -> Path:
        """Returns the path of a measurement."""
        return self.folder / "measured" / f"{number:04d}.h5"

    def stated(self, who: int) -> Path:
        """Returns the path of what is known about an individual that flies."""
        return self.folder / "individuals" / f"flight{who}.json"

    def truth(self, number: int) -> dict[str, Any]:
        """Returns the truth of a case, after its measurement has been checked."""
        sealed = read(self.folder / "sealed" / f"{number:04d}.json")
        if digest(self.measurement(number).read_bytes()) != sealed["measurement_sha256"]:
            raise InputError(f"{self.measurement(number)}: is not the measurement that was made")
        return sealed["truth"]

    def wants_oracle(self, truth: dict[str, Any]) -> bool:
        """Returns whether the gain of the true cause is to be computed."""
        return self.kind == "bending" and truth["kind"] == "single" and truth["snr"] >= 8

    def make(self, number: int, stratum: Stratum, before: int) -> None:
        """Makes a case unless it exists: the measurement first, then its truth, each completely or not at all."""
        if self.made(number):
            return
        begin = time.process_time()
        individual = self.individual(stratum.wing, self._whose(stratum, before))
        shared = time.process_time() - begin
        if self.kind in ("vibration", "flight"):
            draw_case = vibration.draw_case if self.kind == "vibration" else flight_study.draw_case
            write_case, truth = draw_case(self.seed, number, stratum, before, individual)
        else:
            content, truth = self._drawn(number, stratum, before, individual)
            write_case = partial(joint.write_joint if self.kind == "joint" else write_test, content=content)
        path = self.measurement(number)
        part = path.with_name(f"{path.name}.{os.getpid()}.part")
        part.unlink(missing_ok=True)
        write_case(part)
        os.replace(part, path)
        truth = {**truth, "stratum": stratum.name, "wing": stratum.wing, "cpu_seconds": time.process_time() - begin - shared,
                 "cpu_seconds_individual": shared}
        write(self.folder / "sealed" / f"{number:04d}.json",
              dump({"truth": truth, "measurement_sha256": hashlib.sha256(path.read_bytes()).hexdigest()}))

    def _whose(self, stratum: Stratum, before: int) -> int:
        """Returns the number of the individual of a case."""
        if self.kind == "vibration":
            return vibration.number_of(before)
        if self.kind == "flight":
            return flight_study.number_of(stratum, before)
        return 0 if stratum.wing == "large" else before // 4 % INDIVIDUALS

    def _drawn(self, number: int, stratum: Stratum, before: int, individual: Individual) -> tuple[dict[str, Any], dict[str, Any]]:
        """Returns content and truth; a case is drawn again if its wing snaps under the errors of its loads."""
        is_large = stratum.wing == "large"
        bounds = stratum.snr if stratum.kind == "single" else (0.0, float("inf"))
        for attempt in range(DRAWS):
            rng = numbers(self.seed, "study", number, *([attempt] if attempt else []))
            head = {"kind": stratum.kind, "mesh": "same" if is_large or before % 2 == 0 else "finer",
                    "rig": ("quiet", "busy")[before // 2 % 2], "individual": self._whose(stratum, before),
                    "errors": int(rng.integers(2**53))}
            try:
                return fill_case(rng, self.seed, number, head, individual, Options({}, stratum.snr), bounds)
            except NoEquilibrium:
                continue
        raise InputError(f"{DRAWS} wings in a row snap")

    def individual(self, wing: str, who: int) -> Any:
        """Returns the individual; a wing whose shapes are already known is read from its file."""
        if self.latest is not None and self.latest[0] == (wing, who):
            return self.latest[1]
        path = self.folder / "individuals" / f"{wing}{who}.pickle"
        if path.exists():
            individual = pickle.loads(path.read_bytes())
        else:
            individual = self._bent(wing, who)
            part = path.with_name(f"{path.name}.{os.getpid()}.part")
            part.write_bytes(pickle.dumps(individual))
            os.replace(part, path)
        self.latest = (wing, who), individual
        return individual

    def _bent(self, wing: str, who: int) -> Individual | vibration.Individual | flight_study.Individual:
        """Makes an individual, with the shapes from which its cases begin."""
        if self.kind == "flight":
            made = flight_study.Individual(self.designs[wing], self.seed, who)
            made.write_stated(self.stated(who))
            return made
        if self.kind == "vibration":
            return vibration.Individual(self.designs[wing], self.seed, who)
        if self.kind == "joint":
            return joint.JointIndividual(self.designs[wing], self.seed, who)
        return Individual(self.designs[wing], self.seed, who, ("same",) if wing == "large" else ("same", "finer"))


def designs_of(design: Case) -> dict[str, Case]:
    """Returns the design on its own wing, and on the wing with about a thousand points in the same folder."""
    large = Path(design.wing).with_name(Path(design.wing).name.replace("_small", ""))
    if large == Path(design.wing) or not large.exists():
        raise InputError(f"{design.wing}: the study needs NAME_small.h5 and NAME.h5 beside it")
    return {"small": design, "large": replace(design, wing=str(large))}
