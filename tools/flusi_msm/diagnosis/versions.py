# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads diagnosis.json of both versions: what a file of version 1 says is put into the form of version 2."""
from __future__ import annotations

from typing import Any

from flusi_msm.errors import InputError

SCHEMA = "flusi-msm diagnosis"
NEWEST = 2
KINDS = ("bending", "modes", "series", "flight", "landmarks")


def upgraded(diagnosis: dict[str, Any], place: object) -> dict[str, Any]:
    """Returns a diagnosis in the form of version 2; `place` is its file, for messages. Of version 1 it is not known what each kind of
    data contributes to chi^2, unless there is one kind only, nor how well each was predicted."""
    version = diagnosis.get("schema_version")
    if diagnosis.get("schema") != SCHEMA or version not in (1, NEWEST):
        raise InputError(f"{place}: not a diagnosis of a version that this tool knows")
    if version == NEWEST:
        return diagnosis
    moved = ("modes", "series", "flight", "next_measurements", "new_loads")
    new = {key: value for key, value in diagnosis.items() if key not in moved}
    new["schema_version"] = NEWEST
    new["verdict"] = {**diagnosis["verdict"], "statement": statement_of(diagnosis["verdict"])}
    new["data"] = data_of(diagnosis)
    new["next"] = {"sentence": "", "measurements": measurements_of(diagnosis, new["data"])}
    return new


def statement_of(verdict: dict[str, Any]) -> str:
    """Returns the verdict with what was found of each of its causes."""
    found = [cause.get("finding", "") for cause in verdict["causes"]] if verdict["word"] in ("named", "consistent_with_set") else []
    return ". ".join(filter(None, [verdict["sentence"], *found]))


def data_of(diagnosis: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns the entries of `data` that a file of version 1 tells."""
    flight = diagnosis.get("flight")
    data: list[dict[str, Any]] = []
    if diagnosis["baseline"].get("loads", 1):
        data.append({"kind": "bending", "sets": []})
    if diagnosis.get("modes"):
        data.append({"kind": "modes", "sets": diagnosis["modes"]})
    if diagnosis.get("series"):
        data.append({"kind": "series", "sets": diagnosis["series"], "observations": sum(one["observations"] for one in diagnosis["series"])})
    if flight:
        sets = [{"name": f"{one['record']}:{one['component']}", "observations": len(one["time"]), **one} for one in flight["records"]]
        facts = {key: value for key, value in flight.items() if key != "records"}
        data.append({"kind": "flight", "sets": sets, "observations": sum(one["observations"] for one in sets), **facts})
    if len(data) == 1:
        data[0].update(observations=diagnosis["baseline"].get("observations"), baseline_chi2=diagnosis["baseline"]["chi2"])
        if "chi2" in diagnosis["extended"]:
            data[0]["extended_chi2"] = diagnosis["extended"]["chi2"]
    return data


def measurements_of(diagnosis: dict[str, Any], data: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Returns the measurements of version 1 in one list, the best one first."""
    kind_of = {one["name"]: entry["kind"] for entry in data for one in entry["sets"]}
    repeats = [{"kind": kind_of.get(one["repeat"], kind_of.get(one["repeat"].partition(":")[0], "bending")), **one}
               for one in diagnosis.get("next_measurements", [])]
    new = [{"kind": "bending", **one} for one in diagnosis.get("new_loads", [])]
    return sorted(repeats + new, key=lambda one: -one["separation_sd"])


def entry_of(diagnosis: dict[str, Any], kind: str) -> dict[str, Any]:
    """Returns the entry of a kind of data of a diagnosis of version 2, or one without sets."""
    return next((entry for entry in diagnosis["data"] if entry["kind"] == kind), {"kind": kind, "sets": []})
