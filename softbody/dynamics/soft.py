"""What acceleration does every particle of the soft bodies have?"""

from __future__ import annotations

import numpy as np

from softbody.dynamics.pressure import add_pressure_forces, gas_pressure
from softbody.dynamics.springs import add_spring_forces
from softbody.geometry.polyhedron import signed_volume
from softbody.jit import jit
from softbody.state import Model


@jit
def body_volume(model: Model, position: np.ndarray, body: int) -> float:
    """Return the signed volume [m³] of one soft body at `position` (n, 3) [m]."""
    triangles = model.triangles[model.triangle_start[body] : model.triangle_start[body + 1]]
    return signed_volume(position, triangles)


@jit
def soft_accelerations(model: Model, position: np.ndarray, acceleration: np.ndarray) -> None:
    """Overwrite `acceleration` (n, 3) [m/s²] with (springs + gas)/m + gravity at `position` (n, 3) [m]; §5.1.

    The obvious form, edge by edge and triangle by triangle, which the fast one (softbody/dynamics/ring_forces.py) is
    tested against. External forces and pins count; damping and drag, which need velocities, do not.
    """
    acceleration[:] = 0.0
    for body in range(model.gas.shape[0]):
        edges = slice(model.edge_start[body], model.edge_start[body + 1])
        triangles = model.triangles[model.triangle_start[body] : model.triangle_start[body + 1]]
        add_spring_forces(position, model.edges[edges], model.rest_length[edges], model.stiffness[edges], acceleration)
        pressure = gas_pressure(model.gas[body], signed_volume(position, triangles))
        add_pressure_forces(position, triangles, pressure, acceleration)
    pushed = model.external_force.shape[0] > 0
    for i in range(position.shape[0]):
        for c in range(3):
            force = acceleration[i, c] + (model.external_force[i, c] if pushed else 0.0)
            fall = model.gravity[c] if model.inverse_mass[i] > 0.0 else 0.0
            acceleration[i, c] = force * model.inverse_mass[i] + fall
