"""Exact integer arithmetic on the very numbers given, which arbitrates where engines disagree.

Every float64 is a rational number. Lengths are brought to integers by one common power of two, quaternions by one each,
and a rotation matrix times |q|² then has integer entries, whether or not the quaternion is quite a unit one. Signs are
exact; nothing has a margin.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

Integers = Any  # three of them: a list, a tuple, or a row of an array of Python integers

GUARD_BITS = 160  # of a square root, beyond its integer part: the float64 nearest to a separation is then certain


def boxes_overlap(
    size_a: ArrayLike,
    position_a: ArrayLike,
    orientation_a: ArrayLike,
    size_b: ArrayLike,
    position_b: ArrayLike,
    orientation_b: ArrayLike,
) -> np.ndarray:
    """Return +1 where the interiors of two boxes meet, 0 where they exactly touch, −1 where they are apart: (m,).

    Sizes (m, 3) full extents [m], positions (m, 3) [m], orientations (m, 4) quaternions (w, x, y, z), of any length;
    without the m, one int. All fifteen axes of the separating-axis test (Gottschalk, Lin and Manocha 1996).
    """
    return _overlap_of_pairs(size_a, position_a, orientation_a, size_b, position_b, orientation_b)


def box_separation(
    size_a: ArrayLike,
    position_a: ArrayLike,
    orientation_a: ArrayLike,
    size_b: ArrayLike,
    position_b: ArrayLike,
    orientation_b: ArrayLike,
) -> np.ndarray:
    """Return the largest separation (m,) [m] of two boxes over the fifteen axes, correctly rounded; arrays as above.

    A positive one is the gap along that axis (the distance may be larger), a negative one is minus the depth.
    """
    return np.nanmax(box_separations(size_a, position_a, orientation_a, size_b, position_b, orientation_b), axis=-1)


def box_separations(
    size_a: ArrayLike,
    position_a: ArrayLike,
    orientation_a: ArrayLike,
    size_b: ArrayLike,
    position_b: ArrayLike,
    orientation_b: ArrayLike,
) -> np.ndarray:
    """Return the separation (m, 15) [m] along each axis, correctly rounded; arrays as above.

    Axes 0 … 2 are the faces of a, 3 … 5 those of b, 6 + 3 i + j edge i of a across edge j of b: NaN if parallel.
    """
    return _separations_of_pairs(size_a, position_a, orientation_a, size_b, position_b, orientation_b)


def convex_overlap(vertices_a: ArrayLike, triangles_a: ArrayLike, vertices_b: ArrayLike, triangles_b: ArrayLike) -> int:
    """Return +1 where the interiors of two convex meshes meet, 0 where they exactly touch, −1 where they are apart.

    Vertices (n, 3) [m], triangles (t, 3). Along the normals of all triangles and all edges of a across all of b.
    """
    points_a, points_b = np.asarray(vertices_a, float), np.asarray(vertices_b, float)
    lengths, _ = _integers(np.concatenate([points_a, points_b]).ravel())
    rows = np.array(lengths, dtype=object).reshape(-1, 3)
    solids = (rows[: len(points_a)], np.asarray(triangles_a)), (rows[len(points_a) :], np.asarray(triangles_b))
    normals, edges = [], []
    for points, faces in solids:
        a, b, c = (points[faces[:, k]] for k in range(3))
        normals.append(_crosses(b - a, c - a))
        ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        ends = np.unique(np.sort(ends, axis=1), axis=0)
        edges.append(points[ends[:, 1]] - points[ends[:, 0]])
    pairs = [np.repeat(edges[0], len(edges[1]), axis=0), np.tile(edges[1], (len(edges[0]), 1))]
    axes = np.concatenate([*normals, _crosses(*pairs)])
    axes = axes[np.any(axes != 0, axis=1)]
    shadow_a, shadow_b = (axes @ points.T for points, _ in solids)
    gap = max(max(shadow_a.min(axis=1) - shadow_b.max(axis=1)), max(shadow_b.min(axis=1) - shadow_a.max(axis=1)))
    return int(gap < 0) - int(gap > 0)


def _one_overlap(*boxes: np.ndarray) -> int:
    numerators = [numerator for numerator, _, _, _ in _separating_axes(*boxes) if numerator is not None]
    largest = max(numerators)
    return (largest < 0) - (largest > 0)


def _one_separations(*boxes: np.ndarray) -> np.ndarray:
    separations = [
        np.nan if numerator is None else float(Fraction(numerator << GUARD_BITS, denominator * _root(square)) * unit)
        for numerator, denominator, square, unit in _separating_axes(*boxes)
    ]
    return np.array(separations)


_overlap_of_pairs = np.vectorize(_one_overlap, otypes=[int], signature="(i),(i),(q),(i),(i),(q)->()")
_separations_of_pairs = np.vectorize(_one_separations, otypes=[float], signature="(i),(i),(q),(i),(i),(q)->(k)")


def _root(square: int) -> int:
    """Return √square · 2^GUARD_BITS, rounded down."""
    return isqrt(square << (2 * GUARD_BITS))


def _separating_axes(
    size_a: np.ndarray,
    position_a: np.ndarray,
    orientation_a: np.ndarray,
    size_b: np.ndarray,
    position_b: np.ndarray,
    orientation_b: np.ndarray,
) -> Iterator[tuple[int | None, int, int, Fraction]]:
    """Yield (numerator, denominator, square, unit) of each axis: its separation is n / (d √square) × unit [m].

    A numerator of None: the edges are parallel, and the face axes do for them.
    """
    lengths, unit = _integers(np.concatenate([size_a, size_b, position_a, position_b]))
    s_a, s_b, p_a, p_b = (lengths[k : k + 3] for k in (0, 3, 6, 9))
    axes_a, norm_a = _scaled_axes(orientation_a)
    axes_b, norm_b = _scaled_axes(orientation_b)
    apart = _sub(p_a, p_b)
    for axis in [*axes_a, *axes_b, *(_cross(a, b) for a in axes_a for b in axes_b)]:
        square = _dot(axis, axis)
        reach_a = sum(s * abs(_dot(axis, x)) for s, x in zip(s_a, axes_a)) * norm_b
        reach_b = sum(s * abs(_dot(axis, x)) for s, x in zip(s_b, axes_b)) * norm_a
        numerator = 2 * abs(_dot(axis, apart)) * norm_a * norm_b - reach_a - reach_b
        yield numerator if square else None, 2 * norm_a * norm_b, square, unit


def _scaled_axes(orientation: np.ndarray) -> tuple[list[Integers], int]:
    """Return the three axes of a body, each |q|² long, and |q|², all integers."""
    (w, x, y, z), _ = _integers(orientation)
    columns = [
        (w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z),
    ]
    return columns, w * w + x * x + y * y + z * z


def point_in_mesh(point: ArrayLike, vertices: ArrayLike, triangles: ArrayLike) -> int:
    """Return +1 if `point` (3,) [m] is inside a closed mesh, 0 if exactly on its surface, −1 if outside.

    `vertices` (n, 3) [m], `triangles` (t, 3); see `points_in_mesh`.
    """
    return int(points_in_mesh(np.asarray(point, float)[None], vertices, triangles)[0])


def points_in_mesh(points: ArrayLike, vertices: ArrayLike, triangles: ArrayLike) -> np.ndarray:
    """Return +1 for each of `points` (m, 3) [m] inside a closed mesh, 0 exactly on its surface, −1 outside: (m,).

    `vertices` (n, 3) [m], `triangles` (t, 3). By the parity of the triangles that a half-line meets; a direction that
    meets an edge or a vertex is thrown away and another one drawn. Triangles without area only count as surface.
    """
    points, vertices = np.asarray(points, float), np.asarray(vertices, float)
    lengths, _ = _integers(np.concatenate([points, vertices]).ravel())
    rows = np.array(lengths, dtype=object).reshape(-1, 3)
    corners = rows[len(points) :][np.asarray(triangles)]
    return np.array([_one_point(point, corners) for point in rows[: len(points)]], dtype=int)


def _one_point(point: np.ndarray, corners: np.ndarray) -> int:
    """Place one point of integers (3,) by the corners (t, 3, 3) of all triangles."""
    a, b, c = np.moveaxis(corners - point, 1, 0)
    ab, bc, ca = _crosses(a, b), _crosses(b, c), _crosses(c, a)
    normal = ab + bc + ca
    six_volumes = _dots(a, bc)
    for t in np.flatnonzero(six_volumes == 0):
        if _on_triangle(normal[t], (a[t], b[t], c[t]), (ab[t], bc[t], ca[t])):
            return 0
    solid = np.any(normal != 0, axis=1)
    generator = np.random.default_rng(0)
    while True:
        direction = np.array([int(x) for x in generator.integers(-(2**20), 2**20, 3)], dtype=object)
        turns = np.stack([_dots(ab, direction), _dots(bc, direction), _dots(ca, direction)])[:, solid]
        same_way = ~(np.any(turns > 0, axis=0) & np.any(turns < 0, axis=0))
        if np.any(turns[:, same_way] == 0):
            continue  # the line meets an edge or a vertex, or lies in a plane of the mesh
        ahead = (six_volumes[solid] > 0) == np.any(turns > 0, axis=0)
        return 1 if np.count_nonzero(same_way & ahead) % 2 else -1


def _on_triangle(normal: np.ndarray, corners: tuple, crosses: tuple) -> bool:
    """Tell whether the origin, in the plane of a triangle, is on it; corners and their cross products in turn."""
    if any(normal):
        return all(_dot(normal, cross) >= 0 for cross in crosses)
    a, b, c = corners
    collinear = not any(x for cross in crosses for x in cross)
    return collinear and min(_dot(a, b), _dot(b, c), _dot(c, a)) <= 0


def _integers(values: np.ndarray) -> tuple[list[int], Fraction]:
    """Return integers, and the power of two of which they are the multiples that `values` (k,) are."""
    ratios = [float(value).as_integer_ratio() for value in values]
    common = max(denominator for _, denominator in ratios)
    return [numerator * (common // denominator) for numerator, denominator in ratios], Fraction(1, common)


def _dot(a: Integers, b: Integers) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Integers, b: Integers) -> Integers:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _sub(a: Integers, b: Integers) -> Integers:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dots(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def _crosses(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.stack(_cross(a.T, b.T), axis=-1)
