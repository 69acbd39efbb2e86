"""3-vectors as tuples: the arithmetic every kernel is written in."""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit, jit_lean

Vec = tuple[float, float, float]


@jit_lean
def load(rows: np.ndarray, i: int) -> Vec:
    """Return row `i` of an `(n, 3)` array."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@jit_lean
def store(rows: np.ndarray, i: int, a: Vec) -> None:
    """Overwrite row `i` of an `(n, 3)` array."""
    rows[i, 0] = a[0]
    rows[i, 1] = a[1]
    rows[i, 2] = a[2]


@jit_lean
def accumulate(rows: np.ndarray, i: int, a: Vec) -> None:
    """Add `a` to row `i` of an `(n, 3)` array."""
    rows[i, 0] += a[0]
    rows[i, 1] += a[1]
    rows[i, 2] += a[2]


@jit
def add(a: Vec, b: Vec) -> Vec:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@jit
def sub(a: Vec, b: Vec) -> Vec:
    """Return a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@jit
def scale(s: float, a: Vec) -> Vec:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@jit
def multiply(a: Vec, b: Vec) -> Vec:
    """Return the product by components, such as that of a diagonal matrix and a vector."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


@jit
def dot(a: Vec, b: Vec) -> float:
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit
def cross(a: Vec, b: Vec) -> Vec:
    """Return a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@jit
def norm(a: Vec) -> float:
    """Return |a|."""
    return sqrt(dot(a, a))


@jit
def normalize(a: Vec) -> Vec:
    """Return a / |a|; the caller makes sure that a is not zero."""
    return scale(1.0 / norm(a), a)
