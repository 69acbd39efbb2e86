"""Does the arithmetic of 3-vectors agree with NumPy's?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.linalg import vec

coordinate = st.floats(-1e3, 1e3)
vectors = st.tuples(coordinate, coordinate, coordinate)


@given(vectors, vectors)
def test_sums_and_products_agree_with_numpy(a, b):
    p, q = np.array(a), np.array(b)
    assert vec.add(a, b) == tuple(p + q)
    assert vec.sub(a, b) == tuple(p - q)
    assert vec.multiply(a, b) == tuple(p * q)
    assert vec.scale(b[0], a) == tuple(b[0] * p)
    assert vec.dot(a, b) == pytest.approx(p @ q, rel=1e-14, abs=1e-9)
    assert vec.cross(a, b) == tuple(np.cross(p, q))


@given(vectors, vectors)
def test_the_cross_product_is_normal_to_both_factors(a, b):
    limit = 1e-14 * vec.norm(a) * vec.norm(b)
    assert abs(vec.dot(vec.cross(a, b), a)) <= limit * vec.norm(a)
    assert abs(vec.dot(vec.cross(a, b), b)) <= limit * vec.norm(b)


def test_x_cross_y_is_z():
    assert vec.cross((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) == (0.0, 0.0, 1.0)


def test_the_norm_of_3_4_12_is_13():
    assert vec.norm((3.0, 4.0, 12.0)) == 13.0
    assert vec.normalize((3.0, 4.0, 12.0)) == pytest.approx((3 / 13, 4 / 13, 12 / 13), rel=1e-15)


def test_rows_are_loaded_stored_and_added_to():
    rows = np.arange(6.0).reshape(2, 3)
    assert vec.load(rows, 1) == (3.0, 4.0, 5.0)
    vec.store(rows, 0, (7.0, 8.0, 9.0))
    vec.accumulate(rows, 1, (10.0, 20.0, 30.0))
    assert rows.tolist() == [[7.0, 8.0, 9.0], [13.0, 24.0, 35.0]]
