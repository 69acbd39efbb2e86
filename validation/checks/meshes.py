"""What a Mesh finds doubtful in itself, and how far points are from it."""

from __future__ import annotations

import numpy as np

from softbody import Mesh, MeshError
from softbody.geometry import MeshQuery, query, self_intersections
from validation.cases import MESH_KINDS, edge_lengths, points_around, random_mesh, rotated
from validation.check import DISAGREEMENTS, Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"


@check(
    family=FAMILY,
    claim="`Mesh.check` finds the pairs of triangles that go through each other, and no others, on meshes of all kinds"
    " whose vertices have been moved about.",
    section="beyond the paper",
    piece="softbody.Mesh.check",
    reference="libigl's remesh_self_intersections, with CGAL's exact predicates",
    engines=("igl",),
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="both are exact",
    detects="a pair that is overlooked, or one that only shares a corner",
    faults=(
        Fault(
            "edges of one triangle only",
            self_intersections._meet,
            "segment_meets_triangle(a[i], a[j], b) or segment_meets_triangle(b[i], b[j], a)",
            "segment_meets_triangle(a[i], a[j], b)",
        ),
        Fault(
            "pairs that share a corner, by another edge",
            self_intersections._how_they_lie,
            "segment_meets_triangle(a[1], a[2], b)",
            "segment_meets_triangle(a[0], a[2], b)",
        ),
        Fault("two of three edges", self_intersections._meet, "range(3)", "range(2)"),
    ),
)
def intersections_of_the_surface_with_itself(run: Run) -> Comparison:
    from references import igl

    rng = run.fresh_rng()
    ours, theirs, kinds = [], [], []
    for kind in MESH_KINDS:
        for _ in range(run.count(1, 3, 20)):
            mesh = _crumpled(random_mesh(kind, rng), rng)
            told = [finding.where for finding in mesh.check() if finding.kind == "self-intersections"]
            found = _pairs(np.concatenate([*told, np.empty((0, 2), int)]))
            expected = _pairs(igl.self_intersections(mesh.vertices, mesh.triangles))
            others = _pairs(rng.integers(0, len(mesh.triangles), (100, 2)))
            asked = sorted(found | expected | others)
            ours += [pair in found for pair in asked]
            theirs += [pair in expected for pair in asked]
            kinds += [kind] * len(asked)
    return Comparison(np.array(ours), np.array(theirs), 1.0, kinds, notes=[f"{sum(theirs)} pairs do"])


def _pairs(rows: np.ndarray) -> set[tuple[int, int]]:
    """Return pairs (p, 2) of numbers, the smaller one first."""
    return {(int(low), int(high)) for low, high in np.sort(rows, axis=1)}


def _crumpled(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    """Return a mesh with its vertices moved by up to two edges each way: it goes through itself in places."""
    length = edge_lengths(mesh.vertices, mesh.edges).mean()
    for _ in range(20):
        far = rng.uniform(0.3, 2.0) * length * rng.uniform(-1.0, 1.0, mesh.vertices.shape)
        try:
            return Mesh(mesh.vertices + far * (rng.random((len(far), 1)) < 0.3), mesh.triangles)
        except MeshError:
            continue
    return mesh


@check(
    family=FAMILY,
    claim="The signed distances of points near and far, inside and outside of meshes of all kinds, before and after"
    " they have moved, are libigl's.",
    section="4.6",
    piece="softbody.geometry.MeshQuery.signed_distance",
    reference="libigl: its closest points, and the sign of its winding number",
    engines=("igl",),
    unit="of the size",
    tolerance=1.5e-15,
    because="rounding of the closest point: 1.4e-16 at worst of ten seeds, 1.8e-16 at full",
    detects="another sign, or the distance of a mesh as it was",
    faults=(
        Fault(
            "distances without a sign",
            query.MeshQuery.signed_distance,
            "np.where(inside, -distance, distance)",
            "distance",
        ),
        Fault(
            "distances the other way round",
            query.MeshQuery.signed_distance,
            "np.where(inside, -distance, distance)",
            "np.where(inside, distance, -distance)",
        ),
    ),
)
def signed_distances(run: Run) -> Comparison:
    from references import igl

    rng = run.fresh_rng()
    ours, theirs, scales, kinds = [], [], [], []
    for kind in MESH_KINDS:
        mesh = random_mesh(kind, rng)
        asked = MeshQuery(mesh)
        for now in (mesh, rotated(mesh, rng)):
            asked.move(now.vertices)
            points = points_around(now, run.count(50, 300, 3_000), rng)
            distance, *_ = igl.closest_points(points, now.vertices, now.triangles)
            inside = igl.points_in_mesh(points, now.vertices, now.triangles)
            ours.append(asked.signed_distance(points))
            theirs.append(np.where(inside, -distance, distance))
            scales.append(np.full(len(points), np.ptp(now.vertices, axis=0).max()))
            kinds += [kind] * len(points)
    return Comparison(np.concatenate(ours), np.concatenate(theirs), np.concatenate(scales), kinds)
