# SPDX-License-Identifier: GPL-3.0-or-later
"""Divides traced veins into stretches inside the wing and stretches along its margin."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flusi_msm.errors import Problems
from flusi_msm.wing.polyline import Polyline, runs
from flusi_msm.wing.trace import Line, Trace

ALONG_MARGIN = 4.0   # a vein that is at the margin for that many snapping distances runs along it
TAIL = 3.0           # an overshoot is at most that many snapping distances long
LEAVING = 0.2        # slope at which it leaves the margin, whatever its distance


@dataclass
class Piece:
    """A stretch of a vein inside the wing, as a line of its own."""
    vein: int
    line: Polyline
    start: float | None = None                    # arc lengths on the outline where its ends are fixed to it
    stop: float | None = None
    number: int = 0                                  # among the carriers


@dataclass
class Stretch:
    """A stretch of a vein that is the margin from `start` to `stop`, arc lengths on the outline."""
    vein: int
    start: float
    stop: float
    forward: bool


class VeinLines:
    """The outline of a trace and its veins in parts; the carriers are those parts that are lines of their own."""

    def __init__(self, trace: Trace, snap: float, problems: Problems) -> None:
        self.trace, self.snap, self.problems = trace, snap, problems
        self.outline = Polyline(trace.outline, closed=True)
        self.parts: list[list[Piece | Stretch]] = []
        self.carriers: list[Piece] = []
        self.lost: dict[str, Polyline] = {}          # veins that are left out after a mistake

    def length_text(self, length: float) -> str:
        """Writes a length in the unit of messages."""
        return f"{1e3 * length:.3g} {self.trace.unit}"

    def place_text(self, p: np.ndarray) -> str:
        """Writes a place in the unit of messages."""
        return f"({1e3 * p[0]:.3g}, {1e3 * p[1]:.3g}) {self.trace.unit}"

    def lines(self) -> None:
        """Fills `parts` and `carriers`."""
        for k, vein in enumerate(self.trace.veins):
            self.parts.append([])
            if vein.closed:
                self.problems.error(f"{vein.where}: is closed: open it at one node (a vein has two ends)")
            elif Polyline(vein.points).length < 2 * self.snap:
                self.problems.error(f"{vein.where}: is shorter than twice the snapping distance of {self.length_text(self.snap)}: "
                                    "delete it, or choose --snap smaller")
            elif self.check_inside(vein):
                self.parts[k] = self.split(k, vein)
            if not self.parts[k]:
                self.lost[vein.name] = Polyline(vein.points)
        for piece in (p for parts in self.parts for p in parts if isinstance(p, Piece)):
            piece.number = len(self.carriers)
            self.carriers.append(piece)
        for piece in self.carriers:
            crossed = piece.line.crosses_itself()
            if crossed:
                self.problems.error(f"{self.trace.veins[piece.vein].where}: crosses itself at {self.place_text(crossed[0])}: split it")
        for piece in self.carriers:
            self.trim(piece)

    def split(self, k: int, vein: Line) -> list[Piece | Stretch]:
        """Divides a vein into stretches inside the wing and along its margin."""
        line = Polyline(vein.points)
        points, s = line.samples(self.snap / 2)
        distance, on = self.outline.project(points)
        found: list[Piece | Stretch] = []
        done, fixed = 0.0, None

        def own(begin: float, end: float, start: float | None, stop: float | None) -> None:
            piece = line.piece(begin, end)
            if start is not None:
                piece[0] = self.outline.at(start)
            if stop is not None:
                piece[-1] = self.outline.at(stop)
            found.append(Piece(k, Polyline(piece), start, stop))

        for i, j in runs(distance < self.snap):
            while 0 < i < j and self.leaves(distance[i + 1], distance[i], s[i + 1] - s[i]):
                i += 1
            while i < j < len(s) - 1 and self.leaves(distance[j - 1], distance[j], s[j] - s[j - 1]):
                j -= 1
            turn = np.diff(on[i:j + 1])
            turn = turn - self.outline.length * np.round(turn / self.outline.length)
            travelled = float(turn.sum())
            if s[j] - s[i] < ALONG_MARGIN * self.snap or abs(travelled) < 0.6 * (s[j] - s[i]) \
                    or distance[i:j + 1].mean() > self.snap / 2:
                continue
            if s[i] - done > self.snap:
                own(done, s[i], fixed, float(on[i]))
            begin = float(on[i]) if fixed is None or s[i] - done > self.snap else fixed
            found.append(Stretch(k, begin, float(on[j]), travelled > 0))
            done, fixed = float(s[j]), float(on[j])
        if line.length - done > (self.snap if found else 0.0):
            own(done, line.length, fixed, None)
        return found

    def leaves(self, near: float, far: float, step: float) -> bool:
        """Returns whether a vein leaves the margin between two of its points, `step` apart, at these distances from the margin.
        """
        return far > near and (far > self.snap / 4 or far - near > LEAVING * step)

    def check_inside(self, vein: Line) -> bool:
        """Returns whether a vein lies inside the wing; otherwise there is one mistake more."""
        points, _ = Polyline(vein.points).samples(self.snap)
        out = ~self.outline.contains(points)
        distance, _ = self.outline.project(points)
        far = out & (distance > self.snap)
        if far.any():
            worst = int(np.where(far, distance, 0).argmax())
            self.problems.error(f"{vein.where}: leaves the wing by {self.length_text(distance[worst])} at {self.place_text(points[worst])}: "
                                "draw it inside the outline, or move the outline")
        return not far.any()

    def trim(self, piece: Piece) -> None:
        """Cuts off the part of a piece beyond the lines that it crosses shortly before its ends."""
        for end in (0, 1):
            if (piece.start, piece.stop)[end] is not None:
                continue
            line = piece.line
            reach = min(TAIL * self.snap, 0.3 * line.length)
            best, at_outline = 0.0, None
            for other in [self.outline] + [p.line for p in self.carriers if p is not piece]:
                for s, r in line.crossings(other):
                    tail = s if end == 0 else line.length - s
                    # Two veins that cross near the ends of both meet; the longer tail is cut.
                    if tail <= reach and (tail > best or (other is self.outline and tail >= best)):
                        if other is not self.outline and min(r, other.length - r) < 1e-9 * other.length:
                            continue
                        best, at_outline = tail, r if other is self.outline else None
            if best > 0:
                piece.line = Polyline(line.piece(best, line.length) if end == 0 else line.piece(0.0, line.length - best))
            if at_outline is not None:
                if end == 0:
                    piece.start = at_outline
                else:
                    piece.stop = at_outline

    def check_margin(self) -> None:
        """Checks that no two veins are the same stretch of the margin."""
        whole = self.outline.length
        margin = [p for parts in self.parts for p in parts if isinstance(p, Stretch)]
        spans = [((p.start, p.stop) if p.forward else (p.stop, p.start)) for p in margin]
        spans = [(a, a + (b - a) % whole) for a, b in spans]
        for i, (a0, a1) in enumerate(spans):
            for j, (b0, b1) in enumerate(spans[i + 1:], i + 1):
                shared = sum(max(0.0, min(a1, b1 + k * whole) - max(a0, b0 + k * whole)) for k in (-1, 0, 1))
                if shared > 2 * self.snap:
                    self.share_margin(self.trace.veins[margin[i].vein], self.trace.veins[margin[j].vein])

    def share_margin(self, one: Line, other: Line) -> None:
        """Reports two veins that are the same stretch of the margin."""
        self.problems.error(f"{one.where}: runs along the margin where vein '{other.name}' does, too: draw what they share in one "
                            "of them")
