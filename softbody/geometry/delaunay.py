"""Constrained Delaunay triangulations of points in a plane, some of them joined by edges that must be there.

Points are inserted one by one into a triangle around all, and edges that are not locally Delaunay are flipped (Lawson
1977). Then the given edges are forced by flips (Sloan 1993), and Lawson's flips spare them. All corners turn
counter-clockwise by exact signs (`predicates`), and an edge is flipped for a circle's sake only where rounding cannot
have decided it: so flips end, and of four corners on a circle either diagonal may stay.

Half-edge 3 t + i runs from corner i of triangle t to corner i + 1; its twin runs back, in the triangle beyond.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.predicates import HALF_ULP, orient2d
from softbody.linalg.vec import Vec, load

NONE = -1  # no half-edge, or no point

# What rounding can make of the determinant of `_is_surely_in_circle`, as a part of the sum of its terms' sizes
# (Shewchuk 1997, §4.4).
CIRCLE_ROUNDING = (10.0 + 96.0 * HALF_ULP) * HALF_ULP

AROUND = 16.0  # how far the corners of the triangle around all points are, over their extent: 2 would do


class Triangulation(NamedTuple):
    """Triangles (2 n − 5) of n points, the last three of them the corners of a triangle around all others."""

    points: np.ndarray  # (n, 3) [m]; z plays no part
    start: np.ndarray  # (h,) the point at which each half-edge starts
    twin: np.ndarray  # (h,) the half-edge that runs back, or NONE
    border: np.ndarray  # (h,) 1 for the half-edges of the given edges, -1 for their twins, 0 for all others
    leaving: np.ndarray  # (n,) a half-edge that starts at each point


def triangulate(points: np.ndarray, edges: np.ndarray) -> tuple[Triangulation, tuple[int, int, int]]:
    """Return a constrained Delaunay triangulation of different points (n, 2) [m], and (NONE, NONE, NONE).

    Edges (m, 2) are marked in its `border`. If one cannot be made, it ends there, and returns its number and the ends
    of the edge that it crosses or runs along, or twice the point that it goes through.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    around = AROUND * (high - low).max() * np.array([(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)])
    all_points = np.zeros((len(points) + 3, 3))
    all_points[:, :2] = np.concatenate([points, 0.5 * (low + high) + around])
    halves = 3 * (2 * len(all_points) - 5)
    starts, twins, leaving = np.full(halves, NONE), np.full(halves, NONE), np.full(len(all_points), NONE)
    mesh = Triangulation(all_points, starts, twins, np.zeros(halves, np.int8), leaving)
    return mesh, _triangulate(mesh, edges)


@jit
def _triangulate(mesh: Triangulation, edges: np.ndarray) -> tuple[int, int, int]:
    """Do what `triangulate` says, in arrays that are still empty."""
    count = mesh.points.shape[0] - 3
    _put_triangle(mesh, 0, count, count + 1, count + 2)
    waiting = np.empty(mesh.points.shape[0], np.int64)
    h = 0
    for v in range(count):
        _split_triangle(mesh, _triangle_around(mesh, load(mesh.points, v), h), v)
        _flip_around(mesh, v, waiting)
        h = mesh.leaving[v]
    for e in range(edges.shape[0]):
        a, b = _force_edge(mesh, edges[e, 0], edges[e, 1])
        if a != NONE:
            return e, a, b
    _flip_until_delaunay(mesh)
    return NONE, NONE, NONE


@jit_lean
def _put_triangle(mesh: Triangulation, t: int, a: int, b: int, c: int) -> None:
    """Write the corners of a triangle."""
    for h, corner in ((3 * t, a), (3 * t + 1, b), (3 * t + 2, c)):
        mesh.start[h] = corner
        mesh.leaving[corner] = h


@jit_lean
def _next(h: int) -> int:
    """Return the half-edge after one in its triangle."""
    return h - 2 if h % 3 == 2 else h + 1


@jit_lean
def _previous(h: int) -> int:
    """Return the half-edge before one in its triangle."""
    return h + 2 if h % 3 == 0 else h - 1


@jit_lean
def _make_twins(mesh: Triangulation, h: int, g: int) -> None:
    """Say that two half-edges are twins; `g` may be NONE."""
    mesh.twin[h] = g
    if g != NONE:
        mesh.twin[g] = h


@jit_lean
def _triangle_around(mesh: Triangulation, p: Vec, h: int) -> int:
    """Return a triangle that a point is in, or on the edge of, walking there from half-edge `h`.

    Over any edge that the point is beyond; which edge is asked first is left to chance, that no walk goes in a circle
    (Devillers, Pion and Teillaud 2002).
    """
    chance, asked = 1, 0
    while asked < 3:
        if orient2d(load(mesh.points, mesh.start[h]), load(mesh.points, mesh.start[_next(h)]), p) < 0.0:
            h, asked = mesh.twin[h], 0
            chance = (1664525 * chance + 1013904223) % 2**32  # Knuth's and Lewis' generator
            h = h // 3 * 3 + (chance >> 16) % 3
        else:
            h, asked = _next(h), asked + 1
    return h // 3


@jit_lean
def _split_triangle(mesh: Triangulation, t: int, v: int) -> None:
    """Join point `v` with the corners of the triangle around it; one of the three may be flat, see `_must_flip`."""
    u, w = 2 * v + 1, 2 * v + 2  # two new triangles come with each point
    a, b, c = mesh.start[3 * t], mesh.start[3 * t + 1], mesh.start[3 * t + 2]
    beyond_ab, beyond_bc, beyond_ca = mesh.twin[3 * t], mesh.twin[3 * t + 1], mesh.twin[3 * t + 2]
    _put_triangle(mesh, t, a, b, v)
    _put_triangle(mesh, u, b, c, v)
    _put_triangle(mesh, w, c, a, v)
    _make_twins(mesh, 3 * t, beyond_ab)
    _make_twins(mesh, 3 * u, beyond_bc)
    _make_twins(mesh, 3 * w, beyond_ca)
    _make_twins(mesh, 3 * t + 1, 3 * u + 2)
    _make_twins(mesh, 3 * u + 1, 3 * w + 2)
    _make_twins(mesh, 3 * w + 1, 3 * t + 2)


@jit_lean
def _flip_around(mesh: Triangulation, v: int, waiting: np.ndarray) -> None:
    """Flip edges opposite to the new point `v` until all are locally Delaunay; `waiting` (n + 3,) is memory.

    Each flip adds an edge at `v`, so that no more than it has edges ever wait.
    """
    count = 0
    h = mesh.leaving[v]
    for _ in range(3):
        waiting[count] = _next(h)
        count += 1
        h = mesh.twin[_previous(h)]
    while count > 0:
        count -= 1
        h = waiting[count]
        if _must_flip(mesh, h):
            g = mesh.twin[h]
            _flip(mesh, h)
            waiting[count], waiting[count + 1] = h, _next(g)
            count += 2


@jit_lean
def _must_flip(mesh: Triangulation, h: int) -> bool:
    """Tell whether an edge is not locally Delaunay, and may be flipped.

    Neither may a triangle stay flat that a point on its edge has made.
    """
    g = mesh.twin[h]
    if g == NONE or mesh.border[h] != 0:
        return False
    a, b = load(mesh.points, mesh.start[h]), load(mesh.points, mesh.start[g])
    c, d = load(mesh.points, mesh.start[_previous(h)]), load(mesh.points, mesh.start[_previous(g)])
    return orient2d(a, b, c) == 0.0 or _is_surely_in_circle(a, b, c, d)


@jit_lean
def _is_surely_in_circle(a: Vec, b: Vec, c: Vec, p: Vec) -> bool:
    """Tell whether a point is in the circle through three others, counter-clockwise, by more than rounding can do."""
    ax, ay = a[0] - p[0], a[1] - p[1]
    bx, by = b[0] - p[0], b[1] - p[1]
    cx, cy = c[0] - p[0], c[1] - p[1]
    aa, bb, cc = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    bc, cb, ca, ac, ab, ba = bx * cy, cx * by, cx * ay, ax * cy, ax * by, bx * ay
    inside = aa * (bc - cb) + bb * (ca - ac) + cc * (ab - ba)
    size = aa * (abs(bc) + abs(cb)) + bb * (abs(ca) + abs(ac)) + cc * (abs(ab) + abs(ba))
    return inside > CIRCLE_ROUNDING * size


@jit_lean
def _flip(mesh: Triangulation, h: int) -> None:
    """Replace the edge of half-edge `h` by the other diagonal of the two triangles beside it."""
    g = mesh.twin[h]
    h_next, h_last, g_next, g_last = _next(h), _previous(h), _next(g), _previous(g)
    a, b, c, d = mesh.start[h], mesh.start[g], mesh.start[h_last], mesh.start[g_last]
    beyond_ca, beyond_db = mesh.twin[h_last], mesh.twin[g_last]
    border_ca, border_db = mesh.border[h_last], mesh.border[g_last]
    mesh.start[h], mesh.start[g] = d, c
    mesh.leaving[a], mesh.leaving[b], mesh.leaving[c], mesh.leaving[d] = g_next, h_next, g, h
    mesh.border[h], mesh.border[g] = border_db, border_ca
    mesh.border[h_last], mesh.border[g_last] = 0, 0
    _make_twins(mesh, h, beyond_db)
    _make_twins(mesh, g, beyond_ca)
    _make_twins(mesh, h_last, g_last)


@jit_lean
def _force_edge(mesh: Triangulation, a: int, b: int) -> tuple[int, int]:
    """Make an edge between two points, and mark it; return NONE twice, or what is in its way as `triangulate` does."""
    h = _half_edge_towards(mesh, a, b)
    while mesh.start[_next(h)] != b:
        crossed, touched = _to_be_flipped(mesh, a, b, h)
        if touched != NONE:
            return touched, touched
        if mesh.border[crossed] != 0:
            return mesh.start[crossed], mesh.start[_next(crossed)]
        _flip(mesh, crossed)
        h = _half_edge_towards(mesh, a, b)
    if mesh.border[h] != 0:
        return a, b
    mesh.border[h], mesh.border[mesh.twin[h]] = 1, -1
    return NONE, NONE


@jit_lean
def _half_edge_towards(mesh: Triangulation, a: int, b: int) -> int:
    """Return the half-edge from point `a` along which one sees point `b`, or whose triangle is on the way there."""
    p, q = load(mesh.points, a), load(mesh.points, b)
    h = mesh.leaving[a]
    while (
        orient2d(p, q, load(mesh.points, mesh.start[_next(h)])) > 0.0
        or orient2d(p, q, load(mesh.points, mesh.start[_previous(h)])) <= 0.0
    ):
        h = mesh.twin[_previous(h)]
    return h


@jit_lean
def _to_be_flipped(mesh: Triangulation, a: int, b: int, h: int) -> tuple[int, int]:
    """Return which edge to flip on the way from point `a` to `b`, which begins at half-edge `h`, and NONE.

    Of the edges across the way that may be flipped, one whose left end is farthest to the left as seen from `a`; of
    several ends in line with `a` the last. The left end that is so among all has such an edge, as nothing on its side
    is beyond it. Each flip of its edges takes one from it, and gives one at most, to an end less far: so flips end.

    If an edge across the way is of the border, it is returned; if a point is on the way, NONE and that point.
    """
    p, q = load(mesh.points, a), load(mesh.points, b)
    if orient2d(p, q, load(mesh.points, mesh.start[_next(h)])) == 0.0:
        return NONE, mesh.start[_next(h)]
    chosen, farthest = NONE, q
    h = _next(h)  # from here on from the right of the way to its left
    while mesh.border[h] == 0:
        g = mesh.twin[h]
        right, left = load(mesh.points, mesh.start[h]), load(mesh.points, mesh.start[g])
        before, ahead = load(mesh.points, mesh.start[_previous(h)]), load(mesh.points, mesh.start[_previous(g)])
        is_convex = orient2d(before, right, ahead) > 0.0 and orient2d(ahead, left, before) > 0.0
        if is_convex and orient2d(p, farthest, left) >= 0.0:
            chosen, farthest = h, left
        if mesh.start[_previous(g)] == b:
            return chosen, NONE
        side = orient2d(p, q, ahead)
        if side == 0.0:
            return NONE, mesh.start[_previous(g)]
        h = _next(g) if side > 0.0 else _previous(g)
    return h, NONE


@jit_lean
def _flip_until_delaunay(mesh: Triangulation) -> None:
    """Flip edges, except those of the border, until all are locally Delaunay."""
    has_flipped = True
    while has_flipped:
        has_flipped = False
        for h in range(mesh.start.shape[0]):
            if _must_flip(mesh, h):
                _flip(mesh, h)
                has_flipped = True
