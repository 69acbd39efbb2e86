"""Is a point judged in or out of a triangle as its picture says?"""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from softbody.geometry.triangle import area_vector, point_in_triangle, triangle_area
from softbody.linalg.quaternion import from_rotation_vector, rotate
from softbody.linalg.vec import add, norm, scale, sub

A, B, C = (0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)

coordinate = st.floats(-10.0, 10.0)
vectors = st.tuples(coordinate, coordinate, coordinate)
weights = st.floats(0.01, 1.0)


def test_the_area_of_a_right_triangle_is_half_the_product_of_its_legs():
    assert triangle_area(A, (3.0, 0.0, 0.0), (0.0, 4.0, 0.0)) == 6.0


def test_the_area_vector_points_to_where_the_triangle_turns_counter_clockwise():
    assert area_vector(A, B, C) == (0.0, 0.0, 8.0)
    assert area_vector(A, C, B) == (0.0, 0.0, -8.0)


@given(vectors, vectors, vectors, vectors)
def test_the_area_survives_rotation_and_grows_with_the_square_of_scale(a, b, c, rotation):
    q = from_rotation_vector(rotation)
    area = triangle_area(a, b, c)
    assert triangle_area(rotate(q, a), rotate(q, b), rotate(q, c)) == pytest.approx(area, rel=1e-12, abs=1e-11)
    assert triangle_area(scale(3.0, a), scale(3.0, b), scale(3.0, c)) == pytest.approx(9.0 * area, rel=1e-12, abs=1e-11)


@pytest.mark.parametrize(
    ("p", "inside"),
    [
        ((1.0, 1.0, 0.0), True),
        ((3.0, 3.0, 0.0), False),
        ((-1.0, 1.0, 0.0), False),
        ((1.0, -1.0, 0.0), False),
        (A, True),
        (B, True),
        (C, True),
        ((2.0, 0.0, 0.0), True),
        ((0.0, 2.0, 0.0), True),
        ((2.0, 2.0, 0.0), True),
        ((5.0, 0.0, 0.0), False),
        ((-1.0, 0.0, 0.0), False),
        ((0.0, 5.0, 0.0), False),
        ((0.0, -1.0, 0.0), False),
        ((-1.0, 5.0, 0.0), False),
        ((5.0, -1.0, 0.0), False),
        ((1.0, 1.0, 7.0), True),
        ((3.0, 3.0, 7.0), False),
    ],
)
@pytest.mark.parametrize("corners", [(A, B, C), (B, C, A), (C, A, B), (A, C, B), (C, B, A), (B, A, C)])
def test_a_point_is_in_the_triangle_on_its_border_or_above_it(p, inside, corners):
    assert point_in_triangle(p, *corners) is inside


@pytest.mark.parametrize(
    "corners", [(A, A, A), (A, B, B), (A, A, B), (A, B, A), (A, B, (2.0, 0.0, 0.0)), ((1.0, 1.0, 1.0),) * 3]
)
@pytest.mark.parametrize("p", [A, B, (1.0, 0.0, 0.0), (1.0, 1.0, 1.0), (9.0, 9.0, 9.0)])
def test_a_triangle_without_area_contains_nothing(p, corners):
    assert not point_in_triangle(p, *corners)


@given(vectors, vectors, vectors, weights, weights, weights, st.floats(-5.0, 5.0))
def test_a_positive_mixture_of_the_corners_is_inside_and_a_negative_one_outside(a, b, c, u, v, w, height):
    n = area_vector(a, b, c)
    assume(norm(n) > 0.1)
    total = u + v + w
    foot = add(add(scale(u / total, a), scale(v / total, b)), scale(w / total, c))
    assert point_in_triangle(add(foot, scale(height / norm(n), n)), a, b, c)
    beyond = add(a, scale(-0.1 * u, sub(foot, a)))
    assert not point_in_triangle(beyond, a, b, c)


@given(vectors, vectors, vectors, vectors)
def test_the_answer_does_not_depend_on_the_order_of_the_corners(p, a, b, c):
    n = area_vector(a, b, c)
    assume(norm(n) > 0.1)
    clear = min(abs(np.dot(area_vector(p, x, y), n)) for x, y in ((a, b), (b, c), (c, a)))
    assume(clear > 1e-9)
    answers = {point_in_triangle(p, *order) for order in ((a, b, c), (b, c, a), (c, b, a), (a, c, b))}
    assert len(answers) == 1
