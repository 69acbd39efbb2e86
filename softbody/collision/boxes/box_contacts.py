"""Contacts of boxes with each other and with the ground, now or speculatively within the next step.

Looking one step ahead keeps a box that rests, its depth now a rounding above zero and now below, in contact; and stops
a fast one before it is inside.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.boxes.manifold import Manifold, stopped_manifold, swept_manifold
from softbody.collision.boxes.sat_boxes import BoxFrames, Limits, PlacedBoxes, bounds_apart, frames_of
from softbody.collision.boxes.swept_boxes import STILL, Sweep
from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive
from softbody.collision.contact import GROUND, Contacts, Touch, add_contact, box_side, fit, with_room
from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.box import box_corner
from softbody.linalg.quaternion import load_quaternion
from softbody.linalg.vec import Vec, add, load, norm, scale, sub
from softbody.model.arrays import Controls, Model, State
from softbody.model.material import combined, material_of_box, material_of_ground
from softbody.model.settings import Settings


@jit_lean
def penetration_slop(controls: Controls, h: float) -> float:
    """Return how far [m] gravity moves a body within a step of `h` [s]: lengths below it are the solver's noise."""
    return h * h * norm((controls.gravity[0], controls.gravity[1], controls.gravity[2]))


@jit_lean
def _pull_in_step(model: Model, controls: Controls, box: int, h: float) -> Vec:
    """Return how far [m] gravity and forces move a box within a step of `h` [s]; one without a mass not at all."""
    inverse_mass = model.box_inverse_mass[box]
    if inverse_mass == 0.0:
        return STILL
    gravity = controls.gravity[0], controls.gravity[1], controls.gravity[2]
    return scale(h * h, add(gravity, scale(inverse_mass, load(controls.box_force, box))))


@jit_lean
def travel_in_step(model: Model, controls: Controls, state: State, box: int, h: float) -> Vec:
    """Return how far [m] a box moves within a step of `h` [s] if nothing holds it."""
    return add(scale(h, load(state.box_velocity, box)), _pull_in_step(model, controls, box, h))


@jit_lean
def turn_in_step(model: Model, controls: Controls, state: State, box: int, h: float) -> float:
    """Return how far [m] any point of a box may come within a step of `h` [s] by turning, and by its torque."""
    inverse_inertia = load(model.box_inverse_inertia, box)
    angular = max(inverse_inertia[0], inverse_inertia[1], inverse_inertia[2]) * norm(load(controls.box_torque, box))
    spin = norm(load(state.box_angular_velocity, box))
    return h * 0.5 * norm(load(model.box_size, box)) * (spin + h * angular)


@jit_lean
def speculative_margin(model: Model, controls: Controls, state: State, box: int, h: float) -> float:
    """Return how far [m] any point of a box may come within a step of `h` [s]: by its motion, and what acts on it."""
    return norm(travel_in_step(model, controls, state, box, h)) + turn_in_step(model, controls, state, box, h)


@jit
def near_boxes(model: Model, state: State, margin: np.ndarray, exhaustive: bool) -> np.ndarray:
    """Return the pairs (p, 2) of boxes whose bounding spheres, grown by `margin` (m,) [m], meet; paper §4."""
    radius = np.empty(model.box_count)
    movable = np.empty(model.box_count, np.bool_)
    for i in range(model.box_count):
        radius[i] = 0.5 * norm(load(model.box_size, i)) + margin[i]
        movable[i] = model.box_inverse_mass[i] > 0.0
    if exhaustive:
        return near_pairs_exhaustive(state.box_position, radius, movable)
    return near_pairs(state.box_position, radius, movable)


@jit
def find_box_contacts(
    model: Model,
    controls: Controls,
    state: State,
    manifold: Manifold | None,
    contacts: Contacts,
    settings: Settings,
    h: float,
) -> Contacts:
    """Find where boxes touch each other or the ground, or may do so within `h` [s]; return contacts with room for all.

    Contacts of the step before are forgotten; what the solver remembers of them is in the cache. `manifold` is None
    where there are no boxes.
    """
    if manifold is None:
        return contacts
    margin = np.empty(model.box_count)
    for i in range(model.box_count):
        margin[i] = speculative_margin(model, controls, state, i, h)
    pairs = near_boxes(model, state, margin, settings.exhaustive_pairs)
    boxes = frames_of(PlacedBoxes(model.box_size, state.box_position, state.box_orientation))
    slop = penetration_slop(controls, h)
    while True:
        contacts.number[0] = 0
        pair = 0
        for a in range(model.box_count):
            _add_ground_contacts(model, state, a, margin[a], contacts)
            while pair < pairs.shape[0] and pairs[pair, 0] == a:
                b = pairs[pair, 1]
                pair += 1
                limits = Limits(margin[a] + margin[b], slop, settings.paper_axes)
                # (The paper's axes see overlaps that these bounds would refute.)
                if settings.paper_axes or not bounds_apart(boxes, a, b, limits.margin):
                    found = _find_pair(model, controls, state, boxes, (a, b), limits, manifold, h)
                    _add_pair_contacts(model, (a, b), found, manifold, contacts)
        contacts.number[1] = contacts.number[0]
        if fit(contacts):
            return contacts
        contacts = with_room(contacts, 0)


@jit_lean
def _find_pair(
    model: Model,
    controls: Controls,
    state: State,
    boxes: BoxFrames,
    pair: tuple[int, int],
    limits: Limits,
    manifold: Manifold,
    h: float,
) -> int:
    """Find where two boxes touch, or may do so within `h` [s]; return the number of points, now in `manifold`.

    Where axes tie, the faces of the first are taken: those of a box that stands still, so that what slides on it slides
    level with it, and not along a face of its own that leans by what the solver leaves.
    """
    turned = model.box_inverse_mass[pair[1]] == 0.0
    a, b = (pair[1], pair[0]) if turned else pair
    travel_a, travel_b = travel_in_step(model, controls, state, a, h), travel_in_step(model, controls, state, b, h)
    spins = scale(h, load(state.box_angular_velocity, a)), scale(h, load(state.box_angular_velocity, b))
    turn = turn_in_step(model, controls, state, a, h) + turn_in_step(model, controls, state, b, h)
    share = model.box_inverse_mass[a] / (model.box_inverse_mass[a] + model.box_inverse_mass[b])
    pull = sub(_pull_in_step(model, controls, a, h), _pull_in_step(model, controls, b, h))
    sweep = Sweep(sub(travel_a, travel_b), pull, spins[0], spins[1], turn, share)
    found = swept_manifold(boxes, (a, b), sweep, limits, manifold)
    if turned:
        for c in range(3):
            manifold.sat.normal[c] = -manifold.sat.normal[c]
    both_move = model.box_inverse_mass[a] > 0.0 and model.box_inverse_mass[b] > 0.0
    # (What bounces must come as fast as it flies, and is not held up before it is there.)
    if found > 0 or not both_move or combined(material_of_box(model, a), material_of_box(model, b)).restitution > 0.0:
        return found
    found = stopped_manifold(boxes, pair, sweep, scale(-1.0, travel_a), limits, manifold)
    return found if found > 0 else stopped_manifold(boxes, pair, sweep, travel_b, limits, manifold)


@jit_lean
def _add_pair_contacts(model: Model, pair: tuple[int, int], found: int, manifold: Manifold, contacts: Contacts) -> None:
    """Add the points, so many, where two boxes touch or will meet."""
    a, b = pair
    if found == 0:
        return
    material = combined(material_of_box(model, a), material_of_box(model, b))
    normal = manifold.sat.normal[0], manifold.sat.normal[1], manifold.sat.normal[2]
    for k in range(found):
        touch = Touch(load(manifold.point, k), normal, manifold.depth[k], manifold.feature[k])
        add_contact(contacts, box_side(a), box_side(b), touch, material)


@jit_lean
def _add_ground_contacts(model: Model, state: State, box: int, margin: float, contacts: Contacts) -> None:
    """Add the corners of a box that are, or may come, below the ground."""
    top = model.ground_height + margin
    size, position = load(model.box_size, box), load(state.box_position, box)
    if model.box_inverse_mass[box] == 0.0 or position[2] - 0.5 * norm(size) > top:
        return
    material = combined(material_of_box(model, box), material_of_ground(model))
    orientation = load_quaternion(state.box_orientation, box)
    for k in range(8):
        corner = box_corner(size, position, orientation, k)
        if corner[2] <= top:
            depth = model.ground_height - corner[2]
            point = corner[0], corner[1], corner[2] + 0.5 * depth
            add_contact(contacts, box_side(box), GROUND, Touch(point, (0.0, 0.0, 1.0), depth, k), material)
