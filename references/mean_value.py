"""Mean value coordinates by the integral that defines them (Ju, Schaefer and Warren 2005), and weights in tetrahedra.

The weight of a vertex is ∫ φ / r dΩ, over all directions from the point, of its hat function φ where the surface is, r
away; where it faces the point it counts as less than nothing. With dΩ = n · (q − p) / r³ dA it is an integral over the
triangles. They are split until none is longer than half of how far away it is, and taken by Gauss and Legendre.
"""

from __future__ import annotations

import numpy as np

ORDER = 10  # nodes along each side of a triangle: its part is off by 1e-16 then
HALVES = (
    np.array(  # barycentric corners of the four triangles that the middles of sides cut one into
        [
            [[2, 0, 0], [1, 1, 0], [1, 0, 1]],
            [[1, 1, 0], [0, 2, 0], [0, 1, 1]],
            [[1, 0, 1], [0, 1, 1], [0, 0, 2]],
            [[0, 1, 1], [1, 0, 1], [1, 1, 0]],
        ]
    )
    / 2.0
)


def weights(point: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the mean value coordinates (n,) of a point (3,) [m] that is in a closed mesh and not on it."""
    node, share = np.polynomial.legendre.leggauss(ORDER)
    u, v = (rows.ravel() for rows in np.meshgrid(0.5 + 0.5 * node, 0.5 + 0.5 * node, indexing="ij"))
    places = np.column_stack([1.0 - u, u * (1.0 - v), u * v])  # a square, one side of which is drawn together (Duffy)
    measure = 0.25 * np.outer(share, share).ravel() * u
    total = np.zeros(len(vertices))
    whose, corners = np.arange(len(triangles)), np.broadcast_to(np.eye(3), (len(triangles), 3, 3))
    while len(whose):
        way = corners @ vertices[triangles[whose]] - point
        longest = np.linalg.norm(way - np.roll(way, 1, axis=1), axis=2).max(axis=1)
        far = np.linalg.norm(way.mean(axis=1), axis=1) >= 2.0 * longest
        area = np.cross(way[far, 1] - way[far, 0], way[far, 2] - way[far, 0])  # twice it
        at = places @ way[far]
        steepness = (at @ area[:, :, None])[:, :, 0] / (at**2).sum(axis=2) ** 2
        parts = ((measure * steepness)[:, :, None] * (places @ corners[far])).sum(axis=1)
        np.add.at(total, triangles[whose[far]], parts)
        corners = (HALVES[None] @ corners[~far][:, None]).reshape(-1, 3, 3)
        whose = np.repeat(whose[~far], len(HALVES))
    return total / total.sum()


def tetrahedron(point: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the weights (n,) of a point (3,) [m] in the tetrahedron of the middle and a triangle that it is in.

    Where there are several, by the one whose triangle the ray from the middle meets first.
    """
    middle = vertices.mean(axis=0)
    ways = np.swapaxes(vertices[triangles] - middle, 1, 2)
    ways, triangles = (rows[np.linalg.det(ways) != 0.0] for rows in (ways, triangles))
    shares = np.linalg.solve(ways, np.broadcast_to((point - middle)[:, None], (len(ways), 3, 1)))[:, :, 0]
    total = shares.sum(axis=1)
    is_in = (shares >= 0.0).all(axis=1) & (total > 0.0) & (total <= 1.0)
    first = np.argmax(np.where(is_in, total, -1.0))
    result = np.full(len(vertices), (1.0 - total[first]) / len(vertices))
    result[triangles[first]] += shares[first]
    return result
