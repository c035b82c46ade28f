#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mechanics behind tools/make_measurement: derivatives, beams, plates, refinement and hidden effects against closed
forms.

usage: bending_mechanics.py
"""
import unittest
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
from scipy.integrate import solve_bvp

from flusi_msm.bending.jets import Jet, squared_angle
from flusi_msm.bending.mesh import locate, plan_hinges, refine
from flusi_msm.bending.model import Model, Stiffness
from flusi_msm.bending.statics import Path as LoadingPath
from flusi_msm.measurement.synthesis import rest_on_clamp, rotation
from flusi_msm.wing.file import Wing, read_wing

SOURCE = Path(__file__).resolve().parents[2]
SMALL = SOURCE / "wings/calliphora_small.h5"
LENGTH, WIDTH, YOUNG = 9e-3, 60e-6, 12.58e9
EI = YOUNG * pi * WIDTH**4 / 64


def chain(n):
    """A straight vein of n segments, clamped at x = 0."""
    points = np.zeros((n + 1, 3))
    points[:, 0] = np.linspace(0, LENGTH, n + 1)
    return Wing(points, np.zeros((0, 3), int), {"v": (list(range(n + 1)), np.full(n + 1, WIDTH))}, {}, [0])


def strip(columns, rows, length, chord, root, jitter=0.0):
    """A membrane -length..length by chord of right triangles with alternating diagonals; clamped at x = `root`."""
    x, y = np.meshgrid(np.linspace(-length, length, 2 * columns + 1), np.linspace(0, chord, rows + 1), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)
    rng = np.random.default_rng(4)
    inner = (np.abs(x.ravel()) < 0.999 * length) & (y.ravel() > 0) & (y.ravel() < chord)
    points[inner, :2] += jitter * rng.uniform(-1, 1, (inner.sum(), 2))
    number = np.arange(len(points)).reshape(x.shape)
    triangles = []
    for i in range(2 * columns):
        for j in range(rows):
            a, b, c, d = number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]
            triangles += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    clamped = np.flatnonzero(np.abs(points[:, 0] - root) < 1e-9)
    return Wing(points, np.array(triangles), {}, {}, clamped.tolist())


class Derivatives(unittest.TestCase):
    """Complex steps have no cancellation: agreement is that of round-off."""

    def setUp(self):
        self.model = Model(read_wing(SMALL), Stiffness(cross_springs=True, joint_hardening=3.0,
                                                       cuticle_hardening=1e-7, one_way=("C_Sc", 1.7),
                                                       damage=(5e-3, -5e-4, 1e-3, 0.3), orthotropy=0.4,
                                                       pretension=0.3, torsion=0.7))
        rng = np.random.default_rng(1)
        x = self.model.positions[:, 0]
        self.u = np.zeros((self.model.n_nodes, 3))
        self.u[:len(x)] = 2e-5 * rng.standard_normal((len(x), 3))
        self.u[:len(x), 2] += 30 * x**2
        self.u[len(x):] = 1e-4 * rng.standard_normal((self.model.n_nodes - len(x), 3))
        self.direction = rng.standard_normal(self.u.shape)

    def test_gradient(self):
        for part in (self.model.springs, self.model.turns, self.model.plate, *self.model.extras):
            u = self.u if part is self.model.plate else self.u[:len(self.model.positions)]
            d = self.direction[:len(u)]
            g = np.zeros(u.shape)
            part.add_gradient(u, g)
            step = part.energy(u + 1e-30j * d).imag / 1e-30
            self.assertLess(abs(step - (g * d).sum()), 1e-11 * np.abs(g * d).sum())

    def test_tangent(self):
        moves = self.model.moves
        d = np.where(moves[:, None], self.direction, 0)
        step = self.model.gradient(self.u + 1e-30j * d).imag[moves].ravel() / 1e-30
        k = self.model.tangent(self.u, self.model.springs.forces(self.u))
        self.assertLess(np.abs(k @ d[moves].ravel() - step).max(), 1e-11 * np.abs(step).max())
        self.assertLess(abs(k - k.T).max(), 1e-13 * abs(k).max())
        # What the stiff springs would hide.
        for part in (self.model.turns, *self.model.extras):
            g, h = part.derivatives(self.u)
            local = part.positions.shape
            d = self.direction[:local[0]]
            shifted, _ = part.derivatives(self.u[:local[0]] + 1e-30j * d)
            found = np.einsum("hiajb,hjb->hia", h, d[part.local])
            total, want = np.zeros(local), np.zeros(local)
            np.add.at(total, part.local.ravel(), found.reshape(-1, 3))
            np.add.at(want, part.local.ravel(), shifted.imag.reshape(-1, 3) / 1e-30)
            self.assertLess(np.abs(total - want).max(), 1e-11 * np.abs(want).max())

    def test_bent_vein(self):
        """A vein that is bent at rest, without a membrane that carries its normal."""
        wing = chain(4)
        wing.points[3:, 1] = 3e-4
        turns = Model(wing, Stiffness()).turns
        u, d = self.u[:len(turns.positions)], self.direction[:len(turns.positions)]
        g = np.zeros(u.shape)
        turns.add_gradient(u, g)
        step = turns.energy(u + 1e-30j * d).imag / 1e-30
        self.assertLess(abs(step - (g * d).sum()), 1e-11 * np.abs(g * d).sum())

    def test_angle(self):
        """(2 asin sqrt s)^2 and its derivatives: series and closed form agree where one takes over, up to the
        cancellation in the closed form, eps/s of the second derivative."""
        s = np.array([0.999e-3, 1.001e-3])
        jet = squared_angle(Jet(s, np.ones((2, 1)), np.zeros((2, 1, 1))))
        a, r = np.arcsin(np.sqrt(s)), s * (1 - s)
        np.testing.assert_allclose(jet.v, 4 * a**2, rtol=1e-14)
        np.testing.assert_allclose(jet.g[:, 0], 4 * a / np.sqrt(r), rtol=1e-14)
        np.testing.assert_allclose(jet.h[:, 0, 0], 2 / r - 2 * a * (1 - 2 * s) / r**1.5, rtol=2e-12)

    def test_rotation(self):
        model = Model(read_wing(SMALL), Stiffness(plate="edges", pretension=0.3, torsion=0.7))
        u = self.u[:model.n_nodes]
        turn = rotation([0.7, -1.1, 0.4])
        turned = (model.positions + u) @ turn.T - model.positions
        for part in (model.turns, model.springs, model.plate, *model.extras):
            self.assertLess(abs(part.energy(turned) - part.energy(u)), 1e-9 * part.energy(u))


class Membranes(unittest.TestCase):
    def test_film(self):
        """Raised along its slope s a film of tension T and area A has the energy T A (sqrt(1 + s^2) - 1), and its inner
        points are in equilibrium."""
        model = Model(strip(6, 4, 2e-3, 1e-3, -2e-3, jitter=5e-5), Stiffness(pretension=0.2))
        film, = model.extras
        u = np.zeros(model.positions.shape)
        u[:, 2] = 0.3 * model.positions[:, 0] + 0.4 * model.positions[:, 1]
        self.assertAlmostEqual(film.energy(u) / (0.2 * 4e-6 * (1.25**0.5 - 1)), 1, delta=1e-12)
        g = np.zeros(u.shape)
        film.add_gradient(0 * u, g)
        x, y = model.positions[:, 0], model.positions[:, 1]
        inner = (np.abs(x) < 1.99e-3) & (y > 1e-9) & (y < 0.99e-3)
        self.assertLess(np.abs(g[inner]).max(), 1e-12 * np.abs(g).max())

    def test_twist(self):
        """A strip about its vein, turned by a x at x: a triangle beside the vein is turned as its third corner is. Those of
        a segment are at one of its ends, alternately, so that the twist at every other hinge is a times two segments, up
        to the third order of it, and none between; a strip that is only bent has none."""
        wing = strip(8, 2, 4e-3, 1e-3, -4e-3)
        middle = np.flatnonzero(np.abs(wing.points[:, 1] - 0.5e-3) < 1e-9)
        vein = {"v": (middle[np.argsort(wing.points[middle, 0])].tolist(), np.full(len(middle), WIDTH))}
        model = Model(Wing(wing.points, wing.triangles, vein, {}, wing.root), Stiffness(torsion=0.5))
        twists, = model.extras
        x, y = model.positions[:, 0], model.positions[:, 1] - 0.5e-3
        a = 20.0
        u = np.zeros(model.positions.shape)
        u[:, 1], u[:, 2] = y * (np.cos(a * x) - 1), y * np.sin(a * x)
        step = 0.5e-3
        want = 7 * 0.5 * twists.k[0] * (2 * a * step)**2
        self.assertEqual(len(twists.k), 15)
        self.assertAlmostEqual(twists.energy(u) / want, 1, delta=1e-9)
        u[:] = 0
        u[:, 2] = 50 * x**2
        self.assertLess(twists.energy(u), 1e-12 * want)


class Beams(unittest.TestCase):
    def tip(self, n, force, **stiffness):
        model = Model(chain(n), Stiffness(**stiffness))
        load = model.zeros()
        load[n, 2] = force
        u, report = LoadingPath(model, largest=0.1).solve(load)
        self.assertTrue(report.converged and report.snaps == 0)
        return u[n]

    def test_cantilever(self):
        """Hinges EI/l, and 2 EI/l at the root, add up the flexibility by the trapezoidal rule, whose error for
        (L - x)^2 is 1/(2 N^2) of P L^3/(3 EI). Large deflections enter with the square of the angle, 1e-6."""
        force = 1e-3 * 3 * EI / LENGTH**2
        for n in (4, 12):
            self.assertAlmostEqual(self.tip(n, force)[2] / (1e-3 * LENGTH * (1 + 0.5 / n**2)), 1, delta=3e-6)

    def test_gradient_of_E(self):
        """E exp(g (x/L - 1/2)): the integral of (L - x)^2/E(x), by the same trapezoidal rule."""
        n, g, force = 24, 1.5, 1e-3 * 3 * EI / LENGTH**2
        x = np.linspace(0, 1, n + 1)
        flexible = (1 - x)**2 * np.exp(-g * (x - 0.5))
        want = 3e-3 * LENGTH * (flexible[:-1].sum() - flexible[0] / 2) / n
        self.assertAlmostEqual(self.tip(n, force, E_gradient=g)[2] / want, 1, delta=3e-6)

    def test_elastica(self):
        """P L^2/EI = 3: Euler's elastica as a boundary value problem. Second order in the length of the segments."""
        load = 3.0
        rod = solve_bvp(lambda s, y: [y[1], -load * np.cos(y[0])], lambda a, b: [a[0], b[1]], np.linspace(0, 1, 41),
                        np.ones((2, 41)), tol=1e-10)
        s = np.linspace(0, 1, 20001)
        angle = rod.sol(s)[0]
        exact = LENGTH * np.array([np.trapezoid(np.cos(angle) - 1, s), np.trapezoid(np.sin(angle), s)]) \
            if hasattr(np, "trapezoid") else LENGTH * np.array([np.trapz(np.cos(angle) - 1, s),
                                                               np.trapz(np.sin(angle), s)])
        errors = [np.abs(self.tip(n, load * EI / LENGTH**2)[[0, 2]] - exact).max() / LENGTH for n in (10, 20)]
        self.assertLess(errors[1], 1e-3)
        self.assertAlmostEqual(np.log2(errors[0] / errors[1]), 2, delta=0.1)

    def test_hardening(self):
        """M = k (1 + h Theta^2) Theta at one joint, the rest rigid: the angle solves the cubic equation."""
        wing = chain(2)
        wing.joints["j"] = ("v", 1)
        k, h, arm = 1e-6, 2.0, LENGTH / 2
        force = 5e-5
        model = Model(wing, Stiffness(E=1e16, joints={"j": k}, joint_hardening=h))
        load = model.zeros()
        load[2, 2] = force
        u, _ = LoadingPath(model).solve(load)
        angle = np.arcsin(u[2, 2] / arm)
        self.assertGreater(angle, 0.1)
        self.assertAlmostEqual(k * angle * (1 + h * angle**2) / (force * arm * np.cos(angle)), 1, delta=1e-4)

    def test_clamp(self):
        """A stiff wing on a soft clamp turns by C times the moment about the turned clamp."""
        wing, c = chain(2), 4e5
        model = Model(wing, Stiffness(E=1e16, root_compliance=(c, 0.0)))
        load = model.zeros()
        load[2, 2] = 1e-4
        u, _, turn = rest_on_clamp(model, LoadingPath(model), load)
        angle = -turn[1]
        self.assertAlmostEqual(angle / (c * 1e-4 * (LENGTH + u[2, 0])), 1, delta=1e-9)
        self.assertAlmostEqual(u[2, 2] / (LENGTH * np.sin(angle)), 1, delta=1e-4)


class Weights(unittest.TestCase):
    def test_total(self):
        """The weight of the wing is that of its frustums and its membrane, and acts at their common centre."""
        wing = read_wing(SMALL)
        model = Model(refine(wing), Stiffness())
        force = model.weights((0, 0, -9.81), 1300.0, 3e-3)
        weight = -9.81 * (wing.vein_mass() + 3e-3 * wing.areas().sum())
        self.assertAlmostEqual(force[:, 2].sum() / weight, 1, delta=1e-12)
        fine = Model(refine(model.wing), Stiffness()).weights((0, 0, -9.81), 1300.0, 3e-3)
        self.assertAlmostEqual(fine[:, 2].sum() / force[:, 2].sum(), 1, delta=1e-12)
        finer = refine(model.wing).points
        centre, other = force[:model.n_points, 2] @ model.wing.points, fine[:len(finer), 2] @ finer
        np.testing.assert_allclose(other, centre, rtol=0, atol=1e-12 * np.abs(centre).max())

    def test_beam(self):
        """A light beam under its weight: q L^4/(8 EI), by the trapezoidal rules of the hinges and of the masses, whose
        errors are of the second order."""
        errors = []
        for n in (8, 16):
            model = Model(chain(n), Stiffness())
            load = model.weights((0, 0, 1e-2), 1300.0, 0.0)
            u, _ = LoadingPath(model).solve(load)
            line = 1300.0 * pi / 4 * WIDTH**2 * 1e-2
            errors.append(abs(u[n, 2] / (line * LENGTH**4 / (8 * EI)) - 1))
        self.assertLess(errors[1], 0.01)
        self.assertAlmostEqual(np.log2(errors[0] / errors[1]), 2, delta=0.1)

    def test_wave(self):
        """E (1 + a sin(2 pi s/length)) of one vein: at a quarter and three quarters of a wave the factors are 1 + a
        and 1 - a, at the half 1."""
        model = Model(chain(12), Stiffness(E_wave=("v", 0.4, LENGTH)))
        np.testing.assert_allclose([model.young("v", k) / YOUNG for k in (3, 6, 9)], [1.4, 1, 0.6], rtol=1e-12)
        k = model.turns.k / Model(chain(12), Stiffness()).turns.k
        np.testing.assert_allclose([k[2], k[5], k[8]], [1.4, 1, 0.6], rtol=1e-12)


class Plates(unittest.TestCase):
    def test_quadratic_shapes(self):
        """Morley's triangles hold every constant curvature exactly, on any mesh; the sums over edges do so for
        cylinders along the edges of right triangles."""
        wing = strip(4, 5, 3e-3, 4e-3, 0.0, jitter=2e-4)
        x, y = wing.points[:, 0], wing.points[:, 1]
        area = wing.areas().sum()
        for poisson in (-1 / 3, 0.3):
            model = Model(wing, Stiffness(poisson=poisson))
            for cxx, cyy, cxy in ((1.0, 0, 0), (0, 1.0, 0), (0.3, -0.8, 0.6)):
                u = np.zeros((model.n_nodes, 3))
                u[:len(x), 2] = (cxx * x**2 + cyy * y**2) / 2 + cxy * x * y
                a, b = model.edges.ends.T
                side = wing.points[b, :2] - wing.points[a, :2]
                normal = np.stack([side[:, 1], -side[:, 0]], 1) / np.linalg.norm(side, axis=1)[:, None]
                middle = (wing.points[a, :2] + wing.points[b, :2]) / 2
                slope = np.stack([cxx * middle[:, 0] + cxy * middle[:, 1], cyy * middle[:, 1] + cxy * middle[:, 0]], 1)
                u[model.n_nodes - model.plate.n_slopes:, 2] = (slope * normal).sum(1) * model.plate.scale
                exact = model.stiffness.D * area / 2 * ((cxx + cyy)**2 - 2 * (1 - poisson) * (cxx * cyy - cxy**2))
                self.assertAlmostEqual(model.plate.energy(u) / exact, 1, delta=1e-12)

    def test_equilateral(self):
        """On equilateral triangles the sums over edges are the law for nu = -1/3: per area D kappa^2/2 for cylinders
        in any direction and 4/3 of D kappa^2 for saddles. Edges far from the boundary count, and per edge the energy
        belongs to a third of both triangles."""
        n, h = 12, 1e-4
        i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
        points = np.stack([(i + j / 2).ravel() * h, (j * np.sqrt(0.75)).ravel() * h, 0.0 * i.ravel()], 1)
        number = np.arange(n * n).reshape(n, n)
        a, b, c, d = (q.ravel() for q in (number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]))
        wing = Wing(points, np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]), {}, {}, [0])
        model = Model(wing, Stiffness(plate="edges"))
        local = points[model.plate.nodes].mean(1)
        inner = np.flatnonzero(np.linalg.norm(local - points.mean(0), axis=1) < 3 * h)
        share = 2 * (np.sqrt(0.75) / 2 * h * h) / 3
        kinds = np.round(np.degrees(np.arctan2(*(points[model.plate.nodes[inner, 1]]
                                                 - points[model.plate.nodes[inner, 0]])[:, 1::-1].T))) % 180
        self.assertEqual(set(kinds), {0, 60, 120})
        for turn in (0.0, 0.4, 1.3):
            p, q = points[:, 0] * np.cos(turn) + points[:, 1] * np.sin(turn), \
                points[:, 1] * np.cos(turn) - points[:, 0] * np.sin(turn)
            for w, density in ((p**2 / 2, 0.5), ((p**2 - q**2) / 2, 4 / 3)):
                local = w[model.plate.nodes[inner]]
                each = 0.5 * np.einsum("ei,eij,ej->e", local, model.plate.blocks[inner], local)
                mean = np.mean([each[kinds == kind].mean() for kind in (0, 60, 120)])
                self.assertAlmostEqual(mean / share / (model.stiffness.D * density), 1, delta=1e-9)

    def test_strip(self):
        """A strip that is held along its middle line and loaded at both ends: P L^3/(3 D b) without Poisson's
        contraction; the triangles converge with the second order."""
        length, chord, errors = 6e-3, 2e-3, []
        for columns in (6, 12):
            wing = strip(columns, columns // 3, length, chord, 0.0)
            model = Model(wing, Stiffness(poisson=0.0))
            ends = np.flatnonzero(np.abs(np.abs(wing.points[:, 0]) - length) < 1e-9)
            exact = 1e-3 * length
            force = exact * 3 * model.stiffness.D * chord / length**3
            load = model.zeros()
            share = np.where((wing.points[ends, 1] < 1e-9) | (wing.points[ends, 1] > chord - 1e-9), 0.5, 1.0)
            load[ends, 2] = force * share / (columns // 3)
            u, report = LoadingPath(model).solve(load)
            errors.append(abs(u[ends, 2].mean() / exact - 1))
        print(f"plate strip: errors {errors[0]:.2e} {errors[1]:.2e}")
        self.assertLess(errors[1], 0.01)
        self.assertAlmostEqual(np.log2(errors[0] / errors[1]), 2, delta=0.4)


class Cambers(unittest.TestCase):
    camber = (1.2e-4, 4e-4, -2e-4)

    def test_rest(self):
        """The cambered wing is free of stress as it is, and when it is turned as a whole: points, ghosts and slopes."""
        model = Model(read_wing(SMALL), Stiffness(camber=self.camber))
        length = np.linalg.norm(model.springs.d0, axis=1).min()
        angle = 1e-15 * model.turns.k.max() / length        # [N] rounding of a hinge's angle
        stretch = 1e-15 * model.springs.k.max() * model.span  # and of a spring's elongation
        zero = np.zeros((model.n_nodes, 3))
        self.assertGreater(np.ptp(model.wing.points[:, 2]), 3e-4)
        self.assertLess(abs(model.energy(zero)), angle * length)
        bent = np.abs(np.einsum("eij,ej->ei", model.plate.blocks, model.bending.z0[model.plate.nodes])).max()
        self.assertLess(np.abs(model.gradient(zero)).max(), angle)
        self.assertGreater(bent, 1e3 * stretch)  # what the camber's moments would be if they did not turn
        turn, n = rotation([0.3, -0.8, 0.5]), len(model.positions)
        moved = np.zeros((model.n_nodes, 3))
        moved[:n] = model.positions @ turn.T - model.positions
        # A slope is the derivative of the position along the edge's normal: (n, dz0) at rest.
        a, b = (read_wing(SMALL).points[model.edges.ends[:, k], :2] for k in range(2))
        normal = np.stack([(b - a)[:, 1], -(b - a)[:, 0], 0 * a[:, 0]], 1) / np.linalg.norm(b - a, axis=1)[:, None]
        rest = normal * model.plate.scale
        rest[:, 2] = model.bending.z0[n:]
        moved[n:] = rest @ turn.T - rest
        self.assertLess(np.abs(model.gradient(moved)).max(), 10 * stretch)

    def test_derivatives(self):
        model = Model(read_wing(SMALL), Stiffness(camber=self.camber))
        rng = np.random.default_rng(2)
        u, n = 2e-5 * rng.standard_normal((model.n_nodes, 3)), len(model.positions)
        u[:n, 2] += 20 * model.positions[:, 0]**2
        d = 1e-6 * rng.standard_normal(u.shape)
        for part in (model.turns, model.bending):
            sides = [part.derivatives(u + s * d, False)[0] for s in (1e-3, -1e-3)]
            g, h = part.derivatives(u)
            local = part.local if part is model.turns else part.nodes
            found = np.einsum("hiajb,hjb->hia", h, d[local])
            if part is model.bending:
                found += np.einsum("eij,ejk->eik", model.plate.blocks, d[local])
            total, want = np.zeros(u.shape), np.zeros(u.shape)
            np.add.at(total, local.ravel(), found.reshape(-1, 3))
            np.add.at(want, local.ravel(), ((sides[0] - sides[1]) / 2e-3).reshape(-1, 3))
            self.assertLess(np.abs(total - want).max(), 1e-6 * np.abs(want).max())  # of central differences
            step = (part.energy(u + 1e-3 * d) - part.energy(u - 1e-3 * d)) / 2e-3
            whole = np.zeros(u.shape)
            part.add_gradient(u, whole)
            self.assertAlmostEqual((whole * d).sum() / step, 1, delta=1e-6)

    def test_small(self):
        """Camber goes to zero like the flat wing, and its sign matters like that of the load."""
        wing, moved = read_wing(SMALL), {}
        for arch, force in ((0.0, 1e-3), (1e-9, 1e-3), (1e-4, 1e-3), (1e-4, -1e-3), (-1e-4, -1e-3)):
            model = Model(wing, Stiffness(camber=(arch, 0.0, 0.0)))
            load = model.point_load((0.00405, 0.00066), (0, 0, force))
            u, report = LoadingPath(model).solve(load)
            moved[arch, force] = (load * u).sum() / 1e-3
        self.assertAlmostEqual(moved[1e-9, 1e-3] / moved[0.0, 1e-3], 1, delta=1e-4)
        self.assertAlmostEqual(moved[1e-4, 1e-3] / moved[-1e-4, -1e-3], 1, delta=1e-6)
        self.assertGreater(abs(moved[1e-4, 1e-3] / moved[1e-4, -1e-3] - 1), 1e-3)


class Meshes(unittest.TestCase):
    def test_refinement(self):
        """The refined wing is the same wing: area, veins, joints and root; its veins hinge at the same points."""
        wing = read_wing(SMALL)
        fine = refine(wing)
        self.assertEqual(len(fine.triangles), 4 * len(wing.triangles))
        self.assertTrue((fine.areas() > 0).all())
        self.assertAlmostEqual(fine.areas().sum() / wing.areas().sum(), 1, delta=1e-12)
        self.assertAlmostEqual(fine.smallest_angle(), wing.smallest_angle(), delta=1e-9)
        np.testing.assert_array_equal(fine.points[:len(wing.points)], wing.points)
        edges = set(map(tuple, fine.edges()[0].tolist()))
        for name, (nodes, diameters) in fine.veins.items():
            self.assertTrue(all((min(p), max(p)) in edges for p in zip(nodes[:-1], nodes[1:])))
            np.testing.assert_allclose(diameters[1::2], (diameters[:-1:2] + diameters[2::2]) / 2, rtol=1e-14)
            self.assertEqual(nodes[::2], wing.veins[name][0])
        self.assertEqual({j: fine.joint_nodes(j)[1] for j in fine.joints}, {j: wing.joint_nodes(j)[1]
                                                                           for j in wing.joints})
        coarse_hinges, fine_hinges = plan_hinges(wing)[0], plan_hinges(fine)[0]
        self.assertEqual(sorted(h.joint for h in coarse_hinges if h.joint), sorted(wing.joints))
        self.assertEqual(sorted(h.joint for h in fine_hinges if h.joint), sorted(wing.joints))
        inner = {h.nodes[1] for h in fine_hinges if h.nodes[1] < len(wing.points)}
        self.assertEqual(inner, {h.nodes[1] for h in coarse_hinges})

    def test_locate(self):
        wing = read_wing(SMALL)
        corners, shares = locate(wing.points, wing.triangles, (5e-3, -1e-3))
        np.testing.assert_allclose(shares @ wing.points[corners], [5e-3, -1e-3, 0], atol=1e-18)
        self.assertAlmostEqual(shares.sum(), 1, delta=1e-12)

    def test_damage(self):
        """A disc with factor 1 changes nothing, a soft one softens, and only near it."""
        wing = read_wing(SMALL)
        plain = Model(wing, Stiffness())
        same = Model(wing, replace(plain.stiffness, damage=(5e-3, 0.0, 1e-3, 1.0)))
        soft = Model(wing, replace(plain.stiffness, damage=(5e-3, 0.0, 1e-3, 0.2)))
        np.testing.assert_array_equal(plain.turns.k, same.turns.k)
        near = np.linalg.norm(wing.points[plain.turns.nodes[:, 1], :2] - [5e-3, 0.0], axis=1)
        ratio = soft.turns.k / plain.turns.k
        np.testing.assert_allclose(ratio[near > 1.05e-3], 1, rtol=1e-14)
        np.testing.assert_allclose(ratio[near < 0.95e-3], 0.2, rtol=1e-14)
        self.assertGreater((near < 0.95e-3).sum(), 3)


if __name__ == "__main__":
    unittest.main()
