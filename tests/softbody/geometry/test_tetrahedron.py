"""Is a point judged in or out of a tetrahedron, whichever way round its corners are named?"""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from softbody.geometry.tetrahedron import barycentric_in_tetrahedron, point_in_tetrahedron, tetrahedron_volume
from softbody.linalg.vec import scale

ORIGIN, X, Y, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

coordinate = st.floats(-5.0, 5.0)
vectors = st.tuples(coordinate, coordinate, coordinate)


def test_the_corner_of_a_unit_cube_has_a_sixth_of_its_volume():
    assert tetrahedron_volume(ORIGIN, X, Y, Z) == pytest.approx(1 / 6, rel=1e-15)
    assert tetrahedron_volume(ORIGIN, Y, X, Z) == pytest.approx(-1 / 6, rel=1e-15)


@pytest.mark.parametrize(
    ("p", "inside"),
    [
        ((0.1, 0.1, 0.1), True),
        ((0.25, 0.25, 0.25), True),
        ((0.5, 0.5, 0.5), False),
        ((-0.1, 0.1, 0.1), False),
        ((0.1, -0.1, 0.1), False),
        ((0.1, 0.1, -0.1), False),
        (ORIGIN, True),
        (X, True),
        (Y, True),
        (Z, True),
        ((0.5, 0.0, 0.0), True),
        ((0.5, 0.5, 0.0), True),
        ((0.25, 0.25, 0.0), True),
        ((2.0, 0.0, 0.0), False),
        ((0.25, 0.25, 0.5), True),
        ((0.5, 0.25, 0.5), False),
    ],
)
def test_a_point_is_in_it_in_every_order_of_the_corners(p, inside):
    for corners in permutations((ORIGIN, X, Y, Z)):
        assert point_in_tetrahedron(p, *corners) is inside


@pytest.mark.parametrize(
    "corners", [(ORIGIN, X, Y, (1.0, 1.0, 0.0)), (ORIGIN, X, (2.0, 0.0, 0.0), Z), (ORIGIN, ORIGIN, X, Y), (ORIGIN,) * 4]
)
def test_a_flat_one_contains_nothing(corners):
    for p in (ORIGIN, X, (0.25, 0.25, 0.0), (0.2, 0.2, 0.2)):
        assert not point_in_tetrahedron(p, *corners)


@given(vectors, vectors, vectors, vectors, vectors)
def test_the_weights_sum_to_one_and_reproduce_the_point(p, a, b, c, d):
    assume(abs(tetrahedron_volume(a, b, c, d)) > 0.1)
    weights = barycentric_in_tetrahedron(p, a, b, c, d)
    assert sum(weights) == pytest.approx(1.0, abs=1e-9)
    assert np.array(weights) @ np.array([a, b, c, d]) == pytest.approx(np.array(p), abs=1e-8)


@given(vectors, vectors, vectors, vectors, vectors)
def test_a_point_is_inside_where_no_weight_is_negative(p, a, b, c, d):
    assume(abs(tetrahedron_volume(a, b, c, d)) > 0.1)
    least = min(barycentric_in_tetrahedron(p, a, b, c, d))
    assume(abs(least) > 1e-9)
    assert point_in_tetrahedron(p, a, b, c, d) == (least > 0.0)


def test_the_weights_at_the_corners_are_one_and_zero():
    for k, p in enumerate((ORIGIN, X, Y, Z)):
        assert barycentric_in_tetrahedron(p, ORIGIN, X, Y, Z) == tuple(float(k == i) for i in range(4))


@given(vectors, vectors, vectors, vectors)
def test_the_volume_grows_with_the_cube_of_scale_and_flips_with_a_swap(a, b, c, d):
    volume = tetrahedron_volume(a, b, c, d)
    doubled = tetrahedron_volume(*(scale(2.0, v) for v in (a, b, c, d)))
    assert doubled == pytest.approx(8.0 * volume, rel=1e-12, abs=1e-12)
    assert tetrahedron_volume(a, c, b, d) == pytest.approx(-volume, rel=1e-12, abs=1e-12)
