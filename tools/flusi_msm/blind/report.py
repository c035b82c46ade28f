# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints the results of a study: targets with point estimates and bounds, the errors for each cause, and the last line in JSON.
"""
from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flusi_msm.blind.calibration import fortran_of, try_on_even
from flusi_msm.blind.calibration import table_of as calibration_table
from flusi_msm.blind.ledger import dump, read, write
from flusi_msm.blind.scores import Case, calibration_error, confusion_of, scores_of

if TYPE_CHECKING:
    from flusi_msm.blind.archive import ArchivedStudy

KEYS = ("false_alarm_rate", "detection_snr5", "right_or_in_set_snr8", "single_right_snr8", "wrong_single_name_rate",
        "wrong_single_name_outside", "unknown_called_snr12")
REPEATS = 2000  # of the bootstrap


class StudyCase(Case):
    """A case of a study; a program that failed counts as a verdict of data_insufficient."""

    def __init__(self, name: str, truth: dict[str, Any], record: dict[str, Any]) -> None:
        super().__init__(name, truth, record.get("verdict") or {"verdict": "data_insufficient"})
        self.stratum, self.wing, self.record, self.truth = truth["stratum"], truth["wing"], record, truth


def collect(study: ArchivedStudy, folder: Path, count: int) -> tuple[list[StudyCase], dict[str, dict[str, Any]], dict[str, dict[str, Any]]]:
    """Returns (cases, records, oracles) of all that is finished."""
    cases, records, oracles = [], {}, {}
    for number in range(1, count + 1):
        path, place = (folder / f"{number:04d}{end}.json" for end in ("", ".oracle"))
        row = study.archive.rows.get(number, {})
        if not row and not path.exists():
            continue
        record, truth = row.get("record") or read(path), study.truth(number)
        case = StudyCase(f"{number:04d}", truth, record)
        cases.append(case)
        records[case.name] = record
        if "oracle" in row or not row and place.exists():
            oracles[case.name] = row.get("oracle") or read(place)
    return cases, records, oracles


def gain_of(oracles: Mapping[str, dict[str, Any]], cases: Sequence[Case]) \
        -> tuple[float | None, tuple[float, float] | tuple[None, None], int]:
    """Returns (gain of all extensions over that of all true causes, 95 % bounds by bootstrap over cases, number of cases); the
    first is None if there is no gain. An extension whose verdict names no cause counts as no gain."""
    says = {case.name: case.verdict in ("named", "consistent_with_set") for case in cases}
    rows = np.array([(one["gain"] if says[name] else 0.0, one["oracle"]) for name, one in oracles.items()
                     if one["oracle"] is not None])
    if len(rows) == 0 or rows[:, 1].sum() <= 0:
        return None, (None, None), len(rows)
    rng = np.random.default_rng(1)
    sums = rows[rng.integers(len(rows), size=(REPEATS, len(rows)))].sum(1)
    ends = np.quantile(sums[:, 0] / np.maximum(sums[:, 1], 1e-300), (0.025, 0.975))
    return float(rows[:, 0].sum() / rows[:, 1].sum()), (float(ends[0]), float(ends[1])), len(rows)


def table_of(title: str, scores: dict[str, Any]) -> str:
    """Returns the shares of a group of cases as a table of text."""
    lines = [f"{title}: {scores['cases']} cases", f"  {'':58} {'share':>7} {'of':>5}  {'95 % bounds':>15}  bar"]
    for row in scores["shares"].values():
        if not row["n"]:
            continue
        low, high = row["clopper_pearson_95"]
        bar = "" if row["bar"] is None else f"{100 * row['bar']:.0f} %" + ("" if row["is_met"] else "  missed")
        lines.append(f"  {row['title']:58} {100 * row['value']:6.1f}% {row['n']:5}  {100 * low:6.1f} to {100 * high:5.1f}"
                     f"  {bar}".rstrip())
    if scores["ece"] is not None:
        lines.append(f"  expected calibration error {scores['ece']:.3f} (bar 0.05), Brier score {scores['brier']:.3f}")
    if scores["gain_fraction_snr8"] is not None:
        lines.append(f"  share of the misfit on unseen data that the extension removes, SNR >= 8: "
                     f"{100 * scores['gain_fraction_snr8']:.1f} % (bar 90), {scores['gain_cases']} cases")
    if scores["intervals"]:
        low, high = scores["intervals_95"]
        lines.append(f"  90 % intervals that hold the truth: {100 * scores['interval_coverage']:.1f} % of "
                     f"{scores['intervals']} ({100 * low:.1f} to {100 * high:.1f}; bar 85 to 95)")
    return "\n".join(lines)


def causes_table(cases: Sequence[Case]) -> str:
    """Returns the verdicts on each hidden cause at signal-to-noise ratios of at least 8."""
    rows: dict[str, list[Case]] = {}
    for case in cases:
        if case.kind in ("single", "outside") and case.snr >= 8:
            rows.setdefault(("outside: " if case.kind == "outside" else "") + case.causes[0]["name"], []).append(case)
    lines = [f"  {'SNR >= 8':28} {'n':>3} {'named':>6} {'in set':>6} {'other set':>9} {'unknown':>8} {'adequate':>8} "
             f"{'wrong name':>10}"]
    for name, chosen in sorted(rows.items(), key=lambda item: (item[0].startswith("outside"), item[0])):
        true = chosen[0].causes[0]["name"]
        named = sum(c.is_named(true) for c in chosen)
        held = sum(c.holds(true) for c in chosen) - named
        other = sum(c.verdict == "consistent_with_set" and not c.holds(true) for c in chosen)
        lines.append(f"  {name:28} {len(chosen):3} {named:6} {held:6} {other:9} "
                     f"{sum(c.verdict == 'unknown_cause' for c in chosen):8} "
                     f"{sum(c.verdict == 'adequate' for c in chosen):8} {sum(c.names_wrongly() for c in chosen):10}")
    return "\n".join(lines)


def snr_table(scores: dict[str, Any]) -> str:
    """Returns verdicts by signal-to-noise ratio as a table of text."""
    lines = [f"  {'one cause of the catalogue, SNR':32} {'n':>4} {'found':>6} {'named':>6} {'in set':>6} {'wrong name':>10}"]
    for row in scores["by_snr"]:
        if row["n"]:
            end = "" if row["to"] is None else f" to {row['to']}"
            lines.append(f"  {str(row['from']) + end:32} {row['n']:4} {row['found']:6} {row['named']:6} {row['in_set']:6} "
                         f"{row['wrong_name']:10}")
    return "\n".join(lines)


def costs(cases: Sequence[StudyCase], kind: str) -> str:
    """Returns the CPU seconds of the stages of a study of this kind."""
    lines = []
    groups = (("section that flaps", list(cases)),) if kind == "flight" else (
        ("small wing, its mesh", [c for c in cases if c.wing == "small" and c.mesh == "same"]),
        ("small wing, finer mesh", [c for c in cases if c.wing == "small" and c.mesh == "finer"]),
        ("large wing", [c for c in cases if c.wing == "large"]))
    for title, chosen in groups:
        for word, some in (("adequate", [c for c in chosen if c.verdict == "adequate"]),
                           ("other verdicts", [c for c in chosen if c.verdict != "adequate"])):
            if some:
                lines.append(f"  {title + ', ' + word:38} {len(some):4} cases: made in "
                             f"{np.mean([c.truth['cpu_seconds'] for c in some]):5.1f} s, diagnosed in "
                             f"{np.mean([c.record['cpu_seconds'] for c in some]):6.1f} s (median "
                             f"{np.median([c.record['cpu_seconds'] for c in some]):.1f}) of CPU time")
    return "\n".join(lines)


def print_report(study: ArchivedStudy, folder: Path, count: int, figure: Path | None = None, map_file: Path | None = None) -> None:
    """Prints everything, the machine-readable line last; scores.json in the folder of verdicts has all of it. The map of
    probabilities goes to `map_file`."""
    cases, records, oracles = collect(study, folder, count)
    if not cases:
        print(f"{folder}: no verdicts")
        return
    parts = {"all": ("all", cases)}
    for mesh, title in (("same", "small wing, data from its mesh"), ("finer", "small wing, data from a finer mesh")):
        parts[mesh] = title, [c for c in cases if c.wing == "small" and c.mesh == mesh]
    parts["large"] = "wing of about 1000 points", [c for c in cases if c.wing == "large"]
    if study.kind == "flight":  # a section has no mesh
        parts = {"all": parts["all"]}
    scores = {name: scores_of(some) for name, (_, some) in parts.items()}
    for name, (title, some) in parts.items():
        if some:
            print(table_of(title, scores[name]))
    print(snr_table(scores["all"]))
    print(causes_table(cases))
    fraction, ends, n = gain_of(oracles, cases)
    if fraction is not None and ends[0] is not None:
        print(f"  gain on locations left out over that of the true cause, SNR >= 8: {100 * fraction:.1f} % of {n} cases "
              f"({100 * ends[0]:.1f} to {100 * ends[1]:.1f}; bar 90)")
    tried = try_on_even(cases)
    print(calibration_table(tried))
    if map_file:
        programs = sorted({record.get("program", "")[:12] for record in records.values()})
        map_file.write_text(fortran_of(tried, {"seed": study.seed, "cases": len(cases), "program": " ".join(programs)},
                                       map_file.stem))
    for case in cases:
        if case.names_wrongly():
            print(f"  wrong name in {case.name}: {case.sets} for {[c['name'] for c in case.causes] or 'nothing'}, "
                  f"{case.mesh}, {case.rig}, SNR {case.snr:.1f}")
    failed = [name for name, record in records.items() if "verdict" not in record]
    for name in failed:
        print(f"  no verdict on {name}: exit code {records[name]['exit_code']}, {records[name]['problem']}")
    print(costs(cases, study.kind))
    whole = scores["all"]
    # The map of a program was learned from the odd cases.
    is_mapped = any(case.probability != case.raw for case in cases)
    even = [case for case in cases if int(case.name) % 2 == 0]
    error = calibration_error(even)[0] if is_mapped else whole["ece"]
    result = {**{key: whole["shares"][key]["value"] for key in KEYS}, "ece": error, "gain_fraction_snr8": fraction,
              "interval_coverage": whole["interval_coverage"], "ece_raw_even": tried["ece_raw"],
              "ece_mapped_even": tried["ece_mapped"]}
    rows, columns, counts = confusion_of(cases)
    write(folder / "scores.json", dump({**result, "cases": len(cases), "gain_95": ends, "gain_cases": n, "failed": failed,
                                        "scores": scores, "confusion": {"rows": rows, "columns": columns,
                                                                        "counts": counts.tolist()}}))
    if figure:
        from flusi_msm.blind.picture import draw_confusion
        figure.parent.mkdir(parents=True, exist_ok=True)
        draw_confusion(figure, cases)
    print(json.dumps(result))
