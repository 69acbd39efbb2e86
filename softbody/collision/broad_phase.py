"""Broad phase: pairs of bodies whose bounding spheres meet, by hashed grids or exhaustively.

A pair is near if its bounding spheres meet and one of the two can move; paper §4 tries all pairs. Both functions return
the same pairs in the same order, (a, b) with a > b, by a and then b: the order in which contacts are solved.
"""

from __future__ import annotations

from math import floor, frexp
from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean

# Cells are this much wider than the spheres in them: else two that just touch could, by rounding, lie two cells apart.
WIDER = 1.0 + 1e-6


@jit
def near_pairs_exhaustive(centre: np.ndarray, radius: np.ndarray, movable: np.ndarray) -> np.ndarray:
    """Return the near pairs (p, 2) by trying all m (m − 1)/2 of them, as the paper does: the baseline.

    `centre` (m, 3) [m] and `radius` (m,) [m] of the bounding spheres; `movable` (m,) bool.
    """
    pairs = np.empty((4 * centre.shape[0] + 4, 2), np.int64)
    count = 0
    for a in range(centre.shape[0]):
        for b in range(a):
            if (movable[a] or movable[b]) and spheres_meet(centre, radius, a, b):
                if count == pairs.shape[0]:
                    pairs = _longer(pairs)
                pairs[count, 0] = a
                pairs[count, 1] = b
                count += 1
    return pairs[:count].copy()


class Cells(NamedTuple):
    """Spheres, listed by the cells of grids."""

    widest: float  # [m] the width of a cell of the coarsest grid, of level 0
    level: np.ndarray  # (m,) of the grid of each sphere
    cell: np.ndarray  # (m, 3) in that grid
    start: np.ndarray  # (buckets + 1,) where the list of each bucket starts
    listed: np.ndarray  # (m,) the spheres, bucket by bucket


@jit
def near_pairs(centre: np.ndarray, radius: np.ndarray, movable: np.ndarray) -> np.ndarray:
    """Return the near pairs (p, 2) in a time that grows as m + p; arguments as above.

    Grids (Teschner et al. 2003), one as wide as the largest sphere, the others half, a quarter … of it: a sphere is
    listed at its centre, in the finest grid that is still wider than it. Whatever meets it and is not smaller lies, in
    a grid as coarse or coarser, in the cell of its centre or in one of the 26 around.
    """
    widest, level, cell, start, listed = _list_in_cells(centre, radius)
    count, buckets = centre.shape[0], start.shape[0] - 1
    levels = _distinct(level)
    pairs = np.empty((4 * count + 4, 2), np.int64)
    found = 0
    for i in range(count):
        for coarse in levels:
            if coarse > level[i]:
                continue
            width = widest * 0.5**coarse
            x = floor(centre[i, 0] / width)
            y = floor(centre[i, 1] / width)
            z = floor(centre[i, 2] / width)
            # In its own grid each sphere looks at its own cell and half of those around: the other half look at it.
            own = coarse == level[i]
            for u in range(x if own else x - 1, x + 2):
                for v in range(y if own and u == x else y - 1, y + 2):
                    for w in range(z if own and u == x and v == y else z - 1, z + 2):
                        k = _bucket(u, v, w, coarse, buckets)
                        for place in range(start[k], start[k + 1]):
                            j = listed[place]
                            if cell[j, 0] != u or cell[j, 1] != v or cell[j, 2] != w or level[j] != coarse:
                                continue
                            if own and j >= i and u == x and v == y and w == z:
                                continue
                            if (movable[i] or movable[j]) and spheres_meet(centre, radius, i, j):
                                if found == pairs.shape[0]:
                                    pairs = _longer(pairs)
                                pairs[found, 0] = max(i, j)
                                pairs[found, 1] = min(i, j)
                                found += 1
    return _sorted(pairs[:found], count)


@jit
def _list_in_cells(centre: np.ndarray, radius: np.ndarray) -> Cells:
    """Return the spheres by their cells; see `near_pairs`."""
    count = centre.shape[0]
    # The grid of each sphere, by its radius.
    largest = 0.0
    for i in range(count):
        largest = max(largest, radius[i])
    widest = 2.0 * WIDER * largest
    level = np.empty(count, np.int64)
    for i in range(count):
        level[i] = frexp(largest / radius[i])[1] - 1
    # Its cell, and a bucket of a hash table for that.
    cell = np.empty((count, 3), np.int64)
    buckets = 8
    while buckets < 2 * count:
        buckets *= 2
    start = np.zeros(buckets + 1, np.int64)
    bucket = np.empty(count, np.int64)
    for i in range(count):
        for c in range(3):
            cell[i, c] = floor(centre[i, c] / (widest * 0.5 ** level[i]))
        bucket[i] = _bucket(cell[i, 0], cell[i, 1], cell[i, 2], level[i], buckets)
        start[bucket[i] + 1] += 1
    # A counting sort by bucket.
    for k in range(buckets):
        start[k + 1] += start[k]
    filled = start[:buckets].copy()
    listed = np.empty(count, np.int64)
    for i in range(count):
        listed[filled[bucket[i]]] = i
        filled[bucket[i]] += 1
    return Cells(widest, level, cell, start, listed)


@jit_lean
def spheres_meet(centre: np.ndarray, radius: np.ndarray, a: int, b: int) -> bool:
    """Tell whether two spheres overlap or touch; paper §4."""
    x = centre[a, 0] - centre[b, 0]
    y = centre[a, 1] - centre[b, 1]
    z = centre[a, 2] - centre[b, 2]
    reach = radius[a] + radius[b]
    return x * x + y * y + z * z <= reach * reach


@jit_lean
def _bucket(x: int, y: int, z: int, level: int, buckets: int) -> int:
    """Return the place of a cell in a table of 2^k buckets (hash of Teschner et al. 2003)."""
    return ((x * 73856093) ^ (y * 19349663) ^ (z * 83492791) ^ (level * 50331653)) & (buckets - 1)


@jit
def _distinct(level: np.ndarray) -> np.ndarray:
    """Return the different values of `level` (m,); there are a few, whatever m."""
    found = np.empty(level.shape[0], np.int64)
    count = 0
    for i in range(level.shape[0]):
        known = False
        for k in range(count):
            known = known or found[k] == level[i]
        if not known:
            found[count] = level[i]
            count += 1
    return found[:count].copy()


@jit
def _longer(pairs: np.ndarray) -> np.ndarray:
    """Return a copy of `pairs` with as many free rows after them."""
    longer = np.empty((2 * pairs.shape[0], 2), np.int64)
    for k in range(pairs.shape[0]):
        longer[k, 0], longer[k, 1] = pairs[k, 0], pairs[k, 1]
    return longer


@jit
def _sorted(pairs: np.ndarray, bodies: int) -> np.ndarray:
    """Return pairs (p, 2) by their first and then second body, in a time that grows as bodies + p."""
    start = np.zeros(bodies + 1, np.int64)
    for k in range(pairs.shape[0]):
        start[pairs[k, 0] + 1] += 1
    for a in range(bodies):
        start[a + 1] += start[a]
    filled = start[:bodies].copy()
    result = np.empty_like(pairs)
    for k in range(pairs.shape[0]):
        a = pairs[k, 0]
        place = filled[a]
        filled[a] += 1
        while place > start[a] and result[place - 1, 1] > pairs[k, 1]:
            result[place, 1] = result[place - 1, 1]
            place -= 1
        result[place, 1] = pairs[k, 1]
    for a in range(bodies):
        result[start[a] : start[a + 1], 0] = a
    return result
