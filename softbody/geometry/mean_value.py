"""Points in closed meshes as weighted sums of the vertices: mean value coordinates, and weights in a tetrahedron.

Weights sum to 1 and give the point, so that they carry it along with vertices that move: by an affine map exactly.
"""

from __future__ import annotations

import numpy as np

from softbody.geometry.tetrahedron import points_in_tetrahedra

FLAT = 1e-8  # sine of the corner that a triangle is for a point from which it is its own plane: √ of the rounding
ROUND = 1e-6  # [rad] by which the angles of a triangle that a point is on may fall short of a whole turn
ROUNDING = 1e-12  # of a weight that is 0


def mean_value_weights(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the mean value coordinates (k, n) of `points` (k, 3) [m] in a closed mesh (Ju, Schaefer and Warren 2005).

    `vertices` (n, 3) [m], `triangles` (t, 3), which face outwards; convex or not. The weight of a vertex is the
    integral over all directions of what its hat function is where the ray leaves, by how far away that is, less where
    the ray enters again. A point on a triangle has its barycentric weights there. In a convex mesh all are ≥ 0.
    """
    weights = np.array([_mean_values(vertices - point, triangles) for point in points]).reshape(-1, len(vertices))
    # What rounding leaves of Σ w (x − p) = 0 and Σ w = 1 is taken off by the least change of the weights.
    size = float(np.ptp(vertices, axis=0).max())
    for row, point in zip(weights, points):
        exact = np.column_stack([np.ones(len(vertices)), (vertices - point) / size])
        row += np.linalg.lstsq(exact.T, np.eye(4)[0] - row @ exact, rcond=None)[0]
    return weights


def _mean_values(way: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the weights (n,) of a point from which the vertices are as far as `way` (n, 3) [m].

    Over the part of the unit sphere that a triangle covers, the mean of the direction is ½ Σ θ n, of its sides' angles
    and normals (Floater, Kós and Reimers 2005): weighted sum of the ways to its corners.
    """
    corners = way[triangles]
    after, before = np.roll(corners, -1, axis=1), np.roll(corners, 1, axis=1)
    sides = np.cross(after, before)  # opposite to each corner
    double = np.linalg.norm(sides, axis=2)
    angles = np.arctan2(double, (after * before).sum(axis=2))
    whole = (corners[:, 0] * sides[:, 0]).sum(axis=1)
    is_flat = np.abs(whole) <= FLAT * np.linalg.norm(corners, axis=2).prod(axis=1)
    on = np.flatnonzero(is_flat & (angles.sum(axis=1) >= 2.0 * np.pi - ROUND))
    weights = np.zeros(len(way))
    if len(on):
        weights[triangles[on[0]]] = double[on[0]] / double[on[0]].sum()
        return weights
    mean = 0.5 * (np.divide(angles, double, where=double > 0.0, out=np.zeros_like(double))[:, :, None] * sides).sum(1)
    shares = (sides @ mean[:, :, None])[:, :, 0] / np.where(is_flat, np.inf, whole)[:, None]
    np.add.at(weights, triangles, shares)
    return np.asarray(weights / weights.sum())


def tetrahedron_weights(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the weights (k, n) of `points` (k, 3) [m] in tetrahedra of a triangle and the middle; the paper's §7.

    `vertices` (n, 3) [m], `triangles` (t, 3) of a closed mesh. The middle is the mean of the vertices, each of which
    has its share of the weight. Of tetrahedra that overlap, as they may in a mesh that is not convex, it is the one
    whose triangle is nearest behind the point. The row of a point that is in none is NaN.
    """
    middle, weights = vertices.mean(axis=0), np.full((len(points), len(vertices)), np.nan)
    tetrahedra = np.concatenate([np.broadcast_to(middle, (len(triangles), 1, 3)), vertices[triangles]], axis=1)
    for row, point in zip(weights, points):
        _, each = points_in_tetrahedra(np.broadcast_to(point, (len(triangles), 3)), tetrahedra)
        with np.errstate(invalid="ignore"):
            inside = np.flatnonzero((each >= -ROUNDING).all(axis=1))
        if len(inside):
            chosen = inside[np.argmin(each[inside, 0])]
            row[:] = each[chosen, 0] / len(vertices)
            row[triangles[chosen]] += each[chosen, 1:]
    return weights
