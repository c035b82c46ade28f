#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pictures of docs/guide/tutorial.md of the folder in which its commands have run: each is shrunk, nothing else.

usage: tools/python docs/images/tutorial_pictures.py FOLDER [OUTPUT_FOLDER]
"""
import sys
from pathlib import Path

from PIL import Image

WIDTH = 900  # pixels
N_COLOURS = 128
PICTURES = {"wing": "wing.png", "parameters": "pictures/train_parameters.png", "residuals": "pictures/diagnosis_residuals.png",
            "beat": "beat.png", "flow": "flow.png"}


def shrink(source, target):
    picture = Image.open(source).convert("RGB")
    if picture.width > WIDTH:
        picture = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.LANCZOS)
    picture.quantize(N_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(target, optimize=True)


def main():
    folder = Path(sys.argv[1])
    output = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).parent
    for name, source in PICTURES.items():
        shrink(folder / source, output / f"tutorial-{name}.png")


if __name__ == "__main__":
    main()
