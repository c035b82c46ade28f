# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a network from traced lines: it finds which veins meet each other and the margin, and where.

A traced line never ends exactly where it should. Ends within the snapping distance of another line are moved onto it, overshoots
are cut off, stretches of a vein along the margin become the margin itself, and lines that cross are joined. Larger deviations are
reported to the user as mistakes. All lengths are metres in the wing frame.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, List, Optional, Tuple

import numpy as np

from flusi_msm.errors import Problems
from flusi_msm.wing.polyline import Polyline, runs
from flusi_msm.wing.trace import JointMark, Line, Trace

SNAP = 0.01          # snapping distance by the length of the wing
ALONG_MARGIN = 4.0   # a vein that is at the margin for that many snapping distances runs along it
TAIL = 3.0           # an overshoot is at most that many snapping distances long
LEAVING = 0.2        # slope at which it leaves the margin, whatever its distance
OVERLAP = 6.0        # two veins that are closer than a third of the snapping distance for that many of them are one
CORNER = 40.0        # degrees; a sharper turn is a corner that the mesh keeps
OUTLINE = -1         # number of the outline among the carriers


@dataclass
class Branch:
    """A line between two nodes without a node in between."""
    first: int
    last: int
    points: np.ndarray


@dataclass
class Network:
    nodes: np.ndarray                                # (k, 2)
    branches: List[Branch]
    outline: List[int]                               # its branches in counter-clockwise order, all forward
    veins: Dict[str, List[Tuple[int, bool]]]         # branches of a vein in order; False: from last to first
    joints: Dict[str, Tuple[Tuple[str, ...], int]]   # ((vein,) or (vein, vein)), node
    root: List[int]                                  # branches of the outline that are held


@dataclass
class _Piece:
    """A stretch of a vein: its own line, or, with `line` None, the outline from `start` to `stop`."""
    vein: int
    line: Optional[Polyline] = None
    start: Optional[float] = None                    # arc length on the outline where it is fixed to it, or begins
    stop: Optional[float] = None
    forward: bool = True
    number: int = 0                                  # among the carriers


@dataclass
class _Attachments:
    """Places on carriers (the outline and the pieces) that are joined to nodes."""
    carrier: List[int] = field(default_factory=list)
    s: List[float] = field(default_factory=list)
    parent: List[int] = field(default_factory=list)
    soft: set = field(default_factory=set)           # round corners: they are replaced by an end that is near

    def add(self, carrier: int, s: float) -> int:
        self.carrier.append(carrier)
        self.s.append(s)
        self.parent.append(len(self.parent))
        return len(self.parent) - 1

    def top(self, k: int) -> int:
        while self.parent[k] != k:
            k = self.parent[k]
        return k

    def join(self, a: int, b: int) -> None:
        a, b = self.top(a), self.top(b)
        self.parent[max(a, b)] = min(a, b)


class _Builder:
    def __init__(self, trace: Trace, snap: float, problems: Problems) -> None:
        self.trace, self.snap, self.problems = trace, snap, problems
        self.outline = Polyline(trace.outline, closed=True)
        self.parts: List[List[_Piece]] = []
        self.carriers: List[_Piece] = []
        self.att = _Attachments()
        self.lost: Dict[str, Polyline] = {}          # veins that are left out after a mistake

    def length_text(self, length: float) -> str:
        return f"{1e3 * length:.3g} {self.trace.unit}"

    def place_text(self, p: np.ndarray) -> str:
        return f"({1e3 * p[0]:.3g}, {1e3 * p[1]:.3g}) {self.trace.unit}"

    # ---- veins as pieces

    def split(self, k: int, vein: Line) -> List[_Piece]:
        """Divides a vein into stretches inside the wing and along its margin."""
        line = Polyline(vein.points)
        points, s = line.samples(self.snap / 2)
        distance, on = self.outline.project(points)
        found: List[_Piece] = []
        done, fixed = 0.0, None

        def own(begin: float, end: float, start: Optional[float], stop: Optional[float]) -> None:
            piece = line.piece(begin, end)
            if start is not None:
                piece[0] = self.outline.at(start)
            if stop is not None:
                piece[-1] = self.outline.at(stop)
            found.append(_Piece(k, Polyline(piece), start, stop))

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
            found.append(_Piece(k, None, begin, float(on[j]), travelled > 0))
            done, fixed = float(s[j]), float(on[j])
        if line.length - done > (self.snap if found else 0.0):
            own(done, line.length, fixed, None)
        return found

    def leaves(self, near: float, far: float, step: float) -> bool:
        """Returns whether a vein leaves the margin between two of its points, `step` apart, at these distances from the margin.
        """
        return far > near and (far > self.snap / 4 or far - near > LEAVING * step)

    def check_inside(self, vein: Line) -> bool:
        points, _ = Polyline(vein.points).samples(self.snap)
        out = ~self.outline.contains(points)
        distance, _ = self.outline.project(points)
        far = out & (distance > self.snap)
        if far.any():
            worst = int(np.where(far, distance, 0).argmax())
            self.problems.error(f"{vein.where}: leaves the wing by {self.length_text(distance[worst])} at {self.place_text(points[worst])}: "
                                "draw it inside the outline, or move the outline")
        return not far.any()

    def trim(self, piece: _Piece) -> None:
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

    # ---- places where lines meet

    def place(self, carrier: int, s: float, merge: Optional[float] = None, is_soft: bool = False) -> int:
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

    def half_width(self, piece: _Piece) -> float:
        return max(d for _, d in self.trace.veins[piece.vein].diameters) / 2

    def attach_ends(self) -> None:
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

    def attach_end(self, piece: _Piece, s: float, k: int) -> None:
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
        for a in self.carriers:
            points, s = a.line.samples(self.snap / 4)
            for b in self.carriers[a.number + 1:]:
                distance, _ = b.line.project(points)
                for i, j in runs(distance < self.snap / 3):
                    if s[j] - s[i] > OVERLAP * self.snap:
                        self.problems.error(f"{self.trace.veins[a.vein].where}: runs along vein '{self.trace.veins[b.vein].name}' "
                                            f"from {self.place_text(points[i])} to {self.place_text(points[j])}: draw what they share in one of them")

    def attach_corners(self, lines: List[Tuple[int, Polyline]]) -> None:
        for number, line in lines:
            turns = []
            for s in line.s[(0 if line.closed else 1):-1]:
                if line.cosine(s, self.snap) < np.cos(np.radians(CORNER)):
                    turns.append((line.cosine(s, self.snap / 10), float(s)))
            for cosine, s in sorted(turns):              # the sharpest first; those near it are the same corner
                self.place(number, s, is_soft=bool(cosine > np.cos(np.radians(CORNER))))

    # ---- root

    def root_stretch(self) -> Optional[Tuple[float, float]]:
        """Returns the held part of the outline: from, to, counter-clockwise."""
        root = self.trace.root
        if root is None and self.trace.root_part <= 0:
            return None
        points, s = self.outline.samples(self.snap / 2)
        if root is None:
            low = points[:, 0].min()
            return self.stretch_where(points[:-1, 0] <= low + self.trace.root_part * self.trace.length, s[:-1], "the root")
        if root.closed:
            return self.stretch_where(Polyline(root.points, closed=True).contains(points[:-1]), s[:-1], root.where)
        distance, on = self.outline.project(Polyline(root.points).samples(self.snap)[0])
        if distance.max() > 2 * self.snap:
            self.problems.error(f"{root.where}: is {self.length_text(distance.max())} off the outline: draw it along the outline")
            return None
        turn = np.diff(on)
        travelled = float((turn - self.outline.length * np.round(turn / self.outline.length)).sum())
        if abs(travelled) < 1.2 * self.snap:
            self.problems.error(f"{root.where}: holds only {self.length_text(abs(travelled))} of the outline: draw it longer (its ends "
                                "must not meet)")
            return None
        return (float(on[0]), float(on[-1])) if travelled > 0 else (float(on[-1]), float(on[0]))

    def stretch_where(self, flags: np.ndarray, s: np.ndarray, where: str) -> Optional[Tuple[float, float]]:
        if flags.all() or not flags.any():
            self.problems.error(f"{where}: holds {'all' if flags.any() else 'nothing'} of the outline: draw a line along the part "
                                "that is held")
            return None
        shift = int(np.flatnonzero(~flags)[0])      # so that no run contains the end
        found = runs(np.roll(flags, -shift))
        if len(found) > 1:
            self.problems.error(f"{where}: holds {len(found)} parts of the outline: draw it so that it holds one")
            return None
        i, j = ((k + shift) % len(flags) for k in found[0])
        return float(s[i]), float(s[j])

    # ---- joints

    def attach_joints(self) -> List[Tuple[int, int]]:
        """Returns (number of the joint, attachment) of the joints that lie on a vein."""
        found = []
        for k, joint in enumerate(self.trace.joints):
            best = (np.inf, -1, 0.0, -1)
            for parts in self.parts:
                for piece in parts:
                    vein = self.trace.veins[piece.vein]
                    if joint.veins and vein.name not in joint.veins:
                        continue
                    if piece.line is None:
                        distance, on = self.outline.project(joint.place)
                        span = self.along(piece, float(on[0]))
                        if not 0 <= span <= 1:
                            continue
                        best = min(best, (float(distance[0]), OUTLINE, float(on[0]), piece.vein))
                    else:
                        distance, on = piece.line.project(joint.place)
                        best = min(best, (float(distance[0]), piece.number, float(on[0]), piece.vein))
            unknown = [name for name in joint.veins if name not in {v.name for v in self.trace.veins}]
            if unknown:
                self.problems.error(f"{joint.where}: names vein '{unknown[0]}', which is not drawn; there are "
                                    + ", ".join(v.name for v in self.trace.veins))
                continue
            if len(joint.veins) > 2:
                self.problems.error(f"{joint.where}: names {len(joint.veins)} veins: a hinge is inside one vein or from one into "
                                    "another")
                continue
            reach = max(self.snap, joint.radius)
            if best[3] >= 0:
                reach = max(reach, max(d for _, d in self.trace.veins[best[3]].diameters) / 2)
            if best[0] > reach:
                name = f"vein '{self.trace.veins[best[3]].name}'" if best[3] >= 0 else "any vein"
                told = f"{self.length_text(best[0])} from {name}" if best[3] >= 0 else "not on a vein"
                if not any(v in self.lost for v in joint.veins) and not self.is_at_lost(joint.place, reach):
                    self.problems.error(f"{joint.where}: is off its vein, {told}: move it onto the vein")
                continue
            found.append((k, self.place(best[1], best[2])))
        return found

    def along(self, piece: _Piece, s: float) -> float:
        """Returns where the outline's `s` lies along a stretch of the margin: 0 at its begin, 1 at its end."""
        begin, end = (piece.start, piece.stop) if piece.forward else (piece.stop, piece.start)
        whole = (end - begin) % self.outline.length
        part = (s - begin + 1e-6 * whole) % self.outline.length - 1e-6 * whole
        return part / whole

    # ---- all of it

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
        for piece in (p for parts in self.parts for p in parts if p.line is not None):
            piece.number = len(self.carriers)
            self.carriers.append(piece)
        for piece in self.carriers:
            crossed = piece.line.crosses_itself()
            if crossed:
                self.problems.error(f"{self.trace.veins[piece.vein].where}: crosses itself at {self.place_text(crossed[0])}: split it")
        for piece in self.carriers:
            self.trim(piece)

    def check_margin(self) -> None:
        """Checks that no two veins are the same stretch of the margin."""
        whole = self.outline.length
        margin = [p for parts in self.parts for p in parts if p.line is None]
        spans = [((p.start, p.stop) if p.forward else (p.stop, p.start)) for p in margin]
        spans = [(a, a + (b - a) % whole) for a, b in spans]
        for i, (a0, a1) in enumerate(spans):
            for j, (b0, b1) in enumerate(spans[i + 1:], i + 1):
                shared = sum(max(0.0, min(a1, b1 + k * whole) - max(a0, b0 + k * whole)) for k in (-1, 0, 1))
                if shared > 2 * self.snap:
                    self.share_margin(self.trace.veins[margin[i].vein], self.trace.veins[margin[j].vein])

    def share_margin(self, one: Line, other: Line) -> None:
        self.problems.error(f"{one.where}: runs along the margin where vein '{other.name}' does, too: draw what they share in one "
                            "of them")

    def node_positions(self) -> Tuple[np.ndarray, Dict[int, int]]:
        """Returns the position of every node; and the number of the node of every top attachment."""
        groups: Dict[int, List[int]] = {}
        for k in range(len(self.att.s)):
            groups.setdefault(self.att.top(k), []).append(k)
        places, number = [], {}
        for top, members in groups.items():
            def rank(k: int) -> int:
                if self.att.carrier[k] == OUTLINE:
                    return 0
                length = self.carriers[self.att.carrier[k]].line.length
                return 2 if self.att.s[k] in (0.0, length) else 1
            best = min(map(rank, members))
            chosen = [k for k in members if rank(k) == best]
            chosen = chosen if best == 2 else chosen[:1]
            places.append(np.mean([self.line_of(self.att.carrier[k]).at(self.att.s[k]) for k in chosen], axis=0))
            number[top] = len(places) - 1
        return np.array(places).reshape(-1, 2), number

    def line_of(self, carrier: int) -> Polyline:
        return self.outline if carrier == OUTLINE else self.carriers[carrier].line

    def cut(self, carrier: int, nodes: np.ndarray, number: Dict[int, int], branches: List[Branch]) -> List[int]:
        """Adds the branches of a carrier and returns their numbers in order."""
        line = self.line_of(carrier)
        stops = sorted({(self.att.s[k], number[self.att.top(k)]) for k in range(len(self.att.s))
                        if self.att.carrier[k] == carrier})
        pairs = list(zip(stops, stops[1:])) + ([(stops[-1], stops[0])] if line.closed else [])
        made = []
        for (s0, a), (s1, b) in pairs:
            if a == b:
                continue
            points = line.piece(s0, s1)
            shift = [np.linalg.norm(points[0] - nodes[a]), np.linalg.norm(points[-1] - nodes[b])]
            keep = (np.linalg.norm(points - points[0], axis=1) > 2 * shift[0]) & \
                   (np.linalg.norm(points - points[-1], axis=1) > 2 * shift[1])
            keep[[0, -1]] = True
            points = points[keep]
            points[0], points[-1] = nodes[a], nodes[b]
            made.append(len(branches))
            branches.append(Branch(a, b, points))
        return made

    def build(self) -> Optional[Network]:
        crossed = self.outline.crosses_itself()
        if crossed:
            self.problems.error(f"{self.trace.outline_where}: the outline crosses itself at {self.place_text(crossed[0])}: move its nodes apart")
            return None
        self.lines()
        self.check_margin()
        self.check_overlaps()
        self.attach_corners([(OUTLINE, self.outline)])
        held = self.root_stretch()
        held_at = [self.place(OUTLINE, s) for s in held] if held else []
        margin = [(p, [self.place(OUTLINE, s) for s in (p.start, p.stop)])
                  for parts in self.parts for p in parts if p.line is None]
        self.attach_ends()
        self.attach_crossings()
        joints = self.attach_joints()
        self.attach_corners([(piece.number, piece.line) for piece in self.carriers])
        if self.problems.errors or not held:
            return None
        while sum(c == OUTLINE for c in self.att.carrier) < 3:
            stops = sorted(s for c, s in zip(self.att.carrier, self.att.s) if c == OUTLINE)
            gaps = [((b - a) % self.outline.length or self.outline.length, a) for a, b in zip(stops, stops[1:] + stops[:1])]
            gap, a = max(gaps)
            self.att.add(OUTLINE, (a + gap / 2) % self.outline.length)
        nodes, number = self.node_positions()
        branches: List[Branch] = []
        outline = self.cut(OUTLINE, nodes, number, branches)
        own = {piece.number: self.cut(piece.number, nodes, number, branches) for piece in self.carriers}

        def stretch(a: int, b: int) -> List[int]:
            """Returns branches of the outline from one node to another, counter-clockwise."""
            i = next(i for i, k in enumerate(outline) if branches[k].first == a)
            found = []
            while not found or branches[found[-1]].last != b:
                found.append(outline[(i + len(found)) % len(outline)])
            return found

        node_of = [number[self.att.top(k)] for k in range(len(self.att.s))]
        veins: Dict[str, List[Tuple[int, bool]]] = {}
        ends = {id(piece): at for piece, at in margin}
        for vein, parts in zip(self.trace.veins, self.parts):
            chain: List[Tuple[int, bool]] = []
            for piece in parts:
                if piece.line is not None:
                    chain += [(k, True) for k in own[piece.number]]
                else:
                    a, b = (node_of[k] for k in ends[id(piece)])
                    if piece.forward:
                        chain += [(k, True) for k in stretch(a, b)]
                    else:
                        chain += [(k, False) for k in reversed(stretch(b, a))]
            veins[vein.name] = chain
            passed = [(branches[k].first if forward else branches[k].last) for k, forward in chain]
            if len(set(passed)) < len(passed) or not chain:
                self.problems.error(f"{vein.where}: comes back to a place where it has been, within the snapping distance of "
                                    f"{self.length_text(self.snap)}: choose --snap smaller, or redraw it")
        owner: Dict[int, Line] = {}
        for vein in self.trace.veins:
            for k, _ in veins[vein.name]:
                if owner.setdefault(k, vein) is not vein:
                    self.share_margin(vein, owner[k])
        root = stretch(*(node_of[k] for k in held_at))
        net = Network(nodes, branches, outline, veins, {}, root)
        for k, at in joints:
            self.choose_hinge(self.trace.joints[k], node_of[at], net)
        return net

    def choose_hinge(self, joint: JointMark, node: int, net: Network) -> None:
        """Returns the segments between which the joint at a node lies."""
        inside, ending = [], []
        for name, chain in net.veins.items():
            stops = chain_nodes(net, chain)
            if node in stops[1:-1]:
                inside.append(name)
            elif node in stops:
                ending.append(name)
        veins = joint.veins
        here = inside + ending
        if not veins:
            if here == inside and len(inside) == 1:
                veins = (inside[0],)
            elif len(here) == 2 and not inside:
                veins = tuple(here)
            elif len(here) > 1:
                first = inside[0] if inside else here[0]
                other = next(name for name in here if name != first)
                self.problems.error(f"{joint.where}: lies where the veins {', '.join(here)} meet: say which hinge it is, for "
                                    f"instance '{joint.name} @ {first}' inside that vein or '{joint.name} @ {first} > {other}' "
                                    "from one into the other")
                return
            else:
                self.problems.error(f"{joint.where}: lies at the end of vein '{here[0]}', where there is nothing to bend: move it")
                return
        away = [name for name in veins if name not in here]
        if away:
            self.problems.error(f"{joint.where}: vein '{away[0]}' does not pass there: move the joint, or name another vein")
        elif len(veins) == 1 and veins[0] not in inside:
            self.problems.error(f"{joint.where}: lies at the end of vein '{veins[0]}': name the vein into which it leads, too "
                                f"('{joint.name} @ {veins[0]} > ...')")
        else:
            net.joints[joint.name] = (tuple(veins), node)


def chain_nodes(net: Network, chain: List[Tuple[int, bool]]) -> List[int]:
    """Returns the nodes on a vein, in order."""
    stops = []
    for k, forward in chain:
        a, b = (net.branches[k].first, net.branches[k].last) if forward else (net.branches[k].last, net.branches[k].first)
        stops = stops or [a]
        stops.append(b)
    return stops


def build_network(trace: Trace, snap: float, problems: Problems) -> Optional[Network]:
    """Returns the network of a trace with lines joined within `snap` [m]. Mistakes are added to `problems`; None if there are
    any."""
    net = _Builder(trace, snap, problems).build()
    return None if problems.errors else net
