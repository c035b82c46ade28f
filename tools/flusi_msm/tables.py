# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the output of the programs as tables and arrays: pandas for columns, xarray for arrays with axes. It needs pandas;
xarray only where it is used."""
from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from flusi_msm.diagnosis.versions import SCHEMA, upgraded
from flusi_msm.errors import InputError
from flusi_msm.results.files import Field, fields_in
from flusi_msm.results.files import read_series as read_columns
from flusi_msm.seal import check_seal

if TYPE_CHECKING:
    import pandas
    import xarray

Place = Union[str, os.PathLike]
UNIT = re.compile(r"(rho|rad|L|T)(?:\^(\d+))?")
POWERS: dict[str, tuple[str | None, int]] = {"L": ("length", 1), "rho": ("density", 1), "T": ("frequency", -1), "rad": (None, 0)}
SI = {"L": "m", "rho": "kg/m^3", "T": "s"}


def read_series(path: Place) -> "pandas.DataFrame":
    """Reads a time series (*.t) with one column for each quantity, indexed by time. `attrs['units']` has the unit of every
    column and of the index, `attrs['scales']` the units of the run in SI: length [m], frequency [1/s], density [kg/m^3]."""
    import pandas
    found = read_columns(Path(path))
    table = pandas.DataFrame(found.data[:, 1:], index=pandas.Index(found.time, name=found.names[0]), columns=found.names[1:])
    table.attrs.update(units=dict(zip(found.names, found.units)), scales=dict(found.scales), path=str(path))
    return table


def si_factor(unit: str, scales: dict[str, float]) -> float:
    """Returns the factor to SI of a number in a unit of L, T and rho; raises an InputError for other words."""
    above, _, below = unit.replace("(", "").replace(")", "").partition("/")
    factor = 1.0
    for text, sign in ((above, 1), (below, -1)):
        for word in text.split():
            if word in ("1", "-", "s", "W", "N", "kg", "m"):
                continue
            match = UNIT.fullmatch(word)
            if not match:
                raise InputError(f"the unit {unit!r} is not known")
            name, power = POWERS[match[1]]
            if name is not None:
                factor *= scales[name]**(sign * power * int(match[2] or 1))
    return factor


def to_si(table: "pandas.DataFrame") -> "pandas.DataFrame":
    """Returns the same series in SI units, if its file says what L, T and rho are (section [units] of the input)."""
    scales, units = table.attrs["scales"], table.attrs["units"]
    missing = [name for name in ("length", "frequency", "density") if name not in scales]
    if missing:
        raise InputError(f"{table.attrs['path']}: does not say what {', '.join(missing)} are in SI: give [units] in the input")
    factors = [si_factor(units[name], scales) for name in table.columns]
    made = table * factors
    made.index = table.index * si_factor(units[table.index.name], scales)
    made.attrs.update(table.attrs, units={name: si_name(unit) for name, unit in units.items()})
    return made


def si_name(unit: str) -> str:
    """Returns the SI unit of a unit of L, T and rho."""
    known = {"rho L^4/T^2": "N", "rho L^5/T^2": "N m", "rho L^5/T^3": "W", "L": "m", "T": "s", "L/T": "m/s", "1/T": "1/s", "L/T^2": "m/s^2",
             "rad/T": "rad/s", "rad/T^2": "rad/s^2"}
    if unit in known:
        return known[unit]
    return re.sub(r"\b(rho|L|T)\b", lambda match: SI[match[1]], unit)


def stroke_average(table: "pandas.DataFrame", period: float = 1.0, first: int | None = None) -> "pandas.DataFrame":
    """Returns means over whole beats, one row for each, by the trapezoidal rule between the rows, with interpolated ends.
    `period` is in the unit of the index; `first` leaves earlier beats out (the start of a flow). Raises an InputError if there
    is no whole beat."""
    import pandas
    time = table.index.to_numpy()
    slack = 1e-9 * period
    beats = range(max(int(np.ceil((time[0] - slack) / period)), first or 0), int(np.floor((time[-1] + slack) / period)))
    if not len(beats):
        raise InputError(f"the series runs from {time[0]:.6g} to {time[-1]:.6g}: no whole beat of {period:.6g}"
                         + (f" from number {first} on" if first else ""))
    rows = []
    for beat in beats:
        ends = np.array([beat, beat + 1]) * period
        t = np.concatenate([ends[:1], time[(time > ends[0] + slack) & (time < ends[1] - slack)], ends[1:]])
        values = np.stack([np.interp(t, time, column) for column in table.to_numpy().T])
        rows.append((np.diff(t) * (values[:, 1:] + values[:, :-1]) / 2).sum(1) / period)
    made = pandas.DataFrame(rows, index=pandas.Index(beats, name="beat"), columns=table.columns)
    made.attrs.update(table.attrs)
    return made


def read_field(path: Place) -> "xarray.DataArray":
    """Reads a field file (ux_000500.h5) with the axes z, y, x."""
    import xarray
    found = Field(Path(path))
    axes = {name: found.origin[k] + found.spacing[k] * np.arange(found.n[k]) for k, name in enumerate("xyz")}
    return xarray.DataArray(found.data[...], dims=("z", "y", "x"), coords=axes, name=found.name,
                            attrs={"time": found.time, "viscosity": found.viscosity, "path": str(path)})


def list_fields(folder: Place, *names: str) -> dict[str, list[Path]]:
    """Returns {quantity: its files in the order of their labels} of a folder, all or those of `names`."""
    found: dict[str, list[Path]] = {}
    for label, prefixes in sorted(fields_in(Path(folder)).items(), key=lambda one: int(one[0])):
        for prefix in sorted(prefixes):
            if not names or prefix in names:
                found.setdefault(prefix, []).append(Path(folder, f"{prefix}_{label}.h5"))
    return found


@dataclass
class Measurement:
    """A measurement file (docs/formats/measurement-format.md) in SI units. Heights are (ny, nx), NaN where missing."""
    path: Path
    x: np.ndarray
    y: np.ndarray
    reference: np.ndarray | None                 # heights of the unloaded wing
    heights: dict[str, np.ndarray]                  # of the loads that have heights
    facts: dict[str, dict[str, Any]]                # attributes of the loads: force, direction, point, ...
    accuracy: dict[str, float] = field(default_factory=dict)
    calibration: dict[str, int] = field(default_factory=dict)
    title: str = ""

    def loads(self) -> "pandas.DataFrame":
        """Returns one row for each load: force [N], place [m], direction, and the largest change of a height [m]."""
        import pandas
        rows = {}
        for name, facts in self.facts.items():
            change = self.deformation(name) if name in self.heights and self.reference is not None else np.array([np.nan])
            known = np.abs(change[np.isfinite(change)])
            rows[name] = {"force": facts["force"], "x": facts["point"][0], "y": facts["point"][1],
                          **{f"direction_{a}": v for a, v in zip("xyz", facts["direction"])},
                          "largest": known.max() if known.size else np.nan}
        return pandas.DataFrame.from_dict(rows, orient="index")

    def deformation(self, name: str) -> np.ndarray:
        """Returns the heights of a load minus those of the unloaded wing (ny, nx) [m]."""
        if self.reference is None or name not in self.heights:
            raise InputError(f"{self.path}: {name} has no heights; loads are {', '.join(self.facts) or 'none'}")
        return self.heights[name] - self.reference


def read_measurement(path: Place) -> Measurement:
    """Reads a measurement file, without the checks of the programs."""
    import h5py

    def plain(value: Any) -> Any:
        value = np.asarray(value)
        if value.dtype.kind in "SO":
            return value.item().decode() if isinstance(value.item(), bytes) else str(value.item())
        return value.ravel()[0].item() if value.size == 1 else value

    try:
        check_seal(Path(path))
        with h5py.File(path, "r") as file:
            if plain(file.attrs.get("schema", "")) != "flusi-msm measurement":
                raise InputError(f"{path}: not a measurement file")
            def attributes(part: str) -> dict[str, Any]:
                return {key: plain(v) for key, v in file[part].attrs.items()} if part in file else {}

            groups = file.get("loads", {})
            lines = {name: file[f"reference/{name}"][:] if f"reference/{name}" in file else np.zeros(0) for name in "xy"}
            return Measurement(Path(path), lines["x"], lines["y"], file["reference/z"][:] if "reference/z" in file else None,
                               {name: group["z"][:] for name, group in groups.items() if "z" in group},
                               {name: {key: plain(v) for key, v in group.attrs.items()} for name, group in groups.items()},
                               attributes("accuracy"), attributes("calibration"), plain(file.attrs.get("title", "")))
    except (OSError, KeyError) as error:
        raise InputError(f"{path}: not a readable measurement file: {error}") from None


@dataclass
class Diagnosis:
    """The results of msm_diagnose; `data` is all of diagnosis.json, in the form of version 2 (docs/formats/diagnosis.schema.json)."""
    path: Path
    data: dict[str, Any]

    @property
    def verdict(self) -> str:
        """Returns the word of the verdict, such as adequate."""
        return self.data["verdict"]["word"]

    @property
    def sentence(self) -> str:
        """Returns the verdict in a sentence."""
        return self.data["verdict"]["sentence"]

    @property
    def statement(self) -> str:
        """Returns the verdict with sign, size, unit and interval of its causes."""
        return self.data["verdict"]["statement"]

    def parameters(self) -> "pandas.DataFrame":
        """Returns one row for each parameter of the baseline."""
        import pandas
        return pandas.DataFrame(self.data["baseline"]["parameters"]).set_index("name")

    def causes(self) -> "pandas.DataFrame":
        """Returns one row for each possible cause, the most probable first."""
        import pandas
        table = pandas.DataFrame(self.data["effects"]).set_index("name")
        return table.sort_values("posterior", ascending=False, na_position="last") if "posterior" in table else table


def read_diagnosis(path: Place) -> Diagnosis:
    """Reads diagnosis.json."""
    try:
        data = json.loads(Path(path).read_text())
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: not JSON: {error}") from None
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise InputError(f"{path}: not the diagnosis.json of msm_diagnose")
    return Diagnosis(Path(path), upgraded(data, path))
