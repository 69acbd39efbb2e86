"""Connected parts of a closed mesh: triangles as shells, and the triangles around a vertex as fans.

Joined pair by pair (union–find, Tarjan 1975). The half-edge number k t + i is edge k of triangle i of t: it runs from
corner k to corner k + 1.
"""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit, jit_lean


@jit_lean
def root_of(parent: np.ndarray, i: int) -> int:
    """Return the number that stands for all that `i` is joined with, in a forest `parent` (n,)."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]  # the way is halved for those who come later
        i = parent[i]
    return i


@jit_lean
def join(parent: np.ndarray, i: int, j: int) -> None:
    """Join all that is joined with `i` and all that is with `j`; the lowest number stands for all."""
    a, b = root_of(parent, i), root_of(parent, j)
    parent[max(a, b)] = min(a, b)


@jit
def joined(count: int, pairs: np.ndarray) -> np.ndarray:
    """Return for each of `count` numbers the lowest that `pairs` (p, 2) join it with, (count,)."""
    parent = np.arange(count)
    for k in range(pairs.shape[0]):
        join(parent, pairs[k, 0], pairs[k, 1])
    for i in range(count):
        parent[i] = root_of(parent, i)
    return parent


NONE = -1


@jit
def fans_of_corners(side: np.ndarray, parted: np.ndarray) -> np.ndarray:
    """Return for each corner, 3 t + c of triangle t, the lowest one of its fan (3 t,).

    `side` (t, 3): the edge from each corner to the next. Triangles hang together at edges that have not `parted` (e,).
    """
    fan, met = np.arange(side.size), np.full(len(parted), NONE)
    for one in range(side.size):
        edge = side[one // 3, one % 3]
        other = met[edge]
        if other == NONE:
            met[edge] = one
        elif not parted[edge]:  # where a side begins for one triangle, it ends for the other
            join(fan, one, _following(other))
            join(fan, other, _following(one))
    for corner in range(len(fan)):
        fan[corner] = root_of(fan, corner)
    return fan


@jit_lean
def _following(corner: int) -> int:
    """Return the next corner of the same triangle."""
    return corner - 2 if corner % 3 == 2 else corner + 1


def half_edges(edge_of: np.ndarray) -> np.ndarray:
    """Return the two half-edges (e, 2) of each edge, given the edge of each half-edge (3 t,); all have two."""
    numbers = np.arange(len(edge_of))
    last = np.empty(len(edge_of) // 2, np.int64)
    last[edge_of] = numbers
    both = np.bincount(edge_of, numbers).astype(np.int64)  # a sum of two: exact
    return np.stack([both - last, last], axis=1)


def shells(edges: np.ndarray) -> np.ndarray:
    """Return the shell (t,) of each triangle, 0, 1, … in order, of half-edges (e, 2): joined by edges."""
    count = 2 * len(edges) // 3
    return np.unique(joined(count, edges % count), return_inverse=True)[1].ravel()


def fans(triangles: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return how many fans of triangles (n,) there are around each vertex, of half-edges (e, 2): usually 1."""
    count = len(triangles)
    start = edges % count + edges // count * count  # a corner has the number of the half-edge that begins there
    end = edges % count + (edges // count + 1) % 3 * count
    # Where an edge begins for one triangle, it ends for the other.
    pairs = np.concatenate([np.stack([start[:, 0], end[:, 1]], axis=1), np.stack([start[:, 1], end[:, 0]], axis=1)])
    corners = np.unique(joined(3 * count, pairs))
    return np.bincount(triangles.T.ravel()[corners])
