# SPDX-License-Identifier: GPL-3.0-or-later
"""Scores verdicts on the blind cases of tools/blind_generate: opens the sealed truths once all verdicts exist, and prints how often
alarms were false, causes were found, and causes were named rightly or wrongly, with 95 % bounds. It does so for all cases, and
separately for those on the mesh of the wing file and those on a finer one. The last line is JSON.

usage: blind_score FOLDER [--verdicts FOLDER/verdicts] [-o scores.json] [--figure confusion.png]

The verdict of case NNNN is NNNN.json in the folder of verdicts, or NNNN/diagnosis.json there; docs/results/blind-tests.md lists
the values that are read from it.
"""
from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

from flusi_msm.errors import InputError, run_command, tell_new_name


def verdicts_in(folder: Path) -> dict[str, Path]:
    """Returns the verdicts in a folder as {case: path}."""
    found = {path.stem: path for path in folder.glob("[0-9]*.json")}
    found.update({path.parent.name: path for path in folder.glob("[0-9]*/diagnosis.json")})
    return found


def main() -> None:
    """Does what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="of the batch")
    parser.add_argument("--verdicts", type=Path, metavar="DIR", help="default: FOLDER/verdicts")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="all scores as JSON")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="confusion matrix as a picture")
    options = parser.parse_args()
    from flusi_msm.blind.ledger import Ledger, dump, write
    from flusi_msm.blind.report import KEYS, table_of
    from flusi_msm.blind.scores import Case, scores_of
    if not (options.folder / "ledger.json").exists():
        raise InputError(f"{options.folder}: has no ledger of blind cases")
    opened = Ledger(options.folder).open(verdicts_in(options.verdicts or options.folder / "verdicts"))
    cases = [Case(name, *pair) for name, pair in sorted(opened.items())]
    scores = {"all": scores_of(cases)}
    for mesh in sorted({case.mesh for case in cases}):
        scores[mesh] = scores_of([case for case in cases if case.mesh == mesh])
    for name, title in (("all", "all"), ("same", "on the mesh of the wing file"), ("finer", "on a finer mesh")):
        if name in scores:
            print(table_of(title, scores[name]))
    if options.output:
        write(options.output, dump(scores))
    if options.figure:
        from flusi_msm.blind.picture import draw_confusion
        draw_confusion(options.figure, cases)
    every = scores["all"]
    print(json.dumps({"cases": every["cases"], **{key: every["shares"][key]["value"] for key in KEYS},
                      **{key: every[key] for key in ("ece", "gain_fraction_snr8", "interval_coverage")}}))


def command() -> None:
    """Runs the tool; mistakes become messages."""
    os.environ.setdefault("MPLBACKEND", "Agg")
    run_command("blind_score", main)


def old_command() -> None:
    """Runs the tool under its old name."""
    tell_new_name("blindscore", "blind_score")
    command()
