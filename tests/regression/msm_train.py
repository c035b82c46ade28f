#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""msm_train: finds what is known, on any number of ranks the same; refuses mistakes.

usage: msm_train.py <msm_train> <h5dump> <write_replicate> [tests]
"""
import math
import re

from training_case import OTHERS, TRUTH, WING, number, quick, replicate, same_outcome, training
from whole_program import EXIT_NUMERICAL, EXIT_USER, TRAIN_REFERENCE, check, live_keys, main, merged


def test_recovers(case):
    """Search and polish find the truth; the fragment holds it, and gives the same cost."""
    replicate(case)
    case.write("train.ini", training())
    done = case.run("train.ini", ranks=0)
    text = (case.folder / "trained.ini").read_text()
    found = {"E": number(r"\nE = (\S+);", text)}
    for name in ("joint:R4+5_base", "joint:R1_Rs"):
        found[name] = number(re.escape(name) + r" ([^,;]+)[,;]", text)
    # The prior of one decade draws by its distance (up to ln 3.3) times the square of the ratio of the standard
    # deviations (0.5 % at most over ln 10): 6e-6.
    for name, value in TRUTH.items():
        check(abs(math.log(found[name] / value)) < 1e-5, f"{name} is {value}, not {found[name]}")
        check(re.search(re.escape(name) + r": \S+ .*with 90 % confidence between", text), f"{name} has an interval")
    check("not measured" in text and "D = 2e-7; N m" in text and "cross_springs = no" in text, "D is quoted with E")
    check("\nz_side = left ventral;\n" in text, "and the side to which +z points")
    h = number(r"; h = +(\S+) m", text)
    check(h < 1e-10, f"nothing is left: {h}")
    check("does not fit" not in done.out + text, f"and no difference is told:\n{done.out}")
    check(number(r"from an earlier shape differ by at most +(\S+) m", done.out) < 1e-12, "warm and cold are the same")
    check((case.folder / "train.log").read_text().count("generation") >= 5, "the log tells the generations")
    check(re.search(r"polish +\d of \d starts end at this point", done.out), f"several starts agree:\n{done.out}")
    contents = case.contents("train_history.h5")
    check(any("covariance" in key for key in contents) and any("load_a" in key for key in contents), "all is saved")
    check_details(contents)
    case.write("again.ini", {"include": {"file": "trained.ini"}, "Wing": {"file": WING},
                             "Measurement": {"file": "replicate.h5"}})
    again = case.run("again.ini", "--evaluate", ranks=2)
    check(abs(number(r"\nh = +(\S+) m", again.out) - h) < 1e-4 * h + 1e-15, f"the same cost:\n{again.out}")
    far = case.write("far.ini", {"Wing": {"file": WING}, "Measurement": {"file": "replicate.h5"}})
    check(number(r"\nh = +(\S+) m", case.run(far, "--evaluate", ranks=0).out) > 1e-5, "which is not that of any wing")


def rows_of(contents, name, width):
    numbers = [float(x) for x in contents[name]]
    return [numbers[k:k + width] for k in range(0, len(numbers), width)]


def check_details(contents):
    """The path has one fit behind the other. Each goes down in every stage, and the lowest end is the outcome. Profiles pass the
    threshold where intervals end."""
    path = rows_of(contents, "path", 4)
    check(len(path) > 2 and all(a[0] < b[0] for a, b in zip(path, path[1:])), f"evaluations are counted: {path}")
    errors = [row[3] for row in path]
    check(errors == sorted(errors, reverse=True) and errors[0] > 10 and errors[-1] == 1, f"errors fall to 1: {errors}")
    rises = 0
    for stage in set(errors):
        sums = [chi2 / stage**2 + prior for _, chi2, prior, one in path if one == stage]
        rises += sum(b > a for a, b in zip(sums, sums[1:]))
    check(rises < len(path) / 4, f"the path goes down but where a fit begins, and a fit has several points: {path}")
    lowest = min((row for row in path if row[3] == 1), key=lambda row: row[1] + row[2])
    # The cold solution is another by 1e-12 m at most, of errors of 1e-7 m declared: 1e-5 of a residual, in each of n.
    n, chi2 = (float(next(v[0] for k, v in contents.items() if k.split("/")[-1] == name))
               for name in ("residuals", "chi2"))
    check(abs(lowest[1] - chi2) < 1e-5 * (2 * math.sqrt(n * max(chi2, lowest[1])) + n * 1e-5),
          f"and its lowest end is the outcome: {lowest}, {chi2}")
    # One decade about the values of [Wing]; parameters are known to 1e-5.
    prior = sum(math.log10(value / (12.58e9 if name == "E" else OTHERS))**2 for name, value in TRUTH.items())
    check(abs(lowest[2] - prior) < 1e-5, f"the priors are counted: {lowest[2]}, not {prior}")
    intervals = rows_of(contents, "intervals", 5)
    check(len(intervals) == len(TRUTH), "an interval of every parameter")
    for (lower, best, upper, *has), name in zip(intervals, ("E", "joint:R4+5_base", "joint:R1_Rs")):
        profile = rows_of(contents, name, 2)
        values = [value for value, _ in profile]
        check(values == sorted(values) and has == [1, 1], f"{name}: in ascending order, {has}")
        check(min(profile, key=lambda row: row[1]) == [best, 0], f"{name}: the minimum is 0")
        for end in (lower, upper):
            # The search of an end stops within 1 % of the threshold's root.
            above = next(chi2 for value, chi2 in profile if value == end)
            check(abs(math.sqrt(above / 2.705543454) - 1) < 0.0101, f"{name}: {above} at the end {end}")


def test_ranks(case):
    """1, 2, 3 and 7 ranks do the same to the bit, with a polish, its intervals and their profiles."""
    runs = []
    for ranks in (1, 2, 3, 7):
        runs.append(case.sub(f"ranks{ranks}"))
        replicate(runs[-1])
        runs[-1].write("train.ini", training(CMAES={"max_generations": 3}, Polish={"starts": 2}))
        runs[-1].run("train.ini", ranks=ranks)
    for run in runs[1:]:
        same_outcome(runs[0], run)


def test_paper(case):
    """The preset: linear box, population 16, two stages of which the second keeps E, cross-springs."""
    replicate(case)
    case.write("train.ini", training(Train={"preset": "paper"}, CMAES={"max_generations": 2}))
    done = case.run("train.ini", ranks=0)
    for word in ("16 candidates, weights paper", "linear", "stage 2", "cross-springs yes", "maxiter"):
        check(word in done.out, f"'{word}' is told:\n{done.out}")
    check("polish" not in done.out and "logarithmic" not in done.out, f"no polish:\n{done.out}")
    text = (case.folder / "trained.ini").read_text()
    check("cross_springs = yes" in text and ", without an uncertainty" in text, text)
    rows = [float(x) for x in next(v for k, v in case.contents("train_history.h5").items() if "generations" in k
                                   and len(v) == 4 * 15)]
    check([rows[15 * i] for i in range(4)] == [1, 1, 2, 2], "two generations in both stages")
    check(rows[15 * 2 + 12] == rows[15 * 3 + 12] and rows[12] != rows[15 + 12], "E stands still in the second")


def test_individuals(case):
    """Two individuals, one after another, each as if alone; the summary has their mean and sd."""
    replicate(case, "one.h5")
    replicate(case, "two.h5", E=1.0e10)
    ini = training(Measurement={"file": "one.h5, two.h5"}, CMAES={"max_generations": 3}, Polish={"intervals": "no"})
    case.write("train.ini", ini)
    done = case.run("train.ini", ranks=2)
    check("individual one, 1 of 2" in done.out and "individual two, 2 of 2" in done.out, done.out)
    for name in ("one", "two"):
        alone = case.sub(name)
        replicate(alone, f"{name}.h5", **({"E": 1.0e10} if name == "two" else {}))
        alone.write("train.ini", merged(ini, {"Measurement": {"file": f"{name}.h5"}}))
        alone.run("train.ini", ranks=0)
        a, b = case.contents(f"train_{name}_history.h5"), alone.contents("train_history.h5")
        check(len(a) > 10 and all(a[key] == b[key] for key in b if "measurement" not in key), f"{name} is as if alone")
        check(f"trained_{name}.ini" in case.files(), f"the wing of {name} is written")
    rows = [line.split(",") for line in (case.folder / "train_individuals.csv").read_text().splitlines()[1:]]
    table = {(row[0], row[1]): float(row[3]) for row in rows}
    check(len(rows) == 2 * 3 + 2 * 3, f"two individuals, mean and sd of three parameters: {rows}")
    one, two = table["one", "E"], table["two", "E"]
    # As in test_recovers; the prior draws a little farther here, with E at another distance.
    check(abs(one / 8e9 - 1) < 2e-5 and abs(two / 1e10 - 1) < 2e-5, f"both are found: {one}, {two}")
    check(math.isclose(table["mean", "E"], (one + two) / 2, rel_tol=1e-14), "the mean is the mean")
    check(math.isclose(table["sd", "E"], (two - one) / math.sqrt(2), rel_tol=1e-12), "the sd that of a sample")
    before = case.contents("train_two_history.h5")
    for path in case.folder.glob("train*_two*"):
        path.unlink()
    again = case.run("train.ini", "--restart", ranks=0)  # the first goes on from its end, the second anew
    check("there is no backup of two: the training starts from the beginning" in again.out, again.out)
    check(case.contents("train_two_history.h5") == before, "and ends as before")
    for changed, sentence in (({"Measurement": {"file": "one.h5, one.h5"}}, "two measurements are called 'one'"),
                              ({"Measurement": {"file": "one.h5, none.h5"}}, "'none.h5' does not exist"),
                              ({"Wing": {"file": f"{WING}, {WING}, {WING}"}}, "3 wings, but 2 measurements")):
        case.write("wrong.ini", merged(ini, changed))
        done = case.run("wrong.ini", ranks=0, code=EXIT_USER)
        check(done.err.count(sentence) == 1, f"{sentence}:\n{done.err}")
    check("is valid for one individual only" in case.run("train.ini", "--restart=x.h5", ranks=0, code=EXIT_USER).err, "no FILE")
    case.write("wings.ini", merged(ini, {"Wing": {"file": f"{WING}, {WING}"}}))
    case.run("wings.ini", "--check", ranks=0)


def test_infeasible(case):
    """Nothing is feasible: the program says so."""
    replicate(case)
    case.write("train.ini", quick(Train={"parameters": "E 1e8 1.01e8", "start": "wing"}, CMAES={"max_generations": 1, "lambda": 3},
                                  Solver={"factorisation_limit": 3}))
    done = case.run("train.ini", ranks=0, code=EXIT_NUMERICAL)
    check("no candidate was feasible" in done.out, done.out)


def test_screen(case):
    """Veins and joints are ranked; what is proposed can be sought."""
    replicate(case)
    case.write("train.ini", training())
    done = case.run("train.ini", "--screen", ranks=2)
    ranked = re.findall(r"^ +(\d+)  (\S+) .*(yes|no)$", done.out, re.M)
    check(len(ranked) == 1 + 14 + 10 and ranked[0][1] == "E" and ranked[0][2] == "yes", f"25 parameters:\n{done.out}")
    # E and the factors of all veins are one too many.
    check(done.out.count("infinite") >= 1 and ranked[-1][2] == "no", f"one is not determined:\n{done.out}")
    proposed = re.search(r"parameters = (.*)", done.out).group(1)
    case.write("next.ini", training(Train={"parameters": proposed}))
    case.run("next.ini", "--check", ranks=0)


def test_screen_numbers(case):
    """At the truth, where nothing else differs: the effects are those of a wing whose E is 0.1 % larger, and the third
    standard deviation is what a training of the first three says."""
    replicate(case)
    true = {"E": TRUTH["E"], "parameters": ", ".join(f"{name} {TRUTH[name]}" for name in TRUTH if name != "E")}
    case.write("train.ini", training(Wing=true))
    done = case.run("train.ini", "--screen", ranks=0)
    rows = re.findall(r"^ +\d+  (\S+) +(\S+) +(\S+) +(\S+) +(\S+) +yes$", done.out, re.M)
    check(rows[0][0] == "E" and len(rows) > 3, f"E is first:\n{done.out}")
    moved, effect, alone = map(float, rows[0][1:4])
    step = 1e-3
    case.write("more.ini", training(Wing={**true, "E": TRUTH["E"] * math.exp(step)}))
    more = case.run("more.ini", "--evaluate", ranks=0).out
    loads = [(int(n), float(chi2)) for n, chi2 in re.findall(r"^load_\w +\S+ +(\d+) +\S+ +\S+ +(\S+)", more, re.M)]
    check(len(loads) == 3, f"three loads:\n{more}")
    # Second order: the step, times a few. The table has three digits.
    seen = math.sqrt(sum(n * chi2 for n, chi2 in loads)) / step
    check(abs(effect / seen - 1) < 0.01, f"the effect over the noise is {seen}: {effect}")
    check(abs(alone * seen - 1) < 0.01, f"and E is known to {1 / seen}: {alone}")
    # h is the root of a sum over loads of mean squares.
    seen = 1e6 * 0.1 * number(r"\nh = +(\S+) m", more) / math.sqrt(len(loads)) / step
    check(abs(moved / seen - 1) < 0.01, f"10 % move the wing by {seen} um: {moved}")
    names = [row[0] for row in rows[:3]]
    case.write("next.ini", training(Wing=true, Train={"parameters": ", ".join(names), "start": "wing"},
                                    CMAES={"max_evaluations": 7, "sigma0": 1e-3}, Polish={"intervals": "no"}))
    told = case.run("next.ini", ranks=0).out
    sd = number(re.escape(names[2]) + r": .*predicted sd of the logarithm (\S+)", told)
    check(abs(float(rows[2][4]) / sd - 1) < 0.006, f"{names[2]} is known to {sd} beside the others: {rows[2][4]}")


def test_mistakes(case):
    """All mistakes are told together, with file, line and what is valid; nothing is written."""
    replicate(case)
    ini = training(Train={"parameters": "E 4e9, joint:R1_RS, E 3e9 1e9, joint:C_h 0 1 log, D, D, E:C 1 2 cubic",
                          "preset": "papier"}, CMAES={"lambda": -1}, Polish={"prior_decades": 0})
    case.write("train.ini", ini)
    done = case.run("train.ini", ranks=2, code=EXIT_USER)
    for sentence in ("'E 4e9' is not NAME", "'joint:R1_RS' is unknown", "did you mean 'joint:R1_Rs'?",
                     "'E': the upper bound must exceed", "'joint:C_h': a logarithmic scale needs positive bounds",
                     "'D' is given twice", "'cubic' is no scale", "did you mean 'paper'?", "[CMAES] lambda",
                     "[Polish] prior_decades"):
        check(done.err.count(sentence) == 1, f"'{sentence}' once:\n{done.err}")
    check("train.ini:" in done.err, "with the line")
    check(case.files() == ["replicate.h5", "train.ini"], f"nothing is written: {case.files()}")
    case.write("part.ini", "[Wing]\nk_e = 50;\n")
    for changed, sentence in (({"Measurement": {"file": "none.h5"}}, "'none.h5' does not exist"),
                              ({"Measurement": {"file": str(WING)}}, "schema"),
                              ({"CMAES": {"lambda": 2}}, "lambda must be at least 3"),
                              ({"CMAES": {"lambda": 8, "mu": 5}}, "[CMAES] mu: mu must be at most lambda/2 = 4"),
                              ({"CMAES": {"c_1": 0.6, "c_mu": 0.5}}, "[CMAES] c_1: c_1 + c_mu must not exceed 1"),
                              ({"CMAES": {"c_sigma": 1.5}}, "[CMAES] c_sigma"),
                              ({"CMAES": {"alpha_minus": 1, "weights": "positive"}}, "alpha_minus needs active"),
                              ({"Saving": {"result": "train.ini"}}, "train.ini is an input file and would be overwritten"),
                              ({"Saving": {"result": "replicate.h5"}}, "[Saving] result: replicate.h5 is an input file"),
                              ({"Saving": {"result": str(WING)}}, f"{WING} is an input file"),
                              ({"include": {"file": "part.ini"}, "Saving": {"result": "part.ini"}}, "part.ini is an input file"),
                              ({"Train": {"parameters": "joint:*", "stages": 2}}, "second stage fixes E"),
                              ({"Train": {"parameters": "D, thickness"}}, "change the same stiffness"),
                              ({"Train": {"parameters": ","}}, "the list is empty")):
        case.write("train.ini", training(**changed))
        done = case.run("train.ini", ranks=0, code=EXIT_USER)
        check(sentence in done.err, f"{sentence}:\n{done.err}")
    for words, sentence in ((["--restart"], "missing"), (["train.ini", "--chek"], "unknown argument"),
                            (["train.ini", "--check", "--screen"], "contradicts"),
                            (["train.ini", "--check", "--restart"], "is valid for a run only")):
        check(sentence in case.run(*words, ranks=0, code=EXIT_USER).err, sentence)
    case.write("train.ini", training())
    done = case.run("train.ini", "--restart", ranks=0, code=EXIT_USER)
    check("no valid backup" in done.err, done.err)


def test_check(case):
    """--check prints every documented key; the shipped case is valid."""
    replicate(case)
    case.write("train.ini", training())
    done = case.run("train.ini", "--check", ranks=2)
    reference = case.run("--parameters", ranks=0).out
    known = live_keys(reference)
    known.discard(("include", "file"))
    check(TRAIN_REFERENCE in reference and len(known) > 30, "the reference has keys")
    section, printed = "", set()
    for line in done.out.splitlines():
        section = line.strip("[]") if line.startswith("[") else section
        found = re.match(r"  (\S+) = ", line)
        if found:
            printed.add((section, found.group(1)))
    check(printed == known, f"every key: {printed ^ known}")
    case.write("train.ini", training(Train={"preset": "paper", "parameters": "E, joint:*"}, CMAES={"max_generations": 0}))
    done = case.run("train.ini", "--check", ranks=0)
    for key, value in (("lambda", 16), ("max_generations", 100), ("target", 1e-6), ("tolfun", 1e-11)):
        said = re.search(rf"^  {key} = (\S+); .*by the preset", done.out, re.M)
        check(said and float(said.group(1)) == value, f"{key} is {value}:\n{done.out}")
    for said in ("weights = paper", "constants = paper", "scale = linear", "cost = h", "stages = 2", "polish = no",
                 "cross_springs = yes", "outliers = keep"):
        check(re.search(rf"^  {said};", done.out, re.M), f"{said}:\n{done.out}")
    case.write("train.ini", done.out)
    again = case.run("train.ini", "--check", ranks=0)
    values = [re.findall(r"^  (.*); ", text, re.M) for text in (done.out, again.out)]
    check(values[0] == values[1], "what --check prints is an input with the same meaning")
    check(case.run("--help", ranks=2).out.count("usage:") == 1, "help is said once")


main(globals())
