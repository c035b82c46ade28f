#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pictures of docs/guide/tutorial.md of the folder in which its commands have run: each is shrunk, and those of the loads
are laid side by side; nothing else.

usage: tools/python docs/images/tutorial_pictures.py FOLDER [OUTPUT_FOLDER]
"""
import sys
from pathlib import Path

from PIL import Image

WIDTH = 900  # pixels
WIDE = 1200  # of several pictures
N_COLOURS = 256
# Of several files that fit the pattern all are shown, in two columns.
PICTURES = {"wing": "wing.png", "parameters": "pictures/train_parameters.png", "residuals": "pictures/diagnosis_residuals_*.png",
            "beat": "beat.png", "flow": "flow.png"}


def side_by_side(pictures):
    width, height = (max(getattr(picture, side) for picture in pictures) for side in ("width", "height"))
    sheet = Image.new("RGB", (2 * width, (len(pictures) + 1) // 2 * height), "white")
    for k, picture in enumerate(pictures):
        sheet.paste(picture, (k % 2 * width, k // 2 * height))
    return sheet


def shrink(picture, width, target):
    if picture.width > width:
        picture = picture.resize((width, round(picture.height * width / picture.width)), Image.LANCZOS)
    picture.quantize(N_COLOURS, method=Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE).save(target, optimize=True)


def main():
    folder = Path(sys.argv[1])
    output = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).parent
    for name, pattern in PICTURES.items():
        found = [Image.open(path).convert("RGB") for path in sorted(folder.glob(pattern))]
        if not found:
            sys.exit(f"tutorial_pictures: {folder}: there is no {pattern}")
        shrink(found[0] if len(found) == 1 else side_by_side(found), WIDTH if len(found) == 1 else WIDE, output / f"tutorial-{name}.png")


if __name__ == "__main__":
    main()
