"""Forces of springs and gas on every particle, the fast form: one pass over each particle's neighbours.

On a closed mesh the force of the gas on particle i is P/6 G_i with G_i = Σ (x_j − x_i) × (x_k − x_i) over the pairs
j, k of successive neighbours around it, and V = Σ x_i · G_i / 18. So springs, gas and volume come from one gathering
of the neighbours' coordinates, and nothing is scattered. Every sum has an order: the same bits every time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import (
    LANES,
    Lanes,
    first_lanes,
    gather_lanes,
    in_double,
    load_lanes,
    spread,
    square_root,
    sum_of_lanes,
)
from softbody.geometry.borders import hole, volume_of_fan
from softbody.linalg.vec import add, cross, dot, scale, sub
from softbody.linalg.vec_lanes import VecLanes, load_vec_lanes, store_vec_lanes
from softbody.model.arrays import DEGREE, END, ENTRY, FIRST, NEXT, NUMBER, STIFFNESS, VertexRings

# Rows of the work array in which one body moves, by index: three each for x, y and z.
POSITION = 0  # [m]; velocities follow positions
VELOCITY = 3  # [m/s]
NEXT_POSITION = 6  # [m] of a stage, in the end of the step
NEXT_VELOCITY = 9  # [m/s²] a weighted sum of accelerations, in the end the velocity [m/s]
PULL = 12  # [N] of the springs, and of everything else but gas and gravity
AREA = 15  # G [m²]
INVERSE_MASS = 18  # [1/kg], one row
STAGE_VELOCITY = 19  # [m/s] for rk4, and where something damps
SHIFT = 22  # [m/s²] sum over the stages, for rk4
SEEN = 25  # [m] where particles of a body that is watched were when it was looked at
WORK_ROWS = 28

Blocks = tuple[int, int]  # first and end


class Forces(NamedTuple):
    """What a pass over the rings reads and writes, by index."""

    position: np.ndarray  # (3, n) [m]
    velocity: np.ndarray  # (3, n) [m/s]
    pull: np.ndarray  # (3, n) [N]
    area: np.ndarray  # (3, n) G [m²]


class Springs(NamedTuple):
    """What the springs of one body have in common, in the precision of the arrays."""

    stiffness: float  # [N/m] of all, if it is one
    damping: float  # [N s/m] against the speed at which their ends part; 0: no velocity is read
    pull: bool  # or only the areas count, and the pull is 0


@jit_lean
def ring_forces(rings: VertexRings, springs: Springs, blocks: Blocks, forces: Forces, block_moment: np.ndarray) -> None:
    """Overwrite pull and area of the particles in `blocks`, which are of one body.

    `block_moment` (blocks,) gets Σ x · G [m³] over each block; their sum over a body is 18 V.
    """
    for block in range(blocks[0], blocks[1]):
        if rings.block[block, NEXT] < 0:
            block_moment[block] = ring_sums(rings, springs, block, forces)
        else:
            block_moment[block] = fan_sums(rings, springs, block, forces)


@jit_lean
def ring_sums(rings: VertexRings, springs: Springs, block: int, forces: Forces) -> float:
    """Overwrite pull [N] and area (G, [m²]) of the particles of one block; return the sum of x · G [m³].

    The moment is about the particle at index 0: about the origin, it would lose its digits far away.
    """
    x, velocity, pulls, areas = forces
    first, size = rings.block[block, FIRST], rings.block[block, END] - rings.block[block, FIRST]
    origin, total = (x[0, 0], x[1, 0], x[2, 0]), spread(0.0)
    for q in range(0, size, LANES):
        here = load_vec_lanes(x, first + q)
        # The first neighbour: its spring, and where the ring starts.
        e = rings.block[block, ENTRY] + q
        start = _to_neighbour(rings.neighbour, e, x, here)
        pull = scale(_tension(rings, springs, block, e, start, (velocity, first + q)), start)
        turn = _no_vec_lanes(x)
        # The others: their springs, and the triangle with the neighbour before.
        before = start
        for _ in range(1, rings.block[block, DEGREE]):
            e += size
            side = _to_neighbour(rings.neighbour, e, x, here)
            pull = add(pull, scale(_tension(rings, springs, block, e, side, (velocity, first + q)), side))
            turn = add(turn, cross(before, side))
            before = side
        # The triangle that closes the ring.
        turn = add(turn, cross(before, start))
        store_vec_lanes(pulls, first + q, pull)
        store_vec_lanes(areas, first + q, turn)
        total = total + in_double(first_lanes(dot(sub(here, origin), turn), rings.block[block, NUMBER] - q))
    return sum_of_lanes(total)


@jit_lean
def fan_sums(rings: VertexRings, springs: Springs, block: int, forces: Forces) -> float:
    """Do the same where a particle's entries are several cycles, so that each says which neighbour comes next."""
    x, velocity, pulls, areas = forces
    first, size = rings.block[block, FIRST], rings.block[block, END] - rings.block[block, FIRST]
    origin, total = (x[0, 0], x[1, 0], x[2, 0]), spread(0.0)
    for q in range(0, size, LANES):
        here = load_vec_lanes(x, first + q)
        pull = turn = _no_vec_lanes(x)
        for d in range(rings.block[block, DEGREE]):
            e = rings.block[block, ENTRY] + d * size + q
            side = _to_neighbour(rings.neighbour, e, x, here)
            pull = add(pull, scale(_tension(rings, springs, block, e, side, (velocity, first + q)), side))
            ahead = _to_neighbour(rings.next_neighbour, rings.block[block, NEXT] + d * size + q, x, here)
            turn = add(turn, cross(side, ahead))
        store_vec_lanes(pulls, first + q, pull)
        store_vec_lanes(areas, first + q, turn)
        total = total + in_double(first_lanes(dot(sub(here, origin), turn), rings.block[block, NUMBER] - q))
    return sum_of_lanes(total)


@jit_lean
def volume_of_holes(rings: VertexRings, body: int, x: np.ndarray) -> float:
    """Return the volume [m³] that closes all holes of a body at `x` (3, n) [m], about the particle at index 0."""
    volume, points = 0.0, x.T
    for k in range(rings.hole_start[body], rings.hole_start[body + 1]):
        middle, area = hole(points, rings.border, (rings.hole[k, 0], rings.hole[k, 1]))
        volume += volume_of_fan(middle, area, (x[0, 0], x[1, 0], x[2, 0]))
    return volume


@jit_lean
def _no_vec_lanes(x: np.ndarray) -> VecLanes:
    """Return zeros, in the precision of `x`."""
    zero = spread(x.dtype.type(0.0))
    return zero, zero, zero


@jit_lean
def _to_neighbour(neighbour: np.ndarray, e: int, x: np.ndarray, here: VecLanes) -> VecLanes:
    """Return the ways [m] from `here` to the neighbours at entries e … e + 7, of particles at `x` (3, n)."""
    there = (
        gather_lanes(x[0], neighbour, e),
        gather_lanes(x[1], neighbour, e),
        gather_lanes(x[2], neighbour, e),
    )
    return sub(there, here)


@jit_lean
def _tension(
    rings: VertexRings, springs: Springs, block: int, e: int, side: VecLanes, moving: tuple[np.ndarray, int]
) -> Lanes:
    """Return the forces of damped springs over their lengths [N/m], at entries e … e + 7, along `side` [m].

    `moving`: the velocities (3, n) [m/s] of all particles, and where the ways start.
    """
    if not springs.pull:
        return spread(rings.rest_tension.dtype.type(0.0))
    first, (velocity, here) = rings.block[block, STIFFNESS], moving
    k, rest_tension = spread(springs.stiffness), load_lanes(rings.rest_tension, e)
    if first >= 0:
        k = load_lanes(rings.stiffness, first + e - rings.block[block, ENTRY])
    square = dot(side, side)
    tension = k - rest_tension / square_root(square)
    if springs.damping > 0.0:
        parting = dot(_to_neighbour(rings.neighbour, e, velocity, load_vec_lanes(velocity, here)), side)
        tension = tension + springs.damping * parting / square
    return tension


class Load(NamedTuple):
    """What acts on one soft body besides springs, gas and gravity."""

    first: int  # its first row of VertexRings.particle
    drag: float  # [1/s]: a force of −drag m v
    force: np.ndarray  # (n, 3) [N] on each particle of all bodies, or (0, 3)


@jit_lean
def add_load(
    rings: VertexRings,
    load: Load,
    blocks: Blocks,
    inverse_mass: np.ndarray,
    moving: tuple[np.ndarray, np.ndarray],
) -> None:
    """Add drag and forces from outside to the pull [N] of the particles in `blocks`.

    `moving` are velocity [m/s] and pull, with a row for each component, by index; `inverse_mass` (n,).
    """
    velocity, pull = moving
    for block in range(blocks[0], blocks[1]):
        first, end = rings.block[block, FIRST], rings.block[block, END]
        if load.force.shape[0] > 0:
            for i in range(first, end):
                for c in range(3):
                    pull[c, i] += load.force[rings.particle[load.first + i], c]
        if load.drag > 0.0:
            for i in range(first, end):
                if inverse_mass[i] > 0.0:
                    for c in range(3):
                        pull[c, i] -= load.drag / inverse_mass[i] * velocity[c, i]
