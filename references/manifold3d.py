"""What of a closed mesh is below a level, and beside a plane, by Manifold (Lalish and others).

It cuts by symbolic perturbation.

A vertex in the plane counts as beside it, so that what is cut is closed in every case; its places are float64.
"""

from __future__ import annotations

from typing import NamedTuple

import manifold3d
import numpy as np

PACKAGES = {"manifold3d": "manifold3d"}  # import name, and the name to install it by
SETTINGS = {  # what was chosen against the defaults, and why
    "Mesh64": "the usual Mesh is float32: 1e-8 of the size",
    "the mesh about its own mean vertex": "what counts as equal, 5e-13, is a part of how far from the origin a mesh is",
}


class Below(NamedTuple):
    """What of a closed mesh is below a level."""

    volume: float  # [m³]
    moment: np.ndarray  # (3,) [m⁴] ∫ x dV
    area: float  # [m²] of the mesh's own surface there, without the lid


class Solid(NamedTuple):
    """A piece of a closed mesh."""

    volume: float  # [m³]
    centre: np.ndarray  # (3,) [m] of the volume
    euler: int  # characteristic of its surface


def below(vertices: np.ndarray, triangles: np.ndarray, level: float) -> Below:
    """Return what of a closed mesh, `vertices` (n, 3) [m], `triangles` (t, 3), is below z = `level` [m].

    The volume is Manifold's own; moments are ∮ x² n_x dA / 2 over its cut mesh, and so on, and the area is without
    what the plane has brought. Raises ValueError for what it does not take as a closed mesh.
    """
    whole, origin = _solid(vertices, triangles)
    part = whole.trim_by_plane((0.0, 0.0, -1.0), origin[2] - level)
    mesh = part.to_mesh64()
    normal, moment = _normals_and_moment(mesh)
    volume = float(part.volume())
    # Triangles come in runs, one for each mesh that they are of: the first is the mesh's own, the second the lid.
    own = whole.to_mesh64().run_original_id[0]
    area = 0.0
    for start, end, of in zip(mesh.run_index, mesh.run_index[1:], mesh.run_original_id):
        if of == own:
            area += 0.5 * float(np.linalg.norm(normal[int(start) // 3 : int(end) // 3], axis=1).sum())
    return Below(volume, moment + volume * origin, area)


def halves(
    vertices: np.ndarray, triangles: np.ndarray, point: np.ndarray, normal: np.ndarray
) -> tuple[list[Solid], list[Solid]]:
    """Return the pieces of a closed mesh in front of a plane through `point` (3,) [m], where `normal` (3,) points.

    And those behind it; the largest first, on each side; arrays and errors as of `below`.
    """
    whole, origin = _solid(vertices, triangles)
    way = normal / np.linalg.norm(normal)
    sides = whole.split_by_plane(tuple(way), float((point - origin) @ way))
    ahead, behind = (
        sorted((_measured(part, origin) for part in side.decompose()), key=lambda solid: -solid.volume)
        for side in sides
    )
    return ahead, behind


def _measured(part: manifold3d.Manifold, origin: np.ndarray) -> Solid:
    volume = float(part.volume())
    return Solid(volume, _normals_and_moment(part.to_mesh64())[1] / volume + origin, 2 - 2 * int(part.genus()))


def _solid(vertices: np.ndarray, triangles: np.ndarray) -> tuple[manifold3d.Manifold, np.ndarray]:
    """Return the mesh about its mean vertex, and that vertex (3,) [m]."""
    origin = np.mean(vertices, axis=0)
    points, faces = np.ascontiguousarray(vertices - origin, np.float64), np.ascontiguousarray(triangles, np.uint64)
    whole = manifold3d.Manifold(manifold3d.Mesh64(points, faces))
    if whole.status() != manifold3d.Error.NoError:
        raise ValueError(f"Manifold refuses a mesh: {whole.status()}")
    return whole, origin


def _normals_and_moment(mesh: manifold3d.Mesh64) -> tuple[np.ndarray, np.ndarray]:
    """Return the normals (t, 3) [m²] of a mesh, twice the area long, and ∫ x dV (3,) [m⁴]."""
    a, b, c = (np.asarray(mesh.vert_properties)[np.asarray(mesh.tri_verts)[:, k].astype(int), :3] for k in range(3))
    normal = np.cross(b - a, c - a)
    # The mean of x² over a triangle is (a² + b² + c² + a b + b c + c a) / 6.
    square = (a * a + b * b + c * c + a * b + b * c + c * a) / 6.0
    return normal, (square * normal).sum(axis=0) / 4.0
