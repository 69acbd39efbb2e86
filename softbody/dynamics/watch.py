"""A body that is moved by many steps at once is watched, if it must not come near itself on the way unseen."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import LANES, in_double, load_lanes, spread, sum_of_lanes
from softbody.geometry.drift import drift_of_rows
from softbody.geometry.star import corners_of, room_of_star
from softbody.linalg.vec_lanes import load_vec_lanes, store_vec_lanes
from softbody.model.arrays import VertexRings


class Watch(NamedTuple):
    """How far bodies may move while nothing of them is near itself."""

    seen: np.ndarray  # (n, 3) [m] where particles were when their body was looked at
    room: np.ndarray  # (b,) [m] that they may drift from there; inf: the body is not watched
    height: np.ndarray  # (b,) [m] from which a body is to be seen whole, for more room
    corners: np.ndarray  # (s,) uint32, of the only body's triangles: places in rows, see star.py


def nobody_watched(count: int) -> Watch:
    """Return what says of so many bodies that none is watched."""
    return Watch(np.empty((0, 3)), np.full(count, np.inf), np.zeros(count), np.empty(0, np.uint32))


def watch_of(rings: VertexRings, triangles: np.ndarray) -> Watch:
    """Return a watch of the only body, whose triangles (t, 3) are given; it is not on yet."""
    place = np.empty(int(rings.particle.max()) + 1, np.int64)
    place[rings.particle] = np.arange(len(rings.particle))
    return nobody_watched(1)._replace(seen=np.empty((len(place), 3)), corners=corners_of(triangles, place))


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
