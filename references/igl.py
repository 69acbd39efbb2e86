"""Point in mesh, distance to the surface and self-intersections by libigl (Jacobson and others).

Three ways to tell inside from outside that have nothing in common: the exact winding number, the sign of the distance
along the pseudonormal of the closest feature (Baerentzen and Aanaes 2005), and the fast winding number (Barill and
others 2018), which is an approximation.

Pairs of triangles that meet are found with CGAL's exact predicates; libigl leaves out neighbours that are folded onto
each other along a common edge, and triangles of the same three vertices. Vertices are the same if their numbers are.
"""

from __future__ import annotations

import os

import igl
import igl.copyleft.cgal
import numpy as np

PACKAGES = {"igl": "libigl"}  # import name, and the name to install it by
SETTINGS = {  # what was chosen against the defaults, and why
    "the sign of signed_distance is named": "by default it is chosen by the kind of mesh",
}

# Part of the size [m/m]. Points nearer to the surface may be judged either way by the first two. Leave them out.
MARGIN = 1e-12


def points_in_mesh(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell for each of `points` (m, 3) [m] whether a closed mesh winds around it: (m,) of bool, beyond MARGIN."""
    return np.asarray(igl.winding_number(*_arrays(vertices, triangles), _rows(points))) > 0.5


def points_in_mesh_by_distance(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell for each of `points` (m, 3) [m] whether its closest surface faces away: (m,) of bool, beyond MARGIN."""
    kind = igl.SIGNED_DISTANCE_TYPE_PSEUDONORMAL
    return np.asarray(igl.signed_distance(_rows(points), *_arrays(vertices, triangles), kind)[0]) < 0.0


def points_in_mesh_fast(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell the same by the fast winding number, an approximation in float32: beyond about 1e-5 of the size."""
    return np.asarray(igl.fast_winding_number(*_arrays(vertices, triangles), _rows(points))) > 0.5


def closest_points(
    points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (distance (m,) [m], triangle (m,), point (m, 3) [m]) of the surface closest to each of `points` (m, 3)."""
    square, triangle, point = igl.point_mesh_squared_distance(_rows(points), *_arrays(vertices, triangles))
    return np.sqrt(square), np.asarray(triangle), np.asarray(point)


def self_intersections(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the pairs (p, 2) of triangles that go through each other or touch, in order; see above for two kinds."""
    pairs = igl.copyleft.cgal.remesh_self_intersections(*_arrays(vertices, triangles), detect_only=True)[2]
    return np.unique(np.sort(np.asarray(pairs).reshape(-1, 2), axis=1), axis=0)


def shells(triangles: np.ndarray) -> np.ndarray:
    """Return the shell (t,) of each triangle: those that hang together by edges."""
    return np.asarray(igl.facet_components(np.ascontiguousarray(triangles, dtype=np.int64))[-1])


def is_pinched(triangles: np.ndarray) -> np.ndarray:
    """Tell for each vertex (n,) whether its triangles are not one fan."""
    return ~np.asarray(igl.is_vertex_manifold(np.ascontiguousarray(triangles, dtype=np.int64)), bool).ravel()


def _rows(points: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(points, dtype=np.float64)


def _arrays(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return _rows(vertices), np.ascontiguousarray(triangles, dtype=np.int64)


def read_mesh(path: str | os.PathLike[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) and triangles (t, 3) of an STL, PLY, OBJ or OFF file, as they stand there."""
    vertices, triangles = igl.read_triangle_mesh(os.fspath(path))
    return np.asarray(vertices, np.float64), np.asarray(triangles, np.int64)


def below(vertices: np.ndarray, triangles: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what of a closed mesh is below z = `level` [m], closed: vertices (n, 3) and triangles (t, 3).

    By exact arithmetic. And of each triangle whether it is of the mesh's own surface (t,), and not of the lid.
    """
    return behind(vertices, triangles, np.array([0.0, 0.0, level]), np.array([0.0, 0.0, 1.0]))


def behind(
    vertices: np.ndarray, triangles: np.ndarray, point: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return as `below` what is behind the plane through `point` (3,) [m], where its `normal` (3,) does not point."""
    points, faces, birth = igl.copyleft.cgal.intersect_with_half_space(
        *_arrays(vertices, triangles), np.asarray(point, float), np.asarray(normal, float)
    )
    return np.asarray(points), np.asarray(faces), np.asarray(birth).ravel() < len(triangles)
