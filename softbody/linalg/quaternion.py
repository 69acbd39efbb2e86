"""Unit quaternions (w, x, y, z): orientation of rigid bodies, body frame to world frame."""

from __future__ import annotations

from math import atan2, cos, sin, sqrt

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import Vec, add, cross, multiply, norm, scale

Quaternion = tuple[float, float, float, float]


def rotation_matrix(orientation: np.ndarray) -> np.ndarray:
    """Return the matrix (3, 3) of a unit quaternion (4,)."""
    w, x, y, z = orientation.tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


@jit_lean
def load_quaternion(rows: np.ndarray, i: int) -> Quaternion:
    """Return row `i` of an `(n, 4)` array."""
    return rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3]


@jit
def rotate(q: Quaternion, a: Vec) -> Vec:
    """Rotate `a` from the body frame to the world frame."""
    axis = (q[1], q[2], q[3])
    t = scale(2.0, cross(axis, a))
    return add(add(a, scale(q[0], t)), cross(axis, t))


@jit
def rotate_inverse(q: Quaternion, a: Vec) -> Vec:
    """Rotate `a` from the world frame to the body frame."""
    return rotate((q[0], -q[1], -q[2], -q[3]), a)


@jit
def rotate_diagonal(q: Quaternion, diagonal: Vec, a: Vec) -> Vec:
    """Return R diag(diagonal) Rᵀ a: a body-frame inertia, or its inverse, applied in the world frame."""
    return rotate(q, multiply(diagonal, rotate_inverse(q, a)))


@jit
def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the Hamilton product p q: the rotation q followed by p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@jit
def normalize_quaternion(q: Quaternion) -> Quaternion:
    """Return q / |q|."""
    s = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return s * q[0], s * q[1], s * q[2], s * q[3]


@jit
def from_rotation_vector(rotation: Vec) -> Quaternion:
    """Return the rotation by |rotation| [rad] about the direction of `rotation`."""
    angle = norm(rotation)
    if angle == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    s = sin(0.5 * angle) / angle
    return cos(0.5 * angle), s * rotation[0], s * rotation[1], s * rotation[2]


def rotation_between(q: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the turn (3,) [rad], the shorter one, in the world, that takes orientation `q` (4,) to `end` (4,).

    Half a turn is |w| = 0, where rounding decides which way.
    """
    # end q*: the product with the conjugate.
    cosine = float(end @ q)
    axis = q[0] * end[1:] - end[0] * q[1:] - np.cross(end[1:], q[1:])
    sine = float(np.linalg.norm(axis))
    turn = 2.0 * atan2(sine, abs(cosine))
    return axis * (turn / sine if cosine >= 0.0 else -turn / sine) if sine > 0.0 else np.zeros(3)
