"""Contacts of boxes with each other and with the ground, now or speculatively within the next step.

Looking one step ahead keeps a box that rests, its depth now a rounding above zero and now below, in contact; and stops
a fast one before it is inside. What a contact stops, strikes or turns flies another way than was looked at. So once the
velocities are solved, whom they divert is looked at again: of boxes that fall one above the other each stops the next,
and a box that is struck strikes its neighbour within the same step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.boxes.manifold import Manifold, closes, swept_manifold
from softbody.collision.boxes.sat_boxes import BoxFrames, Limits, PlacedBoxes, bounds_apart, frames_of
from softbody.collision.boxes.swept_boxes import Sweep, grazing_depth
from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive
from softbody.collision.contact import (
    GROUND,
    Contacts,
    Touch,
    add_contact,
    box_side,
    first_of_pair,
    fit,
    new_contacts_in_kernel,
    sort_in,
    with_room,
)
from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.box import box_corner
from softbody.linalg.quaternion import load_quaternion
from softbody.linalg.vec import add, cross, load, norm, scale, store, sub
from softbody.model.arrays import NOBODY, Controls, Model, State
from softbody.model.material import combined, material_of_box, material_of_ground
from softbody.model.settings import Settings

WORTH = 1e-4  # of the slop: overlaps of a knock-on that are worth another solve


@jit_lean
def penetration_slop(controls: Controls, h: float) -> float:
    """Return how far [m] gravity moves a body within a step of `h` [s]: lengths below it are the solver's noise."""
    return h * h * norm((controls.gravity[0], controls.gravity[1], controls.gravity[2]))


class Flights(NamedTuple):
    """What boxes would do within a step, a row each."""

    travel: np.ndarray  # (m, 3) [m]
    pull: np.ndarray  # (m, 3) [m] what of it comes from gravity and forces that nothing has answered yet
    spin: np.ndarray  # (m, 3) [rad]
    turn: np.ndarray  # (m,) [m] that any point may come by turning, torque included
    margin: np.ndarray  # (m,) [m] that any point may come by both


@jit
def _no_pull(count: int) -> Flights:
    """Return room for the flights of so many boxes, that nothing pulls."""
    still = np.zeros((count, 3))
    return Flights(np.empty((count, 3)), still, np.empty((count, 3)), np.empty(count), np.empty(count))


@jit
def free_flights(model: Model, controls: Controls, state: State, h: float) -> Flights:
    """Return what boxes do within a step of `h` [s] if nothing holds them; without a mass, what they are told."""
    flights = _no_pull(model.box_count)
    for i in range(model.box_count):
        inverse_mass, inverse_inertia = model.box_inverse_mass[i], load(model.box_inverse_inertia, i)
        for c in range(3 if inverse_mass > 0.0 else 0):
            flights.pull[i, c] = h * h * (controls.gravity[c] + inverse_mass * controls.box_force[i, c])
        most = max(inverse_inertia[0], inverse_inertia[1], inverse_inertia[2])
        _set_flight(model, state, flights, i, most * norm(load(controls.box_torque, i)), h)
    return flights


@jit
def solved_flights(model: Model, state: State, h: float) -> Flights:
    """Return what boxes do within a step of `h` [s] by velocities that their contacts have answered."""
    flights = _no_pull(model.box_count)
    for i in range(model.box_count):
        _set_flight(model, state, flights, i, 0.0, h)
    return flights


@jit_lean
def _set_flight(model: Model, state: State, flights: Flights, box: int, angular: float, h: float) -> None:
    """Set what a box does by its velocities, what pulls it, and an `angular` acceleration [rad/s²] about any axis."""
    store(flights.travel, box, add(scale(h, load(state.box_velocity, box)), load(flights.pull, box)))
    store(flights.spin, box, scale(h, load(state.box_angular_velocity, box)))
    spin = norm(load(state.box_angular_velocity, box))
    flights.turn[box] = h * 0.5 * norm(load(model.box_size, box)) * (spin + h * angular)
    flights.margin[box] = norm(load(flights.travel, box)) + flights.turn[box]


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
    contacts.number[0] = contacts.number[1] = 0
    flights, everyone = free_flights(model, controls, state, h), np.ones(model.box_count, np.bool_)
    return _find_more(model, state, flights, everyone, manifold, contacts, settings, penetration_slop(controls, h))


@jit
def find_knock_ons(
    model: Model,
    state: State,
    before: Flights,
    after: Flights,
    manifold: Manifold,
    contacts: Contacts,
    settings: Settings,
    slop: float,
) -> Contacts:
    """Add to `contacts` where boxes go into others or the ground because contacts have changed how they fly.

    They flew as `before` when the last contacts were found, and fly as `after` now. What goes no deeper than `slop` [m]
    is left out.
    """
    diverted, some = np.zeros(model.box_count, np.bool_), False
    for i in range(model.box_count):
        change = norm(sub(load(after.travel, i), load(before.travel, i)))
        change += 0.5 * norm(load(model.box_size, i)) * norm(sub(load(after.spin, i), load(before.spin, i)))
        diverted[i] = change > grazing_depth(model.box_size, (i, i), slop)
        some = some or diverted[i]
    if not some:
        return contacts
    return _find_more(model, state, after, diverted, manifold, contacts, settings, slop)


@jit
def _find_more(
    model: Model,
    state: State,
    flights: Flights,
    of: np.ndarray,
    manifold: Manifold,
    contacts: Contacts,
    settings: Settings,
    slop: float,
) -> Contacts:
    """Add the contacts that boxes `of` (m,) bool have in flight, where none is listed yet; return them, in order.

    All that may be contacts if there are none so far; later those that go deeper than `slop` [m].
    """
    pairs = near_boxes(model, state, flights.margin, settings.exhaustive_pairs)
    boxes = frames_of(PlacedBoxes(model.box_size, state.box_position, state.box_orientation))
    listed = contacts.number[1]
    while True:
        contacts.number[0] = listed
        pair = at = 0
        for a in range(model.box_count):
            at = first_of_pair(contacts, at, listed, a, NOBODY)
            if of[a]:
                _add_ground_contacts(model, state, flights, boxes, a, (at, listed), slop, contacts)
            while pair < pairs.shape[0] and pairs[pair, 0] == a:
                b = pairs[pair, 1]
                pair += 1
                limits = Limits(flights.margin[a] + flights.margin[b], slop, settings.paper_axes)
                # (The paper's axes see overlaps that these bounds would refute.)
                if not (of[a] or of[b]) or (not settings.paper_axes and bounds_apart(boxes, a, b, limits.margin)):
                    continue
                at = first_of_pair(contacts, at, listed, a, b)
                if at == listed or contacts.box[at, 0] != a or contacts.box[at, 1] != b:
                    found = _find_pair(model, flights, boxes, (a, b), limits, listed > 0, manifold)
                    _add_pair_contacts(model, (a, b), found, manifold, contacts)
        contacts.number[1] = contacts.number[0]
        if fit(contacts):
            break
        contacts = with_room(contacts, listed)
    if listed:
        sort_in(contacts, listed, new_contacts_in_kernel(1))
    return contacts


@jit_lean
def _find_pair(
    model: Model,
    flights: Flights,
    boxes: BoxFrames,
    pair: tuple[int, int],
    limits: Limits,
    must_close: bool,
    manifold: Manifold,
) -> int:
    """Find where two boxes touch, or may do so in flight; return the number of points, now in `manifold`.

    Where axes tie, the faces of the first are taken: those of a box that stands still, so that what slides on it slides
    level with it, and not along a face of its own that leans by what the solver leaves.
    """
    turned = model.box_inverse_mass[pair[1]] == 0.0
    a, b = (pair[1], pair[0]) if turned else pair
    travel, pull = (
        sub(load(flights.travel, a), load(flights.travel, b)),
        sub(load(flights.pull, a), load(flights.pull, b)),
    )
    share = model.box_inverse_mass[a] / (model.box_inverse_mass[a] + model.box_inverse_mass[b])
    turn = flights.turn[a] + flights.turn[b]
    sweep = Sweep(travel, pull, load(flights.spin, a), load(flights.spin, b), turn, share)
    found = swept_manifold(boxes, (a, b), sweep, limits, manifold)
    if must_close and not closes(boxes, (a, b), sweep, found, WORTH * limits.slop, manifold):
        return 0
    if turned:
        for c in range(3):
            manifold.sat.normal[c] = -manifold.sat.normal[c]
    return found


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
def _add_ground_contacts(
    model: Model,
    state: State,
    flights: Flights,
    boxes: BoxFrames,
    box: int,
    listed: tuple[int, int],
    slop: float,
    contacts: Contacts,
) -> None:
    """Add the corners of a box that are, or may come, below the ground, but for those of it `listed` (from, to)."""
    top = model.ground_height + flights.margin[box]
    size, position = load(model.box_size, box), load(state.box_position, box)
    if model.box_inverse_mass[box] == 0.0 or position[2] - 0.5 * norm(size) > top:
        return
    material = combined(material_of_box(model, box), material_of_ground(model))
    orientation = load_quaternion(state.box_orientation, box)
    for k in range(8):
        corner = box_corner(size, position, orientation, k)
        is_near = corner[2] <= top
        if is_near and listed[1] > 0:
            way = add(load(flights.travel, box), cross(load(flights.spin, box), sub(corner, position)))
            is_near = corner[2] + way[2] < model.ground_height - WORTH * slop
            at = listed[0]
            while is_near and at < listed[1] and contacts.box[at, 0] == box and contacts.box[at, 1] == NOBODY:
                is_near = contacts.feature[at] != k
                at += 1
        if is_near:
            depth = model.ground_height - corner[2]
            point = corner[0], corner[1], corner[2] + 0.5 * depth
            add_contact(contacts, box_side(box), GROUND, Touch(point, (0.0, 0.0, 1.0), depth, k), material)
