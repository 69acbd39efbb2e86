"""Does a bounding sphere hold its points, and is it not much too large?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.geometry import bounding_sphere, bounding_spheres
from softbody.geometry.sphere import radius_about

point = st.tuples(*[st.floats(-1e6, 1e6)] * 3)


@given(st.lists(point, min_size=1, max_size=30))
def test_a_bounding_sphere_holds_every_point(points):
    rows = np.array(points)
    centre, radius = bounding_sphere(rows)
    assert (np.sqrt(((rows - centre) ** 2).sum(axis=1)) <= radius).all()


@given(st.integers(2, 200), st.integers(0, 1000))
def test_a_bounding_sphere_is_not_much_larger_than_the_points_need(count, seed):
    rows = np.random.default_rng(seed).normal(size=(count, 3))
    _, radius = bounding_sphere(rows)
    reach = np.linalg.norm(rows[:, None] - rows, axis=2).max()
    assert 0.5 * reach <= radius <= 1.3 * np.sqrt(3 / 8) * reach  # Jung 1901: √(3/8) of the reach always do


@given(st.lists(point, min_size=1, max_size=30), point)
def test_a_sphere_about_a_point_holds_every_other_and_no_more(points, centre):
    rows = np.array(points)
    distances = np.sqrt(((rows - np.array(centre)) ** 2).sum(axis=1))
    radius = radius_about(centre, rows)
    assert (distances <= radius).all()
    assert radius <= distances.max() * (1.0 + 2.0**-49)


def test_of_two_points_it_is_the_sphere_between_them():
    centre, radius = bounding_sphere(np.array([[1.0, 2.0, 3.0], [3.0, 2.0, 3.0]]))
    assert (centre, radius) == ((2.0, 2.0, 3.0), pytest.approx(1.0, rel=1e-14))


def test_one_point_is_its_own_sphere_and_none_has_none():
    assert bounding_sphere(np.ones((3, 3))) == ((1.0, 1.0, 1.0), 0.0)
    assert np.isnan(bounding_sphere(np.empty((0, 3)))[1])


def test_the_spheres_of_several_bodies_are_those_of_each():
    rows = np.random.default_rng(0).normal(size=(10, 3))
    centres, radii = np.empty((2, 3)), np.empty(2)
    bounding_spheres(rows, np.array([0, 4, 10]), centres, radii)
    for k, part in enumerate((rows[:4], rows[4:])):
        assert (tuple(centres[k]), radii[k]) == bounding_sphere(part)
