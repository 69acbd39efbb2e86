"""Does what is cut keep surfaces apart, and give the body its momenta back?"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from softbody.collision.soft.guard import MOST_LEFT, OF_DISTANCE, give_back, least_left


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.mark.parametrize("gap", [1e-9, 1e-6, 1e-4, 1e-3, 1e-2])
def test_a_part_of_every_gap_is_left_and_less_than_all(gap):
    left = least_left(gap, 1e-3)
    assert 0.1 * gap <= left <= MOST_LEFT * gap
    assert left <= max(0.1 * gap, OF_DISTANCE * 1e-3)


def test_both_momenta_come_back(rng):
    place, speed = rng.normal(size=(2, 30, 3))
    position, velocity = place + 0.01 * rng.normal(size=(30, 3)), speed + rng.normal(size=(30, 3))
    give_back(np.full(30, 2.0), position, velocity, place, speed)
    assert_allclose(velocity.sum(axis=0), speed.sum(axis=0), atol=1e-13)
    assert_allclose(np.cross(position, velocity).sum(axis=0), np.cross(place, speed).sum(axis=0), atol=1e-12)


def test_what_is_held_takes_them_itself(rng):
    place, speed = rng.normal(size=(2, 30, 3))
    velocity, inverse_mass = 0.5 * speed, np.full(30, 2.0)
    inverse_mass[4] = 0.0
    give_back(inverse_mass, place.copy(), velocity, place, speed)
    assert np.array_equal(velocity, 0.5 * speed)
