#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors that are declared three times too small, in msm_diagnose with `noise = estimated`: a misfit of this size is an alarm and does
not vanish into the size of the noise. The same data with the true errors are adequate. Forces on a flapping wing are in
flight_records.py.

usage: declared_errors.py <msm_diagnose> <h5dump> [tests]
"""
import math

import h5py
from ring_down_diagnose import ring
from synthetic_bending import ADEQUATE, UNKNOWN, diagnose, measure, seal
from vibration_diagnose import vibrate
from whole_program import check, main

FACTOR = 3.0
OPTIONS = "starts = 1;\ndraws = 500;\nrefits = 1;\nvalidation = no;\nintervals = no;\n"


def declare_less(case, file):
    """Divides all declared errors of values by FACTOR: those of heights, modes and records."""
    with h5py.File(case.folder / file, "r+") as data:
        def divide(_, item):
            for name in "sigma", "frequency_sigma", "damping_sigma", "height":
                if name in item.attrs:
                    item.attrs[name] = item.attrs[name] / FACTOR
            if item.name.endswith("/sigma"):
                item[...] = item[...] / FACTOR
        data.visititems(divide)
    seal(case.folder / file)


def check_both(case, options=OPTIONS):
    """The data are adequate with their true errors. With smaller ones the check of chi^2 is an alarm that says how much too small."""
    code, found = diagnose(case, "data.h5", "honest", options, parameters="E")
    check(code == ADEQUATE and found["noise"]["warning"] == "", f"{found['verdict']['sentence']}; {found['noise']['warning']}")
    declare_less(case, "data.h5")
    code, found = diagnose(case, "data.h5", "small", options, parameters="E")
    chi2, = (one for one in found["questions"] if one["name"] == "chi2")
    check(code == UNKNOWN, f"a chi^2 of {found['baseline']['chi2']:.0f} is {found['verdict']['sentence']}")
    # Bonferroni: the p of all is that of this check times the number of checks, of which there are fewer than 20, and 5.
    check(chi2["takes_part"] and found["verdict"]["log_global_p"] < chi2["log_p"] + math.log(100) < -10, f"chi^2 takes part: {chi2}")
    return found, chi2


def check_size(chi2):
    """The sentence has the factor. Of 100 numbers or more sqrt(chi^2) is within 4/sqrt(200) = 28 % of it but for a probability of 1e-4."""
    ratio = chi2["statistic"]**0.5
    check(abs(ratio / FACTOR - 1) < 0.28, f"errors are {ratio:.2f} times as large as declared")
    check(f"{ratio:.1f} times as large as the declared errors" in chi2["sentence"], chi2["sentence"])


def test_series(case):
    """A record of motion. No test of the catalogue sees it: the verdict gives the reason."""
    ring(case, "data.h5", lowpass=4000, order=2)
    found, chi2 = check_both(case)
    check_size(chi2)
    check(chi2["sentence"] in found["verdict"]["sentence"], found["verdict"]["sentence"])
    check("times as much as the declared errors allow" in found["noise"]["warning"], f"warning: {found['noise']['warning']}")


def test_modes(case):
    """Natural modes, with so many numbers that the tests leave some to estimate the size of the noise."""
    vibrate(case, "data.h5", stiffness={"E": 1.1e10}, sites=120, seed=5)
    check_size(check_both(case)[1])


def test_heights(case):
    """Heights whose errors neighbours have in common over a declared length: pixels do not show the size of such errors."""
    measure(case, "data.h5", stiffness={"plate": "edges"}, noise={"height": 3.0e-6, "correlated": 1.0e-5, "correlation_length": 1.0e-3})
    found, _ = check_both(case, OPTIONS + "observations = 150;\n")
    check("times as much as the declared errors allow" in found["noise"]["warning"], f"warning: {found['noise']['warning']}")


if __name__ == "__main__":
    main(globals())
