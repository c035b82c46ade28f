# SPDX-License-Identifier: GPL-3.0-or-later
"""The job chain: restarts, hands the signal on, resubmits itself after exit code 4 and only then."""
import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[3] / "tools" / "slurm" / "flusi.sbatch"
SBATCH = 'echo "$FLUSI_CHAIN $*" > submitted; echo "$FLUSI_CHAIN_RUN" > submitted_run\n'


def hear_signals():
    """A job that was started in the background, or with nohup, ignores these."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


class SlurmChain(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "a.ini").touch()

    def stub(self, name, text):
        path = self.folder / "bin" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("#!/usr/bin/env bash\n" + text)
        path.chmod(0o755)

    def start(self, program, *arguments, **environment):
        """Starts the job script; srun is replaced by `program`."""
        self.stub("srun", 'echo "$*" > started\n' + program)
        self.stub("sbatch", SBATCH)
        environment = {**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}", **environment}
        return subprocess.Popen(["bash", str(SCRIPT), *(arguments or ["a.ini"])], cwd=self.folder, env=environment,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, preexec_fn=hear_signals)

    def run_job(self, program, *arguments, **environment):
        job = self.start(program, *arguments, **environment)
        output = job.communicate(timeout=300)[0]
        return job.returncode, output

    def read(self, name):
        path = self.folder / name
        return path.read_text().strip() if path.exists() else None

    def test_finished_run_is_not_resubmitted(self):
        code, output = self.run_job("exit 0\n")
        self.assertEqual((code, self.read("submitted")), (0, None), output)
        self.assertEqual(self.read("started"), "flusi a.ini")

    def test_early_stop_is_resubmitted(self):
        code, output = self.run_job("touch runtime_backup0.h5; exit 4\n")
        self.assertEqual((code, self.read("submitted")), (0, f"2 --export=ALL {SCRIPT} a.ini"), output)

    def test_first_job_takes_up_no_run_unless_told(self):
        (self.folder / "runtime_backup1.h5").touch()
        for words in ([], ["--restart"], ["--overwrite"]):
            self.run_job("exit 0\n", "a.ini", *words, FLUSI="/opt/flusi")
            self.assertEqual(self.read("started"), " ".join(["/opt/flusi a.ini", *words]))
        code, output = self.run_job("exit 0\n", "a.ini", "--whatever")
        self.assertEqual((code, "usage" in output), (2, True), output)

    def test_successor_restarts_its_own_run(self):
        self.run_job("printf 'id = 12AB\\nversion = 1\\n' > runtime_identity.txt; touch runtime_backup0.h5; exit 4\n")
        self.assertEqual(self.read("submitted_run"), "12AB")
        self.run_job("exit 0\n", FLUSI_CHAIN="2", FLUSI_CHAIN_RUN="12AB")
        self.assertEqual(self.read("started"), "flusi a.ini --restart")

    def test_training_goes_on_too(self):
        """The files of msm_train are called after its output."""
        stops = "printf 'id = 7T\\n' > training_identity.txt; touch training_backup1.h5; exit 4\n"
        code, output = self.run_job(stops, FLUSI="msm_train")
        self.assertEqual((code, self.read("submitted"), self.read("submitted_run")), (0, f"2 --export=ALL {SCRIPT} a.ini", "7T"), output)
        chain = {"FLUSI": "msm_train", "FLUSI_CHAIN": "2", "FLUSI_CHAIN_RUN": "7T", "FLUSI_CHAIN_FILE": "./training_identity.txt"}
        self.run_job("exit 0\n", **chain)
        self.assertEqual(self.read("started"), "msm_train a.ini --restart")
        code, output = self.run_job("exit 0\n", **{**chain, "FLUSI_CHAIN_RUN": "8T"})
        self.assertEqual(code, 2, output)

    def test_diagnosis_ends_the_chain(self):
        """The exit code of a diagnosis is 0 whatever its verdict is; the script never asks for --exit-code."""
        code, output = self.run_job("exit 0\n", FLUSI="msm_diagnose")
        self.assertEqual((code, self.read("submitted"), self.read("started")), (0, None, "msm_diagnose a.ini"), output)
        self.assertIn("the case is done", output)
        self.assertNotIn("10 |", SCRIPT.read_text())

    def test_nine_individuals(self):
        share = SCRIPT.parents[2]
        self.stub("srun", 'echo "$PWD $*" > "$OUT"\n')
        for number, code in (("3", 0), ("10", 2), ("", 2)):
            environment = {**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}", "FLUSI_SHARE": str(share),
                           "SLURM_ARRAY_TASK_ID": number, "OUT": str(self.folder / "started")}
            job = subprocess.run(["bash", SCRIPT.with_name("individuals.sbatch")], cwd=self.folder, env=environment,
                                 capture_output=True, text=True)
            self.assertEqual(job.returncode, code, job.stdout + job.stderr)
        self.assertEqual(self.read("started"), f"{self.folder}/individual_3 flusi {share}/ini/individuals/3.ini")

    def test_successor_leaves_another_run_alone(self):
        (self.folder / "runtime_identity.txt").write_text("id = 34CD\n")
        (self.folder / "runtime_backup0.h5").touch()
        code, output = self.run_job("exit 0\n", FLUSI_CHAIN="2", FLUSI_CHAIN_RUN="12AB")
        self.assertEqual((code, self.read("started")), (2, None), output)
        self.assertIn("this folder holds run '34CD' now", output)

    def test_no_new_checkpoint_ends_the_chain(self):
        (self.folder / "runtime_backup0.h5").touch()
        code, output = self.run_job("exit 4\n")
        self.assertEqual((code, self.read("submitted")), (1, None), output)

    def test_longest_chain(self):
        code, output = self.run_job("touch runtime_backup0.h5; exit 4\n", FLUSI_CHAIN="3", FLUSI_CHAIN_MAX="3")
        self.assertEqual((code, self.read("submitted")), (4, None), output)

    def test_failures_end_the_chain(self):
        for failure in (1, 2, 3):
            code, output = self.run_job(f"touch runtime_backup0.h5; exit {failure}\n")
            self.assertEqual((code, self.read("submitted")), (failure, None), output)

    def test_signal_is_handed_on(self):
        job = self.start("trap 'sleep 0.2; touch runtime_backup0.h5; exit 4' USR1\ntouch ready\n"
                         "for i in {1..600}; do sleep 0.05; done\n")
        while not (self.folder / "ready").exists():
            time.sleep(0.02)
        job.send_signal(signal.SIGUSR1)
        output = job.communicate(timeout=300)[0]
        self.assertEqual((job.returncode, self.read("submitted")), (0, f"2 --export=ALL {SCRIPT} a.ini"), output)

    def test_cancelled_job_writes_a_checkpoint_and_ends_the_chain(self):
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            job = self.start("trap 'sleep 0.2; touch runtime_backup0.h5; exit 4' USR1\ntouch ready\n"
                             "for i in {1..600}; do sleep 0.05; done\n")
            while not (self.folder / "ready").exists():
                time.sleep(0.02)
            job.send_signal(number)
            output = job.communicate(timeout=300)[0]
            self.assertEqual((job.returncode, self.read("submitted")), (4, None), output)
            self.assertTrue((self.folder / "runtime_backup0.h5").exists())
            self.assertIn("the chain ends", output)
            for name in ("ready", "runtime_backup0.h5"):
                (self.folder / name).unlink()

    def test_diagnosis_goes_on_from_its_journal(self):
        """msm_diagnose has no --restart: the signal ends it, and it goes on from the journal that it finds."""
        job = self.start("touch diagnosis.journal ready\nexec sleep 30\n", FLUSI="msm_diagnose")
        while not (self.folder / "ready").exists():
            time.sleep(0.02)
        job.send_signal(signal.SIGUSR1)
        output = job.communicate(timeout=300)[0]
        self.assertEqual((job.returncode, self.read("submitted"), self.read("submitted_run")),
                         (0, f"2 --export=ALL {SCRIPT} a.ini", ""), output)
        chain = {"FLUSI": "msm_diagnose", "FLUSI_CHAIN": "2", "FLUSI_CHAIN_RUN": "", "FLUSI_CHAIN_FILE": "./diagnosis.journal"}
        self.run_job("exit 0\n", **chain)
        self.assertEqual(self.read("started"), "msm_diagnose a.ini")
        (self.folder / "diagnosis.journal").unlink()
        code, output = self.run_job("exit 0\n", **chain)
        self.assertEqual(code, 2, output)
        self.assertIn("another diagnosis has ended", output)

    def test_diagnosis_that_fails_ends_the_chain(self):
        code, output = self.run_job("touch diagnosis.journal; exit 3\n", FLUSI="msm_diagnose")
        self.assertEqual((code, self.read("submitted")), (3, None), output)

    def test_wrong_use(self):
        self.assertEqual(self.run_job("exit 0\n", "absent.ini")[0], 2)


if __name__ == "__main__":
    unittest.main()
