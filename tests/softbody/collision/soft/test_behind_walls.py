"""Tests of what a wall keeps from going past another."""

import numpy as np
import pytest

import softbody
from softbody import OverlapWarning, World

pytestmark = pytest.mark.interpreted

MESH = softbody.box((0.4, 0.4, 0.4), 1)
GAPS = 0.0008, 0.0002  # [m] to the walls in front of y and of z
GAS = 4_000.0  # [J] throws a corner by some centimetres within a step


def pressed_into_a_groove(order):
    """Return how far (3,) [m] an edge of a body has come past each of two walls of 0.4 mm that meet along it."""
    world, thick = World((0.0, 0.0, 0.0), edge_contacts=False), 0.0004
    for axis in order:
        size, place = np.array([1.0, 0.0, 0.0]), np.zeros(3)
        size[1:] = 0.4 + 2.0 * np.array(GAPS) + 2.0 * thick
        size[axis], place[axis] = thick, 0.2 + GAPS[axis - 1] + 0.5 * thick
        world.add_box(size, None, place, friction=0.0)
    body = world.add_soft_body(MESH, 0.1, 100.0, GAS, friction=0.0)
    with pytest.warns(OverlapWarning):
        world.step(0.0005, allow_unstable=True)
    edge = (MESH.vertices[:, 1:] > 0.0).all(axis=1)
    return body.positions[edge].max(axis=0) - np.array([0.0, *GAPS]) - 0.2


@pytest.mark.parametrize("order", [(1, 2), (2, 1)])
def test_what_goes_by_the_side_of_one_wall_past_another_is_kept_by_both(order):
    out, y, z = pressed_into_a_groove(order)
    assert out > 0.01
    assert max(y, z) < 1e-4
