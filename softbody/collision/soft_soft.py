"""Where does one soft body touch another? Particles inside it, and edges that go through its surface; paper §4.3."""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts, Touch, add_contact, soft_side
from softbody.collision.edge_mesh import Crossing, Ridge, edge_across_edge
from softbody.collision.law import Material
from softbody.collision.point_mesh import way_out
from softbody.collision.surface import Memory, Solid, Surface, third_corner
from softbody.collision.surface_point import SurfacePoint, at_particle, on_edge
from softbody.geometry.aabb import AABB, boxes_meet
from softbody.geometry.bvh_rays import list_near, segment_hits
from softbody.geometry.penetration import INSIDE, find_penetrations
from softbody.jit import jit_lean
from softbody.vec import Vec, add, dot, load, norm, scale, store, sub

# How deep a ridge is that an edge goes through, at most, as a part of the edge's way inside: for one of 28° and more.
REACH = 4.0


@jit_lean
def find_soft_soft_contacts(
    one: Surface, other: Solid, deepest: float, memory: Memory, material: Material, contacts: Contacts
) -> None:
    """List what of `one` is inside `other`, whose tree must have been fitted: particles, and edges across its edges.

    `one` is side a of the contacts, `other` side b. Edges are looked for down to a depth of `deepest` [m].
    """
    if not boxes_meet(one.vertices.bounds, other.surface.vertices.bounds):
        return
    inside = find_penetrations(one.vertices, other.surface.vertices, other.tree, memory.search, memory.found)
    if inside > 0:
        _add_particles(one, other, inside, memory, material, contacts)
    if deepest > 0.0:
        count = candidate_edges(one.edges, one.first, memory.found.outcode, memory.edge)
        _add_edges(one, other, count, deepest, memory, material, contacts)


@jit_lean
def point_between(p: Vec, q: Vec, place: float) -> Vec:
    """Return the point [m] of a segment at `place`, 0 at p … 1 at q."""
    return add(scale(1.0 - place, p), scale(place, q))


@jit_lean
def half_way(point: Vec, depth: float, out: Vec) -> Vec:
    """Return the place [m] half-way between a `point` that is inside a body and that body's surface, `depth` away."""
    return add(point, scale(0.5 * depth, out))


@jit_lean
def _add_particles(
    one: Surface, other: Solid, inside: int, memory: Memory, material: Material, contacts: Contacts
) -> None:
    """Add the particles that were found `inside`."""
    found = memory.found
    for row in range(inside):
        p = load(one.vertices.position, found.point[row])
        depth, normal, end = way_out(p, other.surface, found.triangle[row], load(found.weights, row))
        store(memory.way_out, found.point[row], normal)
        if depth > 0.0:
            a = soft_side(at_particle(one.first + found.point[row]))
            add_contact(contacts, a, soft_side(end), Touch(half_way(p, depth, normal), normal, depth, 0), material)


@jit_lean
def candidate_edges(edges: np.ndarray, first: int, outcode: np.ndarray, listed: np.ndarray) -> int:
    """Write into `listed` which of `edges` (e, 2) are not outside by the outcodes of both ends; return how many.

    Vertices of the edges are numbered from `first`. An edge with both ends inside is none: they are parted as points.
    """
    count = 0
    for e in range(edges.shape[0]):
        listed[count] = e
        count += outcode[edges[e, 0] - first] & outcode[edges[e, 1] - first] == 0
    return count


@jit_lean
def _add_edges(
    one: Surface, other: Solid, count: int, deepest: float, memory: Memory, material: Material, contacts: Contacts
) -> None:
    """Add where those of the `count` candidate edges that are partly inside are across edges of the other surface."""
    places, triangles, listed = memory.places, other.surface.triangles, memory.search.listed
    for row in range(count):
        edge = memory.edge[row]
        ridge = _ridge_of(one, edge)
        starts_inside = memory.found.outcode[one.edges[edge, 0] - one.first] == INSIDE
        ends_inside = memory.found.outcode[one.edges[edge, 1] - one.first] == INSIDE
        p, q = ridge.start, ridge.end
        # One that leads out from an end that is inside goes no deeper: it is parted as a particle.
        along = sub(q, p) if starts_inside else sub(p, q)
        inner = one.edges[edge, 0 if starts_inside else 1] - one.first
        if (starts_inside or ends_inside) and dot(along, load(memory.way_out, inner)) > 0.0:
            continue
        hits = segment_hits(p, q, other.tree, other.surface.vertices.position, memory.search, places)
        if hits == 0 and not starts_inside:
            continue
        # The other's edges that are near what is inside: each is a side, from the lower vertex, of one triangle.
        enter, leave = 0.0 if starts_inside else 1.0, 1.0 if ends_inside else 0.0
        for k in range(hits):
            enter, leave = min(enter, places[k]), max(leave, places[k])
        margin = min(deepest, REACH * (leave - enter) * norm(along))
        low, high = _box_around(point_between(p, q, enter), point_between(p, q, leave), margin)
        for near in range(list_near(low, high, other.tree, memory.search)):
            for side in range(3):
                if triangles[listed[near], side] < triangles[listed[near], (side + 1) % 3]:
                    other_edge = other.surface.sides[listed[near], side]
                    crossing = edge_across_edge(ridge, _ridge_of(other.surface, other_edge), deepest)
                    if crossing.depth > 0.0 and _is_inside(crossing.place, starts_inside, places, hits):
                        _add_crossing((one, edge), (other.surface, other_edge), crossing, material, contacts)


@jit_lean
def _ridge_of(surface: Surface, edge: int) -> Ridge:
    points, first = surface.vertices.position, surface.first
    return Ridge(
        load(points, surface.edges[edge, 0] - first),
        load(points, surface.edges[edge, 1] - first),
        load(points, third_corner(surface, edge, 0)),
        load(points, third_corner(surface, edge, 1)),
    )


@jit_lean
def _box_around(p: Vec, q: Vec, margin: float) -> AABB:
    """Return the corners [m] of the box around two points, and a `margin`."""
    low = min(p[0], q[0]) - margin, min(p[1], q[1]) - margin, min(p[2], q[2]) - margin
    return low, (max(p[0], q[0]) + margin, max(p[1], q[1]) + margin, max(p[2], q[2]) + margin)


@jit_lean
def _is_inside(place: float, starts_inside: bool, places: np.ndarray, hits: int) -> bool:
    """Tell whether a segment is inside at a `place`, 0 … 1, that goes through a surface at the first `hits` places."""
    inside = starts_inside
    for k in range(hits):
        inside ^= places[k] < place
    return inside


@jit_lean
def _add_crossing(
    one: tuple[Surface, int], other: tuple[Surface, int], crossing: Crossing, material: Material, contacts: Contacts
) -> None:
    """Add the contact of two edges, each a row of its surface's."""
    (surface, edge), (other_surface, other_edge), (depth, normal, place, other_place, on_left) = one, other, crossing
    i, j = surface.edges[edge, 0], surface.edges[edge, 1]
    u, v = other_surface.edges[other_edge, 0], other_surface.edges[other_edge, 1]
    wing = other_surface.first + third_corner(other_surface, other_edge, 0 if on_left else 1)
    points, first = surface.vertices.position, surface.first
    point = half_way(point_between(load(points, i - first), load(points, j - first), place), depth, normal)
    b = SurfacePoint((u, v, wing), (1.0 - other_place, other_place, 0.0))
    add_contact(contacts, soft_side(on_edge(i, j, place)), soft_side(b), Touch(point, normal, depth, 0), material)
