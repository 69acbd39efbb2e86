"""Triangle meshes of planar regions, given by their borders: caps for bodies that a plane has cut.

Points of a triangular lattice fill the region; they and the border's are joined by a constrained Delaunay
triangulation (`delaunay`), of which the triangles left of the border are kept.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit
from softbody.errors import MeshError, ParameterError
from softbody.geometry.connected import joined
from softbody.geometry.delaunay import NONE, Triangulation, triangulate

# Spacings that inner points stay away from the border: triangles there are about as high as those of the lattice. No
# round number, so that no rounding decides about points in a box of round sides.
MARGIN = 0.618

LEAST = 1e-12  # spacing over the largest coordinate: far beyond rounding

ROUND = 1e-6  # a region whose moments of area differ by less, over their sum, has no axis: beyond rounding


def planar_mesh(points: np.ndarray, edges: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return inner points (k, 2) [m] and triangles (t, 3), counter-clockwise, that fill a planar region.

    `points` (n, 2) [m] are those of the border, of sizes that `predicates` can tell apart; `edges` (n, 2) its directed
    edges, the region on their left: closed loops, outer ones counter-clockwise, holes clockwise, each point in one.
    Triangles number the border's points first, then the inner ones. Each edge of the border is an edge of one triangle,
    in its direction, and every other edge of two, in opposite directions. All triangles turn counter-clockwise by exact
    signs, however thin.

    `spacing` [m] is the distance between inner points. Their lattice is centred on the region's centroid and turned
    along its long axis, if it has one, else along x: it does not depend on how points and edges are numbered, beyond
    rounding.

    Raises MeshError where the border meets itself, is no closed loops, or goes the wrong way around, and ParameterError
    if the spacing is no positive number, or too small for the coordinates.
    """
    points, edges = np.ascontiguousarray(points, np.float64), np.ascontiguousarray(edges, np.int64)
    _check_loops(points, edges)
    if not LEAST * np.abs(points).max() < spacing < np.inf:
        raise ParameterError(f"the spacing is {spacing} m; give a positive one, not too small for these coordinates")
    inner = _lattice_within(points, edges, spacing)
    mesh, (edge, a, b) = triangulate(np.concatenate([points, inner]), edges)
    if edge != NONE:
        raise MeshError(f"{_named(points, edges[edge])} meets {_named(points, (a, b))}; let loops keep apart")
    return inner, mesh.start.reshape(-1, 3)[_is_left_of_border(mesh)]


def _check_loops(points: np.ndarray, edges: np.ndarray) -> None:
    """Raise MeshError unless points (n, 2) are finite and different, and edges (n, 2) join them to closed loops."""
    if points.ndim != 2 or points.shape[1] != 2 or edges.shape != points.shape or len(points) < 3:
        raise MeshError(
            f"the border has points of shape {points.shape} and edges of {edges.shape}; give (n, 2) both, n ≥ 3"
        )
    for i in np.flatnonzero(~np.isfinite(points).all(axis=1)):
        raise MeshError(f"border point {i} is at {points[i]}: not finite; repair its coordinates")
    order = np.lexsort(points.T)
    for k in np.flatnonzero((points[order[1:]] == points[order[:-1]]).all(axis=1)):
        i, j = np.sort(order[k : k + 2])
        raise MeshError(f"border points {i} and {j} are both at {points[i]} m; let loops keep apart")
    for ends, what in zip(edges.T, ("start", "end")):
        for i in np.setdiff1d(np.arange(len(points)), ends):
            raise MeshError(f"no border edge {what}s at point {i}; let each point {what} one")
    for i in edges[edges[:, 0] == edges[:, 1], 0]:
        raise MeshError(f"a border edge runs from point {i} to itself; let each loop have three points or more")


def _named(points: np.ndarray, ends: np.ndarray | tuple[int, int]) -> str:
    """Return words for the border's edge between two points, or for its point, if they are one."""
    a, b = ends
    where = f"point {a} at {points[a]} m"
    return where if a == b else f"the border's edge from {where} to point {b} at {points[b]} m"


def _is_left_of_border(mesh: Triangulation) -> np.ndarray:
    """Tell which triangles (t,) are in the region; raise MeshError where it is not on the left of its whole border."""
    inner = np.flatnonzero((mesh.border == 0) & (mesh.twin != NONE))
    part = joined(len(mesh.start) // 3, np.stack([inner, mesh.twin[inner]], axis=1) // 3)
    left, right = np.flatnonzero(mesh.border == 1), np.flatnonzero(mesh.border == -1)
    outside = np.append(part[right // 3], part[mesh.leaving[-1] // 3])
    for h in left[np.isin(part[left // 3], outside)]:
        ends = mesh.start[h], mesh.start[mesh.twin[h]]
        where = _named(mesh.points[:, :2], ends)
        raise MeshError(f"{where} has the region not on its left, or on both sides; turn only holes clockwise")
    return np.isin(part, part[left // 3])


def _lattice_within(points: np.ndarray, edges: np.ndarray, spacing: float) -> np.ndarray:
    """Return the points (k, 2) [m] of a triangular lattice that are in a region and not too near its border."""
    area, middle, axis = _centre_and_axis(points, edges)
    if not area > 0.0:  # what is wrong with the border is told later
        return np.empty((0, 2))
    along, across = np.array(axis), np.array((-axis[1], axis[0]))
    places = (points - np.array(middle)) @ np.stack([along, across], axis=1)
    step = np.array((spacing, 0.5 * sqrt(3.0) * spacing))
    (first, lowest), (last, highest) = np.floor(places.min(axis=0) / step), np.ceil(places.max(axis=0) / step)
    row, column = np.meshgrid(np.arange(lowest, highest + 1.0), np.arange(first, last + 1.0), indexing="ij")
    u, v = (column + 0.5 * (row % 2.0)).reshape(-1, 1) * step[0], row.reshape(-1, 1) * step[1]
    lattice = np.array(middle) + u * along + v * across
    return lattice[_are_well_within(points, edges, lattice, MARGIN * spacing)]


@jit
def _centre_and_axis(points: np.ndarray, edges: np.ndarray) -> tuple[float, tuple[float, float], tuple[float, float]]:
    """Return the area [m²] of a region, its centroid [m], and the direction in which it is longest, or that of x.

    Green's theorem turns moments of area into sums over the border's edges. Those about x = y = 0 are taken from its
    first point, and moved to the centroid by Steiner's theorem.
    """
    ox, oy = points[0, 0], points[0, 1]
    area = x = y = xx = yy = xy = 0.0
    for e in range(edges.shape[0]):
        px, py = points[edges[e, 0], 0] - ox, points[edges[e, 0], 1] - oy
        qx, qy = points[edges[e, 1], 0] - ox, points[edges[e, 1], 1] - oy
        turn = px * qy - qx * py
        area += turn / 2.0
        x += turn * (px + qx) / 6.0
        y += turn * (py + qy) / 6.0
        xx += turn * (px * px + px * qx + qx * qx) / 12.0
        yy += turn * (py * py + py * qy + qy * qy) / 12.0
        xy += turn * (2.0 * (px * py + qx * qy) + px * qy + qx * py) / 24.0
    if not area > 0.0:
        return area, (ox, oy), (1.0, 0.0)
    x, y = x / area, y / area
    xx, yy, xy = xx - area * x * x, yy - area * y * y, xy - area * x * y
    stretch, shear = xx - yy, 2.0 * xy  # the cosine and the sine of twice the axis' angle, times their norm
    size = sqrt(stretch * stretch + shear * shear)
    if not size > ROUND * (xx + yy):
        return area, (ox + x, oy + y), (1.0, 0.0)
    cosine, sine = sqrt(0.5 * (1.0 + stretch / size)), sqrt(0.5 * (1.0 - stretch / size))
    return area, (ox + x, oy + y), (cosine, sine if shear >= 0.0 else -sine)


@jit
def _are_well_within(points: np.ndarray, edges: np.ndarray, places: np.ndarray, margin: float) -> np.ndarray:
    """Tell which places (m, 2) are in a region, and farther than `margin` [m] from its border."""
    found = np.zeros(places.shape[0], np.bool_)
    for i in range(places.shape[0]):
        x, y = places[i, 0], places[i, 1]
        is_inside, is_clear = False, True
        for e in range(edges.shape[0]):
            px, py = points[edges[e, 0], 0] - x, points[edges[e, 0], 1] - y
            qx, qy = points[edges[e, 1], 0] - x, points[edges[e, 1], 1] - y
            wx, wy = qx - px, qy - py
            # A ray along x leaves or enters the region here.
            if (py > 0.0) != (qy > 0.0) and px - py / wy * wx > 0.0:
                is_inside = not is_inside
            length = wx * wx + wy * wy
            nearest = min(max(-(px * wx + py * wy) / length, 0.0), 1.0) if length > 0.0 else 0.0
            dx, dy = px + nearest * wx, py + nearest * wy
            is_clear = is_clear and dx * dx + dy * dy > margin * margin
        found[i] = is_inside and is_clear
    return found
