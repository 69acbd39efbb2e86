"""What force do springs and gas exert on every particle? The fast form: one pass over each particle's neighbours.

On a closed mesh the force of the gas on particle i is P/6 G_i with G_i = Σ (x_j − x_i) × (x_k − x_i) over the pairs
j, k of successive neighbours around it, and V = Σ x_i · G_i / 18. So springs, gas and volume come from one gathering
of the neighbours' coordinates, and nothing is scattered. Every sum has an order: the same bits every time.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.jit import arrays_do_not_overlap, jit_lean
from softbody.state import Rings

# Rows of the work array in which one body moves, by place: three each for x, y and z.
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


@jit_lean
def ring_sums(
    degree: tuple[int, ...],
    differ: tuple[int, ...],
    first: int,
    end: int,
    entry: int,
    neighbour: np.ndarray,
    common_stiffness: float,
    stiffness: np.ndarray,
    rest_pull: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    pull_x: np.ndarray,
    pull_y: np.ndarray,
    pull_z: np.ndarray,
    area_x: np.ndarray,
    area_y: np.ndarray,
    area_z: np.ndarray,
    moment: np.ndarray,
) -> None:
    """Overwrite pull [N], area (G, [m²]) and moment (x · G, [m³]) of the particles of one block, `first` … `end`.

    The lengths of two tuples, not their values, choose the machine code: that of `degree` is the number of
    neighbours, so that the loop over them is unrolled; `differ` is () where all springs have `common_stiffness`.
    `moment` is about the particle at place 0: about the origin, it would lose its digits far away. Components are
    written out, as LLVM vectorises this and not the same in tuples (12 against 19 ns).
    """
    arrays_do_not_overlap()
    if first < 0 or entry < 0:
        return  # never: it tells LLVM that no index is negative, so that it reads and writes rows in one piece
    count = end - first
    origin_x, origin_y, origin_z = x[0], y[0], z[0]
    for q in range(count):
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
        turn_x += before_y * start_z - before_z * start_y
        turn_y += before_z * start_x - before_x * start_z
        turn_z += before_x * start_y - before_y * start_x
        pull_x[i], pull_y[i], pull_z[i] = sum_x, sum_y, sum_z
        area_x[i], area_y[i], area_z[i] = turn_x, turn_y, turn_z
        moment[i] = (here_x - origin_x) * turn_x + (here_y - origin_y) * turn_y + (here_z - origin_z) * turn_z


@jit_lean
def any_ring_sums(
    first: int,
    end: int,
    degree: int,
    entry: int,
    behind: int,
    neighbour: np.ndarray,
    following: np.ndarray,
    stiffness: np.ndarray,
    rest_pull: np.ndarray,
    x: np.ndarray,
    pull: np.ndarray,
    area: np.ndarray,
    moment: np.ndarray,
) -> None:
    """Do the same for a block of any degree, where a particle's entries may be several cycles.

    `following`, from `behind` on, has the particle that comes next around the ring after each neighbour.
    """
    count = end - first
    for q in range(count):
        i = first + q
        sum_x = sum_y = sum_z = 0.0
        turn_x = turn_y = turn_z = 0.0
        for d in range(degree):
            e = entry + d * count + q
            j = neighbour[e]
            dx, dy, dz = x[0, j] - x[0, i], x[1, j] - x[1, i], x[2, j] - x[2, i]
            tension = stiffness[e] - rest_pull[e] / sqrt(dx * dx + dy * dy + dz * dz)
            sum_x += tension * dx
            sum_y += tension * dy
            sum_z += tension * dz
            j = following[behind + d * count + q]
            nx, ny, nz = x[0, j] - x[0, i], x[1, j] - x[1, i], x[2, j] - x[2, i]
            turn_x += dy * nz - dz * ny
            turn_y += dz * nx - dx * nz
            turn_z += dx * ny - dy * nx
        pull[0, i], pull[1, i], pull[2, i] = sum_x, sum_y, sum_z
        area[0, i], area[1, i], area[2, i] = turn_x, turn_y, turn_z
        moment[i] = (x[0, i] - x[0, 0]) * turn_x + (x[1, i] - x[1, 0]) * turn_y + (x[2, i] - x[2, 0]) * turn_z


@jit_lean
def ring_forces(
    rings: Rings,
    k: float,
    first_block: int,
    end_block: int,
    x: np.ndarray,
    pull: np.ndarray,
    area: np.ndarray,
    moment: np.ndarray,
    block_moment: np.ndarray,
) -> None:
    """Overwrite `pull` [N], `area` [m²] and `moment` [m³] of the particles in blocks `first_block` … `end_block`.

    The blocks are of one body, `k` [N/m] is the stiffness of its springs, NaN if they differ. `x` [m], `pull` and
    `area` have a row for each component; all by place. `block_moment` (blocks,) gets the sum over each block of
    `moment`; the sum over a body is 18 V.
    """
    nb, ks, rest = rings.neighbour, rings.stiffness, rings.rest_pull
    rx, ry, rz = x[0], x[1], x[2]
    px, py, pz = pull[0], pull[1], pull[2]
    gx, gy, gz = area[0], area[1], area[2]
    for c in range(first_block, end_block):
        first, end, degree = rings.block[c, 0], rings.block[c, 1], rings.block[c, 2]
        entry, behind = rings.block[c, 3], rings.block[c, 4]
        if behind >= 0:
            any_ring_sums(first, end, degree, entry, behind, nb, rings.following, ks, rest, x, pull, area, moment)
        elif k == k:
            if degree == 6:
                ring_sums(SIX, (), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
            elif degree == 5:
                ring_sums(FIVE, (), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
            elif degree == 7:
                ring_sums(SEVEN, (), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
            elif degree == 4:
                ring_sums(FOUR, (), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
            else:
                ring_sums(EIGHT, (), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
        elif degree == 6:
            ring_sums(SIX, (0,), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
        elif degree == 5:
            ring_sums(FIVE, (0,), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
        elif degree == 7:
            ring_sums(SEVEN, (0,), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
        elif degree == 4:
            ring_sums(FOUR, (0,), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
        else:
            ring_sums(EIGHT, (0,), first, end, entry, nb, k, ks, rest, rx, ry, rz, px, py, pz, gx, gy, gz, moment)
        block_moment[c] = sum_in_lanes(moment[first:end], end - first)


FOUR, FIVE, SIX, SEVEN, EIGHT = (0,) * 4, (0,) * 5, (0,) * 6, (0,) * 7, (0,) * 8


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


@jit_lean
def add_other_forces(
    rings: Rings,
    start: int,
    first_block: int,
    end_block: int,
    damping: float,
    drag: float,
    external_force: np.ndarray,
    inverse_mass: np.ndarray,
    x: np.ndarray,
    velocity: np.ndarray,
    pull: np.ndarray,
) -> None:
    """Add damping, drag and external forces to `pull` [N] of the particles in blocks `first_block` … `end_block`.

    `inverse_mass` (n,) [1/kg], `x` [m], `velocity` [m/s], with a row for each component, by place; `external_force`
    as of Model. A damped spring resists by `damping` [N s/m] times the speed at which its ends
    part; drag [1/s] is −`drag` m v. `start` is the first particle of the body.
    """
    for block in range(first_block, end_block):
        first, end, degree, entry, _ = rings.block[block]
        if external_force.shape[0] > 0:
            for i in range(first, end):
                for c in range(3):
                    pull[c, i] += external_force[rings.order[start + i], c]
        if drag > 0.0:
            for i in range(first, end):
                if inverse_mass[i] > 0.0:
                    for c in range(3):
                        pull[c, i] -= drag / inverse_mass[i] * velocity[c, i]
        if damping > 0.0:
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
                    share = damping * parting / (dx * dx + dy * dy + dz * dz)
                    pull[0, i] += share * dx
                    pull[1, i] += share * dy
                    pull[2, i] += share * dz
