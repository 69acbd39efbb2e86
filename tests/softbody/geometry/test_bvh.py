"""Is the closest triangle, and the closest point of a triangle, the closest, and the same from the tree?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody import MeshError
from softbody.geometry import (
    build_bvh,
    closest_all_in_bvh,
    closest_in_bvh,
    closest_on_mesh,
    closest_point_on_triangle,
    closest_points_on_triangles,
    closest_triangle,
    closest_triangles,
    refit_bvh,
    search_space,
)
from softbody.geometry.bvh import near_order
from softbody.geometry.closest_point import no_answers
from tests.softbody.geometry.shapes import ALL, T, V, questions, turned

NOT_FINITE = np.array([[np.nan] * 3, [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [-np.inf, np.inf, 0.0]])

A, B, C = (0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)

coordinate = st.floats(-3.0, 3.0)
point = st.tuples(coordinate, coordinate, coordinate)


def ask(tree, points, vertices):
    answers = no_answers(len(points))
    closest_all_in_bvh(points, tree, vertices, answers, (0, len(points)))
    return answers


def assert_same_bits(found, expected):
    for name, a, b in zip(found._fields, found, expected):
        assert np.array_equal(a, b, equal_nan=True), name


@pytest.mark.parametrize(
    ("p", "closest", "weights"),
    [
        ((0.5, 0.5, 3.0), (0.5, 0.5, 0.0), (0.5, 0.25, 0.25)),  # over the face
        ((-1.0, -1.0, 0.0), A, (1, 0, 0)),
        ((5.0, -1.0, 1.0), B, (0, 1, 0)),
        ((-1.0, 9.0, 1.0), C, (0, 0, 1)),
        ((1.0, -2.0, 1.0), (1.0, 0.0, 0.0), (0.5, 0.5, 0.0)),
        ((-2.0, 0.5, 1.0), (0.0, 0.5, 0.0), (0.75, 0.0, 0.25)),
        ((2.0, 2.0, 1.0), (1.0, 1.0, 0.0), (0.0, 0.5, 0.5)),
        (A, A, (1, 0, 0)),
        (B, B, (0, 1, 0)),
        (C, C, (0, 0, 1)),
    ],
)
def test_the_closest_point_is_on_the_face_an_edge_or_a_corner(p, closest, weights):
    found, shares = closest_point_on_triangle(p, A, B, C)
    assert found == pytest.approx(closest, abs=1e-15)
    assert shares == pytest.approx(weights, abs=1e-15)


@given(point, point, point, point, point)
def test_no_point_of_the_triangle_is_closer(p, a, b, c, other):
    shares = np.abs(other) + 1e-9
    shares /= shares.sum()
    found, weights = closest_point_on_triangle(p, a, b, c)
    assert min(weights) >= 0.0
    assert sum(weights) == pytest.approx(1.0, abs=1e-12)
    assert np.array(found) == pytest.approx(weights @ np.array([a, b, c]), abs=1e-12)
    distance = np.linalg.norm(np.subtract(p, found))
    assert distance <= np.linalg.norm(p - shares @ np.array([a, b, c])) + 1e-7
    for corner in (a, b, c):
        assert distance <= np.linalg.norm(np.subtract(p, corner)) + 1e-14


@pytest.mark.parametrize("corner", [0, 1, 2])
def test_a_corner_is_met_exactly_wherever_the_triangle_is(corner):
    corners = [tuple(row) for row in np.random.default_rng(corner).normal(size=(3, 3)) + 1e5]
    assert closest_point_on_triangle(corners[corner], *corners)[0] == corners[corner]


@pytest.mark.parametrize(
    ("a", "b", "c", "closest"),
    [
        ((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 0.0, 0.0)),  # on a line
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 0.0, 0.0)),  # two corners at one place
        ((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 0.0, 0.0)),
        ((2.0, 0.0, 0.0), (0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 0.0, 0.0)),
        ((7.0, 0.0, 0.0), (7.0, 0.0, 0.0), (7.0, 0.0, 0.0), (7.0, 0.0, 0.0)),  # one point
    ],
)
def test_a_triangle_without_area_is_its_edges(a, b, c, closest):
    found, weights = closest_point_on_triangle((0.5, 1.0, 0.0), a, b, c)
    assert found == pytest.approx(closest, abs=1e-15)
    assert sum(weights) == 1.0


def test_many_triangles_at_once_are_each_as_alone():
    rng = np.random.default_rng(0)
    points, corners = rng.normal(size=(20, 3)), rng.normal(size=(20, 3, 3))
    found, weights = closest_points_on_triangles(points, corners)
    for p, triangle, q, w in zip(points, corners, found, weights):
        assert closest_point_on_triangle(tuple(p), *map(tuple, triangle)) == (tuple(q), tuple(w))


@pytest.mark.parametrize("kind", ALL)
def test_the_tree_gives_the_answers_of_the_exhaustive_search(kind):
    vertices, triangles = ALL[kind]
    points = np.concatenate([questions(vertices, triangles, count=60), NOT_FINITE])
    expected = closest_triangles(points, vertices, triangles)
    tree = build_bvh(vertices, triangles)
    assert_same_bits(ask(tree, points, vertices), expected)
    search = search_space(tree)
    for q in range(0, len(points), 11):
        one = closest_triangle(tuple(points[q]), vertices, triangles)
        for guess in (-1, 0, one[0], len(triangles) - 1, len(triangles)):
            assert repr(closest_in_bvh(tuple(points[q]), tree, vertices, search, guess)) == repr(one)
        assert one[0] == expected.triangle[q]


def test_of_equally_close_triangles_the_lowest_is_taken():
    vertices, triangles = ALL["every triangle three times"]
    found = closest_on_mesh(questions(V, T), vertices, triangles)
    assert found.triangle.max() < len(T)


@pytest.mark.parametrize("away", [1e3, 1e12, 1e25, 1e100])
def test_points_far_away_are_answered_too(away):
    points = V[:20] * away
    tree = build_bvh(V, T)
    assert_same_bits(ask(tree, points, V), closest_triangles(points, V, T))


@pytest.mark.parametrize("scale", [1e-30, 1e-6, 1e6, 1e30])
def test_the_size_of_the_mesh_does_not_matter(scale):
    tree = build_bvh(scale * V, T)
    points = scale * questions(V, T)
    assert_same_bits(ask(tree, points, scale * V), closest_triangles(points, scale * V, T))


def test_refitting_follows_the_mesh():
    tree = build_bvh(V, T)
    for step in range(5):
        moved = turned(V) * [1.0 + step, 1.0, 0.3] + [step, 0.0, -step]
        refit_bvh(tree, moved)
        points = questions(moved, T, step)
        assert_same_bits(ask(tree, points, moved), closest_triangles(points, moved, T))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_nothing_is_closest_in_a_mesh_whose_vertices_are_not_finite(value):
    tree = build_bvh(V, T)
    spoiled = V.copy()
    spoiled[3, 1] = value
    refit_bvh(tree, spoiled)
    assert (ask(tree, questions(V, T), spoiled).triangle == -1).all()
    refit_bvh(tree, V)
    assert (ask(tree, questions(V, T), V).triangle >= 0).all()


def test_a_point_that_is_not_finite_has_no_closest_triangle():
    found = ask(build_bvh(V, T), np.array(NOT_FINITE), V)
    assert found.triangle.tolist() == [-1] * 4
    assert np.isnan(found.distance).all()
    assert np.isnan(found.weights).all()
    assert np.isnan(found.point).all()
    with pytest.raises(MeshError, match="not finite; leave it out"):
        closest_on_mesh(NOT_FINITE, V, T)


@given(st.integers(1, 700), st.integers(0, 10))
def test_the_order_of_a_tree_holds_each_triangle_once(count, seed):
    points = np.random.default_rng(seed).integers(0, 5, (count, 3)).astype(float)
    assert sorted(near_order(points).tolist()) == list(range(count))


def test_neighbours_in_the_order_are_near_each_other():
    points = np.random.default_rng(0).uniform(size=(4096, 3))
    boxes = points[near_order(points)].reshape(-1, 8, 3)
    assert np.ptp(boxes, axis=1).max(axis=1).mean() < 0.2  # eight points of 4096 fill a cube of side 1/8


@pytest.mark.parametrize("count", [1, 7, 8, 9, 63, 64, 65, 512, 513, 4097])
def test_trees_of_any_size_work(count):
    rng = np.random.default_rng(count)
    vertices = rng.uniform(size=(3 * count, 3))
    triangles = np.arange(3 * count).reshape(-1, 3)
    points = rng.uniform(size=(30, 3))
    tree = build_bvh(vertices, triangles)
    assert_same_bits(ask(tree, points, vertices), closest_triangles(points, vertices, triangles))


def test_what_is_not_a_list_of_triangles_is_refused():
    with pytest.raises(MeshError, match="vertices run from 0 to 161"):
        build_bvh(V, T + 1)
