"""Forces of a liquid on what is in it: pressure that grows with depth, and drag.

The liquid is at rest, or flows all at one velocity, below a level surface that bodies do not move. Its pressure
ρ g depth acts on the wet part of each triangle, which is cut at the surface exactly: as forces on its corners by their
weights, so that they are −∂U/∂x of the energy U = ρ g ∫ depth dV. Drag, by wet area, acts on the corners too. A box is
eight corners, whose forces act on it as one. Waves, splash and the mass of the liquid that moves along are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.box import box_corners
from softbody.geometry.submerged import double_area, submerged_part, wet_part
from softbody.linalg.quaternion import load_quaternion
from softbody.linalg.vec import Vec, accumulate, add, cross, load, norm, scale, store, sub
from softbody.model.arrays import NOBODY, Controls, Model, State

# Two triangles on each face of a box, by its corners, counter-clockwise seen from outside.
BOX_TRIANGLES = np.array(
    [
        [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5], [0, 1, 5], [0, 5, 4],
        [2, 6, 7], [2, 7, 3], [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6],
    ]
)  # fmt: skip


class Medium(NamedTuple):
    """A liquid, as triangles feel it."""

    level: float  # z [m] of its surface
    push: float  # [N/m³] half of ρ g, along z
    drag: float  # [N s/m³] half of it
    flow: Vec  # [m/s]


class Moving(NamedTuple):
    """Corners of triangles, as they will be in a moment."""

    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    ahead: float  # [s]


@jit
def add_liquid_forces(model: Model, gravity: np.ndarray, state: State, ahead: float, acting: Controls) -> None:
    """Add what the liquid does to all bodies to what acts on them; soft bodies as they will be `ahead` [s]."""
    medium = medium_of(model, gravity)
    moving = Moving(state.particle_position, state.particle_velocity, ahead)
    press(medium, moving, model.triangle_particles, acting.particle_force)
    force = np.empty((8, 3))
    for box in range(model.box_count):
        centre = load(state.box_position, box)
        is_near = centre[2] - 0.5 * norm(load(model.box_size, box)) < medium.level
        if is_near and can_be_wet(model, box):
            corners = corners_of(model, state, box)
            force[:] = 0.0
            press(medium, Moving(corners, velocities_of(state, box, corners), 0.0), BOX_TRIANGLES, force)
            for k in range(8):
                accumulate(acting.box_force, box, load(force, k))
                accumulate(acting.box_torque, box, cross(sub(load(corners, k), centre), load(force, k)))


@jit_lean
def can_be_wet(model: Model, box: int) -> bool:
    """Tell whether the world's liquid acts on a box: one that can move, and does not hang in a soft body."""
    return model.box_inverse_mass[box] > 0.0 and model.box_host[box] == NOBODY


@jit_lean
def medium_of(model: Model, gravity: np.ndarray) -> Medium:
    """Return the liquid of a world."""
    u = model.liquid_velocity
    push = 0.5 * model.liquid_density * gravity[2]
    return Medium(model.liquid_surface_height, push, 0.5 * model.liquid_drag, (u[0], u[1], u[2]))


@jit_lean
def press(medium: Medium, moving: Moving, triangles: np.ndarray, force: np.ndarray) -> None:
    """Add what the liquid does to `triangles` (t, 3) to the `force` (n, 3) [N] on their corners."""
    x, v, ahead = moving
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        depth = (
            medium.level - x[i, 2] - ahead * v[i, 2],
            medium.level - x[j, 2] - ahead * v[j, 2],
            medium.level - x[k, 2] - ahead * v[k, 2],
        )
        if depth[0] > 0.0 or depth[1] > 0.0 or depth[2] > 0.0:
            normal = double_area(place_of(moving, i), place_of(moving, j), place_of(moving, k))
            wet, resistance = wet_part(depth), 0.0
            if medium.drag > 0.0:
                resistance = medium.drag * norm(normal)
            for c in range(3):
                corner = triangles[t, c]
                on = scale(medium.push * wet.load[c], normal)
                if resistance > 0.0:
                    on = add(on, scale(resistance * wet.share[c], sub(medium.flow, load(v, corner))))
                accumulate(force, corner, on)


@jit_lean
def place_of(moving: Moving, i: int) -> Vec:
    """Return where a corner will be [m]."""
    return add(load(moving.position, i), scale(moving.ahead, load(moving.velocity, i)))


@jit
def corners_of(model: Model, state: State, box: int) -> np.ndarray:
    """Return the corners (8, 3) [m] of a box."""
    return box_corners(
        load(model.box_size, box), load(state.box_position, box), load_quaternion(state.box_orientation, box)
    )


@jit
def velocities_of(state: State, box: int, corners: np.ndarray) -> np.ndarray:
    """Return the velocities (8, 3) [m/s] of the `corners` (8, 3) [m] of a box."""
    velocities, centre = np.empty((8, 3)), load(state.box_position, box)
    v, spin = load(state.box_velocity, box), load(state.box_angular_velocity, box)
    for k in range(8):
        store(velocities, k, add(v, cross(spin, sub(load(corners, k), centre))))
    return velocities


@jit
def liquid_energy(model: Model, gravity: np.ndarray, state: State) -> float:
    """Return the energy U = ρ g ∫ depth dV [J] of all that is submerged of bodies that can move."""
    depth, level = 0.0, model.liquid_surface_height
    for body in range(model.soft_count):
        triangles = model.triangle_particles[model.soft_triangle_start[body] : model.soft_triangle_start[body + 1]]
        depth += submerged_part(state.particle_position, triangles, level).depth
    for box in range(model.box_count):
        if can_be_wet(model, box):
            depth += submerged_part(corners_of(model, state, box), BOX_TRIANGLES, level).depth
    return -model.liquid_density * gravity[2] * depth
