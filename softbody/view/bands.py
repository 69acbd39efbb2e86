"""Bands that show a quantity on a mesh of one colour only: each a mesh of its own."""

from __future__ import annotations

import numpy as np

LEVELS = 12


def bands_of(
    vertices: np.ndarray, triangles: np.ndarray, values: np.ndarray, least: float, greatest: float
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the part of a mesh that belongs to each of LEVELS equal parts of the range: vertices and triangles.

    A triangle belongs where the mean of its three `values` (n,) does; every vertex that a part needs is in it.
    """
    means = values[triangles].mean(axis=1)
    level = np.clip((means - least) * (LEVELS / max(greatest - least, 1e-300)), 0, LEVELS - 1).astype(np.int64)
    parts = []
    for k in range(LEVELS):
        used, renumbered = np.unique(triangles[level == k], return_inverse=True)
        parts.append((vertices[used], renumbered.reshape(-1, 3)))
    return parts
