"""What force do the springs along the edges exert, and how much energy do they hold?"""

from __future__ import annotations

import numpy as np

from softbody.jit import jit
from softbody.vec import accumulate, load, norm, scale, sub


@jit
def add_spring_forces(
    position: np.ndarray, edges: np.ndarray, rest_length: np.ndarray, stiffness: np.ndarray, force: np.ndarray
) -> None:
    """Add Hooke's force k (l − l0) along each edge to `force` (n, 3) [N]; paper §2.1, §10.5.

    `position` (n, 3) [m], `edges` (e, 2), `rest_length` (e,) [m], `stiffness` (e,) [N/m].
    """
    for e in range(edges.shape[0]):
        i = edges[e, 0]
        j = edges[e, 1]
        along = sub(load(position, j), load(position, i))
        length = norm(along)
        pull = scale(stiffness[e] * (length - rest_length[e]) / length, along)
        accumulate(force, i, pull)
        accumulate(force, j, scale(-1.0, pull))


@jit
def spring_energy(position: np.ndarray, edges: np.ndarray, rest_length: np.ndarray, stiffness: np.ndarray) -> float:
    """Return ½ Σ k (l − l0)² [J]; arrays as for add_spring_forces."""
    energy = 0.0
    for e in range(edges.shape[0]):
        stretch = norm(sub(load(position, edges[e, 1]), load(position, edges[e, 0]))) - rest_length[e]
        energy += 0.5 * stiffness[e] * stretch * stretch
    return energy


@jit
def spring_virial(position: np.ndarray, edges: np.ndarray, rest_length: np.ndarray, stiffness: np.ndarray) -> float:
    """Return Σ k (l − l0) l [J], which is 3 nRT at any equilibrium without outer forces."""
    virial = 0.0
    for e in range(edges.shape[0]):
        length = norm(sub(load(position, edges[e, 1]), load(position, edges[e, 0])))
        virial += stiffness[e] * (length - rest_length[e]) * length
    return virial
