"""Response of boxes that reach below the ground, by the paper's single impulses.

Boxes whose contacts are solved together have theirs with the ground among them. Particles land in
`softbody.dynamics.particle_ground`.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.impulse import apply_friction, apply_impulse, inverse_effective_mass_at, velocity_of_point
from softbody.compiler.jit import jit
from softbody.geometry.box import box_corner
from softbody.linalg.quaternion import load_quaternion
from softbody.linalg.vec import Vec, load
from softbody.model.arrays import NOBODY, Model, RigidBodies, State
from softbody.model.material import (
    Material,
    combined,
    material_of_box,
    material_of_ground,
    speed_after,
)

UP = (0.0, 0.0, 1.0)

# A box that lies flat touches with four corners at once; impulses at one corner undo those at the others.
# Sixteen rounds leave 1e-13 of the approach speed for a cube and 9e-5 for a tower of 1:1:5.
BOX_ROUNDS = 16


@jit
def resolve_ground_of_boxes(model: Model, state: State, bodies: RigidBodies, grounded: np.ndarray) -> None:
    """Stop the corners of boxes that go down below the ground, then lift each box out of it.

    `grounded` (m,) of bool is set to whether each box was below.
    """
    grounded[:] = False
    for box in range(model.box_count):
        if model.box_inverse_mass[box] == 0.0:
            continue
        material = combined(material_of_box(model, box), material_of_ground(model))
        size = load(model.box_size, box)
        position = load(state.box_position, box)
        orientation = load_quaternion(state.box_orientation, box)
        lowest = model.ground_height
        for k in range(8):
            lowest = min(lowest, box_corner(size, position, orientation, k)[2])
        if lowest < model.ground_height:
            grounded[box] = True
            bounce_box(bodies, box, size, model.ground_height, material)
            state.box_position[box, 2] += model.ground_height - lowest


@jit
def bounce_box(bodies: RigidBodies, box: int, size: Vec, height: float, material: Material) -> None:
    """Stop all corners of one box below z = `height` [m] at once: u_z' ≥ −e u_z of before, then friction.

    Sequential impulses (Catto 2005): a corner's impulse may shrink again in a later round, but not below zero.
    Friction waits for the last round: before, the corners slide by what the impulses elsewhere leave behind.
    """
    position = load(bodies.position, box)
    orientation = load_quaternion(bodies.orientation, box)
    target = np.zeros(8)
    impulse = np.zeros(8)
    # How fast each corner must go up afterwards.
    for k in range(8):
        corner = box_corner(size, position, orientation, k)
        approach = max(0.0, -velocity_of_point(bodies, box, corner)[2])
        target[k] = speed_after(approach, material.restitution)
    # Normal impulses, corner by corner, again and again.
    for _ in range(BOX_ROUNDS):
        for k in range(8):
            corner = box_corner(size, position, orientation, k)
            if corner[2] < height:
                lack = target[k] - velocity_of_point(bodies, box, corner)[2]
                change = max(-impulse[k], lack / inverse_effective_mass_at(bodies, box, corner, UP))
                impulse[k] += change
                apply_impulse(bodies, box, corner, (0.0, 0.0, change))
    # Friction where something was pushed.
    for k in range(8):
        if impulse[k] > 0.0:
            corner = box_corner(size, position, orientation, k)
            apply_friction(bodies, (box, NOBODY), corner, UP, material.friction * impulse[k])
