"""Shortest way out for a point inside a soft body, and the triangle that pushes it back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.soft.surface import Surface
from softbody.compiler.jit import jit_lean
from softbody.geometry.closest_point import with_weights
from softbody.geometry.triangle import area_vector, squared_distance_to_triangle, weighted_point
from softbody.linalg.vec import Vec, add, dot, load, norm, scale, sub
from softbody.model.surface_point import SurfacePoint, at_particle

# A way shorter than this part of a triangle's size is rounding, and has no direction.
NO_WAY = 1e-9

BEYOND = -1  # no triangle


class WayOut(NamedTuple):
    """The shortest way from inside a body to its surface, or from outside; a depth ≤ 0: there is none."""

    depth: float  # [m]
    normal: Vec  # unit, out of the body, or into it
    end: SurfacePoint


@jit_lean
def way_out(p: Vec, surface: Surface, triangle: int, weights: Vec, side: float = 1.0) -> WayOut:
    """Return the way from `p` to its closest point, of a triangle and barycentric weights; none if `p` is before it.

    Of a `side` of −1 it is the way back in, and there is none if `p` is behind it.
    It is along the triangle's normal, but where the closest point is on a reentrant edge or corner. All triangles that
    share the point are equally close, to rounding. Which of them was found must not show: the one that faces the way
    takes the reaction.
    """
    triangles, first = surface.triangles, surface.first
    out = sub(_point_of(surface, triangle, weights), p)
    best = _facing(scale(side, out), surface, triangle, weights)
    i, j, k = triangles[best, 0], triangles[best, 1], triangles[best, 2]
    where = (
        _weight_of(i, triangles, triangle, weights),
        _weight_of(j, triangles, triangle, weights),
        _weight_of(k, triangles, triangle, weights),
    )
    end = SurfacePoint((first + i, first + j, first + k), where)
    depth, face = norm(out), scale(side, _normal(surface, best))
    if depth == 0.0 or dot(out, face) <= 0.0:
        return WayOut(0.0, (0.0, 0.0, 0.0), end)
    if depth * depth <= NO_WAY * NO_WAY * norm(face):
        return WayOut(depth, scale(1.0 / norm(face), face), end)
    return WayOut(depth, scale(1.0 / depth, out), end)


@jit_lean
def way_out_before(p: Vec, own: Vec, surface: Surface, farthest: float) -> WayOut:
    """Return the shortest way from `p`, of a skin whose normal is along `own`, through a triangle that faces that skin.

    None if it is longer than `farthest` [m].
    """
    positions, triangles = surface.vertices.position, surface.triangles
    best, closest = farthest * farthest, -1
    for t in range(triangles.shape[0]):
        if dot(_normal(surface, t), own) < 0.0:
            a, b, c = (
                load(positions, triangles[t, 0]),
                load(positions, triangles[t, 1]),
                load(positions, triangles[t, 2]),
            )
            square = squared_distance_to_triangle(p, a, b, c)
            if square < best:
                best, closest = square, t
    if closest < 0:
        return WayOut(0.0, (0.0, 0.0, 0.0), at_particle(surface.first))
    _, weights, _ = with_weights(p, positions, triangles, closest)
    return way_out(p, surface, closest, weights)


@jit_lean
def vertex_normal(surface: Surface, vertex: int) -> Vec:
    """Return the sum of the area vectors [m²] of the triangles about a vertex, which may be on a border."""
    first = int(surface.touching[vertex])
    total, other = _normal(surface, first), _next_about(surface, first, vertex)
    while other != first and other != BEYOND:
        total, other = add(total, _normal(surface, other)), _next_about(surface, other, vertex)
    return total


@jit_lean
def _next_about(surface: Surface, triangle: int, vertex: int) -> int:
    """Return the triangle beyond the side that begins at a vertex of another."""
    corners = surface.triangles
    m = 0 if corners[triangle, 0] == vertex else 1 if corners[triangle, 1] == vertex else 2
    return _across(surface, triangle, m)


@jit_lean
def _facing(out: Vec, surface: Surface, triangle: int, weights: Vec) -> int:
    """Return which triangle faces `out` most, of those that share a point of `triangle`."""
    corners = (1 if weights[0] != 0.0 else 0) + (1 if weights[1] != 0.0 else 0) + (1 if weights[2] != 0.0 else 0)
    best = triangle
    if corners == 2:
        m = 0 if weights[0] == 0.0 else 1 if weights[1] == 0.0 else 2
        best = _facing_more(out, surface, best, _across(surface, triangle, (m + 1) % 3))
    elif corners == 1:
        m = 0 if weights[0] != 0.0 else 1 if weights[1] != 0.0 else 2
        vertex, other = int(surface.triangles[triangle, m]), _across(surface, triangle, m)
        while other != triangle:
            best = _facing_more(out, surface, best, other)
            other = _next_about(surface, other, vertex)
    return best


@jit_lean
def _facing_more(out: Vec, surface: Surface, one: int, other: int) -> int:
    a, b = _normal(surface, one), _normal(surface, other)
    return other if dot(out, b) * norm(a) > dot(out, a) * norm(b) else one


@jit_lean
def _across(surface: Surface, triangle: int, side: int) -> int:
    """Return the triangle beyond a side of another, or BEYOND the border."""
    edge = surface.sides[triangle, side]
    edge = edge if edge >= 0 else -1 - edge
    left, right = surface.wings[edge, 0], surface.wings[edge, 1]
    return left if right == triangle else right


@jit_lean
def _normal(surface: Surface, triangle: int) -> Vec:
    """Return a vector along the normal of a triangle, its area long [m²]."""
    corners, vertices = surface.triangles, surface.vertices.position
    a, b = load(vertices, corners[triangle, 0]), load(vertices, corners[triangle, 1])
    return area_vector(a, b, load(vertices, corners[triangle, 2]))


@jit_lean
def _point_of(surface: Surface, triangle: int, weights: Vec) -> Vec:
    corners, vertices = surface.triangles, surface.vertices.position
    a, b = load(vertices, corners[triangle, 0]), load(vertices, corners[triangle, 1])
    return weighted_point(weights, a, b, load(vertices, corners[triangle, 2]))


@jit_lean
def _weight_of(vertex: int, triangles: np.ndarray, triangle: int, weights: Vec) -> float:
    """Return the weight of a vertex in a point of a triangle: 0 if it is none of its corners."""
    if triangles[triangle, 0] == vertex:
        return weights[0]
    if triangles[triangle, 1] == vertex:
        return weights[1]
    return weights[2] if triangles[triangle, 2] == vertex else 0.0
