# SPDX-License-Identifier: GPL-3.0-or-later
"""The steps of the demo: those of docs/guide/tutorial.md, command by command."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

DONE = (0,)
VERDICTS = (0, 10, 11, 12)  # of msm_diagnose: it has ended with a verdict


@dataclass(frozen=True)
class Step:
    """One command, run in `folder` below that of the demo. The files that it reads and makes are relative to the demo's folder.
    """
    name: str
    title: str
    command: str
    reads: tuple[str, ...]
    makes: tuple[str, ...]
    folder: str = "."
    backups: str = ""  # pattern of the checkpoints that a killed run leaves; empty where a run begins again by itself
    good_codes: tuple[int, ...] = DONE


def flight(name: str, wing: str) -> Step:
    return Step(f"fly-{name}", f"Fly the {name} wing for one beat on a coarse grid", f"mpirun -n 2 flusi ../{name}.ini",
                (f"{name}.ini", "flight.ini", wing, "wing.h5"), (f"{name}/summary.txt", f"{name}/{name}_left.xmf"), name,
                f"{name}/runtime_backup*.h5")


STEPS = (
    Step("wing", "Make a wing of a drawing",
         "make_wing calliphora.svg -o wing.h5 --edge 0.7 --mesher own --membrane-mass 81 --mass-source 'Truong et al.'",
         ("calliphora.svg",), ("wing.h5", "wing.png")),
    Step("bend", "Bend a wing that hides a torn place", "make_measurement bending.json -o bending.h5 --quiet",
         ("bending.json", "wing.h5"), ("bending.h5", "bending.truth.json")),
    Step("train", "Train the model on these tests", "mpirun -n 2 msm_train train.ini",
         ("train.ini", "wing.h5", "bending.h5"), ("trained.ini", "train_history.h5"), backups="train_backup*.h5"),
    Step("training-report", "Report of the training", "plot_training . -o training.html --pictures pictures",
         ("train_history.h5", "wing.h5"), ("training.html",)),
    Step("diagnose", "Ask what the model gets wrong", "mpirun -n 2 msm_diagnose diagnose.ini",
         ("diagnose.ini", "wing.h5", "bending.h5"), ("diagnosis.json", "diagnosis_baseline.ini", "diagnosis_extended.ini"),
         good_codes=VERDICTS),
    flight("fitted", "diagnosis_baseline.ini"),
    flight("extended", "diagnosis_extended.ini"),
    Step("beat", "Lift, drag and power of both", "plot_cycle fitted extended --labels fitted,extended -o beat.png",
         ("fitted/summary.txt", "extended/summary.txt"), ("beat.png",)),
    Step("flow", "The flow in the downstroke", "render extended --time 0.25 --height 600 -o flow.png",
         ("extended/summary.txt",), ("flow.png",)),
    Step("report", "Report of the diagnosis",
         "plot_diagnosis diagnosis.json --flight fitted extended -o diagnosis.html --pictures pictures",
         ("diagnosis.json", "fitted/summary.txt", "extended/summary.txt"), ("diagnosis.html",)),
)


def copies(root: Path) -> tuple[tuple[Path, str], ...]:
    """Returns the files that the folder of the demo begins with, from the source or from an installation, and their places
    there."""
    return (*((path, path.name) for path in sorted((root / "ini/demo").iterdir())),
            (root / "wings/calliphora.svg", "calliphora.svg"),
            (root / "ini/kinematics/calliphora.ini", "kinematics/calliphora.ini"))
