"""Narrow phase of soft bodies: all their contacts with each other and with boxes; paper §4.2, §4.3.

All contacts of a step are found before any is resolved, so that each structure is made once for all that ask it. They
are listed body by body, in a fixed order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from softbody.collision.boxes.sat_boxes import placed_at
from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive
from softbody.collision.contact import Contacts, Listing, move_row, rows_of, with_room
from softbody.collision.soft.behind_walls import find_behind_walls
from softbody.collision.soft.sat_meshes import faces_part
from softbody.collision.soft.soft_box import find_contacts_in_box, find_corner_contacts, find_corners_outside
from softbody.collision.soft.soft_soft import find_soft_soft_contacts
from softbody.collision.soft.split_steps import spheres_of_boxes
from softbody.collision.soft.surface import (
    Memory,
    Shapes,
    Solid,
    Surfaces,
    ThreadScratch,
    memory_at,
    surface_of,
    tree_at,
)
from softbody.compiler.jit import jit, jit_lean, jit_threaded
from softbody.geometry.aabb import bounding_box, boxes_meet
from softbody.geometry.box import point_in_box
from softbody.geometry.bvh import refit_bvh
from softbody.geometry.sphere import radius_about
from softbody.linalg.quaternion import load_quaternion
from softbody.linalg.vec import Vec, add, load, scale, store
from softbody.model.arrays import Model, State, is_open
from softbody.model.material import combined, material_of_box, material_of_soft
from softbody.model.settings import Settings
from softbody.model.sleep_state import SleepState, is_settled, sleeps

# Edges are asked of surfaces whose own are not longer: as a part of their mean length, below which they are not.
COARSE = 0.9

# Particles from which threads share the work: one takes some 0.05 µs, and a thread that sleeps takes as long as all of
# them to wake.
MUCH = 1_500.0

# How deep edges may be across each other, as a part of the shorter mean length: where it is more, particles are inside.
SHALLOW = 0.5


class Pairs(NamedTuple):
    """Which bodies are near which, and how they are asked."""

    start: np.ndarray  # (b + 1,) other[start[i]:start[i + 1]] are the bodies whose bounds meet those of soft body i
    other: np.ndarray  # boxes are numbered after soft bodies
    cut: np.ndarray  # (threads + 1,) where the soft bodies are cut into shares
    work: float  # of all shares, see `even_shares`
    with_edges: bool  # or particles and corners only
    with_boxes: bool | None  # see `Surfaces`


@jit
def find_soft_contacts(
    model: Model,
    state: State,
    before: State,
    surfaces: Surfaces | None,
    rest: SleepState | None,
    settings: Settings,
    contacts: Contacts,
) -> Contacts:
    """Add every contact of a soft body with another or with a box; return the contacts, with room for all.

    What has come into a box since `before`, when the step began, leaves it as it came. `surfaces` is None where there
    are no soft bodies, and `rest` where nobody may sleep.
    """
    if surfaces is None:
        return contacts
    shapes, scratch = surfaces.shapes, surfaces.scratch
    shares = scratch.reals.shape[0]
    start, near = near_bodies(model, state, shapes, scratch, rest, settings.exhaustive_pairs)
    cut, work = even_shares(model, start, near, shares)
    pairs = Pairs(start, near, cut, work, settings.edge_contacts, surfaces.with_boxes)
    kept, found = contacts.number[0], np.zeros(shares, np.int64)
    while True:
        rows = rows_of(contacts, found, kept, contacts.depth.shape[0])
        _find_all(model, state, before, shapes, scratch, pairs, rows, surfaces.threads)
        most, room = 0, (contacts.depth.shape[0] - kept) // shares
        for share in range(shares):
            most = max(most, found[share])
        if most <= room:
            break
        contacts.number[0] = kept + shares * most
        contacts = with_room(contacts, kept)
    # One share after another, without gaps.
    count = kept
    for share in range(shares):
        for k in range(kept + share * room, kept + share * room + found[share]):
            if k != count:
                move_row(contacts, k, contacts, count)
            count += 1
    contacts.number[0] = count
    _note_deepest(surfaces, contacts, kept)
    return contacts


@jit
def _find_all(
    model: Model,
    state: State,
    before: State,
    shapes: Shapes,
    scratch: ThreadScratch,
    pairs: Pairs,
    rows: Listing,
    threads: int | None,
) -> None:
    """List the contacts of all shares, each in its part of the rows."""
    if threads is None or pairs.work < MUCH:
        for share in range(pairs.cut.shape[0] - 1):
            find_share(model, state, before, shapes, scratch, pairs, rows, share)
    else:
        find_on_threads(model, state, before, shapes, scratch, pairs, rows)


@jit_threaded
def find_on_threads(
    model: Model, state: State, before: State, shapes: Shapes, scratch: ThreadScratch, pairs: Pairs, rows: Listing
) -> None:
    """Let each thread find a share of the contacts, in memory of its own."""
    for share in prange(pairs.cut.shape[0] - 1):
        find_share(model, state, before, shapes, scratch, pairs, rows, share)


@jit_lean
def find_share(
    model: Model,
    state: State,
    before: State,
    shapes: Shapes,
    scratch: ThreadScratch,
    pairs: Pairs,
    rows: Listing,
    share: int,
) -> None:
    """List the contacts of one share of the soft bodies in its part of the rows, and count them."""
    room = rows.depth.shape[0] // (pairs.cut.shape[0] - 1)
    listing = rows_of(rows, rows.number[share : share + 1], share * room, (share + 1) * room)
    listing.number[0] = 0
    for body in range(pairs.cut[share], pairs.cut[share + 1]):
        if pairs.start[body] < pairs.start[body + 1]:
            _find_contacts_of(model, state, before, shapes, scratch, pairs, listing, share, body)


@jit
def even_shares(model: Model, start: np.ndarray, near: np.ndarray, shares: int) -> tuple[np.ndarray, float]:
    """Return where to cut the soft bodies into `shares` of about as much work each, (shares + 1,), and all the work.

    Work is counted in particles: of each that is asked, and of all that are asked about.
    """
    soft, particles = model.soft_count, model.soft_particle_start
    work = np.zeros(soft + 1)
    for body in range(soft):
        work[body + 1] = work[body]
        for other in near[start[body] : start[body + 1]]:
            work[body + 1] += (particles[body + 1] - particles[body]) / (start[body + 1] - start[body])
            work[body + 1] += (particles[other + 1] - particles[other]) if other < soft else 8.0
    cut = np.full(shares + 1, soft)
    body = 0
    for share in range(shares):
        while body < soft and work[body] * shares < work[soft] * share:
            body += 1
        cut[share] = body
    return cut, work[soft]


@jit
def near_bodies(
    model: Model, state: State, shapes: Shapes, scratch: ThreadScratch, rest: SleepState | None, exhaustive: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return (start, other) of `Pairs`. (Contacts of boxes among themselves are found elsewhere.)"""
    soft = model.soft_count
    # Spheres about the middles of bounding boxes, in a grid; then the boxes.
    centre, radius = shapes.centre, shapes.radius
    takes_part = np.zeros(soft + model.box_count, np.bool_)
    spheres_of_boxes(model, state, centre, radius)
    for body in range(soft):
        takes_part[body] = not sleeps(rest, body)
        if is_settled(rest, body):
            continue
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        points = state.particle_position[first:end]
        low, high = bounding_box(points)
        store(shapes.low, body, low)
        store(shapes.high, body, high)
        middle = scale(0.5, add(low, high))
        store(centre, body, middle)
        radius[body] = radius_about(middle, points)
    pairs = near_pairs_exhaustive(centre, radius, takes_part) if exhaustive else near_pairs(centre, radius, takes_part)
    count = 0
    start = np.zeros(soft + 1, np.int64)
    for k in range(pairs.shape[0]):
        a, b = min(pairs[k, 0], pairs[k, 1]), max(pairs[k, 0], pairs[k, 1])
        if b < soft:
            bounds = load(shapes.low, a), load(shapes.high, a)
            meet = boxes_meet(bounds, (load(shapes.low, b), load(shapes.high, b)))
            if meet and exhaustive:
                one = surface_of(model, state, shapes, scratch, 0, a)
                other = surface_of(model, state, shapes, scratch, 0, b)
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
    model: Model,
    state: State,
    before: State,
    shapes: Shapes,
    scratch: ThreadScratch,
    pairs: Pairs,
    listing: Listing,
    thread: int,
    body: int,
) -> None:
    """Add what of other bodies is in a soft body, and what of it is in boxes."""
    soft, memory = model.soft_count, memory_at(scratch, thread)
    surface, tree = surface_of(model, state, shapes, scratch, thread, body), tree_at(shapes, scratch, thread, body)
    refit_bvh(tree, surface.vertices.position)
    solid, near, first = Solid(surface, tree), pairs.other[pairs.start[body] : pairs.start[body + 1]], listing.number[0]
    for other in near:
        if other < soft:
            if is_open(model, body):  # nothing is inside it
                continue
            probe = surface_of(model, state, shapes, scratch, thread, other)
            length, other_length = model.soft_edge_length[body], model.soft_edge_length[other]
            has_edges = pairs.with_edges and other_length >= COARSE * length
            deepest = SHALLOW * min(length, other_length)
            material = combined(material_of_soft(model, body), material_of_soft(model, other))
            find_soft_soft_contacts(probe, solid, deepest, has_edges, memory, material, listing)
        else:
            _find_contacts_with_box(
                model, state, before, solid, memory, pairs.with_edges, listing, (body, other - soft), pairs.with_boxes
            )
    find_behind_walls(model, state, before, body, near, first, memory.way_out, listing, pairs.with_boxes)


@jit_lean
def _find_contacts_with_box(
    model: Model,
    state: State,
    before: State,
    solid: Solid,
    memory: Memory,
    with_edges: bool,
    listing: Listing,
    pair: tuple[int, int],
    with_boxes: bool | None,
) -> None:
    """Add what of a soft body is in a box, and which corners of the box are in it, or have left it: (body, box)."""
    if with_boxes is None:
        return
    body, box = pair
    material = combined(material_of_soft(model, body), material_of_box(model, box))
    placed, old = placed_at(model, state, box), placed_at(model, before, box)
    points = before.particle_position[model.soft_particle_start[body] : model.soft_particle_start[body + 1]]
    is_inside, surface = bool(model.box_host[box] == body), solid.surface
    find_contacts_in_box(surface, (box, placed), (points, old), with_edges, is_inside, memory, material, listing)
    if is_open(model, body):
        return
    if is_inside:
        find_corners_outside(solid, (box, placed), memory, material, listing)
    else:
        find_corner_contacts(solid, (box, placed), model.soft_edge_length[body], memory, material, listing)


@jit_lean
def _note_deepest(surfaces: Surfaces, contacts: Contacts, first: int) -> None:
    """Note the contact, from the `first` on, that is deepest, if it is deeper than all before."""
    for k in range(first, contacts.number[0]):
        if contacts.depth[k] > surfaces.deepest[0]:
            surfaces.deepest[0] = contacts.depth[k]
            for side in range(2):
                surfaces.deepest_sides[side, 0] = contacts.box[k, side]
                surfaces.deepest_sides[side, 1] = contacts.particles[k, side, 0]
