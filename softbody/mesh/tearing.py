"""How a surface tears: its fans part at the ends of springs, and what hangs together at no side any more is in two.

A vertex splits along the plane across the spring that tears it: the triangles about it that are on the spring's side
stay together, and so do the others. A split changes no triangle. Springs between triangles that part are two, half as
stiff each, so that no force and no energy changes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.errors import MeshError
from softbody.geometry.connected import fans_of_corners
from softbody.geometry.edges import edges_of_sides
from softbody.mesh.mesh import check_indices, unique_edges

TIED = 1e-9  # loads that differ by less of themselves are equal


class Corners(NamedTuple):
    """The corners about some vertices, vertex by vertex: corner 3 t + c is that of triangle t at its vertex c."""

    start: np.ndarray  # (n + 1,) of each vertex in `corner`
    corner: np.ndarray  # (k,)


def corners_about(triangles: np.ndarray, wanted: np.ndarray) -> Corners:
    """Return the corners of `triangles` (t, 3) about each vertex that is `wanted` (n,)."""
    flat = triangles.ravel()
    corner = np.flatnonzero(wanted[flat])
    vertex = flat[corner]
    number = np.bincount(vertex, minlength=len(wanted))
    return Corners(np.append(0, np.cumsum(number)), corner[np.argsort(vertex, kind="stable")])


def most_loaded(load: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    """Return which of `edges` (e, 2) tear: those of a `load` (e,) above 1 that none at their ends exceeds."""
    greatest = np.zeros(count)
    beyond = np.flatnonzero(load > 1.0)
    for end in edges[beyond].T:
        np.maximum.at(greatest, end, load[beyond])
    return beyond[load[beyond] >= (1.0 - TIED) * greatest[edges[beyond]].max(axis=1)]


def may_part(triangles: np.ndarray, edges: np.ndarray, meets: np.ndarray) -> np.ndarray:
    """Tell of which of `edges` (e, 2) an end has triangles besides the one or two that it `meets` (e,).

    There a fan can part.
    """
    about = np.bincount(triangles.ravel())
    return np.asarray((about[edges[:, 0]] > meets) | (about[edges[:, 1]] > meets))


def check_torn_surface(triangles: np.ndarray, count: int) -> None:
    """Raise MeshError unless `triangles` (t, 3) of `count` vertices are oriented, with borders that are simple."""
    check_indices(triangles, count)
    after = np.roll(triangles, -1, axis=1)
    keys, times = np.unique(triangles * count + after, return_counts=True)
    if (times > 1).any():
        a, b = divmod(int(keys[np.argmax(times > 1)]), count)
        raise MeshError(f"two triangles run along edge {a}–{b} the same way; flip one, or take one away")
    edges = unique_edges(triangles)
    _, origin = _parted(triangles, edges_of_sides(triangles, edges, count), np.zeros(len(edges), bool), count)
    if len(origin) > count:
        raise MeshError(f"vertex {origin[count]} has triangles that hang together there alone; give each part its own")


def torn(
    points: np.ndarray,
    triangles: np.ndarray,
    edges: np.ndarray,
    tearing: np.ndarray,
    pull: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return triangles (t, 3) where fans have parted, and the vertex (m,) of before that each vertex is.

    `points` (n, 3) [m]; `edges` (e, 2) of `triangles` (t, 3), sorted; the rows that are `tearing`; `pull` (n,) [N] of
    all springs at each vertex. A spring parts the fan at that end which is on the border, so that a tear runs on; of
    two such, or none, where there is more pull; of equal ones at both. Vertices that do not split keep their number.
    """
    count = len(points)
    side = edges_of_sides(triangles, edges, count)
    meets = np.bincount(side.ravel(), minlength=len(edges))
    on_border, splits = np.zeros((2, count), bool)
    on_border[edges[meets == 1]] = splits[edges[tearing]] = True
    corners = corners_about(triangles, splits)
    parted = np.zeros(len(edges), bool)
    for edge in tearing.tolist():
        for vertex in _ends_that_split(edge, edges, corners, meets, (on_border, pull)):
            other = int(edges[edge].sum()) - vertex
            parted[_across(points, triangles, side, corners, (vertex, other))] = True
    return _parted(triangles, side, parted, count)


def _ends_that_split(
    edge: int, edges: np.ndarray, corners: Corners, meets: np.ndarray, known: tuple[np.ndarray, np.ndarray]
) -> list[int]:
    """Return the ends of an edge at which it tears: that has triangles besides those of the edge."""
    on_border, pull = known
    ends = [v for v in edges[edge].tolist() if corners.start[v + 1] - corners.start[v] > meets[edge]]
    if len(ends) == 2:
        ends = [v for v in ends if on_border[v]] if on_border[ends].any() else ends
        ends = [v for v in ends if pull[v] >= (1.0 - TIED) * pull[ends].max()]
    return ends


def _across(
    points: np.ndarray, triangles: np.ndarray, side: np.ndarray, corners: Corners, edge: tuple[int, int]
) -> np.ndarray:
    """Return the edges at a vertex where its fan parts, across the edge to another: (vertex, other)."""
    vertex, other = edge
    about = corners.corner[corners.start[vertex] : corners.start[vertex + 1]]
    t, c = about // 3, about % 3
    ahead, back = triangles[t, (c + 1) % 3], triangles[t, (c + 2) % 3]
    of_edge = (ahead == other) | (back == other)
    along = points[other] - points[vertex]
    way = (points[ahead] + points[back] - 2.0 * points[vertex]) @ along
    near = of_edge | (way > -TIED * (along @ along))
    if near.all():  # on a tip: what is not of the edge parts
        near = of_edge
    after, before = side[t, c], side[t, (c + 2) % 3]  # the edges to `ahead` and to `back`
    near_edges = np.concatenate([after[near], before[near]])
    far_edges = np.concatenate([after[~near], before[~near]])
    return np.intersect1d(near_edges, far_edges)


def _parted(triangles: np.ndarray, side: np.ndarray, parted: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return triangles, and the origin of each vertex, where triangles hang together at edges that have not `parted`.

    The part of a fan that has the first corner keeps the vertex's number; others follow, in the order of corners.
    """
    fan, number = fans_of_corners(side, parted), triangles.flatten()
    first = np.flatnonzero(fan == np.arange(len(fan)))  # corner of each fan
    vertex, keeps = number[first], np.empty(count, np.int64)
    keeps[vertex[::-1]] = first[::-1]  # the last that is written is the lowest
    more = first[keeps[vertex] != first]
    origin = np.append(np.arange(count), number[more])
    number[more] = count + np.arange(len(more))
    return number[fan].reshape(-1, 3), origin
