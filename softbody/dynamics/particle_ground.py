"""Contact of particles with the ground: lifted on to it, with restitution and friction.

Each particle by itself: the ground is fixed, and holds a particle as far as that would go below it. Contacts of boxes
with the ground are found in `softbody.collision.boxes.box_contacts`, and by the paper in
`softbody.collision.boxes.box_ground`.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import accumulate, load, scale, store, sub
from softbody.model.arrays import Model, State
from softbody.model.material import Material, combined, material_of_ground, material_of_soft, sliding_kept, speed_after
from softbody.model.sleep_state import SleepState, sleeps


@jit_lean
def resolve_ground(model: Model, state: State, impulse: np.ndarray, rest: SleepState | None, anew: bool) -> None:
    """Lift particles that are below the ground on to it, and let those that still go down bounce.

    What the ground gives each particle is added to `impulse` (n, 3) [N s], which begins `anew` with 0. Who sleeps keeps
    what it was given.
    """
    for body in range(model.soft_count):
        if sleeps(rest, body):
            continue
        material = material_on_ground(model, body)
        for i in range(model.soft_particle_start[body], model.soft_particle_start[body + 1]):
            if anew:
                store(impulse, i, (0.0, 0.0, 0.0))
            if state.particle_position[i, 2] < model.ground_height:
                before = load(state.particle_velocity, i)
                land(state.particle_position.T, state.particle_velocity.T, (i, i + 1), model.ground_height, material)
                change = sub(load(state.particle_velocity, i), before)
                if model.particle_inverse_mass[i] > 0.0:
                    accumulate(impulse, i, scale(1.0 / model.particle_inverse_mass[i], change))


@jit
def material_on_ground(model: Model, body: int) -> Material:
    """Return the material of a soft body and the ground together."""
    return combined(material_of_soft(model, body), material_of_ground(model))


@jit_lean
def land(position: np.ndarray, velocity: np.ndarray, part: tuple[int, int], height: float, material: Material) -> None:
    """Lift particles of a `part` (first, end) that are below z = `height` [m] on to it, and let them bounce.

    `position` [m] and `velocity` [m/s] are (3, n), a row for each component.
    """
    for i in range(part[0], part[1]):
        if position[2, i] < height:
            position[2, i] = height
            bounce_particle(velocity, i, material)


@jit_lean
def bounce_particle(velocity: np.ndarray, i: int, material: Material) -> None:
    """Reflect particle `i` that goes down: v_z' = −e v_z; friction takes at most μ (1 + e) |v_z| off its slide."""
    down = -velocity[2, i]
    if down <= 0.0:
        return
    velocity[2, i] = speed_after(down, material.restitution)
    slide = sqrt(velocity[0, i] ** 2 + velocity[1, i] ** 2)
    if slide > 0.0:
        kept = sliding_kept(slide, down, material)
        velocity[0, i] *= kept
        velocity[1, i] *= kept
