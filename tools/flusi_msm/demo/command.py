# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of the demo."""
from __future__ import annotations

import argparse
import os
import shutil
import signal
import sys
import time
import webbrowser
from pathlib import Path

from flusi_msm.demo.runner import Runner, last_lines
from flusi_msm.demo.steps import STEPS, copies
from flusi_msm.errors import InputError, run_command
from flusi_msm.project_python import ROOT

TEXT = """
From a drawing to a flight, in a few minutes on two cores: makes a wing of wings/calliphora.svg, bends a wing that hides a torn
place, trains the model on these tests, asks what the model gets wrong, and flies the wing with and without the cause that was
found. docs/guide/tutorial.md explains every step. A second call goes on where the first one stopped; a step is repeated if
one of its inputs has changed.
"""
SHOWN = ("wing.png", "training.html", "diagnosis.html", "beat.png", "flow.png")


def prepare(folder: Path) -> None:
    """Copies the inputs that do not exist yet: files that the user has changed are kept."""
    for source, name in copies(ROOT):
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if not place.exists():
            shutil.copyfile(source, place)


def verdict(folder: Path) -> list[str]:
    """Returns the verdict that msm_diagnose has printed, without its names of files."""
    text = (folder / "logs/diagnose.log").read_text(encoding="utf-8")
    lines = last_lines(text, "verdict")
    ends = [at for at, line in enumerate(lines) if line.startswith(("next", "files"))]
    return lines[:ends[0]] if ends else lines


def open_page(page: Path) -> bool:
    """Opens a page in the browser, if there is one."""
    has_screen = sys.platform == "darwin" or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return bool(sys.stdout.isatty() and has_screen and webbrowser.open(page.resolve().as_uri()))


def demo(options: argparse.Namespace) -> None:
    """Runs the demonstration."""
    if options.ranks < 1:
        raise InputError(f"--ranks must be 1 or more, not {options.ranks}")
    folder = Path(options.folder)
    try:
        prepare(folder)
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from None
    begin = time.monotonic()
    runner = Runner(folder, options.ranks, len(STEPS))
    for number, step in enumerate(STEPS, 1):
        runner.run(number, step)
    print(f"\n==> All {len(STEPS)} steps are done, {(time.monotonic() - begin) / 60:.1f} minutes\n")
    print("\n".join(verdict(folder)))
    print("truth     damage 0.3 around (6, -0.3) mm, radius 1.2 mm: bending.json\n")
    for name in SHOWN:
        print(f"    {folder / name}")
    if not options.no_open and open_page(folder / "diagnosis.html"):
        print("    (the last report is open in your browser)")


def command() -> None:
    """Runs the tool; mistakes become messages."""
    parser = argparse.ArgumentParser(prog="demo", description=TEXT, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", help="where it runs, for instance runs/demo")
    parser.add_argument("--ranks", type=int, default=2, metavar="N", help="MPI ranks of the programs (default 2)")
    parser.add_argument("--no-open", action="store_true", help="do not open the report in a browser")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))  # so that its programs are stopped, too
    run_command("demo", lambda: demo(options))
