"""What it takes to ask what is inside soft bodies: a BVH for each surface, and memory for the answers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit_inlined
from softbody.compiler.simd import LANES
from softbody.geometry.bvh import BVH, Search, build_bvh, search_space
from softbody.geometry.penetration import Penetrations, Points, room_for_penetrations
from softbody.geometry.segments import ROWS
from softbody.linalg.vec import load
from softbody.mesh.mesh import unique_edges
from softbody.model.arrays import Model, State


class Surface(NamedTuple):
    """One soft body as what may be inside another; its vertices are numbered from 0."""

    first: int  # number of its first particle
    ridges: (
        np.ndarray
    )  # (e, 4) int32: ends of each edge, i < j, third corners of the triangles with sides (i, j), (j, i)
    wings: np.ndarray  # (e, 2) int32: these triangles
    triangles: np.ndarray  # (t, 3) vertices
    sides: np.ndarray  # (t, 3) int32: edge from each corner of a triangle to the next, or −1 − the edge that leads back
    vertices: Points


class Solid(NamedTuple):
    """One soft body as what another may be inside of."""

    surface: Surface
    tree: BVH


class Eight(NamedTuple):
    """Eight edges of one body, side by side, and where each goes through the surface of another."""

    edge: np.ndarray  # (8,)
    segments: np.ndarray  # (9, 8) see `softbody.geometry.segments`
    hits: np.ndarray  # (8,)
    place: np.ndarray  # (8, most triangles of a body)


class Memory(NamedTuple):
    """Working memory of one query, of one body after another."""

    search: Search
    found: Penetrations
    edge: np.ndarray  # (most edges of a body + 1,) see `candidate_edges`
    tried: Eight  # edges that may go in
    entered: Eight  # those that do
    way_out: (
        np.ndarray
    )  # (most vertices of a body, 3) unit vector out of the other body, of those that are inside; or 0
    corners: Points  # of the box that is asked


class Shapes(NamedTuple):
    """What is known of all surfaces, whichever is asked: a row for each body, then rows of kinds, one after another.

    Bodies whose triangles are the same are of one kind: they share what does not move.
    """

    kind: np.ndarray  # (b,)
    centre: np.ndarray  # (b + m, 3) [m] of the bounding sphere of each body, and of each box, of this
    radius: np.ndarray  # (b + m,) [m]
    low: np.ndarray  # (b, 3) [m] corner of the bounding box of each body
    high: np.ndarray  # (b, 3) [m]
    start: (
        np.ndarray
    )  # (kinds + 1, 8) first row of each kind in each of the following, which `Surface` and `BVH` explain
    triangles: np.ndarray
    order: np.ndarray
    places: np.ndarray
    level_start: np.ndarray
    level_count: np.ndarray
    ridges: np.ndarray
    wings: np.ndarray
    sides: np.ndarray


class Desks(NamedTuple):
    """Memory of as many threads, each with room for the largest surface: one is asked at a time.

    First what follows that surface as it moves, see `BVH`; then hints; then what `memory_at` makes a `Memory` of.
    """

    corners: np.ndarray  # (threads, leaves, 9, 8)
    boxes: np.ndarray  # (threads, nodes, 6, 8)
    frame: np.ndarray  # (threads, 4)
    hint: np.ndarray  # (threads, n) int32, see `Points`
    node: np.ndarray
    bound: np.ndarray
    near: np.ndarray
    square: np.ndarray
    asked: np.ndarray
    point: np.ndarray
    listed: np.ndarray
    meets: np.ndarray
    inside: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    depth: np.ndarray
    outcode: np.ndarray
    edge: np.ndarray
    tried_edge: np.ndarray
    tried_segments: np.ndarray
    tried_hits: np.ndarray
    tried_place: np.ndarray
    entered_edge: np.ndarray
    entered_segments: np.ndarray
    entered_hits: np.ndarray
    entered_place: np.ndarray
    way_out: np.ndarray
    box_corners: np.ndarray
    box_hint: np.ndarray


class Surfaces(NamedTuple):
    """What finds the contacts of soft bodies, and what else their response remembers."""

    shapes: Shapes
    desks: Desks
    threads: int | None  # None: one thread, for which nothing but the plain loop needs to be compiled
    with_boxes: bool | None  # None: there are none, and nothing that touches them needs to be compiled
    weight_sum: np.ndarray  # (n,) see `resolve_contacts`
    deepest: np.ndarray  # (1,) [m] of all contacts since it was last set to 0
    deepest_sides: np.ndarray  # (2, 2) box and particle, or NOBODY, on both sides of that contact


def build_surfaces(model: Model, position: np.ndarray, threads: int = 1) -> Surfaces:
    """Return the surfaces of all soft bodies of a model whose particles are at `position` (n, 3) [m]."""
    # Of the first kind no row is kept: it tells what arrays look like where there are no bodies.
    kinds = [_kind_of(np.eye(4, 3), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))]
    known, kind = dict[bytes, int](), np.empty(model.soft_count, np.int64)
    for body in range(model.soft_count):
        first, end = model.soft_particle_start[body : body + 2]
        triangles = model.triangle_particles[slice(*model.soft_triangle_start[body : body + 2])] - first
        kind[body] = known.setdefault(triangles.tobytes(), len(known))
        if len(known) == len(kinds):
            kinds.append(_kind_of(position[first:end], triangles))
    lengths = [[0] * 8, *([len(rows) for rows in topology] for _, topology in kinds[1:])]
    low, high = np.zeros((2, model.soft_count, 3))
    return Surfaces(
        Shapes(
            kind,
            np.zeros((model.soft_count + model.box_count, 3)),
            np.zeros(model.soft_count + model.box_count),
            low,
            high,
            np.cumsum(lengths, axis=0),
            *(
                np.concatenate([rows[0][:0], *rows[1:]])
                for rows in zip(*(topology for _, topology in kinds), strict=True)
            ),
        ),
        _desks(max((tree for tree, _ in kinds), key=lambda tree: len(tree.order)), model, threads),
        None if threads == 1 else threads,
        None if model.box_count == 0 else True,
        weight_sum=np.zeros(len(position)),
        deepest=np.zeros(1),
        deepest_sides=np.zeros((2, 2), np.int64),
    )


def _desks(largest: BVH, model: Model, threads: int) -> Desks:
    """Return room for as many threads to ask a surface with the `largest` tree what of any other is inside."""
    most = int(np.diff(model.soft_particle_start).max(initial=8))
    edges = int(np.diff(model.soft_edge_start).max(initial=0))
    desk = (
        largest.corners,
        largest.boxes,
        largest.frame,
        np.empty(len(model.particle_inverse_mass), np.int32),
        *search_space(largest),
        *room_for_penetrations(most),
        np.empty(edges + 1, np.int64),
        *_room_for_eight(len(largest.order)),
        *_room_for_eight(len(largest.order)),
        np.empty((most, 3)),
        np.empty((8, 3)),
        np.empty(8, np.int32),
    )
    desks = Desks(*(np.zeros((threads, *rows.shape), rows.dtype) for rows in desk))
    desks.hint[:] = -1
    desks.box_hint[:] = -1
    return desks


def _room_for_eight(most: int) -> Eight:
    """Return room for eight edges that go through `most` triangles each."""
    return Eight(np.empty(LANES, np.int64), np.empty((ROWS, LANES)), np.empty(LANES, np.int64), np.empty((LANES, most)))


def _kind_of(vertices: np.ndarray, triangles: np.ndarray) -> tuple[BVH, tuple[np.ndarray, ...]]:
    """Return the BVH of a closed mesh, and its rows in `Shapes`; edges are in the order of `unique_edges`."""
    edges = unique_edges(triangles)
    start, end, third = (np.roll(triangles, -k, axis=1) for k in range(3))
    rows = np.array([len(vertices), 1])
    edge = np.searchsorted(edges @ rows, np.stack([np.minimum(start, end), np.maximum(start, end)], axis=-1) @ rows)
    leads_back = start > end
    wings, corners = np.empty((2, len(edges), 2), np.int32)
    wings[edge, leads_back.astype(int)] = np.arange(len(triangles))[:, None]
    corners[edge, leads_back.astype(int)] = third
    ridges = np.concatenate([edges, corners], axis=1).astype(np.int32)
    sides = np.where(leads_back, -1 - edge, edge).astype(np.int32)
    tree = build_bvh(vertices, triangles)
    return tree, (tree.triangles, tree.order, tree.places, tree.level_start, tree.level_count, ridges, wings, sides)


@jit_inlined
def surface_of(model: Model, state: State, shapes: Shapes, desks: Desks, desk: int, body: int) -> Surface:
    """Return one surface, its bounds as they are noted, and hints of one desk."""
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    one, last = shapes.start[shapes.kind[body]], shapes.start[shapes.kind[body] + 1]
    bounds = load(shapes.low, body), load(shapes.high, body)
    return Surface(
        first,
        shapes.ridges[one[5] : last[5]],
        shapes.wings[one[6] : last[6]],
        shapes.triangles[one[0] : last[0]],
        shapes.sides[one[7] : last[7]],
        Points(state.particle_position[first:end], bounds, desks.hint[desk, first:end]),
    )


@jit_inlined
def tree_at(shapes: Shapes, desks: Desks, desk: int, body: int) -> BVH:
    """Return the BVH of one body at a desk; fit it before it is asked, and before another one is fitted there."""
    one, last = shapes.start[shapes.kind[body]], shapes.start[shapes.kind[body] + 1]
    leaves = (last[1] - one[1]) // LANES
    return BVH(
        shapes.triangles[one[0] : last[0]],
        shapes.order[one[1] : last[1]],
        shapes.places[one[2] : last[2]],
        desks.corners[desk, :leaves],
        shapes.level_start[one[3] : last[3]],
        shapes.level_count[one[4] : last[4]],
        desks.boxes[desk],
        desks.frame[desk],
    )


@jit_inlined
def memory_at(desks: Desks, desk: int) -> Memory:
    """Return the memory of one desk."""
    no_bounds = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return Memory(
        Search(
            desks.node[desk],
            desks.bound[desk],
            desks.near[desk],
            desks.square[desk],
            desks.asked[desk],
            desks.point[desk],
            desks.listed[desk],
            desks.meets[desk],
        ),
        Penetrations(
            desks.inside[desk], desks.triangle[desk], desks.weights[desk], desks.depth[desk], desks.outcode[desk]
        ),
        desks.edge[desk],
        Eight(desks.tried_edge[desk], desks.tried_segments[desk], desks.tried_hits[desk], desks.tried_place[desk]),
        Eight(
            desks.entered_edge[desk], desks.entered_segments[desk], desks.entered_hits[desk], desks.entered_place[desk]
        ),
        desks.way_out[desk],
        Points(desks.box_corners[desk], no_bounds, desks.box_hint[desk]),
    )
