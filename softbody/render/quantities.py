"""Which number does each vertex of a soft body have, where its colour is to show one?"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from softbody.bodies import SoftBody

UNITS = {"pressure": "Pa", "strain": "", "speed": "m/s"}


def pressure(body: SoftBody) -> np.ndarray:
    """Return the pressure of the gas (n,) [Pa], which is the same for all vertices."""
    return np.full(len(body.positions), body.pressure)


def strain(body: SoftBody) -> np.ndarray:
    """Return the mean strain (n,) of the springs that meet in each vertex: positive where they are stretched."""
    ends, each = spring_strains(body)
    count = len(body.positions)
    total = np.bincount(ends.ravel(), np.repeat(each, 2), count)
    return total / np.bincount(ends.ravel(), minlength=count)


def spring_strains(body: SoftBody) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends (e, 2) of a body's springs, as rows of its positions, and their strains l / l₀ − 1 (e,)."""
    model, positions = body.world.model, body.positions
    edges = slice(*model.soft_edge_start[body.index : body.index + 2])
    ends = model.edge_particles[edges] - model.soft_particle_start[body.index]
    length = np.linalg.norm(positions[ends[:, 1]] - positions[ends[:, 0]], axis=1)
    return ends, length / model.edge_rest_length[edges] - 1.0


def speed(body: SoftBody) -> np.ndarray:
    """Return the speed (n,) [m/s]."""
    return np.linalg.norm(body.velocities, axis=1)


QUANTITIES: dict[str, Callable[[SoftBody], np.ndarray]] = {"pressure": pressure, "strain": strain, "speed": speed}
