# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads outlines of wings from ini files of FLUSI and WABBIT: section [Wing], type = fourier.

R(theta) = a0/2 + sum_i a_i cos(i theta) + b_i sin(i theta) about (x0w, y0w), with theta = pi + atan2(y_w - y0w, x_w - x0w)
in FLUSI's wing frame (x_w chordwise, y_w spanwise). Lengths are in wing lengths.
"""
from __future__ import annotations

import re

import numpy as np

from flusi_msm.errors import InputError

POINTS = 720
SERIES = ("ai_wings", "bi_wings")


def _entries(path: str) -> dict[str, str]:
    """Returns keys of [Wing] in small letters with their text; matrices (/ ... /) over several lines are one text."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    text = re.sub(r"[;#!%].*", "", text)
    text = re.sub(r"\(/.*?/\)", lambda found: " ".join(found[0][2:-2].split()), text, flags=re.S)
    section, found = "", {}
    for line in text.splitlines():
        heading = re.fullmatch(r"\s*\[(.*?)\]\s*", line)
        if heading:
            section = heading[1].strip().lower()
        elif section == "wing" and "=" in line:
            key, value = line.split("=", 1)
            found[key.strip().lower()] = value.strip().strip("'\"")
    return found


def read_fourier_outline(path: str) -> np.ndarray:
    """Returns points (n, 2) of the outline in the wing frame, x from root to tip, y toward the leading edge, counter-clockwise;
    the unit is that of the file. All mistakes are raised at once."""
    entries = _entries(path)
    wrong: list[str] = []
    if not entries:
        raise InputError(f"{path}: has no section [Wing]")
    if entries.get("type", "fourier").lower() != "fourier":
        raise InputError(f"{path}: [Wing] type = {entries['type']}: only fourier has an outline that can be read here; draw the "
                         "wing as SVG, or give its outline in a TOML file")
    numbers = {}
    for key in ("a0_wings", "x0w", "y0w", *SERIES):
        try:
            numbers[key] = [float(word.lower().replace("d", "e")) for word in re.split(r"[\s,]+", entries[key]) if word]
        except KeyError:
            wrong.append(f"{path}: [Wing] {key}: is missing")
        except ValueError:
            wrong.append(f"{path}: [Wing] {key}: '{entries[key][:40]}' are not numbers")
    for key in ("a0_wings", "x0w", "y0w"):
        if key in numbers and len(numbers[key]) != 1:
            wrong.append(f"{path}: [Wing] {key}: must be one number")
    if all(key in numbers for key in SERIES) and len(numbers["ai_wings"]) != len(numbers["bi_wings"]):
        wrong.append(f"{path}: [Wing] bi_wings: has {len(numbers['bi_wings'])} numbers, ai_wings has {len(numbers['ai_wings'])}")
    if wrong:
        raise InputError("\n".join(wrong))
    theta = 2 * np.pi * np.arange(POINTS) / POINTS
    order = np.arange(1, len(numbers["ai_wings"]) + 1)[:, None]
    radius = numbers["a0_wings"][0] / 2 + np.array(numbers["ai_wings"]) @ np.cos(order * theta) \
        + np.array(numbers["bi_wings"]) @ np.sin(order * theta)
    if radius.min() <= 0:
        raise InputError(f"{path}: [Wing] the radius R(theta) of the outline is not positive everywhere")
    x, y = numbers["y0w"][0] + radius * np.sin(theta - np.pi), numbers["x0w"][0] + radius * np.cos(theta - np.pi)
    return np.stack([x, y], axis=1)[::-1]
