"""Cholesky factor L Lᵀ of a body's six equations, L a lower triangle (Golub, Van Loan §4.2).

The diagonal of L is kept as its reciprocals, so that solving divides by nothing.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit_lean


@jit_lean
def factor(block: np.ndarray) -> None:
    """Replace the lower triangle of a symmetric positive definite `block` (6, 6) by its factor L."""
    for r in range(6):
        for c in range(r):
            s = block[r, c]
            for k in range(c):
                s -= block[r, k] * block[c, k]
            block[r, c] = s * block[c, c]
        s = block[r, r]
        for k in range(r):
            s -= block[r, k] * block[r, k]
        block[r, r] = 1.0 / sqrt(s)


@jit_lean
def solve_lower(block: np.ndarray, x: np.ndarray) -> None:
    """Replace `x` (6,) by the solution y of L y = x, with the L of `factor`."""
    for r in range(6):
        s = x[r]
        for k in range(r):
            s -= block[r, k] * x[k]
        x[r] = s * block[r, r]


@jit_lean
def solve_upper(block: np.ndarray, x: np.ndarray) -> None:
    """Replace `x` (6,) by the solution y of Lᵀ y = x, with the L of `factor`."""
    for r in range(5, -1, -1):
        s = x[r]
        for k in range(r + 1, 6):
            s -= block[k, r] * x[k]
        x[r] = s * block[r, r]
