"""Contacts of two soft bodies: particles inside, and edges that go through a surface; paper §4.3."""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Listing, Touch, add_contact, soft_side
from softbody.collision.soft.edge_mesh import SLACK, Crossing, Ridge, bits_across, edge_across_edge
from softbody.collision.soft.point_mesh import vertex_normal, way_out, way_out_before
from softbody.collision.soft.surface import Eight, Memory, Solid, Surface
from softbody.compiler.jit import jit_lean
from softbody.compiler.simd import LANES, lowest_bit
from softbody.geometry.aabb import box_around, boxes_meet
from softbody.geometry.bvh import Search
from softbody.geometry.bvh_boxes import ask_box, ask_nothing, list_near, sort_listed
from softbody.geometry.bvh_rays import segment_hits
from softbody.geometry.penetration import INSIDE, find_penetrations
from softbody.geometry.segments import end_of, put_segment, start_of
from softbody.linalg.vec import Vec, add, dot, load, norm, scale, store, sub
from softbody.model.material import Material
from softbody.model.surface_point import SurfacePoint, at_particle, on_edge

# How deep a ridge is that an edge goes through, at most, as a part of the edge's way inside: for one of 28° and more.
REACH = 4.0

# Cosine between a particle's way out and its own normal above which the way is one that it cannot have come in by.
ALONG_OWN = 0.8


@jit_lean
def find_soft_soft_contacts(
    one: Surface,
    other: Solid,
    deepest: float,
    with_edges: bool,
    memory: Memory,
    material: Material,
    contacts: Listing,
) -> None:
    """List what of `one` is inside `other`, whose tree must have been fitted: particles, and edges across its edges.

    `one` is side a of the contacts, `other` side b. Edges, if `with_edges`, and ways out that are not the shortest, are
    looked for down to a depth of `deepest` [m].
    """
    if not boxes_meet(one.vertices.bounds, other.surface.vertices.bounds):
        return
    inside = find_penetrations(one.vertices, other.surface.vertices, other.tree, memory.search, memory.found)
    if inside > 0:
        _add_particles(one, other, inside, deepest, memory, material, contacts)
    if with_edges:
        count = candidate_edges(one.ridges, memory.found.outcode, memory.edge)
        count = _drop_those_that_lead_out(one, count, memory)
        _add_edges(one, count, other, deepest, memory, material, contacts)


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
    one: Surface,
    other: Solid,
    inside: int,
    deepest: float,
    memory: Memory,
    material: Material,
    contacts: Listing,
) -> None:
    """Add the particles that were found `inside`.

    A way out along a particle's own normal would pull its skin from within. It is that of a rim that has slid past the
    other's rim, and would lock both: the particle goes back by the triangle before it, if there is one.
    """
    found = memory.found
    for row in range(inside):
        p, own = load(one.vertices.position, found.point[row]), vertex_normal(one, found.point[row])
        depth, normal, end = way_out(p, other.surface, found.triangle[row], load(found.weights, row))
        if dot(normal, own) > ALONG_OWN * norm(own):
            before_it = way_out_before(p, own, other.surface, deepest)
            if before_it.depth > 0.0:
                depth, normal, end = before_it
        store(memory.way_out, found.point[row], normal)
        if depth > 0.0:
            a = soft_side(at_particle(one.first + found.point[row]))
            add_contact(contacts, a, soft_side(end), Touch(half_way(p, depth, normal), normal, depth, 0), material)


@jit_lean
def candidate_edges(ridges: np.ndarray, outcode: np.ndarray, listed: np.ndarray) -> int:
    """Write into `listed` which edges, of `ridges` (e, 4), may be inside by the outcodes of both ends; return how many.

    An edge with both ends inside is none: they are parted as points.
    """
    count = 0
    for e in range(ridges.shape[0]):
        listed[count] = e
        count += outcode[ridges[e, 0]] & outcode[ridges[e, 1]] == 0
    return count


@jit_lean
def _drop_those_that_lead_out(one: Surface, count: int, memory: Memory) -> int:
    """Drop from the `count` edges in `memory.edge` what leads out from an end that is inside; return how many are left.

    Such an edge goes no deeper: it is parted as a particle. One that lies along the surface, but for SLACK, may go
    deeper farther on, and which it is must not change from step to step.
    """
    points, outcode = one.vertices.position, memory.found.outcode
    left = 0
    for row in range(count):
        edge = memory.edge[row]
        i, j = one.ridges[edge, 0], one.ridges[edge, 1]
        along, out = sub(load(points, j), load(points, i)), 0.0
        if outcode[i] == INSIDE:
            out = dot(along, load(memory.way_out, i))
        elif outcode[j] == INSIDE:
            out = -dot(along, load(memory.way_out, j))
        memory.edge[left] = edge
        left += out <= SLACK * norm(along)
    return left


@jit_lean
def _add_edges(
    one: Surface, count: int, other: Solid, deepest: float, memory: Memory, material: Material, contacts: Listing
) -> None:
    """Add where those of the `count` edges in `memory.edge` that go into the other body are across edges of it.

    They are tried eight at a time; those that go in, seldom more than two, are collected until they are eight.
    """
    tried, entered, waiting = memory.tried, memory.entered, 0
    for row in range(0, count, LANES):
        number = min(LANES, count - row)
        for lane in range(number):
            edge = memory.edge[row + lane]
            i, j = one.ridges[edge, 0], one.ridges[edge, 1]
            tried.edge[lane] = edge
            put_segment(tried.segments, lane, load(one.vertices.position, i), load(one.vertices.position, j))
        segment_hits(
            tried.segments, number, other.tree, other.surface.vertices.position, memory.search, tried.hits, tried.place
        )
        for lane in range(number):
            if tried.hits[lane] > 0 or _starts_inside(one, tried.edge[lane], memory):
                _move_edge(tried, lane, entered, waiting)
                waiting += 1
            if waiting == LANES or (waiting > 0 and row + lane == count - 1):
                _add_crossings(one, waiting, other, deepest, memory, material, contacts)
                waiting = 0


@jit_lean
def _move_edge(tried: Eight, lane: int, entered: Eight, place: int) -> None:
    """Note an edge that goes in, and where."""
    entered.edge[place], entered.hits[place] = tried.edge[lane], tried.hits[lane]
    put_segment(entered.segments, place, start_of(tried.segments, lane), end_of(tried.segments, lane))
    for k in range(tried.hits[lane]):
        entered.place[place, k] = tried.place[lane, k]


@jit_lean
def _add_crossings(
    one: Surface, number: int, other: Solid, deepest: float, memory: Memory, material: Material, contacts: Listing
) -> None:
    """Add where the `number` edges, eight at most, that go in are across edges of the other surface."""
    surface, tree, search = other.surface, other.tree, memory.search
    edges, segments, hits, places = memory.entered
    # Which edges of the other are near what is inside?
    ask_nothing(search)
    for lane in range(number):
        p, q = start_of(segments, lane), end_of(segments, lane)
        enter = 0.0 if _starts_inside(one, edges[lane], memory) else 1.0
        leave = 1.0 if _ends_inside(one, edges[lane], memory) else 0.0
        for k in range(hits[lane]):
            enter, leave = min(enter, places[lane, k]), max(leave, places[lane, k])
        margin = min(deepest, REACH * (leave - enter) * norm(sub(q, p)))
        low, high = box_around(point_between(p, q, enter), point_between(p, q, leave), margin)
        ask_box(search, lane, low, high, tree)
    count = _keep_those_across(surface, segments, search, list_near(tree, search), deepest)
    sort_listed(search, count)
    for near in range(count):
        for side in range(3):
            other_edge, meets = surface.sides[search.listed[near], side], _of_side(search.meets[near], side)
            while meets != 0:
                lane = lowest_bit(meets)
                meets &= meets - 1
                crossing = edge_across_edge(_ridge_of(one, edges[lane]), _ridge_of(surface, other_edge), deepest)
                if crossing.depth > 0.0 and _goes_under(one, edges[lane], crossing, lane, memory):
                    _add_crossing((one, edges[lane]), (surface, other_edge), crossing, material, contacts)


@jit_lean
def _keep_those_across(surface: Surface, segments: np.ndarray, search: Search, count: int, deepest: float) -> int:
    """Keep of the `count` triangles that are listed those with a side that one of eight edges may cross.

    Returns how many. In `search.meets` are then the bits of three sides, see `_of_side`: none of one that leads back,
    which is asked for in the triangle that it leads to.
    """
    kept = 0
    for near in range(count):
        across = 0
        for side in range(3):
            other_edge = surface.sides[search.listed[near], side]
            if other_edge >= 0:
                bits = search.meets[near] & bits_across(segments, _ridge_of(surface, other_edge), deepest)
                across |= bits << (LANES * side)
        search.listed[kept], search.meets[kept] = search.listed[near], across
        kept += across != 0
    return kept


@jit_lean
def _of_side(bits: int, side: int) -> int:
    """Return the eight bits that are about one side of a triangle."""
    return (bits >> (LANES * side)) & ((1 << LANES) - 1)


@jit_lean
def _starts_inside(one: Surface, edge: int, memory: Memory) -> bool:
    return memory.found.outcode[one.ridges[edge, 0]] == INSIDE


@jit_lean
def _ends_inside(one: Surface, edge: int, memory: Memory) -> bool:
    return memory.found.outcode[one.ridges[edge, 1]] == INSIDE


@jit_lean
def _ridge_of(surface: Surface, edge: int) -> Ridge:
    points, ridges = surface.vertices.position, surface.ridges
    return Ridge(
        load(points, ridges[edge, 0]),
        load(points, ridges[edge, 1]),
        load(points, ridges[edge, 2]),
        load(points, ridges[edge, 3]),
    )


@jit_lean
def _goes_under(one: Surface, edge: int, crossing: Crossing, lane: int, memory: Memory) -> bool:
    """Tell whether an edge is inside where it crosses another, or next to that: by SLACK of how deep it is."""
    points, ridges = one.vertices.position, one.ridges
    near = SLACK * crossing.depth / norm(sub(load(points, ridges[edge, 1]), load(points, ridges[edge, 0])))
    is_inside = False
    for step in range(-1, 2):
        place = min(1.0, max(0.0, crossing.place + step * near))
        is_inside = is_inside or _is_inside(one, edge, place, lane, memory)
    return is_inside


@jit_lean
def _is_inside(one: Surface, edge: int, place: float, lane: int, memory: Memory) -> bool:
    """Tell whether an edge, whose hits are in a `lane`, is inside at a `place`, 0 … 1."""
    inside = _starts_inside(one, edge, memory)
    for k in range(memory.entered.hits[lane]):
        inside ^= memory.entered.place[lane, k] < place
    return inside


@jit_lean
def _add_crossing(
    one: tuple[Surface, int], other: tuple[Surface, int], crossing: Crossing, material: Material, contacts: Listing
) -> None:
    """Add the contact of two edges, each a row of its surface's."""
    (surface, edge), (other_surface, other_edge), (depth, normal, place, other_place, on_left) = one, other, crossing
    i, j = surface.ridges[edge, 0], surface.ridges[edge, 1]
    first, ridges = other_surface.first, other_surface.ridges
    u, v, third = ridges[other_edge, 0], ridges[other_edge, 1], ridges[other_edge, 2 if on_left else 3]
    points = surface.vertices.position
    point = half_way(point_between(load(points, i), load(points, j), place), depth, normal)
    a = soft_side(on_edge(surface.first + i, surface.first + j, place))
    b = soft_side(SurfacePoint((first + u, first + v, first + third), (1.0 - other_place, other_place, 0.0)))
    add_contact(contacts, a, b, Touch(point, normal, depth, 0), material)
