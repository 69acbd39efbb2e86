"""A body that is moved by many steps at once is watched, if it must not come near itself, or tear, unseen."""

from __future__ import annotations

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


class Limits(NamedTuple):
    """Springs of the only body that tear it, in whole lanes."""

    first: np.ndarray  # (k,) uint32: place in rows of one end
    second: np.ndarray  # (k,) of the other
    square: np.ndarray  # (k,) [m²] of the length beyond which it tears
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
    is_torn: np.ndarray


def no_limits() -> Limits:
    """Return what says that nothing tears."""
    none = np.empty(0, np.uint32)
    return Limits(none, none, np.empty(0), np.zeros(1, np.bool_))


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
def is_beyond(watch: Watch, rows: np.ndarray) -> bool:
    """Tell whether springs of the only body, in `rows` (3, s) [m], are beyond their limits, and note it."""
    first, second, square = watch.first, watch.second, watch.square
    least = spread(0.0)
    for i in range(0, square.shape[0], LANES):
        left = load_lanes(square, i)
        for c in range(3):
            along = in_double(gather_lanes(rows[c], second, i)) - in_double(gather_lanes(rows[c], first, i))
            left = left - along * along
        least = where_less(left, least, left, least)
    watch.is_torn[0] = least_lane(least) < 0.0
    return bool(watch.is_torn[0])


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
