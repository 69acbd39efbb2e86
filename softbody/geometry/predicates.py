"""Orientation predicates: the side of a line or plane that a point is on, exact, and fast where clear.

A floating-point filter first: a determinant of differences in float64. If it is larger than its rounding can be, its
sign is right. Where the filter fails, the sign is decided by exact arithmetic on sums of floats that do not overlap
(Shewchuk 1997). So the sign is that of the very numbers given, for coordinates between 1e-60 and 1e60 m: beyond, a
product of three under- or overflows.
"""

from __future__ import annotations

from math import isnan

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import Vec, sub

HALF_ULP = 2.0**-53

# What rounding can make of the two determinants, as a part of the sum of their terms' sizes (Shewchuk 1997, §4.2–4.3).
LINE_ROUNDING = (3.0 + 16.0 * HALF_ULP) * HALF_ULP
PLANE_ROUNDING = (7.0 + 56.0 * HALF_ULP) * HALF_ULP

SPLITTER = 2.0**27 + 1.0  # halves the 53 bits of a float64

LINE_TERMS = 12  # of the exact determinant of three points: six products of two floats each
PLANE_TERMS = 4 * 2 * LINE_TERMS


@jit
def _split(a: float) -> tuple[float, float]:
    """Return two floats of 26 bits that sum to `a` (Dekker 1971)."""
    c = SPLITTER * a
    high = c - (c - a)
    return high, a - high


@jit
def _product(a: float, b: float) -> tuple[float, float]:
    """Return a b and its rounding error: together, the product exactly (Dekker 1971)."""
    product = a * b
    a_high, a_low = _split(a)
    b_high, b_low = _split(b)
    return product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)


@jit
def _grow(terms: np.ndarray, count: int, x: float) -> int:
    """Add `x` to the exact sum in terms[:count], of growing size, none overlapping; return the new count."""
    kept = 0
    carry = x
    for i in range(count):
        total = carry + terms[i]
        virtual = total - carry
        rest = (carry - (total - virtual)) + (terms[i] - virtual)
        carry = total
        if rest != 0.0:
            terms[kept] = rest
            kept += 1
    if carry != 0.0:
        terms[kept] = carry
        kept += 1
    return kept


@jit
def _grow_by_product(terms: np.ndarray, count: int, a: float, b: float) -> int:
    product, rest = _product(a, b)
    return _grow(terms, _grow(terms, count, rest), product)


@jit
def _exact_turn(terms: np.ndarray, a: Vec, b: Vec, c: Vec) -> int:
    """Put det(a, b, c with a row of ones), seen from above, into `terms` (12,), exactly; return the number of terms."""
    n = _grow_by_product(terms, 0, a[0], b[1])
    n = _grow_by_product(terms, n, -a[1], b[0])
    n = _grow_by_product(terms, n, b[0], c[1])
    n = _grow_by_product(terms, n, -b[1], c[0])
    n = _grow_by_product(terms, n, c[0], a[1])
    return _grow_by_product(terms, n, -c[1], a[0])


@jit
def _exact_orient2d(a: Vec, b: Vec, p: Vec) -> float:
    terms = np.empty(LINE_TERMS)
    count = _exact_turn(terms, a, b, p)
    return terms[count - 1] if count > 0 else 0.0


@jit
def orient2d(a: Vec, b: Vec, p: Vec) -> float:
    """Return a number whose sign tells where `p` is, seen from above along the line from a to b: + left, − right.

    0 on the line; z plays no part. Twice the area of the triangle (a, b, p) [m²], to rounding; the sign is exact.
    """
    left = (a[0] - p[0]) * (b[1] - p[1])
    right = (a[1] - p[1]) * (b[0] - p[0])
    turn = left - right
    if abs(turn) >= LINE_ROUNDING * (abs(left) + abs(right)):
        return turn
    return _exact_orient2d(a, b, p)


@jit
def _grow_by_scaled_turn(terms: np.ndarray, count: int, z: float, corners: tuple[Vec, Vec, Vec]) -> int:
    """Add z det(a, b, c with a row of ones), seen from above, to the exact sum in `terms`."""
    turn = np.empty(LINE_TERMS)
    for i in range(_exact_turn(turn, corners[0], corners[1], corners[2])):
        count = _grow_by_product(terms, count, z, turn[i])
    return count


@jit
def _exact_orient3d(a: Vec, b: Vec, c: Vec, p: Vec) -> float:
    terms = np.empty(PLANE_TERMS)
    n = _grow_by_scaled_turn(terms, 0, a[2], (b, c, p))
    n = _grow_by_scaled_turn(terms, n, -b[2], (a, c, p))
    n = _grow_by_scaled_turn(terms, n, c[2], (a, b, p))
    n = _grow_by_scaled_turn(terms, n, -p[2], (a, b, c))
    return terms[n - 1] if n > 0 else 0.0


@jit_lean
def orient3d_filtered(a: Vec, b: Vec, c: Vec, p: Vec) -> float:
    """Return the number of `orient3d`, or NaN where rounding might decide its sign."""
    ax, ay, az = sub(a, p)
    bx, by, bz = sub(b, p)
    cx, cy, cz = sub(c, p)
    bc, cb = bx * cy, cx * by
    ca, ac = cx * ay, ax * cy
    ab, ba = ax * by, bx * ay
    six_volumes = az * (bc - cb) + bz * (ca - ac) + cz * (ab - ba)
    size = (abs(bc) + abs(cb)) * abs(az) + (abs(ca) + abs(ac)) * abs(bz) + (abs(ab) + abs(ba)) * abs(cz)
    return six_volumes if abs(six_volumes) >= PLANE_ROUNDING * size else np.nan


@jit
def orient3d(a: Vec, b: Vec, c: Vec, p: Vec) -> float:
    """Return a number whose sign tells where `p` is: + behind the triangle (a, b, c), 0 in its plane, − in front.

    The front is where the triangle turns counter-clockwise. Six volumes of the tetrahedron [m³], to rounding; the sign
    is exact.
    """
    six_volumes = orient3d_filtered(a, b, c, p)
    return _exact_orient3d(a, b, c, p) if isnan(six_volumes) else six_volumes
