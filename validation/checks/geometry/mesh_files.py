"""Claims that files, and triangles that share no corners, become the mesh that was meant."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from softbody import Mesh, MeshError
from softbody.mesh import files, mesh, weld
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh
from validation.check import Comparison, Run, check
from validation.checks.geometry.cases import corners_side_by_side, longest_side, random_meshes
from validation.fault import Fault

FAMILY = "meshes that users make"

FILES = ("stl", "ascii.stl", "ply", "ascii.ply", "obj", "off")


def _add(
    answers: Answers,
    kind: str,
    make: Callable[[], Mesh],
    judged: tuple[np.ndarray, np.ndarray],
    size: float,
    count: int | None = None,
) -> None:
    """Compare corners of a mesh, in units of its size, with those judged, and the number of vertices, or `count`."""
    try:
        shape = make()
        ours = shape.vertices, shape.triangles
    except MeshError:
        ours = np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    answers.extend(*corners_side_by_side(ours, judged, size), kind=kind)
    of_ours, of_judged = float(len(ours[0])), float(len(judged[0]) if count is None else count)
    answers.add(np.full(9, of_ours), np.full(9, of_judged), kind=kind)


@check(
    section="beyond the paper",
    piece="softbody.Mesh.from_file",
    reference="libigl's own reader; files written by trimesh",
    engines=("igl", "trimesh"),
    unit="of the size",
    tolerance=0.0,
    because="the same digits, read twice: readers that round decimals to the nearest double give the same bits",
    faults=(
        Fault(
            "coordinates read in single precision",
            files.triangles_of,
            "(mesh.vertices, mesh.faces) → (__import__('numpy').float32(mesh.vertices), mesh.faces)",
        ),
        Fault(
            "a merge that is asked for by a tolerance only",
            mesh.Mesh._from_arrays,
            'check_yes_or_no(merge, "merge") or tolerance > 0.0 → tolerance > 0.0',
        ),
        Fault(
            "vertices merged within a thousandth of a metre",
            mesh.Mesh._from_arrays,
            "cls.from_soup(vertices, triangles, tolerance) → cls.from_soup(vertices, triangles, 1e-3)",
        ),
    ),
)
def files_of_all_kinds(run: Run) -> Comparison:
    """`Mesh.from_file` makes the triangles that libigl reads from a file.

    Of meshes of all kinds, written as STL, PLY, OBJ and OFF, as text and in binary. With `merge=True` it has as many
    vertices as were written; without it, that is so of files in which triangles share vertices.
    """
    from references import igl, trimesh

    rng, answers = run.fresh_rng(), Answers()
    with tempfile.TemporaryDirectory() as folder:
        for kind in MESH_KINDS[: run.count(2, 6, 6)]:
            shape = random_mesh(kind, rng).scaled(10.0 ** rng.uniform(-3.0, 0.0)).moved(rng.normal(size=3))
            size = longest_side(shape.vertices)
            for file in FILES:
                path = Path(folder) / f"{kind}.{file}"
                trimesh.write_mesh(path, shape.vertices, shape.triangles, "ascii" in file)
                judged = igl.read_mesh(path)
                for merge, how in ((True, "merged"), (False, "as it stands")):
                    if merge or "stl" not in file:
                        make = partial(Mesh.from_file, path, merge=merge)
                        _add(answers, f"{file}, {how}", make, judged, size, len(shape.vertices))
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.Mesh.from_soup",
    reference="SciPy: its k-d tree, and connected components",
    engines=("scipy",),
    unit="of the size",
    tolerance=0.0,
    because="places are copied, not computed",
    faults=(
        Fault(
            "half of the tolerance",
            weld._join_near,
            "norm(sub(load(p_, i_), load(p_, j_))) <= t_ → norm(sub(load(p_, i_), load(p_, j_))) <= 0.5 * t_",
        ),
        Fault(
            "half as much again, and more",
            weld._join_near,
            "norm(sub(load(p_, i_), load(p_, j_))) <= t_ → norm(sub(load(p_, i_), load(p_, j_))) <= 1.7 * t_",
        ),
        Fault("chains that are not followed", weld._join_near, "parent[i] = root_of(parent, i) → pass", nth=0),
        Fault(
            "vertices that no triangle uses, kept",
            weld.merged,
            "points[used] → np.append(points[used], points[-1:], axis=0)",
        ),
    ),
)
def soups_within_a_tolerance(run: Run) -> Comparison:
    """`from_soup` joins the corners that SciPy finds connected within a tolerance.

    Corners lie apart, in chains of up to six within a `tolerance` of the next; the vertex is at the place of the first.
    Those that are farther apart, by less than half as much, stay. Slivers, and vertices that no triangle uses, are left
    out.
    """
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for kind, shape in random_meshes(run.count(2, 6, 60), rng):
        tolerance = float(edge_lengths(shape.vertices, shape.edges).min()) / 40.0
        numbers = shape.triangles.ravel()
        # The corners at a vertex are beads on a string, so that the first reaches the last by leaps only.
        bead = _turn_of_each(numbers) % 6
        along = rng.normal(size=(len(shape.vertices), 3))
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        corners = shape.vertices[numbers] + (0.9 * tolerance * bead)[:, None] * along[numbers]
        # Its corners are 0.99 of the tolerance apart along two axes, so that none are to be merged.
        tiny = 10.0 + (0.99 * tolerance / 2.0) * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
        corners = np.concatenate([corners, tiny[[0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2]]])
        sliver = np.repeat(corners[:1], 3, axis=0)
        points = np.concatenate([corners, sliver, 20.0 + rng.normal(size=(2, 3))])
        triangles = np.arange(len(corners) + 3).reshape(-1, 3)
        used, faces = np.unique(scipy.places_joined(corners, tolerance), return_inverse=True)
        make = partial(Mesh.from_soup, points, triangles, tolerance)
        _add(answers, kind, make, (points[used], faces.reshape(-1, 3)), longest_side(shape.vertices))
    return answers.comparison()


def _turn_of_each(numbers: np.ndarray) -> np.ndarray:
    """Return for each number (n,) how often it has come before."""
    order = np.argsort(numbers, kind="stable")
    begins = np.searchsorted(numbers[order], numbers[order])
    turn = np.empty(len(numbers), np.int64)
    turn[order] = np.arange(len(numbers)) - begins
    return turn


@check(
    section="beyond the paper",
    piece="softbody.Mesh.from_trimesh",
    reference="trimesh: unmerge_vertices, merge_vertices",
    engines=("trimesh",),
    unit="of the size",
    tolerance=0.0,
    because="places are copied, not computed",
    faults=(
        Fault(
            "a mesh of half the size",
            mesh.Mesh.from_trimesh,
            "cls._from_arrays(*triangles_of(mesh), merge, tolerance)"
            " → cls._from_arrays(mesh.vertices * 0.5, mesh.faces, merge, tolerance)",
        ),
        Fault(
            "a mesh that is mirrored",
            mesh.Mesh.from_trimesh,
            "cls._from_arrays(*triangles_of(mesh), merge, tolerance)"
            " → cls._from_arrays(mesh.vertices * (1.0, 1.0, -1.0), mesh.faces[:, ::-1], merge, tolerance)",
        ),
    ),
)
def meshes_of_trimesh(run: Run) -> Comparison:
    """A Trimesh of loose triangles, merged, is the mesh that trimesh makes.

    It was cut apart, and is merged again by trimesh itself; so it is with a Trimesh that was not cut.
    """
    from references import trimesh

    rng, answers = run.fresh_rng(), Answers()
    for kind, shape in random_meshes(run.count(2, 6, 60), rng):
        whole, loose, merged = trimesh.cut_apart_and_merged(shape.vertices, shape.triangles)
        for given, merge in ((whole, False), (whole, True), (loose, True)):
            make = partial(Mesh.from_trimesh, given, merge=merge)
            _add(answers, kind, make, merged, longest_side(shape.vertices))
    return answers.comparison()
