# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where lines of a traced wing meet: ends of veins, crossings, corners of the outline."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flusi_msm.errors import Problems
from flusi_msm.wing.polyline import Polyline, runs
from flusi_msm.wing.trace import Trace
from flusi_msm.wing.vein_lines import Piece, VeinLines

OVERLAP = 6.0        # two veins that are closer than a third of the snapping distance for that many of them are one
CORNER = 40.0        # degrees; a sharper turn is a corner that the mesh keeps
OUTLINE = -1         # number of the outline among the carriers


@dataclass
class Attachments:
    """Places on carriers (the outline and the pieces) that are joined to nodes."""
    carrier: list[int] = field(default_factory=list)
    s: list[float] = field(default_factory=list)
    parent: list[int] = field(default_factory=list)
    soft: set = field(default_factory=set)           # round corners: they are replaced by an end that is near

    def add(self, carrier: int, s: float) -> int:
        """Adds a place; returns its number."""
        self.carrier.append(carrier)
        self.s.append(s)
        self.parent.append(len(self.parent))
        return len(self.parent) - 1

    def top(self, k: int) -> int:
        """Returns the attachment that stands for all that are joined with this one."""
        while self.parent[k] != k:
            k = self.parent[k]
        return k

    def join(self, a: int, b: int) -> None:
        """Joins two attachments."""
        a, b = self.top(a), self.top(b)
        self.parent[max(a, b)] = min(a, b)


class Meetings(VeinLines):
    """The lines of a trace, and the places where they are joined."""

    def __init__(self, trace: Trace, snap: float, problems: Problems) -> None:
        super().__init__(trace, snap, problems)
        self.att = Attachments()

    def place(self, carrier: int, s: float, merge: float | None = None, is_soft: bool = False) -> int:
        """Returns the attachment of a carrier at `s`, or near it, made if there is none; soft ones are replaced by others."""
        merge = self.snap if merge is None else merge
        best, found = merge, -1
        for k, (c, t) in enumerate(zip(self.att.carrier, self.att.s)):
            if c == carrier:
                gap = abs(t - s)
                gap = min(gap, self.outline.length - gap) if carrier == OUTLINE else gap
                if gap <= best:
                    best, found = gap, k
        if found < 0:
            found = self.att.add(carrier, s)
            if is_soft:
                self.att.soft.add(found)
        elif found in self.att.soft and not is_soft:
            self.att.soft.remove(found)
            self.att.s[found] = s
        return found

    def half_width(self, piece: Piece) -> float:
        """Returns half the largest diameter of a vein."""
        return max(d for _, d in self.trace.veins[piece.vein].diameters or ()) / 2

    def attach_ends(self) -> None:
        """Joins the ends of all pieces with what they meet."""
        ends = []
        for piece in self.carriers:
            for s, fixed in ((0.0, piece.start), (piece.line.length, piece.stop)):
                ends.append((piece, s, fixed, self.att.add(piece.number, s)))
        for piece, s, fixed, k in ends:
            if fixed is not None:
                self.att.join(k, self.place(OUTLINE, fixed))
        for piece, s, fixed, k in ends:
            if fixed is None:
                self.attach_end(piece, s, k)

    def attach_end(self, piece: Piece, s: float, k: int) -> None:
        """Joins the end of a piece with the lines near it."""
        vein = self.trace.veins[piece.vein]
        p = piece.line.at(s)
        near = []
        nearest = (np.inf, "the outline")
        for other in [None] + [c for c in self.carriers if c is not piece]:
            line = self.outline if other is None else other.line
            distance, on = (float(v[0]) for v in line.project(p))
            reach = self.snap if other is None else max(self.snap, self.half_width(other))
            if other is not None and other.vein == piece.vein and distance > 0.1 * self.snap:
                continue
            name = "the outline" if other is None else f"vein '{self.trace.veins[other.vein].name}'"
            nearest = min(nearest, (distance, name))
            if distance <= reach:
                near.append((distance, OUTLINE if other is None else other.number, on))
        if near:
            least = min(near)[0]
            for distance, carrier, on in near:
                if distance <= max(1.5 * least, 0.1 * self.snap):
                    self.att.join(k, self.place(carrier, on))
        elif not vein.free_end and not self.is_at_lost(p, self.snap):
            self.problems.error(f"{vein.where}: ends in the air at {self.place_text(p)}, {self.length_text(nearest[0])} from {nearest[1]}: "
                                f"draw it to there, or allow it with --free-end {vein.name}")

    def is_at_lost(self, p: np.ndarray, reach: float) -> bool:
        """Returns whether a vein that was left out passes there: lines that should end on it are not reported again."""
        return any(line.project(p)[0][0] <= reach for line in self.lost.values())

    def attach_crossings(self) -> None:
        """Joins lines where they cross."""
        for a in self.carriers:
            for s, r in a.line.crossings(self.outline):
                if min(s, a.line.length - s) > self.snap:
                    self.problems.error(f"{self.trace.veins[a.vein].where}: touches the outline at {self.place_text(a.line.at(s))} and goes "
                                        "on: keep it inside, or let it end there")
            for b in self.carriers[a.number + 1:]:
                for s, r in a.line.crossings(b.line):
                    here, there = (self.place(c.number, t, 2 * self.snap) for c, t in ((a, s), (b, r)))
                    if self.att.top(here) == self.att.top(there):
                        continue
                    here, there = self.place(a.number, s), self.place(b.number, r)
                    self.att.join(here, there)
                    if min(s, a.line.length - s) > self.snap and min(r, b.line.length - r) > self.snap:
                        names = [self.trace.veins[c.vein].name for c in (a, b)]
                        self.problems.notice(f"{self.trace.source}: veins '{names[0]}' and '{names[1]}' cross at "
                                             f"{self.place_text(a.line.at(s))}: they are joined there")

    def check_overlaps(self) -> None:
        """Reports veins that run along each other."""
        for a in self.carriers:
            points, s = a.line.samples(self.snap / 4)
            for b in self.carriers[a.number + 1:]:
                distance, _ = b.line.project(points)
                for i, j in runs(distance < self.snap / 3):
                    if s[j] - s[i] > OVERLAP * self.snap:
                        self.problems.error(f"{self.trace.veins[a.vein].where}: runs along vein '{self.trace.veins[b.vein].name}' "
                                            f"from {self.place_text(points[i])} to {self.place_text(points[j])}: draw what they share in one of them")

    def attach_corners(self, lines: list[tuple[int, Polyline]]) -> None:
        """Adds the corners of lines."""
        for number, line in lines:
            turns = []
            for s in line.s[(0 if line.closed else 1):-1]:
                if line.cosine(s, self.snap) < np.cos(np.radians(CORNER)):
                    turns.append((line.cosine(s, self.snap / 10), float(s)))
            for cosine, s in sorted(turns):              # the sharpest first; those near it are the same corner
                self.place(number, s, is_soft=bool(cosine > np.cos(np.radians(CORNER))))
