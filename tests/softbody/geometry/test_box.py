"""Are the corners and the inertia of a box those of a solid box?"""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.geometry.box import box_corner, box_corners, box_inertia, point_in_box, way_back

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


HALF = (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("before", "now", "depth", "normal"),
    [
        ((1.5, 0.0, 0.0), (0.9, 0.0, 0.0), 0.1, (1.0, 0.0, 0.0)),  # in by the face in front of it
        ((1.5, 0.0, 0.0), (-0.9, 0.0, 0.0), 1.9, (1.0, 0.0, 0.0)),  # all but through: still by that face
        ((1.5, 0.0, 0.0), (-1.5, 0.0, 0.0), 2.5, (1.0, 0.0, 0.0)),  # right through
        ((0.0, -2.5, 0.0), (0.9, -1.0, 0.0), 1.0, (0.0, -1.0, 0.0)),  # by its own face, though another is closer
        ((0.9, 0.0, 0.0), (-0.9, 0.0, 0.0), 1.9, (1.0, 0.0, 0.0)),  # inside before: by the face that was closest
        ((0.9, 0.0, 0.0), (-1.5, 0.0, 0.0), 2.5, (1.0, 0.0, 0.0)),
        ((0.9, 0.0, 0.0), (1.5, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0)),  # inside before, and out again
        ((1.5, 0.0, 0.0), (0.5, 2.5, 0.0), 0.5, (1.0, 0.0, 0.0)),  # in by one face, and out by a side
        ((0.9, 1.5, 0.0), (0.5, 2.5, 0.0), 0.5, (1.0, 0.0, 0.0)),  # inside before, and out by a side
        ((1.5, 1.5, 0.0), (0.5, 2.6, 0.0), 0.0, (0.0, 0.0, 0.0)),  # past the side of that face
        ((1.5, 0.0, 0.0), (1.5, 1.0, 0.0), 0.0, (0.0, 0.0, 0.0)),  # past it
        ((0.5, 0.0, 0.0), (0.5, 0.0, 0.0), 0.5, (1.0, 0.0, 0.0)),  # still, and inside
    ],
)
def test_a_point_goes_back_by_the_face_through_which_it_came(before, now, depth, normal):
    found, out = way_back(before, now, HALF)
    assert found == pytest.approx(depth, abs=1e-15)
    assert out == normal


places = st.tuples(*[st.floats(-4.0, 4.0)] * 3)


@given(before=places, now=places)
def test_where_a_point_goes_back_to_it_is_outside_and_as_far_as_it_says(before, now):
    depth, out = way_back(before, now, HALF)
    inside = all(abs(x) < half for x, half in zip(now, HALF))
    on_its_way = np.linspace(before, now, 1001)
    assert depth > 0.0 or not inside
    if depth > 0.0 and not (np.abs(on_its_way) < HALF).all(axis=1).any():  # some may be so little inside, or so briefly
        assert np.max(np.abs(on_its_way) - HALF, axis=1).min() < 0.01
    if depth > 0.0:
        back = np.array(now) + depth * np.array(out)
        assert np.dot(back, out) == pytest.approx(np.dot(np.abs(out), HALF), rel=1e-12)
        if not all(abs(x) < half for x, half in zip(before, HALF)):  # it was before that face, to rounding
            assert np.dot(before, out) >= np.dot(np.abs(out), HALF) - 1e-9 or inside
