"""Features of one surface that are near each other and have no vertex in common: particle and triangle, edge and edge.

What comes through a surface comes through such a pair first. A pair is one number, of its kind and both features.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.collision.soft.surface import Solid, Surface
from softbody.compiler.jit import jit, jit_inlined, jit_lean
from softbody.compiler.simd import lowest_bit
from softbody.geometry.bvh import WIDTH, Search
from softbody.geometry.bvh_boxes import ask_leaf, list_near
from softbody.geometry.segment_pair import closest_places_on_segments
from softbody.geometry.triangle import closest_weights_on_triangle
from softbody.linalg.vec import Vec, load, scale, sub

TRIANGLE, EDGE = 0, 1  # kinds: a particle and a triangle, or two edges, the lower number first

BITS = 30  # of the number of a feature

NEW = -np.inf  # of a vertex that was not listed

Members = tuple[int, int, int, int]


@jit_lean
def pair_of(kind: int, a: int, b: int) -> np.int64:
    """Return the pair of a kind and two features."""
    return np.int64(kind) << 2 * BITS | np.int64(a) << BITS | np.int64(b)


@jit_lean
def kind_of(pair: int) -> int:
    """Return the kind of a pair."""
    return pair >> 2 * BITS


@jit_lean
def features_of(pair: int) -> tuple[int, int]:
    """Return the numbers of the features of a pair."""
    return pair >> BITS & (1 << BITS) - 1, pair & (1 << BITS) - 1


@jit_lean
def members(surface: Surface, pair: int) -> Members:
    """Return the four particles of a pair: that which is near a triangle, and its three; or those of two edges."""
    a, b = features_of(pair)
    if kind_of(pair) == TRIANGLE:
        return a, surface.triangles[b, 0], surface.triangles[b, 1], surface.triangles[b, 2]
    ridges = surface.ridges
    return 0 + ridges[a, 0], 0 + ridges[a, 1], 0 + ridges[b, 0], 0 + ridges[b, 1]  # of 64 bits, as particles are


@jit_lean
def nearest_weights(kind: int, p: Vec, q: Vec, r: Vec, s: Vec) -> tuple[Vec, Vec]:
    """Return (w, u): w·(q, r, s) is nearest to p; or, of two edges, places u on p–q and w on r–s, as first numbers.

    With the distance [m] as the last number of u.
    """
    if kind == TRIANGLE:
        weights, square = closest_weights_on_triangle(p, q, r, s)
        return weights, (0.0, 0.0, sqrt(square))
    one, other, square = closest_places_on_segments(p, q, r, s)
    return (other, 0.0, 0.0), (one, 0.0, sqrt(square))


@jit_lean
def gap_of(kind: int, p: Vec, q: Vec, r: Vec, s: Vec) -> float:
    """Return the distance [m] of the features of a pair whose members are at these places."""
    return nearest_weights(kind, p, q, r, s)[1][2]


@jit_lean
def gap_at(surface: Surface, pair: int, vertices: np.ndarray) -> float:
    """Return the distance [m] of the features of a pair of a surface whose vertices are at (n, 3)."""
    i, j, k, m = members(surface, pair)
    return gap_of(kind_of(pair), load(vertices, i), load(vertices, j), load(vertices, k), load(vertices, m))


@jit
def list_all(solid: Solid, search: Search, vertices: np.ndarray, margin: float, pairs: np.ndarray) -> int:
    """Write all pairs nearer than a `margin` [m] into `pairs` (p,); return how many there are, also beyond p.

    The tree must have been fitted to the vertices (n, 3).
    """
    return list_near_features(solid, search, vertices, margin, np.full(vertices.shape[0], NEW), pairs, 0)


@jit_lean
def has_new(listed: np.ndarray, four: Members) -> bool:
    """Tell whether any of four vertices is NEW."""
    return min(listed[four[0]], listed[four[1]], listed[four[2]], listed[four[3]]) == NEW


@jit_lean
def _is_new(surface: Surface, listed: np.ndarray, t: int) -> bool:
    """Tell whether any corner of a triangle is NEW."""
    corners = surface.triangles[t]
    return min(listed[corners[0]], listed[corners[1]], listed[corners[2]]) == NEW


@jit_lean
def list_near_features(
    solid: Solid,
    search: Search,
    vertices: np.ndarray,
    margin: float,
    listed: np.ndarray,
    pairs: np.ndarray,
    count: int,
) -> int:
    """Write pairs nearer than a `margin` [m] into `pairs` (p,), from `count` on; return how many there are then.

    Those that have a vertex which is NEW in `listed` (n,). How many, also beyond p. The tree must have been fitted to
    the vertices (n, 3).
    """
    surface, tree = solid.surface, solid.tree
    for leaf in range(tree.corners.shape[0]):
        if not ask_leaf(search, leaf, tree, vertices, margin, listed, NEW):
            continue
        for k in range(list_near(tree, search)):
            u, meets = search.listed[k], search.meets[k]
            while meets != 0:
                lane = lowest_bit(meets)
                meets &= meets - 1
                t = tree.order[WIDTH * leaf + lane]
                if t != u and (t < u or not _is_new(surface, listed, u)):
                    count = _add_pairs(surface, vertices, t, u, margin, listed, pairs, count)
    return count


@jit_lean
def _add_pairs(
    surface: Surface,
    vertices: np.ndarray,
    t: int,
    u: int,
    margin: float,
    listed: np.ndarray,
    pairs: np.ndarray,
    count: int,
) -> int:
    """Add the pairs that two triangles have; a vertex is that of one triangle, and so is an edge."""
    triangles, sides, ridges = surface.triangles, surface.sides, surface.ridges
    for turn in range(2):
        one, other = (t, u) if turn == 0 else (u, t)
        i, j, k = triangles[other, 0], triangles[other, 1], triangles[other, 2]
        for c in range(3):
            v = triangles[one, c]
            if surface.touching[v] != one or v in (i, j, k):
                continue
            if not has_new(listed, (v, i, j, k)) or _are_far(vertices, v, v, v, i, j, k, margin):
                continue
            if gap_of(TRIANGLE, load(vertices, v), load(vertices, i), load(vertices, j), load(vertices, k)) < margin:
                count = _add(pairs, count, TRIANGLE, v, other)
    for c in range(3):
        e = sides[t, c]
        if e < 0:
            continue
        i, j = ridges[e, 0], ridges[e, 1]
        for d in range(3):
            f = sides[u, d]
            if f < 0:
                continue
            k, m = ridges[f, 0], ridges[f, 1]
            if i in (k, m) or j in (k, m) or not has_new(listed, (0 + i, 0 + j, 0 + k, 0 + m)):
                continue
            if _are_far(vertices, i, j, j, k, m, m, margin):
                continue
            if gap_of(EDGE, load(vertices, i), load(vertices, j), load(vertices, k), load(vertices, m)) < margin:
                count = _add(pairs, count, EDGE, min(e, f), max(e, f))
    return count


@jit_lean
def least_gap_of_all(solid: Solid, search: Search, vertices: np.ndarray, most: float) -> float:
    """Return the least distance [m] of features that have no vertex in common, or `most` [m], if it is wider.

    The tree must have been fitted to the vertices (n, 3).
    """
    tree, least = solid.tree, most
    for leaf in range(tree.corners.shape[0]):
        ask_leaf(search, leaf, tree, vertices, least)
        for k in range(list_near(tree, search)):
            u, meets = search.listed[k], search.meets[k]
            while meets != 0:
                lane = lowest_bit(meets)
                meets &= meets - 1
                t = tree.order[WIDTH * leaf + lane]
                if t < u:
                    least = _least_gap_of_two(solid.surface, vertices, t, u, least)
    return least


@jit_lean
def _least_gap_of_two(surface: Surface, vertices: np.ndarray, t: int, u: int, least: float) -> float:
    """Return the least distance [m] of the features of two triangles, or `least`, if they are farther apart."""
    triangles, sides, ridges = surface.triangles, surface.sides, surface.ridges
    for turn in range(2):
        one, other = (t, u) if turn == 0 else (u, t)
        i, j, k = triangles[other, 0], triangles[other, 1], triangles[other, 2]
        for c in range(3):
            v = triangles[one, c]
            if surface.touching[v] == one and v not in (i, j, k) and not _are_far(vertices, v, v, v, i, j, k, least):
                p, q, r, s = load(vertices, v), load(vertices, i), load(vertices, j), load(vertices, k)
                least = min(least, gap_of(TRIANGLE, p, q, r, s))
    for c in range(3):
        e = sides[t, c]
        for d in range(3):
            f = sides[u, d]
            if e < 0 or f < 0:
                continue
            i, j, k, m = ridges[e, 0], ridges[e, 1], ridges[f, 0], ridges[f, 1]
            if i not in (k, m) and j not in (k, m) and not _are_far(vertices, i, j, j, k, m, m, least):
                p, q, r, s = load(vertices, i), load(vertices, j), load(vertices, k), load(vertices, m)
                least = min(least, gap_of(EDGE, p, q, r, s))
    return least


@jit_lean
def _add(pairs: np.ndarray, count: int, kind: int, a: int, b: int) -> int:
    if count < pairs.shape[0]:
        pairs[count] = pair_of(kind, a, b)
    return count + 1


@jit_inlined
def _are_far(vertices: np.ndarray, a: int, b: int, c: int, i: int, j: int, k: int, margin: float) -> bool:
    """Tell whether the bounding boxes of two triples of vertices are farther apart than a margin [m] along an axis."""
    far = False
    for x in range(3):
        low = min(vertices[a, x], vertices[b, x], vertices[c, x])
        high = max(vertices[a, x], vertices[b, x], vertices[c, x])
        other_low = min(vertices[i, x], vertices[j, x], vertices[k, x])
        other_high = max(vertices[i, x], vertices[j, x], vertices[k, x])
        far = far or low > other_high + margin or other_low > high + margin
    return far


@jit_lean
def sort_pairs(pairs: np.ndarray, base: np.ndarray, sorted_already: int) -> None:
    """Sort `pairs` (p,), of which the first are `sorted_already`, and a number of each: how they came does not show."""
    _sort(pairs[sorted_already:], base[sorted_already:])
    if 0 < sorted_already < pairs.shape[0] and pairs[sorted_already] < pairs[sorted_already - 1]:
        _merge(pairs, base, sorted_already)


@jit_lean
def _sort(pairs: np.ndarray, base: np.ndarray) -> None:
    """Sort pairs by heapsort (Williams 1964)."""
    count = pairs.shape[0]
    for root in range(count // 2 - 1, -1, -1):
        _sift(pairs, base, root, count)
    for end in range(count - 1, 0, -1):
        pairs[0], pairs[end] = pairs[end], pairs[0]
        base[0], base[end] = base[end], base[0]
        _sift(pairs, base, 0, end)


@jit_lean
def _sift(pairs: np.ndarray, base: np.ndarray, root: int, end: int) -> None:
    """Let a heap be in order below its root."""
    while 2 * root + 1 < end:
        child = 2 * root + 1
        if child + 1 < end and pairs[child] < pairs[child + 1]:
            child += 1
        if pairs[root] >= pairs[child]:
            return
        pairs[root], pairs[child] = pairs[child], pairs[root]
        base[root], base[child] = base[child], base[root]
        root = child


@jit
def _merge(pairs: np.ndarray, base: np.ndarray, middle: int) -> None:
    """Merge two sorted parts of pairs."""
    later, numbers = pairs[middle:].copy(), base[middle:].copy()
    i, j = middle - 1, later.shape[0] - 1
    for k in range(pairs.shape[0] - 1, -1, -1):
        if j < 0:
            return
        if i >= 0 and pairs[i] > later[j]:
            pairs[k], base[k] = pairs[i], base[i]
            i -= 1
        else:
            pairs[k], base[k] = later[j], numbers[j]
            j -= 1


@jit_lean
def most_of(pair: int, step: np.ndarray, four: Members) -> float:
    """Return how far [m] the features of a pair move against each other at most, each vertex by its `step` (n,)."""
    i, j, k, m = four
    if kind_of(pair) == TRIANGLE:
        return step[i] + max(step[j], step[k], step[m])
    return max(step[i], step[j]) + max(step[k], step[m])


@jit_lean
def least_gap(surface: Surface, vertices: np.ndarray, pairs: np.ndarray) -> float:
    """Return the least distance [m] above 0 of the features of `pairs` (p,); inf without any."""
    least = np.inf
    for k in range(pairs.shape[0]):
        gap = gap_at(surface, pairs[k], vertices)
        least = gap if 0.0 < gap < least else least
    return least


@jit_lean
def way_to(p: Vec, q: Vec, gap: float) -> Vec:
    """Return the unit vector to p from q, which are a `gap` [m] apart."""
    return scale(1.0 / gap, sub(p, q))
