"""Features of a mesh that are near each other, and how near, by the IPC Toolkit (Ferguson and others).

Pairs of a vertex and a triangle, and of two edges, that have no vertex in common: those whose bounding boxes, made
larger, meet are its candidates, and their distances say which are nearer than a margin.
"""

from __future__ import annotations

import ipctk
import numpy as np

PACKAGES = {"ipctk": "ipctk"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "boxes grown by a whole margin, not half": "its bounding boxes are in single precision: none must be left out",
}


def near_features(
    vertices: np.ndarray, edges: np.ndarray, triangles: np.ndarray, margin: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return (pairs (p, 3), distances (p,) [m]) of features nearer than a `margin` [m], in order.

    A pair is (0, vertex, triangle) or (1, edge, edge), the lower edge first.
    """
    points = np.asfortranarray(vertices, dtype=np.float64)
    mesh = ipctk.CollisionMesh(points, np.asarray(edges, np.int32), np.asarray(triangles, np.int32))
    candidates = ipctk.Candidates()
    candidates.build(mesh, points, margin)
    found = []
    for each in candidates.fv_candidates:
        corners = points[triangles[each.face_id]]
        found.append((0, each.vertex_id, each.face_id, ipctk.point_triangle_distance(points[each.vertex_id], *corners)))
    for each in candidates.ee_candidates:
        a, b = sorted((each.edge0_id, each.edge1_id))
        found.append((1, a, b, ipctk.edge_edge_distance(*points[edges[a]], *points[edges[b]])))
    rows = np.array(found).reshape(-1, 4)
    rows = rows[rows[:, 3] < margin * margin]  # it gives squares
    rows = rows[np.lexsort(rows[:, 2::-1].T)]
    return rows[:, :3].astype(np.int64), np.sqrt(rows[:, 3])
