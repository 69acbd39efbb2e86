"""Motion of cubes and spring bodies joined by damped springs: SciPy's DOP853 on Newton's and Euler's equations.

Cubes, so that the torque alone turns them: ω' = τ / I. Their orientation is a rotation matrix whose columns are
integrated by R' = ω × R. Nothing of it is anybody's time stepping.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.integrate

PACKAGES = {"scipy": "scipy"}  # import name, and the name to install it by

RTOL, ATOL = 1e-10, 1e-12


class Cube(NamedTuple):
    """A homogeneous cube."""

    edge: float  # [m]
    mass: float  # [kg]
    position: np.ndarray  # (3,) [m]
    orientation: np.ndarray  # (3, 3) from its own frame to the world
    velocity: np.ndarray  # (3,) [m/s]
    angular_velocity: np.ndarray  # (3,) [rad/s]


class Net(NamedTuple):
    """Equal point masses that springs join."""

    mass: float  # [kg] of each
    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    edges: np.ndarray  # (e, 2)
    rest_length: np.ndarray  # (e,) [m]
    stiffness: float  # [N/m] of each


class Joined(NamedTuple):
    """A damped spring of two ends: ("cube", number, arm (3,)), ("net", number, weights (n,)) or ("place", (3,))."""

    a: tuple
    b: tuple
    stiffness: float  # [N/m]
    damping: float  # [N s/m]
    rest_length: float  # [m]; 0: it pulls a to b, and damps all their motion


def motion(
    cubes: list[Cube], nets: list[Net], joints: list[Joined], gravity: np.ndarray, seconds: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return where the cubes' centres and all point masses are (c + n, 3) [m] after `seconds`, and their velocities."""
    masses, points = len(cubes), [len(net.position) for net in nets]
    begin = [np.concatenate([c.position, c.velocity, c.orientation.ravel(), c.angular_velocity]) for c in cubes]
    begin += [np.concatenate([net.position.ravel(), net.velocity.ravel()]) for net in nets]
    cuts = np.cumsum([len(part) for part in begin])[:-1]

    def end(where: tuple, parts: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return where an end is and its velocity."""
        if where[0] == "place":
            return np.asarray(where[1], float), np.zeros(3)
        y = parts[where[1] + (masses if where[0] == "net" else 0)]
        if where[0] == "net":
            x, v = y.reshape(2, -1, 3)
            return where[2] @ x, where[2] @ v
        arm = y[6:15].reshape(3, 3) @ where[2]
        return y[:3] + arm, y[3:6] + np.cross(y[15:], arm)

    def derivative(_: float, y: np.ndarray) -> np.ndarray:
        parts = np.split(y, cuts)
        force = [np.tile(gravity * c.mass, 1) for c in cubes] + [
            np.tile(gravity * n.mass, (len(n.position), 1)) for n in nets
        ]
        torque = [np.zeros(3) for _ in cubes]
        for net, part, f in zip(nets, parts[masses:], force[masses:]):
            x = part.reshape(2, -1, 3)[0]
            way = x[net.edges[:, 1]] - x[net.edges[:, 0]]
            length = np.linalg.norm(way, axis=1)
            pull = (net.stiffness * (length - net.rest_length) / length)[:, None] * way
            np.add.at(f, net.edges[:, 0], pull)
            np.add.at(f, net.edges[:, 1], -pull)
        for joint in joints:
            (a, v_a), (b, v_b) = end(joint.a, parts), end(joint.b, parts)
            away, closing = a - b, v_b - v_a
            if joint.rest_length == 0.0:
                on_a = -joint.stiffness * away + joint.damping * closing
            else:
                length = np.linalg.norm(away)
                along = away / length
                on_a = (joint.stiffness * (joint.rest_length - length) + joint.damping * closing @ along) * along
            for where, f in ((joint.a, on_a), (joint.b, -on_a)):
                if where[0] == "cube":
                    arm = parts[where[1]][6:15].reshape(3, 3) @ where[2]
                    force[where[1]] += f
                    torque[where[1]] += np.cross(arm, f)
                elif where[0] == "net":
                    force[masses + where[1]] += where[2][:, None] * f
        rates = []
        for cube, part, f, t in zip(cubes, parts, force, torque):
            turn = np.cross(part[15:], part[6:15].reshape(3, 3), axisb=0, axisc=0)
            rates.append(np.concatenate([part[3:6], f / cube.mass, turn.ravel(), t * 6.0 / (cube.mass * cube.edge**2)]))
        for net, part, f in zip(nets, parts[masses:], force[masses:]):
            rates.append(np.concatenate([part[3 * len(net.position) :], f.ravel() / net.mass]))
        return np.concatenate(rates)

    run = scipy.integrate.solve_ivp(
        derivative, (0.0, seconds), np.concatenate(begin), method="DOP853", rtol=RTOL, atol=ATOL
    )
    parts = np.split(run.y[:, -1], cuts)
    x = [part[:3][None] for part in parts[:masses]] + [
        part[: 3 * n].reshape(-1, 3) for part, n in zip(parts[masses:], points)
    ]
    v = [part[3:6][None] for part in parts[:masses]] + [
        part[3 * n :].reshape(-1, 3) for part, n in zip(parts[masses:], points)
    ]
    return np.concatenate(x), np.concatenate(v)
