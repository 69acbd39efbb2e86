"""Mobility of boxes that soft bodies press on, if they stand on something, and what holds them.

Alone a box would go by its own mass, however light; on the ground, or on boxes that stand on it, it cannot. How it can
move is found from the push itself: supports that this does not open hold the box along their normals, and leave all
other motions as they are. What they hold goes down from support to support, and adds to what the contacts there carry.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.contact import Contacts
from softbody.collision.impulse import inverse_effective_mass
from softbody.collision.solver.solver_row import NORMAL_IMPULSE, TARGET
from softbody.collision.solver.sweep_order import sweep_order
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.quaternion import load_quaternion, rotate_diagonal
from softbody.linalg.vec import Vec, add, cross, dot, load, scale, sub
from softbody.model.arrays import RigidBodies

# Sweeps over the supports of one box at most, and the part of the largest correction that is not worth another one.
SWEEPS, CLOSE = 200, 1e-12

# The part of the speeds that a push gives a free box at its supports below which these are not opening, and the part of
# its mobility along a support's normal below which others hold it there already: both far above rounding.
OPENING, HELD = 1e-9, 1e-9


class Supports(NamedTuple):
    """What carries boxes: contacts, or gaps that this step closes, with bodies nearer to something that cannot move."""

    level: np.ndarray  # (m + 1,) see `SweepOrder`
    contact: np.ndarray  # (c,) those of the box that is asked
    impulse: np.ndarray  # (c,) of each, in answer to a push [N s]


@jit
def box_mobilities(contacts: Contacts, bodies: RigidBodies, push: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (m, 6, 6): the motion of each box, v [m/s] and ω [rad/s], by a unit push; and (m,): whether it is held.

    A push is an impulse [N s] and its moment about the box's centre [N m s]. Supports hold along their normals, both
    ways, what `push` (m, 6) presses on them; the bodies below count as held. What is not pushed is free.
    """
    count = bodies.inverse_mass.shape[0]
    mobility, stands = np.zeros((count, 6, 6)), np.zeros(count, np.bool_)
    for box in range(count):
        _set_free(bodies, box, mobility[box])
    if contacts.number[1] == 0 or not push.any():
        return mobility, stands
    supports = _supports(contacts, bodies)
    for box in range(count):
        if 0 < supports.level[box] <= count and push[box].any():
            stands[box] = _hold(contacts, bodies, box, supports, push[box], mobility[box])
    return mobility, stands


@jit_lean
def motion_by(mobility: np.ndarray, impulse: Vec, moment: Vec) -> tuple[Vec, Vec]:
    """Return the motion, v [m/s] and ω [rad/s], that a push gives a box of a mobility (6, 6)."""
    return (
        (
            _times(mobility, 0, impulse, moment),
            _times(mobility, 1, impulse, moment),
            _times(mobility, 2, impulse, moment),
        ),
        (
            _times(mobility, 3, impulse, moment),
            _times(mobility, 4, impulse, moment),
            _times(mobility, 5, impulse, moment),
        ),
    )


@jit_lean
def _times(matrix: np.ndarray, row: int, a: Vec, b: Vec) -> float:
    first = matrix[row, 0] * a[0] + matrix[row, 1] * a[1] + matrix[row, 2] * a[2]
    return first + (matrix[row, 3] * b[0] + matrix[row, 4] * b[1] + matrix[row, 5] * b[2])


@jit_lean
def keep_what_is_held(bodies: RigidBodies, mobility: np.ndarray, stands: np.ndarray, push: np.ndarray) -> None:
    """Take from `push` (m, 6) what moves boxes by their `mobility` (m, 6, 6), so that what supports hold is left."""
    for box in range(stands.shape[0]):
        if not stands[box]:
            push[box] = 0.0
            continue
        orientation, inertia = load_quaternion(bodies.orientation, box), load(bodies.inverse_inertia, box)
        v, w = motion_by(mobility[box], load(push, box), (push[box, 3], push[box, 4], push[box, 5]))
        moment = rotate_diagonal(orientation, (1.0 / inertia[0], 1.0 / inertia[1], 1.0 / inertia[2]), w)
        for c in range(3):
            push[box, c] -= v[c] / bodies.inverse_mass[box]
            push[box, 3 + c] -= moment[c]


@jit_lean
def _set_free(bodies: RigidBodies, box: int, mobility: np.ndarray) -> None:
    """Set the mobility (6, 6), zero so far, of a box that nothing holds."""
    orientation, inverse_inertia = load_quaternion(bodies.orientation, box), load(bodies.inverse_inertia, box)
    for c in range(3):
        mobility[c, c] = bodies.inverse_mass[box]
        unit = (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)
        spin = rotate_diagonal(orientation, inverse_inertia, unit)
        for r in range(3):
            mobility[3 + r, 3 + c] = spin[r]


@jit_lean
def _hold(
    contacts: Contacts, bodies: RigidBodies, box: int, supports: Supports, push: np.ndarray, mobility: np.ndarray
) -> bool:
    """Take from a box's mobility (6, 6) the motions that its supports hold; tell whether any does."""
    number, any_holds, fastest = _list_supports(contacts, box, supports), False, 0.0
    v, w = _motion_alone(bodies, box, push)
    for place in range(number):
        fastest = max(fastest, abs(_opening(contacts, bodies, box, supports.contact[place], v, w)))
    v, w = _held_motion(contacts, bodies, box, supports, number, (v, w))
    for place in range(number):
        k = supports.contact[place]
        if supports.impulse[place] > 0.0 or _opening(contacts, bodies, box, k, v, w) <= OPENING * fastest:
            _fix(contacts, bodies, box, k, mobility)
            any_holds = True
    return any_holds


@jit_lean
def _opening(contacts: Contacts, bodies: RigidBodies, box: int, k: int, v: Vec, w: Vec) -> float:
    """Return how fast a box that moves by v and ω parts from what carries it at contact `k` [m/s]."""
    arm = sub(load(contacts.point, k), load(bodies.position, box))
    return dot(add(v, cross(w, arm)), _normal_to(contacts, k, box))


@jit_lean
def _fix(contacts: Contacts, bodies: RigidBodies, box: int, k: int, mobility: np.ndarray) -> None:
    """Take from a box's mobility (6, 6) all motion along the normal of contact `k`."""
    normal, arm = _normal_to(contacts, k, box), sub(load(contacts.point, k), load(bodies.position, box))
    orientation, inverse_inertia = load_quaternion(bodies.orientation, box), load(bodies.inverse_inertia, box)
    free = inverse_effective_mass(arm, normal, bodies.inverse_mass[box], inverse_inertia, orientation)
    v, w = motion_by(mobility, normal, cross(arm, normal))
    left = dot(add(v, cross(w, arm)), normal)
    if left <= HELD * free:
        return
    motion = (v[0], v[1], v[2], w[0], w[1], w[2])
    for r in range(6):
        for c in range(6):
            mobility[r, c] -= motion[r] * motion[c] / left


@jit
def pass_down(contacts: Contacts, bodies: RigidBodies, push: np.ndarray, motion: np.ndarray) -> None:
    """Let supports hold boxes that are pushed, by `push` (m, 6), from above down to what cannot move.

    Adds to the pushes on boxes below, to the normal impulses of contacts, and to `motion` (m + 1, 6) what is not held.
    """
    count = bodies.inverse_mass.shape[0]
    supports = _supports(contacts, bodies)
    highest = 0
    for box in range(count):
        if supports.level[box] <= count:  # what stands on nothing is not held, and has no such push
            highest = max(highest, supports.level[box])
    for height in range(highest, 0, -1):
        for box in range(count):
            if supports.level[box] != height or not push[box].any():
                continue
            number = _list_supports(contacts, box, supports)
            v, w = _held_motion(contacts, bodies, box, supports, number, _motion_alone(bodies, box, push[box]))
            for c in range(3):
                motion[box, c] += v[c]
                motion[box, 3 + c] += w[c]
            for place in range(number):
                k, impulse = supports.contact[place], supports.impulse[place]
                contacts.row[k, NORMAL_IMPULSE] += impulse
                other = contacts.box[k, 1] if contacts.box[k, 0] == box else contacts.box[k, 0]
                if supports.level[other] > 0:
                    arm = sub(load(contacts.point, k), load(bodies.position, other))
                    add_push(push, other, arm, scale(-impulse, _normal_to(contacts, k, box)))


@jit_lean
def add_push(push: np.ndarray, box: int, arm: Vec, impulse: Vec) -> None:
    """Add an impulse [N s] at `arm` [m] from a box's centre to what pushes that box: (m, 6), with its moment."""
    moment = cross(arm, impulse)
    for c in range(3):
        push[box, c] += impulse[c]
        push[box, 3 + c] += moment[c]


@jit
def _supports(contacts: Contacts, bodies: RigidBodies) -> Supports:
    number = contacts.number[1]
    return Supports(sweep_order(contacts, bodies).level, np.empty(number, np.int64), np.empty(number))


@jit_lean
def _list_supports(contacts: Contacts, box: int, supports: Supports) -> int:
    """List the contacts that carry a box; return how many."""
    number = 0
    for k in range(contacts.number[1]):
        a, b = contacts.box[k, 0], contacts.box[k, 1]
        stays_open = contacts.row[k, TARGET] < 0.0 and contacts.row[k, NORMAL_IMPULSE] == 0.0
        if (a == box or b == box) and not stays_open and supports.level[b if a == box else a] < supports.level[box]:
            supports.contact[number] = k
            number += 1
    return number


@jit_lean
def _normal_to(contacts: Contacts, k: int, box: int) -> Vec:
    """Return the normal of contact `k`, towards one of its two boxes."""
    return scale(1.0 if contacts.box[k, 0] == box else -1.0, load(contacts.normal, k))


@jit_lean
def _motion_alone(bodies: RigidBodies, box: int, push: np.ndarray) -> tuple[Vec, Vec]:
    """Return what a push makes of a free box that rests: v [m/s] and ω [rad/s]."""
    orientation, inverse_inertia = load_quaternion(bodies.orientation, box), load(bodies.inverse_inertia, box)
    v = scale(bodies.inverse_mass[box], (push[0], push[1], push[2]))
    return v, rotate_diagonal(orientation, inverse_inertia, (push[3], push[4], push[5]))


@jit_lean
def _held_motion(
    contacts: Contacts, bodies: RigidBodies, box: int, supports: Supports, number: int, motion: tuple[Vec, Vec]
) -> tuple[Vec, Vec]:
    """Return what is left of a `motion`, (v, ω), of a box by `number` supports, and write what they push."""
    orientation, inverse_inertia = load_quaternion(bodies.orientation, box), load(bodies.inverse_inertia, box)
    v, w = motion
    for place in range(number):
        supports.impulse[place] = 0.0
    first = 0.0
    for _ in range(SWEEPS if number else 0):
        most = 0.0
        for place in range(number):
            k = supports.contact[place]
            normal, arm = _normal_to(contacts, k, box), sub(load(contacts.point, k), load(bodies.position, box))
            yielding = inverse_effective_mass(arm, normal, bodies.inverse_mass[box], inverse_inertia, orientation)
            before = supports.impulse[place]
            supports.impulse[place] = max(0.0, before - dot(add(v, cross(w, arm)), normal) / yielding)
            change = supports.impulse[place] - before
            v = add(v, scale(bodies.inverse_mass[box] * change, normal))
            w = add(w, rotate_diagonal(orientation, inverse_inertia, cross(arm, scale(change, normal))))
            most = max(most, abs(change) * yielding)
        first = max(first, most)
        if most <= CLOSE * first:
            break
    return v, w
