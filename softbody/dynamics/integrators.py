"""How do the particles move over one time step? The paper's scheme and two to compare it with.

On x'' = −ω² x (ω h = z): `rk4_velocity` is of order 1, stable to z = 2, and loses z²/4 of the amplitude a step;
`rk4` is of order 4 and stable to z = 2√2; `symplectic_euler` is of order 1, stable to z = 2, and loses nothing.
A step is a few stages, and a stage the force on all particles, by place (softbody/dynamics/ring_forces.py), then one
of the updates below. Their arrays have a row for each component: `pull` [N] and `area` [m²] make the force pull +
P/6 area, `inverse_mass` is (n,), and `start` and `end` of a step have six rows, positions and then velocities.
"""

from __future__ import annotations

import numpy as np

from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.ring_forces import (
    AREA,
    MOMENT,
    NEXT_POSITION,
    POSITION,
    PULL,
    SHIFT,
    STAGE_VELOCITY,
    add_other_forces,
    ring_forces,
)
from softbody.jit import arrays_do_not_overlap, jit_lean
from softbody.state import Model

RK4_VELOCITY = 0
RK4 = 1
SYMPLECTIC_EULER = 2

INTEGRATORS = {"rk4_velocity": RK4_VELOCITY, "rk4": RK4, "symplectic_euler": SYMPLECTIC_EULER}
STAGES = (4, 4, 1)  # forces a step, in the same order
STABILITY_LIMIT = {"rk4_velocity": 2.0, "rk4": 2.0 * 2.0**0.5, "symplectic_euler": 2.0}  # ω h


@jit_lean
def advance_body(
    model: Model, body: int, h: float, steps: int, integrator: int, inverse_mass: np.ndarray, work: np.ndarray
) -> float:
    """Advance one body by `steps` steps of `h` [s] in the rows POSITION and VELOCITY of `work` (WORK_ROWS, n).

    `inverse_mass` (n,) [1/kg] by place. Returns the least volume [m³] of all starts of steps and of the end (NaN if
    one is NaN).
    """
    one, other = work[POSITION : POSITION + 6], work[NEXT_POSITION : NEXT_POSITION + 6]
    pull, area, moment = work[PULL : PULL + 3], work[AREA : AREA + 3], work[MOMENT]
    stage_velocity, shift = work[STAGE_VELOCITY : STAGE_VELOCITY + 3], work[SHIFT : SHIFT + 3]
    damped = model.damping[body] > 0.0 or model.drag[body] > 0.0
    loaded = damped or model.external_force.shape[0] > 0
    stages = STAGES[integrator]
    count = inverse_mass.shape[0]
    least = np.inf
    # One call of the force, for the stages of all steps and for the volume at the end: machine code for it is made
    # for every place that it is called from.
    for turn in range(stages * steps + 1):
        step = turn // stages
        stage = turn - step * stages
        # Each step starts where the one before ended: the two sets of rows change places.
        start, end = (one, other) if step % 2 == 0 else (other, one)
        x = start if stage == 0 else end
        volume = ring_forces(model.rings, body, count, x, pull, area, moment)
        if stage == 0 and not volume >= least:  # so that NaN stays
            least = volume
        if step == steps:
            break
        if loaded:
            add_other_forces(model, body, x, start[3:] if stage == 0 else stage_velocity, pull)
        push = gas_pressure(model.gas[body], volume) / 6.0
        if integrator == RK4_VELOCITY:
            rk4_velocity_stage(
                stage, pull, area, inverse_mass, push, model.gravity, h, start, end, stage_velocity, damped
            )
        elif integrator == RK4:
            rk4_stage(stage, pull, area, inverse_mass, push, model.gravity, h, start, end, stage_velocity, shift)
        else:
            symplectic_euler_stage(pull, area, inverse_mass, push, model.gravity, h, start, end)
    if steps % 2 == 1:
        copy_rows(work, NEXT_POSITION, POSITION, count)
    return least


@jit_lean
def copy_rows(work: np.ndarray, source: int, target: int, count: int) -> None:
    """Copy `count` positions and velocities: six rows of `work` from `source` on, to those from `target` on."""
    for row in range(6):
        for i in range(count):
            work[target + row, i] = work[source + row, i]


@jit_lean
def acceleration(pull: float, push: float, inverse_mass: float, gravity: float) -> float:
    """Return one component [m/s²] from forces [N], mass [1/kg] and gravity [m/s²], which does not move a pin."""
    return (pull + push) * inverse_mass + (gravity if inverse_mass > 0.0 else 0.0)


@jit_lean
def rk4_velocity_stage(
    stage: int,
    pull: np.ndarray,
    area: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    gravity: np.ndarray,
    h: float,
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
    step = h if stage == 2 else 0.5 * h
    if stage == 0:
        for c in range(3):
            for i in range(inverse_mass.shape[0]):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], gravity[c])
                end[3 + c, i] = a
                end[c, i] = start[c, i] + step * (start[3 + c, i] + step * a)
    elif stage < 3:
        for c in range(3):
            for i in range(inverse_mass.shape[0]):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], gravity[c])
                end[3 + c, i] += 2.0 * a
                end[c, i] = start[c, i] + step * (start[3 + c, i] + step * a)
    else:
        for c in range(3):
            for i in range(inverse_mass.shape[0]):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], gravity[c])
                u = start[3 + c, i] + h / 6.0 * (end[3 + c, i] + a)
                end[3 + c, i] = u
                end[c, i] = start[c, i] + h * u
    if damped and stage < 3:
        for c in range(3):
            for i in range(inverse_mass.shape[0]):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], gravity[c])
                stage_velocity[c, i] = start[3 + c, i] + step * a


@jit_lean
def rk4_stage(
    stage: int,
    pull: np.ndarray,
    area: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    gravity: np.ndarray,
    h: float,
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
    step = h if stage == 2 else 0.5 * h
    if stage == 0:
        for c in range(3):
            for i in range(inverse_mass.shape[0]):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], gravity[c])
                end[3 + c, i] = a
                shift[c, i] = a
                end[c, i] = start[c, i] + step * start[3 + c, i]
                stage_velocity[c, i] = start[3 + c, i] + step * a
    elif stage < 3:
        for c in range(3):
            for i in range(inverse_mass.shape[0]):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], gravity[c])
                end[3 + c, i] += 2.0 * a
                shift[c, i] += a
                end[c, i] = start[c, i] + step * stage_velocity[c, i]
                stage_velocity[c, i] = start[3 + c, i] + step * a
    else:
        for c in range(3):
            for i in range(inverse_mass.shape[0]):
                a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], gravity[c])
                end[c, i] = start[c, i] + h * (start[3 + c, i] + h / 6.0 * shift[c, i])
                end[3 + c, i] = start[3 + c, i] + h / 6.0 * (end[3 + c, i] + a)


@jit_lean
def symplectic_euler_stage(
    pull: np.ndarray,
    area: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    gravity: np.ndarray,
    h: float,
    start: np.ndarray,
    end: np.ndarray,
) -> None:
    """Do the whole step of symplectic Euler: v' = v + h a(x), then x' = x + h v'."""
    arrays_do_not_overlap()
    for c in range(3):
        for i in range(inverse_mass.shape[0]):
            a = acceleration(pull[c, i], push * area[c, i], inverse_mass[i], gravity[c])
            u = start[3 + c, i] + h * a
            end[3 + c, i] = u
            end[c, i] = start[c, i] + h * u
