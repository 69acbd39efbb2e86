"""How much energy, momentum and angular momentum do the bodies have?"""

from __future__ import annotations

from softbody.dynamics.pressure import gas_energy
from softbody.dynamics.soft import body_volume
from softbody.dynamics.springs import spring_energy
from softbody.jit import jit
from softbody.quaternion import load_quaternion, rotate_diagonal
from softbody.state import Model, State
from softbody.vec import Vec, add, cross, dot, load, scale


@jit
def kinetic_energy(model: Model, state: State) -> float:
    """Return ½ Σ m v² + ½ Σ ω·Iω [J] of every body that can move."""
    energy = 0.0
    for i in range(state.position.shape[0]):
        if model.inverse_mass[i] > 0.0:
            v = load(state.velocity, i)
            energy += 0.5 * dot(v, v) / model.inverse_mass[i]
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            v = load(state.box_velocity, i)
            w = load(state.box_angular_velocity, i)
            energy += 0.5 * dot(v, v) / model.box_inverse_mass[i] + 0.5 * dot(w, _box_spin(model, state, i))
    return energy


@jit
def potential_energy(model: Model, state: State) -> float:
    """Return ½ Σ k (l − l0)² − Σ nRT ln V − Σ m g·x − Σ f·x [J] of all that can move; f are external forces."""
    energy = 0.0
    for body in range(model.gas.shape[0]):
        edges = slice(model.edge_start[body], model.edge_start[body + 1])
        energy += spring_energy(state.position, model.edges[edges], model.rest_length[edges], model.stiffness[edges])
        if model.gas[body] > 0.0:
            energy += gas_energy(model.gas[body], body_volume(model, state.position, body))
    g = load(model.gravity.reshape(1, 3), 0)
    for i in range(state.position.shape[0]):
        if model.inverse_mass[i] > 0.0:
            energy -= dot(g, load(state.position, i)) / model.inverse_mass[i]
            if model.external_force.shape[0] > 0:
                energy -= dot(load(model.external_force, i), load(state.position, i))
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            energy -= dot(g, load(state.box_position, i)) / model.box_inverse_mass[i]
    return energy


@jit
def total_energy(model: Model, state: State) -> float:
    """Return kinetic plus potential energy [J]."""
    return kinetic_energy(model, state) + potential_energy(model, state)


@jit
def linear_momentum(model: Model, state: State) -> Vec:
    """Return Σ m v [kg m/s] of every body that can move."""
    momentum = (0.0, 0.0, 0.0)
    for i in range(state.position.shape[0]):
        if model.inverse_mass[i] > 0.0:
            momentum = add(momentum, scale(1.0 / model.inverse_mass[i], load(state.velocity, i)))
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            momentum = add(momentum, scale(1.0 / model.box_inverse_mass[i], load(state.box_velocity, i)))
    return momentum


@jit
def angular_momentum(model: Model, state: State) -> Vec:
    """Return Σ x × m v + Σ I ω [kg m²/s] about the origin, of every body that can move."""
    momentum = (0.0, 0.0, 0.0)
    for i in range(state.position.shape[0]):
        if model.inverse_mass[i] > 0.0:
            orbit = cross(load(state.position, i), load(state.velocity, i))
            momentum = add(momentum, scale(1.0 / model.inverse_mass[i], orbit))
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            orbit = cross(load(state.box_position, i), load(state.box_velocity, i))
            momentum = add(momentum, scale(1.0 / model.box_inverse_mass[i], orbit))
            momentum = add(momentum, _box_spin(model, state, i))
    return momentum


@jit
def _box_spin(model: Model, state: State, i: int) -> Vec:
    """Return I ω [kg m²/s] of a box that can move."""
    inverse = load(model.box_inverse_inertia, i)
    inertia = (1.0 / inverse[0], 1.0 / inverse[1], 1.0 / inverse[2])
    return rotate_diagonal(load_quaternion(state.box_orientation, i), inertia, load(state.box_angular_velocity, i))
