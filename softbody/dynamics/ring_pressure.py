"""What a pressure that grows along a line does to a skin, the fast form: one pass over each particle's neighbours.

A triangle (i, j, k), with a normal n as long as twice its area, gives its corner i (2 p_i + p_j + p_k) n / 24. Where p
grows by a for each metre, that is (4 p_i n + (a·(x_j − x_i) + a·(x_k − x_i)) n) / 24: two sums over the triangles
around a particle, of which nothing is scattered. In double precision, whatever that of the springs is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import LANES, Lanes, gather_lanes, spread
from softbody.dynamics.liquid_forces import Moving
from softbody.linalg.vec import Vec, add, cross, dot, scale, sub
from softbody.linalg.vec_lanes import VecLanes, gather_vec, load_vec_lanes, scatter_vec, store_vec_lanes
from softbody.model.arrays import DEGREE, END, ENTRY, FIRST, NEXT, VertexRings

# Rows of the work array, by index: three each, for x, y and z.
PLACE = 0  # [m] of a particle
TURN = 3  # [m²] Σ n over the triangles around it
SLOPE = 6  # Σ (a·(x_j − x_i) + a·(x_k − x_i)) n
ROWS = 9


class RingWork(NamedTuple):
    """The rings of all bodies, and memory for one body at a time."""

    rings: VertexRings
    rows: np.ndarray  # (ROWS, particles of the largest body, and some)


@jit
def memory_for_rings(rings: VertexRings) -> np.ndarray:
    """Return memory for the work of one body at a time."""
    largest = 0
    for body in range(rings.start.shape[0] - 1):
        largest = max(largest, rings.start[body + 1] - rings.start[body])
    return np.empty((ROWS, largest + LANES))


@jit_lean
def sum_around(work: RingWork, body: int, moving: Moving, along: Vec) -> None:
    """Overwrite the rows of a body; `along` is how much a pressure grows for each metre."""
    rings, rows = work
    places = rows[PLACE : PLACE + 3]
    _load_places(rings, body, moving, places)
    for block in range(rings.block_start[body], rings.block_start[body + 1]):
        first, size = rings.block[block, FIRST], rings.block[block, END] - rings.block[block, FIRST]
        degree, entry, next_ = rings.block[block, DEGREE], rings.block[block, ENTRY], rings.block[block, NEXT]
        for q in range(0, size, LANES):
            here = load_vec_lanes(places, first + q)
            turn = slope = spread(0.0), spread(0.0), spread(0.0)
            side = _to_neighbour(places, rings.neighbour, entry + q, here)
            for d in range(degree):
                if next_ < 0:  # a cycle
                    after = d + 1 if d + 1 < degree else 0
                    ahead = _to_neighbour(places, rings.neighbour, entry + after * size + q, here)
                else:
                    side = _to_neighbour(places, rings.neighbour, entry + d * size + q, here)
                    ahead = _to_neighbour(places, rings.next_neighbour, next_ + d * size + q, here)
                normal = cross(side, ahead)
                turn = add(turn, normal)
                slope = add(slope, scale(dot(along, add(side, ahead)), normal))
                side = ahead
            store_vec_lanes(rows[TURN : TURN + 3], first + q, turn)
            store_vec_lanes(rows[SLOPE : SLOPE + 3], first + q, slope)


@jit_lean
def _load_places(rings: VertexRings, body: int, moving: Moving, places: np.ndarray) -> None:
    """Copy where the particles of a body will be to rows."""
    first, position, velocity = rings.start[body], moving.position.reshape(-1), moving.velocity.reshape(-1)
    for i in range(0, rings.start[body + 1] - first, LANES):
        x, v = gather_vec(position, rings.number, first + i), gather_vec(velocity, rings.number, first + i)
        store_vec_lanes(places, i, add(x, scale(moving.ahead, v)))


@jit_lean
def _to_neighbour(places: np.ndarray, neighbour: np.ndarray, e: int, here: VecLanes) -> VecLanes:
    """Return the ways [m] from `here` to the neighbours at entries e … e + 7."""
    x, y, z = places[0], places[1], places[2]
    return sub((gather_lanes(x, neighbour, e), gather_lanes(y, neighbour, e), gather_lanes(z, neighbour, e)), here)


@jit_lean
def pressed(work: RingWork, i: int, pressure: Lanes, growth: float) -> VecLanes:
    """Return 24 times the forces [N] on particles i … i + 7, where the pressure is `pressure` [Pa] there.

    It grows as `growth` times what `sum_around` was told.
    """
    slope = load_vec_lanes(work.rows[SLOPE : SLOPE + 3], i)
    return add(scale(4.0 * pressure, turn_of_rows(work, i)), scale(growth, slope))


@jit_lean
def place_of_rows(work: RingWork, i: int) -> VecLanes:
    """Return where particles i … i + 7 will be [m]."""
    return load_vec_lanes(work.rows[PLACE : PLACE + 3], i)


@jit_lean
def origin_of_rows(work: RingWork) -> Vec:
    """Return where the first particle in the rings will be [m]."""
    return work.rows[PLACE, 0], work.rows[PLACE + 1, 0], work.rows[PLACE + 2, 0]


@jit_lean
def turn_of_rows(work: RingWork, i: int) -> VecLanes:
    """Return Σ n [m²] of particles i … i + 7."""
    return load_vec_lanes(work.rows[TURN : TURN + 3], i)


@jit_lean
def add_to_particles(work: RingWork, body: int, i: int, on: VecLanes, force: np.ndarray) -> None:
    """Add to the `force` (n, 3) [N] on the particles i … i + 7 of a body; twins of one get it once."""
    numbers, at = force.reshape(-1), work.rings.start[body] + i
    scatter_vec(numbers, work.rings.number, add(gather_vec(numbers, work.rings.number, at), on), at)
