"""How far points have moved besides what all of them have in common: half the diagonal of the box around their ways.

No point has moved farther than that from where a shift takes it, if the shift is the middle of the box.
"""

from __future__ import annotations

from math import inf, isfinite, sqrt

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import LANES, in_double, least_lane, spread
from softbody.linalg.vec import load, norm, scale, sub
from softbody.linalg.vec_lanes import VecLanes, least_vec, load_vec_lanes, most_vec


@jit_lean
def drift(points: np.ndarray, seen: np.ndarray) -> float:
    """Return how far [m] points (n, 3) [m] have drifted apart since they were `seen` (n, 3); n ≥ 1."""
    low = high = sub(load(points, 0), load(seen, 0))
    total = low[0] + low[1] + low[2]  # where it is no number, the far ones may be others
    for i in range(1, points.shape[0]):
        way = sub(load(points, i), load(seen, i))
        total += way[0] + way[1] + way[2]
        low = min(low[0], way[0]), min(low[1], way[1]), min(low[2], way[2])
        high = max(high[0], way[0]), max(high[1], way[1]), max(high[2], way[2])
    far = norm(scale(0.5, sub(high, low)))
    return far if isfinite(total) else inf


@jit_lean
def drift_of_rows(rows: np.ndarray, seen: np.ndarray, count: int) -> float:
    """Return the same [m] of the first `count` points of `rows` (3, n), in whole lanes."""
    low = high = _way(rows, seen, 0)
    for i in range(LANES, count, LANES):  # all sides at once: none waits for another
        way = _way(rows, seen, i)
        low, high = least_vec(way, low), most_vec(way, high)
    square = 0.0
    for c in range(3):
        side = -least_lane(spread(0.0) - high[c]) - least_lane(low[c])
        square += side * side
    return 0.5 * sqrt(square)


@jit_lean
def _way(rows: np.ndarray, seen: np.ndarray, i: int) -> VecLanes:
    x, y, z = sub(load_vec_lanes(rows, i), load_vec_lanes(seen, i))
    return in_double(x), in_double(y), in_double(z)
