"""A body that is moved by many steps at once is watched, if it must not come near itself, or tear, unseen."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import (
    LANES,
    gather_lanes,
    in_double,
    least_lane,
    load_lanes,
    spread,
    sum_of_lanes,
    where_less,
)
from softbody.geometry.drift import drift_of_rows
from softbody.geometry.star import corners_of, room_of_star
from softbody.linalg.vec_lanes import load_vec_lanes, store_vec_lanes
from softbody.model.arrays import VertexRings

ROUNDING = 1e-12  # of squares of lengths: some thousand times what is lost in them
DRIFT_ROUNDING = 1e-5  # of a drift: some hundred times what is lost in it in single precision


class Limits(NamedTuple):
    """Springs of the only body that tear it, in whole lanes."""

    first: np.ndarray  # (k,) uint32: place in rows of one end
    second: np.ndarray  # (k,) of the other
    square: np.ndarray  # (k,) [m²] of the length beyond which it tears
    per_length: np.ndarray  # (k,) [1/m] of four times that length
    is_torn: np.ndarray  # (1,) of bool: one is


class Watch(NamedTuple):
    """How far bodies may move while nothing of them is near itself."""

    seen: np.ndarray  # (n, 3) [m] where particles were when their body was looked at
    room: np.ndarray  # (b,) [m] that they may drift from there; inf: the body is not watched
    height: np.ndarray  # (b,) [m] from which a body is to be seen whole, for more room
    corners: np.ndarray  # (s,) uint32, of the only body's triangles: places in rows, see star.py
    # As of Limits.
    first: np.ndarray
    second: np.ndarray
    square: np.ndarray
    per_length: np.ndarray
    is_torn: np.ndarray


def no_limits() -> Limits:
    """Return what says that nothing tears."""
    none = np.empty(0, np.uint32)
    return Limits(none, none, np.empty(0), np.empty(0), np.zeros(1, np.bool_))


def nobody_watched(count: int) -> Watch:
    """Return what says of so many bodies that none is watched."""
    return Watch(np.empty((0, 3)), np.full(count, np.inf), np.zeros(count), np.empty(0, np.uint32), *no_limits())


def watch_of(rings: VertexRings, triangles: np.ndarray) -> Watch:
    """Return a watch of the only body, whose triangles (t, 3) are given; it is not on yet."""
    place = places_of(rings)
    return nobody_watched(1)._replace(seen=np.empty((len(place), 3)), corners=corners_of(triangles, place))


def places_of(rings: VertexRings) -> np.ndarray:
    """Return the place in rows of each particle (n,) of the only body."""
    place = np.empty(int(rings.particle.max()) + 1, np.int64)
    place[rings.particle] = np.arange(len(rings.particle))
    return place


@jit_lean
def room_of_springs(watch: Watch, rows: np.ndarray, seen: np.ndarray, count: int) -> float:
    """Return how far [m] the only body, in `rows` (3, s) [m], may drift before a spring is beyond its limit.

    It is noted if one is, and where particles are `seen` (3, s). By a drift d a length l changes by 2 d at most, and
    the limit L leaves L − l ≥ (L² − l²) / 2 L.
    """
    first, second = watch.first, watch.second
    least = room = spread(inf)
    for i in range(0, watch.square.shape[0], LANES):
        square = load_lanes(watch.square, i)
        left = square
        for c in range(3):
            along = in_double(gather_lanes(rows[c], second, i)) - in_double(gather_lanes(rows[c], first, i))
            left = left - along * along
        least = where_less(left, least, left, least)
        drift = (left - ROUNDING * square) * load_lanes(watch.per_length, i)  # no number without a limit: not less
        room = where_less(drift, room, drift, room)
    watch.is_torn[0] = least_lane(least) < 0.0
    for i in range(0, count, LANES):
        store_vec_lanes(seen, i, load_vec_lanes(rows, i))
    return (1.0 - DRIFT_ROUNDING) * least_lane(room)


@jit_lean
def stays_in_room(watch: Watch, body: int, rows: np.ndarray, seen: np.ndarray, count: int) -> bool:
    """Tell whether particles in `rows` (3, s) [m] are where they may be; perhaps as now they are `seen` (3, s)."""
    if drift_of_rows(rows, seen, count) <= watch.room[body]:
        return True
    eye = _mean(rows[0], count), _mean(rows[1], count), _mean(rows[2], count)
    room = room_of_star((rows[0], rows[1], rows[2]), watch.corners, eye, watch.height[body])
    if not room > 0.0:
        return False
    watch.room[body] = room
    for i in range(0, count, LANES):
        store_vec_lanes(seen, i, load_vec_lanes(rows, i))
    return True


@jit_lean
def _mean(row: np.ndarray, count: int) -> float:
    total = spread(0.0)
    for i in range(0, count, LANES):
        total = total + in_double(load_lanes(row, i))
    return sum_of_lanes(total) / count
