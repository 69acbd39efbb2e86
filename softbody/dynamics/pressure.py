"""What pressure does the gas have, and what force does it exert on a closed mesh?"""

from __future__ import annotations

from math import log

import numpy as np

from softbody.geometry.triangle import area_vector
from softbody.jit import jit
from softbody.vec import accumulate, load, scale


@jit
def gas_pressure(gas: float, volume: float) -> float:
    """Return P = nRT / V [Pa] of an ideal gas; `gas` is nRT [J], `volume` [m³]; paper §2.3, §10.6."""
    return gas / volume


@jit
def add_pressure_forces(position: np.ndarray, triangles: np.ndarray, pressure: float, force: np.ndarray) -> None:
    """Add a third of P A n̂ of each triangle to the force on each of its corners; paper §2.2, §10.11.

    `position` (n, 3) [m], `triangles` (t, 3), `pressure` [Pa], `force` (n, 3) [N]. On a closed mesh the sum is
    exactly P ∂V/∂x: it does the work P dV, and exerts no net force and no net torque.
    """
    for t in range(triangles.shape[0]):
        i = triangles[t, 0]
        j = triangles[t, 1]
        k = triangles[t, 2]
        area = area_vector(load(position, i), load(position, j), load(position, k))
        share = scale(pressure / 3.0, area)
        accumulate(force, i, share)
        accumulate(force, j, share)
        accumulate(force, k, share)


@jit
def gas_energy(gas: float, volume: float) -> float:
    """Return −nRT ln(V / 1 m³) [J]: the work that the gas can still be made to do, up to a constant."""
    return -gas * log(volume)
