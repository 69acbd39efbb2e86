"""Are copies copies, and views views?"""

import numpy as np

from softbody import World
from softbody.model.arrays import boxes_of


def test_a_copy_of_a_state_shares_no_memory_with_it():
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0, velocity=(1.0, 2.0, 3.0))
    copy = world.state.copy()
    world.state.box_velocity[:] = 0.0
    assert copy.box_velocity.tolist() == [[1.0, 2.0, 3.0]]


def test_the_boxes_of_a_world_are_views_of_it():
    world = World()
    world.add_box((1.0, 1.0, 1.0), 2.0, velocity=(1.0, 2.0, 3.0))
    bodies = boxes_of(world.model, world.state)
    bodies.velocity[0] = (4.0, 5.0, 6.0)
    assert world.state.box_velocity.tolist() == [[4.0, 5.0, 6.0]]
    assert bodies.inverse_mass.tolist() == [0.5]
    assert np.shares_memory(bodies.position, world.state.box_position)
