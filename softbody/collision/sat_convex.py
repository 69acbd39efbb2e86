"""Separating-axis test of two convex meshes: whether they overlap, and along which axis least; for geometry users."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from softbody.collision.edge_edge import PARALLEL_SINE
from softbody.compiler.jit import jit
from softbody.errors import MeshError
from softbody.geometry.triangle_list import checked_triangles
from softbody.linalg.quaternion import Quaternion, load_quaternion, rotate
from softbody.linalg.vec import Vec, cross, dot, load, norm, scale, store, sub

# Directions whose angle has a smaller sine count as one: to leave one out then moves the end of a projection by less
# than the rounding of its corners. (Triangles of one flat face, the edges of a box.)
SAME_DIRECTION = 4e-15

# A corner may stand out this part of the size over a face of a mesh that still counts as convex: rounding, and no more.
FLATNESS = 1e-12


class Convex(NamedTuple):
    """A convex mesh about its own origin, and the directions that the separating-axis test needs.

    Faces, and edges, count as parallel if the sine of their angle is below 4e-15.
    """

    vertices: np.ndarray  # (n, 3) [m]
    normals: np.ndarray  # (f, 3) unit, one for each pair of parallel faces
    edges: np.ndarray  # (e, 3) unit, one for each set of parallel edges


def convex(vertices: ArrayLike, triangles: ArrayLike) -> Convex:
    """Return the convex mesh of `vertices` (n, 3) [m], `triangles` (t, 3), ready to be tested.

    Triangles without area are passed over. Raises MeshError, naming the vertex, if the mesh is not convex.
    """
    points, faces = checked_triangles(vertices, triangles)
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    solid = lengths > 0.0
    if not solid.any():
        raise MeshError("no triangle has an area; give a convex solid")
    normals = normals[solid] / lengths[solid, None]
    size = float(np.ptp(points, axis=0).max())
    used = np.unique(faces)
    for face, normal, corner in zip(faces[solid], normals, corners[solid, 0]):
        heights = (points[used] - corner) @ normal
        if heights.max() > FLATNESS * size:
            raise MeshError(
                f"vertex {used[heights.argmax()]} stands {heights.max():.3g} m out over triangle {face}: the mesh "
                "is not convex, or inside out; take its convex hull"
            )
    edges = _sharp_edges(faces[solid], normals)
    spans = points[edges[:, 1]] - points[edges[:, 0]]
    lengths = np.linalg.norm(spans, axis=1)
    spans = spans[lengths > 0.0] / lengths[lengths > 0.0, None]
    return Convex(points[used], _distinct(normals), _distinct(spans))


def _sharp_edges(faces: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return every edge (e, 2) once, but for those between two triangles of one flat face."""
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges, edge_of, meetings = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    by_edge = np.argsort(edge_of.ravel(), kind="stable")
    first = np.cumsum(meetings) - meetings
    paired = np.flatnonzero(meetings == 2)
    one, other = (normals[by_edge[first[paired] + k] % len(faces)] for k in (0, 1))
    flat = np.linalg.norm(np.cross(one, other), axis=1) < SAME_DIRECTION
    return np.delete(edges, paired[flat], axis=0)


def _distinct(directions: np.ndarray) -> np.ndarray:
    """Return `directions` (k, 3), unit, without those that are parallel to one before."""
    kept = np.empty_like(directions)
    count = 0
    for direction in directions:
        sines = np.linalg.norm(np.cross(kept[:count], direction), axis=1)
        if not (sines < SAME_DIRECTION).any():
            kept[count] = direction
            count += 1
    return np.ascontiguousarray(kept[:count])


@jit
def placed(shape: Convex, position: Vec, orientation: Quaternion) -> Convex:
    """Return a convex mesh moved to `position` [m] and turned to `orientation`, a unit quaternion."""
    vertices, normals, edges = np.empty_like(shape.vertices), np.empty_like(shape.normals), np.empty_like(shape.edges)
    for i in range(vertices.shape[0]):
        x, y, z = rotate(orientation, load(shape.vertices, i))
        store(vertices, i, (x + position[0], y + position[1], z + position[2]))
    for i in range(normals.shape[0]):
        store(normals, i, rotate(orientation, load(shape.normals, i)))
    for i in range(edges.shape[0]):
        store(edges, i, rotate(orientation, load(shape.edges, i)))
    return Convex(vertices, normals, edges)


@jit
def _projection(vertices: np.ndarray, origin: Vec, axis: Vec) -> tuple[float, float]:
    """Return the ends [m] of the projection of `vertices` on `axis`, from `origin`."""
    low = np.inf
    high = -np.inf
    for i in range(vertices.shape[0]):
        x = dot(sub(load(vertices, i), origin), axis)
        low = min(low, x)
        high = max(high, x)
    return low, high


@jit
def convex_separation(a: Convex, b: Convex, paper_axes: bool = False) -> tuple[float, Vec, int]:
    """Return (separation [m], normal, axis) of two convex meshes along the axis that parts them most; paper §4.5.

    A positive separation is a gap, and then the meshes are apart. Otherwise they overlap, or touch at 0, and
    −separation is the depth along `normal`, the unit vector from b to a. `axis` counts the normals of a, those of b,
    then edge i of a across edge j of b. `paper_axes` tries the face normals only: meshes can then seem to overlap
    that are apart.

    The time grows as (edges of a) × (edges of b) × (vertices of both): meant for shapes with up to some 100 edges.
    """
    origin = load(b.vertices, 0)  # near both: far from the world's origin nothing is lost
    faces_a, faces_b = a.normals.shape[0], b.normals.shape[0]
    edges_b = b.edges.shape[0]
    count = faces_a + faces_b + (0 if paper_axes else a.edges.shape[0] * edges_b)
    best = -np.inf
    best_axis = -1
    normal = (0.0, 0.0, 0.0)
    for k in range(count):
        if k < faces_a:
            direction = load(a.normals, k)
        elif k < faces_a + faces_b:
            direction = load(b.normals, k - faces_a)
        else:
            pair = k - faces_a - faces_b
            direction = cross(load(a.edges, pair // edges_b), load(b.edges, pair % edges_b))
            length = norm(direction)
            if length < PARALLEL_SINE:
                continue
            direction = scale(1.0 / length, direction)
        low_a, high_a = _projection(a.vertices, origin, direction)
        low_b, high_b = _projection(b.vertices, origin, direction)
        if low_a - high_b > best:
            best = low_a - high_b
            normal = direction
            best_axis = k
        if low_b - high_a > best:
            best = low_b - high_a
            normal = scale(-1.0, direction)
            best_axis = k
    return best, normal, best_axis


@jit
def convex_pairs_separation(
    a: Convex,
    position_a: np.ndarray,
    orientation_a: np.ndarray,
    b: Convex,
    position_b: np.ndarray,
    orientation_b: np.ndarray,
    paper_axes: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Return separations (m,) [m] and normals (m, 3) of two convex meshes in m pairs of poses; see `convex_separation`.

    Positions (m, 3) [m], orientations (m, 4) unit quaternions; row i of a against row i of b.
    """
    separations = np.empty(position_a.shape[0])
    normals = np.empty((position_a.shape[0], 3))
    for i in range(position_a.shape[0]):
        placed_a = placed(a, load(position_a, i), load_quaternion(orientation_a, i))
        placed_b = placed(b, load(position_b, i), load_quaternion(orientation_b, i))
        separation, normal, _ = convex_separation(placed_a, placed_b, paper_axes)
        separations[i] = separation
        store(normals, i, normal)
    return separations, normals
