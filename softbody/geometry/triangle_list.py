"""Checks of arrays of vertices and triangles, before any structure is built on them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from softbody.errors import MeshError

MOST = (2**32 - 1) // 3  # triangles and vertices: a tree holds where the three numbers of each begin as uint32


def checked_triangles(vertices: ArrayLike, triangles: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return both as contiguous float64 (n, 3) and int64 (t, 3) arrays, neither of them empty; the triangles as a copy.

    Raises MeshError if they are not, if a vertex is not finite or an index out of range. Nothing else is asked: the
    triangles may be degenerate, overlap, or leave holes; `softbody.Mesh` asks for a closed solid.
    """
    points, faces = _rows(vertices, "vertices"), _rows(triangles, "triangles")
    if len(points) == 0 or len(faces) == 0:
        raise MeshError("the mesh is empty; give at least one triangle")
    if max(len(points), len(faces)) > MOST:
        raise MeshError(f"the mesh has more than {MOST} vertices or triangles; split it")
    if faces.dtype.kind not in "iu":
        raise MeshError(f"triangles are {faces.dtype}; give vertex indices, as integers")
    # A copy, made before it is looked at: what structures keep must not change when the caller's array does.
    points, faces = checked_points(points, "vertices"), faces.copy()
    if faces.min() < 0 or faces.max() >= len(points):
        t = int(np.argmax(((faces < 0) | (faces >= len(points))).any(axis=1)))
        raise MeshError(f"triangle {t} is {faces[t]}, but vertices run from 0 to {len(points) - 1}; repair its indices")
    if not np.isfinite(points).all():
        i = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise MeshError(f"vertex {i} is at {points[i]}: not finite; repair its coordinates")
    return points, faces.astype(np.int64, order="C", copy=False)


def checked_points(points: ArrayLike, name: str = "points") -> np.ndarray:
    """Return `points` as a contiguous float64 (m, 3) array, or raise MeshError; they may be none, or not finite.

    A read-only one, as a Mesh has, is copied: kernels would be compiled once more for it.
    """
    return np.require(_rows(points, name), np.float64, ["C", "A", "W"])


def finite_points(points: ArrayLike) -> np.ndarray:
    """Return `points` as `checked_points` does, or raise MeshError if one is not finite."""
    rows = checked_points(points)
    with np.errstate(all="ignore"):
        total = np.add.reduce(rows, None)  # quicker than a look at every number; finite only if they are
    if not np.isfinite(total) and not np.isfinite(rows).all():
        i = int(np.argmin(np.isfinite(rows).all(axis=1)))
        raise MeshError(f"point {i} is at {rows[i]}: not finite; leave it out")
    return rows


def _rows(rows: ArrayLike, name: str) -> np.ndarray:
    try:
        array = np.asarray(rows)
        if array.dtype.kind not in "iuf":
            raise TypeError(f"{array.dtype} is not a type of real numbers")
    except (TypeError, ValueError) as error:
        raise MeshError(f"{name} are not numbers in rows of three; give an (n, 3) array") from error
    if array.size == 0 and array.ndim == 1:
        return np.empty((0, 3))
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{name} have shape {array.shape}; give an (n, 3) array")
    return array


def edges_meet_evenly(triangles: np.ndarray) -> bool:
    """Tell whether every edge belongs to an even number of `triangles` (t, 3): only then is there an inside."""
    return odd_edge(triangles) is None


def odd_edge(triangles: np.ndarray) -> tuple[int, int, int] | None:
    """Return the vertices of the first edge that belongs to an odd number of `triangles` (t, 3), and that number.

    A triangle that repeats a vertex has one edge twice and no other: it changes nothing.
    """
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    directed = directed[directed[:, 0] != directed[:, 1]]
    low, high = directed.min(axis=1), directed.max(axis=1)
    count = int(triangles.max()) + 1
    keys, meetings = np.unique(low * count + high, return_counts=True)
    odd = meetings % 2 == 1
    if not odd.any():
        return None
    first = int(np.argmax(odd))
    i, j = divmod(int(keys[first]), count)
    return i, j, int(meetings[first])
