"""What happens to particles and boxes that reach below the ground?"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.collision.impulse import NOBODY, apply_friction, apply_impulse, point_mobility, point_velocity
from softbody.collision.material import combined_friction, combined_restitution
from softbody.geometry.box import box_corner
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion
from softbody.state import Model, RigidBodies, State
from softbody.vec import Vec, load

UP = (0.0, 0.0, 1.0)

# A box that lies flat touches with four corners at once; impulses at one corner undo those at the others.
# Sixteen rounds leave 1e-13 of the approach speed for a cube and 9e-5 for a tower of 1:1:5.
BOX_ROUNDS = 16


@jit_lean
def ground_soft_bodies(model: Model, state: State) -> None:
    """Lift particles that are below the ground on to it, and turn back those that still go down."""
    for body in range(model.gas.shape[0]):
        restitution = combined_restitution(model.soft_restitution[body], model.ground_restitution)
        friction = combined_friction(model.soft_friction[body], model.ground_friction)
        for i in range(model.particle_start[body], model.particle_start[body + 1]):
            if state.position[i, 2] < model.ground_height:
                state.position[i, 2] = model.ground_height
                bounce_particle(state.velocity, i, restitution, friction)


@jit_lean
def bounce_particle(velocity: np.ndarray, i: int, restitution: float, friction: float) -> None:
    """Reflect particle `i` that goes down: v_z' = −e v_z; friction takes at most μ (1 + e) |v_z| off its slide."""
    down = -velocity[i, 2]
    if down <= 0.0:
        return
    velocity[i, 2] = restitution * down
    slide = sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2)
    if slide > 0.0:
        kept = max(0.0, 1.0 - friction * (1.0 + restitution) * down / slide)
        velocity[i, 0] *= kept
        velocity[i, 1] *= kept


@jit
def ground_boxes(model: Model, state: State, bodies: RigidBodies, grounded: np.ndarray) -> None:
    """Turn back the corners of boxes that go down below the ground, then lift each box out of it.

    `grounded` (m,) of bool is set to whether each box was below.
    """
    grounded[:] = False
    for box in range(model.box_size.shape[0]):
        if model.box_inverse_mass[box] == 0.0:
            continue
        restitution = combined_restitution(model.box_restitution[box], model.ground_restitution)
        friction = combined_friction(model.box_friction[box], model.ground_friction)
        size = load(model.box_size, box)
        position = load(state.box_position, box)
        orientation = load_quaternion(state.box_orientation, box)
        lowest = model.ground_height
        for k in range(8):
            lowest = min(lowest, box_corner(size, position, orientation, k)[2])
        if lowest < model.ground_height:
            grounded[box] = True
            bounce_box(bodies, box, size, model.ground_height, restitution, friction)
            state.box_position[box, 2] += model.ground_height - lowest


@jit
def bounce_box(bodies: RigidBodies, box: int, size: Vec, height: float, restitution: float, friction: float) -> None:
    """Turn back all corners of one box below z = `height` [m] at once: u_z' ≥ −e u_z of before, then friction.

    Sequential impulses (Catto 2005): a corner's impulse may shrink again in a later round, but not below zero.
    Friction waits for the last round: before, the corners slide by what the impulses elsewhere leave behind.
    """
    position = load(bodies.position, box)
    orientation = load_quaternion(bodies.orientation, box)
    target = np.zeros(8)
    pushed = np.zeros(8)
    for k in range(8):
        corner = box_corner(size, position, orientation, k)
        target[k] = restitution * max(0.0, -point_velocity(bodies, box, corner)[2])
    for _ in range(BOX_ROUNDS):
        for k in range(8):
            corner = box_corner(size, position, orientation, k)
            if corner[2] < height:
                lack = target[k] - point_velocity(bodies, box, corner)[2]
                push = max(-pushed[k], lack / point_mobility(bodies, box, corner, UP))
                pushed[k] += push
                apply_impulse(bodies, box, corner, (0.0, 0.0, push))
    for k in range(8):
        if pushed[k] > 0.0:
            corner = box_corner(size, position, orientation, k)
            apply_friction(bodies, box, NOBODY, corner, UP, friction * pushed[k])
