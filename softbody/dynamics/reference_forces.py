"""The forces in their readable form, edge by edge and triangle by triangle: springs and gas.

Worlds move by the fast form, softbody/dynamics/one_ring_forces.py, which is tested against this one; they take their
energies from here.
"""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit
from softbody.dynamics.pressure import gas_pressure, room_in
from softbody.geometry.triangle import area_vector
from softbody.linalg.vec import accumulate, load, norm, scale, sub
from softbody.model.arrays import Controls, Model


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
def plain_accelerations(model: Model, controls: Controls, position: np.ndarray, acceleration: np.ndarray) -> None:
    """Overwrite `acceleration` (n, 3) [m/s²] with (springs + gas)/m + gravity at `position` (n, 3) [m]; §5.1.

    Forces from outside and fixed particles count; damping and drag, which need velocities, do not.
    """
    acceleration[:] = 0.0
    for body in range(model.soft_count):
        edges = slice(model.soft_edge_start[body], model.soft_edge_start[body + 1])
        triangles = model.triangle_particles[model.soft_triangle_start[body] : model.soft_triangle_start[body + 1]]
        add_spring_forces(
            position,
            model.edge_particles[edges],
            model.edge_rest_length[edges],
            model.edge_stiffness[edges],
            acceleration,
        )
        pressure = gas_pressure(controls.soft_gas[body], room_in(model, position, body))
        add_pressure_forces(position, triangles, pressure, acceleration)
    loaded = controls.particle_force.shape[0] > 0
    for i in range(position.shape[0]):
        for c in range(3):
            force = acceleration[i, c] + (controls.particle_force[i, c] if loaded else 0.0)
            fall = controls.gravity[c] if model.particle_inverse_mass[i] > 0.0 else 0.0
            acceleration[i, c] = force * model.particle_inverse_mass[i] + fall
