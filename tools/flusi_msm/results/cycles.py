# SPDX-License-Identifier: GPL-3.0-or-later
"""Divides lift, drag and power of a run with flapping wings into wing beats. Cycle n is n-1 <= t f <= n."""
from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from flusi_msm.results.files import InputError, Series, read_series

QUANTITIES = ("lift", "drag", "aerodynamic power", "inertial power")
PHASES = (np.arange(400) + 0.5) / 400
AXES = "xyz"


class CyclicSignal:
    """One quantity over time. `x` is t f, the number of the cycle and the phase in it."""

    def __init__(self, x: np.ndarray, values: np.ndarray) -> None:
        good = np.isfinite(x) & np.isfinite(values)
        self.x, self.values = x[good], values[good]

    def cycles(self) -> list[int]:
        """Returns numbers of the cycles that the record contains from end to end; at both ends one time step may be missing."""
        if len(self.x) < 2:
            return []
        gap = min(0.05, 1.5 * np.median(np.diff(self.x)))
        first, last = int(np.ceil(self.x[0] - gap)), int(np.floor(self.x[-1] + gap))
        return list(range(first + 1, last + 1))

    def cycle(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Returns (phase, value) of a cycle with its ends."""
        begin = number - 1
        inside = (self.x > begin) & (self.x < number)
        phase = np.concatenate([[0.0], self.x[inside] - begin, [1.0]])
        ends = np.interp([begin, number], self.x, self.values)
        return phase, np.concatenate([ends[:1], self.values[inside], ends[1:]])

    def at(self, number: int, phases: np.ndarray) -> np.ndarray:
        """Returns the values at phases of a cycle."""
        return np.interp(phases, *self.cycle(number))

    def mean(self, number: int) -> float:
        """Returns the time average over a cycle, by the trapezoidal rule on the record itself."""
        phase, value = self.cycle(number)
        return float(np.sum(np.diff(phase) * (value[1:] + value[:-1]) / 2))


class FlappingRun:
    """The series of a run folder. signals: {quantity: CyclicSignal}; scales: SI value of one unit of the run; down: True for
    each of PHASES in which the wing moves down, or None without kinematics.t."""

    def __init__(self, folder: str | Path, frequency: float = 1.0, wind: str = "x") -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise InputError(f"{folder}: not the folder of a run")
        self.frequency = frequency
        self.scales: dict[str, float] = {}
        self.signals = self._forces(wind)
        self.signals.update(self._power())
        self.phi = self._position()

    @property
    def name(self) -> str:
        """Returns the name of the folder."""
        return self.folder.resolve().name

    def _read(self, name: str) -> Series | None:
        path = self.folder / name
        if not path.is_file():
            return None
        series = read_series(path)
        for key, value in series.scales.items():
            self.scales.setdefault(key, value)
        return series

    def _signal(self, series: Series, values: np.ndarray) -> CyclicSignal:
        return CyclicSignal(series.time * self.frequency, values)

    def _forces(self, wind: str) -> dict[str, CyclicSignal]:
        series = self._read("forces.t")
        if series is None:
            have = ", ".join(sorted(path.name for path in self.folder.glob("*.t"))) or "no time series"
            raise InputError(f"{self.folder / 'forces.t'}: no such file; the folder has {have}")

        def force(c: str) -> np.ndarray:
            return series.column(f"F{c}", f"Force{c}") + series.column(f"F{c} unsteady", f"Force{c}_unst")
        sign = -1 if wind.startswith("-") else 1
        return {"lift": self._signal(series, force("z")), "drag": self._signal(series, sign * force(wind[-1]))}

    def _power(self) -> dict[str, CyclicSignal]:
        """Reads the power from aero_power.t or else the sum over the wings; nothing if neither exists."""
        total = self._read("aero_power.t")
        parts = [total] if total else [s for s in map(self._read, ("wing_left.t", "wing_right.t")) if s]
        found = {}
        for quantity, names in (("aerodynamic power", ("aerodynamic power", "aerodynamic_power")),
                                ("inertial power", ("inertial power", "inertial_power"))):
            signals = [self._signal(part, part.column(*names)) for part in parts]
            if signals:
                x = signals[0].x
                found[quantity] = CyclicSignal(x, sum(np.interp(x, s.x, s.values) for s in signals))
        return found

    def _position(self) -> CyclicSignal | None:
        series = self._read("kinematics.t")
        return self._signal(series, series.column("phi_l", "phi left")) if series else None

    def cycles(self) -> list[int]:
        """Returns numbers of the complete cycles that all quantities have."""
        common = set.intersection(*(set(signal.cycles()) for signal in self.signals.values()))
        if not common:
            signal = self.signals["lift"]
            raise InputError(f"{self.folder}: no complete cycle, the forces go from t f = {signal.x[0]:.4g} to "
                             f"{signal.x[-1]:.4g}; is --frequency right?")
        return sorted(common)

    def choose(self, wanted: str) -> list[int]:
        """Returns the cycles that 'last', 'all', '4', '3-4' or '1,3' mean."""
        have = self.cycles()
        if wanted == "all":
            return have
        if wanted == "last":
            return have[-1:]
        chosen: list[int] = []
        for part in wanted.split(","):
            match = re.fullmatch(r"\s*(\d+)\s*(?:-\s*(\d+)\s*)?", part)
            if not match:
                raise InputError(f"--cycles takes last, all, 4, 3-4 or 1,3, not '{wanted}'")
            chosen += range(int(match[1]), int(match[2] or match[1]) + 1)
        lacking = sorted(set(chosen) - set(have))
        if lacking or not chosen:
            raise InputError(f"{self.folder}: cycle {', '.join(map(str, lacking)) or wanted} is not complete; there is "
                             f"{', '.join(map(str, have))}")
        return sorted(set(chosen))

    def phase_average(self, quantity: str, cycles: list[int]) -> np.ndarray:
        """Returns the quantity at PHASES, averaged over the cycles."""
        return np.mean([self.signals[quantity].at(n, PHASES) for n in cycles], axis=0)

    def means(self, quantity: str, cycles: list[int]) -> tuple[float, float]:
        """Returns (average over the cycles, half the range of the averages of the single cycles). Values that are only rounding
        errors of the sum are set to zero."""
        signal = self.signals[quantity]
        each = np.array([signal.mean(n) for n in cycles])
        each[np.abs(each) < 1e-12 * np.max(np.abs(signal.values))] = 0.0
        return float(np.mean(each)), float(np.ptp(each)) / 2

    def downstroke(self, cycle: int) -> np.ndarray | None:
        """Returns True at each of PHASES where the position angle falls; None if it is not known in this cycle."""
        if self.phi is None or cycle not in self.phi.cycles():
            return None
        step = 0.5 / len(PHASES)
        before, after = (self.phi.at(cycle, PHASES + s) for s in (-step, step))
        return after < before

    def si_factor(self, quantity: str) -> tuple[float | None, str]:
        """Returns (factor, unit) from units of the run to mN or mW; (None, '') if its units are not known."""
        kind, unit = ("power", "mW") if "power" in quantity else ("force", "mN")
        scale = self.scales.get(kind)
        if scale is None and {"length", "frequency", "density"} <= set(self.scales):
            length, f, density = (self.scales[key] for key in ("length", "frequency", "density"))
            scale = density * length**(5 if kind == "power" else 4) * f**(3 if kind == "power" else 2)
        return (1e3 * scale, unit) if scale else (None, "")
