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
from softbody.collision.ground import ground_boxes, ground_soft_bodies
from softbody.collision.impulse import NOBODY, resolve_contact
from softbody.collision.manifold import new_scratch
from softbody.collision.material import combined_friction, combined_restitution
from softbody.collision.solver import inverse_masses, prepare_contacts, solve_displacements, solve_velocities
from softbody.dynamics.integrators import WORK_ROWS, integrate
from softbody.dynamics.rigid import accelerate_boxes, advance_boxes, limit_boxes, shift_boxes
from softbody.geometry.polyhedron import signed_volume
from softbody.jit import jit
from softbody.quaternion import load_quaternion
from softbody.state import Model, RigidBodies, Rules, State, boxes_of
from softbody.vec import Vec, accumulate, load, scale

# What stopped `run`: a soft body, or more contacts than there is room for.
DIVERGED = 1
COLLAPSED = 2
OVERFLOW = 3

# The part of the speed that gravity gives in a step below which a correction by the contact solver is not worth another
# sweep. Without gravity all sweeps are made.
ENOUGH = 1e-4


@jit
def run(
    model: Model, state: State, h: float, steps: int, integrator: int, rules: Rules, contacts: Contacts
) -> tuple[int, int, int]:
    """Advance a world by `steps` steps of `h` [s]; return (steps done, fault, soft body).

    On a fault (DIVERGED or COLLAPSED, else 0) the state is that of the last good step; so it is on OVERFLOW, when
    `contacts` must grow before the run can go on.
    """
    next_position = np.empty_like(state.position)
    next_velocity = np.empty_like(state.velocity)
    work = np.empty((WORK_ROWS, state.position.shape[0], 3))
    bodies = boxes_of(model, state)
    grounded = np.zeros(state.box_position.shape[0], np.bool_)
    scratch = new_scratch()
    for done in range(steps):
        if not rules.single_contact:
            find_contacts(model, state, h, rules, contacts, scratch)
            if contacts.number[0] > contacts.depth.shape[0]:
                return done, OVERFLOW, -1
        integrate(integrator, model, state.position, state.velocity, h, next_position, next_velocity, work)
        fault, body = find_fault(model, next_position, next_velocity, h)
        if fault:
            return done, fault, body
        state.position[:] = next_position
        state.velocity[:] = next_velocity
        if rules.single_contact:
            step_boxes_singly(model, state, bodies, h, rules, grounded)
        else:
            step_boxes(model, state, bodies, h, rules, contacts, grounded)
        limit_boxes(model, state, rules, grounded)
        ground_soft_bodies(model, state)
    return steps, 0, -1


@jit
def find_fault(model: Model, position: np.ndarray, velocity: np.ndarray, h: float) -> tuple[int, int]:
    """Return (fault, soft body) of the first soft body that diverged or collapsed, or (0, −1).

    Diverged: some particle is not finite, or would cross its whole body in one more step, as seen from the
    body's mean velocity. Collapsed: the gas has no volume left, and its pressure no meaning.
    """
    for body in range(model.gas.shape[0]):
        first = model.particle_start[body]
        end = model.particle_start[body + 1]
        mean = (0.0, 0.0, 0.0)
        low = load(position, first)
        high = low
        for i in range(first, end):
            mean = (mean[0] + velocity[i, 0], mean[1] + velocity[i, 1], mean[2] + velocity[i, 2])
            p = load(position, i)
            low = (min(low[0], p[0]), min(low[1], p[1]), min(low[2], p[2]))
            high = (max(high[0], p[0]), max(high[1], p[1]), max(high[2], p[2]))
        mean = scale(1.0 / (end - first), mean)
        extent = max(high[0] - low[0], high[1] - low[1], high[2] - low[2])
        for i in range(first, end):
            for c in range(3):
                # Written so that NaN, for which every comparison is false, counts as diverged.
                if not h * abs(velocity[i, c] - mean[c]) < extent:
                    return DIVERGED, body
        triangles = model.triangles[model.triangle_start[body] : model.triangle_start[body + 1]]
        volume = signed_volume(position, triangles)
        if not volume < np.inf:
            return DIVERGED, body
        if volume <= 0.0:
            return COLLAPSED, body
    return 0, -1


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
