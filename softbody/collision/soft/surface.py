"""What it takes to ask what is inside soft bodies: a BVH for each surface, and memory for the answers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.soft.soft_response import Response, response_memory
from softbody.compiler.jit import jit, jit_inlined
from softbody.compiler.parts import END, FIRST, odd_lines, part_of, room_for, spans_of
from softbody.compiler.simd import LANES
from softbody.geometry.bvh import BVH, Search, build_bvh, search_space
from softbody.geometry.edges import edges_of_sides
from softbody.geometry.penetration import Penetrations, Points, room_for_penetrations
from softbody.geometry.segments import ROWS
from softbody.linalg.vec import load
from softbody.mesh.mesh import unique_edges
from softbody.model.arrays import Model, State

NONE = -1  # no triangle, beyond a border


class Surface(NamedTuple):
    """One soft body as what may be inside another; its vertices are numbered from 0."""

    first: int  # number of its first particle
    ridges: (
        np.ndarray
    )  # (e, 4) int32: ends of each edge, i < j, third corners of the triangles with sides (i, j), (j, i)
    wings: np.ndarray  # (e, 2) int32: these triangles
    triangles: np.ndarray  # (t, 3) vertices
    sides: np.ndarray  # (t, 3) int32: edge from each corner of a triangle to the next, or −1 − the edge that leads back
    touching: np.ndarray  # (n,) int32: a triangle of each vertex
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
    whole: np.ndarray  # int64: TRIANGLES, LEVEL_START and LEVEL_COUNT of each kind, which `Surface` and `BVH` explain
    short: np.ndarray  # int32: its ORDER, RIDGES, WINGS, SIDES and TOUCHING
    places: np.ndarray  # uint32: its PLACES
    spans: np.ndarray  # (kinds, 9, 2) see `softbody.compiler.parts`


TRIANGLES, ORDER, PLACES, LEVEL_START, LEVEL_COUNT, RIDGES, WINGS, SIDES, TOUCHING = range(9)  # parts of Shapes


class ThreadScratch(NamedTuple):
    """Memory of as many threads, a row each, with room for the largest surface: one is asked at a time.

    `surface_of`, `tree_at` and `memory_at` make views of its parts.
    """

    reals: np.ndarray  # (threads, …) float64
    singles: np.ndarray  # (threads, …) float32
    whole: np.ndarray  # (threads, …) int64
    short: np.ndarray  # (threads, …) int32
    codes: np.ndarray  # (threads, …) uint8
    spans: np.ndarray  # (parts, 2) of each row, see `softbody.compiler.parts`


# Parts of ThreadScratch: what follows a surface as it moves, see `BVH`; hints of all particles, see `Points`; then what
# `memory_at` makes a `Memory` of, in its order.
TREE_CORNERS, TREE_BOXES, TREE_FRAME, HINT = range(4)
SEARCH_NODE, SEARCH_BOUND, SEARCH_NEAR, SEARCH_SQUARE = range(4, 8)
SEARCH_ASKED, SEARCH_POINT, SEARCH_LISTED, SEARCH_MEETS = range(8, 12)
FOUND_POINT, FOUND_TRIANGLE, FOUND_WEIGHTS, FOUND_DEPTH, FOUND_OUTCODE = range(12, 17)
EDGE = 17
TRIED_EDGE, TRIED_SEGMENTS, TRIED_HITS, TRIED_PLACE = range(18, 22)
ENTERED_EDGE, ENTERED_SEGMENTS, ENTERED_HITS, ENTERED_PLACE = range(22, 26)
WAY_OUT, BOX_CORNERS, BOX_HINT = range(26, 29)


class Surfaces(NamedTuple):
    """What finds the contacts of soft bodies, and what else their response remembers."""

    shapes: Shapes
    scratch: ThreadScratch
    threads: int | None  # None: one thread, for which nothing but the plain loop needs to be compiled
    with_boxes: bool | None  # None: there are none, and nothing that touches them needs to be compiled
    response: Response
    deepest: np.ndarray  # (1,) [m] of all contacts since it was last set to 0
    deepest_sides: np.ndarray  # (2, 2) box and particle, or NOBODY, on both sides of that contact


def build_surfaces(model: Model, position: np.ndarray, threads: int = 1) -> Surfaces:
    """Return the surfaces of all soft bodies of a model whose particles are at `position` (n, 3) [m]."""
    # The first kind is nobody's, and none of its tables is kept: it is the largest where there are no bodies.
    nobody = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    kinds = [_kind_of(np.eye(4, 3), nobody, unique_edges(nobody))]
    known, kind = dict[bytes, int](), np.empty(model.soft_count, np.int64)
    for body in range(model.soft_count):
        first, end = model.soft_particle_start[body : body + 2]
        triangles = model.triangle_particles[slice(*model.soft_triangle_start[body : body + 2])] - first
        kind[body] = known.setdefault(triangles.tobytes(), len(known))
        if len(known) == len(kinds):
            edges = model.edge_particles[slice(*model.soft_edge_start[body : body + 2])] - first
            kinds.append(_kind_of(position[first:end], triangles, edges))
    low, high = np.zeros((2, model.soft_count, 3))
    return Surfaces(
        Shapes(
            kind,
            np.zeros((model.soft_count + model.box_count, 3)),
            np.zeros(model.soft_count + model.box_count),
            low,
            high,
            *_tables_of([tables for _, tables in kinds[1:]]),
        ),
        _scratch(max((tree for tree, _ in kinds), key=lambda tree: len(tree.order)), model, threads),
        None if threads == 1 else threads,
        None if model.box_count == 0 else True,
        response=response_memory(model.soft_particle_start, model.box_count),
        deepest=np.zeros(1),
        deepest_sides=np.zeros((2, 2), np.int64),
    )


def _tables_of(kinds: list[tuple[np.ndarray, ...]]) -> list[np.ndarray]:
    """Return what `_kind_of` says of all kinds, as the last four fields of `Shapes`."""
    taken = {np.dtype(kind): 0 for kind in (np.int64, np.int32, np.uint32)}
    spans = np.array([spans_of(tables, taken) for tables in kinds], np.int64).reshape(-1, 9, 2)
    rows = {kind: room_for((size,), kind) for kind, size in taken.items()}
    for tables, places in zip(kinds, spans, strict=True):
        for table, (first, end) in zip(tables, places, strict=True):
            rows[table.dtype][first:end] = table.ravel()
    return [*rows.values(), spans]


def _scratch(largest: BVH, model: Model, threads: int) -> ThreadScratch:
    """Return room for as many threads to ask a surface with the `largest` tree what of any other is inside."""
    most = int(np.diff(model.soft_particle_start).max(initial=8))
    edges = int(np.diff(model.soft_edge_start).max(initial=0))
    parts = (
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
    taken = {np.dtype(kind): 0 for kind in (np.float64, np.float32, np.int64, np.int32, np.uint8)}
    spans = spans_of(parts, taken)
    rows = [room_for((threads, odd_lines(size, kind)), kind) for kind, size in taken.items()]
    scratch = ThreadScratch(*[*rows, spans])
    for hint in (HINT, BOX_HINT):
        scratch.short[:, slice(*spans[hint])] = -1
    return scratch


def _room_for_eight(most: int) -> Eight:
    """Return room for eight edges that go through `most` triangles each."""
    return Eight(np.empty(LANES, np.int64), np.empty((ROWS, LANES)), np.empty(LANES, np.int64), np.empty((LANES, most)))


def _kind_of(vertices: np.ndarray, triangles: np.ndarray, edges: np.ndarray) -> tuple[BVH, tuple[np.ndarray, ...]]:
    """Return the BVH of a mesh, and its rows in `Shapes`; `edges` (e, 2) are those of `unique_edges`.

    Beyond a border there is triangle −1, and the corner of an edge there is the other one. Around a vertex on the
    border, the triangle that touches it is that beyond whose sides, one after the other, are all others.
    """
    sides = _sides_of(len(vertices), triangles, edges, edges_of_sides(triangles, edges, len(vertices)))
    tree = build_bvh(vertices, triangles)
    of_tree = tree.triangles, tree.order, tree.places, tree.level_start, tree.level_count
    return tree, (*of_tree, *sides)


@jit
def _sides_of(
    count: int, triangles: np.ndarray, edges: np.ndarray, edge: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return RIDGES, WINGS, SIDES and TOUCHING of `_kind_of`; `edge` (t, 3) from each corner to the next."""
    ridges, wings = np.full((len(edges), 4), NONE, np.int32), np.full((len(edges), 2), NONE, np.int32)
    sides, touching = np.empty(triangles.shape, np.int32), np.zeros(count, np.int32)
    for t in range(triangles.shape[0]):
        for c in range(3):
            e, i = edge[t, c], triangles[t, c]
            leads_back = 1 if i > triangles[t, (c + 1) % 3] else 0
            sides[t, c] = -1 - e if leads_back else e
            wings[e, leads_back] = touching[i] = t
            ridges[e, leads_back] = i
            ridges[e, 1 - leads_back] = triangles[t, (c + 1) % 3]
            ridges[e, 2 + leads_back] = triangles[t, (c + 2) % 3]
    for t in range(triangles.shape[0]):
        for c in range(3):
            if min(wings[edge[t, c], 0], wings[edge[t, c], 1]) == NONE:
                touching[triangles[t, (c + 1) % 3]] = t
    for e in range(len(edges)):
        for beyond, within in (2, 3), (3, 2):
            if ridges[e, beyond] == NONE:
                ridges[e, beyond] = ridges[e, within]
    return ridges, wings, sides, touching


@jit_inlined
def surface_of(model: Model, state: State, shapes: Shapes, scratch: ThreadScratch, thread: int, body: int) -> Surface:
    """Return one surface, its bounds as they are noted, and hints of one thread."""
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    spans, bounds = shapes.spans[shapes.kind[body]], (load(shapes.low, body), load(shapes.high, body))
    hint = part_of(scratch.short[thread], scratch.spans, HINT, ())
    return Surface(
        first,
        part_of(shapes.short, spans, RIDGES, (4,)),
        part_of(shapes.short, spans, WINGS, (2,)),
        part_of(shapes.whole, spans, TRIANGLES, (3,)),
        part_of(shapes.short, spans, SIDES, (3,)),
        part_of(shapes.short, spans, TOUCHING, ()),
        Points(state.particle_position[first:end], bounds, hint[first:end]),
    )


@jit_inlined
def tree_at(shapes: Shapes, scratch: ThreadScratch, thread: int, body: int) -> BVH:
    """Return the BVH of one body for a thread; fit it before it is asked, and before another one is fitted there."""
    spans, reals = shapes.spans[shapes.kind[body]], scratch.reals[thread]
    order = part_of(shapes.short, spans, ORDER, ())
    return BVH(
        part_of(shapes.whole, spans, TRIANGLES, (3,)),
        order,
        part_of(shapes.places, spans, PLACES, (3, LANES)),
        part_of(reals, scratch.spans, TREE_CORNERS, (9, LANES))[: order.shape[0] // LANES],
        part_of(shapes.whole, spans, LEVEL_START, ()),
        part_of(shapes.whole, spans, LEVEL_COUNT, ()),
        part_of(scratch.singles[thread], scratch.spans, TREE_BOXES, (6, LANES)),
        part_of(reals, scratch.spans, TREE_FRAME, ()),
    )


@jit_inlined
def memory_at(scratch: ThreadScratch, thread: int) -> Memory:
    """Return the memory of one thread."""
    reals, singles, whole, short = (
        scratch.reals[thread],
        scratch.singles[thread],
        scratch.whole[thread],
        scratch.short[thread],
    )
    spans, no_bounds = scratch.spans, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    most_hits = spans[SEARCH_LISTED, END] - spans[SEARCH_LISTED, FIRST]  # an edge may go through all triangles
    return Memory(
        Search(
            part_of(whole, spans, SEARCH_NODE, ()),
            part_of(reals, spans, SEARCH_BOUND, ()),
            part_of(singles, spans, SEARCH_NEAR, ()),
            part_of(reals, spans, SEARCH_SQUARE, ()),
            part_of(singles, spans, SEARCH_ASKED, (LANES,)),
            part_of(whole, spans, SEARCH_POINT, ()),
            part_of(whole, spans, SEARCH_LISTED, ()),
            part_of(whole, spans, SEARCH_MEETS, ()),
        ),
        Penetrations(
            part_of(whole, spans, FOUND_POINT, ()),
            part_of(whole, spans, FOUND_TRIANGLE, ()),
            part_of(reals, spans, FOUND_WEIGHTS, (3,)),
            part_of(reals, spans, FOUND_DEPTH, ()),
            part_of(scratch.codes[thread], spans, FOUND_OUTCODE, ()),
        ),
        part_of(whole, spans, EDGE, ()),
        Eight(
            part_of(whole, spans, TRIED_EDGE, ()),
            part_of(reals, spans, TRIED_SEGMENTS, (LANES,)),
            part_of(whole, spans, TRIED_HITS, ()),
            part_of(reals, spans, TRIED_PLACE, (most_hits,)),
        ),
        Eight(
            part_of(whole, spans, ENTERED_EDGE, ()),
            part_of(reals, spans, ENTERED_SEGMENTS, (LANES,)),
            part_of(whole, spans, ENTERED_HITS, ()),
            part_of(reals, spans, ENTERED_PLACE, (most_hits,)),
        ),
        part_of(reals, spans, WAY_OUT, (3,)),
        Points(part_of(reals, spans, BOX_CORNERS, (3,)), no_bounds, part_of(short, spans, BOX_HINT, ())),
    )
