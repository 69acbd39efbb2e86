"""Pixels of pictures, and frames of films with their durations, read by Pillow."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageSequence

PACKAGES = {"PIL": "pillow"}  # import name, and the name to install it by


class Film(NamedTuple):
    """What a viewer shows."""

    frames: np.ndarray  # (f, h, w, 3) of uint8
    milliseconds: np.ndarray  # (f,) that each stays
    loops: int  # 0: for ever


def picture(path: str | Path) -> np.ndarray:
    """Return the pixels (h, w, 3) of uint8 of a picture's file."""
    with Image.open(path) as image:
        return np.array(image.convert("RGB"))


def film(path: str | Path) -> Film:
    """Return what an animated file shows."""
    with Image.open(path) as image:
        frames, stays = [], []
        for frame in ImageSequence.Iterator(image):
            frames.append(np.array(frame.convert("RGB")))
            stays.append(frame.info["duration"])
        return Film(np.array(frames), np.array(stays), image.info["loop"])
