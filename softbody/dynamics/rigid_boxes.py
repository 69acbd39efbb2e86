"""Motion of rigid boxes over one time step, between contacts."""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.quaternion import (
    Quaternion,
    from_rotation_vector,
    load_quaternion,
    normalize_quaternion,
    product,
    rotate_diagonal,
)
from softbody.linalg.vec import Vec, accumulate, load, norm, scale, store
from softbody.model.arrays import Controls, Model, State
from softbody.model.settings import Settings


@jit_lean
def accelerate_boxes(model: Model, controls: Controls, state: State, h: float) -> None:
    """Change velocities over `h` [s]: v' = v + (g + F/m) h and ω' = ω + R I⁻¹ Rᵀ τ h; paper §5.2, §10.13."""
    for i in range(state.box_position.shape[0]):
        inverse_mass = model.box_inverse_mass[i]
        if inverse_mass > 0.0:
            for c in range(3):
                state.box_velocity[i, c] += h * (controls.gravity[c] + inverse_mass * controls.box_force[i, c])
            q, inverse = load_quaternion(state.box_orientation, i), load(model.box_inverse_inertia, i)
            turn = rotate_diagonal(q, inverse, load(controls.box_torque, i))
            accumulate(state.box_angular_velocity, i, scale(h, turn))


# Times that the angular velocity half-way is found from itself: one gains 2e-4 of the energy in 20 s at 20 rad/s and
# 1/240 s, three 2e-5, and more no less.
MIDPOINTS = 3


@jit_lean
def advance_boxes(model: Model, state: State, h: float, gyroscopic: bool) -> None:
    """Move and turn every box by its velocities over `h` [s]: x' = x + v' h, the velocity first (Euler–Cromer); §5.2.

    (The paper prints x' = x + a t.) Without the gyroscopic torque ω keeps its direction, as in the paper, so an
    asymmetric box in free rotation keeps ω and not I ω. With it the angular momentum L = I ω is what stays, exactly,
    and ω follows from L and the orientation half-way (implicit midpoint rule, by iteration): adding −ω × I ω h to ω
    instead gains energy in every step. A kinematic box keeps both velocities.
    """
    for i in range(state.box_position.shape[0]):
        v, spin = load(state.box_velocity, i), load(state.box_angular_velocity, i)
        is_free = model.box_inverse_mass[i] > 0.0
        if not (is_free or is_moving(v, spin)):
            continue  # static
        for c in range(3):
            state.box_position[i, c] += h * state.box_velocity[i, c]
        q = load_quaternion(state.box_orientation, i)
        if gyroscopic and is_free:
            inverse = load(model.box_inverse_inertia, i)
            momentum = rotate_diagonal(q, (1.0 / inverse[0], 1.0 / inverse[1], 1.0 / inverse[2]), spin)
            for _ in range(MIDPOINTS):
                spin = rotate_diagonal(turned(q, scale(0.5 * h, spin)), inverse, momentum)
            q = turned(q, scale(h, spin))
            store(state.box_angular_velocity, i, rotate_diagonal(q, inverse, momentum))
        else:
            q = turned(q, scale(h, spin))
        for c in range(4):
            state.box_orientation[i, c] = q[c]


ON_TIME = 1e-9  # of a step: the rounding of the time left is less
ARRIVED = -1.0  # for the time left of a box that stops at the end of the step


@jit_lean
def slow_boxes(model: Model, state: State, grounded: np.ndarray | None, h: float) -> None:
    """Let a kinematic box that has less than a step of `h` [s] left go as much slower, so that it is there at its end.

    `grounded` is None where there are no boxes.
    """
    if grounded is None:
        return
    for i in range(state.box_position.shape[0]):
        left = state.box_time_left[i]
        if left > 0.0 and model.box_inverse_mass[i] == 0.0:
            if left > h * (1.0 + ON_TIME):
                state.box_time_left[i] = left - h
            else:
                store(state.box_velocity, i, scale(left / h, load(state.box_velocity, i)))
                store(state.box_angular_velocity, i, scale(left / h, load(state.box_angular_velocity, i)))
                state.box_time_left[i] = ARRIVED


@jit_lean
def stop_boxes(state: State, grounded: np.ndarray | None) -> None:
    """Let boxes stop that have arrived in this step, see `slow_boxes`."""
    if grounded is None:
        return
    for i in range(state.box_position.shape[0]):
        if state.box_time_left[i] < 0.0:
            store(state.box_velocity, i, (0.0, 0.0, 0.0))
            store(state.box_angular_velocity, i, (0.0, 0.0, 0.0))
            state.box_time_left[i] = 0.0


@jit_lean
def is_moving(v: Vec, spin: Vec) -> bool:
    """Tell whether a box of these velocities moves at all."""
    return v[0] != 0.0 or v[1] != 0.0 or v[2] != 0.0 or spin[0] != 0.0 or spin[1] != 0.0 or spin[2] != 0.0


# A box has diverged where one more step would turn it by more than MOST_TURN [rad], or lead so far away from the origin
# that its thinnest side, times RESOLVED, is less than that: it would be lost in rounding.
MOST_TURN, RESOLVED = 1e6, 2.0**46
UNIT = 1e-6  # how far from 1 the square of an orientation's length may be


@jit_lean
def diverged_box(model: Model, state: State, h: float) -> int:
    """Return the first box that has diverged, as seen before one more step of `h` [s], or −1."""
    for i in range(state.box_position.shape[0]):
        far = turn = length = 0.0
        for c in range(3):
            far = far + abs(state.box_position[i, c]) + h * abs(state.box_velocity[i, c])
            turn = turn + h * abs(state.box_angular_velocity[i, c])
        for c in range(4):
            length += state.box_orientation[i, c] ** 2
        size = load(model.box_size, i)
        # Written so that NaN, for which every comparison is false, counts as diverged.
        if not (far <= RESOLVED * min(size[0], size[1], size[2]) and turn <= MOST_TURN and abs(length - 1.0) <= UNIT):
            return i
    return -1


@jit_lean
def shift_boxes(state: State, shift: np.ndarray) -> None:
    """Move every box by `shift` [i, :3] [m] and turn it by [i, 3:] [rad], its velocities untouched."""
    for i in range(state.box_position.shape[0]):
        turn = (shift[i, 3], shift[i, 4], shift[i, 5])
        if shift[i, 0] != 0.0 or shift[i, 1] != 0.0 or shift[i, 2] != 0.0 or norm(turn) > 0.0:
            for c in range(3):
                state.box_position[i, c] += shift[i, c]
            q = turned(load_quaternion(state.box_orientation, i), turn)
            for c in range(4):
                state.box_orientation[i, c] = q[c]


@jit
def turned(q: Quaternion, rotation: Vec) -> Quaternion:
    """Return orientation `q` after the turn by |rotation| [rad] about it, in the world."""
    return normalize_quaternion(product(from_rotation_vector(rotation), q))


@jit
def limit_speeds(model: Model, state: State, settings: Settings) -> None:
    """Cut the speed and the angular speed of every box to their ceilings; paper §6."""
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            v, w = load(state.box_velocity, i), load(state.box_angular_velocity, i)
            if norm(v) > settings.speed_ceiling:
                store(state.box_velocity, i, scale(settings.speed_ceiling / norm(v), v))
            if norm(w) > settings.angular_speed_ceiling:
                store(state.box_angular_velocity, i, scale(settings.angular_speed_ceiling / norm(w), w))


@jit
def limit_boxes(model: Model, state: State, settings: Settings, grounded: np.ndarray | None) -> None:
    """Hold every box to the paper's limits; paper §6. `grounded` (m,) tells which boxes touch the ground.

    Besides its ceilings: one on the ground that turns more slowly than the floor stops turning, and its axes snap to
    the nearest multiples of 90°.
    """
    if grounded is None:
        return
    limit_speeds(model, state, settings)
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            w = load(state.box_angular_velocity, i)
            if grounded[i] and norm(w) < settings.angular_speed_floor:
                store(state.box_angular_velocity, i, (0.0, 0.0, 0.0))
                q = nearest_right_angles(load_quaternion(state.box_orientation, i))
                for c in range(4):
                    state.box_orientation[i, c] = q[c]


@jit
def nearest_right_angles(q: Quaternion) -> Quaternion:
    """Return the one of the 24 orientations of a cube that takes the least turn from `q`.

    As quaternions, up to sign: one component 1; two of √½; or all of ½. The nearest has the largest product with q.
    """
    sizes = (abs(q[0]), abs(q[1]), abs(q[2]), abs(q[3]))
    largest = 0
    for c in range(1, 4):
        if sizes[c] > sizes[largest]:
            largest = c
    second = 1 if largest == 0 else 0
    for c in range(4):
        if c != largest and sizes[c] > sizes[second]:
            second = c
    one = sizes[largest]
    two = sqrt(0.5) * (sizes[largest] + sizes[second])
    four = 0.5 * (sizes[0] + sizes[1] + sizes[2] + sizes[3])
    result = np.zeros(4)
    for c in range(4):
        sign = 1.0 if q[c] >= 0.0 else -1.0
        if one >= two and one >= four:
            result[c] = sign if c == largest else 0.0
        elif two >= four:
            result[c] = sign * sqrt(0.5) if c in (largest, second) else 0.0
        else:
            result[c] = 0.5 * sign
    return result[0], result[1], result[2], result[3]
