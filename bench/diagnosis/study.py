# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies how well msm_diagnose finds hidden causes: runs many blind cases and gives their scores with 95 % bounds, and the share
of the gain that the true cause would bring. The last line is JSON.

usage: bench/diagnosis/run [--kind bending|vibration|joint|flight] [--cases N] [--seed S] [--folder runs/bench_diagnosis]
                       [--program build/release/bin/msm_diagnose]
                       [--jobs 1] [--ranks 1] [--shard K/N] [--only generate|diagnose|score] [--hours H]
                       [--archive bench/diagnosis/diagnosis_study.jsonl] [--figure docs/images/diagnosis_confusion.png]
                       [--write-map src/inference/probability/inference_probability_of_KIND.f90]

The whole study has 762 cases: on the small blowfly wing 250 without a hidden cause (nulls), 200 with causes outside the
catalogue, and 60 with causes of the catalogue in each of five ranges of the signal-to-noise ratio; and 12 cases on the wing of
1015 points. --kind vibration has 300 cases with natural modes, a record of a free vibration, or both: 100 nulls, 50 with causes
outside the catalogue, 150 with causes of it. --kind joint has 174 cases with bending tests and modes of the same wing, 24 of them
with two causes. --kind flight has 60 cases with records of forces on a section that flaps: 20 nulls, 10 with causes outside the
catalogue, 30 with causes of it. Cases are mixed so that the first N cases are a sample of all, and each has its own random numbers.
Every case that is finished is a file; a
study that was stopped, at any time, is continued by the same command. Shards K/N of one study may run on several machines with a
common folder. Verdicts of different programs, which are distinguished by their SHA-256, are kept separately in the same folder.
The archive is one file with all verdicts and truths; the study can be scored from it, or continued without the contents of the
folder. Results are in docs/results/diagnosis-results.md.
"""
import argparse
import fcntl
import hashlib
import json
import os
import secrets
import shutil
import sys
import time
from contextlib import contextmanager
from multiprocessing import Pool
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
os.environ.setdefault("MPLBACKEND", "Agg")
sys.dont_write_bytecode = True
from flusi_msm.errors import InputError, run_command

ROOT = Path(__file__).resolve().parents[2]
DESIGNS = {"bending": "ini/blind.json", "vibration": "ini/blind.json", "joint": "ini/blind.json", "flight": "ini/blind-flight.json"}
VERDICT_CODES = (0, 10, 11, 12, 20)
WING = ROOT / "wings/calliphora_small.h5"
INPUT = {"Wing": {"E": "12.58e9", "D": "2.0e-7"}, "Measurement": {}, "Instrument": {},
         "Diagnose": {"parameters": "E, joint:*"}, "Next": {"modes": "0"}, "Saving": {"name": "diagnosis"}}
# No score asks what to measure next, and the ranking of modes and releases would take a third of the time.
# Lines of the kinds of study: modes and records contain too little information about ten joints; the errors are those that are
# declared.
LINES = {"bending": {}, "vibration": {"parameters": "E", "noise": "declared"}, "joint": {},
         "flight": {"noise": "declared"}}
CPU_SECONDS = {"bending": (30, 0), "vibration": (15, 0), "joint": (30, 0), "flight": (8, 45)}  # of a case; and of an individual once


def ini_text(case, wing, measurement, more=None, kind="bending"):
    """Returns the input file of msm_diagnose. It asks for the bands for differences of mesh if the data come from another mesh
    than the wing's."""
    sections = {name: dict(keys) for name, keys in INPUT.items()}
    sections["Wing"]["file"] = wing
    sections["Measurement"]["file"] = measurement
    sections["Diagnose"].update(LINES[kind])
    if kind == "flight":
        del sections["Diagnose"]["parameters"]
    else:
        sections["Diagnose"]["refine"] = "auto" if case["mesh"] == "finer" else "no"
    for name, keys in (more or {}).items():
        sections.setdefault(name, {}).update(keys)
    return "".join(f"[{name}]\n" + "".join(f"{key} = {value};\n" for key, value in keys.items())
                   for name, keys in sections.items() if keys)


def run(command, folder):
    """Runs a program in a folder of its own and returns (exit code, CPU seconds, last line on stderr)."""
    with open(folder / "out", "wb") as out, open(folder / "err", "wb") as err:
        child = os.posix_spawnp(command[0], command, os.environ, file_actions=[
            (os.POSIX_SPAWN_DUP2, out.fileno(), 1), (os.POSIX_SPAWN_DUP2, err.fileno(), 2)])
        _, status, usage = os.wait4(child, 0)
    text = (folder / "err").read_text(errors="replace").strip().splitlines()
    return os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, text[-1] if text else ""


class Diagnoses:
    """The verdicts of one program on the cases of a study."""

    def __init__(self, study, program, ranks):
        self.study, self.program, self.ranks = study, program, ranks
        self.sha256 = hashlib.sha256(program.read_bytes()).hexdigest()
        self.folder = study.folder / f"verdicts-{self.sha256[:12]}"

    def done(self, number):
        return (self.folder / f"{number:04d}.json").exists()

    def diagnose(self, number):
        """Writes the verdict on a case. If a cause other than the true one was added, it then also writes what the true one
        would have gained. The truth is read only after the verdict."""
        from flusi_msm.blind.ledger import dump, read, write
        path = self.folder / f"{number:04d}.json"
        if not path.exists():
            facts = read(self.study.folder / "sealed" / f"{number:04d}.json")["truth"]
            with self.flights(facts) as lines:
                write(path, dump({"program": self.sha256, **self.once(number, facts, lines)}))
        place = self.folder / f"{number:04d}.oracle.json"
        truth = self.study.truth(number)
        if self.study.wants_oracle(truth) and not place.exists():
            write(place, dump(self.oracle(number, truth, read(path))))

    @contextmanager
    def flights(self, facts):
        """Gives the lines of [Flight], none for other kinds. The simulated flights of all cases of an individual are kept together,
        and one diagnosis at a time makes them."""
        if self.study.kind != "flight":
            yield None
            return
        from flusi_msm.blind.flight_input import write_section
        from flusi_msm.blind.flight_study import FACTOR
        from flusi_msm.blind.ledger import read
        who = facts["individual"]
        stated = read(self.study.stated(who))
        place = self.study.folder / f"flights-{self.sha256[:12]}"
        place.mkdir(exist_ok=True)
        with open(place / f"lock{who}", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            case = write_section(place / f"case{who}", stated)
            yield {"Flight": {"file": case, "folder": place / f"of{who}", "beats": stated["beats"], "refine": "grid, box",
                              "model_sd": FACTOR}}

    def once(self, number, facts, more=None):
        from flusi_msm.blind.verdict import flat_verdict
        folder = self.study.folder / "work" / f"{number:04d}.{os.getpid()}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "diagnose.ini").write_text(ini_text(facts, self.wing_of(facts), self.study.measurement(number), more,
                                                      self.study.kind))
        command = [str(self.program), "diagnose.ini", "--exit-code"]
        if self.ranks > 1:
            command = ["mpirun", "-n", str(self.ranks), *command]
        begin = time.time()
        code, seconds, problem = run(["env", "-C", str(folder), *command], folder)
        result = {"exit_code": code, "cpu_seconds": seconds, "seconds": time.time() - begin, "problem": problem}
        if code in VERDICT_CODES:
            data = json.loads((folder / "diagnosis.json").read_text())
            tested = sorted((e for e in data["effects"] if e["status"] == "tested"), key=lambda e: -e["log_evidence"])
            result.update(verdict=flat_verdict(data), noise=data["noise"], mesh_band=data["mesh_band"],
                          details={key: data["verdict"][key] for key in data["verdict"] if key != "sentence"},
                          chi2=data["baseline"]["chi2"], parameters=data["extended"].get("parameters", []),
                          leaders=[{key: e[key] for key in ("name", "variant", "log_evidence", "posterior", "retained",
                                                            "local_p", "p")} for e in tested[:5]])
        shutil.rmtree(folder, ignore_errors=True)
        return result

    def wing_of(self, facts):
        """Returns the wing file. The forces on a section do not depend on it."""
        return WING if self.study.kind == "flight" else self.study.designs[facts["wing"]].wing

    def oracle(self, number, truth, record):
        """Returns the gain of log predictive density on locations left out, of the extended model and of a model that has the
        true cause."""
        from flusi_msm.blind.verdict import density_gain, effect_lines
        folds = record.get("verdict", {}).get("folds", {})
        names = [name for name, _ in record.get("verdict", {}).get("extension", [])]
        gain = density_gain(folds["baseline"], folds["extended"]) if len(folds) == 2 else 0.0
        true = truth["causes"][0]
        if len(folds) == 2 and names == [true["name"]] and not true["place"] and len(true["parameters"]) != 1:
            return {"gain": gain, "oracle": gain, "is_same": True}
        if len(folds) == 2 and names == [true["name"]] and is_variant(true, record["verdict"]["extension"][0][1]):
            return {"gain": gain, "oracle": gain, "is_same": True}
        lines = effect_lines(truth)
        if lines is None or "baseline" not in folds:
            return {"gain": gain, "oracle": None, "is_same": False}
        lines["Diagnose"] = {"intervals": "no", "refits": "1"}
        other = self.once(number, truth, lines)
        known = other.get("verdict", {}).get("folds", {}).get("baseline")
        return {"gain": gain, "oracle": None if known is None else density_gain(folds["baseline"], known),
                "is_same": False, "exit_code": other["exit_code"], "problem": other["problem"],
                "cpu_seconds": other["cpu_seconds"]}


def is_variant(true, label):
    """Returns whether an entry with this label is the true cause: the true cause has no place, and if its parameter belongs to one
    vein or joint, this is the label."""
    name, = true["parameters"] if len(true["parameters"]) == 1 else ("",)
    return not true["place"] and (":" not in name or name.split(":", 1)[1] == label)


def work(task):
    """Processes one case, unless the time is up."""
    study, diagnoses, number, stratum, before, stages, deadline = task
    if time.time() > deadline:
        return 0
    try:
        if "generate" in stages:
            study.make(number, stratum, before)
        if "diagnose" in stages and study.made(number):
            diagnoses.diagnose(number)
    except InputError as error:
        return f"case {number:04d}: {error}"
    return 1


def tell_cost(kind, study, tasks, folder):
    """Says what the cases that are not finished cost."""
    of_case, of_individual = CPU_SECONDS[kind]
    open_ones = [number for _, _, number, *_ in tasks if not (folder / f"{number:04d}.json").exists()]
    seconds = of_case * len(open_ones)
    if of_individual and open_ones:
        from flusi_msm.blind.flight_study import INDIVIDUALS
        seconds += of_individual * sum(not list(study.folder.glob(f"flights-*/of{who}")) for who in range(INDIVIDUALS))
    print(f"{len(open_ones)} cases to make and to diagnose: about {seconds / 3600:.1f} hours of CPU time on one core", file=sys.stderr,
          flush=True)


def begin(options):
    """Begins or continues the study in the folder; seed, design and generator must be the same as before."""
    from dataclasses import asdict

    from flusi_msm.blind.archive import Archive, ArchivedStudy, program_digest
    from flusi_msm.blind.batch import read_design
    from flusi_msm.blind.ledger import digest, dump, read, write
    from flusi_msm.blind.study import designs_of, sources_digest
    design = options.design or str(ROOT / DESIGNS[options.kind])
    if options.kind == "flight":
        from flusi_msm.measurement.flight import read_case
        designs = {"small": read_case(design)}
        shown = [asdict(d) for d in designs.values()]
    else:
        designs = designs_of(read_design(design)[0])
        shown = [{**asdict(d), "wing": digest(Path(d.wing).read_bytes())} for d in designs.values()]
    try:
        for part in ("sealed", "measured", "individuals", "work"):
            (options.folder / part).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{options.folder}: cannot be made: {error.strerror}") from None
    archive = Archive(options.archive)
    if options.archive and options.only == "score":
        if not archive.rows:
            raise InputError(f"{options.archive}: there is no archive with cases")
        return ArchivedStudy(options.folder, designs, archive.facts["seed"], archive, options.kind)
    place, known = options.folder / "study.json", {}
    if place.exists():
        known = read(place)
    seed = next((seed for seed in (options.seed, known.get("seed"), archive.facts.get("seed")) if seed is not None),
                secrets.randbits(31))
    facts = {"seed": seed, "generator": sources_digest(options.kind), "design": digest(dump(shown))}
    if options.kind != "bending":
        facts["kind"] = options.kind
    for key, value in facts.items():
        if known and known.get(key) != value:
            raise InputError(f"{options.folder}: holds a study of another {key}; use another folder")
    archive.begin({**facts, "program": program_digest(ROOT)})
    write(place, dump(facts))
    return ArchivedStudy(options.folder, designs, seed, archive, options.kind)


def shares_of(text):
    """Returns (K, N) of the text K/N, zeros if it is another."""
    try:
        shard, shards = map(int, text.split("/"))
    except ValueError:
        shard = shards = 0
    return shard, shards


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", choices=tuple(DESIGNS), default="bending", help="of the data")
    parser.add_argument("--cases", type=int, metavar="N", help="the first N; default: all of the study")
    parser.add_argument("--seed", type=int, help="of everything; default: that of the folder, or from the operating system")
    parser.add_argument("--folder", type=Path, help="default: runs/bench_diagnosis, with the kind behind it")
    parser.add_argument("--design", help="of the bending test, or of the flight (docs/results/blind-tests.md)")
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/msm_diagnose")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="cases at the same time")
    parser.add_argument("--ranks", type=int, default=1, metavar="N", help="of each run of the program")
    parser.add_argument("--shard", default="1/1", metavar="K/N", help="cases K, K+N, K+2N ... only")
    parser.add_argument("--only", choices=("generate", "diagnose", "score"))
    parser.add_argument("--hours", type=float, default=1e9, help="begin no case after so long")
    parser.add_argument("--archive", type=Path, metavar="JSONL", help="of what was found: joined by what this run finds")
    parser.add_argument("--figure", type=Path, metavar="PNG", help="draw the confusion matrix")
    parser.add_argument("--write-map", type=Path, metavar="F90", help="write the map from the probabilities of verdicts to how "
                        "often they were right, learned on the odd cases, as the module that msm_diagnose applies")
    options = parser.parse_args()
    shard, shards = shares_of(options.shard)
    from flusi_msm.blind.strata import plan, whole_study
    if options.cases is None:
        options.cases = whole_study(options.kind)
    if options.folder is None:
        options.folder = ROOT / "runs" / ("bench_diagnosis" + ("" if options.kind == "bending" else f"_{options.kind}"))
    if not 1 <= shard <= shards or min(options.cases, options.jobs, options.ranks) < 1:
        raise InputError("--shard is K/N with 1 <= K <= N; --cases, --jobs and --ranks are at least 1")
    from flusi_msm.blind.report import print_report
    from flusi_msm.blind.study import Study
    if not options.program.exists() and (options.only != "generate") and not (options.only == "score" and options.archive):
        raise InputError(f"{options.program}: not there; build it or give --program")
    options.folder = options.folder.resolve()
    study = begin(options)
    stages = [options.only] if options.only else ["generate", "diagnose"]
    diagnoses, folder = None, options.folder
    if options.only != "generate" and not (options.only == "score" and options.archive):
        diagnoses = Diagnoses(study, options.program.resolve(), options.ranks)
        folder = diagnoses.folder
        folder.mkdir(exist_ok=True)
    deadline = time.time() + 3600 * options.hours
    plain = Study(study.folder, study.designs, study.seed, study.kind)  # what the workers need
    if diagnoses:
        diagnoses.study = plain
    tasks = [(plain, diagnoses, number, *row, stages, deadline)
             for number, row in enumerate(plan(options.cases, options.kind), 1)
             if number % shards == shard % shards and number not in study.archive.rows]
    if options.only != "score":
        tell_cost(options.kind, study, tasks, folder)
        with Pool(options.jobs) as pool:
            for k, outcome in enumerate(pool.imap_unordered(work, tasks), 1):
                if isinstance(outcome, str):
                    print(f"{outcome}: left out", file=sys.stderr, flush=True)
                if outcome and (k % 10 == 0 or k == len(tasks)):
                    print(f"{k} of {len(tasks)} cases", file=sys.stderr, flush=True)
    if options.only != "generate":
        if options.archive and options.only != "score":
            for problem in study.archive.save(study, folder, options.cases):
                print(f"{problem}: not archived", file=sys.stderr)
        print_report(study, folder, options.cases, options.figure, options.write_map)


if __name__ == "__main__":
    run_command("bench/diagnosis/run", main)
