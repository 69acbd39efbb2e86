"""Axis-aligned bounding boxes: that of a set of points, and whether two meet."""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.linalg.vec import Vec, load

AABB = tuple[Vec, Vec]  # low and high corner [m]


@jit_lean
def bounding_box(points: np.ndarray) -> AABB:
    """Return the low and the high corner [m] of `points` (n, 3); NaN in both if any number is not finite."""
    x0 = x1 = points[0, 0]
    y0 = y1 = points[0, 1]
    z0 = z1 = points[0, 2]
    spoiled = 0.0
    for i in range(points.shape[0]):
        x, y, z = load(points, i)
        x0, x1 = min(x0, x), max(x1, x)
        y0, y1 = min(y0, y), max(y1, y)
        z0, z1 = min(z0, z), max(z1, z)
        spoiled += 0.0 * x + 0.0 * y + 0.0 * z  # inf · 0 is NaN
    return (x0 + spoiled, y0 + spoiled, z0 + spoiled), (x1 + spoiled, y1 + spoiled, z1 + spoiled)


@jit_lean
def box_around(p: Vec, q: Vec, margin: float) -> AABB:
    """Return the corners [m] of the box around two points, and a `margin`."""
    low = min(p[0], q[0]) - margin, min(p[1], q[1]) - margin, min(p[2], q[2]) - margin
    return low, (max(p[0], q[0]) + margin, max(p[1], q[1]) + margin, max(p[2], q[2]) + margin)


@jit_lean
def boxes_meet(a: AABB, b: AABB) -> bool:
    """Tell whether two boxes have a point in common; not if any number is not finite."""
    for axis in range(3):  # noqa: SIM110 (Numba has no all() of a generator)
        if not (a[0][axis] <= b[1][axis] and b[0][axis] <= a[1][axis]):
            return False
    return True
