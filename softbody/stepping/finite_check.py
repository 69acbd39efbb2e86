"""Checks that steps begin with finite numbers, and a checksum that shows whether somebody moved particles."""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.model.arrays import Controls, State


@jit_lean
def begins_finite(controls: Controls, state: State) -> bool:
    """Tell whether all positions, velocities and forces are finite."""
    particles = is_finite(state.particle_position) and is_finite(state.particle_velocity)
    forces = is_finite(controls.particle_force) and is_finite(controls.box_force) and is_finite(controls.box_torque)
    boxes = is_finite(state.box_position) and is_finite(state.box_orientation)
    return particles and forces and boxes and is_finite(state.box_velocity) and is_finite(state.box_angular_velocity)


@jit_lean
def is_finite(rows: np.ndarray) -> bool:
    """Tell whether all of `rows` (n, k) are finite: eight at a time."""
    numbers = rows.reshape(-1)
    spoiled = 0
    for i in range(numbers.shape[0]):
        spoiled |= int(not abs(numbers[i]) < np.inf)
    return spoiled == 0


# What is kept of the 64 bits of a number: 39, in which each of them shows, so that sums are the same in plain Python.
SHIFT, MASK = 29, 2**39 - 1


@jit_lean
def checksum(rows: np.ndarray) -> int:
    """Return a number that tells `rows` (n, k) from others, and from themselves in another order."""
    bits = rows.reshape(-1).view(np.int64)
    total = 0
    for i in range(bits.shape[0]):
        one = int(bits[i]) ^ (i * 2654435761)
        total += (one ^ (one >> SHIFT)) & MASK
    return total
