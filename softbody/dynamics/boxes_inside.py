"""Boxes that are inside a soft body full of a liquid: what the liquid does to them, and they to it.

A box takes the place of liquid, which weighs ρ V g there: so much bears it up, and all of the liquid the more. Drag is
that of a pool, against the liquid's own motion: with the momentum and the angular momentum of the particles, as a rigid
body. They get what drags a box back, so that both momenta are kept.
"""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit
from softbody.dynamics.filling import liquid_mass, volume_in, volume_of_box
from softbody.dynamics.liquid_forces import BOX_TRIANGLES, Medium, Moving, corners_of, press, velocities_of
from softbody.geometry.affine_fit import Rows3, inertia_of, mean_of, solved
from softbody.linalg.vec import Vec, accumulate, add, cross, load, norm, scale, store, sub
from softbody.model.arrays import Controls, Model, State


@jit
def add_forces_inside(model: Model, gravity: np.ndarray, state: State, ahead: float, acting: Controls) -> None:
    """Add what liquids in soft bodies do to boxes inside to what acts; soft bodies as they will be `ahead` [s]."""
    g = gravity[0], gravity[1], gravity[2]
    moving = Moving(state.particle_position, state.particle_velocity, ahead)
    for body in range(model.soft_count):
        mass = liquid_mass(model, body)
        if mass > 0.0 and model.soft_boxes_volume[body] > 0.0:
            density = mass / (volume_in(model, moving, body) - model.soft_boxes_volume[body])
            for box in range(model.box_count):
                if model.box_host[box] == body:
                    accumulate(acting.box_force, box, scale(-density * volume_of_box(model, box), g))
            if model.soft_liquid_drag[body] > 0.0:
                _drag(model, state, body, acting)


@jit
def _drag(model: Model, state: State, body: int, acting: Controls) -> None:
    """Let the liquid in a body drag boxes inside it along, and them the liquid."""
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    points, velocities = state.particle_position[first:end], state.particle_velocity[first:end]
    middle, inertia, flow, spin = _motion_of(points, velocities)
    half, still = 0.5 * model.soft_liquid_drag[body], (0.0, 0.0, 0.0)
    push, torque, on = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), np.empty((8, 3))
    for box in range(model.box_count):
        if model.box_host[box] == body:
            centre, corners = load(state.box_position, box), corners_of(model, state, box)
            against = velocities_of(state, box, corners)
            for k in range(8):
                carried = add(flow, cross(spin, sub(load(corners, k), middle)))
                store(against, k, sub(load(against, k), carried))
            on[:] = 0.0
            above = centre[2] + norm(load(model.box_size, box))
            press(Medium(above, 0.0, half, still), Moving(corners, against, 0.0), BOX_TRIANGLES, on)
            for k in range(8):
                force, corner = load(on, k), load(corners, k)
                accumulate(acting.box_force, box, force)
                accumulate(acting.box_torque, box, cross(sub(corner, centre), force))
                push, torque = sub(push, force), sub(torque, cross(sub(corner, middle), force))
    turn = solved(inertia, torque)
    for i in range(first, end):
        arm = sub(load(state.particle_position, i), middle)
        accumulate(acting.particle_force, i, add(scale(1.0 / (end - first), push), cross(turn, arm)))


@jit
def _motion_of(points: np.ndarray, velocities: np.ndarray) -> tuple[Vec, Rows3, Vec, Vec]:
    """Return middle [m], inertia, velocity [m/s] and spin [rad/s] of `points` (n, 3) [m] of mass 1 each."""
    middle, flow, moment = mean_of(points), mean_of(velocities), (0.0, 0.0, 0.0)
    for i in range(points.shape[0]):
        moment = add(moment, cross(sub(load(points, i), middle), load(velocities, i)))
    inertia = inertia_of(points, middle)
    return middle, inertia, flow, solved(inertia, moment)
