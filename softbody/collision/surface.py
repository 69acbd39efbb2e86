"""What it takes to ask what is inside soft bodies: a BVH for each surface, and memory for the answers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.geometry.bvh import BVH, Search, build_bvh, search_space
from softbody.geometry.penetration import Penetrations, Points, room_for_penetrations
from softbody.jit import jit_inlined
from softbody.lanes import LANES
from softbody.mesh import unique_edges
from softbody.state import Model, State
from softbody.vec import load


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


class Topology(NamedTuple):
    """What of a kind of surface never changes, or of all kinds, one after another: see `Surface`."""

    ridges: np.ndarray
    wings: np.ndarray
    sides: np.ndarray


class Solid(NamedTuple):
    """One soft body as what another may be inside of."""

    surface: Surface
    tree: BVH


class Memory(NamedTuple):
    """Working memory of one query, of one body after another."""

    search: Search
    found: Penetrations
    edge: np.ndarray  # (most edges of a body + 1,) see `candidate_edges`
    ends: np.ndarray  # (8, 2, 3) see `segment_hits`
    hits: np.ndarray  # (8,)
    place: np.ndarray  # (8, most triangles of a body)
    way_out: (
        np.ndarray
    )  # (most vertices of a body, 3) unit vector out of the other body, of those that are inside; or 0


class Surfaces(NamedTuple):
    """What finds the contacts of soft bodies: the BVHs of all kinds of surfaces, one after another, and memory.

    What follows a surface as it moves (corners, boxes, frame) has room for the largest: one surface is asked at a time.
    """

    trees: BVH
    kind: np.ndarray  # (b,) of each body's mesh: bodies whose triangles are the same share what does not move
    start: np.ndarray  # (kinds + 1, fields of a BVH) first row of each kind in each of its arrays
    topology: Topology
    topology_start: np.ndarray  # (kinds + 1, fields of a Topology)
    low: np.ndarray  # (b, 3) [m] corner of the bounding box of each body
    high: np.ndarray  # (b, 3) [m]
    hint: np.ndarray  # (n,) see `Points`
    corners: np.ndarray  # (8, 3) [m] of the box that is asked
    corner_hint: np.ndarray  # (8,)
    memory: Memory
    weight_sum: np.ndarray  # (n,) see `resolve_contacts`
    deepest: np.ndarray  # (1,) [m] of all contacts since it was last set to 0
    deepest_pair: np.ndarray  # (2,) the bodies of that contact, boxes numbered after soft bodies


def build_surfaces(model: Model, position: np.ndarray) -> Surfaces:
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
    trees = [tree for tree, _ in kinds]
    (joined, start), (topology, topology_start) = _joined(trees), _joined([topology for _, topology in kinds])
    largest = max(trees, key=lambda tree: len(tree.order))
    most = int(np.diff(model.soft_particle_start).max(initial=8))
    return Surfaces(
        trees=BVH(*joined)._replace(corners=largest.corners, boxes=largest.boxes, frame=largest.frame),
        kind=kind,
        start=start,
        topology=Topology(*topology),
        topology_start=topology_start,
        low=np.zeros((model.soft_count, 3)),
        high=np.zeros((model.soft_count, 3)),
        hint=np.full(len(position), -1),
        corners=np.zeros((8, 3)),
        corner_hint=np.full(8, -1),
        memory=Memory(
            search_space(largest),
            room_for_penetrations(most),
            np.zeros(int(np.diff(model.soft_edge_start).max(initial=0)) + 1, np.int64),
            np.zeros((LANES, 2, 3)),
            np.zeros(LANES, np.int64),
            np.zeros((LANES, int(np.diff(model.soft_triangle_start).max(initial=0)))),
            np.zeros((most, 3)),
        ),
        weight_sum=np.zeros(len(position)),
        deepest=np.zeros(1),
        deepest_pair=np.zeros(2, np.int64),
    )


def _joined(parts: list[BVH] | list[Topology]) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the rows of all parts but the first, one after another, and where each starts: (parts, fields)."""
    lengths = [[0] * len(parts[0]), *([len(rows) for rows in part] for part in parts[1:])]
    rows = [np.concatenate([rows[0][:0], *rows[1:]]) for rows in zip(*parts, strict=True)]
    return rows, np.cumsum(lengths, axis=0)


def _kind_of(vertices: np.ndarray, triangles: np.ndarray) -> tuple[BVH, Topology]:
    """Return the BVH and the topology of a closed mesh; edges are in the order of `unique_edges`."""
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
    return build_bvh(vertices, triangles), Topology(ridges, wings, sides)


@jit_inlined
def surface_of(model: Model, state: State, surfaces: Surfaces, body: int) -> Surface:
    """Return one surface, its bounds as they are noted."""
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    kind = surfaces.kind[body]
    topology, one, last = surfaces.topology, surfaces.topology_start[kind], surfaces.topology_start[kind + 1]
    bounds = load(surfaces.low, body), load(surfaces.high, body)
    return Surface(
        first,
        topology.ridges[one[0] : last[0]],
        topology.wings[one[1] : last[1]],
        surfaces.trees.triangles[surfaces.start[kind, 0] : surfaces.start[kind + 1, 0]],
        topology.sides[one[2] : last[2]],
        Points(state.particle_position[first:end], bounds, surfaces.hint[first:end]),
    )


@jit_inlined
def tree_of(surfaces: Surfaces, body: int) -> BVH:
    """Return the BVH of one body; fit it before it is asked, and before another one is fitted."""
    trees, kind = surfaces.trees, surfaces.kind[body]
    first, end = surfaces.start[kind], surfaces.start[kind + 1]
    return BVH(
        trees.triangles[first[0] : end[0]],
        trees.order[first[1] : end[1]],
        trees.corners[: end[2] - first[2]],
        trees.level_start[first[3] : end[3]],
        trees.level_count[first[4] : end[4]],
        trees.boxes,
        trees.frame,
    )
