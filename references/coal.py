"""Overlap and depth of two boxes or convex meshes by coal (once hpp-fcl; Mirabel, Montaut and others).

The normal of its signed distance points from the first to the second shape.
"""

from __future__ import annotations

import coal
import numpy as np

PACKAGES = {"coal": "coal"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "tolerances of GJK and EPA 1e-10 m (1e-6)": "shapes nearer than that count as touching; even so a margin is left",
    "signed distance": "depths are answered too, by EPA",
}

# [m], absolute, at sizes near 1 m. Shapes whose separation is smaller may be judged either way. Leave them out.
MARGIN = 1e-6

TOLERANCE = 1e-10  # [m] of GJK and EPA


def boxes_overlap(
    size_a: np.ndarray,
    position_a: np.ndarray,
    orientation_a: np.ndarray,
    size_b: np.ndarray,
    position_b: np.ndarray,
    orientation_b: np.ndarray,
) -> np.ndarray:
    """Tell for each of m pairs of boxes whether they overlap: (m,) of bool, to be trusted beyond MARGIN.

    Sizes (m, 3) full extents [m], positions (m, 3) [m], orientations (m, 4) unit quaternions (w, x, y, z).
    """
    rows = zip(size_a, position_a, orientation_a, size_b, position_b, orientation_b)
    return np.array(
        [_collide(coal.Box(*s), _pose(p, q), coal.Box(*t), _pose(r, u)) for s, p, q, t, r, u in rows], dtype=bool
    )


def convex_overlap(
    vertices_a: np.ndarray, triangles_a: np.ndarray, vertices_b: np.ndarray, triangles_b: np.ndarray
) -> bool:
    """Tell whether two convex meshes overlap, beyond MARGIN; vertices (n, 3) [m], triangles (t, 3)."""
    rest = coal.Transform3s()
    return _collide(_convex(vertices_a, triangles_a), rest, _convex(vertices_b, triangles_b), rest)


def convex_distance(
    vertices_a: np.ndarray, triangles_a: np.ndarray, vertices_b: np.ndarray, triangles_b: np.ndarray
) -> float:
    """Return the distance [m] of two convex meshes; minus the least depth over all directions where they overlap."""
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = TOLERANCE
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    rest = coal.Transform3s()
    a, b = _convex(vertices_a, triangles_a), _convex(vertices_b, triangles_b)
    return float(coal.distance(a, rest, b, rest, request, coal.DistanceResult()))


def _collide(a: coal.ShapeBase, pose_a: coal.Transform3s, b: coal.ShapeBase, pose_b: coal.Transform3s) -> bool:
    request = coal.CollisionRequest()
    request.gjk_tolerance = request.epa_tolerance = TOLERANCE
    return coal.collide(a, pose_a, b, pose_b, request, coal.CollisionResult()) > 0


def _pose(position: np.ndarray, orientation: np.ndarray) -> coal.Transform3s:
    w, x, y, z = orientation
    matrix = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return coal.Transform3s(matrix, np.asarray(position, float))


def _convex(vertices: np.ndarray, triangles: np.ndarray) -> coal.Convex:
    points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for vertex in np.asarray(vertices, float):
        points.append(vertex)
    for i, j, k in np.asarray(triangles):
        faces.append(coal.Triangle(int(i), int(j), int(k)))
    return coal.Convex(points, faces)
