import numpy as np
from numpy.testing import assert_allclose

from references import exact, winding


def test_a_cube_is_wound_once_around_its_inside(cases):
    got = winding.winding_numbers(
        [(0.5, 0.5, 0.5), (0.01, 0.99, 0.5), (2, 0.5, 0.5), (0.5, 0.5, 1.0001)], *cases.cube()
    )
    assert_allclose(got, [1, 1, 0, 0], atol=1e-12)


def test_one_triangle_covers_an_eighth_of_the_sphere():
    # seen from the origin, the triangle of the three unit axes fills one octant
    assert_allclose(winding.winding_numbers([(0, 0, 0)], np.eye(3), np.array([(0, 1, 2)])), 1 / 8, rtol=1e-14)


def test_a_mesh_inside_out_is_wound_the_other_way(cases):
    vertices, triangles = cases.cube()
    assert_allclose(winding.winding_numbers([(0.5, 0.5, 0.5)], vertices, triangles[:, ::-1]), -1, rtol=1e-14)


def test_where_two_bodies_overlap_the_numbers_add(cases):
    vertices, triangles = cases.cube()
    both = np.concatenate([vertices, vertices + 0.5]), np.concatenate([triangles, triangles + 8])
    assert_allclose(winding.winding_numbers([(0.75, 0.75, 0.75), (0.25, 0.25, 0.25)], *both), [2, 1], rtol=1e-14)


def test_points_are_inside_where_integers_say_so(cases, rng):
    vertices, triangles = cases.torus(1.0, 0.4, 16, 8)
    up = np.array([0.0, 0.0, 0.15])
    points = np.concatenate([rng.uniform(-1.5, 1.5, (400, 3)), vertices - up, vertices + up])
    inside = exact.points_in_mesh(points, vertices, triangles) > 0
    assert 100 < inside.sum() < 400
    assert np.array_equal(winding.points_in_mesh(points, vertices, triangles), inside)


def test_points_are_judged_rightly_down_to_the_margin(cases, rng):
    vertices, triangles = cases.torus(1.0, 0.4, 16, 8)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    weights = rng.dirichlet((1, 1, 1), len(a))
    at = weights[:, :1] * a + weights[:, 1:2] * b + weights[:, 2:] * c
    gap = 2.8 * winding.MARGIN * n
    assert not winding.points_in_mesh(at + gap, vertices, triangles).any()
    assert winding.points_in_mesh(at - gap, vertices, triangles).all()


def test_the_answer_does_not_depend_on_the_chunks(cases, rng, monkeypatch):
    mesh = cases.torus(1.0, 0.4, 16, 8)
    points = rng.uniform(-1.5, 1.5, (103, 3))
    whole = winding.winding_numbers(points, *mesh)
    for entries in (1, 256, 10**7):
        monkeypatch.setattr(winding, "ENTRIES", entries)
        assert_allclose(winding.winding_numbers(points, *mesh), whole, atol=1e-14)


def test_no_points_give_no_answers(cases):
    assert winding.points_in_mesh(np.empty((0, 3)), *cases.cube()).shape == (0,)
