"""Energy, linear momentum and angular momentum of the bodies."""

from __future__ import annotations

from typing import NamedTuple

from softbody.compiler.jit import jit
from softbody.dynamics.filling import filling_energies
from softbody.dynamics.liquid_forces import liquid_energy
from softbody.dynamics.pressure import gas_energy, room_in
from softbody.dynamics.reference_forces import spring_energy
from softbody.linalg.quaternion import load_quaternion, rotate_diagonal
from softbody.linalg.vec import Vec, add, cross, dot, load, scale
from softbody.model.arrays import Controls, Model, State


class Energies(NamedTuple):
    """Energy [J] of every body that can move, by kind. Only differences mean something, but of the first two."""

    kinetic: float  # ½ Σ m v² + ½ Σ ω·Iω
    spring: float  # ½ Σ k (l − l0)²
    gas: float  # −Σ nRT ln(V / V0), what the gas can be made to do: V0 is stated where they come from
    gravity: float  # −Σ m g·x, of liquid in a body by the centre of its volume
    external: float  # −Σ f·x of the forces on particles; forces on boxes are not in it
    liquid: float  # ρ g ∫ depth dV over what is submerged, and of liquids in bodies that are pressed together

    @property
    def total(self) -> float:
        """The sum of all [J]."""
        return sum(self)


@jit
def kinetic_energy(model: Model, state: State) -> float:
    """Return ½ Σ m v² + ½ Σ ω·Iω [J] of every body that can move."""
    energy = 0.0
    for i in range(state.particle_position.shape[0]):
        if model.particle_inverse_mass[i] > 0.0:
            v = load(state.particle_velocity, i)
            energy += 0.5 * dot(v, v) / model.particle_inverse_mass[i]
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            v = load(state.box_velocity, i)
            w = load(state.box_angular_velocity, i)
            energy += 0.5 * dot(v, v) / model.box_inverse_mass[i] + 0.5 * dot(w, _box_spin(model, state, i))
    return energy


@jit
def potential_energies(model: Model, controls: Controls, state: State) -> tuple[float, float, float, float, float]:
    """Return the energy [J] of springs, gas against 1 m³, in gravity, external forces and liquid; see `Energies`."""
    spring = gas = gravity = external = 0.0
    for body in range(model.soft_count):
        edges = slice(model.soft_edge_start[body], model.soft_edge_start[body + 1])
        spring += spring_energy(
            state.particle_position,
            model.edge_particles[edges],
            model.edge_rest_length[edges],
            model.edge_stiffness[edges],
        )
        if controls.soft_gas[body] > 0.0:
            room = room_in(model, state.particle_position, body)
            if room > 0.0:
                gas += gas_energy(controls.soft_gas[body], room)
    g = controls.gravity[0], controls.gravity[1], controls.gravity[2]
    for i in range(state.particle_position.shape[0]):
        if model.particle_inverse_mass[i] > 0.0:
            gravity -= dot(g, load(state.particle_position, i)) / model.particle_inverse_mass[i]
            if controls.particle_force.shape[0] > 0:
                external -= dot(load(controls.particle_force, i), load(state.particle_position, i))
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            gravity -= dot(g, load(state.box_position, i)) / model.box_inverse_mass[i]
    weight, liquid = filling_energies(model, controls.gravity, state)
    gravity += weight
    if model.liquid_density > 0.0:
        liquid += liquid_energy(model, controls.gravity, state)
    return spring, gas, gravity, external, liquid


@jit
def potential_energy(model: Model, controls: Controls, state: State) -> float:
    """Return all energy [J] but the kinetic."""
    spring, gas, gravity, external, liquid = potential_energies(model, controls, state)
    return spring + gas + gravity + external + liquid


@jit
def total_energy(model: Model, controls: Controls, state: State) -> float:
    """Return kinetic plus potential energy [J]."""
    return kinetic_energy(model, state) + potential_energy(model, controls, state)


@jit
def linear_momentum(model: Model, state: State) -> Vec:
    """Return Σ m v [kg m/s] of every body that can move."""
    momentum = (0.0, 0.0, 0.0)
    for i in range(state.particle_position.shape[0]):
        if model.particle_inverse_mass[i] > 0.0:
            momentum = add(momentum, scale(1.0 / model.particle_inverse_mass[i], load(state.particle_velocity, i)))
    for i in range(state.box_position.shape[0]):
        if model.box_inverse_mass[i] > 0.0:
            momentum = add(momentum, scale(1.0 / model.box_inverse_mass[i], load(state.box_velocity, i)))
    return momentum


@jit
def angular_momentum(model: Model, state: State) -> Vec:
    """Return Σ x × m v + Σ I ω [kg m²/s] about the origin, of every body that can move."""
    momentum = (0.0, 0.0, 0.0)
    for i in range(state.particle_position.shape[0]):
        if model.particle_inverse_mass[i] > 0.0:
            orbit = cross(load(state.particle_position, i), load(state.particle_velocity, i))
            momentum = add(momentum, scale(1.0 / model.particle_inverse_mass[i], orbit))
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
