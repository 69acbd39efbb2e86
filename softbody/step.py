"""One time step of a whole world, and a run of many."""

from __future__ import annotations

import numpy as np

from softbody.collision.box_box import box_box_contact
from softbody.collision.contacts import (
    Contacts,
    fall_in_step,
    find_contacts,
    pairs_of_boxes,
    recall_impulses,
    remember_impulses,
)
from softbody.collision.fast import parts_of_step
from softbody.collision.ground import ground_boxes, ground_soft_bodies
from softbody.collision.impulse import NOBODY, resolve_contact
from softbody.collision.manifold import new_scratch
from softbody.collision.material import combined_friction, combined_restitution
from softbody.collision.skins import Skins
from softbody.collision.soft_contacts import collide_soft_bodies
from softbody.collision.soft_response import room_for_soft_contacts
from softbody.collision.solver import inverse_masses, prepare_contacts, solve_displacements, solve_velocities
from softbody.dynamics.motion import Scratch, move_soft_bodies
from softbody.dynamics.rigid import accelerate_boxes, advance_boxes, limit_boxes, shift_boxes
from softbody.jit import jit
from softbody.quaternion import load_quaternion
from softbody.state import Model, RigidBodies, Rings, Rules, State, boxes_of, copied
from softbody.vec import Vec, accumulate, load, scale, store

# What stopped `run`, besides a soft body that DIVERGED or COLLAPSED: more contacts than there is room for.
OVERFLOW = 3

FIRST_ROOM = 256  # contacts of soft bodies; there is more as soon as it is needed

# The part of the speed that gravity gives in a step below which a correction by the contact solver is not worth another
# sweep. Without gravity all sweeps are made.
ENOUGH = 1e-4


@jit
def run_soft_bodies(
    model: Model,
    rings: Rings,
    state: State,
    scratch: Scratch,
    h: float,
    steps: int,
    integrator: int,
    substeps: int,
    threads: int | None,
) -> tuple[int, int, int]:
    """Advance a world of one soft body by `steps` steps of `h` [s]; return (steps done, fault, soft body).

    `scratch` from scratch_for. Soft bodies take each step in `substeps` equal parts, contacts take it as one. On a
    fault (DIVERGED or COLLAPSED, else 0) the state is that of the last good step. The same as `run`, but compiled in a
    third of the time. On `threads`, of which `scratch` must know, with the same result; None: on one, for which
    nothing else needs to be compiled.
    """
    # Without a ground they meet nothing, and need not stop after every step.
    stretch = 1 if model.ground_height > -np.inf else steps
    done = 0
    while done < steps:
        count = min(stretch, steps - done)
        count, fault, body = step_soft_bodies(model, rings, state, scratch, h, count, integrator, substeps, threads)
        ground_soft_bodies(model, state)
        done += count
        if fault:
            return done, fault, body
    return steps, 0, -1


@jit
def run(
    model: Model,
    rings: Rings,
    state: State,
    scratch: Scratch,
    h: float,
    steps: int,
    integrator: int,
    rules: Rules,
    substeps: int,
    contacts: Contacts,
    skins: Skins,
    threads: int | None,
) -> tuple[int, int, int]:
    """Advance any world by `steps` steps of `h` [s]; return (steps done, fault, soft body).

    Boxes take each step as one, as contacts do; where bodies would jump through each other it is taken in parts. On a
    fault the state is that of the last good step; so it is on OVERFLOW, when `contacts` must grow before the run can
    go on. `threads` as of run_soft_bodies; they move soft bodies.
    """
    bodies = boxes_of(model, state)
    grounded = np.zeros(state.box_position.shape[0], np.bool_)
    clipping = new_scratch()
    touching = room_for_soft_contacts(FIRST_ROOM)
    for done in range(steps):
        parts = parts_of_step(model, state, h) if rules.split_steps else 1
        start = copied(state) if parts > 1 else state
        for _ in range(parts):
            part = h / parts
            if not rules.single_contact:
                find_contacts(model, state, part, rules, contacts, clipping)
                if contacts.number[0] > contacts.depth.shape[0]:
                    put_back(start, state)
                    return done, OVERFLOW, -1
            _, fault, body = step_soft_bodies(model, rings, state, scratch, part, 1, integrator, substeps, threads)
            if fault:
                put_back(start, state)
                return done, fault, body
            if rules.single_contact:
                step_boxes_singly(model, state, bodies, part, rules, grounded)
            else:
                step_boxes(model, state, bodies, part, rules, contacts, grounded)
            limit_boxes(model, state, rules, grounded)
            touching = collide_soft_bodies(model, state, bodies, skins, rules, touching)
            ground_soft_bodies(model, state)
    return steps, 0, -1


@jit
def put_back(start: State, state: State) -> None:
    """Overwrite the arrays of `state` with those of `start`."""
    state.position[:], state.velocity[:] = start.position, start.velocity
    state.box_position[:], state.box_orientation[:] = start.box_position, start.box_orientation
    state.box_velocity[:], state.box_angular_velocity[:] = start.box_velocity, start.box_angular_velocity


@jit
def step_soft_bodies(
    model: Model,
    rings: Rings,
    state: State,
    scratch: Scratch,
    h: float,
    steps: int,
    integrator: int,
    substeps: int,
    threads: int | None,
) -> tuple[int, int, int]:
    """Advance the soft bodies alone by `steps` steps of `h` [s]; return (steps done, fault, body)."""
    part = h / substeps
    moved, fault, body = move_soft_bodies(model, rings, state, part, steps * substeps, integrator, scratch, threads)
    if fault:
        steps = moved // substeps
        move_soft_bodies(model, rings, state, part, steps * substeps, integrator, scratch, threads)
    for i in range(state.position.shape[0]):
        store(state.position, i, load(scratch.position, i))
        store(state.velocity, i, load(scratch.velocity, i))
    return steps, fault, body


@jit
def step_boxes(
    model: Model, state: State, bodies: RigidBodies, h: float, rules: Rules, contacts: Contacts, grounded: np.ndarray
) -> None:
    """Advance all boxes by `h` [s], the velocities at all `contacts` solved together.

    Contacts come from where the boxes are, velocities are made to suit them, and then the boxes move: so a box that
    rests never enters what it rests on.
    """
    inverse = inverse_masses(bodies)
    prepare_contacts(contacts, bodies, inverse)
    recall_impulses(contacts)
    accelerate_boxes(model, state, h)
    fall = fall_in_step(model, h)
    solve_velocities(contacts, bodies, inverse, h, rules.iterations, ENOUGH * fall / h)
    remember_impulses(contacts)
    shift = solve_displacements(contacts, bodies, inverse, fall, rules.iterations)
    advance_boxes(model, state, h, rules.gyroscopic)
    shift_boxes(state, shift)
    grounded[:] = False
    for k in range(contacts.number[0]):
        if contacts.body[k, 1] == NOBODY and contacts.impulse[k, 2] > 0.0:
            grounded[contacts.body[k, 0]] = True


@jit
def step_boxes_singly(
    model: Model, state: State, bodies: RigidBodies, h: float, rules: Rules, grounded: np.ndarray
) -> None:
    """Advance all boxes by `h` [s], then part each pair that overlaps by one impulse, as in the paper; §4.4, §5.2."""
    accelerate_boxes(model, state, h)
    advance_boxes(model, state, h, rules.gyroscopic)
    collide_boxes(model, state, bodies, rules)
    ground_boxes(model, state, bodies, grounded)


@jit
def collide_boxes(model: Model, state: State, bodies: RigidBodies, rules: Rules) -> None:
    """Part every pair of boxes that overlap: first their velocities by an impulse, then their positions."""
    pairs = pairs_of_boxes(model, state, np.zeros(model.box_size.shape[0]), rules.exhaustive_pairs)
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        depth, point, normal = box_box_contact(
            load(model.box_size, a),
            load(state.box_position, a),
            load_quaternion(state.box_orientation, a),
            load(model.box_size, b),
            load(state.box_position, b),
            load_quaternion(state.box_orientation, b),
            rules.paper_axes,
        )
        if depth > 0.0:
            restitution = combined_restitution(model.box_restitution[a], model.box_restitution[b])
            friction = combined_friction(model.box_friction[a], model.box_friction[b])
            resolve_contact(bodies, a, b, point, normal, restitution, friction)
            share = model.box_inverse_mass[a] + model.box_inverse_mass[b]
            separate(bodies, a, b, scale(depth / share, normal))


@jit
def separate(bodies: RigidBodies, a: int, b: int, shift: Vec) -> None:
    """Move a and b apart by `shift` [kg m] times their inverse masses."""
    accumulate(bodies.position, a, scale(bodies.inverse_mass[a], shift))
    accumulate(bodies.position, b, scale(-bodies.inverse_mass[b], shift))
