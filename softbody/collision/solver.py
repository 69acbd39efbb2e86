"""Which impulses at all contacts together part the bodies, hold them, and let them slide?

Sequential impulses (Catto 2005): contact by contact, in the order of the list, each impulse is corrected to what its
contact asks for, given all the others; the sums are kept within their bounds, not the corrections. This is a projected
Gauss–Seidel method on the velocities, and converges to the solution of the complementarity problem. Depths are undone
by a second, like solve for displacements, which no velocity ever feels.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.contacts import Contacts
from softbody.collision.impulse import NOBODY
from softbody.jit import compile_apart, jit
from softbody.quaternion import load_quaternion, rotate_diagonal
from softbody.state import RigidBodies
from softbody.vec import Vec, load

# Columns of a contact's row. Directions: the normal, and two tangents.
NORMAL, TANGENT, SECOND, ARM_A, ARM_B = 0, 3, 6, 9, 12
GIVE, SLIP, TARGET, APPROACH = 15, 16, 17, 18  # speed an impulse gives [m/s per N s]; speeds after and before [m/s]
PUSH, DRAG, DRAG2, SHIFT = 19, 20, 21, 22  # impulses so far [N s]; the displacements' [kg m]

# The part of a depth that one step undoes. All at once would let a pile that is not solved to the end jump.
RECOVERY = 0.2


@jit
def inverse_masses(bodies: RigidBodies) -> np.ndarray:
    """Return (m + 1, 10): 1/m and R I⁻¹ Rᵀ, row by row, of each body; the last row is the ground's, zeros."""
    compile_apart()
    count = bodies.inverse_mass.shape[0]
    result = np.zeros((count + 1, 10))
    for i in range(count):
        if bodies.inverse_mass[i] > 0.0:
            result[i, 0] = bodies.inverse_mass[i]
            q, inverse = load_quaternion(bodies.orientation, i), load(bodies.inverse_inertia, i)
            for k in range(3):
                unit = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
                column = rotate_diagonal(q, inverse, unit)
                result[i, 1 + k] = column[0]
                result[i, 4 + k] = column[1]
                result[i, 7 + k] = column[2]
    return result


@jit
def load_motion(bodies: RigidBodies) -> np.ndarray:
    """Return (m + 1, 6): v [m/s] and ω [rad/s] of each body; the last row is the ground's, zeros."""
    count = bodies.inverse_mass.shape[0]
    motion = np.zeros((count + 1, 6))
    motion[:count, :3] = bodies.velocity
    motion[:count, 3:] = bodies.angular_velocity
    return motion


@jit
def store_motion(bodies: RigidBodies, motion: np.ndarray) -> None:
    """Write velocities back to the bodies that can move."""
    for i in range(bodies.inverse_mass.shape[0]):
        if bodies.inverse_mass[i] > 0.0:
            for c in range(3):
                bodies.velocity[i, c] = motion[i, c]
                bodies.angular_velocity[i, c] = motion[i, 3 + c]


@jit
def _cross(row: np.ndarray, k: int, arm: int, direction: int) -> Vec:
    r0, r1, r2 = row[k, arm], row[k, arm + 1], row[k, arm + 2]
    d0, d1, d2 = row[k, direction], row[k, direction + 1], row[k, direction + 2]
    return r1 * d2 - r2 * d1, r2 * d0 - r0 * d2, r0 * d1 - r1 * d0


@jit
def _turn(inverse: np.ndarray, i: int, t: Vec) -> Vec:
    """Return I⁻¹ t."""
    return (
        inverse[i, 1] * t[0] + inverse[i, 2] * t[1] + inverse[i, 3] * t[2],
        inverse[i, 4] * t[0] + inverse[i, 5] * t[1] + inverse[i, 6] * t[2],
        inverse[i, 7] * t[0] + inverse[i, 8] * t[1] + inverse[i, 9] * t[2],
    )


@jit
def _coupling(row: np.ndarray, k: int, inverse: np.ndarray, a: int, b: int, first: int, second: int) -> float:
    """Return the speed [m/s per N s] along one direction that an impulse along another one gives its contact."""
    result = 0.0
    if first == second:
        result = inverse[a, 0] + inverse[b, 0]
    turn = _turn(inverse, a, _cross(row, k, ARM_A, second))
    twist = _cross(row, k, ARM_A, first)
    result += twist[0] * turn[0] + twist[1] * turn[1] + twist[2] * turn[2]
    turn = _turn(inverse, b, _cross(row, k, ARM_B, second))
    twist = _cross(row, k, ARM_B, first)
    return result + twist[0] * turn[0] + twist[1] * turn[1] + twist[2] * turn[2]


@jit
def relative_velocity(row: np.ndarray, k: int, motion: np.ndarray, a: int, b: int) -> Vec:
    """Return the velocity [m/s] of a's point of contact `k` seen from b's."""
    a0, a1, a2 = row[k, ARM_A], row[k, ARM_A + 1], row[k, ARM_A + 2]
    b0, b1, b2 = row[k, ARM_B], row[k, ARM_B + 1], row[k, ARM_B + 2]
    return (
        motion[a, 0] + motion[a, 4] * a2 - motion[a, 5] * a1 - motion[b, 0] - motion[b, 4] * b2 + motion[b, 5] * b1,
        motion[a, 1] + motion[a, 5] * a0 - motion[a, 3] * a2 - motion[b, 1] - motion[b, 5] * b0 + motion[b, 3] * b2,
        motion[a, 2] + motion[a, 3] * a1 - motion[a, 4] * a0 - motion[b, 2] - motion[b, 3] * b1 + motion[b, 4] * b0,
    )


@jit
def _push(row: np.ndarray, k: int, motion: np.ndarray, inverse: np.ndarray, a: int, b: int, p: Vec) -> None:
    """Give a the impulse `p` [N s] at contact `k`, and b its opposite."""
    a0, a1, a2 = row[k, ARM_A], row[k, ARM_A + 1], row[k, ARM_A + 2]
    turn = _turn(inverse, a, (a1 * p[2] - a2 * p[1], a2 * p[0] - a0 * p[2], a0 * p[1] - a1 * p[0]))
    for c in range(3):
        motion[a, c] += inverse[a, 0] * p[c]
        motion[a, 3 + c] += turn[c]
    if inverse[b, 0] > 0.0:
        b0, b1, b2 = row[k, ARM_B], row[k, ARM_B + 1], row[k, ARM_B + 2]
        turn = _turn(inverse, b, (b1 * p[2] - b2 * p[1], b2 * p[0] - b0 * p[2], b0 * p[1] - b1 * p[0]))
        for c in range(3):
            motion[b, c] -= inverse[b, 0] * p[c]
            motion[b, 3 + c] -= turn[c]


@jit
def _along(row: np.ndarray, k: int, direction: int, u: Vec) -> float:
    return row[k, direction] * u[0] + row[k, direction + 1] * u[1] + row[k, direction + 2] * u[2]


@jit
def prepare_contacts(contacts: Contacts, bodies: RigidBodies, inverse: np.ndarray) -> None:
    """Fill in the solver's row of each contact, from where the bodies are and how they move before the step."""
    compile_apart()
    motion = load_motion(bodies)
    row = contacts.row
    ground = bodies.inverse_mass.shape[0]
    for k in range(contacts.count[0]):
        a, b = contacts.body[k, 0], contacts.body[k, 1]
        n0, n1, n2 = contacts.normal[k, 0], contacts.normal[k, 1], contacts.normal[k, 2]
        # Any two tangents do; these turn with the normal except where its smallest component changes.
        if abs(n0) <= abs(n1) and abs(n0) <= abs(n2):
            t0, t1, t2 = 0.0, n2, -n1
        elif abs(n1) <= abs(n2):
            t0, t1, t2 = -n2, 0.0, n0
        else:
            t0, t1, t2 = n1, -n0, 0.0
        length = np.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
        t0, t1, t2 = t0 / length, t1 / length, t2 / length
        row[k, 0], row[k, 1], row[k, 2] = n0, n1, n2
        row[k, 3], row[k, 4], row[k, 5] = t0, t1, t2
        row[k, 6], row[k, 7], row[k, 8] = n1 * t2 - n2 * t1, n2 * t0 - n0 * t2, n0 * t1 - n1 * t0
        for c in range(3):
            row[k, ARM_A + c] = contacts.point[k, c] - bodies.position[a, c]
            row[k, ARM_B + c] = 0.0 if b == NOBODY else contacts.point[k, c] - bodies.position[b, c]
        if b == NOBODY:
            b = ground
        row[k, GIVE] = _coupling(row, k, inverse, a, b, NORMAL, NORMAL)
        k11 = _coupling(row, k, inverse, a, b, TANGENT, TANGENT)
        k12 = _coupling(row, k, inverse, a, b, TANGENT, SECOND)
        k22 = _coupling(row, k, inverse, a, b, SECOND, SECOND)
        # The most that friction in any direction can give.
        row[k, SLIP] = 0.5 * (k11 + k22) + np.sqrt(0.25 * (k11 - k22) * (k11 - k22) + k12 * k12)
        row[k, APPROACH] = -_along(row, k, NORMAL, relative_velocity(row, k, motion, a, b))


@jit
def solve_velocities(
    contacts: Contacts, bodies: RigidBodies, inverse: np.ndarray, h: float, iterations: int, enough: float
) -> None:
    """Change the velocities so that at every contact the bodies part, rest or slide as they must.

    A contact that closes within `h` [s] must part with e times the speed that it closed at *before* this step's
    gravity and forces: so what rests does not hop, and a ball of e = 1 keeps its energy to the last bit. A gap that
    stays open may close, but no further. Friction is bounded by μ times the normal impulse, in every direction alike.
    Ends after `iterations` sweeps, or after one that changed no speed at a contact by more than `enough` [m/s].
    """
    compile_apart()
    motion = load_motion(bodies)
    row = contacts.row
    ground = bodies.inverse_mass.shape[0]
    count = contacts.count[0]
    for k in range(count):
        a, b = contacts.body[k, 0], contacts.body[k, 1]
        b = ground if b == NOBODY else b
        closing = -_along(row, k, NORMAL, relative_velocity(row, k, motion, a, b))
        gap = max(0.0, -contacts.depth[k])
        row[k, TARGET] = -gap / h
        if closing * h > gap and row[k, APPROACH] > 0.0 and contacts.restitution[k] > 0.0:
            row[k, TARGET] = contacts.restitution[k] * row[k, APPROACH]
    for k in range(count):
        a, b = contacts.body[k, 0], contacts.body[k, 1]
        b = ground if b == NOBODY else b
        p = load(contacts.impulse, k)
        row[k, PUSH] = max(0.0, _along(row, k, NORMAL, p))
        row[k, DRAG] = _along(row, k, TANGENT, p) if contacts.friction[k] > 0.0 else 0.0
        row[k, DRAG2] = _along(row, k, SECOND, p) if contacts.friction[k] > 0.0 else 0.0
        if row[k, PUSH] > 0.0:
            _push(row, k, motion, inverse, a, b, _impulse(row, k))
        else:
            row[k, DRAG] = row[k, DRAG2] = 0.0
    for _ in range(iterations):
        most = 0.0
        for k in range(count):
            a, b = contacts.body[k, 0], contacts.body[k, 1]
            b = ground if b == NOBODY else b
            u = relative_velocity(row, k, motion, a, b)
            before = row[k, PUSH]
            row[k, PUSH] = max(0.0, before + (row[k, TARGET] - _along(row, k, NORMAL, u)) / row[k, GIVE])
            change = row[k, PUSH] - before
            if change != 0.0:
                most = max(most, abs(change) * row[k, GIVE])
                _push(row, k, motion, inverse, a, b, (change * row[k, 0], change * row[k, 1], change * row[k, 2]))
            if contacts.friction[k] > 0.0 and (before > 0.0 or row[k, PUSH] > 0.0):
                most = max(most, _rub(row, k, motion, inverse, a, b, contacts.friction[k] * row[k, PUSH]))
        if most <= enough:
            break
    for k in range(count):
        p = _impulse(row, k)
        for c in range(3):
            contacts.impulse[k, c] = p[c]
    store_motion(bodies, motion)


@jit
def _impulse(row: np.ndarray, k: int) -> Vec:
    """Return the impulse [N s] on a of contact `k`, in the world."""
    n, s, t = row[k, PUSH], row[k, DRAG], row[k, DRAG2]
    return (
        n * row[k, 0] + s * row[k, 3] + t * row[k, 6],
        n * row[k, 1] + s * row[k, 4] + t * row[k, 7],
        n * row[k, 2] + s * row[k, 5] + t * row[k, 8],
    )


@jit
def _rub(row: np.ndarray, k: int, motion: np.ndarray, inverse: np.ndarray, a: int, b: int, limit: float) -> float:
    """Correct the friction of contact `k` towards rest, within `limit` [N s]; return the change [m/s].

    The correction is along the sliding, by one number for both tangents: with the exact 2 × 2 solve, what the bound
    leaves would not point against the sliding, and a box would slide on by a seventh too far.
    """
    u = relative_velocity(row, k, motion, a, b)
    before, before2 = row[k, DRAG], row[k, DRAG2]
    drag = before - _along(row, k, TANGENT, u) / row[k, SLIP]
    drag2 = before2 - _along(row, k, SECOND, u) / row[k, SLIP]
    square = drag * drag + drag2 * drag2
    if square > limit * limit:
        kept = limit / np.sqrt(square)
        drag, drag2 = kept * drag, kept * drag2
    row[k, DRAG], row[k, DRAG2] = drag, drag2
    s, t = drag - before, drag2 - before2
    if s != 0.0 or t != 0.0:
        _push(
            row, k, motion, inverse, a, b,
            (s * row[k, 3] + t * row[k, 6], s * row[k, 4] + t * row[k, 7], s * row[k, 5] + t * row[k, 8]),
        )  # fmt: skip
    return np.sqrt(s * s + t * t) * row[k, SLIP]


@jit
def solve_displacements(
    contacts: Contacts, bodies: RigidBodies, inverse: np.ndarray, allowed: float, iterations: int
) -> np.ndarray:
    """Return (m + 1, 6) displacements [m] and turns [rad] that undo RECOVERY of each depth beyond `allowed` [m].

    By pushes only. Depths as small as the way that gravity moves a body in one step are what a solve that stops early
    leaves; undoing them too would lift a stack again and again, and feed it energy: ten boxes then never come to rest.
    """
    compile_apart()
    row = contacts.row
    ground = bodies.inverse_mass.shape[0]
    shift = np.zeros((ground + 1, 6))
    deep = np.empty(contacts.count[0], np.int64)
    count = 0
    for k in range(contacts.count[0]):
        if contacts.depth[k] > allowed:
            deep[count] = k
            count += 1
            row[k, SHIFT] = 0.0
    for _ in range(iterations if count else 0):
        for place in range(count):
            k = deep[place]
            a, b = contacts.body[k, 0], contacts.body[k, 1]
            b = ground if b == NOBODY else b
            u = relative_velocity(row, k, shift, a, b)
            before = row[k, SHIFT]
            lack = RECOVERY * (contacts.depth[k] - allowed) - _along(row, k, NORMAL, u)
            row[k, SHIFT] = max(0.0, before + lack / row[k, GIVE])
            change = row[k, SHIFT] - before
            if change != 0.0:
                _push(row, k, shift, inverse, a, b, (change * row[k, 0], change * row[k, 1], change * row[k, 2]))
    return shift
