"""Welding of triangles that share no vertices: vertices at the same place, or nearly so, are merged."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from softbody.compiler.jit import jit
from softbody.compiler.simd import lowest_bit
from softbody.errors import MeshError
from softbody.geometry.bvh import BVH, WIDTH, Search, build_bvh, search_space
from softbody.geometry.bvh_boxes import ask_leaf, list_near
from softbody.geometry.connected import join, root_of
from softbody.geometry.triangle_list import checked_triangles
from softbody.linalg.vec import load, norm, sub


def merged(vertices: ArrayLike, triangles: ArrayLike | None, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) [m] and triangles (t, 3), with vertices merged that are at most `tolerance` [m] apart.

    Without `triangles`, each three `vertices` are one, (t, 3, 3) or (3 t, 3). Of those that are merged, the first gives
    the place; a chain of near ones becomes one. Triangles of which that leaves no three corners are left out, and
    vertices that none uses. Raises MeshError for what are no triangles.
    """
    if triangles is None:
        vertices, triangles = _listed(vertices)
    points, faces = checked_triangles(vertices, triangles)
    place = first_at_place(points)
    if tolerance > 0.0:
        place = first_within(points, place, tolerance)
    faces = place[faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    if len(faces) == 0:
        raise MeshError(f"no triangle is left where vertices within {tolerance:g} m are merged; give a smaller one")
    used, numbers = np.unique(faces, return_inverse=True)
    return points[used], numbers.reshape(-1, 3)


def _listed(corners: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and triangles of a list of corners, (t, 3, 3) or (3 t, 3)."""
    try:
        rows = np.asarray(corners)
    except (TypeError, ValueError) as error:
        raise MeshError("corners are not numbers in triples of three; give a (t, 3, 3) array") from error
    if rows.ndim not in (2, 3) or rows.shape[-1] != 3 or (rows.size % 9 if rows.ndim == 2 else rows.shape[1] != 3):
        raise MeshError(f"corners have shape {rows.shape}; give (t, 3, 3), or (3 t, 3), or triangles, too")
    return rows.reshape(-1, 3), np.arange(rows.size // 3).reshape(-1, 3)


def first_at_place(points: np.ndarray) -> np.ndarray:
    """Return for each of `points` (n, 3) the lowest number of those at the same place, (n,)."""
    order = np.lexsort(points.T)  # those at one place in order
    ordered = points[order]
    begins = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))
    place = np.empty(len(points), np.int64)
    place[order] = order[begins][np.cumsum(begins) - 1]
    return place


def first_within(points: np.ndarray, place: np.ndarray, tolerance: float) -> np.ndarray:
    """Return for each of `points` (n, 3) [m] the lowest number of those that it reaches in leaps ≤ `tolerance` [m].

    `place` (n,): the same for those at the same place.
    """
    kept, of = np.unique(place, return_inverse=True)
    spots = np.ascontiguousarray(points[kept])
    tree = build_bvh(spots, np.repeat(np.arange(len(kept))[:, None], 3, axis=1))
    parent = np.arange(len(kept))
    _join_near(tree, spots, search_space(tree), tolerance, parent)
    return kept[parent[of.ravel()]]


@jit
def _join_near(tree: BVH, points: np.ndarray, search: Search, tolerance: float, parent: np.ndarray) -> None:
    """Join in `parent` (n,) the `points` (n, 3) [m] that are near; each is a triangle of the tree, of no size."""
    for leaf in range(tree.corners.shape[0]):
        ask_leaf(search, leaf, tree, points, tolerance)
        for k in range(list_near(tree, search)):
            j, meets = search.listed[k], search.meets[k]
            while meets != 0:
                i = tree.order[WIDTH * leaf + lowest_bit(meets)]
                meets &= meets - 1
                if i < j and norm(sub(load(points, i), load(points, j))) <= tolerance:
                    join(parent, i, j)
    for i in range(parent.shape[0]):
        parent[i] = root_of(parent, i)
