"""Contacts of a soft body with a box: particles and edges in the box, corners in the body; paper §4.2."""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.collision.boxes.sat_boxes import PlacedBox
from softbody.collision.contact import Listing, Touch, add_contact, box_side, soft_side
from softbody.collision.soft.edge_box import edge_in_box
from softbody.collision.soft.point_mesh import way_out, way_out_before
from softbody.collision.soft.soft_soft import ALONG_OWN, half_way, point_between
from softbody.collision.soft.surface import Memory, Solid, Surface
from softbody.compiler.jit import jit_lean
from softbody.geometry.aabb import AABB, bounding_box
from softbody.geometry.box import box_corner, corner_signs, way_back
from softbody.geometry.bvh import closest_in_bvh
from softbody.geometry.penetration import INSIDE, Points, find_inside, find_penetrations
from softbody.geometry.triangle import area_vector
from softbody.linalg.quaternion import rotate, rotate_inverse
from softbody.linalg.vec import Vec, dot, load, multiply, norm, scale, store, sub
from softbody.model.material import Material
from softbody.model.surface_point import at_particle, on_edge

ALL_FACES = INSIDE - 1


@jit_lean
def find_contacts_in_box(
    surface: Surface,
    box: tuple[int, PlacedBox],
    before: tuple[np.ndarray, PlacedBox],
    with_edges: bool,
    is_inside: bool,
    memory: Memory,
    material: Material,
    contacts: Listing,
) -> None:
    """List where particles of a soft body are in a box, (its number, where it is), and its edges if they count.

    A particle leaves by the face through which it came since `before`, when the particles were at (n, 3) [m], and the
    box where it was then; also one that has gone right through. An edge whose ends leave by one face leaves with them;
    if they do by two, it is across a side of the box. Of a body that the box `is_inside`, edges in valleys do not
    count: what comes there meets the triangles first. The surface is side a of the contacts, the box side b.
    """
    number, (size, position, orientation) = box
    first, points, outcode = surface.first, surface.vertices.position, memory.found.outcode
    b, half = box_side(number), scale(0.5, size)
    (old_points, old_box), box_way = before, way_of_box(before[1], box[1])
    # Outcodes by the six faces. A particle that is inside has that of the face by which it leaves.
    for i in range(points.shape[0]):
        p, old = load(points, i), load(old_points, i)
        x, y, z = rotate_inverse(orientation, sub(p, position))
        bits = (x <= -half[0]) | (x >= half[0]) << 1 | (y <= -half[1]) << 2 | (y >= half[1]) << 3
        bits |= (z <= -half[2]) << 4 | (z >= half[2]) << 5
        outcode[i] = bits
        # Who is outside by more than both have moved has not been inside.
        way, outside = sub(p, old), max(abs(x) - half[0], abs(y) - half[1], abs(z) - half[2])
        if bits == 0 or outside * outside < 2.0 * (dot(way, way) + box_way * box_way):
            from_box = rotate_inverse(old_box.orientation, sub(old, old_box.position))
            depth, normal = way_back(from_box, (x, y, z), half)
            if depth > 0.0:
                outcode[i] = INSIDE | _face_of(normal)
                normal = rotate(orientation, normal)
                touch = Touch(half_way(p, depth, normal), normal, depth, 0)
                add_contact(contacts, soft_side(at_particle(first + i)), b, touch, material)
    if not with_edges:
        return
    for edge in range(surface.ridges.shape[0]):
        i, j = surface.ridges[edge, 0], surface.ridges[edge, 1]
        if outcode[i] & outcode[j] & ALL_FACES != 0:
            continue
        if is_inside and not _is_reentrant(points, surface.ridges[edge]):
            continue
        p, q = load(points, i), load(points, j)
        edge_before = load(old_points, i), load(old_points, j)
        depth, normal, place = edge_in_box((p, q), box[1], edge_before, old_box)
        # At an end that leaves by the same face, it leaves with that.
        face = _face_of(rotate_inverse(orientation, normal)) | INSIDE
        with_end = (place == 0.0 and outcode[i] == face) or (place == 1.0 and outcode[j] == face)
        if depth > 0.0 and not with_end:
            point = half_way(point_between(p, q, place), depth, normal)
            add_contact(
                contacts, soft_side(on_edge(first + i, first + j, place)), b, Touch(point, normal, depth, 0), material
            )


@jit_lean
def _is_reentrant(points: np.ndarray, ridge: np.ndarray) -> bool:
    """Tell whether the surface is bent outwards at an edge, of these `points` (n, 3) [m]; `ridge`: see `Surface`."""
    a, b, c = load(points, ridge[0]), load(points, ridge[1]), load(points, ridge[2])
    return bool(dot(area_vector(a, b, c), sub(load(points, ridge[3]), a)) > 0.0)


@jit_lean
def _face_of(normal: Vec) -> int:
    """Return the outcode of a face of a box, by its normal; 0 if that is of none."""
    for axis in range(3):
        if abs(normal[axis]) > 1.0 - 1e-9:
            return 1 << (2 * axis + (normal[axis] > 0.0))
    return 0


@jit_lean
def way_of_box(before: PlacedBox, now: PlacedBox) -> float:
    """Return a bound of how far [m] any point of a box has moved: with its centre, and by its turn about that."""
    turn = 0.0
    for k in range(4):
        turn += (now.orientation[k] - before.orientation[k]) ** 2
    return norm(sub(now.position, before.position)) + sqrt(turn) * norm(now.size)


@jit_lean
def find_corner_contacts(
    solid: Solid,
    box: tuple[int, PlacedBox],
    deepest: float,
    memory: Memory,
    material: Material,
    contacts: Listing,
) -> None:
    """List which corners of a box, (its number, where it is), are inside a soft body, whose tree must have been fitted.

    A way out along the normal of a corner's own face would pull the box in further. It is that of a corner that has
    pressed a skin close to the one behind it: it goes back by the triangle before it, down to a depth of `deepest` [m].
    The surface is side a of the contacts, the box side b.
    """
    number, (_, _, orientation) = box
    found, place = memory.found, memory.corners.position
    corners = Points(place, _put_corners(box[1], place), memory.corners.hint)
    for row in range(find_penetrations(corners, solid.surface.vertices, solid.tree, memory.search, found)):
        p, signs = load(place, found.point[row]), corner_signs(found.point[row])
        depth, out, end = way_out(p, solid.surface, found.triangle[row], load(found.weights, row))
        along = multiply(signs, rotate_inverse(orientation, out))
        if max(along[0], along[1], along[2]) > ALONG_OWN:
            before_it = way_out_before(p, rotate(orientation, signs), solid.surface, deepest)
            if before_it.depth > 0.0:
                depth, out, end = before_it
        if depth > 0.0:
            touch = Touch(half_way(p, depth, out), scale(-1.0, out), depth, 0)
            add_contact(contacts, soft_side(end), box_side(number), touch, material)


@jit_lean
def find_corners_outside(
    solid: Solid, box: tuple[int, PlacedBox], memory: Memory, material: Material, contacts: Listing
) -> None:
    """List which corners of a box, (its number, where it is), are outside the soft body that it is inside.

    They go back by the shortest way. The tree must have been fitted. The surface is side a, the box side b.
    """
    surface, mesh, outcode = solid.surface, solid.surface.vertices, memory.found.outcode
    place, hint = memory.corners.position, memory.corners.hint
    corners = Points(place, _put_corners(box[1], place), hint)
    if find_inside(corners, mesh, solid.tree, memory.search, outcode) == 8:
        return
    for k in range(8):
        if outcode[k] != INSIDE:
            p = load(place, k)
            triangle, weights, _ = closest_in_bvh(p, solid.tree, mesh.position, memory.search, int(hint[k]))
            hint[k] = triangle
            depth, back, end = way_out(p, surface, triangle, weights, -1.0)
            if depth > 0.0:
                touch = Touch(half_way(p, depth, back), scale(-1.0, back), depth, 0)
                add_contact(contacts, soft_side(end), box_side(box[0]), touch, material)


@jit_lean
def _put_corners(box: PlacedBox, place: np.ndarray) -> AABB:
    """Write the corners of a box into `place` (8, 3) [m]; return their bounds."""
    for k in range(8):
        store(place, k, box_corner(box.size, box.position, box.orientation, k))
    return bounding_box(place)
