"""Trimesh as a subject: point in mesh, by rays through an R-tree."""

from __future__ import annotations

import numpy as np

from references import trimesh

PACKAGES = {"trimesh": "trimesh", "rtree": "rtree"}  # import name, and the name to install it by
CANNOT = {  # question → why it has no answer
    "move_boxes": "it knows meshes, and moves nothing",
    "boxes_overlap": "it knows meshes, and no boxes",
    "gas_volume": "it knows meshes, and has no soft bodies",
    "gas_period": "it knows meshes, and has no soft bodies",
    "move_soft": "it knows meshes, and has no soft bodies",
}


def points_in_mesh(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell whether points are inside."""
    return trimesh.points_in_mesh(points, vertices, triangles)
