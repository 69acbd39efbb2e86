"""Do boxes that overlap part by their masses, one pair after the other?"""

import pytest

from softbody import World
from softbody.model.arrays import boxes_of
from softbody.stepping.move_boxes import collide_boxes, correct_pair

pytestmark = pytest.mark.interpreted


def boxes(static=False):
    world = World()
    world.add_box((1.0, 1.0, 1.0), None if static else 1.0)
    world.add_box((1.0, 1.0, 1.0), 3.0, (0.9, 0.0, 0.0), velocity=(-4.0, 0.0, 0.0))
    return world


def test_boxes_part_by_their_depth_in_inverse_proportion_to_their_masses():
    world = boxes()
    collide_boxes(world.model, world.state, boxes_of(world.model, world.state), world.store.settings)
    assert world.state.box_position[:, 0] == pytest.approx([-0.075, 0.925], abs=1e-14)
    assert world.state.box_velocity[:, 0] == pytest.approx([-3.0, -3.0], rel=1e-14)


def test_a_static_box_does_not_give_way():
    world = boxes(static=True)
    collide_boxes(world.model, world.state, boxes_of(world.model, world.state), world.store.settings)
    assert world.state.box_position[:, 0] == pytest.approx([0.0, 1.0], abs=1e-14)
    assert world.state.box_velocity[:, 0].tolist() == [0.0, 0.0]


def test_two_static_boxes_may_overlap_for_ever():
    world = World()
    world.add_box((1.0, 1.0, 1.0), None)
    world.add_box((1.0, 1.0, 1.0), None, (0.5, 0.0, 0.0))
    before = world.state.copy()
    world.step(1e-3, 10)
    assert all((a == b).all() for a, b in zip(world.state, before))


def test_a_correction_keeps_the_centre_of_mass():
    world = boxes()
    bodies = boxes_of(world.model, world.state)
    correct_pair(bodies, 1, 0, (3.0, 6.0, 9.0))
    assert bodies.position.tolist() == [[-3.0, -6.0, -9.0], [0.9 + 1.0, 2.0, 3.0]]
