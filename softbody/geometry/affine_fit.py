"""The affine motion that all points of a body have in common: what is left of a motion is how it changes shape."""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit
from softbody.linalg.vec import Vec, add, cross, dot, load, scale, store, sub

Rows3 = tuple[Vec, Vec, Vec]

# By how much a body counts as round: what presses a flat one is not what its points have in common. And the least
# stretch of a motion that is taken off: of one that presses a body flat, distances would not tell much.
ROUNDING, LEAST_STRETCH = 1e-3, 0.3


@jit
def mean_of(points: np.ndarray) -> Vec:
    """Return the mean of `points` (n, 3)."""
    mean = (0.0, 0.0, 0.0)
    for i in range(points.shape[0]):
        mean = add(mean, load(points, i))
    return scale(1.0 / points.shape[0], mean)


@jit
def solved(rows: Rows3, right: Vec) -> Vec:
    """Return x of A x = b, the rows of A given; not finite where there is none."""
    a, b, c = rows
    determinant = dot(a, cross(b, c))
    x = add(scale(right[0], cross(b, c)), add(scale(right[1], cross(c, a)), scale(right[2], cross(a, b))))
    return scale(1.0 / determinant, x)


@jit
def turned_by(rows: Rows3, x: Vec) -> Vec:
    """Return A x, the rows of A given."""
    return dot(rows[0], x), dot(rows[1], x), dot(rows[2], x)


@jit
def inertia_of(points: np.ndarray, middle: Vec) -> Rows3:
    """Return the rows of the inertia about a `middle` [m] of `points` (n, 3) [m] of mass 1 each."""
    xx = yy = zz = xy = yz = zx = 0.0
    for i in range(points.shape[0]):
        r = sub(load(points, i), middle)
        xx, yy, zz = xx + r[0] * r[0], yy + r[1] * r[1], zz + r[2] * r[2]
        xy, yz, zx = xy + r[0] * r[1], yz + r[1] * r[2], zx + r[2] * r[0]
    return (yy + zz, -xy, -zx), (-xy, zz + xx, -yz), (-zx, -yz, xx + yy)


@jit
def fit_affine(before: np.ndarray, after: np.ndarray, carried: np.ndarray) -> float:
    """Write into `carried` (n, 3) where the affine motion nearest to that from `before` to `after` takes all points.

    Returns the stretch: no two points come nearer by it than to so many times their distance. Where it would press the
    body flat, or turn it inside out, it is the mean motion.
    """
    n, old, new = before.shape[0], mean_of(before), mean_of(after)
    xx = yy = zz = xy = yz = zx = 0.0
    u, v, w = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(n):
        p, q = sub(load(before, i), old), sub(load(after, i), new)
        xx, yy, zz = xx + p[0] * p[0], yy + p[1] * p[1], zz + p[2] * p[2]
        xy, yz, zx = xy + p[0] * p[1], yz + p[1] * p[2], zx + p[2] * p[0]
        u, v, w = add(u, scale(q[0], p)), add(v, scale(q[1], p)), add(w, scale(q[2], p))
    more = ROUNDING * (xx + yy + zz)
    square = (xx + more, xy, zx), (xy, yy + more, yz), (zx, yz, zz + more)
    u, v, w = (u[0] + more, u[1], u[2]), (v[0], v[1] + more, v[2]), (w[0], w[1], w[2] + more)
    rows = solved(square, u), solved(square, v), solved(square, w)
    # The square of no length is less than its 1 − |Aᵀ A − 1| th part.
    a, b, c = _columns(rows)
    aside = dot(a, b) ** 2 + dot(b, c) ** 2 + dot(c, a) ** 2
    strain = (dot(a, a) - 1.0) ** 2 + (dot(b, b) - 1.0) ** 2 + (dot(c, c) - 1.0) ** 2 + 2.0 * aside
    stretch = sqrt(max(0.0, 1.0 - sqrt(strain))) if dot(a, cross(b, c)) > 0.0 else 0.0
    if not stretch > LEAST_STRETCH:
        stretch, rows = 1.0, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for i in range(n):
        store(carried, i, add(new, turned_by(rows, sub(load(before, i), old))))
    return stretch


@jit
def _columns(rows: Rows3) -> Rows3:
    """Return the columns of a matrix whose rows are given."""
    a, b, c = rows
    return (a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2])
