"""Eight 3-vectors side by side: tuples of lanes, for which the arithmetic of `softbody.linalg.vec` does as it is."""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import Lanes, gather_lanes, load_lanes, scatter_lanes, store_lanes, where_less

VecLanes = tuple[Lanes, Lanes, Lanes]


@jit_lean
def load_vec_lanes(rows: np.ndarray, i: int) -> VecLanes:
    """Return columns i … i + 7 of `rows` (3, n)."""
    return load_lanes(rows[0], i), load_lanes(rows[1], i), load_lanes(rows[2], i)


@jit_lean
def store_vec_lanes(rows: np.ndarray, i: int, a: VecLanes) -> None:
    """Overwrite columns i … i + 7 of `rows` (3, n)."""
    store_lanes(rows[0], i, a[0])
    store_lanes(rows[1], i, a[1])
    store_lanes(rows[2], i, a[2])


@jit_lean
def gather_vec(numbers: np.ndarray, first: np.ndarray, i: int = 0) -> VecLanes:
    """Return eight vectors that are among `numbers` (n,), from where `first` (e,), unsigned, says at i … i + 7."""
    return gather_lanes(numbers, first, i), gather_lanes(numbers[1:], first, i), gather_lanes(numbers[2:], first, i)


@jit_lean
def scatter_vec(numbers: np.ndarray, first: np.ndarray, a: VecLanes, i: int = 0) -> None:
    """Overwrite what `gather_vec` returns."""
    scatter_lanes(numbers, first, i, a[0])
    scatter_lanes(numbers[1:], first, i, a[1])
    scatter_lanes(numbers[2:], first, i, a[2])


@jit_lean
def least_vec(a: VecLanes, b: VecLanes) -> VecLanes:
    """Return the lesser of both, component by component; b where that cannot be told."""
    return where_less(a[0], b[0], a[0], b[0]), where_less(a[1], b[1], a[1], b[1]), where_less(a[2], b[2], a[2], b[2])


@jit_lean
def most_vec(a: VecLanes, b: VecLanes) -> VecLanes:
    """Return the greater of both, component by component; b where that cannot be told."""
    return where_less(b[0], a[0], a[0], b[0]), where_less(b[1], a[1], a[1], b[1]), where_less(b[2], a[2], a[2], b[2])
