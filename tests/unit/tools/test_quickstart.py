# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/quickstart on pretended machines: every program it calls is a stub that records its call."""
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]
REAL = ("bash env dirname basename mkdir tee tail sed awk cat rm mktemp tr xargs sort wc grep cksum mv cp ls touch "
        "chmod echo mkfifo").split()
RECORD = 'echo "${0##*/} $*" >> "$MACHINE/calls"\n'
STUBS = {
    "cmake": '[ "$1" = --version ] && { echo "cmake version ${CMAKE_IS:-3.25.1}"; exit; }\n' + RECORD +
             'if [ "$1" = --build ]; then seq_fail=${BUILD_FAILS:-}; [ -z "$seq_fail" ] || { echo "error: $seq_fail"; '
             'exit 3; }\n  mkdir -p build/release/bin; cp "$MACHINE/bin/flusi" build/release/bin/flusi; fi\n',
    "ctest": RECORD + 'echo "100% tests passed"; exit ${CTEST_EXIT:-0}\n',
    "mpirun": RECORD + 'echo "as root: ${OMPI_ALLOW_RUN_AS_ROOT:-no}"; '
              'echo "more ranks than cores: $OMPI_MCA_rmaps_base_oversubscribe $PRTE_MCA_rmaps_default_mapping_policy"; '
              'touch out.xmf; exit ${RUN_EXIT:-0}\n',
    "apt-get": RECORD + '[ -z "${APT_GIVES:-}" ] || case "$*" in *install*) for f in $APT_GIVES; do '
                        'cp "$MACHINE/bin/true" "$MACHINE/bin/$f"; done ;; esac\n',
    "sudo": 'exit 1\n',
    "id": 'echo ${UID_IS:-1000}\n',
    "nproc": 'echo 8\n',
    "lscpu": 'printf "# c\\n0,0\\n1,0\\n2,0\\n0,0\\n1,0\\n2,0\\n"\n',
}
PRESENT = "gcc gfortran ninja make pkg-config git mpifort h5pfc h5dump python3 flusi true".split()


class Quickstart(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.machine = Path(folder.name).resolve()
        self.tree = self.machine / "tree"
        (self.tree / "tools").mkdir(parents=True)
        (self.tree / "ini").mkdir()
        for case in ("sphere.ini", "wing.ini"):
            (self.tree / "ini" / case).write_text("[Time]\n")
        shutil.copy(SOURCE / "tools" / "quickstart", self.tree / "tools")
        for requirements in ("requirements.txt", "requirements-mesh.txt", "requirements-render.txt"):
            shutil.copy(SOURCE / "tools" / requirements, self.tree / "tools")
        self.bin = self.machine / "bin"
        self.bin.mkdir()
        for name in REAL:
            (self.bin / name).symlink_to(shutil.which(name))
        for name, text in {**{p: "" for p in PRESENT}, **STUBS}.items():
            self.stub(self.bin / name, text)
        self.environment_is_made()

    def stub(self, path, text):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("#!/bin/bash\n" + text)
        path.chmod(0o755)

    def environment_is_made(self):
        self.stub(self.tree / ".venv" / "bin" / "python", '[ "$1" = -c ] || ' + RECORD)
        for stamp, names in (("stamp", ["requirements.txt"]), ("extras", ["requirements-mesh.txt", "requirements-render.txt"])):
            text = b"".join((self.tree / "tools" / name).read_bytes() for name in names)
            (self.tree / ".venv" / stamp).write_bytes(subprocess.run(["cksum"], input=text, capture_output=True, check=True).stdout)

    def quickstart(self, *arguments, **environment):
        environment = {"PATH": str(self.bin), "MACHINE": str(self.machine), "HOME": str(self.machine),
                       "TMPDIR": str(self.machine), "PYTHON": "python3", **environment}
        return subprocess.run([str(self.bin / "bash"), str(self.tree / "tools" / "quickstart"), *arguments],
                              capture_output=True, text=True, env=environment, cwd=self.tree, check=False)

    def calls(self, program):
        path = self.machine / "calls"
        lines = path.read_text().splitlines() if path.exists() else []
        return [line.split(" ", 1)[1] for line in lines if line.split(" ", 1)[0] == program]

    def assert_exit(self, done, code):
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)

    # ---- what is missing

    def test_build_on_a_complete_machine_installs_nothing(self):
        self.assert_exit(self.quickstart("build"), 0)
        self.assertEqual(self.calls("apt-get"), [])
        self.assertEqual(self.calls("cmake"), [f"--preset release -DPython3_EXECUTABLE={self.tree}/.venv/bin/python",
                                               "--build --preset release -j 3"])

    def test_names_of_packages_where_nothing_can_be_installed(self):
        (self.bin / "h5pfc").unlink()
        self.stub(self.bin / "pkg-config", "exit 1\n")
        for apt in ("there", "absent"):
            done = self.quickstart("deps")
            self.assert_exit(done, 2)
            for line in ("sudo apt-get install libfftw3-dev libhdf5-openmpi-dev\n",
                         "sudo dnf install fftw-devel hdf5-openmpi-devel\n", "brew install fftw hdf5-mpi\n",
                         "spack install fftw hdf5+mpi+fortran+tools\n"):
                self.assertIn(line, done.stderr, apt)
            self.assertEqual(self.calls("apt-get"), [])
            (self.bin / "apt-get").unlink(missing_ok=True)

    def test_root_installs_exactly_what_is_missing(self):
        (self.bin / "h5pfc").unlink()
        (self.bin / "ninja").unlink()
        self.assert_exit(self.quickstart("deps", UID_IS="0", APT_GIVES="h5pfc ninja"), 0)
        update, install = self.calls("apt-get")
        self.assertTrue(update.endswith(" update"))
        self.assertTrue(install.endswith("install -y --no-install-recommends ninja-build libhdf5-openmpi-dev"), install)

    def test_still_missing_after_installing(self):
        (self.bin / "git").unlink()
        done = self.quickstart("deps", UID_IS="0")
        self.assert_exit(done, 2)
        self.assertIn("Missing on this machine: git\n", done.stderr)

    def test_old_cmake_counts_as_missing(self):
        done = self.quickstart("deps", CMAKE_IS="3.22.1")
        self.assert_exit(done, 2)
        self.assertIn("Missing on this machine: cmake\n", done.stderr)

    def test_mesher(self):
        """Gmsh comes from PyPI; the libraries that it loads come from the system if they are missing."""
        self.assert_exit(self.quickstart("mesher"), 0)
        self.assertEqual(self.calls("apt-get"), [])
        self.assertIn(f"--requirement {self.tree}/tools/requirements-mesh.txt", self.calls("python")[0])
        self.stub(self.tree / ".venv" / "bin" / "python", 'case "$*" in *gmsh*) [ "$1" != -c ] || [ -e "$MACHINE/calls.gl" ] || '
                                                          'exit 1 ;; esac\n')
        done = self.quickstart("mesher")
        self.assert_exit(done, 2)
        self.assertIn("sudo apt-get install libgl1 libglu1-mesa", done.stderr)
        self.stub(self.bin / "apt-get", RECORD + 'case "$*" in *libglu1-mesa*) > "$MACHINE/calls.gl" ;; esac\n')
        self.assert_exit(self.quickstart("mesher", UID_IS="0"), 0)
        self.assertIn("libglu1-mesa", self.calls("apt-get")[-1])

    def test_pictures(self):
        """PyVista is tried by drawing; the library that draws without a screen comes from the system if it is missing."""
        self.assert_exit(self.quickstart("pictures"), 0)
        self.assertEqual(self.calls("apt-get"), [])
        self.assertIn(f"--requirement {self.tree}/tools/requirements-render.txt", self.calls("python")[0])
        self.stub(self.tree / ".venv" / "bin" / "python", 'case "$*" in *flusi_msm.render.renderers*) [ -e "$MACHINE/calls.gl" ] || exit 1 ;; esac\n')
        done = self.quickstart("pictures")
        self.assert_exit(done, 2)
        self.assertIn("sudo apt-get install libegl1 libgl1\n", done.stderr)
        self.stub(self.bin / "apt-get", RECORD + 'case "$*" in *libegl1*) > "$MACHINE/calls.gl" ;; esac\n')
        self.assert_exit(self.quickstart("pictures", UID_IS="0"), 0)
        self.assertIn("libegl1", self.calls("apt-get")[-1])

    def test_mesher_and_pictures_come_with_the_rest(self):
        """Once; a machine that cannot have them goes on and is told what the tools use instead."""
        (self.tree / ".venv" / "extras").unlink()
        self.assert_exit(self.quickstart("build"), 0)
        calls = self.calls("python")
        installed = [call.rsplit("/requirements-", 1)[1] for call in calls if "pip install" in call]
        self.assertEqual(installed, ["mesh.txt", "render.txt"])
        self.assert_exit(self.quickstart("build"), 0)
        self.assertEqual(self.calls("python"), calls)
        (self.tree / ".venv" / "extras").unlink()
        self.stub(self.tree / ".venv" / "bin" / "python", 'case "$*" in *gmsh*|*pyvista*|*requirements-*) exit 1 ;; esac\n')
        done = self.quickstart("build")
        self.assert_exit(done, 0)
        self.assertIn("going on without Gmsh", done.stdout)
        self.assertIn("going on without PyVista", done.stdout)

    def test_lean(self):
        (self.tree / ".venv" / "extras").unlink()
        self.assert_exit(self.quickstart("build", "--lean"), 0)
        self.assert_exit(self.quickstart("build"), 0)
        self.assertEqual(self.calls("python"), [])

    def test_environment_is_made_again_after_a_change_of_requirements(self):
        self.assert_exit(self.quickstart("deps"), 0)
        self.assertEqual(self.calls("python"), [])
        with open(self.tree / "tools" / "requirements.txt", "a", encoding="utf-8") as requirements:
            requirements.write("# changed\n")
        self.quickstart("deps")
        self.assertIn("-m pip install", self.calls("python")[0])

    # ---- build and test

    def test_failing_build_shows_its_end_and_how_to_repeat(self):
        done = self.quickstart("build", BUILD_FAILS="no such thing")
        self.assert_exit(done, 1)
        self.assertIn("    error: no such thing\n", done.stderr)
        self.assertIn(f"cd {self.tree} && cmake --build --preset release -j 3", done.stderr)
        self.assertIn("error: no such thing", (self.tree / "build/logs/build-release.log").read_text())

    def test_ctest_gets_the_rest_and_has_the_last_word(self):
        done = self.quickstart("test", "--preset", "dev", "-L", "unit", "--native")
        self.assert_exit(done, 0)
        self.assertEqual(self.calls("ctest"), ["--preset dev --output-on-failure --no-tests=error -j 9 -L unit"])
        self.assertIn("-DFLUSI_NATIVE=ON", self.calls("cmake")[0])
        self.assertTrue(done.stdout.endswith("100% tests passed\n"))
        self.assert_exit(self.quickstart("test", CTEST_EXIT="8"), 8)

    # ---- run

    def test_run_copies_the_input_and_keeps_earlier_results(self):
        done = self.quickstart("run")
        self.assert_exit(done, 0)
        self.assertIn("out.xmf   open in ParaView", done.stdout)
        self.assertIn("as root: no", done.stdout)
        self.assertIn("more ranks than cores: 1 :oversubscribe", done.stdout)  # Open MPI 4 and 5
        # The file in its place is run, because it may name others that lie beside it.
        self.assertEqual(self.calls("mpirun"), [f"-n 3 {self.tree}/build/release/bin/flusi {self.tree}/ini/wing.ini"])
        (self.tree / "runs/wing/mine").touch()
        self.assertIn("kept in runs/wing.1", self.quickstart("run", "ini/wing.ini").stdout)
        self.assertTrue((self.tree / "runs/wing.1/mine").exists())
        self.assertEqual(sorted(p.name for p in (self.tree / "runs/wing").iterdir()),
                         ["out.xmf", "run.log", "wing.ini"])

    def test_demo(self):
        self.assert_exit(self.quickstart("demo"), 0)
        self.assertEqual(self.calls("cmake")[-1].split()[:2], ["--build", "--preset"])
        self.assertEqual(self.calls("python")[-1], f"{self.tree}/tools/demo {self.tree}/runs/demo --ranks 3")
        self.assert_exit(self.quickstart("demo", "--preset", "dev"), 2)

    def test_cases_of_the_same_name_in_two_folders(self):
        (self.tree / "ini" / "flusi").mkdir()
        shutil.copy(self.tree / "ini" / "sphere.ini", self.tree / "ini" / "flusi")
        self.assert_exit(self.quickstart("run", "ini/flusi/sphere.ini"), 0)
        self.assertTrue((self.tree / "runs/flusi_sphere/flusi_sphere.ini").exists())

    def test_early_stop_and_restart(self):
        done = self.quickstart("run", "--ranks", "2", RUN_EXIT="4", UID_IS="0")
        self.assert_exit(done, 4)
        self.assertIn("tools/quickstart run --restart", done.stderr)
        self.assertIn("as root: 1", done.stdout)
        self.assert_exit(self.quickstart("run", "--ranks", "2", "--restart"), 0)
        self.assertEqual(self.calls("mpirun")[1], f"-n 2 {self.tree}/build/release/bin/flusi {self.tree}/ini/wing.ini --restart")
        self.assertFalse((self.tree / "runs/wing.1").exists())

    def test_pictures_are_made_of_what_the_run_wrote(self):
        self.stub(self.bin / "mpirun", "touch ux_000100.h5\nprintf '%% t F\\n0 1\\n1 2\\n' > forces.t\n"
                                       "printf '%% t E\\n0 1\\n' > energy.t\n")
        self.assert_exit(self.quickstart("run", "ini/sphere.ini"), 0)
        folder = f"{self.tree}/runs/sphere"
        self.assertEqual(self.calls("python"),
                         [f"{self.tree}/tools/plot_slice {folder} -o {folder}/flow.png",
                          f"{self.tree}/tools/plot_series {folder}/forces.t -o {folder}/forces.png"])

    def test_pictures_of_wings(self):
        self.stub(self.bin / "mpirun", "touch vorx_000100.h5 aero_power.t summary.txt wing.xmf\n")
        self.assert_exit(self.quickstart("run"), 0)
        folder = f"{self.tree}/runs/wing"
        self.assertEqual(self.calls("python"),
                         [f"{self.tree}/tools/plot_slice {folder} -o {folder}/flow.png",
                          f"{self.tree}/tools/plot_cycle {folder} -o {folder}/beat.png",
                          f"{self.tree}/tools/render {folder} -o {folder}/wings.png",
                          f"{self.tree}/tools/plot_slice {folder} --section left -o {folder}/sections.png",
                          f"{self.tree}/tools/open_in_paraview {folder}"])

    def test_wrong_use(self):
        for arguments in (["frob"], ["run", "no.ini"], ["run", "--ranks", "0"], ["run", "--ranks"], ["build", "x"],
                          ["build", "--preset", "fast"], ["run", "ini/sphere.ini", "ini/sphere.ini"]):
            done = self.quickstart(*arguments)
            self.assert_exit(done, 2)
            self.assertIn("see tools/quickstart help", done.stderr)
        self.assertEqual(self.calls("cmake"), [])
        self.assert_exit(self.quickstart("help"), 0)


if __name__ == "__main__":
    unittest.main()
