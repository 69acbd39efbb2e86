"""Where does one soft body touch another? Particles inside it, and edges that go through its surface; paper §4.3."""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts, Touch, add_contact, soft_side
from softbody.collision.edge_mesh import depth_and_direction, edge_across_edge, edge_through_faces, facing
from softbody.collision.law import Material
from softbody.collision.surface import Memory, Solid, Surface
from softbody.collision.surface_point import at_particle, in_triangle, on_edge
from softbody.geometry.aabb import boxes_meet
from softbody.geometry.bvh_rays import segment_hits
from softbody.geometry.penetration import INSIDE, find_penetrations
from softbody.jit import jit_lean
from softbody.vec import Vec, add, dot, load, scale, sub


@jit_lean
def find_soft_soft_contacts(
    one: Surface, other: Solid, with_edges: bool, memory: Memory, material: Material, contacts: Contacts
) -> None:
    """List what of `one` is inside `other`, whose tree must have been fitted: particles, and edges if they count.

    `one` is side a of the contacts, `other` side b.
    """
    if not boxes_meet(one.vertices.bounds, other.surface.vertices.bounds):
        return
    inside = find_penetrations(one.vertices, other.surface.vertices, other.tree, memory.search, memory.found)
    if inside > 0:
        _add_particles(one, other, inside, memory, material, contacts)
    if with_edges:
        count = candidate_edges(one.edges, one.first, memory.found.outcode, memory.edge)
        _add_edges(one, other, count, memory, material, contacts)


@jit_lean
def half_way(point: Vec, depth: float, out: Vec) -> Vec:
    """Return the place [m] half-way between a `point` that is inside a body and that body's surface, `depth` away."""
    return add(point, scale(0.5 * depth, out))


@jit_lean
def _add_particles(
    one: Surface, other: Solid, inside: int, memory: Memory, material: Material, contacts: Contacts
) -> None:
    """Add the particles that were found `inside`."""
    (first, _, mesh), triangles, found = other.surface, other.tree.triangles, memory.found
    for row in range(inside):
        vertex, triangle, weights = found.point[row], found.triangle[row], load(found.weights, row)
        p = load(one.vertices.position, vertex)
        depth, normal = depth_and_direction(p, mesh.position, triangles, triangle, weights)
        if depth > 0.0:
            a = soft_side(at_particle(one.first + vertex))
            b = soft_side(in_triangle(triangles, triangle, first, weights))
            add_contact(contacts, a, b, Touch(half_way(p, depth, normal), normal, depth, 0), material)


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
def _add_edges(one: Surface, other: Solid, count: int, memory: Memory, material: Material, contacts: Contacts) -> None:
    """Add those of the `count` candidate edges that go through the other surface between their ends."""
    edges, first, points = one.edges, one.first, one.vertices.position
    outcode, hint, search = memory.found.outcode, one.vertices.hint, memory.search
    tree, vertices, triangles = other.tree, other.surface.vertices.position, other.tree.triangles
    for row in range(count):
        # Start at the end that is inside, if one is.
        i, j = edges[memory.edge[row], 0], edges[memory.edge[row], 1]
        if outcode[j - first] == INSIDE:
            i, j = j, i
        starts_inside = outcode[i - first] == INSIDE
        p, q = load(points, i - first), load(points, j - first)
        # The two triangles that it goes through.
        if starts_inside:
            # It is parted as a particle, and with it the edge, unless that goes deeper still.
            nearest = hint[i - first]
            if dot(sub(q, p), facing(triangles, nearest, vertices)) >= 0.0:
                continue
            leave, out, _, _ = segment_hits(p, q, tree, vertices, search)
            hits = 0.0, nearest, leave, out
        else:
            hits = segment_hits(p, q, tree, vertices, search)
        if hits[3] < 0:
            continue
        # Across an edge that they share, or through the two faces.
        crossing = edge_across_edge(p, q, hits, vertices, triangles)
        if crossing.triangle < 0 and not starts_inside:
            crossing = edge_through_faces(p, q, hits, tree, vertices, search)
        if crossing.depth > 0.0:
            place, depth, normal = crossing.place, crossing.depth, crossing.normal
            a = soft_side(on_edge(i, j, place))
            b = soft_side(in_triangle(triangles, crossing.triangle, other.surface.first, crossing.weights))
            point = half_way(add(scale(1.0 - place, p), scale(place, q)), depth, normal)
            add_contact(contacts, a, b, Touch(point, normal, depth, 0), material)
