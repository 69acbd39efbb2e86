"""Volume, area, centroid, inertia, point in mesh, and contents of mesh files, by trimesh."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import trimesh.creation
import trimesh.proximity
import trimesh.triangles
import trimesh.util
from trimesh.ray.ray_triangle import RayMeshIntersector

# Import name, and the name to install it by; `contains` needs rtree, and takes embreex by itself where it is installed.
PACKAGES = {"trimesh": "trimesh", "rtree": "rtree", "embreex": "embreex"}
SETTINGS = {  # what was chosen against the defaults, and why
    "process=False": (
        "it merges and drops vertices on construction: a mesh would no longer be the one that was asked about"
    ),
    "the rtree-based intersector is named": (
        "Trimesh.contains switches silently to embree, which is float32, when embreex is installed"
    ),
    "integrals about the mesh's own mean vertex": (
        "far from the origin trimesh loses digits as any sum of signed tetrahedra does, and would judge a better "
        "core wrong"
    ),
    "vertices are merged only where they are equal": "merge_vertices rounds to 1e-8 m",
    "directions of second rays are seeded": "they are random: answers are to be the same every time",
}

# [m], absolute, at mesh sizes near 1 m. Points nearer to the surface may be judged either way. Leave them out.
MARGIN = 1e-5


def volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume [m³] of a closed mesh, `vertices` (n, 3) [m], `triangles` (t, 3); negative if inside out."""
    mesh, _ = _mesh(vertices, triangles)
    return float(mesh.volume)


def area(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return the surface area [m²] of a mesh, `vertices` (n, 3) [m], `triangles` (t, 3)."""
    mesh, _ = _mesh(vertices, triangles)
    return float(mesh.area)


def centroid(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the centroid (3,) [m] of the solid in a closed mesh, `vertices` (n, 3) [m], `triangles` (t, 3)."""
    mesh, origin = _mesh(vertices, triangles)
    return np.asarray(mesh.center_mass) + origin


def topology(vertices: np.ndarray, triangles: np.ndarray) -> tuple[bool, bool, int]:
    """Tell whether a mesh is closed, and turned one way, and return its Euler characteristic."""
    mesh, _ = _mesh(vertices, triangles)
    return bool(mesh.is_watertight), bool(mesh.is_winding_consistent), int(mesh.euler_number)


def inertia(vertices: np.ndarray, triangles: np.ndarray, mass: float) -> np.ndarray:
    """Return the inertia (3, 3) [kg m²] about its centroid of the homogeneous solid in a closed mesh."""
    mesh, _ = _mesh(vertices, triangles)
    mesh.density = mass / mesh.volume
    return np.asarray(mesh.moment_inertia)


def points_in_mesh(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell for each of `points` (m, 3) [m] whether it is inside a closed mesh: (m,) of bool, beyond MARGIN.

    By parity of the hits of a ray, with the triangles found through an R-tree.
    """
    mesh, origin = _mesh(vertices, triangles)
    _seed_rays()
    return np.asarray(RayMeshIntersector(mesh).contains_points(np.asarray(points, float) - origin), dtype=bool)


def points_in_mesh_by_embree(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell the same by embree, which is float32: beyond about 1e-5 of the size and of the distance from the origin."""
    from trimesh.ray.ray_pyembree import RayMeshIntersector as EmbreeIntersector

    mesh, origin = _mesh(vertices, triangles)
    _seed_rays()
    return np.asarray(EmbreeIntersector(mesh).contains_points(np.asarray(points, float) - origin), dtype=bool)


def _seed_rays() -> None:
    """Seed the generator of the second rays: where the first two disagree, trimesh asks again in a random direction."""
    if hasattr(trimesh.util, "random_generator"):  # those before it draw from NumPy's, which is seeded for every claim
        trimesh.util.random_generator().bit_generator.state = np.random.default_rng(0).bit_generator.state


def closest_points(
    points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (distance (m,) [m], triangle (m,), point (m, 3) [m]) of the surface closest to each of `points` (m, 3).

    Not always the closest: among triangles whose distances differ by less than about 1e-5 it may take the wrong one.
    """
    mesh, origin = _mesh(vertices, triangles)
    point, distance, triangle = trimesh.proximity.closest_point(mesh, np.asarray(points, float) - origin)
    return np.asarray(distance), np.asarray(triangle), np.asarray(point) + origin


def closest_on_triangles(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the point (m, 3) [m] of each triangle, `corners` (m, 3, 3), that is closest to its own of `points`."""
    return np.asarray(trimesh.triangles.closest_point(corners, points))


def icosphere(subdivisions: int, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return (vertices (n, 3) [m], triangles (t, 3)) of an icosahedron that is split so often, on its sphere."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return np.array(mesh.vertices), np.array(mesh.faces)


def scaled_and_moved(
    vertices: np.ndarray, triangles: np.ndarray, factor: float, offset: np.ndarray
) -> tuple[np.ndarray, float, np.ndarray]:
    """Return vertices (n, 3) [m], volume [m³] and centroid (3,) [m] of a mesh, scaled about the origin, then moved."""
    mesh = trimesh.Trimesh(vertices.copy(), triangles, process=False)
    mesh.apply_scale(factor)
    mesh.apply_translation(offset)
    return np.array(mesh.vertices), volume(mesh.vertices, triangles), centroid(mesh.vertices, triangles)


def write_mesh(path: str | Path, vertices: np.ndarray, triangles: np.ndarray, as_text: bool) -> None:
    """Write a mesh, `vertices` (n, 3), `triangles` (t, 3), to an STL, PLY, OBJ or OFF file, as text or in binary."""
    kind = Path(path).suffix[1:]
    how: dict[str, Any] = {"file_type": "stl_ascii"} if as_text and kind == "stl" else {"file_type": kind}
    how |= {"encoding": "ascii" if as_text else "binary"} if kind == "ply" else {}
    how |= {"digits": 17} if kind in ("obj", "off") else {}
    trimesh.Trimesh(vertices, triangles, process=False).export(path, **how)


def cut_apart_and_merged(
    vertices: np.ndarray, triangles: np.ndarray
) -> tuple[trimesh.Trimesh, trimesh.Trimesh, tuple[np.ndarray, np.ndarray]]:
    """Return trimesh's mesh, the same with no vertex shared, and vertices and triangles of that one merged again."""
    whole = trimesh.Trimesh(vertices, triangles, process=False)
    loose = whole.copy()
    loose.unmerge_vertices()
    merged = loose.copy()
    merged.merge_vertices()
    return whole, loose, (np.array(merged.vertices), np.array(merged.faces))


def first_triangles(
    starts: np.ndarray, ways: np.ndarray, vertices: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return (triangle (m,), part of the way (m,)) that each of `ways` (m, 3) from `starts` (m, 3) [m] meets first.

    −1 and inf for what meets none, however far it goes on.
    """
    mesh, origin = _mesh(vertices, triangles)
    points = np.asarray(starts, float) - origin
    place, ray, triangle = RayMeshIntersector(mesh).intersects_location(points, ways, multiple_hits=True)
    first, part = np.full(len(points), -1), np.full(len(points), np.inf)
    along = np.einsum("ij,ij->i", place - points[ray], ways[ray]) / np.einsum("ij,ij->i", ways[ray], ways[ray])
    for hit in np.argsort(along)[::-1]:
        first[ray[hit]], part[ray[hit]] = triangle[hit], along[hit]
    return first, part


def first_met(eye: np.ndarray, directions: np.ndarray, surfaces: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return which of `surfaces`, vertices and triangles of each, a ray from `eye` (3,) meets first; −1 for none.

    `directions` (m, 3); the answers (m,) are embree's, which is float32: not next to an outline.
    """
    from trimesh.ray.ray_pyembree import RayMeshIntersector as EmbreeIntersector

    starts = np.cumsum([0, *(len(vertices) for vertices, _ in surfaces)])
    triangles = np.concatenate([faces + start for (_, faces), start in zip(surfaces, starts)])
    of = np.repeat(np.arange(len(surfaces)), [len(faces) for _, faces in surfaces])
    mesh = trimesh.Trimesh(np.concatenate([vertices for vertices, _ in surfaces]), triangles, process=False)
    met = EmbreeIntersector(mesh).intersects_first(np.broadcast_to(eye, directions.shape), directions)
    return np.where(met < 0, -1, of[met])


def load_mesh(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Return (vertices (n, 3), triangles (t, 3)) of an STL, OBJ, PLY or GLB file, in the file's units and axes.

    Equal vertices are merged (STL repeats each one for every triangle, others along seams of normals or texture) and
    numbered in the order in which they first appear. The bodies of a scene are put into one mesh, each in its place.
    """
    mesh = trimesh.load_mesh(path, process=False)
    vertices, first, merged = np.unique(np.asarray(mesh.vertices), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.arange(len(order))
    return vertices[order], number[merged.ravel()][np.asarray(mesh.faces)]


def load_scene(path: str | Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return vertices (n, 3) and triangles (t, 3) of each node of a GLB file, by its name; y up there is z up here."""
    scene = trimesh.load_scene(path, process=False)
    found = {}
    for name in scene.graph.nodes_geometry:
        matrix, geometry = scene.graph[name]
        mesh = scene.geometry[geometry]
        x, y, z = (np.array(mesh.vertices) @ matrix[:3, :3].T + matrix[:3, 3]).T
        found[name] = np.stack([x, -z, y], axis=1), np.array(mesh.faces)
    return found


def _mesh(vertices: np.ndarray, triangles: np.ndarray) -> tuple[trimesh.Trimesh, np.ndarray]:
    """Return the mesh about its mean vertex, and that vertex (3,) [m]."""
    origin = np.mean(vertices, axis=0)
    return trimesh.Trimesh(vertices - origin, triangles, process=False), origin
