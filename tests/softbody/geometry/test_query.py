"""Can a user of Python ask many points about a mesh, also while it moves, and on several threads?"""

import numpy as np
import pytest

import softbody
from softbody import MeshError, ParameterError
from softbody.geometry import MeshQuery, closest_on_mesh, closest_triangles, points_in_mesh, points_in_polyhedron
from tests.softbody.geometry.shapes import T, V, questions, turned

POINTS = questions(V, T)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_points_in_a_mesh_are_those_of_the_exhaustive_test_on_any_number_of_threads(threads):
    assert points_in_mesh(POINTS, V, T, threads).tolist() == points_in_polyhedron(POINTS, V, T).tolist()


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_the_closest_triangles_are_those_of_the_exhaustive_search_on_any_number_of_threads(threads):
    for found, expected in zip(closest_on_mesh(POINTS, V, T, threads), closest_triangles(POINTS, V, T)):
        assert found.tolist() == expected.tolist()


def test_a_query_follows_its_mesh():
    query = MeshQuery(V, T)
    assert query.contains(POINTS).tolist() == points_in_polyhedron(POINTS, V, T).tolist()
    for step in (1, 2):
        moved = turned(V) + step
        query.move(moved)
        points = questions(moved, T)
        assert query.contains(points).tolist() == points_in_polyhedron(points, moved, T).tolist()
        assert query.closest(points).triangle.tolist() == closest_triangles(points, moved, T).triangle.tolist()


def test_a_query_keeps_its_answers_when_the_callers_array_changes():
    vertices = V.copy()
    query = MeshQuery(vertices, T)
    vertices += 100.0
    assert query.contains([[0.0, 0.0, 0.0]]).tolist() == [True]


def test_a_query_keeps_its_triangles_when_the_callers_array_changes():
    triangles = T.copy()
    query = MeshQuery(V, triangles)
    triangles += 10**9
    np.testing.assert_array_equal(query.closest(POINTS[:9]).triangle, closest_on_mesh(POINTS[:9], V, T).triangle)
    np.testing.assert_array_equal(query.contains(POINTS[:9]), points_in_mesh(POINTS[:9], V, T))
    for array in (query.triangles, query.vertices):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 10**9


def test_lists_integers_and_float32_are_taken():
    assert points_in_mesh([[0, 0, 0], [5, 0, 0]], V.tolist(), T.tolist()).tolist() == [True, False]
    assert points_in_mesh(np.zeros((1, 3), np.float32), V.astype(np.float32), T.astype(np.uint8)).tolist() == [True]
    assert points_in_mesh(np.zeros((3, 2)).T, np.asfortranarray(V), T).tolist() == [True, True]


def test_points_may_be_as_far_as_numbers_go():
    far = [[1e308] * 3, [1.7e308] * 3]
    assert points_in_mesh(far, V, T).tolist() == [False, False]


def test_no_points_get_no_answers():
    assert points_in_mesh([], V, T).shape == (0,)
    assert closest_on_mesh(np.empty((0, 3)), V, T).weights.shape == (0, 3)


def test_a_mesh_is_taken_in_place_of_its_arrays():
    query = MeshQuery(softbody.icosphere(1))
    assert query.contains([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]).tolist() == [True, False]


def test_signed_distances_are_those_of_a_box_and_follow_it():
    box = softbody.box((2.0, 2.0, 2.0))
    query = MeshQuery(box)
    points = np.array([[0.0, 0.0, 0.0], [0.5, 0.25, 0.0], [3.0, 0.0, 0.0], [4.0, 5.0, 0.0], [1.0, 0.0, 0.0]])
    assert query.signed_distance(points) == pytest.approx([-1.0, -0.5, 2.0, 5.0, 0.0], abs=1e-15)
    query.move(box.vertices + [1.0, 0.0, 0.0])
    assert query.signed_distance(points, threads=2) == pytest.approx([0.0, -0.5, 1.0, np.hypot(2, 4), -1.0], abs=1e-15)


def test_signed_distances_are_those_of_libigl():
    igl = pytest.importorskip("igl")
    points = questions(V, T)
    distance = MeshQuery(V, T).signed_distance(points)
    theirs = igl.signed_distance(np.ascontiguousarray(points), V, T, igl.SIGNED_DISTANCE_TYPE_PSEUDONORMAL)[0]
    assert distance == pytest.approx(theirs, abs=1e-12)


def test_an_open_mesh_has_closest_triangles_and_no_inside():
    query = MeshQuery(V, T[1:])
    assert query.closest(POINTS[:3]).distance.min() >= 0.0
    for ask in (query.contains, query.signed_distance, lambda points: points_in_mesh(points, V, T[1:])):
        with pytest.raises(MeshError, match=r"mesh is open, and has no inside: edge \d+–\d+ is met by 1 triangle"):
            ask(POINTS[:3])


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        (lambda: points_in_mesh([[0.0, 0.0]], V, T), MeshError, r"points have shape \(1, 2\)"),
        (lambda: points_in_mesh("abc", V, T), MeshError, "points are not numbers"),
        (lambda: points_in_mesh(POINTS, V, T + 1), MeshError, "vertices run from 0 to 161"),
        (lambda: points_in_mesh(POINTS, V, T, 0), ParameterError, "threads is 0"),
        (lambda: points_in_mesh(POINTS, V, T, 1.5), ParameterError, r"threads is 1\.5"),
        (lambda: MeshQuery(V, T, 0.0), ParameterError, r"columns_per_triangle is 0\.0"),
        (lambda: MeshQuery(V, T).move(V[1:]), MeshError, "the mesh has 162 of them"),
        (lambda: MeshQuery(V, T).move(V * np.nan), MeshError, "vertex 0 is at .* not finite"),
        (lambda: MeshQuery(V, []), MeshError, "the mesh is empty"),
        (lambda: MeshQuery(V), MeshError, "a ndarray alone is no mesh; give vertices and triangles, or a Mesh"),
        (lambda: points_in_mesh([[0, 0, 0], [0, np.nan, 0]], V, T), MeshError, r"point 1 is at .*: not finite; leave"),
        (lambda: closest_on_mesh([[np.inf, -np.inf, 0]], V, T), MeshError, r"point 0 is at .*: not finite"),
        (lambda: MeshQuery(V, T).signed_distance([[np.nan] * 3]), MeshError, r"point 0 is at .*: not finite"),
    ],
)
def test_what_cannot_be_answered_is_refused_by_name(wrong, error, message):
    with pytest.raises(error, match=message):
        wrong()
