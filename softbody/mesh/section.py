"""Section of a closed surface by a plane: the surface of what is left on both sides, closed by caps.

Where the plane goes through an edge there is a new vertex on it, and where it passes near a vertex, through that: so no
piece of an edge is shorter than a part of it, NEAREST. Such a cut is bent by as much; where its caps would go through
the surface, by less. Vertices of the cut are two afterwards, one for each side, at the same place; so are caps, which
fill the section with triangles as large as those of the surface.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.errors import MeshError
from softbody.geometry.connected import joined
from softbody.geometry.planar_mesh import planar_mesh
from softbody.geometry.polyhedron import signed_volume
from softbody.geometry.query import points_in_mesh
from softbody.geometry.self_intersections import self_intersections
from softbody.mesh.mesh import unique_edges
from softbody.mesh.weld import first_at_place

# Of an edge: the nearest to an end of it that a cut goes through it. A spring is the stiffer the shorter it is, and
# steps must be the shorter for it. Others are tried where a cut that is bent so much meets itself, or caps the skin.
NEAREST = 0.2
BENDS = NEAREST, 0.1, 0.05, 0.01

NOT = -1  # no vertex, no triangle


class Plane(NamedTuple):
    """A plane that cuts within a distance of a point, which may be inf."""

    point: np.ndarray  # (3,) [m]
    normal: np.ndarray  # (3,) unit
    radius: float  # [m]


class Cut(NamedTuple):
    """A surface that was cut, all of it; caps count as surface."""

    ends: np.ndarray  # (n, 2) vertices of before between which each one is: the same twice for old ones; NOT in a cap
    way: np.ndarray  # (n,) part of the way from the first to the second
    points: np.ndarray  # (n, 3) [m]
    triangles: np.ndarray  # (t, 3)
    origin: np.ndarray  # (t,) triangle of before of which each is a part; NOT of a cap
    on_cut: np.ndarray  # (n,) of bool: the vertex is on the border of a cap


class _Nodes(NamedTuple):
    """Where the surface is cut: vertices that are on the plane, and points of edges that go through it."""

    ends: np.ndarray  # (k, 2) vertices, the same twice for one that is cut itself
    way: np.ndarray  # (k,)
    of_vertex: np.ndarray  # (n,) node that a vertex is, or NOT
    of_edge: dict[tuple[int, int], int]  # node of each edge that is cut, by its vertices


def cut_surface(points: np.ndarray, triangles: np.ndarray, plane: Plane, spacing: float) -> Cut | None:
    """Return the surface that a plane leaves of a closed one, or None where it meets nothing.

    `points` (n, 3) [m], `triangles` (t, 3); `spacing` [m] of vertices within caps. Only those parts of the section are
    cut that are within the plane's radius, all of them. Raises MeshError where the section meets itself, or goes on
    beyond the radius.
    """
    found, error = None, None
    for nearest in BENDS:
        try:
            cut = _bent(points, triangles, plane, spacing, nearest)
        except MeshError as each:
            error = error or each
            continue
        if cut is None or not _caps_go_through(cut):
            return cut
        found = found or cut
    if found is None and error is not None:
        raise error
    return found


def _bent(points: np.ndarray, triangles: np.ndarray, plane: Plane, spacing: float, nearest: float) -> Cut | None:
    """Return the cut that is bent by such a part of edges, at most."""
    heights = (points - plane.point) @ plane.normal
    side = sides_of(heights, triangles, nearest)
    nodes, rings = _nodes(heights, triangles, side, nearest), {}
    corners = side[triangles]
    on_border = (corners > 0).any(axis=1) & ((corners < 0).any(axis=1) | ((corners == 0).sum(axis=1) == 2))
    for row in np.flatnonzero(on_border).tolist():
        rings[row] = _ring(triangles[row].tolist(), side, nodes)
    if not rings:
        return None
    places = _between(points, nodes.ends, nodes.way)
    axes = _axes(plane.normal)
    border = np.array([_border_edge(ring) for ring in rings.values()])
    try:
        inner, cap = planar_mesh((places - plane.point) @ axes.T, border, spacing)
    except MeshError as error:
        raise MeshError("its section there meets itself; move or turn the plane") from error
    chosen = _within(plane, places, cap)
    if not chosen[: len(places)].any():
        return None
    return _put_together(points, triangles, side, nodes, rings, (plane.point + inner @ axes, cap, chosen))


def _caps_go_through(cut: Cut) -> bool:
    """Tell whether caps meet the surface elsewhere than along their borders."""
    meets, _ = self_intersections(cut.points, cut.triangles, first_at_place(cut.points))
    return bool((cut.origin[meets] == NOT).any())


def _nodes(heights: np.ndarray, triangles: np.ndarray, side: np.ndarray, nearest: float) -> _Nodes:
    edges, vertices = unique_edges(triangles), np.flatnonzero(side == 0)
    cut = edges[side[edges[:, 0]] * side[edges[:, 1]] < 0]
    from_first, whole = heights[cut[:, 0]], heights[cut[:, 0]] - heights[cut[:, 1]]
    way = np.clip(from_first / whole, nearest, 1.0 - nearest)
    of_vertex = np.full(len(side), NOT)
    of_vertex[vertices] = np.arange(len(vertices))
    return _Nodes(
        np.concatenate([np.stack([vertices, vertices], axis=1), cut]),
        np.append(np.zeros(len(vertices)), way),
        of_vertex,
        {(a, b): len(vertices) + k for k, (a, b) in enumerate(cut.tolist())},
    )


def _ring(corners: list[int], side: np.ndarray, nodes: _Nodes) -> list[tuple[int, int]]:
    """Return what is met along the border of a triangle: sides and vertices, or 0 and a node."""
    ring = []
    for a, b in zip(corners, [*corners[1:], corners[0]]):
        ring.append((int(side[a]), a) if side[a] else (0, int(nodes.of_vertex[a])))
        if side[a] * side[b] < 0:
            ring.append((0, nodes.of_edge[min(a, b), max(a, b)]))
    return ring


def _border_edge(ring: list[tuple[int, int]]) -> tuple[int, int]:
    """Return the nodes between which the upper part of a triangle ends, in its order."""
    last, first = NOT, NOT
    for (before, _), (kind, node), (after, _) in zip([ring[-1], *ring], ring, [*ring[1:], ring[0]]):
        if kind == 0 and before > 0:
            last = node
        if kind == 0 and after > 0:
            first = node
    return last, first


def _within(plane: Plane, places: np.ndarray, cap: np.ndarray) -> np.ndarray:
    """Return which nodes and inner vertices are of parts of the section that are within the plane's radius.

    `places` (k, 3) [m] of nodes. Raises MeshError for one that goes on beyond it.
    """
    part = joined(int(cap.max()) + 1, np.concatenate([cap[:, :2], cap[:, 1:]]))
    near = np.linalg.norm(places - plane.point, axis=1) <= plane.radius
    some, every = np.zeros(len(part), bool), np.ones(len(part), bool)
    np.logical_or.at(some, part[: len(near)], near)
    np.logical_and.at(every, part[: len(near)], near)
    if (some[part] & ~every[part]).any():
        far = np.linalg.norm(places - plane.point, axis=1)[(some & ~every)[part[: len(near)]]].max()
        raise MeshError(
            f"radius is {plane.radius:.6g} m, and the section at hand reaches to {far:.6g} m from the point; give "
            "more, or another point"
        )
    return np.asarray(every[part])


def _put_together(
    points: np.ndarray,
    triangles: np.ndarray,
    side: np.ndarray,
    nodes: _Nodes,
    rings: dict[int, list[tuple[int, int]]],
    caps: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> Cut:
    """Return the surface that is cut at the chosen nodes; `caps`: points within (k, 3), triangles, who is chosen."""
    inner, cap, chosen = caps
    count, at_vertices = len(points), int((side == 0).sum())
    number = len(nodes.way)
    # The first copy of a vertex that is cut is the vertex itself.
    upper = np.append(nodes.ends[:at_vertices, 0], count + np.arange(number - at_vertices))
    lower = count + number - at_vertices + np.arange(number)
    first_inner = lower[-1] + 1
    ids = {
        1: np.append(upper, first_inner + np.arange(len(inner))),
        -1: np.append(lower, first_inner + len(inner) + np.arange(len(inner))),
    }
    within = np.full((2 * len(inner), 2), NOT)
    ends = np.concatenate([np.tile(np.arange(count)[:, None], 2), nodes.ends[at_vertices:], nodes.ends, within])
    way = np.concatenate([np.zeros(count), nodes.way[at_vertices:], nodes.way, np.zeros(len(within))])
    placed = np.concatenate([_between(points, ends[:first_inner], way[:first_inner]), inner, inner])

    whole = _whole(triangles, side, nodes.of_vertex, lower, chosen)
    stays, parts, of = np.ones(len(triangles), bool), list[list[int]](), list[int]()
    for row, ring in rings.items():
        if chosen[_border_edge(ring)[0]] and (side[triangles[row]] < 0).any():
            stays[row] = False
            found = [part for sign in (1, -1) for part in _part(ring, sign, ids[sign], placed)]
            parts, of = parts + found, of + [row] * len(found)
    cap = cap[chosen[cap[:, 0]]]
    split = np.array(parts, np.int64).reshape(-1, 3)
    every = np.concatenate([whole[stays], split, ids[1][cap[:, ::-1]], ids[-1][cap]])
    origin = np.concatenate([np.flatnonzero(stays), np.array(of, np.int64), np.full(2 * len(cap), NOT)])
    used, renumbered = np.unique(every, return_inverse=True)
    on_cut = np.isin(used, np.concatenate([upper[chosen[:number]], lower[chosen[:number]]]))
    return Cut(ends[used], way[used], placed[used], renumbered.reshape(-1, 3), origin, on_cut)


def _whole(
    triangles: np.ndarray, side: np.ndarray, of_vertex: np.ndarray, lower: np.ndarray, chosen: np.ndarray
) -> np.ndarray:
    """Return all triangles, those below with the lower copies of vertices that are cut."""
    rows, is_cut = triangles.copy(), side == 0
    is_cut[is_cut] = chosen[of_vertex[is_cut]]
    below = (side[triangles] <= 0).all(axis=1)[:, None] & is_cut[triangles]
    rows[below] = lower[of_vertex[rows[below]]]
    return rows


def _part(ring: list[tuple[int, int]], sign: int, ids: np.ndarray, points: np.ndarray) -> list[list[int]]:
    """Return the triangles, one or two, of the part of a triangle that is on one side."""
    corners = [int(ids[which]) if kind == 0 else which for kind, which in ring if kind in (0, sign)]
    if len(corners) == 3:
        return [corners]
    a, b, c, d = corners
    if ((points[a] - points[c]) ** 2).sum() <= ((points[b] - points[d]) ** 2).sum():
        return [[a, b, c], [a, c, d]]
    return [[a, b, d], [b, c, d]]


def _between(points: np.ndarray, ends: np.ndarray, way: np.ndarray) -> np.ndarray:
    a, b = points[ends[:, 0]], points[ends[:, 1]]
    return np.asarray(a + way[:, None] * (b - a))


def _axes(normal: np.ndarray) -> np.ndarray:
    """Return two unit vectors (2, 3) that turn counter-clockwise seen from where the `normal` (3,) points."""
    least = np.zeros(3)
    least[np.argmin(np.abs(normal))] = 1.0
    first = np.cross(least, normal)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def pieces_of(cut: Cut) -> list[np.ndarray]:
    """Return the triangles of each piece that a surface fell into; cavities are of the piece that they are in."""
    part = joined(len(cut.points), np.concatenate([cut.triangles[:, :2], cut.triangles[:, 1:]]))[cut.triangles[:, 0]]
    pieces = {label: np.flatnonzero(part == label) for label in np.unique(part).tolist()}
    hollow = [label for label, rows in pieces.items() if signed_volume(cut.points, cut.triangles[rows]) < 0.0]
    solid = {label: rows for label, rows in pieces.items() if label not in hollow}
    for label in hollow:
        inside = cut.points[cut.triangles[pieces[label][:1], 0]]
        around = [other for other, rows in solid.items() if _is_in(inside, cut, pieces[other])]
        if around:
            host = min(around, key=lambda other: signed_volume(cut.points, cut.triangles[pieces[other]]))
            solid[host] = np.append(solid[host], pieces[label])
    return list(solid.values())


def _is_in(point: np.ndarray, cut: Cut, rows: np.ndarray) -> bool:
    corners, numbers = np.unique(cut.triangles[rows], return_inverse=True)
    return bool(points_in_mesh(point, cut.points[corners], numbers.reshape(-1, 3))[0])


def sides_of(heights: np.ndarray, triangles: np.ndarray, nearest: float) -> np.ndarray:
    """Return on which side of the plane (n,) vertices at these `heights` (n,) [m] are: 1, −1, and 0 for those cut.

    A vertex is cut to which the plane is nearer than `nearest` of an edge, where the cut can pass through it: its
    neighbours are on one side of it, and the others on the other.
    """
    side = np.where(heights >= 0.0, 1, -1)
    edges = unique_edges(triangles)
    edges = edges[side[edges[:, 0]] != side[edges[:, 1]]]
    size = np.abs(heights)
    share = size[edges] / size[edges].sum(axis=1, keepdims=True).clip(np.finfo(float).tiny)
    near = np.unique(edges[share < nearest])
    order = np.argsort(triangles.ravel(), kind="stable")
    corner = triangles.ravel()[order]
    for vertex in near[np.argsort(size[near], kind="stable")].tolist():
        first, end = np.searchsorted(corner, (vertex, vertex + 1))
        around = order[first:end]
        ahead = triangles[around // 3, (around + 1) % 3], triangles[around // 3, (around + 2) % 3]
        if _passes(side, *ahead):
            side[vertex] = 0
    return side


def _passes(side: np.ndarray, after: np.ndarray, before: np.ndarray) -> bool:
    """Tell whether a cut can pass through a vertex, given the others (d,) of each triangle around it, in its order."""
    a, b = side[after], side[before]
    if ((a == 0) & (b == 0)).any():
        return False
    beyond = dict(zip(after.tolist(), b.tolist()))
    ahead = dict(zip(before.tolist(), a.tolist()))
    cut = [vertex for vertex in beyond if side[vertex] == 0]
    return all(beyond[v] * ahead[v] < 0 for v in cut) and int((a * b < 0).sum()) + len(cut) == 2
