"""What the bodies of a World have, by the judge: the World's arrays are read, and none of its sums."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softbody import World

if TYPE_CHECKING:
    from references.accounts import Accounts


def energy(world: World, behind: float = 0.0) -> float:
    """Return the energy [J]: kinetic, of springs and gas, of weight and of the forces on particles.

    The velocities of soft bodies count as `behind` their places by so many seconds. Symplectic Euler's are by half a
    step: it is the leapfrog method, and taken at one time its energy sways with the power of the forces, by up to h ω/2
    of what vibrates, and not by its square.
    """
    lag = sum(_gained(world, k, behind) for k in range(world.model.soft_count)) if behind else 0.0
    return sum(part.energy for part in _parts(world)) + lag


def momentum(world: World) -> np.ndarray:
    """Return the momentum (3,) [kg m/s]."""
    return np.sum([part.momentum for part in _parts(world)], axis=0)


def angular_momentum(world: World) -> np.ndarray:
    """Return the angular momentum (3,) [kg m²/s] about the origin."""
    return np.sum([part.angular_momentum for part in _parts(world)], axis=0)


def of_each(world: World) -> list[Accounts]:
    """Return the accounts of each soft body, then of each box."""
    soft = [_of_soft_body(world, k) for k in range(world.model.soft_count)]
    return soft + [_of_boxes(world, slice(k, k + 1)) for k in range(world.model.box_count)]


def _parts(world: World) -> list[Accounts]:
    """Return the accounts of each soft body, and of all boxes at once."""
    return [*(_of_soft_body(world, k) for k in range(world.model.soft_count)), _of_boxes(world, slice(None))]


def _of_soft_body(world: World, k: int) -> Accounts:
    from references import accounts, scipy

    model, controls, state = world.model, world.controls, world.state
    rows = slice(*model.soft_particle_start[k : k + 2])
    edges, triangles = (slice(*start[k : k + 2]) for start in (model.soft_edge_start, model.soft_triangle_start))
    free = model.particle_inverse_mass[rows] > 0.0
    moving = accounts.of_particles(
        1.0 / model.particle_inverse_mass[rows][free],
        state.particle_position[rows][free],
        state.particle_velocity[rows][free],
        controls.gravity,
        controls.particle_force[rows][free] if len(controls.particle_force) else 0.0,
    )
    stretched = scipy.energy(
        state.particle_position[rows],
        model.edge_particles[edges] - rows.start,
        model.edge_rest_length[edges],
        model.edge_stiffness[edges],
        model.triangle_particles[triangles] - rows.start,
        float(controls.soft_gas[k]),
    )
    return moving._replace(energy=moving.energy + stretched)


def _gained(world: World, k: int, seconds: float) -> float:
    """Return the kinetic energy [J] that springs and gas give a soft body in some seconds, at the forces of now."""
    from references import scipy

    model, state = world.model, world.state
    rows = slice(*model.soft_particle_start[k : k + 2])
    edges, triangles = (slice(*start[k : k + 2]) for start in (model.soft_edge_start, model.soft_triangle_start))
    force = scipy.forces(
        state.particle_position[rows],
        model.edge_particles[edges] - rows.start,
        model.edge_rest_length[edges],
        model.edge_stiffness[edges],
        model.triangle_particles[triangles] - rows.start,
        float(world.controls.soft_gas[k]),
    )
    push = seconds * force
    yields = model.particle_inverse_mass[rows][:, None]
    return float((push * (state.particle_velocity[rows] + 0.5 * yields * push)).sum())


def _of_boxes(world: World, rows: slice) -> Accounts:
    from references import accounts

    model, state = world.model, world.state
    loose = model.box_inverse_mass[rows] > 0.0
    return accounts.of_boxes(
        model.box_size[rows][loose],
        1.0 / model.box_inverse_mass[rows][loose],
        state.box_position[rows][loose],
        state.box_orientation[rows][loose],
        state.box_velocity[rows][loose],
        state.box_angular_velocity[rows][loose],
        world.controls.gravity,
    )
