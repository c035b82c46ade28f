# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes batches of blind cases, individual by individual, and the fixed cases of a design."""
import hashlib
import json
import secrets
from dataclasses import asdict, replace
from multiprocessing import Pool
from pathlib import Path

from flusi_msm.bending.model import Stiffness
from flusi_msm.blind.cases import Individual, draw_head, make_case
from flusi_msm.blind.ledger import Ledger, digest, dump, read, write
from flusi_msm.blind.oracle import Base
from flusi_msm.measurement.case import Hidden, read_case
from flusi_msm.measurement.case_file import build, convert
from flusi_msm.measurement.file import write_test
from flusi_msm.measurement.synthesis import Bench, observe
from flusi_msm.results.files import InputError


def is_flight(path):
    """Returns whether a design is that of a flight."""
    data = read(Path(path))
    return isinstance(data, dict) and "kinematics" in data


def read_design(path):
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


def salt_of(seed, name):
    """Returns the salt of a case, without which a truth could be guessed from its hash; it cannot be found without the seed."""
    return hashlib.sha256(f"salt {seed} {name}".encode()).hexdigest()


def begin_batch(folder, seed, contents):
    """Returns (ledger, seed) of a batch that begins, or that continues with the seed that it has. Without a seed one is drawn
    and sealed. `contents` describes the batch."""
    ledger, key = Ledger(folder), folder / "sealed" / "seed.json"
    is_public = seed is not None
    if ledger.cases and not is_public:
        seed, is_public = read(key)["seed"], read(key)["is_public"]
    elif seed is None:
        seed = secrets.randbits(63)
    ledger.begin({**contents, "seed": seed if is_public else "sealed"})
    write(key, dump({"seed": seed, "is_public": is_public}))
    return ledger, seed


def described(options):
    """Returns the options of a batch that its ledger keeps."""
    return {**asdict(options), "snr": list(options.snr), "meshes": list(options.meshes)}


def end_batch(folder, ledger, tell):
    """Prints how many cases there are, and whether their seed is known."""
    is_public = read(folder / "sealed" / "seed.json")["is_public"]
    tell(f"{ledger.path}: {len(ledger.cases)} cases; seed {'as given' if is_public else 'sealed'}")


def workers(jobs):
    """Returns a pool of so many processes, or this process alone."""
    return Pool(jobs) if jobs > 1 else _Alone()


def make_batch(design, folder, count, seed, options, jobs, tell):
    """Makes those of the cases 1 to `count` that do not exist yet, each as soon as the shapes of its individual are known."""
    ledger, seed = begin_batch(folder, seed, {"design": digest(dump(asdict(replace(design, wing=Path(design.wing).name)))),
                                              "options": described(options)})
    groups = {}
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
            tell(f"{done} of {sum(map(len, groups.values()))} cases")
    end_batch(folder, ledger, tell)


def _make_group(task):
    design, seed, who, numbers, options, folder = task
    individual, found = Individual(design, seed, who), []
    for number in numbers:
        content, truth = make_case(seed, number, individual, options)
        write_test(folder / f"{number:04d}.h5", content)
        found.append((f"{number:04d}", truth))
    return found


class _Alone:
    """A pool with one worker, which is this process."""

    def __enter__(self):
        self.imap_unordered = map
        return self

    def __exit__(self, *_):
        return False


def make_fixed(design, fixed, names, folder, tell):
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
            kinds = type(part).__dataclass_fields__
            case = replace(case, **{section: replace(part, **{
                key: convert(kinds[key], value, f"fixed.{name}.{section}.{key}") for key, value in keys.items()})})
        bench = Bench(case)
        shapes = [bench.bend(load, base.shapes[load.name]) for load in bench.loads()]
        content, truth = observe(bench, bench.loads(), shapes, bench.rest())
        write_test(folder / f"{name}.h5", content)
        write(folder / f"{name}.truth.json", json.dumps(truth, indent=1, default=lambda v: v.tolist()) + "\n")
        tell(str(folder / f"{name}.h5"))
