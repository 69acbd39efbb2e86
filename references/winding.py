"""Generalised winding numbers of a mesh around points, in NumPy.

The sum of the signed solid angles of the triangles (van Oosterom and Strackee 1983), over 4π: 1 inside a closed mesh,
0 outside (Jacobson, Kavan and Sorkine-Hornung 2013). No ray, so nothing special at edges and vertices seen from afar.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# Part of the size [m/m]. Points nearer to the surface may be judged either way. Leave them out.
MARGIN = 1e-12

ENTRIES = 20_000  # point–triangle pairs at a time: 0.16 MB an array, which the processor's cache holds


def winding_numbers(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the winding number (m,) of a mesh around each of `points` (m, 3) [m].

    `vertices` (n, 3) [m], `triangles` (t, 3). On the surface of a smooth closed mesh the value is near ½.
    """
    points = np.asarray(points, float)
    chunk = max(1, ENTRIES // len(triangles))
    parts = [
        _solid_angles(points[start : start + chunk], vertices, triangles).sum(axis=1)
        for start in range(0, len(points), chunk)
    ]
    return np.concatenate([np.empty(0), *parts]) / (4.0 * np.pi)


def points_in_mesh(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell for each of `points` (m, 3) [m] whether it is inside a closed mesh: (m,) of bool, beyond MARGIN."""
    return winding_numbers(points, vertices, triangles) > 0.5


def _solid_angles(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the signed solid angle (m, t) [sr] of each triangle from each point: tan(Ω/2) = a·(b×c) / (…)."""
    seen = np.asarray(vertices, float).T[:, None] - points.T[:, :, None]
    distance = np.sqrt(_dot(seen, seen))
    a, b, c = (seen[:, :, triangles[:, k]] for k in range(3))
    al, bl, cl = (distance[:, triangles[:, k]] for k in range(3))
    triple = _dot(a, (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]))
    return 2.0 * np.arctan2(triple, al * bl * cl + _dot(a, b) * cl + _dot(b, c) * al + _dot(c, a) * bl)


def _dot(a: Sequence[np.ndarray] | np.ndarray, b: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
