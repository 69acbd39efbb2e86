"""What floats in a liquid, by closed forms and by its surface as CGAL cuts it: volume, centres, metacentre."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from references import igl


class Wet(NamedTuple):
    """What of a closed surface is below a level."""

    volume: float  # [m³]
    centre: np.ndarray  # (3,) [m] of the volume
    area: float  # [m²] of the surface
    area_centre: np.ndarray  # (3,) [m]


def wet(vertices: np.ndarray, triangles: np.ndarray, level: float) -> Wet:
    """Return what of a closed mesh is below z = `level` [m]: sums over tetrahedra, and triangles, of the cut mesh."""
    points, faces, is_skin = igl.below(vertices, triangles, level)
    if not len(faces):
        return Wet(0.0, np.zeros(3), 0.0, np.zeros(3))
    origin = points.mean(axis=0)
    a, b, c = (points[faces[:, k]] - origin for k in range(3))
    six = np.einsum("ij,ij->i", a, np.cross(b, c))
    centre = (six[:, None] * (a + b + c)).sum(axis=0) / 4.0 / six.sum()
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1) * is_skin
    area_centre = (areas[:, None] * (a + b + c)).sum(axis=0) / 3.0 / areas.sum()
    return Wet(float(six.sum() / 6.0), centre + origin, float(areas.sum()), area_centre + origin)


def depth(vertices: np.ndarray, triangles: np.ndarray, level: float) -> float:
    """Return ∫ depth dV [m⁴] over what of a closed mesh is below z = `level` [m]."""
    below = wet(vertices, triangles, level)
    return below.volume * (level - below.centre[2])


def gyration(size: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the inertia (3, 3) [m²] by mass of a box of an extent [m], in the world: `corners` as of `box_mesh`."""
    axes = np.array([corners[4] - corners[0], corners[2] - corners[0], corners[1] - corners[0]]) / size[:, None]
    square = size**2
    return np.asarray(axes.T @ np.diag((square.sum() - square) / 12.0) @ axes)


def box_mesh(size: np.ndarray, position: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return corners (8, 3) [m] and triangles (12, 3) of a box of an extent [m], turned by a matrix (3, 3)."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    return corners * size @ turn.T + position, np.array(triangles)


def metacentric_height(width: float, height: float, part: float) -> float:
    """Return GM [m] of an upright box: its `width` across the axis it rolls about, `part` of its `height` wet.

    BM is I / V = B² / (12 s H), and B is (1 − s) H / 2 below G; Bouguer 1746.
    """
    return width**2 / (12.0 * part * height) - 0.5 * height * (1.0 - part)


def oscillation(start: float, square: float, h: float, steps: int) -> np.ndarray:
    """Return x (steps + 1,) of x'' = −ω² x from rest at `start`, by x' = x + h v', v' = v − h ω² x; `square` is ω²."""
    x, v = [start], 0.0
    for _ in range(steps):
        v -= h * square * x[-1]
        x.append(x[-1] + h * v)
    return np.array(x)
