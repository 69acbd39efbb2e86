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
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion, rotate_diagonal
from softbody.state import RigidBodies
from softbody.vec import Vec, add, cross, dot, load, normalize, scale, sub

# The directions of a contact: its normal and two tangents. In a contact's row, three columns for each direction hold
# the direction d itself; the twists r × d of a and of b; and the turns R I⁻¹ Rᵀ (r × d) of a and of b. With these
# stored, an impulse takes a dozen multiplications a body, a third of what it takes from the arms.
NORMAL, TANGENT, SECOND = 0, 1, 2
TWIST_A, TWIST_B, TURN_A, TURN_B = 9, 18, 27, 36
# Mass that an impulse meets along the normal, and the least one across it [kg]; speeds after and before [m/s].
MASS, DRAG_MASS, TARGET, APPROACH = 45, 46, 47, 48
PUSH, DRAG, DRAG2, SHIFT = 49, 50, 51, 52  # impulses so far [N s]; the displacements' [kg m]

# The part of a depth that one step undoes. All at once would let a pile that is not solved to the end jump.
RECOVERY = 0.2


@jit
def inverse_masses(bodies: RigidBodies) -> np.ndarray:
    """Return (m + 1, 10): 1/m and R I⁻¹ Rᵀ, row by row, of each body; the last row is the ground's, zeros."""
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
    for i in range(count):
        for c in range(3):
            motion[i, c] = bodies.velocity[i, c]
            motion[i, 3 + c] = bodies.angular_velocity[i, c]
    return motion


@jit
def store_motion(bodies: RigidBodies, motion: np.ndarray) -> None:
    """Write velocities back to the bodies that can move."""
    for i in range(bodies.inverse_mass.shape[0]):
        if bodies.inverse_mass[i] > 0.0:
            for c in range(3):
                bodies.velocity[i, c] = motion[i, c]
                bodies.angular_velocity[i, c] = motion[i, 3 + c]


@jit_lean
def _fill(
    row: np.ndarray, k: int, direction: int, d: Vec, arm_a: Vec, arm_b: Vec, inverse: np.ndarray, a: int, b: int
) -> None:
    """Store one direction of contact `k`, and what an impulse along it does to both bodies."""
    twist_a, twist_b = cross(arm_a, d), cross(arm_b, d)
    turn_a, turn_b = _turn(inverse, a, twist_a), _turn(inverse, b, twist_b)
    for c in range(3):
        row[k, 3 * direction + c] = d[c]
        row[k, TWIST_A + 3 * direction + c] = twist_a[c]
        row[k, TWIST_B + 3 * direction + c] = twist_b[c]
        row[k, TURN_A + 3 * direction + c] = turn_a[c]
        row[k, TURN_B + 3 * direction + c] = turn_b[c]


@jit_lean
def _turn(inverse: np.ndarray, i: int, t: Vec) -> Vec:
    """Return I⁻¹ t."""
    return (
        inverse[i, 1] * t[0] + inverse[i, 2] * t[1] + inverse[i, 3] * t[2],
        inverse[i, 4] * t[0] + inverse[i, 5] * t[1] + inverse[i, 6] * t[2],
        inverse[i, 7] * t[0] + inverse[i, 8] * t[1] + inverse[i, 9] * t[2],
    )


@jit_lean
def _coupling(row: np.ndarray, k: int, inverse: np.ndarray, a: int, b: int, first: int, second: int) -> float:
    """Return the speed [m/s per N s] along one direction that an impulse along another one gives its contact."""
    result = inverse[a, 0] + inverse[b, 0] if first == second else 0.0
    for c in range(3):
        result += row[k, TWIST_A + 3 * first + c] * row[k, TURN_A + 3 * second + c]
        result += row[k, TWIST_B + 3 * first + c] * row[k, TURN_B + 3 * second + c]
    return result


@jit_lean
def _speed(row: np.ndarray, k: int, direction: int, motion: np.ndarray, a: int, b: int) -> float:
    """Return the speed [m/s] along one direction of a's point of contact `k` seen from b's."""
    v_a, w_a, v_b, w_b = _three(motion, a, 0), _three(motion, a, 3), _three(motion, b, 0), _three(motion, b, 3)
    return _speed_of(row, k, direction, v_a, w_a, v_b, w_b)


@jit_lean
def _push(
    row: np.ndarray, k: int, direction: int, motion: np.ndarray, inverse: np.ndarray, a: int, b: int, p: float
) -> None:
    """Give a the impulse `p` [N s] along one direction at contact `k`, and b its opposite."""
    d = 3 * direction
    s = p * inverse[a, 0]
    motion[a, 0] += s * row[k, d]
    motion[a, 1] += s * row[k, d + 1]
    motion[a, 2] += s * row[k, d + 2]
    motion[a, 3] += p * row[k, TURN_A + d]
    motion[a, 4] += p * row[k, TURN_A + d + 1]
    motion[a, 5] += p * row[k, TURN_A + d + 2]
    s = p * inverse[b, 0]
    if s != 0.0:
        motion[b, 0] -= s * row[k, d]
        motion[b, 1] -= s * row[k, d + 1]
        motion[b, 2] -= s * row[k, d + 2]
        motion[b, 3] -= p * row[k, TURN_B + d]
        motion[b, 4] -= p * row[k, TURN_B + d + 1]
        motion[b, 5] -= p * row[k, TURN_B + d + 2]


@jit
def prepare_contacts(contacts: Contacts, bodies: RigidBodies, inverse: np.ndarray) -> None:
    """Fill in the solver's row of each contact, from where the bodies are and how they move before the step."""
    motion = load_motion(bodies)
    row = contacts.row
    ground = bodies.inverse_mass.shape[0]
    for k in range(contacts.number[0]):
        a, b = contacts.body[k, 0], contacts.body[k, 1]
        n = load(contacts.normal, k)
        # Any two tangents do; these turn with the normal except where its smallest component changes.
        if abs(n[0]) <= abs(n[1]) and abs(n[0]) <= abs(n[2]):
            tangent = normalize((0.0, n[2], -n[1]))
        elif abs(n[1]) <= abs(n[2]):
            tangent = normalize((-n[2], 0.0, n[0]))
        else:
            tangent = normalize((n[1], -n[0], 0.0))
        point = load(contacts.point, k)
        arm_a = sub(point, load(bodies.position, a))
        arm_b = (0.0, 0.0, 0.0)
        if b == NOBODY:
            b = ground
        else:
            arm_b = sub(point, load(bodies.position, b))
        _fill(row, k, NORMAL, n, arm_a, arm_b, inverse, a, b)
        _fill(row, k, TANGENT, tangent, arm_a, arm_b, inverse, a, b)
        _fill(row, k, SECOND, cross(n, tangent), arm_a, arm_b, inverse, a, b)
        row[k, MASS] = 1.0 / _coupling(row, k, inverse, a, b, NORMAL, NORMAL)
        k11 = _coupling(row, k, inverse, a, b, TANGENT, TANGENT)
        k12 = _coupling(row, k, inverse, a, b, TANGENT, SECOND)
        k22 = _coupling(row, k, inverse, a, b, SECOND, SECOND)
        # The most that friction in any direction can give.
        give = 0.5 * (k11 + k22) + np.sqrt(0.25 * (k11 - k22) * (k11 - k22) + k12 * k12)
        row[k, DRAG_MASS] = 1.0 / give
        row[k, APPROACH] = -_speed(row, k, NORMAL, motion, a, b)


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
    motion = load_motion(bodies)
    row = contacts.row
    ground = bodies.inverse_mass.shape[0]
    count = contacts.number[0]
    for k in range(count):
        a, b = contacts.body[k, 0], contacts.body[k, 1]
        b = ground if b == NOBODY else b
        closing = -_speed(row, k, NORMAL, motion, a, b)
        gap = max(0.0, -contacts.depth[k])
        row[k, TARGET] = -gap / h
        if closing * h > gap and row[k, APPROACH] > 0.0 and contacts.restitution[k] > 0.0:
            row[k, TARGET] = contacts.restitution[k] * row[k, APPROACH]
    for k in range(count):
        a, b = contacts.body[k, 0], contacts.body[k, 1]
        b = ground if b == NOBODY else b
        p = load(contacts.impulse, k)
        row[k, PUSH] = max(0.0, _along(row, k, NORMAL, p))
        row[k, DRAG] = row[k, DRAG2] = 0.0
        if row[k, PUSH] > 0.0:
            _push(row, k, NORMAL, motion, inverse, a, b, row[k, PUSH])
            if contacts.friction[k] > 0.0:
                row[k, DRAG], row[k, DRAG2] = _along(row, k, TANGENT, p), _along(row, k, SECOND, p)
                _push(row, k, TANGENT, motion, inverse, a, b, row[k, DRAG])
                _push(row, k, SECOND, motion, inverse, a, b, row[k, DRAG2])
    for _ in range(iterations):
        if _sweep(contacts, motion, inverse) <= enough:
            break
    for k in range(count):
        p = _impulse(row, k)
        for c in range(3):
            contacts.impulse[k, c] = p[c]
    store_motion(bodies, motion)


@jit_lean
def _sweep(contacts: Contacts, motion: np.ndarray, inverse: np.ndarray) -> float:
    """Correct the impulses of all contacts once, in order; return the largest change of a speed at a contact [m/s].

    The contacts of a pair follow each other: its velocities stay in the processor's registers from one to the next.
    """
    row = contacts.row
    count, ground = contacts.number[0], motion.shape[0] - 1
    most = 0.0
    k = 0
    while k < count:
        first, second = contacts.body[k, 0], contacts.body[k, 1]
        a, b = first, ground if second == NOBODY else second
        share_a, share_b = inverse[a, 0], inverse[b, 0]
        v_a, w_a, v_b, w_b = _three(motion, a, 0), _three(motion, a, 3), _three(motion, b, 0), _three(motion, b, 3)
        while k < count and contacts.body[k, 0] == first and contacts.body[k, 1] == second:
            before = row[k, PUSH]
            lack = row[k, TARGET] - _speed_of(row, k, NORMAL, v_a, w_a, v_b, w_b)
            push = max(0.0, before + row[k, MASS] * lack)
            change = push - before
            if change != 0.0:
                row[k, PUSH] = push
                most = max(most, abs(change) / row[k, MASS])
                v_a = add(v_a, scale(share_a * change, _three(row, k, 0)))
                v_b = sub(v_b, scale(share_b * change, _three(row, k, 0)))
                w_a = add(w_a, scale(change, _three(row, k, TURN_A)))
                w_b = sub(w_b, scale(change, _three(row, k, TURN_B)))
            if contacts.friction[k] > 0.0 and (before > 0.0 or push > 0.0):
                # Along the sliding, by one number for both tangents: with the exact 2 × 2 solve, what the bound leaves
                # would not point against the sliding, and a box would slide on by a seventh too far.
                limit = contacts.friction[k] * push
                drag = row[k, DRAG] - row[k, DRAG_MASS] * _speed_of(row, k, TANGENT, v_a, w_a, v_b, w_b)
                drag2 = row[k, DRAG2] - row[k, DRAG_MASS] * _speed_of(row, k, SECOND, v_a, w_a, v_b, w_b)
                square = drag * drag + drag2 * drag2
                if square > limit * limit:
                    kept = limit / np.sqrt(square)
                    drag, drag2 = kept * drag, kept * drag2
                s, t = drag - row[k, DRAG], drag2 - row[k, DRAG2]
                row[k, DRAG], row[k, DRAG2] = drag, drag2
                most = max(most, (abs(s) + abs(t)) / row[k, DRAG_MASS])
                along = add(scale(s, _three(row, k, 3)), scale(t, _three(row, k, 6)))
                v_a, v_b = add(v_a, scale(share_a, along)), sub(v_b, scale(share_b, along))
                w_a = add(w_a, add(scale(s, _three(row, k, TURN_A + 3)), scale(t, _three(row, k, TURN_A + 6))))
                w_b = sub(w_b, add(scale(s, _three(row, k, TURN_B + 3)), scale(t, _three(row, k, TURN_B + 6))))
            k += 1
        _keep(motion, a, v_a, w_a)
        if second != NOBODY:
            _keep(motion, b, v_b, w_b)
    return most


@jit_lean
def _three(rows: np.ndarray, k: int, column: int) -> Vec:
    """Return three numbers of row `k` from `column` on."""
    return rows[k, column], rows[k, column + 1], rows[k, column + 2]


@jit_lean
def _keep(motion: np.ndarray, i: int, v: Vec, w: Vec) -> None:
    for c in range(3):
        motion[i, c] = v[c]
        motion[i, 3 + c] = w[c]


@jit_lean
def _speed_of(row: np.ndarray, k: int, direction: int, v_a: Vec, w_a: Vec, v_b: Vec, w_b: Vec) -> float:
    """Return the speed [m/s] along one direction of a's point of contact `k` seen from b's."""
    d = 3 * direction
    turning = dot(_three(row, k, TWIST_A + d), w_a) - dot(_three(row, k, TWIST_B + d), w_b)
    return dot(_three(row, k, d), sub(v_a, v_b)) + turning


@jit_lean
def _along(row: np.ndarray, k: int, direction: int, p: Vec) -> float:
    d = 3 * direction
    return row[k, d] * p[0] + row[k, d + 1] * p[1] + row[k, d + 2] * p[2]


@jit_lean
def _impulse(row: np.ndarray, k: int) -> Vec:
    """Return the impulse [N s] on a of contact `k`, in the world."""
    n, s, t = row[k, PUSH], row[k, DRAG], row[k, DRAG2]
    return (
        n * row[k, 0] + s * row[k, 3] + t * row[k, 6],
        n * row[k, 1] + s * row[k, 4] + t * row[k, 7],
        n * row[k, 2] + s * row[k, 5] + t * row[k, 8],
    )


@jit
def solve_displacements(
    contacts: Contacts, bodies: RigidBodies, inverse: np.ndarray, allowed: float, iterations: int
) -> np.ndarray:
    """Return (m + 1, 6) displacements [m] and turns [rad] that undo RECOVERY of each depth beyond `allowed` [m].

    By pushes only. Depths as small as the way that gravity moves a body in one step are what a solve that stops early
    leaves; undoing them too would lift a stack again and again, and feed it energy: ten boxes then never come to rest.
    """
    row = contacts.row
    ground = bodies.inverse_mass.shape[0]
    shift = np.zeros((ground + 1, 6))
    deep = np.empty(contacts.number[0], np.int64)
    count = 0
    for k in range(contacts.number[0]):
        if contacts.depth[k] > allowed:
            deep[count] = k
            count += 1
            row[k, SHIFT] = 0.0
    for _ in range(iterations if count else 0):
        for place in range(count):
            k = deep[place]
            a, b = contacts.body[k, 0], contacts.body[k, 1]
            b = ground if b == NOBODY else b
            before = row[k, SHIFT]
            lack = RECOVERY * (contacts.depth[k] - allowed) - _speed(row, k, NORMAL, shift, a, b)
            row[k, SHIFT] = max(0.0, before + row[k, MASS] * lack)
            change = row[k, SHIFT] - before
            if change != 0.0:
                _push(row, k, NORMAL, shift, inverse, a, b, change)
    return shift
