"""Quantities that colours can show at the vertices of a soft body: pressure, strain and speed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from softbody.bodies.soft_body import SoftBody

UNITS = {"pressure": "Pa", "strain": "", "speed": "m/s"}


def pressure(body: SoftBody) -> np.ndarray:
    """Return the pressure of the gas (n,) [Pa], which is the same for all vertices."""
    return np.full(len(body.positions), body.pressure)


def strain(body: SoftBody) -> np.ndarray:
    """Return the mean strain (n,) of the springs that meet in each vertex: positive where they are stretched."""
    ends, count = body.edges.ravel(), len(body.positions)
    return np.bincount(ends, np.repeat(body.strain, 2), count) / np.bincount(ends, minlength=count)


def speed(body: SoftBody) -> np.ndarray:
    """Return the speed (n,) [m/s]."""
    return np.linalg.norm(body.velocities, axis=1)


QUANTITIES: dict[str, Callable[[SoftBody], np.ndarray]] = {"pressure": pressure, "strain": strain, "speed": speed}
