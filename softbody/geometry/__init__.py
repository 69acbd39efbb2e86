"""Pure predicates and measures on points, triangles, tetrahedra, polyhedra and boxes.

What a World runs, and claims judge as it runs them: `aabb`, `box`, `bvh`, `bvh_rays`, `mean_value`, `penetration`,
`predicates`, `self_intersections`, `sphere`, `unfolded`, the volume and the ray of `polyhedron`, and what these call.
For geometry users, called by no World's steps: `query` (`MeshQuery`, `points_in_mesh`, `closest_on_mesh`) and its
`parity_grid`, `connected` (what `Mesh.check` asks), `tetrahedron`, `points_in_…` and `closest_…s` of many at once,
point in convex, centroid and inertia, and the exhaustive forms, which are the baselines.

From Python: `points_in_mesh`, `closest_on_mesh`, and `MeshQuery` for a mesh that moves; their arrays are checked. From
other kernels, or for single points: the functions of the modules, on tuples and arrays; theirs are not.
"""

from softbody.geometry.aabb import AABB, bounding_box, boxes_meet
from softbody.geometry.bvh import BVH, build_bvh, closest_all_in_bvh, closest_in_bvh, refit_bvh, search_space
from softbody.geometry.closest_point import Closest, closest_triangle, closest_triangles
from softbody.geometry.parity_grid import (
    ParityGrid,
    build_parity_grid,
    point_in_parity_grid,
    points_in_parity_grid,
    rebuild_parity_grid,
)
from softbody.geometry.penetration import (
    Penetrations,
    Points,
    find_penetrations,
    find_penetrations_exhaustively,
    points_of,
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

__all__ = [
    "AABB",
    "BVH",
    "Closest",
    "MeshQuery",
    "ParityGrid",
    "Penetrations",
    "Points",
    "barycentric_in_tetrahedron",
    "bounding_box",
    "bounding_sphere",
    "bounding_spheres",
    "boxes_meet",
    "build_bvh",
    "build_parity_grid",
    "centroid",
    "closest_all_in_bvh",
    "closest_in_bvh",
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
    "points_of",
    "rebuild_parity_grid",
    "refit_bvh",
    "room_for_penetrations",
    "search_space",
    "signed_volume",
    "surface_area",
    "tetrahedron_volume",
    "triangle_area",
]
