"""Energy, momentum and angular momentum of particles and boxes, summed up by NumPy and SciPy.

Of raw arrays, so that a claim that something is kept does not ask the core how much of it there is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

PACKAGES = {"scipy": "scipy"}  # import name, and the name to install it by


class Accounts(NamedTuple):
    """What bodies have."""

    energy: float  # [J], of weight and forces up to a constant
    kinetic: float  # [J] of it, by moving and turning
    momentum: np.ndarray  # (3,) [kg m/s]
    angular_momentum: np.ndarray  # (3,) [kg m²/s] about the origin


def of_particles(
    mass: np.ndarray, position: np.ndarray, velocity: np.ndarray, gravity: np.ndarray, force: np.ndarray | float = 0.0
) -> Accounts:
    """Return the accounts of particles: kinetic energy, that of weight, and that of a constant `force` (n, 3) [N].

    `mass` (n,) [kg], `position` (n, 3) [m], `velocity` (n, 3) [m/s], `gravity` (3,) [m/s²].
    """
    pull = mass[:, None] * gravity + force
    carried = mass[:, None] * velocity
    kinetic = float(0.5 * (carried * velocity).sum())
    return Accounts(
        kinetic - float((pull * position).sum()),
        kinetic,
        carried.sum(axis=0),
        np.cross(position, carried).sum(axis=0),
    )


def of_boxes(
    size: np.ndarray,
    mass: np.ndarray,
    position: np.ndarray,
    orientation: np.ndarray,
    velocity: np.ndarray,
    spin: np.ndarray,
    gravity: np.ndarray,
) -> Accounts:
    """Return the accounts of boxes that can move: as of particles at their centres, and those of their spins.

    `size` (m, 3) full extents [m], `mass` (m,) [kg], `position` (m, 3) [m], `orientation` (m, 4) unit quaternions
    (w, x, y, z), `velocity` (m, 3) [m/s], `spin` (m, 3) [rad/s] in the world frame, `gravity` (3,) [m/s²].
    """
    if not len(size):
        return of_particles(mass, position, velocity, gravity)
    centres = of_particles(mass, position, velocity, gravity)
    turned = Rotation.from_quat(np.roll(orientation, -1, axis=1))
    squares = size**2
    inertia = mass[:, None] / 12.0 * (squares.sum(axis=1, keepdims=True) - squares)
    own = turned.apply(inertia * turned.apply(spin, inverse=True))
    turning = float(0.5 * (own * spin).sum())
    return Accounts(
        centres.energy + turning,
        centres.kinetic + turning,
        centres.momentum,
        centres.angular_momentum + own.sum(axis=0),
    )
