"""Relaxation of a system to rest by the algorithm FIRE, in NumPy.

That is of Bitzek, Koskinen, Gähler, Moseler and Gumbsch (2006), with their parameters: five steps of patience, steps
that grow by 1.1 and shrink by a half, mixing of 0.1 that fades by 0.99; motion by symplectic Euler. Forces are those of
references.scipy, as the gradient of the energy.
"""

from __future__ import annotations

import numpy as np

from references import scipy

PACKAGES = {"scipy": "scipy"}  # import name, and the name to install it by


def relaxed(
    position: np.ndarray,
    longest: float,
    steps: int,
    edges: np.ndarray,
    rest_length: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
    particle_mass: float,
    gravity: np.ndarray,
    free: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return positions and velocities (n, 3) of a soft body after so many steps from rest, and the next step's length.

    Springs (e,) of `rest_length` [m] and `stiffness` [N/m] on `edges` (e, 2), `gas` nRT [J] inside `triangles`; `free`
    (n,) of bool. The first step is the `longest` [s].
    """

    def acceleration(x: np.ndarray) -> np.ndarray:
        force = scipy.forces(x, edges, rest_length, stiffness, triangles, gas)
        return np.where(free[:, None], force / particle_mass + gravity, 0.0)

    x, v, a = position, np.zeros_like(position), acceleration(position)
    step, mixing, downhill = longest, 0.1, 0
    for _ in range(steps):
        if np.vdot(a, v) > 0.0:
            v = (1.0 - mixing) * v + mixing * a * np.linalg.norm(v) / np.linalg.norm(a)
            downhill += 1
            if downhill > 5:
                step, mixing = min(1.1 * step, longest), 0.99 * mixing
        else:
            v, step, mixing, downhill = np.zeros_like(v), 0.5 * step, 0.1, 0
        v = v + step * a
        x = x + step * v
        a = acceleration(x)
    return x, v, step
