"""Motion of a soft body, step by step, by each of the three schemes, written once more in NumPy.

Forces are those of references.scipy, as the gradient of the energy; a scheme is written here as its source writes it:
the paper's (§5.1) with four estimates of the acceleration, each of which moves velocities and then positions from the
start of the step; the classical Runge–Kutta scheme on (x, v); and symplectic Euler.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from references import scipy

PACKAGES = {"scipy": "scipy"}  # import name, and the name to install it by


class SoftBody(NamedTuple):
    """What a soft body is made of, and what acts on it."""

    edges: np.ndarray  # (e, 2)
    rest_length: np.ndarray  # (e,) [m]
    stiffness: np.ndarray  # (e,) [N/m]
    triangles: np.ndarray  # (t, 3)
    gas: float  # nRT [J]
    particle_mass: float  # [kg]
    gravity: np.ndarray  # (3,) [m/s²]
    force: np.ndarray  # (n, 3) [N] from outside
    damping: float  # of every spring, along it [N s/m]
    drag: float  # [1/s]: every particle loses so much of its velocity a second
    free: np.ndarray  # (n,) of bool; the others stay where they are

    def acceleration(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the acceleration (n, 3) [m/s²] at positions `x` and velocities `v`."""
        force = self.force + scipy.forces(x, self.edges, self.rest_length, self.stiffness, self.triangles, self.gas)
        force += scipy.dampers(x, v, self.edges, self.damping)
        return np.where(self.free[:, None], force / self.particle_mass + self.gravity - self.drag * v, 0.0)


def _paper(body: SoftBody, x: np.ndarray, v: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    a0 = body.acceleration(x, v)
    v1 = v + 0.5 * h * a0
    a1 = body.acceleration(x + 0.5 * h * v1, v1)
    v2 = v + 0.5 * h * a1
    a2 = body.acceleration(x + 0.5 * h * v2, v2)
    v3 = v + h * a2
    a3 = body.acceleration(x + h * v3, v3)
    v = v + h / 6.0 * (a0 + 2.0 * a1 + 2.0 * a2 + a3)
    return x + h * v, v


def _runge_kutta(body: SoftBody, x: np.ndarray, v: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    v1, a1 = v, body.acceleration(x, v)
    v2, a2 = v + 0.5 * h * a1, body.acceleration(x + 0.5 * h * v1, v + 0.5 * h * a1)
    v3, a3 = v + 0.5 * h * a2, body.acceleration(x + 0.5 * h * v2, v + 0.5 * h * a2)
    v4, a4 = v + h * a3, body.acceleration(x + h * v3, v + h * a3)
    return x + h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


def _symplectic_euler(body: SoftBody, x: np.ndarray, v: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    v = v + h * body.acceleration(x, v)
    return x + h * v, v


SCHEMES: dict[str, Callable[[SoftBody, np.ndarray, np.ndarray, float], tuple[np.ndarray, np.ndarray]]] = {
    "rk4_velocity": _paper,
    "rk4": _runge_kutta,
    "symplectic_euler": _symplectic_euler,
}


def motion(
    body: SoftBody, position: np.ndarray, velocity: np.ndarray, step: float, steps: int, scheme: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n, 3) [m] and velocities (n, 3) [m/s] after so many steps of `step` [s] by one of SCHEMES."""
    x, v = position, np.where(body.free[:, None], velocity, 0.0)
    for _ in range(steps):
        x, v = SCHEMES[scheme](body, x, v, step)
    return x, v
