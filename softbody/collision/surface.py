"""What it takes to ask what is inside soft bodies: a BVH for each surface, and memory for the answers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.geometry.bvh import BVH, Search, build_bvh, search_space
from softbody.geometry.penetration import Penetrations, Points, room_for_penetrations
from softbody.jit import jit_inlined, jit_lean
from softbody.state import Model, State
from softbody.vec import load


class Surface(NamedTuple):
    """One soft body as what may be inside another."""

    first: int  # number of its first particle
    edges: np.ndarray  # (e, 2) particles
    wings: np.ndarray  # (e, 2) triangles on both sides: that with the side (i, j) of an edge, and that with (j, i)
    triangles: np.ndarray  # (t, 3) vertices
    sides: np.ndarray  # (t, 3) edge from each corner of a triangle to the next
    vertices: Points


class Solid(NamedTuple):
    """One soft body as what another may be inside of."""

    surface: Surface
    tree: BVH


class Memory(NamedTuple):
    """Working memory of one query, of one body after another."""

    search: Search
    found: Penetrations
    edge: np.ndarray  # (most edges of a body + 1,) see `candidate_edges`
    places: np.ndarray  # (most triangles of a body,) see `segment_hits`
    way_out: (
        np.ndarray
    )  # (most vertices of a body, 3) unit vector out of the other body, of those that are inside; or 0


class Surfaces(NamedTuple):
    """What finds the contacts of soft bodies: the BVHs of all surfaces, one body's rows after another's, and memory.

    What follows a surface as it moves (corners, boxes, frame) has room for the largest: one surface is asked at a time.
    """

    trees: BVH
    start: np.ndarray  # (b + 1, fields of a BVH) first row of each body in each of its arrays
    wings: np.ndarray  # (e, 2) see `Surface`
    sides: np.ndarray  # (t, 3) see `Surface`
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
    # Of the first mesh no row is kept: it tells what arrays look like where there are no bodies.
    meshes = [(np.eye(4, 3), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))]
    neighbours = [(np.empty((0, 2), np.int64), np.empty((0, 3), np.int64))]
    for body in range(model.soft_count):
        first, end = model.soft_particle_start[body : body + 2]
        rows, edges = slice(*model.soft_triangle_start[body : body + 2]), slice(*model.soft_edge_start[body : body + 2])
        triangles = model.triangle_particles[rows] - first
        meshes.append((position[first:end], triangles))
        neighbours.append(_wings_and_sides(model.edge_particles[edges] - first, triangles))
    trees = [build_bvh(*mesh) for mesh in meshes]
    joined = BVH(*(np.concatenate([rows[0][:0], *rows[1:]]) for rows in zip(*trees, strict=True)))
    lengths = [[len(rows) for rows in tree] for tree in trees]
    lengths[0] = [0] * len(joined)
    largest = max(trees, key=lambda tree: len(tree.order))
    most = int(np.diff(model.soft_particle_start).max(initial=8))
    return Surfaces(
        trees=joined._replace(corners=largest.corners, boxes=largest.boxes, frame=largest.frame),
        start=np.cumsum(lengths, axis=0),
        wings=np.concatenate([wings for wings, _ in neighbours]),
        sides=np.concatenate([sides for _, sides in neighbours]),
        low=np.zeros((model.soft_count, 3)),
        high=np.zeros((model.soft_count, 3)),
        hint=np.full(len(position), -1),
        corners=np.zeros((8, 3)),
        corner_hint=np.full(8, -1),
        memory=Memory(
            search_space(largest),
            room_for_penetrations(most),
            np.zeros(int(np.diff(model.soft_edge_start).max(initial=0)) + 1, np.int64),
            np.zeros(int(np.diff(model.soft_triangle_start).max(initial=0))),
            np.zeros((most, 3)),
        ),
        weight_sum=np.zeros(len(position)),
        deepest=np.zeros(1),
        deepest_pair=np.zeros(2, np.int64),
    )


def _wings_and_sides(edges: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (wings (e, 2), sides (t, 3)) of a closed mesh whose `edges` (e, 2) are as `unique_edges` returns them."""
    start, end = triangles, np.roll(triangles, -1, axis=1)
    rows = np.array([triangles.max() + 1, 1])
    sides = np.searchsorted(edges @ rows, np.stack([np.minimum(start, end), np.maximum(start, end)], axis=-1) @ rows)
    wings = np.empty_like(edges)
    wings[sides, (start > end).astype(np.int64)] = np.arange(len(triangles))[:, None]
    return wings, sides


@jit_inlined
def surface_of(model: Model, state: State, surfaces: Surfaces, body: int) -> Surface:
    """Return one surface, its bounds as they are noted."""
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    one, last = model.soft_edge_start[body], model.soft_edge_start[body + 1]
    low, high = model.soft_triangle_start[body], model.soft_triangle_start[body + 1]
    bounds = load(surfaces.low, body), load(surfaces.high, body)
    return Surface(
        first,
        model.edge_particles[one:last],
        surfaces.wings[one:last],
        surfaces.trees.triangles[low:high],
        surfaces.sides[low:high],
        Points(state.particle_position[first:end], bounds, surfaces.hint[first:end]),
    )


@jit_lean
def third_corner(surface: Surface, edge: int, wing: int) -> int:
    """Return the vertex that a triangle beside an edge has besides the edge's two."""
    triangle, first = surface.wings[edge, wing], surface.first
    corners = surface.triangles[triangle, 0] + surface.triangles[triangle, 1] + surface.triangles[triangle, 2]
    return corners - (surface.edges[edge, 0] - first) - (surface.edges[edge, 1] - first)


@jit_inlined
def tree_of(surfaces: Surfaces, body: int) -> BVH:
    """Return the BVH of one body; fit it before it is asked, and before another one is fitted."""
    trees, first, end = surfaces.trees, surfaces.start[body], surfaces.start[body + 1]
    return BVH(
        trees.triangles[first[0] : end[0]],
        trees.order[first[1] : end[1]],
        trees.corners[: end[2] - first[2]],
        trees.level_start[first[3] : end[3]],
        trees.level_count[first[4] : end[4]],
        trees.boxes,
        trees.frame,
    )
