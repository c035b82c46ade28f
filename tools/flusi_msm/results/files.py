# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the output of the program: time series (*.t) and fields (<prefix>_<label>.h5)."""
from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from flusi_msm.errors import InputError

# ---- time series ---------------------------------------------------------------------------------

_XYZ = "xyz"
# Columns of files whose header does not name them one by one.
KNOWN_COLUMNS = {
    "forces": ["time"] + [f"{q}{c}{u}" for q in ("Force", "Moment") for u in ("", "_unst") for c in _XYZ],
    "ekin": ["time", "E_kin"],
    "dt": ["time", "dt", "CFL", "dt*nu/dx2", "dt/eps"],
    "timesteps_info": ["time", "seconds_per_step", "step", "dt", "ranks"],
    "divu": ["time", "divu_max_fluid", "divu_max"],
    "meanflow": ["time", "mean_ux", "mean_uy", "mean_uz"],
    "mask_volume": ["time", "volume", "momentum_x", "momentum_y", "momentum_z"],
    "energy": ["time"]
              + [f"{q}{c}_{part}" for part in ("fluid", "total") for q in ("E", "dissipation")
                 for c in ("", "x", "y", "z")]
              + [f"penal_power{c}" for c in ("", "_x", "_y", "_z")],
    "aero_power": ["time", "aerodynamic_power", "inertial_power"],
    "kinematics": ["time", "xc", "yc", "zc", "psi", "beta", "gamma", "eta"]
                  + [f"{angle}_{side}" for side in "lr" for angle in ("alpha", "phi", "theta")]
                  + [f"{q}_{side}{c}" for q in ("omega", "acceleration") for side in "lr" for c in _XYZ],
}


class Series:
    """A time series: one name, unit (or '') and column of data for each quantity; column 0 is time.
    scales: the units of the run in SI, {'length': 0.009, 'force': 2e-4, ...}, empty if the file has none."""

    def __init__(self, path: Path, names: list[str], units: list[str], data: np.ndarray, scales: dict[str, float] | None = None) -> None:
        self.path, self.names, self.units, self.data = Path(path), names, units, data
        self.scales = scales or {}

    @property
    def kind(self) -> str:
        """Returns the file name without the ending: forces, energy, ..."""
        return self.path.stem

    @property
    def time(self) -> np.ndarray:
        """Returns the times."""
        return self.data[:, 0]

    def index(self, name: str) -> int:
        """Returns the number of the column of that name; capitals do not matter if the name is still unique."""
        if name in self.names:
            return self.names.index(name)
        lower = [n.lower() for n in self.names]
        if lower.count(name.lower()) == 1:
            return lower.index(name.lower())
        near = difflib.get_close_matches(name, self.names, n=1, cutoff=0.5)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise InputError(f"{self.path}: no column '{name}'{hint}; it has {', '.join(self.names)}")

    def column(self, *names: str) -> np.ndarray:
        """Returns the data of the first of these names that the header has, else those in the place that one of them has in
        FLUSI's order of columns."""
        lower = [n.lower() for n in self.names]
        for name in names:
            if lower.count(name.lower()) == 1:
                return self.data[:, lower.index(name.lower())]
        known = KNOWN_COLUMNS.get(self.kind, [])
        for name in names:
            if name in known and len(known) == len(self.names):
                return self.data[:, known.index(name)]
        raise InputError(f"{self.path}: no column '{names[0]}'; it has {', '.join(self.names)}")


def _number(text: str) -> float:
    """Converts a number as Fortran writes it; 1.0-100 is 1.0E-100, stars (too wide) become NaN."""
    try:
        return float(text.replace("D", "E").replace("d", "e"))
    except ValueError:
        pass
    if re.fullmatch(r"\*+", text):
        return np.nan
    return float(re.sub(r"(?<=[0-9.])([+-]\d+)$", r"E\1", text))


def _header_names(header: str, kind: str, n_columns: int) -> tuple[list[str], list[str]]:
    """Returns names and units from the header line, in the first of several readings that fits."""
    found = re.findall(r"([^\s,\[]+)(?:\s*\[([^\]]*)\])?", header)
    wide = [word for word in re.split(r"\s{2,}|\t+", header.strip()) if word]
    known = KNOWN_COLUMNS.get(kind, [])
    if len(found) == n_columns:
        return [name for name, _ in found], [unit.strip().strip("-") for _, unit in found]
    if len(wide) == n_columns:
        parts = [re.fullmatch(r"(.*?)\s*\[([^\]]*)\]", word) for word in wide]
        if all(parts):
            matches = [part for part in parts if part]
            return [part[1] for part in matches], [part[2].strip().strip("-") for part in matches]
        names = wide
    elif len(known) == n_columns:
        names = known
    else:
        names = ["time"] + [f"column{i + 1}" for i in range(1, n_columns)]
    return list(names), [""] * n_columns


SCALES = {"L": "length", "1/T": "frequency", "rho": "density", "force": "force", "power": "power"}


def _scales(line: str) -> dict[str, float]:
    """Returns {'length': 0.009, 'force': 2e-4, ...} in SI of 'L = 9.0E-03 m, ..., force rho L^4/T^2 = 2.0E-04 N'."""
    scales = {}
    for item in line.split(","):
        match = re.fullmatch(r"\s*(\S+)[^=]*=\s*(\S+)\s+\S+\s*", item)
        if match and match[1] in SCALES:
            scales[SCALES[match[1]]] = _number(match[2])
    return scales


def _without_repeats(data: np.ndarray) -> np.ndarray:
    """Drops rows that a restart computed again: a row is kept if all later times are larger."""
    data = data[np.isfinite(data[:, 0])]
    if len(data) == 0:
        return data
    later = np.minimum.accumulate(data[::-1, 0])[::-1]
    keep = np.append(data[:-1, 0] < later[1:], True)
    return data[keep]


def read_series(path: str | Path) -> Series:
    """Reads a .t file. Where a restart began at an earlier time the later rows are kept."""
    path = Path(path)
    try:
        lines = path.read_text(errors="replace").splitlines()
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    header, n_bad = "", 0
    rows: list[list[float]] = []
    scales: dict[str, float] = {}
    for line in lines:
        text = line.strip()
        if re.match(r"%\s*units\s*:", text, re.IGNORECASE):
            scales = _scales(text.split(":", 1)[1])
        elif text.startswith("%"):
            header = header if rows else text.lstrip("% \t")  # the last one before the numbers
        elif text:
            try:
                rows.append([_number(word) for word in text.split()])
            except ValueError:
                n_bad += 1
    if not rows:
        raise InputError(f"{path}: no numbers in this file")
    n_columns = len(rows[0])
    whole = [row for row in rows if len(row) == n_columns]
    n_bad += len(rows) - len(whole)
    if n_columns < 2:
        raise InputError(f"{path}: one column only; a time series has the time and at least one quantity")
    if n_bad:
        print(f"note: {path}: {n_bad} damaged line(s) left out", file=sys.stderr)
    names, units = _header_names(header, path.stem, n_columns)
    return Series(path, names, units, _without_repeats(np.array(whole)), scales)


# ---- fields --------------------------------------------------------------------------------------

_FIELD_FILE = re.compile(r"(?P<prefix>[A-Za-z][A-Za-z0-9]*)_(?P<label>\d+)\.h5")
_SURFACES = ("body", "solid", "static")  # files with such names that hold no field


class Snapshot(NamedTuple):
    """The fields of one time in a folder."""
    folder: Path
    label: str


class Field:
    """One field file; the data are read only when they are needed. Arrays are (z, y, x)."""

    def __init__(self, path: str | Path) -> None:
        import h5py  # here, so that time series need numpy alone
        self.path = Path(path)
        match = _FIELD_FILE.fullmatch(self.path.name)
        if not match:
            raise InputError(f"{path}: a field file is called <quantity>_<label>.h5, like ux_000500.h5")
        self.name, self.label = match["prefix"], match["label"]
        try:
            self._file = h5py.File(self.path, "r")
        except OSError:
            reason = "not a readable HDF5 file" if self.path.exists() else "no such file"
            raise InputError(f"{path}: {reason}") from None
        if self.name not in self._file:
            raise InputError(f"{path}: no dataset '{self.name}'; it has {', '.join(self._file) or 'none'}")
        self.data = self._file[self.name]
        if self.data.ndim != 3:
            raise InputError(f"{path}: dataset '{self.name}' has {self.data.ndim} dimensions, wanted 3")
        self.n = np.array(self.data.shape[::-1])
        self.length = self._attribute("domain_size", 3)
        self.origin = self._attribute("origin", 3, [0.0, 0.0, 0.0])
        self.time = self._attribute("time", 1, [np.nan])[0]
        self.viscosity = self._attribute("viscosity", 1, [np.nan])[0]
        self.spacing = self.length / self.n

    def _attribute(self, name: str, size: int, default: Sequence[float] | None = None) -> np.ndarray:
        value = np.ravel(self.data.attrs.get(name, default if default is not None else []))
        if value.size != size:
            raise InputError(f"{self.path}: attribute '{name}' is missing or has not {size} value(s)")
        return value.astype(float)

    def plane(self, axis: int, index: int) -> np.ndarray:
        """Returns the plane number `index` normal to `axis` (0 x, 1 y, 2 z), in double precision."""
        where: list[slice | int] = [slice(None)] * 3
        where[2 - axis] = index
        return self.data[tuple(where)].astype(float)


class SmoothField(Field):
    """A field whose values are means over three grid points in each direction, without waves that are three spacings long. They
    commute with derivatives."""

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        values = self.data[...].astype(float)
        for axis in (axis for axis in range(3) if values.shape[axis] >= 3):
            values = (values + np.roll(values, 1, axis) + np.roll(values, -1, axis)) / 3
        self.data = values


def fields_in(folder: Path) -> dict[str, set[str]]:
    """Returns {label: set of prefixes} of the field files of a folder."""
    folder = Path(folder)
    labels: dict[str, set[str]] = {}
    for path in folder.glob("*_*.h5"):
        match = _FIELD_FILE.fullmatch(path.name)
        if match and match["prefix"] not in _SURFACES:
            labels.setdefault(match["label"], set()).add(match["prefix"])
    if not labels:
        raise InputError(f"{folder}: no field files like ux_000500.h5 in this folder")
    return labels


def snapshot_times(folder: Path) -> dict[str, float]:
    """Returns {label: time} of a folder."""
    return {label: Field(folder / f"{sorted(prefixes)[0]}_{label}.h5").time
            for label, prefixes in fields_in(folder).items()}


def choose_snapshot(folder: Path, time: float | None, label: str | None) -> Snapshot:
    """Returns the snapshot of a folder with that label, nearest to that time, or the last one."""
    labels = fields_in(folder)
    if label is not None:
        same = [have for have in labels if int(have) == int(label)]
        if not same:
            raise InputError(f"{folder}: nothing with label {label}; there is {', '.join(sorted(labels))}")
        return Snapshot(folder, same[0])
    times = snapshot_times(folder)
    if time is None:
        best = max(times, key=lambda have: (np.nan_to_num(times[have], nan=-np.inf), int(have)))
    else:
        best = min(times, key=lambda have: abs(np.nan_to_num(times[have], nan=np.inf) - time))
    return Snapshot(folder, best)


def field_path(snapshot: Snapshot, name: str) -> Path:
    """Returns the path of a field."""
    return snapshot.folder / f"{name}_{snapshot.label}.h5"


def has_field(snapshot: Snapshot, name: str) -> bool:
    """Returns whether a field was saved."""
    return field_path(snapshot, name).is_file()


def load_field(snapshot: Snapshot, name: str, smooth: bool = False) -> Field:
    """Opens a field; with `smooth` it holds means over three grid points in each direction, and all of it is read."""
    return (SmoothField if smooth else Field)(field_path(snapshot, name))


def has_rings(snapshot: Snapshot) -> bool:
    """Returns whether the run has wings without thickness: the truncation of the Fourier modes surrounds their vorticity with rings
    three grid spacings long, which a SmoothField does not have."""
    return (snapshot.folder / "slip.t").is_file()


# ---- spectral derivatives, the same as the solver's ----------------------------------------------
# The derivative of the highest mode of an even n is not real; irfft leaves it out, which is correct.

def _wavenumbers(n: int, length: float) -> np.ndarray:
    return 2 * np.pi / length * np.arange(n // 2 + 1)


def derivative_in_plane(plane: np.ndarray, axis: int, length: float) -> np.ndarray:
    """Returns the derivative of a periodic plane along its own array axis."""
    n = plane.shape[axis]
    shape = [1] * plane.ndim
    shape[axis] = -1
    ik = 1j * _wavenumbers(n, length).reshape(shape)
    return np.fft.irfft(ik * np.fft.rfft(plane, axis=axis), n=n, axis=axis)


def derivative_at_index(field: Field, axis: int, index: int) -> np.ndarray:
    """Returns the derivative of a field along `axis` (0 x, 1 y, 2 z) on the plane `index` normal to it."""
    n, length = int(field.n[axis]), field.length[axis]
    if n == 1:
        return np.zeros_like(field.plane(axis, 0))
    response = np.fft.irfft(1j * _wavenumbers(n, length), n=n)  # derivative of a unit pulse at 0
    weights = response[(index - np.arange(n)) % n]
    return np.tensordot(weights, field.data[...].astype(float), axes=(0, 2 - axis))


def derivative_on_plane(field: Field, along: int, normal: int, index: int) -> np.ndarray:
    """Returns the derivative of a field along one direction, on the plane `index` normal to `normal`."""
    if along == normal:
        return derivative_at_index(field, normal, index)
    array_axis = [a for a in (2, 1, 0) if a != normal].index(along)
    return derivative_in_plane(field.plane(normal, index), array_axis, field.length[along])
