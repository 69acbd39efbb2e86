"""Does the grid answer what the exhaustive test answers, on any mesh and any point, also after it moved?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody import MeshError
from softbody.geometry import (
    build_parity_grid,
    point_in_parity_grid,
    points_in_parity_grid,
    points_in_polyhedron,
    rebuild_parity_grid,
)
from softbody.geometry.parity_grid import _step
from tests.softbody.geometry.shapes import ALL, BALL, CLOSED, OPEN, T, V, questions, split, turned

NOT_FINITE = [[np.nan] * 3, [np.nan, 0.0, 0.0], [0.0, 0.0, np.nan], [0.0, 0.0, np.inf], [0.0, 0.0, -np.inf],
              [np.inf, 0.0, 0.0], [0.0, -np.inf, 0.0]]  # fmt: skip


def ask(grid, points, vertices):
    answers = np.empty(len(points), bool)
    points_in_parity_grid(points, grid, vertices, answers, (0, len(points)))
    return answers


def one_by_one(grid, points, vertices):
    return np.array([point_in_parity_grid(tuple(p), grid, vertices) for p in points])


@pytest.mark.parametrize("kind", ALL)
def test_the_grid_gives_the_answers_of_the_exhaustive_test(kind):
    vertices, triangles = ALL[kind]
    points = np.concatenate([questions(vertices, triangles), NOT_FINITE])
    expected = points_in_polyhedron(points, vertices, triangles)
    for columns in (0.01, 0.25, 4.0):
        grid = build_parity_grid(vertices, triangles, columns)
        assert ask(grid, points, vertices).tolist() == expected.tolist()
    assert one_by_one(grid, points[::7], vertices).tolist() == expected[::7].tolist()


@pytest.mark.parametrize(("kinds", "closed"), [(CLOSED, True), (OPEN, False)])
def test_a_mesh_is_closed_if_every_edge_belongs_to_an_even_number_of_triangles(kinds, closed):
    assert {kind: build_parity_grid(*kinds[kind]).closed for kind in kinds} == dict.fromkeys(kinds, closed)


def test_an_unmerged_mesh_holds_the_same_points_as_the_merged_one():
    points = questions(V, T)
    expected = points_in_polyhedron(points, V, T)
    vertices, triangles = split(V, T)
    assert points_in_polyhedron(points, vertices, triangles).tolist() == expected.tolist()


def test_what_is_inside_does_not_depend_on_the_order_of_triangles_and_corners():
    points = questions(V, T)
    expected = points_in_polyhedron(points, V, T)
    rng = np.random.default_rng(0)
    shuffled = np.array([rng.permutation(t) for t in T[rng.permutation(len(T))]])
    assert points_in_polyhedron(points, V, shuffled).tolist() == expected.tolist()
    assert ask(build_parity_grid(V, shuffled), points, V).tolist() == expected.tolist()


@pytest.mark.parametrize(
    ("kind", "inside"),
    [
        ("two that overlap", [True, False]),  # each of the two sheets counts: out where they overlap
        ("every triangle twice", [False, False]),
        ("every triangle three times", [True, True]),
        ("inside out", [True, True]),
        ("one in another", [True, False]),
    ],
)
def test_what_a_defective_mesh_holds_is_where_its_sheets_are_odd_in_number(kind, inside):
    vertices, triangles = CLOSED[kind]
    points = np.array([[-0.7, 0.0, 0.05], [0.33, 0.1, 0.05]])
    assert points_in_polyhedron(points, vertices, triangles).tolist() == inside


def test_rebuilding_follows_the_mesh():
    grid = build_parity_grid(V, T)
    for step in range(5):
        moved = turned(V) * [1.0 + step, 1.0, 0.3] + [step, 0.0, -step]
        rebuild_parity_grid(grid, moved)
        points = questions(moved, T, step)
        assert ask(grid, points, moved).tolist() == points_in_polyhedron(points, moved, T).tolist()


def test_a_mesh_stretched_so_that_its_lists_overflow_gets_fewer_columns_and_keeps_its_answers():
    rng = np.random.default_rng(0)
    triangles = np.arange(3 * 4000).reshape(-1, 3)
    vertices = rng.uniform(size=(3 * 4000, 3))  # every triangle is as large as the mesh
    grid = build_parity_grid(vertices, triangles)
    assert grid.shape.prod() < 0.25 * 4000
    points = rng.uniform(size=(50, 3))
    assert ask(grid, points, vertices).tolist() == points_in_polyhedron(points, vertices, triangles).tolist()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_nothing_is_inside_a_mesh_whose_vertices_are_not_finite(value):
    grid = build_parity_grid(V, T)
    spoiled = V.copy()
    spoiled[3, 1] = value
    rebuild_parity_grid(grid, spoiled)
    assert not ask(grid, questions(V, T), spoiled).any()
    rebuild_parity_grid(grid, V)
    assert ask(grid, questions(V, T), V).any()


def test_no_points_get_no_answers():
    assert ask(build_parity_grid(V, T), np.empty((0, 3)), V).tolist() == []


def test_a_range_of_points_is_answered_alone():
    points, grid = np.zeros((10, 3)), build_parity_grid(V, T)
    answers = np.zeros(10, bool)
    points_in_parity_grid(points, grid, V, answers, (3, 7))
    assert answers.tolist() == [False] * 3 + [True] * 4 + [False] * 3


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(1e-3, 1e300))
def test_the_number_of_a_step_never_falls(x, y, per_metre):
    if x > y:
        x, y = y, x
    assert 0 <= _step(x, 0.3, per_metre, 62) <= _step(y, 0.3, per_metre, 62) <= 61


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (V, [[0, 1, 162]], r"triangle 0 is \[  0   1 162\], but vertices run from 0 to 161"),
        (V, [[0, 1, -1]], "triangle 0 is .* repair its indices"),
        (V, [[0.0, 1.0, 2.0]], "triangles are float64; give vertex indices"),
        (V, [[0, 1, 2, 3]], r"triangles have shape \(1, 4\)"),
        (V, [], "the mesh is empty"),
        ([], T, "the mesh is empty"),
        (V[:, :2], T, r"vertices have shape \(162, 2\)"),
        (V * np.nan, T, r"vertex 0 is at .*: not finite"),
        (V, None, "triangles are not numbers"),
        ("abc", T, "vertices are not numbers"),
        (V, [[0, 1, 2], [0, 1]], "triangles are not numbers"),
        (V, np.array([[0, 1, 2**63]], np.uint64), "but vertices run from 0 to 161"),
    ],
)
def test_what_is_not_a_list_of_triangles_is_refused_by_name(vertices, triangles, message):
    with pytest.raises(MeshError, match=message):
        build_parity_grid(vertices, triangles)


def test_a_grid_needs_not_much_memory():
    grid = build_parity_grid(BALL.vertices, BALL.triangles)
    large = build_parity_grid(*split(np.tile(V, (20, 1)), np.concatenate([T + 162 * k for k in range(20)])))
    size = [sum(a.nbytes for a in g if isinstance(a, np.ndarray)) for g in (grid, large)]
    assert size[1] - size[0] < 220 * 19 * len(T)
