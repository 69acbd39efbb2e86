"""Embree as a subject, by way of trimesh: point in mesh, by rays in single precision."""

from __future__ import annotations

import numpy as np

from references import trimesh

PACKAGES = {"embreex": "embreex", "trimesh": "trimesh"}  # import name, and the name to install it by
PRECISION = "single"
CANNOT = {  # question → why it has no answer
    "move_boxes": "it knows meshes, and moves nothing",
    "boxes_overlap": "it knows meshes, and no boxes",
    "gas_volume": "it knows meshes, and has no soft bodies",
    "gas_period": "it knows meshes, and has no soft bodies",
    "move_soft": "it knows meshes, and has no soft bodies",
}


def points_in_mesh(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell whether points are inside."""
    return trimesh.points_in_mesh_by_embree(points, vertices, triangles)
