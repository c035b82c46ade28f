# SPDX-License-Identifier: GPL-3.0-or-later
"""What the whole-program tests share: starting flusi, writing its input, reading its output.

A test file defines functions `test_*` that take a `Case` and calls `main(globals())`. Its arguments are
the program, h5dump, and optionally the names of the tests to run. Every test gets an empty folder of its
own below the working directory. Nothing but the standard library is used; HDF5 is read through h5dump. With
FLUSI_TEST_TRANSFORM in the environment all runs use that transform.
"""
import contextlib
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import time
import traceback
from collections import namedtuple
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
ALIVE = 300  # s after which a run that has not done what a test waits for is taken for dead, on however busy a machine
EXIT_OK, EXIT_FAILURE, EXIT_USER, EXIT_NUMERICAL, EXIT_STOPPED, EXIT_UNWRITABLE = range(6)
# Lines of msm_diagnose on the terminal. Of them the table of what to measure next has up to five, one for each kind of data, and the
# comparison of flights two.
MOST_LINES = 22
# What the runtime of a compiler or the system prints when a program dies of a defect.
CRASH_MARKS = ("Backtrace", "Fortran runtime error", "SIGSEGV", "SIGFPE", "SIGABRT",
               "internal error", "AddressSanitizer", "runtime error:")

# Where the keys of `flusi --static`, `flusi --solid` and `msm_train` begin in the reference of parameters.
STATIC_REFERENCE = "# Parameters of `flusi --static`"
SOLID_REFERENCE = "# Parameters of `flusi --solid`"
TRAIN_REFERENCE = "# Parameters of `msm_train`"

Finished = namedtuple("Finished", "code out err")
Series = namedtuple("Series", "header lines rows")


def check(condition, sentence):
    """`sentence` should be true."""
    if not condition:
        raise AssertionError(sentence)


def sphere(n=16, **sections):
    """A sphere set into motion, small enough for a test; `sections` add to it or replace keys."""
    return merged({
        "Resolution": {"nx": n, "ny": n, "nz": n},
        "Time": {"nt": 40, "CFL": 0.2},
        "ReynoldsNumber": {"nu": 1e-2},
        "InitialCondition": {"inicond": "quiescent"},
        "Penalization": {"iPenalization": "yes", "iMask": "sphere", "eps": 5e-3},
        "Geometry": {"xl": 2.5, "yl": 2.5, "zl": 2.5, "Size": 0.8},
        "MeanFlow": {"iMeanFlow": 1, "ux": 1.0, "uy": 0.1, "uz": 0.0},
        "Saving": {"tsave": 0.05, "tintegral": 0.01, "iSaveVelocity": "yes"},
    }, sections)


def ring(n=16, **sections):
    """A vortex ring without solids."""
    return merged({
        "Resolution": {"nx": n, "ny": n, "nz": n},
        "Time": {"nt": 40, "CFL": 0.2},
        "ReynoldsNumber": {"nu": 1e-2},
        "InitialCondition": {"inicond": "VortexRing", "omega1": 3.0},
        "Geometry": {"xl": 2.5, "yl": 2.5, "zl": 2.5, "Size": 0.5},
        "MeanFlow": {"ux": 0.0, "uy": 0.0, "uz": 0.0},
        "Saving": {"tsave": 0.05, "tintegral": 0.01, "iSaveVelocity": "yes"},
    }, sections)


def merged(ini, sections):
    """`ini` with the keys of `sections` added or replaced; a key of value None is left out."""
    result = {name: dict(keys) for name, keys in ini.items()}
    for name, keys in sections.items():
        result.setdefault(name, {}).update(keys)
    return result


def ini_text(ini):
    if os.environ.get("FLUSI_TEST_TRANSFORM"):
        ini = merged({"Parallel": {"transform": os.environ["FLUSI_TEST_TRANSFORM"]}}, ini)
    lines = []
    for section, keys in ini.items():
        lines.append(f"[{section}]")
        lines += [f"{key}={value};" for key, value in keys.items() if value is not None]
    return "\n".join(lines) + "\n"


class Case:
    """One test: the program and a folder to run it in."""

    def __init__(self, program, h5dump, folder):
        self.program, self.h5dump, self.folder = str(Path(program).resolve()), h5dump, Path(folder)
        self.headers = {}
        self.mpiexec = os.environ.get("MPIEXEC", "mpiexec")
        if self.folder.exists():
            shutil.rmtree(self.folder)
        self.folder.mkdir(parents=True)

    def sub(self, name):
        """A case in a new folder below this one."""
        return Case(self.program, self.h5dump, self.folder / name)

    def traps(self):
        """Whether this build ends on the first invalid operation instead of carrying NaN on."""
        return "-ffpe-trap" in self.flusi("--version").out

    def has_p3dfft(self):
        """Whether this build has the transform of P3DFFT."""
        return "P3DFFT    yes" in self.flusi("--version").out

    def write(self, name, ini):
        text = ini if isinstance(ini, str) else ini_text(ini)
        (self.folder / name).write_text(text)
        return name

    def start(self, *arguments, ranks=0, env=None):
        """Starts flusi, under mpiexec if `ranks` > 0; output goes to the files .out and .err."""
        command = [self.program, *map(str, arguments)]
        if ranks:
            command = [self.mpiexec, "-n", str(ranks), *command]
        self.out, self.err = self.folder / ".out", self.folder / ".err"
        environment = {k: v for k, v in os.environ.items() if k != "SLURM_JOB_END_TIME"}
        environment["OMPI_MCA_odls_base_sigkill_timeout"] = "0"  # do not wait for ranks that have ended
        with open(self.out, "w") as out, open(self.err, "w") as err:
            self.process = subprocess.Popen(command, cwd=self.folder, stdout=out, stderr=err, text=True,
                                            stdin=subprocess.DEVNULL, env={**environment, **(env or {})})
        return self.process

    def wait(self, timeout=ALIVE):
        """Waits for the end of what `start` began."""
        try:
            code = self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.process.terminate()  # mpiexec ends its ranks on this
            try:
                self.process.wait(10)
            except subprocess.TimeoutExpired:
                self.process.kill()
            raise AssertionError(f"no end within {timeout} s: {self.process.args}\n{self.out.read_text()}"
                                 f"{self.err.read_text()}") from None
        result = Finished(code, self.out.read_text(errors="replace"), self.err.read_text(errors="replace"))
        self.out.unlink()
        self.err.unlink()
        return result

    def wait_killed(self, timeout=ALIVE):
        """Waits for the end of a run whose ranks a test has killed. Where the launcher waits for a rank that is dead, it is
        killed as well: that of OpenMPI can hang if ranks die while they still connect to it. A rank that lives is a failure."""
        end = time.monotonic() + timeout
        while self.process.poll() is None and time.monotonic() < end:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(10)
            if self.process.poll() is None and not self.ranks():
                print("      the launcher waits for dead ranks and is killed", flush=True)
                self.process.kill()
                self.process.wait(10)
        check(self.process.poll() is not None, f"no rank outlives the kill: {self.ranks()}")
        return self.wait(1)

    def flusi(self, *arguments, ranks=0, env=None, timeout=ALIVE):
        """Runs flusi to its end."""
        self.start(*arguments, ranks=ranks, env=env)
        return self.wait(timeout)

    def run(self, *arguments, ranks=0, code=EXIT_OK, env=None, timeout=ALIVE):
        """Runs flusi, on `ranks` ranks or without a launcher, and checks its exit code and that it did not crash."""
        done = self.flusi(*arguments, ranks=ranks, env=env, timeout=timeout)
        check(done.code == code, f"exit code of {arguments} on {ranks} ranks is {code}, not {done.code}:\n"
                                 f"{done.out}{done.err}")
        no_crash(done)
        return done

    def wait_for_steps(self, steps, timeout=ALIVE):
        """Waits until the run that `start` began has made `steps` steps."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            file = self.folder / "timesteps_info.t"
            try:
                if len(series(file).rows) >= steps:
                    return
            except FileNotFoundError:  # not yet, or no longer: a run may move that of an earlier one aside
                pass
            check(self.process.poll() is None, f"the run ended too early: {self.err.read_text()}")
            time.sleep(0.01)
        raise AssertionError(f"not {steps} steps within {timeout} s")

    def wait_for(self, name, timeout=ALIVE):
        """Waits until the run that `start` began has made the file or folder `name`; whether it
        has."""
        end = time.monotonic() + timeout
        while time.monotonic() < end and self.process.poll() is None:
            if (self.folder / name).exists():
                return True
            time.sleep(0.002)
        return False

    def ranks(self):
        """Process ids of the ranks of the run that `start` began."""
        found = []
        for process in filter(str.isdigit, os.listdir("/proc")):
            try:
                words = Path(f"/proc/{process}/cmdline").read_text().split("\0")
                if words[0] == self.program and os.readlink(f"/proc/{process}/cwd") == str(self.folder.resolve()):
                    found.append(int(process))
            except (OSError, UnicodeDecodeError):
                pass  # it has ended, or is none of ours
        return found

    def files(self):
        return sorted(p.name for p in self.folder.iterdir())

    def sub_files(self, folder):
        return sorted(p.name for p in (self.folder / folder).iterdir())

    def series(self, name):
        return series(self.folder / name)

    def all_series(self):
        """Every .t file; of timesteps_info.t only what does not depend on the machine (not the wall time)."""
        result = {}
        for path in sorted(self.folder.glob("*.t")):
            result[path.name] = series(path).lines
            if path.name == "timesteps_info.t":
                result[path.name] = [line.split()[:1] + line.split()[2:4] for line in result[path.name]]
        return result

    def contents(self, name):
        """All of an HDF5 file: name -> list of numbers or texts, as strings that determine every bit."""
        text = subprocess.run([self.h5dump, "-m", "%.17g", "-w", "0", str(self.folder / name)],
                              capture_output=True, text=True, check=True).stdout
        result, dataset = {}, ""
        for kind, key, data in re.findall(r'(ATTRIBUTE|DATASET) "([^"]+)" \{.*?DATA \{(.*?)\n\s*\}', text, re.S):
            if kind == "DATASET":
                dataset = key + "/"
            else:
                key = dataset + key
            values = re.sub(r"\(\d+(?:,\d+)*\):", " ", data)
            result[key] = [v.strip() for v in values.replace("\n", ",").split(",") if v.strip()]
        return result

    def field(self, name):
        """The numbers of a field file, x fastest."""
        header = self.header(name)
        key = re.search(r'DATASET "([^"]+)"', header).group(1)
        width = int(re.search(r"H5T_IEEE_F(\d+)", header).group(1)) // 8
        data = self.raw(name, key)
        return struct.unpack(f"<{len(data) // width}{'fd'[width == 8]}", data)

    def raw(self, name, dataset):
        """The bytes of a dataset."""
        file = self.folder / ".raw"
        subprocess.run([self.h5dump, "-d", dataset, "-b", "LE", "-o", str(file), str(self.folder / name)],
                       capture_output=True, check=True)
        data = file.read_bytes()
        file.unlink()
        return data

    def header(self, name):
        """Types, sizes and attributes in an HDF5 file, as text; remembered as long as the file is the same."""
        path = self.folder / name
        key = (path, path.stat().st_mtime_ns, path.stat().st_ino)
        if key not in self.headers:
            self.headers[key] = subprocess.run([self.h5dump, "-m", "%.17g", "-A", str(path)], capture_output=True,
                                               text=True, check=True).stdout
        return self.headers[key]

    def attribute(self, name, which):
        """Numbers of an attribute of the dataset in a field file."""
        found = re.search(rf'ATTRIBUTE "{which}" \{{.*?DATA \{{(.*?)\n\s*\}}', self.header(name), re.S)
        check(found, f"{name} has the attribute {which}")
        return [float(v) for v in re.sub(r"\(\d+\):", " ", found.group(1)).replace(",", " ").split()]

    def newest_checkpoint(self):
        """Name of the backup of the highest generation, checked by name only."""
        names = [n for n in ("runtime_backup0.h5", "runtime_backup1.h5") if (self.folder / n).exists()]
        check(names, "there is a backup")
        return max(names, key=self.generation)

    def generation(self, name):
        out = subprocess.run([self.h5dump, "-a", "/generation", str(self.folder / name)], capture_output=True,
                             text=True, check=True).stdout
        return int(re.search(r"\(0\): (\d+)", out).group(1))

    def check_index(self, name):
        """The XDMF index describes what is there."""
        done = subprocess.run([sys.executable, "-B", str(SOURCE / "tests/support/check_xdmf.py"), self.h5dump,
                               str(self.folder / name)], capture_output=True, text=True)
        check(done.returncode == 0, f"{name} is a correct index:\n{done.stdout}{done.stderr}")


def series(path):
    """Header, complete lines and numbers of a time series."""
    text = Path(path).read_text()
    lines = text.split("\n")[:-1]
    header = [line for line in lines if line.startswith("%")]
    lines = [line for line in lines if not line.startswith("%")]
    return Series(header, lines, [[float(x) for x in line.split()] for line in lines])


def live_keys(reference):
    """Section and key of every row of the tables that has a type, that is, of every key with an effect, but that of
    [include], in the place of which --check prints what was included."""
    keys, section = set(), ""
    for line in reference.splitlines():
        if line.startswith("## ["):
            section = line[4:].split("]")[0]
        found = re.match(r"\| `([^`]+)` \| (\w+)", line)
        if found:
            keys.add((section, found.group(1)))
    return keys - {("include", "file")}


def no_crash(done):
    for mark in CRASH_MARKS:
        check(mark not in done.out + done.err, f"nothing crashes:\n{done.out}{done.err}")


def same_files(one, two):
    """Whether two HDF5 files are the same but for the second of creation of each dataset, which HDF5 stores."""
    a, b = Path(one).read_bytes(), Path(two).read_bytes()
    if a == b:
        return True
    if len(a) != len(b):
        return False
    places = []  # first and last of bytes that differ and are close together
    for i in (i for i in range(len(a)) if a[i] != b[i]):
        if places and i - places[-1][0] <= 3:
            places[-1][1] = i
        else:
            places.append([i, i])
    return all(is_clock(a, b, first, last) for first, last in places)


def is_clock(a, b, first, last):
    """Up to four bytes: two readings of the clock today, little-endian, at some alignment around them."""
    for start in range(last - 3, first + 1):
        if all(abs(struct.unpack_from("<I", x, start)[0] - time.time()) < 86400 for x in (a, b)):
            return True
    return False


def same_runs(one, two):
    """Two folders hold the same run: the newest checkpoint, every series, index and field, to the bit."""
    same_checkpoints(one, one.newest_checkpoint(), two, two.newest_checkpoint())
    a, b = one.all_series(), two.all_series()
    check(a.keys() == b.keys() and "ekin.t" in a, f"the same series: {sorted(a)}, {sorted(b)}")
    for name in a:
        check(a[name] == b[name], f"{name} is the same line by line")
        if name == "spectrum_k.t":
            continue  # one line of wavenumbers, no times
        times = [float(line[0] if isinstance(line, list) else line.split()[0]) for line in b[name]]
        check(len(set(times)) == len(times) > 2, f"{name} has every time once")
    for index in [n for n in one.files() if n.endswith(".xmf")]:
        check((one.folder / index).read_text() == (two.folder / index).read_text(), f"{index} is the same")
    compared = 0
    for name in one.files():
        if name.endswith(".h5") and not name.startswith("runtime_backup"):
            check(same_files(one.folder / name, two.folder / name), f"{name} is the same to the bit")
            compared += 1
    check(compared > 5, "there are fields to compare")


def same_checkpoints(a, name_a, b, name_b, tolerance=None):
    """Two checkpoints hold the same state: to the bit, or within `tolerance` times the largest number of
    each table (at least 1e-3: some vanish by symmetry). The generation, the name of the run and what depends on them
    may differ."""
    one, two = a.contents(name_a), b.contents(name_b)
    check(one.keys() == two.keys(), "both checkpoints hold the same things")
    check("u" in "".join(one), "the checkpoint holds a state")
    for key in one:
        if key.split("/")[-1] in ("generation", "contents") or key.startswith("run_"):
            continue
        if tolerance is None:
            check(one[key] == two[key], f"{key} is the same to the bit")
        elif not key.endswith("checksum"):
            close(one[key], two[key], tolerance, key)


def close(one, two, tolerance, what, floor=1e-3):
    """`one` and `two` differ by at most `tolerance` times the largest of `one`, or times `floor` if that is
    more."""
    check(len(one) == len(two), f"{what} has the same size")
    try:
        x, y = [float(v) for v in one], [float(v) for v in two]
    except ValueError:
        check(one == two, f"{what} is the same")
        return
    scale = max(map(abs, x), default=0.0)
    scale = max(scale, floor)
    worst = max((abs(p - q) for p, q in zip(x, y)), default=0.0)
    check(worst <= tolerance * scale, f"{what} is the same within {tolerance} * {scale}; differs by {worst}")


def let_programs_hear():
    """What is started in the background, or with nohup, ignores these signals and hands that on, unless it has a handler."""
    for number in (signal.SIGINT, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, lambda *_: None)


def main(names):
    """Runs the tests among `names`, the globals of a test file, or those that the command line names."""
    let_programs_hear()
    program, h5dump, wanted = sys.argv[1], sys.argv[2], sys.argv[3:]
    tests = {name: test for name, test in names.items() if name.startswith("test_")}
    unknown = [name for name in wanted if name not in tests]
    if unknown:
        sys.exit(f"{sys.argv[0]} has no test {', '.join(unknown)}; it has {', '.join(tests)}")
    failed = 0
    for name, test in tests.items():
        if wanted and name not in wanted:
            continue
        begun, used = time.monotonic(), sum(os.times()[:4])
        try:
            test(Case(program, h5dump, Path.cwd() / name))
            print(f"pass  {name} ({time.monotonic() - begun:.1f} s, {sum(os.times()[:4]) - used:.1f} s of CPU)", flush=True)
        except AssertionError as error:
            failed += 1
            where = traceback.extract_tb(error.__traceback__)
            line = [f.lineno for f in where if f.filename == sys.argv[0]][-1:]
            print(f"FAIL  {name}, line {line}: {error}", flush=True)
    sys.exit(1 if failed else 0)
