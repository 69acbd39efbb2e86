"""Shells of a closed mesh, and which of them enclose which."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.geometry.connected import half_edges, shells
from softbody.geometry.query import points_in_mesh


class Shells(NamedTuple):
    """The shells of a closed mesh: triangles that hang together by edges."""

    of: np.ndarray  # (t,) which one each triangle belongs to
    volume: np.ndarray  # (s,) [m³], negative where triangles face inwards
    first: np.ndarray  # (s,) triangle


def shells_of(vertices: np.ndarray, triangles: np.ndarray, edge_of: np.ndarray) -> Shells:
    """Return the shells of a closed mesh, given the edge (3 t,) of each half-edge; see `connected`."""
    of = shells(half_edges(edge_of))
    _, first = np.unique(of, return_index=True)
    if len(first) == 1:
        return Shells(of, np.zeros(0), first)
    # About a vertex of each shell: about another point, the sum would lose digits.
    a, b, c = (vertices[triangles[:, k]] - vertices[triangles[first, 0]][of] for k in range(3))
    return Shells(of, np.bincount(of, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0), first)


def enclosing(vertices: np.ndarray, triangles: np.ndarray, found: Shells, asked: np.ndarray) -> np.ndarray:
    """Return how many other shells are around each of the `asked` (k,), as seen from a vertex of it: (k,)."""
    order = np.argsort(found.of, kind="stable")
    members = np.split(order, np.flatnonzero(np.diff(found.of[order])) + 1)
    points = vertices[triangles[found.first[asked], 0]]
    around = np.zeros(len(asked), np.int64)
    for shell, rows in enumerate(members):
        corners, numbers = np.unique(triangles[rows], return_inverse=True)
        corners = vertices[corners]
        near = ((points > corners.min(axis=0)) & (points < corners.max(axis=0))).all(axis=1) & (asked != shell)
        if near.any():
            around[near] += points_in_mesh(points[near], corners, numbers.reshape(-1, 3))
    return around


def volume_of_rounding(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume [m³] that rounding can give what is flat: about 1e-16 of size³ for each triangle."""
    return 1e-16 * len(triangles) * float(np.ptp(vertices, axis=0).max()) ** 3
