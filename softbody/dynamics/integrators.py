"""How do the particles move over one time step? The paper's scheme and two to compare it with.

On x'' = −ω² x (ω h = z): `rk4_velocity` is of order 1, stable to z = 2, and loses z²/4 of the amplitude a step;
`rk4` is of order 4 and stable to z = 2√2; `symplectic_euler` is of order 1, stable to z = 2, and loses nothing.
Each stage is a force on all particles, by place (softbody/dynamics/ring_forces.py), and then one of the updates below
on every component: `s` [N] and G [m²] sum to the force s + P/6 G, (n,) arrays all.
"""

from __future__ import annotations

import numpy as np

from softbody.dynamics.pressure import gas_pressure
from softbody.dynamics.ring_forces import (
    AREA,
    LAST,
    NEXT_POSITION,
    NEXT_VELOCITY,
    POSITION,
    PULL,
    SHIFT,
    STAGE_VELOCITY,
    VELOCITY,
    add_other_forces,
    ring_forces,
)
from softbody.jit import arrays_do_not_overlap, jit
from softbody.state import Model

RK4_VELOCITY = 0
RK4 = 1
SYMPLECTIC_EULER = 2

INTEGRATORS = {"rk4_velocity": RK4_VELOCITY, "rk4": RK4, "symplectic_euler": SYMPLECTIC_EULER}
STABILITY_LIMIT = {"rk4_velocity": 2.0, "rk4": 2.0 * 2.0**0.5, "symplectic_euler": 2.0}  # ω h

SPAN = 2048  # particles that are updated together, as many as are in one block of the force


@jit
def advance_body(
    model: Model, body: int, h: float, steps: int, integrator: int, inverse_mass: np.ndarray, work: np.ndarray
) -> float:
    """Advance one body by `steps` steps of `h` [s] in the rows POSITION and VELOCITY of `work` (WORK_ROWS, n).

    `inverse_mass` (n,) [1/kg] by place. Returns the least volume [m³] at the start of a step (NaN if one is NaN).
    """
    position, velocity = work[POSITION : POSITION + 3], work[VELOCITY : VELOCITY + 3]
    next_position, next_velocity = work[NEXT_POSITION : NEXT_POSITION + 3], work[NEXT_VELOCITY : NEXT_VELOCITY + 3]
    least = np.inf
    for _ in range(steps):
        if integrator == RK4_VELOCITY:
            volume = rk4_velocity_step(
                model, body, h, inverse_mass, position, velocity, next_position, next_velocity, work
            )
        elif integrator == RK4:
            volume = rk4_step(model, body, h, inverse_mass, position, velocity, next_position, next_velocity, work)
        else:
            volume = symplectic_euler_step(
                model, body, h, inverse_mass, position, velocity, next_position, next_velocity, work
            )
        if not volume >= least:  # so that NaN stays
            least = volume
        position, next_position = next_position, position
        velocity, next_velocity = next_velocity, velocity
    if steps % 2 == 1:
        work[POSITION : POSITION + 6] = work[NEXT_POSITION : NEXT_POSITION + 6]
    return least


@jit
def rk4_velocity_step(
    model: Model,
    body: int,
    h: float,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    next_position: np.ndarray,
    next_velocity: np.ndarray,
    work: np.ndarray,
) -> float:
    """Advance by `h` [s] as the paper does; §5.1, in the right form. Returns the volume [m³] at the start.

    Each of four acceleration estimates moves all velocities from the step's start by the one before, then all
    positions from the step's start by that velocity. (The paper prints the mean of the velocities where the
    mean of their increments is meant.) Arrays (3, n) [m], [m/s], by place.
    """
    volume = force(model, body, position, velocity, work)
    start_volume = volume
    for stage in range(4):
        if stage > 0:
            volume = force(model, body, next_position, work[STAGE_VELOCITY : STAGE_VELOCITY + 3], work)
        push = gas_pressure(model.gas[body], volume) / 6.0
        keep = is_damped(model, body)
        for first in range(0, inverse_mass.shape[0], SPAN):
            end = min(first + SPAN, inverse_mass.shape[0])
            for c in range(3):
                x, v, nx, total = position[c], velocity[c], next_position[c], next_velocity[c]
                s, G, stage_v, g = work[PULL + c], work[AREA + c], work[STAGE_VELOCITY + c], model.gravity[c]
                if stage == 0:
                    start_stage(first, end, s, G, inverse_mass, push, g, 0.5 * h, x, v, nx, total, stage_v, keep)
                elif stage == 1:
                    middle_stage(first, end, s, G, inverse_mass, push, g, 0.5 * h, x, v, nx, total, stage_v, keep)
                elif stage == 2:
                    middle_stage(first, end, s, G, inverse_mass, push, g, h, x, v, nx, total, stage_v, keep)
                else:
                    last_stage(first, end, s, G, inverse_mass, push, g, h, x, v, nx, total)
    return start_volume


@jit
def force(model: Model, body: int, position: np.ndarray, velocity: np.ndarray, work: np.ndarray) -> float:
    """Overwrite the rows PULL and AREA of `work` at `position`, `velocity` (3, n); return the volume [m³]."""
    volume = ring_forces(model, body, position, work)
    if is_damped(model, body) or model.external_force.shape[0] > 0:
        add_other_forces(model, body, position, velocity, work)
    return volume


@jit
def is_damped(model: Model, body: int) -> bool:
    """Tell whether any force on the body depends on velocities."""
    return model.damping[body] > 0.0 or model.drag[body] > 0.0


@jit
def start_stage(
    first: int,
    end: int,
    s: np.ndarray,
    G: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    g: float,
    step: float,
    x: np.ndarray,
    v: np.ndarray,
    next_x: np.ndarray,
    total: np.ndarray,
    stage_v: np.ndarray,
    keep: bool,
) -> None:
    """Start the sum of accelerations; move from x by the velocity that the first of them leads to."""
    arrays_do_not_overlap()
    for i in range(first, end):
        a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
        u = v[i] + step * a
        total[i] = a
        next_x[i] = x[i] + step * u
        if keep:
            stage_v[i] = u


@jit
def middle_stage(
    first: int,
    end: int,
    s: np.ndarray,
    G: np.ndarray,
    inverse_mass: np.ndarray,
    push: float,
    g: float,
    step: float,
    x: np.ndarray,
    v: np.ndarray,
    next_x: np.ndarray,
    total: np.ndarray,
    stage_v: np.ndarray,
    keep: bool,
) -> None:
    """Add an acceleration twice; move from x by the velocity that it leads to."""
    arrays_do_not_overlap()
    for i in range(first, end):
        a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
        u = v[i] + step * a
        total[i] += 2.0 * a
        next_x[i] = x[i] + step * u
        if keep:
            stage_v[i] = u


@jit
def last_stage(
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
) -> None:
    """Finish the step: v' = v + h/6 (sum of accelerations), x' = x + h v'; v' takes the place of the sum."""
    arrays_do_not_overlap()
    for i in range(first, end):
        a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
        u = v[i] + h / 6.0 * (total[i] + a)
        total[i] = u
        next_x[i] = x[i] + h * u


@jit
def rk4_step(
    model: Model,
    body: int,
    h: float,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    next_position: np.ndarray,
    next_velocity: np.ndarray,
    work: np.ndarray,
) -> float:
    """Advance by `h` [s] with the classical Runge–Kutta scheme on (x, v) (Kutta 1901); arrays as above.

    x' = x + h v + h²/6 (a0 + a1 + a2), as the four velocities are v, v + h/2 a0, v + h/2 a1 and v + h a2.
    """
    start_volume = 0.0
    keep = is_damped(model, body)
    for stage in range(4):
        if stage == 0:
            volume = force(model, body, position, velocity, work)
            start_volume = volume
        else:
            volume = force(model, body, next_position, work[STAGE_VELOCITY : STAGE_VELOCITY + 3], work)
        push = gas_pressure(model.gas[body], volume) / 6.0
        step = h if stage == 2 else 0.5 * h  # from here to the next stage
        lead = h if stage == 3 else 0.5 * h  # from the start to the velocity of this stage
        for first in range(0, inverse_mass.shape[0], SPAN):
            end = min(first + SPAN, inverse_mass.shape[0])
            for c in range(3):
                rk4_stage(
                    stage,
                    first,
                    end,
                    work[PULL + c],
                    work[AREA + c],
                    inverse_mass,
                    push,
                    model.gravity[c],
                    h,
                    step,
                    lead,
                    position[c],
                    velocity[c],
                    next_position[c],
                    next_velocity[c],
                    work[LAST + c],
                    work[SHIFT + c],
                    work[STAGE_VELOCITY + c],
                    keep,
                )
    return start_volume


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
    step: float,
    lead: float,
    x: np.ndarray,
    v: np.ndarray,
    next_x: np.ndarray,
    total: np.ndarray,
    last: np.ndarray,
    shift: np.ndarray,
    stage_v: np.ndarray,
    keep: bool,
) -> None:
    """Take in the acceleration of one stage of four, and move to the next, or to the end of the step."""
    arrays_do_not_overlap()
    if stage == 0:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            total[i] = a
            shift[i] = a
            last[i] = a
            next_x[i] = x[i] + step * v[i]
            if keep:
                stage_v[i] = v[i] + step * a
    elif stage < 3:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            total[i] += 2.0 * a
            shift[i] += a
            next_x[i] = x[i] + step * (v[i] + lead * last[i])
            last[i] = a
            if keep:
                stage_v[i] = v[i] + step * a
    else:
        for i in range(first, end):
            a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
            total[i] = v[i] + h / 6.0 * (total[i] + a)
            next_x[i] = x[i] + h * (v[i] + h / 6.0 * shift[i])


@jit
def symplectic_euler_step(
    model: Model,
    body: int,
    h: float,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    next_position: np.ndarray,
    next_velocity: np.ndarray,
    work: np.ndarray,
) -> float:
    """Advance by `h` [s]: v' = v + h a(x), then x' = x + h v'; arrays as above."""
    volume = force(model, body, position, velocity, work)
    push = gas_pressure(model.gas[body], volume) / 6.0
    for first in range(0, inverse_mass.shape[0], SPAN):
        end = min(first + SPAN, inverse_mass.shape[0])
        for c in range(3):
            euler_stage(
                first,
                end,
                work[PULL + c],
                work[AREA + c],
                inverse_mass,
                push,
                model.gravity[c],
                h,
                position[c],
                velocity[c],
                next_position[c],
                next_velocity[c],
            )
    return volume


@jit
def euler_stage(
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
    """Do the whole step of symplectic Euler for one component."""
    arrays_do_not_overlap()
    for i in range(first, end):
        a = (s[i] + push * G[i]) * inverse_mass[i] + (g if inverse_mass[i] > 0.0 else 0.0)
        u = v[i] + h * a
        next_v[i] = u
        next_x[i] = x[i] + h * u
