"""Rotation of a free, asymmetric box, and the turn half-way between two, by SciPy.

DOP853 solves Euler's equations in the box's frame, with rtol 1e-12 and atol 1e-13 instead of 1e-3 and 1e-6.
"""

from __future__ import annotations

import numpy as np
import scipy.integrate
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation, Slerp

from references.analytic import box_inertia, rotation_matrix


def free_rotation(
    size: ArrayLike, orientation: ArrayLike, angular_velocity: ArrayLike, seconds: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rotation matrix (3, 3) and the angular velocity (3,) [rad/s] in the world after `seconds` [s].

    I ω' = −ω × I ω with ω in the body's frame, and q' = q (0, ω) / 2.
    """
    inertia = box_inertia(size, 1.0)
    start = np.asarray(orientation, float)
    spin = rotation_matrix(start).T @ np.asarray(angular_velocity, float)

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        w, x, y_, z = y[:4]
        p, q, r = y[4:]
        turn = 0.5 * np.array(
            [-x * p - y_ * q - z * r, w * p + y_ * r - z * q, w * q + z * p - x * r, w * r + x * q - y_ * p]
        )
        return np.concatenate([turn, -np.cross(y[4:], inertia * y[4:]) / inertia])

    end = scipy.integrate.solve_ivp(
        rate, (0.0, seconds), np.concatenate([start, spin]), method="DOP853", rtol=1e-12, atol=1e-13
    ).y[:, -1]
    turn = rotation_matrix(end[:4])
    return turn, turn @ end[4:]


def half_way(one: ArrayLike, other: ArrayLike) -> np.ndarray:
    """Return the quaternion (4,) (w, x, y, z) in the middle of the shortest turn from one to the other."""
    ends = Rotation.from_quat([np.roll(one, -1), np.roll(other, -1)])
    return np.roll(Slerp([0.0, 1.0], ends)(0.5).as_quat(), 1)


def rotation_vector(matrix: np.ndarray) -> np.ndarray:
    """Return the axis of a turn (3, 3), as long as its angle [rad]: (3,)."""
    return np.asarray(Rotation.from_matrix(matrix).as_rotvec())
