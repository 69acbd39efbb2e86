"""One time step of a whole world, and a run of many."""

from __future__ import annotations

import numpy as np

from softbody.collision.box_box import box_box_contact
from softbody.collision.ground import ground_boxes, ground_soft_bodies
from softbody.collision.impulse import resolve_contact
from softbody.collision.material import combined_friction, combined_restitution
from softbody.dynamics.motion import Scratch, move_soft_bodies
from softbody.dynamics.rigid import move_boxes
from softbody.jit import jit
from softbody.quaternion import load_quaternion
from softbody.state import Model, RigidBodies, State, boxes_of
from softbody.vec import Vec, accumulate, load, scale, store


@jit
def run(
    model: Model, state: State, scratch: Scratch, h: float, steps: int, integrator: int, paper_axes: bool, substeps: int
) -> tuple[int, int, int]:
    """Advance a world by `steps` steps of `h` [s]; return (steps done, fault, soft body).

    `scratch` from scratch_for. Soft bodies take each step in `substeps` equal parts; boxes and contacts take it as
    one. On a fault (DIVERGED or COLLAPSED, else 0) the state is that of the last good step.
    """
    bodies = boxes_of(model, state)
    stretch = 1 if soft_bodies_touch(model) else steps
    done = 0
    while done < steps:
        count = min(stretch, steps - done)
        part = h / substeps
        moved, fault, body = move_soft_bodies(model, state, part, count * substeps, integrator, scratch)
        if fault:
            count = moved // substeps
            move_soft_bodies(model, state, part, count * substeps, integrator, scratch)
        for i in range(state.position.shape[0]):
            store(state.position, i, load(scratch.position, i))
            store(state.velocity, i, load(scratch.velocity, i))
        for _ in range(count):
            move_boxes(model, state, h)
            collide_boxes(model, state, bodies, paper_axes)
            ground_boxes(model, state, bodies)
        done += count
        if fault:
            return done, fault, body
        ground_soft_bodies(model, state)
    return steps, 0, -1


@jit
def soft_bodies_touch(model: Model) -> bool:
    """Tell whether soft bodies can touch anything, so that they must stop for contacts after every step."""
    return model.ground_height > -np.inf


@jit
def collide_boxes(model: Model, state: State, bodies: RigidBodies, paper_axes: bool) -> None:
    """Part every pair of boxes that overlap: first their velocities by an impulse, then their positions."""
    for a in range(model.box_size.shape[0]):
        for b in range(a):
            share = model.box_inverse_mass[a] + model.box_inverse_mass[b]
            if share == 0.0:
                continue
            depth, point, normal = box_box_contact(
                load(model.box_size, a),
                load(state.box_position, a),
                load_quaternion(state.box_orientation, a),
                load(model.box_size, b),
                load(state.box_position, b),
                load_quaternion(state.box_orientation, b),
                paper_axes,
            )
            if depth > 0.0:
                restitution = combined_restitution(model.box_restitution[a], model.box_restitution[b])
                friction = combined_friction(model.box_friction[a], model.box_friction[b])
                resolve_contact(bodies, a, b, point, normal, restitution, friction)
                separate(bodies, a, b, scale(depth / share, normal))


@jit
def separate(bodies: RigidBodies, a: int, b: int, shift: Vec) -> None:
    """Move a and b apart by `shift` [kg m] times their inverse masses."""
    accumulate(bodies.position, a, scale(bodies.inverse_mass[a], shift))
    accumulate(bodies.position, b, scale(-bodies.inverse_mass[b], shift))
