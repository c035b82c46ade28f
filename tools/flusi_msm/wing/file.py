# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps wings in memory and in wing files (docs/formats/wing-format.md). Points are counted from 0 here, from 1 in files."""
from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from math import pi
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flusi_msm.errors import InputError
from flusi_msm.seal import check_seal, write_seal

SCHEMA, VERSION = "flusi-msm wing", 1
Z_SIDES = ("left ventral", "right dorsal", "left dorsal", "right ventral")


LAWS = ("uniform", "bilinear")


@dataclass
class WingMass:
    """The known masses of this individual wing."""
    law: str                                         # of the membrane, of LAWS
    membrane: float                                  # mass of the membrane [kg]
    source: str                                      # where this comes from, for readers
    weights: tuple[float, float, float] = (1.0, 0.0, 0.0)  # bilinear: areal density ~ w1 + w2 x + w3 y [-], [1/m], [1/m]
    vein_density: float = 1300.0                     # [kg/m^3]


@dataclass
class Wing:
    """A wing: points, membrane, veins, joints and what holds it."""
    points: np.ndarray                               # (n, 3) [m]
    triangles: np.ndarray                            # (m, 3)
    veins: dict[str, tuple[list[int], np.ndarray]] = field(default_factory=dict)  # name: (nodes, diameters [m])
    joints: dict[str, tuple[Any, ...]] = field(default_factory=dict)  # name: (vein, node) or (node, node, node)
    root: list[int] = field(default_factory=list)
    title: str = ""
    z_side: str = ""                                 # which side of which wing +z points to, of Z_SIDES; "": not stated
    mass: WingMass | None = None                  # None: not stated

    def areas(self) -> np.ndarray:
        """Returns the area of every triangle in the x, y plane [m^2], negative if clockwise."""
        a, b, c = (self.points[self.triangles[:, k], :2] for k in range(3))
        u, v = b - a, c - a
        return (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2

    def smallest_angle(self) -> float:
        """Returns the smallest angle of all triangles [degrees]."""
        smallest = np.inf
        for k in range(3):
            a, b, c = (self.points[self.triangles[:, (k + m) % 3]] for m in range(3))
            u, v = b - a, c - a
            cosine = (u * v).sum(1) / np.sqrt((u * u).sum(1) * (v * v).sum(1))
            smallest = min(smallest, np.degrees(np.arccos(np.clip(cosine, -1, 1))).min())
        return smallest

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Returns unique edges (k, 2), smaller point first, sorted; and the number of triangles at each."""
        pairs = np.sort(np.concatenate([self.triangles[:, [0, 1]], self.triangles[:, [1, 2]],
                                        self.triangles[:, [2, 0]]]), axis=1)
        return np.unique(pairs, axis=0, return_counts=True)

    def joint_nodes(self, name: str) -> list:
        """Returns the three points of a joint."""
        joint = self.joints[name]
        if len(joint) == 3:
            return list(joint)
        nodes = list(self.veins[joint[0]][0])
        i = nodes.index(joint[1])
        return nodes[i - 1:i + 2]

    def vein_mass(self, density: float = 1300.0) -> float:
        """Returns the mass of all veins as conical frustums [kg]."""
        mass = 0.0
        for nodes, d in self.veins.values():
            d = np.asarray(d)
            length = np.sqrt((np.diff(self.points[list(nodes)], axis=0)**2).sum(1))
            mass += density * pi / 12 * (length * (d[1:]**2 + d[1:] * d[:-1] + d[:-1]**2)).sum()
        return mass

    def summary(self) -> str:
        """Describes the wing in lines."""
        text = f"{len(self.points)} points, {len(self.triangles)} triangles, {len(self.veins)} veins, " \
               f"{len(self.joints)} joints, {len(self.root)} root points"
        if len(self.triangles):
            area, span = self.areas().sum(), np.ptp(self.points[:, 0])
            text += f"\nlength {1e3 * span:.3f} mm, area {1e6 * area:.3f} mm^2, mean chord {1e3 * area / span:.3f} " \
                    f"mm, smallest angle {self.smallest_angle():.1f} degrees"
        if self.z_side:
            text += f"\n+z points to the side: {self.z_side}"
        if self.veins:
            d = np.concatenate([np.asarray(d) for _, d in self.veins.values()])
            text += f"\ndiameters {1e6 * d.min():.0f} to {1e6 * d.max():.0f} um, veins of 1300 kg/m^3 weigh " \
                    f"{1e9 * self.vein_mass():.2f} ug"
        return text


def add_z_side(parser: argparse.ArgumentParser) -> None:
    """Adds the option for the sides of a wing that its file states."""
    parser.add_argument("--z-side", choices=Z_SIDES, default="",
                        help="which side of which wing +z points to (left out: not stated, left ventral is meant)")


def sorted_wing(wing: Wing) -> Wing:
    """Returns the same wing with its points in the order of x and then y, and its triangles in the order of points."""
    order = np.lexsort((wing.points[:, 1], wing.points[:, 0]))
    number = np.empty(len(order), int)
    number[order] = np.arange(len(order))
    triangles = number[wing.triangles] if len(wing.triangles) else wing.triangles
    turns = triangles.argmin(1) if len(triangles) else []
    triangles = np.array([np.roll(t, -k) for t, k in zip(triangles, turns)], int).reshape(-1, 3)
    triangles = triangles[np.lexsort(triangles.T[::-1])] if len(triangles) else triangles
    joints = {k: (j[0], int(number[j[1]])) if len(j) == 2 else tuple(int(number[i]) for i in j)
              for k, j in wing.joints.items()}
    return Wing(wing.points[order], triangles,
                {k: ([int(number[i]) for i in nodes], d) for k, (nodes, d) in wing.veins.items()}, joints,
                sorted(int(number[i]) for i in wing.root), wing.title, wing.z_side, wing.mass)


def write_wing(path: str | Path, wing: Wing) -> None:
    """Writes a wing file with a seal in the layout of HDF5 1.8, whose metadata carry checksums."""
    def dataset(group: h5py.Group, name: str, values: Any, kind: str, units: str | None = None) -> h5py.Dataset:
        made = group.create_dataset(name, data=np.asarray(values, kind), track_times=False)
        if units:
            made.attrs["units"] = np.bytes_(units)
        return made

    try:
        with h5py.File(path, "w", libver=("v108", "v108")) as file:
            file.attrs["schema"] = np.bytes_(SCHEMA)
            file.attrs["version"] = np.int32(VERSION)
            file.attrs["index_base"] = np.int32(1)
            if wing.title:
                file.attrs["title"] = np.bytes_(wing.title)
            if wing.z_side:
                file.attrs["z_side"] = np.bytes_(wing.z_side)
            if wing.mass:
                file.attrs["membrane_law"] = np.bytes_(wing.mass.law)
                file.attrs["membrane_mass"] = np.float64(wing.mass.membrane)
                if wing.mass.law == "bilinear":
                    file.attrs["membrane_weights"] = np.array(wing.mass.weights, "<f8")
                file.attrs["vein_density"] = np.float64(wing.mass.vein_density)
                file.attrs["mass_source"] = np.bytes_(wing.mass.source.encode())
            dataset(file, "points", wing.points, "<f8", "m")
            dataset(file, "triangles", np.reshape(wing.triangles, (-1, 3)) + 1, "<i4")
            for name, (nodes, diameters) in sorted(wing.veins.items()):
                group = file.create_group("veins/" + name)
                dataset(group, "nodes", np.asarray(nodes) + 1, "<i4")
                dataset(group, "diameters", diameters, "<f8", "m")
            for name, joint in sorted(wing.joints.items()):
                places = joint[1:] if len(joint) == 2 else joint
                made = dataset(file, "joints/" + name, np.asarray(places) + 1, "<i4")
                if len(joint) == 2:
                    made.attrs["vein"] = np.bytes_(joint[0])
            dataset(file, "root/nodes", np.asarray(wing.root) + 1, "<i4")
        write_seal(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error}") from None


def read_wing(path: str | Path) -> Wing:
    """Reads a wing file; it is checked only as far as needed to draw it, not as strictly as by the solver."""
    def text(value: object) -> str:
        return value.decode() if isinstance(value, bytes) else str(value)

    try:
        check_seal(path)
        with h5py.File(path, "r") as file:
            if text(file.attrs.get("schema", "")) != SCHEMA or file.attrs.get("version") != VERSION:
                raise InputError(f"{path}: not a wing file of version {VERSION}")
            base = int(file.attrs["index_base"])
            points = file["points"][:]
            triangles = file["triangles"][:] - base if "triangles" in file else np.zeros((0, 3), int)
            veins = {name: ((group["nodes"][:] - base).tolist(), group["diameters"][:])
                     for name, group in file.get("veins", {}).items()}
            joints = {}
            for name, made in file.get("joints", {}).items():
                nodes = tuple(int(i) - base for i in made[:])
                joints[name] = (text(made.attrs["vein"]), nodes[0]) if "vein" in made.attrs else nodes
            root = (file["root/nodes"][:] - base).tolist()
            mass = None
            if "membrane_law" in file.attrs:
                one, x, y = (float(w) for w in file.attrs.get("membrane_weights", (1.0, 0.0, 0.0)))
                mass = WingMass(text(file.attrs["membrane_law"]), float(file.attrs["membrane_mass"]),
                                text(file.attrs["mass_source"]), (one, x, y),
                                float(file.attrs.get("vein_density", 1300.0)))
            title, z_side = (text(file.attrs.get(name, "")) for name in ("title", "z_side"))
    except FileNotFoundError:
        raise InputError(f"{path}: not a readable wing file: no such file") from None
    except (OSError, KeyError, AttributeError, TypeError) as error:
        raise InputError(f"{path}: not a readable wing file: {error}") from None
    every = [i for nodes, _ in veins.values() for i in nodes] + [int(i) for i in triangles.ravel()] + root
    if every and not 0 <= min(every) <= max(every) < len(points):
        raise InputError(f"{path}: names points that do not exist")
    return Wing(points, triangles, veins, joints, root, title, z_side, mass)
