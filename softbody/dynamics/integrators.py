"""Integrators of the particles over a step: symplectic Euler, classical Runge–Kutta, and the paper's scheme.

On x'' = −ω² x (ω h = z): `symplectic_euler`, the default, is of order 1, stable to z = 2, and loses nothing; `rk4` is
of order 4 and stable to z = 2√2; `rk4_velocity`, the paper's, is of order 1, stable to z = 2, and loses z²/4 of the
amplitude a step. A step is a few stages, and a stage the force on all particles, by index
(softbody/dynamics/one_ring_forces.py), then one of the updates below. Everything is computed in the precision of the
arrays.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np
from numba import prange

from softbody.compiler.jit import jit_lean, jit_threaded
from softbody.compiler.simd import LANES, Lanes, load_lanes, store_lanes, where_less
from softbody.dynamics.one_ring_forces import (
    AREA,
    INVERSE_MASS,
    NEXT_POSITION,
    POSITION,
    PULL,
    SEEN,
    SHIFT,
    STAGE_VELOCITY,
    Forces,
    Load,
    Springs,
    add_load,
    ring_forces,
    volume_of_holes,
)
from softbody.dynamics.particle_ground import land
from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.watch import Watch, room_of_springs, stays_in_room
from softbody.geometry.drift import drift_of_rows
from softbody.model.arrays import END, FIRST, SoftBodies, VertexRings
from softbody.model.material import Material
from softbody.model.settings import RK4, RK4_VELOCITY, SYMPLECTIC_EULER

STAGES = (4, 4, 1)  # forces a step, by the number of the integrator
STABILITY_LIMIT = (2.0, 2.0 * 2.0**0.5, 2.0)  # ω h, likewise


class StepBatch(NamedTuple):
    """So many steps of so long, by one integrator; on the way the ground, if there is one, stops what comes down."""

    h: float  # [s]
    begin: int  # steps that were done before
    steps: int
    integrator: int
    landing: int  # the ground acts after every so many steps
    height: float  # of the ground [m]; −inf: there is none
    restitution: float  # of body and ground together, as is the
    friction: float
    abort_mid_step: bool  # where it is to end early, that is in the midst of a step, which then has not happened


class StageRows(NamedTuple):
    """What an update reads and writes, by index: a row for each component."""

    pull: np.ndarray  # (3, n) [N]; with the area it makes the force pull + P/6 area
    area: np.ndarray  # (3, n) [m²]
    inverse_mass: np.ndarray  # (n,) [1/kg]
    start: np.ndarray  # (6, n) positions, then velocities, at the start of the step
    end: np.ndarray  # (6, n) at its end
    velocity: np.ndarray  # (3, n) [m/s] of the stage, for rk4 and where something damps
    shift: np.ndarray  # (3, n) [m/s²] sum over the stages, for rk4
    gravity: np.ndarray  # (3,) [m/s²]


class StageCoefficients(NamedTuple):
    """The numbers of one stage, in the precision of the arrays."""

    stage: int
    push: float  # [Pa] a sixth of the pressure
    lead: float  # [s] how far the stage looks ahead: half the step or, in the last two, all of it
    sixth: float  # [s] of the step
    damped: bool  # something reads the velocity of the next stage


Part = tuple[int, int]  # first index and end, whole lanes


def _advance_body(
    bodies: SoftBodies, rings: VertexRings, body: int, batch: StepBatch, cut: np.ndarray, work: np.ndarray,
    block_moment: np.ndarray, stop: np.ndarray, watch: Watch,
) -> tuple[float, int]:  # fmt: skip
    """Advance one body by a stretch of steps in the rows POSITION and VELOCITY of `work` (WORK_ROWS, n).

    Its blocks are done in shares, of which share i has blocks cut[i] … cut[i + 1]; they write to places of their own,
    so that the result is the same for any `cut`. `block_moment` (blocks,) is scratch. Returns the least volume [m³]
    of all starts of steps and of the end (NaN if one is NaN), and how many steps were made: where `stop` (1,) is not 0,
    only those to the next landing. Where particles leave their room in a step, those before are made; where a spring
    goes beyond its limit, that step, too. In haste a step that follows a landing is left at once, with the rows where
    it began; and so are all before the first landing, but then the rows are scratch: −1.
    """
    h, steps, integrator = batch.h, batch.steps, batch.integrator
    one, other = work[POSITION : POSITION + 6], work[NEXT_POSITION : NEXT_POSITION + 6]
    pull, area = work[PULL : PULL + 3], work[AREA : AREA + 3]
    velocity, shift, inverse_mass = (
        work[STAGE_VELOCITY : STAGE_VELOCITY + 3],
        work[SHIFT : SHIFT + 3],
        work[INVERSE_MASS],
    )
    # What a thread is handed it unpacks each time: here are the few fields that count.
    gravity, load = bodies.gravity, Load(rings.start[body], bodies.drag[body], bodies.force)
    real, stages, least = work.dtype.type, STAGES[integrator], np.inf
    k, damping = rings.common_stiffness[body], real(bodies.damping[body])
    seen, count = work[SEEN : SEEN + 3], rings.block[cut[-1] - 1, END]
    limited, room = watch.square.shape[0] > 0, -1.0  # [m] to drift from where it was seen: not known yet
    damped, loaded = damping > 0.0 or load.drag > 0.0, load.drag > 0.0 or load.force.shape[0] > 0
    # One call of the force, for the stages of all steps and for the volume at the end: machine code for it is made
    # for every place that it is called from.
    for turn in range(stages * batch.steps + 1):
        step = turn // stages
        stage = turn - step * stages
        # Each step starts where the one before ended: the two sets of rows change places.
        start, end = (one, other) if step % 2 == 0 else (other, one)
        x, v = (start, start[3:]) if stage == 0 else (end, velocity)
        is_done = step == batch.steps  # only the volume counts
        for share in prange(cut.shape[0] - 1):
            blocks = cut[share], cut[share + 1]
            ring_forces(rings, Springs(k, damping, not is_done), blocks, Forces(x, v, pull, area), block_moment)
            if loaded and not is_done:
                add_load(rings, load, blocks, inverse_mass, (v, pull))
        # The volume, and with it the pressure.
        volume = 0.0
        for block in range(cut[0], cut[-1]):
            volume += block_moment[block]
        volume = volume / 18.0 + volume_of_holes(rings, body, x)
        if stage == 0 and not volume >= least:  # so that NaN stays
            least = volume
        if turn > 0 and stop[0] != 0:
            if (batch.begin + step) % batch.landing == 0 and (stage == 0 or batch.abort_mid_step):
                steps = step
            elif batch.begin + step < batch.landing and batch.abort_mid_step:
                steps = -1
        if step >= steps:
            break
        push = gas_pressure(bodies.gas[body], volume - bodies.boxes_volume[body])
        lead = h if stage >= 2 or integrator == SYMPLECTIC_EULER else 0.5 * h
        coefficients = StageCoefficients(stage, real(push / 6.0), real(lead), real(h / 6.0), damped)
        for share in prange(cut.shape[0] - 1):
            if cut[share] < cut[share + 1]:
                part = rings.block[cut[share], FIRST], rings.block[cut[share + 1] - 1, END]
                rows = StageRows(pull, area, inverse_mass, start, end, velocity, shift, gravity)
                _update(integrator, part, rows, coefficients)
                if stage == stages - 1 and batch.height > -inf and (batch.begin + step + 1) % batch.landing == 0:
                    land(end[:3], end[3:], part, batch.height, Material(batch.restitution, batch.friction))
        if stage == stages - 1 and watch.room[body] < inf and not stays_in_room(watch, body, end[:3], seen, count):
            steps = step
            break
        lands = stage == stages - 1 and (batch.begin + step + 1) % batch.landing == 0
        if limited and lands and (room < 0.0 or not drift_of_rows(end[:3], seen, count) <= room):
            room = room_of_springs(watch, end[:3], seen, count)
            if watch.is_torn[0]:
                steps = step + 1
    if steps % 2 == 1:
        copy_rows(work, NEXT_POSITION, POSITION, count)
    return least, steps


advance_body = jit_lean(_advance_body)
advance_body_on_threads = jit_threaded(_advance_body)  # the shares side by side


@jit_lean
def _update(integrator: int, part: Part, rows: StageRows, coefficients: StageCoefficients) -> None:
    """Take in the acceleration of one stage by an integrator, for the indices of `part`."""
    if integrator == RK4_VELOCITY:
        rk4_velocity_stage(part, rows, coefficients)
    elif integrator == RK4:
        rk4_stage(part, rows, coefficients)
    else:
        symplectic_euler_stage(part, rows, coefficients)


@jit_lean
def copy_rows(work: np.ndarray, source: int, target: int, count: int) -> None:
    """Copy `count` positions and velocities: six rows of `work` from `source` on, to those from `target` on."""
    for row in range(6):
        for i in range(0, count, LANES):
            store_lanes(work[target + row], i, load_lanes(work[source + row], i))


@jit_lean
def acceleration(rows: StageRows, push: float, c: int, i: int) -> Lanes:
    """Return component c of the accelerations [m/s²] at i … i + 7; gravity does not move what is fixed."""
    inverse_mass = load_lanes(rows.inverse_mass, i)
    zero, g = rows.pull.dtype.type(0.0), rows.pull.dtype.type(rows.gravity[c])
    force = load_lanes(rows.pull[c], i) + push * load_lanes(rows.area[c], i)
    return force * inverse_mass + where_less(zero, inverse_mass, g, inverse_mass)


@jit_lean
def rk4_velocity_stage(part: Part, rows: StageRows, coefficients: StageCoefficients) -> None:
    """Take in the acceleration of one stage of four of the paper's scheme; §5.1, in the right form.

    Each of four acceleration estimates moves all velocities from the step's start by the one before, then all
    positions from the step's start by that velocity. (The paper prints the mean of the velocities where the
    mean of their increments is meant.) The velocities of `end` hold the weighted sum of accelerations until the
    last stage.
    """
    for c in range(3):
        x, v, sums = rows.start[c], rows.start[3 + c], rows.end[3 + c]
        for i in range(part[0], part[1], LANES):
            a = acceleration(rows, coefficients.push, c, i)
            if coefficients.stage == 0:
                store_lanes(sums, i, a)
                u = load_lanes(v, i) + coefficients.lead * a
            elif coefficients.stage < 3:
                store_lanes(sums, i, load_lanes(sums, i) + (a + a))
                u = load_lanes(v, i) + coefficients.lead * a
            else:
                u = load_lanes(v, i) + coefficients.sixth * (load_lanes(sums, i) + a)
                store_lanes(sums, i, u)
            store_lanes(rows.end[c], i, load_lanes(x, i) + coefficients.lead * u)
            if coefficients.damped and coefficients.stage < 3:
                store_lanes(rows.velocity[c], i, u)


@jit_lean
def rk4_stage(part: Part, rows: StageRows, coefficients: StageCoefficients) -> None:
    """Take in the acceleration of one stage of four of the classical Runge–Kutta scheme on (x, v) (Kutta 1901).

    The velocities of the stages are v, v + h/2 a0, v + h/2 a1 and v + h a2, so that x' = x + h v + h²/6 (a0 + a1 + a2).
    `shift` holds the plain sum of three accelerations, the velocities of `end` the weighted one until the last stage.
    """
    for c in range(3):
        x, v, sums, shift, velocity = rows.start[c], rows.start[3 + c], rows.end[3 + c], rows.shift[c], rows.velocity[c]
        for i in range(part[0], part[1], LANES):
            a = acceleration(rows, coefficients.push, c, i)
            u = load_lanes(v, i)
            if coefficients.stage == 0:
                store_lanes(sums, i, a)
                store_lanes(shift, i, a)
                moving = u
            elif coefficients.stage < 3:
                store_lanes(sums, i, load_lanes(sums, i) + (a + a))
                store_lanes(shift, i, load_lanes(shift, i) + a)
                moving = load_lanes(velocity, i)
            else:
                store_lanes(sums, i, u + coefficients.sixth * (load_lanes(sums, i) + a))
                moving = u + coefficients.sixth * load_lanes(shift, i)
            store_lanes(rows.end[c], i, load_lanes(x, i) + coefficients.lead * moving)
            if coefficients.stage < 3:
                store_lanes(velocity, i, u + coefficients.lead * a)


@jit_lean
def symplectic_euler_stage(part: Part, rows: StageRows, coefficients: StageCoefficients) -> None:
    """Do the whole step of symplectic Euler: v' = v + h a(x), then x' = x + h v'."""
    for c in range(3):
        for i in range(part[0], part[1], LANES):
            u = load_lanes(rows.start[3 + c], i) + coefficients.lead * acceleration(rows, coefficients.push, c, i)
            store_lanes(rows.end[3 + c], i, u)
            store_lanes(rows.end[c], i, load_lanes(rows.start[c], i) + coefficients.lead * u)
