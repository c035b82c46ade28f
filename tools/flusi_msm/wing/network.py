# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a network from traced lines: it finds which veins meet each other and the margin, and where.

A traced line never ends exactly where it should. Ends within the snapping distance of another line are moved onto it, overshoots
are cut off, stretches of a vein along the margin become the margin itself, and lines that cross are joined. Larger deviations are
reported to the user as mistakes. All lengths are metres in the wing frame.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flusi_msm.errors import Problems
from flusi_msm.wing.meetings import OUTLINE, Meetings
from flusi_msm.wing.polyline import Polyline, runs
from flusi_msm.wing.trace import JointMark, Line, Trace
from flusi_msm.wing.vein_lines import Stretch

SNAP = 0.01          # snapping distance by the length of the wing


@dataclass
class Branch:
    """A line between two nodes without a node in between."""
    first: int
    last: int
    points: np.ndarray


@dataclass
class Network:
    """Lines between nodes, and what veins, joints and root are made of."""
    nodes: np.ndarray                                # (k, 2)
    branches: list[Branch]
    outline: list[int]                               # its branches in counter-clockwise order, all forward
    veins: dict[str, list[tuple[int, bool]]]         # branches of a vein in order; False: from last to first
    joints: dict[str, tuple[tuple[str, ...], int]]   # ((vein,) or (vein, vein)), node
    root: list[int]                                  # branches of the outline that are held


def stretch_between(branches: list[Branch], outline: list[int], a: int, b: int) -> list[int]:
    """Returns branches of the outline from one node to another, counter-clockwise."""
    i = next(i for i, k in enumerate(outline) if branches[k].first == a)
    found: list[int] = []
    while not found or branches[found[-1]].last != b:
        found.append(outline[(i + len(found)) % len(outline)])
    return found


class _Builder(Meetings):
    """Makes the network of a trace: the held part of the outline, joints, nodes, branches."""

    def root_stretch(self) -> tuple[float, float] | None:
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

    def stretch_where(self, flags: np.ndarray, s: np.ndarray, where: str) -> tuple[float, float] | None:
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

    def attach_joints(self) -> list[tuple[int, int]]:
        """Returns (number of the joint, attachment) of the joints that lie on a vein."""
        found = []
        for k, joint in enumerate(self.trace.joints):
            best = (np.inf, -1, 0.0, -1)
            for parts in self.parts:
                for piece in parts:
                    vein = self.trace.veins[piece.vein]
                    if joint.veins and vein.name not in joint.veins:
                        continue
                    if isinstance(piece, Stretch):
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
                reach = max(reach, max(d for _, d in self.trace.veins[best[3]].diameters or ()) / 2)
            if best[0] > reach:
                name = f"vein '{self.trace.veins[best[3]].name}'" if best[3] >= 0 else "any vein"
                told = f"{self.length_text(best[0])} from {name}" if best[3] >= 0 else "not on a vein"
                if not any(v in self.lost for v in joint.veins) and not self.is_at_lost(joint.place, reach):
                    self.problems.error(f"{joint.where}: is off its vein, {told}: move it onto the vein")
                continue
            found.append((k, self.place(best[1], best[2])))
        return found

    def along(self, piece: Stretch, s: float) -> float:
        """Returns where the outline's `s` lies along a stretch of the margin: 0 at its begin, 1 at its end."""
        begin, end = (piece.start, piece.stop) if piece.forward else (piece.stop, piece.start)
        whole = (end - begin) % self.outline.length
        part = (s - begin + 1e-6 * whole) % self.outline.length - 1e-6 * whole
        return part / whole

    def node_positions(self) -> tuple[np.ndarray, dict[int, int]]:
        """Returns the position of every node; and the number of the node of every top attachment."""
        groups: dict[int, list[int]] = {}
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

    def cut(self, carrier: int, nodes: np.ndarray, number: dict[int, int], branches: list[Branch]) -> list[int]:
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

    def build(self) -> Network | None:
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
                  for parts in self.parts for p in parts if isinstance(p, Stretch)]
        self.attach_ends()
        self.attach_crossings()
        joints = self.attach_joints()
        self.attach_corners([(piece.number, piece.line) for piece in self.carriers])
        if self.problems.errors or not held:
            return None
        self.divide_outline()
        nodes, number = self.node_positions()
        branches: list[Branch] = []
        outline = self.cut(OUTLINE, nodes, number, branches)
        own = {piece.number: self.cut(piece.number, nodes, number, branches) for piece in self.carriers}
        node_of = [number[self.att.top(k)] for k in range(len(self.att.s))]
        ends = {id(piece): (node_of[at[0]], node_of[at[1]]) for piece, at in margin}
        veins = self.lay_veins(branches, outline, own, ends)
        root = stretch_between(branches, outline, *(node_of[k] for k in held_at))
        net = Network(nodes, branches, outline, veins, {}, root)
        for k, at in joints:
            self.choose_hinge(self.trace.joints[k], node_of[at], net)
        return net

    def divide_outline(self) -> None:
        """Adds nodes in the middle of the largest gaps until the outline has three."""
        while sum(c == OUTLINE for c in self.att.carrier) < 3:
            stops = sorted(s for c, s in zip(self.att.carrier, self.att.s) if c == OUTLINE)
            gaps = [((b - a) % self.outline.length or self.outline.length, a) for a, b in zip(stops, stops[1:] + stops[:1])]
            gap, a = max(gaps)
            self.att.add(OUTLINE, (a + gap / 2) % self.outline.length)

    def lay_veins(self, branches: list[Branch], outline: list[int], own: dict[int, list[int]],
                  ends: dict[int, tuple[int, int]]) -> dict[str, list[tuple[int, bool]]]:
        """Returns the branches of each vein, and whether it passes them forward. `own` has the branches of each carrier, `ends` the
        nodes at the ends of each stretch of the outline."""
        veins: dict[str, list[tuple[int, bool]]] = {}
        for vein, parts in zip(self.trace.veins, self.parts):
            chain: list[tuple[int, bool]] = []
            for piece in parts:
                if not isinstance(piece, Stretch):
                    chain += [(k, True) for k in own[piece.number]]
                    continue
                a, b = ends[id(piece)]
                if piece.forward:
                    chain += [(k, True) for k in stretch_between(branches, outline, a, b)]
                else:
                    chain += [(k, False) for k in reversed(stretch_between(branches, outline, b, a))]
            veins[vein.name] = chain
            passed = [(branches[k].first if forward else branches[k].last) for k, forward in chain]
            if len(set(passed)) < len(passed) or not chain:
                self.problems.error(f"{vein.where}: comes back to a place where it has been, within the snapping distance of "
                                    f"{self.length_text(self.snap)}: choose --snap smaller, or redraw it")
        owner: dict[int, Line] = {}
        for vein in self.trace.veins:
            for k, _ in veins[vein.name]:
                if owner.setdefault(k, vein) is not vein:
                    self.share_margin(vein, owner[k])
        return veins

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


def chain_nodes(net: Network, chain: list[tuple[int, bool]]) -> list[int]:
    """Returns the nodes on a vein, in order."""
    stops: list[int] = []
    for k, forward in chain:
        a, b = (net.branches[k].first, net.branches[k].last) if forward else (net.branches[k].last, net.branches[k].first)
        stops = stops or [a]
        stops.append(b)
    return stops


def build_network(trace: Trace, snap: float, problems: Problems) -> Network | None:
    """Returns the network of a trace with lines joined within `snap` [m]. Mistakes are added to `problems`; None if there are
    any."""
    net = _Builder(trace, snap, problems).build()
    return None if problems.errors else net
