"""Pure predicates and measures on points, triangles, tetrahedra, polyhedra and boxes.

From Python: `points_in_mesh`, `closest_on_mesh`, and `MeshQuery` for a mesh that moves. From other kernels, or for
single points: the functions of the modules, on tuples and plain arrays.
"""

from softbody.geometry.closest import Closest, closest_triangle, closest_triangles
from softbody.geometry.parity_grid import (
    ParityGrid,
    build_parity_grid,
    point_in_parity_grid,
    points_in_parity_grid,
    rebuild_parity_grid,
)
from softbody.geometry.penetration import (
    Penetrations,
    find_penetrations,
    find_penetrations_exhaustively,
    room_for_penetrations,
)
from softbody.geometry.polyhedron import (
    centroid,
    inertia_tensor,
    point_in_convex,
    point_in_polyhedron,
    points_in_convex,
    points_in_polyhedron,
    signed_volume,
    surface_area,
)
from softbody.geometry.query import MeshQuery, closest_on_mesh, points_in_mesh
from softbody.geometry.sphere import bounding_sphere, bounding_spheres
from softbody.geometry.tetrahedron import (
    barycentric_in_tetrahedron,
    point_in_tetrahedron,
    points_in_tetrahedra,
    tetrahedron_volume,
)
from softbody.geometry.triangle import (
    closest_point_on_triangle,
    closest_points_on_triangles,
    point_in_triangle,
    points_in_triangles,
    triangle_area,
)
from softbody.geometry.triangle_tree import (
    TriangleTree,
    build_triangle_tree,
    closest_all_in_tree,
    closest_in_tree,
    refit_triangle_tree,
    search_space,
)

__all__ = [
    "Closest",
    "MeshQuery",
    "ParityGrid",
    "Penetrations",
    "TriangleTree",
    "barycentric_in_tetrahedron",
    "bounding_sphere",
    "bounding_spheres",
    "build_parity_grid",
    "build_triangle_tree",
    "centroid",
    "closest_all_in_tree",
    "closest_in_tree",
    "closest_on_mesh",
    "closest_point_on_triangle",
    "closest_points_on_triangles",
    "closest_triangle",
    "closest_triangles",
    "find_penetrations",
    "find_penetrations_exhaustively",
    "inertia_tensor",
    "point_in_convex",
    "point_in_parity_grid",
    "point_in_polyhedron",
    "point_in_tetrahedron",
    "point_in_triangle",
    "points_in_convex",
    "points_in_mesh",
    "points_in_parity_grid",
    "points_in_polyhedron",
    "points_in_tetrahedra",
    "points_in_triangles",
    "rebuild_parity_grid",
    "refit_triangle_tree",
    "room_for_penetrations",
    "search_space",
    "signed_volume",
    "surface_area",
    "tetrahedron_volume",
    "triangle_area",
]
