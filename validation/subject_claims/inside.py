"""Points inside and outside of meshes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import softbody
from references import exact
from softbody import Mesh
from validation.cases import dented_sphere, points_around, rotated, stacked_points
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.checks.geometry.containment import special_points
from validation.subject import asks

FAMILY = "points in meshes"

Answer = Callable  # the function of the subject that is asked


def inside(meshes: dict[str, Mesh], points: dict[str, np.ndarray], ask: Answer) -> Comparison:
    """Compare a subject with exact arithmetic; what lies exactly on a surface is left out."""
    measured, expected, kinds, asked = [], [], [], []
    for kind, mesh in meshes.items():
        truth = exact.points_in_mesh(points[kind], mesh.vertices, mesh.triangles)
        rows = points[kind][truth != 0]
        measured.append(np.asarray(ask(rows, mesh.vertices, mesh.triangles)))
        expected.append(truth[truth != 0] > 0)
        kinds += [kind] * len(rows)
        asked.append(rows)
    inputs = {"point": np.concatenate(asked)}
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds, inputs=inputs)


POINTS: dict[str, Any] = {
    "reference": "exact integer arithmetic on the same floating-point inputs",
    "kind": "exact arithmetic",
    "unit": DISAGREEMENTS,
    "tolerance": 0.0,
    "because": "a yes-or-no answer; points exactly on the surface are left out",
}


def shapes(run: Run) -> dict[str, Mesh]:
    """Return a torus and a dented sphere, turned anyhow."""
    rng = run.fresh_rng()
    return {"torus": rotated(softbody.torus(1.0, 0.4, 16, 8), rng), "dented sphere": rotated(dented_sphere(1), rng)}


@asks("points_in_mesh", **POINTS)
def anywhere(run: Run, ask: Answer) -> Comparison:
    """Random points are inside or outside as they are."""
    meshes, rng = shapes(run), run.fresh_rng()
    return inside(meshes, {kind: points_around(mesh, run.count(200, 1_000, 20_000), rng) for kind, mesh in meshes.items()}, ask)  # fmt: skip  # noqa: E501


@asks(
    "points_in_mesh",
    **POINTS,
)
def next_to(run: Run, ask: Answer) -> Comparison:
    """Points above, below and 1e-3 to 1e-15 m off vertices, edges and faces are inside or outside as they are."""
    meshes, rng = shapes(run), run.fresh_rng()
    points = {
        k: np.concatenate([*special_points(m, rng, run.count(30, 150, 2_000)).values()]) for k, m in meshes.items()
    }
    return inside(meshes, points, ask)


@asks(
    "points_in_mesh",
    **POINTS,
)
def stacked(run: Run, ask: Answer) -> Comparison:
    """Points straight above and below the vertices of meshes that are stacked are inside or outside as they are."""
    meshes = {"sphere": softbody.icosphere(1), "torus": softbody.torus(1.0, 0.4, 16, 8)}
    rng = run.fresh_rng()
    return inside(meshes, {k: stacked_points(m, rng, run.count(2, 8, 40)) for k, m in meshes.items()}, ask)


@asks(
    "points_in_mesh",
    **POINTS,
)
def far_away(run: Run, ask: Answer) -> Comparison:
    """Random points are inside or outside as they are 1 000 km from the origin, too."""
    rng = run.fresh_rng()
    meshes = {k: Mesh(m.vertices + 1e6 * rng.uniform(-1.0, 1.0, 3), m.triangles) for k, m in shapes(run).items()}
    return inside(meshes, {k: points_around(m, run.count(200, 1_000, 20_000), rng) for k, m in meshes.items()}, ask)
