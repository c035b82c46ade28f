# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes input files of flusi for a plate that hovers in a plane flow: its outline, its rotation, and the path of its middle.
Lengths are in chords."""
from __future__ import annotations

import math
from pathlib import Path

# The wing lies along y of the body and turns about its x by phi alone.
PLATE = "[Wing]\ntype = rectangular\nroot = {0!r}\nlength = {1!r}\nmean_chord = 1.0\nfront = 0.5\n"
TURN = """[kinematics]
type = fourier
nfft_phi = 1
a0_phi = {twice!r}
ai_phi = {cosine!r}
bi_phi = {sine!r}
nfft_alpha = 1
a0_alpha = 0.0
ai_alpha = 0.0
bi_alpha = 0.0
nfft_theta = 1
a0_theta = 0.0
ai_theta = 0.0
bi_theta = 0.0
"""


def write_plate(folder: Path, half: float, pitch: float, lead: float = 0.0, mean: float = 90.0) -> None:
    """Writes plate.ini, a plate from -half to half, and pitch.ini: the angle of its chord is mean + pitch sin(2 pi f t + lead), all
    in degrees."""
    (folder / "plate.ini").write_text(PLATE.format(-half, half))
    cosine, sine = (pitch * math.sin(math.radians(lead)), pitch * math.cos(math.radians(lead))) if lead else (0.0, pitch)
    (folder / "pitch.ini").write_text(TURN.format(twice=2 * mean, cosine=cosine, sine=sine))


def write_stroke(folder: Path, stroke: float, period: float, beats: int, middle: float, steps: int) -> None:
    """Writes stroke.t, the place middle + A0/2 cos(2 pi f t) of the plate with the stroke A0, with the given number of steps in
    a beat."""
    rows = []
    for i in range(steps * beats + 41):
        t = i * period / steps
        w = 2 * math.pi * t / period
        y, v = middle + stroke / 2 * math.cos(w), -stroke / 2 * (2 * math.pi / period) * math.sin(w)
        rows.append(f"{t:.12e} 0 {y:.12e} {middle} 0 {v:.12e} 0  1 0 0 0  0 0 0\n")
    (folder / "stroke.t").write_text("".join(rows))
