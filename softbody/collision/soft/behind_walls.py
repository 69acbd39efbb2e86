"""What a wall keeps from going past another: contacts that a straight way through both does not show."""

from __future__ import annotations

import numpy as np

from softbody.collision.boxes.sat_boxes import PlacedBox, placed_at
from softbody.collision.contact import Listing, Touch, add_contact, box_side, soft_side
from softbody.collision.soft.soft_soft import half_way
from softbody.compiler.jit import jit_lean
from softbody.geometry.box import way_back
from softbody.linalg.quaternion import rotate, rotate_inverse
from softbody.linalg.vec import Vec, accumulate, add, dot, load, scale, store, sub
from softbody.model.arrays import NOBODY, Model, State
from softbody.model.material import combined, material_of_box, material_of_soft
from softbody.model.surface_point import at_particle

# How far a particle that a wall keeps is behind another, at least, as a part of how far it has come: less is rounding.
LEAST = 1e-6


@jit_lean
def find_behind_walls(
    model: Model,
    state: State,
    before: State,
    body: int,
    near: np.ndarray,
    first: int,
    way: np.ndarray,
    contacts: Listing,
    with_boxes: bool | None,
) -> None:
    """List which particles of a soft body would have come into a box, had other boxes kept them from going past it.

    The contacts of the body begin at row `first`. Where two walls meet, a straight way may lead out through one before
    it comes to the other: kept by the first, the particle meets the other. `near`: bodies, boxes numbered after soft
    ones; `way` (n, 3) [m]: memory, for how far contacts bring each particle back. `with_boxes`: see `Surfaces`.
    """
    if with_boxes is None:
        return
    begin = model.soft_particle_start[body]
    k = first
    while k < min(contacts.number[0], contacts.depth.shape[0]):
        if _is_of_particle(contacts, k):
            store(way, contacts.particles[k, 0, 0] - begin, (0.0, 0.0, 0.0))
        k += 1
    k, listed = first, contacts.number[0]
    while k < min(contacts.number[0], contacts.depth.shape[0]):
        i, normal = contacts.particles[k, 0, 0], load(contacts.normal, k)
        if _is_of_particle(contacts, k):
            left = contacts.depth[k] - dot(load(way, i - begin), normal)
            accumulate(way, i - begin, scale(max(0.0, left), normal))
            for other in near:
                box = other - model.soft_count
                if box >= 0 and not _is_listed(contacts, listed, i, box):
                    _add_if_behind(model, state, before, (body, box), i, way, contacts)
        k += 1


@jit_lean
def _is_of_particle(contacts: Listing, k: int) -> bool:
    """Tell whether contact `k` is of one particle with a box."""
    i, j, last = contacts.particles[k, 0, 0], contacts.particles[k, 0, 1], contacts.particles[k, 0, 2]
    return bool(contacts.box[k, 1] != NOBODY and i == j == last)


@jit_lean
def _is_listed(contacts: Listing, first: int, i: int, box: int) -> bool:
    """Tell whether there is a contact of particle `i` with a box from row `first` on."""
    for k in range(first, min(contacts.number[0], contacts.depth.shape[0])):
        if contacts.box[k, 1] == box and contacts.particles[k, 0, 0] == i:
            return True
    return False


@jit_lean
def _add_if_behind(
    model: Model, state: State, before: State, pair: tuple[int, int], i: int, way: np.ndarray, contacts: Listing
) -> None:
    """Add the contact of particle `i` of a soft body with a box, (body, box), if it is behind that where it is kept."""
    body, box = pair
    row = i - model.soft_particle_start[body]
    now, old = placed_at(model, state, box), placed_at(model, before, box)
    place, half = load(state.particle_position, i), scale(0.5, now.size)
    came = _seen_from(old, load(before.particle_position, i))
    behind, normal = way_back(came, _seen_from(now, add(place, load(way, row))), half)
    if not behind > 0.0 or way_back(came, _seen_from(now, place), half)[0] > 0.0:  # it has a contact with this box
        return
    normal = rotate(now.orientation, normal)
    depth = behind + dot(load(way, row), normal)
    if behind > LEAST * depth:
        accumulate(way, row, scale(behind, normal))
        touch = Touch(half_way(place, depth, normal), normal, depth, 0)
        material = combined(material_of_soft(model, body), material_of_box(model, box))
        add_contact(contacts, soft_side(at_particle(i)), box_side(box), touch, material)


@jit_lean
def _seen_from(box: PlacedBox, point: Vec) -> Vec:
    return rotate_inverse(box.orientation, sub(point, box.position))
