"""Cost of the narrow phase of two soft bodies, and of many boxes' separating-axis test. One thread."""

from __future__ import annotations

import coal
import fcl
import igl
import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector as Embree

import softbody
from benchmarks.goals import Goal
from benchmarks.open3d_peer import open3d, open3d_scene
from benchmarks.race import Peer
from benchmarks.suite import Benchmark, Row
from softbody.collision.boxes.sat_boxes import PlacedBoxes, box_pairs_overlap
from softbody.compiler.jit import jit
from softbody.geometry import (
    BVH,
    Penetrations,
    build_bvh,
    find_penetrations,
    find_penetrations_exhaustively,
    points_of,
    refit_bvh,
    room_for_penetrations,
    search_space,
)

PAGE = "standard", 4  # the level from which on the page has it, and where
NARROW = "Narrow phase of two soft bodies that overlap by a seventh, both ways, structures rebuilt"
EXHAUSTIVE = "every particle against every triangle"
MOST_EXHAUSTIVE = {"quick": 3, "standard": 4, "full": 6}


@jit
def rebuild_and_find(points: np.ndarray, vertices: np.ndarray, tree: BVH, found: Penetrations) -> int:
    """Fit the structures to where two bodies are, and find what is inside, one way."""
    refit_bvh(tree, vertices)
    return find_penetrations(points_of(points), points_of(vertices), tree, search_space(tree), found)


@Benchmark(
    Row(NARROW, "particles a body", "particle", "find_penetrations", (EXHAUSTIVE,)),
    sizes={"quick": (3,), "standard": (3, 4, 5), "full": (3, 4, 5, 6)},  # 642 … 40 962 particles a body
    usual=True,
    goals=(
        Goal("Open3D*", 10.0),
        Goal("libigl *", 25.0),
        Goal("python-fcl *", 50.0),
        Goal("trimesh *", 90.0),
        Goal("coal *", 35.0),
    ),
)
def bench_soft_against_soft(race, level: str, subdivisions: int) -> None:
    """Two spheres that overlap by a fifth of their radius, both ways: particles inside, closest triangle, depth."""
    ball = softbody.icosphere(subdivisions)
    triangles = ball.triangles
    a, b = ball.vertices, np.ascontiguousarray(ball.vertices + np.array([0.3, 0.4, 1.728]))
    trees = [build_bvh(x, triangles) for x in (a, b)]
    room = room_for_penetrations(len(a))
    both_ways = ((a, b, trees[1]), (b, a, trees[0]))

    def ours() -> list[int | np.ndarray]:
        found = [rebuild_and_find(x, y, tree, room) for x, y, tree in both_ways]
        assert min(found) > 0
        return [*found, *(rows[: found[-1]] for rows in room[:4])]

    def exhaustively() -> None:
        for x, y, _ in both_ways:
            find_penetrations_exhaustively(x, y, triangles, room)

    def of_box(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """What any user would do first: only the points in the other's bounding box."""
        return np.ascontiguousarray(x[((x >= y.min(axis=0)) & (x <= y.max(axis=0))).all(axis=1)])

    def by_igl() -> None:
        for x, y, _ in both_ways:
            rows = of_box(x, y)
            inside = igl.fast_winding_number(y, triangles, rows) > 0.5
            igl.point_mesh_squared_distance(np.ascontiguousarray(rows[inside]), y, triangles)

    def by_trimesh() -> None:
        for x, y, _ in both_ways:
            rows, mesh = of_box(x, y), trimesh.Trimesh(y, triangles, process=False)
            inside = Embree(mesh).contains_points(rows)
            trimesh.proximity.closest_point(mesh, rows[inside])

    def by_open3d() -> None:
        for x, y, _ in both_ways:
            rows, scene = of_box(x, y).astype(np.float32), open3d_scene(y, triangles)
            inside = scene.compute_occupancy(rows, nthreads=1).numpy() > 0.5
            scene.compute_closest_points(rows[inside], nthreads=1)

    pairs = 2 * len(a)
    peers: dict[str, Peer] = {
        "libigl (fast winding number, closest)": (by_igl, pairs),
        "python-fcl (surfaces only)": (lambda: _fcl_contacts(a, b, triangles), pairs),
        "coal (surfaces only)": (lambda: _coal_contacts(a, b, triangles), pairs),
    }
    if subdivisions <= MOST_EXHAUSTIVE[level]:
        peers[EXHAUSTIVE] = (exhaustively, pairs)
        peers["trimesh (embree, proximity)"] = (by_trimesh, pairs)
    if open3d:
        peers["Open3D (occupancy, closest), float32"] = (by_open3d, pairs)
    race(ours, pairs, size=len(a), peers=peers)


def _fcl_contacts(a: np.ndarray, b: np.ndarray, triangles: np.ndarray) -> int:
    objects = []
    for vertices in (a, b):
        model = fcl.BVHModel()
        model.beginModel(len(triangles), len(vertices))
        model.addSubModel(vertices, triangles)
        model.endModel()
        objects.append(fcl.CollisionObject(model))
    request = fcl.CollisionRequest(num_max_contacts=100_000, enable_contact=True)
    return fcl.collide(*objects, request, fcl.CollisionResult())


def _coal_contacts(a: np.ndarray, b: np.ndarray, triangles: np.ndarray) -> int:
    models = []
    for vertices in (a, b):
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(triangles), len(vertices))
        model.addVertices(vertices)
        model.addTriangles(triangles)
        model.endModel()
        models.append(model)
    request = coal.CollisionRequest()
    request.num_max_contacts = 100_000
    rest = coal.Transform3s()
    return coal.collide(models[0], rest, models[1], rest, request, coal.CollisionResult())


@Benchmark(
    Row("Separating axes of random boxes, in batch", "pairs", "pair", "box_pairs_overlap"),
    goals=(Goal("python-fcl", 12.0),),
)
def bench_boxes(race) -> None:
    """Yes or no for 10 000 pairs of random boxes; FCL's objects are made beforehand, and 1 000 of them asked."""
    rng = np.random.default_rng(0)
    count = 10_000
    turns = rng.standard_normal((2, count, 4))
    turns /= np.linalg.norm(turns, axis=2, keepdims=True)
    sizes, places = rng.uniform(0.4, 2.0, (2, count, 3)), rng.uniform(-1.0, 1.0, (2, count, 3))
    objects = [
        [fcl.CollisionObject(fcl.Box(*sizes[k, i]), fcl.Transform(turns[k, i], places[k, i])) for k in (0, 1)]
        for i in range(1_000)
    ]
    request = fcl.CollisionRequest()
    a, b = (PlacedBoxes(sizes[k], places[k], turns[k]) for k in (0, 1))
    peers = {"python-fcl": (lambda: [fcl.collide(x, y, request, fcl.CollisionResult()) for x, y in objects], 1_000)}
    race(lambda: box_pairs_overlap(a, b), count, size=count, peers=peers)
