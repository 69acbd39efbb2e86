"""Many points at once: whether each is in a mesh, and its closest triangle; for geometry users, with arrays checked."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from softbody.errors import MeshError
from softbody.geometry.bvh import BVH, build_bvh, closest_all_in_bvh, refit_bvh
from softbody.geometry.closest_point import Closest
from softbody.geometry.parity_grid import (
    COLUMNS_PER_TRIANGLE,
    ParityGrid,
    build_parity_grid,
    points_in_parity_grid,
    rebuild_parity_grid,
)
from softbody.geometry.triangle_list import checked_points, checked_triangles, finite_points, odd_edge
from softbody.model.validation import check_range, check_whole

MOST_THREADS = max(64, 4 * (os.cpu_count() or 1))  # that share points; more than there are processors wait in turn


@runtime_checkable
class Surface(Protocol):
    """What has vertices and triangles, as a Mesh does."""

    @property
    def vertices(self) -> ArrayLike:
        """(n, 3) [m]."""

    @property
    def triangles(self) -> ArrayLike:
        """(t, 3)."""


class MeshQuery:
    """A triangle mesh that may move, to ask about many points at once.

    `vertices` (n, 3) [m], `triangles` (t, 3), or a Mesh in place of both. What is inside can only be asked of a closed
    mesh, what is closest of any. `columns_per_triangle`: 4 is faster than 1/4 for a hundred points a triangle and a
    mesh that does not move. Raises MeshError for arrays that are not triangles, and for points that are not finite.
    """

    def __init__(
        self,
        vertices: ArrayLike | Surface,
        triangles: ArrayLike | None = None,
        columns_per_triangle: float = COLUMNS_PER_TRIANGLE,
    ) -> None:
        """Check and copy the arrays. The structures are made when they are first needed."""
        columns_per_triangle = check_range(columns_per_triangle, "columns_per_triangle", above=0.0, most=64.0)
        rows: Any = vertices
        if triangles is None:
            if not isinstance(rows, Surface):
                raise MeshError(f"a {type(rows).__name__} alone is no mesh; give vertices and triangles, or a Mesh")
            rows, triangles = rows.vertices, rows.triangles
        checked, self._triangles = checked_triangles(rows, triangles)
        self._vertices = checked.copy()
        self._columns_per_triangle = columns_per_triangle
        self._grid: ParityGrid | None = None
        self._tree: BVH | None = None
        self._grid_is_old = self._tree_is_old = False

    @property
    def vertices(self) -> np.ndarray:
        """Where the vertices are now (n, 3) [m], read-only; `move` moves them."""
        return _read_only(self._vertices)

    @property
    def triangles(self) -> np.ndarray:
        """The triangles (t, 3), read-only: what is asked trusts them."""
        return _read_only(self._triangles)

    def move(self, vertices: ArrayLike) -> None:
        """Move the mesh: new `vertices` (n, 3) [m] for the same triangles. All must be finite."""
        moved = checked_points(vertices, "vertices")
        if moved.shape != self._vertices.shape:
            raise MeshError(f"vertices have shape {moved.shape}; the mesh has {len(self._vertices)} of them")
        if not np.isfinite(moved).all():
            i = int(np.argmin(np.isfinite(moved).all(axis=1)))
            raise MeshError(f"vertex {i} is at {moved[i]}: not finite; repair its coordinates")
        self._vertices[:] = moved
        self._grid_is_old = self._tree_is_old = True

    def contains(self, points: ArrayLike, threads: int = 1) -> np.ndarray:
        """Tell for each of `points` (m, 3) [m] whether it is inside: (m,) of bool, the same for any `threads`.

        Raises MeshError for a mesh that is open: it has no inside.
        """
        rows = finite_points(points)
        if self._grid is None:
            self._grid = build_parity_grid(self._vertices, self._triangles, self._columns_per_triangle)
        elif self._grid_is_old:
            rebuild_parity_grid(self._grid, self._vertices)
        self._grid_is_old, grid = False, self._grid
        if not grid.closed:
            i, j, meetings = odd_edge(self._triangles) or (0, 0, 0)
            raise MeshError(
                f"the mesh is open, and has no inside: edge {i}–{j} is met by {meetings} triangle(s); close the hole, "
                "merge vertices by softbody.Mesh.from_soup, or ask what is closest"
            )
        answers = np.empty(len(rows), bool)
        _share(
            lambda share: points_in_parity_grid(rows, grid, self._vertices, answers, share),
            len(rows),
            threads,
        )
        return answers

    def closest(self, points: ArrayLike, threads: int = 1) -> Closest:
        """Return the triangle closest to each of `points` (m, 3) [m], with weights, point and distance."""
        rows = finite_points(points)
        if self._tree is None:
            self._tree = build_bvh(self._vertices, self._triangles)
        elif self._tree_is_old:
            refit_bvh(self._tree, self._vertices)
        self._tree_is_old = False
        count, tree = len(rows), self._tree
        answers = Closest(np.empty(count, np.int64), np.empty((count, 3)), np.empty((count, 3)), np.empty(count))
        _share(lambda share: closest_all_in_bvh(rows, tree, self._vertices, answers, share), count, threads)
        return answers

    def signed_distance(self, points: ArrayLike, threads: int = 1) -> np.ndarray:
        """Return how far each of `points` (m, 3) [m] is from the surface, (m,) [m]: negative inside, 0 on it.

        Raises MeshError for a mesh that is open.
        """
        inside = self.contains(points, threads)
        distance = self.closest(points, threads).distance
        return np.where(inside, -distance, distance)


def points_in_mesh(points: ArrayLike, vertices: ArrayLike, triangles: ArrayLike, threads: int = 1) -> np.ndarray:
    """Tell for each of `points` (m, 3) [m] whether it is inside a closed mesh, convex or not: (m,) of bool; paper §4.6.

    `vertices` (n, 3) [m], `triangles` (t, 3). For a mesh that moves, `MeshQuery` saves checking it anew.
    """
    rows = finite_points(points)
    # More columns where more points pay for them.
    columns = min(4.0, max(COLUMNS_PER_TRIANGLE, 0.04 * len(rows) / max(1, len(np.asarray(triangles)))))
    return MeshQuery(vertices, triangles, columns).contains(rows, threads)


def closest_on_mesh(points: ArrayLike, vertices: ArrayLike, triangles: ArrayLike, threads: int = 1) -> Closest:
    """Return the triangle of a mesh closest to each of `points` (m, 3) [m], with weights, point and distance.

    `vertices` (n, 3) [m], `triangles` (t, 3), of any kind. For a mesh that moves, `MeshQuery` saves making its tree
    anew.
    """
    return MeshQuery(vertices, triangles).closest(points, threads)


def _read_only(array: np.ndarray) -> np.ndarray:
    """Return a view through which nothing can be written."""
    view = array.view()
    view.flags.writeable = False
    return view


def _share(work: Callable[[tuple[int, int]], object], count: int, threads: int) -> None:
    """Call work((first, last)) for equal shares of `count` on as many threads; the kernels let go of the GIL."""
    threads = check_whole(threads, "threads", 1, MOST_THREADS)
    if threads == 1:
        work((0, count))
        return
    edges = [count * k // threads for k in range(threads + 1)]
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, pairwise(edges)))
