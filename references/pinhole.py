"""Pinhole camera that stands at `eye` and looks at `target`: its axes by Panda3D, the rest by hand.

A pinhole camera: a point that is `far` [m] along the view, and `x` to the right, is seen f x / far pixels to the right
of the picture's middle. The focal length f is so long that half of the height is seen under half of the angle of view.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from panda3d.core import LMatrix3d, LVector3d, look_at

PACKAGES = {"panda3d": "panda3d"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {"z is up, and y for a camera that looks along z": "what the core promises; Panda3D takes any"}


class Disc(NamedTuple):
    """The ellipse that a sphere is in a picture."""

    middle: np.ndarray  # (2,) column and row [pixels], from the upper left corner
    area: float  # [pixels²]
    reach: float  # half of its longest axis [pixels]


def axes(eye: ArrayLike, target: ArrayLike) -> np.ndarray:
    """Return the unit vectors to the right, upwards and forwards, as rows (3, 3)."""
    forward = np.subtract(target, eye)
    up = (0.0, 0.0, 1.0) if np.hypot(forward[0], forward[1]) > 0.0 else (0.0, 1.0, 0.0)
    matrix = LMatrix3d()
    look_at(matrix, LVector3d(*forward.tolist()), LVector3d(*up))
    right, ahead, upwards = (np.array(matrix.get_row(k)) for k in range(3))
    return np.array([right, upwards, ahead])


def focal_length(view: float, size: tuple[int, int]) -> float:
    """Return the focal length [pixels] of a picture of `size` (width, height) under a vertical angle [degrees]."""
    return float(0.5 * size[1] / np.tan(0.5 * np.radians(view)))


def rays(eye: ArrayLike, target: ArrayLike, view: float, size: tuple[int, int]) -> np.ndarray:
    """Return the directions (h w, 3) in which the middles of pixels are seen, row by row."""
    across, down = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    f = focal_length(view, size)
    aside = np.stack([across - 0.5 * size[0], 0.5 * size[1] - down, np.full(across.shape, f)], axis=-1)
    return aside.reshape(-1, 3) @ axes(eye, target)


def disc(
    eye: ArrayLike, target: ArrayLike, view: float, size: tuple[int, int], centre: ArrayLike, radius: float
) -> Disc:
    """Return how a sphere is seen, which the camera is not in: `centre` (3,) [m], `radius` [m].

    Its outline is a cone of half-angle α, sin α = radius/distance, about a line at θ from the view. The picture cuts it
    in an ellipse of half-axes f sin α cos α/q, along the way to the middle, and f sin α/√q, with q = cos² θ − sin² α;
    its centre is f sin θ cos θ/q away.
    """
    to = axes(eye, target) @ np.subtract(centre, eye)
    away = np.linalg.norm(to)
    sine, cosine, tilt = radius / away, np.sqrt(1.0 - (radius / away) ** 2), to[2] / away
    q, f = tilt**2 - sine**2, focal_length(view, size)
    if not (q > 0.0 and to[2] > 0.0):
        raise ValueError("the outline of the sphere is no ellipse: the camera is too near, or looks elsewhere")
    aside = f * tilt / q * to[:2] / away
    middle = np.array([0.5 * size[0] + aside[0], 0.5 * size[1] - aside[1]])
    long, short = float(f * sine * cosine / q), float(f * sine / np.sqrt(q))
    return Disc(middle, np.pi * long * short, long)
