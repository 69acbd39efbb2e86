"""Cost of point in mesh and closest triangle on a mesh that moves every frame. One thread, structures rebuilt.

Ours and peers in turns. A call is one frame: the structure is rebuilt or refitted, then all points are asked. Peers
that would take minutes get fewer points; all figures are per point. libigl is held to one thread, as ours and the
others.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from math import inf
from typing import Any

import igl
import numpy as np
import pytest
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector as Embree
from trimesh.ray.ray_triangle import RayMeshIntersector as Rtree

import softbody
from benchmarks.goals import Goal
from benchmarks.open3d_peer import open3d, open3d_scene
from benchmarks.race import Peer
from benchmarks.suite import Benchmark, Row
from softbody.geometry import (
    MeshQuery,
    build_bvh,
    build_parity_grid,
    closest_all_in_bvh,
    closest_triangles,
    points_in_parity_grid,
    points_in_polyhedron,
    rebuild_parity_grid,
    refit_bvh,
)
from softbody.geometry.closest_point import Closest, no_answers

Arrays = tuple[np.ndarray, np.ndarray]

PAGE = "standard", 5  # the level from which on the page has it, and where
SIZES = {  # triangles and points, by level
    "quick": ((1_000, 10_000),),
    "standard": ((1_000, 10_000), (10_000, 10_000), (100_000, 10_000)),
    "full": ((1_000, 100_000), (10_000, 100_000), (100_000, 100_000), (1_000_000, 1_000_000)),
}
PAIRS = {"quick": 1e6, "standard": 2e6, "full": 1e8}  # point–triangle pairs that "all pairs" gets a round


def wobbled_torus(triangles: int) -> Arrays:
    """Return a torus of about as many triangles, deformed so that nothing is aligned."""
    across = max(3, round(np.sqrt(triangles / 5.0)))
    mesh = softbody.torus(1.0, 0.4, max(3, round(triangles / 2 / across)), across)
    x, y, z = mesh.vertices.T
    bumps = 1.0 + 0.08 * np.sin(5.0 * x) * np.cos(4.0 * y) * np.sin(3.0 * z)
    return np.ascontiguousarray(mesh.vertices * bumps[:, None]), mesh.triangles


def uniform_points(vertices: np.ndarray, count: int) -> np.ndarray:
    """Return points uniform in the bounding box."""
    return np.random.default_rng(0).uniform(vertices.min(axis=0), vertices.max(axis=0), (count, 3))


def near_points(vertices: np.ndarray, count: int) -> np.ndarray:
    """Return vertices moved by about a thousandth of the size."""
    rng = np.random.default_rng(0)
    return vertices[rng.integers(0, len(vertices), count)] + 1e-3 * rng.normal(size=(count, 3))


def stacked_points(vertices: np.ndarray, count: int) -> np.ndarray:
    """Return the mesh's own vertices, shifted along z: a stack of equal bodies."""
    shifts = np.linspace(-0.35, 0.35, -(-count // len(vertices)) + 1)[1:]
    stack = np.concatenate([vertices + np.array([0.0, 0.0, shift]) for shift in shifts])
    return np.ascontiguousarray(stack[:count])


def cut(points: np.ndarray, pairs: float, triangles: np.ndarray) -> np.ndarray:
    """Return as many points as make `pairs` with all triangles."""
    return points[: max(1, min(len(points), int(pairs / len(triangles))))]


def our_containment(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> Callable[[], np.ndarray]:
    """Return a call that rebuilds the grid and asks it."""
    grid = build_parity_grid(vertices, triangles, 4.0 if len(points) > 5 * len(triangles) else 0.25)
    answers = np.empty(len(points), bool)

    def call() -> np.ndarray:
        rebuild_parity_grid(grid, vertices)
        points_in_parity_grid(points, grid, vertices, answers, (0, len(points)))
        return answers

    return call


def containment_peers(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray, level: str) -> dict[str, Peer]:
    """Return what the others take, and for how many points."""
    budget = PAIRS[level]
    few = cut(points, budget, triangles)
    ray = points[:100]

    def by(engine: type, rows: np.ndarray) -> Callable[[], object]:
        return lambda: engine(trimesh.Trimesh(vertices, triangles, process=False)).contains_points(rows)

    peers: dict[str, Peer] = {
        "all pairs": (lambda: points_in_polyhedron(few, vertices, triangles), len(few)),
        "libigl fast winding number": (lambda: igl.fast_winding_number(vertices, triangles, points), len(points)),
        "trimesh with embree": (by(Embree, points), len(points)),
    }
    if len(triangles) <= 50_000:  # beyond, building its tree takes seconds
        peers["trimesh with rtree, 100 points"] = (by(Rtree, ray), len(ray))
    if open3d:
        single = points.astype(np.float32)
        peers["Open3D, float32"] = (
            lambda: open3d_scene(vertices, triangles).compute_occupancy(single, nthreads=1),
            len(points),
        )
    return peers


DISTRIBUTIONS = {
    "uniform in the bounding box": uniform_points,
    "a thousandth of the size off the surface": near_points,
    "in stacked copies": stacked_points,
}


def sizes_of(*kinds: str) -> dict[str, list[Any]]:
    """Return sizes and kinds of points by level; below full, points are uniform but for 10 000 triangles."""
    return {
        level: [
            pytest.param(size, kind, id=f"{size[0]}, {kind}")
            for size in sizes
            for kind in (kinds if level == "full" or size[0] == 10_000 else kinds[:1])
        ]
        for level, sizes in SIZES.items()
    }


INSIDE = "Point in a mesh that moves: * uniform in the bounding box"
INSIDE_NEAR = "Point in a mesh that moves: * a thousandth of the size off the surface"


@Benchmark(
    Row("Point in a mesh that moves: *", "triangles", "point", "grid rebuilt and asked", ("all pairs",)),
    sizes=sizes_of(*DISTRIBUTIONS),
    usual=True,
    goals=(
        Goal("Open3D*", 4.0, (0, 5_000), table=INSIDE),
        Goal("Open3D*", 5.0, (5_000, 50_000), table=INSIDE),
        Goal("Open3D*", 8.0, (50_000, 500_000), table=INSIDE),
        Goal("Open3D*", 10.0, (500_000, inf), table=INSIDE),
        Goal("trimesh with embree", 22.0, table=INSIDE),
        Goal("libigl *", 35.0, table=INSIDE),
        Goal("Open3D*", 2.0, table=INSIDE_NEAR),
    ),
)
def bench_point_in_mesh(race, level: str, size: tuple[int, int], points_are: str) -> None:
    """Rebuild, then ask: points uniform, next to the surface, and in stacked copies."""
    vertices, triangles = wobbled_torus(size[0])
    points = DISTRIBUTIONS[points_are](vertices, size[1])
    ours, peers = our_containment(points, vertices, triangles), containment_peers(points, vertices, triangles, level)
    table = f"Point in a mesh that moves: {len(points)} points {points_are}"
    race(ours, len(points), table=table, size=len(triangles), peers=peers)


@Benchmark(
    Row("Closest triangle of a mesh that moves: *", "triangles", "point", "tree refitted and asked", ("all pairs",)),
    sizes=sizes_of(*list(DISTRIBUTIONS)[:2]),
    usual=True,
    goals=(Goal("Open3D*", 3.0), Goal("libigl", 4.0)),
)
def bench_closest_triangle(race, level: str, size: tuple[int, int], points_are: str) -> None:
    """Refit, then ask for triangle, weights, point and distance."""
    vertices, triangles = wobbled_torus(size[0])
    points = DISTRIBUTIONS[points_are](vertices, size[1])
    tree, answers = build_bvh(vertices, triangles), no_answers(len(points))

    def ours() -> Closest:
        refit_bvh(tree, vertices)
        closest_all_in_bvh(points, tree, vertices, answers, (0, len(points)))
        return answers

    few = cut(points, PAIRS[level] / 4, triangles)
    ray = points[:1_000]

    def by_trimesh() -> object:
        return trimesh.proximity.closest_point(trimesh.Trimesh(vertices, triangles, process=False), ray)

    peers: dict[str, Peer] = {
        "all pairs": (lambda: closest_triangles(few, vertices, triangles), len(few)),
        "libigl": (lambda: igl.point_mesh_squared_distance(points, vertices, triangles), len(points)),
    }
    if len(triangles) <= 50_000:
        peers["trimesh.proximity, 1 000 points"] = (by_trimesh, len(ray))
    if open3d:
        single = points.astype(np.float32)
        peers["Open3D, float32"] = (
            lambda: open3d_scene(vertices, triangles).compute_closest_points(single, nthreads=1),
            len(points),
        )
    table = f"Closest triangle of a mesh that moves: {len(points)} points {points_are}"
    race(ours, len(points), table=table, size=len(triangles), peers=peers)


@Benchmark(Row("Point in mesh and closest triangle by MeshQuery, all threads", "triangles", "point", own=("1 thread",)))
def bench_threads(race, level: str) -> None:
    """All threads against one, the same bits: 10 000 triangles."""
    vertices, triangles = wobbled_torus(10_000)
    points = uniform_points(vertices, 50_000 if level != "full" else 1_000_000)
    threads = os.cpu_count() or 1
    query = MeshQuery(vertices, triangles)

    def frame(count: int) -> Callable[[], object]:
        def call() -> object:
            query.move(vertices)
            return query.contains(points, count), query.closest(points, count)

        return call

    peers = {"1 thread": (frame(1), len(points))}
    name = f"{threads} threads"
    race(frame(threads), len(points), name=name, size=len(triangles), peers=peers, threads=threads)
