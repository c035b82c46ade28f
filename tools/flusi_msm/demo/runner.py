# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs steps one after another and skips those that are done, so that a stopped demo continues where it stopped."""
from __future__ import annotations

import hashlib
import shlex
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TextIO

from flusi_msm.demo.steps import Step
from flusi_msm.errors import InputError
from flusi_msm.project_python import ROOT, program

PROGRAMS = ("flusi", "msm_train", "msm_diagnose")
WIDTH = 76  # of the live line on a terminal


class Runner:
    """Runs steps in one folder; `.steps` there keeps for every step the checksums with which it was begun and done."""

    def __init__(self, folder: Path, ranks: int, n_steps: int) -> None:
        self.folder = folder
        self.ranks = ranks
        self.n_steps = n_steps
        self.stamps = folder / ".steps"
        self.logs = folder / "logs"
        for path in (self.stamps, self.logs):
            path.mkdir(parents=True, exist_ok=True)

    def run(self, number: int, step: Step) -> None:
        """Does one step unless it is done. An InputError reports a step that failed, with the end of its log."""
        heading = f"==> {number} of {self.n_steps}  {step.title}"
        key = self.key(step)
        if self.is_done(step, key):
            print(f"{heading}: done before", flush=True)
            return
        words = self.words(step, key)
        place = "" if step.folder == "." else f"cd {step.folder}; "
        print(f"{heading}\n    {place}{shlex.join(words)}", flush=True)
        self.stamp(step, "begun").write_text(key)
        self.stamp(step, "done").unlink(missing_ok=True)
        (self.folder / step.folder).mkdir(exist_ok=True)
        begin = time.monotonic()
        code = self.call(step, self.resolved(words))
        missing = [name for name in step.makes if not (self.folder / name).exists()]
        if code not in step.good_codes or missing:
            self.fail(step, code, missing)
        self.stamp(step, "done").write_text(key)
        print(f"    {time.monotonic() - begin:.0f} s, log in {self.log(step).relative_to(self.folder)}", flush=True)

    def key(self, step: Step) -> str:
        """Returns a checksum of the command and of the files that it reads."""
        digest = hashlib.sha256(step.command.encode())
        for name in step.reads:
            path = self.folder / name
            digest.update(path.read_bytes() if path.exists() else b"absent")
        return digest.hexdigest()

    def is_done(self, step: Step, key: str) -> bool:
        return self.has(step, "done", key) and all((self.folder / name).exists() for name in step.makes)

    def has(self, step: Step, what: str, key: str) -> bool:
        stamp = self.stamp(step, what)
        return stamp.exists() and stamp.read_text() == key

    def words(self, step: Step, key: str) -> list[str]:
        """Returns the command. A run that was killed continues; a run with other inputs begins again."""
        words = shlex.split(step.command)
        if words[0] == "mpirun":
            words[2] = str(self.ranks)
        if step.backups:
            if any(self.folder.glob(step.backups)) and self.has(step, "begun", key):
                words.append("--restart")
            elif self.stamp(step, "begun").exists():
                words.append("--overwrite")
        return words

    @staticmethod
    def resolved(words: Sequence[str]) -> list[str]:
        """Replaces names of programs and tools by their paths in this tree."""
        if words[0] == "mpirun":
            return [*words[:3], str(program(words[3])), *words[4:]]
        if words[0] in PROGRAMS:
            return [str(program(words[0])), *words[1:]]
        return [sys.executable, str(ROOT / "tools" / words[0]), *words[1:]]

    def call(self, step: Step, words: Sequence[str]) -> int:
        """Runs the command and returns its exit code; its output goes to the log, and the newest line of it to a terminal."""
        is_live = sys.stdout.isatty()
        with open(self.log(step), "w", encoding="utf-8") as log:
            try:
                process = subprocess.Popen(words, cwd=self.folder / step.folder, stdout=subprocess.PIPE,
                                           stderr=subprocess.STDOUT, text=True, errors="replace")
            except OSError as error:
                raise InputError(f"{step.title}: {words[0]} cannot be started ({error.strerror}); "
                                 "'tools/quickstart demo' builds and installs what is needed") from None
            with process:  # closes its output
                try:
                    self.follow(process.stdout or (), log, is_live)
                except BaseException:
                    process.terminate()  # a program that continues alone would block the folder
                    raise
        if is_live:
            print("\r\033[K", end="")
        return process.returncode

    @staticmethod
    def follow(lines: Iterable[str], log: TextIO, is_live: bool) -> None:
        for line in lines:
            log.write(line)
            log.flush()
            if is_live and line.strip():
                print(f"\r\033[K    {line.rstrip()[:WIDTH]}", end="", flush=True)

    def fail(self, step: Step, code: int, missing: Sequence[str]) -> None:
        tail = self.log(step).read_text(encoding="utf-8").rstrip().split("\n")[-20:]
        reason = f"exit code {code}" if code not in step.good_codes else f"it made no {', '.join(missing)}"
        raise InputError("\n".join([f"'{step.title}' failed: {reason}. Last lines of {self.log(step)}:",
                                    *("    " + line for line in tail), "The same command goes on from here."]))

    def stamp(self, step: Step, what: str) -> Path:
        return self.stamps / f"{step.name}.{what}"

    def log(self, step: Step) -> Path:
        return self.logs / f"{step.name}.log"


def last_lines(text: str, first: str, n_lines: int | None = None) -> list[str]:
    """Returns the lines from the one that begins with `first` on, at most n_lines; nothing if there is none."""
    lines = text.split("\n")
    for at, line in enumerate(lines):
        if line.startswith(first):
            return lines[at:None if n_lines is None else at + n_lines]
    return []
