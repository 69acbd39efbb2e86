"""Do unit quaternions rotate as 3×3 matrices do?"""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from softbody.linalg.quaternion import (
    from_rotation_vector,
    load_quaternion,
    normalize_quaternion,
    product,
    rotate,
    rotate_diagonal,
    rotate_inverse,
)
from tests.softbody.placed_boxes import quaternions

coordinate = st.floats(-10.0, 10.0)
vectors = st.tuples(coordinate, coordinate, coordinate)


def matrix(q):
    """The textbook rotation matrix of a unit quaternion."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_a_quarter_turn_about_z_takes_x_to_y():
    quarter = (cos(pi / 4), 0.0, 0.0, sin(pi / 4))
    assert rotate(quarter, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0), abs=1e-15)


@given(quaternions, vectors)
def test_rotate_is_the_rotation_matrix(q, a):
    assert rotate(q, a) == pytest.approx(matrix(q) @ a, abs=1e-13)


@given(quaternions, vectors)
def test_rotate_inverse_undoes_rotate(q, a):
    assert rotate_inverse(q, rotate(q, a)) == pytest.approx(a, abs=1e-13)


@given(quaternions, quaternions, vectors)
def test_the_product_rotates_by_its_second_factor_first(p, q, a):
    assert rotate(product(p, q), a) == pytest.approx(rotate(p, rotate(q, a)), abs=1e-13)


@given(quaternions, vectors, vectors)
def test_a_diagonal_is_applied_in_the_rotated_frame(q, diagonal, a):
    R = matrix(q)
    assert rotate_diagonal(q, diagonal, a) == pytest.approx(R @ np.diag(diagonal) @ R.T @ a, abs=1e-11)


@given(vectors)
def test_a_rotation_vector_becomes_the_same_rotation_as_in_scipy(rotation):
    R = Rotation.from_rotvec(rotation).as_matrix()
    assert matrix(from_rotation_vector(rotation)) == pytest.approx(R, abs=1e-13)


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-160, 1e-20])
def test_a_tiny_rotation_vector_gives_a_unit_quaternion(size):
    assert from_rotation_vector((size, 0.0, 0.0)) == pytest.approx((1.0, size / 2, 0.0, 0.0), rel=1e-15)


def test_normalizing_divides_by_the_length():
    assert normalize_quaternion((2.0, 2.0, 2.0, 2.0)) == (0.5, 0.5, 0.5, 0.5)
    assert normalize_quaternion((0.0, 3.0, 0.0, -4.0)) == pytest.approx((0.0, 0.6, 0.0, -0.8), rel=1e-15)


def test_a_row_is_loaded_as_w_x_y_z():
    rows = np.array([[1.0, 0.0, 0.0, 0.0], [sqrt(0.5), 0.1, 0.2, 0.3]])
    assert load_quaternion(rows, 1) == (sqrt(0.5), 0.1, 0.2, 0.3)
