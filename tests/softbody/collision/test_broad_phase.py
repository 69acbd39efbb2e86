"""Does the grid find the pairs that trying all of them finds?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive


@given(st.integers(0, 10**6), st.integers(0, 60), st.floats(0.1, 30.0), st.floats(0.0, 4.0))
def test_the_grid_finds_the_same_pairs_in_the_same_order(seed, count, spread, variety):
    random = np.random.default_rng(seed)
    centre = random.uniform(-spread, spread, (count, 3))
    radius = 10.0 ** random.uniform(-variety, 0.0, count)
    movable = random.random(count) < 0.7
    found, expected = (f(centre, radius, movable) for f in (near_pairs, near_pairs_exhaustive))
    assert found.tolist() == expected.tolist()


def test_spheres_that_touch_are_near_also_on_the_borders_of_cells():
    corners = np.indices((3, 3, 3)).reshape(3, -1).T * 2.0 - 2.0
    for radius in (1.0, 0.5, np.nextafter(1.0, 0.0)):
        arguments = corners, np.full(27, radius), np.ones(27, bool)
        assert near_pairs(*arguments).tolist() == near_pairs_exhaustive(*arguments).tolist()
    assert len(near_pairs(corners, np.full(27, 1.0), np.ones(27, bool))) == 54


def test_a_small_box_on_a_huge_plate_is_found():
    centre, radius = np.array([[0.0, 0.0, 0.0], [400.0, 30.0, 1.0]]), np.array([1000.0, 0.01])
    assert near_pairs(centre, radius, np.array([False, True])).tolist() == [[1, 0]]


def test_two_static_bodies_are_no_pair():
    assert len(near_pairs(np.zeros((2, 3)), np.ones(2), np.array([False, False]))) == 0


def test_ten_thousand_boxes_have_the_pairs_of_the_exhaustive_form():
    random = np.random.default_rng(3)
    centre, radius = random.uniform(0.0, 20.0, (10_000, 3)), random.uniform(0.3, 0.6, 10_000)
    movable = np.ones(10_000, bool)
    found = near_pairs(centre, radius, movable)
    assert len(found) > 10_000
    assert (found == near_pairs_exhaustive(centre, radius, movable)).all()


@pytest.mark.parametrize("function", [near_pairs, near_pairs_exhaustive])
def test_no_boxes_no_pairs(function):
    assert function(np.empty((0, 3)), np.empty(0), np.empty(0, bool)).shape == (0, 2)
