"""Bounding volume hierarchy of a mesh that deforms, refitted every step: the triangle closest to a point.

The same answers as `closest_triangle`, bit for bit. The tree's shape is fixed once: triangles in an order in which
neighbours are near each other, eight to a leaf, eight leaves to a node, and so on. When the mesh moves only the boxes
do. A box is passed over only if it is farther than the best triangle by more than any rounding, and of triangles
equally close, to the last bit, the one with the lowest number is taken: so the order of the search does not show.
"""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from softbody.compiler.jit import jit, jit_inlined, jit_lean
from softbody.compiler.simd import (
    Lanes,
    bits_at_most,
    in_double,
    in_single,
    load_lanes,
    lowest_bit,
    store_lanes,
    where_less,
)
from softbody.geometry.aabb import bounding_box
from softbody.geometry.closest_point import Closest, with_weights, write_answer
from softbody.geometry.triangle import squared_distance_to_triangle, squared_distances_to_triangles
from softbody.geometry.triangle_list import checked_triangles
from softbody.linalg.vec import Vec, load, scale, sub
from softbody.linalg.vec_lanes import gather_vec, load_vec_lanes, store_vec_lanes

WIDTH = 8  # children of a node: what a processor with 256-bit registers compares at once in float32

# Boxes are float32, in units of the mesh's half size, about its middle. This is by how much they are grown: a float32
# is rounded by 2⁻²⁴, a corner and a point that is next to it once each, and the float64 of the triangles by far less.
GROWTH = np.float32(2.0**-22)

# Squared distances to boxes are lessened by this part, more than what seven float32 operations on them round.
LESSENED = np.float32(1.0 - 2.0**-20)

Vec32 = tuple[np.float32, np.float32, np.float32]

# Points are drawn in to this many half sizes from the mesh: its square is finite in float32, and a bound stays one.
FARTHEST = 1e18
MOST = 1e300  # more than any bound of a child that there is; those that there are not are infinitely far
ZERO = np.float32(0.0)


class BVH(NamedTuple):
    """The axis-aligned boxes of one mesh; made by `build_bvh` once, `refit_bvh` follows the mesh as it moves."""

    triangles: np.ndarray  # (t, 3) int64
    order: np.ndarray  # (8 leaves,) int32: which triangle is where; the last one again where there are no more
    places: np.ndarray  # (leaves, 3, 8) uint32: where a, b, c of these begin among the numbers of the vertices
    corners: np.ndarray  # (leaves, 9, 8) [m]: a, b, c of the eight triangles of each leaf
    level_start: np.ndarray  # (levels,) first node of each level; level 0 has a node for each leaf
    level_count: np.ndarray  # (levels,)
    boxes: np.ndarray  # (nodes, 6, 8) float32: low x, y, z and high x, y, z of the eight children of each node
    frame: np.ndarray  # (4,) middle of the mesh [m], and 1 / half size [1/m]


def build_bvh(vertices: ArrayLike, triangles: ArrayLike) -> BVH:
    """Return a tree for a mesh: `vertices` (n, 3) [m], `triangles` (t, 3), of any kind.

    The more the mesh later deforms, the more boxes overlap and the slower (never the less right) it gets; make a new
    one then. Raises MeshError if an index is out of range or a vertex not finite.
    """
    vertices, triangles = checked_triangles(vertices, triangles)
    a, b, c = triangles.T
    order = near_order((vertices[a] + vertices[b] + vertices[c]) / 3.0)
    counts = [-(-len(order) // WIDTH)]
    while counts[-1] > 1:
        counts.append(-(-counts[-1] // WIDTH))
    leaves = counts[0]
    padded = np.concatenate([order, np.full(leaves * WIDTH - len(order), order[-1])])
    tree = BVH(
        triangles=triangles,
        order=padded.astype(np.int32),
        places=places_of_corners(triangles[padded]),
        corners=np.zeros((leaves, 9, WIDTH)),
        level_start=np.cumsum([0, *counts[:-1]]).astype(np.int64),
        level_count=np.array(counts, np.int64),
        boxes=np.zeros((sum(counts), 6, WIDTH), np.float32),
        frame=np.zeros(4),
    )
    refit_bvh(tree, vertices)
    return tree


def places_of_corners(triangles: np.ndarray) -> np.ndarray:
    """Return `places` of `BVH` for all `triangles` (8 leaves, 3) in its order."""
    corners = triangles.reshape(-1, WIDTH, 3).transpose(0, 2, 1)
    return np.ascontiguousarray(3 * corners, np.uint32)


@jit
def near_order(points: np.ndarray) -> np.ndarray:
    """Return an order (n,) of `points` (n, 3) [m] in which each aligned run of 8, 64, … lies close together.

    Halved again and again across the longest side, at a multiple of eight times a power of two.
    """
    n = points.shape[0]
    order = np.arange(n)
    waiting = np.empty((64, 2), np.int64)  # each halving leaves the smaller part for last: at most log2(n) wait
    waiting[0, 0], waiting[0, 1] = 0, n
    count = 1
    while count > 0:
        count -= 1
        first, last = waiting[count, 0], waiting[count, 1]
        if last - first <= WIDTH:
            continue
        axis = _longest_side(points, order, first, last)
        half = WIDTH
        while 2 * half < last - first:
            half *= 2
        _part(points, order, first, last, first + half, axis)
        waiting[count, 0], waiting[count, 1] = first + half, last
        waiting[count + 1, 0], waiting[count + 1, 1] = first, first + half
        count += 2
    return order


@jit
def _longest_side(points: np.ndarray, order: np.ndarray, first: int, last: int) -> int:
    """Return the axis along which points order[first:last] spread most."""
    axis = 0
    longest = -1.0
    for k in range(3):
        low = high = points[order[first], k]
        for i in range(first, last):
            low, high = min(low, points[order[i], k]), max(high, points[order[i], k])
        if high - low > longest:
            longest = high - low
            axis = k
    return axis


@jit
def _part(points: np.ndarray, order: np.ndarray, first: int, last: int, middle: int, axis: int) -> None:
    """Reorder order[first:last] so that none before `middle` has a larger coordinate than one after it (Hoare 1961)."""
    last -= 1
    while first < last:
        pivot = points[order[(first + last) // 2], axis]
        i, j = first, last
        while i <= j:
            while points[order[i], axis] < pivot:
                i += 1
            while points[order[j], axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            last = j
        elif middle >= i:
            first = i
        else:
            return


@jit_lean
def refit_bvh(tree: BVH, vertices: np.ndarray) -> None:
    """Fit the boxes to where `vertices` (n, 3) [m] now are. If any is not finite, every answer is then −1."""
    low, high = bounding_box(vertices)
    middle = scale(0.5, (low[0] + high[0], low[1] + high[1], low[2] + high[2]))
    half = 0.5 * max(high[0] - low[0], high[1] - low[1], high[2] - low[2])
    per_metre = 1.0 / half if half > 0.0 else 1.0
    tree.frame[0], tree.frame[1], tree.frame[2] = middle
    tree.frame[3] = per_metre
    if not isfinite(per_metre * half):
        tree.frame[3] = np.nan
        return
    _fit_leaves(tree, vertices, middle, per_metre)
    for level in range(1, tree.level_count.shape[0]):
        _fit_level(tree, level)


@jit_lean
def _fit_leaves(tree: BVH, vertices: np.ndarray, middle: Vec, per_metre: float) -> None:
    """Copy the corners of the triangles of each leaf, and fit a box around each triangle."""
    numbers, places = vertices.reshape(vertices.size), tree.places
    for leaf in range(tree.corners.shape[0]):
        rows, sides = tree.corners[leaf], tree.boxes[leaf]
        a, b, c = (
            gather_vec(numbers, places[leaf, 0]),
            gather_vec(numbers, places[leaf, 1]),
            gather_vec(numbers, places[leaf, 2]),
        )
        store_vec_lanes(rows, 0, a)
        store_vec_lanes(rows[3:], 0, b)
        store_vec_lanes(rows[6:], 0, c)
        for axis in range(3):
            low, high = _least(_least(a[axis], b[axis]), c[axis]), _most(_most(a[axis], b[axis]), c[axis])
            store_lanes(sides[axis], 0, in_single((low - middle[axis]) * per_metre) - GROWTH)
            store_lanes(sides[3 + axis], 0, in_single((high - middle[axis]) * per_metre) + GROWTH)


@jit_lean
def _least(a: Lanes, b: Lanes) -> Lanes:
    return where_less(a, b, a, b)


@jit_lean
def _most(a: Lanes, b: Lanes) -> Lanes:
    return where_less(b, a, a, b)


@jit_lean
def _fit_level(tree: BVH, level: int) -> None:
    """Fit the boxes of one level around those of the level below. Where a child is missing, the box is empty."""
    boxes, width = tree.boxes, tree.boxes.shape[2]
    below, count_below = tree.level_start[level - 1], tree.level_count[level - 1]
    start, count = tree.level_start[level], tree.level_count[level]
    for node in range(count):
        for s in range(width):
            child = node * width + s
            if child < count_below:
                for axis in range(3):
                    low = boxes[below + child, axis, 0]
                    high = boxes[below + child, 3 + axis, 0]
                    for u in range(1, width):
                        other = boxes[below + child, axis, u]
                        low = other if other < low else low
                        other = boxes[below + child, 3 + axis, u]
                        high = other if other > high else high
                    boxes[start + node, axis, s] = low
                    boxes[start + node, 3 + axis, s] = high
            else:
                for axis in range(3):
                    boxes[start + node, axis, s] = np.float32(np.inf)
                    boxes[start + node, 3 + axis, s] = np.float32(-np.inf)


class Search(NamedTuple):
    """What one search needs to remember; made by `search_space` once for many."""

    node: np.ndarray  # (stack,) nodes still to visit: level · 2⁴⁰ + number in the level
    bound: np.ndarray  # (stack,) float64: no triangle in the node is closer; squared, in half sizes
    near: np.ndarray  # (8,) float32: the same for the children of a node
    square: np.ndarray  # (8,) [m²] of the triangles of a leaf
    asked: np.ndarray  # (6, 8) float32: low x, y, z and high x, y, z of eight boxes; see softbody/geometry/bvh_boxes.py
    point: np.ndarray  # (8,) of what the eight are about, if these are points
    listed: np.ndarray  # (8 leaves,) triangles near any of them
    meets: np.ndarray  # (8 leaves,) which of the eight, by bits


@jit
def search_space(tree: BVH) -> Search:
    """Return room for searches in `tree`, of any number of points, one after the other."""
    stack = WIDTH * (tree.level_count.shape[0] + 1)
    return Search(
        np.empty(stack, np.int64),
        np.empty(stack),
        np.empty(WIDTH, np.float32),
        np.empty(WIDTH),
        np.empty((6, WIDTH), np.float32),
        np.empty(WIDTH, np.int64),
        np.empty(tree.order.shape[0], np.int64),
        np.empty(tree.order.shape[0], np.int64),
    )


@jit_lean
def _box_bounds(boxes: np.ndarray, node: int, p: Vec32) -> Lanes:
    """Return a lower bound of the squared distance of `p` to each child of a node, in half sizes."""
    sides = boxes[node]
    dx = _beyond(load_lanes(sides[0], 0) - p[0], p[0] - load_lanes(sides[3], 0))
    dy = _beyond(load_lanes(sides[1], 0) - p[1], p[1] - load_lanes(sides[4], 0))
    dz = _beyond(load_lanes(sides[2], 0) - p[2], p[2] - load_lanes(sides[5], 0))
    return (dx * dx + dy * dy + dz * dz) * LESSENED


@jit_lean
def _beyond(below: Lanes, above: Lanes) -> Lanes:
    """Return how far a coordinate is beyond an interval, by how far it is below and above it."""
    beyond = where_less(above, below, below, above)
    return where_less(ZERO, beyond, beyond, ZERO)


@jit_lean
def _leaf_squares(corners: np.ndarray, leaf: int, p: Vec) -> Lanes:
    """Return the squared distance [m²] of `p` to each triangle of a leaf."""
    rows = corners[leaf]
    return squared_distances_to_triangles(
        p, load_vec_lanes(rows, 0), load_vec_lanes(rows[3:], 0), load_vec_lanes(rows[6:], 0)
    )


@jit
def in_half_sizes(p: Vec, middle: Vec, per_metre: float) -> Vec32:
    """Return a point [m] as the boxes have theirs: float32, about the middle of the mesh, in units of its half size."""
    away = scale(per_metre, sub(p, middle))
    return _to_float32(away[0]), _to_float32(away[1]), _to_float32(away[2])


@jit
def _to_float32(x: float) -> np.float32:
    return np.float32(min(max(x, -FARTHEST), FARTHEST))


@jit
def _in_reach(limit: float) -> float:
    """Return how far a child may be so that it is looked into: those that there are, if nothing is known."""
    return limit if limit < MOST else MOST


LEVEL_SHIFT = 40


@jit_inlined
def _search(p: Vec, tree: BVH, search: Search, closest: int, best: float) -> int:
    """Return the closest triangle to `p`, or −1; `closest`, if not −1, is one at a squared distance of `best` [m²]."""
    middle, per_metre = (tree.frame[0], tree.frame[1], tree.frame[2]), tree.frame[3]
    order, corners, level_start, boxes = tree.order, tree.corners, tree.level_start, tree.boxes
    node_stack, bound_stack, near, square = search.node, search.bound, search.near, search.square
    if not isfinite(per_metre * (p[0] + p[1] + p[2])):
        return -1
    seen = in_half_sizes(p, middle, per_metre)
    to_half_sizes = per_metre * per_metre
    limit = _in_reach(best * to_half_sizes)  # the same in half sizes
    top = level_start.shape[0] - 1
    node_stack[0] = top << LEVEL_SHIFT
    bound_stack[0] = 0.0
    count = 1
    while count > 0:
        count -= 1
        if bound_stack[count] > limit:
            continue
        level = node_stack[count] >> LEVEL_SHIFT
        number = node_stack[count] & ((1 << LEVEL_SHIFT) - 1)
        if level == 0:
            # A leaf: the distances to its eight triangles; of equal ones the lowest number wins.
            squares = _leaf_squares(corners, number, p)
            near_ones = bits_at_most(squares, best)
            if near_ones != 0:
                store_lanes(square, 0, squares)
            while near_ones != 0:
                s = lowest_bit(near_ones)
                near_ones &= near_ones - 1
                t = order[WIDTH * number + s]
                if square[s] < best or (square[s] == best and t < closest):
                    best = square[s]
                    closest = t
            limit = _in_reach(best * to_half_sizes)
        else:
            # An inner node: bounds of its children. The nearest is pushed last, so that it is taken first.
            bounds = _box_bounds(boxes, level_start[level] + number, seen)
            store_lanes(near, 0, bounds)
            children = bits_at_most(in_double(bounds), limit)
            nearest = -1
            while children != 0:
                s = lowest_bit(children)
                children &= children - 1
                if nearest < 0:
                    nearest = s
                    continue
                farther = s
                if near[s] < near[nearest]:
                    farther, nearest = nearest, s
                node_stack[count] = (level - 1) << LEVEL_SHIFT | (WIDTH * number + farther)
                bound_stack[count] = near[farther]
                count += 1
            if nearest >= 0:
                node_stack[count] = (level - 1) << LEVEL_SHIFT | (WIDTH * number + nearest)
                bound_stack[count] = near[nearest]
                count += 1
    return closest


@jit_lean
def _at_least_as_close(p: Vec, triangles: np.ndarray, vertices: np.ndarray, guess: int) -> tuple[int, float]:
    """Return triangle `guess` and its squared distance [m²] for `_search` to start from; −1 and inf if it is none."""
    if 0 <= guess < triangles.shape[0]:
        i, j, k = triangles[guess, 0], triangles[guess, 1], triangles[guess, 2]
        square = squared_distance_to_triangle(p, load(vertices, i), load(vertices, j), load(vertices, k))
        if square < np.inf:
            return guess, square
    return -1, np.inf


@jit_lean
def closest_in_bvh(p: Vec, tree: BVH, vertices: np.ndarray, search: Search, guess: int = -1) -> tuple[int, Vec, float]:
    """Return (triangle, weights, distance [m]) closest to `p` [m]: as `closest_triangle`.

    The tree must have been fitted to `vertices` (n, 3) [m]; `search` comes from `search_space`. With a good `guess` of
    the triangle the same is found sooner; −1 for none.
    """
    guess, best = _at_least_as_close(p, tree.triangles, vertices, guess)
    t = _search(p, tree, search, guess, best)
    return with_weights(p, vertices, tree.triangles, t)


@jit
def closest_all_in_bvh(
    points: np.ndarray, tree: BVH, vertices: np.ndarray, answers: Closest, share: tuple[int, int]
) -> None:
    """Write into the answers from share[0] to share[1] what is closest to these of `points` (m, 3) [m].

    As `closest_triangles`. The tree must have been fitted to `vertices` (n, 3) [m]. Threads take shares of the work.
    """
    search = search_space(tree)
    triangles, guess = tree.triangles, -1
    for q in range(share[0], share[1]):
        p = load(points, q)
        guess, best = _at_least_as_close(p, triangles, vertices, guess)  # as the answer to the point before
        guess = _search(p, tree, search, guess, best)
        answers.triangle[q] = guess
    for q in range(share[0], share[1]):
        found = with_weights(load(points, q), vertices, triangles, answers.triangle[q])
        write_answer(answers, q, vertices, triangles, found)
