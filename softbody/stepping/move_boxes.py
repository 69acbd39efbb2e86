"""Motion of boxes over one time step, contacts included: solved all together, or singly as in the paper."""

from __future__ import annotations

import numpy as np

from softbody.collision.boxes.box_contacts import (
    find_knock_ons,
    free_flights,
    near_boxes,
    penetration_slop,
    solved_flights,
)
from softbody.collision.boxes.box_ground import resolve_ground_of_boxes
from softbody.collision.boxes.manifold import Manifold
from softbody.collision.boxes.sat_boxes import PlacedBoxes, placed_box
from softbody.collision.boxes.single_contact import paper_contact
from softbody.collision.contact import Contacts
from softbody.collision.impulse import resolve_contact
from softbody.collision.solver.sequential_impulses import hold_pushed_boxes, solve_positions, solve_velocities
from softbody.collision.solver.solver_row import prepare_contacts
from softbody.collision.solver.warm_start import warm_start
from softbody.compiler.jit import jit
from softbody.dynamics.rigid_boxes import accelerate_boxes, advance_boxes, shift_boxes
from softbody.linalg.vec import Vec, accumulate, scale
from softbody.model.arrays import NOBODY, Controls, Model, RigidBodies, State, boxes_of
from softbody.model.material import combined, material_of_box
from softbody.model.settings import Settings

# The part of the speed that gravity gives in a step below which a correction by the contact solver is not worth another
# sweep. Without gravity all sweeps are made.
ENOUGH = 1e-4

# As many fewer sweeps are made over contacts that are solved but for a few new ones.
FEWER = 3


@jit
def move_boxes(
    model: Model,
    controls: Controls,
    state: State,
    grounded: np.ndarray | None,
    manifold: Manifold | None,
    contacts: Contacts,
    settings: Settings,
    h: float,
) -> Contacts:
    """Advance all boxes by `h` [s], the velocities at all their contacts solved together; return all these contacts.

    `grounded` (m,) of bool is set to which of them the ground holds; None: there are no boxes. Contacts come from where
    the boxes are, velocities are made to suit them, and then the boxes move: so a box that rests never enters what it
    rests on. Those that go into others by what contacts have done to them have contacts there too, and all are solved
    once more.
    """
    if grounded is None or manifold is None:
        return contacts
    boxes, slop = boxes_of(model, state), penetration_slop(controls, h)
    # Velocities.
    before = free_flights(model, controls, state, h)
    velocity, spin = boxes.velocity.copy(), boxes.angular_velocity.copy()
    iterations = settings.iterations
    warm_start(contacts)
    while True:
        prepare_contacts(contacts, boxes)
        accelerate_boxes(model, controls, state, h)
        solve_velocities(contacts, boxes, h, iterations, ENOUGH * slop / h)
        solved = contacts.number[1]
        if solved > 0:
            after = solved_flights(model, state, h)
            contacts = find_knock_ons(model, state, before, after, manifold, contacts, settings, slop)
            before = after
        if contacts.number[1] == solved:
            break
        # From what is solved so far, few sweeps more will do.
        boxes.velocity[:], boxes.angular_velocity[:], iterations = velocity, spin, max(1, settings.iterations // FEWER)
    # Positions.
    shift = solve_positions(contacts, boxes, slop, settings.iterations)
    advance_boxes(model, state, h, settings.gyroscopic)
    shift_boxes(state, shift)
    grounded[:] = False
    for k in range(contacts.number[1]):
        if contacts.box[k, 1] == NOBODY and contacts.impulse[k, 2] > 0.0:
            grounded[contacts.box[k, 0]] = True
    return contacts


@jit
def hold_boxes(
    model: Model,
    controls: Controls,
    state: State,
    grounded: np.ndarray | None,
    contacts: Contacts,
    push: np.ndarray | None,
    settings: Settings,
    h: float,
) -> None:
    """Let what boxes stand on hold those that soft bodies have pushed in a step of `h` [s], if any: `push` (m, 6)."""
    if grounded is None or push is None:
        return
    if push.any():
        enough = ENOUGH * penetration_slop(controls, h) / h
        hold_pushed_boxes(contacts, boxes_of(model, state), push, settings.iterations, enough)


@jit
def move_boxes_singly(
    model: Model, controls: Controls, state: State, grounded: np.ndarray | None, settings: Settings, h: float
) -> None:
    """Advance all boxes by `h` [s], then part each pair that overlaps by one impulse, as in the paper; §4.4, §5.2."""
    if grounded is None:
        return
    boxes = boxes_of(model, state)
    accelerate_boxes(model, controls, state, h)
    advance_boxes(model, state, h, settings.gyroscopic)
    collide_boxes(model, state, boxes, settings)
    resolve_ground_of_boxes(model, state, boxes, grounded)


@jit
def collide_boxes(model: Model, state: State, boxes: RigidBodies, settings: Settings) -> None:
    """Part every pair of boxes that overlap: first their velocities by an impulse, then their positions."""
    placed = PlacedBoxes(model.box_size, state.box_position, state.box_orientation)
    pairs = near_boxes(model, state, np.zeros(model.box_count), settings.exhaustive_pairs)
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        depth, point, normal = paper_contact(placed_box(placed, a), placed_box(placed, b), settings.paper_axes)
        if depth > 0.0:
            material = combined(material_of_box(model, a), material_of_box(model, b))
            resolve_contact(boxes, (a, b), point, normal, material)
            inverse_mass = model.box_inverse_mass[a] + model.box_inverse_mass[b]
            correct_pair(boxes, a, b, scale(depth / inverse_mass, normal))


@jit
def correct_pair(boxes: RigidBodies, a: int, b: int, shift: Vec) -> None:
    """Move a and b apart by `shift` [kg m] times their inverse masses."""
    accumulate(boxes.position, a, scale(boxes.inverse_mass[a], shift))
    accumulate(boxes.position, b, scale(-boxes.inverse_mass[b], shift))
