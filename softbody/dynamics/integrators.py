"""How do the particles move over one time step? The paper's scheme and two to compare it with.

On x'' = −ω² x (ω h = z): `rk4_velocity` is of order 1, stable to z = 2, and loses z²/4 of the amplitude a step;
`rk4` is of order 4 and stable to z = 2√2; `symplectic_euler` is of order 1, stable to z = 2, and loses nothing.
A step is a few stages, and a stage the force on all particles, by place (softbody/dynamics/ring_forces.py), then one
of the updates below, of the places `first` … `last` − 1 (unsigned: LLVM turns the loops into vector code only if it
knows that no index is negative). Their arrays have a row for each component: `pull` [N] and
`area` [m²] make the force pull + P/6 area, `inverse_mass` is (n,), and `start` and `end` of a step have six rows,
positions and then velocities. `lead` is how far the stage looks ahead: half the step or, in the last two, all of it.
Everything is computed in the precision of the arrays, and of the numbers `push`, `lead` and `sixth` (h/6) [s].
"""

from __future__ import annotations

import numpy as np
from numba import prange

from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.ring_forces import (
    AREA,
    INVERSE_MASS,
    MOMENT,
    NEXT_POSITION,
    POSITION,
    PULL,
    SHIFT,
    STAGE_VELOCITY,
    add_other_forces,
    ring_forces,
)
from softbody.jit import arrays_do_not_overlap, jit_lean, jit_threaded
from softbody.state import Model, Rings

RK4_VELOCITY = 0
RK4 = 1
SYMPLECTIC_EULER = 2

INTEGRATORS = {"rk4_velocity": RK4_VELOCITY, "rk4": RK4, "symplectic_euler": SYMPLECTIC_EULER}
STAGES = (4, 4, 1)  # forces a step, in the same order
STABILITY_LIMIT = {"rk4_velocity": 2.0, "rk4": 2.0 * 2.0**0.5, "symplectic_euler": 2.0}  # ω h


def _advance_body(
    model: Model,
    rings: Rings,
    body: int,
    h: float,
    steps: int,
    integrator: int,
    cut: np.ndarray,
    work: np.ndarray,
    block_moment: np.ndarray,
) -> float:
    """Advance one body by `steps` steps of `h` [s] in the rows POSITION and VELOCITY of `work` (WORK_ROWS, n).

    Its blocks are done in shares, of which share i has blocks cut[i] … cut[i + 1]; they write to places of their own,
    so that the result is the same for any `cut`. `block_moment` (blocks,) is scratch. Returns the least volume [m³]
    of all starts of steps and of the end (NaN if one is NaN).
    """
    one, other = work[POSITION : POSITION + 6], work[NEXT_POSITION : NEXT_POSITION + 6]
    pull, area, moment = work[PULL : PULL + 3], work[AREA : AREA + 3], work[MOMENT]
    stage_velocity, shift = work[STAGE_VELOCITY : STAGE_VELOCITY + 3], work[SHIFT : SHIFT + 3]
    inverse_mass = work[INVERSE_MASS]
    # What a thread is handed it unpacks each time: here are the few fields that count.
    first_particle, gravity, external_force = model.particle_start[body], model.gravity, model.external_force
    damping, drag = model.damping[body], model.drag[body]
    damped = damping > 0.0 or drag > 0.0
    loaded = damped or external_force.shape[0] > 0
    k = rings.common_stiffness[body]
    stages = STAGES[integrator]
    real = work.dtype.type
    least = np.inf
    # One call of the force, for the stages of all steps and for the volume at the end: machine code for it is made
    # for every place that it is called from.
    for turn in range(stages * steps + 1):
        step = turn // stages
        stage = turn - step * stages
        # Each step starts where the one before ended: the two sets of rows change places.
        start, end = (one, other) if step % 2 == 0 else (other, one)
        x = start if stage == 0 else end
        for share in prange(cut.shape[0] - 1):
            ring_forces(rings, k, cut[share], cut[share + 1], x, pull, area, moment, block_moment)
            if loaded:
                velocity = start[3:] if stage == 0 else stage_velocity
                add_other_forces(
                    rings,
                    first_particle,
                    cut[share],
                    cut[share + 1],
                    damping,
                    drag,
                    external_force,
                    inverse_mass,
                    x,
                    velocity,
                    pull,
                )
        volume = 0.0
        for block in range(cut[0], cut[-1]):
            volume += block_moment[block]
        volume /= 18.0
        if stage == 0 and not volume >= least:  # so that NaN stays
            least = volume
        if step == steps:
            break
        push = real(gas_pressure(model.gas[body], volume) / 6.0)
        lead = real(h if stage >= 2 or integrator == SYMPLECTIC_EULER else 0.5 * h)
        sixth = real(h / 6.0)
        for share in prange(cut.shape[0] - 1):
            if cut[share] == cut[share + 1]:
                continue
            first, last = np.uint64(rings.block[cut[share], 0]), np.uint64(rings.block[cut[share + 1] - 1, 1])
            if integrator == RK4_VELOCITY:
                rk4_velocity_stage(
                    stage,
                    first,
                    last,
                    pull,
                    area,
                    inverse_mass,
                    push,
                    gravity,
                    lead,
                    sixth,
                    start,
                    end,
                    stage_velocity,
                    damped,
                )
            elif integrator == RK4:
                rk4_stage(
                    stage,
                    first,
                    last,
                    pull,
                    area,
                    inverse_mass,
                    push,
                    gravity,
                    lead,
                    sixth,
                    start,
                    end,
                    stage_velocity,
                    shift,
                )
            else:
                symplectic_euler_stage(first, last, pull, area, inverse_mass, push, gravity, lead, start, end)
    if steps % 2 == 1:
        copy_rows(work, NEXT_POSITION, POSITION, rings.block[cut[-1] - 1, 1])
    return least


advance_body = jit_lean(_advance_body)
advance_body_on_threads = jit_threaded(_advance_body)  # the shares side by side


@jit_lean
def copy_rows(work: np.ndarray, source: int, target: int, count: int) -> None:
    """Copy `count` positions and velocities: six rows of `work` from `source` on, to those from `target` on."""
    for row in range(6):
        for i in range(count):
            work[target + row, i] = work[source + row, i]


@jit_lean
def acceleration(pull: float, push: float, inverse_mass: float, gravity: float) -> float:
    """Return one component [m/s²] from forces [N], mass [1/kg] and gravity [m/s²], which does not move a pin."""
    return (pull + push) * inverse_mass + (gravity if inverse_mass > 0.0 else inverse_mass)


@jit_lean
def rk4_velocity_stage(
    stage: int,
    first: np.uint64,
    last: np.uint64,
    pull: np.ndarray,
    area: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    gravity: np.ndarray,
    lead: float,
    sixth: float,
    start: np.ndarray,
    end: np.ndarray,
    stage_velocity: np.ndarray,
    damped: bool,
) -> None:
    """Take in the acceleration of one `stage` of four of the paper's scheme; §5.1, in the right form.

    Each of four acceleration estimates moves all velocities from the step's start by the one before, then all
    positions from the step's start by that velocity. (The paper prints the mean of the velocities where the
    mean of their increments is meant.) The velocities of `end` hold the weighted sum of accelerations until the
    last stage.
    """
    arrays_do_not_overlap()
    for c in range(3):
        g = pull.dtype.type(gravity[c])
        if stage == 0:
            for i in range(first, last):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], g)
                end[3 + c, i] = a
                end[c, i] = start[c, i] + lead * (start[3 + c, i] + lead * a)
        elif stage < 3:
            for i in range(first, last):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], g)
                end[3 + c, i] += a + a
                end[c, i] = start[c, i] + lead * (start[3 + c, i] + lead * a)
        else:
            for i in range(first, last):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], g)
                u = start[3 + c, i] + sixth * (end[3 + c, i] + a)
                end[3 + c, i] = u
                end[c, i] = start[c, i] + lead * u
        if damped and stage < 3:
            for i in range(first, last):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], g)
                stage_velocity[c, i] = start[3 + c, i] + lead * a


@jit_lean
def rk4_stage(
    stage: int,
    first: np.uint64,
    last: np.uint64,
    pull: np.ndarray,
    area: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    gravity: np.ndarray,
    lead: float,
    sixth: float,
    start: np.ndarray,
    end: np.ndarray,
    stage_velocity: np.ndarray,
    shift: np.ndarray,
) -> None:
    """Take in the acceleration of one `stage` of four of the classical Runge–Kutta scheme on (x, v) (Kutta 1901).

    The velocities of the stages are v, v + h/2 a0, v + h/2 a1 and v + h a2 (`stage_velocity`), so that x' = x + h v +
    h²/6 (a0 + a1 + a2). `shift` holds the plain sum of three accelerations, the velocities of `end` the weighted
    one until the last stage.
    """
    arrays_do_not_overlap()
    for c in range(3):
        g = pull.dtype.type(gravity[c])
        if stage == 0:
            for i in range(first, last):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], g)
                end[3 + c, i] = a
                shift[c, i] = a
                end[c, i] = start[c, i] + lead * start[3 + c, i]
                stage_velocity[c, i] = start[3 + c, i] + lead * a
        elif stage < 3:
            for i in range(first, last):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], g)
                end[3 + c, i] += a + a
                shift[c, i] += a
                end[c, i] = start[c, i] + lead * stage_velocity[c, i]
                stage_velocity[c, i] = start[3 + c, i] + lead * a
        else:
            for i in range(first, last):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], g)
                end[c, i] = start[c, i] + lead * (start[3 + c, i] + sixth * shift[c, i])
                end[3 + c, i] = start[3 + c, i] + sixth * (end[3 + c, i] + a)


@jit_lean
def symplectic_euler_stage(
    first: np.uint64,
    last: np.uint64,
    pull: np.ndarray,
    area: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    gravity: np.ndarray,
    lead: float,
    start: np.ndarray,
    end: np.ndarray,
) -> None:
    """Do the whole step of symplectic Euler: v' = v + h a(x), then x' = x + h v'."""
    arrays_do_not_overlap()
    for c in range(3):
        g = pull.dtype.type(gravity[c])
        for i in range(first, last):
            a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], g)
            u = start[3 + c, i] + lead * a
            end[3 + c, i] = u
            end[c, i] = start[c, i] + lead * u
