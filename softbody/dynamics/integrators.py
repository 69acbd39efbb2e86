"""How do the particles move over one time step? The paper's scheme and two to compare it with.

On x'' = −ω² x (ω h = z): `rk4_velocity` is of order 1, stable to z = 2, and loses z²/4 of the amplitude a step;
`rk4` is of order 4 and stable to z = 2√2; `symplectic_euler` is of order 1, stable to z = 2, and loses nothing.
A step is a few stages, and a stage the force on all particles, by place (softbody/dynamics/ring_forces.py), then one
of the updates below on every component: arrays (n,), where s [N] and G [m²] make the force s + P/6 G.
"""

from __future__ import annotations

import numpy as np

from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.ring_forces import (
    AREA,
    NEXT_POSITION,
    POSITION,
    PULL,
    SHIFT,
    STAGE_VELOCITY,
    add_other_forces,
    ring_forces,
)
from softbody.jit import arrays_do_not_overlap, compile_apart, jit
from softbody.state import Model

RK4_VELOCITY = 0
RK4 = 1
SYMPLECTIC_EULER = 2

INTEGRATORS = {"rk4_velocity": RK4_VELOCITY, "rk4": RK4, "symplectic_euler": SYMPLECTIC_EULER}
STAGES = (4, 4, 1)  # forces a step, in the same order
STABILITY_LIMIT = {"rk4_velocity": 2.0, "rk4": 2.0 * 2.0**0.5, "symplectic_euler": 2.0}  # ω h

SPAN = 2048  # particles that are updated together, as many as are in one block of the force


@jit
def advance_body(
    model: Model, body: int, h: float, steps: int, integrator: int, inverse_mass: np.ndarray, work: np.ndarray
) -> float:
    """Advance one body by `steps` steps of `h` [s] in the rows POSITION and VELOCITY of `work` (WORK_ROWS, n).

    `inverse_mass` (n,) [1/kg] by place. Returns the least volume [m³] of all starts of steps and of the end (NaN if
    one is NaN).
    """
    here, there = POSITION, NEXT_POSITION  # first rows of where the step starts and of where it ends, both x and v
    damped = model.damping[body] > 0.0 or model.drag[body] > 0.0
    loaded = damped or model.external_force.shape[0] > 0
    compile_apart()
    stages = STAGES[integrator]
    count = inverse_mass.shape[0]
    least = np.inf
    # One call of the force, for the stages of all steps and for the volume at the end: the compiler copies what it
    # calls into every place that it is called from.
    for turn in range(stages * steps + 1):
        stage = turn % stages
        at = here if stage == 0 else there
        volume = ring_forces(model, body, at, work)
        if stage == 0 and not volume >= least:  # so that NaN stays
            least = volume
        if turn == stages * steps:
            break
        if loaded:
            add_other_forces(model, body, at, here + 3 if stage == 0 else STAGE_VELOCITY, work)
        push = gas_pressure(model.gas[body], volume) / 6.0
        for first in range(0, count, SPAN):
            end = min(first + SPAN, count)
            for c in range(3):
                x, v, next_x, total = work[here + c], work[here + 3 + c], work[there + c], work[there + 3 + c]
                s, G, stage_v, g = work[PULL + c], work[AREA + c], work[STAGE_VELOCITY + c], model.gravity[c]
                if integrator == RK4_VELOCITY:
                    rk4_velocity_stage(
                        stage, first, end, s, G, inverse_mass, push, g, h, x, v, next_x, total, stage_v, damped
                    )
                elif integrator == RK4:
                    shift = work[SHIFT + c]
                    rk4_stage(stage, first, end, s, G, inverse_mass, push, g, h, x, v, next_x, total, shift, stage_v)
                else:
                    symplectic_euler_stage(first, end, s, G, inverse_mass, push, g, h, x, v, next_x, total)
        if stage == stages - 1:
            here, there = there, here
    if here != POSITION:
        copy_rows(work, here, POSITION, count)
    return least


@jit
def copy_rows(work: np.ndarray, source: int, target: int, count: int) -> None:
    """Copy `count` positions and velocities: six rows of `work` from `source` on, to those from `target` on."""
    for row in range(6):
        for i in range(count):
            work[target + row, i] = work[source + row, i]


@jit
def rk4_velocity_stage(
    stage: int,
    first: int,
    end: int,
    s: np.ndarray,
    G: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    g: float,
    h: float,
    x: np.ndarray,
    v: np.ndarray,
    next_x: np.ndarray,
    total: np.ndarray,
    stage_v: np.ndarray,
    damped: bool,
) -> None:
    """Take in the acceleration of one `stage` of four of the paper's scheme; §5.1, in the right form.

    Each of four acceleration estimates moves all velocities from the step's start by the one before, then all
    positions from the step's start by that velocity. (The paper prints the mean of the velocities where the
    mean of their increments is meant.) `total` holds the weighted sum of accelerations, and at last v'.
    """
    arrays_do_not_overlap()
    step = h if stage == 2 else 0.5 * h
    if stage == 0:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            total[i] = a
            next_x[i] = x[i] + step * (v[i] + step * a)
    elif stage < 3:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            total[i] += 2.0 * a
            next_x[i] = x[i] + step * (v[i] + step * a)
    else:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            u = v[i] + h / 6.0 * (total[i] + a)
            total[i] = u
            next_x[i] = x[i] + h * u
    if damped and stage < 3:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            stage_v[i] = v[i] + step * a


@jit
def rk4_stage(
    stage: int,
    first: int,
    end: int,
    s: np.ndarray,
    G: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    g: float,
    h: float,
    x: np.ndarray,
    v: np.ndarray,
    next_x: np.ndarray,
    total: np.ndarray,
    shift: np.ndarray,
    stage_v: np.ndarray,
) -> None:
    """Take in the acceleration of one `stage` of four of the classical Runge–Kutta scheme on (x, v) (Kutta 1901).

    The velocities of the stages are v, v + h/2 a0, v + h/2 a1 and v + h a2 (`stage_v`), so that x' = x + h v +
    h²/6 (a0 + a1 + a2). `shift` holds the plain sum of three accelerations, `total` the weighted one of all, then v'.
    """
    arrays_do_not_overlap()
    step = h if stage == 2 else 0.5 * h
    if stage == 0:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            total[i] = a
            shift[i] = a
            next_x[i] = x[i] + step * v[i]
            stage_v[i] = v[i] + step * a
    elif stage < 3:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            total[i] += 2.0 * a
            shift[i] += a
            next_x[i] = x[i] + step * stage_v[i]
            stage_v[i] = v[i] + step * a
    else:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            next_x[i] = x[i] + h * (v[i] + h / 6.0 * shift[i])
            total[i] = v[i] + h / 6.0 * (total[i] + a)


@jit
def symplectic_euler_stage(
    first: int,
    end: int,
    s: np.ndarray,
    G: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    g: float,
    h: float,
    x: np.ndarray,
    v: np.ndarray,
    next_x: np.ndarray,
    next_v: np.ndarray,
) -> None:
    """Do the whole step of symplectic Euler for one component: v' = v + h a(x), then x' = x + h v'."""
    arrays_do_not_overlap()
    for i in range(first, end):
        a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
        u = v[i] + h * a
        next_v[i] = u
        next_x[i] = x[i] + h * u
