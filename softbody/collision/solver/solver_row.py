"""Row that the constraint solver of boxes keeps of each contact, and the action of impulses there."""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.quaternion import load_quaternion, rotate_diagonal
from softbody.linalg.vec import Vec, cross, dot, load, normalize, sub
from softbody.model.arrays import NOBODY, RigidBodies

# The directions of a contact: its normal and two tangents. In a contact's row, three columns for each direction d hold
# the row of the Jacobian and what an impulse along it does: d itself; r × d of a and of b; and R I⁻¹ Rᵀ (r × d) of a
# and of b. With these stored, an impulse takes a dozen multiplications a body, a third of what it takes from the arms.
NORMAL, TANGENT, SECOND = 0, 1, 2
ANGULAR_A, ANGULAR_B, TURN_A, TURN_B = 9, 18, 27, 36
# Effective mass along the normal, and the least one across it [kg]; speeds after and before [m/s].
MASS, TANGENT_MASS, TARGET, APPROACH = 45, 46, 47, 48
# Impulses so far [N s], along the normal and both tangents; the position solve's [kg m].
NORMAL_IMPULSE, TANGENT_IMPULSE, SECOND_IMPULSE, POSITION_IMPULSE = 49, 50, 51, 52
INVERSE_A, INVERSE_B = 53, 54  # inverse masses [1/kg]
COUPLING, SECOND_COUPLING = 55, 56  # speeds along both tangents that an impulse along the normal gives [m/s per N s]

Directions = tuple[Vec, Vec, Vec, Vec, Vec]
PairMotion = tuple[Vec, Vec, Vec, Vec]  # velocity and angular velocity of a, and of b


@jit
def inverse_masses(bodies: RigidBodies) -> np.ndarray:
    """Return (m + 1, 10): 1/m and R I⁻¹ Rᵀ, row by row, of each body; the last row is that of NOBODY, −1: zeros."""
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
    """Return (m + 1, 6): v [m/s] and ω [rad/s] of each body; the last row is that of NOBODY, −1: zeros.

    No zero is negative, nor becomes so: to add either zero to it changes nothing.
    """
    count = bodies.inverse_mass.shape[0]
    motion = np.zeros((count + 1, 6))
    for i in range(count):
        for c in range(3):
            motion[i, c] += bodies.velocity[i, c]
            motion[i, 3 + c] += bodies.angular_velocity[i, c]
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
def prepare_contacts(contacts: Contacts, bodies: RigidBodies) -> None:
    """Fill in the solver's row of each contact, from where the bodies are and how they move before the step."""
    inverse, motion, row = inverse_masses(bodies), load_motion(bodies), contacts.row
    for k in range(contacts.number[1]):
        a, b = contacts.box[k, 0], contacts.box[k, 1]
        # Any two tangents do; these turn with the normal except where its smallest component changes.
        n = load(contacts.normal, k)
        if abs(n[0]) <= abs(n[1]) and abs(n[0]) <= abs(n[2]):
            tangent = normalize((0.0, n[2], -n[1]))
        elif abs(n[1]) <= abs(n[2]):
            tangent = normalize((-n[2], 0.0, n[0]))
        else:
            tangent = normalize((n[1], -n[0], 0.0))
        # The three rows of the Jacobian.
        point = load(contacts.point, k)
        arm_a = sub(point, load(bodies.position, a))
        arm_b = (0.0, 0.0, 0.0)
        if b != NOBODY:
            arm_b = sub(point, load(bodies.position, b))
        row[k, INVERSE_A], row[k, INVERSE_B] = inverse[a, 0], inverse[b, 0]
        _store_direction(row, k, NORMAL, _jacobian(n, (arm_a, arm_b), inverse, (a, b)))
        _store_direction(row, k, TANGENT, _jacobian(tangent, (arm_a, arm_b), inverse, (a, b)))
        _store_direction(row, k, SECOND, _jacobian(cross(n, tangent), (arm_a, arm_b), inverse, (a, b)))
        # Effective masses; across, that of the direction in which friction moves most.
        row[k, MASS] = 1.0 / _coupling(row, k, NORMAL, NORMAL)
        k11 = _coupling(row, k, TANGENT, TANGENT)
        k12 = _coupling(row, k, TANGENT, SECOND)
        k22 = _coupling(row, k, SECOND, SECOND)
        largest = 0.5 * (k11 + k22) + np.sqrt(0.25 * (k11 - k22) * (k11 - k22) + k12 * k12)
        row[k, TANGENT_MASS] = 1.0 / largest
        row[k, COUPLING], row[k, SECOND_COUPLING] = (
            _coupling(row, k, TANGENT, NORMAL),
            _coupling(row, k, SECOND, NORMAL),
        )
        row[k, APPROACH] = -speed_along(row, k, NORMAL, load_pair(motion, a, b))


@jit_lean
def _jacobian(d: Vec, arms: tuple[Vec, Vec], inverse: np.ndarray, pair: tuple[int, int]) -> Directions:
    """Return a direction d, r × d of both bodies, and R I⁻¹ Rᵀ (r × d) of both."""
    angular_a, angular_b = cross(arms[0], d), cross(arms[1], d)
    return d, angular_a, angular_b, _turn(inverse, pair[0], angular_a), _turn(inverse, pair[1], angular_b)


@jit_lean
def _turn(inverse: np.ndarray, i: int, t: Vec) -> Vec:
    """Return R I⁻¹ Rᵀ t."""
    return (
        inverse[i, 1] * t[0] + inverse[i, 2] * t[1] + inverse[i, 3] * t[2],
        inverse[i, 4] * t[0] + inverse[i, 5] * t[1] + inverse[i, 6] * t[2],
        inverse[i, 7] * t[0] + inverse[i, 8] * t[1] + inverse[i, 9] * t[2],
    )


@jit_lean
def _store_direction(row: np.ndarray, k: int, direction: int, jacobian: Directions) -> None:
    for c in range(3):
        row[k, 3 * direction + c] = jacobian[0][c]
        row[k, ANGULAR_A + 3 * direction + c] = jacobian[1][c]
        row[k, ANGULAR_B + 3 * direction + c] = jacobian[2][c]
        row[k, TURN_A + 3 * direction + c] = jacobian[3][c]
        row[k, TURN_B + 3 * direction + c] = jacobian[4][c]


@jit_lean
def _coupling(row: np.ndarray, k: int, first: int, second: int) -> float:
    """Return the speed [m/s per N s] along one direction that an impulse along another one gives its contact."""
    result = row[k, INVERSE_A] + row[k, INVERSE_B] if first == second else 0.0
    for c in range(3):
        result += row[k, ANGULAR_A + 3 * first + c] * row[k, TURN_A + 3 * second + c]
        result += row[k, ANGULAR_B + 3 * first + c] * row[k, TURN_B + 3 * second + c]
    return result


@jit_lean
def speed_along(row: np.ndarray, k: int, direction: int, pair: PairMotion) -> float:
    """Return the speed [m/s] along one direction of a's point of contact `k` seen from b's."""
    v_a, w_a, v_b, w_b = pair
    d = 3 * direction
    turning = dot(load_three(row, k, ANGULAR_A + d), w_a) - dot(load_three(row, k, ANGULAR_B + d), w_b)
    return dot(load_three(row, k, d), sub(v_a, v_b)) + turning


@jit_lean
def load_pair(motion: np.ndarray, a: int, b: int) -> PairMotion:
    """Return the velocities and angular velocities of two bodies."""
    return load_three(motion, a, 0), load_three(motion, a, 3), load_three(motion, b, 0), load_three(motion, b, 3)


@jit_lean
def load_three(rows: np.ndarray, k: int, column: int) -> Vec:
    """Return three numbers of row `k` from `column` on."""
    return rows[k, column], rows[k, column + 1], rows[k, column + 2]


@jit_lean
def apply_impulse(
    row: np.ndarray, k: int, direction: int, impulse: float, motion: np.ndarray, pair: tuple[int, int]
) -> None:
    """Give a an `impulse` [N s] along one direction at contact `k`, and b its opposite."""
    a, b = pair
    d = 3 * direction
    s = impulse * row[k, INVERSE_A]
    motion[a, 0] += s * row[k, d]
    motion[a, 1] += s * row[k, d + 1]
    motion[a, 2] += s * row[k, d + 2]
    motion[a, 3] += impulse * row[k, TURN_A + d]
    motion[a, 4] += impulse * row[k, TURN_A + d + 1]
    motion[a, 5] += impulse * row[k, TURN_A + d + 2]
    s = impulse * row[k, INVERSE_B]
    if s != 0.0:
        motion[b, 0] -= s * row[k, d]
        motion[b, 1] -= s * row[k, d + 1]
        motion[b, 2] -= s * row[k, d + 2]
        motion[b, 3] -= impulse * row[k, TURN_B + d]
        motion[b, 4] -= impulse * row[k, TURN_B + d + 1]
        motion[b, 5] -= impulse * row[k, TURN_B + d + 2]


@jit_lean
def component(row: np.ndarray, k: int, direction: int, p: Vec) -> float:
    """Return the component of `p` along one direction of contact `k`."""
    d = 3 * direction
    return row[k, d] * p[0] + row[k, d + 1] * p[1] + row[k, d + 2] * p[2]
