"""Compliance of boxes that soft bodies press on, if they stand on something, and what holds them.

Alone a box would go by its own mass, however light; on the ground, or on boxes that stand on it, it cannot. What it can
is found from the push itself: as much of the motion that the push would give to the free box as its supports leave. The
rest goes down from support to support, and adds to what the contacts there carry.
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


class Supports(NamedTuple):
    """What carries boxes: contacts, or gaps that this step closes, with bodies nearer to something that cannot move."""

    level: np.ndarray  # (m + 1,) see `SweepOrder`
    contact: np.ndarray  # (c,) those of the box that is asked
    impulse: np.ndarray  # (c,) of each, in answer to a push [N s]


@jit
def support_compliance(contacts: Contacts, bodies: RigidBodies, push: np.ndarray) -> np.ndarray:
    """Return (m,): the part, 0 … 1, of the motion of each box alone that its supports leave to a `push` (m, 6).

    A push is an impulse [N s] and its moment about the box's centre [N m s]. The bodies below count as held.
    """
    count = bodies.inverse_mass.shape[0]
    loose = np.ones(count)
    if contacts.number[1] == 0 or not push.any():
        return loose
    supports = _supports(contacts, bodies)
    for box in range(count):
        if 0 < supports.level[box] <= count and push[box].any():
            number = _list_supports(contacts, box, supports)
            v, w = _motion_alone(bodies, box, push[box])
            alone = _work(push[box], v, w)
            v, w = _held_motion(contacts, bodies, box, supports, number, (v, w))
            loose[box] = min(1.0, max(0.0, _work(push[box], v, w) / alone))
    return loose


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
def _work(push: np.ndarray, v: Vec, w: Vec) -> float:
    return dot((push[0], push[1], push[2]), v) + dot((push[3], push[4], push[5]), w)


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
