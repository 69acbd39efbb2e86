"""Where do soft bodies touch each other and the boxes? Paper §4.2, §4.3.

All contacts of a step are found before any is parted, so that each structure is made once for all that ask it. They
are listed body by body, in a fixed order.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive
from softbody.collision.edge_box import edge_in_box
from softbody.collision.edge_skin import edge_inside, edge_over_ridge, facing, way_out
from softbody.collision.fast import spheres_of_bodies
from softbody.collision.material import combined_friction, combined_restitution
from softbody.collision.patch import WHOLE
from softbody.collision.skins import Skins, tree_of
from softbody.collision.soft_response import NO_BOX, SoftContacts, part_contacts, with_room, write_contact
from softbody.geometry.box import box_corner, point_in_box
from softbody.geometry.parity_grid import bounding_box
from softbody.geometry.penetration import (
    INSIDE,
    BoundingBox,
    Penetrations,
    boxes_meet,
    find_closest,
    mark_inside,
    mark_points,
    settle_doubts,
)
from softbody.geometry.tree_hits import first_hits
from softbody.geometry.triangle_tree import Search, TriangleTree, refit_triangle_tree
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion, rotate_inverse
from softbody.state import Model, RigidBodies, Rules, State
from softbody.vec import Vec, dot, load, scale, store, sub

# Edges are asked of skins whose own are not longer: as a part of their mean length, below which they are not.
COARSE = 0.9


@jit
def collide_soft_bodies(
    model: Model, state: State, bodies: RigidBodies, skins: Skins, rules: Rules, contacts: SoftContacts
) -> SoftContacts:
    """Part all soft bodies from each other and from the boxes; velocities and positions are changed.

    Returns `contacts`, or longer ones if they had no room for all, to be given to the next step.
    """
    contacts, count = find_soft_contacts(model, state, skins, rules, contacts)
    if count > 0:
        part_contacts(contacts, count, model.inverse_mass, state.position, state.velocity, bodies, skins.crowd)
    return contacts


@jit
def find_soft_contacts(
    model: Model, state: State, skins: Skins, rules: Rules, contacts: SoftContacts
) -> tuple[SoftContacts, int]:
    """List every contact of a soft body with another or with a box; return (the list, its length)."""
    start, near = _neighbours(model, state, skins, rules.exhaustive_pairs)
    count = 0
    for body in range(model.gas.shape[0]):
        others = near[start[body] : start[body + 1]]
        if others.shape[0] == 0:
            continue
        before = count
        while True:
            count = _list_contacts(model, state, skins, rules.edge_contacts, body, others, contacts, before)
            if count <= contacts.depth.shape[0]:
                break
            contacts = with_room(contacts, before, 2 * count)
    return contacts, count


@jit
def _neighbours(model: Model, state: State, skins: Skins, exhaustive: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return (start (b + 1,), near): near[start[i]:start[i + 1]] are all bodies whose bounds meet those of soft body i.

    Boxes are numbered after soft bodies. (They part from each other elsewhere.)
    """
    soft = model.gas.shape[0]
    centre, radius, is_soft = spheres_of_bodies(model, state)
    for body in range(soft):
        low, high = bounding_box(state.position[model.particle_start[body] : model.particle_start[body + 1]])
        store(skins.low, body, low)
        store(skins.high, body, high)
    pairs = near_pairs_exhaustive(centre, radius, is_soft) if exhaustive else near_pairs(centre, radius, is_soft)
    count = 0
    start = np.zeros(soft + 1, np.int64)
    for k in range(pairs.shape[0]):
        a, b = min(pairs[k, 0], pairs[k, 1]), max(pairs[k, 0], pairs[k, 1])
        if b < soft:
            meet = boxes_meet((load(skins.low, a), load(skins.high, a)), (load(skins.low, b), load(skins.high, b)))
        else:
            meet = _sphere_may_meet_box(model, state, load(centre, a), radius[a], b - soft)
        if meet:
            pairs[count, 0], pairs[count, 1] = a, b
            start[a + 1] += 1
            if b < soft:
                start[b + 1] += 1
            count += 1
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
def _sphere_may_meet_box(model: Model, state: State, centre: Vec, radius: float, box: int) -> bool:
    """Tell whether no face of a box parts it from a sphere."""
    orientation = load_quaternion(state.box_orientation, box)
    depth, _ = point_in_box(centre, load(model.box_size, box), load(state.box_position, box), orientation)
    return depth >= -radius


@jit
def _list_contacts(
    model: Model,
    state: State,
    skins: Skins,
    edges: bool,
    body: int,
    others: np.ndarray,
    contacts: SoftContacts,
    count: int,
) -> int:
    """List what of `others` is in the skin of a soft body, and what of it is in boxes, after `count` other contacts.

    Particles and corners and, if `edges` count, edges. Returns how many contacts there are then; those for which there
    is no room are counted only.
    """
    soft, first = model.gas.shape[0], model.particle_start[body]
    vertices = state.position[first : model.particle_start[body + 1]]
    own_edges = model.edges[model.edge_start[body] : model.edge_start[body + 1]]
    tree, search, mark = tree_of(skins, body), skins.search, skins.mark
    refit_triangle_tree(tree, vertices)
    bounds = load(skins.low, body), load(skins.high, body)
    for other in others:
        before = count
        if other < soft:
            start, end = model.particle_start[other], model.particle_start[other + 1]
            points, box = state.position[start:end], (load(skins.low, other), load(skins.high, other))
            hint, rows = skins.hint[start:end], model.edges[model.edge_start[other] : model.edge_start[other + 1]]
            if model.edge_length[other] < COARSE * model.edge_length[body]:
                rows = rows[:0]  # short edges do not go deep between their ends
            restitution = combined_restitution(model.soft_restitution[body], model.soft_restitution[other])
            friction = combined_friction(model.soft_friction[body], model.soft_friction[other])
        else:
            start, rows = 0, own_edges[:0]  # its edges are left to those of the soft body
            points, hint = skins.corners, skins.corner_hint
            box = _box_corners(model, state, other - soft, points)
            restitution = combined_restitution(model.soft_restitution[body], model.box_restitution[other - soft])
            friction = combined_friction(model.soft_friction[body], model.box_friction[other - soft])
            count = _list_in_box(
                model.box_size, state, own_edges, edges, first, vertices, other - soft, mark, skins.edge,
                restitution, friction, contacts, count,
            )  # fmt: skip
        if not boxes_meet(box, bounds):
            continue
        left, inside, doubts = _mark(points, box, rows, start, edges, vertices, bounds, tree, search, mark, skins.edge)
        if doubts > 0:
            inside += settle_doubts(points, mark, tree, vertices, search)
        if left + inside > 0:
            find_closest(points, mark, hint, tree, vertices, search, skins.found)
            count = _write_points(
                points, start, other - soft, inside, skins.found, vertices, first, tree.triangles,
                restitution, friction, contacts, count,
            )  # fmt: skip
            count = _write_edges(
                points, start, rows, left, skins.edge, mark, hint, vertices, first, tree, search,
                restitution, friction, contacts, count,
            )  # fmt: skip
        for k in range(before, min(count, contacts.depth.shape[0])):
            if contacts.depth[k] > skins.deepest[0]:
                skins.deepest[0] = contacts.depth[k]
                skins.deepest_pair[0], skins.deepest_pair[1] = min(body, other), max(body, other)
    return count


@jit_lean
def _box_corners(model: Model, state: State, box: int, corners: np.ndarray) -> BoundingBox:
    """Write the eight corners of a box [m] into `corners` (8, 3); return their bounding box."""
    size, position = load(model.box_size, box), load(state.box_position, box)
    orientation = load_quaternion(state.box_orientation, box)
    for k in range(8):
        store(corners, k, box_corner(size, position, orientation, k))
    return bounding_box(corners)


@jit_lean
def _mark(
    points: np.ndarray,
    box: BoundingBox,
    edges: np.ndarray,
    start: int,
    with_edges: bool,
    vertices: np.ndarray,
    bounds: BoundingBox,
    tree: TriangleTree,
    search: Search,
    mark: np.ndarray,
    listed: np.ndarray,
) -> tuple[int, int, int]:
    """Mark the `points` (m, 3) [m] of one body by where they are in another, the `edges` between them listed.

    Returns how many edges may go through the other, and how many points are inside, and how many in doubt.
    """
    free = mark_points(points, box, vertices, bounds, mark)
    left = _edges_left(edges, start, mark, listed) if with_edges else 0
    if free == 0:
        return left, 0, 0
    inside, doubts = mark_inside(points, mark, tree, vertices, search)
    return left, inside, doubts


@jit_lean
def _edges_left(edges: np.ndarray, start: int, mark: np.ndarray, left: np.ndarray) -> int:
    """Write into `left` which of `edges` (e, 2) are not outside by the marks of both ends; return how many."""
    count = 0
    for e in range(edges.shape[0]):
        left[count] = e
        count += mark[edges[e, 0] - start] & mark[edges[e, 1] - start] == 0
    return count


@jit_lean
def _write_points(
    points: np.ndarray,
    start: int,
    box: int,
    inside: int,
    found: Penetrations,
    vertices: np.ndarray,
    first: int,
    triangles: np.ndarray,
    restitution: float,
    friction: float,
    contacts: SoftContacts,
    count: int,
) -> int:
    """List the `inside` points that were `found`, corners of a `box` or, if that is negative, particles from `start`.

    `vertices` (n, 3) [m] and `triangles` (t, 3) are of the body that they are in, its particles from `first` on.
    """
    for row in range(inside):
        point, triangle, weights = found.point[row], found.triangle[row], load(found.weights, row)
        depth, normal = way_out(load(points, point), vertices, triangles, triangle, weights)
        if depth > 0.0:
            skin = first + triangles[triangle, 0], first + triangles[triangle, 1], first + triangles[triangle, 2]
            who, how = skin, weights
            if box < 0:
                who, how = (start + point, start + point, start + point), WHOLE
            else:
                normal = scale(-1.0, normal)
            write_contact(
                contacts, count, who, how, skin, weights, max(box, NO_BOX), normal, depth, restitution, friction
            )
            count += 1
    return count


@jit_lean
def _write_edges(
    points: np.ndarray,
    start: int,
    edges: np.ndarray,
    left: int,
    listed: np.ndarray,
    mark: np.ndarray,
    hint: np.ndarray,
    vertices: np.ndarray,
    first: int,
    tree: TriangleTree,
    search: Search,
    restitution: float,
    friction: float,
    contacts: SoftContacts,
    count: int,
) -> int:
    """List those of the `left` edges `listed` that go through a skin between their ends; as `_write_points`.

    `hint` (m,): the triangle closest to each point inside.
    """
    triangles = tree.triangles
    for row in range(left):
        i, j = edges[listed[row], 0], edges[listed[row], 1]
        if mark[j - start] == INSIDE:
            i, j = j, i
        p, q = load(points, i - start), load(points, j - start)
        if mark[i - start] == INSIDE:
            # It is parted as a particle, and with it the edge, unless that goes deeper still.
            if mark[j - start] == INSIDE or dot(sub(q, p), facing(triangles, hint[i - start], vertices)) >= 0.0:
                continue
            leave, other, _, _ = first_hits(p, q, tree, vertices, search)
            hits = 0.0, hint[i - start], leave, other
        else:
            hits = first_hits(p, q, tree, vertices, search)
        if hits[3] < 0:
            continue
        depth, normal, place, triangle, weights = edge_over_ridge(p, q, hits, vertices, triangles)
        if triangle < 0 and mark[i - start] != INSIDE:
            depth, normal, place, triangle, weights = edge_inside(p, q, hits, tree, vertices, search)
        if depth > 0.0:
            who, how = (i, j, j), (1.0 - place, place, 0.0)
            skin = first + triangles[triangle, 0], first + triangles[triangle, 1], first + triangles[triangle, 2]
            write_contact(contacts, count, who, how, skin, weights, NO_BOX, normal, depth, restitution, friction)
            count += 1
    return count


@jit_lean
def _list_in_box(
    sizes: np.ndarray,
    state: State,
    edges: np.ndarray,
    with_edges: bool,
    first: int,
    points: np.ndarray,
    box: int,
    mark: np.ndarray,
    listed: np.ndarray,
    restitution: float,
    friction: float,
    contacts: SoftContacts,
    count: int,
) -> int:
    """List where particles `points` (n, 3) [m] of a soft body, from `first` on, or edges between them, are in a box."""
    size, position = load(sizes, box), load(state.box_position, box)
    orientation = load_quaternion(state.box_orientation, box)
    half = scale(0.5, size)
    for i in range(points.shape[0]):
        x, y, z = rotate_inverse(orientation, sub(load(points, i), position))
        bits = (x <= -half[0]) | (x >= half[0]) << 1 | (y <= -half[1]) << 2 | (y >= half[1]) << 3
        bits |= (z <= -half[2]) << 4 | (z >= half[2]) << 5
        mark[i] = INSIDE if bits == 0 else bits
        if bits == 0:
            depth, normal = point_in_box(load(points, i), size, position, orientation)
            who = first + i, first + i, first + i
            write_contact(contacts, count, who, WHOLE, who, WHOLE, box, normal, depth, restitution, friction)
            count += 1
    if with_edges:
        for row in range(_edges_left(edges, first, mark, listed)):
            i, j = edges[listed[row], 0], edges[listed[row], 1]
            if mark[i - first] == INSIDE and mark[j - first] == INSIDE:
                continue
            p, q = load(points, i - first), load(points, j - first)
            depth, normal, place = edge_in_box(p, q, size, position, orientation)
            # At an end that is inside it is parted as a particle.
            at_end = (place == 0.0 and mark[i - first] == INSIDE) or (place == 1.0 and mark[j - first] == INSIDE)
            if depth > 0.0 and not at_end:
                who, how = (i, j, j), (1.0 - place, place, 0.0)
                write_contact(contacts, count, who, how, who, WHOLE, box, normal, depth, restitution, friction)
                count += 1
    return count
