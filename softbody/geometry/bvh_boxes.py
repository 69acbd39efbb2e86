"""Triangles that may meet any of eight boxes, found in one walk down a mesh's BVH.

Eight points or edges that are asked about together are near each other, and meet much the same triangles. A box is
passed over only if nothing in it can be met, in spite of any rounding: boxes are grown by more than that.
"""

from __future__ import annotations

from math import isfinite

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import Lanes, bits_at_most, least_lane, load_lanes, lowest_bit
from softbody.geometry.aabb import box_around
from softbody.geometry.bvh import BVH, LEVEL_SHIFT, WIDTH, Search, Vec32, in_half_sizes
from softbody.linalg.vec import Vec, load

NOWHERE = np.float32(np.inf)


@jit_lean
def ask_nothing(search: Search) -> None:
    """Let none of the eight boxes be anywhere."""
    for lane in range(WIDTH):
        _ask(search, lane, (NOWHERE, NOWHERE, NOWHERE), (-NOWHERE, -NOWHERE, -NOWHERE))


@jit_lean
def ask_box(search: Search, lane: int, low: Vec, high: Vec, tree: BVH) -> None:
    """Let one of the eight boxes be that between two corners [m]; nowhere, if a number of `low` is not finite.

    Or if a vertex of the mesh is not.
    """
    middle, per_metre = (tree.frame[0], tree.frame[1], tree.frame[2]), tree.frame[3]
    if isfinite(per_metre * (low[0] + low[1] + low[2])):
        _ask(search, lane, in_half_sizes(low, middle, per_metre), in_half_sizes(high, middle, per_metre))


@jit_lean
def ask_ray(search: Search, lane: int, p: Vec, axis: int, goes_up: bool, tree: BVH) -> None:
    """Let one of the eight boxes be a ray from `p` [m] along an axis; nowhere, as with `ask_box`."""
    ask_box(search, lane, p, p, tree)
    if goes_up:
        search.asked[3 + axis, lane] = np.inf
    else:
        search.asked[axis, lane] = -np.inf


@jit_lean
def ask_leaf(
    search: Search,
    leaf: int,
    tree: BVH,
    vertices: np.ndarray,
    margin: float,
    number: np.ndarray | None = None,
    least: float = 0.0,
) -> bool:
    """Let the eight boxes be those around the triangles of a leaf, and a `margin` [m]; `vertices` (n, 3) [m].

    With a `number` (n,) of each vertex, only of triangles that have a corner with the `least` one. Tells if any is.
    """
    ask_nothing(search)
    any_is = False
    for lane in range(min(WIDTH, tree.triangles.shape[0] - WIDTH * leaf)):
        t = tree.order[WIDTH * leaf + lane]
        i, j, k = tree.triangles[t, 0], tree.triangles[t, 1], tree.triangles[t, 2]
        if number is not None and min(number[i], number[j], number[k]) > least:
            continue
        any_is = True
        a, b, c = load(vertices, i), load(vertices, j), load(vertices, k)
        low, high = box_around(a, b, margin)
        low = min(low[0], c[0] - margin), min(low[1], c[1] - margin), min(low[2], c[2] - margin)
        high = max(high[0], c[0] + margin), max(high[1], c[1] + margin), max(high[2], c[2] + margin)
        ask_box(search, lane, low, high, tree)
    return any_is


@jit_lean
def _ask(search: Search, lane: int, low: Vec32, high: Vec32) -> None:
    for axis in range(3):
        search.asked[axis, lane], search.asked[3 + axis, lane] = low[axis], high[axis]


@jit_lean
def list_near(tree: BVH, search: Search) -> int:
    """List in `search.listed` the triangles whose boxes meet any that is asked; return how many.

    Bits in `search.meets` tell which ones. The tree must have been fitted.
    """
    asked, waiting, boxes = search.asked, search.node, tree.boxes
    x0, y0, z0 = load_lanes(asked[0], 0), load_lanes(asked[1], 0), load_lanes(asked[2], 0)
    x1, y1, z1 = load_lanes(asked[3], 0), load_lanes(asked[4], 0), load_lanes(asked[5], 0)
    low = np.float32(least_lane(x0)), np.float32(least_lane(y0)), np.float32(least_lane(z0))
    high = _greatest_lane(x1), _greatest_lane(y1), _greatest_lane(z1)
    found, count = 0, 1
    waiting[0] = (tree.level_start.shape[0] - 1) << LEVEL_SHIFT
    while count > 0:
        count -= 1
        level, number = waiting[count] >> LEVEL_SHIFT, waiting[count] & ((1 << LEVEL_SHIFT) - 1)
        node = tree.level_start[level] + number
        children = _children_in(boxes, node, low, high)
        if level == 0 and WIDTH * (number + 1) > tree.triangles.shape[0]:
            # The last leaf is filled up with triangles that are there already.
            children &= (1 << (tree.triangles.shape[0] - WIDTH * number)) - 1
        while children != 0:
            child = lowest_bit(children)
            children &= children - 1
            if level > 0:
                waiting[count] = (level - 1) << LEVEL_SHIFT | (WIDTH * number + child)
                count += 1
                continue
            meets = bits_at_most(x0, boxes[node, 3, child]) & bits_at_most(boxes[node, 0, child], x1)
            meets &= bits_at_most(y0, boxes[node, 4, child]) & bits_at_most(boxes[node, 1, child], y1)
            meets &= bits_at_most(z0, boxes[node, 5, child]) & bits_at_most(boxes[node, 2, child], z1)
            search.listed[found], search.meets[found] = tree.order[WIDTH * number + child], meets
            found += meets != 0
    return found


@jit_lean
def _greatest_lane(lanes: Lanes) -> np.float32:
    return np.float32(-least_lane(np.float32(0.0) - lanes))


@jit_lean
def _children_in(boxes: np.ndarray, node: int, low: Vec32, high: Vec32) -> int:
    """Return bits: which children of a node meet the box between two corners."""
    bits = bits_at_most(_row(boxes, node, 0), high[0]) & bits_at_most(low[0], _row(boxes, node, 3))
    bits &= bits_at_most(_row(boxes, node, 1), high[1]) & bits_at_most(low[1], _row(boxes, node, 4))
    return bits & bits_at_most(_row(boxes, node, 2), high[2]) & bits_at_most(low[2], _row(boxes, node, 5))


@jit_lean
def _row(boxes: np.ndarray, node: int, side: int) -> Lanes:
    return load_lanes(boxes[node, side], 0)


@jit_lean
def sort_listed(search: Search, count: int) -> None:
    """Sort what `list_near` has listed by the triangles' numbers: so nothing depends on how the tree was built."""
    listed, meets = search.listed, search.meets
    for k in range(1, count):
        triangle, bits, at = listed[k], meets[k], k
        while at > 0 and listed[at - 1] > triangle:
            listed[at], meets[at] = listed[at - 1], meets[at - 1]
            at -= 1
        listed[at], meets[at] = triangle, bits
