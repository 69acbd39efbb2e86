"""What several files of this room are tried on: meshes of every kind, and points where rays and rounding go wrong."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import softbody
from softbody import Mesh
from validation.cases import MESH_KINDS, dented_sphere, knotted_tube, random_mesh, rotated, scanned_sphere


def longest_side(vertices: np.ndarray) -> float:
    """Return the longest side [m] of the bounding box of `vertices` (n, 3)."""
    return float(np.ptp(vertices, axis=0).max())


def random_meshes(
    count: int, rng: np.random.Generator, kinds: tuple[str, ...] = MESH_KINDS
) -> Iterator[tuple[str, Mesh]]:
    """Yield `count` random meshes of each kind with its name, one drawn when the one before has been used."""
    for kind in kinds:
        for _ in range(count):
            yield kind, random_mesh(kind, rng)


def varied_meshes(rng: np.random.Generator, subdivisions: int = 3) -> dict[str, Mesh]:
    """Return meshes of every kind that the structures are tried on, in random orientations."""
    fine = 2 ** (subdivisions - 2)
    return {
        "sphere": rotated(softbody.icosphere(subdivisions), rng),
        "torus": rotated(softbody.torus(1.0, 0.4, 18 * fine, 9 * fine), rng),
        "dented sphere": rotated(dented_sphere(subdivisions), rng),
        "knotted tube": knotted_tube(rng, 48 * fine, 4 * fine),
        "like a scan": rotated(scanned_sphere(rng, subdivisions), rng),
    }


def points_on_faces(
    vertices: np.ndarray, triangles: np.ndarray, rng: np.random.Generator, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (count, 3) on random triangles, and the corners (count, 3, 3) of those."""
    corners = vertices[triangles[rng.integers(0, len(triangles), count)]]
    return (rng.dirichlet((1.0, 1.0, 1.0), count)[:, :, None] * corners).sum(axis=1), corners


def unit_normals(corners: np.ndarray) -> np.ndarray:
    """Return the normals (t, 3) of triangles with `corners` (t, 3, 3), of length one."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def special_points(mesh: Mesh, rng: np.random.Generator, count: int) -> dict[str, np.ndarray]:
    """Return points where rays and rounding go wrong: above, below, on and just off vertices, edges and faces."""
    on_faces, corners = points_on_faces(mesh.vertices, mesh.triangles, rng, count)
    on_vertices, on_edges = corners[:, 0], 0.5 * (corners[:, 0] + corners[:, 1])
    up = np.array([0.0, 0.0, 1.0]) * rng.uniform(-1.0, 1.0, (count, 1)) * np.ptp(mesh.vertices[:, 2])
    off = rng.normal(size=(count, 3))
    off *= 10.0 ** rng.uniform(-15.0, -3.0, (count, 1)) / np.linalg.norm(off, axis=1, keepdims=True)
    return {
        "above or below vertices": on_vertices + up,
        "above or below edges": on_edges + up,
        "on edges and faces": np.concatenate([on_edges[::2], on_faces[::2]]),
        "next to vertices": on_vertices + off,
        "next to edges": on_edges + off,
        "next to faces": on_faces + off,
    }


def corners_in_order(vertices: np.ndarray, triangles: np.ndarray, digits: int = 6) -> np.ndarray:
    """Return the corners (t, 9) of triangles, in an order that comes from places alone, to so many digits.

    Each triangle begins with its first corner, and keeps the way in which it turns.
    """
    places = np.round(vertices, digits) + 0.0
    _, rank = np.unique(places, axis=0, return_inverse=True)
    numbers = rank.ravel()[triangles]
    first = (numbers.argmin(axis=1)[:, None] + np.arange(3)) % 3
    numbers = np.take_along_axis(numbers, first, axis=1)
    rows = np.lexsort(numbers.T[::-1])
    return vertices[np.take_along_axis(triangles, first, axis=1)[rows]].reshape(-1, 9)


def corners_side_by_side(
    ours: tuple[np.ndarray, np.ndarray], judged: tuple[np.ndarray, np.ndarray], size: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (t, 9) of two meshes in units of a size; of what one lacks, corners are at no place, 0."""
    sides = [corners_in_order(vertices / size, triangles) for vertices, triangles in (ours, judged)]
    rows = max(map(len, sides))
    one, other = (np.vstack([side, np.zeros((rows - len(side), 9))]) for side in sides)
    return one, other
