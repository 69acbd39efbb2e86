"""Masses and velocities of particles that others have become: mass, its centre and both momenta stay as they were."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.errors import ParameterError

MOST_ROUNDS, EXACT = 50, 1e-15  # of Newton's method, and how near to the centre it is to come, as a part of the size


class Particles(NamedTuple):
    """Particles, before or after."""

    mass: np.ndarray  # (n,) [kg]
    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    fixed: np.ndarray  # (n,) of bool: they stay in place


def with_centre(before: Particles, masses: list[np.ndarray], points: list[np.ndarray]) -> list[np.ndarray]:
    """Return `masses` (n,) [kg] of bodies' particles at `points` (n, 3) [m], with the centre of mass of before.

    Those of each body, whose sum stays, lean to one side, all to the same: by e^(g·x) with the g of Newton's method.
    There are so many kilograms of them together as before. Raises ParameterError where no masses have that centre.
    """
    size = float(np.ptp(before.position, axis=0).max())
    arms = [(place - before.position[0]) / size for place in points]
    wanted, lean = before.mass @ (before.position - before.position[0]) / size, np.zeros(3)
    for _ in range(MOST_ROUNDS):
        leaning = [_leaning(mass, arm, lean) for mass, arm in zip(masses, arms)]
        left, slope = wanted.copy(), np.zeros((3, 3))
        for mass, arm in zip(leaning, arms):
            left -= mass @ arm
            away = arm - mass @ arm / mass.sum()
            slope += (away * mass[:, None]).T @ away
        if np.abs(left).max() <= EXACT * before.mass.sum():
            return leaning
        step = np.linalg.lstsq(slope, left, rcond=None)[0]
        lean = lean + step / max(1.0, float(np.abs(step).max()))
    raise ParameterError("its mass cannot be shared so that its centre stays; cut it elsewhere")


def _leaning(mass: np.ndarray, arm: np.ndarray, lean: np.ndarray) -> np.ndarray:
    by = np.exp(arm @ lean - (arm @ lean).max())
    return np.asarray(mass * by * (mass.sum() / (mass @ by)))


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
