"""Open3D as a peer, where somebody has installed it: a large package that nothing else here needs."""

from __future__ import annotations

from typing import Any

import numpy as np

try:
    import open3d
except ImportError:
    open3d = None


def open3d_scene(vertices: np.ndarray, triangles: np.ndarray) -> Any:
    """Return Open3D's structure for occupancy and closest points, on one thread and in float32, as it wants."""
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(vertices.astype(np.float32), triangles.astype(np.uint32))
    return scene
