# SPDX-License-Identifier: GPL-3.0-or-later
"""What tools/reproduce_paper can fly: the pairs on several grids with the individuals, the ensemble of stiffnesses, the scan of
the kinematics. Each study has a `name`, its `cases`, `lines`, True if each flight has a line in the plan, and `write_page`."""
from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Protocol

from flusi_msm.paper import ensemble, scan
from flusi_msm.paper.cases import Case, individual_cases, pair_cases

PAGE_INTERVAL = 300.0  # s between two pages of a study of many short flights


class Study(Protocol):
    """What every study has."""
    name: str
    lines: bool

    @property
    def cases(self) -> Sequence[Case]:
        """Returns all flights."""
        ...

    def write_page(self) -> Path:
        """Writes the page of what is finished; returns its path."""
        ...


class Comparison:
    """Rigid and flexible wings on several grids, and the individuals on one of them if `individual_grid` is given."""
    name, lines = "paper", True

    def __init__(self, folder: Path, ini: Path, grids: Iterable[int], beats: int, inis: Iterable[Path], individual_grid: int | None) \
            -> None:
        self.folder, self.pairs = folder, pair_cases(folder, ini, grids, beats)
        self.individuals = individual_cases(folder, inis, individual_grid, beats) if individual_grid else {}
        self.cases = list({case.name: case for case in [*self.pairs, *self.individuals.values()]}.values())

    def write_page(self) -> Path:
        """Writes the page; returns its path."""
        from flusi_msm.paper.page import write_page
        return write_page(self.folder, self.pairs, self.individuals)


class EnsembleStudy:
    """Flexible wings whose stiffness is drawn."""
    lines = False

    def __init__(self, folder: Path, ini: Path, grid: int, members: int, beats: int, joint_factor: float) -> None:
        self.folder, self.ensemble = folder, ensemble.Ensemble(folder, ini, grid, members, beats, joint_factor)
        self.name, self.cases = self.ensemble.name, self.ensemble.cases

    def write_page(self) -> Path:
        """Writes the page; returns its path."""
        from flusi_msm.paper.ensemble_page import write_page
        return write_page(self.folder, self.ensemble)


class ScanStudy:
    """A scan of the kinematics."""
    lines = False

    def __init__(self, folder: Path, ini: Path, grid: int, sizes: Sequence[int], steps: Sequence[float], beats: int) -> None:
        self.folder, self.scan = folder, scan.Scan(folder, ini, grid, sizes, steps, beats)
        self.name, self.cases = self.scan.name, self.scan.cases

    def write_page(self) -> Path:
        """Writes the page; returns its path."""
        from flusi_msm.paper.scan_page import write_page
        return write_page(self.folder, self.scan)


class Pages:
    """Writes the pages of studies, and says where they are when all are written."""

    def __init__(self, studies: Sequence[Study], clock: Callable[[], float] = time.monotonic) -> None:
        self.studies, self.clock, self.last = studies, clock, clock()

    def write_some(self) -> None:
        """After a flight: the comparison always, the others if the last time is some minutes ago."""
        due = self.clock() - self.last >= PAGE_INTERVAL
        for study in self.studies:
            if study.lines or due:
                study.write_page()
        if due:
            self.last = self.clock()

    def write_all(self) -> None:
        """Writes all pages and prints where they are."""
        for study in self.studies:
            print(study.write_page(), flush=True)
