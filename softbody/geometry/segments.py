"""Eight segments side by side, a coordinate a row: `segments` (9, 8) [m], starts, ends, and the ways between them."""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import LANES, bits_at_most
from softbody.linalg.vec import Vec, cross, dot, sub
from softbody.linalg.vec_lanes import VecLanes, load_vec_lanes

ROWS = 9
LEAST = 5e-324  # above zero


@jit_lean
def put_segment(segments: np.ndarray, lane: int, p: Vec, q: Vec) -> None:
    """Let one of the eight go from `p` to `q` [m]."""
    for c in range(3):
        segments[c, lane], segments[3 + c, lane], segments[6 + c, lane] = p[c], q[c], q[c] - p[c]


@jit_lean
def start_of(segments: np.ndarray, lane: int) -> Vec:
    """Return where one of them starts [m]."""
    return segments[0, lane], segments[1, lane], segments[2, lane]


@jit_lean
def end_of(segments: np.ndarray, lane: int) -> Vec:
    """Return where it ends [m]."""
    return segments[3, lane], segments[4, lane], segments[5, lane]


@jit_lean
def starts_of(segments: np.ndarray) -> VecLanes:
    """Return where all of them start [m]."""
    return load_vec_lanes(segments[0:3], 0)


@jit_lean
def ways_of(segments: np.ndarray) -> VecLanes:
    """Return the ways from their starts to their ends [m]."""
    return load_vec_lanes(segments[6:9], 0)


@jit_lean
def bits_not_beside(segments: np.ndarray, point: Vec, normal: Vec) -> int:
    """Return bits: which of them are not, with both ends, on the same side of a plane through `point` [m]."""
    before = dot(sub(starts_of(segments), point), normal)
    beyond = dot(sub(load_vec_lanes(segments[3:6], 0), point), normal)
    above = bits_at_most(LEAST, before) & bits_at_most(LEAST, beyond)
    below = bits_at_most(before, -LEAST) & bits_at_most(beyond, -LEAST)
    return ((1 << LANES) - 1) & ~(above | below)


@jit_lean
def bits_not_past(segments: np.ndarray, a: Vec, b: Vec, c: Vec) -> int:
    """Return bits: the line of which of them is not clearly past a triangle [m].

    Past it, the line has one side of the triangle on its left and another on its right.
    """
    start, along = starts_of(segments), ways_of(segments)
    a, b, c = sub(a, start), sub(b, start), sub(c, start)
    u, v, w = dot(along, cross(b, c)), dot(along, cross(c, a)), dot(along, cross(a, b))
    left = bits_at_most(LEAST, u) | bits_at_most(LEAST, v) | bits_at_most(LEAST, w)
    right = bits_at_most(u, -LEAST) | bits_at_most(v, -LEAST) | bits_at_most(w, -LEAST)
    return ((1 << LANES) - 1) & ~(left & right)
