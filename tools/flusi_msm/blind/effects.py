# SPDX-License-Identifier: GPL-3.0-or-later
"""The effects that blind cases hide. Every effect is drawn at random except for its strength. This number is 0 where the effect
vanishes, and the effect is more visible when it grows."""
from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, pi, sin
from typing import TYPE_CHECKING, Any, Callable

import numpy as np

from flusi_msm.bending.model import Model
from flusi_msm.measurement.synthesis import with_soft_places

if TYPE_CHECKING:
    from flusi_msm.wing.file import Wing

Host = Any  # what an effect is hidden in: the case of a bending test or of a flight, or the subject of a vibration


@dataclass
class Effect:
    """An effect whose strength is still free."""
    name: str            # of the cause, as in verdicts
    apply: Callable[[Host, float], Host]  # (case, strength) -> case
    parameters: Callable[[float], dict[str, Any]]  # strength -> {name: value} as in verdicts, for intervals
    first: float         # a strength that is small but visible
    most: float          # the largest that makes sense
    is_known: bool = True  # in the catalogue of what can be named
    place: tuple[float, ...] = ()  # [m] where it is, if it has a place
    also: tuple[str, ...] = ()  # other names of the effect that these data cannot tell from it


DrawEffect = Callable[[np.random.Generator, "Wing", Host], Effect]


def stiffness(case: Host, **changes: Any) -> Host:
    """Returns the case with other keys of its stiffness."""
    return replace(case, stiffness=replace(case.stiffness, **changes))


def hidden(case: Host, **changes: Any) -> Host:
    """Returns the case with other hidden properties."""
    return replace(case, hidden=replace(case.hidden, **changes))


def plain(name: str, section: Callable[..., Host], first: float, most: float, sign: float, null: float = 0.0, factor: bool = False) \
        -> Effect:
    """Returns an effect with one key: null + sign s, or null exp(sign s)."""
    def value(s: float) -> float:
        return null * float(np.exp(sign * s)) if factor else null + sign * s
    return Effect(name, lambda case, s: section(case, **{name: value(s)}), lambda s: {name: value(s)}, first, most)


def of(effect: Effect, name: str, parameter: str) -> Effect:
    """Returns the same effect under the names that verdicts use."""
    (key, _), = effect.parameters(0.0).items()
    return replace(effect, name=name, parameters=lambda s: {parameter: effect.parameters(s)[key]})


def direction(rng: np.random.Generator) -> tuple[float, float]:
    """Draws a direction in the plane."""
    angle = rng.uniform(0, 2 * pi)
    return cos(angle), sin(angle)


def sign_of(rng: np.random.Generator) -> float:
    """Draws 1 or -1."""
    return 1.0 if rng.random() < 0.5 else -1.0


def inner_hinges(wing: Wing, least: int = 1) -> list[str]:
    """Returns the veins with at least so many inner points."""
    return sorted(name for name, (nodes, _) in wing.veins.items() if len(nodes) >= least + 2)


# ---- in the catalogue ----------------------------------------------------------------------------

def E_gradient(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Lets E grow or fall from root to tip."""
    return plain("E_gradient", stiffness, 0.05, 3.0, sign_of(rng))


def E_per_vein(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Changes E of one vein."""
    vein, sign = str(rng.choice(inner_hinges(wing, 2))), sign_of(rng)
    def factor(s: float) -> float:
        return float(np.exp(sign * s))
    return Effect("E_per_vein", lambda case, s: stiffness(case, veins={**case.stiffness.veins, vein: factor(s)}),
                  lambda s: {"E:" + vein: factor(s)}, 0.05, np.log(20))


def taper(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Changes the exponent of the diameter in the stiffness of veins."""
    return replace(plain("diameter_exponent", stiffness, 0.05, 2.0, sign_of(rng), null=4.0), name="taper")


def root_compliance(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Lets the clamp turn."""
    angle = rng.uniform(0, pi / 2)
    def pair(s: float) -> tuple[float, float]:
        return s * cos(angle), s * sin(angle)
    return Effect("root_compliance", lambda case, s: stiffness(case, root_compliance=pair(s)),
                  lambda s: {"root_flap": pair(s)[0], "root_twist": pair(s)[1]}, 50.0, 2e4)


def soft_place(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Lowers the stiffness of a hinge of the wing file's mesh by the factor 1 + s."""
    while True:
        vein, share = str(rng.choice(inner_hinges(wing))), float(rng.uniform(0.1, 0.9))
        nodes = wing.veins[vein][0]
        way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(wing.points[nodes], axis=0), axis=1))])
        node = nodes[1 + int(np.abs(way[1:-1] / way[-1] - share).argmin())]
        if all(wing.joint_nodes(j)[1] != node for j in wing.joints):
            break
    probe = replace(case, hidden=replace(case.hidden, soft_places=((vein, share, 1.0),)))
    model = Model(with_soft_places(wing, probe), replace(case.stiffness, joints={}))
    k, = [model.hinge_stiffness(h, with_joint=False) for h in model.hinge_plan if h.joint.startswith("soft")]
    return Effect("soft_place", lambda case, s: hidden(case, soft_places=case.hidden.soft_places +
                                                        ((vein, share, k / (1 + s)),)),
                  lambda s: {}, 0.1, 300.0, place=tuple(map(float, wing.points[node][:2])))


def orthotropy(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Makes springs of the membrane stiffer in one direction."""
    return plain("orthotropy", stiffness, 0.02, 0.9, sign_of(rng))


def pretension(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Stretches the membrane of the unloaded wing."""
    return plain("pretension", stiffness, 1.0, 10.0, 1.0)


def vein_torsion(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Lets veins resist twist."""
    return of(plain("torsion", stiffness, 0.02, 5.0, 1.0), "vein_torsion", "torsion")


def joint_hardening(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Makes joints stiffer the more they bend."""
    effect = plain("joint_hardening", stiffness, 0.5, 3000.0, 1.0)
    return replace(effect, also=("one_joint_hardening",))  # if all joints harden, each of them does


def cuticle(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Makes veins stiffer the more they bend."""
    return of(plain("cuticle_hardening", stiffness, 1e-9, 1e-4, 1.0), "cuticle", "cuticle")


def one_way_joint(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Makes a joint stiffer in one direction."""
    joint, sign = str(rng.choice(sorted(wing.joints))), sign_of(rng)
    def ratio(s: float) -> float:
        return float(np.exp(sign * s))
    return Effect("one_way_joint", lambda case, s: stiffness(case, one_way=(joint, ratio(s))),
                  lambda s: {"one_way:" + joint: ratio(s)}, 0.1, np.log(30))


def damage(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Makes a disc of the wing softer."""
    triangle = wing.triangles[rng.choice(len(wing.triangles), p=np.abs(wing.areas()) / np.abs(wing.areas()).sum())]
    share = rng.dirichlet((1, 1, 1))
    x, y = map(float, share @ wing.points[triangle][:, :2])
    radius = float(rng.uniform(0.04, 0.1) * np.ptp(wing.points[:, 0]))
    return Effect("damage", lambda case, s: stiffness(case, damage=(x, y, radius, float(np.exp(-s)))),
                  lambda s: {}, 0.1, np.log(50), place=(x, y))


def camber(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Gives the unloaded wing a camber."""
    shape = rng.standard_normal(3)
    shape /= np.linalg.norm(shape)
    return Effect("camber", lambda case, s: stiffness(case, camber=tuple(map(float, s * shape))), lambda s: {}, 1e-5,
                  3e-4)


def membrane_bending(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Changes the bending stiffness of the membrane."""
    e = plain("D", stiffness, 0.05, np.log(10), sign_of(rng), null=case.stiffness.D, factor=True)
    return of(e, "membrane_bending", "D")


def force_gain(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Multiplies all forces."""
    effect = plain("force_gain", hidden, 0.02, np.log(2), sign_of(rng), null=1.0, factor=True)
    return replace(effect, also=("elasticity",))  # everything that is not sought is stiffer by a common factor


def force_offset(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Adds a constant to all forces."""
    least = min(float(np.linalg.norm(vector)) for _, vector in case.loads) * min(map(abs, case.protocol.levels))
    return plain("force_offset", hidden, 0.02 * least, 0.7 * least, sign_of(rng))


def force_direction(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Turns the direction of all forces."""
    a, b = direction(rng)
    return Effect("force_direction", lambda case, s: hidden(case, force_tilt=(s * a, s * b)),
                  lambda s: {"force_tilt_x": s * a, "force_tilt_y": s * b}, 0.02, 0.5)


def drift(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Makes the wing softer or stiffer from scan to scan."""
    n = len(case.loads) * len(case.protocol.levels) * case.protocol.repeats
    effect = plain("drift", hidden, 0.02 / n, 0.5 / n, sign_of(rng))
    return replace(effect, also=("drift_in_time",))  # scans follow each other at equal intervals


def load_position(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Shifts the points of application."""
    a, b = direction(rng)
    return Effect("load_position", lambda case, s: hidden(case, load_shift=(s * a, s * b)),
                  lambda s: {"load_shift_x": s * a, "load_shift_y": s * b}, 1e-5, 3e-4)


def height_scale(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Multiplies all heights."""
    return plain("height_scale", hidden, 0.02, np.log(2), sign_of(rng), null=1.0, factor=True)


def registration(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Shifts all height maps."""
    a, b = direction(rng)
    return Effect("registration", lambda case, s: hidden(case, map_shift=(s * a, s * b)),
                  lambda s: {"map_shift_x": s * a, "map_shift_y": s * b}, 1e-5, 3e-4)


def scan_plane(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Tilts and lifts all loaded scans."""
    a, b, c = rng.standard_normal(3)
    reach = float(np.ptp(wing.points[:, 0])) / 2
    def parts(s: float) -> tuple[tuple[float, float], float]:
        return (float(s * a / reach), float(s * b / reach)), float(s * c)
    return Effect("scan_plane", lambda case, s: hidden(case, tilt=parts(s)[0], piston=parts(s)[1]),
                  lambda s: {"tilt_x": parts(s)[0][0], "tilt_y": parts(s)[0][1], "piston": parts(s)[1]}, 1e-6, 2e-4)


# ---- outside -------------------------------------------------------------------------------------

def E_wave(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Makes E of one vein go up and down along it."""
    vein = str(rng.choice(inner_hinges(wing, 3)))
    points = wing.points[wing.veins[vein][0]]
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum() / rng.uniform(1.0, 2.0))
    return Effect("E_wave", lambda case, s: stiffness(case, E_wave=(vein, s, length)), lambda s: {}, 0.05, 0.95, False)


def D_wave(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Makes the bending stiffness of the membrane go up and down over the wing."""
    size = np.ptp(wing.points[:, :2], axis=0)
    lx, ly = map(float, size / rng.uniform(0.7, 2.5, 2))
    return Effect("D_wave", lambda case, s: stiffness(case, D_wave=(s, lx, ly)), lambda s: {}, 0.05, 0.95, False)


def memory(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Lets a part of the previous deformation remain."""
    return replace(plain("memory", hidden, 0.01, 0.5, 1.0), is_known=False)


def bow(rng: np.random.Generator, wing: Wing, case: Host) -> Effect:
    """Bends the scans more and more from one to the next."""
    return replace(plain("bow", hidden, 1e-7, 1e-4, sign_of(rng)), is_known=False)


KNOWN = (E_gradient, E_per_vein, taper, root_compliance, soft_place, orthotropy, pretension, vein_torsion,
         joint_hardening, cuticle,
         one_way_joint, damage, camber, membrane_bending, force_gain, force_offset, force_direction, drift,
         load_position, height_scale, registration, scan_plane)
OUTSIDE = (E_wave, D_wave, memory, bow)
