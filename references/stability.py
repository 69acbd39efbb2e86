"""Bounds of a soft body's frequency and damping, and so of its step, by their formulas in NumPy.

numpy only. Whether they are bounds is another question: `references.scipy.highest_frequency` answers it by eigenvalues.
"""

from __future__ import annotations

import numpy as np


def highest_frequency(
    vertices: np.ndarray,
    edges: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
    inverse_mass: np.ndarray,
) -> float:
    """Return the bound of ω [rad/s] of springs (e,) [N/m] and gas [J] between `vertices` (n, 3), 1/m (n,), 0 for pins.

    ω² ≤ max over edges of Σk/m at both ends (Anderson and Morley 1985), for the springs; nRT/V² Σ|∂V/∂x|²/m, for the
    gas's part of rank one; and P times the largest sum of blocks of ∂²V/∂x² in a row, each as long as half of the
    median of a triangle over 3, 1/m included.
    """
    corners = vertices[triangles]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    gradient, bending = np.zeros(vertices.shape), np.zeros(len(vertices))
    for corner, (p, q) in enumerate(((b, c), (c, a), (a, b))):
        np.add.at(gradient, triangles[:, corner], np.cross(p, q) / 6.0)
        median = np.linalg.norm(corners[:, corner] - 0.5 * (p + q), axis=1)
        for other in ((corner + 1) % 3, (corner + 2) % 3):
            np.add.at(bending, triangles[:, other], median / 6.0)
    pressure = abs(gas / volume)
    rank_one = (np.square(gradient).sum(axis=1) * inverse_mass).sum() / abs(volume)
    squares = _laplacian_bound(edges, stiffness, inverse_mass) + pressure * (rank_one + (bending * inverse_mass).max())
    return float(np.sqrt(squares))


def highest_damping(edges: np.ndarray, damping: float, drag: float, inverse_mass: np.ndarray) -> float:
    """Return the bound of γ [1/s], v' = −γ v, of springs that damp [N s/m] between particles with drag [1/s]."""
    return damping * _laplacian_bound(edges, np.ones(len(edges)), inverse_mass) + drag


def longest_step(frequency: float, damping: float, limit: float) -> float:
    """Return h [s] with (ω h / limit)² + γ h / 2 = 1, by the quadratic formula."""
    return float(2.0 / (0.5 * damping + np.sqrt(0.25 * damping**2 + 4.0 * (frequency / limit) ** 2)))


def _laplacian_bound(edges: np.ndarray, weight: np.ndarray, inverse_mass: np.ndarray) -> float:
    """Return the largest Σw/m at both ends of an edge."""
    sums = np.zeros(len(inverse_mass))
    for end in (0, 1):
        np.add.at(sums, edges[:, end], weight)
    return float((sums * inverse_mass)[edges].sum(axis=1).max())
