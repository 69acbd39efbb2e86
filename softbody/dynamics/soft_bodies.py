"""Motion of all soft bodies over many steps, and which of them fails.

Between contacts the bodies do not know of each other: each is moved by all its steps at once, in a work array that
stays in the processor's cache.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np
from numba import prange

from softbody.compiler.jit import jit, jit_lean, jit_threaded
from softbody.compiler.simd import (
    LANES,
    first_lanes,
    gather_lanes,
    in_double,
    least_lane,
    load_lanes,
    spread,
    store_lanes,
    sum_of_lanes,
    where_less,
)
from softbody.dynamics.integrators import StepBatch, advance_body, advance_body_on_threads
from softbody.dynamics.one_ring_forces import (
    AREA,
    INVERSE_MASS,
    POSITION,
    PULL,
    SEEN,
    VELOCITY,
    WORK_ROWS,
    Forces,
    Load,
    Springs,
    add_load,
    ring_forces,
    volume_of_holes,
)
from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.stability import GROWTH
from softbody.dynamics.watch import Watch, nobody_watched, watch_of
from softbody.linalg.vec import load, store
from softbody.linalg.vec_lanes import gather_vec, load_vec_lanes, scatter_vec, store_vec_lanes
from softbody.model.arrays import END, FIRST, NUMBER, SoftBodies, VertexRings
from softbody.model.material import Material
from softbody.model.settings import Settings

# What is said of the soft body that stopped a run.
DIVERGED = 1
COLLAPSED = 2

# Steps between two looks at a body. The look costs a third of a step; a body that fails is taken back to the last
# look and from there step by step, so that the failing step is found all the same.
LOOK = 32

# Particles from which a body is worth all threads together: they meet eight times a step, which takes some
# microseconds each. Smaller bodies are shared out among the threads.
LARGE = 8_000

# Particles of a world below which one thread moves all: to wake another may take as long.
FEW = 800

# How far away a body may be, in its extents: farther off its shape is lost in rounding.
RESOLVED, RESOLVED_IN_SINGLE = 2.0**46, 2.0**20

BARE = Material(0.0, 0.0)  # where no ground acts


class MotionMemory(NamedTuple):
    """Memory for a run, worth keeping for the next: fresh memory costs a large body more than a step does."""

    position: np.ndarray  # (n, 3) [m] at the last good look, in the end of the next state
    velocity: np.ndarray  # (n, 3) [m/s]
    work: np.ndarray  # (threads, rows, particles of the largest body, and some), for one body at a time on each
    block_moment: np.ndarray  # (blocks,)
    done: np.ndarray  # (b,) steps that each body has done
    fault: np.ndarray  # (b,) DIVERGED, COLLAPSED or 0
    most_extent: np.ndarray  # (b,) [m] beyond which a body has diverged
    asleep: np.ndarray  # (b,) of bool: which are not moved
    stop: np.ndarray  # (1,) what is not 0 ends a run early; somebody else may write it


class Motion(NamedTuple):
    """What moves soft bodies, besides themselves: their rings, memory, and threads if there is more than one."""

    rings: VertexRings
    memory: MotionMemory
    watch: Watch  # whoever leaves its room there ends a run before
    threads: int | None  # None: one thread, for which nothing but the plain loop needs to be compiled


def motion_of(start: np.ndarray, rings: VertexRings, threads: int = 1, watched: np.ndarray | None = None) -> Motion:
    """Return what moves bodies whose first particles are `start` (b + 1,), in the precision of their rings.

    `watched` are the triangles (t, 3) of the only body, if it may be watched. In double precision rows are an odd
    number of cache lines long: rows a multiple of 4 096 bytes apart would evict each other.
    """
    largest = int(np.diff(rings.start).max(initial=0))
    memory = MotionMemory(
        np.empty((int(start[-1]), 3)),
        np.empty((int(start[-1]), 3)),
        np.empty((threads, WORK_ROWS, (largest + 15) // 16 * 16 + 8), rings.rest_tension.dtype),
        np.empty(len(rings.block)),
        np.zeros(len(start) - 1, np.int64),
        np.zeros(len(start) - 1, np.int64),
        np.full(len(start) - 1, np.inf),
        np.zeros(len(start) - 1, bool),
        np.zeros(1, np.uint8),
    )
    watch = nobody_watched(len(start) - 1) if watched is None else watch_of(rings, watched)
    return Motion(rings, memory, watch, None if threads == 1 else threads)


@jit
def move_soft_bodies(
    bodies: SoftBodies,
    motion: Motion | None,
    settings: Settings,
    h: float,
    steps: int,
    height: float = -np.inf,
    material: Material = BARE,
    abort_mid_step: bool = False,
) -> tuple[int, int, int]:
    """Advance the soft bodies alone by `steps` steps of `h` [s], each in sub-steps; return (steps done, fault, body).

    After each step, ground at `height` [m] stops what comes down; −inf: there is none, or it acts later. `material` is
    that of body and ground together.

    On a fault (DIVERGED or COLLAPSED, else 0) the bodies are where they are after the last good step of all. `motion`
    is None where there are none. Where `motion.memory.stop` is not 0, the run ends after one of the next steps, or in
    haste before one is done.
    """
    if motion is None or bodies.gas.shape[0] == 0:
        return steps, 0, -1
    rings, memory, watch, threads = motion
    fault, culprit = _move_all(
        bodies, rings, memory, watch, _batch(settings, h, steps, height, material, abort_mid_step), threads
    )
    least = memory.done.min() // settings.substeps
    while (memory.done != least * settings.substeps).any():
        # Once more, now that it is known how far all can go.
        steps = least
        _move_all(bodies, rings, memory, watch, _batch(settings, h, steps, height, material, False), threads)
        least = memory.done.min() // settings.substeps
        if least < steps:  # stopped before there was a fault
            fault, culprit = 0, -1
    steps = least
    for i in range(bodies.position.shape[0]):
        store(bodies.position, i, load(memory.position, i))
        store(bodies.velocity, i, load(memory.velocity, i))
    return steps, fault, culprit


@jit
def move_in_place(
    bodies: SoftBodies, motion: Motion | None, settings: Settings, h: float, abort_mid_step: bool
) -> tuple[int, int, int]:
    """Advance the soft bodies that are awake by one step of `h` [s] like `move_soft_bodies`, where there is no ground.

    With nothing in between: on a fault, or where no step is done, each is anywhere in it, and has to be put back.
    """
    if motion is None or bodies.gas.shape[0] == 0:
        return 1, 0, -1
    rings, memory, watch, threads = motion
    here = MotionMemory(
        bodies.position,
        bodies.velocity,
        memory.work,
        memory.block_moment,
        memory.done,
        memory.fault,
        memory.most_extent,
        memory.asleep,
        memory.stop,
    )
    fault, culprit = _move_all(
        bodies, rings, here, watch, _batch(settings, h, 1, -np.inf, BARE, abort_mid_step), threads
    )
    return memory.done.min() // settings.substeps, fault, culprit


@jit_lean
def _batch(
    settings: Settings, h: float, steps: int, height: float, material: Material, abort_mid_step: bool
) -> StepBatch:
    """Return `steps` steps of `h` [s] as a stretch of sub-steps, after each of which steps the ground acts."""
    substeps = settings.substeps
    e, mu = material
    return StepBatch(h / substeps, 0, steps * substeps, settings.integrator, substeps, height, e, mu, abort_mid_step)


@jit
def _move_all(
    bodies: SoftBodies, rings: VertexRings, memory: MotionMemory, watch: Watch, batch: StepBatch, threads: int | None
) -> tuple[int, int]:
    """Write to memory where all bodies are after a stretch of steps; return what stops the first one, and which it is.

    Bodies that fail are left where they are after their last good step; (0, −1): none does.
    """
    if threads is None or bodies.start[-1] < FEW:
        for body in range(bodies.gas.shape[0]):
            move_body(bodies, rings, memory, watch, batch, body, 0, None)
    else:
        move_on_threads(bodies, rings, memory, watch, batch, threads)
    culprit = int(np.argmin(memory.done))
    return (memory.fault[culprit], culprit) if memory.fault[culprit] else (0, -1)


@jit_threaded
def move_on_threads(
    bodies: SoftBodies, rings: VertexRings, memory: MotionMemory, watch: Watch, batch: StepBatch, threads: int
) -> None:
    """Move all bodies, the small ones side by side and each large one on all threads; see `_move_all`."""
    start = bodies.start
    for thread in prange(threads):
        for body in range(start.shape[0] - 1):
            # The thread on whose part of all particles the body's first one lies.
            if start[body] * threads // start[-1] == thread and start[body + 1] - start[body] < LARGE:
                move_body(bodies, rings, memory, watch, batch, body, thread, None)
    for body in range(start.shape[0] - 1):
        if start[body + 1] - start[body] >= LARGE:
            move_body(bodies, rings, memory, watch, batch, body, 0, threads)


@jit
def even_cut(rings: VertexRings, body: int, shares: int) -> np.ndarray:
    """Return where to cut the blocks of a body into `shares` of about as many particles each (shares + 1,)."""
    block = rings.block_start[body]
    end = rings.block_start[body + 1]
    cut = np.full(shares + 1, end)
    for share in range(shares):
        while block < end and rings.block[block, FIRST] * shares < rings.block[end - 1, END] * share:
            block += 1
        cut[share] = block
    return cut


@jit
def move_body(
    bodies: SoftBodies,
    rings: VertexRings,
    memory: MotionMemory,
    watch: Watch,
    batch: StepBatch,
    body: int,
    lane: int,
    threads: int | None,
) -> None:
    """Move one body in a `lane` of working memory, alone or on so many `threads`; note in memory how far it came."""
    if memory.asleep[body]:
        memory.done[body], memory.fault[body] = batch.steps, 0
        return
    work, number = memory.work[lane], rings.number[rings.start[body] : rings.start[body + 1]]
    _load_body(bodies, rings, body, work)
    cut = rings.block_start[body : body + 2] if threads is None else even_cut(rings, body, threads)
    least_volume = bodies.deflated_below[body] * bodies.mesh_volume[body]
    if bodies.boxes_volume[body] > 0.0:
        least_volume = max(least_volume, bodies.boxes_volume[body])
    done, fault, look, most = 0, 0, LOOK, memory.most_extent[body]
    h, _, steps, integrator, landing, height, restitution, friction, abort_mid_step = batch
    is_watched, has_left = watch.room[body] < inf, False
    if is_watched:
        _load_points(watch.seen, number, work[SEEN : SEEN + 3])
    while done < steps and fault == 0 and not has_left and (done == 0 or memory.stop[0] == 0 or done % landing != 0):
        part = StepBatch(
            h, done, min(look, steps - done), integrator, landing, height, restitution, friction, abort_mid_step
        )
        if threads is None:
            volume, made = advance_body(bodies, rings, body, part, cut, work, memory.block_moment, memory.stop, watch)
        else:
            volume, made = advance_body_on_threads(
                bodies, rings, body, part, cut, work, memory.block_moment, memory.stop, watch
            )
        is_torn = watch.is_torn[0]
        has_left = (is_watched and 0 <= made < part.steps) or is_torn
        if made <= 0:
            # Left in the midst of a step.
            if made < 0:
                done = 0
                _load_rows(bodies.position, bodies.velocity, number, work)
            break
        fault = find_fault(rings, body, work[POSITION : POSITION + 6], h, volume, least_volume, most)
        if fault == 0:
            done += made
            _store_rows(work, number, memory)
        else:
            # Back to the last look, and from there step by step.
            if done > 0:
                _load_rows(memory.position, memory.velocity, number, work)
            else:
                _load_rows(bodies.position, bodies.velocity, number, work)
            has_left = False
            if made > 1:
                fault, look = 0, 1
    if done == 0:
        _store_rows(work, number, memory)
    if is_watched:
        _store_points(work[SEEN : SEEN + 3], number, watch.seen)
    memory.done[body], memory.fault[body] = done, fault


@jit_lean
def _load_body(bodies: SoftBodies, rings: VertexRings, body: int, work: np.ndarray) -> None:
    """Copy inverse mass, position and velocity of each particle of a body into rows of `work`."""
    first, end = rings.start[body], rings.start[body + 1]
    for i in range(0, end - first, LANES):
        store_lanes(work[INVERSE_MASS], i, gather_lanes(bodies.inverse_mass, rings.particle, first + i))
    _load_rows(bodies.position, bodies.velocity, rings.number[first:end], work)


@jit_lean
def _load_rows(position: np.ndarray, velocity: np.ndarray, number: np.ndarray, work: np.ndarray) -> None:
    """Copy `position` and `velocity` (n, 3) into rows of `work`; `number` (s,) is the first of each particle."""
    _load_points(position, number, work[POSITION : POSITION + 3])
    _load_points(velocity, number, work[VELOCITY : VELOCITY + 3])


@jit_lean
def _load_points(points: np.ndarray, number: np.ndarray, rows: np.ndarray) -> None:
    """Copy `points` (n, 3) into `rows` (3, s); `number` (s,) is the first of each."""
    numbers = points.reshape(-1)
    for i in range(0, number.shape[0], LANES):
        store_vec_lanes(rows, i, gather_vec(numbers, number, i))


@jit_lean
def _store_rows(work: np.ndarray, number: np.ndarray, memory: MotionMemory) -> None:
    """Copy position and velocity of each particle from rows of `work` into memory; twins are the same."""
    _store_points(work[POSITION : POSITION + 3], number, memory.position)
    _store_points(work[VELOCITY : VELOCITY + 3], number, memory.velocity)


@jit_lean
def _store_points(rows: np.ndarray, number: np.ndarray, points: np.ndarray) -> None:
    """Copy `rows` (3, s) into `points` (n, 3); `number` (s,) is the first of each."""
    numbers = points.reshape(-1)
    for i in range(0, number.shape[0], LANES):
        scatter_vec(numbers, number, load_vec_lanes(rows, i), i)


@jit_lean
def find_fault(
    rings: VertexRings,
    body: int,
    rows: np.ndarray,
    h: float,
    volume: float,
    least_volume: float,
    most_extent: float = np.inf,
) -> int:
    """Return whether a body has DIVERGED or COLLAPSED, or 0; `rows` (6, n) of x and of v, by index.

    Diverged: some particle is not finite, or would cross its whole body in one more step, as seen from the body's
    mean velocity; or the body is longer than `most_extent` [m], along an axis, or so far away that it is lost in
    rounding. Collapsed: the volume [m³] is not above `least_volume`.
    """
    first, end = rings.block_start[body], rings.block_start[body + 1]
    extent, far, count = 0.0, 0.0, rings.start[body + 1] - rings.start[body]
    for c in range(3):
        low = high = in_double(load_lanes(rows[c], 0))
        for i in range(LANES, count, LANES):
            x = in_double(load_lanes(rows[c], i))
            low, high = where_less(x, low, x, low), where_less(high, x, x, high)
        highest, lowest = -least_lane(spread(0.0) - high), least_lane(low)
        extent, far = max(extent, highest - lowest), max(far, highest, -lowest)
    # Written so that NaN, for which every comparison is false, counts as diverged.
    if not (extent <= most_extent and far <= extent * (RESOLVED_IN_SINGLE if rows.itemsize == 4 else RESOLVED)):
        return DIVERGED
    if rings.hole_start[body + 1] > rings.hole_start[body]:
        extent = max(extent, most_extent / GROWTH)  # what has torn off may all meet in a point, and part again
    for c in range(3):
        total, number, least = spread(0.0), 0, spread(extent)
        for block in range(first, end):
            number += rings.block[block, NUMBER]
            for i in range(rings.block[block, FIRST], rings.block[block, END], LANES):
                counting = rings.block[block, FIRST] + rings.block[block, NUMBER] - i
                total = total + in_double(first_lanes(load_lanes(rows[3 + c], i), counting))
        mean = sum_of_lanes(total) / number
        for i in range(0, count, LANES):
            off = in_double(load_lanes(rows[3 + c], i)) - mean
            left = extent - h * where_less(off, 0.0, 0.0 - off, off)
            least = where_less(0.0, left, least, 0.0)
        if not least_lane(least) > 0.0:
            return DIVERGED
    if not abs(volume) < np.inf:
        return DIVERGED
    if volume <= least_volume:
        return COLLAPSED
    return 0


@jit
def ring_accelerations(bodies: SoftBodies, motion: Motion, acceleration: np.ndarray) -> None:
    """Overwrite `acceleration` (n, 3) [m/s²] with what the fast kernels make of positions and velocities.

    Everything counts: springs, gas, gravity, damping, drag, forces from outside, fixed particles.
    """
    rings, moments, work = motion.rings, motion.memory.block_moment, motion.memory.work[0]
    x, speed = work[POSITION : POSITION + 3], work[VELOCITY : VELOCITY + 3]
    pull, area = work[PULL : PULL + 3], work[AREA : AREA + 3]
    for body in range(bodies.gas.shape[0]):
        particle = rings.particle[rings.start[body] : rings.start[body + 1]]
        _load_body(bodies, rings, body, work)
        start, end = rings.block_start[body], rings.block_start[body + 1]
        springs = Springs(rings.common_stiffness[body], work.dtype.type(bodies.damping[body]), True)
        ring_forces(rings, springs, (start, end), Forces(x, speed, pull, area), moments)
        outside = Load(rings.start[body], bodies.drag[body], bodies.force)
        add_load(rings, outside, (start, end), work[INVERSE_MASS], (speed, pull))
        volume = moments[start:end].sum() / 18.0 + volume_of_holes(rings, body, x)
        push = gas_pressure(bodies.gas[body], volume - bodies.boxes_volume[body]) / 6.0
        for i in range(particle.shape[0]):
            inverse_mass = bodies.inverse_mass[particle[i]]
            for c in range(3):
                fall = bodies.gravity[c] if inverse_mass > 0.0 else 0.0
                acceleration[particle[i], c] = (pull[c, i] + push * area[c, i]) * inverse_mass + fall
