"""What force do springs and gas exert on every particle? The fast form: one pass over each particle's neighbours.

On a closed mesh the force of the gas on particle i is P/6 G_i with G_i = Σ (x_j − x_i) × (x_k − x_i) over the pairs
j, k of successive neighbours around it, and V = Σ x_i · G_i / 18. So springs, gas and volume come from one gathering
of the neighbours' coordinates, and nothing is scattered. Every sum has an order: the same bits every time.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import literal_unroll

from softbody.jit import arrays_do_not_overlap, jit_lean
from softbody.state import VertexRings

# Rows of the work array in which one body moves, by index: three each for x, y and z.
POSITION = 0  # [m]; velocities follow positions
VELOCITY = 3  # [m/s]
NEXT_POSITION = 6  # [m] of a stage, in the end of the step
NEXT_VELOCITY = 9  # [m/s²] a weighted sum of accelerations, in the end the velocity [m/s]
PULL = 12  # [N] of the springs, and of everything else but gas and gravity
AREA = 15  # G [m²]
MOMENT = 18  # x · G [m³], one row
STAGE_VELOCITY = 19  # [m/s] for rk4, and where something damps
SHIFT = 22  # [m/s²] sum over the stages, for rk4
SAVED = 25  # position and velocity of the last good step, six rows
INVERSE_MASS = 31  # [1/kg], one row
WORK_ROWS = 32

LANES = 8  # partial sums of a long sum

Blocks = tuple[int, int]  # first and end
Components = tuple[np.ndarray, np.ndarray, np.ndarray]  # rows of x, y and z


class Forces(NamedTuple):
    """What a pass over the rings reads and writes, by index."""

    position: np.ndarray  # (3, n) [m]
    pull: np.ndarray  # (3, n) [N]
    area: np.ndarray  # (3, n) G [m²]
    moment: np.ndarray  # (n,) x · G [m³]; the sum over a body is 18 V


@jit_lean
def ring_forces(rings: VertexRings, k: float, blocks: Blocks, forces: Forces, block_moment: np.ndarray) -> None:
    """Overwrite pull, area and moment of the particles in `blocks`.

    They are of one body, `k` [N/m] is the stiffness of its springs, NaN if they differ. `block_moment` (blocks,) gets
    the sum of the moments of each block.
    """
    position, pull, area, moment = forces
    x, pulls = (position[0], position[1], position[2]), (pull[0], pull[1], pull[2])
    areas = area[0], area[1], area[2]
    for block in range(blocks[0], blocks[1]):
        first, end, degree = rings.block[block, 0], rings.block[block, 1], rings.block[block, 2]
        if rings.block[block, 4] >= 0:
            _any_ring_sums(rings, block, forces)
        else:
            # One kernel for each degree, and each of equal or different springs.
            part = first, end, rings.block[block, 3]
            for unrolled in literal_unroll(DEGREES):
                if len(unrolled) == degree:
                    if k == k:
                        ring_sums(unrolled, (), part, k, rings, (x, pulls, areas, moment))
                    else:
                        ring_sums(unrolled, (0,), part, k, rings, (x, pulls, areas, moment))
        block_moment[block] = sum_in_lanes(moment[first:end], end - first)


DEGREES = ((0,) * 6, (0,) * 5, (0,) * 7, (0,) * 4, (0,) * 8)  # the most frequent first


@jit_lean
def ring_sums(
    degree: tuple[int, ...],
    differ: tuple[int, ...],
    part: tuple[int, int, int],
    common_stiffness: float,
    rings: VertexRings,
    rows: tuple[Components, Components, Components, np.ndarray],
) -> None:
    """Overwrite pull [N], area (G, [m²]) and moment (x · G, [m³]) of the particles of one block.

    `part` is its first index, its end and its first entry in the `rings`, `rows` are x, pull, area and moment.
    The lengths of two tuples, not their values, choose the machine code: that of `degree` is the number of
    neighbours, so that the loop over them is unrolled; `differ` is () where all springs have `common_stiffness`.
    The moment is about the particle at index 0: about the origin, it would lose its digits far away. Components are
    written out, as LLVM vectorises this and not the same in tuples (12 against 19 ns).
    """
    arrays_do_not_overlap()
    first, end, entry = part
    if first < 0 or entry < 0:
        return  # never: it tells LLVM that no index is negative, so that it reads and writes rows in one piece
    (x, y, z), (pull_x, pull_y, pull_z), (area_x, area_y, area_z), moment = rows
    neighbour, stiffness, rest_pull = rings.neighbour, rings.stiffness, rings.rest_pull
    count = end - first
    origin_x, origin_y, origin_z = x[0], y[0], z[0]
    for q in range(count):
        # The first neighbour: its spring, and where the ring starts.
        i = first + q
        here_x, here_y, here_z = x[i], y[i], z[i]
        e = entry + q
        j = neighbour[e]
        start_x, start_y, start_z = x[j] - here_x, y[j] - here_y, z[j] - here_z
        k = stiffness[e] if len(differ) else common_stiffness
        tension = k - rest_pull[e] / sqrt(start_x * start_x + start_y * start_y + start_z * start_z)
        sum_x, sum_y, sum_z = tension * start_x, tension * start_y, tension * start_z
        before_x, before_y, before_z = start_x, start_y, start_z
        turn_x = turn_y = turn_z = x.dtype.type(0.0)
        # The others: their springs, and the triangle with the neighbour before.
        for d in range(1, len(degree)):
            e = entry + d * count + q
            j = neighbour[e]
            dx, dy, dz = x[j] - here_x, y[j] - here_y, z[j] - here_z
            k = stiffness[e] if len(differ) else common_stiffness
            tension = k - rest_pull[e] / sqrt(dx * dx + dy * dy + dz * dz)
            sum_x += tension * dx
            sum_y += tension * dy
            sum_z += tension * dz
            turn_x += before_y * dz - before_z * dy
            turn_y += before_z * dx - before_x * dz
            turn_z += before_x * dy - before_y * dx
            before_x, before_y, before_z = dx, dy, dz
        # The triangle that closes the ring.
        turn_x += before_y * start_z - before_z * start_y
        turn_y += before_z * start_x - before_x * start_z
        turn_z += before_x * start_y - before_y * start_x
        pull_x[i], pull_y[i], pull_z[i] = sum_x, sum_y, sum_z
        area_x[i], area_y[i], area_z[i] = turn_x, turn_y, turn_z
        moment[i] = (here_x - origin_x) * turn_x + (here_y - origin_y) * turn_y + (here_z - origin_z) * turn_z


@jit_lean
def _any_ring_sums(rings: VertexRings, block: int, forces: Forces) -> None:
    """Do the same for a block of any degree, where a particle's entries may be several cycles."""
    x, pull, area, moment = forces
    first, end, degree = rings.block[block, 0], rings.block[block, 1], rings.block[block, 2]
    entry, behind = rings.block[block, 3], rings.block[block, 4]
    neighbour, next_neighbour = rings.neighbour, rings.next_neighbour
    count = end - first
    for q in range(count):
        i = first + q
        sum_x = sum_y = sum_z = 0.0
        turn_x = turn_y = turn_z = 0.0
        for d in range(degree):
            # The spring.
            e = entry + d * count + q
            j = neighbour[e]
            dx, dy, dz = x[0, j] - x[0, i], x[1, j] - x[1, i], x[2, j] - x[2, i]
            tension = rings.stiffness[e] - rings.rest_pull[e] / sqrt(dx * dx + dy * dy + dz * dz)
            sum_x += tension * dx
            sum_y += tension * dy
            sum_z += tension * dz
            # The triangle with the neighbour that comes next.
            j = next_neighbour[behind + d * count + q]
            nx, ny, nz = x[0, j] - x[0, i], x[1, j] - x[1, i], x[2, j] - x[2, i]
            turn_x += dy * nz - dz * ny
            turn_y += dz * nx - dx * nz
            turn_z += dx * ny - dy * nx
        pull[0, i], pull[1, i], pull[2, i] = sum_x, sum_y, sum_z
        area[0, i], area[1, i], area[2, i] = turn_x, turn_y, turn_z
        moment[i] = (x[0, i] - x[0, 0]) * turn_x + (x[1, i] - x[1, 0]) * turn_y + (x[2, i] - x[2, 0]) * turn_z


@jit_lean
def sum_in_lanes(values: np.ndarray, count: int) -> float:
    """Return the sum of the first `count` of `values` (n,): in double precision, eight partial sums side by side."""
    a = b = c = d = e = f = g = h = 0.0
    whole = count // LANES * LANES
    for i in range(0, whole, LANES):
        a += values[i]
        b += values[i + 1]
        c += values[i + 2]
        d += values[i + 3]
        e += values[i + 4]
        f += values[i + 5]
        g += values[i + 6]
        h += values[i + 7]
    for i in range(whole, count):
        a += values[i]
    return ((a + b) + (c + d)) + ((e + f) + (g + h))


class Load(NamedTuple):
    """What acts on one soft body besides springs, gas and gravity."""

    first: int  # its first particle
    damping: float  # [N s/m] of its springs, against the speed at which their ends part
    drag: float  # [1/s]: a force of −drag m v
    force: np.ndarray  # (n, 3) [N] on each particle of all bodies, or (0, 3)


@jit_lean
def add_load(
    rings: VertexRings,
    load: Load,
    blocks: Blocks,
    inverse_mass: np.ndarray,
    moving: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    """Add damping, drag and forces from outside to the pull [N] of the particles in `blocks`.

    `moving` are position [m], velocity [m/s] and pull, with a row for each component, by index; `inverse_mass` (n,).
    """
    x, velocity, pull = moving
    for block in range(blocks[0], blocks[1]):
        first, end, degree, entry, _ = rings.block[block]
        if load.force.shape[0] > 0:
            for i in range(first, end):
                for c in range(3):
                    pull[c, i] += load.force[rings.particle[load.first + i], c]
        if load.drag > 0.0:
            for i in range(first, end):
                if inverse_mass[i] > 0.0:
                    for c in range(3):
                        pull[c, i] -= load.drag / inverse_mass[i] * velocity[c, i]
        if load.damping > 0.0:
            # Against the speed at which the ends of each spring part.
            count = end - first
            for q in range(count):
                i = first + q
                for d in range(degree):
                    j = rings.neighbour[entry + d * count + q]
                    dx, dy, dz = x[0, j] - x[0, i], x[1, j] - x[1, i], x[2, j] - x[2, i]
                    parting = (
                        (velocity[0, j] - velocity[0, i]) * dx
                        + (velocity[1, j] - velocity[1, i]) * dy
                        + (velocity[2, j] - velocity[2, i]) * dz
                    )
                    share = load.damping * parting / (dx * dx + dy * dy + dz * dz)
                    pull[0, i] += share * dx
                    pull[1, i] += share * dy
                    pull[2, i] += share * dz
