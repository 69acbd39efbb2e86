"""Borders of an open surface: where they run, and the fans of triangles that would close each hole.

A fan is about the middle of its hole's corners, so that it does not depend on which of them is the first.
"""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import Vec, add, cross, dot, load, norm, scale, sub

NONE = -1

WIDE = 0.5  # of its own area: a skin with holes larger than that holds no gas


@jit
def border_of(count: int, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertex after each of `count`, and that before it, along the border as its triangles run; NONE inside.

    `triangles` (t, 3), oriented, of which one fan at most that is open meets in a vertex. Around a vertex each triangle
    adds the neighbour that comes first in it and takes the last away. What is left is the first neighbour of the fan
    less its last; the squares leave the difference of the squares.
    """
    difference, of_squares = np.zeros(count, np.int64), np.zeros(count, np.int64)
    for t in range(triangles.shape[0]):
        for c in range(3):
            i, first, last = triangles[t, c], triangles[t, (c + 1) % 3], triangles[t, (c + 2) % 3]
            difference[i] += first - last
            of_squares[i] += first * first - last * last
    after, before = np.full(count, NONE), np.full(count, NONE)
    for i in range(count):
        if difference[i] != 0:
            both = of_squares[i] // difference[i]
            after[i], before[i] = (both + difference[i]) // 2, (both - difference[i]) // 2
    return after, before


@jit
def holes_of(count: int, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices (k,) along all borders, hole by hole, and the rows (h, 2) where each begins and ends."""
    after, _ = border_of(count, triangles)
    border, rows = np.empty(count, np.int64), np.empty((count // 3 + 1, 2), np.int64)
    placed = found = 0
    for first in range(count):
        if after[first] != NONE:
            rows[found, 0] = placed
            vertex = first
            while after[vertex] != NONE:
                border[placed] = vertex
                placed += 1
                after[vertex], vertex = NONE, after[vertex]
            rows[found, 1] = placed
            found += 1
    return border[:placed].copy(), rows[:found].copy()


@jit_lean
def hole(points: np.ndarray, border: np.ndarray, rows: tuple[int, int]) -> tuple[Vec, Vec]:
    """Return the middle [m] of a hole's corners, and the area vector [m²] of its fan, out of the surface.

    `points` (n, 3) [m]; `border` and `rows` as of `holes_of`.
    """
    first, end = rows
    middle, area = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for k in range(first, end):
        middle = add(middle, _place(points, border[k]))
    middle = scale(1.0 / (end - first), middle)
    before = sub(_place(points, border[end - 1]), middle)
    for k in range(first, end):
        here = sub(_place(points, border[k]), middle)
        area = add(area, cross(here, before))
        before = here
    return middle, scale(0.5, area)


@jit_lean
def holds_gas(volume: float, open_area: float, area: float) -> bool:
    """Tell whether a skin of such an `area`, with holes of `open_area` [m²], is still a vessel, of a `volume` [m³]."""
    return volume > 0.0 and open_area < WIDE * area


@jit_lean
def volume_of_fan(middle: Vec, area: Vec, origin: Vec) -> float:
    """Return the signed volume [m³] between the fan of a hole and an `origin` (3,) [m]."""
    return dot(sub(middle, origin), area) / 3.0


@jit
def fans_of_holes(points: np.ndarray, triangles: np.ndarray) -> tuple[float, float]:
    """Return the volume [m³] that the fans of all holes add to `signed_volume` of triangles (t, 3), and their area."""
    origin, volume, open_area = load(points, triangles[0, 0]), 0.0, 0.0
    border, rows = holes_of(points.shape[0], triangles)
    for k in range(rows.shape[0]):
        middle, area = hole(points, border, (rows[k, 0], rows[k, 1]))
        volume += volume_of_fan(middle, area, origin)
        open_area += norm(area)
    return volume, open_area


@jit_lean
def _place(points: np.ndarray, i: int) -> Vec:
    """Return a point in double precision, whatever that of `points` is."""
    return scale(1.0, load(points, i))
