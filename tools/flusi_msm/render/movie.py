# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a movie of pictures: MP4 by ffmpeg if this is found, else an animated GIF by Pillow."""
from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from flusi_msm.errors import InputError


def choose_movie(folder: str | Path, output: Path | None) -> Path:
    """Returns the file to write: `output`, or movie.mp4 in the folder, or movie.gif without ffmpeg."""
    if output is None:
        return Path(folder) / ("movie.mp4" if shutil.which("ffmpeg") else "movie.gif")
    if output.suffix not in (".mp4", ".gif"):
        raise InputError(f"{output}: a movie is a .mp4 or a .gif")
    if output.suffix == ".mp4" and not shutil.which("ffmpeg"):
        raise InputError(f"{output}: ffmpeg is not found; install it, or write a .gif")
    return output


def write_movie(pictures: Sequence[Path], out: Path, rate: float) -> None:
    """Writes the pictures in order, all as large as the first, at `rate` per second."""
    frames = [Image.open(path).convert("RGB") for path in pictures]
    width, height = frames[0].size
    size = (2 * (width // 2), 2 * (height // 2))  # MP4 needs even numbers
    frames = [frame if frame.size == size else frame.resize(size, Image.Resampling.LANCZOS) for frame in frames]
    try:
        if out.suffix == ".gif":
            frames[0].save(out, save_all=True, append_images=frames[1:], duration=round(1000 / rate), loop=0)
        else:
            write_mp4(frames, out, rate)
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror or error}") from None
    print(out)


def write_mp4(frames: Sequence[Image.Image], out: Path, rate: float) -> None:
    """Writes a movie with ffmpeg."""
    with tempfile.TemporaryDirectory() as folder:
        for number, frame in enumerate(frames):
            frame.save(Path(folder) / f"{number:06d}.png")
        done = subprocess.run(["ffmpeg", "-y", "-loglevel", "error", "-framerate", str(rate), "-i", f"{folder}/%06d.png",
                               "-pix_fmt", "yuv420p", str(out)], capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"{out}: ffmpeg fails; a .gif needs none: {done.stderr.strip()[-300:]}")
