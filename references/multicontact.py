"""One frictionless impact of two boxes at several points at once, by trying all sets of contacts.

Newton's law at each contact: the points part with at least e times their speed of approach, impulses only push, and
where there is an impulse, the law holds with equality (a linear complementarity problem). A set of contacts that push
gives linear equations; the set whose solution breaks no inequality is the answer. The contacts of two boxes share one
normal, so that three of them suffice, whatever their number (Carathéodory), and the velocities after are unique. No
iteration, no tolerance but the choice of the set that violates least.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from references.analytic import box_inertia, rotation_matrix

ROUNDING = 1e-13  # of the fastest approach: what closes by less does not
MOST_TURNS = 1_000  # of e = 1 they are few; the last ones do not bounce


def manifold_impact(
    bodies: tuple[Any, ...], point: np.ndarray, normal: np.ndarray, restitution: float
) -> tuple[np.ndarray, int]:
    """Return (12,): v_a, ω_a, v_b, ω_b after two boxes strike at `point` (k, 3) [m], k ≥ 1; and in how many turns.

    `bodies`: size, mass, position, orientation, velocity, angular velocity of a and then of b, as arrays of one row
    each; `normal` (k, 3) unit, from b to a, the same in every row.
    """
    motion, inverse, jacobian = _equations(bodies, point, normal)
    fastest, turns = np.abs(jacobian @ motion).max(), 0
    while True:
        closing = jacobian @ motion < -ROUNDING * fastest
        if not closing.any():
            return motion, turns
        bounces = restitution > 0.0 and turns < MOST_TURNS  # what does not bounce goes on to push others
        motion = _bounce(motion, inverse, jacobian[closing] if bounces else jacobian, restitution if bounces else 0.0)
        turns += 1


def _bounce(before: np.ndarray, inverse: np.ndarray, jacobian: np.ndarray, restitution: float) -> np.ndarray:
    """Return the velocities (12,) after all points of `jacobian` (k, 12), which close, have bounced at once."""
    speed = jacobian @ before
    lack = speed - restitution * np.maximum(0.0, -speed)
    spread = jacobian @ inverse
    a = spread @ jacobian.T
    best, least = np.zeros(len(speed)), -lack.min()
    for size in range(1, min(3, len(speed)) + 1):
        for chosen in combinations(range(len(speed)), size):
            block = a[np.ix_(chosen, chosen)]
            if np.linalg.cond(block) > 1e12:
                continue
            push = np.zeros(len(speed))
            push[list(chosen)] = np.linalg.solve(block, -lack[list(chosen)])
            scale = np.abs(push).max()
            violation = max(-(a @ push + lack).min(), -push.min() * np.abs(lack).max() / scale if scale else 0.0)
            if violation < least:
                best, least = push, violation
    return before + spread.T @ best


def energy_change(
    bodies: tuple[Any, ...], point: np.ndarray, normal: np.ndarray, impulse: np.ndarray, after: np.ndarray
) -> tuple[float, float, float]:
    """Return (ΔE, ½ λ·(u_n + u_n'), energy before) [J] of an impact with impulses λ (k,) [N s] along the normals.

    Both are the same for whatever impulses lead from the velocities before to those `after` (12,): an identity.
    """
    before, inverse, jacobian = _equations(bodies, point, normal)
    movable = np.diag(inverse) > 0.0
    mass = np.zeros_like(inverse)
    mass[np.ix_(movable, movable)] = np.linalg.inv(inverse[np.ix_(movable, movable)])
    start = 0.5 * float(before @ mass @ before)
    work = 0.5 * float(impulse @ (jacobian @ (before + after)))
    return 0.5 * float(after @ mass @ after) - start, work, start


def momenta(bodies: tuple[Any, ...], velocities: np.ndarray) -> np.ndarray:
    """Return (6,): Σ m v and, about the origin, Σ x × m v + I ω of two boxes with `velocities` (12,)."""
    total = np.zeros(6)
    for k in (0, 1):
        size, mass, position, orientation = (np.asarray(x, float)[0] for x in bodies[6 * k : 6 * k + 4])
        v, w = velocities[6 * k : 6 * k + 3], velocities[6 * k + 3 : 6 * k + 6]
        turn = rotation_matrix(orientation)
        total[:3] += mass * v
        total[3:] += np.cross(position, mass * v) + turn @ (box_inertia(size, mass) * (turn.T @ w))
    return total


def _equations(bodies: tuple[Any, ...], point: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the velocities (12,), the inverse mass matrix (12, 12), and the contacts' Jacobian (k, 12)."""
    before = np.concatenate([np.asarray(bodies[k], float)[0] for k in (4, 5, 10, 11)])
    inverse = np.zeros((12, 12))
    jacobian = np.zeros((len(point), 12))
    for k, sign in ((0, 1.0), (1, -1.0)):
        size, mass, position, orientation = (np.asarray(x, float)[0] for x in bodies[6 * k : 6 * k + 4])
        rows = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
        if np.isfinite(mass):
            turn = rotation_matrix(orientation)
            inverse[rows[0], rows[0]] = np.eye(3) / mass
            inverse[rows[1], rows[1]] = turn @ np.diag(1.0 / box_inertia(size, mass)) @ turn.T
        jacobian[:, rows[0]] = sign * normal
        jacobian[:, rows[1]] = sign * np.cross(point - position, normal)
    return before, inverse, jacobian
