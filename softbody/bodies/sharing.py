"""Masses and velocities of particles that others have become: mass, its centre and both momenta stay as they were."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Particles(NamedTuple):
    """Particles, before or after."""

    mass: np.ndarray  # (n,) [kg]
    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    fixed: np.ndarray  # (n,) of bool: they stay in place


def with_centre(before: Particles, masses: list[np.ndarray], points: list[np.ndarray]) -> list[np.ndarray]:
    """Return `masses` (n,) [kg] of bodies' particles at `points` (n, 3) [m], with the centre of mass of before.

    Those of each body lean a little to one side, all to the same; their sum stays. There are so many kilograms of them
    together as before.
    """
    arms, lean, left = [], np.zeros((3, 3)), before.mass @ before.position
    for mass, place in zip(masses, points):
        arms.append(place - mass @ place / mass.sum())
        lean += (arms[-1] * mass[:, None]).T @ arms[-1]
        left = left - mass @ place
    tilt = np.linalg.lstsq(lean, left, rcond=None)[0]
    return [mass * (1.0 + arm @ tilt) for mass, arm in zip(masses, arms)]


def with_momenta(before: Particles, after: Particles) -> np.ndarray:
    """Return the velocities (n, 3) [m/s] after, with the linear and angular momentum of before.

    A motion of the whole as a rigid body is added to those that are not fixed.
    """
    mass = np.where(after.fixed, 0.0, after.mass)
    arm = after.position - mass @ after.position / mass.sum()
    centre = after.position[0] - arm[0]
    push, turn = _momenta(np.where(before.fixed, 0.0, before.mass), before.position - centre, before.velocity)
    has_push, has_turn = _momenta(mass, arm, after.velocity)
    inertia = np.einsum("i,ij,ij->", mass, arm, arm) * np.eye(3) - (arm * mass[:, None]).T @ arm
    spin = np.linalg.lstsq(inertia, turn - has_turn, rcond=None)[0]
    more = (push - has_push) / mass.sum() + np.cross(spin, arm)
    return np.asarray(after.velocity + np.where(after.fixed[:, None], 0.0, more))


def _momenta(mass: np.ndarray, arm: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the linear momentum (3,), and the angular about where the arms (n, 3) begin."""
    return mass @ velocity, mass @ np.cross(arm, velocity)
