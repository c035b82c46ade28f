# SPDX-License-Identifier: GPL-3.0-or-later
"""The map from stated probabilities to how often verdicts are right: against another formula of isotonic regression, and on
verdicts that are too sure of themselves by a known law."""
import re
import unittest

import numpy as np

from flusi_msm.blind.calibration import LEAST, LEAST_BLOCK, apply, fortran_of, knots_of, learn, pool, table_of, try_on_even
from flusi_msm.blind.scores import Case


def case(number, word, probability, is_right):
    """A single cause of the catalogue, or nothing, that got this verdict."""
    causes = [{"name": "drift", "is_known": True, "parameters": {}}] if word != "adequate" else []
    kind = "single" if causes else "null"
    if not is_right:
        causes, kind = ([], "null") if causes else ([{"name": "drift", "is_known": True, "parameters": {}}], "single")
    truth = {"kind": kind, "mesh": "same", "rig": "quiet", "snr": 9.0, "causes": causes}
    names = [{"names": ["drift"]}] if word in ("named", "consistent_with_set") else []
    return Case(f"{number:04d}", truth, {"verdict": word, "probability": probability, "causes": names})


def study(n, seed):
    """Names and sets that state p and are right with p^3, nulls that state p and are right with it."""
    rng = np.random.default_rng(seed)
    cases = []
    for number in range(1, n + 1):
        word, p = rng.choice(["adequate", "named", "consistent_with_set"]), rng.uniform(0.5, 1)
        cases.append(case(number, word, float(p), rng.random() < (p if word == "adequate" else p**3)))
    return cases


class Map(unittest.TestCase):
    def test_pool(self):
        """The isotonic regression at i is the largest over a <= i of the smallest over b >= i of the mean from a to b."""
        rng = np.random.default_rng(4)
        for n in 1, 7, 40:
            p = np.sort(rng.random(n))
            right = (rng.random(n) < p).astype(int)
            blocks = pool(p.tolist(), right.tolist())
            found = np.repeat([hits / count for _, hits, count in blocks], [count for _, _, count in blocks])
            exact = [max(min(right[a:b + 1].mean() for b in range(i, n)) for a in range(i + 1)) for i in range(n)]
            self.assertTrue(np.allclose(found, exact, atol=1e-14), n)
            self.assertAlmostEqual(sum(t * count for t, _, count in blocks), p.sum())
        self.assertEqual(len(pool([0.5] * 4, [0, 1, 0, 1])), 1)

    def test_knots(self):
        """Both ascend, and few verdicts make no certainty."""
        knots = knots_of([0.9, 0.95, 0.99], [1, 1, 1])
        self.assertEqual(len(knots), 1)
        self.assertAlmostEqual(knots[0][1], 3.5 / 4)
        p = np.linspace(0.3, 0.99, 60).tolist()
        (one, share), = knots_of(p, [0] + [1] * 59)
        self.assertAlmostEqual(one, np.mean(p))  # one wrong verdict, the least sure, is no block
        self.assertAlmostEqual(share, 59.5 / 61)
        shares = [share for _, share in knots_of(p, [0] * LEAST_BLOCK + [1] * (60 - LEAST_BLOCK))]
        self.assertTrue(np.allclose(shares, [0.5 / (LEAST_BLOCK + 1), (60.5 - LEAST_BLOCK) / (61 - LEAST_BLOCK)]))
        x, y = zip(*knots_of(*zip(*[(p / 100, int(p % 3 > 0)) for p in range(100)])))
        self.assertTrue(all(np.diff(x) > 0) and all(np.diff(y) >= 0) and min(y) > 0 and max(y) < 1)

    def test_learned(self):
        """2000 verdicts of which two thirds are too sure: mean of |p - p^3| over 0.5 .. 1 is 0.281, over all 0.19; with the map
        of 1000 odd ones what is left is scatter: sqrt(0.25/(1000/10)) per bin at most, a mean of 0.8 of that."""
        cases = study(2000, 5)
        tried = try_on_even(cases)
        self.assertGreater(tried["ece_raw"], 0.12)
        self.assertLess(tried["ece_mapped"], 0.04)
        self.assertEqual((tried["odd"], tried["even"]), (1000, 1000))
        self.assertEqual(set(tried["maps"]), {"adequate", "named", "consistent_with_set"})
        named = next(c for c in cases if c.verdict == "named" and 0.7 < c.raw < 0.8)
        self.assertLess(abs(apply(tried["maps"], named) - named.raw**3), 0.15)

    def test_even_cases_teach_nothing(self):
        cases = study(400, 6)
        self.assertEqual(learn(cases), learn([c for c in cases if int(c.name) % 2]))

    def test_few(self):
        """Too few of a kind: no map, and the module says so."""
        cases = study(2 * LEAST, 7)
        tried = try_on_even(cases)
        self.assertEqual(tried["maps"], {})
        self.assertEqual(tried["ece_raw"], tried["ece_mapped"])
        self.assertIn("none", table_of(tried))
        empty = fortran_of(tried, {"seed": 1, "cases": 40, "program": "0"}, "some_map")
        self.assertIn("KNOTS = 0", empty)
        self.assertIn("end module some_map\n", empty)

    def test_fortran(self):
        """The module holds all knots in the order of exit codes, and tells where they come from."""
        tried = try_on_even(study(2000, 5))
        text = fortran_of(tried, {"seed": 11, "cases": 2000, "program": "0123456789abcdef"}, "some_map")
        knots = [knot for word in ("adequate", "named", "consistent_with_set") for knot in tried["maps"][word]]
        numbers = [float(x) for x in re.findall(r"(\d\.\d{9})_rp", text)]
        self.assertTrue(np.allclose(numbers, [p for p, _ in knots] + [q for _, q in knots], atol=1e-9))
        self.assertIn(f"KNOTS = {len(knots)}\n", text)
        self.assertIn("study of seed 11, 1000 odd of 2000 cases, program 0123456789ab", text)
        self.assertLessEqual(max(map(len, text.splitlines())), 120)


if __name__ == "__main__":
    unittest.main()
