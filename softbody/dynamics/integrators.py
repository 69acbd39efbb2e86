"""How do the particles move over one time step? The paper's scheme and two to compare it with.

On x'' = −ω² x (ω h = z): `rk4_velocity` is of order 1, stable to z = 2, and loses z²/4 of the amplitude a step;
`rk4` is of order 4 and stable to z = 2√2; `symplectic_euler` is of order 1, stable to z = 2, and loses nothing.
"""

from __future__ import annotations

import numpy as np

from softbody.dynamics.soft import soft_accelerations
from softbody.jit import jit
from softbody.state import Model

RK4_VELOCITY = 0
RK4 = 1
SYMPLECTIC_EULER = 2

INTEGRATORS = {"rk4_velocity": RK4_VELOCITY, "rk4": RK4, "symplectic_euler": SYMPLECTIC_EULER}
STABILITY_LIMIT = {"rk4_velocity": 2.0, "rk4": 2.0 * 2.0**0.5, "symplectic_euler": 2.0}  # ω h

WORK_ROWS = 5  # arrays (n, 3) of scratch memory that a step needs


@jit
def rk4_velocity_step(
    model: Model,
    position: np.ndarray,
    velocity: np.ndarray,
    h: float,
    next_position: np.ndarray,
    next_velocity: np.ndarray,
    work: np.ndarray,
) -> None:
    """Advance by `h` [s] as the paper does; §5.1, in the right form.

    Each of four acceleration estimates moves all velocities from the step's start by the one before, then all
    positions from the step's start by that velocity. (The paper prints the mean of the velocities where the
    mean of their increments is meant.) Arrays (n, 3) [m], [m/s]; `work` (WORK_ROWS, n, 3).
    """
    a, total = work[0], work[1]
    soft_accelerations(model, position, a)
    total[:] = a
    for stage in range(1, 4):
        step = h if stage == 3 else 0.5 * h
        weight = 1.0 if stage == 3 else 2.0
        for i in range(position.shape[0]):
            for c in range(3):
                next_position[i, c] = position[i, c] + step * (velocity[i, c] + step * a[i, c])
        soft_accelerations(model, next_position, a)
        for i in range(position.shape[0]):
            for c in range(3):
                total[i, c] += weight * a[i, c]
    for i in range(position.shape[0]):
        for c in range(3):
            next_velocity[i, c] = velocity[i, c] + h / 6.0 * total[i, c]
            next_position[i, c] = position[i, c] + h * next_velocity[i, c]


@jit
def rk4_step(
    model: Model,
    position: np.ndarray,
    velocity: np.ndarray,
    h: float,
    next_position: np.ndarray,
    next_velocity: np.ndarray,
    work: np.ndarray,
) -> None:
    """Advance by `h` [s] with the classical Runge–Kutta scheme on (x, v) (Kutta 1901); arrays as above."""
    a, total_a, total_v, x, v = work[0], work[1], work[2], work[3], work[4]
    soft_accelerations(model, position, a)
    total_a[:] = a
    total_v[:] = velocity
    v[:] = velocity
    for stage in range(1, 4):
        step = h if stage == 3 else 0.5 * h
        weight = 1.0 if stage == 3 else 2.0
        for i in range(position.shape[0]):
            for c in range(3):
                x[i, c] = position[i, c] + step * v[i, c]
                v[i, c] = velocity[i, c] + step * a[i, c]
        soft_accelerations(model, x, a)
        for i in range(position.shape[0]):
            for c in range(3):
                total_a[i, c] += weight * a[i, c]
                total_v[i, c] += weight * v[i, c]
    for i in range(position.shape[0]):
        for c in range(3):
            next_position[i, c] = position[i, c] + h / 6.0 * total_v[i, c]
            next_velocity[i, c] = velocity[i, c] + h / 6.0 * total_a[i, c]


@jit
def symplectic_euler_step(
    model: Model,
    position: np.ndarray,
    velocity: np.ndarray,
    h: float,
    next_position: np.ndarray,
    next_velocity: np.ndarray,
    work: np.ndarray,
) -> None:
    """Advance by `h` [s]: v' = v + h a(x), then x' = x + h v'; arrays as above."""
    a = work[0]
    soft_accelerations(model, position, a)
    for i in range(position.shape[0]):
        for c in range(3):
            next_velocity[i, c] = velocity[i, c] + h * a[i, c]
            next_position[i, c] = position[i, c] + h * next_velocity[i, c]


@jit
def integrate(
    integrator: int,
    model: Model,
    position: np.ndarray,
    velocity: np.ndarray,
    h: float,
    next_position: np.ndarray,
    next_velocity: np.ndarray,
    work: np.ndarray,
) -> None:
    """Advance by `h` [s] with one of INTEGRATORS; the result goes to `next_position` and `next_velocity`."""
    if integrator == RK4_VELOCITY:
        rk4_velocity_step(model, position, velocity, h, next_position, next_velocity, work)
    elif integrator == RK4:
        rk4_step(model, position, velocity, h, next_position, next_velocity, work)
    else:
        symplectic_euler_step(model, position, velocity, h, next_position, next_velocity, work)
