"""What of a closed mesh is below a level, by Manifold (Lalish and others), which cuts by symbolic perturbation.

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


def below(vertices: np.ndarray, triangles: np.ndarray, level: float) -> Below:
    """Return what of a closed mesh, `vertices` (n, 3) [m], `triangles` (t, 3), is below z = `level` [m].

    The volume is Manifold's own; moments are ∮ x² n_x dA / 2 over its cut mesh, and so on, and the area is without
    what the plane has brought. Raises ValueError for what it does not take as a closed mesh.
    """
    origin = np.mean(vertices, axis=0)
    points, faces = np.ascontiguousarray(vertices - origin, np.float64), np.ascontiguousarray(triangles, np.uint64)
    whole = manifold3d.Manifold(manifold3d.Mesh64(points, faces))
    if whole.status() != manifold3d.Error.NoError:
        raise ValueError(f"Manifold refuses a mesh: {whole.status()}")
    part = whole.trim_by_plane((0.0, 0.0, -1.0), origin[2] - level)
    mesh = part.to_mesh64()
    a, b, c = (np.asarray(mesh.vert_properties)[np.asarray(mesh.tri_verts)[:, k].astype(int), :3] for k in range(3))
    normal = np.cross(b - a, c - a)  # twice the area long
    # The mean of x² over a triangle is (a² + b² + c² + a b + b c + c a) / 6.
    square = (a * a + b * b + c * c + a * b + b * c + c * a) / 6.0
    volume, moment = float(part.volume()), (square * normal).sum(axis=0) / 4.0
    # Triangles come in runs, one for each mesh that they are of: the first is the mesh's own, the second the lid.
    own = whole.to_mesh64().run_original_id[0]
    area = 0.0
    for start, end, of in zip(mesh.run_index, mesh.run_index[1:], mesh.run_original_id):
        if of == own:
            area += 0.5 * float(np.linalg.norm(normal[int(start) // 3 : int(end) // 3], axis=1).sum())
    return Below(volume, moment + volume * origin, area)
