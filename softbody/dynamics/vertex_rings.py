"""Vertex rings, which the fast kernels read: the particles' order in memory, and who surrounds each."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from softbody.compiler.jit import jit
from softbody.compiler.simd import LANES
from softbody.geometry.borders import border_of, holes_of
from softbody.geometry.edges import rows_of_edges
from softbody.model.arrays import DEGREE, END, ENTRY, FIRST, STIFFNESS, VertexRings, has_border

# Particles whose neighbours are grouped by degree together: 2 048 of them and all that their step needs are some
# 0.4 MB, which stays in a core's second-level cache from the force to the update.
WINDOW = 2048

# The most particles of a block: small enough to share out among threads evenly, large enough that a block's call
# costs nothing.
BLOCK = 256


def no_rings() -> VertexRings:
    """Return the rings of no bodies at all."""
    return VertexRings(
        particle=np.empty(0, np.uint32),
        number=np.empty(0, np.uint32),
        start=np.zeros(1, np.int64),
        block=np.empty((0, 7), np.int64),
        block_start=np.zeros(1, np.int64),
        edge=np.empty(0, np.uint32),
        neighbour=np.empty(0, np.uint32),
        rest_tension=np.empty(0),
        next_neighbour=np.empty(0, np.uint32),
        stiffness=np.empty(0),
        common_stiffness=np.empty(0),
        border=np.empty(0, np.int64),
        hole=np.empty((0, 2), np.int64),
        hole_start=np.zeros(1, np.int64),
    )


def build_rings(
    count: int, edges: np.ndarray, triangles: np.ndarray, rest_length: np.ndarray, stiffness: np.ndarray
) -> VertexRings:
    """Return the rings of one body of `count` particles, whose rows and edges are numbered from 0.

    `edges` (e, 2) as of Mesh.edges, `triangles` (t, 3), `rest_length` (e,) [m], `stiffness` (e,) [N/m]. The order is
    breadth-first over the mesh (Cuthill and McKee 1969), so that neighbours lie near each other in memory, and then
    by degree within windows of it.
    """
    # A copy: for the read-only triangles of a Mesh the kernel would be compiled once more.
    triangles = triangles.copy()
    ring_start, ring, after, is_cycle = one_rings(count, triangles)
    border, holes = holes_of(count, triangles) if has_border(len(edges), len(triangles)) else NO_HOLES
    degree = np.diff(ring_start)
    order = breadth_first_order(ring_start, ring)
    # A particle where several fans of triangles meet goes to blocks of its own: its entries are not one cycle.
    kind = 2 * degree + ~is_cycle
    order = order[np.lexsort((kind[order], np.arange(count) // WINDOW))]

    new_block = np.ones(count, bool)
    new_block[1:] = (np.diff(kind[order]) != 0) | (np.arange(1, count) % BLOCK == 0)
    first = np.flatnonzero(new_block)
    number = np.diff(first, append=count)
    # Each block begins at whole lanes; an index counts its twins.
    end = np.cumsum(-(-number // LANES) * LANES)
    begin = np.append(0, end[:-1])
    index = np.empty(count, np.int64)
    index[order] = np.arange(count) + np.repeat(begin - first, number)

    # A block begins with the particle of each index, of which the twins are the last.
    inside = np.arange(end[-1]) - np.repeat(begin, end - begin)
    particle = order[np.repeat(first, end - begin) + np.minimum(inside, np.repeat(number - 1, end - begin))]
    blocks, entries, nexts, behind, offset = [], [], [], 0, 0
    for k, rows in enumerate(np.split(particle, end[:-1])):
        size, cycle = int(degree[rows[0]]), is_cycle[rows[0]]
        entry = (ring_start[rows] + np.arange(size)[:, None]).ravel()
        blocks.append((begin[k], end[k], number[k], size, offset, -1 if cycle else behind, -1))
        entries.append(entry)
        offset += entry.size
        if not cycle:
            nexts.append(index[after[entry]])
            behind += entry.size
    entry = np.concatenate(entries)
    there = ring[entry]
    edge = rows_of_edges(edges, count, np.repeat(np.arange(count), degree)[entry], there)
    return with_springs(
        no_rings()._replace(
            particle=particle.astype(np.uint32),
            number=(3 * particle).astype(np.uint32),
            start=np.array([0, end[-1]]),
            block=np.array(blocks, np.int64),
            block_start=np.array([0, len(blocks)]),
            edge=edge.astype(np.uint32),
            neighbour=index[there].astype(np.uint32),
            next_neighbour=np.concatenate([np.empty(0, np.int64), *nexts]).astype(np.uint32),
            border=index[border],
            hole=holes,
            hole_start=np.array([0, len(holes)]),
        ),
        rest_length,
        stiffness,
        np.array([0, len(edges)]),
    )


def with_springs(
    rings: VertexRings, rest_length: np.ndarray, stiffness: np.ndarray, edge_start: np.ndarray
) -> VertexRings:
    """Return `rings` with other springs, in their precision.

    `rest_length` (e,) [m], `stiffness` (e,) [N/m], `edge_start` (b + 1,).
    """
    common = [stiffness[a] if (stiffness[a:b] == stiffness[a]).all() else np.nan for a, b in pairwise(edge_start)]
    block, differ = rings.block.copy(), [np.empty(0)]
    block[:, STIFFNESS] = -1
    for body in np.flatnonzero(np.isnan(common)):
        own = slice(*rings.block_start[body : body + 2])
        entry = block[own, ENTRY]
        end = entry[-1] + block[own][-1, DEGREE] * (block[own][-1, END] - block[own][-1, FIRST])
        block[own, STIFFNESS] = entry - entry[0] + sum(map(len, differ))
        differ.append(stiffness[rings.edge[entry[0] : end]])
    changed = rings._replace(
        block=block,
        rest_tension=(stiffness * rest_length)[rings.edge],
        stiffness=np.concatenate(differ),
        common_stiffness=np.array(common),
    )
    return in_precision(changed, rings.rest_tension.dtype.type)


NO_HOLES = np.empty(0, np.int64), np.empty((0, 2), np.int64)


@jit
def one_rings(count: int, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return (start, ring, after, is_cycle): the neighbours of each of `count` vertices, counter-clockwise.

    Vertex i has ring[start[i] : start[i + 1]], and after each of them comes `after`, which closes with the first.
    Where several fans of triangles meet in a vertex, one is listed after the other, and `is_cycle` (count,) is
    False. So it is where the fan is open, whose neighbours have no order: after the last of them comes itself, so that
    both make no triangle. `triangles` (t, 3), of which one fan at most that is open meets in a vertex.
    """
    start = np.zeros(count + 1, np.int64)
    beyond, before = border_of(count, triangles)
    for t in range(triangles.shape[0]):
        for c in range(3):
            start[triangles[t, c] + 1] += 1
    for i in range(count):
        start[i + 1] += start[i] + (beyond[i] >= 0)
    ring = np.empty(start[count], np.int64)
    after = np.empty(start[count], np.int64)
    filled = np.zeros(count, np.int64)
    for t in range(triangles.shape[0]):
        for c in range(3):
            i = triangles[t, c]
            entry = start[i] + filled[i]
            ring[entry] = triangles[t, (c + 1) % 3]
            after[entry] = triangles[t, (c + 2) % 3]
            filled[i] += 1
    is_cycle = np.ones(count, np.bool_)
    entry_of = np.zeros(count, np.int64)  # of each neighbour of the vertex at hand: a search takes d² of d neighbours
    for i in range(count):
        if beyond[i] >= 0:
            ring[start[i + 1] - 1] = after[start[i + 1] - 1] = before[i]
            is_cycle[i] = False
            continue
        for e in range(start[i], start[i + 1]):
            entry_of[ring[e]] = e
        fan = ring[start[i]]
        for e in range(start[i], start[i + 1] - 1):
            wanted = after[e]
            if wanted == fan:  # this fan has closed, and there is another
                is_cycle[i] = False
                fan = ring[e + 1]
                continue
            other = entry_of[wanted]
            entry_of[ring[e + 1]] = other
            ring[other], ring[e + 1] = ring[e + 1], ring[other]
            after[other], after[e + 1] = after[e + 1], after[other]
    return start, ring, after, is_cycle


@jit
def breadth_first_order(start: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Return all vertices (n,), each part of the mesh from one of its ends, neighbours after neighbours.

    `start` (n + 1,) and `ring` as of one_rings.
    """
    count = start.shape[0] - 1
    order = np.empty(count, np.int64)
    seen = np.zeros(count, np.int64)  # the round in which each vertex was met
    placed = 0
    for root in range(count):
        if seen[root] == 0:
            end = _spread(root, 1, (start, ring), order, placed, seen)
            # Once more from the vertex that was met last: that is far out, and the fronts are short.
            placed = _spread(order[end - 1], 2, (start, ring), order, placed, seen)
    return order


@jit
def _spread(
    root: int, mark: int, adjacency: tuple[np.ndarray, np.ndarray], order: np.ndarray, placed: int, seen: np.ndarray
) -> int:
    """List in `order`, from `placed` on, all that hangs together with `root`; return where it ends."""
    start, ring = adjacency
    order[placed] = root
    seen[root] = mark
    end = placed + 1
    head = placed
    while head < end:
        for e in range(start[order[head]], start[order[head] + 1]):
            if seen[ring[e]] < mark:
                seen[ring[e]] = mark
                order[end] = ring[e]
                end += 1
        head += 1
    return end


def in_precision(rings: VertexRings, real: type[np.floating[Any]]) -> VertexRings:
    """Return `rings` with springs in the precision `real`, np.float64 or np.float32."""
    return rings._replace(
        stiffness=rings.stiffness.astype(real, copy=False),
        rest_tension=rings.rest_tension.astype(real, copy=False),
        common_stiffness=rings.common_stiffness.astype(real, copy=False),
    )
