"""Claims that points in a mesh are weighted sums of its vertices, by the weights that are named."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np

from softbody import Mesh
from softbody.geometry import mean_value
from validation.answers import Answers
from validation.cases import knotted_tube, points_around
from validation.check import Comparison, Run, check
from validation.checks.geometry.cases import longest_side, random_meshes
from validation.fault import Fault

FAMILY = "weights of points inside"

NEAR = 1e-2  # of the size: the judge splits the triangles beside a point that is nearer for long


def inside(run: Run, count: int) -> Iterator[tuple[str, Mesh, np.ndarray]]:
    """Yield meshes of every kind, and up to `count` points (k, 3) of each kind in each, not near to its surface."""
    rng = run.fresh_rng()
    count_each = run.count(1, 2, 12)
    tubes = (("knotted tube", knotted_tube(rng, 48, 6)) for _ in range(count_each))
    for kind, mesh in chain(random_meshes(count_each, rng), tubes):
        yield f"{kind}, anywhere", mesh, _not_near(mesh, points_around(mesh, 40 * count, rng))[:count]
        corners = mesh.vertices[mesh.triangles[rng.integers(0, len(mesh.triangles), 400 * count)]]
        shares = rng.normal(0.0, 4.0, (len(corners), 2))
        in_plane = np.column_stack([1.0 - shares.sum(axis=1), shares])
        yield (
            f"{kind}, in planes of triangles",
            mesh,
            _not_near(mesh, (in_plane[:, :, None] * corners).sum(axis=1))[:count],
        )


def _not_near(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Return those of some points that are in a mesh, and not near to its surface."""
    from references import igl

    points = points[igl.points_in_mesh(points, mesh.vertices, mesh.triangles)]
    distance, _, _ = igl.closest_points(points, mesh.vertices, mesh.triangles)
    return points[distance > NEAR * longest_side(mesh.vertices)]


@check(
    section="7",
    piece="softbody.geometry.mean_value.mean_value_weights",
    reference="the integral that defines them, by Gauss and Legendre; on a triangle, the weights that made the point",
    kind="closed form",
    engines=("igl",),
    unit="of the whole",
    tolerance=1e-12,
    because="rounding of some 1 000 terms: 1.3e-13 at worst of four seeds",
    faults=(
        Fault(
            "areas in place of angles",
            mean_value._mean_values,
            "np.divide(angles_, double_, where=w_, out=o_) → np.ones_like(double)",
        ),
        Fault(
            "weights of the corner after",
            mean_value._mean_values,
            "np.add.at(weights_, triangles_, s_) → np.add.at(weights, np.roll(triangles, 1, axis=1), shares)",
        ),
        Fault(
            "triangles that all face outwards",
            mean_value._mean_values,
            "np.where(f_, i_, whole_) → np.where(is_flat, np.inf, np.abs(whole))",
        ),
        Fault("flat ones that are divided by", mean_value._mean_values, "np.where(f_, i_, whole_) → whole"),
        Fault(
            "weights at the corner after",
            mean_value._mean_values,
            "double[on[0]] / d_ → np.roll(double[on[0]], 1) / d_",
        ),
    ),
)
def integrals(run: Run) -> Comparison:
    """Mean value coordinates are the integrals that define them.

    Of points in meshes of every kind, convex or not: anywhere, in the planes of triangles, and on triangles.
    """
    from references import mean_value as judge

    rng, answers = run.fresh_rng(), Answers()
    for kind, mesh, points in inside(run, 3):
        found = mean_value.mean_value_weights(points, mesh.vertices, mesh.triangles)
        for point, row in zip(points, found):
            answers.add(np.linalg.norm(row - judge.weights(point, mesh.vertices, mesh.triangles)), 0.0, kind=kind)
        triangle, shares = rng.integers(len(mesh.triangles)), rng.dirichlet(np.ones(3))
        on = (shares @ mesh.vertices[mesh.triangles[triangle]])[None]
        (row,) = mean_value.mean_value_weights(on, mesh.vertices, mesh.triangles)
        answers.add(np.linalg.norm(row[mesh.triangles[triangle]] - shares), 0.0, kind="on a triangle")
    return answers.comparison()


@check(
    section="7",
    piece="softbody.geometry.mean_value.tetrahedron_weights",
    reference="every tetrahedron tried, by NumPy's linear solver",
    kind="exhaustive search",
    engines=("igl",),
    unit="of the whole",
    tolerance=5e-14,
    because="rounding: 5.3e-15 at worst of six seeds",
    faults=(
        Fault(
            "any of those that overlap",
            mean_value.tetrahedron_weights,
            "inside[np.argmin(each[inside, 0])] → inside[np.argmax(each[inside, 0])]",
        ),
        Fault("a middle without weight", mean_value.tetrahedron_weights, "each[chosen, 0] / len(vertices) → 0.0"),
        Fault(
            "a middle of the bounds",
            mean_value.tetrahedron_weights,
            "vertices.mean(axis=0) → 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))",
        ),
        Fault("outside of it", mean_value.tetrahedron_weights, "each >= -ROUNDING → each >= -1.0"),
    ),
)
def tetrahedra(run: Run) -> Comparison:
    """Weights in a tetrahedron are those of its corners.

    Of the middle of the mesh and the triangle nearest behind the point, in meshes of every kind.
    """
    from references import mean_value as judge

    answers = Answers()
    for kind, mesh, points in inside(run, 20):
        found = mean_value.tetrahedron_weights(points, mesh.vertices, mesh.triangles)
        for point, row in zip(points, found):
            answers.add(np.linalg.norm(row - judge.tetrahedron(point, mesh.vertices, mesh.triangles)), 0.0, kind=kind)
    return answers.comparison()
