# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the masses of a wing and the quality of its mesh, and writes them as text."""
from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from flusi_msm.wing.file import Wing

VEIN_DENSITY = 1300.0   # kg/m^3, default of [Mass] vein_density
FLAT = 20.0             # degrees; smaller angles are counted


@dataclass
class VeinFacts:
    """Numbers of a vein."""
    nodes: int
    length: float                  # m
    diameters: tuple[float, float]  # m, smallest and largest
    mass: float                    # kg, solid conical frustums


@dataclass
class Quality:
    """Numbers by which a mesh is judged."""
    angles: np.ndarray             # (m, 3) degrees
    edges: np.ndarray              # m
    worst: np.ndarray              # (2,) m, middle of the triangle with the smallest angle
    veins: dict[str, VeinFacts]
    area: float                    # m^2
    vein_density: float            # kg/m^3
    membrane_mass: float | None  # kg
    centre: np.ndarray             # (2,) m, of mass; of the veins alone if the mass of the membrane is not known

    @property
    def vein_mass(self) -> float:
        """Returns the mass of all veins [kg]."""
        return sum(v.mass for v in self.veins.values())


def triangle_angles(wing: Wing) -> np.ndarray:
    """Returns all angles (m, 3) in degrees."""
    found = []
    for k in range(3):
        a, b, c = (wing.points[wing.triangles[:, (k + m) % 3]] for m in range(3))
        u, v = b - a, c - a
        cosine = (u * v).sum(1) / np.sqrt((u * u).sum(1) * (v * v).sum(1))
        found.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.stack(found, axis=1)


def quality_of(wing: Wing) -> Quality:
    """Returns angles, edges, and the masses that the wing states; veins have VEIN_DENSITY if it states nothing."""
    density = wing.mass.vein_density if wing.mass else VEIN_DENSITY
    veins, moment, weight = {}, np.zeros(2), 0.0
    for name, (nodes, diameters) in wing.veins.items():
        p, d = wing.points[list(nodes), :2], np.asarray(diameters)
        step = np.linalg.norm(np.diff(p, axis=0), axis=1)
        a, b = d[:-1], d[1:]
        mass = density * pi / 12 * step * (a * a + a * b + b * b)
        place = p[:-1] + ((a * a + 2 * a * b + 3 * b * b) / (4 * (a * a + a * b + b * b)))[:, None] * np.diff(p, axis=0)
        moment, weight = moment + mass @ place, weight + float(mass.sum())
        veins[name] = VeinFacts(len(nodes), float(step.sum()), (float(d.min()), float(d.max())), float(mass.sum()))
    areas = wing.areas()
    corners = wing.points[wing.triangles, :2]
    middles = corners.mean(1)
    area = float(areas.sum())
    if wing.mass or not veins:
        share, law = (wing.mass.membrane, wing.mass.weights) if wing.mass else (1.0, (1.0, 0.0, 0.0))
        w = law[0] + corners @ np.array(law[1:])     # at the corners; linear in between, so that the integrals are exact
        whole = areas @ w.mean(1)
        moment = moment + share * np.einsum("t,tk,tki->i", areas / 12, w + w.sum(1, keepdims=True), corners) / whole
        weight += share
    angles = triangle_angles(wing)
    edges = np.linalg.norm(np.diff(wing.points[wing.edges()[0]], axis=1)[:, 0], axis=1)
    return Quality(angles, edges, middles[angles.min(1).argmin()], veins, area, density,
                   wing.mass.membrane if wing.mass else None, moment / weight)


def report(wing: Wing, quality: Quality) -> list[str]:
    """Returns lines of text for readers."""
    q, mm = quality, 1e3
    span = float(np.ptp(wing.points[:, 0]))
    small = q.angles.min(1)
    lines = [f"wing      {len(wing.points)} points, {len(wing.triangles)} triangles, {len(wing.veins)} veins, {len(wing.joints)} "
             f"joints, {len(wing.root)} root points",
             f"size      length {mm * span:.3f} mm, area {1e6 * q.area:.3f} mm^2, mean chord {mm * q.area / span:.3f} mm",
             f"edges     {mm * q.edges.min():.3f} to {mm * q.edges.max():.3f} mm, mean {mm * q.edges.mean():.3f} mm",
             f"angles    smallest {small.min():.1f} degrees at ({mm * q.worst[0]:.2f}, {mm * q.worst[1]:.2f}) mm, mean of the "
             f"smallest {small.mean():.1f}, below {FLAT:.0f}: {int((small < FLAT).sum())} of {len(small)} triangles"]
    if q.veins:
        width = max(4, *(len(name) for name in q.veins))
        lines.append(f"{'vein':{width}}  points  length [mm]   diameter [um]   mass [ug]")
        for name, v in sorted(q.veins.items()):
            lines.append(f"{name:{width}}  {v.nodes:6d}  {mm * v.length:11.3f}  {1e6 * v.diameters[0]:6.1f} to {1e6 * v.diameters[1]:5.1f}"
                         f"  {1e9 * v.mass:9.4g}")
    lines.append(f"mass      veins of {q.vein_density:.0f} kg/m^3: {1e9 * q.vein_mass:.4g} ug")
    if q.membrane_mass:
        whole = q.vein_mass + q.membrane_mass
        lines[-1] += (f", membrane {1e9 * q.membrane_mass:.4g} ug ({1e3 * q.membrane_mass / q.area:.3g} g/m^2), together "
                      f"{1e9 * whole:.4g} ug, of which veins {100 * q.vein_mass / whole:.1f} %")
        if wing.mass:
            lines.append(f"          {wing.mass.law} membrane, as stated by: {wing.mass.source}")
    else:
        lines[-1] += "; the mass of the membrane is not known (--membrane-mass UG)"
    lines.append(f"centre    of {'mass' if q.membrane_mass else 'the veins' if q.veins else 'the area'} at ({mm * q.centre[0]:.3f}, "
                 f"{mm * q.centre[1]:.3f}) mm")
    return lines
