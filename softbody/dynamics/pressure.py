"""Gas of a soft body: enclosed volume, pressure, and the work that it can still do."""

from __future__ import annotations

from math import log

import numpy as np

from softbody.compiler.jit import jit
from softbody.geometry.borders import fans_of_holes
from softbody.geometry.polyhedron import signed_volume
from softbody.model.arrays import Model, is_open


@jit
def gas_pressure(gas: float, volume: float) -> float:
    """Return P = nRT / V [Pa] of an ideal gas; `gas` is nRT [J], `volume` [m³]; paper §2.3, §10.6."""
    return gas / volume if gas > 0.0 else 0.0


@jit
def gas_energy(gas: float, volume: float) -> float:
    """Return −nRT ln(V / 1 m³) [J]: the work that the gas can still be made to do, up to a constant."""
    return -gas * log(volume)


@jit
def soft_volume(model: Model, position: np.ndarray, body: int) -> float:
    """Return the signed volume [m³] of one soft body at `position` (n, 3) [m]; paper §2.3.

    Holes where it has torn are closed by fans about the middle of their corners.
    """
    triangles = model.triangle_particles[model.soft_triangle_start[body] : model.soft_triangle_start[body + 1]]
    volume = signed_volume(position, triangles)
    if is_open(model, body):
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        volume += fans_of_holes(position[first:end], triangles - first)[0]
    return volume


@jit
def room_in(model: Model, position: np.ndarray, body: int) -> float:
    """Return the room [m³] for gas and liquid in a soft body at `position` (n, 3) [m]: boxes inside take some."""
    return soft_volume(model, position, body) - model.soft_boxes_volume[body]
