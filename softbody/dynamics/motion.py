"""How do all soft bodies move over many steps, and which of them fails?

Between contacts the bodies do not know of each other: each is moved by all its steps at once, in a work array that
stays in the processor's cache.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.dynamics.integrators import advance_body, copy_rows
from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.ring_forces import (
    AREA,
    MOMENT,
    POSITION,
    PULL,
    SAVED,
    VELOCITY,
    WORK_ROWS,
    add_other_forces,
    ring_forces,
    sum_in_lanes,
)
from softbody.jit import jit, jit_lean
from softbody.state import Model, State

# What is said of the soft body that stopped a run.
DIVERGED = 1
COLLAPSED = 2

# Steps between two looks at a body. The look costs a third of a step; a body that fails is taken back to the last
# look and from there step by step, so that the failing step is found all the same.
LOOK = 32


class Scratch(NamedTuple):
    """Memory for a run, worth keeping for the next: fresh memory costs a large body more than a step does."""

    position: np.ndarray  # (n, 3) of the next state
    velocity: np.ndarray  # (n, 3)
    work: np.ndarray  # (WORK_ROWS, particles of the largest body, and some), for one body at a time


def scratch_for(model: Model) -> Scratch:
    """Return memory for runs of this model.

    Rows are an odd number of cache lines long: rows a multiple of 4 096 bytes apart would evict each other.
    """
    count = len(model.inverse_mass)
    largest = int(np.diff(model.particle_start).max(initial=0))
    return Scratch(np.empty((count, 3)), np.empty((count, 3)), np.empty((WORK_ROWS, (largest + 15) // 16 * 16 + 8)))


@jit
def move_soft_bodies(
    model: Model,
    state: State,
    h: float,
    steps: int,
    integrator: int,
    scratch: Scratch,
) -> tuple[int, int, int]:
    """Write to `scratch` where all bodies are after `steps` steps of `h` [s].

    Returns (steps done, fault, body). On a fault (DIVERGED or COLLAPSED, else 0) that is fewer steps: as many as
    every body can do.
    """
    fault, culprit = 0, -1
    rounds = 1
    while rounds > 0:
        rounds -= 1
        for body in range(model.gas.shape[0]):
            done, failure = move_body(model, body, state, h, steps, integrator, scratch)
            if failure != 0:
                steps, fault, culprit = done, failure, body
                rounds = 1  # once more, now that it is known how far this body can go
                break
    return steps, fault, culprit


@jit
def move_body(
    model: Model,
    body: int,
    state: State,
    h: float,
    steps: int,
    integrator: int,
    scratch: Scratch,
) -> tuple[int, int]:
    """Do the same for one body; return (steps done, fault)."""
    work = scratch.work
    first = model.particle_start[body]
    count = model.particle_start[body + 1] - first
    order = model.rings.order[first : first + count]
    inverse_mass = np.empty(count)
    for i in range(count):
        inverse_mass[i] = model.inverse_mass[order[i]]
        for c in range(3):
            work[POSITION + c, i] = state.position[order[i], c]
            work[VELOCITY + c, i] = state.velocity[order[i], c]
    rows = work[POSITION : POSITION + 6]
    done, fault, look = 0, 0, LOOK
    while done < steps and fault == 0:
        stride = min(look, steps - done)
        copy_rows(work, POSITION, SAVED, count)
        volume = advance_body(model, body, h, stride, integrator, inverse_mass, work)
        fault = find_fault(rows, count, h, volume, model.least_volume[body])
        if fault == 0:
            done += stride
        else:
            copy_rows(work, SAVED, POSITION, count)
            if stride > 1:
                fault, look = 0, 1
    for i in range(count):
        for c in range(3):
            scratch.position[order[i], c] = work[POSITION + c, i]
            scratch.velocity[order[i], c] = work[VELOCITY + c, i]
    return done, fault


@jit_lean
def find_fault(rows: np.ndarray, count: int, h: float, volume: float, least_volume: float) -> int:
    """Return whether a body of `count` particles has DIVERGED or COLLAPSED, or 0; `rows` (6, n) of x and of v.

    Diverged: some particle is not finite, or would cross its whole body in one more step, as seen from the body's
    mean velocity. Collapsed: the volume [m³] is not above `least_volume`.
    """
    extent = 0.0
    for c in range(3):
        x = rows[c]
        low = high = x[0]
        for i in range(count):
            low = min(low, x[i])
            high = max(high, x[i])
        extent = max(extent, high - low)
    for c in range(3):
        v = rows[3 + c]
        mean = sum_in_lanes(v, count) / count
        for i in range(count):
            # Written so that NaN, for which every comparison is false, counts as diverged.
            if not h * abs(v[i] - mean) < extent:
                return DIVERGED
    if not abs(volume) < np.inf:
        return DIVERGED
    if volume <= least_volume:
        return COLLAPSED
    return 0


@jit
def ring_accelerations(
    model: Model, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, work: np.ndarray
) -> None:
    """Overwrite `acceleration` (n, 3) [m/s²] with what the fast kernels make of `position`, `velocity` (n, 3).

    Everything counts: springs, gas, gravity, damping, drag, external forces, pins. `work` as of Scratch.
    """
    for body in range(model.gas.shape[0]):
        first = model.particle_start[body]
        count = model.particle_start[body + 1] - first
        order = model.rings.order[first : first + count]
        for i in range(count):
            for c in range(3):
                work[POSITION + c, i] = position[order[i], c]
                work[VELOCITY + c, i] = velocity[order[i], c]
        x, speed = work[POSITION : POSITION + 3], work[VELOCITY : VELOCITY + 3]
        pull, area = work[PULL : PULL + 3], work[AREA : AREA + 3]
        volume = ring_forces(model.rings, body, count, x, pull, area, work[MOMENT])
        add_other_forces(model, body, x, speed, pull)
        push = gas_pressure(model.gas[body], volume) / 6.0
        for i in range(count):
            inverse_mass = model.inverse_mass[order[i]]
            for c in range(3):
                fall = model.gravity[c] if inverse_mass > 0.0 else 0.0
                acceleration[order[i], c] = (pull[c, i] + push * area[c, i]) * inverse_mass + fall
