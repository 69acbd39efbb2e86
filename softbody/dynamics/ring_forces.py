"""What force do springs and gas exert on every particle? The fast form: one pass over each particle's neighbours.

On a closed mesh the force of the gas on particle i is P/6 G_i with G_i = Σ (x_j − x_i) × (x_k − x_i) over the pairs
j, k of successive neighbours around it, and V = Σ x_i · G_i / 18. So springs, gas and volume come from one gathering
of the neighbours' coordinates, and nothing is scattered. Every sum has an order: the same bits every time.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.jit import arrays_do_not_overlap, compile_apart, jit
from softbody.state import Model

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
WORK_ROWS = 31

LANES = 8  # partial sums of a long sum


@jit
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
        turn_x = turn_y = turn_z = 0.0
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


@jit
def any_ring_sums(model: Model, block: int, at: int, work: np.ndarray) -> None:
    """Do the same for a block of any degree, where a particle's entries may be several cycles.

    Positions [m] are the rows `at` … `at` + 2 of `work`; the sums go to its rows PULL, AREA and MOMENT.
    """
    compile_apart()
    rows = work[at : at + 3]
    first, end, degree, entry, behind = model.rings.block[block]
    count = end - first
    for q in range(count):
        i = first + q
        sum_x = sum_y = sum_z = 0.0
        turn_x = turn_y = turn_z = 0.0
        for d in range(degree):
            e = entry + d * count + q
            j = model.rings.neighbour[e]
            dx, dy, dz = rows[0, j] - rows[0, i], rows[1, j] - rows[1, i], rows[2, j] - rows[2, i]
            length = sqrt(dx * dx + dy * dy + dz * dz)
            tension = model.rings.stiffness[e] - model.rings.rest_pull[e] / length
            sum_x += tension * dx
            sum_y += tension * dy
            sum_z += tension * dz
            j = model.rings.following[behind + d * count + q]
            nx, ny, nz = rows[0, j] - rows[0, i], rows[1, j] - rows[1, i], rows[2, j] - rows[2, i]
            turn_x += dy * nz - dz * ny
            turn_y += dz * nx - dx * nz
            turn_z += dx * ny - dy * nx
        work[PULL, i], work[PULL + 1, i], work[PULL + 2, i] = sum_x, sum_y, sum_z
        work[AREA, i], work[AREA + 1, i], work[AREA + 2, i] = turn_x, turn_y, turn_z
        work[MOMENT, i] = (
            (rows[0, i] - rows[0, 0]) * turn_x + (rows[1, i] - rows[1, 0]) * turn_y + (rows[2, i] - rows[2, 0]) * turn_z
        )


@jit
def ring_forces(model: Model, body: int, at: int, work: np.ndarray) -> float:
    """Overwrite the rows PULL and AREA of `work` for one body; return its volume [m³].

    Its positions [m] by place are the rows `at` … `at` + 2 of `work`.
    """
    compile_apart()
    rings = model.rings
    common = rings.common_stiffness[body]
    x, y, z = work[at], work[at + 1], work[at + 2]
    px, py, pz = work[PULL], work[PULL + 1], work[PULL + 2]
    gx, gy, gz, m = work[AREA], work[AREA + 1], work[AREA + 2], work[MOMENT]
    nb, ks, rest = rings.neighbour, rings.stiffness, rings.rest_pull
    for c in range(rings.block_start[body], rings.block_start[body + 1]):
        first, end, degree, entry, behind = rings.block[c]
        if behind >= 0:
            any_ring_sums(model, c, at, work)
        elif common == common:
            if degree == 6:
                ring_sums(SIX, (), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
            elif degree == 5:
                ring_sums(FIVE, (), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
            elif degree == 7:
                ring_sums(SEVEN, (), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
            elif degree == 4:
                ring_sums(FOUR, (), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
            else:
                ring_sums(EIGHT, (), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
        elif degree == 6:
            ring_sums(SIX, (0,), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
        elif degree == 5:
            ring_sums(FIVE, (0,), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
        elif degree == 7:
            ring_sums(SEVEN, (0,), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
        elif degree == 4:
            ring_sums(FOUR, (0,), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
        else:
            ring_sums(EIGHT, (0,), first, end, entry, nb, common, ks, rest, x, y, z, px, py, pz, gx, gy, gz, m)
    return sum_in_lanes(m, model.particle_start[body + 1] - model.particle_start[body]) / 18.0


FOUR, FIVE, SIX, SEVEN, EIGHT = (0,) * 4, (0,) * 5, (0,) * 6, (0,) * 7, (0,) * 8


@jit
def sum_in_lanes(values: np.ndarray, count: int) -> float:
    """Return the sum of the first `count` of `values` (n,), in eight partial sums that run side by side."""
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


@jit
def add_other_forces(model: Model, body: int, at: int, velocity_at: int, work: np.ndarray) -> None:
    """Add damping, drag and external forces to the rows PULL of `work`.

    Positions [m] are its rows from `at` on, velocities [m/s] from `velocity_at` on. A damped spring
    resists by `damping` [N s/m] times the speed at which its ends part; drag is −`drag` m v.
    """
    compile_apart()
    rows, velocity = work[at : at + 3], work[velocity_at : velocity_at + 3]
    start = model.particle_start[body]
    rings = model.rings
    if model.external_force.shape[0] > 0:
        for i in range(model.particle_start[body + 1] - start):
            for c in range(3):
                work[PULL + c, i] += model.external_force[rings.order[start + i], c]
    drag = model.drag[body]
    if drag > 0.0:
        for i in range(model.particle_start[body + 1] - start):
            inverse_mass = model.inverse_mass[rings.order[start + i]]
            if inverse_mass > 0.0:
                for c in range(3):
                    work[PULL + c, i] -= drag / inverse_mass * velocity[c, i]
    damping = model.damping[body]
    if damping > 0.0:
        for block in range(rings.block_start[body], rings.block_start[body + 1]):
            first, end, degree, entry, _ = rings.block[block]
            count = end - first
            for q in range(count):
                i = first + q
                for d in range(degree):
                    j = rings.neighbour[entry + d * count + q]
                    dx, dy, dz = rows[0, j] - rows[0, i], rows[1, j] - rows[1, i], rows[2, j] - rows[2, i]
                    parting = (
                        (velocity[0, j] - velocity[0, i]) * dx
                        + (velocity[1, j] - velocity[1, i]) * dy
                        + (velocity[2, j] - velocity[2, i]) * dz
                    )
                    share = damping * parting / (dx * dx + dy * dy + dz * dz)
                    work[PULL, i] += share * dx
                    work[PULL + 1, i] += share * dy
                    work[PULL + 2, i] += share * dz
