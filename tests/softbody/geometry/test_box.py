"""Are the corners and the inertia of a box those of a solid box?"""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import strategies as st

from softbody.geometry.box import box_corner, box_corners, box_inertia, point_in_box

extent = st.floats(0.1, 10.0)
REST = (1.0, 0.0, 0.0, 0.0)


def test_the_inertia_of_a_1_2_3_box_of_12_kg():
    assert box_inertia((1.0, 2.0, 3.0), 12.0) == (13.0, 10.0, 5.0)


def test_bit_0_1_2_of_a_corner_choose_its_side_along_x_y_z():
    corners = box_corners((2.0, 4.0, 6.0), (10.0, 20.0, 30.0), REST)
    assert corners[0].tolist() == [9.0, 18.0, 27.0]
    assert corners[1].tolist() == [11.0, 18.0, 27.0]
    assert corners[2].tolist() == [9.0, 22.0, 27.0]
    assert corners[4].tolist() == [9.0, 18.0, 33.0]
    assert corners[7].tolist() == [11.0, 22.0, 33.0]


def test_a_quarter_turn_about_z_swaps_the_extents_along_x_and_y():
    quarter = (cos(pi / 4), 0.0, 0.0, sin(pi / 4))
    corners = box_corners((2.0, 4.0, 6.0), (0.0, 0.0, 0.0), quarter)
    assert np.ptp(corners, axis=0) == pytest.approx([4.0, 2.0, 6.0], rel=1e-14)
    assert box_corner((2.0, 4.0, 6.0), (0.0, 0.0, 0.0), quarter, 1) == pytest.approx((2.0, 1.0, -3.0), rel=1e-14)


def test_the_closest_face_of_a_box_and_the_depth_behind_it():
    size, middle, straight = (2.0, 4.0, 6.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    depth, normal = point_in_box((1.9, 0.0, 0.0), size, middle, straight)
    assert (round(depth, 12), normal) == (0.1, (1.0, 0.0, 0.0))
    depth, normal = point_in_box((1.0, -1.7, 0.0), size, middle, straight)
    assert (round(depth, 12), normal) == (0.3, (0.0, -1.0, 0.0))
    assert point_in_box((2.1, 0.0, 0.0), size, middle, straight)[0] < 0.0
    quarter = (0.5**0.5, 0.0, 0.0, 0.5**0.5)  # about z: the side along x now points along y
    depth, normal = point_in_box((1.0, 0.9, 0.0), size, middle, quarter)
    assert depth == pytest.approx(0.1)
    np.testing.assert_allclose(normal, (0.0, 1.0, 0.0), atol=1e-15)
