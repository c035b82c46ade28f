# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes batches of blind cases, individual by individual, and the fixed cases of a design."""
from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from multiprocessing import Pool
from multiprocessing.pool import Pool as ProcessPool
from pathlib import Path
from typing import Any

from flusi_msm.bending.model import Stiffness
from flusi_msm.blind.cases import Individual, Options, draw_head, make_case
from flusi_msm.blind.ledger import Ledger, digest, dump, read, write
from flusi_msm.blind.oracle import Base
from flusi_msm.measurement.case import Case, Hidden, read_case
from flusi_msm.measurement.case_file import build, convert
from flusi_msm.measurement.file import write_test
from flusi_msm.measurement.synthesis import Bench, observe
from flusi_msm.results.files import InputError


def is_flight(path: str | Path) -> bool:
    """Returns whether a design is that of a flight."""
    data = read(Path(path))
    return isinstance(data, dict) and "kinematics" in data


def read_design(path: str | Path) -> tuple[Case, dict[str, dict[str, dict[str, Any]]]]:
    """Returns the case of a design, and its fixed cases {name: {section: {key: value}}}."""
    data = read(Path(path))
    fixed = data.pop("fixed", {}) if isinstance(data, dict) else {}
    case = read_case(path, drop=("fixed",))
    known = {"stiffness": Stiffness, "hidden": Hidden}
    for name, sections in fixed.items():
        for section, keys in sections.items():
            if section not in known:
                raise InputError(f"fixed.{name}.{section}: unknown; known are stiffness, hidden")
            build(known[section], keys, f"fixed.{name}.{section}")
    return case, fixed


def salt_of(seed: int, name: str) -> str:
    """Returns the salt of a case, without which a truth could be guessed from its hash; it cannot be found without the seed."""
    return hashlib.sha256(f"salt {seed} {name}".encode()).hexdigest()


def begin_batch(folder: Path, seed: int | None, contents: dict[str, Any]) -> tuple[Ledger, int]:
    """Returns (ledger, seed) of a batch that begins, or that continues with the seed that it has. Without a seed one is drawn
    and sealed. `contents` describes the batch."""
    ledger, key = Ledger(folder), folder / "sealed" / "seed.json"
    is_public = seed is not None
    if seed is None and ledger.cases:
        is_public = bool(read(key)["is_public"])
    number = seed if seed is not None else int(read(key)["seed"]) if ledger.cases else secrets.randbits(63)
    ledger.begin({**contents, "seed": number if is_public else "sealed"})
    write(key, dump({"seed": number, "is_public": is_public}))
    return ledger, number


def described(options: Options) -> dict[str, Any]:
    """Returns the options of a batch that its ledger keeps."""
    return {**asdict(options), "snr": list(options.snr), "meshes": list(options.meshes)}


def end_batch(folder: Path, ledger: Ledger, tell: Callable[[str], None]) -> None:
    """Prints how many cases there are, and whether their seed is known."""
    is_public = read(folder / "sealed" / "seed.json")["is_public"]
    tell(f"{ledger.path}: {len(ledger.cases)} cases; seed {'as given' if is_public else 'sealed'}")


def workers(jobs: int) -> ProcessPool | _Alone:
    """Returns a pool of so many processes, or this process alone."""
    return Pool(jobs) if jobs > 1 else _Alone()


def make_batch(design: Case, folder: Path, count: int, seed: int | None, options: Options, jobs: int, tell: Callable[[str], None]) -> None:
    """Makes those of the cases 1 to `count` that do not exist yet, each as soon as the shapes of its individual are known."""
    ledger, seed = begin_batch(folder, seed, {"design": digest(dump(asdict(replace(design, wing=Path(design.wing).name)))),
                                              "options": described(options)})
    groups: dict[int, list[int]] = {}
    for number in range(1, count + 1):
        if f"{number:04d}" not in ledger.cases:
            groups.setdefault(draw_head(seed, number, options)[1]["individual"], []).append(number)
    tasks = [(design, seed, who, numbers, options, folder) for who, numbers in sorted(groups.items())]
    done = 0
    with workers(jobs) as pool:
        for found in pool.imap_unordered(_make_group, tasks):
            for name, truth in found:
                ledger.seal(name, truth, salt_of(seed, name))
                done += 1
            tell(f"{done} of {sum(len(numbers) for numbers in groups.values())} cases")
    end_batch(folder, ledger, tell)


def _make_group(task: tuple[Case, int, int, list[int], Options, Path]) -> list[tuple[str, dict[str, Any]]]:
    design, seed, who, numbers, options, folder = task
    individual, found = Individual(design, seed, who), []
    for number in numbers:
        content, truth = make_case(seed, number, individual, options)
        write_test(folder / f"{number:04d}.h5", content)
        found.append((f"{number:04d}", truth))
    return found


class _Alone:
    """A pool with one worker, which is this process."""

    def __enter__(self) -> _Alone:
        self.imap_unordered = map
        return self

    def __exit__(self, *_: object) -> None:
        """Leaves exceptions as they are."""


def make_fixed(design: Case, fixed: Mapping[str, dict[str, dict[str, Any]]], names: Sequence[str], folder: Path,
               tell: Callable[[str], None]) -> None:
    """Makes fixed cases of one wing with open truths; their shapes are computed from those of the wing without hidden effects."""
    for name in names:
        if name not in fixed:
            raise InputError(f"no fixed case {name}; the design has {', '.join(sorted(fixed)) or 'none'}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from None
    base = Base(Bench(design))
    for number, name in enumerate(sorted(fixed)):
        if name not in names:
            continue
        case = replace(design, seed=design.seed + number, title=f"Bending test {number + 1}")
        for section, keys in fixed[name].items():
            part = getattr(case, section)
            case = replace(case, **{section: replace(part, **{
                key: convert(type(part), key, value, f"fixed.{name}.{section}.{key}") for key, value in keys.items()})})
        bench = Bench(case)
        shapes = [bench.bend(load, base.shapes[load.name]) for load in bench.loads()]
        content, truth = observe(bench, bench.loads(), shapes, bench.rest())
        write_test(folder / f"{name}.h5", content)
        write(folder / f"{name}.truth.json", json.dumps(truth, indent=1, default=lambda v: v.tolist()) + "\n")
        tell(str(folder / f"{name}.h5"))
