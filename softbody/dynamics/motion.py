"""How do all soft bodies move over many steps, and which of them fails?

Between contacts the bodies do not know of each other: each is moved by all its steps at once, in a work array that
stays in the processor's cache.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from softbody.dynamics.integrators import advance_body, advance_body_on_threads, copy_rows
from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.ring_forces import (
    AREA,
    INVERSE_MASS,
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
from softbody.jit import jit, jit_lean, jit_threaded
from softbody.state import Model, Rings, State

# What is said of the soft body that stopped a run.
DIVERGED = 1
COLLAPSED = 2

# Steps between two looks at a body. The look costs a third of a step; a body that fails is taken back to the last
# look and from there step by step, so that the failing step is found all the same.
LOOK = 32

# Particles from which a body is worth all threads together: they meet eight times a step, which takes some
# microseconds each. Smaller bodies are shared out among the threads.
LARGE = 8_000


class Scratch(NamedTuple):
    """Memory for a run, worth keeping for the next: fresh memory costs a large body more than a step does."""

    position: np.ndarray  # (n, 3) of the next state
    velocity: np.ndarray  # (n, 3)
    work: np.ndarray  # (threads, WORK_ROWS, particles of the largest body, and some), for one body at a time on each
    block_moment: np.ndarray  # (blocks,)


def scratch_for(model: Model, rings: Rings, threads: int = 1) -> Scratch:
    """Return memory for runs of this model, whose rings these are, in their precision.

    Rows are an odd number of cache lines long: rows a multiple of 4 096 bytes apart would evict each other.
    """
    count = len(model.inverse_mass)
    largest = int(np.diff(model.particle_start).max(initial=0))
    return Scratch(
        np.empty((count, 3)),
        np.empty((count, 3)),
        np.empty((threads, WORK_ROWS, (largest + 15) // 16 * 16 + 8), rings.stiffness.dtype),
        np.empty(len(rings.block)),
    )


@jit
def move_soft_bodies(
    model: Model,
    rings: Rings,
    state: State,
    h: float,
    steps: int,
    integrator: int,
    scratch: Scratch,
    threads: int | None,
) -> tuple[int, int, int]:
    """Write to `scratch` where all bodies are after `steps` steps of `h` [s]; `threads` as of `run`.

    Returns (steps done, fault, body). On a fault (DIVERGED or COLLAPSED, else 0) that is fewer steps: as many as
    every body can do.
    """
    bodies = model.gas.shape[0]
    done, fault = np.full(bodies, steps), np.zeros(bodies, np.int64)
    failure, culprit = 0, -1
    for _ in range(2):
        if threads is None:
            for body in range(bodies):
                cut, work = rings.block_start[body : body + 2], scratch.work[0]
                one = move_body(model, rings, body, state, h, steps, integrator, scratch, cut, work, None)
                done[body], fault[body] = one
        else:
            move_on_threads(model, rings, state, h, steps, integrator, scratch, threads, done, fault)
        if not fault.any():
            break
        # Once more, now that it is known how far all can go.
        culprit = int(np.argmin(done))
        steps, failure = done[culprit], fault[culprit]
    return steps, failure, culprit


@jit_threaded
def move_on_threads(
    model: Model,
    rings: Rings,
    state: State,
    h: float,
    steps: int,
    integrator: int,
    scratch: Scratch,
    threads: int,
    done: np.ndarray,
    fault: np.ndarray,
) -> None:
    """Move all bodies, the small ones side by side and each large one on all threads; see move_soft_bodies."""
    start = model.particle_start
    for thread in prange(threads):
        for body in range(start.shape[0] - 1):
            # The thread on whose part of all particles the body's first one lies.
            if start[body] * threads // start[-1] == thread and start[body + 1] - start[body] < LARGE:
                cut, work = rings.block_start[body : body + 2], scratch.work[thread]
                one = move_body(model, rings, body, state, h, steps, integrator, scratch, cut, work, None)
                done[body], fault[body] = one
    for body in range(start.shape[0] - 1):
        if start[body + 1] - start[body] >= LARGE:
            cut, work = even_cut(rings, body, threads), scratch.work[0]
            one = move_body(model, rings, body, state, h, steps, integrator, scratch, cut, work, threads)
            done[body], fault[body] = one


@jit
def even_cut(rings: Rings, body: int, shares: int) -> np.ndarray:
    """Return where to cut the blocks of a body into `shares` of about as many particles each (shares + 1,)."""
    block = rings.block_start[body]
    end = rings.block_start[body + 1]
    cut = np.full(shares + 1, end)
    for share in range(shares):
        while block < end and rings.block[block, 0] * shares < rings.block[end - 1, 1] * share:
            block += 1
        cut[share] = block
    return cut


@jit
def move_body(
    model: Model,
    rings: Rings,
    body: int,
    state: State,
    h: float,
    steps: int,
    integrator: int,
    scratch: Scratch,
    cut: np.ndarray,
    work: np.ndarray,
    threads: int | None,
) -> tuple[int, int]:
    """Move one body, its blocks in shares that are cut at `cut`; return (steps done, fault)."""
    first = model.particle_start[body]
    count = model.particle_start[body + 1] - first
    order = rings.order[first : first + count]
    for i in range(count):
        work[INVERSE_MASS, i] = model.inverse_mass[order[i]]
        for c in range(3):
            work[POSITION + c, i] = state.position[order[i], c]
            work[VELOCITY + c, i] = state.velocity[order[i], c]
    rows = work[POSITION : POSITION + 6]
    moments = scratch.block_moment
    done, fault, look = 0, 0, LOOK
    while done < steps and fault == 0:
        stride = min(look, steps - done)
        copy_rows(work, POSITION, SAVED, count)
        if threads is None:
            volume = advance_body(model, rings, body, h, stride, integrator, cut, work, moments)
        else:
            volume = advance_body_on_threads(model, rings, body, h, stride, integrator, cut, work, moments)
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
    model: Model, rings: Rings, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, scratch: Scratch
) -> None:
    """Overwrite `acceleration` (n, 3) [m/s²] with what the fast kernels make of `position`, `velocity` (n, 3).

    Everything counts: springs, gas, gravity, damping, drag, external forces, pins.
    """
    work = scratch.work[0]
    for body in range(model.gas.shape[0]):
        first = model.particle_start[body]
        count = model.particle_start[body + 1] - first
        order = rings.order[first : first + count]
        for i in range(count):
            for c in range(3):
                work[POSITION + c, i] = position[order[i], c]
                work[VELOCITY + c, i] = velocity[order[i], c]
        x, speed = work[POSITION : POSITION + 3], work[VELOCITY : VELOCITY + 3]
        pull, area = work[PULL : PULL + 3], work[AREA : AREA + 3]
        start, end = rings.block_start[body], rings.block_start[body + 1]
        k, moments = rings.common_stiffness[body], scratch.block_moment
        ring_forces(rings, k, start, end, x, pull, area, work[MOMENT], moments)
        for i in range(count):
            work[INVERSE_MASS, i] = model.inverse_mass[order[i]]
        damping, drag, force = model.damping[body], model.drag[body], model.external_force
        add_other_forces(rings, first, start, end, damping, drag, force, work[INVERSE_MASS], x, speed, pull)
        push = gas_pressure(model.gas[body], moments[start:end].sum() / 18.0) / 6.0
        for i in range(count):
            inverse_mass = model.inverse_mass[order[i]]
            for c in range(3):
                fall = model.gravity[c] if inverse_mass > 0.0 else 0.0
                acceleration[order[i], c] = (pull[c, i] + push * area[c, i]) * inverse_mass + fall
