"""Closed meshes: volume, area, centroid, inertia, and whether a point is inside."""

from __future__ import annotations

from math import isfinite, isnan

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.predicates import LINE_ROUNDING, orient2d, orient3d, orient3d_filtered
from softbody.geometry.triangle import area_vector, triangle_area
from softbody.linalg.vec import Vec, add, cross, dot, load, norm, scale, sub

UNCERTAIN = 2  # the answer of a floating-point filter that fails, besides yes and no


@jit
def signed_volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume [m³] enclosed by a closed mesh, positive if its triangles face outwards; paper §2.3.

    `vertices` (n, 3) [m], `triangles` (t, 3). Σ a · (b × c) / 6 (Zhang and Chen 2001), taken about a vertex
    of the mesh: about the origin, the sum loses all its digits for a mesh far away.
    """
    origin = load(vertices, triangles[0, 0])
    six_volumes = 0.0
    for t in range(triangles.shape[0]):
        a = sub(load(vertices, triangles[t, 0]), origin)
        b = sub(load(vertices, triangles[t, 1]), origin)
        c = sub(load(vertices, triangles[t, 2]), origin)
        six_volumes += dot(a, cross(b, c))
    return six_volumes / 6.0


@jit
def surface_area(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return the area [m²] of a mesh; `vertices` (n, 3) [m], `triangles` (t, 3)."""
    area = 0.0
    for t in range(triangles.shape[0]):
        a = load(vertices, triangles[t, 0])
        b = load(vertices, triangles[t, 1])
        c = load(vertices, triangles[t, 2])
        area += triangle_area(a, b, c)
    return area


@jit
def centroid(vertices: np.ndarray, triangles: np.ndarray) -> Vec:
    """Return the centroid [m] of the solid that a closed mesh encloses; `vertices` (n, 3) [m]."""
    origin = load(vertices, triangles[0, 0])
    six_volumes = 0.0
    moment = (0.0, 0.0, 0.0)
    for t in range(triangles.shape[0]):
        a = sub(load(vertices, triangles[t, 0]), origin)
        b = sub(load(vertices, triangles[t, 1]), origin)
        c = sub(load(vertices, triangles[t, 2]), origin)
        weight = dot(a, cross(b, c))
        six_volumes += weight
        moment = add(moment, scale(weight, add(add(a, b), c)))
    return add(origin, scale(0.25 / six_volumes, moment))


@jit
def inertia_tensor(vertices: np.ndarray, triangles: np.ndarray, mass: float) -> np.ndarray:
    """Return the inertia (3, 3) [kg m²] about the centroid of a homogeneous solid of `mass` [kg].

    `vertices` (n, 3) [m] of a closed mesh. The second moments of the tetrahedra that the triangles span with
    the centroid: ∫ x xᵀ dV = V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ), s = a + b + c (Tonon 2004).
    """
    centre = centroid(vertices, triangles)
    six_volumes = 0.0
    second = np.zeros((3, 3))
    for t in range(triangles.shape[0]):
        a = sub(load(vertices, triangles[t, 0]), centre)
        b = sub(load(vertices, triangles[t, 1]), centre)
        c = sub(load(vertices, triangles[t, 2]), centre)
        s = add(add(a, b), c)
        weight = dot(a, cross(b, c))
        six_volumes += weight
        for i in range(3):
            for j in range(3):
                second[i, j] += weight * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + s[i] * s[j])
    second *= mass / (20.0 * six_volumes)
    trace = second[0, 0] + second[1, 1] + second[2, 2]
    inertia = -second
    for i in range(3):
        inertia[i, i] += trace
    return inertia


@jit
def _crossing(p: Vec, a: Vec, b: Vec) -> int:
    """Return ±1 if, seen from above, the edge ab crosses the half-line from `p` to +x, going up (+y) or down; else 0.

    Half-open in y, and a point on the edge counts as right of it: so a vertex on the line belongs to one of its two
    edges, and an edge through `p` crosses for both its triangles or for none, whichever way round it is given.
    """
    if (a[1] <= p[1]) == (b[1] <= p[1]):
        return 0
    turn = orient2d(a, b, p)
    if b[1] > a[1]:
        return 1 if turn > 0.0 else 0
    return -1 if turn < 0.0 else 0


@jit
def _is_clear(left: float, right: float) -> bool:
    """Tell whether the sign of left − right is beyond what rounding can do to it; see `orient2d`."""
    return abs(left - right) >= LINE_ROUNDING * (abs(left) + abs(right))


@jit_lean
def ray_hits_triangle_filtered(p: Vec, a: Vec, b: Vec, c: Vec) -> int:
    """Return the answer of `ray_hits_triangle`, 1 or 0, or UNCERTAIN where the floating-point filter fails."""
    a_low, b_low, c_low = a[1] <= p[1], b[1] <= p[1], c[1] <= p[1]
    if a_low == b_low and b_low == c_low:
        return 0
    # All three edges at once, as `_crossing` does one by one, but without a branch that the processor could mispredict.
    ax, ay, _ = sub(a, p)
    bx, by, _ = sub(b, p)
    cx, cy, _ = sub(c, p)
    ab, ba = ax * by, ay * bx
    bc, cb = bx * cy, by * cx
    ca, ac = cx * ay, cy * ax
    if not (_is_clear(ab, ba) & _is_clear(bc, cb) & _is_clear(ca, ac)):
        return UNCERTAIN
    # Of two edges that pass the level of p, one goes up and one down.
    up = (a_low & (not b_low) & (ab > ba)) | (b_low & (not c_low) & (bc > cb)) | (c_low & (not a_low) & (ca > ac))
    down = (b_low & (not a_low) & (ab < ba)) | (c_low & (not b_low) & (bc < cb)) | (a_low & (not c_low) & (ca < ac))
    if up == down or p[2] >= max(a[2], b[2], c[2]):
        return 0
    if p[2] < min(a[2], b[2], c[2]):
        return 1
    side = orient3d_filtered(a, b, c, p)
    if isnan(side):
        return UNCERTAIN
    return 1 if (side > 0.0) == up and side != 0.0 else 0


@jit
def ray_hits_triangle(p: Vec, a: Vec, b: Vec, c: Vec) -> bool:
    """Tell whether the ray from `p` along +z goes through the triangle (a, b, c) [m]; paper §4.6.

    Exact: a ray through an edge or vertex shared by two triangles counts for one of them only, even if the two have
    copies of that vertex of their own, and a triangle without area, or on its edge seen from above, is never hit.
    """
    hit = ray_hits_triangle_filtered(p, a, b, c)
    if hit != UNCERTAIN:
        return hit == 1
    facing = _crossing(p, a, b) + _crossing(p, b, c) + _crossing(p, c, a)
    if facing == 0 or p[2] >= max(a[2], b[2], c[2]):
        return False
    side = orient3d(a, b, c, p)
    return side > 0.0 if facing > 0 else side < 0.0


@jit
def point_in_polyhedron(p: Vec, vertices: np.ndarray, triangles: np.ndarray) -> bool:
    """Tell whether `p` [m] is inside a closed mesh, convex or not, by parity of the hits of a ray; paper §4.6.

    `vertices` (n, 3) [m], `triangles` (t, 3). Exhaustive: every triangle is tried; `softbody.geometry.parity_grid`
    gives the same answers faster. Exact: no rounding, and each crossing of the surface counts once, also where the
    ray meets an edge or a vertex. On the surface itself the answer is one of the two, and always the same.

    What is answered, whatever the mesh: whether the ray from `p` along +z meets an odd number of triangles. So a point
    is inside where the surfaces around it are odd in number: inside one sheet of a mesh that passes through itself,
    outside where two overlap; which way a triangle faces is nothing to it; under a hole of an open mesh all is wrong.
    A point that is not finite is outside.
    """
    if not (isfinite(p[0]) and isfinite(p[1]) and isfinite(p[2])):
        return False
    inside = False
    for t in range(triangles.shape[0]):
        a = load(vertices, triangles[t, 0])
        b = load(vertices, triangles[t, 1])
        c = load(vertices, triangles[t, 2])
        if ray_hits_triangle(p, a, b, c):
            inside = not inside
    return inside


@jit
def points_in_polyhedron(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell for each of `points` (m, 3) [m] whether it is inside a closed mesh: (m,) of bool; paper §4.6."""
    inside = np.empty(points.shape[0], np.bool_)
    for q in range(points.shape[0]):
        inside[q] = point_in_polyhedron(load(points, q), vertices, triangles)
    return inside


@jit
def point_in_convex(p: Vec, vertices: np.ndarray, triangles: np.ndarray) -> tuple[bool, int, float]:
    """Tell whether `p` [m] is in a convex mesh or on it, which face is closest, and how deep; paper §4.7.

    Returns (inside, face, depth [m]): the face whose plane is least far in front of `p`, and the distance
    behind that plane (negative outside). Triangles without area have no plane and are passed over.
    """
    face = -1
    depth = np.inf
    for t in range(triangles.shape[0]):
        a = load(vertices, triangles[t, 0])
        n = area_vector(a, load(vertices, triangles[t, 1]), load(vertices, triangles[t, 2]))
        length = norm(n)
        if length > 0.0:
            behind = dot(sub(a, p), n) / length
            if behind < depth:
                depth = behind
                face = t
    return face >= 0 and depth >= 0.0, face, depth


@jit
def points_in_convex(
    points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (inside (m,) of bool, face (m,), depth (m,) [m]) for `points` (m, 3) [m]: see `point_in_convex`."""
    inside = np.empty(points.shape[0], np.bool_)
    faces = np.empty(points.shape[0], np.int64)
    depths = np.empty(points.shape[0])
    for q in range(points.shape[0]):
        inside[q], faces[q], depths[q] = point_in_convex(load(points, q), vertices, triangles)
    return inside, faces, depths
