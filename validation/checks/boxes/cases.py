"""What claims about boxes share: turns, and the same box by other axes."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def about(axis: int, angle: float) -> np.ndarray:
    """Return the quaternion of a turn about one axis."""
    q = np.zeros(4)
    q[0], q[1 + axis] = np.cos(0.5 * angle), np.sin(0.5 * angle)
    return q


def turned(q: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the quaternion of turn `p` followed by `q`."""
    w = q[0] * p[0] - q[1:] @ p[1:]
    return np.concatenate([[w], q[0] * p[1:] + p[0] * q[1:] + np.cross(q[1:], p[1:])])


def wxyz(turn: Rotation) -> np.ndarray:
    """Return a turn as the core wants it: (w, x, y, z)."""
    return np.asarray(turn.as_quat(scalar_first=True))


def rotation(q: np.ndarray) -> Rotation:
    """Return the turn of a quaternion, or of several, (w, x, y, z)."""
    return Rotation.from_quat(q, scalar_first=True)


def any_yaw(rng: np.random.Generator) -> Rotation:
    """Return a turn about z by any angle."""
    return Rotation.from_rotvec((0.0, 0.0, rng.uniform(-3.0, 3.0)))


def any_turn(rng: np.random.Generator) -> Rotation:
    """Return a turn, uniform over all."""
    return Rotation.random(random_state=rng)


def other_axes(rng: np.random.Generator) -> Rotation:
    """Return one of the 24 ways to call a box's own axes."""
    return Rotation.create_group("O")[int(rng.integers(24))]


def renamed(size: np.ndarray, turn: Rotation, names: Rotation) -> tuple[np.ndarray, np.ndarray]:
    """Return size and orientation of the same box with its axes called otherwise: those of `names`, seen from it."""
    return np.abs(np.round(names.inv().as_matrix()) @ size), wxyz(turn * names)
