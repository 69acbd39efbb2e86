"""Sleep: bodies that have been slow for long, with all that they touch, cost nothing until something wakes them.

A body is slow while the root mean square of the speeds of its mass is at most `sleep_speed`. Bodies whose bounds meet
are an island, and so are bodies that are joined: it sleeps as a whole, once all of it has been slow for `sleep_after`.
So whatever comes near wakes what it may push, and all that leans on that, before it is there; and when it has passed,
they sleep on. What a user changes of a body, or of what acts on it, ends its rest.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.collision.broad_phase import near_pairs
from softbody.compiler.jit import jit, jit_lean
from softbody.dynamics.rigid_boxes import is_moving
from softbody.geometry.aabb import bounding_box
from softbody.geometry.box import box_corners
from softbody.geometry.sphere import bounding_spheres
from softbody.linalg.quaternion import load_quaternion, rotate_inverse
from softbody.linalg.vec import dot, load, norm, store
from softbody.model.arrays import NOBODY, Controls, Joints, Model, State, copy_boxes, copy_particles
from softbody.model.settings import Settings
from softbody.model.sleep_state import SleepState, is_settled
from softbody.stepping.finite_check import MASK, checksum

STILL = (0.0, 0.0, 0.0)

# Bodies are near where less than this part of their radii is between their bounds: what leans on another is a rounding
# away from it at times.
GAP = 0.01


@jit
def let_sleep(
    model: Model, state: State, joints: Joints | None, rest: SleepState | None, settings: Settings, h: float
) -> bool:
    """Decide who sleeps in the next step of `h` [s]; tell whether nobody has moved in the last one, nor will.

    `rest` is None where nobody may sleep.
    """
    if rest is None:
        return False
    soft, asleep = model.soft_count, rest.asleep
    somebody_sleeps, nobody_moves = False, True
    for body in range(asleep.shape[0]):
        slept = rest.settled[body] or _stands(model, state, rest, body)
        is_free = body < soft or rest.box_inverse_mass[body - soft] > 0.0
        asleep[body] = is_free and rest.time[body] > 0.0 and rest.time[body] >= settings.sleep_after
        somebody_sleeps |= asleep[body]
        nobody_moves &= slept and (asleep[body] or _stands(model, state, rest, body))
    if somebody_sleeps and not nobody_moves:
        _wake_islands(model, state, joints, rest, h)
    for body in range(asleep.shape[0]):
        rest.settled[body] &= asleep[body]
    for box in range(model.box_count):
        model.box_inverse_mass[box] = 0.0 if asleep[soft + box] else rest.box_inverse_mass[box]
    return nobody_moves


@jit_lean
def _stands(model: Model, state: State, rest: SleepState, body: int) -> bool:
    """Tell whether a body is a box without mass that does not move."""
    box = body - model.soft_count
    return (
        box >= 0
        and rest.box_inverse_mass[box] == 0.0
        and not is_moving(load(state.box_velocity, box), load(state.box_angular_velocity, box))
    )


@jit
def _wake_islands(model: Model, state: State, joints: Joints | None, rest: SleepState, h: float) -> None:
    """Let nobody sleep whom somebody awake, on his way in a step of `h` [s], may touch, or holds by a joint."""
    radius, takes_part = np.empty_like(rest.radius), np.empty_like(rest.asleep)
    margin = np.empty_like(radius)
    for body in range(radius.shape[0]):
        takes_part[body] = not _stands(model, state, rest, body)
        margin[body] = 0.0
        if not rest.settled[body]:
            _find_bounds(model, state, rest, body)
            margin[body] = h * _fastest(model, state, body, rest.radius[body])
        margin[body] += GAP * rest.radius[body]
        radius[body] = rest.radius[body] + margin[body]
    pairs = near_pairs(rest.centre, radius, takes_part)
    woken = True
    while woken:
        woken = False
        for k in range(pairs.shape[0]):
            a, b = pairs[k, 0], pairs[k, 1]
            if _bounds_meet(rest, a, b, margin[a] + margin[b]):
                woken |= _wake_together(rest, takes_part, a, b)
        if joints is not None:
            for k in range(joints.joint_box.shape[0]):
                a, b = _body_at_end(model, joints, k, 0), _body_at_end(model, joints, k, 1)
                if a != NOBODY and b != NOBODY:
                    woken |= _wake_together(rest, takes_part, a, b)


@jit_lean
def _wake_together(rest: SleepState, takes_part: np.ndarray, a: int, b: int) -> bool:
    """Let neither of two bodies sleep of which one is awake; tell whether the other slept."""
    if rest.asleep[a] == rest.asleep[b] or not (takes_part[a] and takes_part[b]):
        return False
    rest.asleep[a] = rest.asleep[b] = False
    return True


@jit_lean
def _body_at_end(model: Model, joints: Joints, joint: int, end: int) -> int:
    """Return the body that one end of a joint is on, or NOBODY: it is in the world."""
    if joints.joint_box[joint, end] != NOBODY:
        return model.soft_count + joints.joint_box[joint, end]
    particle, body = joints.joint_particles[joint, 3 * end], 0
    if joints.joint_inside[joint, 2 * end] != NOBODY:
        particle = joints.suspension_particles[joints.joint_inside[joint, 2 * end], 0]
    if particle == NOBODY:
        return NOBODY
    while model.soft_particle_start[body + 1] <= particle:
        body += 1
    return body


@jit_lean
def _fastest(model: Model, state: State, body: int, radius: float) -> float:
    """Return a speed [m/s] that no point of a body, of this `radius` [m], exceeds."""
    box = body - model.soft_count
    if box >= 0:
        return norm(load(state.box_velocity, box)) + radius * norm(load(state.box_angular_velocity, box))
    square = 0.0
    for i in range(model.soft_particle_start[body], model.soft_particle_start[body + 1]):
        v = load(state.particle_velocity, i)
        square = max(square, dot(v, v))
    return sqrt(square)


@jit
def _find_bounds(model: Model, state: State, rest: SleepState, body: int) -> None:
    """Note the bounding sphere and the bounding box of a body."""
    box = body - model.soft_count
    if box < 0:
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        low, high = bounding_box(state.particle_position[first:end])
        bounding_spheres(
            state.particle_position,
            model.soft_particle_start[body : body + 2],
            rest.centre[body : body + 1],
            rest.radius[body : body + 1],
        )
    else:
        size, position = load(model.box_size, box), load(state.box_position, box)
        low, high = bounding_box(box_corners(size, position, load_quaternion(state.box_orientation, box)))
        store(rest.centre, body, position)
        rest.radius[body] = 0.5 * norm(size)
    store(rest.low, body, low)
    store(rest.high, body, high)


@jit_lean
def _bounds_meet(rest: SleepState, a: int, b: int, margin: float) -> bool:
    """Tell whether the bounding boxes of two bodies are nowhere more than a `margin` [m] apart."""
    for c in range(3):
        if rest.low[a, c] - rest.high[b, c] > margin or rest.low[b, c] - rest.high[a, c] > margin:
            return False
    return True


@jit_lean
def begin_step(model: Model, state: State, start: State, impulse: np.ndarray, rest: SleepState | None) -> None:
    """Note in `start` how all bodies begin a step, and let those who sleep stand still; see `sleep.let_sleep`.

    `impulse` (n, 3) [N s] of the ground in the last step: none acts on those who sleep.
    """
    for body in range(model.soft_count):
        if not is_settled(rest, body):
            copy_particles(state, start, model.soft_particle_start[body], model.soft_particle_start[body + 1])
    copy_boxes(state, start)
    if rest is None:
        return
    for body in range(model.soft_count):
        if rest.asleep[body] and not rest.settled[body]:
            for i in range(model.soft_particle_start[body], model.soft_particle_start[body + 1]):
                store(state.particle_velocity, i, STILL)
                store(impulse, i, STILL)
    for box in range(model.box_count):
        if rest.asleep[model.soft_count + box]:
            store(state.box_velocity, box, STILL)
            store(state.box_angular_velocity, box, STILL)


@jit_lean
def note_rest(model: Model, state: State, rest: SleepState | None, settings: Settings, h: float) -> None:
    """Count for how long each body has been slow, after a step of `h` [s]."""
    if rest is None:
        return
    most = settings.sleep_speed * settings.sleep_speed
    for body in range(rest.time.shape[0]):
        is_slow = rest.asleep[body] or _square_of_speed(model, state, rest, body) <= most
        rest.time[body] = rest.time[body] + h if is_slow else 0.0
        rest.settled[body] = rest.asleep[body]


@jit_lean
def _square_of_speed(model: Model, state: State, rest: SleepState, body: int) -> float:
    """Return the mean square of the speeds [m²/s²] of the mass of a body: twice its kinetic energy by its mass."""
    square, box = 0.0, body - model.soft_count
    if box < 0:
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        for i in range(first, end):
            v = load(state.particle_velocity, i)
            square += dot(v, v)
        return square / (end - first)
    v, spin = load(state.box_velocity, box), load(state.box_angular_velocity, box)
    spin, size = rotate_inverse(load_quaternion(state.box_orientation, box), spin), load(model.box_size, box)
    # Of its gyration about each axis, a twelfth of the squares of the sides across it.
    for axis in range(3):
        one, other = size[(axis + 1) % 3], size[(axis + 2) % 3]
        square += spin[axis] * spin[axis] * (one * one + other * other) / 12.0
    return square + dot(v, v)


@jit
def wake_changed(
    model: Model, controls: Controls, state: State, joints: Joints | None, rest: SleepState | None
) -> None:
    """End the rest of those of whom something has changed since `mark_sleepers`."""
    if rest is None:
        return
    before, bodies = rest.mark.copy(), rest.time.shape[0]
    mark_sleepers(model, controls, state, joints, rest)
    wakes_all = rest.mark[-1] != before[-1]
    for body in range(bodies):
        if rest.mark[body] != before[body]:
            rest.time[body] = 0.0
            wakes_all |= not rest.asleep[body]  # something without mass, which may have held others, is elsewhere
    if joints is not None:
        for k in range(joints.joint_box.shape[0]):
            for end in range(2):
                body = _body_at_end(model, joints, k, end)
                if rest.mark[bodies + k] != before[bodies + k] and body != NOBODY:
                    rest.time[body] = 0.0
    for body in range(bodies):
        if wakes_all:
            rest.time[body] = 0.0


@jit_lean
def mark_sleepers(
    model: Model, controls: Controls, state: State, joints: Joints | None, rest: SleepState | None
) -> None:
    """Note how those who sleep, boxes without mass, joints, and gravity are left."""
    if rest is None:
        return
    soft, bodies = model.soft_count, rest.time.shape[0]
    for body in range(bodies):
        box = body - soft
        if box >= 0 and rest.box_inverse_mass[box] == 0.0:
            rest.mark[body] = _mark_of_pose(state, box)
        elif not rest.asleep[body]:
            rest.mark[body] = 0
        else:
            rest.mark[body] = (
                _mark_of_soft(model, controls, state, body) if box < 0 else _mark_of_box(controls, state, box)
            )
    if joints is not None:
        for k in range(joints.joint_box.shape[0]):
            rest.mark[bodies + k] = _mark_of_joint(joints, k)
    rest.mark[-1] = checksum(controls.gravity)


@jit_lean
def _mark_of_soft(model: Model, controls: Controls, state: State, body: int) -> int:
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    mark = checksum(state.particle_position[first:end])
    mark = _and(mark, checksum(state.particle_velocity[first:end]))
    mark = _and(mark, checksum(controls.soft_gas[body : body + 1]))
    if controls.particle_force.shape[0] > 0:
        force = controls.particle_force[first:end]
        for i in range(force.shape[0]):
            if norm(load(force, i)) != 0.0:  # none is the same as no array of them
                return _and(mark, checksum(force))
    return mark


@jit_lean
def _mark_of_box(controls: Controls, state: State, box: int) -> int:
    mark = _and(_mark_of_pose(state, box), checksum(state.box_velocity[box]))
    mark = _and(mark, checksum(state.box_angular_velocity[box]))
    return _and(_and(mark, checksum(controls.box_force[box])), checksum(controls.box_torque[box]))


@jit_lean
def _mark_of_pose(state: State, box: int) -> int:
    return _and(checksum(state.box_position[box]), checksum(state.box_orientation[box]))


@jit_lean
def _mark_of_joint(joints: Joints, k: int) -> int:
    mark = _and(checksum(joints.joint_place[k]), checksum(joints.joint_stiffness[k : k + 1]))
    mark = _and(mark, checksum(joints.joint_damping[k : k + 1]))
    return _and(mark, checksum(joints.joint_rest_length[k : k + 1]))


@jit_lean
def _and(mark: int, other: int) -> int:
    """Return a mark that two others show in."""
    return (31 * mark + other) & MASK
