"""Cost of point in mesh and closest triangle on a mesh that moves every frame. One thread, structures rebuilt.

Ours and peers in turns. A call is one frame: the structure is rebuilt or refitted, then all points are asked. Peers
that would take minutes get fewer points; all figures are per point. libigl is held to one thread, as ours and the
others.
"""

from __future__ import annotations

import os
from collections.abc import Callable

import igl
import numpy as np
import pytest
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector as Embree
from trimesh.ray.ray_triangle import RayMeshIntersector as Rtree

import softbody
from benchmarks.open3d_peer import open3d, open3d_scene
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

# Triangles → points, by level.
SIZES = {
    "quick": ((1_000, 10_000),),
    "standard": ((1_000, 10_000), (10_000, 10_000), (100_000, 10_000)),
    "full": ((1_000, 100_000), (10_000, 100_000), (100_000, 100_000), (1_000_000, 1_000_000)),
}
PAIRS = {"quick": 1e6, "standard": 2e6, "full": 1e8}  # point–triangle pairs that "all pairs" gets a round


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run each benchmark on the sizes of the level; on points that are not uniform, below full, on 10 000 triangles."""
    if "size" in metafunc.fixturenames:
        level = metafunc.config.getoption("--level")
        kinds = list(DISTRIBUTIONS)[:2] if metafunc.function is bench_closest_triangle else list(DISTRIBUTIONS)
        runs = [
            pytest.param(size, kind, id=f"{size[0]}, {kind}")
            for size in SIZES[level]
            for kind in (kinds if level == "full" or size[0] == 10_000 else kinds[:1])
        ]
        metafunc.parametrize(("size", "points_are"), runs)


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


def containment_peers(
    points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray, level: str
) -> dict[str, tuple[Callable[[], object], int]]:
    """Return what the others take, and for how many points."""
    budget = PAIRS[level]
    few = cut(points, budget, triangles)
    ray = points[:100]

    def by(engine: type, rows: np.ndarray) -> Callable[[], object]:
        return lambda: engine(trimesh.Trimesh(vertices, triangles, process=False)).contains_points(rows)

    peers: dict[str, tuple[Callable[[], object], int]] = {
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


def bench_point_in_mesh(race, request, size: tuple[int, int], points_are: str) -> None:
    """Rebuild, then ask: points uniform, next to the surface, and in stacked copies."""
    level = request.config.getoption("--level")
    vertices, triangles = wobbled_torus(size[0])
    points = DISTRIBUTIONS[points_are](vertices, size[1])
    race(
        our_containment(points, vertices, triangles),
        len(points),
        table=f"Point in a mesh that moves: {len(points)} points {points_are}",
        name="grid rebuilt and asked",
        size=len(triangles),
        of="triangles",
        per="point",
        peers=containment_peers(points, vertices, triangles, level),
        own=["all pairs"],
    )


def bench_closest_triangle(race, request, size: tuple[int, int], points_are: str) -> None:
    """Refit, then ask for triangle, weights, point and distance."""
    level = request.config.getoption("--level")
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

    peers: dict[str, tuple[Callable[[], object], int]] = {
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
    race(
        ours,
        len(points),
        table=f"Closest triangle of a mesh that moves: {len(points)} points {points_are}",
        name="tree refitted and asked",
        size=len(triangles),
        of="triangles",
        per="point",
        peers=peers,
        own=["all pairs"],
    )


def bench_threads(race, request) -> None:
    """All threads against one, the same bits: 10 000 triangles."""
    vertices, triangles = wobbled_torus(10_000)
    points = uniform_points(vertices, 50_000 if request.config.getoption("--level") != "full" else 1_000_000)
    threads = os.cpu_count() or 1
    query = MeshQuery(vertices, triangles)

    def frame(count: int) -> Callable[[], object]:
        def call() -> object:
            query.move(vertices)
            return query.contains(points, count), query.closest(points, count)

        return call

    race(
        frame(threads),
        len(points),
        table="Point in mesh and closest triangle by MeshQuery, all threads",
        name=f"{threads} threads",
        size=len(triangles),
        of="triangles",
        per="point",
        peers={"1 thread": (frame(1), len(points))},
        threads=threads,
        own=["1 thread"],
    )
