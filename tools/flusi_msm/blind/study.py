# SPDX-License-Identifier: GPL-3.0-or-later
"""The cases of a study of msm_diagnose: kinds and visibilities in fixed proportions, so mixed that any first part of the
cases has them too, and each case with random numbers of its own."""
import hashlib
import os
import pickle
import time
from dataclasses import dataclass, replace
from pathlib import Path

from flusi_msm.bending.statics import NoEquilibrium
from flusi_msm.blind.cases import Individual, Options, fill_case, numbers
from flusi_msm.blind.ledger import digest, dump, read, write
from flusi_msm.measurement.file import write_test
from flusi_msm.results.files import InputError

PACKAGE = Path(__file__).resolve().parents[1]
INDIVIDUALS = 8
DRAWS = 10
WHOLE = (2.0, 30.0)  # signal-to-noise ratios


@dataclass(frozen=True)
class Stratum:
    name: str
    count: int      # in the whole study
    kind: str
    snr: tuple = WHOLE
    wing: str = "small"


STRATA = (Stratum("null", 250, "null"), Stratum("outside", 200, "outside"),
          *(Stratum(f"single {low} to {high}", 60, "single", (float(low), float(high)))
            for low, high in ((2, 5), (5, 8), (8, 12), (12, 20), (20, 30))),
          Stratum("large null", 4, "null", wing="large"), Stratum("large single", 4, "single", wing="large"),
          Stratum("large outside", 4, "outside", wing="large"))
WHOLE_STUDY = sum(stratum.count for stratum in STRATA)


def plan(count):
    """[(stratum, how many of it came before)] of the cases 1 to count: always the one that is most behind."""
    before, rows = [0] * len(STRATA), []
    for number in range(1, count + 1):
        behind = [number * stratum.count / WHOLE_STUDY - n for stratum, n in zip(STRATA, before)]
        k = behind.index(max(behind))
        rows.append((STRATA[k], before[k]))
        before[k] += 1
    return rows


def sources_digest():
    """Of the generator: all that decides about the bytes of a case."""
    files = [path for folder in ("bending", "measurement") for path in (PACKAGE / folder).glob("*.py")]
    files += [PACKAGE / "wing/file.py", *(PACKAGE / f"blind/{part}.py" for part in ("cases", "effects", "oracle", "study"))]
    return digest(b"".join(path.read_bytes() for path in sorted(files)))


class Study:
    """The measurements and sealed truths of a study in a folder."""

    def __init__(self, folder, designs, seed):
        """designs: {"small": design, "large": design}."""
        self.folder, self.designs, self.seed = folder, designs, seed
        self.latest = None, None

    def made(self, number):
        return (self.folder / "sealed" / f"{number:04d}.json").exists()

    def measurement(self, number):
        return self.folder / "measured" / f"{number:04d}.h5"

    def truth(self, number):
        sealed = read(self.folder / "sealed" / f"{number:04d}.json")
        if digest(self.measurement(number).read_bytes()) != sealed["measurement_sha256"]:
            raise InputError(f"{self.measurement(number)}: is not the measurement that was made")
        return sealed["truth"]

    def make(self, number, stratum, before):
        """Makes a case unless it is there: the measurement first, then its truth, each completely or not at all."""
        if self.made(number):
            return
        begin = time.process_time()
        is_large = stratum.wing == "large"
        individual = self.individual(stratum.wing, 0 if is_large else before // 4 % INDIVIDUALS)
        shared = time.process_time() - begin
        content, truth = self._drawn(number, stratum, before, individual)
        path = self.measurement(number)
        part = path.with_name(f"{path.name}.{os.getpid()}.part")
        write_test(part, content)
        os.replace(part, path)
        truth = {**truth, "stratum": stratum.name, "wing": stratum.wing, "cpu_seconds": time.process_time() - begin - shared,
                 "cpu_seconds_individual": shared}
        write(self.folder / "sealed" / f"{number:04d}.json",
              dump({"truth": truth, "measurement_sha256": hashlib.sha256(path.read_bytes()).hexdigest()}))

    def _drawn(self, number, stratum, before, individual):
        """Content and truth; a wing that snaps under the errors of its loads is drawn again."""
        is_large = stratum.wing == "large"
        bounds = stratum.snr if stratum.kind == "single" else (0.0, float("inf"))
        for attempt in range(DRAWS):
            rng = numbers(self.seed, "study", number, *([attempt] if attempt else []))
            head = {"kind": stratum.kind, "mesh": "same" if is_large or before % 2 == 0 else "finer",
                    "rig": ("quiet", "busy")[before // 2 % 2], "individual": 0 if is_large else before // 4 % INDIVIDUALS,
                    "errors": int(rng.integers(2**53))}
            try:
                return fill_case(rng, self.seed, number, head, individual, Options({}, stratum.snr), bounds)
            except NoEquilibrium:
                continue
        raise InputError(f"{DRAWS} wings in a row snap")

    def individual(self, wing, who):
        """A wing that has been bent before is read back."""
        if self.latest[0] == (wing, who):
            return self.latest[1]
        path = self.folder / "individuals" / f"{wing}{who}.pickle"
        if path.exists():
            individual = pickle.loads(path.read_bytes())
        else:
            individual = Individual(self.designs[wing], self.seed, who, ("same",) if wing == "large" else
                                    ("same", "finer"))
            part = path.with_name(f"{path.name}.{os.getpid()}.part")
            part.write_bytes(pickle.dumps(individual))
            os.replace(part, path)
        self.latest = (wing, who), individual
        return individual


def designs_of(design):
    """The design on its own wing, and on the one of about a thousand points beside it."""
    large = Path(design.wing).with_name(Path(design.wing).name.replace("_small", ""))
    if large == Path(design.wing) or not large.exists():
        raise InputError(f"{design.wing}: the study needs NAME_small.h5 and NAME.h5 beside it")
    return {"small": design, "large": replace(design, wing=str(large))}
