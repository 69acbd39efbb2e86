"""Which contacts do soft bodies have, with each other and with boxes? Paper §4.2, §4.3.

All contacts of a step are found before any is resolved, so that each structure is made once for all that ask it. They
are listed body by body, in a fixed order.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive
from softbody.collision.contact import Contacts, fit, with_room
from softbody.collision.law import combined, material_of_box, material_of_soft
from softbody.collision.sat_boxes import PlacedBox
from softbody.collision.sat_meshes import faces_part
from softbody.collision.soft_box import find_contacts_in_box, find_corner_contacts
from softbody.collision.soft_soft import find_soft_soft_contacts
from softbody.collision.substeps import spheres_of_bodies
from softbody.collision.surface import Solid, Surfaces, surface_of, tree_of
from softbody.geometry.aabb import bounding_box, boxes_meet
from softbody.geometry.box import box_corner, point_in_box
from softbody.geometry.bvh import refit_bvh
from softbody.geometry.penetration import Points
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion
from softbody.settings import Settings
from softbody.state import Model, State
from softbody.vec import Vec, load, store

# Edges are asked of surfaces whose own are not longer: as a part of their mean length, below which they are not.
COARSE = 0.9

# How deep edges may be across each other, as a part of the shorter mean length: where it is more, particles are inside.
SHALLOW = 0.5


@jit
def find_soft_contacts(
    model: Model, state: State, surfaces: Surfaces, settings: Settings, contacts: Contacts
) -> Contacts:
    """Add every contact of a soft body with another or with a box; return the contacts, with room for all."""
    if model.soft_count == 0:
        return contacts
    start, near = _near_bodies(model, state, surfaces, settings.exhaustive_pairs)
    for body in range(model.soft_count):
        others = near[start[body] : start[body + 1]]
        if others.shape[0] == 0:
            continue
        before = contacts.number[0]
        while True:
            _find_contacts_of(model, state, surfaces, (body, settings.edge_contacts), others, contacts)
            if fit(contacts):
                break
            contacts = with_room(contacts, before)
    return contacts


@jit
def _near_bodies(model: Model, state: State, surfaces: Surfaces, exhaustive: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return (start (b + 1,), near): near[start[i]:start[i + 1]] are all bodies whose bounds meet those of soft body i.

    Boxes are numbered after soft bodies. (Contacts among them are found elsewhere.)
    """
    soft = model.soft_count
    # Bounding spheres in a grid; then bounding boxes.
    centre, radius, is_soft = spheres_of_bodies(model, state)
    for body in range(soft):
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        low, high = bounding_box(state.particle_position[first:end])
        store(surfaces.low, body, low)
        store(surfaces.high, body, high)
    pairs = near_pairs_exhaustive(centre, radius, is_soft) if exhaustive else near_pairs(centre, radius, is_soft)
    count = 0
    start = np.zeros(soft + 1, np.int64)
    for k in range(pairs.shape[0]):
        a, b = min(pairs[k, 0], pairs[k, 1]), max(pairs[k, 0], pairs[k, 1])
        if b < soft:
            bounds = load(surfaces.low, a), load(surfaces.high, a)
            meet = boxes_meet(bounds, (load(surfaces.low, b), load(surfaces.high, b)))
            if meet and exhaustive:
                one, other = surface_of(model, state, surfaces, a), surface_of(model, state, surfaces, b)
                meet = not faces_part(one.vertices.position, one.triangles, other.vertices.position, other.triangles)
        else:
            meet = _sphere_may_meet_box(model, state, (load(centre, a), radius[a]), b - soft)
        if meet:
            pairs[count, 0], pairs[count, 1] = a, b
            start[a + 1] += 1
            if b < soft:
                start[b + 1] += 1
            count += 1
    # The pairs once more, sorted by soft body.
    for body in range(soft):
        start[body + 1] += start[body]
    near, filled = np.empty(start[soft], np.int64), start[:soft].copy()
    for k in range(count):
        a, b = pairs[k, 0], pairs[k, 1]
        near[filled[a]] = b
        filled[a] += 1
        if b < soft:
            near[filled[b]] = a
            filled[b] += 1
    return start, near


@jit_lean
def _sphere_may_meet_box(model: Model, state: State, sphere: tuple[Vec, float], box: int) -> bool:
    """Tell whether no face of a box parts it from a sphere, (centre, radius) [m]."""
    orientation = load_quaternion(state.box_orientation, box)
    depth, _ = point_in_box(sphere[0], load(model.box_size, box), load(state.box_position, box), orientation)
    return bool(depth >= -sphere[1])


@jit_lean
def _find_contacts_of(
    model: Model, state: State, surfaces: Surfaces, asked: tuple[int, bool], others: np.ndarray, contacts: Contacts
) -> None:
    """Add what of `others` is in the soft body that is `asked`, and what of it is in boxes; (body, with edges)."""
    body, with_edges = asked
    soft, memory = model.soft_count, surfaces.memory
    surface, tree = surface_of(model, state, surfaces, body), tree_of(surfaces, body)
    refit_bvh(tree, surface.vertices.position)
    solid = Solid(surface, tree)
    for other in others:
        before = contacts.number[0]
        if other < soft:
            probe = surface_of(model, state, surfaces, other)
            length, other_length = model.soft_edge_length[body], model.soft_edge_length[other]
            deepest = SHALLOW * min(length, other_length) if with_edges and other_length >= COARSE * length else 0.0
            material = combined(material_of_soft(model, body), material_of_soft(model, other))
            find_soft_soft_contacts(probe, solid, deepest, memory, material, contacts)
        else:
            box = other - soft
            material = combined(material_of_soft(model, body), material_of_box(model, box))
            placed = PlacedBox(
                load(model.box_size, box), load(state.box_position, box), load_quaternion(state.box_orientation, box)
            )
            find_contacts_in_box(surface, (box, placed), with_edges, memory, material, contacts)
            for k in range(8):
                store(surfaces.corners, k, box_corner(placed.size, placed.position, placed.orientation, k))
            corners = Points(surfaces.corners, bounding_box(surfaces.corners), surfaces.corner_hint)
            find_corner_contacts(solid, box, corners, memory, material, contacts)
        _note_deepest(surfaces, (min(body, other), max(body, other)), contacts.depth, (before, contacts.number[0]))


@jit_lean
def _note_deepest(surfaces: Surfaces, pair: tuple[int, int], depth: np.ndarray, rows: tuple[int, int]) -> None:
    """Note the pair if one of its contacts, in `rows`, is deeper than all before."""
    for k in range(rows[0], min(rows[1], depth.shape[0])):
        if depth[k] > surfaces.deepest[0]:
            surfaces.deepest[0] = depth[k]
            surfaces.deepest_pair[0], surfaces.deepest_pair[1] = pair
