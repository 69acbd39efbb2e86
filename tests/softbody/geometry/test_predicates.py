"""Are the signs of the two determinants those of exact arithmetic, for any numbers?"""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.geometry.predicates import orient2d, orient3d

coordinate = st.one_of(st.floats(-4.0, 4.0).filter(lambda x: x == 0.0 or abs(x) > 1e-30), st.integers(-3, 3).map(float))
point_2d = st.tuples(coordinate, coordinate)
point_3d = st.tuples(coordinate, coordinate, coordinate)


def nearby(p, axis, steps):
    """Return p moved by some roundings along an axis; what is too small for the core's range becomes 0."""
    p = [x if abs(x) > 1e-30 else 0.0 for x in p]
    p[axis] += steps * np.spacing(p[axis]) if p[axis] else 0.0
    return tuple(p)


def flat(p):
    """The point of a plane as the core has it: z plays no part."""
    return *p, np.nan


def sign(x):
    return int(x > 0) - int(x < 0)


def exact_turn(a, b, p):
    (ax, ay), (bx, by), (px, py) = (tuple(map(Fraction, q)) for q in (a, b, p))
    return sign((ax - px) * (by - py) - (ay - py) * (bx - px))


def exact_side(a, b, c, p):
    a, b, c, p = (tuple(map(Fraction, q)) for q in (a, b, c, p))
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = ([x - y for x, y in zip(q, p)] for q in (a, b, c))
    return sign(ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx))


@given(point_2d, point_2d, point_2d)
def test_the_side_of_a_line_is_exact(a, b, p):
    assert sign(orient2d(flat(a), flat(b), flat(p))) == exact_turn(a, b, p)


@given(point_2d, point_2d, st.floats(0.0, 1.0), st.integers(-2, 2))
def test_the_side_of_a_line_is_exact_for_points_a_few_roundings_off_it(a, b, t, steps):
    p = nearby([x + t * (y - x) for x, y in zip(a, b)], 0, steps)
    assert sign(orient2d(flat(a), flat(b), flat(p))) == exact_turn(a, b, p)


@given(point_3d, point_3d, point_3d, point_3d)
def test_the_side_of_a_plane_is_exact(a, b, c, p):
    assert sign(orient3d(a, b, c, p)) == exact_side(a, b, c, p)


@given(point_3d, point_3d, point_3d, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.integers(-2, 2))
def test_the_side_of_a_plane_is_exact_for_points_a_few_roundings_off_it(a, b, c, v, w, steps):
    p = nearby([x + v * (y - x) + w * (z - x) for x, y, z in zip(a, b, c)], 2, steps)
    assert sign(orient3d(a, b, c, p)) == exact_side(a, b, c, p)


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
def test_plus_is_left_of_a_line_and_behind_a_triangle(scale):
    assert orient2d((0.0, 0.0, 7.0), (scale, 0.0, -8.0), (0.5 * scale, scale, 9.0)) > 0.0
    corners = (0.0, 0.0, 0.0), (scale, 0.0, 0.0), (0.0, scale, 0.0)
    assert orient3d(*corners, (0.1 * scale, 0.1 * scale, -scale)) > 0.0
    assert orient3d(*corners, (0.1 * scale, 0.1 * scale, scale)) < 0.0
    assert orient3d(*corners, (7.0 * scale, -3.0 * scale, 0.0)) == 0.0
